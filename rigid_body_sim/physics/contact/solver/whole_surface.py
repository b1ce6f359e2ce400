# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Normals of several manifolds that are one surface, solved as a whole before a pass visits them one
by one: what falls flat on tiles, or lies with several parts on one plane, is not turned.

Each manifold alone gives the body a turn, which the others take back to the tolerance of the
passes (`whole_manifold`). But all of one body on one other with one normal (`surface_members`)
are again points of two rigid bodies in a plane. So their impulses are sought in the same form, of
places in the plane, with middles and sums over all of them,

    (B + C) mu = -sum_i psi(i) r_i,   J_i <- J_i + t sum_j mu_j psi_j(i)

    B_jl = F_j . F_l (1/m_A + 1/m_B) + G_j . I^-1 G_l of A and of B
    F_j = sum_i psi_j(i) n_i,   G_j = sum_i psi_j(i) r_i x n_i

with psi, r and t of `whole_manifold`; C as there, or sum_i c_i psi(i) psi(i)^T of what has springs
at its points (`surface_springs`); n_i the normal, up to its sign one and the same but for
rounding. At first psi(i) is taken times J_i / max J, where anything presses: so what lets go does
so at all points at once, however many there are. The visits of the points follow.

A surface is a chain of lanes: `surface_chain`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.solver import (
    bends,
    constraint,
    contact_point,
    lane_scratch,
    rolling_frame,
    solve,
    surface_chain,
    whole_manifold,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    add_symmetric,
    cross,
    dot,
    load,
    scale,
    store,
    subtract,
)

ROUNDS = 12  # of active sets, at most: what is left then, the next pass does

SOFT = slot('[-] whether overlaps are soft, before the motion')
BOUNCING = slot('[-] whether it is the impulse of restitution')
WIDTH = slot('[-] numbers of a point')
TURNS = slot('[-] whether the inertia of anything turns with it, or changes')
RIMS = slot('[-] whether a cylinder may touch')
BENDS = slot('[-] whether anything turns but balls about their centres')
LAYERED = slot('[-] whether anything is a ball or a capsule')
law = slot('kernel (constraints, points, ...): r, c, and whether a point takes part')
part_of = slot('kernel (row, place, change, points): what a point has, and its part')
give_to_point = slot('kernel (row, share, part, points): gives a point its part')
sum_up_surface = slot('kernel (first, ...): sums of the points of a surface')
find_share = slot('kernel (first, ...): which share of a change its points can take')
give_to_surface = slot('kernel (first, ...): gives them their impulses')


@inline
def note_changes(lanes: int, constraints: Array, scratch: Array) -> None:
    """
    Let what a surface was given count for a change of its lanes in this pass, of those that it has
    visited.
    """
    for lane in range(lanes):
        of_surface = constraints[lane + constraint.SURFACE] > constraint.OF_NO_SURFACE
        change = constraints[lane + constraint.SURFACE_CHANGE]
        before = scratch[lane + lane_scratch.LARGEST_CHANGE]
        visited = scratch[lane + lane_scratch.VISITED] > 0.0
        counts = of_surface & visited & (change > before)
        scratch[lane + lane_scratch.LARGEST_CHANGE] = change if counts else before


@inline
def _begin_of(lane: int) -> Any:
    """Where the batch of a lane begins in the rows: batches begin at multiples of LANES."""
    return lane - lane % LANES


@inline
def _fetch(own: int, constraints: Array, scratch: Array, bodies: Array) -> None:
    """Fetch the momenta of the bodies of one lane of a batch: see `solve.gather_momenta`."""
    body_a = int(constraints[own + constraint.BODY_A]) + solver_bodies.MOMENTUM
    body_b = int(constraints[own + constraint.BODY_B]) + solver_bodies.MOMENTUM
    for number in range(6):
        row = own + number * LANES
        scratch[row + lane_scratch.MOMENTUM_A] = bodies[body_a + number]
        scratch[row + lane_scratch.MOMENTUM_B] = bodies[body_b + number]
    solve.begin_lane(own, constraints, scratch)


@inline
def _arms_and_normal(own: int, row: int, sign: float, constraints: Array, points: Array) -> Any:
    """
    Return the arms of a point on the bodies that are A and B of the first manifold of its surface,
    and its normal from A to B; sign: 1 if they are those of its own, else -1.
    """
    arm_a, arm_b = wide_lanes.arms(points, row)
    normal = wide_lanes.vector(constraints, own + constraint.NORMAL)
    if sign > 0.0:
        return arm_a, arm_b, normal
    return arm_b, arm_a, scale(-1.0, normal)


@inline
def _sign(lane: int, first: int, rows: Array) -> Any:
    """Return 1 if A and B of a manifold are those of the first one of its surface, else -1."""
    same = rows[lane + constraint.BODY_A] == rows[first + constraint.BODY_A]
    same = same and rows[lane + constraint.BODY_B] == rows[first + constraint.BODY_B]
    return 1.0 if same else -1.0


@inline
def _place(arm_b: Any, first: int, rows: Array) -> Any:
    """Return where the end of an arm on B is from the first point of a surface [m]."""
    way = subtract(arm_b, wide_lanes.vector(rows, first + constraint.SIZE + contact_point.ARM_B))
    return (
        dot(way, wide_lanes.vector(rows, first + constraint.TANGENT_1)),
        dot(way, wide_lanes.vector(rows, first + constraint.TANGENT_2)),
    )


@kernel
def _begin(first: int, width: int, rows: Array) -> None:
    """Let all points of a surface take part; nothing has been given yet."""
    lane = first
    while lane > 0:
        rows[lane + constraint.SURFACE_CHANGE] = 0.0
        for point in range(int(rows[lane + constraint.SURFACE_POINTS])):
            rows[lane + constraint.SIZE + point * width + contact_point.DROPPED] = 0.0
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])


@kernel
def _goes_on(first: int, rows: Array) -> bool:
    """
    Tell whether the last pass has changed some lane of a surface; let all of them be visited then.
    What is given to the whole may let go on a lane that the last pass has left alone.
    """
    most = 0.0
    lane = first
    while lane > 0:
        most = max(most, rows[lane + constraint.UNSETTLED])
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    if not most > 0.0:
        return False
    lane = first
    while lane > 0:
        rows[lane + constraint.UNSETTLED] = most
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    return True


@kernel
def _most_pressed(first: int, width: int, soft: bool, bouncing: bool, rows: Array) -> float:
    """Return the largest impulse of a point of a surface so far; soft, bouncing: of the pass."""
    most = 0.0
    lane = first
    while lane > 0:
        for point in range(int(rows[lane + constraint.SURFACE_POINTS])):
            row = lane + constraint.SIZE + point * width
            most = max(most, whole_manifold.impulse_so_far(row, rows, soft, bouncing))
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    return most


def _sum_up_surface(
    first: int, most: float, inverse_h: float, slop: float, cap: float, rows: Array,
    scratch: Array, bodies: Array,
) -> Any:  # fmt: skip
    """
    Add up what takes part of a surface: 1, x, y, x^2, xy, y^2; r, r x, r y; c and the same of it;
    F_0, F_1, F_2; G_0, G_1, G_2 of A, and of B. Places are from its first point.

    most : largest impulse so far, by which points are weighed by their own; 0: they are not
    """
    zero = 0.0, 0.0, 0.0
    one_spring = rows[first + constraint.SPRING_MASS] > 0.0
    pressed = surface_chain.impulse_of(first, WIDTH, rows, scratch) if SOFT else 0.0
    soft, soft_count, soft_x, soft_y = 0.0, 0.0, 0.0, 0.0
    places = softness = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    drives, f_0, f_1, f_2 = zero, zero, zero, zero
    a_0, a_1, a_2, b_0, b_1, b_2 = zero, zero, zero, zero, zero, zero
    lane = first
    while lane > 0:
        begin = _begin_of(lane)
        own = lane - begin
        constraints = rows[begin : begin + constraint.SIZE]
        count = int(rows[lane + constraint.SURFACE_POINTS])
        points = rows[begin + constraint.SIZE : begin + constraint.SIZE + count * WIDTH]
        _fetch(own, constraints, scratch, bodies)
        if SOFT and BENDS:
            bends.find_bends_of_lane(own, TURNS, LAYERED, inverse_h, constraints, scratch)
        if SOFT and RIMS:
            rolling_frame.find_bends_of_lane(own, inverse_h, constraints, scratch, bodies)
        scratch[own + lane_scratch.SPRING_IMPULSE] = pressed
        motion = whole_manifold.find_motion(own, TURNS, constraints, scratch)
        sign = _sign(lane, first, rows)
        for point in range(count):
            row = own + point * WIDTH
            arm_a, arm_b = wide_lanes.arms(points, row)
            velocity = motion[0] + (dot(motion[2], arm_b) - dot(motion[1], arm_a))
            r, c, takes_part = law(
                constraints, points, scratch, own, row, velocity, inverse_h, slop, cap
            )
            weight = whole_manifold.impulse_so_far(row, points, SOFT, BOUNCING)
            weight = weight / most if most > 0.0 else points[row + contact_point.SPRING_SHARE]
            weight = weight if takes_part else 0.0
            points[row + contact_point.TAKES_PART] = weight
            if not weight > 0.0:
                continue
            arm_a, arm_b, normal = _arms_and_normal(own, row, sign, constraints, points)
            x, y = _place(arm_b, first, rows)
            normal = scale(weight, normal)
            of_a, of_b = cross(arm_a, normal), cross(arm_b, normal)
            r = weight * r
            along_x, along_y = weight * x, weight * y
            own_places = weight, along_x, along_y, along_x * x, along_x * y, along_y * y
            places = add_symmetric(places, own_places)
            drives = add(drives, (r, r * x, r * y))
            if one_spring and c > 0.0:
                soft, soft_count = soft + weight * c, soft_count + weight
                soft_x, soft_y = soft_x + along_x, soft_y + along_y
            else:
                softness = add_symmetric(
                    softness, whole_manifold.square_of(c, weight, along_x, along_y)
                )
            f_0, f_1, f_2 = (
                add(f_0, normal),
                add_scaled(f_1, x, normal),
                add_scaled(f_2, y, normal),
            )
            a_0, a_1, a_2 = add(a_0, of_a), add_scaled(a_1, x, of_a), add_scaled(a_2, y, of_a)
            b_0, b_1, b_2 = add(b_0, of_b), add_scaled(b_1, x, of_b), add_scaled(b_2, y, of_b)
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    if one_spring and soft_count > 0.0:
        softness = whole_manifold.square_of(soft / soft_count, soft_count, soft_x, soft_y)
    return places, drives, softness, (f_0, f_1, f_2), (a_0, a_1, a_2), (b_0, b_1, b_2)


@inline
def _about_middle(sums: Any, x: float, y: float) -> Any:
    """Return sums of vectors times psi_0, psi_1, psi_2 from those times 1, x, y."""
    return sums[0], add_scaled(sums[1], -x, sums[0]), add_scaled(sums[2], -y, sums[0])


@inline
def _products(vectors: Any, factor: float) -> Any:
    """Return the products of three vectors times a factor: 00, 01, 02, 11, 12, 22."""
    zero, one, two = vectors
    return (
        factor * dot(zero, zero), factor * dot(zero, one), factor * dot(zero, two),
        factor * dot(one, one), factor * dot(one, two), factor * dot(two, two),
    )  # fmt: skip


@inline
def _soft_about_middle(sums: Any, x: float, y: float) -> Any:
    """
    Return C: 00, 01, 02, 11, 12, 22.

        sums : of c times 1, x, y, x^2, xy, y^2
        x, y : middle of what takes part
    """
    c, c_x, c_y, c_xx, c_xy, c_yy = sums
    return (
        c, c_x - x * c, c_y - y * c,
        c_xx - x * (2.0 * c_x - x * c),
        c_xy - x * c_y - y * (c_x - x * c),
        c_yy - y * (2.0 * c_y - y * c),
    )  # fmt: skip


@kernel
def _change_of(first: int, turns: bool, found: Any, rows: Array) -> Any:
    """
    Return the change of the points of a surface: at its first one, and along the two tangents per
    way from there; found: see `_sum_up_surface`.
    """
    places, drives, soft, forces, of_a, of_b = found
    s, s_x, s_y, s_xx, _, s_yy = places
    x, y = s_x / s, s_y / s
    forces = _about_middle(forces, x, y)
    of_a, of_b = _about_middle(of_a, x, y), _about_middle(of_b, x, y)
    inverse_mass = (
        rows[first + constraint.INVERSE_MASS_A] + rows[first + constraint.INVERSE_MASS_B]
    )
    row_a, row_b = first + constraint.INVERSE_INERTIA_A, first + constraint.INVERSE_INERTIA_B
    m = _products(forces, inverse_mass)
    m = add_symmetric(m, whole_manifold.response_of(row_a, turns, of_a, rows))
    m = add_symmetric(m, whole_manifold.response_of(row_b, turns, of_b, rows))
    m = add_symmetric(m, _soft_about_middle(soft, x, y))
    spread = (
        whole_manifold.spread_along(s_xx, x, s_x), whole_manifold.spread_along(s_yy, y, s_y)
    )  # fmt: skip
    return whole_manifold.change_from(spread, drives, m, (x, y), True)


def _part(row: int, place: Any, change: Any, points: Array) -> Any:
    """Return the impulse that a point has, as far as it has come, and its part of the change."""
    part = change[0] + (place[0] * change[1] + place[1] * change[2])
    part *= points[row + contact_point.TAKES_PART]
    return whole_manifold.impulse_so_far(row, points, SOFT, BOUNCING), part


def _find_share(first: int, change: Any, rows: Array) -> Any:
    """
    Return the share of a change of a surface at which the first of its impulses comes to 0, at
    most 1; points that have none, and would be given less, are dropped.
    """
    soonest = 1.0, 1.0
    lane = first
    while lane > 0:
        begin = _begin_of(lane)
        own = lane - begin
        constraints = rows[begin : begin + constraint.SIZE]
        count = int(rows[lane + constraint.SURFACE_POINTS])
        points = rows[begin + constraint.SIZE : begin + constraint.SIZE + count * WIDTH]
        sign = _sign(lane, first, rows)
        for point in range(count):
            row = own + point * WIDTH
            if points[row + contact_point.TAKES_PART] > 0.0:
                arms = _arms_and_normal(own, row, sign, constraints, points)
                part = part_of(row, _place(arms[1], first, rows), change, points)
                soonest = whole_manifold.sooner(row, part, soonest, points)
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    return soonest[0] / soonest[1]


def _give_to_surface(first: int, share: float, change: Any, rows: Array, bodies: Array) -> None:
    """Give the points of a surface a share of its change, and its bodies what they give."""
    zero = 0.0, 0.0, 0.0
    linear, of_a, of_b = zero, zero, zero
    lane = first
    while lane > 0:
        begin = _begin_of(lane)
        own = lane - begin
        constraints = rows[begin : begin + constraint.SIZE]
        count = int(rows[lane + constraint.SURFACE_POINTS])
        points = rows[begin + constraint.SIZE : begin + constraint.SIZE + count * WIDTH]
        sign = _sign(lane, first, rows)
        largest = constraints[own + constraint.SURFACE_CHANGE]
        for point in range(count):
            row = own + point * WIDTH
            if points[row + contact_point.TAKES_PART] > 0.0:
                arm_a, arm_b, normal = _arms_and_normal(own, row, sign, constraints, points)
                part = part_of(row, _place(arm_b, first, rows), change, points)
                given = give_to_point(row, share, part, points)[0]
                largest = max(largest, abs(given))
                linear = add_scaled(linear, given, normal)
                of_a = add_scaled(of_a, given, cross(arm_a, normal))
                of_b = add_scaled(of_b, given, cross(arm_b, normal))
        constraints[own + constraint.SURFACE_CHANGE] = largest
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    for number in range(2):
        place = constraint.BODY_A if number == 0 else constraint.BODY_B
        sign = -1.0 if number == 0 else 1.0
        moment = of_a if number == 0 else of_b
        row = int(rows[first + place]) + solver_bodies.MOMENTUM
        store(bodies, row, add_scaled(load(bodies, row), sign, linear))
        row += 3
        store(bodies, row, add_scaled(load(bodies, row), sign, moment))


def _solve_surfaces(
    number_of_pass: int, inverse_h: float, slop: float, cap: float, rows: Array, scratch: Array,
    bodies: Array,
) -> None:  # fmt: skip
    """
    Solve the normals of all surfaces of several manifolds that are linked.

    number_of_pass : of the first, 0: solve all; else those which the last pass has changed
    """
    first = int(scratch[lane_scratch.WHOLE_SURFACES])
    while first > 0:
        if number_of_pass == 0 or _goes_on(first, rows):
            _begin(first, WIDTH, rows)
            most = _most_pressed(first, WIDTH, SOFT, BOUNCING, rows)
            for turn in range(ROUNDS):
                found = sum_up_surface(
                    first, most if turn == 0 else 0.0, inverse_h, slop, cap, rows, scratch, bodies
                )
                if not found[0][0] > 0.0 or not whole_manifold.stirs(found[0], found[1]):
                    break
                change = _change_of(first, TURNS, found, rows)
                share = find_share(first, change, rows)
                give_to_surface(first, share, change, rows, bodies)
            if SOFT:
                surface_chain.note_impulses_of(first, WIDTH, rows, scratch)
        first = int(rows[first + constraint.NEXT_SURFACE])


def visit(
    kind: str, width: int, *, turns: bool, arcs: bool, layered: bool, on_rims: bool
) -> Callable[..., Any]:
    """Make the kernel of a pass: arguments as of `whole_manifold.visit`."""
    offered = whole_manifold.offered_for(
        kind, width, turns=turns, arcs=arcs, layered=layered, on_rims=on_rims
    )
    name = f'{kind}_{width}'
    offered['part_of'] = specialise(_part, name=name, inlined=True, offered=offered)
    parts = {
        'sum_up_surface': _sum_up_surface,
        'find_share': _find_share,
        'give_to_surface': _give_to_surface,
    }
    for slot_name, source in parts.items():
        offered[slot_name] = specialise(source, name=name, offered=offered)
    return specialise(_solve_surfaces, name=name, offered=offered)
