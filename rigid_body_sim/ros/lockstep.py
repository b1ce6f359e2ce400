# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Lock-step: simulation and controllers advance together. No ROS is known here.

    instant k at k T          T : period, a whole number of publishing periods
    the states of the instant are published; then the run waits for one answer on every topic of
    the list; then it applies them in the order of the list and advances by T

A topic answers once; where it is listed by frame, `drone/wrench@front_left`, once in each of them.
An answer is a command whose stamp is that of the instant. The wall clock decides how long the run
waits, never what it takes: what bears another stamp is dropped, of two answers the first counts.
The same states therefore meet the same commands in every run, whatever the machine does.

It is not kept by a partner that answers the same state differently, nor by commands on topics that
are not in the list: both are counted and told. So is an answer in a second frame on a topic that
is listed without: nobody would know for how many to wait.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import nearest
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.ros.remarks import Remark
from rigid_body_sim.runs.asked_states import KIND as SET_STATE
from rigid_body_sim.runs.commands import Command, CommandRules, frame_id_of

OLDER, NEWER = 'older', 'newer'  # than the state that is waited for
SAME, DIFFERENT = 'same again', 'different again'  # second answers to one state
OTHER_FRAME = 'in another frame'  # a second answer on a topic that is listed without frames
AT = '@'  # between topic and frame; no name of ROS holds it
SHOWN = 5  # [topics] named in a line
STAMP_END = 12  # [bytes] of a message: encapsulation and stamp come first


Target = tuple[str, str, str]


@dataclass(frozen=True)
class Terms:
    """
    What was agreed on.

    topics  : as listed, in the order in which answers are applied
    targets : (body, kind, frame) of each; frame world, body or one of the body's own; '': any
    period  : [tick] between two instants
    stamped : whether an answer bears the stamp of its state
    timeout : [ns] of wall time after which the run counts as paused; 0: never
    """

    topics: tuple[str, ...]
    targets: tuple[Target, ...]
    period: int
    stamped: bool = True
    timeout: int = 0


def targets_of(
    names: Sequence[str],
    *,
    known: Mapping[str, tuple[str, str]],
    namespace: str,
    scene: Scene,
    rules: CommandRules,
    remapped: Callable[[str], str],
) -> tuple[Target, ...]:
    """
    Find body, kind and frame of every topic of the list; UserError for what no answer could come
    on.

    known    : absolute name of a command topic -> (body, kind)
    rules    : which frames a command may be in
    remapped : the name that ROS gives to an absolute one
    """
    if not names:
        raise UserError(
            'parameter lockstep_topics: got nothing, but step_mode is lockstep; name the topics '
            "that a step waits for: lockstep_topics:=['<body>/wrench']"
        )
    found: list[Target] = []
    for name in names:
        topic, frame = parted(name)
        target = _target(topic, known, namespace.rstrip('/'))
        body = next(body for body in scene.bodies if body.name == target[0])
        if body.motion is not None:
            raise _unusable(name, f'{body.name!r} moves as told and takes no commands')
        if body.fixed:
            raise _unusable(name, f'{body.name!r} is fixed and takes no commands')
        if body.is_point and target[1] == 'torque':
            raise _unusable(name, f'{body.name!r} is a point mass and takes no torque')
        frame = _frame(name, target, frame, rules)
        same = [its for *other, its in found if tuple(other) == target]
        if frame in same:
            raise _unusable(name, 'it is in the list twice; each state is answered once a topic')
        if same and '' in (frame, *same):
            raise _unusable(name, f'it is in the list with {AT}FRAME and without; add it to all')
        absolute = next(topic for topic, own in known.items() if own == target)
        if remapped(absolute) != absolute:
            raise _unusable(name, f'it is remapped to {remapped(absolute)}; leave its name as is')
        found.append((*target, frame))
    return tuple(found)


def parted(name: str) -> tuple[str, str]:
    """
    Part an entry of the list: `drone/wrench@front_left` is topic and frame.

    returns : the topic, and the frame; '' where none is named
    """
    topic, _, frame = name.partition(AT)
    return topic, frame


def _frame(name: str, target: tuple[str, str], frame: str, rules: CommandRules) -> str:
    """Find the frame that an entry of the list names; '' where it names none."""
    if AT not in name:
        return ''
    body, kind = target
    if kind == SET_STATE or not frame:
        why = f'a {kind} has no frames' if frame else f'{AT} stands before a frame'
        raise _unusable(name, f'{why}; leave {AT}{frame} out')
    command = Command(body, kind, frame_id=frame_id_of(body, frame))
    if refusal := rules.refusal(command):
        raise _unusable(name, refusal)
    return rules.frame(command)


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
    """
    The answers on one topic, in one frame where it is listed by frames.

    waiting : the one that waits to be applied
    last    : the last one that was
    trouble : why what came since the instant does not count
    met     : frames in which one state was answered, where none is listed
    """

    waiting: Command | None = None
    last: Command | None = None
    trouble: str = ''
    met: dict[str, None] = field(default_factory=dict)


class Gate:
    """
    One place for each entry of the list. Belongs to one thread.

    inbox   : judges and counts, keeps nothing; the gate's alone
    dropped : answers that do not count, by OLDER, NEWER, SAME, DIFFERENT and OTHER_FRAME
    proven  : topics on which an answer has come; whoever knows of the links empties it
    """

    def __init__(self, terms: Terms, inbox: Inbox) -> None:
        self.terms = terms
        self.inbox = inbox
        self._slots = [_Slot() for _ in terms.topics]
        self._stamp: int | None = None
        self._missing = len(self._slots)
        self._places: dict[tuple[str, str], dict[str, int]] = {}
        for place, (body, kind, frame) in enumerate(terms.targets):
            self._places.setdefault((body, kind), {})[frame] = place
        kinds = (OLDER, NEWER, SAME, DIFFERENT, OTHER_FRAME)
        self.dropped: Counter[str] = Counter(dict.fromkeys(kinds, 0))
        self.proven: set[int] = set()

    def open(self, stamp: int) -> None:
        """Wait for answers to the state of this stamp [ns] from now on."""
        self._stamp = stamp
        self._missing = len(self._slots)
        for slot in self._slots:
            slot.waiting, slot.trouble = None, ''

    def receive(self, body: str, kind: str, data: bytes) -> Remark | None:
        """
        Judge what came on a topic, and offer it.

        returns : what to warn of
        """
        command = self.inbox.judge(body, kind, data)
        if isinstance(command, str):
            return self._refused(body, kind, command)
        places = self._places[body, kind]
        frame = self.inbox.frame(command)
        index = places.get('', places.get(frame))
        if index is None:
            return self._refused(body, kind, self.inbox.refuse(self._not_listed(command, frame)))
        dropped = self.offer(index, command)
        if dropped == DIFFERENT:
            topic = self.terms.topics[index]
            return Remark(
                f'{topic} {dropped}',
                f'{topic}: the state of {command.stamp_ns * 1e-9:g} s was answered a second time '
                'and differently; the first answer counts',
            )
        if dropped == OTHER_FRAME:
            said = _several_frames(self.unlisted[index])
            return Remark(said, said)
        return None

    def _refused(self, body: str, kind: str, reason: str) -> Remark:
        """Keep in mind why places stay empty."""
        for place in self._places[body, kind].values():
            if self._slots[place].waiting is None:
                self._slots[place].trouble = f'refused: {reason}'
        return Remark(reason, f'refused: {reason}')

    def _not_listed(self, command: Command, frame: str) -> str:
        listed = ', '.join(self._places[command.body, command.kind])
        return (
            f'{command.kind} for {command.body!r} in frame {frame!r} answers no state: '
            f'lockstep_topics lists this topic for: {listed}; add '
            f'{command.body}/{command.kind}{AT}{frame} to it'
        )

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
            frames = self.inbox.frame(last), self.inbox.frame(command)
            if frames[0] != frames[1]:
                slot.met.update(dict.fromkeys(frames))
                return OTHER_FRAME
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

    @property
    def unlisted(self) -> dict[int, list[str]]:
        """By place: what to list of a topic in whose place one state was answered by frames."""
        return {
            place: [f'{topic}{AT}{frame}' for frame in slot.met]
            for place, (topic, slot) in enumerate(zip(self.terms.topics, self._slots))
            if slot.met
        }

    def take(self) -> list[Command]:
        """Take the answers in the order of the list; from now on there is no state to answer."""
        self._stamp = None
        return [slot.waiting for slot in self._slots if slot.waiting is not None]

    @property
    def is_proven(self) -> bool:
        """Whether an answer has come on every topic by the present links."""
        return len(self.proven) == len(self._slots)


def _several_frames(entries: Sequence[str]) -> str:
    """Say that a topic answers in several frames, and how to list them."""
    topic = parted(entries[0])[0]
    return (
        f'{topic}: one state was answered in several frames, of which the first counts alone, as '
        f'lockstep_topics names none; list each that answers: {", ".join(entries)}'
    )


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
    unlisted  : what to list in place of topics that answered in several frames
    """

    time: float
    period: float
    missing: Mapping[str, str]
    waited: float
    timed_out: bool
    dropped: Mapping[str, int]
    outside: Mapping[str, int] = field(default_factory=dict)
    unlisted: Sequence[Sequence[str]] = ()

    @property
    def warning(self) -> str:
        """What is wrong, in one line; empty where nothing is."""
        if self.timed_out:
            return f'paused: {no_answer(self.missing)}, for {self.waited:.0f} s'
        if self.unlisted:
            return '; '.join(map(_several_frames, self.unlisted))
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
