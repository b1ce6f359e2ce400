# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Derivatives of samples at uneven times: the errors told are those made, and better samples help.
"""

from functools import cache

import numpy as np
import pytest

from rigid_body_sim import inverse_kinematics
from rigid_body_sim.analysis.piecewise_spline import evenly, spans_of

RATES = 2.0 * np.pi * np.array([0.3, 0.7, 0.5])  # [rad/s]
SIZES, PHASES = np.array([0.5, 0.3, 0.2]), np.array([0.0, 1.0, 2.0])
SLOW = np.arange(0.0, 2.5, 0.05)
TWO_RATES = np.concatenate((SLOW, np.arange(2.5, 5.0, 0.005)))
EVEN = np.arange(0.0, 5.0, 0.05)
TIMES = {'two rates': TWO_RATES, 'even': EVEN}
NOISE = 1e-5  # [m]


def positions(time):
    return SIZES * np.sin(np.outer(time, RATES) + PHASES)


def accelerations(time):
    return -SIZES * RATES**2 * np.sin(np.outer(time, RATES) + PHASES)


@cache
def found_in(times, seed):
    time = TIMES[times]
    noise = NOISE * np.random.default_rng(seed).standard_normal((len(time), 3))
    found = inverse_kinematics(time, positions(time) + noise)
    return found, np.abs(found.acceleration - accelerations(time))


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize(
    'seed', [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2, 3))]
)
def test_where_the_rate_changes_numbers_lie_within_the_deviations_told(seed):
    found, error = found_in('two rates', seed)
    times = error / found.acceleration_deviation
    assert np.mean(times < 2.0) > 0.9  # of normal numbers 95 %
    assert np.max(times) < 6.0  # knots as dense as samples: 14 at the first one
    assert found.acceleration_error == pytest.approx(np.sqrt(3.0) * rms(error), rel=0.6)


@pytest.mark.parametrize('draws', [2, pytest.param(4, marks=pytest.mark.long)])
def test_more_samples_in_one_half_do_the_other_no_harm(draws):
    seeds = range(draws)
    slow = np.mean([rms(found_in('two rates', seed)[1][: len(SLOW)]) for seed in seeds])
    alone = np.mean([rms(found_in('even', seed)[1]) for seed in seeds])
    assert slow < 1.5 * alone  # one bandwidth for both halves; knots as dense as samples: 11 times


@pytest.mark.parametrize('draws', [2, pytest.param(5, marks=pytest.mark.long)])
def test_at_random_times_the_error_of_exact_samples_is_told(draws):
    shares = []
    for seed in range(draws):
        time = np.sort(np.random.default_rng(seed).uniform(0.0, 5.0, 501))
        found = inverse_kinematics(time, positions(time))
        error = np.abs(found.acceleration - accelerations(time))
        shares.append(np.mean(error < 2.0 * found.acceleration_deviation))
    assert np.mean(shares) > 0.96  # the distance to the judge alone: 0.91


@pytest.mark.parametrize(
    'seed', [79, 293, *(pytest.param(seed, marks=pytest.mark.long) for seed in (110, 114, 232))]
)
def test_samples_that_nearly_coincide_leave_the_judge_its_digits(seed):
    # by normal equations the judge of these records is off by 1e5 to 1e10 times the true error
    time = np.sort(np.random.default_rng(seed).uniform(0.0, 5.0, 501))
    found = inverse_kinematics(time, positions(time))
    error = np.sqrt(3.0) * rms(found.acceleration - accelerations(time))
    assert error / 3.0 < found.acceleration_error < 10.0 * error  # 5 the worst


@pytest.mark.parametrize('total', [1.0, 5.0, 30.5, 79.0, 80.0, 90.0])
def test_coefficients_are_spread_evenly_over_the_time_and_no_denser_than_samples(total):
    spans = np.exp(np.random.default_rng(3).normal(size=80))
    share = evenly(spans, total)
    assert np.sum(share) == pytest.approx(total, rel=1e-12)
    if total < len(spans):
        free = share < 1.0
        assert np.all(share <= 1.0)
        assert np.ptp(share[free] / spans[free]) < 1e-12
        assert np.all(spans[~free] >= np.max(spans[free], initial=0.0))


def test_even_samples_have_even_shares():
    time = np.arange(40) * 0.25
    assert evenly(spans_of(time), 10.0) == pytest.approx(np.full(40, 0.25), rel=1e-14)
