# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The solvers of scipy as references: they agree with closed forms, and nobody pays for them who does
not ask.
"""

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import free_asymmetric_top, oscillator
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.integration.schemes import scipy_reference
from rigid_body_sim.physics.model.rotation import angle_between

from ..patience import HANGING
from . import scenes

# global errors to expect of the default tolerances over some seconds; BDF is made for less
ACCURACY = {'scipy_dop853': 1e-11, 'scipy_radau': 1e-8, 'scipy_bdf': 1e-5, 'scipy_lsoda': 1e-9}
NAMES = sorted(ACCURACY)


def test_every_reference_is_here():
    assert sorted(name for name in INTEGRATORS if INTEGRATORS[name].is_reference) == NAMES


@pytest.mark.parametrize('name', NAMES)
def test_references_agree_with_the_free_asymmetric_top(name):
    omega = (0.4, 1.0, 0.3)
    sim = Simulation(scenes.top(omega=omega, dt=0.5), integrator=name)
    sim.step(8)
    exact = free_asymmetric_top.rotation(4.0, inertia=(1, 2, 3), angular_velocity_body=omega)
    assert angle_between(sim.state.orientation[0], exact.orientation) < ACCURACY[name]


@pytest.mark.parametrize('name', NAMES)
def test_references_agree_with_the_damped_oscillator(name):
    sim = Simulation(scenes.oscillator(dt=0.5, damping=0.8), integrator=name)
    sim.step(4)
    exact = oscillator.oscillation(2.0, mass=1.0, stiffness=4.0, damping=0.8, position=1.0)
    error = math.hypot(
        sim.state.position[0, 0] - float(exact.position[0]),
        sim.state.velocity[0, 0] - float(exact.velocity[0]),
    )
    assert error < ACCURACY[name]


def test_rk8_agrees_with_dop853_where_there_is_no_closed_form():
    runs = [
        Simulation(scenes.linked_bodies(), integrator=name) for name in ('rk8', 'scipy_dop853')
    ]
    for sim in runs:
        sim.step(50)
    assert runs[0].state.values == pytest.approx(
        runs[1].state.values, abs=1e-11
    )  # tolerance of the solver


def test_a_tolerance_can_be_asked_for():
    errors = []
    exact = oscillator.oscillation(2.0, mass=1.0, stiffness=4.0, position=1.0)
    for rtol in (1e-3, 1e-9):
        options = {'rtol': rtol, 'atol': 1e-12}
        sim = Simulation(
            scenes.oscillator(dt=2.0), integrator='scipy_dop853', integrator_options=options
        )
        sim.step()
        errors.append(abs(sim.state.position[0, 0] - float(exact.position[0])))
    assert errors[1] < 1e-8 < 1e-6 < errors[0]


@pytest.mark.parametrize(
    'name', [pytest.param('scipy_dop853', marks=pytest.mark.long), 'scipy_radau']
)
def test_a_solver_that_fails_stops_the_run(name):
    sim = Simulation(scenes.top(omega=(1e149, 1e149, 1e148), dt=1.0), integrator=name)
    with pytest.raises(SimulationDiverged, match='scipy'):
        sim.step()


@pytest.mark.parametrize('name', NAMES)
def test_a_run_after_a_reset_repeats_the_bits_of_a_fresh_one(name):
    """Nothing in the scene depends on time, so neither may the steps of the solver."""
    fresh, again = (Simulation(scenes.linked_bodies(), integrator=name) for _ in range(2))
    again.step(3)
    again.reset()
    for sim in (fresh, again):
        sim.step(4)
    assert again.state.values.tobytes() == fresh.state.values.tobytes()


def linked_far_away(distance, *, integrator, options=None):
    """A rigid body and a point on a spring between them, far from the origin of the world."""
    inertia = {'ixx': 0.2, 'iyy': 0.3, 'izz': 0.4, 'ixy': 0.03, 'ixz': -0.02, 'iyz': 0.01}
    body = {
        'name': 'a',
        'mass': 1.0,
        'inertia': inertia,
        'initial': {'position': [distance, 0, 0], 'angular_velocity': [1, 2, 3]},
    }
    point = {
        'name': 'c',
        'mass': 1.0,
        'shape': {'type': 'particle'},
        'initial': {'position': [distance + 1, 0, 0.3]},
    }
    spring = {'type': 'spring', 'a': 'a', 'b': 'c', 'a_point': [0.1, 0.1, 0], 'stiffness': 30}
    scene = load_scene({'dt': 0.01, 'bodies': [body, point], 'forces': [spring]})
    return Simulation(scene, integrator=integrator, integrator_options=options)


@pytest.mark.parametrize(
    ('name', 'most'),
    [
        ('scipy_dop853', 10_000),
        pytest.param('scipy_dop853', scipy_reference.MOST, marks=pytest.mark.long),
        pytest.param('scipy_lsoda', scipy_reference.MOST, marks=pytest.mark.long),
        pytest.param('scipy_radau', scipy_reference.MOST, marks=pytest.mark.long),
    ],
)
def test_a_tick_that_rounding_far_from_the_origin_would_never_let_end_is_refused(
    name, most, monkeypatch
):
    first_look = scipy_reference.FIRST_LOOK * most // scipy_reference.MOST
    monkeypatch.setattr(scipy_reference, 'MOST', most)
    monkeypatch.setattr(scipy_reference, 'FIRST_LOOK', first_look)
    sim = linked_far_away(1e9, integrator=name)
    before = sim.state_bytes()
    with pytest.raises(SimulationDiverged, match=r'1e\+09 m from the origin.* rounded to 2e-07 m'):
        sim.step()
    assert (sim.tick, sim.state_bytes()) == (0, before)
    near = linked_far_away(0.0, integrator=name)
    near.step()
    allowed = {'rtol': 1e-5, 'atol': 1e-5}
    far = linked_far_away(1e9, integrator=name, options=allowed)
    far.step()
    moved = [s.state.position[1] - s.state.position[0] for s in (near, far)]
    assert moved[0] == pytest.approx(moved[1], abs=1e-6)


def test_scipy_integrate_is_not_imported_before_a_reference_runs():
    program = (
        'import sys\nfrom rigid_body_sim import Simulation, load_scene\n'
        "s = Simulation(load_scene({'dt': 0.001, 'integrator': 'scipy_lsoda', 'bodies':"
        " [{'name': 'b', 'mass': 1, 'shape': {'type': 'particle'}}]}))\n"
        "print('scipy.integrate' in sys.modules)\ns.step()\nprint('scipy.integrate' in "
        'sys.modules)\n'
    )
    result = subprocess.run(
        [sys.executable, '-c', program],
        env=os.environ | {'PYTHONPATH': str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        check=True,
        timeout=HANGING,
    )
    assert result.stdout.split() == ['False', 'True']
