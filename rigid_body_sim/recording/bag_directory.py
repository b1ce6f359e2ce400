# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The directory of a bag: made at the start, completed at the end.

`NAME/NAME_0.mcap` and, written last, `NAME/metadata.yaml`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from io import FileIO
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import bag_metadata
from rigid_body_sim.recording.mcap_file import McapFile
from rigid_body_sim.recording.new_output import check_folder, check_text, is_taken

NOWHERE = Path()  # where a file is that was removed


class PathTaken(UserError):
    """Something is where a new bag was to be; another process may have put it there just now."""


def file_name(directory: Path) -> str:
    """Name of the MCAP file in a bag directory, as rosbag2 gives it."""
    return f'{directory.resolve().name}_0.mcap'


def check_name(directory: Path) -> None:
    """Refuse a name that no bag can have."""
    if directory.suffix == '.mcap':
        raise UserError(
            f'{directory}: a recording is a directory, and the file in it gets the ending .mcap; '
            'give a name without it'
        )
    check_text(directory.name, what='the name of a bag')  # metadata.yaml holds it


def check_new(directory: Path) -> None:
    """Refuse a path where no bag can be made: asked before a run, not after it."""
    check_name(directory)
    if is_taken(directory):
        raise UserError(f'{directory}: exists already; choose another name or remove it')
    check_folder(directory)


def create(directory: Path) -> Path:
    """Make the directory of a new bag; its name must be free."""
    check_name(directory)
    try:
        directory.mkdir(parents=True)
    except FileExistsError as error:
        raise PathTaken(
            f'{directory}: exists already, and a recording is never overwritten; '
            'choose another path or remove it'
        ) from error
    except OSError as error:
        raise UserError(
            f'{directory}: cannot be created ({error.strerror}); '
            'choose a place that can be written'
        ) from error
    return directory


def open_file(directory: Path) -> FileIO:
    """Make the MCAP file in the directory of a new bag, which goes away again where it cannot."""
    file = directory / file_name(directory)
    try:
        return file.open('xb', buffering=0)
    except OSError as error:
        directory.rmdir()
        raise UserError(
            f'{file}: cannot be created ({error.strerror}); choose a place that can be written, '
            'or a shorter name'
        ) from error


def where_it_went(stream: FileIO) -> Path | None:
    """
    Look whether the file of an open bag still stands where it was made.

    returns : None: it does; else where it stands now, or NOWHERE
    """
    made, own = Path(os.fsdecode(stream.name)), os.fstat(stream.fileno())
    try:
        there = made.stat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except OSError:  # nobody may look any more: nothing is known
        return None
    else:  # a file system that gives numbers anew has the same file, of the same size
        if os.path.samestat(there, own) or there.st_size == own.st_size:
            return None
    if own.st_nlink == 0:
        return NOWHERE
    try:
        now = Path(f'/proc/self/fd/{stream.fileno()}').readlink()
        return now if os.path.samestat(now.stat(), own) else NOWHERE
    except OSError:  # no Linux, or out of sight
        return NOWHERE


def remove(directory: Path) -> None:
    """Take a bag away again that was begun and holds nothing."""
    (directory / file_name(directory)).unlink(missing_ok=True)
    directory.rmdir()


def finish(
    directory: Path,
    file: McapFile,
    stream: FileIO,
    *,
    topics: Sequence[bag_metadata.TopicSummary],
    custom: Mapping[str, str],
) -> None:
    """Write the record for rosbag2, the summary, and, when all is on the disk, metadata.yaml."""
    information = bag_metadata.Information(
        file_name=file_name(directory),
        topics=topics,
        first_time=file.first_time or 0,
        last_time=file.last_time or 0,
        custom=custom,
    )
    file.write_metadata(bag_metadata.RECORD_NAME, {'serialized_metadata': information.text()})
    file.finish()
    os.fsync(stream.fileno())
    bag_metadata.write(directory, information.file_text())
