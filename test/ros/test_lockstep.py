# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Lock-step with a real node: what its partners may do to it, and what comes of it.
"""

import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped, WrenchStamped

from rigid_body_sim.__main__ import main
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.cdr import PoseStamped, decode
from rigid_body_sim.recording.cdr import WrenchStamped as Wrench
from rigid_body_sim.ros.partner import Partner

from ..patience import PATIENCE

MS = 1_000_000  # [ns]
PERIOD = 10 * MS


def stamped(message, stamp):
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    return message


class Controller:
    """
    Answers by hand, on force and torque of the box; hears its poses and the diagnostics.
    """

    def __init__(self, peer, messages):
        self.peer, self._messages = peer, messages
        self.said = {}
        peer.node.create_subscription(DiagnosticArray, '/diagnostics', self._told, 10)
        self.force = peer.sender('box/force', Vector3Stamped)
        self.torque = peer.sender('box/torque', Vector3Stamped)
        self.poses = peer.listen('box/pose', PoseStamped)

    def _told(self, array):
        (status,) = array.status
        if status.name == f'{self.peer.namespace.strip("/")}/rigid_body_sim: simulation':
            self.said = {value.key: value.value for value in status.values}
            self.said['message'] = status.message

    @property
    def stamp(self):
        """Stamp of the last pose [ns]."""
        return self.poses[-1].sec * 10**9 + self.poses[-1].nanosec

    def push(self, stamp, x=0.0):
        self.force.publish(stamped(self._messages.force(x, 0, 0), stamp))

    def turn(self, stamp, x=0.0):
        self.torque.publish(stamped(self._messages.force(0, 0, x), stamp))

    def answer(self, stamp, x=0.0):
        self.push(stamp, x)
        self.turn(stamp)

    def reached(self, stamp):
        self.peer.until(lambda: self.poses and self.stamp >= stamp, f'the state of {stamp} ns')
        assert self.stamp == stamp

    def told(self, key, text):
        return self.peer.until(
            lambda: text in self.said.get(key, '') and self.said, f'{text!r} as {key!r}'
        )


@pytest.fixture
def met(start_node, meet, messages):
    """
    A node with two topics in its list, and a controller that answers by hand.
    """
    node = start_node(
        step_mode='lockstep',
        lockstep_topics="['box/force', 'box/torque']",
        lockstep_timeout=0.5,
        real_time_factor=0.0,
        diagnostics_period=0.1,
        publish_clock='false',
        record='true',
        record_path='bag',
    )
    peer = meet(node)
    return node, peer, Controller(peer, messages)


def test_a_state_waits_for_its_own_answers_whatever_else_comes(
    met, run_verb, commands_in, tmp_path
):
    node, peer, controller = met
    # nobody has answered: it counts as paused and says the state of t = 0 to whoever comes
    controller.reached(0)
    assert 'box/force' in controller.told('message', 'paused')['message']
    assert 'lock-step goes on' not in node.said

    # the controller answers twice, too early, for a state that was, and with nonsense
    controller.push(0, x=1)
    controller.push(0, x=1)
    controller.told('lock-step dropped: same again', '1')
    assert controller.said['lock-step waiting for'] == 'box/torque'
    controller.push(0, x=2)
    controller.told('lock-step dropped: different again', '1')
    controller.turn(PERIOD)
    controller.told('lock-step dropped: newer', '1')
    controller.turn(0, x=float('nan'))
    controller.told('lock-step missing box/torque', 'finite')
    controller.told('message', 'box/torque (refused')
    assert controller.stamp == 0
    controller.turn(0, x=0.5)
    controller.reached(PERIOD)
    assert 'lock-step goes on at 0 s' in node.said
    controller.push(0, x=1)
    controller.told('lock-step dropped: same again', '2')
    controller.push(PERIOD, x=3)  # its place in the list, not its arrival, says when it acts
    controller.turn(PERIOD, x=4)
    controller.reached(2 * PERIOD)
    controller.turn(2 * PERIOD, x=4)
    controller.push(2 * PERIOD, x=3)
    controller.reached(3 * PERIOD)

    # a command that nobody waits for acts at an instant and is told
    peer.sender('stone/impulse', WrenchStamped).publish(node_impulse())
    controller.told('accepted commands', '7')  # with two answers to each of three states
    controller.answer(3 * PERIOD)
    controller.reached(4 * PERIOD)
    controller.told('lock-step, not reproducible: commands on stone/impulse', '1')

    assert node.stop() == 0
    assert main(['replay', str(tmp_path / 'bag')]) == 0
    taken = [(m.topic.split('/', 2)[2], m.sequence) for m in commands_in(tmp_path / 'bag')]
    both = ['box/force', 'box/torque']
    expected = [(topic, 10 * k) for k in range(4) for topic in both]
    assert sorted(taken, key=lambda item: item[1]) == [*expected, ('stone/impulse', 30)]


def node_impulse():
    message = WrenchStamped()
    message.wrench.force.x = 0.25
    return message


def test_services_are_answered_while_the_node_waits(met, tmp_path):
    node, peer, controller = met
    controller.reached(0)
    controller.told('message', 'paused')

    # a person's pause is another one: answers come in, but nothing moves
    assert peer.switch('pause', True).message == 'paused at tick 0, 0 s'
    controller.told('message', 'paused')
    missing = peer.trigger('step')
    assert not missing.success
    assert 'no answer yet from box/force' in missing.message
    controller.answer(0, x=1)
    controller.told('accepted commands', '2')
    assert controller.stamp == 0
    assert peer.trigger('step').message == 'at tick 10, 0.01 s'
    controller.reached(PERIOD)

    # a reset goes on to a state with a stamp of its own: an answer that is on its way is late
    assert peer.trigger('reset').message.startswith('reset at tick 20, 0.02 s')
    controller.reached(2 * PERIOD)
    assert controller.poses[-1].position == (0.0, 0.0, 0.0)
    controller.answer(PERIOD, x=9)
    controller.told('lock-step dropped: older', '2')
    controller.answer(2 * PERIOD, x=1)
    assert peer.switch('pause', False).success
    controller.reached(3 * PERIOD)

    # while it waits a bag ends and another begins
    assert 'closed' in peer.switch('record', False).message
    controller.answer(3 * PERIOD, x=1)
    controller.reached(4 * PERIOD)
    assert 'from tick 40' in peer.switch('record', True).message
    controller.answer(4 * PERIOD, x=1)
    controller.reached(5 * PERIOD)

    asked = time.monotonic()
    assert node.stop() == 0
    assert time.monotonic() - asked < 60  # it did not wait for the answer
    names = sorted(path.name for path in tmp_path.glob('bag*'))
    assert names == ['bag', 'bag_2', 'bag_3']
    for name in names:
        assert main(['replay', str(tmp_path / name)]) == 0


def damper(calls):
    """
    A controller of the box that notes the stamps of the states it is asked for.
    """

    def control(states):
        calls.append(states.stamp)
        box = states['box']
        push = -3.0 * box.position - 0.5 * box.velocity + [0.1, 0, 0]
        return {'box/wrench': (push, 0.01 - 0.1 * box.angular_velocity)}

    return control


def test_a_partner_and_one_who_takes_over_lead_two_runs_to_the_same_bytes(
    start_node, meet, tmp_path
):
    """
    Two runs of 1 s, one of 50 periods with a state within each that nobody answers. Half way
    through the second, which began paused, another partner takes over.
    """
    kept = []
    for relay in (False, True):
        path = tmp_path / f'relay_{relay}'
        node = start_node(
            step_mode='lockstep',
            lockstep_topics="['box/wrench']",
            lockstep_period=0.02,
            real_time_factor=0.0,
            stop_time=1.0,
            record='true',
            record_path=path,
            start_paused=str(relay).lower(),
        )
        peer, calls = meet(node), []

        def partner(spins, peer=peer, calls=calls):
            return Partner(
                peer.node,
                damper(calls),
                bodies=['box'],
                topics=['box/wrench'],
                period=0.02,
                namespace=peer.namespace,
                spins=spins,
            )

        if relay:
            assert peer.switch('pause', False).success
            first = partner(True)
            assert first.spin(until=0.5, patience=PATIENCE).time == 0.5
            first.close()
            assert partner(True).spin(until=1.0, patience=PATIENCE).time == 1.0
        else:
            only = partner(False)
            peer.until(lambda one=only: one.states and one.states.time == 1.0, 'the end')
        assert node.wait() == 0
        # whoever is not told where to stop answers the last state too
        assert calls[:50] == list(range(0, 1000 * MS, 2 * PERIOD))
        assert len(calls) == (50 if relay else 51)
        kept.append([message_of(node, one) for one in Bag(path).messages()])
    assert len(kept[0]) > 50
    assert kept[0] == kept[1]


ROTORS = [f'drone/wrench@{place}' for place in ('front_left', 'front_right', 'rear_left')]
ROTORS.append('drone/wrench@drone/rear_right')


def test_four_rotors_on_one_topic_carry_a_drone(start_node, meet, tmp_path):
    """
    Each state waits for a wrench in each of four frames, whatever order they come in.
    """
    node = start_node(
        scene='quadrotor',
        step_mode='lockstep',
        lockstep_topics=str(ROTORS),
        real_time_factor=0.0,
        stop_time=0.5,
        record='true',
        record_path=tmp_path / 'bag',
    )
    peer = meet(node)
    partner = Partner(
        peer.node,
        lambda states: dict.fromkeys(ROTORS, (0, 0, 1.2 * 9.81 / 4, 0, 0, 0)),
        bodies=['drone'],
        topics=ROTORS[::-1],
        namespace=peer.namespace,
        spins=True,
    )
    assert partner.spin(until=0.5, patience=PATIENCE)['drone'].position[2] == pytest.approx(
        10.0, abs=1e-12
    )  # [m] round-off
    assert node.wait() == 0
    commands = list(Bag(tmp_path / 'bag').messages([f'{node.namespace}/drone/wrench']))
    frames = [decode(Wrench.TYPE, one.data).frame_id for one in commands]
    assert frames == [entry.partition('@')[2] for entry in ROTORS] * 50


def message_of(node, message):
    return (message.topic.removeprefix(node.namespace), message.log_time, message.data)
