# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A recorded run: its scene, its start state, its settings and its commands, from the bag alone.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.forces.held_wrenches import FOREVER, Slot
from rigid_body_sim.physics.integration.choose import NAME as AUTO
from rigid_body_sim.recording.bag_reader import Bag, DamagedBag
from rigid_body_sim.recording.topics import CLOCK_TOPIC, command_topics
from rigid_body_sim.runs import choices
from rigid_body_sim.runs.commands import Command, decode, topics_of
from rigid_body_sim.runs.manifest_values import (
    IMPACTS_AT_START,
    MOST_NS,
    MOST_TICKS,
    MOST_TIMEOUT_NS,
    ManifestValues,
)
from rigid_body_sim.runs.reading_guard import interpreting
from rigid_body_sim.runs.recorder import SCENE_FILE, SCHEMA_VERSION, START_FILE, TICK_SEMANTICS
from rigid_body_sim.runs.run import Run, RunSettings, command_rules
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene

Warn = Callable[[str], None]

MOST_UNSEEN = 100_000_000  # ticks between recorded states that a replay takes; a minute of work


def first_tick_from(instant_ns: int, dt_ns: int) -> int:
    """Give the first tick that does not begin before an instant."""
    return -(-instant_ns // dt_ns)


class RecordedRun:
    """
    A bag of this package, opened to be run again.

    bag        : what is at the path, if it was opened before
    tells_rest : whether its end tells `Run.rest`: not in what was cut off, nor in old recordings
    """

    def __init__(self, path: Path, bag: Bag | None = None) -> None:
        self.bag = Bag(path) if bag is None else bag
        manifest = self.bag.need_run()
        wanted = (SCHEMA_VERSION, TICK_SEMANTICS)
        found = (manifest.get('schema_version'), manifest.get('tick_semantics'))
        if found != wanted:
            raise UserError(
                f'{path}: recorded with schema and tick semantics {found}, this version has '
                f'{wanted}; '
                f'replay it with rigid_body_sim {manifest.get("package_version")}'
            )
        values = ManifestValues(path, 'manifest', manifest)
        source = self._attachment(SCENE_FILE, values.text('scene_sha256'))
        names = values.names('scene_files')
        with interpreting(path):
            self.scene = load_scene(
                source,
                files={name: self._attachment(name, None) for name in names},
                title=f'{values.text("scene")}.yaml',
            )
        bodies = [body.name for body in self.scene.bodies]
        self.start_state = self._attachment(START_FILE, values.text('start_state_sha256'))
        self.integrator = values.text('integrator')
        if self.integrator == AUTO:  # what it chose is recorded, and nothing is chosen again
            raise values.refusal('integrator', AUTO, 'the method that was chosen')
        self.integrator_options = values.mapping('integrator_options', '{}')
        self.dt_ns = values.integer('dt_ns', 1, MOST_NS)
        self.first_tick = values.integer('first_tick', 0, MOST_TICKS)
        self.settings = RunSettings(
            namespace=values.text('namespace'),
            world_frame=values.text('world_frame'),
            command_timeout_ns=values.integer('command_timeout_ns', 0, MOST_TIMEOUT_NS),
            publish_every=values.integer('publish_every', 1, 2**63 - 1),
            publish_phase=values.integer('publish_phase', 0, 2**63 - 1, '0'),
            publish_contacts=values.yes('publish_contacts', 'false'),
            publish_start=values.yes('publish_start', 'false'),
            view=values.view('view'),
            topic_names=self.bag.wire_names,
        )
        self.look_every = values.integer('look_every', 0, 2**63 - 1, '0')
        self.last_tick = self._last_tick()
        self.tells_rest = self.bag.ending is not None and IMPACTS_AT_START in manifest
        self._held = values.held('held_at_start', len(bodies))
        self._shown = values.shown('shown_at_start', len(bodies))
        self._touching = values.places('touching_at_start', len(bodies), '[]')
        self._untold = values.impacts(IMPACTS_AT_START, len(bodies))
        self._command_topics = topics_of(bodies, namespace=self.settings.namespace)
        self._choices_topic = choices.topic_of(self.settings.namespace).name
        with interpreting(path):
            self._rules = command_rules(self.scene, self.settings)
        self._check_ticks()

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
        low, high = self.first_tick, MOST_TICKS
        ending = self.bag.ending
        if ending is None:
            values = ManifestValues(self.bag.path, 'recovery record', self.bag.recovered)
            return values.integer('last_tick', low, high)
        values = ManifestValues(self.bag.path, 'ending record', ending)
        dropped = values.integer('dropped', 0, 2**63, '0')
        if dropped:
            raise RunError(
                f'{self.bag.path}: {dropped} messages were dropped while recording; it cannot be '
                'replayed'
            )
        return values.integer('last_tick', low, high)

    def _check_ticks(self) -> None:
        """Refuse ticks that the recorded states contradict, before anything runs for as long."""
        every, phase = self.settings.publish_every, self.settings.publish_phase
        published = (self.last_tick - phase) // every - (self.first_tick - phase) // every
        published += self.settings.publish_start
        found = self.bag.counts.get(CLOCK_TOPIC, 0)
        if found != published:
            raise DamagedBag(
                f'{self.bag.path}: damaged: ticks {self.first_tick} to {self.last_tick}, one of '
                f'{every} published, are {published} states; it holds {found}'
            )
        first = next(self.bag.messages([CLOCK_TOPIC]), None)
        if first is not None and first.log_time != first.sequence * self.dt_ns:
            raise DamagedBag(
                f'{self.bag.path}: damaged: tick {first.sequence} of {self.dt_ns} ns stands at '
                f'{first.log_time} ns'
            )
        if min(every, self.last_tick - self.first_tick) > MOST_UNSEEN:
            raise UserError(
                f'{self.bag.path}: its states are {every} ticks apart, nothing between them can '
                f'be compared; replayed are at most {MOST_UNSEEN}; record at a higher rate'
            )

    def commands(self) -> dict[int, list[Command]]:
        """
        Consumed commands by the tick on which they first acted, in the order in which they were
        consumed.
        """
        by_tick: dict[int, list[Command]] = {}
        given = [topic for topic in self._command_topics if self.bag.counts.get(topic)]
        for message in self.bag.messages(given) if given else ():
            body, kind = self._command_topics[message.topic]
            with interpreting(self.bag.path):
                command = decode(body, kind, message.data)
            reason = self._rules.refusal(command)
            if reason is not None:
                raise DamagedBag(
                    f'{self.bag.path}: damaged: command of tick {message.sequence}: {reason}'
                )
            by_tick.setdefault(message.sequence, []).append(command)
        return by_tick

    def run_again(
        self,
        *,
        integrator: str | None = None,
        dt: float | None = None,
        warn: Warn | None = None,
    ) -> Run:
        """Make a run that stands where the recording began, compiled."""
        with interpreting(self.bag.path):
            run = self.stand_at_start(integrator=integrator, dt=dt, warn=warn)
            run.simulation.prepare()
        return run

    def stand_at_start(
        self,
        *,
        integrator: str | None = None,
        dt: float | None = None,
        warn: Warn | None = None,
    ) -> Run:
        """Make a run that stands where the recording began; nothing is compiled for it yet."""
        simulation = simulation_of(
            self.scene,
            integrator=self.integrator if integrator is None else integrator,
            integrator_options=self.integrator_options
            if integrator in (None, self.integrator)
            else None,
            dt=self.dt_ns / 1e9 if dt is None else dt,
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
            slots=self._held_in_ticks_of(simulation.dt_ns),
            of_another=integrator not in (None, self.integrator),
        )
        changes = self._choices_topic in self.bag.topics
        if changes and integrator is None and simulation.dt_ns == self.dt_ns:
            made = self.bag.messages([self._choices_topic])
            simulation.follow_choices(choices.decoded(made, self.scene))
        run = Run(simulation, self._settings_in_ticks_of(simulation.dt_ns), warn=warn)
        if run.contact_packer is not None:
            run.contact_packer.touching = self._touching
        run.viewing.shown = self._shown
        run.untold_impacts = self._untold
        self._check_topics(run)
        return run

    def _held_in_ticks_of(self, dt_ns: int) -> dict[tuple[int, str], Slot]:
        """Give the commands that held at the start; they end when they did, in ticks of dt_ns."""
        return {
            key: slot
            if slot.until >= FOREVER
            else slot._replace(until=first_tick_from(slot.until * self.dt_ns, dt_ns))
            for key, slot in self._held.items()
        }

    def _settings_in_ticks_of(self, dt_ns: int) -> RunSettings:
        """Give the settings; a command holds for as long as it did, which is whole ticks."""
        if dt_ns == self.dt_ns:
            return self.settings
        return replace(self.settings, command_timeout_ns=self.timeout_ns)

    @property
    def timeout_ns(self) -> int:
        """How long commands held [ns], up to the end of a tick; 0: until changed."""
        timeout = self.settings.command_timeout_ns
        return first_tick_from(timeout, self.dt_ns) * self.dt_ns

    def within_ticks_of(self, dt_ns: int) -> int:
        """Count the commands that begin, or time out, within a tick of dt_ns."""
        timeout, given = self.timeout_ns % dt_ns, self.commands().items()
        late = sum(len(some) for tick, some in given if timeout or tick * self.dt_ns % dt_ns)
        ends = (slot.until for slot in self._held.values() if slot.until < FOREVER)
        return late + sum(until * self.dt_ns % dt_ns > 0 for until in ends)

    def _check_topics(self, run: Run) -> None:
        """Refuse a bag with topics that its run neither publishes nor takes."""
        expected = {
            *run.topics,
            *command_topics(run.names, namespace=self.settings.namespace),
            choices.topic_of(self.settings.namespace),
        }
        other = sorted(set(self.bag.topics.values()) - expected)
        if other:
            raise DamagedBag(
                f'{self.bag.path}: damaged: the topic {other[0].name!r} of type {other[0].type!r} '
                'does not belong to its run'
            )
