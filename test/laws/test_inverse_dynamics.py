# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From positions back to velocities, accelerations and the wrench: against closed forms, with the
error foretold.
"""

import numpy as np
import pytest

from rigid_body_sim.analysis.inverse_dynamics import continuous, derive
from rigid_body_sim.analysis.piecewise_spline import Break
from rigid_body_sim.errors import UserError
from rigid_body_sim.exact import free_asymmetric_top, oscillator, rocket
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body, InertiaOverTime, MassFlow

INERTIA = np.diag([1.0, 2.0, 3.0])
FORETOLD = 3.0  # [-] how far an estimate may be from the error itself, either way


def rms(vectors):
    return float(np.sqrt(np.mean(np.sum(np.square(vectors), axis=1))))


def spring_motion(t):
    """A mass of 2 kg on a spring of 8 N/m along x that also flies a parabola along z."""
    exact = oscillator.oscillation(t, mass=2.0, stiffness=8.0, position=1.0)
    zero = np.zeros(len(t))
    x, v = exact.position[:, 0], exact.velocity[:, 0]
    position = np.column_stack([x, 3.0 * t, 5.0 * t - 0.5 * 9.81 * t**2])
    velocity = np.column_stack([v, zero + 3.0, 5.0 - 9.81 * t])
    return position, velocity, np.column_stack([-8.0 * x, zero, zero])


def still(t):
    return np.tile(so3.IDENTITY, (len(t), 1))


@pytest.mark.parametrize('step', [0.2, 0.1, 0.05])
def test_the_force_of_a_spring_is_recovered_with_the_error_foretold(step):
    t = np.arange(0.0, 10.0, step)
    position, velocity, force = spring_motion(t)
    body = Body('ball', None, 2.0)
    derived, errors = derive(t, position, still(t), body=body, gravity=(0.0, 0.0, -9.81))
    for name, true in (('velocity', velocity), ('force', force)):
        error = rms(getattr(derived, name) - true)
        assert error / FORETOLD < errors[name].rms < error * FORETOLD
    assert rms(derived.force - force) < 8.0 * (2.0 * step) ** 4  # k A (omega h)^4
    assert np.all(derived.torque == 0.0)


def test_a_free_top_needs_no_torque():
    t = np.arange(0.0, 10.0, 0.02)
    omega = (0.4, 1.0, 0.3)
    exact = free_asymmetric_top.rotation(t, inertia=(1, 2, 3), angular_velocity_body=omega)
    flipped = (
        exact.orientation * np.where(np.arange(len(t)) % 3 == 0, -1.0, 1.0)[:, None]
    )  # q and -q are one attitude
    body = Body('top', None, 1.0, inertia=INERTIA)
    derived, errors = derive(t, np.zeros((len(t), 3)), flipped, body=body)
    in_world = so3.rotate(exact.orientation, exact.angular_velocity_body)
    error = rms(derived.angular_velocity - in_world)
    assert error < 1e-10  # truncation (h w / 2)^5
    assert error / FORETOLD < errors['angular_velocity'].rms < error * FORETOLD
    assert rms(derived.torque) < 2e-8
    assert rms(derived.torque) / FORETOLD < errors['torque'].rms < rms(derived.torque) * FORETOLD


def test_acceleration_of_a_rotation_about_a_fixed_axis():
    """q(t) of a turn by a t^2 / 2: w = a t, w' = a."""
    t = np.linspace(0.0, 3.0, 301)
    axis = np.array([0.6, 0.0, 0.8])
    q = so3.from_rotation_vector(0.5 * 0.7 * t[:, None] ** 2 * axis)
    derived, _ = derive(t, np.zeros((301, 3)), q)
    assert derived.angular_velocity == pytest.approx(
        0.7 * t[:, None] * axis, abs=1e-8
    )  # truncation
    assert derived.angular_acceleration == pytest.approx(np.tile(0.7 * axis, (301, 1)), abs=1e-6)
    assert derived.force is None


@pytest.mark.parametrize('noise', [pytest.param(1e-9, marks=pytest.mark.long), 1e-6])
def test_the_error_by_noise_is_foretold(noise):
    t = np.arange(0.0, 10.0, 0.02)
    position, velocity, force = spring_motion(t)
    shaken = position + noise * np.random.default_rng(7).standard_normal(position.shape)
    derived, errors = derive(
        t, shaken, still(t), body=Body('ball', None, 2.0), gravity=(0.0, 0.0, -9.81)
    )
    for name, true in (('velocity', velocity), ('force', force)):
        error = rms(getattr(derived, name) - true)
        assert error / FORETOLD < errors[name].rms < error * FORETOLD


def test_a_known_jump_of_the_force_is_seen_at_its_instant():
    """
    At rest, then pushed by 1 N from 1 s on: a spline across the jump rings, two splines do not.
    Who is not told finds it in the samples.
    """
    t = np.arange(0.0, 2.0, 0.01)
    after = np.maximum(t - 1.0, 0.0)
    position = np.column_stack([0.5 * after**2, 0 * t, 0 * t])
    pushed = np.column_stack([np.where(t >= 1.0 - 1e-9, 1.0, 0.0), 0 * t, 0 * t])
    found, _ = derive(t, position, still(t), body=Body('ball', None, 1.0))
    assert found.smoothing['position'].found == pytest.approx([1.0], abs=1e-9)
    assert found.force[:-1] == pytest.approx(pushed[:-1], abs=1e-6)
    told, errors = derive(t, position, still(t), body=Body('ball', None, 1.0), breaks=[1.0])
    assert told.force == pytest.approx(pushed, abs=1e-9)  # round-off eps x / h^2
    assert errors['force'].largest < 1e-8


def test_the_thrust_of_a_rocket_is_recovered():
    t = np.arange(0.0, 3.0, 0.02)
    exact = rocket.ascent(t, mass=10.0, mass_flow=1.5, exhaust_speed=300.0, gravity=9.81)
    position = np.column_stack([0 * t, 0 * t, exact.position[:, 0]])
    body = Body('rocket', None, 10.0, mass_flow=MassFlow(-1.5, (0.0, 0.0, -300.0)))
    derived, _ = derive(t, position, still(t), body=body, gravity=(0.0, 0.0, -9.81))
    assert derived.force == pytest.approx(
        np.tile([0.0, 0.0, 450.0], (len(t), 1)), abs=1e-5
    )  # truncation at the ends


def turned(time, rows):
    """Angle of a body with L = 1 along z whose moment follows the rows: int dt / I."""
    at, moments = np.asarray(rows)[:, 0], np.asarray(rows)[:, 3]
    slopes = np.append(np.diff(moments) / np.diff(at), 0.0)
    stretches = np.diff(at) * np.log(moments[1:] / moments[:-1]) / np.diff(moments)
    i = np.clip(np.searchsorted(at, time, side='right') - 1, 0, len(at) - 2)
    within = moments[i] + slopes[i] * (time - at[i])
    return np.append(0.0, np.cumsum(stretches))[i] + np.log(within / moments[i]) / slopes[i]


@pytest.mark.parametrize(
    'seed', [*range(2), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 12))]
)
def test_a_free_body_has_no_torque_at_rows_of_its_inertia_wherever_samples_lie(seed):
    """
    The record begins and ends at rows, and has some inside: of the two rates of omega and of I
    that meet there, one side's. Rows at thirds of seconds are no whole nanoseconds.
    """
    random = np.random.default_rng(seed)
    count, per_second = int(random.integers(5, 8)), int(random.choice([90, 100, 120]))
    thirds = np.cumsum(random.integers(1, 4, count)) + 3 * int(random.integers(0, 50))
    # next to each other they differ, so that the slopes jump
    moments = 2.0 + np.where(np.arange(count) % 2, 1.0, -1.0) * random.uniform(0.2, 0.5, count)
    rows = [(float(t / 3), m, m, m) for t, m in zip(thirds, moments, strict=True)]
    stamps = np.arange(thirds[1] * 120, thirds[-2] * 120 + 1, 360 // per_second)
    seconds = stamps / 360.0
    nanoseconds = np.round(seconds * 1e9)
    angle = turned(nanoseconds * 1e-9, rows)
    q = so3.from_rotation_vector(angle[:, None] * np.array([0.0, 0.0, 1.0]))
    law = InertiaOverTime(tuple(rows), 'linear')
    body = Body('mast', None, 1.0, inertia=np.eye(3) * moments[0], inertia_over_time=law)
    derived, errors = derive(
        nanoseconds,
        np.zeros((len(q), 3)),
        q,
        body=body,
        turning_breaks=[Break(float(np.round(row[0] * 1e9))) for row in rows],
        unit=1e-9,
    )
    # truncation at the ends; the wrong side's rate makes |I'| / I, more than 0.1
    assert np.max(np.abs(derived.torque)) < 2e-3
    worst = np.abs(derived.torque[:, 2]) / derived.deviation['torque'][:, 2]
    assert np.max(worst[[0, -1]]) < 20.0  # rounding is not white; the other side: 10^4 and more
    assert rms(derived.torque) < 20.0 * errors['torque'].rms


def test_neighbouring_quaternions_are_on_one_side():
    q = so3.from_rotation_vector(np.linspace(0.0, 9.0, 50)[:, None] * np.array([0.0, 0.6, 0.8]))
    mixed = q * np.where(np.arange(50) % 7 < 3, -1.0, 1.0)[:, None]
    assert np.all(np.sum(continuous(mixed)[1:] * continuous(mixed)[:-1], axis=1) > 0.0)


@pytest.mark.parametrize(
    ('change', 'said'),
    [
        (lambda t, x: (t[:5], x[:5]), 'at least 6'),
        (lambda t, x: (t[[0, 1, 2, 2, 3, 4, 5]], x[:7]), 'sample 3, at 0.3 s, is not later'),
        (lambda t, x: (t, np.full_like(x, np.nan)), 'NaN'),
    ],
)
def test_samples_that_tell_no_motion_are_refused(change, said):
    t = np.arange(0.1, 1.0, 0.1)
    time, position = change(t, np.zeros((9, 3)))
    with pytest.raises(UserError, match=said):
        derive(time, position, still(time))


@pytest.mark.parametrize('seed', [pytest.param(2, marks=pytest.mark.long), 5])
def test_jumps_of_any_number_and_kind_are_borne(seed):
    """What the samples cannot tell apart is given up, and what comes out is finite."""
    random = np.random.default_rng(seed)
    t = np.cumsum(random.uniform(0.001, 0.05, 40))
    position, _, _ = spring_motion(t)
    instants = [*random.uniform(t[0], t[-1], 4 * seed), *random.choice(t, seed)]
    breaks = [Break(float(at), int(random.integers(0, 6))) for at in instants]
    derived, errors = derive(t, position, still(t), body=Body('ball', None, 2.0), breaks=breaks)
    assert np.all(np.isfinite(derived.force)) and np.all(np.isfinite(derived.deviation['force']))
    assert np.isfinite(errors['force'].largest)
    found = derived.smoothing['position']
    assert found.breaks + len(found.dropped) <= len(breaks)
