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
