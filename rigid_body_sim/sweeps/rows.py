# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From runs of a sweep to rows of its table: here the physics is run.

    run, status, reason, warnings, ticks, time    of every run
    a column for each number that was varied
    last states, extremes, energy balance         as far as the run came

status: done; refused (what was varied makes no scene); diverged (the row holds the last good
state); failed (neither scene nor physics is to blame; `reason` tells). Where a run stands, alone
or in a pack, and which process made it, changes no bit of its row.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.forces.at_start import start_warnings
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.physics.state.snapshot import State
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene
from rigid_body_sim.sweeps import DIVERGED, DONE, FAILED, REFUSED, packs
from rigid_body_sim.sweeps.looks import (
    Looks,
    QuietEnergies,
    energy_columns,
    energy_warning,
    look_ticks,
)
from rigid_body_sim.sweeps.plan import LOOKS, Sweep, code_digest

MOST_TICKS = 2**40  # [-] of a run: years of work
MOST_EVICTED = 8  # [-] runs taken out of a pack one by one; then it costs less to make all alone
NEAR = 1e-6  # [-] of a duration: rounded by less to whole ticks it is not worth a word
MOST_WARNINGS = 8  # [-] lines in one row

Row = dict[str, Any]
Saw = Callable[[float], None]  # is told what share of the work is done


class Pack:
    """
    Runs side by side in one simulation, or one alone: where it may be packed, and not.

    runs   : their numbers
    scenes : their scenes
    """

    def __init__(self, sweep: Sweep, runs: Sequence[int], scenes: Sequence[Scene]) -> None:
        self.sweep = sweep
        self.runs, self.scenes = list(runs), list(scenes)
        self.simulation = self._simulation()
        self.is_quiet = packs.pack_key(scenes[0], energy=True) is not None
        self.ticks, self.every = _ticks(sweep, self.simulation.dt_ns)
        self._rounded = _rounding(sweep, self.ticks, self.simulation.dt)
        self.looks = Looks(scenes[0], sweep.bodies, len(self.runs))
        self.energies: QuietEnergies | None = None
        self.evicted: list[int] = []
        self._warned: list[dict[str, set[int]]] = [{} for _ in self.runs]
        self._told: list[list[str]] = [[] for _ in self.runs]

    def _simulation(self) -> Simulation:
        if len(self.scenes) == 1:
            return simulation_of(self.scenes[0])
        return Simulation(packs.packed_scene(self.scenes))

    def _values(self) -> NDArray[np.float64]:
        values = self.simulation.state.values
        return values.reshape(len(self.runs), -1, values.shape[1])

    def run(self, saw: Saw) -> None:
        """Make the runs; who diverges in a pack is evicted, alone it raises SimulationDiverged."""
        simulation, keeps_energy = self.simulation, 'energy' in self.sweep.keep
        with _compiling_alone():
            simulation.prepare()
            if keeps_energy and not self.is_quiet:
                simulation.keep_energy_balance()
        if keeps_energy and self.is_quiet:
            self.energies = QuietEnergies(self.scenes, self._values())
        self._look()
        for tick in look_ticks(self.ticks, self.every):
            if not self._advance_to(tick):
                return
            self._look()
            saw(tick / self.ticks)

    def _advance_to(self, tick: int) -> bool:
        """Advance; whether anybody is left."""
        while self.simulation.tick < tick:
            try:
                self.simulation.step(tick - self.simulation.tick)
            except SimulationDiverged as diverged:
                if len(self.runs) == 1:
                    raise
                name = diverged.body
                self._evict(self.simulation.body_index(name) // len(self.scenes[0].bodies))
                if len(self.evicted) > MOST_EVICTED or len(self.runs) == 1:
                    self.evicted += self.runs
                    self.runs = []
                    return False
        return True

    def _evict(self, place: int) -> None:
        """Go on without one of the runs, from where the others stand."""
        stays = np.arange(len(self.runs)) != place
        old = self.simulation
        self.evicted.append(self.runs[place])
        for name in ('runs', 'scenes', '_warned', '_told'):
            kept = getattr(self, name)
            setattr(self, name, [kept[i] for i in np.flatnonzero(stays)])
        state = packs.state_of_some(old.state_bytes(), stays, self.scenes[0])
        self.simulation = Simulation(packs.packed_scene(self.scenes))
        self.simulation.restore(tick=old.tick, state=state, slots={})
        self.looks.without(stays)
        if self.energies is not None:
            self.energies.without(stays)

    def _look(self) -> None:
        values, simulation = self._values(), self.simulation
        self.looks.look(values)
        if self.looks.meets:
            self.looks.look_at_contacts(simulation)
        if self.energies is not None:
            self.energies.look(values)
        elif 'energy' in self.sweep.keep:
            simulation.look_at_energy()
        size = len(self.scenes[0].bodies)
        said: dict[str, set[int]] = {}
        for run, kinds in enumerate(self._warned):
            for kind, bodies in kinds.items():
                said.setdefault(kind, set()).update(run * size + body for body in bodies)
        for violation in simulation.stability.check(simulation.state, said):
            for run in sorted({body // size for body in violation.bodies}):
                self._warn_of_limits(run, values[run])

    def _warn_of_limits(self, run: int, values: NDArray[np.float64]) -> None:
        """Say where a run is beyond a limit of its method, as a run alone does."""
        simulation, scene = self.simulation, self.scenes[run]
        watch = simulation.stability
        if len(self.scenes) > 1:
            watch = type(watch)(scene, Layout(scene), simulation.integrator, simulation.dt)
        state = simulation.state if len(self.scenes) == 1 else State(values.copy())
        for violation in watch.check(state, self._warned[run]):
            self._warned[run].setdefault(violation.kind, set()).update(violation.bodies)
            self._told[run].append(violation.text)

    def rows(self) -> Iterator[Row]:
        """Give what the rows of the runs hold beside what was varied."""
        simulation, energies = self.simulation, self.energies
        if not self.runs:
            return
        balances: list[Any] = [None] * len(self.runs)
        values = self._values()
        if energies is not None:
            balances = list(energies.balances(values))
        elif 'energy' in self.sweep.keep:
            balances = [simulation.energy_balance()]
        self.looks.values = values
        packed = len(self.runs) > 1
        always = () if packed else simulation.scene_warnings
        always = (*always, *simulation.overlap_warnings.values())
        for place, run in enumerate(self.runs):
            balance = balances[place]
            of_start = start_warnings(self.scenes[place]) if packed else ()
            told = [*self._rounded, *of_start, *always, *self._told[place]]
            if balance is not None:
                touched = simulation.has_touched
                said = energy_warning(balance, simulation.integrator, touched=touched)
                told += [said] if said else []
            chosen = {}
            if simulation.choices:
                chosen['chosen_integrator'] = simulation.integrator.name
            yield {
                'run': run,
                'status': DONE,
                'reason': None,
                'warnings': _lines(told),
                'ticks': simulation.tick,
                'time': simulation.time,
                **chosen,
                **self.looks.columns(self.sweep.keep, place),
                **(energy_columns(balance) if balance is not None else {}),
            }


def _lines(told: Sequence[str]) -> str | None:
    if not told:
        return None
    more = len(told) - MOST_WARNINGS
    return '\n'.join([*told[:MOST_WARNINGS], *([f'… {more} more'] if more > 0 else [])])


def _ticks(sweep: Sweep, dt_ns: int) -> tuple[int, int]:
    """Give the ticks of a run and between its looks; UserError if there is none, or no end."""
    ticks = round(sweep.duration * 1e9 / dt_ns)
    if not 1 <= ticks <= MOST_TICKS:
        raise UserError(
            f'duration {sweep.duration:g} s is {ticks} ticks of {dt_ns * 1e-9:g} s; allowed: 1 to '
            '2^40'
        )
    every = sweep.duration / LOOKS if sweep.every is None else sweep.every
    return ticks, max(1, round(every * 1e9 / dt_ns))


def _rounding(sweep: Sweep, ticks: int, dt: float) -> list[str]:
    """Say where a duration is no whole number of ticks [s]."""
    if abs(ticks * dt - sweep.duration) <= NEAR * sweep.duration:
        return []
    return [
        f'duration {sweep.duration:g} s is no whole number of ticks of {dt:g} s; the run takes '
        f'{ticks} of them, {ticks * dt:.9g} s'
    ]


def _notes_of(sweep: Sweep, rows: Sequence[Row]) -> list[str]:
    """Say once what is told in rows of what was asked for all of them."""
    ends = [row['time'] for row in rows if row['status'] == DONE]
    if all(abs(end - sweep.duration) <= NEAR * sweep.duration for end in ends):
        return []
    return [
        f'the duration of {sweep.duration:g} s is no whole number of ticks in some runs, which '
        'take the nearest: see `time` and `warnings` of their rows'
    ]


@contextmanager
def _compiling_alone() -> Iterator[None]:
    """
    Let one process of this machine compile at a time, so that the others find its kernels.
    """
    if kernels.CACHE is None:
        yield
        return
    try:
        lock = os.open(Path(kernels.CACHE) / 'compiling.lock', os.O_CREAT | os.O_RDWR, 0o600)
    except OSError:  # a cache that is full or gone: each compiles for itself
        yield
        return
    try:
        with suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def rows_of(
    sweep: Sweep,
    runs: Sequence[int],
    *,
    saw: Saw = lambda _share: None,
    pack: bool = True,
) -> tuple[list[Row], list[str]]:
    """
    Make runs; give their rows, in the order of `runs`, and notes on what went otherwise.

    saw  : called with the share of the work that is done
    pack : whether runs may share a simulation
    """
    if sweep.code != code_digest():
        raise RunError(
            'a worker runs another version of this package than the one that asked it; install '
            'the same one everywhere, or there are no equal bits'
        )
    found, notes = {}, []
    scenes: dict[int, Scene] = {}
    read = sweep.reader()
    values = {}
    for run in runs:
        try:
            values[run] = sweep.values(run)
            scenes[run] = read(values[run])
        except (UserError, InvalidModel) as error:
            found[run] = _failed(run, REFUSED, str(error))
        except Exception as error:  # a run that fails is a row, whatever it fails of
            found[run] = _failed(run, FAILED, _told_of(error))
    in_order = list(scenes)
    keys = [
        packs.pack_key(scenes[run], energy='energy' in sweep.keep) if pack else None
        for run in in_order
    ]
    groups, alone = packs.runs_in_packs(keys, list(scenes.values()))
    count, done = len(in_order), 0
    jobs = [[in_order[i] for i in group] for group in groups] + [[in_order[i]] for i in alone]
    for job in jobs:
        told = partial(_share, saw, done / count, len(job) / count)
        rows, more = _rows_of_job(sweep, job, [scenes[run] for run in job], told)
        found |= {row['run']: row for row in rows}
        notes += more
        done += len(job)
    made = [_with_varied(sweep, found[run], values.get(run)) for run in runs]
    return made, [*notes, *_notes_of(sweep, made)]


def _share(saw: Saw, begin: float, part: float, share: float) -> None:
    saw(begin + part * share)


def _rows_of_job(
    sweep: Sweep, runs: list[int], scenes: list[Scene], saw: Saw
) -> tuple[list[Row], list[str]]:
    """Make runs that may stand side by side; who cannot, or diverges, is made alone."""
    if len(runs) == 1:
        return [_row_alone(sweep, runs[0], scenes[0], saw)], []
    alone = list(runs)
    rows: list[Row] = []
    notes: list[str] = []
    try:
        pack = Pack(sweep, runs, scenes)
        pack.run(saw)
        rows = list(pack.rows())
    except Exception:  # one of them is to blame: alone they tell which
        pack = None
    if pack is not None and rows:
        check = rows[-1]
        again = _row_alone(sweep, check['run'], scenes[runs.index(check['run'])], saw)
        if same_bits(check, again):
            alone = pack.evicted
        else:
            rows = []
            notes.append(
                f'run {check["run"]} came out otherwise alone than beside others; its pack was '
                'made again one by one (please report this scene)'
            )
    rows += [_row_alone(sweep, run, scenes[runs.index(run)], saw) for run in alone]
    return rows, notes


def same_bits(one: Row, other: Row) -> bool:
    """Whether two rows are the same to the bit; NaN is NaN."""
    return _bits(one) == _bits(other)


def _bits(row: Row) -> list[tuple[str, Any]]:
    return [(k, v.hex() if isinstance(v, float) else v) for k, v in row.items()]


def _row_alone(sweep: Sweep, run: int, scene: Scene, saw: Saw) -> Row:
    """Make one run in a simulation of its own."""
    pack = None
    try:
        pack = Pack(sweep, [run], [scene])
        pack.run(saw)
        return next(pack.rows())
    except SimulationDiverged as diverged:
        assert pack is not None
        return {**next(pack.rows()), 'status': DIVERGED, 'reason': str(diverged)}
    except (UserError, InvalidModel) as error:
        return _failed(run, REFUSED, _placed(sweep, run, error))
    except Exception as error:  # a run that fails is a row, whatever it fails of
        return _failed(run, FAILED, _told_of(error))


def _placed(sweep: Sweep, run: int, error: Exception) -> str:
    """Tell a refusal of the physics with its place in the scene."""
    if isinstance(error, UserError):
        return str(error)
    try:
        title = sweep.name
        simulation_of(load_scene(sweep.text(run), files=sweep.files, title=title))
    except (UserError, InvalidModel) as placed:
        return str(placed)
    return str(error)


def _told_of(error: BaseException) -> str:
    return f'{type(error).__name__}: {" ".join(str(error).split())}'


def _failed(run: int, status: str, reason: str) -> Row:
    return {
        'run': run,
        'status': status,
        'reason': reason,
        'warnings': None,
        'ticks': 0,
        'time': 0.0,
    }


def failed_row(sweep: Sweep, run: int, reason: str) -> Row:
    """Make the row of a run that brought its process down."""
    return _with_varied(sweep, _failed(run, FAILED, reason), None)


FIRST = ('run', 'status', 'reason', 'warnings', 'ticks', 'time')


def _with_varied(sweep: Sweep, row: Row, values: Sequence[Any] | None) -> Row:
    """Put what was varied behind the first columns."""
    if values is None:
        try:
            values = sweep.values(row['run'])
        except UserError:
            values = [None] * len(sweep.axes)
    columns = sweep.varied_columns(values)
    first = {name: row[name] for name in FIRST}
    return {**first, **columns, **{k: v for k, v in row.items() if k not in first}}
