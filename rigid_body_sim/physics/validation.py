# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether a scene can be simulated: one judge of records made in Python and of scene files.

`load_scene` and `Simulation` ask it. A record judges what it can judge alone when it is made (a
size, an attitude, a table); what concerns several fields or bodies is judged here. What a scene
file cannot say, a record may not hold either. Refusals blame a path in the scene,
('bodies', 3, 'mass').
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel, blaming, choose_from, path_text
from rigid_body_sim.physics.model.finite_energy import (
    LARGEST,
    need_finite_energy,
    need_finite_weight,
    need_square,
)
from rigid_body_sim.physics.model.inertia_over_time import check_inertia_over_time
from rigid_body_sim.physics.model.inertia_tensor import check_inertia
from rigid_body_sim.physics.model.material import MATERIAL, Material
from rigid_body_sim.physics.model.named_frames import check_frame_names
from rigid_body_sim.physics.model.numbers import number, numbers, shown
from rigid_body_sim.physics.model.pivot import check_pivot
from rigid_body_sim.physics.model.place import WORLD
from rigid_body_sim.physics.model.prescribed_motion import check_motion
from rigid_body_sim.physics.model.rotation import IDENTITY
from rigid_body_sim.physics.model.scene import (
    Body,
    Frame,
    InertiaOverTime,
    MassFlow,
    Motion,
    Pivot,
    Scene,
)
from rigid_body_sim.physics.model.shapes import Particle, Plane, Shape, Surface
from rigid_body_sim.physics.model.tick_length import LONGEST_NS
from rigid_body_sim.physics.model.variable_mass import check_flow

NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]*', re.ASCII)
RESERVED = ('world', 'clock')  # the frame of the world and the topic of simulation time
LONGEST_NAME = 100  # [-] letters: with namespace and leaf a topic has at most 255
LONGEST_TITLE = 200  # [-] letters of the name of a scene
UNIT = 1e-9  # [-] how near to one the length of an attitude in a record must be
MOTION = {'position': 'm', 'velocity': 'm/s', 'angular_velocity': 'rad/s'}  # field: unit


def check_scene(scene: Scene) -> None:
    """Refuse a scene that cannot be simulated, by InvalidModel with a path (`at`)."""
    need(scene, Scene, 'a Scene, such as load_scene returns,')
    with blaming('name'):
        check_title(scene.name)
    _check_ticks(scene.dt_ns)
    with blaming('integrator'):
        need(scene.integrator, str, 'the name of an integrator')
    with blaming('integrator_options'):
        need(scene.integrator_options, Mapping, 'a mapping of options by name')
    with blaming('gravity'):
        need_square(math.hypot(*numbers(scene.gravity, 3, unit='m/s^2')), unit='m/s^2')
    with blaming('contact'):
        _check_contact(scene.contact)
    names = _check_bodies(scene)
    for i, body in enumerate(scene.bodies):
        if not body.fixed:
            with blaming('bodies', i, 'mass'):
                need_finite_weight(float(body.mass), scene.gravity, body.initial.position)
    with blaming('contact'):
        _check_pair_rules(scene.contact, names)
    with blaming('forces'):
        need(scene.forces, list | tuple, 'a tuple of force elements')
    for i, force in enumerate(scene.forces):
        with blaming('forces', i):
            _check_force(force, names)


def check_record(scene: Scene) -> None:
    """Refuse a scene that cannot be simulated, with the path in the message too."""
    with placing():
        check_scene(scene)


@contextmanager
def placing() -> Iterator[None]:
    """Write into the refusals inside what they blame, as a path."""
    try:
        yield
    except InvalidModel as error:
        place, said = path_text(error.at), str(error)
        whole = said if not place or said.startswith(place) else f'{place}: {said}'
        raise InvalidModel(whole, at=error.at) from None


def check_name(name: object, *, of: str = 'body') -> None:
    """
    Refuse what is no name of a body in a scene file: it becomes part of names of topics.

    of : what it names
    """
    if not isinstance(name, str) or not NAME.fullmatch(name) or '__' in name:
        raise InvalidModel(
            f'got {shown(name)}; a {of} name is a letter, '
            'then letters, digits and single underscores'
        )
    if len(name) > LONGEST_NAME:
        raise InvalidModel(
            f'got {shown(name)}, {len(name)} letters; a {of} name has at most {LONGEST_NAME}'
        )
    if name in RESERVED:
        raise InvalidModel(_reserved(name))


def _reserved(name: str) -> str:
    return f'{name!r} is a reserved name ({", ".join(RESERVED)}); choose another'


def check_title(name: object) -> None:
    """Refuse what is no name of a scene, nor of a body without topics: one line of text."""
    if not isinstance(name, str) or not name:
        raise InvalidModel(f'got {shown(name)}; a name is needed, as text')
    if len(name) > LONGEST_TITLE or not name.isprintable():
        raise InvalidModel(
            f'got {shown(name)}; a name is one line of at most {LONGEST_TITLE} printable letters'
        )


def check_body(body: Body, *, sound: set[bytes]) -> None:
    """
    Refuse a body that no physics can honour.

    sound : inertia tensors that were judged before; its own is added
    """
    need(body, Body, 'a Body')
    with blaming('name'):
        check_title(body.name)
        if body.name in RESERVED:
            raise InvalidModel(_reserved(body.name))
    if body.shape is not None:
        with blaming('shape'):
            need(body.shape, Shape, 'a shape')
    with blaming('fixed'):
        need(body.fixed, bool | np.bool_, 'True or False')
        if isinstance(body.shape, Plane) and not body.fixed:
            raise InvalidModel('a plane is always fixed; set fixed to True')
        if isinstance(body.shape, Surface) and not body.fixed:
            raise InvalidModel(
                'triangles and height fields are ground, which is fixed; set fixed to True, or '
                'take a mesh that collides as its hull, or a union of convex shapes'
            )
    with blaming('mass'):
        check_mass(body)
    _check_places(body)
    with blaming('inertia'):
        _check_inertia(body, sound)
    with blaming('initial'):
        _check_motion(body)
    with blaming('material'):
        _check_material(body.material)
    if body.mass_flow is not None:
        with blaming('mass_flow'):
            _check_flow(body, body.mass_flow)
    if body.inertia_over_time is not None:
        with blaming('inertia_over_time'):
            _check_inertia_over_time(body, body.inertia_over_time)
    with blaming('frames'):
        check_frames(body)
    with blaming('motion'):
        check_motion(body)
    with blaming('surface_velocity'):
        numbers(body.surface_velocity, 3, unit='m/s')
        if any(body.surface_velocity) and not body.fixed:
            raise InvalidModel(
                f'{body.name!r} is not fixed; the surface of a fixed body alone may have a '
                'velocity of its own: set fixed, or remove surface_velocity'
            )


def check_frames(body: Body) -> None:
    """Refuse frames that the body cannot have."""
    need(body.frames, Mapping, 'a mapping of names to frames')
    if body.frames and body.is_point:
        raise InvalidModel(
            f'{body.name!r} is a point mass and has no axes to which a frame could be fixed; '
            'remove frames, or give it a shape with extent'
        )
    for name, frame in body.frames.items():
        check_name(name, of='frame')
        with blaming(name):
            need(frame, Frame, 'a Frame')
            with blaming('position'):
                numbers(frame.position, 3, unit='m')
            with blaming('orientation'):
                _check_attitude(frame.orientation)


def check_mass(body: Body) -> None:
    """Refuse a mass that the body cannot have: zero is for fixed bodies."""
    mass = number(body.mass, unit='kg')
    if body.fixed and mass == 0.0:
        return
    if not (mass > 0.0 and math.isfinite(1.0 / mass)):
        raise InvalidModel(
            f'mass is {mass} kg; it must be positive and finite, and so must be its inverse'
        )


def need(value: object, kind: Any, what: str) -> None:
    """Refuse what is not of a kind."""
    if not isinstance(value, kind):
        raise InvalidModel(f'got {shown(value)}; {what} is needed')


def _check_ticks(dt_ns: Any) -> None:
    is_whole = isinstance(dt_ns, int | np.integer) and not isinstance(dt_ns, bool)
    if not is_whole or not 1 <= dt_ns <= LONGEST_NS:
        raise InvalidModel(
            f'got {shown(dt_ns)}; a whole number of nanoseconds from 1 to {LONGEST_NS} is needed',
            at=('dt_ns',),
        )


def _check_contact(contact: Any) -> None:
    need(contact, Mapping, "a mapping such as {'mode': 'timestep'}")
    if contact.get('mode', 'none') != 'none':
        from rigid_body_sim.physics.contact.settings import ContactSettings

        ContactSettings.of(contact)
    elif set(contact) - {'mode'}:
        raise InvalidModel(f"got {shown(dict(contact))}; without contact there is only 'mode'")


def _check_pair_rules(contact: Mapping[str, Any], names: Collection[str]) -> None:
    if contact.get('ignore') or contact.get('pairs'):
        from rigid_body_sim.physics.contact.pair_rules import pair_rules

        pair_rules(contact, [*names])


def _check_bodies(scene: Scene) -> Collection[str]:
    with blaming('bodies'):
        need(scene.bodies, list | tuple, 'a tuple of bodies')
        if not scene.bodies:
            raise InvalidModel('there are none; a scene needs at least one body')
    names: dict[str, None] = {}
    sound: set[bytes] = set()  # inertia tensors: copies of a body have the same one
    for i, body in enumerate(scene.bodies):
        with blaming('bodies', i):
            check_body(body, sound=sound)
            if body.name in names:
                raise InvalidModel(
                    f'the name {body.name!r} is taken by an earlier body; names must differ',
                    at=('name',),
                )
            if body.pivot is not None:
                with blaming('pivot'):
                    _check_pivot(body)
        names[body.name] = None
    for i, body in enumerate(scene.bodies):
        if body.frames:
            with blaming('bodies', i, 'frames'):
                check_frame_names(body, names)
    return names


def _check_places(body: Body) -> None:
    for field in ('center_of_mass', 'shape_position'):
        with blaming(field):
            numbers(getattr(body, field), 3, unit='m')
    if isinstance(body.shape, Particle) and any(body.center_of_mass):
        raise InvalidModel(
            f'got {shown(body.center_of_mass)}; a particle is a point mass: leave it out',
            at=('center_of_mass',),
        )
    with blaming('shape_orientation'):
        _check_attitude(body.shape_orientation)


def _check_attitude(orientation: Any) -> None:
    length = math.hypot(*numbers(orientation, 4, unit='-'))
    if not abs(length - 1.0) <= UNIT:
        raise InvalidModel(
            f'got {shown(orientation)} of length {length:.9g}; a quaternion xyzw of length 1 is '
            'needed: divide it by its length'
        )


def _check_inertia(body: Body, sound: set[bytes]) -> None:
    has_extent = body.shape is not None and not isinstance(body.shape, Particle)
    if body.inertia is None:
        if has_extent and not body.fixed:
            raise InvalidModel(
                f'none is given, and {body.name!r} has a shape with extent: give '
                'physics.model.mass_properties.of_shape(shape, mass=…).inertia, or let '
                'rigid_body_sim.make_body or load_scene compute it; a point mass has the shape '
                'Particle() or None'
            )
        return
    if isinstance(body.shape, Particle):
        raise InvalidModel('a particle is a point mass and does not rotate; leave it out')
    if type(body.inertia) is not np.ndarray or body.inertia.dtype.kind not in 'iuf':
        raise InvalidModel(f'got {shown(body.inertia)}; a (3, 3) array of numbers is needed')
    if body.inertia.shape != (3, 3) or body.inertia.tobytes() not in sound:
        check_inertia(body.inertia)
        sound.add(body.inertia.tobytes())


def _check_motion(body: Body) -> None:
    motion = body.initial
    need(motion, Motion, 'a Motion')
    for field, unit in MOTION.items():
        with blaming(field):
            numbers(getattr(motion, field), 3, unit=unit)
    with blaming('orientation'):
        _check_attitude(motion.orientation)
    if not body.fixed:
        _check_momenta(body)
    _check_energies(body)
    if body.fixed and body.motion is None and any((*motion.velocity, *motion.angular_velocity)):
        raise InvalidModel('a fixed body does not move; remove its velocities, or fixed')
    if body.is_point and (any(motion.angular_velocity) or motion.orientation != IDENTITY):
        raise InvalidModel(
            f'{body.name!r} is a point mass and does not rotate; remove orientation and '
            'angular_velocity, or give it a shape and an inertia'
        )


def _check_momenta(body: Body) -> None:
    """Refuse a motion whose momentum is beyond the largest number."""
    momenta = [float(body.mass) * v for v in map(float, body.initial.velocity)]
    if body.inertia is not None and any(body.initial.angular_velocity):
        x, y, z = map(float, body.initial.angular_velocity)
        momenta += [a * x + b * y + c * z for a, b, c in body.inertia.tolist()]
    if not all(map(math.isfinite, momenta)):
        raise InvalidModel(
            'the momentum, mass times velocity, is beyond the largest number; check the units '
            '(m, kg, s)'
        )


def _check_energies(body: Body) -> None:
    """Refuse a place or a motion whose energy is no number."""
    mass = 0.0 if body.fixed else float(body.mass)
    moment = 0.0 if body.fixed or body.inertia is None else sum(np.diag(body.inertia).tolist())
    motion = body.initial
    size = math.hypot(*motion.position, *motion.velocity, *motion.angular_velocity)
    if size * max(1.0, mass, moment) <= LARGEST:  # as a rule
        return
    for field, unit, weight in (
        ('position', 'm', mass),
        ('velocity', 'm/s', mass),
        ('angular_velocity', 'rad/s', moment),
    ):
        with blaming(field):
            values = list(map(float, getattr(body.initial, field)))
            need_finite_energy(f'the {field}'.replace('_', ' '), values, unit=unit, weight=weight)


def _check_material(material: Any) -> None:
    need(material, Material, 'a Material')
    for field, known in MATERIAL.items():
        with blaming(field):
            given = getattr(material, field)
            number(given, unit=known.unit, minimum=known.least, maximum=known.most)


def _check_flow(body: Body, flow: Any) -> None:
    need(flow, MassFlow, 'a MassFlow')
    with blaming('rate'):
        number(flow.rate, unit='kg/s')
    with blaming('exhaust_velocity'):
        numbers(flow.exhaust_velocity, 3, unit='m/s')
    if flow.final_mass is not None:
        with blaming('final_mass'):
            number(flow.final_mass, unit='kg')
    check_flow(body)


def _check_inertia_over_time(body: Body, law: Any) -> None:
    need(law, InertiaOverTime, 'an InertiaOverTime')
    with blaming('table'):
        need(law.table, list | tuple, 'a tuple of rows')
        for row in law.table:
            numbers(row, 4, unit='s, kg m^2')
    check_inertia_over_time(body)


def _check_pivot(body: Body) -> None:
    need(body.pivot, Pivot, 'a Pivot')
    assert body.pivot is not None
    for field in ('point', 'at'):
        with blaming(field):
            numbers(getattr(body.pivot, field), 3, unit='m')
    check_pivot(body)


def _check_force(force: Any, names: Collection[str]) -> None:
    """Judge a force element by what its fields say of themselves (`forces.element.key`)."""
    is_record = dataclasses.is_dataclass(force) and not isinstance(force, type)
    fields = dataclasses.fields(force) if is_record else ()
    if not fields or not all('kind' in field.metadata for field in fields):
        raise InvalidModel(f'got {shown(force)}; a force element is needed, such as a Spring')
    for field in fields:
        value, known = getattr(force, field.name), field.metadata
        if value is None and field.default is None:
            continue
        with blaming(field.name):
            _check_setting(value, known, names)


def _check_setting(value: Any, known: Mapping[str, Any], names: Collection[str]) -> None:
    kind, unit = known['kind'], known.get('unit') or '-'
    if kind in ('body', 'body_or_world', 'bodies'):
        if kind == 'bodies':
            need(value, list | tuple, 'a tuple of names of bodies')
        for name in value if kind == 'bodies' else (value,):
            is_world = kind == 'body_or_world' and isinstance(name, str) and name == WORLD
            if not is_world and (not isinstance(name, str) or name not in names):
                allowed = [*names, WORLD] if kind == 'body_or_world' else names
                raise InvalidModel(f'body {shown(name)} is unknown{choose_from(name, allowed)}')
    elif kind == 'choice':
        if not isinstance(value, str) or value not in known['choices']:
            raise InvalidModel(f'got {shown(value)}{choose_from(value, known["choices"])}')
    elif kind in ('point', 'vector'):
        need_square(math.hypot(*numbers(value, 3, unit=unit)), unit=unit)
    elif kind == 'number':
        need_square(abs(number(value, unit=unit, minimum=known.get('minimum'))), unit=unit)
        if known.get('positive') and value <= 0:
            raise InvalidModel(f'got {shown(value)}; a positive number [{unit}] is needed')
