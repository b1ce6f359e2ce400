# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether something new can be written at a path: asked before a run, not after it. What replaces
something is written beside it first. A symbolic link stays: what it leads to is replaced; so does
what is no file, a device or a pipe: it is written to as it is.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import get_ident

from rigid_body_sim.errors import RunError, UserError

LONGEST_SHOWN = 200  # [-] letters of a path that a message shows
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)  # the disk, and not the path


def check_folder(path: Path) -> None:
    """Refuse a path that no file can have, or whose folder does not exist."""
    if not is_taken(path) and not path.parent.is_dir():
        raise UserError(
            f'{_shown(path)}: the folder {_shown(path.parent)} does not exist; create it first'
        )


def check_text(name: str, *, what: str) -> None:
    """Refuse a name with bytes that are no text in UTF-8; what must be: for the message."""
    try:
        name.encode()
    except UnicodeEncodeError:
        raise UserError(
            f'{as_text(name)}: holds bytes that are no text in UTF-8, as {what} must be; choose '
            'another name, or, where each of them is a letter, a locale that knows it: '
            'LC_ALL=C.UTF-8'
        ) from None


def as_text(name: str) -> str:
    """Write as escapes the bytes of a name that are no text in UTF-8."""
    return name.encode(errors='backslashreplace').decode()


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """
    Give a path beside another, which takes its place when all is written; until then what is there
    stays. Of a device or a pipe give the path itself. With the path, RunError where there is no
    room, UserError for what cannot be written.
    """
    check_folder(path)
    if _is_no_file(path):
        with _written_to(path):
            yield path
        return
    place = Path(os.path.realpath(path)) if path.is_symlink() else path
    if place.is_symlink():
        raise UserError(
            f'{_shown(path)}: a symbolic link that leads back to itself; remove it, or choose '
            'another name'
        )
    check_folder(place)
    if place.is_dir():
        raise UserError(
            f'{_shown(path)}: is a folder, and a file is to be written; give the name of a file'
        )
    new = place.with_name(f'.{place.name}.{os.getpid()}.{get_ident()}.part')
    try:
        yield new
        os.replace(new, place)  # noqa: PTH105  (says what it does)
    except OSError as error:
        raise not_written(
            path, error, 'what was there before is as it was; make room, or choose another place'
        ) from error
    finally:
        remove(new)


def _is_no_file(path: Path) -> bool:
    """Tell whether a device, a pipe or a socket is there: nothing can take its place."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


@contextmanager
def _written_to(path: Path) -> Iterator[None]:
    """Hold a device or a pipe open, so that its reader waits, while it is written to."""
    held = -1
    try:
        held = os.open(path, os.O_WRONLY | os.O_NONBLOCK)  # a pipe without a reader: ENXIO
        yield
    except OSError as error:
        cure = 'choose another place'
        if error.errno in (errno.ENXIO, errno.EPIPE):
            cure = 'if it is a pipe, let somebody read it, from before to the end'
        raise not_written(path, error, cure) from error
    finally:
        if held >= 0:
            os.close(held)


def remove(path: Path) -> None:
    """Take away what was begun, if it was; a disk that cannot be written says more than that."""
    with suppress(OSError):
        path.unlink(missing_ok=True)


def not_written(path: Path, error: OSError, cure: str) -> RunError | UserError:
    """Say that a path cannot be written: that the disk is full is no error of who named it."""
    kind = RunError if error.errno in FULL else UserError
    return kind(f'{_shown(path)}: cannot be written: {error.strerror or error}; {cure}')


def is_taken(path: Path) -> bool:
    """Tell whether something is there; UserError for a path that no file can have."""
    try:
        os.lstat(path)
    except FileNotFoundError:
        return False
    except (OSError, ValueError) as error:  # ValueError: a null byte in it
        reason = getattr(error, 'strerror', None) or error
        raise UserError(f'{_shown(path)}: nothing can be written there: {reason}') from error
    return True


def _shown(path: Path) -> str:
    name = str(path)
    return name if len(name) <= LONGEST_SHOWN else f'{name[:LONGEST_SHOWN]}…'
