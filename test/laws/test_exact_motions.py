# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The closed forms of translation, friction and impact against independent high-precision references.

Unless stated otherwise a tolerance is round-off of the closed form itself: some ten operations of
1.1e-16 relative to the largest number in the formula, hence 4e-15 of that number.
"""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rigid_body_sim.exact import (
    ballistic,
    collision,
    drag,
    held_wrench,
    oscillator,
    rocket,
    sliding,
)
from rigid_body_sim.exact.attitude import angle_between, product, rotate, turn
from rigid_body_sim.exact.quadratic_flow import solution

ROUND_OFF = 4e-15  # [-] relative to the largest number in the formula
GRAVITY = 9.81  # [m/s^2]


def ratio(numerator: float, denominator: float) -> Decimal:
    """Quotient of two doubles to 28 digits, so that the reference solves the very same problem."""
    return Decimal(float(numerator)) / Decimal(float(denominator))


def test_turns_compose_and_rotate_vectors_right_handedly():
    """A quarter turn about z takes x to y; two turns about one axis add."""
    quarter = turn((0.0, 0.0, 1.0), np.pi / 2)
    assert_allclose(rotate(quarter, (1.0, 0.0, 0.0)), (0.0, 1.0, 0.0), rtol=0.0, atol=ROUND_OFF)
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    twice = product(turn(axis, 0.3), turn(axis, 0.4))
    assert_allclose(angle_between(twice, turn(axis, 0.7)), 0.0, rtol=0.0, atol=ROUND_OFF)


def test_angle_between_attitudes_keeps_its_digits_near_zero():
    """1e-9 rad is seen as 1e-9 rad, though its cosine is 1 in double precision."""
    assert_allclose(
        angle_between(turn((1.0, 0.0, 0.0), 0.5), turn((1.0, 0.0, 0.0), 0.5 + 1e-9)),
        1e-9,
        rtol=0.0,
        atol=ROUND_OFF,
    )


def test_ballistic_flight_solves_its_equation():
    """Check r' = v, v' = g, as a Taylor series."""
    times = [0.0, 0.5, 2.0, 7.0]
    reference = solution([(1, 1, 2, 0), (2, -GRAVITY, 0, 0)], [1.5, 12.0], times, step=10.0)
    motion = ballistic.flight(times, position=[1.5], velocity=[12.0], acceleration=[-GRAVITY])
    assert_allclose(motion.position[:, 0], reference[:, 0], rtol=0.0, atol=240.0 * ROUND_OFF)
    assert_allclose(motion.velocity[:, 0], reference[:, 1], rtol=0.0, atol=70.0 * ROUND_OFF)


def test_held_force_gives_half_f_over_m_t_squared():
    """From rest; each axis on its own."""
    motion = held_wrench.held_force([3.0], mass=2.0, force=(1.0, 0.0, -4.0))
    assert_allclose(motion.position, [[2.25, 0.0, -9.0]], rtol=0.0, atol=9.0 * ROUND_OFF)
    assert_allclose(motion.velocity, [[1.5, 0.0, -6.0]], rtol=0.0, atol=6.0 * ROUND_OFF)


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_held_torque_turns_by_half_tau_over_i_t_squared(axis: int):
    """Check q' = q (w, 0)/2 with w' = tau/I about one axis: three numbers suffice."""
    times, half, rate = [0.0, 0.4, 1.7, 6.0], Decimal('0.5'), ratio(0.7, 0.3)
    reference = solution(
        [(1, rate, 0, 0), (2, half, 3, 1), (3, -half, 2, 1)], [0.9, 0.0, 1.0], times, step=0.03
    )
    motion = held_wrench.held_torque(
        times, axis=axis, inertia=0.3, torque=0.7, angular_velocity=0.9
    )
    # The angle reaches 47 rad: its round-off, half of it in the quaternion.
    assert_allclose(motion.orientation[:, axis], reference[:, 1], rtol=0.0, atol=25.0 * ROUND_OFF)
    assert_allclose(motion.orientation[:, 3], reference[:, 2], rtol=0.0, atol=25.0 * ROUND_OFF)
    assert_allclose(
        motion.angular_velocity_body[:, axis], reference[:, 0], rtol=0.0, atol=15.0 * ROUND_OFF
    )
    assert np.count_nonzero(motion.orientation[:, [i for i in range(3) if i != axis]]) == 0


OSCILLATORS = {
    'undamped': (1.5, 40.0, 0.0),
    'under_damped': (1.5, 40.0, 0.8),
    'almost_critical_below': (1.0, 4.0, 4.0 * (1.0 - 1e-9)),
    'critical': (1.0, 4.0, 4.0),
    'almost_critical_above': (1.0, 4.0, 4.0 * (1.0 + 1e-9)),
    'over_damped': (0.5, 3.0, 9.0),
    'free_with_damping': (0.5, 0.0, 0.7),
}


@pytest.mark.parametrize('case', OSCILLATORS)
def test_oscillator_propagator_solves_its_equation(case: str):
    """Check m x'' = -k x - c x' from unit position and from unit velocity."""
    mass, stiffness, damping = OSCILLATORS[case]
    times = [0.0, 0.1, 1.0, 4.0]
    terms = [(1, 1, 2, 0), (2, -ratio(stiffness, mass), 1, 0), (2, -ratio(damping, mass), 2, 0)]
    matrices = oscillator.propagator(times, mass=mass, stiffness=stiffness, damping=damping)
    for column, start in enumerate(([1, 0], [0, 1])):
        reference = solution(terms, start, times, step=0.02)
        # Largest entry w0 = 5; the phase w t = 20 rad carries its own round-off.
        assert_allclose(matrices[:, :, column], reference, rtol=0.0, atol=20.0 * ROUND_OFF)


def test_oscillator_with_constant_force_swings_about_its_equilibrium():
    """Check m x'' = -k x - c x' + F in the plane."""
    times, mass, stiffness, damping = [0.0, 0.3, 2.0], 2.0, 30.0, 0.5
    motion = oscillator.oscillation(
        times,
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        force=(0.0, -2.0 * GRAVITY),
        position=(1.0, -0.5),
        velocity=(0.0, 2.0),
    )
    for axis, (force, x, v) in enumerate([(0.0, 1.0, 0.0), (-2.0 * GRAVITY, -0.5, 2.0)]):
        terms = [
            (1, 1, 2, 0),
            (2, -ratio(stiffness, mass), 1, 0),
            (2, -ratio(damping, mass), 2, 0),
            (2, ratio(force, mass), 0, 0),
        ]
        reference = solution(terms, [x, v], times, step=0.05)
        assert_allclose(motion.position[:, axis], reference[:, 0], rtol=0.0, atol=10.0 * ROUND_OFF)
        assert_allclose(motion.velocity[:, axis], reference[:, 1], rtol=0.0, atol=10.0 * ROUND_OFF)


def test_stiff_over_damped_oscillator_neither_overflows_nor_loses_its_slow_mode():
    """At k = 1, c = 1e8, x decays as e^(-k t/c); cosh e^(-g t) would be inf times 0."""
    matrix = oscillator.propagator(1e8, mass=1.0, stiffness=1.0, damping=1e8)
    # Slow exponent -k/c (1 + k m/c^2 + ...): the correction is 1e-16 relative.
    assert_allclose(matrix[0, 0], np.exp(-1.0), rtol=ROUND_OFF)
    assert_allclose(matrix[0, 1], 1e-8 * np.exp(-1.0), rtol=ROUND_OFF)


def test_flight_with_linear_drag_solves_its_equation():
    """Check m v' = m g - c v."""
    times, mass, c = [0.0, 0.2, 3.0, 20.0], 0.8, 0.5
    terms = [(1, 1, 2, 0), (2, -GRAVITY, 0, 0), (2, -ratio(c, mass), 2, 0)]
    reference = solution(terms, [10.0, 25.0], times, step=0.5)
    motion = drag.linear(
        times,
        mass=mass,
        coefficient=c,
        acceleration=[-GRAVITY],
        position=[10.0],
        velocity=[25.0],
    )
    assert_allclose(motion.position[:, 0], reference[:, 0], rtol=0.0, atol=320.0 * ROUND_OFF)
    assert_allclose(motion.velocity[:, 0], reference[:, 1], rtol=0.0, atol=40.0 * ROUND_OFF)


def test_fall_with_quadratic_drag_solves_its_equation():
    """Check v' = -g + (b/m) v^2 while falling; early, midway, and at terminal speed."""
    times, mass, b = [0.0, 1e-3, 0.4, 2.0, 12.0], 0.8, 0.05
    terms = [(1, 1, 2, 0), (2, -GRAVITY, 0, 0), (2, ratio(b, mass), 2, 2)]
    reference = solution(terms, [0.0, 0.0], times, step=0.1)
    motion = drag.quadratic_fall(times, mass=mass, coefficient=b, gravity=GRAVITY)
    assert_allclose(motion.position[:, 0], reference[:, 0], rtol=ROUND_OFF, atol=0.0)
    assert_allclose(motion.velocity[:, 0], reference[:, 1], rtol=ROUND_OFF, atol=0.0)


def test_rise_with_quadratic_drag_solves_its_equation_up_to_its_apex():
    """Check v' = -g - (b/m) v^2 while rising; the apex has no speed and the stated height."""
    mass, b, speed = 0.8, 0.05, 30.0
    data = {'mass': mass, 'coefficient': b, 'gravity': GRAVITY, 'speed': speed}
    time, height = drag.apex(**data)
    times = [0.0, 0.1, 0.7, time]
    terms = [(1, 1, 2, 0), (2, -GRAVITY, 0, 0), (2, -ratio(b, mass), 2, 2)]
    reference = solution(terms, [0.0, speed], times, step=0.02)
    motion = drag.quadratic_rise(times, **data)
    assert_allclose(motion.position[:, 0], reference[:, 0], rtol=0.0, atol=height * ROUND_OFF)
    assert_allclose(motion.velocity[:, 0], reference[:, 1], rtol=0.0, atol=speed * ROUND_OFF)
    assert_allclose(
        [motion.position[-1, 0], motion.velocity[-1, 0]], [height, 0.0], rtol=0.0, atol=1e-13
    )


def test_rocket_solves_its_equation():
    """Check v' = v_e mu/m - g with m' = -mu; 1/m as a variable of its own, (1/m)' = mu/m^2."""
    times, mass, flow, exhaust = [0.0, 1.0, 20.0, 38.0], 100.0, 2.5, 2000.0
    thrust = Decimal(exhaust) * Decimal(flow)
    terms = [(1, 1, 2, 0), (2, thrust, 3, 0), (2, -GRAVITY, 0, 0), (3, Decimal(flow), 3, 3)]
    reference = solution(terms, [5.0, 3.0, ratio(1.0, mass)], times, step=0.2)
    motion = rocket.ascent(
        times,
        mass=mass,
        mass_flow=flow,
        exhaust_speed=exhaust,
        gravity=GRAVITY,
        height=5.0,
        speed=3.0,
    )
    # 5 % of the mass is left: log1p(-0.95) loses a factor 1/0.05 of the round-off of its argument.
    assert_allclose(motion.position[:, 0], reference[:, 0], rtol=0.0, atol=80e3 * ROUND_OFF)
    assert_allclose(motion.velocity[:, 0], reference[:, 1], rtol=0.0, atol=6e3 * ROUND_OFF)


def test_block_rests_when_friction_has_eaten_its_kinetic_energy():
    """Check mu m g d = m v0^2/2; before that the deceleration is mu g."""
    time, distance = sliding.stopping(speed=4.0, friction=0.3, gravity=GRAVITY)
    assert_allclose(0.3 * GRAVITY * distance, 8.0, rtol=ROUND_OFF)
    slide = sliding.block([0.5 * time, time, 9.0], speed=4.0, friction=0.3, gravity=GRAVITY)
    assert_allclose(slide.speed, [2.0, 0.0, 0.0], rtol=0.0, atol=4.0 * ROUND_OFF)
    assert_allclose(slide.distance, [0.75 * distance, distance, distance], rtol=ROUND_OFF)


@pytest.mark.parametrize('beta', [0.4, 0.5, 1.0])
def test_wheel_keeps_its_angular_momentum_about_the_ground(beta: float):
    """Check that v + beta R w is constant: friction passes through the contact; then it rolls."""
    data = {'speed': 7.0, 'friction': 0.2, 'gravity': GRAVITY, 'beta': beta}
    start, rolling = sliding.rolling_start(**data)
    times = np.array([0.0, 0.3 * start, start, 2.0 * start])
    slide = sliding.wheel(times, **data)
    assert_allclose(slide.speed + beta * slide.surface_speed, 7.0, rtol=ROUND_OFF)
    assert_allclose(slide.speed[2:], slide.surface_speed[2:], rtol=ROUND_OFF)
    # Work: mu g times the slipped way is the energy that is missing.
    slipped = 0.5 * 7.0 * start
    missing = 0.5 * 7.0**2 - 0.5 * (1.0 + beta) * rolling**2
    assert_allclose(0.2 * GRAVITY * slipped, missing, rtol=ROUND_OFF)
    assert_allclose(slide.distance[2], 0.5 * (7.0 + rolling) * start, rtol=ROUND_OFF)
    assert_allclose(slide.distance[3] - slide.distance[2], rolling * start, rtol=ROUND_OFF)


def test_solid_sphere_rolls_with_five_sevenths_of_its_speed():
    """The textbook numbers 2 v0/(7 mu g) and 5 v0/7."""
    start, rolling = sliding.rolling_start(speed=7.0, friction=0.2, gravity=GRAVITY, beta=0.4)
    assert_allclose([start, rolling], [2.0 / (0.2 * GRAVITY), 5.0], rtol=ROUND_OFF)


@pytest.mark.parametrize('restitution', [0.0, 0.6, 1.0])
def test_impact_obeys_momentum_restitution_and_the_energy_balance(restitution: float):
    """Three laws that fix the two velocities and the loss; across the normal nothing changes."""
    normal = np.array([2.0, -1.0, 2.0]) / 3.0
    a, b = np.array([3.0, 1.0, 2.0]), np.array([-1.0, 0.5, 0.0])
    after = collision.impact(
        mass_a=2.0,
        mass_b=5.0,
        velocity_a=a,
        velocity_b=b,
        normal=normal,
        restitution=restitution,
    )
    assert_allclose(
        2.0 * after.velocity_a + 5.0 * after.velocity_b, 2.0 * a + 5.0 * b, rtol=0.0, atol=5e-14
    )
    parting, closing = (after.velocity_b - after.velocity_a) @ normal, (a - b) @ normal
    assert_allclose(parting, restitution * closing, rtol=0.0, atol=4.0 * ROUND_OFF)
    before = a @ a + 2.5 * b @ b
    left = after.velocity_a @ after.velocity_a + 2.5 * after.velocity_b @ after.velocity_b
    assert_allclose(before - left, after.energy_lost, rtol=0.0, atol=20.0 * ROUND_OFF)
    assert_allclose(np.cross(after.velocity_a - a, normal), 0.0, rtol=0.0, atol=4.0 * ROUND_OFF)


def test_impact_with_a_wall_mirrors_and_parting_bodies_do_not_touch():
    """Infinite mass takes no velocity; a negative closing speed gives no impulse."""
    velocity = np.array([1.0, -2.0])
    data = {'mass_a': 1.0, 'mass_b': np.inf, 'velocity_b': (0.0, 0.0), 'restitution': 1.0}
    hit = collision.impact(velocity_a=velocity, normal=(0.0, -1.0), **data)
    assert_allclose(hit.velocity_a, [1.0, 2.0], rtol=ROUND_OFF)
    assert_allclose(hit.velocity_b, 0.0, rtol=0.0, atol=0.0)
    assert not collision.impact(velocity_a=velocity, normal=(0.0, 1.0), **data).impulse.any()


def test_bouncing_ball_follows_its_flights_one_after_the_other():
    """Simulated flight by flight: fall, reverse with factor e, fly 2 v/g, again."""
    height, e = 1.3, 0.8
    data = {'height': height, 'gravity': GRAVITY, 'restitution': e}
    time, speed = np.sqrt(2.0 * height / GRAVITY), np.sqrt(2.0 * height * GRAVITY)
    impacts = collision.bounce_times(12, **data)
    for impact in impacts:
        assert_allclose(impact, time, rtol=ROUND_OFF)
        speed *= e
        flight = 2.0 * speed / GRAVITY
        at = time + np.array([0.25, 0.5, 0.75]) * flight
        motion = collision.bouncing(at, **data)
        top = speed**2 / (2.0 * GRAVITY)
        # Round-off of the time, some 5 s, times the speed.
        assert_allclose(motion.position[:, 0], [0.75 * top, top, 0.75 * top], rtol=0.0, atol=1e-13)
        assert_allclose(
            motion.velocity[:, 0], [0.5 * speed, 0.0, -0.5 * speed], rtol=0.0, atol=1e-13
        )
        time += flight
    many = collision.bounce_times(200, **data)[-1]
    end = collision.rest_time(**data)
    # e^200 = 4e-20 of the time is still to come.
    assert_allclose(many, end, rtol=4.0 * ROUND_OFF)
    resting = collision.bouncing([end, 2.0 * end], **data)
    assert not resting.position.any() and not resting.velocity.any()
