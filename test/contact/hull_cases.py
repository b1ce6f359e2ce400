# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shapes that meet as polyhedra, placed at random, what the kernels find, and what coal finds."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    HULL,
    NAMES,
    SPHERE,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FOUND,
    HELD,
    HELD_COUNT,
    POINT,
    POINTS,
    SHIFT,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import packed
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hulls import Polyhedron
from rigid_body_sim.physics.contact.collision.pairs import collide_kernel
from rigid_body_sim.physics.model import rotation as so3

PAIRS = (
    (SPHERE, HULL),
    (CAPSULE, CYLINDER),
    (CAPSULE, HULL),
    (BOX, HULL),
    (CYLINDER, CYLINDER),
    (CYLINDER, HULL),
    (HULL, HULL),
)
SIZES = {8: 0.6, 4: 0.1, 12: 0.1, 32: 0.1, 90: 0.1}  # share of hulls by number of points


def name(pair):
    return '-'.join(NAMES[kind] for kind in pair)


@dataclass(eq=False)
class Shape:
    """A shape of a type: its sizes in `numbers`, and the polyhedron or the core it meets as."""

    kind: int
    sizes: np.ndarray
    solid: Polyhedron | None = None
    radius: float = 0.0
    half_length: float = 0.0
    oracle: Any = field(default=None, repr=False)

    @cached_property
    def vertices(self):
        """Corners of polyhedron or core (n, 3) [m], shape axes."""
        if self.solid is not None:
            return self.solid.vertices + self.solid.center
        return np.array([[0.0, 0.0, self.half_length], [0.0, 0.0, -self.half_length]])

    @cached_property
    def half_width(self):
        return self.solid.half_width if self.solid is not None else np.inf

    @cached_property
    def reach(self):
        """Radius about the middle [m]."""
        if self.solid is not None:
            return self.solid.radius
        return self.half_length + self.radius

    @property
    def middle(self):
        return self.solid.center if self.solid is not None else np.zeros(3)


def sphere(radius):
    return Shape(SPHERE, np.array([radius]), None, radius)


def capsule(radius, half_length):
    return Shape(CAPSULE, np.array([radius, half_length]), None, radius, half_length)


def box(half):
    return Shape(BOX, np.array(half), hulls.box(half))


def cylinder(radius, half_length):
    solid = hulls.prism(radius, half_length)
    return Shape(CYLINDER, np.concatenate(([radius, half_length], packed(solid))), solid)


def hull(points):
    solid = hulls.hull(points)
    return Shape(HULL, packed(solid), solid)


def random_shape(kind, rng):
    """Return a shape of 0.1 to 1 m."""
    sizes = np.exp(rng.uniform(-2.0, 0.0, 3))
    if kind == SPHERE:
        return sphere(sizes[0])
    if kind == CAPSULE:
        return capsule(sizes[0], sizes[1])
    if kind == BOX:
        return box(sizes)
    if kind == CYLINDER:
        return cylinder(sizes[0], sizes[1])
    points = rng.normal(size=(rng.choice(list(SIZES), p=list(SIZES.values())), 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    return hull(points * sizes + rng.normal(size=3))


def random_turns(rng, n):
    return so3.matrix_from_quaternion(so3.normalise(rng.normal(size=(n, 4))))


def place(shape, middle, turn):
    """Return the pose of a shape (12,) whose middle is at a place."""
    return np.concatenate((middle - turn @ shape.middle, turn.ravel()))


def random_cases(pair, n, rng, *, shapes=20):
    """
    Yield n times two shapes of a few, with their poses: overlapping, near, or apart.

    Each fifth pair has parallel axes.
    """
    first, second = ([random_shape(kind, rng) for _ in range(shapes)] for kind in pair)
    turns_a, turns_b = random_turns(rng, n), random_turns(rng, n)
    turns_b[::5] = turns_a[::5]
    middles, directions = rng.normal(size=(2, n, 3))
    directions *= (rng.random(n) / np.linalg.norm(directions, axis=1))[:, None]
    choices = rng.integers(shapes, size=(n, 2))
    for (i, j), p, q, x, d in zip(choices, turns_a, turns_b, middles, directions):
        a, b = first[i], second[j]
        yield a, b, place(a, x, p), place(b, x + (a.reach + b.reach) * d, q)


@dataclass
class Found:
    """normal (3,) from A to B, places (n, 3), gaps (n,), features (n,)."""

    normal: np.ndarray
    places: np.ndarray
    gaps: np.ndarray
    features: np.ndarray

    @property
    def gap(self):
        return float(np.min(self.gaps, initial=np.inf))

    def __len__(self):
        return len(self.gaps)


def collide(a, b, pose_a, pose_b, margin, motion=(0.0,) * 6, held=()):
    """
    Run the kernel of two shapes.

        motion : displacement and turn of A in the tick
        held   : features of the points of the last tick
    """
    numbers = np.concatenate((a.sizes, b.sizes))
    poses = np.concatenate((pose_a, pose_b))
    found = np.full(FOUND, np.nan)
    found[SHIFT:HELD_COUNT] = motion
    found[HELD_COUNT] = len(held)
    found[HELD : HELD + len(held)] = held
    kernel = collide_kernel(a.kind, b.kind)
    count = kernel(
        argument(numbers), 0, len(a.sizes), argument(poses), 0, 12, float(margin), argument(found)
    )
    points = found[POINTS : POINTS + POINT * count].reshape(count, POINT)
    return Found(found[:3].copy(), points[:, :3].copy(), points[:, 3].copy(), points[:, 4].copy())


def separation(a, b, pose_a, pose_b, normal):
    """Return min_B n . x - max_A n . x [m]: what the law calls the gap along n."""
    shift = pose_b[:3] - pose_a[:3]
    of_a = a.vertices @ (pose_a[3:].reshape(3, 3).T @ normal)
    of_b = b.vertices @ (pose_b[3:].reshape(3, 3).T @ normal)
    return float(np.min(of_b) - np.max(of_a) + shift @ normal) - a.radius - b.radius


class Oracle:
    """
    Signed distance of two placed shapes by coal.

    round_cylinders : cylinders as such; else as their prisms
    """

    def __init__(self, *, round_cylinders=False):
        import coal

        self._round_cylinders = round_cylinders

        self._coal = coal
        request = coal.DistanceRequest()
        request.enable_signed_distance = True
        request.gjk_tolerance, request.gjk_max_iterations = 1e-12, 1000
        request.epa_tolerance, request.epa_max_iterations = 1e-10, 1000
        self._request = request

    def __call__(self, a, b, pose_a, pose_b):
        result = self._coal.DistanceResult()
        placed = (*self._placed(a, pose_a), *self._placed(b, pose_b))
        return self._coal.distance(*placed, self._request, result)

    def _placed(self, shape, pose):
        if shape.oracle is None:
            shape.oracle = self._geometry(shape)
        return shape.oracle, self._coal.Transform3s(pose[3:].reshape(3, 3), pose[:3])

    def _geometry(self, shape):
        coal = self._coal
        if shape.kind == SPHERE:
            return coal.Sphere(shape.radius)
        if shape.kind == CAPSULE:
            return coal.Capsule(shape.radius, 2.0 * shape.half_length)
        if shape.kind == CYLINDER and self._round_cylinders:
            return coal.Cylinder(shape.sizes[0], 2.0 * shape.sizes[1])
        points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
        for point in shape.vertices:
            points.append(point)
        for triangle in shape.solid.triangles.tolist():
            triangles.append(coal.Triangle(*triangle))
        return coal.Convex(points, triangles)
