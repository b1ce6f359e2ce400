# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Wrenches in frames of a body, and states that are set, from another process: acknowledged,
recorded, replayed, refused.
"""

import pytest
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry

from rigid_body_sim.__main__ import main
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag

DT_NS = 1_000_000


def odometry(position, linear=(0, 0, 0), *, frame='', child=''):
    message = Odometry(child_frame_id=child)
    message.header.frame_id = frame
    place, speed = message.pose.pose.position, message.twist.twist.linear
    place.x, place.y, place.z = map(float, position)
    speed.x, speed.y, speed.z = map(float, linear)
    return message


def test_frames_and_states_are_honoured_recorded_and_replayed(
    start_node, meet, messages, run_verb, commands_in, tmp_path
):
    node = start_node(record='true', record_path=str(tmp_path / 'bag'), command_timeout=0.0)
    peer = meet(node)
    applied = peer.listen('box/applied_wrench', cdr.WrenchStamped)
    poses = peer.listen('stone/pose', cdr.PoseStamped)
    push = peer.sender('box/force', Vector3Stamped)
    states = {body: peer.sender(f'{body}/set_state', Odometry) for body in ('box', 'stone')}
    push.publish(messages.force(0, 2, 0, frame='box/nozzle'))
    acting = peer.until(lambda: [a for a in applied if any(a.force)], 'an applied wrench')[0]
    # the box lies with its x axis along y: 0.25 m of arm, and y of the box is -x of the world
    assert acting.force == pytest.approx((-2, 0, 0), abs=1e-15)
    assert acting.torque == pytest.approx((0, 0, 0.5), abs=1e-15)
    push.publish(messages.force(0, 0, 0, frame='nozzle'))

    states['stone'].publish(odometry((5, 6, 7), (1, 0, 0), frame='world'))
    peer.until(lambda: [p for p in poses if p.position[1] == 6.0], 'the stone elsewhere')
    for message, body, reason in (
        (odometry((0, 0, 0), frame='stone'), 'box', 'a pose is told in the world'),
        (odometry((0, 0, 0), child='stone'), 'box', 'which is another body'),
        (odometry((float('nan'), 0, 0)), 'stone', 'three finite numbers'),
        (messages.force(1, 0, 0, frame='stone/nozzle'), None, "in frame 'stone/nozzle'"),
    ):
        # one warning a second is logged: each must be waited for
        peer.until(
            lambda sender=push if body is None else states[body], message=message, reason=reason: (
                reason in node.said or sender.publish(message)
            ),
            reason,
        )
    # a busy node may stand still for some hundredths: wrench and end would be of one tick
    words = ('--frame', 'nozzle', '--for', 0.5, '--namespace', node.namespace)
    sent = run_verb('wrench_pub', 'box', '--force', 0, 1, 0, *words)
    assert sent.returncode == 0, sent.stderr
    peer.until(lambda: [a for a in applied if a.torque[2] == 0.25], 'the wrench of the verb')
    peer.until(lambda: not any((*applied[-1].force, *applied[-1].torque)), 'its end')
    assert node.stop() == 0

    bag = tmp_path / 'bag'
    kinds = [message.topic.rsplit('/', 1)[-1] for message in commands_in(bag)]
    assert kinds[:3] == ['force', 'force', 'set_state'] and set(kinds[3:]) == {'wrench'}
    recorded = Bag(bag)
    (asked,) = recorded.messages([f'{node.namespace}/stone/set_state'])
    for pose in recorded.messages([f'{node.namespace}/stone/pose']):
        x, y, z = cdr.decode(cdr.PoseStamped.TYPE, pose.data).position
        ticks = pose.sequence - asked.sequence
        there = (1, 0, 0) if ticks <= 0 else (5 + ticks * 1e-3, 6, 7)
        assert (x, y, z) == pytest.approx(there, abs=1e-12)  # round-off of some thousand sums
    assert [name for name in recorded.topics if not recorded.counts[name]] == []
    assert main(['replay', str(bag)]) == 0


def test_wrench_pub_refuses_what_cannot_be_a_frame(capsys):
    for frame in ('left thruster', 'stone/nozzle', ''):
        assert main(['wrench_pub', 'box', '--force', '1', '0', '0', '--frame', frame]) == 2
        assert f'--frame {frame}: ' in capsys.readouterr().err
