# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Deadlines, without a clock: the times are made up.
"""

import pytest

from rigid_body_sim.ros.pacer import LONGEST_LAG, Pacer

MS = 1_000_000  # [ns]


def test_deadlines_do_not_add_up_lateness():
    pacer = Pacer(dt_ns=MS, factor=1.0, now=0)
    for k in range(1, 10_001):
        late = 300_000 * (k % 3)  # [ns] below one period
        now = k * MS + late
        assert pacer.deadline == k * MS
        assert pacer.due(now - late - 1) == 0
        assert pacer.due(now) == 1
        pacer.begin(1, now)
    assert (pacer.overruns, pacer.largest_lateness) == (0, 600_000)


def test_a_late_tick_is_followed_by_those_that_were_missed():
    pacer = Pacer(dt_ns=MS, factor=1.0, now=0)
    assert pacer.due(5 * MS) == 5
    pacer.begin(5, 5 * MS)
    assert pacer.overruns == 4
    assert pacer.largest_lateness == 4 * MS
    assert pacer.deadline == 6 * MS


def test_missed_ticks_done_in_portions_count_once():
    pacer = Pacer(dt_ns=MS, factor=1.0, now=0)
    now = 25 * MS
    done = 0
    while due := pacer.due(now):
        pacer.begin(min(due, 10), now)
        done += min(due, 10)
    assert (done, pacer.overruns) == (25, 24)


def test_a_lag_of_more_than_a_second_is_given_up_and_counted():
    pacer = Pacer(dt_ns=MS, factor=1.0, now=0)
    now = LONGEST_LAG + 100 * MS
    assert pacer.due(now) == 1
    pacer.begin(1, now)
    assert pacer.lags == 1
    assert pacer.largest_lateness >= LONGEST_LAG
    assert pacer.deadline == now + MS


@pytest.mark.parametrize('factor', [0.1, 0.5, 2.0, 3.0, 50.0])
def test_the_real_time_factor_is_the_share_of_ticks_in_wall_time(factor):
    pacer = Pacer(dt_ns=MS, factor=factor, now=0)
    now, done = 0, 0
    while now < 3_000 * MS:
        now = pacer.deadline
        due = pacer.due(now) or pacer.due(now + 1)  # a deadline is cut to whole nanoseconds
        pacer.begin(due, now + 1)
        done += due
    assert done == pytest.approx(3_000 * factor, abs=max(1, factor) + 1)  # one group of ticks
    assert pacer.factor_reached(now) == pytest.approx(factor, rel=0.01)
    assert pacer.overruns == 0


@pytest.mark.parametrize('period', [50, 70, 100, 1000, 1037])  # [ms]
@pytest.mark.parametrize('dt', [1, 10, 100, 700])  # [ms]
def test_a_run_that_keeps_pace_reaches_the_factor_whenever_one_looks(dt, period):
    """
    It does each tick at its deadline, or 0.3 ms later, and is looked at before or after it.
    """
    pacer, look = Pacer(dt_ns=dt * MS, factor=1.0, now=0), period * MS
    for late in (0, 300_000) * 20:
        while look <= pacer.deadline + late:
            assert pacer.factor_reached(look) == pytest.approx(1.0, abs=0.01)
            look += period * MS
        now = pacer.deadline + late
        pacer.begin(pacer.due(now), now)


def test_a_run_at_half_its_pace_reaches_half_the_factor_also_where_lags_are_given_up():
    pacer, reached = Pacer(dt_ns=100 * MS, factor=1.0, now=0), []
    for k in range(1, 200):
        now = k * 200 * MS
        pacer.begin(min(1, pacer.due(now)), now)
        if k % 10 == 0:
            reached.append(pacer.factor_reached(now))
    assert pacer.lags
    assert reached[1:] == pytest.approx([0.5] * len(reached[1:]), abs=0.051)  # a tick of twenty


def test_a_run_that_stands_still_reaches_nothing():
    pacer = Pacer(dt_ns=MS, factor=1.0, now=0)
    pacer.factor_reached(1000 * MS)
    assert pacer.factor_reached(2000 * MS) == 0.0


def test_a_look_just_after_a_change_of_the_factor_finds_the_new_one():
    pacer = Pacer(dt_ns=100 * MS, factor=0.0, now=0)
    pacer.begin(50, MS)
    pacer.set_factor(1.0, 2 * MS)
    assert pacer.factor_reached(2 * MS) == 1.0
    assert pacer.factor_reached(2 * MS + 1000) == pytest.approx(1.0, rel=1e-9)


def test_a_change_of_the_factor_counts_deadlines_anew():
    pacer = Pacer(dt_ns=MS, factor=1.0, now=0)
    pacer.begin(pacer.due(10 * MS), 10 * MS)
    pacer.set_factor(0.5, 10 * MS)
    assert pacer.deadline == 12 * MS


def test_short_ticks_are_done_in_groups():
    pacer = Pacer(dt_ns=10_000, factor=1.0, now=0)
    assert pacer.deadline == MS
    assert pacer.due(MS) == 100
