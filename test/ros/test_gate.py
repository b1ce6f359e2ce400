# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Lock-step without ROS: which answers count, in which order they act, when a state is said again.
"""

import random
from collections import deque

import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.errors import UserError
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.ros.lockstep import (
    DIFFERENT,
    NEWER,
    OLDER,
    OTHER_FRAME,
    SAME,
    Gate,
    Terms,
    notes,
    period_of,
    targets_of,
)
from rigid_body_sim.ros.lockstep_turns import LONGEST_WAIT, REPEAT, LockstepTurns
from rigid_body_sim.ros.requests import Request
from rigid_body_sim.ros.run_loop import RunLoop
from rigid_body_sim.runs.commands import Command, CommandRules, encode, topics_of
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.scene import load_scene

MS = 1_000_000  # [ns]
SCENE = load_scene(
    {
        'dt': 0.001,
        'bodies': [
            {
                'name': 'box',
                'shape': {'type': 'box', 'size': [1, 1, 1]},
                'mass': 1.0,
                'frames': {'left': {'position': [0, 1, 0]}, 'right': {'position': [0, -1, 0]}},
            },
            {'name': 'stone', 'shape': {'type': 'particle'}, 'mass': 1.0},
            {'name': 'plate', 'shape': {'type': 'sphere', 'radius': 1}, 'fixed': True},
        ],
    }
)
TOPICS = ('box/torque', 'box/force', 'stone/impulse')
TARGETS = tuple((*topic.split('/'), '') for topic in TOPICS)


def make_gate(stamped=True, topics=TOPICS, timeout=0):
    targets = tuple((*topic.split('/'), '') for topic in topics)
    terms = Terms(topics, targets, 10, stamped=stamped, timeout=timeout)
    return Gate(terms, Inbox(CommandRules(SCENE)))


def answer(index, stamp, x=0.0):
    body, kind, _ = TARGETS[index]
    vector = (float(x), 0.0, 0.0)
    if kind == 'torque':
        return Command(body, kind, torque=vector, stamp_ns=stamp)
    return Command(body, kind, force=vector, stamp_ns=stamp)


@pytest.mark.parametrize('seed', range(20))
def test_answers_act_in_the_order_of_the_list_whatever_comes_in_which_order(seed):
    """
    Between the answers that count there are doubles, old, early and refused ones, as DDS may
    bring them; what is taken of each state is always the same.
    """
    dice = random.Random(seed)
    gate = make_gate()
    for instant in range(10):
        stamp = instant * 10 * MS
        gate.open(stamp)
        right = [answer(index, stamp, x=100 * instant + index) for index in range(3)]
        others = [
            answer(
                dice.randrange(3), dice.choice([stamp - 10 * MS, stamp + 10 * MS]), x=dice.random()
            )
            for _ in range(4)
        ]
        mixed = [*right, *others, *dice.sample(right, 2)]
        dice.shuffle(mixed)
        for command in mixed:
            gate.receive(command.body, command.kind, encode(command))
        assert gate.is_full
        assert gate.take() == right
    assert gate.inbox.accepted == 30
    assert sum(gate.dropped.values()) == 60


def test_what_does_not_count_is_told_apart():
    gate = make_gate()
    gate.open(20 * MS)
    assert gate.offer(0, answer(0, 10 * MS)) == OLDER
    assert gate.offer(0, answer(0, 0)) == OLDER  # a zero stamp is that of t = 0
    assert 'older' in gate.missing['box/torque']
    assert gate.offer(1, answer(1, 30 * MS)) == NEWER
    assert 'newer' in gate.missing['box/force']
    assert gate.missing['stone/impulse'] == ''
    assert gate.offer(0, answer(0, 20 * MS, x=1)) is None
    assert gate.offer(0, answer(0, 20 * MS, x=1)) == SAME
    assert gate.offer(0, answer(0, 20 * MS, x=2)) == DIFFERENT
    assert list(gate.missing) == ['box/force', 'stone/impulse']
    gate.open(30 * MS)
    # a double that comes late is the same double
    assert gate.offer(0, answer(0, 20 * MS, x=1)) == SAME
    assert gate.offer(0, answer(0, 20 * MS, x=2)) == DIFFERENT
    assert dict(gate.dropped) == {OLDER: 2, NEWER: 1, SAME: 2, DIFFERENT: 2, OTHER_FRAME: 0}


def listed(*names):
    return Gate(Terms(names, targets(names), 10), Inbox(CommandRules(SCENE)))


def push(gate, frame, stamp, x):
    command = Command('box', 'force', (x, 0.0, 0.0), frame_id=frame, stamp_ns=stamp)
    remark = gate.receive('box', 'force', encode(command))
    return command, remark and remark.text


def test_a_topic_that_is_listed_by_frames_answers_once_in_each_and_all_act():
    gate = listed('box/force@left', 'box/force@right', 'box/force@world')
    for stamp in (0, 10 * MS):
        gate.open(stamp)
        right, _ = push(gate, 'box/right', stamp, 2.0)
        world, _ = push(gate, '', stamp, 3.0)
        assert list(gate.missing) == ['box/force@left']
        push(gate, 'right', stamp, 2.5)
        assert gate.dropped[DIFFERENT] == 1 + stamp // (10 * MS)
        assert not gate.is_full
        left, warning = push(gate, 'left', stamp, 1.0)
        assert warning is None
        assert gate.is_full
        assert gate.take() == [left, right, world]
    assert gate.dropped[OTHER_FRAME] == 0


def test_an_answer_in_a_frame_that_is_not_listed_is_refused_and_says_how_to_list_it():
    gate = listed('box/force@left', 'box/force@right')
    gate.open(0)
    push(gate, 'right', 0, 1.0)
    _, warning = push(gate, 'box', 0, 1.0)
    assert 'left, right' in warning
    assert 'add box/force@body' in warning
    assert 'add box/force@body' in gate.missing['box/force@left']
    assert sum(gate.inbox.refused.values()) == 1


def test_answers_in_several_frames_that_nobody_listed_are_told_with_the_list_that_takes_them():
    turns, door, *_ = make_turns()
    gate = door.gate = turns.gate = listed('box/force')
    gate.open(0)
    first, warning = push(gate, 'left', 0, 1.0)
    assert warning is None
    _, warning = push(gate, 'right', 0, 1.0)
    assert 'list each that answers: box/force@left, box/force@right' in warning
    push(gate, '', 0, 1.0)
    _, warning = push(gate, 'left', 0, 1.0)
    assert warning is None
    assert gate.take() == [first]
    assert (gate.dropped[OTHER_FRAME], gate.dropped[SAME], gate.dropped[DIFFERENT]) == (2, 1, 0)
    assert 'box/force@left, box/force@right, box/force@world' in turns.figures(0).warning


def test_a_partner_that_gives_no_stamps_is_told_what_to_do():
    gate = make_gate()
    gate.open(0)
    assert gate.offer(0, answer(0, 0, x=1)) is None
    gate.open(10 * MS)
    assert gate.offer(0, answer(0, 0, x=2)) == DIFFERENT
    assert 'lockstep_stamps:=false' in gate.missing['box/torque']


def test_a_refused_answer_leaves_its_place_empty_and_says_why():
    gate = make_gate()
    gate.open(0)
    bad = answer(0, 0, x=float('nan'))
    assert 'finite' in gate.receive('box', 'torque', encode(bad)).text
    assert 'finite' in gate.missing['box/torque']
    assert gate.receive('box', 'torque', encode(answer(0, 0, x=1))) is None
    assert 'box/torque' not in gate.missing


def test_without_stamps_the_first_command_after_the_state_counts():
    gate = make_gate(stamped=False, topics=TOPICS[:1])
    gate.open(0)
    assert gate.offer(0, answer(0, 123, x=1)) is None
    assert gate.offer(0, answer(0, 124, x=1)) == SAME
    assert gate.offer(0, answer(0, 125, x=2)) == DIFFERENT
    assert gate.take() == [answer(0, 123, x=1)]
    gate.open(10 * MS)
    assert not gate.is_full
    assert gate.offer(0, answer(0, 123, x=1)) is None


class Door:
    """
    Answers come in when it is waited at; time passes by as much.
    """

    def __init__(self):
        self.coming = deque()
        self.now = 0
        self.gate = None
        self.waits = []

    def wait(self, longest):
        self.waits.append(longest)
        self.now += max(0, longest)
        self.take()

    def take(self):
        while self.coming and self.coming[0][0] <= self.now:
            _, index, command = self.coming.popleft()
            self.gate.offer(index, command)

    def wake(self):
        raise AssertionError

    close = wake


def make_turns(timeout=0, stamped=True):
    door = Door()
    door.gate = make_gate(stamped=stamped, topics=TOPICS[:1], timeout=timeout)
    said, links, warned = [], [0], []
    turns = LockstepTurns(
        door.gate,
        dt_ns=MS,
        publish_every=10,
        door=door,
        links=lambda: links[0],
        silence=lambda index: 'nobody publishes it',
        publish=lambda batch: said.append((door.now, batch)),
        warn=warned.append,
    )
    return turns, door, said, links, warned


FAR = 2**61  # [ns]


def wait_until(turns, door, end):
    while door.now < end and not turns.is_ready(door.now):
        turns.wait(door.now, min(FAR, end))


def test_a_state_is_said_again_until_everybody_has_answered_and_when_somebody_comes_or_goes():
    turns, door, said, links, _ = make_turns()
    turns.restart(0, 0.0)
    turns.reach(0, ['t = 0'], 0)
    wait_until(turns, door, 3 * REPEAT + 1)
    assert [batch for _, batch in said] == ['t = 0'] * 3
    door.coming.append((door.now, 0, answer(0, 0)))
    wait_until(turns, door, door.now + REPEAT)
    assert turns.take([], door.now) == [answer(0, 0)]
    # the link has proved itself: a slow partner is left in peace
    turns.reach(10, ['next'], door.now)
    said.clear()
    wait_until(turns, door, door.now + 20 * REPEAT)
    assert said == []
    # another partner is there: it has not heard the state
    links[0] = 1
    wait_until(turns, door, door.now + 2 * REPEAT)
    assert [batch for _, batch in said] == ['next'] * 2
    assert max(door.waits) <= LONGEST_WAIT


def test_a_run_that_waited_too_long_counts_as_paused_until_the_answer_comes():
    turns, door, _, _, warned = make_turns(timeout=1000 * MS)
    turns.restart(0, 0.0)
    turns.reach(0, [], 0)
    wait_until(turns, door, 3000 * MS)
    assert turns.timed_out
    (warning,) = warned
    assert 'box/torque (nobody publishes it)' in warning
    assert 'paused' in turns.figures(door.now).warning
    door.coming.append((door.now, 0, answer(0, 0)))
    wait_until(turns, door, door.now + 1000 * MS)
    assert not turns.timed_out
    assert 'goes on' in warned[1]


def test_a_person_who_pauses_ends_the_other_pause_and_answers_come_in_all_the_same():
    turns, door, _, _, _ = make_turns(timeout=1000 * MS)
    turns.restart(0, 0.0)
    turns.reach(0, [], 0)
    wait_until(turns, door, 2000 * MS)
    assert turns.timed_out
    turns.restart(door.now, 0.0)
    assert not turns.timed_out
    door.coming.append((door.now, 0, answer(0, 0)))
    turns.rest(door.now, FAR)
    assert turns.is_ready(door.now)


def test_the_real_time_factor_holds_back_and_is_not_caught_up_with():
    turns, door, _, _, _ = make_turns()
    turns.restart(0, 1.0)
    began = []
    for tick in range(0, 60, 10):
        turns.reach(tick, [], door.now)
        late = 25 * MS if tick == 20 else 1 * MS
        door.coming.append((door.now + late, 0, answer(0, tick * MS)))
        door.waits.clear()
        while not turns.is_ready(door.now):
            turns.wait(door.now, door.now + MS)
        began.append(door.now // MS)
        turns.take([], door.now)
    # 10 ms each; the third is 15 ms late, and one period is all that is caught up with
    assert began == [10, 20, 45, 46, 55, 65]


def test_a_reset_goes_on_to_an_instant_of_its_own():
    turns, *_ = make_turns()
    assert [turns.next_instant(tick) for tick in (0, 1, 9, 10, 15)] == [10, 10, 10, 20, 20]


class NoBags:
    """
    Nothing is recorded.
    """

    is_open = False

    def record(self, output, tick):
        pass


def test_a_stop_time_within_a_period_that_is_put_off_leads_to_the_next_instant():
    turns, door, *_ = make_turns()
    run = Run(Simulation(SCENE), RunSettings(publish_every=10))
    loop = RunLoop(
        run, inbox=Inbox(run.rules), bags=NoBags(), publish=id, report=id, report_period=1.0,
        factor=0.0, stop_time=0.014, paused=False, lockstep=turns,
    )  # fmt: skip
    turns.reach(0, (), 0)
    for stamp, stands_at in ((0, 10), (10, 14)):
        assert turns.gate.offer(0, answer(0, stamp * MS, x=1)) is None
        loop._advance_period(door.now)
        assert run.simulation.tick == stands_at
    answered = turns.gate.inbox.accepted
    loop._answer(Request('stop_time', 1.0))
    loop._advance_period(door.now)
    assert run.simulation.tick == 20
    assert not turns.gate.is_full  # it waits again
    assert turns.gate.inbox.accepted == answered == 2


@pytest.mark.parametrize(
    ('names', 'why'),
    [
        ((), 'name the topics'),
        (('box/torqe',), 'did you mean box/torque'),
        (('~/box/torque',), 'did you mean box/torque'),
        (('/box/torque',), 'did you mean box/torque'),
        (('box/pose',), 'no body of the scene takes commands there'),
        (('nobody/wrench',), 'no body of the scene takes commands there'),
        (('plate/force',), 'fixed'),
        (('stone/torque',), 'point mass'),
        (('box/force', '/lab/box/force'), 'twice'),
        (('box/wrench',), 'remapped to /thrusters'),
        (('box/force@lft',), "allowed: '', 'world', 'box', 'box/left', 'box/right'"),
        (('box/force@',), 'leave @ out'),
        (('box/set_state@left',), 'leave @left out'),
        (('stone/force@body',), 'point mass'),
        (('box/force@left', 'box/force@box/left'), 'twice'),
        (('box/force', 'box/force@left'), 'and without'),
        (('box/force@left', 'box/force'), 'and without'),
    ],
)
def test_topics_on_which_no_answer_could_come_are_refused(names, why):
    with pytest.raises(UserError, match=r'parameter lockstep_topics') as caught:
        targets(names)
    assert why in str(caught.value)


def targets(names):
    known = topics_of(['box', 'stone', 'plate'], namespace='/lab')
    return targets_of(
        names,
        known=known,
        namespace='/lab',
        scene=SCENE,
        rules=CommandRules(SCENE),
        remapped=lambda name: '/thrusters' if name == '/lab/box/wrench' else name,
    )


def test_topics_may_be_named_with_and_without_the_namespace():
    names = ('stone/impulse', '/lab/box/force', 'box/torque')
    assert targets(names) == (
        ('stone', 'impulse', ''), ('box', 'force', ''), ('box', 'torque', ''),
    )  # fmt: skip


def test_a_topic_may_be_listed_once_for_each_frame():
    names = ('box/force@left', 'box/force@box/right', 'box/force@world', 'box/force@body')
    assert [frame for _, _, frame in targets(names)] == ['left', 'right', 'world', 'body']
    assert targets(('box/force@box',)) == targets(('box/force@body',))


@pytest.mark.parametrize(
    ('seconds', 'ticks'), [(0.0, 10), (0.01, 10), (0.03, 30), (1.0, 1000), (0.07, 70)]
)
def test_a_period_is_a_whole_number_of_publishing_periods(seconds, ticks):
    assert period_of(seconds, publish_every=10, dt_ns=MS) == ticks


@pytest.mark.parametrize(
    ('seconds', 'nearest'), [(0.001, '0.01'), (0.016, '0.02'), (0.0149, '0.01'), (1e-12, '0.01')]
)
def test_any_other_period_is_refused_and_the_nearest_named(seconds, nearest):
    with pytest.raises(UserError) as caught:
        period_of(seconds, publish_every=10, dt_ns=MS)
    assert f'the nearest is {nearest};' in str(caught.value)


def test_terms_that_may_not_be_meant_are_warned_of():
    every = {'publish_every': 10, 'dt_ns': MS}
    assert list(notes(Terms(TOPICS, TARGETS, 200), command_timeout_ns=200 * MS, **every)) == []
    assert list(notes(Terms(TOPICS, TARGETS, 200), command_timeout_ns=0, **every)) == []
    (warning,) = notes(Terms(TOPICS, TARGETS, 210), command_timeout_ns=200 * MS, **every)
    assert 'command_timeout of 0.2 s is shorter' in warning
    unstamped = Terms(TOPICS, TARGETS, 20, stamped=False)
    (warning,) = notes(unstamped, command_timeout_ns=200 * MS, **every)
    assert 'lockstep_stamps' in warning
