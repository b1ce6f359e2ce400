# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A scene that moves: whole ticks, commands at tick boundaries, and what can be asked of it.

    sim = Simulation(load_scene('box.yaml'))
    sim.set_wrench('box', force=(1, 0, 0))
    sim.step(1000)
    sim.state.position

Time is tick * dt_ns in integers. `step(1000)` and a thousand times `step()` give the same bits.
Whatever depends on time counts from the start of the scene: from tick 0, or from the last reset.
Forces over time, the flow of mass, bodies that are moved as told, and the first tick, which finds
the loads of what stands: after a reset the same bits follow as the first time.

An interrupt (KeyboardInterrupt) anywhere leaves tick and state that belong together: what a call
had done in whole chunks of ticks is counted, the rest is put back. One simulation belongs to one
thread at a time; what comes in the middle of a step raises SimulationBusy.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from threading import get_ident
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.compile.kernels import warn_if_plain
from rigid_body_sim.physics.diagnostics import extreme_commands
from rigid_body_sim.physics.diagnostics.energy_balance import (
    NOT_IN_MOTION,
    EnergyBalance,
    EnergyLedger,
    PassiveEnergy,
    overlap_energy,
    words_for_gain,
    words_for_loss,
    words_for_no_energy,
)
from rigid_body_sim.physics.diagnostics.invariants import Invariants
from rigid_body_sim.physics.diagnostics.orthogonality import orthogonality_defect
from rigid_body_sim.physics.diagnostics.point_motion import PointMotion, motion_of
from rigid_body_sim.physics.diagnostics.step_limits import StabilityWatch, substeps_of_contact
from rigid_body_sim.physics.errors import InvalidModel, SimulationBusy, SimulationDiverged
from rigid_body_sim.physics.forces.at_start import (
    asks_the_start,
    need_energy,
    without_direction,
    without_energy,
)
from rigid_body_sim.physics.forces.elements import held_body_wrench
from rigid_body_sim.physics.forces.held_wrenches import FOREVER, HeldWrenches, Slot
from rigid_body_sim.physics.forces.power import COMMANDS
from rigid_body_sim.physics.forces.schedule import SNAP
from rigid_body_sim.physics.integration import choose
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.lookout import Lookout, RecordedChoices, Watch
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.body_axis import moment_of_body
from rigid_body_sim.physics.model.numbers import checked_vector, shown
from rigid_body_sim.physics.model.scene import Scene, Vector
from rigid_body_sim.physics.model.tick_length import LONGEST_NS, tick_nanoseconds, whole_ticks
from rigid_body_sim.physics.model.variable_mass import end_of_mass, mass_at
from rigid_body_sim.physics.state.contacts import Contacts
from rigid_body_sim.physics.state.impacts import Impacts
from rigid_body_sim.physics.state.layout import Layout, as_vector
from rigid_body_sim.physics.state.placement import asked_placement, rows_of
from rigid_body_sim.physics.state.snapshot import State, StateReader
from rigid_body_sim.physics.stepper import Stepper, Undo
from rigid_body_sim.physics.validation import check_record

Array = NDArray[np.float64]

NO_VECTOR: Vector = (0.0, 0.0, 0.0)
NOT_FINITE = 'its state is no longer finite'
START_MARK = b'begun at'  # as a number 4e252: none of a state


class Simulation:
    """
    One run of one scene.

    scene      : what `rigid_body_sim.load_scene` returns
    integrator : name in `integration.integrators.INTEGRATORS`, or with its options, as scene files
                 have it: {'name': 'rk45', 'rtol': 1e-9}; None: the scene's
    integrator_options : its options by name, where they are not in `integrator`; None: those of
                         the scene if the integrator is the scene's, else defaults
    dt         : [s] a whole number of nanoseconds; None: the scene's
    progress   : called with a short text while `auto` chooses

    `choice` is what `auto` chose last and why, None where the integrator was named; `choices` are
    all that held in this run, in order, each with the tick from which it did; `watch` says what
    `auto` saw on the way (`integration.lookout`).

    A copy, a deep copy and a pickle each stand for a simulation of their own, which goes on bit
    for bit from where this one stood; its `contacts` are told from its first tick on, and no
    energy balance is kept until it is asked to.

    Raises InvalidModel for a scene that a scene file could not say (`validation`), an unknown
    integrator or option, an integrator that refuses the scene, or an impossible dt.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        integrator: str | Mapping[str, Any] | None = None,
        integrator_options: Mapping[str, Any] | None = None,
        dt: float | None = None,
        progress: Callable[[str], None] | None = None,
    ) -> None:
        warn_if_plain()
        check_record(scene)
        if progress is not None and not callable(progress):
            raise InvalidModel(
                f'progress: got {shown(progress)}; a function of a short text, such as print, is '
                'needed, or None (a bar is shown by run(…, progress=True))'
            )
        self._scene = scene
        self._dt_ns = scene.dt_ns if dt is None else tick_nanoseconds(dt)
        self._dt = self._dt_ns / 1e9
        self._last_tick = LONGEST_NS // self._dt_ns
        self._integrator, plan = choose.resolve(
            scene,
            integrator,
            integrator_options,
            dt_ns=self.dt_ns,
            pilot=partial(_pilot, scene, self.dt_ns),
            fastest=partial(_fastest_rate, scene),
            progress=progress,
        )
        self._choices: tuple[choose.Choice, ...] = () if plan is None else (plan.choice,)
        self._watch: Watch | None = None
        self._shadows: dict[Any, Simulation] = {}
        self._stepping: dict[str, int] = {}  # 'thread': which one is in a step
        self._invariants = Invariants(scene)
        self._layout = Layout(scene)
        self._reader = StateReader(self._layout)
        self._held = HeldWrenches(self._layout, scene.gravity)
        self._stepper = Stepper(scene, self._layout, self.integrator)
        self._stability = StabilityWatch(scene, self._layout, self.integrator, self.dt)
        self._start_warnings: tuple[str, ...] = ()
        if asks_the_start(scene):
            begin = self._reader.read(*self._stepper.start, 0.0)
            need_energy(scene, begin)
            self._start_warnings = without_direction(scene, begin)
        self._read: State | None = None
        self._ledger: EnergyLedger | None = None
        self._passive: tuple[PassiveEnergy, float] | None = None  # and what was stored then [J]
        self._from_start = True  # whether steps alone led here
        self._commanded = False
        self._held_changed = True
        self._start_ns = 0  # when the scene began: tick 0, or the last reset
        self._out_of_mass = min(
            ((end_of_mass(body), body.name) for body in scene.bodies), default=(math.inf, '')
        )
        self._loses_mass = self._out_of_mass[0] < math.inf
        if plan is not None and plan.setting is not None:
            self._watch = Lookout(plan, scene, dt_ns=self.dt_ns, failed=SimulationDiverged)
            self._watch.attach(shadow=self._shadow, change=self._go_on_with)

    @property
    def scene(self) -> Scene:
        """What is simulated."""
        return self._scene

    @property
    def integrator(self) -> Integrator:
        """By which method; with `auto`, the one that it has chosen last."""
        return self._integrator

    @property
    def invariants(self) -> Invariants:
        """Energy and momenta of the scene in any state."""
        return self._invariants

    @property
    def stability(self) -> StabilityWatch:
        """The limits of the integrator in this scene."""
        return self._stability

    @property
    def choices(self) -> tuple[choose.Choice, ...]:
        """All that `auto` has chosen in this run, in order."""
        return self._choices

    @property
    def watch(self) -> Watch | None:
        """Who sees to it that the choice of `auto` holds; None where nobody does."""
        return self._watch

    @property
    def choice(self) -> choose.Choice | None:
        """What `auto` chose last; None where the integrator was named."""
        return self.choices[-1] if self.choices else None

    def follow_choices(self, choices: Sequence[choose.Choice]) -> None:
        """Change the integrator where it was changed in another run, tick by tick the same."""
        self._watch = RecordedChoices(choices)
        self._watch.attach(shadow=self._shadow, change=self._go_on_with)

    def _go_on_with(self, choice: choose.Choice) -> None:
        """Change the integrator at this tick boundary; the state stays."""
        integrator = choose.integrator_of(choice.name, choice.options)
        self._stepper.go_on_with(
            integrator,
            partial(
                self.__dict__.update,
                _integrator=integrator,
                _stability=StabilityWatch(self.scene, self._layout, integrator, self.dt),
                _choices=(*self.choices, choice),
            ),
        )

    def _shadow(self, integrator: str, options: Mapping[str, Any]) -> Simulation:
        """Make another run of the scene from the present state and commands."""
        key = integrator, *options.items()
        shadow = self._shadows.get(key)
        if shadow is None:
            shadow = self._shadows[key] = Simulation(
                self.scene, integrator=integrator, integrator_options=options, dt=self.dt
            )
        shadow._go_on_from(self.tick, self._bytes(), self.held_slots)
        return shadow

    @property
    def tick(self) -> int:
        """Count of the ticks that were done; those of `state`."""
        undo = self._stepper.undo  # of a step that is under way in another thread, or broke off
        return self._stepper.tick if undo is None else undo[0]

    def __repr__(self) -> str:
        return (
            f'<Simulation of {self.scene.name!r}: {len(self.scene.bodies)} bodies, '
            f'{self.integrator.name}, dt {self.dt:g} s, tick {self.tick}, {self.time:g} s>'
        )

    def __getstate__(self) -> dict[str, Any]:
        """Give what a copy or a pickle needs to go on bit for bit; kernels are made again."""
        return {
            'scene': self.scene,
            'integrator': self.integrator.name,
            'integrator_options': dict(self.integrator.settings),
            'dt': None if self.dt_ns == self.scene.dt_ns else self.dt,
            'choices': self.choices,
            'watch': None if self.watch is None else self.watch.copied(),
            'tick': self.tick,
            'start_ns': self._start_ns,
            'state': self.state_bytes(),
            'slots': self.held_slots,
        }

    def __setstate__(self, kept: Mapping[str, Any]) -> None:
        settings = ('integrator', 'integrator_options', 'dt')
        Simulation.__init__(self, kept['scene'], **{key: kept[key] for key in settings})
        self._choices = kept['choices']
        self._go_on_from(kept['tick'], kept['state'], kept['slots'])
        self._start_ns = kept['start_ns']
        self._watch = kept['watch']
        if self._watch is not None:
            self._watch.attach(shadow=self._shadow, change=self._go_on_with)

    @property
    def time(self) -> float:
        """Simulated time [s]: the nearest number to tick * dt_ns nanoseconds."""
        return self.tick * self._dt_ns / 1e9

    @property
    def scene_time(self) -> float:
        """
        Time since the start of the scene, or since the last reset [s].

        A `restore` brings it back where the scene has something that depends on it; where nothing
        does, it counts from tick 0 again. A copy, a pickle and a checkpoint always keep it.
        """
        return (self._stepper.tick * self._dt_ns - self._start_ns) * 1e-9

    @property
    def _scene_tick(self) -> float:
        """Ticks since the start of the scene, not whole where a recording has another dt."""
        passed_ns = self._stepper.tick * self._dt_ns - self._start_ns
        whole, rest = divmod(passed_ns, self._dt_ns)
        return passed_ns / self._dt_ns if rest else whole  # a float has its kernel compiled anew

    @property
    def dt(self) -> float:
        """Tick length [s]."""
        return self._dt

    @property
    def dt_ns(self) -> int:
        """Tick length [ns]."""
        return self._dt_ns

    @property
    def state(self) -> State:
        """Position, orientation and velocities of every body, scene order: a copy."""
        read = self._read
        if read is None:
            stepper, reader = self._stepper, self._reader
            if self._stepping or stepper.undo is not None:
                self._settle()
            time = self.scene_time if reader.is_timed else 0.0
            self._read = read = reader.read(stepper.translation, stepper.rotation, time)
        return read

    def _read_state(self) -> State:
        """Give `state` to whom is called in the middle of a step."""
        if self._read is None:
            stepper, reader = self._stepper, self._reader
            time = self.scene_time if reader.is_timed else 0.0
            self._read = reader.read(stepper.translation, stepper.rotation, time)
        return self._read

    def prepare(
        self, *, commands_in_body_axes: bool = False, progress: Callable[[str], None] | None = None
    ) -> None:
        """
        Compile now what stepping will need, so that no tick has to wait for it.

        commands_in_body_axes : also what commands in body axes will need
        progress              : called with a short text before each part
        """
        self._stepper.prepare(commands_in_body_axes=commands_in_body_axes, progress=progress)
        for name, options in self.watch.settings if self.watch is not None else ():
            if name != self.integrator.name:
                other = Stepper(self.scene, self._layout, choose.integrator_of(name, options))
                other.prepare(commands_in_body_axes=commands_in_body_axes, progress=progress)
        self._held.prepare(self._stepper.translation, self._stepper.rotation)
        if progress is not None:
            progress('reading states')
        _ = self.state

    def _too_late(self, ticks: object) -> InvalidModel:
        return InvalidModel(
            f'step: {shown(ticks)} ticks from tick {self.tick}; allowed: up to tick '
            f'{self._last_tick}, {LONGEST_NS / 1e9:.3g} s; take fewer ticks'
        )

    def step(self, ticks: int = 1) -> None:
        """
        Advance by whole ticks.

        ticks : 0 or more; of seconds, round(seconds / dt)

        Raises InvalidModel for anything but a whole number of at least 0, and for times beyond 64
        bits of nanoseconds, SimulationBusy while a step is under way in another thread,
        SimulationDiverged when a state leaves the finite numbers; `tick` and `state` are then the
        last good ones. After KeyboardInterrupt, which may come at any moment, they belong together
        too: whole chunks of ticks are counted (1000 ticks; fewer where many bodies meet), the rest
        is put back, and `contacts` are none until the next tick.
        """
        stepper, me, stepping = self._stepper, get_ident(), self._stepping
        try:
            if stepping.setdefault('thread', me) != me:
                raise SimulationBusy
            if stepper.undo is not None:
                self._return()
            tick, watch, held = stepper.tick, self._watch, self._held
            end = tick + (ticks if ticks.__class__ is int and ticks >= 0 else _whole(ticks))
            if end > self._last_tick:
                raise self._too_late(ticks)
            contact = stepper.contact
            if contact is not None:
                contact.readout.forget_impacts()
            while tick < end:
                if watch is not None:
                    watch.meet(tick, self._read_state)
                if self._held_changed or held.no_end_before <= tick:
                    self._take_held()
                stop = end if end < held.no_end_before else held.no_end_before
                chunk = stop - tick
                if watch is not None:
                    chunk = int(min(chunk, watch.next_tick - tick))
                self._read = None
                if self._loses_mass:
                    chunk = min(chunk, self._ticks_with_mass())
                first = self._scene_tick if self._start_ns else tick
                done = stepper.advance(chunk, first, self._dt)
                tick = stepper.tick
                if watch is not None:
                    watch.follow(tick)
                if done < chunk and not (watch is not None and watch.rescue(tick)):
                    raise self._diverged()
        except BaseException:  # no call before the last one: an interrupt could come after it
            if 'thread' in stepping and stepping['thread'] == me:
                try:
                    self._return()
                finally:
                    stepping.clear()
            raise
        else:
            stepping.clear()

    def _settle(self) -> None:
        """Put back what broke off; SimulationBusy while a step is under way."""
        if self._stepping:
            raise SimulationBusy
        if self._stepper.undo is not None:
            self._return()

    def _return(self) -> None:
        """Return to before what broke off, if something did."""
        undo = self._stepper.undo
        if undo is not None:
            self._read = None
            _tick, _motion, _contact, more, _work = undo
            if more is not None:
                self._held_changed = True
                self._start_ns, self._held.slots = more
            self._stepper.put_back()

    @contextmanager
    def _all_or_nothing(self) -> Iterator[None]:
        """Change the state as a whole: an exception puts everything back."""
        self._settle()
        try:
            undo = self._stepper.begin((self._start_ns, self._held.slots))
            yield
            self._compare_energy_from_here()
            self._held_changed = True
            self._read = None
            self._stepper.end(undo)
        except BaseException:
            self._return()
            raise

    def mark(self) -> Undo:
        """Note the tick with its state and what is held, for `return_to`."""
        self._settle()
        undo = self._stepper.begin((self._start_ns, self._held.slots))
        self._stepper.end(undo)
        return undo

    def return_to(self, mark: Undo) -> None:
        """Return to what `mark` noted."""
        self._settle()
        self._stepper.undo = mark
        self._return()
        self._compare_energy_from_here()

    def _ticks_with_mass(self) -> int:
        """Count the whole ticks before a body is out of mass; SimulationDiverged if none."""
        end, body = self._out_of_mass
        # what ends at a boundary, up to rounding, ends there: as forces do
        ticks = math.ceil(end / self._dt - self._scene_tick - SNAP) - 1
        if ticks < 1:
            raise SimulationDiverged(
                body=body,
                tick=self.tick,
                cause=f'its mass is used up at {end:g} s of the scene; give it a final_mass, or '
                'stop earlier',
            )
        return ticks

    def _take_held(self) -> None:
        """Hand what is held now to the stepper."""
        self._drop_expired()
        if self._held_changed:
            work = self._stepper.work
            acting = None if work is None else self._held.acting()
            if work is not None and acting is not None and not work.powers.holds(acting):
                self._stepper.cut_work()
            table = self._held.write(self._stepper.translation, self._stepper.rotation)
            table = self._stepper.set_held(table)
            if work is not None and acting is not None:
                work.powers.hold(acting)
            self._held.written(table)
            if not self._commanded:
                self._commanded = self._held.acts
            self._held_changed = False

    def _drop_expired(self) -> None:
        if self._held.no_end_before <= self._stepper.tick:
            self._held_changed = True  # before it is so: an interrupt may come in between
            self._held.drop_expired(self._stepper.tick)

    def _diverged(self) -> SimulationDiverged:
        core, parts = self._stepper.first_diverged(), substeps_of_contact(self.scene)
        body, found = self._layout.body(core).name, self._stepper.cause or NOT_FINITE
        steps = f', {parts} substeps of contact in a step,' if parts > 1 else ''
        why = self._extreme_command() or (
            f'with {self.integrator.name} at dt = {self.dt:g} s{steps} the limits are: '
            f'{self.integrator.stability}; take a smaller dt or another integrator'
        )
        return SimulationDiverged(body=body, tick=self.tick, cause=f'{found}; {why}', found=found)

    def _extreme_command(self) -> str:
        """Name what is held of a size that no method follows; empty: nothing is."""
        found = extreme_commands.NONE
        for (core, _), slot in self._held.slots.items():
            body = self._layout.body(core)
            held = extreme_commands.of_push(
                mass=body.mass,
                moment=extreme_commands.least_moment(body),
                force=slot.force,
                torque=slot.torque,
                dt=self.dt,
            )
            if held.share > found.share:
                found = held.of(repr(body.name))
        return found.blame if found.is_extreme else ''

    def set_wrench(
        self,
        body: str,
        *,
        force: Sequence[float] = NO_VECTOR,
        torque: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
    ) -> None:
        """
        Hold a force and a torque on a body until changed; it acts from the next tick on.

        force  : (3,) [N]    at the centre of mass, or at the origin of a frame of the body
        torque : (3,) [N m]
        frame  : 'world', or 'body': axes that turn with the body; or a frame of the body by its
                 name: axes and origin (`model.named_frames`), held beside those of other frames
        """
        self._hold(body, 'wrench', force, torque, frame, FOREVER)

    def set_wrenches(
        self, *, force: ArrayLike | None = None, torque: ArrayLike | None = None,
        frame: str = 'world',
    ) -> None:  # fmt: skip
        """
        Hold a force and a torque on every body until changed, in one call: `set_wrench` of each.

        force  : (n, 3) [N]    at the centres of mass, in the order of the scene; None: none
        torque : (n, 3) [N m]  likewise
        frame  : 'world', or 'body': axes that turn with each body

        Rows of fixed bodies are zero. Raises InvalidModel, which names the body, for anything but
        finite numbers, a push on a fixed body, and a torque on a point mass; then nothing changes.
        """
        if self._stepping or self._stepper.undo is not None:
            self._settle()
        # a meter, and who follows what is held, have to know of every change
        is_told = self._watch is not None or self._stepper.work is not None
        was_changed, self._held_changed = self._held_changed, True  # before it is so: an interrupt
        if self._commanded and not is_told and self._held.put_rows_at_once(force, torque, frame):
            self._held_changed = was_changed
            return
        self._held.put_rows(force=force, torque=torque, frame=frame)
        if self._watch is not None:
            shape = (len(self.scene.bodies), 3)
            pushed, turned = (
                np.zeros(shape) if values is None else np.array(values, dtype=np.float64)
                for values in (force, torque)
            )
            for i in self._layout.moving.tolist():
                asked = {'force': pushed[i], 'torque': turned[i], 'frame': frame, 'until': FOREVER}
                self._watch.hold(self.tick, self.scene.bodies[i].name, 'wrench', **asked)

    def run_for(self, seconds: float) -> None:
        """
        Advance by a time [s] that is a whole number of ticks.

        Raises InvalidModel where it is none (within 1e-6 of it), and names the nearest; else as
        `step`.
        """
        self.step(whole_ticks(seconds, self.dt_ns, what='run_for'))

    def hold(
        self,
        body: str,
        source: str,
        *,
        force: Sequence[float] = NO_VECTOR,
        torque: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
        until: int = FOREVER,
    ) -> None:
        """
        Hold what one source asks of a body in place of what it asked before; sources add, and
        each named frame is one of its own.

        source : 'force', 'torque' or 'wrench'
        until  : [tick] first tick on which it no longer acts
        """
        self._hold(body, source, force, torque, frame, until)

    def _hold(
        self, body: str, source: str, force: Any, torque: Any, frame: str, until: int
    ) -> None:
        if self._stepping or self._stepper.undo is not None:
            self._settle()
        held, was_changed = self._held, self._held_changed
        self._held_changed = True  # before it is so: an interrupt may come in between
        # a meter has to know of every change
        if self._stepper.work is None and held.put_at_once(
            body, source, force, torque, frame, until
        ):
            self._held_changed = was_changed
        else:
            held.put(body, source, force=force, torque=torque, frame=frame, until=until)
        if self._watch is not None:
            asked = {'force': force, 'torque': torque, 'frame': frame, 'until': until}
            self._watch.hold(self.tick, body, source, **asked)

    def apply_impulse(
        self,
        body: str,
        *,
        linear: Sequence[float] = NO_VECTOR,
        angular: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
    ) -> tuple[Vector, Vector]:
        """
        Change momentum and angular momentum at once, whatever dt is.

        linear  : (3,) [N s]    at the centre of mass, or at the origin of a frame of the body
        angular : (3,) [N m s]
        frame   : as of `set_wrench`
        returns : both at the centre of mass, in world axes
        """
        self._settle()
        said = f'impulse on {shown(body)}'
        linear = checked_vector(said, 'linear', linear)
        angular = checked_vector(said, 'angular', angular)
        core, linear, angular, frame = self._held.checked(body, linear, angular, frame)
        if frame != 'world':
            self._layout.principal_axes_of(core, linear)  # refuses a point mass
            q = self.state.orientation[self._layout.index(body)]
            linear = as_vector(so3.rotate(q, linear))
            angular = as_vector(so3.rotate(q, angular))
        record = self._layout.body(core)
        ratio = record.mass / mass_at(record, self.scene_time)  # 1.0 unless its mass changes
        work, before = self._stepper.work, 0.0
        if work is not None:
            self._stepper.cut_work()
            before = self._kinetic_energy_of(core)
        self._read = None
        self._compare_energy_from_here()
        self._stepper.apply_impulse(core, ratio * np.array(linear), ratio * np.array(angular))
        if work is not None:
            after = self._kinetic_energy_of(core)
            work.add_jump(COMMANDS, before, after, size=before + after)
        if self._watch is not None:
            self._watch.strike(self.tick, body, linear=linear, angular=angular)
        return linear, angular

    def set_state(
        self,
        body: str,
        *,
        position: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        velocity: Sequence[float] | None = None,
        angular_velocity: Sequence[float] | None = None,
        frame: str = 'world',
    ) -> None:
        """
        Put a body elsewhere, or let it move otherwise, from this tick on; None: as it is.

        position         : (3,) [m]      centre of mass, world
        orientation      : (4,) [-]      quaternion xyzw of any length but zero, body to world
        velocity         : (3,) [m/s]    centre of mass
        angular_velocity : (3,) [rad/s]
        frame            : axes of both velocities: 'world', or 'body' as it is turned then

        The energy that it brings is work of commands. What is remembered of the body, by contacts
        and by the integrator, begins anew; who slept beside it wakes.

        Raises InvalidModel for an unknown or fixed body, numbers that are not finite, an
        orientation of zero length, a turn of a point mass, and what would tear a body off its
        pivot.
        """
        self._settle()
        asked = {
            'position': position,
            'orientation': orientation,
            'velocity': velocity,
            'angular_velocity': angular_velocity,
            'frame': frame,
        }
        index, state = self._layout.index(body), self.state
        x, y, z, w = state.orientation[index].tolist()
        placement = asked_placement(self.scene.bodies[index], **asked, now=(x, y, z, w))
        placed = rows_of(self._layout, placement, body, state, self.scene_time)
        work = self._stepper.work
        before = (0.0, 0.0) if work is None else self._energies()
        with self._all_or_nothing(), np.errstate(over='ignore', invalid='ignore'):
            self._stepper.cut_work()
            self._stepper.place(placed)
            if work is not None:
                self._read = None
                after = self._energies_of(self._read_state())
                size = sum(map(abs, (*before, *after)))
                work.add_jump(COMMANDS, sum(before), sum(after), size=size)
        if self._watch is not None:
            self._watch.place(self.tick, body, **asked)

    def _kinetic_energy_of(self, core: int) -> float:
        """Kinetic energy of one body [J]."""
        return self.invariants.kinetic_energy_of(self.state, self.scene_index(core))

    def applied_wrench(self) -> tuple[Array, Array]:
        """
        Force [N] and torque [N m] that commands exert on each body at the start of the coming
        tick.

        returns : (n, 3) and (n, 3), scene order, world axes; without gravity and force elements
        """
        self._settle()
        self._drop_expired()
        force, torque, table = self._held.sums()
        of_scene = np.zeros((2, len(self.scene.bodies), 3))
        of_scene[0, self._layout.moving] = force
        of_scene[1, self._layout.moving] = torque
        for row in table:
            core = int(row[held_body_wrench.BODY])
            q = self._stepper.orientation(core)
            scene_index = int(self._layout.moving[core])
            of_scene[0, scene_index] += so3.rotate(q, row[held_body_wrench.FORCES])
            of_scene[1, scene_index] += so3.rotate(q, row[held_body_wrench.TORQUES])
        return of_scene[0], of_scene[1]

    def orientation_matrices(self) -> Array:
        """
        Orientation of every body as the integrator keeps it, (n, 3, 3), body to world, scene
        order.

        With `orientation: matrix` these are its own matrices, which need not be rotations any
        more.
        """
        matrices = so3.matrix_from_quaternion(self.state.orientation)
        memory = self._stepper.memory()
        if memory.shape[1] == 9:
            matrices[self._layout.moving[: len(memory)]] = self._layout.to_body_axes(
                memory.reshape(-1, 3, 3)
            )
        return matrices

    def accelerations(self) -> tuple[Array, Array]:
        """
        Accelerations at this instant under all that acts at the start of the coming tick, gravity
        and commands too; of what is moved as told (`motion`), the second derivative of its path.

        returns : linear (n, 3) [m/s^2] of the centres of mass and angular (n, 3) [rad/s^2], scene
                  order, world axes; zero for what stands still. At the ends of a table of `motion`
                  the acceleration jumps; there it is that of the coming tick
        """
        self._settle()
        slots = self._held.slots  # who looks ends no command: a tick does, and tells of it
        self._take_held()
        found = np.zeros((2, len(self.scene.bodies), 3))
        linear, angular = self._stepper.accelerations(self._scene_tick, self.dt)
        if len(slots) != len(self._held.slots):
            self._held_changed = True
            self._held.slots = slots
        found[0, self._layout.moving] = linear
        found[1, self._layout.moving[: self._layout.n_rigid]] = angular
        self._reader.put_accelerations_told(found, self.scene_time)
        return found[0], found[1]

    def motion_of(self, body: str, point: Sequence[float] | Array) -> PointMotion:
        """
        Motion of points fixed to a body: position [m], velocity [m/s] and acceleration [m/s^2].

        point : (..., 3) [m]  shape coordinates; see `diagnostics.point_motion`

        Raises InvalidModel for an unknown body, and for anything but points of three finite
        numbers.
        """
        return motion_of(self, body, point)

    def moment_of_inertia(
        self, body: str, *, direction: Sequence[float], point: Sequence[float] | None = None
    ) -> float:
        """
        Moment of inertia [kg m^2] of a body about an axis fixed to it, now: with the mass and the
        inertia of this tick where they change.

        direction : (3,)      along the axis, body axes
        point     : (3,) [m]  of the axis, shape coordinates; None: the centre of mass

        Raises InvalidModel for an unknown body, a fixed one without mass, and no axis.
        """
        record = self.scene.bodies[self.body_index(body)]
        return moment_of_body(record, direction=direction, point=point, time=self.scene_time)

    def orientation_drift(self) -> float | None:
        """
        How far the matrices of `orientation: matrix` are from rotations: the largest element of
        R^T R - 1 of any body. None where the integrator keeps no matrices.
        """
        memory = self._stepper.memory()
        if memory.shape[1] != 9:
            return None
        return orthogonality_defect(memory.reshape(-1, 3, 3))

    def energy(self) -> float:
        """
        Kinetic and potential energy [J].

        Potential: of the weight, from the origin of the world, of springs and bumpers, of mutual
        gravity, of constant forces in world axes. Where a step does not resolve the swing of a
        stiff spring (h omega > 1: implicit and linearly implicit methods), its ends are held
        within a gap that has nothing to do with a motion: k gap^2 / 2 may be thousands of joules
        that no body has and that never come back. `stored_energy` has that of springs and other
        force elements apart.

        Infinity where a part is beyond the largest number; NaN where parts of both signs are.
        """
        return self.invariants.energy(self.state)

    def stored_energy(self) -> float:
        """Potential energy of the force elements alone, without the weight [J]."""
        return self.invariants.stored_energy(self.state)

    @property
    def has_contact(self) -> bool:
        """Whether bodies of the scene meet at all."""
        return self._stepper.contact is not None

    def keep_energy_balance(self) -> None:
        """
        Begin an energy balance here: add up the work of commands, drives and dampers from now on.

        No bit of the run changes; ticks in which something works cost some microseconds more.
        `reset` and `restore` begin it anew; a copy keeps none until it is asked to.
        """
        self._settle()
        meter = self._stepper.measure_work()
        self._held_changed = True  # what is held is told to the meter before the next tick
        self._ledger = EnergyLedger(
            meter,
            self._stepper.work_done,
            *self._energies(),
            meets=self.has_contact,
            driven=self.invariants.is_driven,
            weight=math.hypot(*self.invariants.weight()),
        )

    def _energies(self) -> tuple[float, float]:
        """Kinetic and potential energy now [J]."""
        return self._energies_of(self.state)

    def _energies_of(self, state: State) -> tuple[float, float]:
        """Kinetic and potential energy of a state [J]."""
        with np.errstate(all='ignore'):  # a run about to diverge
            return self.invariants.kinetic_energy(state), self.invariants.potential_energy(state)

    def look_at_energy(self) -> None:
        """
        Take the energies of now into the balance: lowest and largest values are those of looks.

        Raises InvalidModel where `keep_energy_balance` was not called.
        """
        self._settle()
        self._balance().look(*self._energies())

    def energy_balance(self) -> EnergyBalance:
        """
        Draw the balance since it began, see `diagnostics.energy_balance`; it stays as it is.

        Raises InvalidModel where `keep_energy_balance` was not called.
        """
        self._settle()
        return self._balance().balance(*self._energies())

    def _balance(self) -> EnergyLedger:
        if self._ledger is None:
            raise InvalidModel(
                'energy balance: none is kept; call keep_energy_balance() where it is to begin, '
                'again in a copy, a pickle or a checkpoint, which keep none'
            )
        return self._ledger

    def momentum(self) -> Array:
        """Total momentum (3,) [kg m/s]."""
        return self.invariants.momentum(self.state)

    def angular_momentum(self) -> Array:
        """Total angular momentum about the origin of the world (3,) [kg m^2/s]."""
        return self.invariants.angular_momentum(self.state)

    def warnings(self) -> list[str]:
        """
        Say what is wrong with the scene, where the present state is beyond a limit of the
        integrator, which bodies have overlapped by more than a tenth of the smaller, and whether
        a scene that nobody drives has gained energy by now, or lost some to a method that
        damps its springs, or the energy is no number, a line each.

        Energy is looked at when this is called, and compared with the lowest of the calls before
        and of the start of the scene (after an impulse, `restore` and the like: of the first call
        since). `keep_energy_balance` knows more.
        """
        return [
            *self.scene_warnings,
            *(x.text for x in self.stability.check(self.state)),
            *self.overlap_warnings.values(),
            *self._energy_warnings(),
        ]

    @property
    def may_lose_energy(self) -> bool:
        """Whether something may have taken energy that only a balance tells, or none does."""
        braked = any(force.depends_on_velocity() for force in self.scene.forces)
        return braked or self.has_touched

    def words_for_no_energy(self) -> str | None:
        """Say that the energy is no number now, and why; None: it is one."""
        with np.errstate(all='ignore'):
            energy = self.energy()
        if math.isfinite(energy):
            return None
        return words_for_no_energy(energy, time=self.time, singular=self.singular_force())

    def singular_force(self) -> str | None:
        """Say of a force that it has no energy where its bodies are now; None: all have."""
        found = without_energy(self.scene, self.state)
        return None if found is None else f'forces[{found[0]}]: {found[1]}'

    @property
    def has_touched(self) -> bool:
        """Whether bodies have touched since the start or the last restore."""
        return self.has_contact and self.deepest_gap() is not None

    def words_for_loss(self, loss: float, tolerated: float) -> str:
        """Say that the scene has lost energy by now [J], see `diagnostics.energy_balance`."""
        damping = self.stability.damping(self.state)
        return words_for_loss(
            loss,
            tolerated,
            time=self.time,
            integrator=self.integrator.name,
            damping=None if damping is None else damping.text,
        )

    def _energy_warnings(self) -> list[str]:
        """Warn of energy that is no number, that came from nowhere, and of what went there."""
        told = self.words_for_no_energy()
        if told is not None:
            return [told]
        if self._commanded or self.invariants.is_driven:
            return []
        if self._passive is None:
            self._passive = self._begin_passive()
        seen, stored = self._passive
        energies = self._energies()
        seen.look(*energies)
        gain, tolerated = seen.gain, seen.tolerated(*energies)
        if gain <= tolerated:
            loss = seen.highest - seen.change(*energies)
            lost = loss > tolerated and not self.may_lose_energy
            # one look does not tell a loss from a swing of the energy, but for such a method
            lost = lost and self.stability.damping(self.state) is not None
            return [self.words_for_loss(loss, tolerated)] if lost else []
        return [
            words_for_gain(
                gain,
                tolerated,
                time=self.time,
                integrator=self.integrator.name,
                in_springs=self.stored_energy() - stored > NOT_IN_MOTION * gain,
            )
        ]

    def _compare_energy_from_here(self) -> None:
        """Forget the energies before: what follows is another motion."""
        self._passive, self._from_start, self._commanded = None, False, False

    def _begin_passive(self) -> tuple[PassiveEnergy, float]:
        """Begin to look at the energy, where the scene begins if steps alone led here."""
        state = self.state
        if self._from_start:
            state = self._reader.read(*self._stepper.start, 0.0)
        weight = math.hypot(*self.invariants.weight())
        overlap = overlap_energy(weight) if self.has_contact else 0.0
        seen = PassiveEnergy(*self._energies_of(state), overlap=overlap)
        return seen, self.invariants.stored_energy(state)

    @property
    def overlap_warnings(self) -> dict[tuple[int, int], str]:
        """
        The warnings of pairs of bodies (scene indices) that have overlapped by more than a tenth
        of the smaller, since the start or the last restore, with the greatest depth.
        """
        self._settle()
        return self._stepper.overlap_warnings()

    @property
    def scene_warnings(self) -> tuple[str, ...]:
        """Those of the warnings that hold from the start, whatever the state."""
        return (*self._start_warnings, *self._stepper.warnings())

    def deepest_gap(self) -> float | None:
        """
        Smallest gap [m] of two bodies that touched, of all ticks since the start or the last
        restore; negative: they overlapped. None where nothing touched.

        Gaps are those at the start of each tick and, now, of `contacts`; 0 where bodies touched
        and were apart at each of these instants.
        """
        self._settle()
        found = self._stepper.deepest_gap()
        last = float(np.min(self._stepper.contacts().gap, initial=math.inf))
        if found is None:
            return last if last < math.inf else None
        return min(found, last)

    def contacts(self) -> Contacts:
        """
        Where bodies touched in the last tick, and the impulses that acted there; none after
        something that was put back, or a body put elsewhere.
        """
        self._settle()
        return self._stepper.contacts()

    def impacts(self) -> Impacts:
        """
        Impacts at their instants during the last call of `step`, in their order; none but with
        `contact: {mode: event}`, nor after something that was put back, or a body put elsewhere.
        """
        self._settle()
        return self._stepper.impacts(dt_ns=self.dt_ns, start_ns=self._start_ns)

    def contact_wrenches(self) -> tuple[Array, Array]:
        """
        Force [N] and torque [N m] that contacts exerted on each body, as the mean over the last
        tick: `Contacts.wrenches`.

        returns : (n, 3) and (n, 3), scene order, world axes; torques about the centres of mass
        """
        contacts = self.contacts()
        return contacts.wrenches(self.state.position, self.dt)

    def contact_wrench(self, body: str) -> tuple[Array, Array]:
        """Force (3,) [N] and torque (3,) [N m] of `contact_wrenches` on one body."""
        index = self.body_index(body)
        force, torque = self.contact_wrenches()
        return force[index], torque[index]

    def reset(self) -> None:
        """Put every body back to the start of the scene, without commands; time goes on."""
        with self._all_or_nothing():
            self._stepper.reset()
            self._start_ns = self._stepper.tick * self.dt_ns
            self._held.slots = {}
        self._renew_balance()
        if self._watch is not None:
            self._watch.reset(self.tick)

    def _renew_balance(self) -> None:
        if self._ledger is not None:
            self.keep_energy_balance()

    @property
    def next_expiry(self) -> int:
        """First tick on which a held command ends."""
        return self._held.next_expiry()

    @property
    def has_turning_commands(self) -> bool:
        """Whether a command holds in the axes of a body."""
        return self._held.turns

    @property
    def held_slots(self) -> dict[tuple[int, str], Slot]:
        """Commands that hold, by (core index, source): a copy."""
        return self._held.slots

    def body_index(self, body: str) -> int:
        """Index in the scene of a body; InvalidModel for an unknown name."""
        return self._layout.index(body)

    def scene_index(self, core: int) -> int:
        """Index in the scene of the body with a core index."""
        return int(self._layout.moving[core])

    def state_bytes(self) -> bytes:
        """
        Give everything the next tick depends on, but for commands: float64 little endian, core
        order.

        What the integrator remembers follows, if anything, and the impulses of contacts; then the
        start of the scene [ns] as int64: where a wrench depends on time, and after a reset where a
        body is moved as told, there behind a mark.
        """
        self._settle()
        return self._bytes()

    def _bytes(self) -> bytes:
        state = self._layout.state_bytes(self._stepper.translation, self._stepper.rotation)
        state += self._stepper.remembered().astype('<f8').tobytes()
        start = self._start_ns.to_bytes(8, 'little', signed=True)
        if self._stepper.is_timed:
            return state + start
        if self._start_ns and self._reader.is_timed:
            return state + START_MARK + start
        return state

    def restore(
        self,
        *,
        tick: int,
        state: bytes,
        slots: dict[tuple[int, str], Slot],
        of_another: bool = False,
    ) -> None:
        """
        Go on from a tick, a state of `state_bytes` and the commands that held then.

        tick       : that of the state; where its contacts have not been through a tick, the scene
                     begins there, and it goes on as a new simulation does
        of_another : whether another integrator may have had it: what that one remembered is left
                     out where this one remembers nothing

        Raises InvalidModel for a state that is none of this scene, one whose numbers are not
        finite, and a tick before its last reset, or later than time is counted.
        """
        is_whole = isinstance(tick, int | np.integer) and not isinstance(tick, bool)
        if not is_whole or not 0 <= tick <= self._last_tick:
            raise InvalidModel(
                f'restore: tick {shown(tick)}; a whole number from 0 to {self._last_tick}, '
                f'{LONGEST_NS / 1e9:.3g} s, is needed'
            )
        are_slots = isinstance(slots, Mapping) and all(type(s) is Slot for s in slots.values())
        if not are_slots:
            raise InvalidModel(
                f'restore: slots {shown(slots)}; a mapping as `held_slots` gives it is needed'
            )
        if not isinstance(state, bytes | bytearray) or len(state) % 8:
            raise InvalidModel(
                'restore: a state is bytes as `state_bytes` gives them, eight for a number'
            )
        numbers = np.frombuffer(state[: self._layout.state_size], dtype='<f8')
        if not np.isfinite(numbers).all():
            raise InvalidModel(
                f'restore: {np.count_nonzero(~np.isfinite(numbers))} of {len(numbers)} numbers of '
                'the state are not finite; give bytes as `state_bytes` gave them'
            )
        self._go_on_from(int(tick), bytes(state), slots, of_another=of_another)

    def _go_on_from(
        self,
        tick: int,
        state: bytes,
        slots: dict[tuple[int, str], Slot],
        *,
        of_another: bool = False,
    ) -> None:
        """Do what `restore` does; the state may be one that the next tick calls diverged."""
        with self._all_or_nothing():
            size = self._layout.state_size
            rest, self._start_ns = self._split_start(tick, state[size:])
            if of_another and not self.has_contact and self.integrator.remembers is None:
                rest = b''
            self._layout.set_state_bytes(
                state[:size], self._stepper.translation, self._stepper.rotation
            )
            try:
                self._stepper.recall(np.frombuffer(rest, dtype='<f8'))
            except (ValueError, IndexError, OverflowError) as error:
                raise InvalidModel(f'the state does not fit this scene: {error}') from error
            if self._begins:
                self._start_ns = tick * self._dt_ns
            self._stepper.tick = tick
            self._held.slots = slots
        self._renew_balance()
        if self._watch is not None:
            self._watch.resume(tick)

    @property
    def _begins(self) -> bool:
        """Whether no tick was done since the start of a scene with contact that tells none."""
        tells = self._stepper.is_timed or self._reader.is_timed
        return self.has_contact and not tells and self._stepper.contact.memory.is_new

    def _split_start(self, tick: int, rest: bytes) -> tuple[bytes, int]:
        """Split what follows the motion in a state into what is remembered and the start [ns]."""
        start = 0
        if self._stepper.is_timed:
            if len(rest) < 8:
                raise InvalidModel(
                    'restore: a state that does not tell when its scene began, on which what acts '
                    'here depends; give the whole of what `state_bytes` gave'
                )
            rest, start = rest[:-8], int.from_bytes(rest[-8:], 'little', signed=True)
        elif rest[-16:-8] == START_MARK:
            rest, start = rest[:-16], int.from_bytes(rest[-8:], 'little', signed=True)
        if not 0 <= start <= tick * self._dt_ns:
            raise InvalidModel(
                f'restore: tick {tick} at {tick * self._dt_ns * 1e-9:g} s, and a state whose '
                f'scene began at {start * 1e-9:g} s, its last reset; allowed: ticks from there '
                'on; give the tick that the state had'
            )
        return rest, start

    @property
    def steps_taken(self) -> float:
        """Steps that an integrator which chooses them tried so far; 0 with any other."""
        return self._stepper.steps_taken


def _whole(ticks: object) -> int:
    """Return a number of ticks; InvalidModel unless it is whole and at least 0."""
    try:
        is_number = not isinstance(ticks, bool)
        count = operator.index(ticks) if is_number else -1  # type: ignore[arg-type]  # which it tells
    except TypeError:
        count = -1
    if count < 0:
        raise InvalidModel(
            f'step: {shown(ticks)} ticks; allowed: a whole number of at least 0; to advance '
            'by seconds, step(round(seconds / sim.dt))'
        )
    return count


def _pilot(
    scene: Scene, dt_ns: int, integrator: str, options: Mapping[str, Any], ticks: Sequence[int]
) -> Iterator[choose.Instant]:
    """Run the beginning of a scene for `auto`, up to where it diverges."""
    simulation = Simulation(
        scene, integrator=integrator, integrator_options=options, dt=dt_ns / 1e9
    )
    start = simulation.stability.check(simulation.state)
    beyond = any(violation.kind != 'rotation' for violation in start)
    for tick in ticks:
        try:
            simulation.step(tick - simulation.tick)
        except SimulationDiverged:
            return
        yield choose.Instant(simulation.state, simulation.steps_taken, beyond)


def _fastest_rate(scene: Scene) -> float:
    """Largest rate of the springs and dampers of a scene at its start [1/s]."""
    start = Simulation(scene, integrator='rk4')
    rates = start.stability.rates(start.state)
    return max(float(np.max(rates[kind], initial=0.0)) for kind in ('oscillation', 'relaxation'))
