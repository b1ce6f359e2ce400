# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Closed forms where a parameter goes to a limit: to zero drag, flow, friction or stiffness, to
elastic impacts, to the narrowest ellipse. They keep their digits on the way and have the limit.
"""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rigid_body_sim.exact import (
    ballistic,
    collision,
    drag,
    kepler,
    oscillator,
    quotients,
    rocket,
    sliding,
)

GRAVITY = 9.81
ROUND_OFF = 8.0 * np.finfo(float).eps
SMALL = [0.0, 1e-18, 1e-15, 1e-12, 1e-9]  # beside 1: a second term of a series has all digits


@pytest.mark.parametrize('coefficient', SMALL)
def test_flight_with_little_linear_drag_is_ballistic_with_a_correction(coefficient: float):
    flown = {'position': [1.0], 'velocity': [5.0], 'acceleration': [-GRAVITY]}
    t = np.array([0.0, 0.5, 2.0])
    free = ballistic.flight(t, **flown)
    found = drag.linear(t, mass=1.0, coefficient=coefficient, **flown)
    way = -coefficient * (5.0 * t**2 / 2.0 - GRAVITY * t**3 / 6.0)
    slower = -coefficient * (5.0 * t - GRAVITY * t**2 / 2.0)
    # the next term is c^2 t^2 of the whole: 1e-17
    assert_allclose(found.position[:, 0], free.position[:, 0] + way, rtol=ROUND_OFF)
    # near the apex round-off of what is taken away is left: of 5 m/s
    assert_allclose(
        found.velocity[:, 0], free.velocity[:, 0] + slower, rtol=0.0, atol=5 * ROUND_OFF
    )


@pytest.mark.parametrize('coefficient', SMALL)
def test_fall_and_rise_with_little_quadratic_drag_are_ballistic_with_a_correction(
    coefficient: float,
):
    data = {'mass': 1.0, 'coefficient': coefficient, 'gravity': GRAVITY}
    t, b, g, v0 = np.array([0.0, 0.5, 1.0]), coefficient, GRAVITY, 10.0
    fall = drag.quadratic_fall(t, **data)
    assert_allclose(fall.position[:, 0], -g * t**2 / 2 * (1 - b * g * t**2 / 6), rtol=ROUND_OFF)
    assert_allclose(fall.velocity[:, 0], -g * t * (1 - b * g * t**2 / 3), rtol=ROUND_OFF)
    rise = drag.quadratic_rise(t, **data, speed=v0)
    slower = -b * (v0**2 * t - v0 * g * t**2 + g**2 * t**3 / 3)  # b times the integral of v^2
    lower = -b * (v0**2 * t**2 / 2 - v0 * g * t**3 / 3 + g**2 * t**4 / 12)
    assert_allclose(rise.velocity[:, 0], v0 - g * t + slower, rtol=8 * ROUND_OFF)
    assert_allclose(rise.position[:, 0], v0 * t - g * t**2 / 2 + lower, rtol=ROUND_OFF)
    time, height = drag.apex(**data, speed=v0)
    assert_allclose(time, v0 / g * (1 - b * v0**2 / g / 3), rtol=ROUND_OFF)
    assert_allclose(height, v0**2 / (2 * g) * (1 - b * v0**2 / g / 2), rtol=ROUND_OFF)


def test_rise_against_strong_drag_begins_at_its_speed():
    """At v0 = 1e7 v_t the tangent of the angle a near pi/2 has lost seven digits."""
    data = {'mass': 1.0, 'coefficient': GRAVITY, 'gravity': GRAVITY, 'speed': 1e7}
    rise = drag.quadratic_rise([0.0, 1e-9], **data)
    slowed = 1e7 / (1.0 + GRAVITY * 1e7 * 1e-9)  # gravity takes 1e-16 of it
    assert_allclose(rise.velocity[:, 0], [1e7, slowed], rtol=ROUND_OFF)


@pytest.mark.parametrize('mass_flow', SMALL[1:])
def test_rocket_of_little_flow_rises_by_its_thrust(mass_flow: float):
    t, thrust = np.array([0.0, 1.0, 3.0]), 100.0
    found = rocket.ascent(t, mass=10.0, mass_flow=mass_flow, exhaust_speed=thrust / mass_flow)
    x = mass_flow * t / 10.0
    assert_allclose(found.position[:, 0], 10.0 * t**2 / 2 * (1 + x / 3), rtol=ROUND_OFF)
    assert_allclose(found.velocity[:, 0], 10.0 * t * (1 + x / 2), rtol=ROUND_OFF)


def test_rocket_without_flow_flies_on():
    found = rocket.ascent([2.0], mass=10.0, mass_flow=0.0, exhaust_speed=100.0, speed=3.0)
    assert (found.position[0, 0], found.velocity[0, 0]) == (6.0, 3.0)


@pytest.mark.parametrize('stiffness', SMALL)
def test_soft_spring_under_a_force_gives_way_like_none(stiffness: float):
    data = {'mass': 2.0, 'force': 4.0, 'position': 1.0, 'velocity': 3.0}
    t, k = np.array([0.0, 0.5, 2.0]), stiffness
    found = oscillator.oscillation(t, stiffness=k, **data)
    free = 1.0 + 3.0 * t + t**2
    lower = -k / 2.0 * (t**2 / 2 + t**3 / 2 + t**4 / 12)  # k/m times the way, twice integrated
    assert_allclose(found.position[:, 0], free + lower, rtol=ROUND_OFF)
    slower = -k / 2.0 * (t + 3.0 * t**2 / 2 + t**3 / 3)
    assert_allclose(found.velocity[:, 0], 3.0 + 2.0 * t + slower, rtol=ROUND_OFF)


def test_force_against_damping_alone_is_flight_with_linear_drag():
    t = np.array([0.0, 1e-3, 0.3, 2.0, 50.0])
    found = oscillator.oscillation(
        t, mass=2.0, stiffness=0.0, damping=1.5, force=4.0, position=1.0, velocity=3.0
    )
    same = drag.linear(
        t, mass=2.0, coefficient=1.5, acceleration=[2.0], position=[1.0], velocity=[3.0]
    )
    assert_allclose(found.position, same.position, rtol=2.0 * ROUND_OFF)
    assert_allclose(found.velocity, same.velocity, rtol=2.0 * ROUND_OFF)


@pytest.mark.parametrize('lost', [0.0, 1.2e-16, 1e-12, 1e-9, 1e-6, 0.1])
def test_nearly_elastic_ball_keeps_its_height_less_what_each_impact_takes(lost: float):
    data = {'height': 1.3, 'gravity': GRAVITY, 'restitution': 1.0 - lost}
    times = collision.bounce_times(30, **data)
    middle = 0.5 * (times[1:] + times[:-1])
    flown = collision.bouncing(middle, **data)
    tops = 1.3 * data['restitution'] ** (2.0 * np.arange(1, 30))
    assert_allclose(flown.position[:, 0], tops, rtol=ROUND_OFF)
    # round-off of some 30 s times gravity
    assert_allclose(flown.velocity[:, 0], 0.0, rtol=0.0, atol=30.0 * GRAVITY * ROUND_OFF)
    late = collision.bouncing(np.linspace(0.0, 40.0, 1001), **data)
    assert np.all(late.position >= -1e-13) and np.all(late.position <= 1.3)
    assert collision.rest_time(**data) > times[-1]


def test_ball_without_restitution_stays_down_and_others_are_refused():
    data = {'height': 1.3, 'gravity': GRAVITY}
    fall = math.sqrt(2.6 / GRAVITY)
    t = np.array([0.5 * fall, 1.5 * fall])
    flown = collision.bouncing(t, restitution=0.0, **data)
    assert_allclose(flown.position[:, 0], [0.75 * 1.3, 0.0], rtol=ROUND_OFF)
    for restitution in (-0.1, 1.1, math.nan):
        with pytest.raises(ValueError, match=r'restitution .*allowed: 0 .* to 1'):
            collision.bouncing(t, restitution=restitution, **data)


def test_nearly_elastic_impact_loses_what_its_restitution_lacks():
    lost = 2.0**-50
    after = collision.impact(
        mass_a=1.0, mass_b=1.0, velocity_a=[2.0], velocity_b=[0.0], normal=[1.0],
        restitution=1.0 - lost,
    )  # fmt: skip
    assert_allclose(after.energy_lost, 2.0 * lost, rtol=ROUND_OFF)  # mu (1 - e^2) v^2/2


def test_block_and_wheel_on_ice_move_on_for_ever():
    ice = {'speed': 2.0, 'friction': 0.0, 'gravity': GRAVITY}
    assert sliding.stopping(**ice) == (math.inf, math.inf)
    assert sliding.rolling_start(**ice, beta=0.4)[0] == math.inf
    for slide in (sliding.block([0.0, 5.0], **ice), sliding.wheel([0.0, 5.0], **ice, beta=0.4)):
        assert slide.distance.tolist() == [0.0, 10.0]
        assert slide.speed.tolist() == [2.0, 2.0]
        assert slide.surface_speed.tolist() == [0.0, 0.0]


@pytest.mark.parametrize('near', [1.0, 1e-3, 1e-9, 1e-13])
def test_narrow_ellipse_keeps_its_digits_at_the_nearest_point(near: float):
    """Near it M = (1-e) E + e (E^3/6 - E^5/120 + ...): E of any size is found to round-off."""
    e = 1.0 - near
    near = 1.0 - e  # as rounded
    anomaly = np.array([1e-200, 1e-30, 1e-12, 1e-6, 1e-4, 1e-3])
    mean = near * anomaly + e * anomaly**3 * (1 / 6 - anomaly**2 / 120 + anomaly**4 / 5040)
    found = kepler.eccentric_anomaly(mean, eccentricity=e)
    assert_allclose(found, anomaly, rtol=ROUND_OFF)
    orbit = kepler.relative(mean, parameter=1.0, semi_major_axis=1.0, eccentricity=e)
    distance = near + 2.0 * e * np.sin(0.5 * anomaly) ** 2
    assert_allclose(np.linalg.norm(orbit.position, axis=1), distance, rtol=2.0 * ROUND_OFF)


@pytest.mark.parametrize('eccentricity', [1.0, 1.5, -0.1, math.nan])
def test_what_is_no_ellipse_is_refused(eccentricity: float):
    with pytest.raises(ValueError, match=r'eccentricity .*allowed: 0 .* below 1'):
        kepler.relative(1.0, parameter=1.0, semi_major_axis=1.0, eccentricity=eccentricity)


@pytest.mark.parametrize('edge', [quotients.BY_SERIES, quotients.BURNT_BY_SERIES])
def test_quotients_go_on_smoothly_where_their_series_end(edge: float):
    below, above = np.nextafter(edge, 0.0), np.nextafter(edge, 1.0 + edge)
    for quotient in (quotients.decay_twice, quotients.less_sine, quotients.burnt):
        if quotient is quotients.burnt and edge == 1.0:
            continue
        pair = quotient(np.array([below, above]))
        assert_allclose(pair[0], pair[1], rtol=2.0 * ROUND_OFF)
