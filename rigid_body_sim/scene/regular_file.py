# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read a file that may be anything: regular files only, up to a size.

A named pipe would wait for ever, a device may never end, and a text of gigabytes fills the memory
when it is parsed.
"""

from __future__ import annotations

import csv
import io
import os
import stat
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TypeVar

from rigid_body_sim.errors import UserError

Row = TypeVar('Row')

MOST = 64 * 2**20  # [byte] scenes, meshes, URDF files, tables of commands
KINDS = {
    stat.S_IFDIR: 'a folder',
    stat.S_IFIFO: 'a named pipe',
    stat.S_IFCHR: 'a device',
    stat.S_IFBLK: 'a device',
    stat.S_IFSOCK: 'a socket',
}


def read(path: str | os.PathLike[str]) -> bytes:
    """
    Return the bytes of a regular file, a link to one included.

    Raises OSError, whose `strerror` says why, also for what is not regular or is too large.
    """
    _need_regular(Path(path).stat().st_mode)  # before it is opened: that alone may wait
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with open(handle, 'rb') as stream:  # noqa: PTH123  (already open)
        _need_regular(os.fstat(handle).st_mode)
        content = stream.read(MOST + 1)
    if len(content) > MOST:
        raise OSError(0, f'more than {MOST // 2**20} MiB, too large for a file of this kind')
    return content


def rows(
    path: Path, read_rows: Callable[[Path, Iterator[str]], Iterable[Row]], *, wanted: str
) -> list[Row]:
    """
    Read a CSV file in UTF-8, a byte order mark before it or none; UserError for what is none.

    read_rows : makes rows of the path, for its messages, and the lines
    wanted    : what file to give instead, for messages
    """
    try:
        text = read(path).decode('utf-8-sig')
        return list(read_rows(path, io.StringIO(text, newline='')))
    except (OSError, csv.Error) as error:
        said = reason(error) if isinstance(error, OSError) else error
        raise UserError(f'{path}: cannot be read ({said}); give {wanted}') from None
    except UnicodeDecodeError:
        raise UserError(f'{path}: is not UTF-8 text; give {wanted}') from None


def reason(error: OSError | ValueError) -> str:
    """Say why a file could not be read; ValueError: a null byte in its name."""
    return str(getattr(error, 'strerror', None) or error)


def exists(path: Path) -> bool:
    """Tell whether a path leads anywhere; one that no file can have does not."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def _need_regular(mode: int) -> None:
    if not stat.S_ISREG(mode):
        kind = KINDS.get(stat.S_IFMT(mode), 'something else')
        raise OSError(0, f'it is {kind}, and a regular file is needed')
