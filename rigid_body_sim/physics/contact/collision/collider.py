# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What collides, as arrays: one collider for each solid of each body (`compound`), in scene order.

A fixed body is a static collider. A point mass collides as a sphere of radius zero, but never with
another point. A mesh collides as its convex hull. Bodies without a shape and particles that make a
rigid body do not collide.

    numbers : sizes of all shapes, one after the other; equal hulls share one record
        SPHERE    radius
        CAPSULE   radius, half length; axis z
        BOX       half edges along x, y, z
        CYLINDER  radius, half length; axis z; then, only where a pair needs it, the prism record
                  of `hull_records`
        HULL      record of `hull_records`
        PLANE     unit normal out of the solid (3), distance from the world's origin; world axes
    table   : TABLE per collider: type, where its sizes begin, core index of its body (-1: static),
              scene index of its body
    bounds  : BOUNDS per collider, see `bounding_box`
    mounts  : POSE per collider: centre of mass seen from the origin of the shape, shape axes (3),
              then the rotation from shape axes to principal axes, row by row (9): how the pose of
              a shape follows from r and q of the core: R = R(q) M, x = r - R c; point masses and
              static colliders: M = 1
    poses   : POSE per collider: origin of the shape in the world (3), then R row by row (9), shape
              axes to world; here those at the start
Lengths in metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.solids import solids
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Particle,
    Plane,
    Sphere,
)
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SPHERE, CAPSULE, BOX, CYLINDER, HULL, PLANE = range(6)
NAMES = ('sphere', 'capsule', 'box', 'cylinder', 'hull', 'plane')

TABLE = 4  # numbers of a collider in `table`
TYPE, SIZES, CORE, SCENE = range(4)
POSE = 12  # numbers of a collider in `poses` and `mounts`
BOUNDS = 8  # numbers of a collider in `bounds`
MATERIAL = 4  # numbers of a collider in `materials`
RESTITUTION, FRICTION, ROLLING, TORSIONAL = range(4)

_BY_PRISM = (CAPSULE, BOX, HULL)  # types that meet a cylinder as a prism


@dataclass(frozen=True, eq=False)
class Colliders:
    """
    All colliders of a scene.

    numbers, bounds, mounts, poses, table : one-dimensional, see the module
    materials : one-dimensional, MATERIAL per collider: restitution and friction [-], rolling and
                torsional friction [m]
    """

    numbers: Array
    table: Indices
    bounds: Array
    mounts: Array
    poses: Array
    materials: Array

    @classmethod
    def of(cls, scene: Scene, layout: Layout) -> Colliders:
        """Find the colliders of a scene; InvalidModel for a hull that spans no solid."""
        found = [
            (index, solid, type_of(solid))
            for index, body in enumerate(scene.bodies)
            for solid in solids(body)
            if type_of(solid) >= 0
        ]
        prisms = _needs_prisms([kind for _, _, kind in found])
        core = {int(index): k for k, index in enumerate(layout.moving)}
        to_principal = layout.to_body_axes(np.broadcast_to(np.eye(3), (layout.n_rigid, 3, 3)))
        numbers: list[float] = []
        known: dict[bytes, int] = {}
        hulls: dict[int, Array] = {}
        table, bounds, mounts, poses, materials = [], [], [], [], []
        for index, body, kind in found:
            try:
                record = _sizes(body, prisms, hulls)
            except InvalidModel as error:
                raise InvalidModel(
                    f'{body.name!r} cannot collide: {error}', at=('bodies', index, 'shape')
                ) from error
            at = known.setdefault(record.tobytes(), len(numbers))
            if at == len(numbers):
                numbers.extend(record.tolist())
            place = core.get(index, -1)
            table.append((kind, at, place, index))
            bounds.append(_bounds(body, kind))
            turn = np.eye(3)
            if 0 <= place < layout.n_rigid:
                turn = to_principal[place] @ _shape_axes(body)
            mounts.append((*_center_in_shape(body), *turn.ravel()))
            poses.append(_pose(body))
            material = body.material
            materials.append(
                (
                    material.restitution,
                    material.friction,
                    material.rolling_friction,
                    material.torsional_friction,
                )
            )
        return cls(
            numbers=np.array(numbers, dtype=np.float64),
            table=np.array(table, dtype=np.int64).ravel(),
            bounds=np.array(bounds, dtype=np.float64).ravel(),
            mounts=np.array(mounts, dtype=np.float64).ravel(),
            poses=np.array(poses, dtype=np.float64).ravel(),
            materials=np.array(materials, dtype=np.float64).ravel(),
        )

    def __len__(self) -> int:
        return len(self.table) // TABLE

    @property
    def types(self) -> Indices:
        """Type of each collider (n,)."""
        return self.table[TYPE::TABLE]

    @property
    def cores(self) -> Indices:
        """Core index of the body of each collider (n,); -1: static."""
        return self.table[CORE::TABLE]

    @property
    def radius(self) -> Array:
        """Radius of the ball about the bounding centre that holds each collider (n,) [m]."""
        return self.bounds[7::BOUNDS]

    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Give the pairs of types (a <= b) that may meet in this scene, in order."""
        kinds = len(NAMES)
        all_of = np.bincount(self.types, minlength=kinds)
        moves = self.cores >= 0
        of_body = np.zeros((int(np.max(self.cores, initial=-1)) + 1, kinds), dtype=np.int64)
        np.add.at(of_body, (self.cores[moves], self.types[moves]), 1)
        # some body has a of its own, and b is found among the others
        meets = (of_body > 0).T.astype(np.int64) @ (all_of - of_body > 0) > 0
        return tuple(
            (a, b) for a in range(kinds) for b in range(a, kinds) if meets[a, b] or meets[b, a]
        )


def type_of(body: Body) -> int:
    """Tell as what a body collides; -1: not at all."""
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
        case _:
            return -1


def _needs_prisms(types: list[int]) -> bool:
    """Tell whether some cylinder may meet a shape other than a ball or a plane."""
    return types.count(CYLINDER) > 1 or (
        CYLINDER in types and any(kind in _BY_PRISM for kind in types)
    )


def _sizes(body: Body, prisms: bool, hulls: dict[int, Array]) -> Array:
    """
    Give the numbers of a shape.

    hulls : those that were found already, by the identity of the shape: copies of a body share it
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
            pose = _pose(body)
            turned = pose[3:].reshape(3, 3) @ np.asarray(normal)
            return np.array([*turned, offset + turned @ pose[:3]])
        case _:
            return np.zeros(1)


def _record(shape: Any, hulls: dict[int, Array]) -> Array:
    # Qhull takes a quarter of a second to import: only for the scenes that have a hull.
    from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import record

    if id(shape) not in hulls:
        hulls[id(shape)] = record(shape)
    return hulls[id(shape)]


def _bounds(body: Body, kind: int) -> tuple[float, ...]:
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
        case ConvexHull(vertices=vertices) | Mesh(vertices=vertices):
            low, high = np.min(vertices, axis=0), np.max(vertices, axis=0)
        case Plane():
            rounding = np.inf
    center, half = low + 0.5 * (high - low), 0.5 * (high - low)
    radius = float(np.sqrt(np.sum(half * half))) + rounding
    match body.shape:
        case Cylinder(radius=r, length=length):
            radius = float(np.hypot(r, 0.5 * length))
        case ConvexHull(vertices=vertices) | Mesh(vertices=vertices):
            radius = float(np.sqrt(np.max(np.sum((vertices - center) ** 2, axis=1))))
    return (*center.tolist(), *half.tolist(), rounding, radius)


def _pose(body: Body) -> Array:
    turn = so3.matrix_from_quaternion(body.initial.orientation) @ _shape_axes(body)
    origin = np.asarray(body.initial.position) - turn @ _center_in_shape(body)
    return np.concatenate((origin, turn.ravel()))


def _shape_axes(body: Body) -> Array:
    """Rotation from shape axes to body axes."""
    return so3.matrix_from_quaternion(body.shape_orientation)


def _center_in_shape(body: Body) -> Array:
    """Centre of mass seen from the origin of the shape, shape axes [m]."""
    return np.subtract(body.center_of_mass, body.shape_position) @ _shape_axes(body)


@inline
def bounding_box(bounds: Array, b: int, poses: Array, p: int) -> Any:
    """
    Return the box along the world axes that holds a collider: middle (3), half edges (3) [m].

    c = x + R m,  e_i = min(sum_k |R_ik| h_k + d, radius)
        bounds : BOUNDS per collider: middle m (3) and half edges h (3) of a box along the shape
                 axes, thickness d of the layer around it, radius of the ball about the middle;
                 plane: infinite
        b, p   : where the numbers of this collider begin in `bounds` and `poses`
    """
    mx, my, mz = bounds[b], bounds[b + 1], bounds[b + 2]
    hx, hy, hz = bounds[b + 3], bounds[b + 4], bounds[b + 5]
    layer, radius = bounds[b + 6], bounds[b + 7]
    xx, xy, xz = poses[p + 3], poses[p + 4], poses[p + 5]
    yx, yy, yz = poses[p + 6], poses[p + 7], poses[p + 8]
    zx, zy, zz = poses[p + 9], poses[p + 10], poses[p + 11]
    return (
        poses[p] + (xx * mx + xy * my + xz * mz),
        poses[p + 1] + (yx * mx + yy * my + yz * mz),
        poses[p + 2] + (zx * mx + zy * my + zz * mz),
        min(abs(xx) * hx + abs(xy) * hy + abs(xz) * hz + layer, radius),
        min(abs(yx) * hx + abs(yy) * hy + abs(yz) * hz + layer, radius),
        min(abs(zx) * hx + abs(zy) * hy + abs(zz) * hz + layer, radius),
    )
