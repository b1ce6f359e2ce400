# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Balls, capsules and mantles of cylinders that meet at one point: separation and normal after the
motion over a substep are those of the nearest points of their cores.

A ball is a layer about a point, a capsule and the mantle of a cylinder about a segment of their
axis. With the middles m, the axes a, b and the half lengths of the cores, w = m_B - m_A, all moved
and turned with the bodies,

    d = w + t b - s a,  |d| least;   n = d/|d|,   separation |d| - R_A - R_B
    s = clamp((w . a - (a . b) w . b) / (1 - (a . b)^2)),   t = clamp((a . b) s - w . b)

(Ericson, Real-Time Collision Detection, 5.1.9). The point of contact is the one midway between the
surfaces on this line, or on the surface of the one that moves. What has hit something that cannot
move and bounces off it keeps normal and arms: it bounces by the law of the place where it hit.

Where the end of a cylinder meets, the core is no segment: there the normal stays for the tick.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import collider, collider_record, pose
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_NEAREST_POINT
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    core_pair,
    lane_scratch,
    separation,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import add, add_scaled, dot, load, scale, subtract

ACROSS = 1e-9  # [-] cosine of a normal and an axis: below, it is that of a line
SIDE_BY_SIDE = 1e-2  # [-] sin^2 of two axes: below, the normal follows one of them alone


@inline
def has_core(kind: int) -> bool:
    """Tell whether a type of collider is a layer about a point or a segment, wholly or in part."""
    return kind == collider.SPHERE or kind == collider.CAPSULE or kind == collider.CYLINDER


@inline
def _core(number: int, center: Any, colliders: ColliderArrays) -> Any:
    """
    Return middle, axis, half length and layer of the core of a collider; center: of mass [m].
    """
    row = number * collider_record.SIZE
    begin = colliders.table[row + collider_record.PARAMETERS]
    middle = subtract(load(colliders.poses, number * pose.SIZE), center)
    radius = colliders.parameters[begin + RADIUS]
    if colliders.table[row + collider_record.TYPE] == collider.SPHERE:
        return middle, (0.0, 0.0, 0.0), 0.0, radius
    axis = pose.axis(colliders.poses, number * pose.SIZE, 2)
    return middle, axis, colliders.parameters[begin + HALF_LENGTH], radius


@inline
def _is_at_an_end(number: int, axis: Any, normal: Any, colliders: ColliderArrays) -> bool:
    """Tell whether a collider is a cylinder that meets elsewhere than at its mantle."""
    kind = colliders.table[number * collider_record.SIZE + collider_record.TYPE]
    return kind == collider.CYLINDER and abs(dot(axis, normal)) > ACROSS


@kernel
def prepare_cores(
    a: int, b: int, lane: int, width: int, center_a: Any, center_b: Any,
    colliders: ColliderArrays, rows: Array,
) -> None:  # fmt: skip
    """
    Write the cores of a manifold of one point, after its normal, arms and separation.

    a, b               : its colliders
    width              : numbers of a point
    center_a, center_b : of mass of their bodies, or where arms begin [m]
    """
    middle_a, axis_a, half_a, radius_a = _core(a, center_a, colliders)
    middle_b, axis_b, half_b, radius_b = _core(b, center_b, colliders)
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    point = lane + constraint.SIZE
    turns = not (
        _is_at_an_end(a, axis_a, normal, colliders) or _is_at_an_end(b, axis_b, normal, colliders)
    )
    if turns:
        rows[lane + constraint.RADIUS_A] = radius_a
        rows[lane + constraint.RADIUS_B] = radius_b
    else:
        arm_a, arm_b = wide_lanes.arms(rows, point)
        layer_a, layer_b = radius_a, radius_b
        if colliders.table[a * collider_record.SIZE + collider_record.TYPE] == collider.CYLINDER:
            layer_a = 0.0
        if colliders.table[b * collider_record.SIZE + collider_record.TYPE] == collider.CYLINDER:
            layer_b = 0.0
        rows[lane + constraint.RADIUS_A] = layer_a
        rows[lane + constraint.RADIUS_B] = layer_b
        middle_a, middle_b = (
            add_scaled(arm_a, -layer_a, normal),
            add_scaled(arm_b, layer_b, normal),
        )
        axis_a, axis_b = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        half_a, half_b = 0.0, 0.0
    cores = point + width
    wide_lanes.put_vector(rows, cores + core_pair.OFFSET, subtract(center_b, center_a))
    wide_lanes.put_vector(rows, cores + core_pair.MIDDLE_A, middle_a)
    wide_lanes.put_vector(rows, cores + core_pair.AXIS_A, axis_a)
    rows[cores + core_pair.HALF_A] = half_a
    wide_lanes.put_vector(rows, cores + core_pair.MIDDLE_B, middle_b)
    wide_lanes.put_vector(rows, cores + core_pair.AXIS_B, axis_b)
    rows[cores + core_pair.HALF_B] = half_b
    gap = rows[point + contact_point.INITIAL_SEPARATION]
    rows[cores + core_pair.DISTANCE] = gap + (radius_a + radius_b)
    rows[cores + core_pair.TURNS] = 1.0 if turns else 0.0


@kernel
def gather_lines(lanes: int, constraints: Array, cores: Array, scratch: Array) -> None:
    """Fetch the axes along which the cores of a batch meet as lines, for `approach`."""
    for lane in range(lanes):
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        axis_a = wide_lanes.vector(cores, lane + core_pair.AXIS_A)
        axis_b = wide_lanes.vector(cores, lane + core_pair.AXIS_B)
        cosine = dot(axis_a, axis_b)
        line_a = abs(dot(normal, axis_a)) < ACROSS
        apart = (not line_a) | (1.0 - cosine * cosine > SIDE_BY_SIDE)
        line_b = (abs(dot(normal, axis_b)) < ACROSS) & apart
        share_a, share_b = 1.0 if line_a else 0.0, 1.0 if line_b else 0.0
        wide_lanes.put_vector(scratch, lane + lane_scratch.LINE_A, scale(share_a, axis_a))
        wide_lanes.put_vector(scratch, lane + lane_scratch.LINE_B, scale(share_b, axis_b))
        scratch[lane + lane_scratch.CURVED] = cores[lane + core_pair.TURNS]


@kernel
def clear_lines(lanes: int, scratch: Array) -> None:
    """Let a batch have no such axes."""
    for lane in range(lanes):
        wide_lanes.put_vector(scratch, lane + lane_scratch.LINE_A, (0.0, 0.0, 0.0))
        wide_lanes.put_vector(scratch, lane + lane_scratch.LINE_B, (0.0, 0.0, 0.0))
        scratch[lane + lane_scratch.CURVED] = 0.0


@inline
def _between_nearest(way: Any, axis_a: Any, axis_b: Any, half_a: float, half_b: float) -> Any:
    """Return d and the place s on the core of A; way: w, see the module."""
    along_a, along_b, cosine = dot(way, axis_a), dot(way, axis_b), dot(axis_a, axis_b)
    sine = 1.0 - cosine * cosine
    crosses = sine > NO_NEAREST_POINT
    on_a = (along_a - cosine * along_b) / (sine if crosses else 1.0)
    on_a = wide_lanes.clamp(on_a if crosses else along_a, half_a)
    wanted = cosine * on_a - along_b
    on_b = wide_lanes.clamp(wanted, half_b)
    on_a = on_a if on_b == wanted else wide_lanes.clamp(along_a + cosine * on_b, half_a)
    return subtract(add_scaled(way, on_b, axis_b), scale(on_a, axis_a)), on_a


@inline
def _moved_cores(cores: Array, scratch: Array, lane: int) -> Any:
    """
    Return middle and axis of both cores after the motion, the way from the centre of mass of A to
    that of B, and how far a point of the core of B has moved from one of A.
    """
    turn_a = wide_lanes.vector(scratch, lane + lane_scratch.TURN_A)
    turn_b = wide_lanes.vector(scratch, lane + lane_scratch.TURN_B)
    scalar_a = scratch[lane + lane_scratch.TURN_SCALAR_A]
    scalar_b = scratch[lane + lane_scratch.TURN_SCALAR_B]
    middle_a = wide_lanes.vector(cores, lane + core_pair.MIDDLE_A)
    middle_b = wide_lanes.vector(cores, lane + core_pair.MIDDLE_B)
    axis_a = wide_lanes.vector(cores, lane + core_pair.AXIS_A)
    axis_b = wide_lanes.vector(cores, lane + core_pair.AXIS_B)
    motion = subtract(
        wide_lanes.vector(scratch, lane + lane_scratch.DISPLACEMENT_B),
        wide_lanes.vector(scratch, lane + lane_scratch.DISPLACEMENT_A),
    )
    moved_a = wide_lanes.displacement_by_turn(turn_a, scalar_a, middle_a)
    moved_b = wide_lanes.displacement_by_turn(turn_b, scalar_b, middle_b)
    middle_a, middle_b = add(middle_a, moved_a), add(middle_b, moved_b)
    axis_a = add(axis_a, wide_lanes.displacement_by_turn(turn_a, scalar_a, axis_a))
    axis_b = add(axis_b, wide_lanes.displacement_by_turn(turn_b, scalar_b, axis_b))
    offset = add(wide_lanes.vector(cores, lane + core_pair.OFFSET), motion)
    apart = add(motion, subtract(moved_b, moved_a))
    return (middle_a, axis_a), (middle_b, axis_b), offset, apart


@kernel
def update_cores(
    lanes: int, constraints: Array, points: Array, cores: Array, scratch: Array
) -> None:
    """
    Do what `separation.update_kernel` does where two layers about cores meet at one point.
    """
    for lane in range(lanes):
        (middle_a, axis_a), (middle_b, axis_b), offset, apart = _moved_cores(cores, scratch, lane)
        line, on_a = _between_nearest(
            add(offset, subtract(middle_b, middle_a)), axis_a, axis_b,
            cores[lane + core_pair.HALF_A], cores[lane + core_pair.HALF_B],
        )  # fmt: skip
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        square = dot(line, line)
        has_cores = cores[lane + core_pair.TURNS] > 0.0
        is_apart = square > manifold.TINY
        turns = has_cores & is_apart & (dot(line, normal) > 0.0)
        length = math.sqrt(square if is_apart else 1.0)
        fixed_a = not wide_lanes.gives_way_a(constraints, lane)
        fixed_b = not wide_lanes.gives_way_b(constraints, lane)
        has_hit = (not turns) | (points[lane + contact_point.LARGEST_NORMAL_IMPULSE] > 0.0)
        stays = (
            (fixed_a | fixed_b)
            & (constraints[lane + constraint.RESTITUTION] > 0.0)
            & (points[lane + contact_point.APPROACH_VELOCITY] < 0.0)
            & has_hit
        )
        follows = turns & (not stays)
        new_normal = (
            line[0] / length if follows else normal[0],
            line[1] / length if follows else normal[1],
            line[2] / length if follows else normal[2],
        )
        opening = length - cores[lane + core_pair.DISTANCE] if turns else dot(normal, apart)
        radius_a = constraints[lane + constraint.RADIUS_A]
        radius_b = constraints[lane + constraint.RADIUS_B]
        # on the surface of the one that gives way, or midway
        share = 0.5 * ((0.0 if fixed_b else 1.0) + (1.0 if fixed_a else 0.0))
        reach = radius_a + share * (length - (radius_a + radius_b))
        of_core = add_scaled(middle_a, on_a, axis_a)
        weight = constraints[lane + constraint.SURFACE_WEIGHT]
        arm_a, arm_b = wide_lanes.arms(points, lane)
        new_arm_a = _chosen(
            has_cores,
            add_scaled(of_core, reach, new_normal),
            add(add_scaled(middle_a, radius_a, normal), scale(weight, apart)),
        )
        new_arm_b = _chosen(stays, arm_b, subtract(new_arm_a, offset))
        new_arm_a = _chosen(stays, arm_a, new_arm_a)
        points[lane + contact_point.SEPARATION] += opening
        cores[lane + core_pair.DISTANCE] = length
        wide_lanes.put_vector(cores, lane + core_pair.OFFSET, offset)
        wide_lanes.put_vector(
            cores, lane + core_pair.MIDDLE_A,
            _chosen(has_cores, middle_a, add_scaled(new_arm_a, -radius_a, normal)),
        )  # fmt: skip
        wide_lanes.put_vector(
            cores, lane + core_pair.MIDDLE_B,
            _chosen(has_cores, middle_b, add_scaled(new_arm_b, radius_b, normal)),
        )  # fmt: skip
        wide_lanes.put_vector(cores, lane + core_pair.AXIS_A, axis_a)
        wide_lanes.put_vector(cores, lane + core_pair.AXIS_B, axis_b)
        frame = separation.turned_frame((normal, tangent_1, tangent_2), new_normal)
        separation.turn_total(points, lane, (normal, tangent_1, tangent_2), frame)
        wide_lanes.put_vector(constraints, lane + constraint.NORMAL, frame[0])
        wide_lanes.put_vector(constraints, lane + constraint.TANGENT_1, frame[1])
        wide_lanes.put_vector(constraints, lane + constraint.TANGENT_2, frame[2])
        separation.apply_second_half(points, scratch, lane, frame, new_arm_a, new_arm_b)


@inline
def _chosen(condition: bool, one: Any, other: Any) -> Any:
    """Return one vector or the other, number by number, so that lanes stay side by side."""
    return (
        one[0] if condition else other[0],
        one[1] if condition else other[1],
        one[2] if condition else other[2],
    )
