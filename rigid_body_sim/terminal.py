# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What goes to the terminal: text without control characters, whoever chose the names in it.

A scene or a bag of somebody else may hold names that would clear the screen, set the title of the
window, or turn the line round. They are shown as the escapes that Python writes for them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

_LINE_ENDS = frozenset('\n\t')


def printable(text: str, *, keep: frozenset[str] = frozenset()) -> str:
    """Write as escapes what controls, reorders or ends lines, except what is to be kept."""
    if text.isprintable():
        return text
    return ''.join(
        character if character.isprintable() or character in keep else _escape(character)
        for character in text
    )


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
    out, err = sys.stdout, sys.stderr
    clean_out, clean_err = _CleanStream(out), _CleanStream(err)
    sys.stdout, sys.stderr = clean_out, clean_err  # type: ignore[assignment]  # all but by name
    try:
        yield
    finally:
        if sys.stdout is clean_out:
            sys.stdout = out
        if sys.stderr is clean_err:
            sys.stderr = err


class _CleanStream:
    """A text stream that shows control characters in place of sending them."""

    def __init__(self, stream: TextIO) -> None:
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


def _escape(character: str) -> str:
    return character.encode('unicode_escape').decode('ascii')
