# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From manifolds to contact constraints: materials and softness, what is round of a pair and whose
surface its points follow, tangents, arms and separations.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider,
    collider_record,
    manifold_record,
    pose,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.collision.face_normal import is_face_normal
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.shape_parameters import RADIUS
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    curved_cores,
    face_spring,
    far_points,
    friction_patch,
    pressure_of_face,
    surface_chain,
    surface_friction,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.softness import DEEP, Softness, soften
from rigid_body_sim.physics.contact.solver_bodies import (
    ABOUT_AXIS,
    AS_IT_IS,
    CENTRED_BALL,
    FIXED,
)
from rigid_body_sim.physics.model.material import material_of_pair, store_material
from rigid_body_sim.physics.state.blocks import LANES, RX, TRANSLATION, at
from rigid_body_sim.physics.vectors import add_scaled, cross, dot, load, load_strided, subtract

HALF_WEIGHT = 1e-6  # [m] apart from the nearest point of a manifold: it counts half at first

AT_END = 0.97  # [-] cosine of normal and axis of a cylinder above which an edge is at its end

WITHIN = 1.0 - 1e-6  # [-] of the radius of a cylinder: what is nearer to the axis is no rim

STEEP = 0.7  # [-] of a component z of the normal: the first tangent lies across x below, z above


@inline
def _symmetry(body: int, bodies: Array) -> float:
    """Tell how a body turns (`solver_bodies.SYMMETRY`); FIXED: it cannot move."""
    return bodies[body * solver_bodies.SIZE + solver_bodies.SYMMETRY] if body >= 0 else FIXED


@inline
def _is_driven(body: int, row: int, bodies: Array) -> bool:
    """Tell whether a body is moved as told; row: where its row of `solver_bodies` begins."""
    return body < 0 and bodies[row + solver_bodies.INVERSE_MASS] > 0.0


@inline
def _type(number: int, table: Indices) -> int:
    """Type of the shape of a collider."""
    return table[number * collider_record.SIZE + collider_record.TYPE]


@inline
def _may_roll(type_a: int, type_b: int) -> bool:
    """Tell whether a pair is a cylinder and what has flat sides, on which its rim may roll."""
    if type_a == collider.CYLINDER:
        return type_b >= collider.HULL or type_b == collider.CYLINDER
    return type_a == collider.BOX and type_b == collider.CYLINDER


@inline
def _end_meets(number: int, record: int, colliders: ColliderArrays, manifolds: Array) -> bool:
    """Tell whether the normal of a manifold is about that of an end of a cylinder."""
    axis = pose.axis(colliders.poses, number * pose.SIZE, 2)
    return abs(dot(axis, load(manifolds, record + manifold_record.NORMAL))) >= AT_END


@inline
def _rolls(
    cylinder: int, other: int, whose: float, record: int, colliders: ColliderArrays,
    manifolds: Array, bodies: Array,
) -> bool:  # fmt: skip
    """
    Tell whether the points of a manifold go round with the rims of a cylinder: they are the lowest
    ones over a side (`manifold.RIM`), or an edge or corner is at the mantle or a rim. What is at
    an end stays in it. On another cylinder they do so on its ends.

    other  : the other collider;   whose : SHAPE_A or SHAPE_B, which of the two the cylinder is
    record : where the manifold begins
    """
    table = colliders.table
    if _type(cylinder, table) != collider.CYLINDER:
        return False
    body = table[cylinder * collider_record.SIZE + collider_record.BODY]
    if _symmetry(body, bodies) != ABOUT_AXIS:
        return False
    if manifolds[record + manifold_record.RIM] != manifold.NEITHER:
        return manifolds[record + manifold_record.RIM] == whose
    if _type(other, table) == collider.CYLINDER and not _end_meets(
        other, record, colliders, manifolds
    ):
        return False
    return not _end_meets(cylinder, record, colliders, manifolds)


@inline
def _whose_rim(
    a: int, b: int, record: int, colliders: ColliderArrays, manifolds: Array, bodies: Array
) -> float:
    """Tell whose rim rolls in a manifold of a cylinder, if one does."""
    if _rolls(a, b, manifold.SHAPE_A, record, colliders, manifolds, bodies):
        return constraint.RIM_OF_A
    if _rolls(b, a, manifold.SHAPE_B, record, colliders, manifolds, bodies):
        return constraint.RIM_OF_B
    return constraint.NOT_ROUND


@inline
def roundness(collider_a: int, collider_b: int, table: Indices, bodies: Array) -> float:
    """
    Tell what is round of a pair: two balls, a ball beside what cannot move, or nothing
    (`constraint.ROUNDNESS`); of rims manifolds tell, see `_whose_rim`.
    """
    body_a = table[collider_a * collider_record.SIZE + collider_record.BODY]
    body_b = table[collider_b * collider_record.SIZE + collider_record.BODY]
    type_a, type_b = _type(collider_a, table), _type(collider_b, table)
    if _may_roll(type_a, type_b):
        return constraint.NOT_ROUND
    row_a = collider_record.solver_body(collider_a, table) * solver_bodies.SIZE
    row_b = collider_record.solver_body(collider_b, table) * solver_bodies.SIZE
    if _is_driven(body_a, row_a, bodies) or _is_driven(body_b, row_b, bodies):
        return constraint.NOT_ROUND  # driven: what is round of the pair turns under it
    symmetry_a, symmetry_b = _symmetry(body_a, bodies), _symmetry(body_b, bodies)
    ball_a, ball_b = symmetry_a == CENTRED_BALL, symmetry_b == CENTRED_BALL
    fixed_a = body_a < 0 and type_a == collider.SPHERE
    fixed_b = body_b < 0 and type_b == collider.SPHERE
    if (ball_a and (ball_b or fixed_b)) or (ball_b and fixed_a):
        return constraint.TWO_BALLS
    if (ball_a and body_b < 0) or (ball_b and body_a < 0):
        return constraint.BALL_ON_FIXED
    return constraint.NOT_ROUND


@inline
def are_curved(collider_a: int, collider_b: int, table: Indices, bodies: Array) -> bool:
    """
    Tell whether a pair is one of two layers about cores (`curved_cores`), and none of two balls
    that turn about their centres.

    What is driven keeps its normal here: `prescribed_bodies` turns it.
    """
    row_a, row_b = collider_a * collider_record.SIZE, collider_b * collider_record.SIZE
    if not (
        curved_cores.has_core(table[row_a + collider_record.TYPE])
        and curved_cores.has_core(table[row_b + collider_record.TYPE])
    ):
        return False
    solver_a = collider_record.solver_body(collider_a, table) * solver_bodies.SIZE
    solver_b = collider_record.solver_body(collider_b, table) * solver_bodies.SIZE
    return not (
        _is_driven(table[row_a + collider_record.BODY], solver_a, bodies)
        or _is_driven(table[row_b + collider_record.BODY], solver_b, bodies)
        or roundness(collider_a, collider_b, table, bodies) == constraint.TWO_BALLS
    )


@inline
def _symmetry_of_surface(collider: int, table: Indices, bodies: Array) -> float:
    """Tell how the surface of a collider turns: also of what is round and moved as told."""
    body = table[collider * collider_record.SIZE + collider_record.BODY]
    row = collider_record.solver_body(collider, table) * solver_bodies.SIZE
    if _is_driven(body, row, bodies) and bodies[row + solver_bodies.SYMMETRY] > AS_IT_IS:
        return float(bodies[row + solver_bodies.SYMMETRY])
    return _symmetry(body, bodies)


@inline
def _weight_of(symmetry_a: float, symmetry_b: float) -> float:
    """Return the weight of two surfaces: points follow that of the rounder one."""
    if symmetry_a == symmetry_b:
        return 0.5
    return 0.0 if symmetry_a > symmetry_b else 1.0


@inline
def surface_weight(collider_a: int, collider_b: int, table: Indices, bodies: Array) -> float:
    """
    Tell whose surface the points follow: that of the body that moves, of the rounder one, else of
    both.
    """
    return _weight_of(
        _symmetry_of_surface(collider_a, table, bodies),
        _symmetry_of_surface(collider_b, table, bodies),
    )


@inline
def _lies_on_end(
    cylinder: int, load_on_it: int, record: int, colliders: ColliderArrays, manifolds: Array
) -> bool:  # fmt: skip
    """
    Tell whether all points of a manifold are those of another body that moves and lies on an end
    of a cylinder, within its rim: they go round with that body, where those of the rim stay.
    """
    table = colliders.table
    row, place = cylinder * collider_record.SIZE, cylinder * pose.SIZE
    if (
        table[row + collider_record.TYPE] != collider.CYLINDER
        or table[load_on_it * collider_record.SIZE + collider_record.BODY] < 0
    ):
        return False
    axis = pose.axis(colliders.poses, place, 2)
    if abs(dot(axis, load(manifolds, record + manifold_record.NORMAL))) < AT_END:
        return False
    rim = WITHIN * colliders.parameters[table[row + collider_record.PARAMETERS] + RADIUS]
    middle = load(colliders.poses, place + pose.POSITION)
    for point in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        found = record + manifold_record.POINTS + point * manifold.POINT
        away = cross(axis, subtract(load(manifolds, found), middle))
        if dot(away, away) > rim * rim:
            return False
    return True


@inline
def _weight_beside_ends(
    a: int, b: int, record: int, colliders: ColliderArrays, manifolds: Array, bodies: Array
) -> float:
    """Tell the same as `surface_weight` of a manifold that the end of a cylinder may have."""
    symmetry_a = _symmetry_of_surface(a, colliders.table, bodies)
    symmetry_b = _symmetry_of_surface(b, colliders.table, bodies)
    if _lies_on_end(a, b, record, colliders, manifolds):
        symmetry_a = FIXED
    elif _lies_on_end(b, a, record, colliders, manifolds):
        symmetry_b = FIXED
    return _weight_of(symmetry_a, symmetry_b)


@inline
def layer(number: int, bounds: Array) -> float:
    """Radius of the layer of a collider about its core; a plane has none."""
    thick = bounds[number * bounds_record.SIZE + bounds_record.ROUNDING]
    return thick if thick < math.inf else 0.0


@inline
def faces(a: int, b: int, normal: Any, colliders: ColliderArrays) -> float:
    """Tell whose face the normal of a pair of colliders belongs to (`constraint.FACES`)."""
    of_a = constraint.FACE_OF_A if is_face_normal(a, normal, colliders) else constraint.NO_FACE
    of_b = constraint.FACE_OF_B if is_face_normal(b, normal, colliders) else constraint.NO_FACE
    return of_a + of_b


@kernel
def prepare_materials(
    softness: Softness, curved: bool, table: Indices, bounds: Array, materials: Array,
    of_pairs: Array, order: Indices, manifolds: Array, rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Write material and softness of the manifolds of a group, and whose surface their points follow.

    curved   : whether layers about cores may meet: see `curved_cores`
    of_pairs : pairs with a material of their own, see `model.material`
    order    : these manifolds
    """
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        lane = int(manifolds[record + manifold_record.LANE])
        a = int(manifolds[record + manifold_record.COLLIDER_A])
        b = int(manifolds[record + manifold_record.COLLIDER_B])
        given = material_of_pair(a, b, materials, of_pairs)
        store_material(rows, lane + constraint.MATERIAL, constraint.LANES, given)
        rows[lane + constraint.SURFACE_WEIGHT] = surface_weight(a, b, table, bodies)
        what = roundness(a, b, table, bodies)
        if curved and what == constraint.NOT_ROUND and are_curved(a, b, table, bodies):
            what = constraint.CURVED
        rows[lane + constraint.ROUNDNESS] = what
        rows[lane + constraint.RADIUS_A] = layer(a, bounds)
        rows[lane + constraint.RADIUS_B] = layer(b, bounds)
        fixed = (
            table[a * collider_record.SIZE + collider_record.BODY] < 0
            or table[b * collider_record.SIZE + collider_record.BODY] < 0
        )
        soften(lane, softness, fixed, 1.0, rows)
        rows[lane + constraint.DEEP] = DEEP * bounds_record.smaller_radius(bounds, a, b)


@inline
def _first_tangent(normal: Any) -> Any:
    """First vector of a tangent basis: across x or z, whichever is farther from the normal."""
    flat = abs(normal[2]) < STEEP
    other = normal[0] if flat else normal[2]
    square = normal[1] * normal[1] + other * other
    length = math.sqrt(square if square > 0.0 else 1.0)
    along, across = normal[1] / length, other / length
    return along if flat else 0.0, -across if flat else across, 0.0 if flat else -along


@inline
def _center(
    number: int, core: int, table: Indices, translation: Array, poses: Array, bodies: Array
) -> Any:  # fmt: skip
    """
    Centre of mass of the body of a collider; of what is moved as told the point that its row tells
    of; of what cannot move the origin of its shape.
    """
    if core < 0:
        row = collider_record.solver_body(number, table) * solver_bodies.SIZE
        if _is_driven(core, row, bodies):
            return load(bodies, row + solver_bodies.START_POSITION)
        return load(poses, number * pose.SIZE)
    return load_strided(translation, at(core, TRANSLATION) + RX, LANES)


@inline
def _weigh_nearest(
    point_count: int, record: int, face: int, manifolds: Array, rows: Array
) -> None:  # fmt: skip
    """
    Weigh the points of a manifold in the centre of its friction, until it is known what presses:
    those that are nearest alike, the others by 1/(1 + (s/HALF_WEIGHT)^2), s how much farther.

    The arm of friction ends where the surfaces touch. Halfway to a point that is still apart it
    would tip what lands on an edge or a rim, by an impulse of first order in h.
    """
    first = record + manifold_record.POINTS + manifold.SEPARATION
    nearest = math.inf
    for point in range(point_count):
        nearest = min(nearest, manifolds[first + point * manifold.POINT])
    total = 0.0
    weights = face + friction_patch.WEIGHTS
    for point in range(manifold.MOST):
        weight = 0.0
        if point < point_count:
            farther = (manifolds[first + point * manifold.POINT] - nearest) / HALF_WEIGHT
            weight = 1.0 / (1.0 + farther * farther)
        rows[weights + point * constraint.LANES] = weight
        total += weight
    for point in range(point_count):
        rows[weights + point * constraint.LANES] /= total


@inline
def _prepare_face(
    record: int, lane: int, width: int, tangents: Any, manifolds: Array, rows: Array
) -> None:
    """
    Write how the points of a manifold share its face: see `patch_friction`, `face_spring`.

    tangents : two
    """
    count = int(manifolds[record + manifold_record.POINT_COUNT])
    first = lane + constraint.SIZE
    face = first + manifold.MOST * width
    _weigh_nearest(count, record, face, manifolds, rows)
    is_measured = count > 2 and manifolds[record + manifold_record.FACE_AREA] > 0.0
    if is_measured:
        parts = pressure_of_face.weights(record, tangents, manifolds)
        uniform = pressure_of_face.uniform_share(record, parts, tangents, manifolds)
    else:
        parts = 0.0, 0.0, 0.0, 0.0
        uniform = pressure_of_face.share_of_unmeasured(count)
    rows[face + friction_patch.UNIFORM] = uniform
    for point in range(count):
        share = max(count * parts[point], face_spring.LEAST) if is_measured else 1.0
        rows[first + point * width + contact_point.SPRING_SHARE] = share


@kernel
def prepare_points(
    width: int, curved: bool, order: Indices, translation: Array, colliders: ColliderArrays,
    manifolds: Array, rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Write normals, tangents, arms and separations of the manifolds of a group.

    width  : numbers of a point
    curved : whether layers about cores may meet: see `curved_cores`
    order  : these manifolds, as they lie in the rows
    """
    table, poses = colliders.table, colliders.poses
    for index in range(len(order)):
        m = order[index]
        record = m * manifold_record.SIZE
        lane = int(manifolds[record + manifold_record.LANE])
        normal = load(manifolds, record + manifold_record.NORMAL)
        tangent = _first_tangent(normal)
        wide_lanes.put_vector(rows, lane + constraint.NORMAL, normal)
        wide_lanes.put_vector(rows, lane + constraint.TANGENT_1, tangent)
        wide_lanes.put_vector(rows, lane + constraint.TANGENT_2, cross(normal, tangent))
        rows[lane + constraint.TOUCHED] = 0.0
        rows[lane + constraint.WAITS] = 0.0
        rows[lane + constraint.LEFT_SUBSTEPS] = 0.0
        surface_chain.leave_alone(lane, rows)
        a = int(manifolds[record + manifold_record.COLLIDER_A])
        b = int(manifolds[record + manifold_record.COLLIDER_B])
        core_a = table[a * collider_record.SIZE + collider_record.BODY]
        core_b = table[b * collider_record.SIZE + collider_record.BODY]
        center_a = _center(a, core_a, table, translation, poses, bodies)
        center_b = _center(b, core_b, table, translation, poses, bodies)
        # on the surface of the body that moves: the point midway serves the balance of angular
        # momentum, which what cannot move does not keep
        shift = -0.5 if core_b < 0 else (0.5 if core_a < 0 else 0.0)
        if width > contact_point.SIZE:
            rows[lane + constraint.FACES] = faces(a, b, normal, colliders)
        if _may_roll(_type(a, table), _type(b, table)):
            whose = _whose_rim(a, b, record, colliders, manifolds, bodies)
            if curved and whose == constraint.NOT_ROUND and are_curved(a, b, table, bodies):
                whose = constraint.CURVED
            rows[lane + constraint.ROUNDNESS] = whose
        if _type(a, table) == collider.CYLINDER or _type(b, table) == collider.CYLINDER:
            rows[lane + constraint.SURFACE_WEIGHT] = _weight_beside_ends(
                a, b, record, colliders, manifolds, bodies
            )
        point_count = int(manifolds[record + manifold_record.POINT_COUNT])
        if point_count > 1:
            far_points.put_behind(
                record, bounds_record.smaller_radius(colliders.local_bounds, a, b), manifolds
            )
            surface_friction.leave_alone(lane, width, rows)
            _prepare_face(record, lane, width, (tangent, cross(normal, tangent)), manifolds, rows)
        for point in range(point_count):
            found = record + manifold_record.POINTS + point * manifold.POINT
            row = lane + constraint.SIZE + point * width
            separation = manifolds[found + manifold.SEPARATION]
            place = add_scaled(load(manifolds, found), shift * separation, normal)
            wide_lanes.put_vector(rows, row + contact_point.ARM_A, subtract(place, center_a))
            wide_lanes.put_vector(rows, row + contact_point.ARM_B, subtract(place, center_b))
            rows[row + contact_point.INITIAL_SEPARATION] = separation
            if point_count == 1:
                rows[row + contact_point.SPRING_SHARE] = 1.0
            if width > contact_point.SIZE:
                rows[row + contact_point.RESTITUTION_NORMAL] = 0.0
                rows[row + contact_point.RESTITUTION_TANGENT_1] = 0.0
                rows[row + contact_point.RESTITUTION_TANGENT_2] = 0.0
        if curved and point_count == 1 and are_curved(a, b, table, bodies):
            curved_cores.prepare_cores(a, b, lane, width, center_a, center_b, colliders, rows)
