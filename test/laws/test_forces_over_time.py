# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forces given by a table over time: what they give to a body, whenever they begin and end."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.forces.schedule import Schedule
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

from ..integrators.scenes import OF_EACH_KIND, mostly_long

pytestmark = pytest.mark.usefixtures('plain_source')  # few ticks: to compile takes longer

# those whose error the tick length sets, not a tolerance
FIXED_STEP = sorted(name for name in INTEGRATORS if not INTEGRATORS[name].controls_its_error)

NAMES = sorted(name for name, method in INTEGRATORS.items() if not method.is_reference)
BALL = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 2.0}
BOX = {'name': 'box', 'shape': {'type': 'box', 'size': [0.3, 0.2, 0.4]}, 'mass': 2.0}
ROUND_OFF = 1e-12  # [-] sums over some thousand ticks
SLOPE = 0.1  # the next term of the error at the step lengths chosen


def scene(*forces, body=BALL, dt=0.01):
    return load_scene(
        {'version': 1, 'name': 't', 'dt': dt, 'bodies': [body], 'forces': list(forces)}
    )


def force(table, **more):
    return {'type': 'time', 'body': 'ball', 'table': [list(row) for row in table], **more}


@pytest.mark.parametrize('name', ['dmv6', 'rk4'])
@pytest.mark.parametrize(
    ('begin', 'end'), [(0.1234, 0.777), (0.1, 0.7), (0.1234, 0.1256), (0.0, 5.0)]
)
def test_momentum_gained_is_the_area_under_the_force(name, begin, end):
    """
    The trapezoid of a kick-drift-kick is exact for a straight line, if no step goes across a jump.
    """
    sim = Simulation(scene(force([(begin, 1, 0, 2), (end, 5, 0, 2)])), integrator=name)
    sim.step(100)
    last = min(1.0, end)
    at_last = 1.0 + 4.0 * (last - begin) / (end - begin)
    area = (0.5 * (1.0 + at_last) * (last - begin), 0.0, 2.0 * (last - begin))
    assert sim.momentum() == pytest.approx(area, rel=ROUND_OFF, abs=ROUND_OFF)


@pytest.mark.parametrize('name', mostly_long(FIXED_STEP, short={*OF_EACH_KIND} - {'sdirk2'}))
def test_a_force_that_jumps_in_and_out_within_ticks_keeps_the_order(name):
    """A cubic in time, which the spline gives back exactly, between two instants inside ticks."""
    times = np.linspace(0.0517, 1.0383, 9)
    rows = np.column_stack([times, 3.0 + times**3, 1.0 - 4.0 * times**2, 2.0 * times])
    spline = CubicSpline(times, rows[:, 1:])
    gained = spline.antiderivative(1)(times[-1]) / 2.0
    moved = spline.antiderivative(2)(times[-1]) / 2.0 + gained * (1.2 - times[-1])
    order = INTEGRATORS[name].order

    def error(h):
        pushed = scene(force(rows, interpolation='cubic'), dt=h)
        refusal = INTEGRATORS[name].refuses(pushed)
        if refusal is not None:
            pytest.skip(refusal)
        sim = Simulation(pushed, integrator=name)
        sim.step(round(1.2 / h))
        return math.hypot(
            np.linalg.norm(sim.state.position[0] - moved),
            np.linalg.norm(sim.state.velocity[0] - gained),
        )

    if INTEGRATORS[name].controls_its_error:
        assert error(0.06) < 1e-7  # rtol 1e-9, over some twenty ticks
        return
    coarse, fine = (0.004, 0.002) if order < 4 else (0.06, 0.03)
    if error(fine) < ROUND_OFF:
        return  # exact for cubics: nothing left to converge
    # the parts of a cut tick are shorter than h: the slope wobbles by their share of the whole
    assert math.log2(error(coarse) / error(fine)) > order - 2 * SLOPE


@pytest.mark.parametrize('name', ['rk4', 'rk8'])
def test_rows_inside_ticks_cost_no_digit(name):
    """Between rows the path is a cubic, which both methods follow: no row is stepped over."""
    times = np.array([0.0137, 0.0514, 0.0521, 0.1203, 0.2999, 0.4507, 0.6])
    rows = np.column_stack([times, np.sin(9.0 * times), np.cos(7.0 * times), 40.0 * times])
    pushed = scene(force(rows), dt=0.01)
    sim, single = Simulation(pushed, integrator=name), Simulation(pushed, integrator=name)
    sim.step(60)
    for _ in range(60):
        single.step()
    steps = np.diff(times)[:, None] / 2.0
    velocity, moved = np.zeros(3), np.zeros(3)
    for h, before, after in zip(2.0 * steps, rows[:-1, 1:], rows[1:, 1:], strict=True):
        moved = moved + h * velocity + h * h * (2.0 * before + after) / 12.0
        velocity = velocity + h * (before + after) / 4.0
    assert sim.state.velocity[0] == pytest.approx(velocity, rel=ROUND_OFF, abs=ROUND_OFF)
    assert sim.state.position[0] == pytest.approx(moved, rel=ROUND_OFF, abs=ROUND_OFF)
    assert sim.state_bytes() == single.state_bytes()


def test_rows_on_tick_boundaries_cut_no_tick():
    at_ticks = Schedule([], 0.01 * np.arange(1.0, 500.0))
    assert at_ticks.cuts(0.0, 0.01) == (math.inf, [])
    assert at_ticks.cuts(7.0, 0.02) == (0, [7.5])
    assert Schedule([], np.array([0.055])).cuts(2.0, 0.01) == (3, [])


def test_forces_over_time_superpose():
    a, b = force([(0.1, 1, 0, 0), (0.4, 1, 0, 0)]), force([(0.3, 0, 2, 0), (0.9, 0, 4, 0)])
    sim = Simulation(scene(a, b))
    sim.step(100)
    assert sim.momentum() == pytest.approx([0.3, 1.8, 0.0], rel=ROUND_OFF, abs=ROUND_OFF)


def test_outside_the_table_the_nearest_row_holds_on_request():
    sim = Simulation(scene(force([(0.2, 1, 0, 0), (0.4, 3, 0, 0)], outside='hold')))
    sim.step(100)
    assert sim.momentum()[0] == pytest.approx(0.2 + 0.4 + 1.8, rel=ROUND_OFF)


@pytest.mark.parametrize('frame', ['world', 'body'])
@pytest.mark.parametrize('interpolation', ['linear', 'cubic'])
def test_a_table_that_never_changes_is_a_constant_wrench(frame, interpolation):
    tilted = BOX | {
        'inertia': {'ixx': 0.2, 'iyy': 0.3, 'izz': 0.25, 'ixy': 0.02, 'iyz': -0.01},
        'initial': {'angular_velocity': [1, 2, 3]},
    }
    push, twist = [1.0, 2.0, 3.0], [0.1, -0.2, 0.3]
    both = {'body': 'box', 'frame': frame, 'point': [0.1, 0.0, 0.05]}
    table = [[t, *push, *twist] for t in (0.0, 0.4, 3.0)]
    over_time = {'type': 'time', 'table': table, 'interpolation': interpolation, **both}
    constant = {'type': 'constant', 'force': push, 'torque': twist, **both}
    a, b = (Simulation(scene(f, body=tilted), integrator='rk4') for f in (over_time, constant))
    a.step(100)
    b.step(100)
    assert a.state.values == pytest.approx(b.state.values, rel=ROUND_OFF, abs=ROUND_OFF)


def test_many_ticks_at_once_give_the_bits_of_single_ticks_across_beginnings_and_ends():
    forces = [
        force([(0.1234, 1, 2, 3), (0.1256, 1, 2, 3)]),
        force([(0.2, 1, 0, 0), (0.5, 0, 1, 0), (0.7003, 0, 1, 1)], interpolation='cubic'),
    ]
    a, b = Simulation(scene(*forces)), Simulation(scene(*forces))
    a.step(100)
    for _ in range(100):
        b.step()
    assert a.state_bytes() == b.state_bytes()


def test_a_reset_starts_the_table_anew_and_time_goes_on():
    a, b = (Simulation(scene(force([(0.1, 1, 0, 0), (0.55, 1, 0, 0)]))) for _ in range(2))
    a.step(37)
    a.reset()
    a.step(80)
    b.step(80)
    assert a.tick == 117
    assert a.momentum() == pytest.approx(b.momentum(), rel=ROUND_OFF, abs=ROUND_OFF)


@pytest.mark.parametrize(
    ('table', 'said'),
    [
        ([[0, 1, 2, 3]], 'at least two rows'),
        ([[0, 1, 2], [1, 1, 2]], 'at least two rows are needed, all of (t, fx, fy, fz)'),
        ([[0, 1, 2, 3], [0, 1, 2, 3]], 'row 1 of the table, at 0 s, is not later'),
        ([[0, 1, 2, 3], [1, 1, 2]], 'a list of 4 numbers'),
        ([[0, 1, 2, 3], [1, 1, 2, math.inf]], 'a finite number'),
        ('a', 'a list of rows'),
    ],
)
def test_an_impossible_table_is_refused(table, said):
    with pytest.raises(UserError, match=r'forces\[0\]') as caught:
        scene({'type': 'time', 'body': 'ball', 'table': table})
    assert said in str(caught.value)


def test_a_torque_over_time_on_a_point_mass_is_refused():
    with pytest.raises(ValueError, match='point mass'):
        Simulation(scene(force([(0, 0, 0, 0, 0, 0, 1), (1, 0, 0, 0, 0, 0, 1)])))


@pytest.mark.parametrize(
    'push',
    [
        {'type': 'time', 'table': [[0, 1, 0, 0], [1, 1, 0, 0]]},
        {'type': 'constant', 'force': [1, 0, 0]},
        {'type': 'drag', 'linear': 1.0},
    ],
)
def test_a_force_on_a_fixed_body_is_refused(push):
    wall = {'name': 'wall', 'shape': {'type': 'plane', 'normal': [1, 0, 0]}}
    ground = load_scene(
        {
            'version': 1,
            'name': 't',
            'dt': 0.01,
            'bodies': [BALL, wall],
            'forces': [{'body': 'wall', **push}],
        }
    )
    with pytest.raises(ValueError, match="'wall' is fixed"):
        Simulation(ground)
