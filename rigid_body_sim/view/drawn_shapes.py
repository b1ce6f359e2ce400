# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The shapes of a scene as the playback page draws them: each where it collides.

A recorded pose is that of the centre of mass, with the orientation of the body axes. Of each part
of a body the page holds where it lies from there:
    at   : (3,) [m]  x - c, body axes: origin of the shape seen from the centre of mass
    turn : (4,) [-]  unit quaternion xyzw, shape axes to body axes
Points are drawn as small balls. A body with an inertia but without a shape is drawn as what would
have that inertia at its mass: an ellipsoid where two principal moments are equal, else a box,

    box       : size_x^2 = 6 (I_y + I_z - I_x) / m      ellipsoid : radius_x^2 = 5 (...) / (2 m)

in principal axes. A hull is drawn by its faces, a mesh by its own; where the mesh collides and
leaves much of its hull empty, the hull is drawn too, translucent, because that is what touches.
Equal shapes stand in the page once, whatever bodies have them; a surface is in single precision,
as it is drawn.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model import rotation, shapes
from rigid_body_sim.physics.model.placed_parts import placed_parts
from rigid_body_sim.physics.model.principal_axes import principal_axes
from rigid_body_sim.physics.model.reach import reach
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.view.page_numbers import PageNumbers

Array = NDArray[np.float64]
Forms = list[tuple[Mapping[str, Any], Mapping[str, Any]]]  # forms, and how each is drawn

ALIKE = 1e-6  # [-] principal moments nearer than this are equal to the eye
THIN = 0.02  # [-] of the largest: a needle or a sheet is drawn so thick, or it could not be seen


class DrawnShapes:
    """
    Collects the shapes of a page, each once.

    forms : what the page draws; `parts` names them by their place in it
    """

    def __init__(self, numbers: PageNumbers, *, ball: float, meshes_collide: bool) -> None:
        """
        Begin with none.

        numbers : takes the corners and faces of surfaces
        ball    : [m] radius that points are drawn with
        meshes_collide : as hulls, or not at all
        """
        self.forms: list[Mapping[str, Any]] = []
        self._numbers = numbers
        self._ball = {'type': 'point', 'radius': ball}
        self._meshes_collide = meshes_collide
        self._places: dict[str, int] = {}
        self._forms_of: dict[int, list[tuple[int, Mapping[str, Any]]]] = {}
        self._kept: list[shapes.Shape] = []  # so that no identity is given away again

    def parts(self, body: Body | None) -> list[dict[str, Any]]:
        """Give the parts of a body: which form each has, and where it is; None: a ball."""
        if body is not None and body.shape is None and body.inertia is not None:
            form, turn = inertia_form(body.mass, body.inertia)
            return [self._part(self._place(form), np.zeros(3), turn)]
        if body is None or body.shape is None:
            return [self._part(self._place(self._ball), np.zeros(3), rotation.IDENTITY)]
        found = []
        for part in placed_parts(body):
            at, turn = _from_center(part), part.shape_orientation
            match part.shape:
                case shapes.Plane():
                    continue
                case shapes.Particles(positions=points):
                    ball = self._place(self._ball)
                    places = at + rotation.rotate(turn, points)
                    found += [self._part(ball, place, turn) for place in places]
                case shape:
                    found += [self._part(form, at, turn, **more) for form, more in self._of(shape)]
        return found

    def _part(self, form: int, at: Array, turn: Any, **more: Any) -> dict[str, Any]:
        return {'form': form, 'at': at.tolist(), 'turn': list(turn), **more}

    def _place(self, form: Mapping[str, Any]) -> int:
        """Tell where a form stands among all; a new one is added."""
        key = json.dumps(form)
        if key not in self._places:
            self._places[key] = len(self.forms)
            self.forms.append(form)
        return self._places[key]

    def _of(self, shape: Any) -> list[tuple[int, Mapping[str, Any]]]:
        """Give the forms of one shape, which bodies may share, and how each is drawn."""
        if id(shape) not in self._forms_of:
            self._kept.append(shape)
            self._forms_of[id(shape)] = [
                (self._place(form), more) for form, more in self._forms(shape)
            ]
        return self._forms_of[id(shape)]

    def _forms(self, shape: shapes.Shape) -> Forms:
        match shape:
            case shapes.Sphere(radius):
                return [({'type': 'sphere', 'radius': radius}, {})]
            case shapes.Box(size):
                return [({'type': 'box', 'size': size}, {})]
            case shapes.Cylinder(radius, length):
                return [({'type': 'cylinder', 'radius': radius, 'length': length}, {})]
            case shapes.Capsule(radius, length):
                return [({'type': 'capsule', 'radius': radius, 'length': length}, {})]
            case shapes.Mesh(vertices, faces):
                whole: Forms = [(self._surface(vertices, faces), {})]
                if self._meshes_collide and _leaves_empty(shape):
                    whole.append((self._hull(vertices), {'translucent': True}))
                return whole
            case shapes.Surface(vertices, faces):
                return [(self._surface(vertices, faces) | {'ground': True}, {})]
            case shapes.ConvexHull(vertices):
                return [(self._hull(vertices), {})]
            case _:
                return [(self._ball, {})]

    def _hull(self, vertices: Array) -> dict[str, Any]:
        import trimesh

        with np.errstate(all='ignore'):  # points in a plane have no volume to divide by
            hull = trimesh.convex.convex_hull(vertices)
        return self._surface(np.asarray(hull.vertices), np.asarray(hull.faces))

    def _surface(self, vertices: Array, faces: NDArray[np.int64]) -> dict[str, Any]:
        return {
            'type': 'surface',
            'vertices': self._numbers.add(vertices, 'f4'),
            'faces': self._numbers.add(faces, 'u4'),
        }


def inertia_form(mass: float, inertia: Array) -> tuple[dict[str, Any], list[float]]:
    """Give the box or ellipsoid of an inertia, and its turn (4,) from principal to body axes."""
    moments, axes = principal_axes(inertia)
    squares = (np.sum(moments) - 2.0 * moments) / mass
    sizes = np.sqrt(np.maximum(squares, 0.0))
    sizes = np.maximum(sizes, THIN * sizes.max())
    ordered = np.sort(moments)
    turn = rotation.quaternion_from_matrix(axes).tolist()
    if np.min(np.diff(ordered)) <= ALIKE * ordered[-1]:
        return {'type': 'ellipsoid', 'radii': (np.sqrt(2.5) * sizes).tolist()}, turn
    return {'type': 'box', 'size': (np.sqrt(6.0) * sizes).tolist()}, turn


def drawn_reach(body: Body | None, ball: float) -> float:
    """How far what is drawn of a body goes from its centre of mass [m]."""
    if body is not None and body.shape is None and body.inertia is not None:
        form, _ = inertia_form(body.mass, body.inertia)
        return float(
            np.max(form['radii']) if 'radii' in form else 0.5 * np.hypot.reduce(form['size'])
        )
    return reach(body) or ball


def drawn_bounds(body: Body | None, ball: float) -> tuple[Array, Array]:
    """Lowest and highest corner of what is drawn of a body, each (3,) [m], body axes."""
    if body is None or body.shape is None or isinstance(body.shape, shapes.Plane):
        half = np.full(3, drawn_reach(body, ball))
        if body is not None and body.shape is None and body.inertia is not None:
            form, turn = inertia_form(body.mass, body.inertia)
            sizes = form['radii'] if 'radii' in form else np.multiply(0.5, form['size'])
            half = np.abs(rotation.matrix_from_quaternion(turn)) @ sizes
        return -half, half
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for part in placed_parts(body):
        turn = rotation.matrix_from_quaternion(part.shape_orientation)
        below, above = _bounds(part.shape, ball)
        middle = _from_center(part) + turn @ (0.5 * (below + above))
        half = np.abs(turn) @ (0.5 * (above - below))
        low, high = np.minimum(low, middle - half), np.maximum(high, middle + half)
    return low, high


def _bounds(shape: shapes.Shape | None, ball: float) -> tuple[Array, Array]:
    """Lowest and highest corner of one shape, its own axes."""
    match shape:
        case shapes.Sphere(radius):
            half = np.full(3, radius)
        case shapes.Box(size):
            half = np.multiply(0.5, size)
        case shapes.Cylinder(radius, length):
            half = np.array((radius, radius, 0.5 * length))
        case shapes.Capsule(radius, length):
            half = np.array((radius, radius, radius + 0.5 * length))
        case (
            shapes.ConvexHull(vertices=points)
            | shapes.Mesh(vertices=points)
            | shapes.Surface(vertices=points)
            | shapes.Particles(positions=points)
        ):
            return np.min(points, axis=0), np.max(points, axis=0)
        case _:
            half = np.full(3, ball)
    return -half, half


def drawn_planes(scene: Scene | None) -> list[dict[str, Any]]:
    """Give normal (3,) [-] and offset [m] of each plane in the world, where its body stands."""
    found = []
    for body in () if scene is None else scene.bodies:
        if isinstance(body.shape, shapes.Plane):
            turn = rotation.multiply(body.initial.orientation, body.shape_orientation)
            normal = rotation.rotate(turn, body.shape.normal)
            origin = rotation.rotate(body.initial.orientation, _from_center(body))
            offset = body.shape.offset + float(normal @ (body.initial.position + origin))
            found.append({'normal': normal.tolist(), 'offset': offset})
    return found


def _from_center(part: Body) -> Array:
    """Origin of the shape seen from the centre of mass (3,) [m], body axes."""
    return np.subtract(part.shape_position, part.center_of_mass)


def _leaves_empty(mesh: shapes.Mesh) -> bool:
    from rigid_body_sim.physics.contact.collision.convexity_defect import (
        TOLERATED,
        convexity_defect_of,
    )

    return not convexity_defect_of(mesh) <= TOLERATED
