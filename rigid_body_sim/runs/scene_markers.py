# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The markers of a scene: each shape as it collides, each named frame as three short axes.

    sphere, box, cylinder    the marker of that name
    capsule                  a cylinder and two spheres
    convex hull, mesh        triangles of the hull: what collides; a mesh in a scene without
                             contact: its own triangles
    plane                    two triangles, as wide as the scene
    particle, no shape       a small ball at the centre of mass
    particles                a small ball at each
    union                    its parts

A marker stands where its shape does: x_m = x + R (o - c), q_m = q q_s
    x, q   : pose of the body: of its centre of mass, and body to world
    o, q_s : where the shape lies in body coordinates;  c : centre of mass, body coordinates
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation, shapes
from rigid_body_sim.physics.model.placed_parts import placed_parts
from rigid_body_sim.physics.model.reach import reach
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.recording.marker_packing import (
    CUBE,
    CYLINDER,
    FRAMES,
    LINE_LIST,
    SHAPES,
    SPHERE,
    SPHERE_LIST,
    TRIANGLE_LIST,
    Color,
    Form,
    Poses,
    Scale,
)

Array = NDArray[np.float64]

BALL = 0.01  # [-] of the size of the scene: radius of what stands for a point
STANDARD_GRAVITY = 9.80665  # [m/s^2]
LONGEST = 10.0  # [-] usual arrows
AXES = 0.5  # [-] of the reach of its body: length of the axes of a named frame
LEAST_SIZE, LARGEST_SIZE = 1e-6, 1e30  # [m] of scenes: viewers draw in single precision
LEAST_WEIGHT, LARGEST_WEIGHT = 1e-200, 1e200  # [N] that set the length of arrows
_FIXED: Color = (0.6, 0.6, 0.6, 1.0)
_COLORS: tuple[Color, ...] = (  # told apart by all eyes: Okabe and Ito
    (0.00, 0.45, 0.70, 1.0),
    (0.90, 0.60, 0.00, 1.0),
    (0.00, 0.62, 0.45, 1.0),
    (0.80, 0.47, 0.65, 1.0),
    (0.34, 0.71, 0.91, 1.0),
    (0.84, 0.37, 0.00, 1.0),
    (0.94, 0.89, 0.26, 1.0),
)
_UNIT = (1.0, 1.0, 1.0)
_AXIS_LINES = np.kron(np.eye(3), [[0.0], [1.0]])  # (6, 3): from the origin along each axis
_AXIS_COLORS = np.repeat(np.hstack((np.eye(3), np.ones((3, 1)))), 2, axis=0)


def forms_of(scene: Scene) -> list[Form]:
    """Give the markers of all bodies, in scene order, then those of their frames."""
    size = size_of(scene)
    forms, count, frames = [], len(scene.bodies), 0
    for place, body in enumerate(scene.bodies):
        color = _FIXED if body.fixed else _COLORS[place % len(_COLORS)]
        own = _OfBody(scene, place, color, size).forms()
        forms += [replace(form, number=place + count * k) for k, form in enumerate(own)]
    for place, body in enumerate(scene.bodies):
        length = AXES * min(reach(body) or size, LARGEST_SIZE)
        for frame in body.frames.values():
            forms.append(
                Form(
                    *(FRAMES, frames, place, LINE_LIST),
                    scale=(0.05 * length, 0.0, 0.0),
                    color=(1.0, 1.0, 1.0, 1.0),
                    position=frame.position,
                    orientation=frame.orientation,
                    points=np.multiply(length, _AXIS_LINES, dtype=np.float64),
                    colors=_AXIS_COLORS,
                )
            )
            frames += 1
    return forms


class MarkerPlaces:
    """Where markers stand that go with bodies."""

    def __init__(self, forms: Sequence[Form]) -> None:
        self._bodies = np.array([form.body for form in forms], np.int64)
        self._from_center = np.array([form.position for form in forms]).reshape(-1, 3)
        self._turns = np.array([form.orientation for form in forms]).reshape(-1, 4)

    def poses(self, position: Array, orientation: Array) -> Poses:
        """
        Give the pose of each marker.

        position, orientation : (n, 3) [m], (n, 4) [-] of the bodies: centre of mass, world; xyzw,
                                body to world
        """
        turns = orientation[self._bodies]
        return Poses(
            position[self._bodies] + rotation.rotate(turns, self._from_center),
            rotation.multiply(turns, self._turns),
        )


def scale_of(scene: Scene, metres_per_newton: float) -> Scale:
    """
    Choose how long arrows are.

    metres_per_newton : [m/N] for forces; 0: the weight on earth of the heaviest body that moves is
                        as long as twice the reach of the largest

    A torque is as long as the force that has it at the reach of the largest body.
    """
    moving = [body for body in scene.bodies if not body.fixed]
    size = max((reach(body) for body in moving), default=0.0) or size_of(scene)
    size = min(max(size, LEAST_SIZE), LARGEST_SIZE)
    weight = STANDARD_GRAVITY * max((body.mass for body in moving), default=1.0)
    reference = 2.0 * size
    metres = metres_per_newton or reference / min(max(weight, LEAST_WEIGHT), LARGEST_WEIGHT)
    return Scale(metres, metres / size, reference, LONGEST * reference)


def size_of(scene: Scene) -> float:
    """Half the width of the scene at its start [m], planes aside; never zero."""
    bodies = [body for body in scene.bodies if not isinstance(body.shape, shapes.Plane)]
    if not bodies:
        return 1.0
    middle = _middle(bodies)
    sizes = (math.dist(body.initial.position, middle) + reach(body) for body in bodies)
    return min(max(LEAST_SIZE, *sizes), LARGEST_SIZE)


def _middle(bodies: list[Body]) -> Array:
    places = np.array([body.initial.position for body in bodies])
    middle = 0.5 * places.min(axis=0) + 0.5 * places.max(axis=0)
    return np.clip(middle, -LARGEST_SIZE, LARGEST_SIZE)


def _cube(edge: float) -> tuple[float, float, float]:
    return edge, edge, edge


class _OfBody:
    """The markers of one body."""

    def __init__(self, scene: Scene, place: int, color: Color, size: float) -> None:
        self._scene = scene
        self._place = place
        self._color = color
        self._size = size
        self._ball = _cube(2.0 * BALL * size)
        self._meets = scene.contact.get('mode', 'none') != 'none'

    def forms(self) -> list[Form]:
        """Give them, part by part."""
        body = self._scene.bodies[self._place]
        if body.shape is None:
            return [self._form(SPHERE, self._ball, body, centered=True)]
        return [form for part in placed_parts(body) for form in self._of_part(part)]

    def _of_part(self, part: Body) -> Iterator[Form]:
        match part.shape:
            case shapes.Sphere(radius):
                yield self._form(SPHERE, _cube(2.0 * radius), part)
            case shapes.Box(size):
                yield self._form(CUBE, (size[0], size[1], size[2]), part)
            case shapes.Cylinder(radius, length):
                yield self._form(CYLINDER, (2.0 * radius, 2.0 * radius, length), part)
            case shapes.Capsule(radius, length):
                yield self._form(CYLINDER, (2.0 * radius, 2.0 * radius, length), part)
                for end in (-0.5 * length, 0.5 * length):
                    yield self._form(SPHERE, _cube(2.0 * radius), part, at=(0.0, 0.0, end))
            case shapes.Surface(vertices, faces):
                yield self._triangles(vertices[faces], part)
            case shapes.Mesh(vertices, faces) if not self._meets:
                yield self._triangles(vertices[faces], part)
            case shapes.ConvexHull() | shapes.Mesh() as shape:
                triangles = hull_triangles(shape)
                if triangles is None:
                    yield self._form(SPHERE_LIST, self._ball, part, points=shape.vertices)
                else:
                    yield self._triangles(triangles, part)
            case shapes.Plane() as plane:
                yield self._triangles(self._square(plane, part), part)
            case shapes.Particles(positions=positions):
                yield self._form(SPHERE_LIST, self._ball, part, points=positions)
            case _:
                yield self._form(SPHERE, self._ball, part)

    def _triangles(self, corners: Array, part: Body) -> Form:
        return self._form(TRIANGLE_LIST, _UNIT, part, points=corners.reshape(-1, 3))

    def _form(
        self,
        kind: int,
        scale: tuple[float, float, float],
        part: Body,
        *,
        at: tuple[float, float, float] = (0.0, 0.0, 0.0),
        points: Array | None = None,
        centered: bool = False,
    ) -> Form:
        origin = np.subtract(part.shape_position, part.center_of_mass)
        x, y, z = (origin + rotation.rotate(part.shape_orientation, at)).tolist()
        return Form(
            *(SHAPES, 0, self._place, kind, scale, self._color),
            position=(0.0, 0.0, 0.0) if centered else (x, y, z),
            orientation=part.shape_orientation,
            points=points,
        )

    def _square(self, plane: shapes.Plane, part: Body) -> Array:
        """
        Give two triangles (2, 3, 3) [m] in the plane n . x = d, shape axes, around the point of it
        that is nearest to the middle of the scene.
        """
        normal = np.array(plane.normal)
        bodies = [b for b in self._scene.bodies if not isinstance(b.shape, shapes.Plane)]
        middle = _middle(bodies) if bodies else np.zeros(3)
        to_middle = np.clip(middle - part.initial.position, -LARGEST_SIZE, LARGEST_SIZE)
        from_center = rotation.rotate_back(part.initial.orientation, to_middle)
        origin = np.subtract(part.shape_position, part.center_of_mass)
        seen = rotation.rotate_back(part.shape_orientation, from_center - origin)
        nearest = seen + (plane.offset - float(np.sum(normal * seen))) * normal
        first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        first /= math.sqrt(float(np.sum(first * first)))
        second = np.cross(normal, first)
        half = 2.0 * self._size
        corners = [
            nearest + half * (a * first + b * second)
            for a, b in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
        ]
        return np.array(corners)[[[0, 1, 2], [0, 2, 3]]]


def hull_triangles(shape: shapes.ConvexHull | shapes.Mesh) -> Array | None:
    """
    Give the triangles (m, 3, 3) [m] of the convex hull that collides, counter-clockwise seen from
    outside, shape axes; None where the points span no solid.
    """
    # Qhull takes a quarter of a second to import: only for the scenes that have a hull.
    from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hulls import (
        hull,
        hull_of_mesh,
    )

    try:
        solid = hull_of_mesh(shape) if isinstance(shape, shapes.Mesh) else hull(shape.vertices)
    except InvalidModel:
        return None
    return solid.center + solid.vertices[solid.triangles]
