# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`integrator: auto` meets its tolerance at the least cost, says why, and always chooses the same.
"""

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import oscillator
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

from . import scenes


def spring(tolerance, dt=0.02):
    return load_scene(
        {
            'version': 1,
            'name': 'spring',
            'dt': dt,
            'integrator': {'name': 'auto', 'tolerance': tolerance},
            'bodies': [
                {
                    'name': 'box',
                    'mass': 1.0,
                    'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 3.0},
                    'initial': {'position': [1, 0, 0]},
                }
            ],
            'forces': [{'type': 'spring', 'a': 'box', 'b': 'world', 'stiffness': 4.0}],
        }
    )


@pytest.mark.parametrize('tolerance', [1e-3, 1e-6, 1e-9])
def test_error_per_second_is_within_the_tolerance(tolerance):
    sim = Simulation(spring(tolerance))
    sim.step(50)
    exact = oscillator.oscillation(1.0, mass=1.0, stiffness=4.0, position=1.0)
    assert abs(sim.state.position[0, 0] - float(exact.position[0])) <= tolerance
    assert sim.integrator.name in sim.choice.reason


def test_a_tighter_tolerance_does_not_get_a_cheaper_method():
    loose, tight = (Simulation(spring(t)).choice for t in (1e-3, 1e-9))
    assert (loose.name, loose.substeps) != (tight.name, tight.substeps)
    assert tight.error < loose.error


def test_free_bodies_get_the_default_in_one_step():
    sim = Simulation(scenes.top(dt=0.001), integrator='auto')
    assert (sim.integrator.name, sim.integrator.substeps) == ('dmv6', 1)


def test_the_choice_is_the_same_every_time():
    assert Simulation(spring(1e-6)).choice == Simulation(spring(1e-6)).choice


def test_a_method_that_refuses_the_scene_is_not_chosen():
    sim = Simulation(scenes.oscillator(dt=0.02, damping=0.5), integrator='auto')
    assert INTEGRATORS[sim.integrator.name].refuses(sim.scene) is None


def test_an_option_that_auto_does_not_have_is_refused():
    with pytest.raises(InvalidModel, match='tolerance'):
        Simulation(spring(1e-3), integrator='auto', integrator_options={'rtol': 1e-3})


@pytest.mark.parametrize('name', ['dmv6', 'rk4'])
def test_substeps_divide_the_tick(name):
    """Two substeps of 2 ms are two ticks of 1 ms, bit for bit."""
    coarse = Simulation(
        scenes.oscillator(dt=0.002), integrator=name, integrator_options={'substeps': 2}
    )
    fine = Simulation(scenes.oscillator(dt=0.001), integrator=name)
    coarse.step(50)
    fine.step(100)
    assert coarse.state_bytes() == fine.state_bytes()


def test_each_integrator_bears_the_name_of_its_file():
    """The registry lists files and imports a method when it is asked for."""
    for name, integrator in INTEGRATORS.items():
        assert integrator.name == name
        assert integrator.source


def test_choice_says_what_it_tries_and_what_the_pilot_cannot_know():
    said = []
    sim = Simulation(spring(1e-4), progress=said.append)
    assert said[0] == 'auto: reference run with rk4'
    assert 'auto: trying dmv6' in said
    assert sim.choice.reason.endswith('nothing of commands, nor of what comes after it')


def test_linear_points_are_judged_by_the_exact_motion_however_stiff():
    said = []
    sim = Simulation(
        scenes.oscillator(dt=0.02, stiffness=1e8), integrator='auto', progress=said.append
    )
    assert sim.integrator.name == 'linear_propagator'
    assert not any('reference' in text for text in said)
