# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Services and live parameters: each is answered at a tick boundary.
"""

import signal
import time
from importlib.util import find_spec

import pytest
from geometry_msgs.msg import Vector3Stamped

from rigid_body_sim.recording.cdr import Clock, PoseStamped
from rigid_body_sim.recording.cdr import WrenchStamped as Applied

DT = 0.001  # [s]


def test_a_paused_run_moves_by_steps_alone(start_node, meet):
    node = start_node(start_paused='true', publish_rate=1000.0, step_count=3)
    peer = meet(node)
    clock = peer.listen('/clock', Clock)
    poses = peer.listen('box/pose', PoseStamped)
    # whoever comes late hears of the start too
    peer.until(lambda: len(clock) > 1 and poses, 'the states of t = 0, again')
    assert {(c.sec, c.nanosec) for c in (*clock, *poses)} == {(0, 0)}
    assert peer.trigger('step').message == 'at tick 3, 0.003 s'

    def ticks():
        return [(c.sec, c.nanosec) for c in clock if c.nanosec]

    peer.until(lambda: len(ticks()) == 3, 'three ticks')
    assert ticks() == [(0, k * 1_000_000) for k in (1, 2, 3)]
    assert peer.set('step_count', 1).successful
    assert peer.trigger('step').message == 'at tick 4, 0.004 s'
    assert peer.switch('pause', False).success
    answer = peer.trigger('step')
    assert not answer.success
    assert 'pause' in answer.message


def test_who_finds_a_node_standing_reads_when_it_was_paused(start_node, meet):
    node = start_node()
    peer = meet(node)
    for wanted in (True, True, False, True):  # who asks for what is so already changes nothing
        assert peer.switch('pause', wanted).success
    paused = peer.switch('pause', True).message
    assert peer.trigger('reset').success
    for _ in range(2):
        assert peer.set('real_time_factor', 0.5).successful
    assert peer.trigger('reset').success  # behind the parameter: what is served comes in turn
    assert node.stop() == 0
    said = [line.partition(': ')[2] for line in node.said.splitlines()]
    told = [text for text in said if text.startswith('pause: ')]
    assert [text.split()[1] for text in told] == ['paused', 'running', 'paused']
    assert told[-1] == f'pause: {paused}'
    assert sum('reset at tick' in text for text in said) == 2
    assert sum('real_time_factor: 0.5 from tick' in text for text in said) == 1
    (last,) = (text for text in said if text.startswith('signal: '))
    assert 'paused 2 times, standing at the end; overruns' in last
    assert ', lags 0, largest lateness' in last


def test_a_step_of_many_ticks_lets_others_in(start_node, meet):
    node = start_node(start_paused='true')
    peer = meet(node)
    clock = peer.listen('/clock', Clock)
    assert peer.trigger('step').success

    def begun():
        assert peer.set('step_count', 2_000_000_000).successful
        count, answer = len(clock), peer.begin('step')
        peer.until(lambda: len(clock) > count, 'some ticks')
        assert peer.set('step_count', 1).successful
        assert not answer.done()
        return answer

    broken = begun()
    assert peer.switch('pause', True).success
    peer.until(broken.done, 'its answer')
    assert not broken.result().success
    assert 'of 2000000000 steps' in broken.result().message
    assert 'paused' in broken.result().message
    # calls that come together are all done
    together = [peer.begin('step') for _ in range(5)]
    peer.until(lambda: all(answer.done() for answer in together), 'all answers')
    assert all(answer.result().success for answer in together)
    assert len({answer.result().message for answer in together}) == 5
    # and who waits for one is told of the end
    last = begun()
    node.process.send_signal(signal.SIGINT)
    peer.until(last.done, 'its answer')
    assert 'the run has ended' in last.result().message
    assert node.wait() == 0


def test_pause_stops_time(lab):
    poses = lab.listen('box/pose', PoseStamped)
    lab.until(lambda: poses, 'a pose')
    tick = lab.switch('pause', True).message
    # two services later it is still the same tick
    assert lab.switch('pause', True).message == tick
    assert lab.switch('pause', False).message == tick.replace('paused', 'running')
    count = len(poses)
    lab.until(lambda: len(poses) > count, 'a pose after the pause')


def test_reset_puts_every_body_back_and_lets_time_go_on(lab, messages):
    poses = lab.listen('box/pose', PoseStamped)
    assert lab.set('command_timeout', 0.0).successful
    lab.sender('box/force', Vector3Stamped).publish(messages.force(50, 0, 0))
    moved = lab.until(lambda: [p for p in poses if p.position[0] > 0.1], 'motion')[-1]
    assert lab.trigger('reset').success
    back = lab.until(
        lambda: [
            p
            for p in poses
            if p.position[0] == 0 and p.sec + p.nanosec * 1e-9 > moved.sec + moved.nanosec * 1e-9
        ],
        'the start',
    )[0]
    # the held command is gone too
    count = len(poses)
    lab.until(lambda: len(poses) > count + 5, 'more poses')
    assert all(p.position == back.position for p in poses[count:])


def test_a_command_timeout_that_would_round_to_never_is_refused(lab):
    refusal = lab.set('command_timeout', 4e-10)
    assert not refusal.successful
    assert 'got 4e-10 s; allowed: 0 (until changed), or 1e-09 to 1e+09 s' in refusal.reason
    assert lab.set('command_timeout', 1e-9).successful
    assert lab.set('command_timeout', 0.2).successful


def test_the_real_time_factor_is_live_and_zero_starves_nobody(lab):
    def tick():
        return int(lab.switch('pause', False).message.split()[3].rstrip(','))

    assert lab.set('real_time_factor', 0.25).successful
    asked, start = time.monotonic(), tick()
    lab.until(lambda: time.monotonic() > asked + 0.4, 'time')
    ticks = tick() - start
    # Deadlines count from the first answer, which came after it was asked for; 1: rounding.
    assert ticks <= 0.25 * (time.monotonic() - asked) / DT + 1

    assert lab.set('real_time_factor', 0.0).successful
    asked, start = time.monotonic(), tick()

    def is_fast():
        """Each look needs an answer of the loop, which is as busy as can be."""
        ticks = tick() - start
        wall = time.monotonic() - asked
        return wall > 0.4 and ticks > 2.0 * wall / DT

    # What kept to any factor up to 1 would never come; free, it is a hundred times as fast.
    lab.until(is_fast, 'a run that outruns the wall clock')


@pytest.mark.parametrize(
    ('name', 'value', 'why'),
    [
        ('dt', 0.01, 'read-only'),
        ('scene', 'demo', 'read-only'),
        ('real_time_factor', -1.0, 'range'),
        ('real_time_factor', 1e-320, '1e-09 to 1e+09'),
        ('real_time_factor', 1, 'type'),
        ('use_sim_time', True, 'must not wait'),
    ],
)
def test_a_parameter_that_cannot_change_is_refused_with_a_reason(lab, name, value, why):
    result = lab.set(name, value)
    assert not result.successful
    assert why in result.reason


def test_the_clock_is_left_to_others_when_asked(lab):
    own = [info.node_namespace for info in lab.node.get_publishers_info_by_topic('/clock')]
    assert '/lab' not in own


def test_impulses_and_forces_sent_while_paused_wait_for_the_next_tick(lab, messages):
    applied = lab.listen('stone/applied_wrench', Applied)
    assert lab.switch('pause', True).success
    sender = lab.sender('stone/force', Vector3Stamped)
    sender.publish(messages.force(0, 0, 1))
    assert not any(a.force[2] for a in applied)
    # the service call after the message gives it time to arrive; the tick takes it
    acting = lab.until(
        lambda: lab.trigger('step').success and [a for a in applied if a.force[2] == 1.0],
        'the force',
    )
    assert acting


@pytest.mark.skipif(
    find_spec('simulation_interfaces') is not None, reason='simulation_interfaces is installed'
)
def test_where_the_standard_of_simulators_is_absent_nothing_is_said_of_it(lab):
    def services():
        return {name for name, _ in lab.node.get_service_names_and_types()}

    lab.until(lambda: '/lab/rigid_body_sim/step' in services(), 'the services')
    assert not [name for name in services() if name.startswith('/lab') and 'simulat' in name]
    assert 'simulation_interfaces' not in lab.node_process.said
