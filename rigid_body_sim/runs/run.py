# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One run: a simulation that takes commands at tick boundaries and gives messages. What a tick is, is
said here alone.

Tick k, from k dt to (k + 1) dt:
    commands that arrived are taken in order: a held one replaces what its source asked before, an
    impulse acts at once, a state that was asked for holds from here on
    the physics advances by dt
    applied wrenches of tick k and the states after it are packed: at each publish tick those of
    all bodies, else the wrenches of the bodies whose command changed at k, so that the first
    message with a new value names the tick on which it first acted

Before the first of its ticks the states where a run stands are published too (`start`): those of
t = 0, or of the instant of a reset.

The node, `simulate` and `replay` all run through `Run`; the recorder sees the same bytes that are
published.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.diagnostics import extreme_commands
from rigid_body_sim.physics.diagnostics.conserved_groups import (
    ConservedGroups,
    GroupDrifts,
    KeptQuantity,
)
from rigid_body_sim.physics.diagnostics.energy_balance import EnergyBalance
from rigid_body_sim.physics.diagnostics.extreme_commands import Excess
from rigid_body_sim.physics.diagnostics.invariants import Drift, DriftMeter
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.forces.held_wrenches import FOREVER, Slot
from rigid_body_sim.physics.model.scene import Scene, Vector
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state.impacts import Impacts, joined
from rigid_body_sim.physics.state.snapshot import State
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.contact_packing import ContactPacker
from rigid_body_sim.recording.impact_packing import ImpactPacker
from rigid_body_sim.recording.packing import StatePacker
from rigid_body_sim.recording.topics import COMMAND_TYPES
from rigid_body_sim.runs.commands import Command, CommandRules, topics_of
from rigid_body_sim.runs.energy_log import EnergyLog
from rigid_body_sim.runs.error_estimate import ErrorEstimate, ReferenceRun
from rigid_body_sim.runs.manifest_values import MOST_NS, MOST_TICKS
from rigid_body_sim.runs.pace import Pace
from rigid_body_sim.runs.view import ViewSettings
from rigid_body_sim.runs.viewing import Viewing, bodies_with_topics

if TYPE_CHECKING:
    from rigid_body_sim.physics.state.contacts import Contacts

Array = NDArray[np.float64]

_NOBODY = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class RunSettings:
    """
    What turns a simulation into messages; recorded in the manifest.

    namespace          : of the body topics
    world_frame        : name of the world axes
    command_timeout_ns : how long a held command lasts [ns]; 0: until changed
    publish_every      : ticks between publish ticks
    publish_phase      : a publish tick is so far from a multiple of publish_every [tick]
    estimate_error     : whether finer runs go along to tell how wrong the run is; they change no
                         message
    publish_contacts   : whether contacts are packed too
    publish_start      : whether the states before the first tick are; not in old recordings
    view               : what is published beside the states
    topic_names        : of topics that have another name on the wire: own -> there
    """

    namespace: str = ''
    world_frame: str = 'world'
    command_timeout_ns: int = 200_000_000
    publish_every: int = 10
    publish_phase: int = 0
    estimate_error: bool = False
    publish_contacts: bool = False
    publish_start: bool = True
    view: ViewSettings = field(default_factory=ViewSettings)
    topic_names: Mapping[str, str] = field(default_factory=dict)


def command_rules(
    scene: Scene, settings: RunSettings, names: Collection[str] | None = None
) -> CommandRules:
    """
    Make the rules for commands to a run.

    names : of the bodies that take them; None: as the settings say
    """
    if names is None:
        own = bodies_with_topics(scene, settings.view.body_topics)
        names = [scene.bodies[place].name for place in own]
    return CommandRules(
        scene,
        world_frame=settings.world_frame,
        frame_prefix=settings.view.frame_prefix,
        commanded=names,
    )


RATES = (1e-9, 1e9)  # [Hz] of publishing; ticks are at least a nanosecond, runs less than 2^31 s
MOST_TOPICS = 65535  # [-] channels of a recording: their numbers have 16 bits


def last_tick(dt_ns: int) -> int:
    """Tell the last tick of dt_ns [ns] whose number and stamp a message can bear."""
    return min(MOST_TICKS, (MOST_NS - 1) // dt_ns)


def need_numbers(scene: str, bodies: Sequence[str]) -> None:
    """Refuse more bodies with topics of their own than topics have numbers; UserError."""
    count = len(bodies) * len(COMMAND_TYPES)
    if count > MOST_TOPICS:
        raise UserError(
            f'scene {scene!r}: {len(bodies)} bodies take commands on {count} topics; a recording '
            f'holds at most {MOST_TOPICS}; give fewer bodies topics of their own (body_topics), '
            'and publish all in arrays (publish_arrays)'
        )


def publish_every(rate_hz: float, dt_ns: int) -> int:
    """Count the ticks between published states; UserError for a rate outside of RATES."""
    least, most = RATES
    if not least <= rate_hz <= most:
        raise UserError(f'publish rate {rate_hz:g} Hz; allowed: {least:g} to {most:g} Hz')
    return max(1, round(1e9 / rate_hz / dt_ns))


def rate_note(rate_hz: float, dt_ns: int) -> str | None:
    """
    Say in a line what a publish rate becomes where ticks of dt_ns do not hit it; None where they
    do.
    """
    every = publish_every(rate_hz, dt_ns)
    reached = 1e9 / (every * dt_ns)
    if math.isclose(reached, rate_hz, rel_tol=1e-3):
        return None
    return (
        f'states are published at {reached:g} Hz in place of {rate_hz:g} Hz: every '
        f'{"tick" if every == 1 else f"{every} ticks"} of {dt_ns * 1e-9:g} s; dt and publish rate '
        'agree where 1 / rate is a whole number of ticks'
    )


def start_alone_note(every: int, ticks: int, dt_ns: int) -> str | None:
    """Say in a line that a run of so many ticks ends before its first published tick."""
    if ticks >= every:
        return None
    return (
        f'the run of {ticks * dt_ns * 1e-9:g} s ends before its first published state at '
        f'{every * dt_ns * 1e-9:g} s: the bag will hold the state of its start alone; raise the '
        'publish rate, or make the run longer'
    )


@dataclass(frozen=True)
class TickOutput:
    """
    What came of one tick or of a stretch of them.

    consumed : commands taken at the start, in order, with their messages
    batches  : packed messages, in the order of the file
    """

    tick: int
    consumed: Sequence[tuple[str, bytes]]
    batches: tuple[Batch, ...] = ()


class Run:
    """
    Takes commands, advances, packs. Knows neither file nor ROS, and no clock but for `follow`,
    which does no more at once than a signal may wait for.

    warnings : what is wrong with the scene from the start (`Simulation.scene_warnings`), and where
               the run was seen beyond a limit of its integrator (`diagnostics.step_limits`), at
               the start and whenever drift was sampled: a line each, every body once a limit;
               and which bodies overlap by more than a tenth of the smaller, every pair once
    warn     : is given each of them when it is found
    names    : of the bodies that have topics of their own, scene order
    """

    def __init__(
        self,
        simulation: Simulation,
        settings: RunSettings,
        *,
        warn: Callable[[str], None] | None = None,
    ) -> None:
        self.simulation = simulation
        self.settings = settings
        names = [body.name for body in simulation.scene.bodies]
        self._index = {name: i for i, name in enumerate(names)}
        self._own = bodies_with_topics(simulation.scene, settings.view.body_topics)
        self._all_own = len(self._own) == len(names)
        self.names = tuple(names[place] for place in self._own)
        topics = topics_of(self.names, namespace=settings.namespace)
        self._command_topic = {body_and_kind: topic for topic, body_and_kind in topics.items()}
        self.rules = command_rules(simulation.scene, settings, self.names)
        need_numbers(simulation.scene.name, self.names)
        self.packer = StatePacker(
            self.names,
            dt_ns=simulation.dt_ns,
            namespace=settings.namespace,
            frame_id=settings.world_frame,
        )
        self.contact_packer = self._make_contact_packer(names)
        self.topics = self.packer.topics + (
            self.contact_packer.topics if self.contact_packer else ()
        )
        self._impact_packer = self._make_impact_packer()
        self._impacts: list[Impacts] = []  # since the last published tick
        if self._impact_packer is not None:
            self.topics += self._impact_packer.topics
        self.viewing = Viewing(
            simulation,
            settings.view,
            own=self._own,
            namespace=settings.namespace,
            world_frame=settings.world_frame,
            publish_every=settings.publish_every,
            first_channel_id=1 + len(self.topics),
        )
        self.topics += self.viewing.topics
        self.command_timeout_ns = settings.command_timeout_ns
        self._applied = np.array(simulation.applied_wrench())
        self._meter = DriftMeter(simulation.invariants, simulation.state, time=simulation.time)
        self._groups = ConservedGroups(simulation.scene)
        self._restart_groups()
        self._commanded = bool(simulation.held_slots)
        self._orientation_drift = simulation.orientation_drift()
        if settings.estimate_error and self.has_contact:
            raise UserError(
                f'error estimate of the scene {simulation.scene.name!r}: a finer run says '
                'nothing where bodies meet; replay the bag with half the dt instead'
            )
        self._reference = ReferenceRun(simulation) if settings.estimate_error else None
        self._extreme: dict[str, Excess] = {}  # commands since the start or a reset, by body
        self._masses: dict[str, dict[str, float]] = {}  # and least moments, of who was commanded
        self._modest: dict[str, float] = {}  # size of a command that is not looked at any further
        self._warn = warn
        self._restart_warnings()
        self.energy = EnergyLog(
            simulation, settings.publish_every, self._emit_warning, phase=settings.publish_phase
        )

    def _restart_groups(self) -> None:
        simulation = self.simulation
        self._kept = GroupDrifts(self._groups, simulation.state, time=simulation.time)
        self._touched: set[int] = set()  # scene indices, since the last look at the groups

    def _restart_warnings(self) -> None:
        self.warnings: list[str] = []  # in the order in which they were first seen
        self._warned: dict[str, set[int]] = {}
        self._overlapped: set[tuple[int, int]] = set()
        for text in self.simulation.scene_warnings:
            self._emit_warning(text)
        self._check_limits(self.simulation.state)

    def _check_limits(self, state: State) -> None:
        for violation in self.simulation.stability.check(state, self._warned):
            self._warned.setdefault(violation.kind, set()).update(violation.bodies)
            self._emit_warning(violation.text)

    def _check_overlaps(self) -> None:
        for pair, text in self.simulation.overlap_warnings.items():
            if pair not in self._overlapped:
                self._overlapped.add(pair)
                self._emit_warning(text)

    def add_warning(self, text: str) -> None:
        """Warn of what the caller knows of this run."""
        self._emit_warning(text)

    def _emit_warning(self, text: str) -> None:
        self.warnings.append(text)
        if self._warn is not None:
            self._warn(text)

    def _make_contact_packer(self, names: Sequence[str]) -> ContactPacker | None:
        scene, settings = self.simulation.scene, self.settings
        if not settings.publish_contacts:
            return None
        if not self.has_contact:
            raise UserError(
                f'contacts of the scene {scene.name!r}: asked for, but its bodies do not meet; '
                'give the scene contact: {mode: timestep}, or do not ask'
            )
        own = set(self._own.tolist())
        return ContactPacker(
            names,
            movable=[not body.fixed and i in own for i, body in enumerate(scene.bodies)],
            dt_ns=self.simulation.dt_ns,
            namespace=settings.namespace,
            frame_id=settings.world_frame,
            first_channel_id=1 + len(self.packer.topics),
        )

    def _make_impact_packer(self) -> ImpactPacker | None:
        """Make what packs impacts, where they come at their instants."""
        settings = self.settings
        if self.simulation.scene.contact.get('mode') != 'event':
            return None
        return ImpactPacker(
            node=settings.view.node_name,
            dt_ns=self.simulation.dt_ns,
            namespace=settings.namespace,
            frame_id=settings.world_frame,
            channel_id=1 + len(self.topics),
        )

    @property
    def has_contact(self) -> bool:
        """Whether bodies of the scene meet at all."""
        return self.simulation.scene.contact.get('mode', 'none') != 'none'

    def _step(self, ticks: int) -> None:
        try:
            self.simulation.step(ticks)
        except SimulationDiverged:  # the ticks before are done
            self._note_impacts()
            raise
        self._note_impacts()
        if self.has_contact:
            self._check_overlaps()
        if self._reference is not None:
            try:
                self._reference.step(ticks)
            except SimulationDiverged:  # the run itself is well: only the estimate is lost
                self._reference = None

    def _note_impacts(self) -> None:
        """Keep the impacts of the ticks that were done last."""
        if self._impact_packer is not None:
            self._impacts.append(self.simulation.impacts())

    @property
    def untold_impacts(self) -> Impacts:
        """Impacts at their instants since the last published tick: the next one tells them."""
        return joined(self._impacts)

    @untold_impacts.setter
    def untold_impacts(self, impacts: Impacts) -> None:
        self._impacts = [impacts]

    def error_estimate(self) -> ErrorEstimate | None:
        """Estimate how wrong the states are by now; None where nobody asked for it."""
        return self._reference.estimate() if self._reference is not None else None

    def _consume(self, commands: Sequence[Command]) -> list[tuple[str, bytes]]:
        """
        Apply commands; give the topic and message of each. Impulses are left in `_mean_force`, as
        forces and torques that would do the same over a tick.
        """
        consumed = []
        for command in commands:
            self._apply(command)
            consumed.append((self._command_topic[command.body, command.kind], command.message))
        return consumed

    def _note_its_size(self, command: Command) -> None:
        """Keep the most extreme command to each body, for the words of a run that diverges."""
        dt, asked, name = self.simulation.dt, command.state, command.body
        if asked is not None:
            excess = extreme_commands.of_state(
                position=asked.position, velocity=asked.linear, spin=asked.angular, dt=dt
            )
        else:
            timeout = self.command_timeout_ns * 1e-9 or extreme_commands.LONGEST_HOLD
            if name not in self._masses:
                body = self.simulation.scene.bodies[self._index[name]]
                masses = {'mass': body.mass, 'moment': extreme_commands.least_moment(body)}
                self._masses[name] = masses
                self._modest[name] = extreme_commands.largest_modest(**masses, dt=dt)
            if math.hypot(*command.force, *command.torque) <= self._modest[name]:
                return
            excess = extreme_commands.of_push(
                **self._masses[name],
                force=command.force,
                torque=command.torque,
                dt=dt,
                seconds=None if command.acts_at_once else timeout,
            )
        if excess.share > max(1.0, self._extreme.get(name, extreme_commands.NONE).share):
            topic = self._command_topic[name, command.kind]
            self._extreme[name] = excess.of(f'{topic} in tick {self.simulation.tick}')

    def _with_its_command(self, diverged: SimulationDiverged) -> SimulationDiverged:
        """Blame a command to the body, or to another one, where it was of an extreme size."""
        if not self._extreme or not diverged.found:
            return diverged
        excess = self._extreme.get(diverged.body) or extreme_commands.worst(self._extreme.values())
        return SimulationDiverged(
            body=diverged.body,
            tick=diverged.tick,
            cause=f'{diverged.found}; {excess.blame}',
            found=diverged.found,
        )

    def _apply(self, command: Command) -> None:
        self._note_its_size(command)
        self._touched.add(self._index[command.body])
        impulse = self._issue(command, self.simulation)
        if impulse is not None:
            mean_force = np.array(impulse) / self.simulation.dt
            self._mean_force[:, self._index[command.body]] += mean_force
            self._any_impulse = True
        if self._reference is not None:
            for simulation in self._reference.simulations:
                self._issue(command, simulation)
            if command.state is not None:
                self._reference.follow_the_state()

    def _issue(self, command: Command, simulation: Simulation) -> tuple[Vector, Vector] | None:
        """
        Give a command to a simulation; return an impulse in world axes, None for anything else.
        """
        command = self.rules.without_prefix(command)
        if command.state is not None:
            asked = command.state
            simulation.set_state(
                command.body,
                position=asked.position,
                orientation=asked.orientation,
                velocity=asked.linear,
                angular_velocity=asked.angular,
                frame=asked.axes(command.body),
            )
            return None
        frame = self.rules.frame(command)
        if command.kind == 'impulse':
            return simulation.apply_impulse(
                command.body, linear=command.force, angular=command.torque, frame=frame
            )
        simulation.hold(
            command.body,
            command.kind,
            force=command.force,
            torque=command.torque,
            frame=frame,
            until=self._until(),
        )
        return None

    def _until(self) -> int:
        if self.command_timeout_ns == 0:
            return FOREVER
        ticks = -(-self.command_timeout_ns // self.simulation.dt_ns)
        return self.simulation.tick + ticks

    def start(self) -> tuple[Batch, ...]:
        """Pack the states where the run stands; nothing where they are not to be published."""
        if not self.settings.publish_start:
            return ()
        state = self.simulation.state
        batch = self.packer.pack_states(
            self.simulation.tick,
            position=self._of_own(state.position),
            orientation=self._of_own(state.orientation),
            velocity=self._of_own(state.velocity),
            angular_velocity=self._of_own(state.angular_velocity),
        )
        return (*self.viewing.start(), batch)

    def _of_own(self, array: Array) -> Array:
        """Give the rows of the bodies that have topics of their own."""
        return array if self._all_own else array[self._own]

    def advance(self, ticks: int, commands: Sequence[Command] = ()) -> TickOutput:
        """
        Take commands, then advance over ticks up to the next publish tick or expiry of a command,
        at most `ticks`.

        Raises SimulationDiverged; what was packed before is not lost, the ticks before are done,
        and what the commands did at once is undone: they are part of no recording.
        """
        simulation = self.simulation
        tick = simulation.tick
        changing = bool(commands) or simulation.next_expiry <= tick
        if changing and not self._commanded:
            self._sample(commanded=False)
        self._mean_force = np.zeros_like(self._applied)
        self._any_impulse = False
        held = simulation.held_slots if changing else {}
        mark = simulation.mark() if any(command.acts_at_once for command in commands) else None
        consumed = self._consume(commands)
        self._update_applied(changing)
        changed = self._changed_since(held) if changing else _NOBODY
        stop = min(tick + ticks, self._next_publish(tick))
        if changing:  # where a look at the drift falls must not depend on what is done at once
            stop = tick + 1
        stop = min(stop, max(tick + 1, simulation.next_expiry))
        try:
            self._step_to(stop)
        except SimulationDiverged as diverged:
            if mark is not None:
                simulation.return_to(mark)
            raise self._with_its_command(diverged) from None
        if changing:
            self._close_stretch()
        if self._is_published(stop):
            self.energy.at_publish()
            return TickOutput(stop, consumed, self._pack_states())
        if changed.size:
            force, torque = map(self._of_own, self._applied + self._mean_force)
            batch = self.packer.pack_wrenches(
                np.searchsorted(self._own, changed), tick, force=force, torque=torque
            )
            return TickOutput(stop, consumed, (batch,))
        return TickOutput(stop, consumed)

    def _is_published(self, tick: int) -> bool:
        """Whether the states of a tick are published."""
        return (tick - self.settings.publish_phase) % self.settings.publish_every == 0

    def _next_publish(self, tick: int) -> int:
        """Find the first publish tick after a tick."""
        every = self.settings.publish_every
        return tick + every - (tick - self.settings.publish_phase) % every

    def _step_to(self, stop: int) -> None:
        """Advance to a tick, with the applied wrenches of the one before it where it is told."""
        ticks = stop - self.simulation.tick
        if self._is_published(stop) and ticks > 1:
            self._step(ticks - 1)
            self._update_applied(False)
            ticks = 1
        self._step(ticks)

    def follow(
        self, commands: Mapping[int, Sequence[Command]], last_tick: int
    ) -> Iterator[tuple[int, TickOutput]]:
        """
        Advance to a tick, taking commands at theirs; yield the first tick of each stretch and what
        came of it.
        """
        simulation, pace = self.simulation, Pace()
        pending = sorted((k for k in commands if simulation.tick <= k < last_tick), reverse=True)
        while simulation.tick < last_tick:
            tick = simulation.tick
            if pending and pending[-1] == tick:
                pending.pop()
            stop = pending[-1] if pending else last_tick
            begin = time.perf_counter()
            output = self.advance(min(stop - tick, pace.ticks), commands.get(tick, ()))
            pace.note(output.tick - tick, time.perf_counter() - begin)
            yield tick, output

    def _update_applied(self, changing: bool) -> None:
        """Renew the applied wrenches where they may be others than before."""
        if changing or self.simulation.has_turning_commands:
            self._applied = np.array(self.simulation.applied_wrench())

    def _changed_since(self, held: dict[tuple[int, str], Slot]) -> NDArray[np.int64]:
        """
        Tell which bodies are asked for something else than before, or were struck.

        What is asked decides, not the wrench that comes of it: commands that turn with a body
        change it in every tick, and whether by a bit or not must not depend on how many ticks are
        done at once.
        """
        now = self.simulation.held_slots
        different = self._mean_force.any(axis=(0, 2))
        for key in held.keys() | now.keys():
            if _asked(held.get(key)) != _asked(now.get(key)):
                different[self.simulation.scene_index(key[0])] = True
        return np.flatnonzero(different)

    def _pack_states(self) -> tuple[Batch, ...]:
        simulation, state = self.simulation, self.simulation.state
        force, torque = self._applied + self._mean_force if self._any_impulse else self._applied
        batch = self.packer.pack(
            simulation.tick,
            position=self._of_own(state.position),
            orientation=self._of_own(state.orientation),
            velocity=self._of_own(state.velocity),
            angular_velocity=self._of_own(state.angular_velocity),
            force=self._of_own(force),
            torque=self._of_own(torque),
        )
        between = self._pack_contacts_and_views(force, torque)
        if not between:
            return (batch,)
        if not self.names:
            return (*between, batch)
        wrenches, states = self.packer.split(batch)
        return (wrenches, *between, states)

    def _pack_contacts_and_views(self, force: Array, torque: Array) -> tuple[Batch, ...]:
        """Pack what lies between the wrenches of a tick and its states."""
        impacts = self.rest()
        self._impacts = []
        return (*impacts, *self._pack_contacts_with_views(force, torque))

    def rest(self) -> tuple[Batch, ...]:
        """
        Pack what no message has told of the ticks that are done: the impacts since the last
        published tick. Where the run ends, or a recording of it, nothing else will tell them;
        where it goes on, its next published tick tells them all the same.
        """
        if self._impact_packer is None:
            return ()
        found = self.untold_impacts
        batch = self._impact_packer.pack(
            self.simulation.tick,
            **{each.name: getattr(found, each.name) for each in fields(found)},
        )
        return () if batch is None else (batch,)

    def _pack_contacts_with_views(self, force: Array, torque: Array) -> tuple[Batch, ...]:
        drawn = self.has_contact and self.viewing.shows_contacts(self.simulation.tick)
        if not drawn and self.contact_packer is None:
            return self.viewing.pack(force, torque, None)
        found = self.simulation.contacts()
        contacts = self._pack_contacts(found)
        views = self.viewing.pack(force, torque, found)
        return views if contacts is None else (contacts, *views)

    def _pack_contacts(self, found: Contacts) -> Batch | None:
        if self.contact_packer is None:
            return None
        simulation = self.simulation
        return self.contact_packer.pack(
            simulation.tick,
            bodies=found.bodies,
            point=found.point,
            normal=found.normal,
            gap=found.gap,
            force=found.impulse / simulation.dt,
        )

    def _close_stretch(self) -> None:
        """
        Begin to measure drift anew when no command acts any more; none counts while one does.
        """
        self._commanded = bool(self.simulation.held_slots)
        if not self._commanded:
            self._sample(commanded=True)

    def sample_drift(self) -> Drift:
        """Measure what should have stayed the same, give the worst so far; look at the limits."""
        self._sample(commanded=self._commanded)
        self._check_limits(self.simulation.state)
        return self._meter.drift()

    def kept(self) -> list[KeptQuantity]:
        """Tell what groups of bodies should have kept, and how well they did so far."""
        return self._kept.kept()

    def energy_balance(self) -> EnergyBalance:
        """Draw the energy balance since the run, or its recording, began."""
        return self.energy.balance()

    def deepest_gap(self) -> float | None:
        """
        Smallest distance [m] of two bodies in contact, in any tick since the start or the last
        reset (`Simulation.deepest_gap`); negative: they overlapped. None where nothing touched.
        """
        return self.simulation.deepest_gap()

    def orientation_drift(self) -> float | None:
        """
        How far the matrices of `orientation: matrix` were from rotations at any look so far, see
        `physics.diagnostics.orthogonality`; None where the integrator keeps no matrices.
        """
        return self._orientation_drift

    def _sample(self, *, commanded: bool) -> None:
        simulation = self.simulation
        if self._orientation_drift is not None:
            self._orientation_drift = max(
                self._orientation_drift, simulation.orientation_drift() or 0.0
            )
        self._meter.sample(simulation.state, time=simulation.time, commanded=commanded)
        held = {simulation.scene_index(core) for core, _ in simulation.held_slots}
        touched = self._touched | held
        self._kept.sample(simulation.state, time=simulation.time, commanded=touched)
        self._touched = held

    def reset(self, tick: int | None = None) -> None:
        """
        Put every body back to the start of the scene; time goes on, drift is measured anew.

        tick : where it goes on; None: at the present one
        """
        simulation = self.simulation
        if tick is not None and tick != simulation.tick:
            simulation.restore(
                tick=tick, state=simulation.state_bytes(), slots=simulation.held_slots
            )
        simulation.reset()
        if self.settings.estimate_error:
            self._reference = ReferenceRun(self.simulation)
        self._applied = np.zeros_like(self._applied)
        self._commanded = False
        self._extreme = {}
        self._impacts = []
        self._orientation_drift = self.simulation.orientation_drift()
        self._meter = DriftMeter(
            self.simulation.invariants, self.simulation.state, time=self.simulation.time
        )
        self._restart_groups()
        self._restart_warnings()
        self.energy.begin()


def _asked(slot: Slot | None) -> tuple[object, ...] | None:
    """What a held command asks for, without how long."""
    return None if slot is None else (slot.force, slot.torque, slot.turns_with_body)
