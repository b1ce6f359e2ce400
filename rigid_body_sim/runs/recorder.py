# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A run on disk: a bag that is a complete experiment.

It holds the scene and the files it names, the state at the first recorded tick (exact, and as
messages), what was held then, every command with the tick on which it first acted, and every
published message. `replay` needs nothing else.
"""

from __future__ import annotations

import hashlib
import json
import platform
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from datetime import datetime, timezone
from pathlib import Path

from rigid_body_sim import __version__
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.forces.held_wrenches import Slot
from rigid_body_sim.recording import topic_names
from rigid_body_sim.recording.bag_writer import BagWriter
from rigid_body_sim.recording.topics import Topic, command_topics
from rigid_body_sim.runs import choices
from rigid_body_sim.runs.commands import KINDS
from rigid_body_sim.runs.manifest_values import IMPACTS_AT_START, impacts_text
from rigid_body_sim.runs.run import Run, TickOutput
from rigid_body_sim.runs.viewing import shown_text, view_text
from rigid_body_sim.stop_signals import STOP, Stopped

SCENE_FILE = 'scene.yaml'
START_FILE = 'start_state.bin'
SCHEMA_VERSION = '1'
TICK_SEMANTICS = (
    '1'  # raised when a tick of `run` or a step of an integrator comes to mean something else
)
CHAIN_EVERY = 100  # published ticks between two links of the hash chain


class RunRecorder:
    """
    Records one stretch of one run into one bag.

    The states where the run stands are in the file when it is made, and what comes after them half
    a second (wall) later at most: a thread of its own writes.

    path       : of the bag; None: nothing is written, but manifest and ending are known
    is_torn    : it was closed without an ending, because the run failed inside a tick
    look_every : ticks between looks at what should have stayed the same; 0: somebody else looks,
                 and not at ticks that a replay could know
    """

    def __init__(self, run: Run, path: Path | None, *, look_every: int = 0) -> None:
        self.path = path
        self._run = run
        self._look_every = look_every
        self._dropped = 0
        self._chain = hashlib.sha256()
        self._wall_start = datetime.now(timezone.utc)
        self._clock_start = time.monotonic()
        self._choices = len(run.simulation.choices)  # that need no message
        start = run.simulation.state_bytes()
        if run.energy.begun_at != run.simulation.tick:
            run.energy.begin()  # as a replay will
        self.first_tick = self._recorded = run.simulation.tick
        self.is_torn = False
        self.manifest = self._manifest(start)
        self._writer = None if path is None else self._open(path, start)

    def _open(self, path: Path, start: bytes) -> BagWriter:
        run = self._run
        scene = run.simulation.scene
        writer = BagWriter(
            path,
            topics=run.topics,
            on_demand=_topics_on_demand(run),
            names=run.settings.topic_names,
            manifest=self.manifest,
            attachments={SCENE_FILE: scene.source, START_FILE: start, **scene.files},
            background=True,
        )
        writer.begin(run.start())
        return writer

    def _manifest(self, start: bytes) -> dict[str, str]:
        run, simulation = self._run, self._run.simulation
        scene, settings = simulation.scene, run.settings
        return {
            'schema_version': SCHEMA_VERSION,
            'tick_semantics': TICK_SEMANTICS,
            'package_version': __version__,
            'software': json.dumps(kernels.versions()),
            'platform': f'{platform.machine()} {platform.system()} {platform.libc_ver()[0]}',
            'scene': scene.name,
            'scene_sha256': hashlib.sha256(scene.source).hexdigest(),
            'scene_files': json.dumps(sorted(scene.files)),
            'integrator': simulation.integrator.name,
            'integrator_options': json.dumps(simulation.integrator.settings),
            'integrator_choice': simulation.choice.reason if simulation.choice else '',
            'dt_ns': str(simulation.dt_ns),
            'first_tick': str(self.first_tick),
            'start_state_sha256': hashlib.sha256(start).hexdigest(),
            'held_at_start': json.dumps(held_as_json(simulation.held_slots)),
            'publish_every': str(settings.publish_every),
            **({'publish_phase': str(settings.publish_phase)} if settings.publish_phase else {}),
            'command_timeout_ns': str(run.command_timeout_ns),
            'contact': json.dumps(dict(scene.contact)),
            'publish_contacts': json.dumps(settings.publish_contacts),
            'publish_start': json.dumps(settings.publish_start),
            'touching_at_start': json.dumps(_touching(run)),
            'view': view_text(settings.view),
            'shown_at_start': shown_text(run.viewing.shown),
            IMPACTS_AT_START: impacts_text(run.untold_impacts),
            'namespace': settings.namespace,
            'world_frame': settings.world_frame,
            'bodies': json.dumps([body.name for body in scene.bodies]),
            'command_kinds': json.dumps(KINDS),
            'gravity': json.dumps(scene.gravity),
            **({'look_every': str(self._look_every)} if self._look_every else {}),
            **(
                {topic_names.KEY: json.dumps(settings.topic_names)} if settings.topic_names else {}
            ),
        }

    def record(self, output: TickOutput, *, tick: int) -> None:
        """
        Record what came of `Run.advance` begun at `tick`.

        Raises RunError when the disk takes no more; it says which ticks are safe.
        """
        if self._writer is not None:
            for topic, message in output.consumed:
                self._writer.write_message(topic, tick, tick * self._run.simulation.dt_ns, message)
            self._write_choices()
            for batch in output.batches:
                self._writer.write(batch)
        counted = output.tick - self._run.settings.publish_phase
        if self._look_every and counted % self._look_every == 0:
            self._run.sample_drift()
        every = self._run.settings.publish_every
        if counted % (every * CHAIN_EVERY) == 0:
            self._chain.update(self._run.simulation.state_bytes())
        self._recorded = output.tick

    def _write_choices(self) -> None:
        """Write the changes of integrator since the last ones."""
        assert self._writer is not None
        for made in choices.messages(self._run, self._choices):
            self._writer.write_message(made.topic, made.sequence, made.log_time, made.data)
        self._choices = len(self._run.simulation.choices)

    def close(self, reason: str) -> None:
        """
        Finish the bag. Where the run failed inside a tick, its state is ahead of the messages, and
        an ending would tell of what was never recorded: then the bag gets none.

        reason : duration, stop_time, signal, stopped, reset, replayed, diverged, error
        """
        if reason != 'diverged' and self._run.simulation.tick != self._recorded:
            self.is_torn = True  # what diverged stands at the tick before
            if self._writer is not None:
                self._writer.break_off()
            return
        ending = self.ending(reason)
        if self._writer is not None:
            self._write_choices()
            self._writer.close(ending, self._run.rest())

    def ending(self, reason: str) -> dict[str, str]:
        """Say how the run ended, if it ends here."""
        simulation = self._run.simulation
        chain = self._chain.copy()
        chain.update(simulation.state_bytes())
        self._run.sample_drift()
        estimate = self._run.error_estimate()
        looks = choices.looks_text(simulation)
        drift = asdict(self._run.sample_drift())
        gap, turned = self._run.deepest_gap(), self._run.orientation_drift()
        return {
            **({'error_estimate': json.dumps(estimate.figures())} if estimate else {}),
            **{
                law if law.startswith('energy_rise') else f'{law}_drift': repr(value)
                for law, value in drift.items()
                if value is not None
            },
            **({'integrator_looks': looks} if looks else {}),
            **({'deepest_gap': repr(gap)} if gap is not None else {}),
            **({'orientation_drift': repr(turned)} if turned is not None else {}),
            **self._run.energy.ending(),
            'last_tick': str(simulation.tick),
            'ticks': str(simulation.tick - self.first_tick),
            'last_time_ns': str(simulation.tick * simulation.dt_ns),
            'final_state_sha256': hashlib.sha256(simulation.state_bytes()).hexdigest(),
            'state_chain_sha256': chain.hexdigest(),
            'dropped': str(self._dropped),
            'end_reason': reason,
            'warnings': json.dumps(self._run.warnings, ensure_ascii=False),
            'wall_start': self._wall_start.isoformat(timespec='seconds'),
            'wall_seconds': f'{time.monotonic() - self._clock_start:.3f}',
        }


def recorded_topics(run: Run) -> list[Topic]:
    """Every topic of a bag of this run, by its own name."""
    return [*run.topics, *_topics_on_demand(run)]


def _topics_on_demand(run: Run) -> list[Topic]:
    """Give the topics that a bag has when their first message comes."""
    return [
        *command_topics(run.names, namespace=run.settings.namespace),
        *choices.topics_of(run),
    ]


def _touching(run: Run) -> list[int]:
    """Bodies of which an empty message of contacts is still to come when they let go."""
    return sorted(run.contact_packer.touching) if run.contact_packer else []


@contextmanager
def recording(
    run: Run, path: Path | None, *, done: str, look_every: int = 0
) -> Iterator[RunRecorder]:
    """
    Follow a run with a recorder, if `path` names a bag into one, and close it however it ends; a
    signal waits until then.

    done : the reason to write where nothing went wrong
    """
    STOP.keep()
    recorder, reason = RunRecorder(run, path, look_every=look_every), 'error'
    try:
        yield recorder
        reason = done
    except Stopped:
        reason = 'signal'
        raise
    except SimulationDiverged:
        reason = 'diverged'
        raise
    finally:
        recorder.close(reason)


def held_as_json(slots: Mapping[tuple[int, str], Slot]) -> list[list[object]]:
    """Give held commands as plain lists; floats survive JSON to the bit."""
    return [
        [core, source, slot.force, slot.torque, slot.turns_with_body, slot.until]
        for (core, source), slot in sorted(slots.items())
    ]
