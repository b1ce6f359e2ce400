# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read one body: name, shape, mass properties, initial motion, contact material.

`inertia` is the tensor about the centre of mass in body axes: its keys are the elements of the
tensor, so ixy is minus the integral of x y dm. `inertia` and `center_of_mass` replace what the
shape gives, each on its own: a `center_of_mass` alone moves the centre and keeps the tensor that
the shape has about its own, not shifted; where `mass` is given beside both, nothing is asked of
the shape, and a mesh may be open. `density` is a number, or a law over space
(`scene/densities.py`). `mass_rate` (negative: loses) with `exhaust_velocity` and `final_mass` make
a rocket: `exhaust_velocity` is that of the leaving mass relative to the body, three numbers in
body axes (world axes for a particle), or its speed alone when it leaves along -z.

`frames` names axes fixed to the body, in which commands may be given: their origins are told from
the centre of mass, in body axes (`physics/model/named_frames.py`).

`urdf` names a file that says shape and mass properties in their place (`scene/urdf.py`).
Contact material: `restitution` and `friction` are numbers, `rolling_friction` and
`torsional_friction` lengths [m].
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import mass_properties, rotation
from rigid_body_sim.physics.model.inertia_over_time import inertia_at_start
from rigid_body_sim.physics.model.mass_properties import MassProperties
from rigid_body_sim.physics.model.prescribed_motion import check_motion
from rigid_body_sim.physics.model.scene import (
    Body,
    Frame,
    MassFlow,
    Material,
    Motion,
    Quaternion,
    Vector,
)
from rigid_body_sim.physics.model.shapes import (
    Particle,
    Particles,
    Plane,
    Shape,
    Surface,
    Union,
)
from rigid_body_sim.physics.model.variable_mass import check_flow
from rigid_body_sim.physics.validation import check_name
from rigid_body_sim.scene.densities import read_density
from rigid_body_sim.scene.files import Files
from rigid_body_sim.scene.grammar import (
    BODY,
    FLOW,
    FRAME,
    INERTIA,
    INITIAL,
    MASS,
    SAID_BY_URDF,
    SPINS,
)
from rigid_body_sim.scene.inertia_over_time import read_inertia_over_time
from rigid_body_sim.scene.material import read_material
from rigid_body_sim.scene.motions import read_motion
from rigid_body_sim.scene.pivots import with_pivot
from rigid_body_sim.scene.repeat import repeated
from rigid_body_sim.scene.shapes import read_shape
from rigid_body_sim.scene.urdf import read_link
from rigid_body_sim.scene.values import Value, shown

SUMS = (Particle, Particles, Union)  # shapes whose parts have masses of their own
MOMENTS = ('ixx', 'iyy', 'izz')
PRODUCTS = ('ixy', 'ixz', 'iyz')


def read_bodies(value: Value, files: Files) -> tuple[Body, ...]:
    """Return one checked body, or as many as `repeat` asks for."""
    value.need_mapping('a mapping such as {name: box, shape: …, mass: 1.0}')
    name = _name(value.at('name', what='a name of letters, digits and single underscores'))
    value.need_known(BODY.keys)
    urdf, repeat = value.find('urdf'), value.find('repeat')
    body = _of_scene(name, value, files) if urdf is None else _of_urdf(name, value, urdf, files)
    initial, pivot = value.find('initial'), value.find('pivot')
    told = value.find('motion')
    held = body.fixed and told is None
    motion = _motion(initial, is_particle=isinstance(body.shape, Particle), fixed=held)
    body = _changed(
        body,
        initial=motion,
        material=Material(**read_material(value)),
        mass_flow=_mass_flow(value),
    )
    if body.mass_flow is not None:
        with (value.find('final_mass') or value.find('mass_rate') or value).blamed():
            check_flow(body)
    if told is not None:
        body = _changed(body, motion=read_motion(told))
        with told.blamed():
            check_motion(body)
    speed, frames = value.find('surface_velocity'), value.find('frames')
    if speed is not None:
        body = _changed(body, surface_velocity=speed.vector(unit='m/s'))
    if frames is not None:
        body = _changed(body, frames=_frames(frames))
    body = with_pivot(body, pivot, initial)
    if repeat is None:
        return (body,)
    if pivot is not None:
        raise pivot.error('copies of a body cannot share a pivot; remove pivot, or repeat')
    return repeated(body, repeat)


def _changed(body: Body, **fields: Any) -> Body:
    """Do what `dataclasses.replace` does, four times as fast: each body of a scene needs it."""
    return Body(**{**vars(body), **fields})


def _of_scene(name: str, value: Value, files: Files) -> Body:
    """Return a body whose shape and mass properties stand in the scene."""
    shape_value = value.find('shape')
    shape = None if shape_value is None else read_shape(shape_value, files)
    return _with_mass(Body(name=name, shape=shape, mass=0.0, fixed=_fixed(value, shape)), value)


def _of_urdf(name: str, value: Value, urdf: Value, files: Files) -> Body:
    """Return a body whose shape and mass properties stand in a URDF file."""
    for key in SAID_BY_URDF:
        given = value.find(key)
        if given is not None:
            raise given.error('the URDF file says what the body is; remove this key, or urdf')
    with urdf.blamed():
        link = read_link(files, urdf.text('the path of a URDF file'))
        body = Body(
            name=name,
            shape=link.shape,
            mass=link.mass or 0.0,
            center_of_mass=link.center_of_mass,
            inertia=link.inertia,
            fixed=_fixed(value, None),
            shape_position=link.shape_position,
            shape_orientation=link.shape_orientation,
        )
        if link.mass is None:
            if not body.fixed:
                raise InvalidModel(
                    f'{urdf.content}: <link name={shown(link.name)}> has no <inertial>, and '
                    'none is '
                    'made up; give it one, or make the body fixed: true'
                )
            x, y, z = np.array(link.shape_position) + rotation.rotate(
                link.shape_orientation, _center_of_fixed(link.shape, value)
            )
            body = _changed(body, center_of_mass=(float(x), float(y), float(z)))
    return body


def _name(value: Value) -> str:
    name = value.text('a name')
    with value.blamed():
        check_name(name)
    return name


def _fixed(value: Value, shape: Shape | None) -> bool:
    given = value.find('fixed')
    if value.find('motion') is not None:
        if given is not None:
            raise given.error('a body with motion moves as told, whatever acts; remove this key')
        return True
    fixed = isinstance(shape, Plane) if given is None else given.truth()
    if given is not None and isinstance(shape, Plane) and not fixed:
        raise given.error('a plane is always fixed; remove this key or set it to true')
    if isinstance(shape, Surface) and not fixed:
        blamed = value.at('shape', what='a mapping with a type') if given is None else given
        raise blamed.error(
            'triangles and height fields are ground, which is fixed; write fixed: true, or take '
            'a mesh that collides as its hull (without `as`), or a union of convex shapes'
        )
    return fixed


def _with_mass(body: Body, value: Value) -> Body:
    """Return the body with mass, centre of mass and inertia."""
    if isinstance(body.shape, Plane):
        for key in MASS:
            given = value.find(key)
            if given is not None:
                raise given.error('a plane is static and has no mass; remove this key')
        return body
    if isinstance(body.shape, Surface):
        for key in MASS:
            given = value.find(key)
            if given is not None:
                raise given.error('ground of triangles has no mass; remove this key')
        return body
    mass = _optional(value, 'mass', 'kg')
    density_value = value.find('density')
    varying = density_value is not None and isinstance(density_value.content, dict)
    density = None if varying else _optional(value, 'density', 'kg/m^3')
    inertia_value, center_value = value.find('inertia'), value.find('center_of_mass')
    if isinstance(body.shape, Particle):
        for given in (inertia_value, center_value):
            if given is not None:
                raise given.error(
                    'a particle is a point mass and does not rotate; remove this key, or the shape'
                )
    inertia = None if inertia_value is None else _inertia(inertia_value)
    over_time = value.find('inertia_over_time')
    if over_time is not None:
        if inertia_value is not None or isinstance(body.shape, Particle):
            raise over_time.error(
                'it says the inertia of a body that turns; remove inertia, or it'
            )
        body = _changed(body, inertia_over_time=read_inertia_over_time(over_time))
        inertia_value, inertia = over_time, inertia_at_start(body)
    center = None if center_value is None else center_value.vector(unit='m')
    if body.fixed and not mass and density_value is None:  # 0 kg is that of what has none
        return _changed(
            body, center_of_mass=center or _center_of_fixed(body.shape, value), inertia=inertia
        )
    if varying:
        assert density_value is not None
        with value.blamed('density'):
            properties = _of_varying_density(body.shape, density_value, mass=mass)
    else:
        properties = _properties(
            body,
            mass=mass,
            density=density,
            stated=inertia is not None,
            whole=None not in (mass, inertia_value, center_value),
            value=value,
        )
    x, y, z = properties.center_of_mass
    if inertia is None and not (body.shape is None or isinstance(body.shape, Particle)):
        inertia = properties.inertia
        with (value.find('shape') or value).blamed():
            mass_properties.check_inertia(inertia)
    return _changed(
        body,
        mass=properties.mass,
        center_of_mass=center or (float(x), float(y), float(z)),
        inertia=inertia,
    )


def _properties(
    body: Body,
    *,
    mass: float | None,
    density: float | None,
    stated: bool,
    whole: bool,
    value: Value,
) -> MassProperties:
    """
    Return what the shape gives; a body without a shape has its mass and a stated inertia.

    stated, whole : inertia is given; mass, inertia and centre of mass are: then nothing is asked
                    of the shape, whose surface may be open
    """
    shape = body.shape
    if shape is None:
        if not (stated or body.fixed):
            raise value.error(
                'shape is missing; give one ({type: particle} is a point mass), or an inertia'
            )
        if density is not None:
            raise value.error(
                'a body without a shape has no volume; give its mass [kg] in place of density'
            )
        shape = Particle()
    elif mass is None and density is None and not isinstance(shape, SUMS):
        raise value.error('mass is missing; mass [kg] or density [kg/m^3] is needed')
    if mass is None and density is None and isinstance(shape, Particle):
        raise value.error('mass is missing; mass [kg] is needed')
    if whole and density is None and not mass_properties.states_its_mass(shape):
        shape = Particle()
    with value.blamed():
        return mass_properties.of_shape(shape, mass=mass, density=density)


def _of_varying_density(
    shape: Shape | None, value: Value, *, mass: float | None
) -> MassProperties:
    """Return the mass properties for a density that varies over the shape."""
    law = read_density(value)
    if shape is None or mass is not None:
        raise value.error(
            'a density that varies needs a shape and gives its mass; remove mass, or give a shape'
        )
    with np.errstate(all='ignore'):  # what overflows is refused by name
        return law.of(shape)


def _center_of_fixed(shape: Shape | None, value: Value) -> Vector:
    """Return the centre of a fixed body without mass: only its shape says where it is."""
    if shape is None or isinstance(shape, Particle):
        return (0.0, 0.0, 0.0)
    with (value.find('shape') or value).blamed():
        density = None if isinstance(shape, Particles) else 1.0
        x, y, z = mass_properties.of_shape(shape, density=density).center_of_mass
    return float(x), float(y), float(z)


def _inertia(value: Value) -> NDArray[np.float64]:
    value.need_mapping('a mapping {ixx: , iyy: , izz: } [kg m^2]')
    value.need_known(INERTIA.keys)
    xx, yy, zz = (
        value.at(key, what='a moment of inertia [kg m^2]').number(unit='kg m^2') for key in MOMENTS
    )
    xy, xz, yz = (_optional(value, key, 'kg m^2') or 0.0 for key in PRODUCTS)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    with value.blamed():
        mass_properties.check_inertia(inertia)
    return inertia


def _motion(value: Value | None, *, is_particle: bool, fixed: bool) -> Motion:
    if value is None:
        return Motion()
    value.need_mapping('a mapping such as {position: [0, 0, 1]}')
    value.need_known(INITIAL.keys)
    for key in ('orientation', *SPINS):
        given = value.find(key)
        if given is not None and is_particle:
            raise given.error('a particle is a point mass and does not rotate; remove this key')
    given = value.find('orientation')
    orientation = rotation.IDENTITY if given is None else given.quaternion()
    motion = Motion(
        position=_vector(value, 'position', 'm'),
        orientation=orientation,
        velocity=_vector(value, 'velocity', 'm/s'),
        angular_velocity=_angular_velocity(value, orientation),
    )
    if fixed and any((*motion.velocity, *motion.angular_velocity)):
        raise value.error('a fixed body does not move; remove its velocities, or fixed')
    return motion


def _frames(value: Value) -> dict[str, Frame]:
    value.need_mapping('a mapping such as {left_thruster: {position: [0, 0.2, 0]}}')
    frames = {}
    for name in value.content:
        with value.blamed():
            check_name(name, of='frame')
        given = value.find(name)
        if given is None:
            frames[name] = Frame()
            continue
        given.need_mapping('a mapping such as {position: [0, 0.2, 0]}')
        given.need_known(FRAME.keys)
        attitude = given.find('orientation')
        frames[name] = Frame(
            position=_vector(given, 'position', 'm'),
            orientation=rotation.IDENTITY if attitude is None else attitude.quaternion(),
        )
    return frames


def _angular_velocity(value: Value, orientation: Quaternion) -> Vector:
    in_body = value.find('angular_velocity_body')
    if in_body is None:
        return _vector(value, 'angular_velocity', 'rad/s')
    if value.find('angular_velocity') is not None:
        raise in_body.error('angular_velocity is given too; keep one of the two')
    x, y, z = rotation.rotate(orientation, in_body.vector(unit='rad/s'))
    return float(x), float(y), float(z)


def _mass_flow(value: Value) -> MassFlow | None:
    """Return the flow of mass; given by its speed alone it leaves along -z and pushes along +z."""
    rate, exhaust, final = (value.find(key) for key in FLOW)
    if rate is None:
        for key, given in (('exhaust_velocity', exhaust), ('final_mass', final)):
            if given is not None:
                raise given.error(
                    f'{key} says nothing without mass_rate [kg/s]; give it, or remove this key'
                )
        return None
    if exhaust is None:
        velocity: Vector = (0.0, 0.0, 0.0)
    elif isinstance(exhaust.content, list):
        velocity = exhaust.vector(unit='m/s')
    else:
        velocity = (0.0, 0.0, -exhaust.number(unit='m/s', minimum=0.0))
    return MassFlow(
        rate=rate.number(unit='kg/s'),
        exhaust_velocity=velocity,
        final_mass=None if final is None else final.number(unit='kg', positive=True),
    )


def _optional(value: Value, key: str, unit: str) -> float | None:
    given = value.find(key)
    return None if given is None else given.number(unit=unit)


def _vector(value: Value, key: str, unit: str) -> Vector:
    given = value.find(key)
    return (0.0, 0.0, 0.0) if given is None else given.vector(unit=unit)
