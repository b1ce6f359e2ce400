# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a sweep has so far, in a folder beside its file: `FILE.parts`.

    sweep.json                     what it was asked for
    000000000000-000000000255.parquet   rows of those runs

Each part comes into being whole, by a rename; so does the file at the end, after which the folder
goes. A process that is killed at any moment leaves whole parts, and the same command goes on from
them. Two processes cannot work in one folder: it is locked as long as one does.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording.new_output import check_folder, check_text, is_taken
from rigid_body_sim.sweeps import table
from rigid_body_sim.sweeps.formats import format_of
from rigid_body_sim.sweeps.plan import Sweep
from rigid_body_sim.sweeps.rows import Row

SUFFIX = '.parts'
PLAN = 'sweep.json'
UNFINISHED = '.unfinished'
LONGEST = 200  # [-] letters of a difference that a message shows
_PART = re.compile(r'(\d{12,})-(\d{12,})\.parquet')


class Parts:
    """
    The parts of one sweep on disk.

    path   : of the file
    folder : of the parts
    done   : (first run, last run) of each part, ascending
    notes  : on what was not as it should be
    is_finished : whether the file is there already: a process ended between its last two deeds
    """

    def __init__(self, path: Path, sweep: Sweep) -> None:
        if path.is_dir():
            raise UserError(f'{path}: is a folder; name a file in it')
        self.path, self.folder = path, path.with_name(path.name + SUFFIX)
        self._sweep = sweep
        self.done: list[tuple[int, int]] = []
        self.notes: list[str] = []
        self._lock = -1
        check_folder(path)
        check_text(str(path), what='the path of the table')  # Arrow takes no others
        self._format = format_of(path)
        begun = is_taken(self.folder)
        self.is_finished = is_taken(path)
        if self.is_finished and not begun:
            raise UserError(f'{path}: exists already; choose another name or remove it')
        try:
            self.folder.mkdir(exist_ok=True)
            self._take_lock()
            if (self.folder / PLAN).exists():
                self._resume()
            elif self.is_finished:
                self._release()
                raise UserError(f'{path}: exists already; choose another name or remove it')
            else:
                self._begin()
        except OSError as error:
            raise UserError(
                f'{self.folder}: nothing can be written there: {error.strerror or error}; the '
                f'parts of {path.name} need it until it is done'
            ) from error

    def _take_lock(self) -> None:
        self._lock = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._release()
            raise UserError(
                f'{self.folder}: another process is at work on this sweep; wait for it, or give '
                'another -o'
            ) from None

    def _release(self) -> None:
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def _begin(self) -> None:
        text = self._sweep.facts_text()
        self._write(self.folder / PLAN, lambda p: p.write_text(text, encoding='utf-8'))

    def _resume(self) -> None:
        """Take over what is there; UserError if it belongs to another sweep."""
        if not self.is_finished and not any(self.folder.glob('*.parquet')):
            self._begin()  # whoever was here had done nothing yet
            return
        try:
            there = json.loads((self.folder / PLAN).read_text(encoding='utf-8'))
            assert isinstance(there, dict)
        except (ValueError, AssertionError):
            there = {}
        wanted = json.loads(self._sweep.facts_text())
        for name in wanted:
            if there.get(name) != wanted[name]:
                self._release()
                what = 'file' if self.is_finished else 'begun sweep'
                raise UserError(
                    f'{self.folder}: belongs to a {what} with another {name}: '
                    f'{_short(there.get(name))}, now {_short(wanted[name])}; give the same '
                    'arguments to go on with it, another -o for a sweep beside it, or remove the '
                    'folder'
                )
        for entry in sorted(self.folder.iterdir()):
            match = _PART.fullmatch(entry.name)
            if match:
                self._take_over(entry, int(match[1]), int(match[2]))
            elif entry.name.endswith(UNFINISHED):
                entry.unlink()

    def _take_over(self, part: Path, first: int, last: int) -> None:
        """Count the runs of a part as done; where it does not hold them they are made again."""
        behind = self.done[-1][1] if self.done else -1
        fits = behind < first <= last < self._sweep.runs
        if self.is_finished or (fits and table.rows_in(part) == last - first + 1):
            self.done.append((first, last))
            return
        part.unlink()
        self.notes.append(f'{part}: does not hold whole rows of its runs; they are made again')

    def add(self, rows: Sequence[Row]) -> None:
        """
        Keep rows of runs that follow each other.

        Raises RunError when the disk takes no more; what was kept before stays.
        """
        import pyarrow.parquet

        first, last = rows[0]['run'], rows[-1]['run']
        made = table.table_of(self._sweep, rows)
        path = self.folder / f'{first:012d}-{last:012d}.parquet'
        try:
            self._write(path, lambda p: pyarrow.parquet.write_table(made, p, compression='zstd'))
        except OSError as error:
            raise self._full(error) from error
        self.done.append((first, last))

    def _full(self, error: OSError) -> RunError:
        safe = sum(last - first + 1 for first, last in self.done)
        return RunError(
            f'{self.folder}: cannot be written: {error.strerror or error}; {safe} of '
            f'{self._sweep.runs} runs are safe there, and the same command goes on from them'
        )

    def missing(self) -> list[tuple[int, int]]:
        """Give the stretches (first run, behind the last) that are not done yet."""
        found, begin = [], 0
        for first, last in sorted(self.done):
            if first > begin:
                found.append((begin, first))
            begin = last + 1
        if begin < self._sweep.runs:
            found.append((begin, self._sweep.runs))
        return found

    def statuses(self) -> Iterator[list[Row]]:
        """Give status and reason of the runs that are done."""
        if self.is_finished and self._format.rows_in(self.path) != self._sweep.runs:
            raise UserError(
                f'{self.path}: exists already, and does not hold the {self._sweep.runs} rows of '
                f'the sweep that ended in it; remove it and {self.folder}'
            )
        if self.is_finished:
            yield from self._format.statuses(self.path)
            return
        for path in self._files():
            yield from table.statuses(path)

    def _files(self) -> list[Path]:
        return [self.folder / f'{a:012d}-{b:012d}.parquet' for a, b in sorted(self.done)]

    def finish(self) -> None:
        """Make the file of the parts, and remove them."""
        if not self.is_finished:
            parts = self._files()
            try:
                self._write(self.path, lambda p: self._format.write(self._sweep, parts, p))
            except OSError as error:
                raise self._full(error) from error
        with suppress(OSError):  # what is left of it disturbs nobody
            shutil.rmtree(self.folder)
        self._release()

    def close(self) -> None:
        """Leave the parts as they are; where there are none, nothing stays."""
        if self._lock >= 0 and not self.done:
            with suppress(OSError):
                shutil.rmtree(self.folder)
        self._release()

    def _write(self, path: Path, fill: Callable[[Path], object]) -> None:
        """Let a file come into being whole, or not at all."""
        unfinished = self.folder / (path.name + UNFINISHED)
        try:
            fill(unfinished)
            with unfinished.open('rb') as file:
                os.fsync(file.fileno())
            unfinished.replace(path)
        except BaseException:
            with suppress(OSError):
                unfinished.unlink()
            raise


def _short(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= LONGEST else f'{text[:LONGEST]}…'
