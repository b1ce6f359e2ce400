# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`report`: numbers that a script with `Simulation` alone agrees to; files, refusals, Ctrl-C."""

import csv
import errno
import json
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.__main__ import main
from rigid_body_sim.errors import UserError
from rigid_body_sim.exact import free_asymmetric_top
from rigid_body_sim.exact.attitude import angle_between
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.report import own_scene, results
from rigid_body_sim.report.entry import Setting, our_entry
from rigid_body_sim.report.measure import measure, run_once
from rigid_body_sim.report.method import method
from rigid_body_sim.report.point import DIVERGED, NOT_ACCURATE, OK, REFUSED, Point
from rigid_body_sim.report.problems import PROBLEMS

from .. import inside
from ..patience import HANGING

QUICK = ['--quick', '--repetitions', '1']


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """A short report of one problem."""
    folder = tmp_path_factory.mktemp('report') / 'made' / 'here'
    words = ['--problems', 'torque_free_top', '--integrators', 'dmv6', 'rk4', 'rk45', *QUICK]
    assert main(['report', *words, '-o', str(folder)]) == 0
    return folder


@pytest.fixture(scope='module')
def points(folder):
    return results.read(folder)['problems'][0]['points']


TOP = {
    'version': 1,
    'name': 'flips',
    'dt': 0.01,
    'bodies': [
        {
            'name': 'top',
            'mass': 1.0,
            'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 3.0},
            'initial': {'angular_velocity_body': [0.01, 1.0, 0.01]},
        }
    ],
}


def test_errors_are_those_of_an_independent_script(points):
    exact = free_asymmetric_top.rotation(
        100.0, inertia=(1.0, 2.0, 3.0), angular_velocity_body=(0.01, 1.0, 0.01)
    )
    compared = 0
    for point in points:
        if point['status'] not in (OK, NOT_ACCURATE) or point['dt'] is None:
            continue
        simulation = Simulation(load_scene(TOP), integrator=point['method'], dt=point['dt'])
        simulation.step(round(100.0 / point['dt']))
        error = angle_between(simulation.state.orientation[0], exact.orientation)
        assert point['error'] == error, 'the same steps give the same bits'
        compared += 1
    assert compared > 10


def test_error_falls_with_the_order_of_the_method(points):
    at = {p['dt']: p['error'] for p in points if p['method'] == 'rk4'}
    assert 12.0 < at[0.1] / at[0.05] < 20.0  # order four: 16


def test_costs_are_medians_between_their_quartiles(points):
    for point in points:
        if point['cost'] is not None:
            assert 0.0 < point['cost_low'] <= point['cost'] <= point['cost_high']
            if point['dt'] is not None:
                steps_per_second = 1.0 / point['dt']
                assert point['ns_per_step'] == pytest.approx(
                    1e9 * point['cost'] / steps_per_second, rel=1e-12
                )


def test_free_rotation_keeps_energy_and_angular_momentum_with_dmv6(points):
    drifts = [p['energy_drift'] for p in points if p['method'] == 'dmv6' and p['status'] == OK]
    assert drifts and max(drifts) < 1e-13  # round-off of ten thousand steps


def test_points_that_diverge_say_where(points):
    (point,) = [p for p in points if p['status'] == DIVERGED]
    assert (point['method'], point['dt'], point['cost']) == ('rk4', 5.0, None)
    assert 'diverged in tick' in point['note']


def test_csv_and_json_hold_the_same_points(folder, points):
    with (folder / 'report.csv').open(newline='', encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(points)
    for row, point in zip(rows, points):
        assert row['problem'] == 'torque_free_top'
        assert (float(row['error']) if row['error'] else None) == point['error']
        assert (float(row['cost']) if row['cost'] else None) == point['cost']
        assert row['setting'] == point['setting']


def test_json_survives_reading_and_writing(folder, tmp_path):
    read = results.read(folder)
    results.write(read, tmp_path)
    assert results.read(tmp_path) == read
    assert (tmp_path / 'report.json').read_bytes() == (folder / 'report.json').read_bytes()
    assert not list(tmp_path.glob('*.part'))


def test_the_file_tells_what_it_was_made_on(folder):
    about = results.read(folder)['made']
    assert about['versions'].keys() >= {'rigid_body_sim', 'python', 'numpy', 'scipy'}
    assert (about['repetitions'], about['quick'], about['interrupted']) == (1, True, False)


def test_another_schema_is_refused(folder, tmp_path):
    changed = results.read(folder) | {'schema': 99}
    (tmp_path / 'report.json').write_text(json.dumps(changed), encoding='utf-8')
    with pytest.raises(UserError, match='schema 99'):
        results.read(tmp_path)


def test_a_refused_method_is_one_point_with_its_reason():
    (point,) = measure(PROBLEMS['damped_fall'], ['blanes_moan4'], quick=True)
    assert (point.status, point.setting, point.error) == (REFUSED, 'any', None)
    assert 'depends on velocity' in point.note


def test_a_result_that_says_nothing_is_named_so():
    problem = PROBLEMS['torque_free_top']
    entry = our_entry(problem, method('dmv6'), Setting(5.0), scene=problem.scene())
    point, runner, _ = run_once(problem, entry)
    assert point.status == NOT_ACCURATE and runner is not None
    assert 'errors from 0.5 rad on' in point.note


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (['--problems', 'neddle'], "did you mean 'needle'?"),
        (['--integrators', 'dvm6'], "did you mean 'dmv6'?"),
        (['--integrators', 'rk4:orientation=matrx'], 'allowed: quaternion, matrix'),
        (['--integrators', 'rk4:matrix'], 'no option=value'),
        (['--repetitions', '0'], 'allowed: 1 or more'),
        (['--duration', '3'], 'goes with --scene'),
        (['--scene', 'no_such'], 'no such file'),
        (['--scene', 'free_fall', '--tolerance', 'nan'], 'allowed: a positive number'),
        (['--scene', 'free_fall', '--problems', 'needle'], 'give one of them'),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(words, said, tmp_path, capsys):
    assert main(['report', *words, '-o', str(tmp_path / 'out')]) == 2
    message = capsys.readouterr().err
    assert said in message and message.count('\n') == 1
    assert not (tmp_path / 'out').exists()


def test_a_file_in_place_of_the_folder_is_refused(tmp_path, capsys):
    (tmp_path / 'out').write_text('')
    assert main(['report', '-o', str(tmp_path / 'out')]) == 2
    assert 'is a file' in capsys.readouterr().err


def test_a_report_is_never_replaced(folder, capsys):
    before = (folder / 'report.json').read_bytes()
    assert main(['report', *QUICK, '--problems', 'projectile', '-o', str(folder)]) == 2
    said = capsys.readouterr().err
    assert said.endswith(f'{folder}: holds a report already; choose another folder or remove it\n')
    assert (folder / 'report.json').read_bytes() == before


def test_a_report_on_a_full_disk_says_what_is_safe_and_what_to_do(tmp_path, capsys, monkeypatch):
    taken = []

    def fills(part, path):
        taken.append(path.name)
        if taken.count('report.json') == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        Path(part).rename(path)

    monkeypatch.setattr('os.replace', fills)
    words = ['--problems', 'projectile', 'oscillator', '--integrators', 'dmv6', *QUICK]
    assert main(['report', *words, '-o', str(tmp_path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(
        f'{tmp_path / "report.json"}: cannot be written: No space left on device; what was there '
        'before is as it was; make room, or choose another place; report.json holds projectile; '
        'measure the rest into another folder: --problems oscillator'
    )
    assert [problem['name'] for problem in results.read(tmp_path)['problems']] == ['projectile']
    assert not list(tmp_path.glob('.*'))


def test_an_interrupted_report_leaves_what_is_done(tmp_path):
    words = ['--problems', 'projectile', 'throughput', '--integrators', 'dmv6']
    run = subprocess.Popen(
        [sys.executable, '-m', 'rigid_body_sim', 'report', *words, '-o', str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ,
        # a suite that runs in the background ignores it, and so would its children
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert run.stdout.readline().startswith('projectile: ')
    run.send_signal(signal.SIGINT)  # throughput takes seconds
    _, said = run.communicate(timeout=HANGING)
    assert run.returncode == 130
    assert 'stopped by Ctrl-C' in said and '; 1 of 2 problems' in said and 'Traceback' not in said
    read = results.read(tmp_path)
    assert read['made']['interrupted']
    assert [problem['name'] for problem in read['problems']] == ['projectile']


def test_a_report_that_ends_before_its_first_problem_leaves_none(tmp_path, capsys, monkeypatch):
    def stopped(*_arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr('rigid_body_sim.verbs.report._measured', stopped)
    words = ['--problems', 'projectile', '--integrators', 'dmv6', *QUICK]
    assert main(['report', *words, '-o', str(tmp_path / 'out')]) != 0
    assert '; nothing is written' in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def test_the_step_recommended_for_a_scene_keeps_its_promise(tmp_path, capsys):
    scene = TOP | {'dt': 0.05}
    (tmp_path / 'flips.yaml').write_text(json.dumps(scene), encoding='utf-8')
    words = ['--scene', str(tmp_path / 'flips.yaml'), '--duration', '20', '--tolerance', '1e-7']
    words += ['--integrators', 'dmv6', 'rk4', *QUICK, '-o', str(tmp_path / 'out')]
    assert main(['report', *words]) == 0
    line = capsys.readouterr().out.splitlines()[-2]
    assert line.startswith('recommended for flips: use integrator ')
    said = line.split('use integrator ')[1].split(':')[0]
    name, dt, substeps = said.replace('dt ', '').replace('substeps ', '').split(', ')
    simulation = Simulation(
        load_scene(scene),
        integrator=name,
        dt=float(dt),
        integrator_options={'substeps': int(substeps)},
    )
    exact = free_asymmetric_top.rotation(
        np.array([2.0 * k for k in range(1, 11)]),
        inertia=(1.0, 2.0, 3.0),
        angular_velocity_body=(0.01, 1.0, 0.01),
    )
    errors = []
    for orientation in exact.orientation:
        simulation.step(round(2.0 / float(dt)))
        errors.append(angle_between(simulation.state.orientation[0], orientation))
    assert max(errors) < 1e-7
    read = results.read(tmp_path / 'out')['problems'][0]
    assert read['recommendation'] in line
    assert read['reference_error'] < 1e-10
    for text in ((tmp_path / 'out' / name).read_text() for name in ('report.html', 'report.md')):
        assert 'exact answers are known' not in text and 'Exact answer' not in text
        assert 'stands for the exact motion' in text and 'make report' not in text
        assert f'python -m rigid_body_sim report --scene {tmp_path / "flips.yaml"}' in text
        assert '--duration 20.0 --tolerance 1e-07' in text
    page = (tmp_path / 'out' / 'report.html').read_text()
    assert 'largest error at 10 instants [m or rad]' in page and 'error at the end' not in page


def test_a_scene_that_comes_to_rest_is_judged_on_the_way():
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}
    scene = load_scene(
        {
            'version': 1,
            'name': 'rest',
            'dt': 0.01,
            'bodies': [ball | {'initial': {'position': [1.0, 0.0, 0.0]}}],
            'forces': [
                {'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': 40.0, 'damping': 8.0}
            ],
        }
    )
    against = own_scene.reference(scene, 10.0, lambda _text: None)
    problem = own_scene.problem_of(scene, 10.0, against, tolerance=1e-6)
    entry = our_entry(problem, method('rk4'), Setting(0.1), scene=scene)
    point, runner, _ = run_once(problem, entry)
    assert problem.error(runner.final()) < 1e-9 < 1e-5 < point.error


@pytest.mark.parametrize(('rate', 'longest'), [(100.0, 0.01), (10.0, 0.1), (1000.0, 0.002)])
def test_every_method_is_tried_with_ticks_up_to_the_publishing_period(rate, longest):
    """The tick of the scene, 2 ms, stands where it is longer than the period."""
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}
    head = {'version': 1, 'name': 'tried', 'dt': 0.002}
    scene = load_scene(head | {'bodies': [ball]})
    stands_for = own_scene.Reference([Simulation(scene).state] * own_scene.INSTANTS, 0.0, 'it')
    problem = own_scene.problem_of(scene, 10.0, stands_for, tolerance=1e-6, publish_rate=rate)
    assert problem.tick == max(problem.steps) == pytest.approx(longest)
    ours = {name for name, each in INTEGRATORS.items() if not each.is_reference}
    assert ours <= set(problem.integrators)


def test_a_recommendation_beyond_a_limit_says_so():
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}
    spring = {'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': 1e6, 'rest_length': 1.0}
    head = {'version': 1, 'name': 'stiff', 'dt': 0.01}
    scene = load_scene(head | {'bodies': [ball], 'forces': [spring]})
    against = own_scene.Reference([Simulation(scene).state] * own_scene.INSTANTS, 0.0, 'it')
    problem = own_scene.problem_of(scene, 1.0, against, tolerance=1e-3)
    points = [
        Point('ours', '', name, 'double', '', 0.01, None, 1, OK, error=1e-4, cost=cost)
        for name, cost in (('implicit_midpoint', 1e-6), ('sdirk2', 1e-5))
    ]
    for some, said in ((points, 'for longer runs mind'), (points[1:], '--publish-rate)')):
        text = own_scene.recommendation(some, problem, tolerance=1e-3, against=against)
        assert f'use integrator {some[0].method}' in text and said in text
    assert text.endswith('--publish-rate)')


def test_the_commands_of_the_readme_are_understood():
    text = (Path(__file__).parents[2] / 'README.md').read_text(encoding='utf-8')
    lines = [
        line for line in text.splitlines() if line.startswith('python -m rigid_body_sim report')
    ]
    for line in lines:
        words = shlex.split(line, comments=True)[4:]
        assert inside.wanted(words)
    assert len(lines) == 2
