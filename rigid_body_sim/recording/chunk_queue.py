# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Between the one who writes messages and the file: batches wait here until they make a chunk.

`DirectQueue` closes a chunk by bytes alone, in the caller's thread: equal messages give equal
files; for what is derived from a recording and can be derived again. Runs take the other one.
`ThreadedQueue` closes it in a thread of its own and also by wall time, so that a killed process
loses no more than the last half second; what has piled up goes out as several chunks, so that a
reader need not hold it all. Neither drops anything: a full queue makes the caller wait.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Protocol

from rigid_body_sim.recording.batch import Batch

Sink = Callable[[Sequence[Batch]], None]

DIRECT_CHUNK_BYTES = (
    1 << 20
)  # [bytes] smaller: more index per message; larger: more lost by a kill
THREADED_CHUNK_BYTES = (
    1 << 18
)  # [bytes] smaller: more work; larger: the interpreter is held longer
LARGEST_CHUNK_BYTES = 1 << 21  # [bytes] of what has piled up; one batch may be more
PENDING_BYTES = 1 << 26  # [bytes] that may wait for a slow disk before the writer waits too
FLUSH_PERIOD = 0.1  # [s] wall; leaves 0.4 s for a busy machine to keep the promised 0.5 s


class Queue(Protocol):
    """Takes batches and hands chunks of them to a sink."""

    def put(self, batch: Batch) -> None:
        """Take a batch."""

    def flush(self) -> None:
        """Return when everything taken so far went through the sink."""

    def stop(self) -> None:
        """Flush and end; no batch may follow."""


class DirectQueue:
    """Closes chunks by bytes, in the caller's thread."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._batches: list[Batch] = []
        self._bytes = 0

    def put(self, batch: Batch) -> None:
        """Take a batch; write a chunk when there is enough for one."""
        self._batches.append(batch)
        self._bytes += len(batch.data)
        if self._bytes >= DIRECT_CHUNK_BYTES:
            self.flush()

    def flush(self) -> None:
        """Write what waits, as one chunk."""
        batches, self._batches, self._bytes = self._batches, [], 0
        if batches:
            self._sink(batches)

    stop = flush


class ThreadedQueue:
    """
    Closes chunks by bytes and by wall time, in a worker thread.

    An error of the sink ends the worker and is raised by every later call.
    """

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._changed = threading.Condition()
        self._batches: deque[Batch] = deque()
        self._bytes = 0
        self._writing = False
        self._wanted = False
        self._stopped = False
        self._error: Exception | None = None
        self._worker = threading.Thread(target=self._work, name='recorder', daemon=True)
        self._worker.start()

    def put(self, batch: Batch) -> None:
        """Take a batch; wait only when the disk is far behind."""
        with self._changed:
            self._batches.append(batch)
            self._bytes += len(batch.data)
            if self._bytes >= THREADED_CHUNK_BYTES:
                self._changed.notify_all()
                while self._bytes >= PENDING_BYTES and self._error is None:
                    self._changed.wait()
            if self._error is not None:
                raise self._error

    def flush(self) -> None:
        """Return when everything taken so far went through the sink."""
        with self._changed:
            self._wanted = True
            self._changed.notify_all()
            while (self._batches or self._writing) and self._error is None:
                self._changed.wait()
            if self._error is not None:
                raise self._error

    def stop(self) -> None:
        """Write what waits and end the worker."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        self._worker.join()
        if self._error is not None:
            raise self._error

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(self._is_due, FLUSH_PERIOD)
                batches = self._next_chunk()
                self._wanted = self._wanted and bool(self._batches)
                if not batches and self._stopped:
                    return
                self._writing = True
            try:
                if batches:
                    self._sink(batches)
            except Exception as error:
                self._error = error
            with self._changed:
                self._writing = False
                self._changed.notify_all()
            if self._error is not None:
                return

    def _next_chunk(self) -> list[Batch]:
        """Take what has waited longest, as much as a chunk may hold, and one batch at least."""
        batches, size = [], 0
        while self._batches and (not batches or size < LARGEST_CHUNK_BYTES):
            batches.append(self._batches.popleft())
            size += len(batches[-1].data)
        self._bytes -= size
        return batches

    def _is_due(self) -> bool:
        return self._wanted or self._stopped or self._bytes >= THREADED_CHUNK_BYTES
