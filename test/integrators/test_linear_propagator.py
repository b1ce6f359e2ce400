# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The exact propagator of linear systems of points."""

import math

import mpmath
import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.exact import oscillator
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.schemes import linear_motion

from . import scenes

NAME = 'linear_propagator'


def reference(k, c, h):
    """Fifty digits of what `linear_motion.oscillator` returns."""
    with mpmath.workdps(60):
        k, c, h = mpmath.mpf(k), mpmath.mpf(c), mpmath.mpf(h)
        g = c / 2
        q = mpmath.sqrt(g * g - k + mpmath.mpf(10) ** -50)
        cosh, sinh = mpmath.cosh(q * h), mpmath.sinh(q * h)
        big_c = (mpmath.exp(-g * h) * cosh).real
        big_s = (mpmath.exp(-g * h) * sinh / q).real
        rr, vv = big_c + g * big_s, big_c - g * big_s
        if k:
            psi = (1 - rr) / k
        else:
            psi = (h - big_s) / c if c else h * h / 2
        return [float(x) for x in (rr, big_s, -k * big_s, vv, psi, big_s, rr - 1, vv - 1)]


@pytest.mark.parametrize(
    ('k', 'c', 'h'),
    [
        (100.0, 0.0, 0.1),
        (100.0, 2.0, 0.05),
        (1e8, 2e4, 1e-3),  # critical
        (1e4, 200.0 * (1.0 + 1e-9), 0.1),  # nearly so
        (1e4, 199.9, 0.3),
        (1e4, 1e6, 0.01),  # slow mode 0.01 / s beside one of 1e6 / s
        (0.0, 3.0, 0.1),
        (0.0, 0.0, 0.1),
        (0.0, 1e6, 10.0),
        (0.0, 0.6, 1.0),  # too strong for one series, too weak for the other
        (1e-9, 0.63, 1.0),
        (1e-10, 1e3, 1.0),
        (1e-12, 1e-6, 1.0),
        (2.0, 1e-9, 0.3),
    ],
)
def test_propagator_agrees_with_fifty_digits(k, c, h):
    # each entry right to its own last digits; rounding of the exponent adds a few
    np.testing.assert_allclose(
        linear_motion.oscillator(k, c, h), reference(k, c, h), rtol=3e-15, atol=1e-25
    )


@pytest.mark.parametrize('h', [0.001, 0.25])
@pytest.mark.parametrize('damping', [0.0, 0.8, 4.0, 4.0000001, 50.0])
def test_oscillator_is_exact_in_every_regime_of_damping(damping, h):
    sim = Simulation(scenes.oscillator(dt=h, damping=damping), integrator=NAME)
    sim.step(round(2.0 / h))
    exact = oscillator.oscillation(2.0, mass=1.0, stiffness=4.0, damping=damping, position=1.0)
    # round-off of up to 2000 products with the same matrix: 1e-16 each, all to one side
    assert sim.state.position[0, 0] == pytest.approx(float(exact.position[0]), abs=5e-13)
    assert sim.state.velocity[0, 0] == pytest.approx(float(exact.velocity[0]), abs=5e-13)


@pytest.mark.parametrize('dt', [0.1, 0.25])
def test_a_hundred_periods_leave_round_off(dt):
    sim = Simulation(scenes.oscillator(dt=dt, stiffness=(2.0 * math.pi) ** 2), integrator=NAME)
    sim.step(round(100.0 / dt))
    # round-off of 1000 products, and of k: 100 turns of 2 pi to 1e-16
    assert math.hypot(sim.state.position[0, 0] - 1.0, sim.state.velocity[0, 0] / 6.28) < 1e-12


def test_a_critically_damped_motion_decays_below_the_rounding_of_its_start():
    sim = Simulation(scenes.oscillator(dt=1e-4, stiffness=1e8, damping=2e4), integrator=NAME)
    sim.step(100)
    assert sim.state.position[0, 0] == pytest.approx(101.0 * math.exp(-100.0), rel=1e-12)


def test_linked_points_move_as_a_fine_run_of_another_method():
    coarse, fine = scenes.linked_points(dt=0.5), scenes.linked_points(dt=0.0005)
    exact = Simulation(coarse, integrator=NAME)
    exact.set_wrench('c', force=(1.0, -2.0, 0.5))
    exact.step(10)
    other = Simulation(fine, integrator='rk4')
    other.set_wrench('c', force=(1.0, -2.0, 0.5))
    other.step(10_000)
    # truncation of rk4: (h omega)^4, omega = 5 / s; round-off
    np.testing.assert_allclose(exact.state.position, other.state.position, atol=1e-11)
    np.testing.assert_allclose(exact.state.velocity, other.state.velocity, atol=1e-11)


def test_points_that_nothing_holds_fall_along_the_exact_parabola():
    bodies = [
        {'name': n, 'shape': {'type': 'particle'}, 'mass': m, 'initial': {'position': [x, 0, 0]}}
        for n, m, x in (('a', 1.0, 0.0), ('b', 3.0, 1.0))
    ]
    spring = {'type': 'spring', 'a': 'a', 'b': 'b', 'stiffness': 50.0}
    scene = scenes.scene(bodies, forces=[spring], dt=0.25, gravity=(0.0, 0.0, -9.81))
    sim = Simulation(scene, integrator=NAME)
    momentum = sim.momentum()
    sim.step(400)
    centre = np.array([1.0, 3.0]) @ sim.state.position / 4.0
    np.testing.assert_allclose(centre, [0.75, 0.0, -0.5 * 9.81 * 1e4], rtol=1e-13, atol=1e-12)
    np.testing.assert_allclose(
        sim.momentum() - momentum, [0, 0, -4 * 981.0], rtol=1e-13, atol=1e-11
    )


def test_drag_alone_and_a_fixed_anchor_are_linear_too():
    bodies = [
        {'name': 'hook', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'mass': 1.0, 'fixed': True},
        {
            'name': 'ball',
            'shape': {'type': 'particle'},
            'mass': 2.0,
            'initial': {'velocity': [1, 0, 0]},
        },
    ]
    drag = {'type': 'drag', 'body': 'ball', 'linear': 3.0}
    sim = Simulation(scenes.scene(bodies, forces=[drag], dt=0.5), integrator=NAME)
    sim.step(2)
    assert sim.state.velocity[1, 0] == pytest.approx(math.exp(-1.5), rel=1e-15)
    assert sim.state.position[1, 0] == pytest.approx(-math.expm1(-1.5) / 1.5, rel=1e-15)


def test_many_steps_in_one_call_give_the_bits_of_many_calls():
    whole, parts = (Simulation(scenes.linked_points(), integrator=NAME) for _ in range(2))
    whole.step(100)
    for _ in range(100):
        parts.step()
    assert whole.state_bytes() == parts.state_bytes()


@pytest.mark.parametrize(
    ('force', 'reason'),
    [
        (
            {'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': 1.0, 'rest_length': 0.5},
            'rest length 0.5 m',
        ),
        ({'type': 'drag', 'body': 'ball', 'quadratic': 0.5}, 'quadratic'),
    ],
)
def test_what_is_not_linear_is_refused_with_the_reason_and_another_method(force, reason):
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}
    with pytest.raises(InvalidModel, match=f'{reason}.*use sdirk2'):
        Simulation(scenes.scene([ball], forces=[force]), integrator=NAME)


def test_a_body_that_turns_is_refused():
    with pytest.raises(InvalidModel, match=r"'top' can turn.*dmv6"):
        Simulation(scenes.top(), integrator=NAME)
