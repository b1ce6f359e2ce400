# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A sweep from its plan to its table: hands out stretches of runs, keeps rows, asks again where a
process died.

How long a stretch is depends on how fast runs go here; no bit of a row does. A task whose process
dies is given out once more, then in halves, so that the run to blame is found; it becomes a row
with the reason.
"""

from __future__ import annotations

import math
import os
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import UserError
from rigid_body_sim.missing_packages import missing
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.sweeps import DONE, GROUPS, packs, table
from rigid_body_sim.sweeps.executors import Answer, Executor, Here, Processes, Task
from rigid_body_sim.sweeps.formats import format_of
from rigid_body_sim.sweeps.nursery import Nursery
from rigid_body_sim.sweeps.parts import Parts
from rigid_body_sim.sweeps.plan import Sweep, plan_sweep
from rigid_body_sim.sweeps.rows import Row, failed_row, rows_of

LASTS = 2.0  # [s] of a task: what is lost at most when a process is killed
FIRST_PACK = 256  # [-] runs of the first task where they share a simulation
LARGEST_PACK, LARGEST = 1024, 256  # [-] runs of a task, side by side and one by one
LOOKED_AT = 4  # [-] first runs that tell whether runs share a simulation
WORTH_PROCESSES = 3.0  # [s] of work that is left: to start two costs about that, and helps by half
WAITS = 0.5  # [s] for an answer, then it is looked whether more could work
TRIES = 2  # [-] of a task whose process dies; then it is halved
MOST_WORKERS = 1024
MOST_REASONS = 1000  # [-] that are counted apart

Progress = Callable[[float, int], None]  # runs done so far, and all


class Outcome:
    """
    What came of a sweep, for the line that says so.

    made    : runs that were made now
    failed  : of them, those that did not come to their end
    ends    : how often each status was theirs: refused, diverged, failed
    reasons : how often each reason was given
    notes   : on what went otherwise than it should
    before  : the same of runs that an earlier process made; None: there was none
    """

    def __init__(self, before: Outcome | None = None) -> None:
        self.made = 0
        self.ends: Counter[str] = Counter()
        self.reasons: dict[str, int] = {}
        self.notes: list[str] = []
        self.before = before

    @property
    def failed(self) -> int:
        """How many of the runs did not come to their end."""
        return self.ends.total()

    def take(self, rows: Sequence[Row], notes: Sequence[str]) -> None:
        """Count what rows tell."""
        self.made += len(rows)
        for row in rows:
            if row['status'] != DONE:
                self.ends[str(row['status'])] += 1
                if row['reason'] in self.reasons or len(self.reasons) < MOST_REASONS:
                    reason = str(row['reason'])
                    self.reasons[reason] = self.reasons.get(reason, 0) + 1
        self.notes += [note for note in notes if note not in self.notes]


def need(package: str) -> None:
    """Refuse to begin without an optional package; UserError that says how to come by it."""
    if find_spec(package) is None:
        raise UserError(missing(package))


def cores() -> int:
    """Count the cores that this process may use."""
    return len(os.sched_getaffinity(0))


def make_executor(
    sweep: Sweep,
    *,
    workers: int,
    scheduler: str | None,
    saw: Callable[[float], None],
    nursery: Nursery | None = None,
) -> Executor:
    """Choose who makes the runs; nursery: where workers come from, if it has been started."""
    if scheduler is not None:
        need('distributed')
        from rigid_body_sim.sweeps.cluster import Cluster

        return Cluster(sweep, scheduler)
    return Here(sweep, saw) if workers == 1 else Processes(sweep, workers, saw, nursery)


def run_all(
    sweep: Sweep,
    missing: Sequence[Task],
    keep: Callable[[list[Row]], None],
    *,
    workers: int,
    scheduler: str | None = None,
    progress: Progress = lambda _done, _runs: None,
    nursery: Nursery | None = None,
) -> Outcome:
    """
    Make all runs that are missing.

    keep : is given rows of runs that follow each other, in any order of these stretches
    """
    done = sweep.runs - sum(end - first for first, end in missing)
    progress(done, sweep.runs)
    if not missing:
        return Outcome()
    work = _Work(sweep, missing, keep, done=done, workers=workers)

    def saw(under_way: float) -> None:
        progress(work.done + under_way, sweep.runs)

    here = workers == 1 or work.packs  # side by side most sweeps are done before processes start
    count = 1 if here else workers
    executor = make_executor(sweep, workers=count, scheduler=scheduler, saw=saw, nursery=nursery)

    def hand_out() -> None:
        while (size := work.size()) and executor.wants(work.seconds_left()):
            executor.submit(work.next_task(size))

    try:
        while work.is_left:
            if isinstance(executor, Here) and workers > 1 and work.is_long:
                executor = Processes(sweep, workers, saw, nursery)
            hand_out()
            made = [(answer, work.take(answer)) for answer in executor.wait(WAITS)]
            if not isinstance(executor, Here):
                hand_out()  # nobody waits for the disk
            for answer, rows in made:
                work.keep(rows, answer.notes)
            progress(work.done + executor.under_way(), sweep.runs)
    finally:
        executor.close()
    return work.outcome


class _Work:
    """What is still to do, what is under way, and how long a run takes."""

    def __init__(
        self,
        sweep: Sweep,
        missing: Sequence[Task],
        keep: Callable[[list[Row]], None],
        *,
        done: int,
        workers: int,
    ) -> None:
        self._sweep, self._keep, self._workers = sweep, keep, workers
        self.done, self.outcome = done, Outcome()
        self._stretches = deque(missing)
        self._again: deque[Task] = deque()
        self._tries: dict[Task, int] = {}
        self._begun: dict[Task, float] = {}
        self._pace = math.nan  # [s] for a run
        self._answers = 0
        self.packs = _share_simulations(sweep, missing)

    @property
    def _waiting(self) -> int:
        """Count the runs that nobody has."""
        stretches = (*self._stretches, *self._again)
        return sum(end - first for first, end in stretches)

    @property
    def is_left(self) -> bool:
        """Whether anything is to do, or under way."""
        return bool(self._stretches or self._again or self._begun)

    @property
    def is_long(self) -> bool:
        """Whether processes are worth starting, as far as tasks of this process tell."""
        # the first one also waited for what is loaded or compiled once
        return self._answers > 1 and self.seconds_left() > WORTH_PROCESSES

    def seconds_left(self) -> float:
        """Estimate the time of what nobody has yet; NaN: not known."""
        return self._waiting * self._pace

    def size(self) -> int:
        """Count the runs of the next task; 0: there is none."""
        if self._again:
            first, end = self._again[0]
            return end - first
        if not self._stretches:
            return 0
        size, most = (FIRST_PACK, LARGEST_PACK) if self.packs else (1, LARGEST)
        if not math.isnan(self._pace):
            size = min(most, max(1, int(LASTS / max(self._pace, 1e-9))))
            if not self.packs:  # the last ones should end together
                size = min(size, math.ceil(self._waiting / (2 * self._workers)))
        first, end = self._stretches[0]
        return min(size, end - first)

    def next_task(self, size: int) -> Task:
        """Take the next task."""
        if self._again:
            task = self._again.popleft()
        else:
            first, end = self._stretches.popleft()
            task = (first, first + size)
            if task[1] < end:
                self._stretches.appendleft((task[1], end))
        self._begun[task] = time.monotonic()
        return task

    def take(self, answer: Answer) -> list[Row]:
        """Give the rows that were made, to be kept; what was not is to be done again."""
        task = answer.task
        first, end = task
        took = time.monotonic() - self._begun.pop(task)
        if answer.rows is not None:
            took = took if math.isnan(answer.cost) else answer.cost
            self._pace, self._answers = took / (end - first), self._answers + 1
            return answer.rows
        self._tries[task] = self._tries.get(task, 0) + 1
        if self._tries[task] < TRIES:
            self._again.append(task)
        elif end - first > 1:
            middle = (first + end) // 2
            for half in ((first, middle), (middle, end)):
                self._tries[half] = TRIES - 1
                self._again.append(half)
        else:
            return [failed_row(self._sweep, first, f'{answer.died}, and so did another one')]
        return []

    def keep(self, rows: list[Row], notes: Sequence[str]) -> None:
        """Keep rows and count them."""
        if rows:
            self._keep(rows)
            self.outcome.take(rows, notes)
            self.done += len(rows)


def _share_simulations(sweep: Sweep, missing: Sequence[Task]) -> bool:
    """Tell by the first runs whether runs will share simulations."""
    first, end = missing[0]
    keys = []
    for run in range(first, min(end, first + LOOKED_AT)):
        try:
            scene = sweep.scene(sweep.values(run))
        except (UserError, InvalidModel, ArithmeticError, ValueError):
            continue
        keys.append(packs.pack_key(scene, energy='energy' in sweep.keep))
    return any(key is not None and keys.count(key) > 1 for key in keys)


def to_file(
    sweep: Sweep,
    path: Path,
    *,
    workers: int,
    scheduler: str | None = None,
    progress: Progress = lambda _done, _runs: None,
    nursery: Nursery | None = None,
) -> Outcome:
    """
    Make a sweep into a file, Parquet or CSV by its suffix; what a process that was killed had done
    is taken over.

    Raises UserError where the file exists, has another suffix, or parts of another sweep are
    there, RunError when the disk takes no more.
    """
    need('pyarrow')  # said now, not when all is done
    parts = Parts(path, sweep)
    try:
        before = Outcome()
        for rows in parts.statuses():
            before.take(rows, ())
        missing = [] if parts.is_finished else parts.missing()
        outcome = run_all(
            sweep,
            missing,
            parts.add,
            workers=workers,
            scheduler=scheduler,
            progress=progress,
            nursery=nursery,
        )
        outcome.before = before if before.made else None
        outcome.notes[:0] = parts.notes
        parts.finish()
    finally:
        parts.close()
    return outcome


def to_table(
    sweep: Sweep,
    *,
    workers: int,
    scheduler: str | None = None,
    progress: Progress = lambda _done, _runs: None,
) -> Any:
    """Make a sweep into an Arrow table in memory."""
    import pyarrow

    made: dict[int, Any] = {}

    def keep(rows: list[Row]) -> None:
        made[rows[0]['run']] = table.table_of(sweep, rows)

    run_all(
        sweep, [(0, sweep.runs)], keep, workers=workers, scheduler=scheduler, progress=progress
    )
    tables = [made[first] for first in sorted(made)]
    schema = table.joint_schema(one.schema for one in tables)
    return pyarrow.concat_tables([table.with_schema(one, schema) for one in tables])


def one_row(sweep: Sweep, run: int) -> Row:
    """Make one run, alone."""
    return rows_of(sweep, [run], pack=False)[0][0]


def checked_workers(workers: Any) -> int:
    """Give the number of worker processes; UserError for what is none. None: all cores."""
    if workers is None:
        return cores()
    is_whole = isinstance(workers, int) and not isinstance(workers, bool)
    if not is_whole or not 1 <= workers <= MOST_WORKERS:
        raise UserError(
            f'sweep: workers {shown(workers)}; allowed: a whole number from 1 to {MOST_WORKERS}'
        )
    return workers


def sweep(
    scene: Any,
    vary: Mapping[str, Any],
    *,
    runs: int | None = None,
    seed: int = 0,
    workers: int | None = None,
    duration: float = 10.0,
    every: float | None = None,
    keep: Sequence[str] = GROUPS,
    bodies: Sequence[str] = (),
    output: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Any:
    """
    Run a scene many times with keys that differ; give a table (pandas) with one row a run.

        rbs.sweep('satellite', {'satellite.mass': rbs.uniform(10, 14)}, runs=1000, seed=7)

    scene    : as `load_scene` takes it
    vary     : key of the scene -> values: a list or an array (each takes its turn; of several keys
               all combinations, the last key fastest), a distribution (`uniform`, `normal`,
               `loguniform`, `truncated_normal`, `integers`, `choice`, `direction`,
               `random_rotation`), or text as on the command line ('10:14:5')
    runs     : how many; None: all combinations of the lists
    seed     : of the draws; run K depends on (seed, K) alone
    workers  : processes of this machine; 1: this one; None: one a core. No bit depends on it
    duration : [s] of each run
    every    : [s] between looks at extremes and energy; None: a hundredth of the duration
    keep     : what a row holds beside what was varied: 'last' states, 'extremes', 'energy'
    bodies   : names of those with columns of their own; none named: all that move
    output   : FILE.parquet or FILE.csv to write too; a sweep that was killed goes on where it was
    scheduler : address of a Dask scheduler whose workers make the runs
    progress : called with the runs done so far and all of them

    A run that fails is a row with `status` and `reason`. Raises UserError for a key, a value or a
    number that makes no sense in any run.
    """
    need('pyarrow')
    need('pandas')  # said now, not when all is done

    plan = plan_sweep(
        scene,
        vary,
        runs=runs,
        seed=seed,
        duration=duration,
        every=every,
        keep=keep,
        bodies=bodies,
    )
    count, told = checked_workers(workers), progress or (lambda _done, _runs: None)
    if output is None:
        made = to_table(plan, workers=count, scheduler=scheduler, progress=told)
    else:
        from rigid_body_sim.recording.paths import path_of

        path = path_of(output, said='sweep: output')
        to_file(plan, path, workers=count, scheduler=scheduler, progress=told)
        made = format_of(path).read(plan, path)
    return made.to_pandas()
