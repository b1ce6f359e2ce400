# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What integrators keep, to the last bit or to round-off, and the symmetries of mechanics."""

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.exact import free_asymmetric_top
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.model import rotation

from . import scenes

NAMES = scenes.TURNING


@pytest.mark.parametrize('dt', [0.001, 0.03, 0.1, 0.4])
def test_dmv6_keeps_angular_momentum_to_the_last_bit_without_torque(dt):
    sim = Simulation(scenes.top(omega=(0.3, 1.0, 0.2), dt=dt))
    before = sim.state.angular_momentum.tobytes()
    sim.step(100_000)
    assert sim.state.angular_momentum.tobytes() == before


@pytest.mark.parametrize('dt', [0.001, 0.03, 0.1])
def test_dmv6_keeps_energy_to_1e_minus_12(dt):
    sim = Simulation(scenes.top(dt=dt))
    before = sim.energy()
    sim.step(round(100.0 / dt))
    assert (
        abs(sim.energy() / before - 1.0) < 1e-12
    )  # round-off: 1e5 steps of a random walk of 1e-16


def test_dmv6_follows_the_flipping_top_over_a_hundred_seconds():
    sim = Simulation(scenes.top(dt=0.025))
    sim.step(4000)
    exact = free_asymmetric_top.rotation(
        100.0, inertia=(1, 2, 3), angular_velocity_body=(0.01, 1.0, 0.01)
    )
    # truncation: 5e-12 rad at h |omega| = 0.025 (Hairer & Vilmart's map of order six)
    assert rotation.angle_between(sim.state.orientation[0], exact.orientation) < 2e-11


@pytest.mark.parametrize('name', NAMES)
def test_one_call_of_many_steps_gives_the_bits_of_many_calls_where_a_body_turns_alone(name):
    whole, parts = (Simulation(scenes.top(), integrator=name) for _ in range(2))
    for sim in (whole, parts):
        sim.hold('top', 'wrench', force=(1, 0, 0), torque=(0, 0.1, 0), until=37)
    want_same_bits(whole, parts)


@pytest.mark.parametrize('name', scenes.mostly_long(NAMES, short=scenes.OF_EACH_KIND))
def test_one_call_of_many_steps_gives_the_bits_of_many_calls(name):
    scene = scenes.linked_bodies(name)
    whole, parts = (Simulation(scene, integrator=name) for _ in range(2))
    for sim in (whole, parts):
        sim.hold('box', 'wrench', force=(1, 0, 0), torque=(0, 0.1, 0), until=37)
        sim.set_wrench('rod', force=(0, 0, 1), frame='body')
    want_same_bits(whole, parts)


def want_same_bits(whole, parts):
    whole.step(100)
    for _ in range(100):
        parts.step()
    assert whole.state_bytes() == parts.state_bytes()


@pytest.mark.parametrize('name', NAMES)
def test_a_body_does_not_feel_its_neighbours_in_the_block(name):
    def turned(count):
        bodies = [
            {
                'name': f'b{i}',
                'mass': 1.0 + i,
                'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 2.5},
                # the first spins slowly, the others too fast for the fast pass of the drift
                'initial': {
                    'angular_velocity': [0.1, 1.0, 0.2] if i == 0 else [40.0 + i, 3.0, 2.0]
                },
            }
            for i in range(count)
        ]
        sim = Simulation(scenes.scene(bodies, dt=0.005), integrator=name)
        sim.step(50)
        return sim.state.values[0].tobytes()

    assert turned(1) == turned(70)


def test_springs_between_bodies_keep_total_momentum_and_angular_momentum():
    free = scenes.scene(
        [
            {
                'name': name,
                'mass': mass,
                'inertia': {'ixx': 0.2, 'iyy': 0.3, 'izz': 0.25},
                'initial': {
                    'position': position,
                    'velocity': velocity,
                    'angular_velocity': [1, 2, 3],
                },
            }
            for name, mass, position, velocity in (
                ('a', 1.0, [0, 0, 0], [0, 1, 0]),
                ('b', 2.0, [1, 0, 0], [0, 0, 1]),
            )
        ],
        forces=[
            {
                'type': 'spring',
                'a': 'a',
                'a_point': [0.1, 0.2, 0.3],
                'b': 'b',
                'b_point': [-0.2, 0.1, 0],
                'stiffness': 50.0,
                'damping': 0.3,
                'rest_length': 0.4,
            }
        ],
    )
    sim = Simulation(free)
    momentum, angular = sim.momentum(), sim.angular_momentum()
    sim.step(5000)
    # round-off of 5000 pairs of opposite kicks
    np.testing.assert_allclose(sim.momentum(), momentum, rtol=0, atol=1e-13)
    np.testing.assert_allclose(sim.angular_momentum(), angular, rtol=0, atol=1e-12)


def test_dmv6_does_not_let_the_energy_of_a_spring_drift():
    sim = Simulation(scenes.oscillator(dt=0.02, stiffness=100.0))
    start = sim.energy()
    worst = 0.0
    for _ in range(100):
        sim.step(997)
        worst = max(worst, abs(sim.energy() / start - 1.0))
    # Stoermer-Verlet: the energy swings by (h omega)^2 / 4 = 1 % and comes back, over 1e5 steps
    assert worst < 0.0105


def test_time_runs_backwards_along_the_same_path_with_dmv6():
    omega = (0.3, 1.0, 0.2)
    sim = Simulation(scenes.top(omega=omega, dt=0.02))
    sim.step(2000)
    back = Simulation(
        scenes.top(
            omega=(-sim.state.angular_velocity_body[0]).tolist(),
            dt=0.02,
            orientation=sim.state.orientation[0].tolist(),
        )
    )
    back.step(2000)
    # a symmetric map: what is left is the round-off of 4000 steps
    assert rotation.angle_between(back.state.orientation[0], (0, 0, 0, 1)) < 1e-12


@pytest.mark.parametrize('name', NAMES)
def test_turning_the_world_turns_the_motion(name):
    turn = rotation.normalise((0.1, -0.3, 0.2, 0.9))
    omega = (0.3, 1.0, 0.2)
    straight = Simulation(scenes.top(omega=omega, dt=0.01), integrator=name)
    turned = Simulation(
        scenes.top(omega=omega, dt=0.01, orientation=turn.tolist()), integrator=name
    )
    for sim in (straight, turned):
        sim.step(300)
    expected = rotation.multiply(turn, straight.state.orientation[0])
    assert rotation.angle_between(turned.state.orientation[0], expected) < 1e-13  # round-off


@pytest.mark.parametrize('name', NAMES)
def test_a_boost_changes_nothing_but_the_place(name):
    rest = Simulation(scenes.top(dt=0.01), integrator=name)
    moving = Simulation(scenes.top(dt=0.01, velocity=[3.0, 0.0, 0.0]), integrator=name)
    for sim in (rest, moving):
        sim.step(300)
    np.testing.assert_array_equal(rest.state.orientation, moving.state.orientation)
    assert moving.state.position[0, 0] == pytest.approx(9.0, rel=1e-14)  # round-off


def test_order_of_the_bodies_in_the_scene_does_not_matter():
    first, second = (
        {
            'name': name,
            'mass': 1.0,
            'inertia': {'ixx': 0.2, 'iyy': 0.3, 'izz': 0.25},
            'initial': {'position': position, 'angular_velocity': [1, 2, 3]},
        }
        for name, position in (('a', [0, 0, 0]), ('b', [1, 0, 0]))
    )
    spring = {'type': 'spring', 'a': 'a', 'b': 'b', 'stiffness': 5.0, 'rest_length': 0.5}
    one = Simulation(scenes.scene([first, second], forces=[spring]))
    two = Simulation(scenes.scene([second, first], forces=[spring]))
    for sim in (one, two):
        sim.step(500)
    np.testing.assert_array_equal(one.state.values, two.state.values[::-1])


def test_fast_spin_is_followed_by_dividing_the_drift():
    # h |omega| = 8: the discrete equation has no solution in one piece
    omega = (0.0, 0.0, 80.0)
    sim = Simulation(scenes.top(omega=omega, dt=0.1))
    before = sim.state.angular_momentum.tobytes()
    energy = sim.energy()
    sim.step(100)
    assert sim.state.angular_momentum.tobytes() == before
    assert abs(sim.energy() / energy - 1.0) < 1e-12  # round-off
    assert np.isfinite(sim.state.values).all()


def test_explicit_euler_overdamped_diverges_exactly_beyond_two_over_k():
    """v <- (1 - h k) v: bounded at h k = 2 and below, growing without bound above."""

    def speed(hk):
        scene = scenes.scene(
            [
                {
                    'name': 'ball',
                    'shape': {'type': 'particle'},
                    'mass': 1.0,
                    'initial': {'velocity': [1.0, 0.0, 0.0]},
                }
            ],
            forces=[{'type': 'drag', 'body': 'ball', 'linear': hk}],
            dt=1.0,
        )
        sim = Simulation(scene, integrator='explicit_euler')
        sim.step(2000)
        return abs(sim.state.velocity[0, 0])

    assert speed(1.99) == pytest.approx(0.99**2000, rel=1e-9)  # round-off of 2000 products
    assert speed(2.0) == 1.0
    assert speed(2.01) == pytest.approx(1.01**2000, rel=1e-9)


def test_a_run_that_leaves_the_finite_numbers_stops_and_names_body_and_tick():
    scene = scenes.oscillator(dt=1.0, stiffness=100.0)
    sim = Simulation(scene, integrator='explicit_euler')
    with pytest.raises(SimulationDiverged) as caught:
        sim.step(100_000)
    assert caught.value.body == 'ball'
    assert caught.value.tick == sim.tick
    # |x| grows by sqrt(1 + (h omega)^2) = sqrt(101) a tick and |v| is ten times that: beyond
    # 1.8e308 after 306.6 ticks
    assert abs(sim.tick - 306) <= 1
    assert np.isfinite(sim.state.values).all()
