# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run tells how wrong it is: within a factor of three of the truth where the truth is known."""

import json
import math

import numpy as np
import pytest
import yaml

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import free_asymmetric_top, heavy_top, oscillator
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.run import Run, RunSettings

from .conftest import SCENES

FACTOR = 3.0  # what the estimate promises


def finished(scene, *, integrator, seconds, commands=None, **options):
    simulation = Simulation(
        load_scene(scene), integrator=integrator, integrator_options=options or None
    )
    run = Run(simulation, RunSettings(estimate_error=True))
    for _ in run.follow(commands or {}, round(seconds / simulation.dt)):
        pass
    return run


def spring(dt, stiffness=4.0, damping=0.2):
    return {
        'version': 1,
        'name': 'spring',
        'dt': dt,
        'bodies': [
            {
                'name': 'ball',
                'mass': 1.0,
                'shape': {'type': 'sphere', 'radius': 0.1},  # others have its kernels
                'initial': {'position': [1, 0, 0]},
            }
        ],
        'forces': [
            {
                'type': 'spring',
                'a': 'ball',
                'b': 'world',
                'stiffness': stiffness,
                'damping': damping,
            }
        ],
    }


@pytest.mark.parametrize(
    'integrator',
    [
        'explicit_euler', 'dmv6', 'rk4',
        # kernels that no other test wants
        *(pytest.param(n, marks=pytest.mark.long) for n in ('semi_implicit_euler', 'midpoint')),
    ],
)  # fmt: skip
def test_estimate_on_a_damped_spring_is_within_a_factor_of_three(integrator):
    run = finished(spring(0.01), integrator=integrator, seconds=10.0)
    exact = oscillator.oscillation(10.0, mass=1.0, stiffness=4.0, damping=0.2, position=1.0)
    error = abs(run.simulation.state.position[0, 0] - float(exact.position[0]))
    assert error / FACTOR <= run.error_estimate().position <= error * FACTOR


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize(
    ('integrator', 'dt'),
    [
        pytest.param('midpoint', 0.01, marks=pytest.mark.long),  # the most ticks
        ('dmv6', 0.1),
        ('rk4', 0.05),
    ],
)
def test_estimate_on_a_free_top_is_within_a_factor_of_three(integrator, dt):
    omega = (0.3, 1.0, 0.2)
    scene = {
        'version': 1,
        'name': 'top',
        'dt': dt,
        'bodies': [
            {
                'name': 'top',
                'mass': 1.0,
                'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 3.0},
                'initial': {'angular_velocity_body': list(omega)},
            }
        ],
    }
    run = finished(scene, integrator=integrator, seconds=20.0)
    exact = free_asymmetric_top.rotation(20.0, inertia=(1, 2, 3), angular_velocity_body=omega)
    error = float(angle_between(run.simulation.state.orientation[0], exact.orientation))
    assert error / FACTOR <= run.error_estimate().angle <= error * FACTOR


@pytest.mark.parametrize(('dt', 'rtol'), [(0.2, 1e-3), (0.05, 1e-5)])
def test_a_tick_shorter_than_the_tolerance_asks_for_is_no_reason_to_see_no_error(dt, rtol):
    scene = spring(dt, damping=0.0)
    run = finished(scene, integrator='rk45', seconds=10.0, rtol=rtol, atol=1e-3 * rtol)
    exact = oscillator.oscillation(10.0, mass=1.0, stiffness=4.0, position=1.0)
    error = abs(run.simulation.state.position[0, 0] - float(exact.position[0]))
    assert error / FACTOR <= run.error_estimate().position <= error * FACTOR


def test_what_a_step_damps_away_is_an_error_that_is_seen():
    """h omega = 10: every step that long loses the oscillation, and all of them agree."""
    scene = spring(0.1, stiffness=1e4, damping=0.0)
    run = finished(scene, integrator='implicit_euler', seconds=2.0)
    exact = oscillator.oscillation(2.0, mass=1.0, stiffness=1e4, position=1.0)
    error = abs(run.simulation.state.position[0, 0] - float(exact.position[0]))
    estimate = run.error_estimate()
    assert error > 0.1
    assert error / FACTOR <= estimate.position <= error * FACTOR
    assert estimate.reliable


BOX = {'ixx': 0.3, 'iyy': 0.35, 'izz': 0.1}
MASS = 1e12  # kg: two of them 10 m apart fall round each other in 17 s
SWINGING = {
    'a pendulum': {
        'gravity': [0, 0, -9.81],
        'bodies': [
            {
                'name': 'bar', 'mass': 2.0, 'inertia': BOX,
                'pivot': {'point': [0, 0, 0.5], 'at': [0, 0, 0]},
                'initial': {'orientation': [0.5, 0.2, 0, 1]},
            }
        ],
    },
    'an orbit': {
        'bodies': [
            {
                'name': f'star{i}', 'mass': MASS, 'shape': {'type': 'particle'},
                'initial': {'position': [10.0 * i, 0, 0], 'velocity': [0, 3.65 * i, 0]},
            }
            for i in range(2)
        ],
        'forces': [{'type': 'gravity', 'among': ['star0', 'star1']}],
    },
}  # fmt: skip


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize(
    ('what', 'integrator', 'dt'),
    [
        ('a pendulum', 'dmv6', 0.7),
        ('an orbit', 'sdirk2', 5.0),
        *(
            pytest.param(what, name, dt, marks=pytest.mark.long)
            for what, dt, names in (
                (
                    'a pendulum',
                    0.7,
                    ('implicit_midpoint', 'implicit_euler', 'sdirk2', 'linearly_implicit'),
                ),
                ('an orbit', 5.0, ('implicit_midpoint', 'linearly_implicit')),
            )
            for name in names
        ),
    ],
)
def test_what_swings_too_fast_for_the_step_is_an_error_that_is_seen(what, integrator, dt):
    """No spring tells how fast these turn; all long steps of an implicit method agree on it."""
    ticks = 12
    scene = {'version': 1, 'name': 'swing', 'dt': dt, **SWINGING[what]}
    run = finished(scene, integrator=integrator, seconds=ticks * dt)
    told, end = run.error_estimate(), run.simulation.state
    true = Simulation(
        load_scene(scene), integrator='rk8', integrator_options={'substeps': 60}
    )  # h rate < 0.1: its own error is below 1e-9 of what is compared
    true.step(ticks)
    for key in ('position', 'velocity', 'angular_velocity'):
        error = np.max(np.linalg.norm(getattr(end, key) - getattr(true.state, key), axis=1))
        assert error <= FACTOR * getattr(told, key) + 1e-9, key
        if told.reliable:
            assert error >= getattr(told, key) / FACTOR - 1e-9, key


def test_what_no_finer_run_resolves_is_said_to_be_unreliable():
    scene = spring(0.1, stiffness=1e12, damping=0.0)
    run = finished(scene, integrator='implicit_euler', seconds=0.2)
    estimate = run.error_estimate()
    assert not estimate.reliable
    assert 'oscillation' in estimate.doubt


def test_estimate_is_never_nothing():
    run = finished(spring(0.001, damping=0.0), integrator='rk8', seconds=0.005)
    assert 0.0 < run.error_estimate().position < 1e-12
    assert 0.0 < run.error_estimate().velocity < 1e-12


def test_the_attitude_of_what_moves_as_told_has_its_rounding():
    deck = {
        'name': 'deck',
        'shape': {'type': 'box', 'size': [1, 1, 0.1]},
        'mass': 1.0,
        'initial': {'position': [0, 0, 5]},
        'motion': {'yaw': {'amplitude': 0.5, 'period': 1.0}},
    }
    scene = spring(0.01)
    scene['bodies'].append(deck)
    estimate = finished(scene, integrator='rk4', seconds=0.2).error_estimate()
    # sin and cos of half an angle, each to half a unit in the last place, and their product
    assert 0.0 < estimate.angle < 1e-15


def test_estimate_follows_commands():
    push = Command('ball', 'force', force=(1.0, 0, 0))
    strike = Command('ball', 'impulse', force=(0.3, 0, 0))
    run = finished(
        spring(0.01), integrator='rk4', seconds=5.0, commands={100: [push], 200: [strike]}
    )
    # the finer runs got both: what is left is the error of rk4, far below what a missed
    # command would leave
    assert 0 < run.error_estimate().position < 1e-6


def test_estimate_changes_no_message_and_stands_in_the_bag(verb, as_json, tmp_path):
    digests = []
    for name, words in (('plain', ()), ('estimated', ('--estimate-error',))):
        code, result = as_json(
            'simulate',
            SCENES / 'oscillator.yaml',
            '-o',
            tmp_path / name,
            '--duration',
            0.5,
            *words,
        )
        assert code == 0
        digests.append([repr(message) for message in Bag(tmp_path / name).messages()])
    assert digests[0] == digests[1]
    recorded = json.loads(Bag(tmp_path / 'estimated').ending['error_estimate'])
    assert recorded == result['error_estimate']
    assert math.isfinite(recorded['position'])
    assert np.all(np.array(list(recorded.values())) >= 0)
    assert as_json('replay', tmp_path / 'estimated')[1]['identical']


@pytest.mark.parametrize(('integrator', 'dt'), [('dmv6', 0.002), ('rk8', 0.03)])
def test_estimate_on_a_heavy_top_is_within_a_factor_of_three(integrator, dt):
    scene = yaml.safe_load((SCENES / 'heavy_top.yaml').read_text()) | {'dt': dt}
    run = finished(scene, integrator=integrator, seconds=6.0)
    exact = heavy_top.steady(6.0, precession=2.0, spin=20.39145188432738, tilt=math.radians(30.0))
    state = run.simulation.state
    error = float(angle_between(state.orientation[0], np.ravel(exact.orientation)))
    assert error / FACTOR <= run.error_estimate().angle <= error * FACTOR
