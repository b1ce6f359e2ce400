# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Lock-step: simulation and controllers advance together. No ROS is known here.

    instant k at k T          T : period, a whole number of publishing periods
    the states of the instant are published; then the run waits for one answer on every topic of
    the list; then it applies them in the order of the list and advances by T

An answer is a command whose stamp is that of the instant. The wall clock decides how long the run
waits, never what it takes: what bears another stamp is dropped, of two answers the first counts.
The same states therefore meet the same commands in every run, whatever the machine does.

It is not kept by a partner that answers the same state differently, nor by commands on topics that
are not in the list: both are counted and told.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import nearest
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.runs.commands import Command

OLDER, NEWER = 'older', 'newer'  # than the state that is waited for
SAME, DIFFERENT = 'same again', 'different again'  # second answers to one state
SHOWN = 5  # [topics] named in a line
STAMP_END = 12  # [bytes] of a message: encapsulation and stamp come first


@dataclass(frozen=True)
class Terms:
    """
    What was agreed on.

    topics  : as listed, in the order in which answers are applied
    targets : (body, kind) of each
    period  : [tick] between two instants
    stamped : whether an answer bears the stamp of its state
    timeout : [ns] of wall time after which the run counts as paused; 0: never
    """

    topics: tuple[str, ...]
    targets: tuple[tuple[str, str], ...]
    period: int
    stamped: bool = True
    timeout: int = 0


def targets_of(
    names: Sequence[str],
    *,
    known: Mapping[str, tuple[str, str]],
    namespace: str,
    scene: Scene,
    remapped: Callable[[str], str],
) -> tuple[tuple[str, str], ...]:
    """
    Find body and kind of every topic of the list; UserError for what no answer could come on.

    known    : absolute name of a command topic -> (body, kind)
    remapped : the name that ROS gives to an absolute one
    """
    if not names:
        raise UserError(
            'parameter lockstep_topics: got nothing, but step_mode is lockstep; name the topics '
            "that a step waits for: lockstep_topics:=['<body>/wrench']"
        )
    found: list[tuple[str, str]] = []
    for name in names:
        target = _target(name, known, namespace.rstrip('/'))
        body = next(body for body in scene.bodies if body.name == target[0])
        if body.motion is not None:
            raise _unusable(name, f'{body.name!r} moves as told and takes no commands')
        if body.fixed:
            raise _unusable(name, f'{body.name!r} is fixed and takes no commands')
        if body.is_point and target[1] == 'torque':
            raise _unusable(name, f'{body.name!r} is a point mass and takes no torque')
        if target in found:
            raise _unusable(name, 'it is in the list twice; each state is answered once a topic')
        absolute = next(topic for topic, own in known.items() if own == target)
        if remapped(absolute) != absolute:
            raise _unusable(name, f'it is remapped to {remapped(absolute)}; leave its name as is')
        found.append(target)
    return tuple(found)


def _target(name: str, known: Mapping[str, tuple[str, str]], namespace: str) -> tuple[str, str]:
    absolute = name if name.startswith('/') else f'{namespace}/{name}'
    if absolute in known:
        return known[absolute]
    relative = [topic.removeprefix(f'{namespace}/') for topic in known]
    near = nearest(name.removeprefix('~/'), relative)
    hint = f'; such as {relative[0]}' if near is None else f'; did you mean {near}?'
    raise _unusable(name, f'no body of the scene takes commands there{hint}')


def _unusable(name: str, why: str) -> UserError:
    return UserError(f'parameter lockstep_topics: {name!r}: {why}')


def period_of(seconds: float, *, publish_every: int, dt_ns: int) -> int:
    """
    Return the period in ticks; 0.0 seconds: one publishing period. UserError unless it is a whole
    number of publishing periods.
    """
    shortest = publish_every * dt_ns
    asked = round(seconds * 1e9)
    if not seconds or asked == shortest:
        return publish_every
    if asked % shortest or not asked:
        nearest = max(1, round(asked / shortest)) * shortest
        raise UserError(
            f'parameter lockstep_period: got {seconds:g} s; allowed: whole numbers of publishing '
            f'periods of {shortest * 1e-9:g} s; the nearest is {nearest * 1e-9:g}; or change '
            'publish_rate'
        )
    return asked // dt_ns


def notes(
    terms: Terms, *, command_timeout_ns: int, publish_every: int, dt_ns: int
) -> Iterator[str]:
    """Warn in a line each of terms that may not be meant."""
    period = terms.period * dt_ns
    if 0 < command_timeout_ns < period:
        yield (
            f'command_timeout of {command_timeout_ns * 1e-9:g} s is shorter than the '
            f'lock-step period of {period * 1e-9:g} s: an answer ends before the next one acts; '
            'give command_timeout:=0.0 to hold it'
        )
    if not terms.stamped and terms.period > publish_every:
        yield (
            f'lockstep_stamps is false and states are published within the lock-step period of '
            f'{period * 1e-9:g} s: an answer to one of those may come late and count for the '
            'next instant, so that runs differ; let answers bear stamps, or choose one period'
        )


@dataclass
class _Slot:
    """The answers on one topic: the one that waits to be applied, and the last one that was."""

    waiting: Command | None = None
    last: Command | None = None
    trouble: str = ''  # why what came since the instant does not count


class Gate:
    """
    One place for each topic of the list. Belongs to one thread.

    inbox   : judges and counts, keeps nothing; the gate's alone
    dropped : answers that do not count, by OLDER, NEWER, SAME and DIFFERENT
    proven  : topics on which an answer has come; whoever knows of the links empties it
    """

    def __init__(self, terms: Terms, inbox: Inbox) -> None:
        self.terms = terms
        self.inbox = inbox
        self._slots = [_Slot() for _ in terms.topics]
        self._stamp: int | None = None
        self._missing = len(self._slots)
        self.dropped: Counter[str] = Counter({OLDER: 0, NEWER: 0, SAME: 0, DIFFERENT: 0})
        self.proven: set[int] = set()

    def open(self, stamp: int) -> None:
        """Wait for answers to the state of this stamp [ns] from now on."""
        self._stamp = stamp
        self._missing = len(self._slots)
        for slot in self._slots:
            slot.waiting, slot.trouble = None, ''

    def receive(self, index: int, data: bytes) -> str | None:
        """
        Judge what came on a topic, and offer it.

        returns : what to warn of
        """
        body, kind = self.terms.targets[index]
        command = self.inbox.judge(body, kind, data)
        if isinstance(command, str):
            self._slots[index].trouble = f'refused: {command}'  # its place stays empty
            return f'refused: {command}'
        if self.offer(index, command) == DIFFERENT:
            return (
                f'{self.terms.topics[index]}: the state of {command.stamp_ns * 1e-9:g} s was '
                'answered a second time and differently; the first answer counts'
            )
        return None

    def offer(self, index: int, command: Command) -> str | None:
        """
        Take an answer on a topic, or drop it.

        returns : why it does not count; None if it does
        """
        slot = self._slots[index]
        if self._counts(slot, command):
            slot.waiting = slot.last = command
            self._missing -= 1
            self.proven.add(index)
            self.inbox.accepted += 1
            return None
        kind = self._drop(slot, command)
        self.dropped[kind] += 1
        return kind

    def _counts(self, slot: _Slot, command: Command) -> bool:
        if slot.waiting is not None or self._stamp is None:
            return False
        return not self.terms.stamped or command.stamp_ns == self._stamp

    def _drop(self, slot: _Slot, command: Command) -> str:
        """Say why an answer does not count."""
        stamped, last = self.terms.stamped, slot.last
        older = not stamped or self._stamp is None or command.stamp_ns < self._stamp
        kind = OLDER if older else NEWER
        if slot.waiting is None:
            slot.trouble = _wrong_stamp(command.stamp_ns, kind)
        again = last is not None and (
            last.stamp_ns == command.stamp_ns if stamped else slot.waiting is not None
        )
        if again and last is not None:
            same = last.message[STAMP_END:] == command.message[STAMP_END:]
            return SAME if same else DIFFERENT
        return kind

    @property
    def is_full(self) -> bool:
        """Whether every topic has answered."""
        return not self._missing

    @property
    def missing(self) -> dict[str, str]:
        """The topics that have not answered, and what came in place of an answer."""
        return {
            topic: slot.trouble
            for topic, slot in zip(self.terms.topics, self._slots)
            if slot.waiting is None
        }

    def take(self) -> list[Command]:
        """Take the answers in the order of the list; from now on there is no state to answer."""
        self._stamp = None
        return [slot.waiting for slot in self._slots if slot.waiting is not None]

    @property
    def is_proven(self) -> bool:
        """Whether an answer has come on every topic by the present links."""
        return len(self.proven) == len(self._slots)


def _wrong_stamp(stamp: int, kind: str) -> str:
    text = f'the last one bears the stamp {stamp * 1e-9:.9g} s, {kind} than that of the state'
    return f'{text}; one who gives no stamps needs lockstep_stamps:=false' if not stamp else text


@dataclass(frozen=True)
class LockstepFigures:
    """
    Where a run in lock-step stands.

    time      : [s] of the state that waits for answers
    period    : [s]
    missing   : topic -> what came in place of an answer
    waited    : [s] of wall time
    timed_out : whether it counts as paused because of that
    dropped   : numbers of answers that did not count
    outside   : commands on topics that are not in the list: number by topic
    """

    time: float
    period: float
    missing: Mapping[str, str]
    waited: float
    timed_out: bool
    dropped: Mapping[str, int]
    outside: Mapping[str, int] = field(default_factory=dict)

    @property
    def warning(self) -> str:
        """What is wrong, in one line; empty where nothing is."""
        if self.timed_out:
            return f'paused: {no_answer(self.missing)}, for {self.waited:.0f} s'
        if self.dropped[DIFFERENT]:
            return (
                f'answers that contradicted the first one to the same state: '
                f'{self.dropped[DIFFERENT]}; a partner is not a function of the states, and this '
                'run may not come out again'
            )
        return ''

    def values(self) -> dict[str, str]:
        """Every figure by name, as text."""
        texts = {
            'lock-step state [s]': f'{self.time:.9f}',
            'lock-step period [s]': f'{self.period:g}',
            'lock-step waiting for': shown(list(self.missing)),
            'lock-step waited [s]': f'{self.waited:.3f}',
        }
        texts |= {f'lock-step missing {topic}': why for topic, why in self.missing.items() if why}
        texts |= {f'lock-step dropped: {kind}': str(n) for kind, n in self.dropped.items()}
        texts |= {
            f'lock-step, not reproducible: commands on {topic}': str(n)
            for topic, n in self.outside.items()
        }
        return texts


def no_answer(missing: Mapping[str, str]) -> str:
    """Name the topics that are missing and why."""
    named = [f'{topic} ({why})' if why else topic for topic, why in missing.items()]
    return f'no answer yet from {shown(named)}'


def shown(names: Sequence[str]) -> str:
    """List names, of many the first."""
    more = f' and {len(names) - SHOWN} more' if len(names) > SHOWN else ''
    return ', '.join(names[:SHOWN]) + more
