# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A recorded run: its scene, its start state, its settings and its commands, from the bag alone.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording.bag_reader import Bag, RecordedMessage
from rigid_body_sim.runs import choices
from rigid_body_sim.runs.commands import Command, decode, topics_of
from rigid_body_sim.runs.recorder import (
    SCENE_FILE,
    SCHEMA_VERSION,
    START_FILE,
    TICK_SEMANTICS,
    held_from_json,
)
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene

Warn = Callable[[str], None]


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
        self._choices_topic = choices.topic_of(self.settings.namespace).name

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
            [
                name
                for name in self.bag.topics
                if name not in self._command_topics and name != self._choices_topic
            ]
        )

    def run_again(
        self,
        *,
        integrator: str | None = None,
        dt: float | None = None,
        warn: Warn | None = None,
    ) -> Run:
        """Make a run that stands where the recording began."""
        simulation = simulation_of(
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
        if integrator is None and simulation.dt_ns == self.dt_ns:
            made = self.bag.messages([self._choices_topic])
            simulation.follow_choices(choices.decoded(made, self.scene))
        simulation.prepare()
        run = Run(simulation, self.settings, warn=warn)
        if run.contact_packer is not None:
            touching = json.loads(self.bag.manifest['touching_at_start'])
            run.contact_packer.touching = frozenset(touching)
        return run
