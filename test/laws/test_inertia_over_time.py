# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The skater of the lecture: inertia that changes at constant mass, and L that does not."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.inertia_over_time import (
    moments_at,
    rates_at,
)
from rigid_body_sim.physics.model.scene import InertiaOverTime
from rigid_body_sim.runs.error_estimate import _spread_of_moments
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene.shipped_scenes import find_scene

ROWS = [[0.33, 1, 2, 2.5], [1.71, 1.5, 1.2, 0.9], [2.5, 2, 2.2, 3]]  # none at a tick
RATE = [1.0, 1.5, 2.0]


def scene(*, integrator='lie_rk4', interpolation='smooth', forces=(), **more):
    law = {'table': ROWS, 'interpolation': interpolation}
    body = {'name': 'b', 'mass': 1, 'inertia_over_time': law, **more}
    body.setdefault('initial', {'angular_velocity': RATE})
    return {'dt': 0.05, 'integrator': integrator, 'bodies': [body], 'forces': list(forces)}


@pytest.mark.usefixtures('plain_source')
def test_a_skater_turns_thrice_as_fast_and_keeps_l_to_the_last_bit():
    sim = Simulation(load_scene(find_scene('skater')))
    before, energy = sim.state.angular_momentum.tobytes(), sim.energy()
    for seconds, rate in ((4, 3.0), (5, 6.0), (9, 6.0), (10, 3.0), (11, 2.0)):
        sim.step(200 * seconds - sim.tick)
        assert sim.state.angular_momentum.tobytes() == before
        assert sim.state.angular_velocity[0] == pytest.approx((0, 0, rate), rel=1e-14)
        # T = L^2 / 2 I = L omega / 2: what the arms did is what the energy gained
        assert sim.energy() - energy == pytest.approx(3.0 * (rate - 2.0), rel=1e-13, abs=1e-13)
    assert not sim.invariants.energy_is_conserved and sim.invariants.momentum_is_conserved


def exact_end(law, momentum, instants):
    """Attitude at the last of some instants, each stretch between rows by itself."""

    def slope(t, q):
        omega = rotation.rotate_back(q / np.linalg.norm(q), momentum) / moments_at(law, t)
        return 0.5 * rotation.multiply(q, [*omega, 0.0])

    q, begin = np.array([0.0, 0.0, 0.0, 1.0]), 0.0
    for end in instants:
        q = solve_ivp(slope, (begin, end), q, method='DOP853', rtol=1e-12, atol=1e-13).y[:, -1]
        begin = end
    return q / np.linalg.norm(q)


@pytest.mark.parametrize('interpolation', ['smooth', 'linear'])
def test_the_order_stays_four_across_the_rows_of_the_table(interpolation):
    read = load_scene(scene(interpolation=interpolation))
    momentum = Simulation(read).state.angular_momentum[0]
    exact = exact_end(read.bodies[0].inertia_over_time, momentum, (0.33, 1.71, 2.5, 3.0))
    errors = []
    for h in (0.05, 0.025):
        sim = Simulation(read, dt=h)
        sim.step(round(3.0 / h))
        errors.append(rotation.angle_between(sim.state.orientation[0], exact))
        assert np.array_equal(sim.state.angular_momentum[0], momentum)
    assert 12 < errors[0] / errors[1] < 20
    assert errors[1] < 1e-5


def test_the_drive_gives_the_energy_that_the_body_gains():
    """P = -omega I' omega / 2 without torque; and I alpha = -omega x L - I' omega."""
    h = 0.005  # [s] rows lie at even ticks: Simpson's rule sees smooth pieces
    sim = Simulation(load_scene(scene()), dt=h)
    law = sim.scene.bodies[0].inertia_over_time
    powers, energies = [], []
    for _ in range(601):
        omega = sim.state.angular_velocity_body[0]
        powers.append(-0.5 * np.sum(rates_at(law, sim.time) * omega**2))
        energies.append(sim.energy())
        sim.step()
    work = h / 3 * (powers[0] + 4 * sum(powers[1:-1:2]) + 2 * sum(powers[2:-2:2]) + powers[-1])
    assert energies[-1] - energies[0] == pytest.approx(work, rel=1e-6)
    assert abs(work) > 1.0
    sim = Simulation(load_scene(scene()), dt=1e-4)
    sim.step(9999)
    before = sim.state.angular_velocity[0]
    sim.step()
    alpha = sim.accelerations()[1][0]
    sim.step()
    assert alpha == pytest.approx((sim.state.angular_velocity[0] - before) / 2e-4, abs=1e-6)


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_the_moment_of_inertia_is_that_of_now(axis):
    """I_n omega_n = L_n about each principal axis, at every time and after a reset."""
    sim = Simulation(load_scene(scene()), dt=0.01)
    direction = np.eye(3)[axis]
    law, mass = sim.scene.bodies[0].inertia_over_time, sim.scene.bodies[0].mass
    start = sim.moment_of_inertia('b', direction=direction)
    found = []
    for _ in range(3):
        sim.step(70)
        found.append(sim.moment_of_inertia('b', direction=direction))
        assert found[-1] == pytest.approx(moments_at(law, sim.time)[axis], rel=1e-12)
        state = sim.state
        along = rotation.rotate_back(state.orientation[0], state.angular_momentum[0])[axis]
        expected = along / state.angular_velocity_body[0, axis]
        assert found[-1] == pytest.approx(expected, rel=1e-12)
    off = sim.moment_of_inertia('b', direction=direction, point=np.eye(3)[axis - 1])
    assert off == pytest.approx(found[-1] + mass, rel=1e-12)
    assert max(found) != pytest.approx(start, rel=0.01)
    sim.reset()
    assert sim.moment_of_inertia('b', direction=direction) == start


def test_the_estimate_of_rounding_knows_the_most_slender_shape_of_a_changing_body():
    law = {'table': [*ROWS[:1], [9.0, 0.001, 1.0, 1.0]]}
    found = _spread_of_moments(Simulation(load_scene(scene(inertia_over_time=law))))
    assert found == pytest.approx(1000.0, rel=1e-12)


def test_the_state_belongs_to_the_time_of_the_scene():
    read = load_scene(scene())
    one, other = Simulation(read), Simulation(read)
    one.step(40)
    for _ in range(40):
        other.step()
    assert one.state.values.tobytes() == other.state.values.tobytes()
    fresh = Simulation(read)
    fresh.restore(tick=40, state=one.state_bytes(), slots={})
    assert fresh.state.values.tobytes() == one.state.values.tobytes()
    one.step(20), fresh.step(20)
    assert fresh.state_bytes() == one.state_bytes()
    one.reset()
    assert one.state.angular_velocity[0] == pytest.approx(RATE, rel=1e-15)


@pytest.mark.parametrize('how', ['smooth', 'linear'])
def test_moments_stay_between_their_rows_and_have_the_rates_that_are_said(how):
    law = InertiaOverTime(tuple(map(tuple, ROWS)), how)
    times = np.linspace(0, 3, 301)
    moments = np.array([moments_at(law, t) for t in times])
    table = np.array(ROWS)[:, 1:]
    assert np.all(moments >= table.min(axis=0)) and np.all(moments <= table.max(axis=0))
    for t in (0.1, 0.9, 2.0, 2.9):
        slope = (moments_at(law, t + 1e-6) - moments_at(law, t - 1e-6)) / 2e-6
        assert rates_at(law, t) == pytest.approx(slope, abs=1e-8)
    assert moments_at(law, math.nextafter(0.33, 0)) == pytest.approx(table[0])


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'integrator': 'dmv6'}, 'dmv6 does not follow; take lie_rk4, or a Runge–Kutta method'),
        ({'integrator': 'rk4'}, 'rk4 does not follow'),
        ({'inertia': {'ixx': 1, 'iyy': 1, 'izz': 1}}, 'remove inertia'),
        ({'fixed': True, 'initial': {}}, 'does not turn'),
        ({'mass_rate': -0.1}, 'mass_rate is not modelled'),
        ({'pivot': {'point': [0, 0, 1]}}, 'pivot is not modelled'),
        ({'inertia_over_time': {'table': ROWS[:1]}}, 'at least two rows'),
        ({'inertia_over_time': {'table': [ROWS[1], ROWS[0]]}}, 'times must ascend'),
        ({'inertia_over_time': {'table': [[0, 1, 1, 3], [1, 1, 1, 1]]}}, 'break the triangle'),
        ({'inertia_over_time': {'table': [[0, 1, 1]]}}, 'table[0]: got 3 numbers'),
        ({'inertia_over_time': {'table': ROWS, 'interpolation': 'cubic'}}, "'cubic' is unknown"),
    ],
)
def test_what_cannot_change_its_inertia_is_refused(change, reason):
    with pytest.raises(UserError) as caught:
        simulation_of(load_scene(scene(**change)))
    assert reason in str(caught.value) and '\n' not in str(caught.value)
