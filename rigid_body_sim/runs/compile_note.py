# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a terminal shows while kernels are compiled: what, how far it is, how long it will still take.

numba tells of every function that it has compiled. How many a scene needs is known only roughly
(FREE, FORCES, CONTACT, by `python benchmark/start_up.py --functions`), and callers, which come
last, take longest, then LLVM with all of them (SHARE): so the time left is told as `some`. Kernels
that are cached, or come as machine code, are ready before anything is shown.
"""

from __future__ import annotations

import itertools
import sys
import threading
import time
from collections.abc import Callable

from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.terminal import progress_bar

EVERY = 0.5  # [s] between two looks; nothing is shown before the first
# functions compiled: tumbling_box 38, two_bodies 62; rolling_sphere 460, stack 575
FREE, FORCES, CONTACT = 38, 62, 520
SHARE = ((0.0, 0.0), (0.25, 0.15), (0.5, 0.28), (0.75, 0.44), (0.9, 0.52), (1.0, 0.58))  # of time
EARLY, SOON = 0.1, 0.98  # [-] of the functions: too few to guess from; the guess is used up


def expected_functions(scene: Scene) -> int:
    """Guess how many functions a scene needs."""
    if scene.contact.get('mode', 'none') != 'none':
        return CONTACT
    return FORCES if scene.forces or any(scene.gravity) else FREE


def time_left(done: int, expected: int, elapsed: float) -> float | None:
    """
    Guess how long compiling still takes [s]; zero where the guess is used up, and LLVM at work;
    None where there is too little to guess from.

    done, expected : functions compiled so far, and in all
    elapsed        : [s] since it began
    """
    share = done / expected
    if share < EARLY:
        return None
    for (below, begin), (above, end) in itertools.pairwise(SHARE):
        if share < above:
            of_time = begin + (end - begin) * (share - below) / (above - below)
            return elapsed * (1.0 - of_time) / of_time if share < SOON else 0.0
    return 0.0


class CompileNote:
    """
    A line on a terminal, while this is open, and kernels are compiled.

    expected : functions in all, see `expected_functions`
    shown    : whether there is somebody to read it
    """

    def __init__(self, expected: int, *, shown: bool) -> None:
        self._expected = expected
        self._shown = shown and sys.stderr.isatty()
        self._what = 'kernels'
        self._done = 0
        self._begin = time.monotonic()
        self._end = 0.0  # [s] since it began, as guessed last
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._show, daemon=True)
        self._forget: Callable[[], None] | None = None

    def compiling(self, what: str) -> None:
        """Say what comes next."""
        self._what = what

    def text(self) -> str:
        """Write the line."""
        elapsed = time.monotonic() - self._begin
        if self._done == 0:  # reading what is cached
            return f'preparing {self._what}: {elapsed:.0f} s'
        left = time_left(self._done, self._expected, elapsed)
        if left:
            self._end = elapsed + left
        elif left is not None:
            left = max(0.0, self._end - elapsed)
        words = '' if left is None else f', some {left:.0f} s left' if left >= 1 else ', soon done'
        return (
            f'compiling, once per machine: {elapsed:.0f} s{words} ({self._done} of some '
            f'{max(self._expected, self._done)} functions): {self._what}'
        )

    def __enter__(self) -> CompileNote:
        if self._shown:
            self._thread.start()
        return self

    def __exit__(self, *_exception: object) -> None:
        self.end()

    def end(self) -> None:
        """Take the line away; more than once does no harm."""
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()
        if self._forget is not None:
            self._forget()
            self._forget = None

    def _show(self) -> None:
        with progress_bar(total=0, bar_format='{desc}') as bar:
            while not self._over.wait(EVERY):
                if self._forget is None:
                    self._listen()
                bar.set_description_str(self.text())

    def _listen(self) -> None:
        """Count what numba compiles, once it is imported: nobody waits for it otherwise."""
        event = sys.modules.get('numba.core.event')
        if event is None or not hasattr(event, 'register'):
            return
        note = self

        class Count(event.Listener):
            def on_start(self, _event: object) -> None:
                """Nothing is done yet."""

            def on_end(self, _event: object) -> None:
                note._done += 1

        listener = Count()
        event.register('numba:compile', listener)
        self._forget = lambda: event.unregister('numba:compile', listener)
