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
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.commands import Command, decode, topics_of
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.rotation import angle_between
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag, RecordedMessage
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.ulps import ulp_distance
from rigid_body_sim.run import Run, RunSettings
from rigid_body_sim.run_recorder import (
    SCENE_FILE,
    SCHEMA_VERSION,
    START_FILE,
    TICK_SEMANTICS,
    RunRecorder,
    held_from_json,
    recording,
)
from rigid_body_sim.scene import load_scene

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]
Warn = Callable[[str], None]

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


class RecordedRun:
    """A bag of this package, opened to be run again."""

    def __init__(self, path: Path) -> None:
        self.bag = Bag(path)
        manifest = self.bag.need_run()
        wanted = (SCHEMA_VERSION, TICK_SEMANTICS)
        found = (manifest.get('schema_version'), manifest.get('tick_semantics'))
        if found != wanted:
            raise UserError(
                f'{path}: recorded with schema and tick semantics {found}, this version has '
                f'{wanted}; '
                f'replay it with rigid_body_sim {manifest.get("package_version")}'
            )
        source = self._attachment(SCENE_FILE, manifest['scene_sha256'])
        names = json.loads(manifest['scene_files'])
        self.scene = load_scene(
            source, files={name: self._attachment(name, None) for name in names}
        )
        self.start_state = self._attachment(START_FILE, manifest['start_state_sha256'])
        self.integrator = manifest['integrator']
        self.integrator_options = json.loads(manifest.get('integrator_options', '{}'))
        self.dt_ns = int(manifest['dt_ns'])
        self.first_tick = int(manifest['first_tick'])
        self.settings = RunSettings(
            namespace=manifest['namespace'],
            world_frame=manifest['world_frame'],
            command_timeout_ns=int(manifest['command_timeout_ns']),
            publish_every=int(manifest['publish_every']),
            publish_contacts=json.loads(manifest.get('publish_contacts', 'false')),
        )
        self.last_tick = self._last_tick()
        bodies = [body.name for body in self.scene.bodies]
        self._command_topics = topics_of(bodies, namespace=self.settings.namespace)

    def _attachment(self, name: str, sha256: str | None) -> bytes:
        content = self.bag.attachments.get(name)
        if content is None:
            raise UserError(
                f'{self.bag.path}: the attachment {name} is missing; only a whole bag can be '
                'replayed'
            )
        if sha256 is not None and hashlib.sha256(content).hexdigest() != sha256:
            raise RunError(
                f'{self.bag.path}: the attachment {name} is not the one that was recorded (its '
                'sha256 differs)'
            )
        return content

    def _last_tick(self) -> int:
        ending = self.bag.ending
        if ending is not None:
            if ending.get('dropped', '0') != '0':
                raise RunError(
                    f'{self.bag.path}: {ending["dropped"]} messages were dropped while '
                    'recording; it cannot be replayed'
                )
            return int(ending['last_tick'])
        return int(self.bag.recovered['last_tick'])

    def commands(self) -> dict[int, list[Command]]:
        """
        Consumed commands by the tick on which they first acted, in the order in which they were
        consumed.
        """
        by_tick: dict[int, list[Command]] = {}
        for message in self.bag.messages(self._command_topics):
            body, kind = self._command_topics[message.topic]
            by_tick.setdefault(message.sequence, []).append(decode(body, kind, message.data))
        return by_tick

    def outputs(self) -> Iterator[RecordedMessage]:
        """Recorded messages that are not commands, in file order."""
        return self.bag.messages(
            [name for name in self.bag.topics if name not in self._command_topics]
        )

    def run_again(
        self,
        *,
        integrator: str | None = None,
        dt: float | None = None,
        warn: Warn | None = None,
    ) -> Run:
        """Make a run that stands where the recording began."""
        simulation = Simulation(
            self.scene,
            integrator=integrator or self.integrator,
            integrator_options=self.integrator_options
            if integrator in (None, self.integrator)
            else None,
            dt=dt or self.dt_ns / 1e9,
        )
        begin_ns = self.first_tick * self.dt_ns
        if begin_ns % simulation.dt_ns:
            raise UserError(
                f'--dt {simulation.dt:g} s: does not divide the start of the recording at '
                f'{begin_ns * 1e-9:g} s'
            )
        simulation.restore(
            tick=begin_ns // simulation.dt_ns,
            state=self.start_state,
            slots=held_from_json(self.bag.manifest['held_at_start']),
        )
        simulation.prepare()
        run = Run(simulation, self.settings, warn=warn)
        if run.contact_packer is not None:
            touching = json.loads(self.bag.manifest['touching_at_start'])
            run.contact_packer.touching = frozenset(touching)
        return run


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
    for tick, taken in run.follow(commands, last_tick):
        if run.simulation.tick % look_every == 0:
            run.sample_drift()
        if recorder is not None:
            recorder.record(taken, tick=tick)
        progress(run.simulation.tick, last_tick)
        yield from taken.batches


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
    end_ns = recorded.last_tick * recorded.dt_ns
    commands: dict[int, list[Command]] = {}
    for tick, taken in recorded.commands().items():
        commands.setdefault(-(-tick * recorded.dt_ns // simulation.dt_ns), []).extend(taken)
    errors = {body.name: Errors() for body in recorded.scene.bodies}
    index = {body.name: i for i, body in enumerate(recorded.scene.bodies)}
    compared = 0
    for time_ns, states in _recorded_states(recorded):
        if time_ns % simulation.dt_ns or time_ns > end_ns:
            continue
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
        body, leaf = names[message.topic]
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
