# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How far bodies reach: their bounding boxes, and whether they overlap a ball or a box.

A body is made of pieces: a box (a point where it has no edges) that a layer of some thickness
surrounds. Balls, capsules, boxes and points are told exactly, as long as a box meets no edge of a
capsule; cylinders, hulls and meshes are taken for the boxes around them, along the axes of their
shape. A plane fills everything below it.

The separating axes of two boxes: S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.model.rotation import matrix_from_quaternion
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Particles,
    Plane,
    Shape,
    Sphere,
    Surface,
    Union,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Pose:
    """
    Where axes lie in others.

    origin : (3,) [m]
    axes   : (3, 3) [-]  their axes as columns
    """

    origin: Array
    axes: Array

    @classmethod
    def of(cls, position: ArrayLike, orientation: ArrayLike) -> Pose:
        """Make one of a position [m] and a unit quaternion xyzw."""
        return cls(np.asarray(position, dtype=np.float64), matrix_from_quaternion(orientation))

    def place(self, inner: Pose) -> Pose:
        """Where `inner` lies as seen from outside."""
        return Pose(self.origin + self.axes @ inner.origin, self.axes @ inner.axes)


@dataclass(frozen=True, eq=False)
class Piece:
    """
    A box with a layer around it.

    pose     : of its middle and axes, from the centre of mass in body axes
    half     : (3,) [m]  half edges
    layer    : [m]       thickness of the layer
    """

    pose: Pose
    half: Array
    layer: float = 0.0

    def meets_ball(self, body: Pose, center: Array, radius: float) -> bool:
        """Whether it is no farther from a point than a radius [m], the body being there."""
        pose = body.place(self.pose)
        inside = np.abs(pose.axes.T @ (center - pose.origin))
        gap = np.maximum(inside - self.half, 0.0)
        return float(np.linalg.norm(gap)) <= radius + self.layer

    def meets_box(self, body: Pose, center: Array, half: Array) -> bool:
        """Whether no axis separates it from a box along the axes of the world."""
        pose = body.place(self.pose)
        if not self.half.any():
            gap = np.maximum(np.abs(pose.origin - center) - half, 0.0)
            return float(np.linalg.norm(gap)) <= self.layer
        edges = np.cross(np.eye(3)[:, None, :], pose.axes.T[None, :, :]).reshape(-1, 3)
        axes = np.concatenate((np.eye(3), pose.axes.T, edges))
        lengths = np.linalg.norm(axes, axis=1)
        axes = axes[lengths > 1e-9] / lengths[lengths > 1e-9, None]  # parallel edges span none
        reach = np.abs(axes) @ half + np.abs(axes @ pose.axes) @ self.half + self.layer
        return bool(np.all(np.abs(axes @ (pose.origin - center)) <= reach))


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """
    What lies below a plane.

    normal : (3,) [-]  out of it, body axes
    offset : [m]       of its surface along the normal, from the centre of mass
    """

    normal: Array
    offset: float

    def meets_ball(self, body: Pose, center: Array, radius: float) -> bool:
        """Whether a ball reaches below the plane."""
        return self._height(body, center) <= radius

    def meets_box(self, body: Pose, center: Array, half: Array) -> bool:
        """Whether a box along the axes of the world reaches below it."""
        return self._height(body, center) <= float(np.abs(body.axes @ self.normal) @ half)

    def _height(self, body: Pose, point: Array) -> float:
        return float((body.axes @ self.normal) @ (point - body.origin)) - self.offset


@dataclass(frozen=True, eq=False)
class Extent:
    """
    How far one body reaches.

    pieces : what it is made of; a point where it has no shape
    box    : low and high corner (2, 3) [m] of what it fills, from its centre of mass in body axes;
             None for a body that has no bounds or no shape
    """

    pieces: tuple[Piece | HalfSpace, ...]
    box: Array | None

    @property
    def is_unbounded(self) -> bool:
        """Whether it goes on for ever."""
        return any(isinstance(piece, HalfSpace) for piece in self.pieces)

    def meets_ball(self, pose: Pose, center: Array, radius: float) -> bool:
        """Whether the body at a pose of its centre of mass overlaps a ball."""
        return any(piece.meets_ball(pose, center, radius) for piece in self.pieces)

    def meets_box(self, pose: Pose, center: Array, half: Array) -> bool:
        """Whether it overlaps a box along the axes of the world; `half`: half edges [m]."""
        return any(piece.meets_box(pose, center, half) for piece in self.pieces)


def extent_of(body: Body) -> Extent:
    """Find how far a body reaches."""
    point = Pose(np.zeros(3), np.eye(3))
    if body.is_point:
        return Extent((Piece(point, np.zeros(3)),), np.zeros((2, 3)))
    if body.shape is None:
        return Extent((Piece(point, np.zeros(3)),), None)
    origin = np.subtract(body.shape_position, body.center_of_mass)
    pieces, corners = _of_shape(body.shape, Pose.of(origin, body.shape_orientation))
    if corners is None:
        return Extent(tuple(pieces), None)
    return Extent(tuple(pieces), np.array([np.min(corners, axis=0), np.max(corners, axis=0)]))


def _of_shape(shape: Shape, pose: Pose) -> tuple[list[Piece | HalfSpace], Array | None]:
    """
    Cut a shape into pieces; with them corners of the boxes around them, None if there is no end.
    """
    match shape:
        case Plane(normal=normal, offset=offset):
            turned = pose.axes @ np.array(normal)
            return [HalfSpace(turned, offset + float(turned @ pose.origin))], None
        case Union(parts=parts):
            found = [
                _of_shape(part.shape, pose.place(Pose.of(part.position, part.orientation)))
                for part in parts
            ]
            corners = [more for _, more in found if more is not None]
            return [piece for pieces, _ in found for piece in pieces], np.concatenate(corners)
        case Particles(positions=positions):
            points = pose.origin + positions @ pose.axes.T
            return [Piece(Pose(x, pose.axes), np.zeros(3)) for x in points], points
        case ConvexHull(vertices=vertices) | Mesh(vertices=vertices) | Surface(vertices=vertices):
            low, high = np.min(vertices, axis=0), np.max(vertices, axis=0)
            middle = pose.place(Pose(0.5 * (low + high), np.eye(3)))
            return [Piece(middle, 0.5 * (high - low))], pose.origin + vertices @ pose.axes.T
    half, layer, reach = _around(shape, pose.axes)
    return [Piece(pose, half, layer)], pose.origin + np.array([-reach, reach])


def _around(shape: Shape, axes: Array) -> tuple[Array, float, Array]:
    """
    Give half edges and layer of a shape about its origin, and how far it reaches along axes.

    axes : (3, 3)  those of the shape as columns, seen from the others
    """
    match shape:
        case Sphere(radius=radius):
            half, layer = np.zeros(3), radius
        case Box(size=size):
            half, layer = 0.5 * np.array(size), 0.0
        case Capsule(radius=radius, length=length):
            half, layer = np.array([0.0, 0.0, 0.5 * length]), radius
        case Cylinder(radius=radius, length=length):
            along = axes[:, 2]
            across = np.sqrt(np.maximum(1.0 - along * along, 0.0))
            half = np.array([radius, radius, 0.5 * length])
            return half, 0.0, 0.5 * length * np.abs(along) + radius * across
        case _:
            half, layer = np.zeros(3), 0.0
    return half, layer, np.abs(axes) @ half + layer
