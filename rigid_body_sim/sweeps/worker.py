# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A process that makes runs for another one: it is given a sweep, then stretches of runs, and answers
with rows.

It reads its tasks from one connection and ends when that, or a second pipe that the asking process
keeps open, is closed: however that one ends, no worker outlives it.
"""

from __future__ import annotations

import os
import signal
import threading
import time
import traceback
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from rigid_body_sim.errors import RunError

READY, SHARE, ROWS, BROKEN, UNLIKE = 'ready', 'share', 'rows', 'broken', 'unlike'
TELL_EVERY = 0.2  # [s] of a share of the work that is done


def main(tasks: int, lifeline: int) -> None:
    """
    Work until nobody asks any more.

    tasks, lifeline : file descriptors
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for who asks; it ends us
    threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()
    connection = Connection(tasks)
    with suppress(EOFError, ConnectionError):  # nobody asks any more
        _serve(connection)


def _serve(connection: Connection) -> None:
    from rigid_body_sim.sweeps.rows import rows_of

    sweep = connection.recv()
    connection.send((READY, None))
    teller = _Teller(connection)
    while (task := connection.recv()) is not None:
        try:
            answer: tuple[str, Any] = (ROWS, rows_of(sweep, range(*task), saw=teller.saw))
        except RunError as error:  # code unlike that of who asks
            answer = (UNLIKE, str(error))
        except MemoryError:
            answer = (BROKEN, 'out of memory')
        except Exception:  # of the work itself; those of a run are rows
            answer = (BROKEN, traceback.format_exc())
        connection.send(answer)


class _Teller:
    """Tells now and then how far a task is."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._due = 0.0

    def saw(self, share: float) -> None:
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + TELL_EVERY
            self._connection.send((SHARE, share))


def _end_with(lifeline: int) -> None:
    while os.read(lifeline, 1):
        pass
    os._exit(0)
