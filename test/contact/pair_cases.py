# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pairs of shapes at random, what the kernels find between them, and what coal finds."""

import math
from dataclasses import dataclass

import numpy as np

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    NAMES,
    PLANE,
    SPHERE,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FOUND,
    POINT,
    POINTS,
    SCRATCH,
    SHIFT,
)
from rigid_body_sim.physics.contact.collision.pairs import collide_kernel
from rigid_body_sim.physics.model import rotation as so3

COUNT = {SPHERE: 1, CAPSULE: 2, BOX: 3, CYLINDER: 2, PLANE: 4}  # sizes of each type
ANALYTIC = (
    (SPHERE, SPHERE),
    (SPHERE, CAPSULE),
    (SPHERE, BOX),
    (SPHERE, CYLINDER),
    (SPHERE, PLANE),
    (CAPSULE, CAPSULE),
    (CAPSULE, BOX),
    (CAPSULE, PLANE),
    (BOX, BOX),
    (BOX, PLANE),
    (CYLINDER, PLANE),
)
KERNELS = {}  # found once


def name(pair):
    return '-'.join(NAMES[kind] for kind in pair)


@dataclass
class Placed:
    """A shape somewhere: type, sizes as in `collider`, origin (3,) [m], rotation (3, 3)."""

    kind: int
    sizes: np.ndarray
    origin: np.ndarray
    turn: np.ndarray

    def moved(self, turn, shift):
        """Move rigidly about the world's origin."""
        if self.kind == PLANE:
            normal = turn @ self.sizes[:3]
            offset = self.sizes[3] + normal @ shift
            return Placed(PLANE, np.array([*normal, offset]), self.origin, self.turn)
        return Placed(self.kind, self.sizes, turn @ self.origin + shift, turn @ self.turn)

    def support(self, direction):
        """Farthest reach [m] along a unit vector, from the origin of the shape."""
        local = self.turn.T @ direction
        s = self.sizes
        if self.kind == SPHERE:
            return s[0]
        if self.kind == CAPSULE:
            return s[0] + s[1] * abs(local[2])
        if self.kind == BOX:
            return float(s @ np.abs(local))
        return s[1] * abs(local[2]) + s[0] * float(np.hypot(local[0], local[1]))


@dataclass
class Found:
    """normal (3,) from A to B, places (n, 3), gaps (n,), features (n,)."""

    normal: np.ndarray
    places: np.ndarray
    gaps: np.ndarray
    features: np.ndarray

    @property
    def gap(self):
        """The smallest gap; infinite where nothing was found."""
        return float(np.min(self.gaps, initial=np.inf))

    def __len__(self):
        return len(self.gaps)


def collide(a, b, margin):
    """Run the kernel of two placed shapes."""
    numbers = np.concatenate((a.sizes, b.sizes))
    poses = np.concatenate((a.origin, a.turn.ravel(), b.origin, b.turn.ravel()))
    found = np.full(FOUND, np.nan)
    found[SHIFT:SCRATCH] = 0.0  # nothing is known of a motion, or of the last tick
    if (a.kind, b.kind) not in KERNELS:
        KERNELS[a.kind, b.kind] = collide_kernel(a.kind, b.kind)
    count = KERNELS[a.kind, b.kind](
        argument(numbers), 0, len(a.sizes), argument(poses), 0, 12, margin, argument(found)
    )
    points = found[POINTS : POINTS + POINT * count].reshape(count, POINT)
    return Found(found[:3].copy(), points[:, :3].copy(), points[:, 3].copy(), points[:, 4].copy())


def about(axis, angle):
    """Rotation (3, 3) by an angle about axis 0, 1 or 2."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = c
    turn[j, i], turn[i, j] = s, -s
    return turn


def random_turns(rng, n):
    return so3.matrix_from_quaternion(so3.normalise(rng.normal(size=(n, 4))))


def random_pairs(pair, n, rng, *, depth=0.9):
    """
    Yield n pairs of placed shapes of 0.1 to 3 m that overlap or nearly touch.

    depth : [-] how far, at most, they are pushed into each other from touching supports
    """
    first, second = pair
    sizes_a = np.exp(rng.uniform(-2.0, 1.0, (n, COUNT[first])))
    sizes_b = np.exp(rng.uniform(-2.0, 1.0, (n, COUNT[second])))
    origins, directions = rng.normal(size=(2, n, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    turns_a, turns_b = random_turns(rng, n), random_turns(rng, n)
    turns_b[::4] = turns_a[::4]  # parallel axes are the hard case
    shares = 1.05 - (depth + 0.05) * rng.random(n)
    for k, direction in enumerate(directions):
        a = Placed(first, sizes_a[k], origins[k], turns_a[k])
        if second == PLANE:
            offset = direction @ a.origin - shares[k] * a.support(direction)
            yield a, Placed(PLANE, np.array([*direction, offset]), np.zeros(3), np.eye(3))
        else:
            b = Placed(second, sizes_b[k], np.zeros(3), turns_b[k])
            reach = shares[k] * (a.support(direction) + b.support(direction))
            b.origin = a.origin + reach * direction
            yield a, b


class Oracle:
    """Signed distance of two placed shapes by coal, and its normal from A to B."""

    def __init__(self):
        import coal

        self._coal = coal
        self._request = coal.DistanceRequest()
        self._request.enable_signed_distance = True

    def __call__(self, a, b):
        result = self._coal.DistanceResult()
        gap = self._coal.distance(*self._placed(a), *self._placed(b), self._request, result)
        return gap, np.array(result.normal)

    def _placed(self, shape):
        coal, s = self._coal, shape.sizes.tolist()
        if shape.kind == SPHERE:
            geometry = coal.Sphere(s[0])
        elif shape.kind == CAPSULE:
            geometry = coal.Capsule(s[0], 2.0 * s[1])
        elif shape.kind == BOX:
            geometry = coal.Box(2.0 * s[0], 2.0 * s[1], 2.0 * s[2])
        elif shape.kind == CYLINDER:
            geometry = coal.Cylinder(s[0], 2.0 * s[1])
        else:
            return coal.Halfspace(shape.sizes[:3], s[3]), coal.Transform3s()
        return geometry, coal.Transform3s(shape.turn, shape.origin)
