# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Finds the files of a bag: what a path names, whether it is a file at all, which files belong to it.

Only regular files are opened: a pipe or a device would be waited for, or read without end.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, BinaryIO

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import bag_metadata, mcap_file


class DamagedBag(UserError):
    """A recording that is torn, unfinished or damaged: `bag recover` saves what is good."""


def damaged(file: Path, problem: object) -> DamagedBag:
    """Say what is wrong with a file, in one line, and what to do."""
    return DamagedBag(
        f'{file}: damaged ({" ".join(str(problem).split())}); '
        f'save what is good with: bag recover {file} -o NEW'
    )


def locate(path: Path) -> tuple[tuple[Path, ...], dict[str, Any] | None]:
    """Find the MCAP files of a finished bag and its metadata; None for a lone file."""
    if not _is_directory(path):
        return (path,), None
    if not (path / bag_metadata.FILE_NAME).exists():
        files = _mcap_files(path)
        if files:
            raise DamagedBag(f'{path}: unfinished recording (no metadata.yaml); {_cure(files)}')
        raise UserError(f'{path}: not a bag: holds neither metadata.yaml nor an .mcap file')
    information = bag_metadata.read(path)
    storage = information.get('storage_identifier')
    compression = information.get('compression_mode')
    if storage != 'mcap' or compression:
        raise UserError(
            f'{path}: storage {_short(storage)}, compression mode {_short(compression)}; '
            "allowed: 'mcap', none; convert it with: ros2 bag convert"
        )
    files = tuple(path / _on_disk(Path(name).name) for name in information['relative_file_paths'])
    if len(set(files)) < len(files):
        raise DamagedBag(f'{path / bag_metadata.FILE_NAME}: names a file twice')
    for file in files:
        if not file.is_file():
            raise UserError(f'{file}: missing, but metadata.yaml names it')
    return files, information


def _on_disk(name: str) -> str:
    """Give the name of a file, text in UTF-8, as paths have it in the locale of the process."""
    try:
        os.fsencode(name)
    except UnicodeEncodeError:  # LC_ALL=C without UTF-8 knows ASCII alone, and bytes
        return os.fsdecode(name.encode(errors='surrogateescape'))
    return name


def lone_file(path: Path) -> Path:
    """Find the one MCAP file of a bag that may be unfinished."""
    if not _is_directory(path):
        return path
    files = _mcap_files(path)
    if not files:
        raise UserError(f'{path}: holds no .mcap file; name the file to recover')
    if len(files) > 1:
        raise UserError(f'{path}: holds {len(files)} .mcap files, expected one; {_cure(files)}')
    return files[0]


def _mcap_files(path: Path) -> list[Path]:
    return sorted(file for file in path.glob('*.mcap') if file.is_file())


def _cure(files: list[Path]) -> str:
    """Say how to come by what is in the files of a bag that is not finished."""
    if len(files) == 1:
        return f'restore it with: bag recover {files[0].parent} -o NEW'
    torn = [file for file in files if _is_torn(file)]
    whole = 'read its files one by one, those that are whole as they are'
    if not torn:
        return f'{whole}: {files[0]}'
    those = 'the torn one' if len(torn) == 1 else f'each of the {len(torn)} torn ones'
    return f'{whole}; restore {those} with: bag recover {torn[0]} -o NEW'


def _is_torn(file: Path) -> bool:
    try:
        with file.open('rb') as stream:
            check_ends(file, stream)
    except (UserError, OSError):
        return True
    return False


def check_ends(file: Path, stream: BinaryIO) -> None:
    """Refuse what is no MCAP file, and what was torn off."""
    magic = mcap_file.MAGIC
    if stream.read(len(magic)) != magic:
        raise UserError(f'{file}: not a bag: does not start as an MCAP file')
    size = stream.seek(0, 2)
    stream.seek(max(len(magic), size - len(magic)))
    if stream.read() != magic:
        raise DamagedBag(
            f'{file}: torn: its end is missing; restore the rest with: bag recover {file} -o NEW'
        )
    stream.seek(0)


def _is_directory(path: Path) -> bool:
    """Whether a path is a directory; UserError unless it is one or a regular file."""
    try:
        if path.is_dir():
            return True
        if path.is_file():
            return False
        missing = not path.exists()
    except (OSError, ValueError) as error:  # too long a name, a NUL in it, no permission
        reason = error.strerror if isinstance(error, OSError) else error
        raise UserError(f'{_short(str(path))}: cannot be read ({reason})') from error
    if missing:
        raise UserError(
            f'{path}: no such file or directory; expected a bag directory or an .mcap file'
        )
    raise UserError(
        f'{path}: neither a file nor a directory; expected a bag directory or an .mcap file'
    )


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + '...'
