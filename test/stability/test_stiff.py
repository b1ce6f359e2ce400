# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Stiff springs and strong damping, from a step that resolves them to one that resolves nothing.

k dt^2 runs from 1e-2 to 1e9. A method that has no limit there must stay bounded; any other may
leave the numbers only with words: it warned at the start, and stops with the body and the tick.
"""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

from . import cases

DT = 0.01
STIFFNESSES = [10.0**power / DT**2 for power in range(-2, 10)]  # k dt^2 = 1e-2 … 1e9, of 1 kg
TICKS = 300
SHORT = ('explicit_euler', 'semi_implicit_euler', 'rk4', 'dmv6', 'linear_propagator')
ANY_STEP = ('implicit_euler', 'sdirk2', 'implicit_midpoint', 'linear_propagator')


def names(scene, *, short=SHORT):
    return [
        pytest.param(name, marks=() if name in short else pytest.mark.long)
        for name in cases.methods(scene)
    ]


IMPLICIT = ('implicit_euler', 'sdirk2', 'implicit_midpoint')


def mostly_long(*short, implicit=IMPLICIT):
    """Leave to the short form what compiles within a second."""
    return [*short, *(pytest.param(name, marks=pytest.mark.long) for name in implicit)]


def ticks_to_look(name, stiffness):
    """
    How many ticks tell whether a method grows: 300, or the time of 30 000 rad where it is less.

    A method that chooses its steps makes at least omega dt of them in a tick, being stable up to
    about 1 rad a step: at the top three ticks hold 100 000, and what grows by 1 / 10 000 a step
    shows. Left unresolved, in one step, a tick there would grow by omega dt > 300 or more. With
    rtol = 0.1 and atol = 1 this rule fails at each stiffness of k dt^2 = 10 and above.
    """
    if 'rtol' not in INTEGRATORS[name].options:
        return TICKS
    return max(3, math.ceil(TICKS * min(1.0, 100.0 / (math.sqrt(stiffness) * DT))))


def orbit(found, stiffness):
    """Size of the orbit after each tick [m]: sqrt(x^2 + v^2 / k)."""
    return np.hypot(found[:, 0], found[:, 1] / math.sqrt(stiffness))


@pytest.mark.parametrize('name', names(cases.on_a_spring(dt=DT, stiffness=1.0)))
def test_a_spring_that_grows_was_warned_of_and_one_that_does_not_was_not(name):
    for stiffness in STIFFNESSES:
        scene = cases.on_a_spring(dt=DT, stiffness=stiffness)
        warnings = Simulation(scene, integrator=name).warnings()
        found, diverged = cases.run(scene, name, ticks_to_look(name, stiffness))
        assert np.isfinite(found).all()
        size = orbit(found, stiffness)
        grows = diverged or size[-1] > 10.0
        if grows:
            assert any("'ball' may swing" in text for text in warnings), stiffness
        # a window of instability of two hundredths in 3.16 … 5.03, and growth of 1e-5 a step, are
        # warned of although 300 ticks do not show them
        slow = name in ('blanes_moan4', 'midpoint', 'explicit_euler')
        assert slow or bool(warnings) == grows


@pytest.mark.parametrize(
    'name', [pytest.param(ANY_STEP[0], marks=pytest.mark.long), *ANY_STEP[1:]]
)
@pytest.mark.parametrize(
    'stiffness',
    [
        pytest.param(stiffness, marks=() if i in (0, 4, 11) else pytest.mark.long)
        for i, stiffness in enumerate(STIFFNESSES)
    ],
)
def test_methods_for_any_step_stay_bounded_and_warn_of_nothing(name, stiffness):
    scene = cases.on_a_spring(dt=DT, stiffness=stiffness)
    assert not Simulation(scene, integrator=name).warnings()
    found, diverged = cases.run(scene, name, TICKS)
    assert not diverged
    assert orbit(found, stiffness).max() <= 1.0 + 1e-9  # round-off of three hundred solves


@pytest.mark.parametrize('stiffness', STIFFNESSES)
def test_rigid_bodies_on_springs_off_their_centres_stay_bounded(stiffness):
    """Two needles, one 1000 times as heavy, on one spring between their tips: solved at once."""
    scene = cases.scene(
        cases.body((1e-3, 1.0, 1.0005), (0.0, 1.0, 0.0), name='a'),
        cases.body((1.0, 1e3, 1e3), (0.0, 0.0, 1.0), name='b', mass=1e3, position=[0, 3, 0]),
        forces=[
            {
                'type': 'spring',
                'a': 'a',
                'a_point': [0, 1, 0],
                'b': 'b',
                'b_point': [0, -1, 0],
                'stiffness': stiffness,
            }
        ],
        dt=DT,
    )
    sim = Simulation(scene, integrator='linearly_implicit')
    assert all('rest length' in text for text in sim.warnings())  # a limit on the safe side
    kinetic = [sim.invariants.kinetic_energy(sim.state)]
    stored = sim.energy() - kinetic[0]
    for _ in range(100):
        sim.step(3)
        kinetic.append(sim.invariants.kinetic_energy(sim.state))
    # implicit Euler in the stiff direction: what it stores it loses or hands over, never more
    assert max(kinetic) < 1.5 * (kinetic[0] + stored)
    assert np.linalg.norm(sim.momentum()) < 1e-6 * math.sqrt(stiffness)  # round-off of the force


@pytest.mark.parametrize('damping_ratio', [1.0, 50.0])
@pytest.mark.parametrize('steps', [1.0, 1e2, 1e4, 1e6])
@pytest.mark.parametrize(
    'name', mostly_long('linear_propagator', implicit=('implicit_euler', 'sdirk2'))
)
def test_critical_and_overdamped_springs_come_to_rest_at_any_step(name, steps, damping_ratio):
    """dt = steps / omega, the energy never rises."""
    stiffness = (steps / DT) ** 2
    damping = 2.0 * damping_ratio * math.sqrt(stiffness)
    scene = cases.on_a_spring(dt=DT, stiffness=stiffness, damping=damping)
    found, diverged = cases.run(scene, name, 400)
    assert not diverged
    size = orbit(found, stiffness)
    assert (size[1:] <= size[:-1] * (1.0 + 1e-12) + 1e-300).all()  # round-off of the solve
    # the slow mode of the overdamped one has the rate omega / 100: 400 ticks are 4 of its times
    assert size[-1] < (1e-6 if damping_ratio == 1.0 else 0.02)


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('name', mostly_long('linear_propagator', 'dmv6'))
@pytest.mark.parametrize('hk', [0.1, 1.0, 3.9])
def test_drag_never_speeds_a_body_up(name, hk):
    found, _ = cases.run(cases.in_a_fluid(dt=DT, rate=hk / DT), name, 100)
    speed = np.abs(found[:, 1])
    assert (speed[1:] <= speed[:-1]).all()
    assert speed[0] < 1.0


@pytest.mark.parametrize('hk', [1e2, 1e6, 1e12])
@pytest.mark.parametrize('name', mostly_long('linear_propagator'))
def test_drag_far_beyond_the_step_is_no_trouble_for_methods_for_any_step(name, hk):
    found, diverged = cases.run(cases.in_a_fluid(dt=DT, rate=hk / DT), name, 20)
    assert not diverged
    # implicit Euler: 1 / (1 + h k); midpoint hardly decays but never grows; the exact one dies out
    bound = {'implicit_euler': 2.0 / hk, 'sdirk2': 5.0 / hk, 'implicit_midpoint': 1.0}
    assert abs(found[0, 1]) <= bound.get(name, 1e-40) * (1.0 + 1e-12)


@pytest.mark.parametrize('ratio', [1.0, 1e3, 1e6, 1e9])
@pytest.mark.parametrize('name', ['implicit_midpoint', 'sdirk2', 'linearly_implicit'])
def test_light_body_on_a_stiff_spring_to_a_heavy_one(name, ratio, request):
    """h omega = 100 for the light one, whatever the other weighs."""
    if name == 'linearly_implicit':  # of points: no other test wants its kernel
        request.getfixturevalue('plain_source')
    scene = cases.scene(
        cases.point('heavy', mass=ratio),
        cases.point('light', position=[1, 0, 0]),
        forces=[{'type': 'spring', 'a': 'heavy', 'b': 'light', 'stiffness': (100.0 / DT) ** 2}],
        dt=DT,
    )
    sim = Simulation(scene, integrator=name)
    energy = sim.energy()
    for _ in range(50):
        sim.step(4)
        assert sim.energy() <= energy * (1.0 + 1e-9)  # round-off
    # it hands the light one 1e6 times its force h; what is left is rounding of that
    assert np.linalg.norm(sim.momentum()) < 1e-9 * 100.0 / DT


@pytest.mark.parametrize(
    ('name', 'scene', 'of'),
    [
        ('dmv6', cases.on_a_spring(dt=DT, stiffness=1e6), 'ball'),
        ('rk4', cases.on_a_spring(dt=DT, stiffness=1e6), 'ball'),
        ('explicit_euler', cases.in_a_fluid(dt=DT, rate=1e3), 'ball'),
        ('rk4', cases.top((1.0, 2.0, 3.0), (1e3, 3e3, 2e3), dt=DT), 'top'),
        ('explicit_euler', cases.top((1e-3, 1.0, 1.0005), (80.0, 60.0, 2.0), dt=DT), 'top'),
        ('taylor16', cases.top((1.0, 2.0, 3.0), (1e5, 3e5, 2e5), dt=DT), 'top'),
    ],
)
def test_a_run_that_diverges_warned_and_stops_at_its_last_finite_state(name, scene, of):
    sim = Simulation(scene, integrator=name)
    warnings = sim.warnings()
    assert warnings and all(text.startswith(f"'{of}' ") for text in warnings)
    with pytest.raises(SimulationDiverged) as caught:
        sim.step(200_000)
    assert caught.value.body == of
    assert caught.value.tick == sim.tick
    assert INTEGRATORS[name].stability in str(caught.value)
    assert np.isfinite(sim.state.values[:, :10]).all()
