# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Friction of several faces as that of one surface.

Where the faces of a body on another carry one pressure (`common_pressure`) and have one
coefficient of friction, they have one patch as well: that of the manifold which carries most, with
force, torque, middle and size of all of them (`patch_friction`). So a floor of tiles brakes what
drills on it as a floor of one piece does. The manifolds of the others have no friction of their
own in such a tick, but for that of restitution; at its end each point has its part.

Such manifolds are a chain from the one that has the friction: FIRST_OTHER there, then NEXT_OTHER,
where their lanes begin in the rows. The second moment of a uniform pressure on the whole is

    Sigma = sum A_j (k_j Sigma_j + (c_j - c)(c_j - c)^T) / sum A_j       k_j, c_j: of each face
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    friction_patch,
    lane_scratch,
    pressure_of_face,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import add, add_scaled, cross, dot, scale, subtract

ALONE, OF_ANOTHER = 0.0, -1.0  # in FIRST_OTHER: no others; friction is that of another manifold


@inline
def _patch_of(lane: int, width: int) -> int:
    """Where the friction of a lane begins in the rows."""
    return lane + constraint.SIZE + MOST * width


@inline
def leave_alone(lane: int, width: int, rows: Array) -> None:
    """Begin a tick: a manifold has its own friction."""
    rows[_patch_of(lane, width) + friction_patch.FIRST_OTHER] = ALONE
    rows[_patch_of(lane, width) + friction_patch.NEXT_OTHER] = 0.0


@inline
def _point_row(lane: int, point: int, width: int) -> int:
    """Where a point of a lane begins in the rows."""
    return lane + constraint.SIZE + point * width


@inline
def _moves_a(lane: int, width: int, rows: Array) -> Any:
    """Tell whether the body whose faces they are is A of a manifold."""
    return rows[_patch_of(lane, width) + friction_patch.MOVER] > 0.0


@inline
def _sign(lane: int, head: int, width: int, rows: Array) -> Any:
    """Return 1 if A and B are those of another manifold, -1 if they are the other way round."""
    mover = friction_patch.MOVER
    return rows[_patch_of(lane, width) + mover] * rows[_patch_of(head, width) + mover]


@inline
def _arm(lane: int, row: int, width: int, rows: Array) -> Any:
    """Arm of a point from that body."""
    if _moves_a(lane, width, rows):
        return wide_lanes.vector(rows, row + contact_point.ARM_A)
    return wide_lanes.vector(rows, row + contact_point.ARM_B)


@inline
def _arm_of_center(lane: int, width: int, rows: Array) -> Any:
    """Arm of the centre of a patch from that body."""
    patch = _patch_of(lane, width)
    if _moves_a(lane, width, rows):
        return wide_lanes.vector(rows, patch + friction_patch.ARM_A)
    return wide_lanes.vector(rows, patch + friction_patch.ARM_B)


@inline
def any_surface(scratch: Array) -> Any:
    """Tell whether some manifolds of the group have one friction in this tick."""
    return scratch[lane_scratch.SURFACES] > 0.0


@inline
def _friction_of(lane: int, row: int, rows: Array) -> Any:
    """Friction impulse of a point, as recalled, world axes."""
    return add(
        scale(
            rows[row + contact_point.TANGENT_IMPULSE_1],
            wide_lanes.vector(rows, lane + constraint.TANGENT_1),
        ),
        scale(
            rows[row + contact_point.TANGENT_IMPULSE_2],
            wide_lanes.vector(rows, lane + constraint.TANGENT_2),
        ),
    )


@inline
def _put_friction(lane: int, row: int, impulse: Any, rows: Array) -> None:
    """Write it."""
    rows[row + contact_point.TANGENT_IMPULSE_1] = dot(
        impulse, wide_lanes.vector(rows, lane + constraint.TANGENT_1)
    )
    rows[row + contact_point.TANGENT_IMPULSE_2] = dot(
        impulse, wide_lanes.vector(rows, lane + constraint.TANGENT_2)
    )


@inline
def name_mover(lane: int, side: int, width: int, rows: Array) -> None:
    """Say whose faces those of a surface are; side: 0: of A, 1: of B."""
    rows[_patch_of(lane, width) + friction_patch.MOVER] = 1.0 - 2.0 * side


@kernel
def _take_recalled(
    count: int, members: Indices, first: int, width: int, manifolds: Array, rows: Array
) -> None:
    """Move the friction that all recall to the points of one of them, as one force and twist."""
    lane = int(manifolds[first + manifold_record.LANE])
    points = int(manifolds[first + manifold_record.POINT_COUNT])
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    middle, spread = (0.0, 0.0, 0.0), 0.0
    origin = first + manifold_record.POINTS
    for point in range(points):
        middle = add_scaled(
            middle, 1.0 / points, pressure_of_face.way(origin, first, point, manifolds)
        )
    for point in range(points):
        arm = subtract(pressure_of_face.way(origin, first, point, manifolds), middle)
        spread += dot(arm, arm)
    force, twist = (0.0, 0.0, 0.0), 0.0
    for place in range(count):
        record = members[place]
        its_lane = int(manifolds[record + manifold_record.LANE])
        whose = _sign(its_lane, lane, width, rows)
        for point in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            row = _point_row(its_lane, point, width)
            impulse = scale(whose, _friction_of(its_lane, row, rows))
            arm = subtract(pressure_of_face.way(origin, record, point, manifolds), middle)
            force = add(force, impulse)
            twist += dot(normal, cross(arm, impulse))
            rows[row + contact_point.TANGENT_IMPULSE_1] = 0.0
            rows[row + contact_point.TANGENT_IMPULSE_2] = 0.0
    for point in range(points):
        arm = subtract(pressure_of_face.way(origin, first, point, manifolds), middle)
        turn = twist / spread if spread > 0.0 else 0.0
        impulse = add_scaled(scale(1.0 / points, force), turn, cross(normal, arm))
        _put_friction(lane, _point_row(lane, point, width), impulse, rows)


@kernel
def join(
    count: int, members: Indices, first: int, share: float, width: int, manifolds: Array,
    rows: Array, scratch: Array,
) -> None:  # fmt: skip
    """
    Let the manifolds of a surface have one friction.

        members : where their records begin
        first   : of the one that has the friction
        share   : k_face of all
    """
    mu = rows[int(manifolds[first + manifold_record.LANE]) + constraint.FRICTION]
    for place in range(count):
        lane = int(manifolds[members[place] + manifold_record.LANE])
        if rows[lane + constraint.FRICTION] != mu:
            return
    scratch[lane_scratch.SURFACES] = 1.0
    _take_recalled(count, members, first, width, manifolds, rows)
    head = int(manifolds[first + manifold_record.LANE])
    patch = _patch_of(head, width)
    rows[patch + friction_patch.UNIFORM] = share
    before, field = patch, friction_patch.FIRST_OTHER
    for place in range(count):
        if members[place] == first:
            continue
        lane = int(manifolds[members[place] + manifold_record.LANE])
        rows[before + field] = float(lane)
        before, field = _patch_of(lane, width), friction_patch.NEXT_OTHER
        rows[before + friction_patch.FIRST_OTHER] = OF_ANOTHER


@kernel
def add_press_of_others(used: int, width: int, rows: Array, patch: Array, scratch: Array) -> None:
    """
    Add what presses on the other manifolds of a surface; nothing presses on those that have no
    friction of their own.
    """
    for lane in range(used):
        other = patch[lane + friction_patch.FIRST_OTHER]
        if other == OF_ANOTHER:
            scratch[lane + lane_scratch.PRESS] = 0.0
            continue
        while other > 0.0:
            for point in range(MOST):
                row = _point_row(int(other), point, width)
                scratch[lane + lane_scratch.PRESS] += rows[row + contact_point.NORMAL_IMPULSE]
            other = rows[_patch_of(int(other), width) + friction_patch.NEXT_OTHER]


@kernel
def add_moments_of_others(
    used: int, first: int, width: int, rows: Array, patch: Array, scratch: Array
) -> None:
    """Do the same with all sums of `patch_friction.add_moments`."""
    begin = first - constraint.SIZE  # of the batch: lanes of `rows` are absolute
    for lane in range(used):
        other = patch[lane + friction_patch.FIRST_OTHER]
        if other == OF_ANOTHER:
            scratch[lane + lane_scratch.PRESS] = 0.0
            continue
        if not other > 0.0:
            continue
        tangent_1 = wide_lanes.vector(rows, begin + lane + constraint.TANGENT_1)
        tangent_2 = wide_lanes.vector(rows, begin + lane + constraint.TANGENT_2)
        center = _arm_of_center(begin + lane, width, rows)
        while other > 0.0:
            for point in range(MOST):
                row = _point_row(int(other), point, width)
                press = rows[row + contact_point.NORMAL_IMPULSE]
                if not press > 0.0:
                    continue
                arm = subtract(_arm(int(other), row, width, rows), center)
                place_1, place_2 = dot(arm, tangent_1), dot(arm, tangent_2)
                scratch[lane + lane_scratch.PRESS] += press
                scratch[lane + lane_scratch.PRESS_1] += press * place_1
                scratch[lane + lane_scratch.PRESS_2] += press * place_2
                scratch[lane + lane_scratch.PRESS_11] += press * place_1 * place_1
                scratch[lane + lane_scratch.PRESS_12] += press * place_1 * place_2
                scratch[lane + lane_scratch.PRESS_22] += press * place_2 * place_2
            other = rows[_patch_of(int(other), width) + friction_patch.NEXT_OTHER]


@inline
def _press_over_tick(row: int, rows: Array) -> float:
    """What a point has pressed over the tick."""
    return rows[row + contact_point.TOTAL_IMPULSE] + rows[row + contact_point.NORMAL_IMPULSE]


@kernel
def _sums(head: int, center: Any, width: int, rows: Array) -> Any:
    """Sum up what the points of a surface have pressed: all, middle from the centre, trace."""
    total, moment, square = 0.0, (0.0, 0.0, 0.0), 0.0
    lane = head
    while lane > 0:
        for point in range(MOST):
            row = _point_row(lane, point, width)
            press = _press_over_tick(row, rows)
            if press > 0.0:
                arm = subtract(_arm(lane, row, width, rows), center)
                total += press
                moment = add_scaled(moment, press, arm)
                square += press * dot(arm, arm)
        field = friction_patch.FIRST_OTHER if lane == head else friction_patch.NEXT_OTHER
        lane = int(rows[_patch_of(lane, width) + field])
    if not total > 0.0:
        return 0.0, moment, 0.0
    middle = scale(1.0 / total, moment)
    return total, middle, square / total - dot(middle, middle)


@kernel
def _spread_surface(head: int, width: int, rows: Array) -> None:
    """Give the points of a surface their parts of its friction: see `patch_friction.spread`."""
    center = _arm_of_center(head, width, rows)
    total, middle, trace = _sums(head, center, width, rows)
    if not total > 0.0:
        return
    normal = wide_lanes.vector(rows, head + constraint.NORMAL)
    tangent_1 = wide_lanes.vector(rows, head + constraint.TANGENT_1)
    tangent_2 = wide_lanes.vector(rows, head + constraint.TANGENT_2)
    patch = _patch_of(head, width)
    now = wide_lanes.vector(rows, patch + friction_patch.IMPULSE_1)
    whole = wide_lanes.vector(rows, patch + friction_patch.TOTAL_1)
    force = add(scale(now[0], tangent_1), scale(now[1], tangent_2))
    force_whole = add(scale(whole[0], tangent_1), scale(whole[1], tangent_2))
    inverse = 1.0 / trace if trace > contact_point.ONE_POINT else 0.0
    turn = inverse * (now[2] - dot(normal, cross(middle, force)))
    turn_whole = inverse * (whole[2] - dot(normal, cross(middle, force_whole)))
    lane = head
    while lane > 0:
        sign = _sign(lane, head, width, rows)
        for point in range(MOST):
            row = _point_row(lane, point, width)
            share = sign * _press_over_tick(row, rows) / total
            arm = subtract(subtract(_arm(lane, row, width, rows), center), middle)
            across = cross(normal, arm)
            impulse = scale(share, add_scaled(force, turn, across))
            _put_friction(lane, row, impulse, rows)
            impulse = scale(share, add_scaled(force_whole, turn_whole, across))
            for axis, tangent in ((1, constraint.TANGENT_1), (2, constraint.TANGENT_2)):
                at = row + contact_point.TOTAL_IMPULSE + axis * constraint.LANES
                rows[at] += dot(impulse, wide_lanes.vector(rows, lane + tangent))
        field = friction_patch.FIRST_OTHER if lane == head else friction_patch.NEXT_OTHER
        lane = int(rows[_patch_of(lane, width) + field])


@kernel
def spread(used: int, first: int, width: int, rows: Array) -> None:
    """Do so for all surfaces whose friction is that of a lane of a batch."""
    for lane in range(first - constraint.SIZE, first - constraint.SIZE + used):
        if rows[_patch_of(lane, width) + friction_patch.FIRST_OTHER] > 0.0:
            _spread_surface(lane, width, rows)
