# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Who makes the runs: this process, processes of this machine, or a Dask cluster.

An executor takes stretches of runs (first, behind the last) as long as it `wants` more, and gives
back, in any order, their rows, or why there are none. What it does changes no bit of a row.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, Pipe, wait
from typing import Any, Protocol

from rigid_body_sim.errors import RunError
from rigid_body_sim.sweeps import worker
from rigid_body_sim.sweeps.nursery import Gone, Nursery, how_ended
from rigid_body_sim.sweeps.plan import Sweep
from rigid_body_sim.sweeps.rows import Row, rows_of

Task = tuple[int, int]  # first run, behind the last

WORTH_A_PROCESS = 0.1  # [s] of work that is left: less is done before another one is at it
AT_ONCE = 2  # [-] processes that start before it is known how long the work is
COMPILES_WITHIN = 2.0  # [s] until others start although nothing is done yet


@dataclass(frozen=True)
class Answer:
    """
    What came of a task.

    rows   : of its runs, in order; None: there are none
    notes  : on what went otherwise than it should
    died   : why the process that had it is gone
    cost   : [s] of processor time, where it is known; else NaN
    """

    task: Task
    rows: list[Row] | None
    notes: list[str]
    died: str = ''
    cost: float = math.nan


class Executor(Protocol):
    """What makes runs."""

    def wants(self, seconds_left: float) -> bool:
        """
        Whether another task would be taken now.

        seconds_left : of work that nobody has yet; NaN: not known
        """
        ...

    def submit(self, task: Task) -> None:
        """Take a task."""
        ...

    def wait(self, seconds: float) -> list[Answer]:
        """Give what is done, after so many seconds at most where nothing is."""
        ...

    def under_way(self) -> float:
        """Count the runs that are done of tasks which are not."""
        ...

    def close(self) -> None:
        """End."""
        ...


class Here:
    """Makes the runs in this process."""

    def __init__(self, sweep: Sweep, saw: Callable[[float], None]) -> None:
        self._sweep, self._saw = sweep, saw
        self._task: Task | None = None
        self._done = 0.0

    def wants(self, seconds_left: float) -> bool:
        return self._task is None

    def submit(self, task: Task) -> None:
        self._task = task

    def wait(self, seconds: float) -> list[Answer]:
        task, self._task, self._done = self._task, None, 0.0
        if task is None:
            return []

        raised: list[Exception] = []

        def saw(share: float) -> None:
            self._done = share * (task[1] - task[0])
            try:
                self._saw(self._done)
            except Exception as error:  # of who looks on; in a run it would be taken for the run's
                raised.append(error)

        begin = time.process_time()
        rows, notes = rows_of(self._sweep, range(*task), saw=saw)
        self._done = 0.0
        if raised:
            raise raised[0]
        return [Answer(task, rows, notes, cost=time.process_time() - begin)]

    def under_way(self) -> float:
        return self._done

    def close(self) -> None:
        pass


class _Worker:
    """One process that makes runs."""

    def __init__(self, sweep: Sweep, nursery: Nursery) -> None:
        self.connection, theirs = Pipe()
        lifeline, self._lifeline = os.pipe()
        self._nursery = nursery
        try:
            self._pid = nursery.fork((theirs.fileno(), lifeline))
        except BaseException:
            os.close(self._lifeline)
            self.connection.close()
            raise
        finally:
            theirs.close()
            os.close(lifeline)
        self.is_ready = False
        self.task: Task | None = None
        self.share = 0.0
        self.send(sweep)

    def send(self, what: Any) -> None:
        with suppress(OSError):  # it died: reading will tell
            self.connection.send(what)

    def why_gone(self) -> str:
        """Say how the process ended."""
        try:
            code = self._nursery.status(self._pid)
        except Gone:
            return (
                f'the worker process ended, and so did who started it ({self._nursery.why_gone()})'
            )
        if code is None:
            return 'the worker process closed its connection'
        return how_ended(code)

    def close(self) -> None:
        """End the process, whatever it does."""
        with suppress(OSError):
            self.connection.close()
        with suppress(OSError):
            os.close(self._lifeline)
        self._lifeline = -1


class Processes:
    """
    Makes the runs in processes of this machine.

    Two start at once; more when these have done something or are long at it, and only while there
    is work that lasts longer than starting them. Who finds another one compiling waits for its
    kernels (`rows`).
    """

    def __init__(
        self,
        sweep: Sweep,
        count: int,
        saw: Callable[[float], None],
        nursery: Nursery | None = None,
    ) -> None:
        self._sweep, self._count, self._saw = sweep, count, saw
        self._begun = time.monotonic()
        self._workers: list[_Worker] = []
        self._nursery = nursery or _nursery_for(sweep)
        self._has_begun = False
        try:
            for _ in range(min(AT_ONCE, count, sweep.runs)):
                self._workers.append(self._new())
        except BaseException:
            self.close()
            raise

    def _new(self) -> _Worker:
        """Start a worker; where nobody can any more, somebody who can."""
        with suppress(Gone):
            return _Worker(self._sweep, self._nursery)
        if not self._has_begun:  # the next one would end as this one did
            raise self._cannot_start()
        self._nursery.close()
        self._nursery = _nursery_for(self._sweep)
        try:
            return _Worker(self._sweep, self._nursery)
        except Gone:
            raise self._cannot_start() from None

    def _cannot_start(self) -> RunError:
        why = self._nursery.why_gone()
        return RunError(f'no worker process can be started: {why} before it began')

    def _free(self) -> _Worker | None:
        return next((w for w in self._workers if w.task is None), None)

    def wants(self, seconds_left: float) -> bool:
        if not self._workers or self._free() is not None:
            return True
        if len(self._workers) >= self._count:
            return False
        if math.isnan(seconds_left):
            return time.monotonic() - self._begun > COMPILES_WITHIN
        return seconds_left > WORTH_A_PROCESS

    def submit(self, task: Task) -> None:
        one = self._free()
        if one is None:
            one = self._new()
            self._workers.append(one)
        one.task, one.share = task, 0.0
        one.send(task)

    def wait(self, seconds: float) -> list[Answer]:
        by_connection = {w.connection: w for w in self._workers}
        found = []
        for connection in wait(list(by_connection), seconds):
            assert isinstance(connection, Connection)
            answer = self._read(by_connection[connection])
            if answer is not None:
                found.append(answer)
        return found

    def _read(self, one: _Worker) -> Answer | None:
        try:
            kind, what = one.connection.recv()
        except (EOFError, OSError):
            return self._lost(one)
        if kind == worker.READY:
            one.is_ready = self._has_begun = True
        elif kind == worker.UNLIKE:
            raise RunError(what)
        elif kind == worker.SHARE and one.task is not None:
            one.share = what * (one.task[1] - one.task[0])
            self._saw(self.under_way())
        elif kind in (worker.ROWS, worker.BROKEN):
            task, one.task, one.share = one.task, None, 0.0
            assert task is not None
            if kind == worker.BROKEN:
                return Answer(task, None, [], died=f'the worker failed: {_last_line(what)}')
            return Answer(task, *what)
        return None

    def _lost(self, one: _Worker) -> Answer | None:
        why, task = one.why_gone(), one.task
        self._workers.remove(one)
        one.close()
        if not one.is_ready and not self._has_begun:  # the next one would end as this one did
            raise RunError(f'no worker process can be started: {why} before it began')
        return Answer(task, None, [], died=why) if task is not None else None

    def under_way(self) -> float:
        return sum(w.share for w in self._workers)

    def close(self) -> None:
        while self._workers:
            self._workers.pop().close()
        self._nursery.close()


def _nursery_for(sweep: Sweep) -> Nursery:
    contact = sweep.content.get('contact')
    mode = contact.get('mode', 'none') if isinstance(contact, Mapping) else 'none'
    return Nursery(meeting=mode != 'none')


def _last_line(text: str) -> str:
    return text.strip().splitlines()[-1]
