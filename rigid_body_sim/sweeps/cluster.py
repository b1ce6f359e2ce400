# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Runs on an existing Dask cluster.

Every task carries the whole sweep: a worker that dies takes nothing along that others need. The
workers need this package, in the same version as who asks (`rows_of` compares).
"""

from __future__ import annotations

import threading
import time
from contextlib import suppress
from typing import Any

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.sweeps.executors import Answer, Task
from rigid_body_sim.sweeps.plan import Sweep

CONNECTS_WITHIN = 10.0  # [s]
WORKERS_WITHIN = 60.0  # [s] without a single worker, or without the scheduler, before we give up
AHEAD = 2  # [-] tasks for each thread of the cluster: one at work, one that waits for it

_one_at_a_time = threading.Lock()


def rows_on_worker(sweep: Sweep, first: int, end: int) -> Any:
    """Make runs on a worker: one task at a time in each process, whatever threads it has."""
    from rigid_body_sim.sweeps.rows import rows_of

    with _one_at_a_time:
        return rows_of(sweep, range(first, end))


class Cluster:
    """Makes the runs on the workers of a Dask scheduler."""

    def __init__(self, sweep: Sweep, address: str) -> None:
        import distributed

        self._sweep, self._address = sweep, address
        try:
            self._client = distributed.Client(
                address, timeout=CONNECTS_WITHIN, set_as_default=False
            )
        except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
            reason = str(error).strip().splitlines() or [type(error).__name__]
            raise UserError(
                f'--scheduler {address}: no Dask scheduler answers there: {reason[0]}; start one '
                'with: dask scheduler'
            ) from error
        self._futures: dict[Any, Task] = {}
        self._alone_since: float | None = None
        self._slots = 0
        self._count_slots()

    def _count_slots(self) -> int:
        """Count the threads of the cluster now."""
        threads: Any = {}
        if self._client.status == 'running':
            with suppress(Exception):  # whatever a scheduler that is about to go answers
                threads = self._client.nthreads()
        self._slots = sum(threads.values())
        if self._slots:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = time.monotonic()
        elif time.monotonic() - self._alone_since > WORKERS_WITHIN:
            raise RunError(
                f'the Dask cluster at {self._address} has had no worker for {WORKERS_WITHIN:g} s; '
                'start some with: dask worker ' + self._address
            )
        return self._slots

    def wants(self, seconds_left: float) -> bool:
        return len(self._futures) < AHEAD * max(1, self._slots)

    def submit(self, task: Task) -> None:
        future = self._client.submit(
            rows_on_worker, self._sweep, *task, pure=False, key=f'sweep-{id(self)}-{task}-'
            f'{time.monotonic_ns()}'
        )  # fmt: skip
        self._futures[future] = task

    def wait(self, seconds: float) -> list[Answer]:
        import distributed

        if self._futures:
            with self._client.as_current(), suppress(TimeoutError, distributed.CancelledError):
                distributed.wait(
                    list(self._futures), timeout=seconds, return_when='FIRST_COMPLETED'
                )
        done = [future for future in self._futures if future.done()]
        if not done:
            self._count_slots()
        return [self._answer(future) for future in done]

    def _answer(self, future: Any) -> Answer:
        import distributed

        task = self._futures.pop(future)
        try:
            return Answer(task, *future.result())
        except distributed.KilledWorker:
            return Answer(task, None, [], died='Dask workers ended in this task')
        except (distributed.CancelledError, OSError) as error:
            self._count_slots()
            return Answer(task, None, [], died=f'the Dask cluster lost it: {error}')
        except RunError as error:
            raise RunError(f'Dask cluster at {self._address}: {error}') from error
        except ImportError as error:
            raise RunError(
                f'the Dask workers at {self._address} cannot import this package ({error}); '
                'install the same version of it there'
            ) from error
        except Exception as error:  # whatever a worker raises: the task is what is lost
            return Answer(task, None, [], died=f'{type(error).__name__}: {error}')
        finally:
            future.release()

    def under_way(self) -> float:
        return 0.0

    def close(self) -> None:
        with suppress(Exception):  # the scheduler may be gone
            self._client.cancel(list(self._futures))
        with suppress(Exception):
            self._client.close(timeout=2.0)
