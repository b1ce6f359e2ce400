# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Springs that hold bodies off their centres, or have a rest length: what an implicit method is not
sure to keep is said before the first step. `benchmark/stiff_chains.py` draws chains at random.
"""

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

INERTIA = {'ixx': 0.1, 'iyy': 0.1, 'izz': 0.1}


def hinge(*, dt=0.01, arm=0.5, rest_length=0.0):
    """Two bars in a row, at rest, joined to the world and each other by very stiff springs."""
    bodies = [
        {
            'name': name,
            'mass': 1.0,
            'inertia': INERTIA,
            'initial': {'position': [(2 * i + 1) * (0.5 + 0.5 * rest_length), 0, 0]},
        }
        for i, name in enumerate(('first', 'second'))
    ]
    stiff = {'type': 'spring', 'stiffness': 1e8, 'damping': 1e4, 'rest_length': rest_length}
    forces = [
        stiff | {'a': 'first', 'b': 'world', 'a_point': [-arm, 0, 0]},
        stiff | {'a': 'second', 'b': 'first', 'a_point': [-arm, 0, 0], 'b_point': [arm, 0, 0]},
    ]
    head = {'version': 1, 'name': 'hinge', 'dt': dt, 'gravity': [0, 0, -9.81]}
    return load_scene(head | {'bodies': bodies, 'forces': forces})


@pytest.mark.parametrize('name', ['implicit_midpoint', 'linearly_implicit'])
@pytest.mark.parametrize('dt', [0.01, 0.1])
def test_a_stiff_hinge_is_warned_of_before_the_first_step(name, dt):
    (text,) = Simulation(hinge(dt=dt), integrator=name).warnings()
    limit = INTEGRATORS[name].limits.bent
    assert f'only up to {limit:g}' in text and 'off its centre' in text
    assert 'the integrator sdirk2' in text
    assert Simulation(hinge(dt=dt), integrator='sdirk2').warnings() == []


@pytest.mark.parametrize('name', ['implicit_midpoint', 'linearly_implicit'])
def test_the_limit_is_that_of_springs_that_are_not_linear_in_the_state(name):
    assert Simulation(hinge(arm=0.0), integrator=name).warnings() == []
    assert Simulation(hinge(arm=0.0, rest_length=0.3), integrator=name).warnings() != []
    (text,) = Simulation(hinge(), integrator=name).warnings()
    within = float(text.split('dt <= ')[1].split(' s')[0])
    assert Simulation(hinge(), dt=within, integrator=name).warnings() == []


def test_a_damped_hinge_within_the_limit_gains_nothing():
    sim = Simulation(hinge(dt=2e-5), integrator='implicit_midpoint')
    start = sim.energy()
    for _ in range(5):
        sim.step(20)
        assert sim.energy() <= start + 1e-9  # [J] of some 1e-3 J moved by then


def thrown_chain(*, dt):
    """Two points, the first on a stiff spring to the world, the second on one to the first."""
    first = {'position': [-0.33203, -0.56157, 0.17279], 'velocity': [-0.0614, 0.40653, -0.98929]}
    second = {'position': [-0.31504, -0.46033, 0.10317], 'velocity': [0.88790, -0.08949, -0.01403]}
    stiff = {'type': 'spring', 'stiffness': 6.091848e6}
    return load_scene(
        {
            'version': 1,
            'name': 'thrown_chain',
            'dt': dt,
            'gravity': [0, 0, -9.81],
            'bodies': [
                {'name': 'a', 'shape': {'type': 'particle'}, 'mass': 0.18125, 'initial': first},
                {'name': 'b', 'shape': {'type': 'particle'}, 'mass': 0.45117, 'initial': second},
            ],
            'forces': [
                stiff | {'a': 'a', 'b': 'world', 'rest_length': 0.67487},
                stiff | {'a': 'b', 'b': 'a', 'rest_length': 0.12403},
            ],
        }
    )


def test_a_passive_scene_that_gains_is_warned_of_when_it_is_looked_at():
    """No limit of sdirk2 forbids this step, h omega = 500; it throws the chain all the same."""
    sim = Simulation(thrown_chain(dt=0.055), integrator='sdirk2')
    assert sim.warnings() == []
    start = sim.energy()
    sim.step(25)
    assert sim.energy() > start + 10.0  # 0.3 J are in the motion
    (text,) = sim.warnings()
    assert 'gained' in text and 'sdirk2 brought it in' in text
    late = Simulation(thrown_chain(dt=0.055), integrator='sdirk2')
    late.step(25)  # whoever asks only now is told too
    assert late.warnings() == [text]
    late.apply_impulse('a', linear=(0, 0, 1))  # energy brought in is no gain
    assert late.warnings() == []


def test_a_passive_scene_within_its_limits_and_a_driven_one_are_not_warned_of():
    sim = Simulation(thrown_chain(dt=2e-5), integrator='dmv6')  # h omega = 0.2
    for _ in range(10):
        sim.step(20)
        assert sim.warnings() == []
    sim.set_wrench('a', force=(0, 0, 100))
    sim.step(100)
    assert sim.warnings() == []
    sim.reset()
    assert sim.warnings() == []
