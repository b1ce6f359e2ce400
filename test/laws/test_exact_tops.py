# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The closed forms of tops against Taylor series in 34-digit arithmetic, and their limits.

An angle tolerance is round-off: 1.1e-16 times the angle turned through (the phase nu t and the
precession are products of a rounded rate and a time), a few operations deep: `round_off`.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from itertools import permutations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rigid_body_sim.exact import free_asymmetric_top, free_symmetric_top, heavy_top, held_wrench
from rigid_body_sim.exact.attitude import angle_between, product, rotate, turn
from rigid_body_sim.exact.quadratic_flow import DIGITS, euler_terms, rotation_terms, solution

TILTED = np.array([0.1, -0.5, 0.7, 0.5])  # [-] exactly of length 1 in decimals, not in doubles
TILTED = TILTED / np.linalg.norm(TILTED)


def round_off(angle: float) -> float:
    """Angle error [rad] of a closed form after `angle` [rad]: 4 ulp of it, and 4 of the start."""
    return 4 * 1.2e-16 * (angle + 4.0)


def free_reference(inertia, w, times, *, step, orientation=(0.0, 0.0, 0.0, 1.0)):
    """Angular velocity (body) and orientation of a free body from the Taylor series."""
    terms = euler_terms(inertia) + rotation_terms(1, 4)
    rows = solution(terms, [*w, *orientation], times, step=step)
    return rows[:, :3], rows[:, 3:]


def check_free(inertia, w, times, *, step, orientation=(0.0, 0.0, 0.0, 1.0)):
    """Compare the free top with the series; the tolerance is round-off of the angle turned."""
    rates, attitude = free_reference(inertia, w, times, step=step, orientation=orientation)
    motion = free_asymmetric_top.rotation(
        times, inertia=inertia, angular_velocity_body=w, orientation=orientation
    )
    speed = np.linalg.norm(rates, axis=1).max()
    allowed = round_off(speed * max(times))
    assert angle_between(motion.orientation, attitude).max() < allowed
    assert np.abs(motion.angular_velocity_body - rates).max() < speed * allowed


def test_asymmetric_top_flips_exactly_for_a_hundred_seconds():
    """The spin near the middle axis of I = (1, 2, 3): five flips, 1e-13 rad asked."""
    inertia, w, times = (1.0, 2.0, 3.0), (0.01, 1.0, 0.01), [0.0, 10.0, 50.0, 100.0]
    rates, attitude = free_reference(inertia, w, times, step=0.5)
    motion = free_asymmetric_top.rotation(times, inertia=inertia, angular_velocity_body=w)
    assert angle_between(motion.orientation, attitude).max() < 1e-13
    assert_allclose(motion.angular_velocity_body, rates, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize('inertia', list(permutations((1.0, 2.0, 3.0))), ids=str)
@pytest.mark.parametrize(
    'w',
    [
        (0.3, -0.5, 0.7),
        (-0.9, 0.4, 0.1),
        pytest.param((0.1, 0.2, -0.9), marks=pytest.mark.long),
    ],
    ids=['about_z', 'about_minus_x', 'about_minus_z'],
)
def test_asymmetric_top_whatever_the_order_of_its_axes(inertia, w):
    """Six orders of the moments, left- and right-handed, both branches and senses of rotation."""
    check_free(inertia, w, [0.0, 3.0, 11.0], step=0.4, orientation=TILTED)


def test_needle_keeps_its_digits():
    """Moments in the ratio 1000: the wrong precession axis would lose three of them."""
    check_free((1e-3, 1.0, 1.0005), (80.0, 60.0, 2.0), [0.1, 0.5], step=0.005)


@pytest.mark.parametrize('inertia', [(1.0, 1.0, 1.5), (1.5, 1.0, 1.0), (2.0, 1.0, 2.0)], ids=str)
def test_equal_moments_need_no_special_case(inertia):
    """The general solution at I1 = I2 and I2 = I3, where its modulus is zero."""
    check_free(inertia, (0.3, 0.5, 0.7), [0.0, 9.0], step=0.4)


def test_motion_on_the_separatrix_ends_in_the_middle_axis():
    """
    G^2 = 2 T I2 to the last bit: sn = tanh, one flip and no second.

    Moments and rates are dyadic, so that the double-precision data lie on it exactly.
    """
    inertia = (72 / 128, 144 / 128, 169 / 128)
    w = (65 / 64, 1.0, 72 / 64)
    check_free(inertia, w, [0.0, 2.0, 8.0], step=0.2)
    assert np.isinf(free_asymmetric_top.period(inertia=inertia, angular_velocity_body=w))
    late = free_asymmetric_top.rotation(1e3, inertia=inertia, angular_velocity_body=w)
    momentum = np.linalg.norm(np.multiply(inertia, w))
    assert_allclose(
        late.angular_velocity_body, [0.0, momentum / inertia[1], 0.0], rtol=0.0, atol=1e-15
    )
    assert np.isfinite(late.orientation).all()


@pytest.mark.parametrize('offset', [1e-4, 1e-8])
def test_spin_next_to_the_separatrix_flips_on_time(offset):
    """Middle-axis spin with a tiny push, which grows as e^(t/sqrt(3)) before the first flip."""
    check_free((1.0, 2.0, 3.0), (offset, 1.0, offset), [4.0, 30.0], step=0.4)


def test_steady_rotations_stay():
    """A sphere and a spin about a principal axis keep w; no motion keeps the attitude."""
    w = np.array([0.3, -0.4, 1.2])  # [rad/s] of length 1.3
    sphere = free_asymmetric_top.rotation(2.0, inertia=(3.0, 3.0, 3.0), angular_velocity_body=w)
    assert_allclose(sphere.orientation, turn(w / 1.3, 2.6), rtol=0.0, atol=round_off(2.6))
    axial = free_asymmetric_top.rotation(
        2.0, inertia=(1.0, 2.0, 3.0), angular_velocity_body=(0.0, -0.7, 0.0), orientation=TILTED
    )
    expected = held_wrench.held_torque(
        2.0, axis=1, inertia=2.0, torque=0.0, angular_velocity=-0.7, orientation=TILTED
    )
    assert angle_between(axial.orientation, expected.orientation) < round_off(1.4)
    assert_allclose(
        axial.angular_velocity_body, expected.angular_velocity_body, rtol=0.0, atol=0.0
    )
    still = free_asymmetric_top.rotation(
        [0.0, 5.0], inertia=(1.0, 2.0, 3.0), angular_velocity_body=(0, 0, 0), orientation=TILTED
    )
    assert_allclose(still.orientation, [TILTED, TILTED], rtol=0.0, atol=0.0)


def test_angular_velocity_returns_after_one_period_and_never_before():
    """w(T) = w(0), w(T/2) has two components turned about; the attitude does not return."""
    data = {'inertia': (1.0, 2.0, 3.0), 'angular_velocity_body': (0.3, 1.0, 0.5)}
    period = free_asymmetric_top.period(**data)
    motion = free_asymmetric_top.rotation([0.0, 0.5 * period, period], **data)
    start, half, end = motion.angular_velocity_body
    assert_allclose(end, start, rtol=0.0, atol=round_off(period))
    assert_allclose(np.abs(half), np.abs(start), rtol=0.0, atol=round_off(period))
    assert np.sum(np.sign(half) != np.sign(start)) == 2
    assert angle_between(motion.orientation[0], motion.orientation[2]) > 0.1


def test_free_top_keeps_its_angular_momentum_in_the_world_at_late_times():
    """R(t) I w(t) = L after 1e6 s, whatever the phase: round-off of one rotation."""
    inertia, w = np.array([1.0, 2.0, 3.0]), np.array([0.2, 1.0, -0.4])
    motion = free_asymmetric_top.rotation(
        [[0.0, 1e3], [1e5, 1e6]], inertia=inertia, angular_velocity_body=w, orientation=TILTED
    )
    momentum = rotate(motion.orientation, inertia * motion.angular_velocity_body)
    assert momentum.shape == (2, 2, 3)
    assert_allclose(momentum, np.broadcast_to(momentum[0, 0], (2, 2, 3)), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize('axial', [0.4, 1.0, 1.7], ids=['rod', 'sphere', 'disc'])
def test_symmetric_top_precesses_about_its_angular_momentum(axial):
    """R = exp(t [L]/I1) R0 exp(t w3 (1 - I3/I1) [e3])."""
    w, times = (0.3, -0.4, 1.2), [0.0, 4.0, 15.0]
    rates, attitude = free_reference((1.0, 1.0, axial), w, times, step=0.3, orientation=TILTED)
    motion = free_symmetric_top.rotation(
        times,
        inertia_across=1.0,
        inertia_axial=axial,
        angular_velocity_body=w,
        orientation=TILTED,
    )
    allowed = round_off(2.1 * 15.0)
    assert angle_between(motion.orientation, attitude).max() < allowed
    assert_allclose(motion.angular_velocity_body, rates, rtol=0.0, atol=allowed)


def heavy_reference(start, tilt, times, *, across, axial, weight_moment, step):
    """
    Lagrange top from its equations in body axes, q(0) = R_x(tilt).

    With g = R^T e_z:  I w' = I w x w + m g l (g2, -g1, 0),  g' = g x w
    """
    with localcontext() as context:
        context.prec = DIGITS
        push = Decimal(weight_moment) / Decimal(across)
    gravity = [(1, push, 5, 0), (2, -push, 4, 0)]
    carried = [
        (4, 1, 5, 3),
        (4, -1, 6, 2),
        (5, 1, 6, 1),
        (5, -1, 4, 3),
        (6, 1, 4, 2),
        (6, -1, 5, 1),
    ]
    q = turn((1.0, 0.0, 0.0), tilt)
    rows = solution(
        euler_terms((across, across, axial)) + gravity + carried + rotation_terms(1, 7),
        [*start, 0.0, np.sin(tilt), np.cos(tilt), *q],
        times,
        step=step,
    )
    return rows[:, :3], rows[:, 6:]


CUSPED = {
    'fast': (1.0, 1.5, 2.0, 6.0, 1.0),
    'slow': (1.0, 0.5, 2.0, 1.0, 1.0),
    'hanging_backwards': (1.0, 1.5, 2.0, -3.0, 2.0),
    'almost_a_pendulum': (1.0, 0.2, 2.0, 0.1, 0.1),
}


@pytest.mark.parametrize('case', CUSPED)
def test_heavy_top_with_cusps_solves_its_equation(case):
    """Released with spin alone; precession and nutation by elliptic functions."""
    across, axial, weight_moment, spin, tilt = CUSPED[case]
    times = [0.0, 1.0, 4.0]
    rates, attitude = heavy_reference(
        (0.0, 0.0, spin),
        tilt,
        times,
        across=across,
        axial=axial,
        weight_moment=weight_moment,
        step=0.1,
    )
    motion = heavy_top.cusped(
        times,
        inertia_across=across,
        inertia_axial=axial,
        weight_moment=weight_moment,
        spin=spin,
        tilt=tilt,
    )
    allowed = round_off(9.0 * 4.0)
    assert angle_between(motion.orientation, attitude).max() < allowed
    assert np.abs(motion.angular_velocity_body - rates).max() < 9.0 * allowed


def test_steady_precession_solves_its_equation():
    """A top with the spin that its precession asks for keeps its tilt."""
    top = {'inertia_across': 1.0, 'inertia_axial': 1.5, 'weight_moment': 2.0, 'tilt': 0.8}
    precession, times = 0.5, [0.0, 2.0, 6.0]
    spin = heavy_top.spin_for(precession, **top)
    motion = heavy_top.steady(times, precession=precession, spin=spin, tilt=0.8)
    rates, attitude = heavy_reference(
        motion.angular_velocity_body[0],
        0.8,
        times,
        across=1.0,
        axial=1.5,
        weight_moment=2.0,
        step=0.15,
    )
    allowed = round_off(spin * 6.0)
    assert angle_between(motion.orientation, attitude).max() < allowed
    assert_allclose(motion.angular_velocity_body, rates, rtol=0.0, atol=spin * allowed)


def test_slow_precession_and_spin_belong_together():
    """I1 W^2 cos(theta) - I3 w3 W + m g l = 0; a spin too slow has no steady precession."""
    top = {'inertia_across': 1.0, 'inertia_axial': 1.5, 'weight_moment': 2.0, 'tilt': 0.8}
    for spin in (6.0, -6.0):
        assert_allclose(
            heavy_top.spin_for(heavy_top.slow_precession(spin, **top), **top), spin, rtol=4e-15
        )
    assert np.isnan(heavy_top.slow_precession(0.5, **top))


def test_rates_of_the_tops_are_the_derivatives_of_their_attitudes():
    """q* q' = (w, 0)/2 by central differences: the two halves of a closed form fit each other."""
    h, t = 1e-4, np.linspace(0.3, 9.0, 12)
    top = {'inertia_across': 1.0, 'inertia_axial': 1.5, 'weight_moment': 2.0}
    motions = [
        lambda s: heavy_top.cusped(s, spin=3.0, tilt=0.6, **top),
        lambda s: heavy_top.steady(s, precession=0.5, spin=3.0, tilt=0.6),
        lambda s: free_asymmetric_top.rotation(
            s, inertia=(3.0, 1.0, 2.5), angular_velocity_body=(0.3, 0.8, -0.9)
        ),
    ]
    for motion in motions:
        between = product(
            motion(t - h).orientation * [-1.0, -1.0, -1.0, 1.0], motion(t + h).orientation
        )
        rate = np.sign(between[:, 3:]) * between[:, :3] / h
        # Truncation h^2/6 times the third derivative (some 30 /s^3), round-off 1e-16/h.
        assert_allclose(rate, motion(t).angular_velocity_body, rtol=0.0, atol=1e-6)
