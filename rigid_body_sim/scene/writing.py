# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Records to YAML: the text of a scene that was made, or changed, in Python.

A bag and a checkpoint hold the text of their scene, and are read by the one reader of scenes. So a
scene is written as a scene file would say it, read again, and compared: what comes back must be
the same records, number by number. Where it is not, the scene is refused, and nothing is written.

What no scene file can say: a mesh or a surface that came from no file, a shape that lies askew in
its body (`shape_position`, which URDF files have; a Union can say it).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, TypeGuard

import numpy as np

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel, path_text
from rigid_body_sim.physics.model import shapes
from rigid_body_sim.physics.model.material import MATERIAL
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.validation import check_record
from rigid_body_sim.scene import document
from rigid_body_sim.scene.experiment import load_scene

NOT_COMPARED = {'source', 'origin', 'files'}  # of a scene: what stands around its records
STRAIGHT = (0.0, 0.0, 0.0, 1.0)
NOWHERE = (0.0, 0.0, 0.0)
WAYS = ('surge', 'sway', 'heave', 'roll', 'pitch', 'yaw')


def with_text(scene: Scene) -> Scene:
    """
    Return the scene with a text (`source`) that says what its records say.

    Raises InvalidModel, which names the place, for one that no scene file can say.
    """
    check_record(scene)
    if scene.source:
        try:
            read = load_scene(scene.source, files=scene.files, title=scene.name)
        except UserError:  # of a text that is not that of its records, anything may be
            read = None
        if read is not None and difference(scene, read) is None:
            return scene
    text = document.write(mapping_of(scene))
    try:
        read = load_scene(text, files=scene.files, title=scene.name)
    except UserError as error:
        raise InvalidModel(
            f'scene {scene.name!r}: no scene file can say it ({error}); make it by load_scene '
            'from a mapping'
        ) from error
    place = difference(scene, read)
    if place is not None:
        raise InvalidModel(
            f'scene {scene.name!r}: {path_text(place)} cannot be said by a scene file to the bit; '
            'make it by load_scene from a mapping',
            at=place,
        )
    return read


def mapping_of(scene: Scene) -> dict[str, Any]:
    """Return the mapping that a scene file would hold, with `version`."""
    said: dict[str, Any] = {
        'version': 1,
        'name': scene.name,
        'dt': scene.dt_ns / 1e9,
        'integrator': {'name': scene.integrator, **scene.integrator_options}
        if scene.integrator_options
        else scene.integrator,
        'gravity': _plain(scene.gravity),
        'contact': _plain(scene.contact),
        'bodies': [_body(body, i) for i, body in enumerate(scene.bodies)],
    }
    for body, written in zip(scene.bodies, said['bodies'], strict=True):
        if isinstance(body.shape, shapes.Mesh | shapes.Surface):
            written['shape'] = _as_it_was(scene, body) or written['shape']
    if scene.forces:
        said['forces'] = [_force(force) for force in scene.forces]
    return said


def _as_it_was(scene: Scene, body: Body) -> dict[str, Any] | None:
    """
    Return the shape as the text of the scene has it, where that text is of an earlier state of it:
    triangles come from files and tables that only the text names.
    """
    try:
        found = document.read(scene.source, name='', with_lines=False).content['bodies']
        shape = next(item['shape'] for item in found if item['name'] == body.name)
    except (UserError, LookupError, TypeError, StopIteration):
        return None
    return shape if isinstance(shape, dict) else None


def _force(force: Any) -> dict[str, Any]:
    """Write a force element by what its fields say of themselves."""
    said = {'type': force.TYPE}
    for field in dataclasses.fields(force):
        value = getattr(force, field.name)
        if value is not None and not _same(value, field.default):
            said[field.name] = _plain(value)
    return said


def _body(body: Body, number: int) -> dict[str, Any]:
    if not (_same(body.shape_position, NOWHERE) and _same(body.shape_orientation, STRAIGHT)):
        raise InvalidModel(
            f'bodies[{number}].shape_position: no scene file can say that a shape lies askew in '
            'its body; give the body a Union of one part, which says where it lies',
            at=('bodies', number, 'shape_position'),
        )
    said: dict[str, Any] = {'name': body.name}
    if body.shape is not None:
        said['shape'] = _shape(body.shape, ('bodies', number, 'shape'))
    elif body.is_point:
        said['shape'] = {'type': 'particle'}
    said |= _mass(body)
    if body.motion is not None:
        said['motion'] = _fields(body.motion)
        for way in WAYS:
            if way in said['motion']:
                said['motion'][way] = [_fields(one) for one in getattr(body.motion, way)]
    elif body.fixed and not isinstance(body.shape, shapes.Plane):
        said['fixed'] = True
    initial = _fields(body.initial)
    if body.pivot is not None:
        said['pivot'] = {'point': _plain(body.pivot.point), 'at': _plain(body.pivot.at)}
        initial = {k: v for k, v in initial.items() if k not in ('position', 'velocity')}
    if initial:
        said['initial'] = initial
    said |= {key: value for key, value in _fields(body.material).items() if key in MATERIAL}
    if body.mass_flow is not None:
        flow = _fields(body.mass_flow)
        said['mass_rate'] = flow.pop('rate')
        said |= flow
    if body.frames:
        said['frames'] = {name: _fields(frame) for name, frame in body.frames.items()}
    if any(body.surface_velocity):
        said['surface_velocity'] = _plain(body.surface_velocity)
    return said


def _mass(body: Body) -> dict[str, Any]:
    """Write mass, centre and inertia as they are, whatever they came from."""
    if isinstance(body.shape, shapes.Plane | shapes.Surface):
        return {}
    said: dict[str, Any] = {}
    if not (body.fixed and body.mass == 0.0):
        said['mass'] = float(body.mass)
    if body.is_point or isinstance(body.shape, shapes.Particle):
        return said
    said['center_of_mass'] = _plain(body.center_of_mass)
    if body.inertia_over_time is not None:
        said['inertia_over_time'] = _fields(body.inertia_over_time)
    elif body.inertia is not None:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia.tolist()
        said['inertia'] = {
            'ixx': xx, 'iyy': yy, 'izz': zz, 'ixy': xy, 'ixz': xz, 'iyz': yz,
        }  # fmt: skip
    return said


def _shape(shape: Any, at: tuple[str | int, ...]) -> dict[str, Any]:
    name = type(shape).__name__
    match shape:
        case shapes.Mesh(parts=parts):
            return {'type': 'mesh', 'file': shape.name, **({'as': 'parts'} if parts else {})}
        case shapes.Surface():
            return {'type': 'mesh', 'file': shape.name, 'as': 'triangles'}
        case shapes.ConvexHull():
            return {'type': 'convex_hull', 'vertices': shape.vertices}
        case shapes.Particles():
            pairs = zip(shape.masses.tolist(), shape.positions.tolist(), strict=True)
            return {
                'type': 'particles',
                'particles': [{'mass': mass, 'position': place} for mass, place in pairs],
            }
        case shapes.Union():
            parts = [_part(part, (*at, 'parts', i)) for i, part in enumerate(shape.parts)]
            return {'type': 'union', 'parts': parts}
    return {'type': name.lower(), **_fields(shape)}


def _part(part: shapes.Part, at: tuple[str | int, ...]) -> dict[str, Any]:
    said = {key: value for key, value in _fields(part).items() if key != 'shape'}
    return {'shape': _shape(part.shape, at), **said}


def _fields(record: Any) -> dict[str, Any]:
    """Write the fields of a record that are not as they are by default."""
    return {
        field.name: _plain(getattr(record, field.name))
        for field in dataclasses.fields(record)
        if not _same(getattr(record, field.name), field.default)
    }


def _plain(value: Any) -> Any:
    """Write arrays, tuples and mappings as lists and dicts."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def difference(ours: Any, theirs: Any) -> tuple[str | int, ...] | None:
    """Find where two records first differ, as a path; None where all numbers are the same."""
    if dataclasses.is_dataclass(ours) and not isinstance(ours, type):
        if type(ours) is not type(theirs):
            return None if _both_points(ours, theirs) else ()
        for field in dataclasses.fields(ours):
            if field.name in NOT_COMPARED and isinstance(ours, Scene):
                continue
            place = difference(getattr(ours, field.name), getattr(theirs, field.name))
            if place is not None:
                return (field.name, *place)
        return None
    if isinstance(ours, Mapping) and isinstance(theirs, Mapping):
        if ours.keys() != theirs.keys():
            return ()
        found = ((key, difference(ours[key], theirs[key])) for key in ours)
        return next(((key, *place) for key, place in found if place is not None), None)
    if _is_plain_list(ours) and _is_plain_list(theirs):
        if len(ours) != len(theirs):
            return ()
        for i, (a, b) in enumerate(zip(ours, theirs, strict=True)):
            place = difference(a, b)
            if place is not None:
                return (i, *place)
        return None
    return None if _same(ours, theirs) or _both_points(ours, theirs) else ()


def _both_points(ours: Any, theirs: Any) -> bool:
    """Whether both say that a body is a point: no shape, or that of a particle."""
    return all(shape is None or isinstance(shape, shapes.Particle) for shape in (ours, theirs))


def _is_plain_list(value: object) -> TypeGuard[Sequence[Any]]:
    return isinstance(value, list | tuple)


def _same(a: Any, b: Any) -> bool:
    """Whether two values are the same to the bit; a list of numbers may be an array."""
    if a is b:
        return True
    numeric = (int, float, np.number, np.ndarray, list, tuple)
    if isinstance(a, bool | str) or not (isinstance(a, numeric) and isinstance(b, numeric)):
        return type(a) is type(b) and bool(a == b)
    try:
        x, y = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    except (TypeError, ValueError):
        return type(a) is type(b) and bool(a == b)
    return x.shape == y.shape and (x + 0.0).tobytes() == (y + 0.0).tobytes()
