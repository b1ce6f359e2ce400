# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which conservation laws are left where bodies meet, and how their breach is measured.

The states are made up: a ball on the z axis whose speed is set, so that its energy is known.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rigid_body_sim.physics.diagnostics.invariants import DriftMeter, Invariants
from rigid_body_sim.physics.forces.elements.drag import Drag
from rigid_body_sim.physics.forces.elements.spring import Spring
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.shapes import Particles, Plane, Sphere
from rigid_body_sim.physics.state.snapshot import COLUMNS, State

BALL = Body('ball', Sphere(0.1), mass=2.0, inertia=0.01 * np.eye(3))
OTHER = Body('other', Sphere(0.1), mass=1.0, inertia=0.01 * np.eye(3))
GROUND = Body('ground', Plane((0.0, 0.0, 1.0)), mass=0.0, fixed=True)
GHOST = Body('ghost', None, mass=0.0, fixed=True)
FRAME = Body('frame', Particles(np.eye(3), np.ones(3)), mass=0.0, fixed=True)


def scene(*bodies: Body, mode: str = 'timestep', **keys: Any) -> Scene:
    """Return a scene in which bodies meet."""
    return Scene('meet', 1_000_000, bodies, contact={'mode': mode}, **keys)


def moving(speed: float, bodies: int = 2) -> State:
    """Return the state of the ball with a speed along z [m/s]; other bodies rest."""
    rows = np.zeros((bodies, COLUMNS))
    rows[:, 6] = 1.0  # orientations
    rows[0, 9], rows[0, 18] = speed, BALL.mass * speed
    return State(rows)


def test_energy_may_fall_but_not_rise_where_bodies_meet() -> None:
    laws = Invariants(scene(BALL, GROUND))
    assert (laws.energy_is_conserved, laws.energy_must_not_rise) == (False, True)
    laws = Invariants(scene(BALL, GROUND, mode='none'))
    assert (laws.energy_is_conserved, laws.energy_must_not_rise) == (True, False)
    damped = scene(BALL, GROUND, forces=(Drag(body='ball', linear=1.0),))
    assert not Invariants(damped).energy_must_not_rise  # not of a force that nobody asked its sign


@pytest.mark.parametrize(
    ('bodies', 'kept'),
    (
        ((BALL, OTHER), True),
        ((BALL, OTHER, GROUND), False),
        ((BALL, OTHER, GHOST), True),  # nothing can hit it
        ((BALL, OTHER, FRAME), True),
    ),
    ids=lambda item: str(len(item)) if isinstance(item, tuple) else str(item),
)
def test_momentum_stays_unless_something_fixed_can_be_hit(
    bodies: tuple[Body, ...], kept: bool
) -> None:
    assert Invariants(scene(*bodies)).momentum_is_conserved is kept
    assert Invariants(scene(*bodies, mode='none')).momentum_is_conserved
    rope = Spring(a='ball', b='other', stiffness=1.0)
    assert Invariants(scene(*bodies, forces=(rope,))).momentum_is_conserved is kept


def test_the_rise_is_counted_from_the_lowest_energy_so_far() -> None:
    meter = DriftMeter(Invariants(scene(BALL, GROUND)), moving(4.0), time=0.0)
    assert meter.drift().energy_rise == 0.0
    for k, speed in enumerate((3.0, 2.0, 2.5, 1.0, 1.2)):
        meter.sample(moving(speed), time=float(k), commanded=False)
    drift = meter.drift()
    # from 2 to 2.5 m/s: 2.25 J of 16 J; the later rise, from 1 to 1.2 m/s, is smaller
    assert drift.energy_rise == pytest.approx(2.25 / 16.0, rel=1e-14)
    assert (drift.energy, drift.momentum, drift.angular_momentum) == (None, None, None)


def test_what_a_command_gives_is_no_rise() -> None:
    meter = DriftMeter(Invariants(scene(BALL, GROUND)), moving(1.0), time=0.0)
    meter.sample(moving(5.0), time=1.0, commanded=True)
    meter.sample(moving(4.0), time=2.0, commanded=False)
    assert meter.drift().energy_rise == 0.0


def test_without_contact_nothing_is_said_of_a_rise() -> None:
    meter = DriftMeter(Invariants(scene(BALL, mode='none')), moving(1.0, 1), time=0.0)
    meter.sample(moving(2.0, 1), time=1.0, commanded=False)
    drift = meter.drift()
    assert drift.energy_rise is None and drift.energy == pytest.approx(0.75, rel=1e-14)
