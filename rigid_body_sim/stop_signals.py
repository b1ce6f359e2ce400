# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
SIGINT, SIGTERM and SIGHUP: a wish to stop, heard when the work may stop.

The first signal counts; those after it change nothing. What a verb does with it depends on where
it stands:

    nothing begun that must be finished : the process says so in one line and ends at once, also in
        the middle of a long call that Python cannot leave
    after `STOP.keep()` : the signal is noted in `STOP.number`; the verb looks at it between ticks,
        closes what is open and ends by itself
    inside `STOP.kept()` : the same, as long as something is written that a reader would take for
        whole

A handler of Python runs in the main thread between two of its instructions, wherever these are, so
that an exception out of it would leave anything half done: here it notes a number and no more. A
thread of its own, woken through a pipe, ends the process where nothing is kept.

Exit codes: 128 + the number of the signal (130, 143, 129); of the node, whose normal end is a
signal, 0. Where another program calls `main`, what is not kept is left to its own handlers.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

NAMES = {signal.SIGINT: 'Ctrl-C', signal.SIGTERM: 'SIGTERM', signal.SIGHUP: 'SIGHUP'}
BEGINNING, WORKING = 'before it began', 'before it was done'


class Stopped(Exception):
    """A verb ends because a signal came; the message says how far it came."""


class StopSignals:
    """
    The signals of this process.

    number : of the first signal that came; 0: none
    verb   : who is stopped, for the line that says so
    stage  : what is going on, for the same line: 'while compiling'
    quits  : exit code of a process that ends at once; None: 128 + number
    before_leaving : called before the process ends at once, in a thread of its own; returns what
             more there is to say
    """

    def __init__(self) -> None:
        self.number = 0
        self.verb = ''
        self.stage = BEGINNING
        self.quits: int | None = None
        self.before_leaving: Callable[[], str] | None = None
        self._kept = 0
        self._changing = threading.Lock()
        self._before: dict[int, object] = {}
        self._owns_process = False

    @property
    def name(self) -> str:
        """What came, for people."""
        return NAMES.get(signal.Signals(self.number), '') if self.number else ''

    @property
    def owns_process(self) -> bool:
        """Whether this process lives for a verb alone."""
        return self._owns_process

    @property
    def exit_code(self) -> int:
        """Exit code of a verb that stopped because of it."""
        return 128 + self.number if self.quits is None else self.quits

    def listen(self, *, owns_process: bool) -> bool:
        """
        Take the signals over, in the main thread; tell whether that was done now.

        owns_process : whether this process lives for a verb alone, so that it may be ended
        """
        if self._before or threading.current_thread() is not threading.main_thread():
            return False
        self.number, self.verb, self.stage, self.quits = 0, '', BEGINNING, None
        self.before_leaving, self._kept, self._owns_process = None, 0, owns_process
        if owns_process:
            self._watch()
        for number in NAMES:
            before = signal.getsignal(number)
            if number == signal.SIGHUP and before == signal.SIG_IGN:
                continue  # nohup: what hangs up is no reason to end
            self._before[number] = signal.signal(number, self._note)
        return True

    def ignore(self) -> None:
        """Let no signal disturb the end of the process, which is near."""
        for number in self._before:
            signal.signal(number, signal.SIG_IGN)

    def restore(self) -> None:
        """Put back the handlers that were there."""
        while self._before:
            number, handler = self._before.popitem()
            signal.signal(number, handler)  # type: ignore[arg-type]  # as it was given

    def check(self, how_far: Callable[[], str]) -> None:
        """Raise Stopped if a signal came."""
        if self.number:
            raise Stopped(how_far())

    def keep(self) -> None:
        """Begin what must be finished: from now on a signal is noted, and nothing else."""
        with self._changing:
            self._kept += 1

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Do something that must be finished; a signal meanwhile ends the process after it."""
        self.keep()
        try:
            yield
        finally:
            with self._changing:
                self._kept -= 1
            if self.number and self._owns_process:
                self._leave_unless_kept()

    def _note(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal, in the main thread."""
        self.number = self.number or number
        if self._owns_process or self._kept:
            return
        before = self._before[number]
        if callable(before):
            before(number, frame)
        elif before == signal.SIG_DFL:
            self.restore()
            os.kill(os.getpid(), number)

    def _watch(self) -> None:
        """Hear signals in a thread too, while the main thread is in a call it cannot leave."""
        reading, writing = os.pipe()
        os.set_blocking(writing, False)
        signal.set_wakeup_fd(writing, warn_on_full_buffer=False)

        def hear() -> None:
            while numbers := os.read(reading, 16):
                self.number = self.number or numbers[0]
                self._leave_unless_kept()

        threading.Thread(target=hear, name='signals', daemon=True).start()

    def _leave_unless_kept(self) -> None:
        with self._changing:
            if self._kept:
                return
            more = ''
            if self.before_leaving is not None:
                with suppress(Exception):
                    more = self.before_leaving()
            line = f'rigid_body_sim {self.verb}: stopped by {self.name} {self.stage}{more}\n'
            with suppress(OSError):  # whoever hung up reads it no more
                clear = '\r\x1b[2K' if os.isatty(2) else ''
                os.write(2, (clear + line).encode())
            os._exit(self.exit_code)


STOP = StopSignals()


def say(line: str) -> None:
    """Print to standard error, where it still takes anything."""
    with suppress(OSError):
        print(line, file=sys.stderr, flush=True)
