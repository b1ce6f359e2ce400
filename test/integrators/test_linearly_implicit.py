# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The linearly implicit solve: bounded on springs of any stiffness."""

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.model import rotation

from . import scenes

NAME = 'linearly_implicit'
ANCHOR = (0.3, 0.4, 0.1)  # [m] 0.51 from the centre of mass


def hung(*, stiffness, h, damping=0.0):
    """A body that spins at 10 rad/s about a point off its centre, on a spring to the world."""
    body = {
        'name': 'body',
        'mass': 1.0,
        'inertia': {'ixx': 0.1, 'iyy': 0.2, 'izz': 0.25},
        'initial': {'angular_velocity_body': [6, 7, 4], 'velocity': [-0.9, 0.6, 0.3]},
    }
    spring = {
        'type': 'spring', 'a': 'body', 'a_point': ANCHOR, 'b': 'world', 'b_point': ANCHOR,
        'stiffness': stiffness, 'damping': damping,
    }  # fmt: skip
    return scenes.scene([body], forces=[spring], dt=h)


def gap(sim):
    state = sim.state
    end = state.position[0] + rotation.rotate(state.orientation[0], ANCHOR)
    return float(np.linalg.norm(end - ANCHOR))


def kinetic(sim, stiffness):
    return sim.energy() - 0.5 * stiffness * gap(sim) ** 2


@pytest.mark.parametrize('h', [1e-3, 1e-2])
@pytest.mark.parametrize('stiffness', [1e2, 1e4, 1e6, 1e8, 1e12])
def test_a_body_on_a_spring_stays_bounded_at_any_stiffness(stiffness, h):
    sim = Simulation(hung(stiffness=stiffness, h=h), integrator=NAME)
    start = kinetic(sim, stiffness)
    worst, speed = 0.0, 0.0
    for _ in range(100):
        sim.step(round(0.02 / h))
        worst = max(worst, gap(sim))
        speed = max(speed, float(np.linalg.norm(sim.state.angular_velocity_body)))
        assert kinetic(sim, stiffness) < 1.02 * start
    if stiffness >= 1e8:  # what the arc of the drift leaves open, (h |omega|)^2 |arm| / 2
        assert worst < (h * speed) ** 2 * 0.51 / 2.0 * 1.3


@pytest.mark.parametrize('h', [1e-3, 1e-2])
def test_two_bodies_on_a_stiff_link_keep_momentum_and_stay_together(h):
    bodies = [
        {
            'name': name,
            'mass': mass,
            'inertia': {'ixx': 0.1, 'iyy': 0.2, 'izz': 0.25},
            'initial': {'position': [x, 0, 0], 'angular_velocity': [1, 2, 3]},
        }
        for name, mass, x in (('a', 1.0, -0.5), ('b', 3.0, 0.5))
    ]
    link = {
        'type': 'spring', 'a': 'a', 'a_point': [0.5, 0, 0], 'b': 'b', 'b_point': [-0.5, 0, 0],
        'stiffness': 1e8, 'damping': 10.0,
    }  # fmt: skip
    sim = Simulation(scenes.scene(bodies, forces=[link], dt=h), integrator=NAME)
    momentum = sim.momentum()
    sim.step(round(2.0 / h))
    # round-off of the solves: 1e-16 k h^2 / m = 1e-10 a step at worst
    np.testing.assert_allclose(sim.momentum(), momentum, rtol=0, atol=1e-8)
    a, b = sim.state.position
    q = sim.state.orientation
    ends = a + rotation.rotate(q[0], (0.5, 0, 0)), b + rotation.rotate(q[1], (-0.5, 0, 0))
    assert np.linalg.norm(ends[0] - ends[1]) < (h * 6.0) ** 2  # arcs of two arms of 0.5 m


def test_soft_springs_lose_energy_as_documented():
    sim = Simulation(hung(stiffness=1e4, h=1e-2), integrator=NAME)
    start = sim.energy()
    sim.step(200)
    assert 0.5 * start < sim.energy() < start


def test_without_torque_the_angular_momentum_keeps_its_bits_beside_coupled_bodies():
    scene = scenes.scene(
        [
            {
                'name': name,
                'mass': 1.0,
                'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 2.5},
                'initial': {'angular_velocity': [0.3, 1.0, 0.2]},
            }
            for name in ('free', 'hung')
        ],
        forces=[
            {'type': 'spring', 'a': 'hung', 'a_point': [0.1, 0, 0], 'b': 'world', 'stiffness': 1e5}
        ],
        dt=0.01,
    )
    sim = Simulation(scene, integrator=NAME)
    before = sim.state.angular_momentum[0].tobytes()
    sim.step(500)
    assert sim.state.angular_momentum[0].tobytes() == before
