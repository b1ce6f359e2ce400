# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An impact at several points at once: the corners of a face, or what strikes together with the
contacts that carry the struck.

    compression: v_n >= 0, p_n >= 0, v_n p_n = 0 at every point; friction in its disc mu p_n,
                 against the slip that is left
    restitution: e p_n more at the points that strike (Poisson's rule), while contacts that carry
                 load hold v_n >= 0 as in the compression; friction changes by what is in the disc
                 of the normal impulses of this phase

So a ball leaves a box that rests on the ground, or a whole stack, with e v, and a box that falls
flat on four corners does not spin. The points push and rub one after the other, forwards and
backwards, until nobody changes anything more (projected Gauss-Seidel).

    energy of the restitution <= sum e^2 W_c,   W_c = -p_n (v_n before + v_n compressed) / 2

bounds what comes back: where friction would make it more, the restitution of all is scaled. The
bound is that of Stronge's rule, and without friction an equality.

M. Anitescu and F. Potra, Nonlinear Dynamics 14 (1997) 231 (compression and restitution as two
complementarity problems); Ch. Glocker and F. Pfeiffer, Nonlinear Dynamics 7 (1995) 471.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.events import collision_matrix
from rigid_body_sim.physics.contact.events import joint_impact_record as record
from rigid_body_sim.physics.contact.events.collision_matrix import StruckBody
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    dot,
    load,
    load_symmetric,
    negate,
    scale,
    store,
    subtract,
)

TINIEST = 1e-300  # [N s]
SETTLED = 1e-16  # [-] of the largest impulse: changes below are round-off
ENOUGH = 1e-10  # [-] the same, after the last sweep: by less nobody sees that it did not settle
MOST_SWEEPS = 400  # there and back; of a face 3 to 20, of a stack of ten boxes some hundred
ENERGY_ROUND_OFF = 1e-13  # [-] of the energy: what is more than that is a gain
NO_INERTIA = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NO_VECTOR = (0.0, 0.0, 0.0)


class JointImpact(NamedTuple):
    """
    The tables of an impact: see `joint_impact_record`.

    body_count, point_count : rows of each that take part
    """

    body_count: int
    point_count: int
    bodies: Array
    points: Array


@inline
def _struck(body: float, arm: Any, bodies: Array) -> StruckBody:
    """Return a body as the collision matrix takes it."""
    if body < 0.0:
        return StruckBody(0.0, NO_INERTIA, NO_VECTOR)
    row = int(body) * record.BODY_SIZE
    return StruckBody(
        bodies[row + record.INVERSE_MASS],
        load_symmetric(bodies, row + record.INVERSE_INERTIA),
        arm,
    )


@inline
def _velocity_at(body: float, arm: Any, bodies: Array) -> Any:
    """Return the velocity of a body at an arm [m/s]."""
    if body < 0.0:
        return NO_VECTOR
    row = int(body) * record.BODY_SIZE
    spin = load(bodies, row + record.ANGULAR_VELOCITY)
    return add(load(bodies, row + record.VELOCITY), cross(spin, arm))


@inline
def _push(body: float, arm: Any, impulse: Any, bodies: Array) -> None:
    """Let an impulse [N s] act on a body at an arm."""
    if body < 0.0:
        return
    row = int(body) * record.BODY_SIZE
    velocity = load(bodies, row + record.VELOCITY)
    velocity = add_scaled(velocity, bodies[row + record.INVERSE_MASS], impulse)
    store(bodies, row + record.VELOCITY, velocity)
    turn = apply_symmetric(
        load_symmetric(bodies, row + record.INVERSE_INERTIA), cross(arm, impulse)
    )
    spin = load(bodies, row + record.ANGULAR_VELOCITY)
    store(bodies, row + record.ANGULAR_VELOCITY, add(spin, turn))


@inline
def _relative_velocity(place: int, impact: JointImpact) -> Any:
    """Return the velocity of B against A at a point [m/s]."""
    points, bodies = impact.points, impact.bodies
    of_a = _velocity_at(points[place + record.BODY_A], load(points, place + record.ARM_A), bodies)
    of_b = _velocity_at(points[place + record.BODY_B], load(points, place + record.ARM_B), bodies)
    return add(load(points, place + record.TOLD), subtract(of_b, of_a))


@inline
def _act(place: int, impulse: Any, impact: JointImpact) -> None:
    """Let an impulse [N s] act at a point: on B, its opposite on A."""
    points, bodies = impact.points, impact.bodies
    arm_a, arm_b = load(points, place + record.ARM_A), load(points, place + record.ARM_B)
    _push(points[place + record.BODY_A], arm_a, negate(impulse), bodies)
    _push(points[place + record.BODY_B], arm_b, impulse, bodies)


@kernel
def _prepare(impact: JointImpact) -> None:
    """Fill in what the points need to know: effective masses and normal velocities before."""
    points, bodies = impact.points, impact.bodies
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        normal = load(points, place + record.NORMAL)
        first = collision_matrix.across(normal)
        axes = first, cross(normal, first), normal
        arm_a, arm_b = load(points, place + record.ARM_A), load(points, place + record.ARM_B)
        a = _struck(points[place + record.BODY_A], arm_a, bodies)
        b = _struck(points[place + record.BODY_B], arm_b, bodies)
        k = collision_matrix.in_axes(a, b, axes)
        unlike = 0.5 * (k.k_11 - k.k_22)
        stiffest = 0.5 * (k.k_11 + k.k_22) + math.sqrt(unlike * unlike + k.k_12 * k.k_12)
        points[place + record.NORMAL_MASS] = 1.0 / k.k_nn
        points[place + record.TANGENT_MASS] = 1.0 / stiffest
        points[place + record.START] = dot(normal, _relative_velocity(place, impact))
        points[place + record.NORMAL_IMPULSE] = 0.0
        store(points, place + record.FRICTION_IMPULSE, NO_VECTOR)
        points[place + record.COMPRESSION] = 0.0
        store(points, place + record.COMPRESSION_IMPULSE, NO_VECTOR)


@kernel
def _press_together(impact: JointImpact) -> None:
    """
    Let all that approach push at once, each by its effective mass, all scaled so that they stop in
    the mean: a flat face comes to rest by that, without a spin that rounding would leave.
    """
    points = impact.points
    given, gained = 0.0, 0.0
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        impulse = max(-points[place + record.NORMAL_MASS] * points[place + record.START], 0.0)
        points[place + record.NORMAL_IMPULSE] = impulse
        _act(place, scale(impulse, load(points, place + record.NORMAL)), impact)
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        impulse, start = points[place + record.NORMAL_IMPULSE], points[place + record.START]
        speed = dot(load(points, place + record.NORMAL), _relative_velocity(place, impact))
        given -= impulse * start
        gained += impulse * (speed - start)
    if gained <= 0.0:
        return
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        impulse = points[place + record.NORMAL_IMPULSE]
        more = (given / gained - 1.0) * impulse
        points[place + record.NORMAL_IMPULSE] = impulse + more
        _act(place, scale(more, load(points, place + record.NORMAL)), impact)


@inline
def _rub(place: int, impact: JointImpact) -> float:
    """
    Bring friction at a point up to date, in its disc: of what this phase has given; return by how
    much it changed [N s].
    """
    points = impact.points
    normal = load(points, place + record.NORMAL)
    velocity = _relative_velocity(place, impact)
    slip = add_scaled(velocity, -dot(normal, velocity), normal)
    old = load(points, place + record.FRICTION_IMPULSE)
    new = add_scaled(old, -points[place + record.TANGENT_MASS], slip)
    compression = points[place + record.COMPRESSION]
    most = points[place + record.FRICTION] * (points[place + record.NORMAL_IMPULSE] - compression)
    begun = add_scaled(load(points, place + record.COMPRESSION_IMPULSE), -compression, normal)
    given = subtract(new, begun)
    size = math.sqrt(dot(given, given))
    if size > most:
        new = add_scaled(begun, most / size, given)
    store(points, place + record.FRICTION_IMPULSE, new)
    change = subtract(new, old)
    _act(place, change, impact)
    return math.sqrt(dot(change, change))


@inline
def _press(place: int, least: float, impact: JointImpact) -> float:
    """Keep a point from going in; return by how much its normal impulse changed [N s]."""
    points = impact.points
    normal = load(points, place + record.NORMAL)
    speed = dot(normal, _relative_velocity(place, impact))
    old = points[place + record.NORMAL_IMPULSE]
    new = max(old - points[place + record.NORMAL_MASS] * speed, least)
    points[place + record.NORMAL_IMPULSE] = new
    _act(place, scale(new - old, normal), impact)
    return abs(new - old)


@kernel
def _sweep(backwards: bool, compresses: bool, rubs: bool, impact: JointImpact) -> float:
    """
    Let each point push, and rub, once; return the largest change over the largest impulse.
    """
    points, count = impact.points, impact.point_count
    changed, largest = 0.0, TINIEST
    for turn in range(count):
        number = count - 1 - turn if backwards else turn
        place = number * record.POINT_SIZE
        if compresses or points[place + record.RESTITUTION] == 0.0:
            least = 0.0 if compresses else points[place + record.COMPRESSION]
            changed = max(changed, _press(place, least, impact))
        if rubs and points[place + record.FRICTION] > 0.0:
            changed = max(changed, _rub(place, impact))
        largest = max(largest, points[place + record.NORMAL_IMPULSE])
    return changed / largest


@inline
def _impulse(place: int, points: Array) -> Any:
    """Return all that a point gave so far to B [N s]."""
    rubbed = load(points, place + record.FRICTION_IMPULSE)
    normal = load(points, place + record.NORMAL)
    return add_scaled(rubbed, points[place + record.NORMAL_IMPULSE], normal)


@kernel
def _begin_sweep(impact: JointImpact) -> None:
    """Keep what the points gave so far."""
    points = impact.points
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        store(points, place + record.BEFORE, _impulse(place, points))


@kernel
def _go_on(before: float, impact: JointImpact) -> float:
    """
    Go on beyond a sweep in the direction in which the last ones went, by conjugate gradients; what
    the sweep changed stands for the gradient. Return its square.

    before : square of what the sweep before changed; 0: begin anew
    """
    points = impact.points
    square = 0.0
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        change = subtract(_impulse(place, points), load(points, place + record.BEFORE))
        square += dot(change, change)
    share = square / before if before > 0.0 else 0.0
    share = share if share < 1.0 else 0.0  # it grows: begin anew
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        normal, now = load(points, place + record.NORMAL), _impulse(place, points)
        change = subtract(now, load(points, place + record.BEFORE))
        further = scale(share, load(points, place + record.DIRECTION))
        store(points, place + record.DIRECTION, add(further, change))
        if share > 0.0:
            _act(place, further, impact)
            along = dot(normal, further)
            points[place + record.NORMAL_IMPULSE] += along
            rubbed = load(points, place + record.FRICTION_IMPULSE)
            across = add_scaled(further, -along, normal)
            store(points, place + record.FRICTION_IMPULSE, add(rubbed, across))
    return square


@kernel
def _solve(compresses: bool, impact: JointImpact) -> bool:
    """
    Let the points push until nobody changes anything, then also rub until nobody does; return
    whether that was reached.

    compresses : whether this is the compression; in the restitution what strikes only rubs, and
                 nobody takes back what he gave in the compression

    Friction waits, because a stack that only has to hold then needs none; together they would go
    a long way round to find that. Sweeps alone need the square of the height of a stack; so they
    are the gradients of a search, there and back at a time, which makes them symmetric (Silcowitz,
    Niebe & Erleben, VRIPHYS 2010).
    """
    for rubs in (False, True):
        square, change = 0.0, math.inf
        for sweep in range(MOST_SWEEPS):
            _begin_sweep(impact)
            forth = _sweep(False, compresses, rubs, impact)
            change = max(forth, _sweep(True, compresses, rubs, impact))
            if change <= SETTLED:
                break
            if sweep + 1 < MOST_SWEEPS:
                square = _go_on(square, impact)
        if change > ENOUGH:
            return False
    return True


@kernel
def _end_compression(impact: JointImpact) -> float:
    """
    Keep how it stands after the compression, and return the work that may come back [J].
    """
    points, bodies = impact.points, impact.bodies
    returned = 0.0
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        velocity = _relative_velocity(place, impact)
        pressed = points[place + record.NORMAL_IMPULSE]
        speed = dot(load(points, place + record.NORMAL), velocity)
        e = points[place + record.RESTITUTION]
        returned -= 0.5 * e * e * pressed * (points[place + record.START] + speed)
        points[place + record.COMPRESSION] = pressed
        store(points, place + record.COMPRESSION_IMPULSE, _impulse(place, points))
        store(points, place + record.COMPRESSED, velocity)
    for number in range(impact.body_count):
        row = number * record.BODY_SIZE
        velocity = load(bodies, row + record.VELOCITY)
        store(bodies, row + record.COMPRESSED_VELOCITY, velocity)
        spin = load(bodies, row + record.ANGULAR_VELOCITY)
        store(bodies, row + record.COMPRESSED_SPIN, spin)
    return returned


@kernel
def _restore(impact: JointImpact) -> bool:
    """Let what strikes give back its share, and the others hold against it; see `_solve`."""
    points = impact.points
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        returned = points[place + record.RESTITUTION] * points[place + record.COMPRESSION]
        points[place + record.NORMAL_IMPULSE] += returned
        _act(place, scale(returned, load(points, place + record.NORMAL)), impact)
    return _solve(False, impact)


@kernel
def _share(returned: float, impact: JointImpact) -> float:
    """
    Return the share of the restitution that gives no more energy than may come back.

    With the share s it gives s J . u_c + s^2 J . (u_r - u_c) / 2, summed over the points; u_c and
    u_r are the velocities after the compression, and after all of the restitution.
    """
    points = impact.points
    linear, square = 0.0, 0.0
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        given = subtract(_impulse(place, points), load(points, place + record.COMPRESSION_IMPULSE))
        before = load(points, place + record.COMPRESSED)
        linear += dot(given, before)
        square += 0.5 * dot(given, subtract(_relative_velocity(place, impact), before))
    if linear + square <= returned * (1.0 + ENERGY_ROUND_OFF):
        return 1.0
    return 2.0 * returned / (linear + math.sqrt(linear * linear + 4.0 * square * returned))


@inline
def _between(array: Array, now: int, before: int, share: float) -> None:
    """Go back from three numbers to a share of the way from three others."""
    start = load(array, before)
    store(array, now, add_scaled(start, share, subtract(load(array, now), start)))


@kernel
def joint_impact(impact: JointImpact) -> bool:
    """
    Let bodies meet at several points at once: see above. Writes the impulses of the points and the
    velocities of the bodies; returns whether the impulses settled.
    """
    points, bodies = impact.points, impact.bodies
    _prepare(impact)
    _press_together(impact)
    settled = _solve(True, impact)
    returned = _end_compression(impact)
    share = 0.0
    if returned > 0.0:
        settled = _restore(impact) and settled
        share = _share(returned, impact)
    for number in range(impact.point_count):
        place = number * record.POINT_SIZE
        store(points, place + record.IMPULSE, _impulse(place, points))
        if share < 1.0:
            _between(points, place + record.IMPULSE, place + record.COMPRESSION_IMPULSE, share)
    if share < 1.0:
        for number in range(impact.body_count):
            row = number * record.BODY_SIZE
            velocity, spin = row + record.VELOCITY, row + record.ANGULAR_VELOCITY
            _between(bodies, velocity, row + record.COMPRESSED_VELOCITY, share)
            _between(bodies, spin, row + record.COMPRESSED_SPIN, share)
    return settled
