# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hard cases for the default integrator and its kin: needles, flips, round-off, extremes."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import free_asymmetric_top
from rigid_body_sim.physics.rotation import angle_between

DRIFTS = ('dmv4', 'dmv6', 'dmv8', 'dmv10', 'five_rotations')


def top(inertia, omega, *, dt, mass=1.0, **initial):
    i1, i2, i3 = inertia
    return load_scene(
        {
            'version': 1,
            'name': 'hard',
            'dt': dt,
            'bodies': [
                {
                    'name': 'top',
                    'mass': mass,
                    'inertia': {'ixx': i1, 'iyy': i2, 'izz': i3},
                    'initial': {'angular_velocity_body': list(omega), **initial},
                }
            ],
        }
    )


@pytest.mark.parametrize('name', DRIFTS)
def test_angular_momentum_keeps_its_last_bit_over_a_million_ticks(name):
    sim = Simulation(top((1.0, 2.0, 3.0), (0.3, 1.0, 0.2), dt=0.01), integrator=name)
    before = sim.state.angular_momentum.tobytes()
    sim.step(1_000_000)
    assert sim.state.angular_momentum.tobytes() == before


def test_energy_of_a_needle_at_100_rad_per_second_stays():
    sim = Simulation(top((1e-3, 1.0, 1.0005), (80.0, 60.0, 2.0), dt=0.00125))
    energy = sim.energy()
    sim.step(80_000)
    # round-off of the attitude is magnified by the ratio of the moments, 1000, in 8e4 ticks
    assert abs(sim.energy() / energy - 1.0) < 1e-11


def test_attitude_of_a_needle_is_right_to_the_truncation_of_order_six():
    omega = (80.0, 60.0, 2.0)
    sim = Simulation(top((1e-3, 1.0, 1.0005), omega, dt=0.00125))
    sim.step(8000)
    exact = free_asymmetric_top.rotation(
        10.0, inertia=(1e-3, 1.0, 1.0005), angular_velocity_body=omega
    )
    # at h |omega| = 0.125 the map of order six errs by 3e-6 rad over 1000 rad
    assert angle_between(sim.state.orientation[0], exact.orientation) < 1e-5


def test_a_flipping_top_is_followed_for_ten_thousand_seconds():
    omega = (0.01, 1.0, 0.01)
    sim = Simulation(top((1.0, 2.0, 3.0), omega, dt=0.025), integrator='dmv10')
    sim.step(400_000)
    exact = free_asymmetric_top.rotation(1e4, inertia=(1.0, 2.0, 3.0), angular_velocity_body=omega)
    # each pass of the separatrix magnifies round-off: the exact map itself is at 5e-8 here
    assert angle_between(sim.state.orientation[0], exact.orientation) < 1e-6


def test_compensated_sums_lose_nothing_in_a_million_ticks():
    sim = Simulation(
        top((1.0, 2.0, 3.0), (0, 0, 0), dt=0.001, position=[7e3, 0, 0], velocity=[0.7, 0, 0])
    )
    sim.step(1_000_000)
    # the last bit of 7700 is 9e-13: a plain sum is off by some 1e-8
    assert abs(sim.state.position[0, 0] - 7700.0) < 2e-12


def test_a_body_a_thousand_kilometres_away_turns_as_one_at_home():
    near, far = (
        Simulation(top((1.0, 2.0, 3.0), (0.3, 1.0, 0.2), dt=0.01, position=[x, 0, 0]))
        for x in (0.0, 1e6)
    )
    for sim in (near, far):
        sim.step(1000)
    np.testing.assert_array_equal(near.state.orientation, far.state.orientation)


@pytest.mark.parametrize('name', ['dmv6', 'exact_rotor', 'five_rotations', 'rk4', 'taylor16'])
def test_nearly_equal_moments_are_no_special_case(name):
    inertia, omega = (1.0, 1.0, 1.0 + 1e-12), (0.3, 1.0, 0.2)
    sim = Simulation(top(inertia, omega, dt=0.001), integrator=name)
    sim.step(10_000)
    speed = math.hypot(*omega)
    axis = np.array(omega) / speed
    exact = np.array([*(math.sin(5.0 * speed) * axis), math.cos(5.0 * speed)])
    # a sphere to 1e-12; the rest is truncation of the method (five_rotations is of order two, but
    # has no error on equal moments beyond the difference) and round-off of 1e4 ticks
    assert angle_between(sim.state.orientation[0], exact) < 5e-7


@pytest.mark.parametrize('name', ['dmv6', 'exact_rotor', 'taylor16'])
def test_a_start_on_the_separatrix_stays_finite_and_keeps_energy(name):
    # 2 T I2 = |L|^2: the motion runs into the unstable axis and never comes back in exact numbers
    w1 = 0.5
    w3 = w1 * math.sqrt(1.0 * (2.0 - 1.0) / (3.0 * (3.0 - 2.0)))
    sim = Simulation(top((1.0, 2.0, 3.0), (w1, 0.5, w3), dt=0.01), integrator=name)
    energy = sim.energy()
    sim.step(20_000)
    assert np.isfinite(sim.state.values).all()
    assert abs(sim.energy() / energy - 1.0) < 1e-11  # round-off


@pytest.mark.parametrize('name', ['dmv6', 'dmv10', 'exact_rotor', 'rk4', 'implicit_midpoint'])
@pytest.mark.parametrize('size', [0.0, 5e-324, 1e-310, 1e-160])
def test_no_rotation_and_hardly_any_rotation_are_no_special_cases(name, size):
    sim = Simulation(top((1.0, 2.0, 3.0), (size, size, size), dt=0.001), integrator=name)
    sim.step(100)
    np.testing.assert_array_equal(sim.state.orientation[0, 3], 1.0)
    assert np.isfinite(sim.state.values).all()


def test_a_spring_between_masses_of_ratio_1e9_swings_at_the_frequency_of_the_light_one():
    scene = load_scene(
        {
            'version': 1,
            'name': 'ratio',
            'dt': 0.001,
            'bodies': [
                {'name': 'heavy', 'mass': 1e9, 'shape': {'type': 'particle'}},
                {
                    'name': 'light',
                    'mass': 1.0,
                    'shape': {'type': 'particle'},
                    'initial': {'position': [1, 0, 0]},
                },
            ],
            'forces': [{'type': 'spring', 'a': 'heavy', 'b': 'light', 'stiffness': 4.0}],
        }
    )
    sim = Simulation(scene, integrator='rk4')
    sim.step(10_000)
    # reduced mass: 1 - 1e-9 kg; truncation of rk4 at h omega = 0.002: 1e-12
    expected = math.cos(2.0 * math.sqrt(1.0 + 1e-9) * 10.0)
    separation = sim.state.position[1, 0] - sim.state.position[0, 0]
    assert separation == pytest.approx(expected, abs=1e-10)
    np.testing.assert_allclose(sim.momentum(), 0.0, atol=1e-10)  # round-off


@pytest.mark.parametrize('stiffness', [1e2, 1e4, 1e6, 1e9, 1e12])
@pytest.mark.parametrize('name', ['implicit_euler', 'sdirk2', 'implicit_midpoint'])
def test_stiff_springs_stay_bounded_whatever_the_step(name, stiffness):
    scene = load_scene(
        {
            'version': 1,
            'name': 'stiff',
            'dt': 0.01,
            'bodies': [
                {
                    'name': 'ball',
                    'mass': 1.0,
                    'shape': {'type': 'particle'},
                    'initial': {'position': [1, 0, 0]},
                }
            ],
            'forces': [{'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': stiffness}],
        }
    )
    sim = Simulation(scene, integrator=name)
    energy = sim.energy()
    sim.step(1000)
    assert sim.energy() <= energy * (1.0 + 1e-9)  # round-off of a thousand solves
