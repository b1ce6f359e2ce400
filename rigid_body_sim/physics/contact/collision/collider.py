# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What collides, as arrays: one collider for each solid of each body (`solids`), in scene order.

A fixed body is a static collider. A point mass collides as a sphere of radius zero, but never with
another point. A mesh collides as its convex hull, a surface as its triangles. Bodies without a
shape and particles that make a rigid body do not collide.

    shape_parameters : of all shapes, one after the other, see `shape_parameters`; equal hulls
                       share one record; a cylinder has the prism record of `hull_records` behind
                       its two numbers only where a pair needs it
    table            : collider table, see `collider_record`
    local_bounds     : local AABB and bounding ball of each, see `bounds_record`
    local_poses      : where each sits in its body, see `pose`; point masses and static colliders
                       have M = 1
    poses            : where each stands, see `pose`; here those at the start
    materials        : of each, see `model.material`
Lengths in metres.

Kernels get these arrays as `ColliderArrays`, and those of the broad phase as `BroadPhase`: groups
that are made inside the kernel that Python calls, where they cost nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    pose,
)
from rigid_body_sim.physics.contact.collision.aabb import extent
from rigid_body_sim.physics.contact.collision.solids import solids
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.material import MATERIAL
from rigid_body_sim.physics.model.plain_products import dot, product, times
from rigid_body_sim.physics.model.plain_products import length as length_of
from rigid_body_sim.physics.model.scene import Body, Scene, Vector
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Particle,
    Plane,
    Sphere,
    Surface,
)
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.physics.vectors import add, load

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SPHERE, CAPSULE, BOX, CYLINDER, HULL, PLANE, SURFACE = range(7)
NAMES = ('sphere', 'capsule', 'box', 'cylinder', 'hull', 'plane', 'surface')

NO_COLLIDER = -1  # type of a body that does not collide

_BY_PRISM = (CAPSULE, BOX, HULL, SURFACE)  # types that meet a cylinder as a prism


class ColliderArrays(NamedTuple):
    """
    The colliders of a scene, as kernels take them; one-dimensional, see the module.

    swept_aabbs : what each may reach within a tick, see `swept_aabbs`
    """

    parameters: Array
    table: Indices
    local_bounds: Array
    poses: Array
    swept_aabbs: Array


class BroadPhase(NamedTuple):
    """
    What the broad phase keeps from tick to tick, and what it works with; one-dimensional.

    fat_aabbs, neighbours : see `neighbour_list`
    grid, hash_heads      : see `hash_grid`
    pair_ids              : written: the pairs that may meet, see `neighbour_list.find_pairs`
    """

    fat_aabbs: Array
    grid: Indices
    hash_heads: Indices
    neighbours: Indices
    pair_ids: Indices


@dataclass(frozen=True, eq=False)
class Colliders:
    """
    All colliders of a scene.

    shape_parameters, local_bounds, local_poses, poses, table, materials : one-dimensional, see the
                                                                           module
    parts : of each its body with its shape alone
    """

    shape_parameters: Array
    table: Indices
    local_bounds: Array
    local_poses: Array
    poses: Array
    materials: Array
    parts: tuple[Body, ...]

    @classmethod
    def of(cls, scene: Scene, layout: Layout) -> Colliders:
        """Find the colliders of a scene; InvalidModel for a hull that spans no solid."""
        found = [
            (index, solid, type_of(solid))
            for index, body in enumerate(scene.bodies)
            for solid in solids(body)
            if type_of(solid) != NO_COLLIDER
        ]
        prisms = _needs_prisms([kind for _, _, kind in found])
        moving = {int(index): i for i, index in enumerate(layout.moving)}
        to_principal = layout.to_body_axes(np.broadcast_to(np.eye(3), (layout.n_rigid, 3, 3)))
        parameters: list[float] = []
        known: dict[bytes, int] = {}
        hulls: dict[Any, Array] = {}
        table, bounds, local_poses, poses, materials = [], [], [], [], []
        for index, body, kind in found:
            try:
                of_shape = _parameters(body, prisms, hulls)
            except InvalidModel as error:
                raise InvalidModel(
                    f'{body.name!r} cannot collide: {error}', at=('bodies', index, 'shape')
                ) from error
            begin = known.setdefault(of_shape.tobytes(), len(parameters))
            if begin == len(parameters):
                parameters.extend(of_shape.tolist())
            place = moving.get(index, collider_record.STATIC)
            table.append((kind, begin, place, index, 0, layout.n_moving))
            bounds.append(_bounds(body))
            turn = np.eye(3)
            if 0 <= place < layout.n_rigid:
                turn = product(to_principal[place], _shape_axes(body))
            reference = body.center_of_mass if body.pivot is None else body.pivot.point
            local_poses.append((*_in_shape(body, reference), *turn.ravel()))
            poses.append(_pose(body))
            materials.append([getattr(body.material, key) for key in MATERIAL])
        return cls(
            shape_parameters=np.array(parameters, dtype=np.float64),
            table=np.array(table, dtype=np.int64).ravel(),
            local_bounds=np.array(bounds, dtype=np.float64).ravel(),
            local_poses=np.array(local_poses, dtype=np.float64).ravel(),
            poses=np.array(poses, dtype=np.float64).ravel(),
            materials=np.array(materials, dtype=np.float64).ravel(),
            parts=tuple(body for _, body, _ in found),
        )

    def __len__(self) -> int:
        return len(self.table) // collider_record.SIZE

    @property
    def types(self) -> Indices:
        """Type of each collider (n,)."""
        return self.table[collider_record.TYPE :: collider_record.SIZE]

    @property
    def bodies(self) -> Indices:
        """Index of the body of each collider among those that move (n,); -1: static."""
        return self.table[collider_record.BODY :: collider_record.SIZE]

    @property
    def radius(self) -> Array:
        """Radius of the ball about the bounding centre that holds each collider (n,) [m]."""
        return self.local_bounds[bounds_record.RADIUS :: bounds_record.SIZE]

    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Give the pairs of types (a <= b) that may meet in this scene, in order."""
        kinds = len(NAMES)
        of_all = np.bincount(self.types, minlength=kinds)
        moves = self.bodies >= 0
        count = int(np.max(self.bodies, initial=collider_record.STATIC)) + 1
        of_body = np.zeros((count, kinds), dtype=np.int64)
        np.add.at(of_body, (self.bodies[moves], self.types[moves]), 1)
        # some body has a of its own, and b is found among the others
        meets = (of_body > 0).T.astype(np.int64) @ (of_all - of_body > 0) > 0
        return tuple(
            (a, b) for a in range(kinds) for b in range(a, kinds) if meets[a, b] or meets[b, a]
        )


def type_of(body: Body) -> int:
    """Tell as what a body collides; NO_COLLIDER: not at all."""
    match body.shape:
        case Sphere() | Particle():
            return SPHERE
        case Capsule():
            return CAPSULE
        case Box():
            return BOX
        case Cylinder():
            return CYLINDER
        case ConvexHull() | Mesh():
            return HULL
        case Plane():
            return PLANE
        case Surface():
            return SURFACE
        case _:
            return NO_COLLIDER


def _needs_prisms(types: list[int]) -> bool:
    """Tell whether some cylinder may meet a shape other than a ball or a plane."""
    return types.count(CYLINDER) > 1 or (
        CYLINDER in types and any(kind in _BY_PRISM for kind in types)
    )


def _parameters(body: Body, prisms: bool, hulls: dict[Any, Array]) -> Array:
    """
    Give the parameters of a shape, see `shape_parameters`.

    hulls : those that were found already: a hull of a hundred equal tiles is found once
    """
    match body.shape:
        case Sphere(radius=radius):
            return np.array([radius])
        case Capsule(radius=radius, length=length):
            return np.array([radius, 0.5 * length])
        case Box(size=size):
            return 0.5 * np.array(size)
        case Cylinder(radius=radius, length=length) as shape:
            return np.concatenate(
                ([radius, 0.5 * length], _record(shape, hulls) if prisms else [])
            )
        case ConvexHull() | Mesh() as shape:
            return _record(shape, hulls)
        case Plane(normal=normal, offset=offset):
            placed = _pose(body)
            turned = times(placed[pose.ROW_X :].reshape(3, 3), normal)
            return np.array([*turned, offset + dot(turned, placed[: pose.ROW_X])])
        case Surface() as shape:
            return _surface_record(body, shape)
        case _:
            return np.zeros(1)


def _record(shape: Any, hulls: dict[Any, Array]) -> Array:
    # Qhull takes a quarter of a second to import: only for the scenes that have a hull.
    from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import record

    match shape:
        case ConvexHull(vertices=vertices):
            which: Any = vertices.tobytes()
        case Cylinder(radius=radius, length=length):
            which = radius, length
        case _:
            which = id(shape)
    if which not in hulls:
        hulls[which] = record(shape)
    return hulls[which]


def _surface_record(body: Body, shape: Surface) -> Array:
    # scipy's graphs take a tenth of a second to import: only for the scenes that have ground.
    from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import record

    placed = _pose(body)
    turned = shape.vertices @ placed[pose.ROW_X :].reshape(3, 3).T
    return record(turned + placed[: pose.ROW_X], shape.faces, name=shape.name)


def _bounds(body: Body) -> tuple[float, ...]:
    low, high, rounding = np.zeros(3), np.zeros(3), 0.0
    match body.shape:
        case Sphere(radius=radius):
            rounding = radius
        case Capsule(radius=radius, length=length):
            high, rounding = np.array([0.0, 0.0, 0.5 * length]), radius
            low = -high
        case Box(size=size):
            high = 0.5 * np.array(size)
            low = -high
        case Cylinder(radius=radius, length=length):
            high = np.array([radius, radius, 0.5 * length])
            low = -high
        case ConvexHull(vertices=vertices) | Mesh(vertices=vertices) | Surface(vertices=vertices):
            low, high = np.min(vertices, axis=0), np.max(vertices, axis=0)
        case Plane():
            rounding = np.inf
    center, half = low + 0.5 * (high - low), 0.5 * (high - low)
    radius = float(np.sqrt(np.sum(half * half))) + rounding
    match body.shape:
        case Cylinder(radius=of_side, length=length):
            radius = float(length_of((of_side, 0.5 * length)))
        case ConvexHull(vertices=vertices) | Mesh(vertices=vertices) | Surface(vertices=vertices):
            radius = float(np.sqrt(np.max(np.sum((vertices - center) ** 2, axis=1))))
    return (*center.tolist(), *half.tolist(), rounding, radius)


def _pose(body: Body) -> Array:
    turn = product(so3.matrix_from_quaternion(body.initial.orientation), _shape_axes(body))
    origin = np.asarray(body.initial.position) - times(turn, _in_shape(body, body.center_of_mass))
    return np.concatenate((origin, turn.ravel()))


def _shape_axes(body: Body) -> Array:
    """Rotation from shape axes to body axes."""
    return so3.matrix_from_quaternion(body.shape_orientation)


def _in_shape(body: Body, point: Vector) -> Array:
    """Return a point of a body as seen from the origin of the shape, shape axes [m]."""
    return times(_shape_axes(body).T, np.subtract(point, body.shape_position))


@inline
def world_aabb(local_bounds: Array, collider: int, poses: Array) -> Any:
    """
    Return the AABB of a collider in the world: its middle and its half edges, two vectors [m].

    c = x + R m,  e_i = min(sum_k |R_ik| h_k + d, radius)
        m, h, d, radius : middle, half edges, rounding and bounding ball of its local bounds
    """
    bounds, place = collider * bounds_record.SIZE, collider * pose.SIZE
    center = add(
        load(poses, place + pose.POSITION),
        pose.to_world(poses, place, load(local_bounds, bounds + bounds_record.CENTER)),
    )
    half = load(local_bounds, bounds + bounds_record.HALF)
    layer = local_bounds[bounds + bounds_record.ROUNDING]
    radius = local_bounds[bounds + bounds_record.RADIUS]
    return center, (
        min(extent(half, load(poses, place + pose.ROW_X)) + layer, radius),
        min(extent(half, load(poses, place + pose.ROW_Y)) + layer, radius),
        min(extent(half, load(poses, place + pose.ROW_Z)) + layer, radius),
    )
