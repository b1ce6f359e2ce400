# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A recorded run, run again from the bag alone: its scene, its start state, its commands at their
ticks.

With the same integrator and dt every message must come out with the same bits. With others, the
difference of the states at common times is the error of one of the two.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_diff import first_difference
from rigid_body_sim.recording.bag_reader import RecordedMessage
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.every_body import with_every_body
from rigid_body_sim.recording.message_stream import MessageStream
from rigid_body_sim.runs import choices
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.reading_guard import interpreting
from rigid_body_sim.runs.recorded_facts import Fact, ending_differences, manifest_differences
from rigid_body_sim.runs.recorded_run import RecordedRun, Warn, first_tick_from
from rigid_body_sim.runs.recorder import RunRecorder, recording
from rigid_body_sim.runs.run import Run, TickOutput
from rigid_body_sim.stop_signals import STOP

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

LOOKS = 256  # at drift and limits over a replay: cheap beside it


@dataclass(frozen=True)
class Difference:
    """
    Where a replay first left the recording.

    ulps : doubles between the recorded and the replayed value; None where it is not a number that
           differs
    """

    tick: int
    body: str
    field: str
    recorded: str
    replayed: str
    ulps: int | None


@dataclass(frozen=True)
class Comparison:
    """Outcome of a bit-by-bit replay."""

    ticks: int
    messages: int
    final_state_sha256: str
    difference: Difference | None
    recovered: bool
    warnings: Sequence[str] = ()


@dataclass
class Errors:
    """
    Largest and last difference of one body from the recording, at the recorded times that both
    runs hit.

    position [m], angle [rad], velocity [m/s], angular_velocity [rad/s]
    """

    largest: dict[str, float] = field(default_factory=dict)
    last: dict[str, float] = field(default_factory=dict)

    def take(self, values: dict[str, float]) -> None:
        """Take the differences at one time."""
        self.last = values
        self.largest = {
            name: max(value, self.largest.get(name, 0.0)) for name, value in values.items()
        }


def compare(
    recorded: RecordedRun, *, output: Path | None, progress: Progress, warn: Warn | None = None
) -> Comparison:
    """
    Run again with the same settings and compare every message bit by bit, up to the first
    difference.
    """
    run = recorded.run_again(warn=warn)
    look_every = recorded.look_every or _look_every(run, recorded.last_tick)
    with (
        interpreting(recorded.bag.path),
        recording(run, output, done='replayed', look_every=look_every) as recorder,
    ):
        return _compared(recorded, run, recorder, progress)


def _look_every(run: Run, last_tick: int) -> int:
    every = run.settings.publish_every
    return every * max(1, last_tick // every // LOOKS)


def _compared(
    recorded: RecordedRun, run: Run, recorder: RunRecorder, progress: Progress
) -> Comparison:
    count = 0
    difference = _first(manifest_differences(recorded.bag.manifest, recorder.manifest), run)
    if difference is None:
        theirs = recorded.bag.stream()
        for ours, number in _pairs(theirs, _replayed(recorded, run, recorder, progress), run):
            count += number
            if ours is not None:
                difference = _difference(recorded, run, *ours)
                break
    ending = recorded.bag.ending
    if difference is None and ending is not None:
        same_looks = recorded.look_every > 0
        again = recorder.ending('replayed')
        difference = _first(ending_differences(ending, again, same_looks=same_looks), run)
    return Comparison(
        ticks=recorded.last_tick - recorded.first_tick,
        messages=count,
        final_state_sha256=hashlib.sha256(run.simulation.state_bytes()).hexdigest(),
        difference=difference,
        recovered=ending is None,
        warnings=tuple(run.warnings),
    )


def _first(facts: Iterator[Fact], run: Run) -> Difference | None:
    """Tell the first of the facts that differ."""
    for name, said, is_ in facts:
        return Difference(run.simulation.tick, '', name, said, is_, None)
    return None


def _pairs(
    theirs: MessageStream, ours: Iterator[Batch | RecordedMessage], run: Run
) -> Iterator[tuple[tuple[RecordedMessage | None, RecordedMessage | None] | None, int]]:
    """
    Compare two streams of messages, batches by their bytes.

    yields : the messages that differ, None if none does, and how many were equal
    """
    topics = [topic.name for topic in run.topics]
    is_numbered_alike = theirs.has_numbers(topics)
    for made in ours:
        if isinstance(made, RecordedMessage):
            singles: Iterable[RecordedMessage] = (made,)
        elif is_numbered_alike and theirs.take(made.data):
            yield None, made.message_count
            continue
        else:
            singles = _unpacked(made, topics)
        for single in singles:
            recorded = theirs.next()
            yield (None, 1) if recorded == single else ((recorded, single), 0)
    rest = theirs.next()
    if rest is not None:
        yield (rest, None), 0


def _unpacked(batch: Batch, topics: Sequence[str]) -> Iterator[RecordedMessage]:
    for channel, sequence, log_time, publish_time, payload in batch.records():
        yield RecordedMessage(topics[channel - 1], sequence, log_time, payload, publish_time)


def _replayed(
    recorded: RecordedRun, run: Run, recorder: RunRecorder, progress: Progress
) -> Iterator[Batch | RecordedMessage]:
    """Run again; yield what a recorder would have written, commands too."""
    dt_ns, changes = run.simulation.dt_ns, len(run.simulation.choices)
    yield from run.start()
    for tick, taken in _advance(run, recorded.commands(), recorded.last_tick, recorder, progress):
        for topic, message in taken.consumed:
            yield RecordedMessage(topic, tick, tick * dt_ns, message, tick * dt_ns)
        yield from choices.messages(run, changes)
        changes = len(run.simulation.choices)
        yield from taken.batches
    if recorded.tells_rest:
        yield from run.rest()


def _advance(
    run: Run,
    commands: dict[int, list[Command]],
    last_tick: int,
    recorder: RunRecorder,
    progress: Progress,
) -> Iterator[tuple[int, TickOutput]]:
    """Advance to a tick, taking commands at theirs; yield the first tick of each stretch."""

    def how_far() -> str:
        return f'at {run.simulation.time:g} s of {last_tick * run.simulation.dt:g} s'

    for tick, taken in run.follow(commands, last_tick):
        recorder.record(taken, tick=tick)
        progress(run.simulation.tick, last_tick)
        yield tick, taken
        STOP.check(how_far)


def _difference(
    recorded: RecordedRun,
    run: Run,
    theirs: RecordedMessage | None,
    ours: RecordedMessage | None,
) -> Difference:
    if theirs is None:
        assert ours is not None
        return Difference(
            run.simulation.tick,
            _body(recorded, ours.topic),
            'message',
            'missing',
            ours.topic,
            None,
        )
    body = _body(recorded, theirs.topic)
    if ours is None or ours.topic != theirs.topic:
        again = ours.topic if ours else 'missing'
        return Difference(theirs.sequence, body, 'message', theirs.topic, again, None)
    leaf = theirs.topic.rsplit('/', 1)[-1]
    for name in ('sequence', 'log_time', 'publish_time'):
        said, is_ = getattr(theirs, name), getattr(ours, name)
        if said != is_:
            where = f'{leaf}, {name.replace("_", " ")} of the message'
            return Difference(ours.sequence, body, where, str(said), str(is_), None)
    kind = recorded.bag.topics[theirs.topic].type
    name, said, is_, ulps = first_difference(kind, theirs.data, ours.data)
    if name.startswith('byte '):
        said, is_ = theirs.data.hex(), ours.data.hex()
        return Difference(theirs.sequence, body, f'{leaf} padding', said, is_, None)
    return Difference(theirs.sequence, body, f'{leaf}.{name}', repr(said), repr(is_), ulps)


def _body(recorded: RecordedRun, topic: str) -> str:
    parts = topic.rsplit('/', 2)
    return parts[-2] if any(body.name == parts[-2] for body in recorded.scene.bodies) else ''


def measure(
    recorded: RecordedRun,
    *,
    integrator: str | None,
    dt: float | None,
    output: Path | None,
    progress: Progress,
    warn: Warn | None = None,
) -> tuple[Run, dict[str, Errors]]:
    """Run again with other settings and measure the distance from the recorded states; by body."""
    run = recorded.run_again(integrator=integrator, dt=dt, warn=warn)
    end = recorded.last_tick * recorded.dt_ns // run.simulation.dt_ns
    with (
        interpreting(recorded.bag.path),
        recording(run, output, done='replayed', look_every=_look_every(run, end)) as recorder,
    ):
        errors = _measured(recorded, run, recorder, progress)
    return run, errors


def _measured(
    recorded: RecordedRun, run: Run, recorder: RunRecorder, progress: Progress
) -> dict[str, Errors]:
    simulation = run.simulation
    begin_ns, end_ns = (k * recorded.dt_ns for k in (recorded.first_tick, recorded.last_tick))
    commands: dict[int, list[Command]] = {}
    for tick, taken in recorded.commands().items():
        at = first_tick_from(tick * recorded.dt_ns, simulation.dt_ns)
        commands.setdefault(at, []).extend(taken)
    late = recorded.within_ticks_of(simulation.dt_ns)
    if late:
        run.add_warning(
            f'{late} command{"s" * (late > 1)} began or timed out within a tick of '
            f'{simulation.dt:g} s, and here at its end: the differences are of that too; take a '
            f'dt that divides {recorded.dt_ns * 1e-9:g} s'
        )
    errors = {body.name: Errors() for body in recorded.scene.bodies}
    index = {body.name: i for i, body in enumerate(recorded.scene.bodies)}
    compared = later = 0
    for time_ns, states in _recorded_states(recorded):
        if not begin_ns < time_ns <= end_ns:
            continue  # at the start both are the same
        later += 1
        if time_ns % simulation.dt_ns:
            continue
        target = time_ns // simulation.dt_ns
        for _ in _advance(run, commands, target, recorder, progress):
            pass
        state = simulation.state
        for body, (pose, twist) in states.items():
            i = index[body]
            errors[body].take(
                {
                    'position': _distance(state.position[i], pose.position),
                    'angle': float(
                        angle_between(state.orientation[i], np.array(pose.orientation))
                    ),
                    'velocity': _distance(state.velocity[i], twist.linear),
                    'angular_velocity': _distance(state.angular_velocity[i], twist.angular),
                }
            )
        compared += 1
    if not later:
        raise UserError(
            f'{recorded.bag.path}: holds no state after that of its start, with which another '
            'method could be compared; record one tick at least, and publish it'
        )
    if not compared:
        raise UserError(
            f'--dt {simulation.dt:g} s: hits none of the recorded times; choose one that divides '
            f'{recorded.settings.publish_every * recorded.dt_ns * 1e-9:g} s'
        )
    return errors


def _recorded_states(
    recorded: RecordedRun,
) -> Iterator[tuple[int, dict[str, tuple[cdr.PoseStamped, cdr.TwistStamped]]]]:
    """Yield (time [ns], body -> (pose, twist)) of each published tick."""
    bag = with_every_body(recorded.bag)
    names = {topic.name: topic.name.rsplit('/', 2)[1:] for topic in bag.topics.values()}
    wanted = [name for name, parts in names.items() if parts[-1] in ('pose', 'twist')]
    half: dict[str, cdr.PoseStamped] = {}
    states: dict[str, tuple[cdr.PoseStamped, cdr.TwistStamped]] = {}
    for message in bag.messages(wanted):
        body, _ = names[message.topic]
        decoded = cdr.decode(bag.topics[message.topic].type, message.data)
        if isinstance(decoded, cdr.PoseStamped):
            half[body] = decoded
        elif isinstance(decoded, cdr.TwistStamped):
            states[body] = (half.pop(body), decoded)
            if len(states) == len(recorded.scene.bodies):
                yield message.log_time, states
                states = {}


def _distance(a: Array, b: tuple[float, ...]) -> float:
    return math.hypot(*(a - np.array(b)).tolist())  # which a diverging run does not overflow
