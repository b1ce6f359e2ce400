# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws of the drifts that turn a body freely and leave its angular momentum alone."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.exact import free_asymmetric_top, free_symmetric_top
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.free_rotation import exact_rotor, five_rotations, taylor
from rigid_body_sim.physics.integration.free_rotation.moser_veselov_series import (
    ORDERS,
    series,
    series_rows,
)
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS, blanes_moan4
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.model import rotation

from .. import inside
from . import scenes

KEEPS_L = sorted(name for name in INTEGRATORS if 'L to the last bit' in INTEGRATORS[name].keeps)
DMV = [f'dmv{order}' for order in ORDERS]
FAST = [*DMV, 'blanes_moan4', 'five_rotations']


def error_after(seconds, name, *, inertia, omega, dt):
    """Angle [rad] between a run and the closed form."""
    sim = Simulation(scenes.top(inertia=inertia, omega=omega, dt=dt), integrator=name)
    sim.step(round(seconds / dt))
    exact = free_asymmetric_top.rotation(sim.time, inertia=inertia, angular_velocity_body=omega)
    return rotation.angle_between(sim.state.orientation[0], exact.orientation)


def test_all_drifts_that_leave_angular_momentum_alone_say_so():
    named = {*DMV, 'five_rotations', 'five_rotations_kl6', 'exact_rotor', 'taylor16'}
    assert named | {'blanes_moan4', 'lie_rk4'} <= set(KEEPS_L)


@pytest.mark.parametrize('dt', [0.01, 0.2, 0.7])
@pytest.mark.parametrize('name', KEEPS_L)
def test_angular_momentum_does_not_change_in_its_last_bit_without_torque(name, dt):
    sim = Simulation(scenes.top(omega=(0.3, 1.0, 0.2), dt=dt), integrator=name)
    before = sim.state.angular_momentum.tobytes()
    sim.step(20_000)
    assert sim.state.angular_momentum.tobytes() == before


@pytest.mark.parametrize('name', [*DMV, 'exact_rotor', 'taylor16', 'blanes_moan4'])
def test_energy_is_kept_to_round_off(name):
    sim = Simulation(scenes.top(omega=(0.3, 1.0, 0.2), dt=0.1), integrator=name)
    before = sim.energy()
    sim.step(20_000)
    assert abs(sim.energy() / before - 1.0) < 2e-13  # round-off: 1e-16 a tick, at random


@pytest.mark.parametrize(
    ('name', 'dt', 'bound'),
    [
        ('five_rotations', 0.1, 3e-4),
        ('five_rotations', 0.4, 5e-3),
        ('five_rotations_kl6', 0.4, 1e-6),
    ],
)
def test_energy_of_split_rotations_swings_within_a_bound(name, dt, bound):
    sim = Simulation(scenes.top(omega=(0.3, 1.0, 0.2), dt=dt), integrator=name)
    before = sim.energy()
    errors = []
    for _ in range(200):
        sim.step(101)
        errors.append(abs(sim.energy() / before - 1.0))
    assert max(errors) < bound  # truncation, h^2 or h^6
    # no drift: the second half of the run swings no wider than the first
    assert max(errors[100:]) < 1.2 * max(errors[:100])


@pytest.mark.parametrize('name', KEEPS_L)
def test_a_cyclic_change_of_body_axes_changes_round_off_only(name):
    """Body axes (x, y, z) become (y, z, x): the same body under other names."""
    omega = (0.3, 1.0, 0.2)
    cycle = (0.5, 0.5, 0.5, 0.5)  # turns x to y, y to z, z to x
    straight = Simulation(
        scenes.top(inertia=(1.0, 2.0, 2.5), omega=omega, dt=0.02), integrator=name
    )
    renamed = Simulation(
        scenes.top(
            inertia=(2.0, 2.5, 1.0),
            omega=(omega[1], omega[2], omega[0]),
            dt=0.02,
            orientation=cycle,
        ),
        integrator=name,
    )
    for sim in (straight, renamed):
        sim.step(500)
    expected = rotation.multiply(straight.state.orientation[0], cycle)
    # round-off of 500 steps; truncation where the method treats its axes in an order
    allowed = 1e-3 if name.startswith('five_rotations') else 1e-12
    assert rotation.angle_between(renamed.state.orientation[0], expected) < allowed


@pytest.mark.parametrize('name', FAST)
def test_speed_of_the_neighbours_cannot_be_seen(name):
    """Slow, brisk and fast lanes take different passes of the drift, alone or together."""
    speeds = [0.01, 0.5, 3.0, 12.0, 25.0, 45.0, 90.0, 400.0]

    def run(chosen):
        bodies = [
            {
                'name': f'b{speeds.index(speed)}',
                'mass': 1.0,
                'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 2.5},
                'initial': {'angular_velocity': [0.1 * speed, 0.9 * speed, 0.3 * speed]},
            }
            for speed in chosen
        ]
        sim = Simulation(scenes.scene(bodies, dt=0.01), integrator=name)
        for speed in chosen:
            sim.set_wrench(f'b{speeds.index(speed)}', torque=(0.3, -0.2, 0.5))
        sim.step(40)
        return {speed: sim.state.values[i].tobytes() for i, speed in enumerate(chosen)}

    together = run(speeds)
    for speed in speeds:
        assert run([speed])[speed] == together[speed]


def test_moser_veselov_series_are_nested_and_scale_with_the_unit_of_inertia():
    moments = np.array([[1.3, 0.7, 1.9], [0.01, 1.0, 1.005]])
    whole = series(moments, 10)
    for order in ORDERS:
        rows = series_rows(order)
        part = series(moments, order)
        assert part.shape == (2, 2 * rows)
        np.testing.assert_array_equal(part[:, :rows], whole[:, :rows])
    # s3 of A has the unit I^-2, d3 of A the unit I^-3; an unusual unit does not overflow D^4
    tiny = series(moments * 2.0**-90, 10)
    np.testing.assert_array_equal(tiny[:, 0], whole[:, 0] * 2.0**180)
    np.testing.assert_array_equal(tiny[:, series_rows(10)], whole[:, series_rows(10)] * 2.0**270)
    assert np.isfinite(tiny).all()


def test_moser_veselov_series_turns_a_sphere_by_its_angle():
    """Its c is tan(x), x = h omega / 2, and solves c = (1 + c^2) x j: j = sin(2 x) / (2 x)."""
    x = 0.05
    a = 0.5 * (2.0 * x) ** 2  # of inertia 1: A = H = (h omega)^2 / 2
    rows = series_rows(10)
    s, d = np.split(series(np.ones((1, 3)), 10)[0], [rows])
    degree = np.repeat([1, 2, 3, 4], [2, 3, 4, 5])
    j = 1.0 + float(((s + d) * a**degree).sum())
    # the next term: (2 x)^10 / 11!
    assert j == pytest.approx(math.sin(2 * x) / (2 * x), abs=1e-15)


def test_weights_of_compositions_fulfil_their_conditions():
    weights = np.array(five_rotations.KAHAN_LI_6)
    assert weights.tolist() == weights[::-1].tolist()
    # consistency and the conditions of orders three and five of a symmetric composition
    for power in (1, 3, 5):
        assert (weights**power).sum() == pytest.approx(1.0 if power == 1 else 0.0, abs=1e-15)
    scheme = INTEGRATORS['blanes_moan4'].scheme
    kicks, drifts = np.array(scheme.kicks), np.array(scheme.drifts)
    assert len(kicks) == 7 and len(drifts) == 6
    assert kicks.tolist() == kicks[::-1].tolist() and drifts.tolist() == drifts[::-1].tolist()
    assert kicks.sum() == pytest.approx(1.0, abs=1e-15)
    assert drifts.sum() == pytest.approx(1.0, abs=1e-15)
    at = np.concatenate(([0.0], np.cumsum(drifts)))  # when each kick acts
    # order three: kicks b_i at times c_i integrate t^2, and sum over j < i of b_i b_j (c_i - c_j)
    assert (kicks * at**2).sum() == pytest.approx(1 / 3, abs=1e-14)
    earlier = np.tril(kicks[:, None] * kicks * (at[:, None] - at))
    assert earlier.sum() == pytest.approx(1 / 6, abs=1e-14)


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('order', [pytest.param(2, marks=pytest.mark.long), 4, 6])
def test_taylor_drift_has_the_order_it_is_made_for(order, monkeypatch):
    """Order sixteen is below round-off before its first term leads; lower ones show the series."""
    scheme = Splitting(
        kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=taylor.drift(order), order=2
    )
    name = f'made{order}'  # compiled kernels are told apart by it
    made = Integrator(name, 2, order, '', '', '', scheme, taylor.coefficients)
    inside.add_integrator(monkeypatch, made)
    steps = {2: (0.01, 0.005), 4: (0.04, 0.02), 6: (0.08, 0.04)}[order]
    one, other = (
        error_after(8.0, name, inertia=(1.0, 2.0, 3.0), omega=(0.4, 1.0, 0.3), dt=dt)
        for dt in steps
    )
    assert math.log(one / other) / math.log(2.0) == pytest.approx(order, abs=0.1)


BRANCHES = {
    'about the highest axis': ((1.0, 2.0, 3.0), (0.2, 0.3, 1.0)),
    'about the lowest axis': ((1.0, 2.0, 3.0), (1.0, 0.3, -0.2)),
    'negative spin': ((1.0, 2.0, 3.0), (0.2, -0.3, -1.0)),
    'left-handed order of the axes': ((2.0, 1.0, 3.0), (0.3, 0.2, 1.0)),
    'another cyclic order': ((3.0, 1.0, 2.0), (0.2, 1.0, 0.5)),
    'oblate': ((2.0, 2.0, 3.0), (0.5, 0.2, 1.0)),
    'prolate': ((1.0, 2.0, 2.0), (1.0, 0.2, 0.5)),
    'symmetric top across its axis': ((2.0, 2.0, 3.0), (0.8, 0.6, 0.0)),
    'sphere': ((2.0, 2.0, 2.0), (0.5, 0.2, 1.0)),
    'nearly equal moments': ((1.0, 1.0, 1.0 + 1e-12), (0.5, 0.2, 1.0)),
    'principal axis': ((1.0, 2.0, 3.0), (0.0, 0.0, 1.0)),
    'intermediate axis': ((1.0, 2.0, 3.0), (0.0, 1.0, 0.0)),
    'no momentum': ((1.0, 2.0, 3.0), (0.0, 0.0, 0.0)),
    'barely any momentum': ((1.0, 2.0, 3.0), (1e-310, 2e-310, 0.0)),
    'needle': ((1e-3, 1.0, 1.0005), (0.8, 0.6, 0.02)),
    'needle that precesses about its own axis': ((1e-3, 1.0, 1.0005), (1.0, 1e-4, 1e-4)),
}


@pytest.mark.parametrize('dt', [0.01, 0.3, 2.5])
@pytest.mark.parametrize('branch', BRANCHES)
def test_exact_rotor_agrees_with_the_closed_form_in_every_branch(branch, dt):
    inertia, omega = BRANCHES[branch]
    # round-off: 3e-16 rad in each of up to 3000 steps, which changes omega from there on; on a
    # needle by a thousand times itself
    allowed = 2e-10 if 'needle' in branch else 3e-12
    assert error_after(30.0, 'exact_rotor', inertia=inertia, omega=omega, dt=dt) < allowed


@pytest.mark.parametrize('dt', [0.1, 1.0, 5.0])
def test_exact_rotor_follows_the_separatrix(dt):
    """I = (1, 2, 3), m1^2 = m3^2 / 3: omega2 = tanh, omega1 and omega3 fall as 1 / cosh."""
    inertia, omega = (1.0, 2.0, 3.0), (math.sqrt(3.0), 0.5, 1.0)
    m = np.multiply(inertia, omega)
    assert abs(m[2] ** 2 / 3 - m[0] ** 2 * 1.0) < 1e-15
    # the orbit leaves the separatrix as exp(nu t), nu = 1.2 / s: 1e-16 grows to 1e-13 in 5 s
    assert error_after(5.0, 'exact_rotor', inertia=inertia, omega=omega, dt=dt) < 1e-12


def test_exact_rotor_takes_a_whole_run_in_one_step():
    error = error_after(100.0, 'exact_rotor', inertia=(1, 2, 3), omega=(0.01, 1.0, 0.01), dt=100.0)
    assert error < 1e-11  # round-off of the phase of 100 rad, amplified at each of ten flips


def test_exact_rotor_sorts_axes_into_a_right_handed_frame():
    moments = np.array([[1.0, 2, 3], [2.0, 1, 3], [3.0, 1, 2], [2.0, 2, 1]])
    assert exact_rotor.coefficients(moments)[:, :4].tolist() == [
        [0, 64, 128, 1],
        [64, 0, 128, -1],
        [64, 128, 0, 1],
        [128, 0, 64, 1],
    ]


def test_flipping_top_over_a_hundred_seconds_to_1e_minus_10():
    for name, dt in (('taylor16', 0.5), ('exact_rotor', 0.5), ('dmv10', 0.2), ('dmv8', 0.1)):
        error = error_after(100.0, name, inertia=(1, 2, 3), omega=(0.01, 1.0, 0.01), dt=dt)
        assert error < 1e-10  # the round-off of the runs is 1e-12


@pytest.mark.parametrize('inertia', [(0.011, 0.8, 0.81), (1.02, 0.05, 1.0)])
def test_taylor_steps_stay_away_from_the_poles_of_the_motion(inertia):
    """Where two moments are nearly equal they lie nearer than a turn: round-off is left."""
    for dt in (0.1, 4.0):
        error = error_after(20.0, 'taylor16', inertia=inertia, omega=(3.0, 0.4, 5.0), dt=dt)
        assert error < 1e-11  # rounding of q times I_max / I_min; else 1e-9


def test_needle_over_a_hundred_turns_a_second_to_1e_minus_10():
    sim = Simulation(
        scenes.top(inertia=(1e-3, 1.0, 1.0), omega=(60.0, 80.0, 0.0), dt=1.0),
        integrator='exact_rotor',
    )
    sim.step(10)
    axial = free_symmetric_top.rotation(
        10.0, inertia_across=1.0, inertia_axial=1e-3, angular_velocity_body=(80.0, 0.0, 60.0)
    )
    # the closed form has its axis along z: (x, y, z) of this body is (z, x, y) of that one
    named = (0.5, 0.5, 0.5, 0.5)
    unnamed = rotation.conjugate(named)
    expected = rotation.multiply(named, rotation.multiply(axial.orientation, unnamed))
    error = rotation.angle_between(sim.state.orientation[0], expected)
    # an attitude rounded to 1e-16 changes the spin by 8e4 times that: 1e-11 rad/s over ten ticks
    assert error < 2e-10


def test_blanes_moan_refuses_forces_that_depend_on_velocity():
    with pytest.raises(InvalidModel, match=r'blanes_moan4.*forces\[0\] \(spring on ball.*dmv6'):
        Simulation(scenes.oscillator(dt=0.01, damping=0.1), integrator='blanes_moan4')
    Simulation(scenes.oscillator(dt=0.01), integrator='blanes_moan4').step(10)


def test_last_kick_of_a_tick_and_the_first_of_the_next_are_one():
    """Seven kicks share six evaluations in a long call, and give the bits of single calls."""
    assert blanes_moan4.INTEGRATOR.scheme.kicks[0] == blanes_moan4.INTEGRATOR.scheme.kicks[-1]
    whole, parts = (
        Simulation(scenes.oscillator(dt=0.05), integrator='blanes_moan4') for _ in range(2)
    )
    whole.step(50)
    for _ in range(50):
        parts.step()
    assert whole.state_bytes() == parts.state_bytes()


def test_blanes_moan_keeps_the_energy_of_a_spring_a_thousand_times_better_than_one_kick():
    def swing(name):
        sim = Simulation(scenes.oscillator(dt=0.05, stiffness=16.0), integrator=name)
        start = sim.energy()
        worst = 0.0
        for _ in range(100):
            sim.step(37)
            worst = max(worst, abs(sim.energy() / start - 1.0))
        return worst

    assert swing('blanes_moan4') < 1e-3 * swing('dmv6')
