# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`simulate`: a scene to a bag."""

import hashlib
import math

import pytest

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.commands import read_csv
from rigid_body_sim.scene import load_scene

from .conftest import SCENES

SCENE = SCENES / 'two_bodies.yaml'


def message_digest(path):
    digest = hashlib.sha256()
    for message in Bag(path).messages():
        digest.update(repr(message).encode())
    return digest.hexdigest()


def test_two_runs_write_the_same_message_bytes(verb, tmp_path, commands):
    for name in ('one', 'two'):
        words = ('--duration', 0.5, '--commands', commands)
        assert verb('simulate', SCENE, '-o', tmp_path / name, *words)[0] == 0
    assert message_digest(tmp_path / 'one') == message_digest(tmp_path / 'two')


def test_with_and_without_numba_the_message_bytes_are_the_same(process, tmp_path, commands):
    for name, compiled in (('compiled', '1'), ('plain', '0')):
        result = process(
            'simulate', SCENE, '-o', tmp_path / name, '--duration', '0.3', '--commands', commands,
            RIGID_BODY_SIM_COMPILE=compiled,
        )  # fmt: skip
        assert result.returncode == 0, result.stderr
    assert message_digest(tmp_path / 'compiled') == message_digest(tmp_path / 'plain')


def test_json_names_the_run_and_nothing_else_is_printed(as_json, tmp_path):
    code, result = as_json(
        'simulate', SCENES / 'free_fall.yaml', '-o', tmp_path / 'b', '--duration', 1
    )
    assert code == 0
    assert result['ticks'] * result['dt'] == pytest.approx(1.0)
    assert result['sim_time'] == pytest.approx(1.0)
    for key in ('energy_drift', 'momentum_drift', 'angular_momentum_drift'):
        assert 0 <= result[key] < 1e-12  # round-off: free fall is integrated exactly
    assert result['bag'] == str(tmp_path / 'b')
    assert result['ns_per_body_tick'] > 0


def test_a_duration_that_is_no_whole_number_of_ticks_is_rounded_and_said(verb, tmp_path):
    scene = SCENES / 'free_fall.yaml'
    for name, duration, ticks in (
        ('up', '0.0106', 11),
        ('down', '0.0104', 10),
        ('whole', '0.3', 0),
    ):
        code, _, err = verb('simulate', scene, '-o', tmp_path / name, '--duration', duration)
        assert code == 0
        rounded = f'--duration {duration} s is no whole number of ticks of 0.001 s; '
        assert (rounded + f'the run takes {ticks} of them' in err) == bool(ticks)


def test_a_timeout_that_is_no_whole_number_of_ticks_is_rounded_and_said(verb, tmp_path):
    (tmp_path / 'c.csv').write_text('time,body,kind,fx\n0,ball,force,1\n')
    words = ('simulate', SCENES / 'free_fall.yaml', '--commands', tmp_path / 'c.csv')
    for name, timeout, dt, said in (
        ('up', '0.2', '0.03', '0.2 s is no whole number of ticks of 0.03 s; a command acts for 7 '
         'of them, 0.21 s'),
        ('whole', '0.2', '0.01', ''),
        ('never', '0', '0.03', ''),
    ):  # fmt: skip
        times = ('--command-timeout', timeout, '--dt', dt, '--duration', '0.6')
        code, _, err = verb(*words, *times, '-o', tmp_path / name)
        assert code == 0
        assert ('--command-timeout' in err) == bool(said) and said in err


def test_a_bag_of_free_fall_holds_the_parabola(verb, tmp_path):
    scene = tmp_path / 'fall.yaml'
    scene.write_text(
        'version: 1\nname: fall\ndt: 0.001\ngravity: [0, 0, -9.81]\n'
        'bodies:\n  - '
        '{name: ball, mass: 1, shape: {type: sphere, radius: 0.1}, '
        'initial: {position: [0, 0, 10]}}\n'
    )
    assert verb('simulate', scene, '-o', tmp_path / 'b', '--duration', 1)[0] == 0
    bag = Bag(tmp_path / 'b')
    poses = list(bag.messages(['/ball/pose']))
    assert len(poses) == 101  # with that of t = 0
    for message in poses:
        pose = cdr.decode(bag.topics[message.topic].type, message.data)
        t = message.log_time * 1e-9
        assert message.sequence * 1_000_000 == message.log_time
        assert pose.position[2] == pytest.approx(10 - 9.81 * t**2 / 2, rel=1e-13)  # round-off


def test_commands_are_recorded_with_the_tick_on_which_they_first_acted(bag):
    found = [
        (m.topic, m.sequence, m.log_time)
        for m in Bag(bag).messages(['/box/wrench', '/box/torque', '/ball/impulse'])
    ]
    assert found == [
        ('/box/wrench', 50, 50_000_000),
        ('/box/torque', 100, 100_000_000),
        ('/ball/impulse', 150, 150_000_000),
        ('/box/wrench', 203, 203_000_000),
    ]


def test_log_times_ascend_in_the_file(bag):
    times = [message.log_time for message in Bag(bag).messages()]
    assert times == sorted(times)


def test_a_diverging_run_stops_names_the_body_and_leaves_a_readable_bag(verb, tmp_path):
    scene = tmp_path / 'stiff.yaml'
    scene.write_text(
        'version: 1\nname: stiff\ndt: 0.01\n'
        'bodies:\n  - '
        '{name: ball, mass: 1, shape: {type: particle}, initial: {position: [1, 0, 0]}}\n'
        'forces:\n  - {type: spring, a: ball, b: world, stiffness: 1000000}\n'
    )
    code, _, err = verb('simulate', scene, '-o', tmp_path / 'b', '--integrator', 'explicit_euler')
    assert code == 1
    warning, *gains, error = err.splitlines()
    assert "warning: 'ball'" in warning
    assert gains
    assert all('warning: the scene gained' in gain for gain in gains)
    assert "'ball' diverged in tick" in error
    bag = Bag(tmp_path / 'b')
    assert bag.ending['end_reason'] == 'diverged'
    poses = [cdr.decode(cdr.PoseStamped.TYPE, m.data) for m in bag.messages(['/ball/pose'])]
    assert poses and all(math.isfinite(x) for pose in poses for x in pose.position)


@pytest.mark.parametrize(
    ('words', 'expected'),
    [
        (['no_such_scene.yaml', '-o', 'b'], 'no_such_scene'),
        ([SCENE, '-o', 'b', '--integrator', 'rk5'], 'rk5'),
        ([SCENE, '-o', 'b', '--dt', '0.3333333333333333'], 'nanosecond'),
        ([SCENE, '-o', 'b', '--dt', '-1'], 'dt'),
        ([SCENE, '-o', 'b', '--duration', '-1'], 'duration'),
        ([SCENE, '-o', 'b', '--duration', 'nan'], 'duration'),
        ([SCENE, '-o', 'b', '--commands', 'none.csv'], 'none.csv'),
    ],
)
def test_bad_arguments_exit_2_with_one_line(verb, tmp_path, monkeypatch, words, expected):
    monkeypatch.chdir(tmp_path)
    code, out, err = verb('simulate', *words)
    assert code == 2
    assert expected in err
    assert err.count('\n') == 1
    assert 'Traceback' not in err
    assert not out
    assert not (tmp_path / 'b').exists()


def test_an_existing_bag_is_never_overwritten(verb, tmp_path):
    (tmp_path / 'b').mkdir()
    (tmp_path / 'b' / 'precious').write_text('data')
    code, _, err = verb('simulate', SCENE, '-o', tmp_path / 'b')
    assert code == 2
    assert 'exists' in err
    assert (tmp_path / 'b' / 'precious').read_text() == 'data'


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('time,body\n', 'needed'),
        ('time,body,kind,colour\n0,box,force,red\n', 'colour'),
        ('time,body,kind,fx\n0,box,push,1\n', "'push'"),
        ('time,body,kind,fx\n0,nobody,force,1\n', 'nobody'),
        ('time,body,kind,fx\n-1,box,force,1\n', 'time'),
        ('time,body,kind,fx\n0,box,force,nan\n', 'finite'),
        ('time,body,kind,fx\n0,box,force,one\n', "'one'"),
        ('time,body,kind,tx\n0,ball,torque,1\n', 'point mass'),
        ('time,body,kind,fx\n0,box\n', 'line 2'),
        ('time,body,kind,fx\n,box,force,1\n', 'line 2: time is empty; allowed: 0 and more'),
        ('time,body,kind,fx,fx\n0,box,force,1,2\n', 'fx stands there 2 times'),
        ('time,body,kind,fx,tz\n0,box,force,1,5e-1\n', 'line 2: force has no tz, got 5e-1'),
        ('time,body,kind,fx,tz\n0,box,torque,1,1\n', 'line 2: torque has no fx, got 1; leave'),
    ],
)
def test_bad_command_files_are_refused_by_line(verb, tmp_path, text, expected):
    path = tmp_path / 'c.csv'
    path.write_text(text)
    code, _, err = verb('simulate', SCENE, '-o', tmp_path / 'b', '--commands', path)
    assert code == 2
    assert expected in err
    assert err.count('\n') == 1


def test_a_table_of_commands_may_have_blanks_after_its_commas(tmp_path):
    scene = load_scene(SCENE)
    tight, wide = tmp_path / 'tight.csv', tmp_path / 'wide.csv'
    lines = 'time,body,kind,frame,fx\n0.1,box,force,world,2\n'
    tight.write_text(lines)
    wide.write_text(lines.replace(',', ', '))
    assert read_csv(wide, scene, dt_ns=10**6) == read_csv(tight, scene, dt_ns=10**6)


def test_a_force_beside_empty_or_zero_torques_is_obeyed_and_replays(verb, tmp_path):
    path, bag = tmp_path / 'c.csv', tmp_path / 'b'
    path.write_text(
        '\ufefftime,body,kind,fx,fy,fz,tx,ty,tz\n'  # as spreadsheets write it
        '0,box,force,1,2,3,0,-0,\n0.1,box,torque,,0,-0,1,2,3\n0.2,box,wrench,1,2,3,1,2,3\n',
        encoding='utf-8',
    )
    code, _, err = verb('simulate', SCENE, '-o', bag, '--commands', path, '--duration', 0.3)
    assert (code, err) == (0, '')
    assert verb('replay', bag)[0] == 0


@pytest.mark.parametrize(
    ('times', 'expected'),
    [
        ((), 'c.csv of --commands holds a header and no command'),
        (('0.1', '0.2'), 'c.csv of --commands: 1 of 2 commands never act, the first at 0.2 s'),
        (('7', '0.1', '5'), '2 of 3 commands never act, the first at 5 s'),
        (('0.199',), ''),
        (('0.1991',), 'the first at 0.1991 s: the last tick of the run begins at 0.199 s'),
    ],
)
def test_commands_that_never_act_are_told(verb, tmp_path, times, expected):
    path = tmp_path / 'c.csv'
    rows = ''.join(f'{time},box,force,1\n' for time in times)
    path.write_text('time,body,kind,fx\n' + rows)
    words = ('--commands', path, '--duration', 0.2, '--dt', 0.001)
    code, _, err = verb('simulate', SCENE, '-o', tmp_path / 'b', *words)
    assert code == 0
    assert (expected in err and err.count('\n') == 1) if expected else not err


@pytest.mark.usefixtures('plain_source')
def test_the_drift_of_the_matrices_is_told_and_recorded(tmp_path, as_json, verb):
    """Euler about a fixed axis: |R^T R - 1| = (1 + (h w)^2)^n - 1 after n steps."""
    scene = tmp_path / 'spin.yaml'
    text = 'dt: 0.01\nbodies: [{name: b, shape: {type: box, size: [1, 2, 3]}, mass: 1, '
    text += 'initial: {angular_velocity: [0, 0, 1]}}]\nintegrator: explicit_euler\n'
    kept = 'orientation: {representation: matrix, reorthonormalise: true}\n'
    scene.write_text(text + kept)
    code, result = as_json('simulate', scene, '-o', tmp_path / 'kept', '--duration', '1')
    assert (code, result['orientation_drift'] < 1e-14) == (0, True)
    scene.write_text(f'{text}orientation: matrix\n')
    _, result = as_json('simulate', scene, '-o', tmp_path / 'drifts', '--duration', '1')
    assert result['orientation_drift'] == pytest.approx((1 + 1e-4) ** 100 - 1, rel=1e-10)
    ending = Bag(tmp_path / 'drifts').ending
    assert float(ending['orientation_drift']) == result['orientation_drift']
    _, out, _ = verb('simulate', scene, '-o', tmp_path / 'said', '--duration', '1')
    assert 'drift of the matrices: |R^T R - 1| up to 1.0e-02' in out
    scene.write_text(text)
    _, result = as_json('simulate', scene, '-o', tmp_path / 'quaternions', '--duration', '1')
    assert result['orientation_drift'] is None
    assert 'orientation_drift' not in Bag(tmp_path / 'quaternions').ending
