# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bags of one node: at most one is open; each stretch of recording gets one of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from itertools import chain, count
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording.bag_directory import PathTaken, check_name
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.run import Run, TickOutput
from rigid_body_sim.scene import regular_file


class Bags:
    """
    Opens, feeds and closes bags.

    asked : path of the first bag; later ones get _2, _3 and so on; None: a name with date and time
    path  : the open bag, or the last one; None if there was none
    torn  : whether the last one has no ending, because the run failed inside a tick or the disk
            took no more
    """

    def __init__(self, run: Run, asked: Path | None) -> None:
        self._run = run
        self._asked = asked
        self._recorder: RunRecorder | None = None
        self.path: Path | None = None
        self.torn = False

    @property
    def is_open(self) -> bool:
        """Whether a recording runs."""
        return self._recorder is not None

    def start(self) -> Path:
        """Open the next bag at the present tick; UserError if its path is taken."""
        for path in self._next_paths():
            try:
                self._recorder = RunRecorder(self._run, path)
            except PathTaken:
                if path == self._asked and self.path is None:
                    raise
                continue  # by another node that began in the same second
            self.path = path
            break
        assert self.path is not None
        return self.path

    def record(self, output: TickOutput, tick: int) -> None:
        """Record what came of the ticks from `tick` on, if a bag is open; RunError: disk full."""
        if self._recorder is not None:
            self._recorder.record(output, tick=tick)

    def stop(self, reason: str) -> None:
        """Close the open bag, if there is one; RunError if it could not be finished."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            self.torn = True
            recorder.close(reason)
            self.torn = recorder.is_torn

    def _next_paths(self) -> Iterator[Path]:
        """Yield the paths to try, best first."""
        if self._asked is None:
            yield from _free(Path(f'rigid_body_sim_{datetime.now():%Y%m%d_%H%M%S}'))
        elif self.path is None:
            yield need_free(self._asked)
        else:
            yield from _free(self._asked)


def need_free(path: Path) -> Path:
    """Return the path of a new bag; UserError if something is there."""
    check_name(path)
    if regular_file.exists(path):
        raise UserError(f'{path}: exists already; choose another record_path or remove it')
    return path


def _free(path: Path) -> Iterator[Path]:
    """Yield the path, path_2, path_3, …, those that nothing has."""
    later = (path.with_name(f'{path.name}_{number}') for number in count(2))
    return (candidate for candidate in chain([path], later) if not regular_file.exists(candidate))
