# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The problems of the report: their exact ends, and that their scenes move towards them."""

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.exact import free_asymmetric_top, free_symmetric_top, quadratic_flow
from rigid_body_sim.exact.attitude import angle_between
from rigid_body_sim.report.entry import command
from rigid_body_sim.report.method import method
from rigid_body_sim.report.problem import THROUGHPUT, ladder
from rigid_body_sim.report.problems import PROBLEMS, needle, torque_free_top

PROMISED = {
    'torque_free_top',
    'needle',
    'heavy_top',
    'projectile',
    'oscillator',
    'stiff_oscillator',
    'damped_fall',
    'throughput',
    'bounce',
    'slide',
    'roll',
    'stack',
    'pile',
    'billiards',
    'cradle',
    'tumbling_cube',
    'closed_loop',
}
# dt [s] at which rk4 is far from its limits: what it errs by there, from its order
FINE = {
    'torque_free_top': (0.01, 1e-8),
    'needle': (0.0005, 1e-3),
    'heavy_top': (0.002, 1e-5),
    'projectile': (1.0, 1e-12),
    'oscillator': (0.005, 1e-4),
    'stiff_oscillator': (0.00005, 1e-12),
    'damped_fall': (0.01, 1e-8),
    'orientation_torque': (0.01, 1e-6),
    'throughput': (0.001, 1e-12),
    'closed_loop': (0.001, 1e-13),
    'kepler': (0.005, 1e-5),
    'pendulum': (0.01, 1e-6),
    'rocket': (1.0, 1e-2),
    'euler_limit': (0.05, 1e-12),
    'drift_of_r': (0.1, 2e-4),
}
# The same for contact by time stepping with dmv6: order one and its tolerances at 5 ms and less.
TOUCHING = {
    'elastic_collision': (0.0005, 1e-4),  # no contact, but order two at its kinks
    'bounce': (0.0005, 0.022),  # ten impacts, each up to a tick late at 4.4 m/s
    'slide': (0.005, 5e-3),
    'roll': (0.005, 2e-3),
    'stack': (0.005, 1e-3),
    'pile': (0.005, 2e-3),
}
# The same with impacts at their instants: round-off.
STRUCK = {
    'billiards': (0.02, 1e-12),
    'cradle': (0.02, 1e-12),
    'tumbling_cube': (0.02, 1e-12),
}
AT_THE_START = ('oscillator', 'stack', 'drift_of_r', 'tumbling_cube')


LECTURE = {'kepler', 'pendulum', 'rocket', 'elastic_collision', 'euler_limit', 'drift_of_r'}


def test_the_problems_of_the_lecture_stand_under_its_heading():
    assert {name for name in PROBLEMS if PROBLEMS[name].heading} == LECTURE


def test_explicit_euler_grows_from_two_over_k_on():
    """v' = -k v, k = 10 1/s: the factor of a step is 1 - k h."""
    problem = PROBLEMS['euler_limit']

    def error(method, step):
        sim = Simulation(problem.scene(), integrator=method, dt=step)
        sim.step(round(problem.duration / step))
        return problem.error_at_end(sim)

    assert error('explicit_euler', 0.25) == pytest.approx(1.5**24, rel=1e-9)
    assert error('explicit_euler', 0.2) == pytest.approx(1.0)
    assert error('explicit_euler', 0.15) == pytest.approx(0.5**40, rel=1e-9)


def test_the_promised_problems_are_found():
    assert set(PROBLEMS) >= PROMISED


@pytest.mark.parametrize('name', PROBLEMS)
def test_scene_and_exact_end_are_the_same_motion(name):
    problem = PROBLEMS[name]
    known = {**FINE, **TOUCHING, **STRUCK}
    text = 'rk4' if name in FINE else 'dmv6:contact=event' if name in STRUCK else 'dmv6'
    dt, bound = known[name]
    bodies = 10 if problem.kind == THROUGHPUT else 1
    used = method(text)
    scene = used.scene_of(problem.scene(bodies))
    simulation = Simulation(scene, integrator=used.integrator, dt=dt)
    start = problem.error(simulation.state)
    ticks = round(problem.duration / dt)
    if problem.control is None:
        simulation.step(ticks)
    else:
        command(simulation, ticks, problem.control)
    assert problem.error_at_end(simulation) < bound
    # before it has moved it is far from there, but for whole periods, what is at rest, and energy
    assert start > 10 * bound or name in AT_THE_START


@pytest.mark.parametrize('name', PROBLEMS)
def test_every_step_of_a_sweep_divides_the_duration(name):
    problem = PROBLEMS[name]
    for text in problem.integrators:
        for step in problem.steps_for(text):
            ticks = problem.duration / step
            assert round(ticks) >= 1
            assert abs(ticks - round(ticks)) < 1e-9 * ticks  # rounding of the division


def test_jacobis_solution_of_the_flips_is_right_to_1e_14():
    inertia, rate = torque_free_top.MOMENTS, torque_free_top.RATE
    terms = [*quadratic_flow.euler_terms(inertia), *quadratic_flow.rotation_terms(1, 4)]
    start = [*rate, 0.0, 0.0, 0.0, 1.0]
    series = quadratic_flow.solution(terms, start, [torque_free_top.DURATION], step=0.25)
    closed = free_asymmetric_top.rotation(
        torque_free_top.DURATION, inertia=inertia, angular_velocity_body=rate
    )
    assert angle_between(closed.orientation, series[0, 3:7]) < 1e-14  # measured 9e-15: round-off


def test_the_end_of_the_needle_is_that_of_a_symmetric_top():
    axial, across, _ = needle.MOMENTS
    # the symmetric top has its axis along z: x -> z, y -> x, z -> y
    rate = np.roll(needle.RATE, -1)
    closed = free_symmetric_top.rotation(
        needle.DURATION,
        inertia_across=across,
        inertia_axial=axial,
        angular_velocity_body=rate,
    )
    x, y, z, w = closed.orientation
    # 1000 rad in double precision: 1e-13 rad each
    assert PROBLEMS['needle'].error(_End(np.array([[z, x, y, w]]))) < 1e-12


class _End:
    def __init__(self, orientation):
        self.orientation = orientation


def test_a_ladder_has_both_ends_and_nothing_beyond():
    assert ladder(0.5, 0.05) == (0.5, 0.2, 0.1, 0.05)
    assert ladder(0.2, 0.02) == (0.2, 0.1, 0.05, 0.02)
