# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`inverse`: from the poses of a bag or a CSV file to twists, accelerations and wrenches."""

import json

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag

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


@pytest.fixture
def recorded(tmp_path, verb):
    (tmp_path / 'scene.yaml').write_text(SCENE)
    (tmp_path / 'commands.csv').write_text(COMMANDS)
    path = tmp_path / 'run'
    words = ('--duration', 1.2, '--commands', tmp_path / 'commands.csv')
    assert verb('simulate', tmp_path / 'scene.yaml', '-o', path, *words)[0] == 0
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


def test_a_command_is_found_from_the_motion_alone(recorded, tmp_path, as_json):
    assert as_json('inverse', recorded, '-o', tmp_path / 'new')[0] == 0
    new = Bag(tmp_path / 'new')
    wrench = column(new, '/box/wrench')
    times = np.array([message.log_time for message in new.messages(['/box/wrench'])]) * 1e-9
    acts = (times > 0.6 - 1e-6)[:, None]
    # dmv6 turns under a torque to order two: 1e-6 of the torque at 1 ms; the ends of the splines
    # lose more
    assert wrench == pytest.approx(np.where(acts, [1, 2, 3, 0.01, 0.02, 0.03], 0.0), abs=1e-4)


def test_the_new_bag_is_one_that_other_programs_read(recorded, tmp_path, as_json):
    as_json('inverse', recorded, '-o', tmp_path / 'new')
    with AnyReader([tmp_path / 'new']) as reader:
        kinds = {connection.topic: connection.msgtype for connection in reader.connections}
        assert kinds['/box/accel'] == 'geometry_msgs/msg/AccelStamped'
        connection = next(c for c in reader.connections if c.topic == '/box/accel')
        _, stamp, data = next(reader.messages([connection]))
        message = reader.deserialize(data, connection.msgtype)
        assert message.header.frame_id == 'world'
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
    assert '/post/wrench' not in kinds
    report = json.loads(Bag(tmp_path / 'new').attachments['inverse.json'])
    assert set(report['bodies']) == {'ball', 'box', 'post'}


def test_poses_from_a_csv_file_give_the_same_as_those_of_a_bag(recorded, tmp_path, as_json):
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
        'inverse', path, '-o', tmp_path / 'csv', '--scene', tmp_path / 'scene.yaml'
    )
    assert code == 0 and result['bodies']['box']['wrench']
    as_json('inverse', recorded, '-o', tmp_path / 'new')
    a, b = Bag(tmp_path / 'csv'), Bag(tmp_path / 'new')
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


def test_the_new_bag_is_whole_and_says_that_it_holds_no_run(recorded, tmp_path, verb):
    verb('inverse', recorded, '-o', tmp_path / 'new')
    assert verb('bag', 'check', tmp_path / 'new')[0] == 0
    code, _, err = verb('replay', tmp_path / 'new')
    assert code == 2
    assert f'holds no run of rigid_body_sim, but what inverse derived from {recorded.name}' in err
