# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Calls that have nothing to do with each other, on all processors that this process may use.

Compiled kernels let Python's lock go, so threads of one process run them side by side. Who calls
takes calls out of a list, and so do the threads that help, each begun for one batch: that costs
some 20 us, and nothing is left over for who forks. What comes of it does not depend on who did
what.

$RIGID_BODY_SIM_THREADS says how many threads there may be, or else $NUMBA_NUM_THREADS; without
them there are as many as processors, at most MOST.
"""

from __future__ import annotations

import os
from _thread import allocate_lock, start_new_thread
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache
from typing import Any

MOST = 8  # threads: more wait for memory
_LOOK = 0.01  # [s] between two looks at whether all are done, should nobody wake who waits
NAMES = ('RIGID_BODY_SIM_THREADS', 'NUMBA_NUM_THREADS')


@cache
def threads() -> int:
    """Count the threads that there may be; 1 where the environment says anything unclear."""
    asked = next(filter(None, map(os.environ.get, NAMES)), '')
    if asked:
        return min(max(1, int(asked)), 64) if asked.isascii() and asked.isdigit() else 1
    try:
        return min(MOST, len(os.sched_getaffinity(0)))
    except AttributeError:  # not Linux
        return min(MOST, os.cpu_count() or 1)


class SideBySide:
    """
    Who makes calls side by side, one batch after the other.

    An interrupt may come anywhere, also while others still work: whoever then looks at what they
    write calls `rest` first.
    """

    def __init__(self) -> None:
        self._batch: _Batch | None = None

    def call(self, calls: Sequence[Callable[..., Any]], arguments: Sequence[Any]) -> list[Any]:
        """Make all calls with the same arguments, and return what they return, in any order."""
        self.rest()
        self._batch = batch = _Batch(calls, arguments)
        try:
            with suppress(RuntimeError):  # the system has no thread left
                for _ in range(min(threads(), len(calls)) - 1):
                    start_new_thread(batch.help, ())
            batch.work()
        finally:
            self.rest()
        if batch.failed:
            raise batch.failed[0]
        return batch.found

    def rest(self) -> None:
        """Wait until nobody works, and nobody will."""
        batch = self._batch
        if batch is not None:
            batch.end()
            self._batch = None


class _Batch:
    """
    Calls, and who makes them. Signals are handled by Python's first thread alone, so what helpers
    do here is never broken off.
    """

    def __init__(self, calls: Sequence[Callable[..., Any]], arguments: Sequence[Any]) -> None:
        self.found: list[Any] = []
        self.failed: list[BaseException] = []
        self._ahead = list(calls)
        self._arguments = arguments
        self._came: list[None] = []  # a helper each, before it takes a call
        self._left: list[None] = []
        self._wake = allocate_lock()
        self._wake.acquire()

    def work(self) -> None:
        """Make calls while there are some."""
        while self._ahead:
            try:
                call = self._ahead.pop()  # in one go: nobody else gets it
            except IndexError:
                return
            self.found.append(call(*self._arguments))

    def help(self) -> None:
        """Do what `work` does, in a thread of its own."""
        self._came.append(None)
        try:
            self.work()
        except BaseException as error:  # told to who called
            self.failed.append(error)
        self._left.append(None)
        with suppress(RuntimeError):  # another one has
            self._wake.release()

    def end(self) -> None:
        """Wait until all who came have left; who comes later finds nothing to do."""
        self._ahead.clear()
        while len(self._left) < len(self._came):
            self._wake.acquire(timeout=_LOOK)
