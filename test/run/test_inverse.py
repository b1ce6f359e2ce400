# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`inverse`: from the poses of a bag or a CSV file to twists, accelerations and wrenches."""

import json

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from rigid_body_sim import load_scene
from rigid_body_sim.__main__ import main
from rigid_body_sim.analysis.jumps import jumps_of
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.bag_writer import BagWriter

SCENE = """
version: 1
dt: 0.001
gravity: [0, 0, -9.81]
integrator: rk4
bodies:
  - name: ball
    shape: {type: particle}
    mass: 2.0
    initial: {position: [1, 0, 0], velocity: [0, 1, 3]}
  - name: box
    shape: {type: box, size: [0.3, 0.2, 0.1]}
    mass: 3.0
    initial: {angular_velocity: [1, 2, 3]}
  - {name: post, shape: {type: box, size: [1, 1, 1]}, fixed: true}
forces:
  - {type: spring, a: ball, b: world, stiffness: 8}
"""
COMMANDS = 'time,body,kind,frame,fx,fy,fz,tx,ty,tz\n0.6,box,wrench,world,1,2,3,0.01,0.02,0.03\n'


def simulated(folder, scene, commands, *words):
    """The bag of 1.2 s of a scene under commands."""
    (folder / 'scene.yaml').write_text(scene)
    (folder / 'commands.csv').write_text(commands)
    words = ('--duration', 1.2, '--commands', folder / 'commands.csv', *words)
    words = ('simulate', folder / 'scene.yaml', '-o', folder / 'run', *words)
    assert main([str(word) for word in words]) == 0
    return folder / 'run'


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    return simulated(tmp_path_factory.mktemp('recorded'), SCENE, COMMANDS)


@pytest.fixture(scope='module')
def derived(recorded):
    """The bag that `inverse` makes of a run."""
    path = recorded.parent / 'derived'
    assert main(['inverse', str(recorded), '-o', str(path)]) == 0
    return path


def column(bag, topic):
    """Every message of a topic as rows of its numbers."""
    found = []
    for message in bag.messages([topic]):
        decoded = cdr.decode(bag.topics[topic].type, message.data)
        found.append([x for name, _ in decoded.PARTS for x in getattr(decoded, name)])
    return np.array(found)


def test_twist_acceleration_and_wrench_of_a_run_come_back(recorded, tmp_path, as_json):
    code, result = as_json('inverse', recorded, '-o', tmp_path / 'new')
    assert code == 0
    old, new = Bag(recorded), Bag(tmp_path / 'new')
    errors = result['bodies']['ball']['errors']
    for body in ('ball', 'box'):
        assert np.array_equal(column(new, f'/{body}/pose'), column(old, f'/{body}/pose'))
        # the estimates foretell the error within a factor of three; truncation at 100 samples per
        # second
        assert column(new, f'/{body}/twist') == pytest.approx(
            column(old, f'/{body}/twist'), abs=1e-6
        )
    position = column(old, '/ball/pose')[:, :3]
    wrench = column(new, '/ball/wrench')
    assert wrench[:, :3] == pytest.approx(
        -8.0 * position, abs=3 * errors['force']['largest'] + 1e-9
    )
    assert column(new, '/ball/accel')[:, :3] == pytest.approx(
        -4.0 * position + [0, 0, -9.81], abs=3 * errors['acceleration']['largest'] + 1e-9
    )
    assert not np.any(wrench[:, 3:])


def test_a_command_is_found_from_the_motion_alone(derived):
    new = Bag(derived)
    wrench = column(new, '/box/wrench')
    times = np.array([message.log_time for message in new.messages(['/box/wrench'])]) * 1e-9
    acts = (times > 0.6 - 1e-6)[:, None]
    # dmv6 turns under a torque to order two: 1e-6 of the torque at 1 ms; the ends of the splines
    # lose more
    assert wrench == pytest.approx(np.where(acts, [1, 2, 3, 0.01, 0.02, 0.03], 0.0), abs=1e-4)


def test_the_new_bag_is_one_that_other_programs_read(derived):
    with AnyReader([derived]) as reader:
        kinds = {connection.topic: connection.msgtype for connection in reader.connections}
        assert kinds['/box/accel'] == 'geometry_msgs/msg/AccelStamped'
        connection = next(c for c in reader.connections if c.topic == '/box/accel')
        _, stamp, data = next(reader.messages([connection]))
        message = reader.deserialize(data, connection.msgtype)
        assert message.header.frame_id == 'world'
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
    assert '/post/wrench' not in kinds
    report = json.loads(Bag(derived).attachments['inverse.json'])
    assert set(report['bodies']) == {'ball', 'box', 'post'}


def test_poses_from_a_csv_file_give_the_same_as_those_of_a_bag(
    recorded, derived, tmp_path, as_json
):
    lines = ['time,body,px,py,pz,qx,qy,qz,qw']
    bag = Bag(recorded)
    for topic in ('/ball/pose', '/box/pose'):
        body = topic.split('/')[1]
        for message, row in zip(bag.messages([topic]), column(bag, topic), strict=True):
            orientation = [''] * 4 if body == 'ball' else map(repr, row[3:].tolist())
            lines.append(
                ','.join(
                    [
                        f'{message.log_time / 1e9!r}',
                        body,
                        *map(repr, row[:3].tolist()),
                        *orientation,
                    ]
                )
            )
    path = tmp_path / 'poses.csv'
    path.write_text('\n'.join(lines) + '\n')
    code, result = as_json(
        'inverse', path, '-o', tmp_path / 'csv', '--scene', recorded.parent / 'scene.yaml'
    )
    assert code == 0 and result['bodies']['box']['wrench']
    a, b = Bag(tmp_path / 'csv'), Bag(derived)
    assert np.array_equal(column(a, '/ball/wrench'), column(b, '/ball/wrench'))
    code, result = as_json('inverse', path, '-o', tmp_path / 'massless')
    assert code == 0 and not result['bodies']['box']['wrench']
    assert '/box/wrench' not in Bag(tmp_path / 'massless').topics


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('time,body,px,py\n', 'needed: time, body, px, py, pz'),
        ('time,body,px,py,pz\n', 'holds no rows'),
        ('time,body,px,py,pz\n0,box,1,2,x\n', "line 2: pz 'x'; allowed: a finite number"),
        ('time,body,px,py,pz\n0,box,1,2\n', 'line 2: has not as many values'),
        ('time,body,px,py,pz\n-1,box,1,2,3\n', 'line 2: time -1 s'),
        ('time,body,px,py,pz\n0,a b,1,2,3\n', "line 2: body 'a b'"),
        (
            'time,body,px,py,pz\n0,box,1,2,3\n',
            '/box: 1 samples; a spline of degree 5 needs at least 6',
        ),
    ],
)
def test_a_file_that_tells_no_motion_is_refused(tmp_path, verb, text, said):
    path = tmp_path / 'poses.csv'
    path.write_text(text)
    code, _, err = verb('inverse', path, '-o', tmp_path / 'new')
    assert code == 2
    assert said in err and err.count('\n') == 1
    assert not (tmp_path / 'new').exists()


@pytest.mark.parametrize('start', [0.0, 1.0, 1.7e9])
@pytest.mark.parametrize('with_scene', [False, True])
def test_a_time_that_does_not_ascend_is_told_in_seconds(tmp_path, verb, start, with_scene):
    text = 'time,body,px,py,pz\n'
    for k in (0, 1, 2, 2, 3, 4, 5, 6):
        text += f'{start + 0.25 * k!r},box,0,0,0\n'
    (tmp_path / 'poses.csv').write_text(text)
    scene = ('--scene', 'two_bodies') if with_scene else ()
    code, _, err = verb('inverse', tmp_path / 'poses.csv', '-o', tmp_path / 'new', *scene)
    assert code == 2
    at = f'{start + 0.5:.15g} s'
    assert f'sample 3, at {at}, is not later than the one before, at {at}; times' in err


def test_a_bag_without_poses_and_an_existing_target_are_refused(recorded, tmp_path, verb):
    code, _, err = verb('inverse', recorded, '-o', recorded)
    assert code == 2 and 'exists already' in err
    code, _, err = verb('inverse', tmp_path / 'none', '-o', tmp_path / 'new')
    assert code == 2 and 'no such file' in err


def test_people_read_the_estimated_errors(recorded, tmp_path, verb):
    code, out, _ = verb('inverse', recorded, '-o', tmp_path / 'new')
    assert code == 0
    assert 'box: 121 samples; estimated error, mean (largest):' in out
    assert 'post: 121 samples' in out and 'no wrench' in out


def test_the_new_bag_is_whole_and_says_that_it_holds_no_run(recorded, derived, verb):
    assert verb('bag', 'check', derived)[0] == 0
    code, _, err = verb('replay', derived)
    assert code == 2
    assert f'holds no run of rigid_body_sim, but what inverse derived from {recorded.name}' in err


JUMPY = """
version: 1
dt: 0.001
gravity: [0, 0, -9.81]
integrator: rk8
bodies:
  - name: box
    shape: {type: box, size: [0.3, 0.2, 0.1]}
    mass: 1.5
    initial: {velocity: [0.3, -0.2, 2], angular_velocity: [1.0, 2.0, 0.5]}
forces:
  - {type: constant, body: box, force: [0, 0, 0]}  # for a kernel that others have
"""
JUMPY_COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.2503,box,wrench,world,1,2,-1,0.01,0.02,0
0.5,box,wrench,body,0.5,-1,2,0.01,-0.01,0.02
0.8,box,force,world,3,0,0,0,0,0
0.9,box,impulse,body,0.3,0,0.1,0.001,0,0.002
"""


@pytest.fixture(scope='module')
def jumpy(tmp_path_factory):
    """A run with jumps in both axes between and at samples, published at 1 kHz, and its truth."""
    folder = tmp_path_factory.mktemp('jumpy')
    return simulated(folder, JUMPY, JUMPY_COMMANDS, '--publish-rate', 1000)


def thinned(bag, path, every):
    """The same run published every so many ticks."""
    old = Bag(bag)
    writer = BagWriter(
        path,
        topics=list(old.topics.values()),
        manifest=old.manifest | {'publish_every': str(every)},
        attachments=old.attachments,
    )
    for message in old.messages():
        kept = not message.topic.endswith(('/pose', '/twist')) or message.sequence % every == 0
        if kept:
            writer.write_message(message.topic, message.sequence, message.log_time, message.data)
    writer.close({})
    return path


def by_time(bag, topic):
    times = [message.log_time for message in bag.messages([topic])]
    return dict(zip(times, column(bag, topic), strict=True))


@pytest.mark.parametrize(
    ('every', 'within'),
    [*(pytest.param(*one, marks=pytest.mark.long) for one in ((1, 1e-5), (10, 1e-4))), (20, 2e-3)],
)
def test_every_jump_of_the_wrench_is_seen_at_its_tick(jumpy, tmp_path, as_json, every, within):
    """World axes, body axes, two sources at once, an impulse; between samples and at them."""
    source = thinned(jumpy, tmp_path / 'thin', every)
    code, result = as_json('inverse', source, '-o', tmp_path / 'new')
    assert code == 0 and result['jumps_known']
    new = Bag(tmp_path / 'new')
    true, found = by_time(Bag(jumpy), '/box/applied_wrench'), by_time(new, '/box/wrench')
    struck = 900_000_000  # there the applied wrench holds the impulse, spread over its tick
    stamps = [stamp for stamp in found if stamp in true and stamp != struck]
    wrong = np.array([found[stamp] - true[stamp] for stamp in stamps])
    assert np.max(np.abs(wrong)) < within  # of 3 N; truncation, or rounding at 1 kHz
    told = result['bodies']['box']['errors']['force']['rms']
    assert told < 2.0 * within
    twist, derived = by_time(Bag(jumpy), '/box/twist'), by_time(new, '/box/twist')
    assert max(np.max(np.abs(derived[t] - twist[t])) for t in derived) < within  # also at the blow


def test_a_command_that_runs_out_ends_at_its_tick(jumpy):
    bag, scene = Bag(jumpy), load_scene(Bag(jumpy).attachments['scene.yaml'])
    bag.manifest['command_timeout_ns'] = '100000000'
    found = jumps_of(bag, scene).paths['box']
    strong = [round(b.instant * 1e-6) for b in found if b.continuity <= 1]
    assert strong == [251, 351, 500, 600, 800, 900]  # [ms]; the last runs out as the blow strikes
    assert [b.continuity for b in found if b.instant == 9e8] == [0]


def test_what_one_body_feels_of_anothers_jump_is_smoother():
    scene = load_scene(
        {
            'dt': 0.001,
            'bodies': [
                {'name': n, 'shape': {'type': 'particle'}, 'mass': 1} for n in ('a', 'b', 'c')
            ],
            'forces': [
                {'type': 'spring', 'a': 'a', 'b': 'b', 'stiffness': 1, 'damping': 1},
                {'type': 'spring', 'a': 'b', 'b': 'c', 'stiffness': 1},
                {
                    'type': 'time',
                    'body': 'a',
                    'table': [[1, 1, 0, 0], [2, 2, 0, 0], [3, 3, 0, 0], [4, 0, 0, 0]],
                },
            ],
        }
    )

    class Nothing:
        holds_run = False

    found = jumps_of(Nothing(), scene).paths
    at = {body: {b.instant * 1e-9: b.continuity for b in found.get(body, ())} for body in 'abc'}
    assert at['a'] == {1.0: 1, 3.0: 2, 4.0: 2}  # it begins, it bends; the row at 2 s is straight
    assert at['b'] == {1.0: 2, 3.0: 3, 4.0: 3}
    assert at['c'] == {}


FALLING = """
version: 1
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: MODE}
bodies:
  - {name: ground, fixed: true, shape: {type: plane, normal: [0, 0, 1]}}
  - name: ball
    shape: {type: sphere, radius: 0.1}
    mass: 1
    restitution: 0.8
    initial: {position: [0, 0, 1.1], velocity: [0.3, 0, 0]}
"""


@pytest.mark.parametrize('mode', ['event', 'timestep'])
def test_between_its_bounces_a_ball_falls_with_g_and_no_force(tmp_path, as_json, verb, mode):
    """Recorded impacts are breaks; of others the poses show the instants."""
    (tmp_path / 'scene.yaml').write_text(FALLING.replace('MODE', mode))
    assert (
        verb('simulate', tmp_path / 'scene.yaml', '-o', tmp_path / 'run', '--duration', 2.5)[0]
        == 0
    )
    code, result = as_json('inverse', tmp_path / 'run', '-o', tmp_path / 'new')
    assert code == 0
    told = result['bodies']['ball']
    assert told['smoothing']['position']['breaks'] == 4
    assert len(told['smoothing']['position']['found']) == (0 if mode == 'event' else 4)
    new, old = Bag(tmp_path / 'new'), Bag(tmp_path / 'run')
    fall = np.tile([0.0, 0.0, -9.81], (len(column(new, '/ball/accel')), 1))
    assert column(new, '/ball/accel')[:, :3] == pytest.approx(fall, abs=1e-3)  # rounding / h^2
    wrong = column(new, '/ball/twist')[:, :3] - column(old, '/ball/twist')[:, :3]
    assert np.sqrt(np.mean(np.sum(wrong**2, axis=1))) < 1e-6  # of 4 m/s


def test_jumps_that_last_are_told_with_their_times(tmp_path, verb):
    """A push of six samples: where it begins and ends, body, stretch and cure are named."""
    assert verb('simulate', 'elastic_push', '-o', tmp_path / 'run', '--duration', 1)[0] == 0
    code, out, _ = verb('inverse', tmp_path / 'run', '-o', tmp_path / 'new')
    assert code == 0
    line = next(line for line in out.splitlines() if 'warning' in line)
    assert 'position jumps within the samples at 0.42 to 0.5 s' in line and 'publish-rate' in line
    twist, band = (
        column(Bag(tmp_path / 'new'), '/heavy/twist'),
        column(Bag(tmp_path / 'new'), '/heavy/twist_std'),
    )
    wrong = twist[:, :3] - column(Bag(tmp_path / 'run'), '/heavy/twist')[:, :3]
    assert np.sqrt(np.mean(wrong**2)) < 2.0 * np.sqrt(np.mean(band[:, :3] ** 2))


def test_noise_is_smoothed_and_its_band_is_written(tmp_path, as_json, verb):
    random = np.random.default_rng(5)
    lines = ['time,body,px,py,pz']
    for k in range(500):
        t = k * 1e-3
        place = np.array([np.sin(3 * t), t, 0.0]) + 1e-6 * random.standard_normal(3)
        lines.append(','.join([f'{t:.3f}', 'box', *map(repr, place.tolist())]))
    (tmp_path / 'poses.csv').write_text('\n'.join(lines) + '\n')
    (tmp_path / 'still.yaml').write_text(JUMPY.replace('-9.81', '0'))
    words = ['inverse', tmp_path / 'poses.csv', '--scene', tmp_path / 'still.yaml']
    code, result = as_json(*words, '-o', tmp_path / 'new')
    assert code == 0 and not result['jumps_known']
    smoothing = result['bodies']['box']['smoothing']['position']
    assert smoothing['noise'] == pytest.approx(1e-6, rel=0.1) and smoothing['smoothed']
    new = Bag(tmp_path / 'new')
    wrench, band = column(new, '/box/wrench'), column(new, '/box/wrench_std')
    true = np.zeros((500, 3))
    true[:, 0] = -1.5 * 9.0 * np.sin(3e-3 * np.arange(500))
    wrong = wrench[:, :3] - true
    rms = np.sqrt(np.mean(np.sum(np.square(wrong), axis=1)))
    assert rms < 0.02  # [N]; unsmoothed 12 N
    told = result['bodies']['box']['errors']['force']['rms']
    assert rms / 3 < told < 3 * rms
    assert np.mean(np.abs(wrong) < 2.0 * band[:, :3]) > 0.85
    code, out, _ = verb(*words, '-o', tmp_path / 'wide', '--bandwidth', 50)
    assert code == 0 and 'smoothed to 50' in out and 'jumps: none known' in out


def test_what_is_known_of_the_ends_is_kept(jumpy, tmp_path, as_json, verb):
    words = ['inverse', thinned(jumpy, tmp_path / 'thin', 10), '-o']
    ends = ['--start-velocity', 1, 2, 3, '--end-velocity', 4, 5, 6]
    assert as_json(*words, tmp_path / 'given', *ends, '--body', 'box')[0] == 0
    twist = column(Bag(tmp_path / 'given'), '/box/twist')
    assert twist[0, :3] == pytest.approx([1, 2, 3]) and twist[-1, :3] == pytest.approx([4, 5, 6])
    assert as_json(*words, tmp_path / 'rest', '--at-rest')[0] == 0
    twist = column(Bag(tmp_path / 'rest'), '/box/twist')
    assert np.max(np.abs(twist[[0, -1]])) < 1e-9
    for wrong, said in (
        (['--bandwidth', 0], 'allowed: a positive number'),
        (['--bandwidth', 'nan'], 'allowed: a positive number'),
        (['--at-rest', *ends], 'at rest'),
        (['--start-velocity', 'nan', 0, 0], 'three finite numbers'),
        (['--body', 'ball'], "no poses of a body named 'ball'; it has: box"),
    ):
        code, _, err = verb(*words, tmp_path / 'none', *wrong)
        assert code == 2 and said in err and err.count('\n') == 1
