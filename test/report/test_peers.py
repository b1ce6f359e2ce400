# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Other engines get the same physical problem, and one that is not there is a row that says so.

What needs an engine is skipped where it is not installed.
"""

import math
import sys
import time

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact.attitude import angle_between
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.report import peers
from rigid_body_sim.report.measure import run_once
from rigid_body_sim.report.peers.engine import SLOW, Engine, Way, steps_of
from rigid_body_sim.report.peers.task import End, Task
from rigid_body_sim.report.point import OK, REFUSED
from rigid_body_sim.report.problems import PROBLEMS

PYTHON_NAMES = {
    'mujoco': 'mujoco',
    'drake': 'pydrake',
    'dart': 'dartpy',
    'rapier': 'rapier3d',
    'pinocchio': 'pinocchio',
    'bullet': 'pybullet',
}


def test_every_engine_of_the_mission_has_a_file():
    assert set(peers.names()) == set(PYTHON_NAMES)


@pytest.mark.parametrize('name', peers.names())
def test_an_engine_that_is_not_installed_is_a_row_with_the_reason(name, monkeypatch):
    monkeypatch.setitem(sys.modules, PYTHON_NAMES[name], None)  # so that its import fails
    found, (absent,) = peers.find([name])
    assert found == []
    assert absent.reason.startswith('not installed (') and 'pip install' in absent.reason


class Turn:
    """An engine as small as can be: it turns about one axis at a constant rate."""

    def __init__(self, task, dt, *, seconds=0.0):
        self.task, self.seconds, self.angle = task, seconds, 0.0

    def fresh(self):
        self.angle = 0.0

    def advance(self):
        end = time.process_time() + self.seconds
        while time.process_time() < end:
            pass
        self.angle = self.task.body.initial.angular_velocity[1] * self.task.duration

    def final(self):
        q = (0.0, math.sin(0.5 * self.angle), 0.0, math.cos(0.5 * self.angle))
        return End(np.zeros((1, 3)), np.array([q]), np.zeros((1, 3)), np.zeros((1, 3)))


def measured(engine, problem):
    return [run_once(problem, entry)[0] for entry in engine.entries(problem)]


def test_a_sweep_takes_the_steps_of_the_problem_and_their_errors():
    problem = PROBLEMS['torque_free_top']
    points = measured(Engine('Turn', '1', (Way('only', Turn),)), problem)
    assert [point.dt for point in points] == list(steps_of(problem)) == list(problem.steps)
    assert {point.engine for point in points} == {'Turn'}
    assert min(point.error for point in points) > 0.01  # it knows nothing of flips


def test_who_cannot_be_commanded_in_the_loop_is_refused():
    problem = PROBLEMS['closed_loop']
    (point,) = measured(Engine('Turn', '1', (Way('only', Turn),)), problem)
    assert point.status == REFUSED and 'a controller in the loop' in point.note
    points = measured(Engine('Turn', '1', (Way('only', Turn, commanded=True),)), problem)
    assert [point.bodies for point in points] == list(problem.bodies)


def test_a_sweep_ends_after_a_run_that_takes_long():
    def slow(task, dt):
        return Turn(task, dt, seconds=1.1 * SLOW if dt < 1.0 else 0.0)

    points = measured(Engine('Turn', '1', (Way('slow', slow),)), PROBLEMS['torque_free_top'])
    assert [point.dt for point in points] == [5.0, 2.0, 1.0, 0.5]


def test_an_engine_whose_interface_has_changed_is_refused_with_the_reason():
    def changed(task, dt):
        raise TypeError('takes 3 arguments')

    (point,) = measured(Engine('Changed', '9', (Way('only', changed),)), PROBLEMS['needle'])
    assert point.status == REFUSED
    assert 'Changed 9' in point.note and 'takes 3 arguments' in point.note


def test_a_force_without_counterpart_is_refused():
    scene = load_scene(
        {
            'version': 1,
            'name': 'drag',
            'dt': 0.01,
            'bodies': [{'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}],
            'forces': [{'type': 'drag', 'body': 'ball', 'quadratic': 1.0}],
        }
    )
    with pytest.raises(InvalidModel, match='drag'):
        Task.of_scene(scene, 1.0)


def scene_on_ground(shape, *, of_body=(), **ground):
    body = {'name': 'body', 'shape': shape, 'mass': 1.0, 'initial': {'position': [0, 0, 0.1]}}
    body |= dict(of_body)
    plane = {'name': 'ground', 'shape': {'type': 'plane', **ground}}
    gravity = [0, 0, -9.81]
    return load_scene(
        {'version': 1, 'name': 'floor', 'dt': 0.01, 'gravity': gravity, 'bodies': [plane, body]}
    )


def test_contact_with_what_is_no_level_ground_is_refused():
    ball = {'type': 'sphere', 'radius': 0.1}
    with pytest.raises(InvalidModel, match='plane z = 0'):
        Task.of_scene(scene_on_ground(ball, normal=[1, 0, 1]), 1.0)
    with pytest.raises(InvalidModel, match='plane z = 0'):
        capsule = {'type': 'capsule', 'radius': 0.1, 'length': 1}
        Task.of_scene(scene_on_ground(capsule, normal=[0, 0, 1]), 1.0)


def test_contact_of_a_shape_off_its_centre_of_mass_is_refused():
    box = {'type': 'box', 'size': [0.2, 0.2, 0.2]}
    lopsided = scene_on_ground(box, of_body={'center_of_mass': [0, 0, 0.05]}, normal=[0, 0, 1])
    with pytest.raises(InvalidModel, match='about their centres of mass'):
        Task.of_scene(lopsided, 1.0)


def test_an_engine_without_ways_for_contact_is_refused(monkeypatch):
    problem = PROBLEMS['torque_free_top']
    scene = scene_on_ground({'type': 'sphere', 'radius': 0.1}, normal=[0, 0, 1])
    monkeypatch.setattr(type(problem), 'scene', lambda self, bodies=1: scene)
    (entry,) = Engine('Turn', '1', (Way('only', Turn),)).entries(problem)
    with pytest.raises(InvalidModel, match='contact'):
        entry.make()


@pytest.mark.parametrize('name', ['mujoco', 'rapier'])
def test_an_engine_leaves_what_lies_on_the_ground_where_it_is(name):
    found, absent = peers.find([name])
    if absent:
        pytest.skip(f'{absent[0].engine} {absent[0].reason}')
    box = {'type': 'box', 'size': [0.2, 0.2, 0.2]}
    task = Task.of_scene(scene_on_ground(box, normal=[0, 0, 1]), 1.0)
    for way in found[0].ways:
        if way.contact:
            runner = way.build(task, 0.005)
            runner.fresh()
            runner.advance()
            position = runner.final().position
            assert position.shape == (2, 3) and not position[0].any()
            assert position[1] == pytest.approx([0.0, 0.0, 0.1], abs=2e-3)  # soft contacts sink


def test_springs_and_drag_are_read_as_they_stand():
    task = Task.of(PROBLEMS['stiff_oscillator'])
    assert (task.stiffness, task.damping, task.axes()) == (1e5, 2e4, [0])
    task = Task.of(PROBLEMS['damped_fall'])
    assert (task.stiffness, task.damping, task.axes()) == (0.0, 0.5, [0, 2])


def test_a_weight_on_a_pivot_turns_as_the_body_does_under_the_force():
    # the ball joint that engines get in place of a force beside the centre of mass
    problem = PROBLEMS['orientation_torque']
    task = Task.of(problem)
    (xx, yy, zz) = np.diag(task.body.inertia).tolist()
    scene = {
        'version': 1,
        'name': 'pivot',
        'dt': 0.01,
        'gravity': list(task.gravity),
        'bodies': [
            {
                'name': 'load',
                'mass': task.body.mass,
                'inertia': {'ixx': xx, 'iyy': yy, 'izz': zz},
                'pivot': {'point': [-part for part in task.arm], 'at': list(task.pivot)},
                'initial': {'angular_velocity': list(task.body.initial.angular_velocity)},
            }
        ],
    }
    under_force = Simulation(problem.scene(), integrator='rk8', dt=0.01)
    on_pivot = Simulation(load_scene(scene), integrator='rk8', dt=0.01)
    for simulation in (under_force, on_pivot):
        simulation.step(1000)
    apart = angle_between(under_force.state.orientation[0], on_pivot.state.orientation[0])
    assert apart < 1e-10  # rad: truncation of both, 1e-12, and round-off


ORDERS = {  # engine: problem, method, dt [s], order
    'mujoco': ('torque_free_top', 'RK4', 0.1, 4),
    'pinocchio': ('torque_free_top', 'Runge–Kutta 4', 0.1, 2),  # its attitude is of order two
    'drake': ('torque_free_top', 'runge_kutta3, fixed step', 0.02, 3),
    'dart': ('damped_fall', 'semi-implicit Euler', 0.1, 1),
    'rapier': ('damped_fall', '1 substep', 0.1, 1),
    'bullet': ('damped_fall', 'maximal coordinates', 0.1, 1),
}


@pytest.mark.parametrize('name', peers.names())
def test_an_engine_converges_to_the_exact_answer_at_the_order_of_its_method(name):
    found, absent = peers.find([name])
    if absent:
        pytest.skip(f'{absent[0].engine} {absent[0].reason}')
    problem_name, method, dt, order = ORDERS[name]
    problem = PROBLEMS[problem_name]
    way = next(way for way in found[0].ways if way.method == method)
    errors = []
    for step in (dt, dt / 2):
        runner = way.build(Task.of(problem), step)
        runner.fresh()
        runner.advance()
        errors.append(problem.error(runner.final()))
    assert errors[0] / errors[1] == pytest.approx(2.0**order, rel=0.35)


@pytest.mark.parametrize('problem_name', ['heavy_top', 'slide'])
@pytest.mark.parametrize('name', peers.names())
def test_an_engine_measured_twice_ends_where_it_ended(name, problem_name):
    found, absent = peers.find([name])
    if absent:
        pytest.skip(f'{absent[0].engine} {absent[0].reason}')
    task = Task.of(PROBLEMS[problem_name])
    try:
        ways = found[0].ways_for(task)
    except InvalidModel as refusal:
        pytest.skip(str(refusal))
    for way in ways[:2]:
        setting = way.tolerances[1] if way.tolerances else 0.01
        runner = way.build(task, setting)
        ends = []
        for _ in range(2):
            runner.fresh()
            runner.advance()
            end = runner.final()
            ends.append(end.orientation.tobytes() + end.position.tobytes())
        assert ends[0] == ends[1]


def test_all_of_the_installed_engines_give_points_or_reasons():
    found, absent = peers.find()
    assert len(found) + len(absent) == len(peers.names())
    for engine in found:
        entry = next(iter(engine.entries(PROBLEMS['projectile'])))
        point = run_once(PROBLEMS['projectile'], entry)[0]
        assert point.status in (OK, REFUSED) or point.note
