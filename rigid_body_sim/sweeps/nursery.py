# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A process that has imported what runs need, once; workers come from it by fork within milliseconds.

It has one thread (no pool of NumPy's either), so that what forks from it is whole, and it runs
nothing of the program that asks. Asked through a socket: fork a worker that gets two pipes; tell
how one ended. It ends, and whoever it forked with it, when that socket is closed: however the
asking process ends. Imports next to nothing, so that it can be started first of all and load the
package while the asking process does so too.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import time
import traceback
from contextlib import suppress
from typing import NoReturn

from rigid_body_sim.errors import RunError
from rigid_body_sim.sweeps import worker

THREADS = (
    'OMP_NUM_THREADS',
    'OPENBLAS_NUM_THREADS',
    'MKL_NUM_THREADS',
    'NUMBA_NUM_THREADS',
    'VECLIB_MAXIMUM_THREADS',
    'NUMEXPR_NUM_THREADS',
)
ONE_THREAD = dict.fromkeys(THREADS, '1')

NEEDED = 'rigid_body_sim.sweeps.rows'
WHERE_BODIES_MEET = 'rigid_body_sim.physics.contact.world'

FORK, STATUS = 1, 2  # what is asked
_ASKED, _ANSWER = struct.Struct('<qq'), struct.Struct('<q')
ENDS_WITHIN = 5.0  # [s] of a worker whose connection is closed
RUNNING = -1  # in place of a status


class Gone(Exception):
    """The nursery ended."""


class Nursery:
    """
    The asking side.

    meeting : whether bodies will meet: what that needs is imported before workers fork
    """

    def __init__(self, *, meeting: bool) -> None:
        self._has_workers = False
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        imported = [NEEDED, WHERE_BODIES_MEET] if meeting else [NEEDED]
        program = (
            f'import sys; sys.path[:] = {json.dumps(sys.path)}; '
            f'from {__name__} import main; main({theirs.fileno()}, {imported})'
        )
        try:
            self._process = subprocess.Popen(
                [sys.executable, '-c', program],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env={**os.environ, **ONE_THREAD},
                start_new_session=True,  # Ctrl-C on a terminal is for who asks
            )
        except OSError as error:
            self._socket.close()
            raise RunError(f'no worker process can be started: {error.strerror}') from error
        finally:
            theirs.close()

    def fork(self, descriptors: tuple[int, int]) -> int:
        """
        Start a worker; give its process id. Gone if there is nobody who could.

        descriptors : of its tasks and its lifeline
        """
        self._has_workers = True
        return self._ask(FORK, 0, descriptors)

    def status(self, pid: int) -> int | None:
        """Tell how a worker ended: its exit code, or minus the signal; None: it did not."""
        status = self._ask(STATUS, pid)
        return None if status == RUNNING else os.waitstatus_to_exitcode(status)

    def _ask(self, what: int, number: int, descriptors: tuple[int, ...] = ()) -> int:
        """Ask, and wait for the number that answers."""
        try:
            socket.send_fds(self._socket, [_ASKED.pack(what, number)], descriptors)
            answer = self._socket.recv(_ANSWER.size, socket.MSG_WAITALL)
        except OSError as error:
            raise Gone from error
        if len(answer) < _ANSWER.size:
            raise Gone
        return _ANSWER.unpack(answer)[0]

    def why_gone(self) -> str:
        """Say how it ended."""
        with suppress(subprocess.TimeoutExpired):
            return how_ended(self._process.wait(ENDS_WITHIN))
        return 'it closed its connection'

    def close(self) -> None:
        """End it, and all its workers."""
        self._socket.close()
        if self._has_workers:  # it ends them; else nobody waits until it has imported all
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(ENDS_WITHIN)
        self._process.kill()
        self._process.wait()


def how_ended(code: int) -> str:
    """Say how a process ended by its exit code, or minus the signal."""
    how = f'signal {-code}' if code < 0 else f'exit code {code}'
    return f'the worker process ended ({how})'


def main(number: int, imported: list[str]) -> None:
    """
    Import, then fork workers until nobody asks any more.

    number : file descriptor of the socket
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for who asks; it ends us
    for name in imported:
        importlib.import_module(name)
    from rigid_body_sim.sweeps.plan import code_digest

    code_digest()  # of the code that was imported; it is kept
    children: set[int] = set()
    with socket.socket(fileno=number) as asking, suppress(ConnectionError):
        while _answer(asking, children):
            pass
    for child in children:
        with suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
    for child in children:
        with suppress(ChildProcessError):
            os.waitpid(child, 0)
    os._exit(0)  # nothing is left to be tidied up


def _answer(asking: socket.socket, children: set[int]) -> bool:
    """Do what is asked; whether somebody asked."""
    message, descriptors, _flags, _address = socket.recv_fds(asking, _ASKED.size, 2)
    if len(message) < _ASKED.size:
        return False
    what, number = _ASKED.unpack(message)
    if what == FORK:
        tasks, lifeline = descriptors
        answer = os.fork()
        if answer == 0:
            _be_a_worker(asking, tasks, lifeline)
        children.add(answer)
        for one in descriptors:
            os.close(one)
    else:
        answer = _status(number)
        if answer != RUNNING:
            children.discard(number)
    asking.sendall(_ANSWER.pack(answer))
    return True


def _be_a_worker(asking: socket.socket, tasks: int, lifeline: int) -> NoReturn:
    """Go on as a worker, and never come back."""
    code = 1
    try:
        asking.close()
        worker.main(tasks, lifeline)
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def _status(pid: int) -> int:
    """Wait a while for the end of a worker; RUNNING if it has none."""
    deadline = time.monotonic() + ENDS_WITHIN
    while time.monotonic() < deadline:
        try:
            ended, status = os.waitpid(pid, os.WNOHANG)
        except ChildProcessError:
            return RUNNING
        if ended:
            return status
        time.sleep(0.005)
    return RUNNING
