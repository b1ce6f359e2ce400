# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One stretch of a simulation, kept as it goes: every so many ticks a row, and a controller asked.

    controller(t, state) -> {'box': Wrench(…), …} or None

It is asked at t = 0 (where the stretch begins) and every `every` seconds, but not at the end: that
answer would never act. What it answers is all that it asks for: held until it is asked again. A
body that its answer does not name gets nothing from it any more, and None names none; after the
stretch nothing of it holds. On a body (and in a frame) that it names it takes the place of what
`set_wrench` held; what else is held stays.

A body may get several wrenches at once, in frames of its own: `{'craft': [Wrench(…, frame='left'),
Wrench(…, frame='right')]}`.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.library.energy_warnings import energy_warning
from rigid_body_sim.library.run import WHOLE, Origin, Run
from rigid_body_sim.physics.errors import InvalidModel, SimulationBusy, SimulationDiverged
from rigid_body_sim.physics.model.named_frames import RESERVED_FRAMES, SEPARATOR
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.physics.model.tick_length import whole_ticks
from rigid_body_sim.physics.state.impacts import Impacts, joined
from rigid_body_sim.physics.state.snapshot import COLUMNS, State
from rigid_body_sim.runs.wrench import Wrench

if TYPE_CHECKING:
    from rigid_body_sim.physics.simulation import Simulation

Array = NDArray[np.float64]
Answer = Mapping[str, Wrench | Sequence[Wrench]] | None
Controller = Callable[[float, State], Answer]

USUAL = 10_000_000  # [ns] between rows unless somebody says otherwise
LOOKS = 256  # at the limits of the integrator over a run: cheap beside it
MOST_BYTES = 64 << 30  # [bytes] of arrays that a run may ask for


class RunWarning(UserWarning):
    """What a user should know of a run that came back; also in `Run.warnings`."""


class Stretch:
    """
    What is kept of a simulation while it goes on.

    simulation : stands where the stretch begins
    ticks      : to be done
    per        : [tick] between rows
    """

    def __init__(self, simulation: Simulation, ticks: int, per: int) -> None:
        self.simulation = simulation
        self._first, self._last, self._per = simulation.tick, simulation.tick + ticks, per
        self._choices = len(simulation.choices)
        self._start = simulation.__getstate__()
        simulation.prepare()
        self._begun = time.process_time()  # what is compiled once is not of the run
        count, bodies = ticks // per + 1, len(simulation.scene.bodies)
        self._values = _room((count, bodies, COLUMNS))
        self._wrench = _room((2, count, bodies, 3))
        self._masses: Array | None = None
        self._rows = 0
        self._commands: list[Any] = []
        self._is_controlled = False
        self._impacts: list[Impacts] = []
        self._asked: dict[tuple[str, str], str] = {}  # (body, slot) -> frame
        self._index = {body.name: i for i, body in enumerate(simulation.scene.bodies)}
        self.warnings: list[str] = list(simulation.scene_warnings)
        self._warned: dict[str, set[int]] = {}

    def follow(self, controller: Controller | None, on_row: Callable[[int], None]) -> None:
        """Advance to the end; `on_row` is called with the ticks done after each row."""
        simulation, per = self.simulation, self._per
        self._is_controlled = controller is not None
        applied = np.array(simulation.applied_wrench())
        self._keep(simulation.state, applied)
        look_every = max(1, len(self._values) // LOOKS)
        while simulation.tick < self._last:
            begin = self._first + (self._rows - 1) * per
            stop = min(begin + per, self._last)
            self._need(begin)
            before = None
            if controller is not None or simulation.next_expiry <= begin:
                before = simulation.held_slots
                if controller is not None:
                    self._ask(controller)
            if before is not None or simulation.has_turning_commands:
                applied = np.array(simulation.applied_wrench())
            if before is not None:
                self._note(self._changed(before), applied)
            if per == 1:
                self._wrench[:, self._rows - 1] = applied
            applied = self._advance(stop, applied)
            self._need(stop)
            if stop - begin == per:
                self._keep(simulation.state, applied)
                on_row(stop - self._first)
                if self._rows % look_every == 0:
                    self._look()
        self._look()

    def _need(self, tick: int) -> None:
        """Refuse to go on where somebody else moved the simulation: its rows would lie."""
        if self.simulation.tick != tick:
            raise InvalidModel(
                f'run at {self.simulation.time:g} s: another thread moved the simulation; give '
                'each thread a Simulation of its own'
            )

    def _advance(self, stop: int, applied: Array) -> Array:
        """Advance to a tick; give the wrenches of the last one before it."""
        simulation = self.simulation
        ticks = stop - simulation.tick
        ends_between = simulation.next_expiry < stop
        if ticks > 1 and (ends_between or simulation.has_turning_commands):
            simulation.step(ticks - 1)
            self._impacts.append(simulation.impacts())
            applied = np.array(simulation.applied_wrench())
            ticks = 1
        simulation.step(ticks)
        self._impacts.append(simulation.impacts())
        return applied

    def _keep(self, state: State, applied: Array) -> None:
        row = self._rows
        self._values[row] = state.values
        self._wrench[:, row] = applied
        if state.masses is not None:
            if self._masses is None:
                self._masses = _room(self._values.shape[:2])
            self._masses[row] = state.masses
        self._rows = row + 1  # last: an interrupt before it leaves the row out

    def _note(self, changed: list[int], applied: Array) -> None:
        """Put the wrenches of bodies that are asked for something new into the present row."""
        self._wrench[:, self._rows - 1, changed] = applied[:, changed]

    def _changed(self, before: Mapping[tuple[int, str], Any]) -> list[int]:
        """Find the bodies of which something else is asked than before."""
        simulation, now = self.simulation, self.simulation.held_slots
        changed = {
            simulation.scene_index(key[0])
            for key in before.keys() | now.keys()
            if _asked(before.get(key)) != _asked(now.get(key))
        }
        return sorted(changed)

    def _ask(self, controller: Controller) -> None:
        """Ask the controller, and hold what it answers in place of what it answered before."""
        simulation = self.simulation
        tick, time = simulation.tick, simulation.time
        answer = controller(time, simulation.state)
        if simulation.tick != tick:
            raise InvalidModel(
                f'controller at {time:g} s: it moved the simulation that asks it; step a copy '
                '(copy.copy(sim)) to look ahead'
            )
        said = f'controller at {time:g} s'
        asked = {}
        for body, wrench in _wrenches(answer, said):
            key = body, _slot(body, wrench.frame)
            if key in asked:
                raise InvalidModel(
                    f'{said}: two wrenches on {body!r} in the frame {wrench.frame!r}; add them'
                )
            asked[key] = wrench
        for key, frame in list(self._asked.items()):
            if key not in asked:
                self._give(key, Wrench(frame=frame), said)
                del self._asked[key]
        for key, wrench in asked.items():
            if key not in self._asked:
                self._warn_of_what_was_held(key)
            self._asked[key] = wrench.frame
            self._give(key, wrench, said)

    def _give(self, key: tuple[str, str], wrench: Wrench, said: str) -> None:
        body, simulation = key[0], self.simulation
        try:
            simulation.hold(
                body, 'wrench', force=wrench.force, torque=wrench.torque, frame=wrench.frame
            )
        except InvalidModel as error:
            raise InvalidModel(f'{said}: {error}') from None
        force, torque = (tuple(map(float, vector)) for vector in (wrench.force, wrench.torque))
        self._commands.append((simulation.tick, body, force, torque, wrench.frame))

    def _warn_of_what_was_held(self, key: tuple[str, str]) -> None:
        body, slot = key
        core = {self.simulation.scene_index(c): c for c, _ in self.simulation.held_slots}
        at = core.get(self._index.get(body, -1))
        if at is not None and (at, slot) in self.simulation.held_slots:
            self.warnings.append(
                f'the controller took the place of the wrench that set_wrench held on {body!r}'
            )

    def let_go(self) -> None:
        """Hold nothing of the controller any more."""
        for (body, _), frame in self._asked.items():
            with suppress(InvalidModel):  # it was refused when it was asked for
                self.simulation.hold(body, 'wrench', frame=frame)
        self._asked.clear()

    def _look(self) -> None:
        """Look where the run is beyond a limit of its integrator."""
        simulation = self.simulation
        for violation in simulation.stability.check(simulation.state, self._warned):
            self._warned.setdefault(violation.kind, set()).update(violation.bodies)
            self.warnings.append(violation.text)

    def _warn_of_energy(self) -> None:
        """Look whether the method brought energy in or took it, where nothing else could."""
        simulation, rows = self.simulation, self._rows
        no_number = simulation.words_for_no_energy()
        if no_number is not None:
            self.warnings.append(no_number)
            return
        if self._is_controlled or np.any(self._wrench[:, :rows]):
            return
        times: Array = np.multiply(self._first + self._per * np.arange(rows), simulation.dt)
        masses = None if self._masses is None else self._masses[:rows]
        told = energy_warning(simulation, times, self._values[:rows], masses)
        if told is not None:
            self.warnings.append(told)

    def run(self, end_reason: str, problem: str = '') -> Run:
        """Give what was reached."""
        simulation, rows = self.simulation, self._rows
        self._warn_of_energy()
        self.warnings += simulation.overlap_warnings.values()
        per, dt_ns = self._per, simulation.dt_ns
        ticks = self._first + per * np.arange(rows, dtype=np.int64)
        end = min(simulation.tick, self._last)
        if end_reason == WHOLE and rows and ticks[-1] != end:
            self.warnings.append(
                f'the run ends at {end * dt_ns * 1e-9:g} s and its last row is that of '
                f'{ticks[-1] * dt_ns * 1e-9:g} s: rows are {per * dt_ns * 1e-9:g} s apart (every)'
            )
        whole = rows == len(self._values)
        return Run(
            names=tuple(self._index),
            time=np.divide(ticks * dt_ns, 1e9),
            scene=simulation.scene,
            integrator=self._start['integrator'],
            dt=simulation.dt,
            end_reason=end_reason,
            end_time=end * dt_ns / 1e9,
            problem=problem,
            warnings=tuple(dict.fromkeys(self.warnings)),
            impacts=joined(self._impacts),
            _values=self._values if whole else self._values[:rows].copy(),
            _wrench=self._wrench if whole else self._wrench[:, :rows].copy(),
            _masses=None if self._masses is None else self._masses[:rows].copy(),
            _ticks=(self._first, end, per),
            _origin=Origin(
                self._start,
                [command for command in self._commands if command[0] < end],
                simulation.choices[self._choices :],
                simulation.state_bytes(),
            ),
            _cost=time.process_time() - self._begun,
        )


def follow(
    simulation: Simulation,
    duration: float,
    *,
    every: float | None,
    controller: Controller | None,
    progress: bool,
) -> Run:
    """Run a simulation from where it stands: see `library.simulation.Simulation.run`."""
    dt_ns = simulation.dt_ns
    ticks = whole_ticks(duration, dt_ns, what='duration')
    per = usual_every(ticks, dt_ns) if every is None else whole_ticks(every, dt_ns, what='every')
    if per < 1:
        raise InvalidModel(f'every: {every} s; allowed: one tick of {dt_ns * 1e-9:g} s and more')
    if controller is not None and not callable(controller):
        raise InvalidModel(
            f'controller: got {shown(controller)}; a function f(t, state) is needed'
        )
    stretch = Stretch(simulation, ticks, per)
    if simulation.__dict__.setdefault('_stretch', stretch) is not stretch:
        raise SimulationBusy
    try:
        with _Bar(ticks, shown=progress) as bar:
            stretch.follow(controller, bar.show)
        run = stretch.run(WHOLE)
    except SimulationDiverged as error:
        run = stretch.run('diverged', str(error))
        warnings.warn(f'{error}; the run holds what came before', RunWarning, stacklevel=3)
    except BaseException as error:
        reason = 'error' if isinstance(error, Exception) else 'stopped'
        with suppress(Exception):  # what it raises says more than what could be kept
            text = f'{type(error).__name__}: {error}'.rstrip(': ')
            error.run = stretch.run(reason, text)  # type: ignore[attr-defined]
        raise
    finally:
        stretch.let_go()
        del simulation.__dict__['_stretch']
    for text in run.warnings:
        warnings.warn(text, RunWarning, stacklevel=3)
    return run


def usual_every(ticks: int, dt_ns: int) -> int:
    """Count the ticks between rows, about USUAL, so that the last row is that of the end."""
    most = max(1, USUAL // dt_ns)
    least = max(1, most // 2)  # of ticks of 4 ms one, or half of all durations end beside a row
    return next((per for per in range(most, least - 1, -1) if ticks % per == 0), most)


def _wrenches(answer: Any, said: str) -> Iterable[tuple[str, Wrench]]:
    """Yield body and wrench of an answer; InvalidModel for what is none."""
    if answer is None:
        return
    if not isinstance(answer, Mapping):
        raise InvalidModel(
            f"{said}: it answered {shown(answer)}; allowed: a mapping such as {{'box': "
            'Wrench(force=(1, 0, 0))}, or None'
        )
    for body, given in answer.items():
        several = given if isinstance(given, list | tuple) else (given,)
        for wrench in several:
            if not isinstance(wrench, Wrench):
                raise InvalidModel(
                    f'{said}: it answered {shown(given)} for {shown(body)}; allowed: a Wrench, or '
                    'a list of them'
                )
            yield body, wrench


def _slot(body: str, frame: Any) -> str:
    """Name the slot in which a wrench is held, as `held_wrenches` does."""
    if not isinstance(frame, str) or frame in RESERVED_FRAMES:
        return 'wrench'
    return f'wrench{SEPARATOR}{frame.removeprefix(f"{body}/")}'


def _asked(slot: Any) -> object:
    """What a held command asks for, without how long."""
    return None if slot is None else (slot.force, slot.torque, slot.turns_with_body)


def _room(shape: tuple[int, ...]) -> Array:
    """Make room for an array; InvalidModel where the memory has none."""
    size = 8 * int(np.prod(shape, dtype=object))
    try:
        if size > MOST_BYTES:
            raise MemoryError
        return np.empty(shape)
    except MemoryError:
        raise InvalidModel(
            f'{shape[-3 if len(shape) > 2 else 0]} rows of this scene are '
            f'{size / 1e9:.1f} GB; take a longer every, or a shorter duration'
        ) from None


class _Bar:
    """A bar of progress on a terminal, or nothing."""

    def __init__(self, ticks: int, *, shown: bool) -> None:
        self._bar: Any = None
        if shown:
            from tqdm import tqdm

            self._bar = tqdm(total=ticks, unit='tick', unit_scale=True, leave=False)

    def show(self, done: int) -> None:
        """Show how many ticks are done."""
        if self._bar is not None:
            self._bar.update(done - self._bar.n)

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_exception: object) -> None:
        if self._bar is not None:
            self._bar.close()
