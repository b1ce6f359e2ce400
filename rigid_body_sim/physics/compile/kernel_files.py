# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The files in which compiled kernels are kept: one for each kernel and signature, which is whole and
ours, or is not read.

    file = MAGIC | sha256(key | payload) | payload

The key names the signature, the processor, the code of the function, its source file and the
releases of Python, numba and LLVM; its digest is in the name of the file, so that no list has
to agree with what lies there, and two processes that compile at once write either the same kernel
or another file. A file is written beside its place and moved there. One that is cut short,
changed, moved to another name, of another release or of another user counts as absent: its kernel
is compiled anew and written over it. What cannot be written (a full disk) is not kept: that costs
time, not the run.

The payload is a pickle, which runs what it names: whoever may write a folder of kernels may run
code as its reader. So a folder counts only if it belongs to the user and nobody else may write
into it (`is_ours`).
"""

from __future__ import annotations

import errno
import hashlib
import os
import pickle
import stat
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

MAGIC = b'rigid_body_sim kernel 1\n'
DIGEST_SIZE = hashlib.sha256().digest_size
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def is_ours(found: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user, alone to write."""
    if not hasattr(os, 'geteuid'):
        return True
    return found.st_uid == os.geteuid() and not found.st_mode & _OTHERS_WRITE


def _opened(path: str, flags: int) -> int:
    """Open a regular file of ours alone; OSError for anything else."""
    handle = os.open(path, flags | getattr(os, 'O_NONBLOCK', 0) | getattr(os, 'O_NOFOLLOW', 0))
    found = os.fstat(handle)
    if stat.S_ISREG(found.st_mode) and is_ours(found):
        return handle
    os.close(handle)
    raise OSError(errno.EPERM, 'not a file of this user alone', path)


def names_of(cache: Any) -> tuple[str, str, str]:
    """Folder, name and source file (its time and length) under which numba keeps a function."""
    kept = cache._impl
    return cache._cache_path, kept.filename_base, repr(kept.locator.get_source_stamp())


def read_whole(path: Path, key: bytes, *, of_any_user: bool = False) -> bytes | None:
    """
    Give what was kept in a file under a key; None where it is not whole, or not ours.

    of_any_user : it came with the package, whose modules are run whosever they are
    """
    try:
        with open(path, 'rb', opener=None if of_any_user else _opened) as file:
            content = file.read(os.fstat(file.fileno()).st_size)
    except OSError:
        return None
    begin = len(MAGIC) + DIGEST_SIZE
    payload = content[begin:]
    whole = MAGIC + hashlib.sha256(key + payload).digest()
    return payload if content[:begin] == whole else None


def write_whole(path: Path, key: bytes, payload: bytes) -> None:
    """Keep a payload under a key, if the folder takes it."""
    with suppress(OSError):
        handle, beside = tempfile.mkstemp(dir=path.parent, prefix='new-')
        try:
            with os.fdopen(handle, 'wb') as file:
                file.write(MAGIC + hashlib.sha256(key + payload).digest() + payload)
            Path(beside).replace(path)
        except BaseException:
            Path(beside).unlink(missing_ok=True)
            raise


def named(folder: Path, name: str, key: bytes) -> Path:
    """Name the file that keeps what a key tells of a function."""
    return folder / f'{name}.{hashlib.sha256(key).hexdigest()[:16]}.kernel'


class KernelFiles:
    """
    The files of one function; stands where numba keeps an index and its files.

    folder, name, source : of `names_of`
    releases             : of what a payload depends on beside the code
    """

    def __init__(self, folder: str, name: str, source: str, releases: str) -> None:
        self._folder = Path(folder)
        self._name = name
        self._made_of = f'{source} {releases} python {sys.version}'

    def _place(self, key: Any) -> tuple[bytes, Path]:
        """Give the text of a key and the file that it names."""
        text = f'{self._made_of} {self._name} {key!r}'.encode()
        return text, named(self._folder, self._name, text)

    def _payload(self, key: Any) -> bytes | None:
        text, path = self._place(key)
        return read_whole(path, text)

    def holds(self, key: Any) -> bool:
        """Whether there is a whole file for a key."""
        return self._payload(key) is not None

    def load(self, key: Any) -> Any:
        """Give what was kept for a key; None where nothing whole is, or nothing of use."""
        payload = self._payload(key)
        try:
            return None if payload is None else pickle.loads(payload)
        except (AttributeError, ImportError):  # a class of numba that has moved since
            return None

    def save(self, key: Any, data: Any) -> None:
        """Keep data for a key, if the folder takes it."""
        from numba.core.serialize import dumps  # also of what pickle alone does not know

        text, path = self._place(key)
        write_whole(path, text, dumps(data))

    def flush(self) -> None:
        """Forget all that was kept for the function."""
        for path in self._folder.glob(f'{self._name}.*.kernel'):
            path.unlink(missing_ok=True)
