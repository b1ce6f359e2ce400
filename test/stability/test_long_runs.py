# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ten million ticks: what round-off makes of them. In full only: minutes."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation

from . import cases

pytestmark = pytest.mark.long

TICKS = 10_000_000
TOP = ((1.0, 2.0, 3.0), (0.3, 1.0, 0.2))
NEEDLE = ((1e-3, 1.0, 1.0005), (0.8, 0.6, 0.02))
DMV = ('dmv2', 'dmv4', 'dmv6', 'dmv8', 'dmv10')


@pytest.mark.parametrize('dt', [0.01, 0.3, 2.5])  # the fast pass, the patient one, divided steps
@pytest.mark.parametrize('name', DMV)
def test_angular_momentum_keeps_its_last_bit_over_ten_million_ticks(name, dt):
    sim = Simulation(cases.top(*TOP, dt=dt), integrator=name)
    before = sim.state.angular_momentum.tobytes()
    for _ in range(10):
        sim.step(TICKS // 10)
        assert sim.state.angular_momentum.tobytes() == before


@pytest.mark.parametrize('name', [*DMV, 'exact_rotor', 'implicit_midpoint', 'taylor16'])
@pytest.mark.parametrize(('case', 'allowed'), [('top', 1e-12), ('needle', 1e-11)])
def test_energy_walks_at_random_by_round_off_alone(name, case, allowed):
    """
    At h |omega| = 0.02, a look every 1e6 ticks.

    The energy is a function of q alone, and q is normalised: no bias adds up. A needle magnifies
    the rounding of q by up to a thousand, its walk over 1e7 ticks is published as 1e-13 to 5e-13
    (and 2e-13 to 1e-9 where the momentum is kept in body axes).
    """
    inertia, omega = TOP if case == 'top' else NEEDLE
    sim = Simulation(cases.top(inertia, omega, dt=0.02), integrator=name)
    energy, worst = sim.energy(), 0.0
    for _ in range(10):
        sim.step(TICKS // 10)
        worst = max(worst, abs(sim.energy() / energy - 1.0))
    assert worst < allowed


@pytest.mark.parametrize(
    ('name', 'case', 'drift'),
    [
        ('rk4', 'top', 3e-7),
        ('rk4', 'needle', 4e-6),
        ('five_rotations', 'top', 2e-7),
        ('five_rotations', 'needle', 3e-6),
        ('lie_rk4', 'top', 3e-6),
        ('lie_rk4', 'needle', 2e-4),
    ],
)
def test_energy_of_the_others_drifts_no_faster_than_published(name, case, drift):
    """At h |omega| = 0.02; one digit is given, for |omega| = 1 along a direction of its own."""
    inertia, omega = TOP if case == 'top' else NEEDLE
    sim = Simulation(cases.top(inertia, omega, dt=0.02), integrator=name)
    energy = sim.energy()
    sim.step(TICKS)
    assert abs(sim.energy() / energy - 1.0) < 5.0 * drift


@pytest.mark.parametrize('name', ['dmv6', 'rk4', 'linear_propagator', 'explicit_euler'])
def test_compensated_sums_lose_nothing_in_a_hundred_million_ticks(name):
    sim = Simulation(
        cases.scene(cases.point('stone', position=[7e3, 0, 0], velocity=[0.7, 0, 0]), dt=0.001),
        integrator=name,
    )
    sim.step(10 * TICKS)
    # a plain sum is off by 1e-4; the last bit of 77000 is 1.5e-11, and 0.7 * 0.001 is itself
    # rounded, by 1e-20 at 1e8 ticks
    assert abs(sim.state.position[0, 0] - 77000.0) < 3e-11


def test_a_fall_of_ten_million_ticks_is_the_parabola():
    sim = Simulation(
        cases.scene(cases.point('stone', velocity=[1, 0, 0]), dt=0.001, gravity=(0, 0, -9.81))
    )
    sim.step(TICKS)
    time = 1e4
    np.testing.assert_allclose(sim.state.velocity[0], (1.0, 0.0, -9.81 * time), rtol=1e-15)
    np.testing.assert_allclose(
        sim.state.position[0], (time, 0.0, -9.81 * time**2 / 2.0), rtol=1e-14
    )  # round-off of h g / 2 in each kick, which is the same in each


def test_an_undamped_spring_keeps_its_energy_over_ten_million_ticks():
    """Störmer–Verlet keeps (1 - (h omega / 2)^2) k x^2 + v^2; the rest is a walk of round-off."""
    h, k = 0.01, 100.0
    sim = Simulation(cases.on_a_spring(dt=h, stiffness=k))

    def kept():
        x, v = sim.state.position[0, 0], sim.state.velocity[0, 0]
        return (1.0 - h * h * k / 4.0) * k * x * x + v * v

    before = kept()
    for _ in range(10):
        sim.step(TICKS // 10)
        assert abs(kept() / before - 1.0) < 1e-12


def test_exact_propagator_keeps_the_amplitude_of_ten_million_ticks():
    """The determinant of the matrix is 1 to 1e-16: 1e7 ticks may bring 1e-9."""
    h, k = 0.01, 100.0
    sim = Simulation(cases.on_a_spring(dt=h, stiffness=k), integrator='linear_propagator')
    sim.step(TICKS)
    x, v = sim.state.position[0, 0], sim.state.velocity[0, 0]
    assert abs(math.hypot(x, v / 10.0) - 1.0) < 2e-9
