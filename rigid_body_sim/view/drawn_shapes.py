# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The shapes of a scene as the playback page draws them: each where it collides.

A recorded pose is that of the centre of mass, with the orientation of the body axes. Of each part
of a body the page holds where it lies from there:
    at   : (3,) [m]  x - c, body axes: origin of the shape seen from the centre of mass
    turn : (4,) [-]  unit quaternion xyzw, shape axes to body axes
Points are drawn as small balls. A hull is drawn by its faces, a mesh by its own; where the mesh
collides and leaves much of its hull empty, the hull is drawn too, translucent, because that is
what touches. Equal shapes stand in the page once, whatever bodies have them; a surface is in
single precision, as it is drawn.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model import rotation, shapes
from rigid_body_sim.physics.model.placed_parts import placed_parts
from rigid_body_sim.physics.model.scene import Body, Scene

Array = NDArray[np.float64]
Forms = list[tuple[Mapping[str, Any], Mapping[str, Any]]]  # forms, and how each is drawn


class DrawnShapes:
    """
    Collects the shapes of a page, each once.

    forms : what the page draws; `parts` names them by their place in it
    """

    def __init__(self, *, ball: float, meshes_collide: bool) -> None:
        """Draw points as balls of a radius `ball` [m]; meshes collide as hulls, or not at all."""
        self.forms: list[Mapping[str, Any]] = []
        self._ball = {'type': 'sphere', 'radius': ball}
        self._meshes_collide = meshes_collide
        self._places: dict[str, int] = {}
        self._forms_of: dict[int, list[tuple[int, Mapping[str, Any]]]] = {}
        self._kept: list[shapes.Shape] = []  # so that no identity is given away again

    def parts(self, body: Body | None) -> list[dict[str, Any]]:
        """Give the parts of a body: which form each has, and where it is; None: a ball."""
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
                whole: Forms = [(_surface(vertices, faces), {})]
                if self._meshes_collide and _leaves_empty(shape):
                    whole.append((_hull(vertices), {'translucent': True}))
                return whole
            case shapes.Surface(vertices, faces):
                return [(_surface(vertices, faces), {})]
            case shapes.ConvexHull(vertices):
                return [(_hull(vertices), {})]
            case _:
                return [(self._ball, {})]


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


def _hull(vertices: Array) -> dict[str, Any]:
    import trimesh

    with np.errstate(all='ignore'):  # points in a plane have no volume to divide by
        hull = trimesh.convex.convex_hull(vertices)
    return _surface(np.asarray(hull.vertices), np.asarray(hull.faces))


def _surface(vertices: Array, faces: NDArray[np.int64]) -> dict[str, Any]:
    return {
        'type': 'surface',
        'vertices': base64.b64encode(vertices.astype('<f4').tobytes()).decode(),
        'faces': base64.b64encode(faces.astype('<u4').tobytes()).decode(),
    }
