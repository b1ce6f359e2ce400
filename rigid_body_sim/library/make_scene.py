# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A scene in Python that reads as one in YAML.

    box = make_body('box', Box((0.4, 0.2, 0.1)), mass=2, position=(0, 0, 1))
    ball = make_body('ball', Particle(), mass=0.5, position=(1, 0, 0))
    spring = Spring('ball', 'world', b_point=(1, 0, 1), stiffness=50, rest_length=0.8)
    scene = make_scene([box, ball], [spring], dt=1e-3, gravity=(0, 0, -9.81))

What comes out are the records that `load_scene` makes (`physics.model.scene`), judged by the same
validator; `dataclasses.replace` varies them. Words and units are those of a scene file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.model import mass_properties, rotation
from rigid_body_sim.physics.model.numbers import array_of_numbers, number, numbers, shown
from rigid_body_sim.physics.model.pivot import check_given
from rigid_body_sim.physics.model.scene import (
    Body,
    Frame,
    MassFlow,
    Material,
    Motion,
    Pivot,
    PrescribedMotion,
    Scene,
    Vector,
)
from rigid_body_sim.physics.model.shapes import Particle, Plane, Shape, Surface
from rigid_body_sim.physics.model.tick_length import tick_nanoseconds
from rigid_body_sim.physics.validation import check_scene, need, placing

NOWHERE: Vector = (0.0, 0.0, 0.0)


def make_body(
    name: str,
    shape: Shape | None = None,
    *,
    mass: float | None = None,
    density: float | None = None,
    inertia: ArrayLike | None = None,
    center_of_mass: Sequence[float] | None = None,
    position: Sequence[float] = NOWHERE,
    orientation: Sequence[float] = rotation.IDENTITY,
    velocity: Sequence[float] = NOWHERE,
    angular_velocity: Sequence[float] | None = None,
    angular_velocity_body: Sequence[float] | None = None,
    fixed: bool = False,
    restitution: float = Material.restitution,
    friction: float = Material.friction,
    rolling_friction: float = Material.rolling_friction,
    torsional_friction: float = Material.torsional_friction,
    frames: Mapping[str, Frame] | None = None,
    pivot: Pivot | None = None,
    mass_flow: MassFlow | None = None,
    motion: PrescribedMotion | None = None,
    surface_velocity: Sequence[float] = NOWHERE,
) -> Body:
    """
    Make a body; its mass properties come from its shape, as those of a scene file do. Its keywords
    are the keys of a body there, one for one, so there are as many; each may be left out.

    shape   : None with an inertia: a body that is not drawn; None without: a point mass
    mass, density : [kg], [kg/m^3]  one of them; neither for a plane, fixed bodies, and shapes that
              say their own
    inertia : [kg m^2]  (3, 3), or the three principal moments (3,), about the centre of mass, body
              axes, in place of that of the shape
    center_of_mass : (3,) [m]  body coordinates, in place of that of the shape
    position, velocity  : (3,) [m], [m/s]  of the centre of mass, world
    orientation         : (4,) [-]  quaternion xyzw of any length but zero, body to world
    angular_velocity, angular_velocity_body : (3,) [rad/s]  one of them: world axes, body axes
    frames  : axes fixed to the body, by name, in which commands may be given
    pivot   : the point about which it turns; then position and velocity follow from it
    motion  : how it is moved, whatever acts; then it is fixed for all that acts

    Raises InvalidModel for what no physics can honour; the rest is judged with the scene.
    """
    with _of_body(name):
        with blaming('fixed'):
            need(fixed, bool | np.bool_, 'True or False')
        held = bool(fixed) or motion is not None or isinstance(shape, Plane)
        body = Body(name, shape, mass=0.0, fixed=held, motion=motion, mass_flow=mass_flow)
        body = _with_mass(body, mass=mass, density=density, inertia=inertia)
        if center_of_mass is not None:
            body = replace(body, center_of_mass=_vector('center_of_mass', center_of_mass, 'm'))
        initial = Motion(
            position=_vector('position', position, 'm'),
            orientation=orientation,  # type: ignore[arg-type]  # which the record judges
            velocity=_vector('velocity', velocity, 'm/s'),
        )
        spin = _spin(initial, angular_velocity, angular_velocity_body)
        body = replace(
            body,
            initial=replace(initial, angular_velocity=spin),
            material=Material(restitution, friction, rolling_friction, torsional_friction),
            frames={} if frames is None else frames,
            surface_velocity=_vector('surface_velocity', surface_velocity, 'm/s'),
        )
        if pivot is None:
            return body
        return _on_pivot(
            body, pivot, placed=position is not NOWHERE, moving=velocity is not NOWHERE
        )


def make_scene(
    bodies: Sequence[Body],
    forces: Sequence[Any] = (),
    *,
    dt: float = 0.001,
    name: str = 'scene',
    gravity: Sequence[float] = NOWHERE,
    integrator: str | Mapping[str, Any] = Scene.integrator,
    integrator_options: Mapping[str, Any] | None = None,
    contact: Mapping[str, Any] | None = None,
) -> Scene:
    """
    Make a scene of bodies and forces, and judge it.

    bodies  : of `make_body`, or records of your own
    forces  : Spring, Drag, Constant, TimeTable, Bumper, Gravity
    dt      : [s] tick length, a whole number of nanoseconds
    gravity : (3,) [m/s^2] world
    integrator : its name, or with its options: {'name': 'rk45', 'rtol': 1e-9}
    contact : such as {'mode': 'timestep'}; None: bodies pass through each other

    Raises InvalidModel with the path of what is wrong.
    """
    from rigid_body_sim.physics.integration.choose import check_method, name_and_options  # slow

    with placing():
        method, options = name_and_options(integrator, integrator_options)
        options = {} if options is None else options
        check_method(method, options)
        with blaming('dt'):
            dt_ns = tick_nanoseconds(dt)
        scene = Scene(
            name=name,
            dt_ns=dt_ns,
            bodies=_all_of('bodies', bodies, 'bodies, such as make_body returns'),
            integrator=method,
            integrator_options=options,
            gravity=_vector('gravity', gravity, 'm/s^2'),
            forces=_all_of('forces', forces, 'force elements, such as a Spring'),
            contact={'mode': 'none'} if contact is None else contact,
        )
        check_scene(scene)
    return scene


@contextmanager
def _of_body(name: object) -> Iterator[None]:
    """Say of refusals inside which body is meant, and what of it."""
    try:
        with placing():
            yield
    except InvalidModel as error:
        raise InvalidModel(f'body {shown(name)}: {error}', at=error.at) from None


def _all_of(what: str, given: Any, wanted: str) -> tuple[Any, ...]:
    """Return the elements of a list, a tuple or whatever else has some in an order."""
    if not isinstance(given, Iterable) or isinstance(given, str | bytes | Mapping | Set):
        raise InvalidModel(f'got {shown(given)}; a list of {wanted}, is needed', at=(what,))
    return tuple(given)


def _vector(what: str, values: Any, unit: str) -> Vector:
    given = values.tolist() if isinstance(values, np.ndarray) else values
    with blaming(what):
        x, y, z = numbers(given, 3, unit=unit)
    return (x, y, z)


def _spin(
    initial: Motion, in_world: Sequence[float] | None, in_body: Sequence[float] | None
) -> Vector:
    """Return the angular velocity in world axes."""
    if in_world is not None and in_body is not None:
        raise InvalidModel('give angular_velocity or angular_velocity_body, and not both')
    if in_body is None:
        return NOWHERE if in_world is None else _vector('angular_velocity', in_world, 'rad/s')
    spin = _vector('angular_velocity_body', in_body, 'rad/s')
    x, y, z = rotation.rotate(initial.orientation, spin).tolist()
    return (x, y, z)


def _with_mass(
    body: Body, *, mass: float | None, density: float | None, inertia: ArrayLike | None
) -> Body:
    if isinstance(body.shape, Plane | Surface):
        if mass is not None or density is not None or inertia is not None:
            raise InvalidModel('it is ground and has no mass; leave it out', at=('mass',))
        return body
    tensor = None if inertia is None else _tensor(inertia)
    if mass is not None:
        with blaming('mass'):
            mass = number(mass, unit='kg')
    if body.shape is None:
        if density is not None:
            raise InvalidModel('it has no shape, so no density; give its mass [kg]', at=('mass',))
        with blaming('mass'):
            kilograms = 0.0 if mass is None and body.fixed else number(mass, unit='kg')
        return replace(body, mass=kilograms, inertia=tensor)
    with blaming('shape'):
        need(body.shape, Shape, 'a shape, such as Box((0.4, 0.2, 0.1)),')
    if body.fixed and not mass and density is None:  # 0 kg is that of what has none
        if isinstance(body.shape, Particle):
            return replace(body, inertia=tensor)
        own = mass_properties.states_its_mass(body.shape)
        of = mass_properties.of_shape(body.shape, density=None if own else 1.0)
        center = _vector('center_of_mass', of.center_of_mass, 'm')
        return replace(body, center_of_mass=center, inertia=tensor)
    of = mass_properties.of_shape(body.shape, mass=mass, density=density)
    body = replace(
        body, mass=of.mass, center_of_mass=_vector('center_of_mass', of.center_of_mass, 'm')
    )
    if isinstance(body.shape, Particle):
        return body if tensor is None else replace(body, inertia=tensor)
    return replace(body, inertia=of.inertia if tensor is None else tensor)


def _tensor(inertia: ArrayLike) -> np.ndarray:
    tensor = array_of_numbers(inertia)
    if tensor is not None and tensor.shape == (3,):
        return np.diag(tensor)
    if tensor is None or tensor.shape != (3, 3):
        got = shown(inertia) if tensor is None else f'the shape {tensor.shape}'
        raise InvalidModel(
            f'got {got}; numbers (3, 3), or three principal moments, [kg m^2] are needed',
            at=('inertia',),
        )
    return tensor


def _on_pivot(body: Body, pivot: Pivot, *, placed: bool, moving: bool) -> Body:
    """
    Return the body turning about its pivot: position and velocity follow.

    placed, moving : whether a position, a velocity was given, which then must be that
    """
    with blaming('pivot'):
        need(pivot, Pivot, 'a Pivot')
        point, at = (_vector(key, getattr(pivot, key), 'm') for key in ('point', 'at'))
    arm = np.subtract(body.center_of_mass, point)
    turned = rotation.rotate(body.initial.orientation, arm)
    position = _vector('position', np.add(at, turned), 'm')
    velocity = _vector('velocity', np.cross(body.initial.angular_velocity, turned), 'm/s')
    given = body.initial
    if placed:
        why = 'the pivot is at `at`'
        check_given(given.position, position, what='position', unit='m', why=why)
    if moving:
        why = 'it is angular_velocity x arm'
        check_given(given.velocity, velocity, what='velocity', unit='m/s', why=why)
    return replace(body, pivot=pivot, initial=replace(given, position=position, velocity=velocity))
