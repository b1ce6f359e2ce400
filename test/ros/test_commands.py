# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a command from another process does to a body: the laws, the rules, the refusals.
"""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped, WrenchStamped

from rigid_body_sim.recording.cdr import PoseStamped, TwistStamped
from rigid_body_sim.recording.cdr import WrenchStamped as Applied

DT_NS = 1_000_000
MASS, FORCE = 2.0, 3.0  # [kg], [N]
ROUND_OFF = 1e-12  # [m], [m/s], relative to values of order 1: some hundred sums of a double


def stamp(message):
    return message.sec * 1_000_000_000 + message.nanosec


def refused(peer):
    """
    Collect (number of refused commands, last reason) from the diagnostics.
    """
    heard = []

    def take(message):
        values = {pair.key: pair.value for pair in message.status[0].values}
        heard.append((int(values['refused commands']), values['last refusal'], values))

    subscription = peer.node.create_subscription(DiagnosticArray, '/diagnostics', take, 10)
    peer.until(lambda: heard, 'diagnostics')
    return heard, subscription


def test_a_force_from_another_process_moves_a_body_by_half_a_t_squared(lab, messages):
    poses, applied = lab.listen('box/pose', PoseStamped), lab.listen('box/applied_wrench', Applied)
    sender = lab.sender('box/force', Vector3Stamped)
    assert lab.set('command_timeout', 0.0).successful
    sender.publish(messages.force(FORCE, 0, 0))
    start = stamp(lab.until(lambda: [a for a in applied if a.force[0]], 'an applied force')[0])
    # a reader that a busy machine lets wait is given the last 10 of those it missed
    moved = lab.until(
        lambda: (
            poses
            and stamp(poses[-1]) > start + 500 * DT_NS
            and len(later := [pose for pose in poses if stamp(pose) > start]) > 20
            and later
        ),
        'twenty poses in half a second',
    )
    for pose in moved:
        t = (stamp(pose) - start) * 1e-9
        assert stamp(pose) % DT_NS == 0
        # kick, drift, kick is exact for a constant force
        way = 0.5 * FORCE / MASS * t * t
        assert pose.position[0] == pytest.approx(way, rel=ROUND_OFF, abs=ROUND_OFF)
        assert pose.position[1:] == (0.0, 0.0)
    assert start % DT_NS == 0


def test_a_force_in_body_axes_turns_with_the_body(lab, messages):
    twists, applied = (
        lab.listen('box/twist', TwistStamped),
        lab.listen('box/applied_wrench', Applied),
    )
    assert lab.set('command_timeout', 0.0).successful
    lab.sender('box/wrench', WrenchStamped).publish(messages.wrench((FORCE, 0, 0), frame='box'))
    acting = lab.until(lambda: [a for a in applied if any(a.force)], 'an applied force')[0]
    # the box lies with its x axis along y
    assert acting.force == pytest.approx((0, FORCE, 0), abs=ROUND_OFF)
    start = stamp(acting)
    twist = lab.until(lambda: [t for t in twists if stamp(t) > start + 50 * DT_NS], 'a twist')[0]
    t = (stamp(twist) - start) * 1e-9
    assert twist.linear == pytest.approx((0, FORCE / MASS * t, 0), abs=ROUND_OFF)


def test_a_command_ends_after_the_timeout_of_simulation_time(lab, messages):
    twists, applied = (
        lab.listen('box/twist', TwistStamped),
        lab.listen('box/applied_wrench', Applied),
    )
    lab.sender('box/force', Vector3Stamped).publish(messages.force(FORCE, 0, 0))
    start = stamp(lab.until(lambda: [a for a in applied if a.force[0]], 'an applied force')[0])
    end = lab.until(
        lambda: [a for a in applied if stamp(a) > start and not a.force[0]], 'its end'
    )[0]
    assert stamp(end) - start == 200 * DT_NS
    twist = lab.until(
        lambda: [t for t in twists if stamp(t) > stamp(end) + 20 * DT_NS], 'a twist'
    )[0]
    assert twist.linear[0] == pytest.approx(FORCE / MASS * 0.2, abs=ROUND_OFF)


def test_force_torque_and_wrench_add(lab, messages):
    applied = lab.listen('box/applied_wrench', Applied)
    senders = [
        lab.sender(f'box/{k}', t)
        for k, t in (('force', Vector3Stamped), ('wrench', WrenchStamped))
    ]
    assert lab.set('command_timeout', 0.0).successful
    senders[0].publish(messages.force(1, 0, 0))
    senders[1].publish(messages.wrench((0.5, 2, 0), (0, 0, 0.25), frame='world'))
    both = lab.until(lambda: [a for a in applied if a.force[1] and a.force[0] > 1], 'both')[0]
    assert (both.force, both.torque) == ((1.5, 2.0, 0.0), (0.0, 0.0, 0.25))


@pytest.mark.parametrize(
    ('name', 'build', 'reason'),
    [
        ('box/force', lambda m: m.force(1, 0, 0, frame='stone'), "'stone'"),
        ('box/force', lambda m: m.force(math.nan, 0, 0), 'finite'),
        ('box/wrench', lambda m: m.wrench((0, 0, 0), (math.inf, 0, 0)), 'finite'),
        ('stone/torque', lambda m: m.force(0, 0, 1), 'point mass'),
        ('stone/impulse', lambda m: m.wrench((0, 0, 0), (0, 0, 1)), 'point mass'),
        ('plate/force', lambda m: m.force(0, 0, 1), 'fixed'),
    ],
    ids=['wrong frame', 'nan', 'infinite', 'torque on a point', 'spin of a point', 'fixed'],
)
def test_what_cannot_be_honoured_is_refused_counted_and_named(lab, messages, name, build, reason):
    applied = lab.listen(f'{name.partition("/")[0]}/applied_wrench', Applied)
    heard, subscription = refused(lab)
    before = heard[-1][0]
    message = build(messages)
    lab.sender(name, type(message)).publish(message)
    count, last, values = lab.until(
        lambda: heard[-1] if heard[-1][0] > before else None, 'a refusal'
    )
    lab.node.destroy_subscription(subscription)
    assert count == before + 1
    assert reason in last
    assert int(values[f'refused: {last}']) >= 1
    lab.node_process.wait_until_said('refused')  # the log may come after the diagnostics
    # the simulation goes on unharmed
    now = len(applied)
    lab.until(lambda: len(applied) > now + 3, 'further ticks')
    assert all(math.isfinite(v) and v == 0 for a in applied for v in (*a.force, *a.torque))


@pytest.mark.parametrize('dt', [pytest.param(0.001, marks=pytest.mark.long), 0.02])
def test_an_impulse_is_the_same_whatever_the_tick_length(start_node, meet, messages, dt):
    node = start_node(dt=dt, start_paused='true', publish_rate=1 / dt)
    peer = meet(node)
    twists, applied = (
        peer.listen('box/twist', TwistStamped),
        peer.listen('box/applied_wrench', Applied),
    )
    peer.sender('box/impulse', WrenchStamped).publish(messages.wrench((0.5, 0, 0)))
    peer.until(lambda: peer.trigger('step').success and any(t.linear[0] for t in twists), 'a jolt')
    peer.trigger('step')
    # momentum changed by 0.5 N s, once
    assert {t.linear[0] for t in twists} <= {0.0, 0.5 / MASS}
    struck = [a for a in applied if a.force[0]]
    assert len(struck) == 1
    assert struck[0].force[0] * dt == pytest.approx(0.5, rel=1e-15)  # one rounding of the division
    assert node.stop() == 0


def test_a_best_effort_publisher_is_reported(lab, messages):
    lab.sender('box/force', Vector3Stamped, 'best_effort').publish(messages.force(1, 0, 0))
    lab.until(lambda: 'incompatible QoS' in lab.node_process.said, 'a warning')
    said = misfits(lab)
    (line,) = lab.until(lambda: said[-1] if said and said[-1] else None, 'a warning of health')
    assert 'box/force: the publisher of /peer_' in line
    assert 'Best effort publisher and reliable subscription' in line
    lab.node.destroy_publisher(lab._publishers.pop())
    lab.until(lambda: not said[-1], 'health without one that has gone')


def misfits(peer):
    """
    Warnings of each diagnostics about quality of service.
    """
    heard = []

    def collect(array):
        (status,) = array.status
        if status.name == 'lab/rigid_body_sim: simulation':
            texts = [v.value for v in status.values if v.key.startswith('warning')]
            heard.append([text for text in texts if 'incompatible QoS' in text])
            assert (status.level == b'\x01') or not texts

    peer._subscriptions.append(
        peer.node.create_subscription(DiagnosticArray, '/diagnostics', collect, 10)
    )
    return heard


def test_a_best_effort_subscriber_sees_poses(lab):
    said = misfits(lab)
    heard = lab.listen('box/pose', PoseStamped, 'best_effort')
    lab.until(lambda: len(heard) > 5, 'poses')
    assert heard[0].frame_id == 'world'
    lab.until(lambda: len(said) > 3, 'diagnostics')
    assert not any(said)
