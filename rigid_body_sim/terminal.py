# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What goes to the terminal: text without control characters, whoever chose the names in it.

A scene or a bag of somebody else may hold names that would clear the screen, set the title of the
window, or turn the line round. They are shown as the escapes that Python writes for them.

A stream that the parent closed (`>&-`, as some services do) takes what is printed, and shows it to
nobody: that is no fault of a run.

Progress is shown to who looks on. Where nobody does, tqdm is not even imported: with what it
imports itself that is some 20 ms, of the 0.4 s that a short run takes in a script.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from fcntl import F_GETFL, fcntl
from typing import Any, TextIO

_LINE_ENDS = frozenset('\n\t')


class OutputFull(OSError):
    """Standard output takes no more."""


def not_written(error: OSError) -> str:
    """Say that standard output takes no more, and what to do."""
    return (
        f'standard output: cannot be written ({error.strerror or error}); make room where it '
        'goes, or send it elsewhere'
    )


def printable(text: str, *, keep: frozenset[str] = frozenset()) -> str:
    """Write as escapes what controls, reorders or ends lines, except what is to be kept."""
    if text.isprintable():
        return text
    return ''.join(
        character if character.isprintable() or character in keep else _escape(character)
        for character in text
    )


def open_closed_streams() -> None:
    """
    Lead to nowhere what the parent of this process closed of the standard streams. Called before
    any file is opened: that would get their number (0, 1, 2), and with it what is printed. The
    shell that starts a script has its file there by then, to be read only.
    """
    for number, never in ((0, os.O_WRONLY), (1, os.O_RDONLY), (2, os.O_RDONLY)):
        try:
            serves = fcntl(number, F_GETFL) & (os.O_WRONLY | os.O_RDWR) != never
        except OSError:
            serves = False
        if not serves:
            nowhere = os.open(os.devnull, os.O_RDWR)
            os.dup2(nowhere, number)
            if nowhere > 2:
                os.close(nowhere)
    sys.stdout, sys.stderr = sys.stdout or _Nowhere(), sys.stderr or _Nowhere()


def take_any_terminal() -> None:
    """Write what a terminal cannot show, such as … in ASCII, as an escape, and go on."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, 'reconfigure', None)
        if reconfigure is not None:
            reconfigure(errors='backslashreplace')


@contextmanager
def clean_output() -> Iterator[None]:
    """Let standard output and standard error pass on nothing but text while a verb runs."""
    take_any_terminal()
    out, err = sys.stdout, sys.stderr  # None: the parent closed it
    clean_out, clean_err = _CleanOutput(out or _Nowhere()), _CleanErrors(err or _Nowhere())
    sys.stdout, sys.stderr = clean_out, clean_err  # type: ignore[assignment]  # all but by name
    try:
        yield
    finally:
        clean_err.flush()  # while what cannot be taken is still no fault of the run
        if sys.stdout is clean_out:
            sys.stdout = out
        if sys.stderr is clean_err:
            sys.stderr = err


class _Nowhere(io.TextIOBase):
    """A stream that nobody reads."""

    def write(self, text: str) -> int:
        """Write nothing."""
        return len(text)


class _CleanStream:
    """A text stream that shows control characters in place of sending them."""

    def __init__(self, stream: TextIO | io.TextIOBase) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write text; a progress bar may go back to the start of its line."""
        start = '\r' if text.startswith('\r') else ''
        self._stream.write(start + printable(text[len(start) :], keep=_LINE_ENDS))
        return len(text)

    def writelines(self, lines: list[str]) -> None:
        """Write texts one after the other."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class _CleanOutput(_CleanStream):
    """Standard output; where it is full, that is said of it: OutputFull."""

    def write(self, text: str) -> int:
        """Write text."""
        with _taken():
            return super().write(text)

    def flush(self) -> None:
        """Hand everything written so far on."""
        with _taken():
            self._stream.flush()


class _CleanErrors(_CleanStream):
    """Standard error; where it takes no more, that ends no run: its results lie elsewhere."""

    def write(self, text: str) -> int:
        """Write text, if it is taken."""
        try:
            return super().write(text)
        except OSError:
            _lead_to_nowhere(self._stream)
            return len(text)

    def flush(self) -> None:
        """Hand everything written so far on, if it is taken."""
        try:
            self._stream.flush()
        except OSError:
            _lead_to_nowhere(self._stream)


def _lead_to_nowhere(stream: TextIO | io.TextIOBase) -> None:
    """Let what a stream still holds be taken: Python hands it on as it ends, or fails with 120."""
    with suppress(OSError, ValueError):
        number = stream.fileno()
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, number)
        os.close(nowhere)


@contextmanager
def _taken() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputFull(not_written(error)) from error


class NoBar:
    """A bar of progress that nobody sees; its methods are those of tqdm."""

    n = 0
    disable = True

    def __init__(self) -> None:
        self.total = 0

    def update(self, n: float = 1) -> None:
        """Show nothing."""

    def set_description_str(self, text: str) -> None:
        """Show nothing."""

    def close(self) -> None:
        """Leave nothing to take away."""

    def __enter__(self) -> NoBar:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()


def progress_bar(*, shown: bool = True, **options: Any) -> Any:
    """
    Make a bar of progress that goes away when it is done; nothing where standard error is no
    terminal.

    options : of tqdm
    """
    if not (shown and sys.stderr.isatty()):
        return NoBar()
    from tqdm import tqdm

    return tqdm(leave=False, **options)


def write_beside_bars(text: str) -> None:
    """Write a line to standard error, above the bars of progress that are there."""
    tqdm: Any = sys.modules.get('tqdm')
    if tqdm is None:
        print(text, file=sys.stderr)
    else:
        tqdm.tqdm.write(text, file=sys.stderr)


def _escape(character: str) -> str:
    return character.encode('unicode_escape').decode('ascii')
