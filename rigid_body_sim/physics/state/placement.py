# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A body put elsewhere: where it is from now on, and how it moves from there.

    p = m v,   L = R I R^T omega        what the blocks keep; of a body on a pivot, L about it
        position, velocity : [m, m/s]    of the centre of mass, world axes
        omega              : [rad/s]     world axes

What is not given stays as it is; velocities stay in world axes where only the orientation is
given. What rounding had lost of position and momentum is forgotten with them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel, choose_from
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.finite_energy import need_finite_energy
from rigid_body_sim.physics.model.inertia_over_time import moments_at
from rigid_body_sim.physics.model.numbers import checked_vector, shown
from rigid_body_sim.physics.model.pivot import arm_of, inertia_of
from rigid_body_sim.physics.model.scene import Body, Quaternion, Vector
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.layout import Layout, as_vector
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

FRAMES = ('world', 'body')
NO_VECTOR: Vector = (0.0, 0.0, 0.0)
ROOM = 4.0  # [-] what turning a vector back and forth may need of the numbers on the way
OFF_PIVOT = 1e-6  # [-] of the lengths: so far from what a pivot allows is the same place, written
# with fewer digits


@dataclass(frozen=True)
class Placement:
    """
    What is asked of one body; None: stays as it is.

    position, velocity : (3,) [m], [m/s]  centre of mass, world axes
    orientation        : (4,) [-]         unit quaternion xyzw, body to world
    angular_velocity   : (3,) [rad/s]     world axes
    """

    position: Vector | None = None
    orientation: Quaternion | None = None
    velocity: Vector | None = None
    angular_velocity: Vector | None = None


@dataclass(frozen=True)
class PlacedRows:
    """
    Rows of the blocks of one body, by their offsets.

    core : of the body
    """

    core: int
    translation: Mapping[int, Array] = field(default_factory=dict)
    rotation: Mapping[int, Array] = field(default_factory=dict)


def asked_placement(
    body: Body,
    *,
    position: Any = None,
    orientation: Any = None,
    velocity: Any = None,
    angular_velocity: Any = None,
    frame: str = 'world',
    now: Quaternion = so3.IDENTITY,
) -> Placement:
    """
    Judge what is asked of a body, as far as it can be judged without its state.

    frame : axes of the velocities: 'world', or 'body' as it is turned then
    now   : orientation, where none is asked

    Raises InvalidModel for what no body, or not this one, can be.
    """
    said = f'state of {body.name!r}'
    if body.motion is not None:
        raise InvalidModel(f'{said}: it moves as told; choose a body without `motion`')
    if body.fixed:
        raise InvalidModel(f'{said}: it is fixed; choose a body without `fixed: true`')
    if not isinstance(frame, str) or frame not in FRAMES:
        raise InvalidModel(f'{said}: frame {shown(frame)}{choose_from(frame, FRAMES)}')
    r, v, w = (
        None if values is None else checked_vector(said, name, values)
        for name, values in (
            ('position', position),
            ('velocity', velocity),
            ('angular_velocity', angular_velocity),
        )
    )
    q = None
    if orientation is not None:
        try:
            q = so3.unit_quaternion(orientation)
        except InvalidModel as error:
            raise InvalidModel(f'{said}: orientation {shown(orientation)}: {error}') from None
    if body.is_point:
        if (q is not None and any(q[:3])) or (w is not None and any(w)):
            raise InvalidModel(
                f'{said}: it is a point mass and does not turn; leave orientation (or give '
                '0 0 0 1) and angular velocity out'
            )
        q, w = None, None
    elif frame == 'body':
        turned = now if q is None else q
        v, w = (None if each is None else as_vector(so3.rotate(turned, each)) for each in (v, w))
    return Placement(r, q, v, w)


def rows_of(layout: Layout, asked: Placement, body: str, state: State, time: float) -> PlacedRows:
    """
    Give the rows of a body for what is asked of it.

    state, time : of now; time [s] since the start of the scene

    Raises InvalidModel where a pivot does not allow it, or a momentum is beyond the numbers.
    """
    index, core = layout.index(body), layout.core(body)
    record = layout.bodies[index]
    attitude = state.orientation[index] if asked.orientation is None else asked.orientation
    spin = state.angular_velocity[index]
    if asked.angular_velocity is not None:
        spin = np.array(asked.angular_velocity)
    check_placement(record, asked, np.array(attitude), spin)
    rotation: dict[int, Array] = {}
    if not (asked.orientation is None and asked.angular_velocity is None):
        axes = np.array(attitude)
        if not np.array_equal(layout.principal[core], so3.IDENTITY):
            axes = so3.normalise(so3.multiply(axes, layout.principal[core]))
        law = record.inertia_over_time
        moments = layout.moments[core] if law is None else moments_at(law, time)
        rotation[blocks.ANGULAR_MOMENTUM] = so3.rotate(axes, moments * so3.rotate_back(axes, spin))
        if asked.orientation is not None:
            rotation[blocks.ORIENTATION] = axes
    translation: dict[int, Array] = {}
    if asked.position is not None and record.pivot is None:
        translation[blocks.POSITION] = np.array(asked.position)
        translation[blocks.POSITION_RESIDUAL] = np.zeros(3)
    if asked.velocity is not None and record.pivot is None:
        translation[blocks.MOMENTUM] = record.mass * np.array(asked.velocity)
        translation[blocks.MOMENTUM_RESIDUAL] = np.zeros(3)
    return PlacedRows(core, translation, rotation)


def check_placement(
    body: Body, asked: Placement, attitude: Array | None = None, spin: Array | None = None
) -> None:
    """
    Refuse what would tear a body off its pivot, or has a momentum or an energy beyond the numbers.

    attitude, spin : orientation (4,) and angular velocity (3,) [rad/s], world axes, that it will
                     have; None: those that are asked
    """
    if attitude is None:
        attitude = np.array(asked.orientation or so3.IDENTITY)
    if spin is None:
        spin = np.array(asked.angular_velocity or NO_VECTOR)
    if body.pivot is not None:
        _check_pivot(body, asked, attitude, spin)
    with np.errstate(over='ignore', invalid='ignore'):
        momenta = [body.mass * np.array(asked.velocity or NO_VECTOR)]
        if not body.is_point:
            momenta.append(ROOM * _largest_moment(body) * spin)
    if not np.isfinite(momenta).all():
        raise InvalidModel(
            f'state of {body.name!r}: the momentum, mass times velocity, is beyond the largest '
            'number; check the units (m, kg, s)'
        )
    moment = 0.0 if body.is_point else _largest_moment(body)
    for name, values, unit, weight in (
        ('position', asked.position, 'm', body.mass),
        ('velocity', asked.velocity, 'm/s', body.mass),
        ('angular velocity', asked.angular_velocity, 'rad/s', moment),
    ):
        if values is not None:
            said = f'state of {body.name!r}: the {name}'
            need_finite_energy(said, values, unit=unit, weight=weight)


def _largest_moment(body: Body) -> float:
    """No moment of inertia of a rigid body is larger at any time [kg m^2]."""
    if body.inertia_over_time is not None:
        return max(max(row[1:]) for row in body.inertia_over_time.table)
    return sum(inertia_of(body).diagonal().tolist())


def _check_pivot(body: Body, asked: Placement, attitude: Array, spin: Array) -> None:
    """Refuse what would tear a body off its pivot."""
    assert body.pivot is not None
    arm = so3.rotate(attitude, arm_of(body))
    length = float(np.linalg.norm(arm))
    reach = float(np.linalg.norm(body.pivot.at)) + length
    with np.errstate(over='ignore', invalid='ignore'):
        speed = math.hypot(*spin.tolist()) * length
        velocity = np.cross(spin, arm)
    for name, wanted, allowed, size, unit in (
        ('position', asked.position, np.array(body.pivot.at) + arm, reach, 'm'),
        ('velocity', asked.velocity, velocity, speed, 'm/s'),
    ):
        if wanted is None:
            continue
        off = math.hypot(*(np.array(wanted) - allowed).tolist())
        if not off <= OFF_PIVOT * size:
            x, y, z = (f'{value:.9g}' for value in allowed)
            raise InvalidModel(
                f'state of {body.name!r}: {name} {shown(wanted)} would tear it off its pivot; '
                f'with this orientation and angular velocity it is ({x}, {y}, {z}) {unit}'
            )
