# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""From positions and boundary conditions to velocities and accelerations."""

import numpy as np
import pytest

from rigid_body_sim import inverse_kinematics
from rigid_body_sim.errors import UserError

START, END = 0.3, 1.7  # [s]


def polynomial(degree, t, order=0):
    """Derivative of a polynomial of a degree along each axis, (n, 3)."""
    rows = np.random.default_rng(degree).uniform(-1, 1, (3, degree + 1))
    return np.stack([np.polynomial.Polynomial(row).deriv(order)(t) for row in rows], axis=1)


def swing(t, order=0):
    """Sines of three rates, (n, 3)."""
    rates = np.array([1.0, 2.0, 3.0])
    return rates**order * np.sin(np.outer(t, rates) + 0.5 * np.pi * order)


def given(motion, *names):
    """The true values of some conditions."""
    at = {'start': np.array([START]), 'end': np.array([END])}
    orders = {'velocity': 1, 'acceleration': 2}
    return {name: motion(at[name.split('_')[0]], orders[name.split('_')[1]])[0] for name in names}


CONDITIONS = [
    (),
    ('start_velocity',),
    ('start_velocity', 'end_velocity'),
    ('start_velocity', 'start_acceleration'),
    ('start_velocity', 'end_velocity', 'start_acceleration', 'end_acceleration'),
]


@pytest.mark.parametrize('names', CONDITIONS)
@pytest.mark.parametrize('even', [True, False])
def test_a_motion_of_degree_five_is_met_exactly(names, even):
    t = np.linspace(START, END, 23)
    if not even:
        t[1:-1] += np.random.default_rng(3).uniform(-0.02, 0.02, 21)

    def motion(at, order=0):
        return polynomial(5, at, order)

    found = inverse_kinematics(t, motion(t), **given(motion, *names))
    assert found.velocity == pytest.approx(motion(t, 1), abs=1e-10)  # round-off eps / h
    assert found.acceleration == pytest.approx(motion(t, 2), abs=1e-8)  # eps / h^2


@pytest.mark.parametrize('names', CONDITIONS[1:])
def test_conditions_are_kept_whether_true_or_not(names):
    t = np.linspace(START, END, 40)
    wanted = {name: np.array([0.4, -0.2, 0.1]) for name in names}
    found = inverse_kinematics(t, swing(t), **wanted)
    for name, value in wanted.items():
        side, what = name.split('_')
        kept = getattr(found, what)[0 if side == 'start' else -1]
        assert kept == pytest.approx(value, abs=1e-9)
    assert found.position == pytest.approx(swing(t), abs=1e-12)  # it goes through the samples


def error(t, motion, order, **conditions):
    found = inverse_kinematics(t, motion(t), **conditions)
    wrong = (found.velocity, found.acceleration)[order - 1] - motion(t, order)
    told = (found.velocity_error, found.acceleration_error)[order - 1]
    true = float(np.sqrt(np.mean(np.sum(np.square(wrong), axis=1))))
    return true, told


@pytest.mark.parametrize('names', [CONDITIONS[0], CONDITIONS[4]])
def test_the_acceleration_converges_with_order_four_and_its_error_is_foretold(names):
    conditions = given(swing, *names)
    coarse, told_coarse = error(np.linspace(START, END, 15), swing, 2, **conditions)
    fine, told_fine = error(np.linspace(START, END, 29), swing, 2, **conditions)
    assert np.log2(coarse / fine) > 3.7
    for true, told in ((coarse, told_coarse), (fine, told_fine)):
        assert true / 3.0 < told < 3.0 * true


def test_what_is_known_of_the_ends_makes_them_better():
    t = np.linspace(START, END, 15)
    blind, _ = error(t, swing, 2)
    told, _ = error(t, swing, 2, **given(swing, *CONDITIONS[4]))
    assert told < 0.2 * blind


def test_a_motion_that_repeats_has_the_same_velocity_at_both_ends():
    t = np.linspace(0.0, 2.0 * np.pi, 33)
    found = inverse_kinematics(t, swing(t), ends='periodic')
    assert found.velocity[0] == pytest.approx(found.velocity[-1], abs=1e-12)
    assert found.acceleration[0] == pytest.approx(found.acceleration[-1], abs=1e-10)
    assert found.acceleration == pytest.approx(swing(t, 2), abs=3e-2)  # (3 h)^4 of 9 m/s^2
    with pytest.raises(UserError, match='ends where it begins'):
        inverse_kinematics(t[:-3], swing(t[:-3]), ends='periodic')


def test_natural_ends_bend_least():
    """Of all motions through the samples the natural one has the least integral of |r'''|^2."""
    t = np.linspace(START, END, 12)
    natural = inverse_kinematics(t, swing(t), ends='natural')
    free = inverse_kinematics(t, swing(t))

    def bending(found):
        return np.sum(np.square(np.diff(found.acceleration, axis=0)))

    assert bending(natural) < bending(free)


@pytest.mark.parametrize('seed', [0, pytest.param(1, marks=pytest.mark.long)])
def test_with_noise_the_deviation_is_that_of_the_error(seed):
    random = np.random.default_rng(seed)
    t = np.linspace(START, START + 4.0, 800)
    shaken = swing(t) + 1e-5 * random.standard_normal((800, 3))
    found = inverse_kinematics(t, shaken)
    assert found.noise == pytest.approx(1e-5, rel=0.15)
    wrong = found.acceleration - swing(t, 2)
    true = float(np.sqrt(np.mean(np.sum(np.square(wrong), axis=1))))
    assert true / 3.0 < found.acceleration_error < 3.0 * true
    assert np.mean(np.abs(wrong) < 2.0 * found.acceleration_deviation) > 0.8


@pytest.mark.parametrize(
    ('change', 'said'),
    [
        ({'ends': 'clamped'}, 'allowed: free, natural, periodic'),
        ({'ends': 'periodic', 'start_velocity': (0, 0, 0)}, 'leave them out'),
        ({'start_velocity': (0, 0)}, 'three finite numbers'),
        ({'end_acceleration': (0, 0, np.nan)}, 'three finite numbers'),
        ({'bandwidth': 0.0}, 'allowed: a positive number'),
    ],
)
def test_conditions_that_cannot_be_are_refused(change, said):
    t = np.linspace(START, END, 20)
    with pytest.raises(UserError, match=said):
        inverse_kinematics(t, swing(t), **change)


def test_samples_that_are_none_are_refused():
    t = np.linspace(START, END, 20)
    for time, position, said in (
        (t, swing(t)[:, :2], r'\(n, 3\)'),
        (t[:5], swing(t[:5]), 'at least 6'),
        (t[::-1], swing(t), 'must ascend'),
        (t, np.full((20, 3), np.inf), 'NaN'),
        ('now', swing(t), 'numbers'),
    ):
        with pytest.raises(UserError, match=said):
            inverse_kinematics(time, position)
