# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The front, the cheapest point at an error, and the words, on points made by hand."""

import math

from rigid_body_sim.report.pareto import (
    at_equal_error,
    cheapest,
    cost_at,
    mark_front,
    micro,
    verdict,
)
from rigid_body_sim.report.point import DIVERGED, OK, Point, quartiles
from rigid_body_sim.report.throughput import at_equal_bodies, throughput_verdict


def point(method, error, cost, *, engine='rigid_body_sim', status=OK, **more):
    return Point(
        engine=engine,
        version='1',
        method=method,
        precision='f64',
        setting=f'cost {cost:g}',
        dt=None,
        tolerance=None,
        bodies=more.pop('bodies', 1),
        status=status,
        error=error,
        cost=cost,
        **more,
    )


def test_the_front_holds_who_is_beaten_by_nobody():
    points = [
        point('a', 1e-2, 1.0),
        point('a', 1e-4, 2.0),
        point('b', 1e-3, 2.5),  # beaten by a
        point('b', 1e-8, 5.0),
        point('c', 1e-8, 6.0),  # as accurate as b and dearer
        point('c', 1e-9, 1.5, status=DIVERGED),
    ]
    mark_front(points)
    assert [p.on_front for p in points] == [True, True, False, True, False, False]


def test_each_number_of_bodies_has_its_front():
    points = [point('a', 1e-2, 1.0), point('a', 1e-2, 10.0, bodies=10)]
    mark_front(points)
    assert all(p.on_front for p in points)


def test_the_cheapest_point_is_at_least_as_accurate():
    points = [point('a', 2e-6, 1.0), point('a', 1e-6, 2.0), point('b', 1e-9, 3.0)]
    assert cheapest(points, 1e-6) is points[1]
    assert cheapest(points, 1e-10) is None


def test_costs_are_interpolated_in_logarithms():
    # error = cost^-4, a method of order four
    sweep = [point('rk4', cost**-4.0, cost) for cost in (1.0, 2.0, 4.0, 8.0)]
    found = cost_at(sweep, 1e-2)
    assert math.isclose(found, 1e-2**-0.25, rel_tol=1e-12)
    assert cost_at(sweep, 1e-9) is None


def test_ratios_compare_peer_and_ours_at_equal_error():
    points = [
        point('ours', 1e-9, 1.0),
        point('exact', 1e-15, 0.1, closed_form=True),
        point('rk', 1e-3, 10.0, engine='peer'),
        point('rk', 1e-5, 50.0, engine='peer'),
        point('rk', 1e-7, 200.0, engine='peer'),
    ]
    at4, at6, at8, _ = at_equal_error(points)
    assert (at4['peer']['cost'], at4['ratio'], at4['ratio_closed_form']) == (50.0, 50.0, 500.0)
    assert at6['ratio'] == 200.0
    assert at8['peer'] is None and at8['ratio'] is None
    assert at8['ours']['method'] == 'ours', 'a closed form is no general method'


def test_the_verdict_names_who_wins_where_and_what_nobody_reaches():
    points = [
        point('crude', 1e-5, 1e-6),
        point('fine', 1e-9, 2e-6),
        point('exact', 1e-15, 1e-7, closed_form=True),
    ]
    said = verdict(points, 'rad')
    assert 'crude at 1e-04 rad' in said
    assert 'fine from 1e-06 to 1e-08 rad' in said
    assert 'None errs by less than 1e-10 rad.' in said
    assert 'a closed form is at hand: exact' in said


def test_throughput_is_compared_at_the_same_number_of_bodies():
    points = [
        point('euler', 1e-4, 1.0, bodies=10, ns_per_body_step=5.0),
        point('dmv6', 1e-12, 2.0, bodies=10, ns_per_body_step=14.0),
        point('step', 1e-6, 9.0, engine='peer', bodies=10, ns_per_body_step=280.0),
    ]
    (row,) = at_equal_bodies(points)
    assert (row['ratio'], row['ratio_accurate']) == (56.0, 20.0)
    assert 'euler with 10 bodies: 5 ns' in throughput_verdict(points)


def test_quartiles_of_one_repetition_are_that_one():
    assert quartiles([3.0]) == (3.0, 3.0, 3.0)
    assert quartiles([5.0, 1.0, 3.0]) == (2.0, 3.0, 4.0)


def test_costs_are_written_with_a_fitting_unit():
    assert micro(2.5e-6) == '2.5 us'
    assert micro(7e-10) == '0.7 ns'
    assert micro(0.25) == '250 ms'
