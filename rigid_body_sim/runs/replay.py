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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import RecordedMessage
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.ulps import ulp_distance
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.recorded_run import RecordedRun, Warn
from rigid_body_sim.runs.recorder import RunRecorder, recording
from rigid_body_sim.runs.run import Run
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
    with recording(run, output, done='replayed') as recorder:
        return _compared(recorded, run, recorder, progress)


def _compared(
    recorded: RecordedRun, run: Run, recorder: RunRecorder | None, progress: Progress
) -> Comparison:
    count = 0

    def replayed() -> Iterator[tuple[str, bytes]]:
        topics = [topic.name for topic in run.topics]
        for batch in run.start():
            yield from ((topics[channel - 1], payload) for channel, payload in batch.payloads())
        for batch in _advance(run, recorded.commands(), recorded.last_tick, recorder, progress):
            for channel, payload in batch.payloads():
                yield topics[channel - 1], payload

    difference = None
    for theirs, ours in zip_longest(recorded.outputs(), replayed()):
        if theirs is None or ours is None or (theirs.topic, theirs.data) != ours:
            difference = _difference(recorded, run, theirs, ours)
            break
        count += 1
    digest = hashlib.sha256(run.simulation.state_bytes()).hexdigest()
    ending = recorded.bag.ending
    if difference is None and ending is not None and digest != ending['final_state_sha256']:
        difference = Difference(
            run.simulation.tick, '', 'final state', ending['final_state_sha256'], digest, None
        )
    return Comparison(
        ticks=recorded.last_tick - recorded.first_tick,
        messages=count,
        final_state_sha256=digest,
        difference=difference,
        recovered=ending is None,
        warnings=tuple(run.warnings),
    )


def _advance(
    run: Run,
    commands: dict[int, list[Command]],
    last_tick: int,
    recorder: RunRecorder | None,
    progress: Progress,
) -> Iterator[Batch]:
    """Advance to a tick, taking commands at theirs; yield what was packed."""
    every = run.settings.publish_every
    look_every = every * max(1, last_tick // every // LOOKS)

    def how_far() -> str:
        return f'at {run.simulation.time:g} s of {last_tick * run.simulation.dt:g} s'

    for tick, taken in run.follow(commands, last_tick):
        if run.simulation.tick % look_every == 0:
            run.sample_drift()
        if recorder is not None:
            recorder.record(taken, tick=tick)
        progress(run.simulation.tick, last_tick)
        yield from taken.batches
        STOP.check(how_far)


def _difference(
    recorded: RecordedRun,
    run: Run,
    theirs: RecordedMessage | None,
    ours: tuple[str, bytes] | None,
) -> Difference:
    if theirs is None:
        assert ours is not None
        return Difference(
            run.simulation.tick, _body(recorded, ours[0]), 'message', 'missing', ours[0], None
        )
    body = _body(recorded, theirs.topic)
    if ours is None or ours[0] != theirs.topic:
        return Difference(
            theirs.sequence, body, 'message', theirs.topic, ours[0] if ours else 'missing', None
        )
    kind = recorded.bag.topics[theirs.topic].type
    try:
        old, new = (cdr.fields(cdr.decode(kind, data)) for data in (theirs.data, ours[1]))
    except cdr.CdrError:
        return Difference(theirs.sequence, body, 'message', theirs.data.hex(), ours[1].hex(), None)
    leaf = theirs.topic.rsplit('/', 1)[-1]
    for name, value in old.items():
        if isinstance(value, float):
            distance = int(ulp_distance(value, new[name]))
            if distance:
                return Difference(
                    theirs.sequence, body, f'{leaf}.{name}', repr(value), repr(new[name]), distance
                )
        elif value != new[name]:
            return Difference(
                theirs.sequence, body, f'{leaf}.{name}', repr(value), repr(new[name]), None
            )
    return Difference(
        theirs.sequence, body, f'{leaf} padding', theirs.data.hex(), ours[1].hex(), None
    )


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
    with recording(run, output, done='replayed') as recorder:
        errors = _measured(recorded, run, recorder, progress)
    return run, errors


def _measured(
    recorded: RecordedRun, run: Run, recorder: RunRecorder | None, progress: Progress
) -> dict[str, Errors]:
    simulation = run.simulation
    begin_ns, end_ns = (k * recorded.dt_ns for k in (recorded.first_tick, recorded.last_tick))
    commands: dict[int, list[Command]] = {}
    for tick, taken in recorded.commands().items():
        commands.setdefault(-(-tick * recorded.dt_ns // simulation.dt_ns), []).extend(taken)
    errors = {body.name: Errors() for body in recorded.scene.bodies}
    index = {body.name: i for i, body in enumerate(recorded.scene.bodies)}
    compared = 0
    for time_ns, states in _recorded_states(recorded):
        if time_ns % simulation.dt_ns or not begin_ns < time_ns <= end_ns:
            continue  # at the start both are the same
        target = time_ns // simulation.dt_ns
        for _batch in _advance(run, commands, target, recorder, progress):
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
    names = {topic.name: topic.name.rsplit('/', 2)[1:] for topic in recorded.bag.topics.values()}
    wanted = [name for name, parts in names.items() if parts[-1] in ('pose', 'twist')]
    half: dict[str, cdr.PoseStamped] = {}
    states: dict[str, tuple[cdr.PoseStamped, cdr.TwistStamped]] = {}
    for message in recorded.bag.messages(wanted):
        body, _ = names[message.topic]
        decoded = cdr.decode(recorded.bag.topics[message.topic].type, message.data)
        if isinstance(decoded, cdr.PoseStamped):
            half[body] = decoded
        elif isinstance(decoded, cdr.TwistStamped):
            states[body] = (half.pop(body), decoded)
            if len(states) == len(recorded.scene.bodies):
                yield message.log_time, states
                states = {}


def _distance(a: Array, b: tuple[float, ...]) -> float:
    return math.hypot(*(a - np.array(b)).tolist())  # which a diverging run does not overflow
