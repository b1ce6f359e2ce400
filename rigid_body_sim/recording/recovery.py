# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Restores a recording that was cut off: by SIGKILL, a power failure, or a full disk.

What is whole is copied; indexes, summary and metadata.yaml are built anew. Of our own recordings
the last incomplete tick is dropped, so that the copy ends where a tick ends: a tick is whole when
clock, poses and twists of every body have it as their sequence. The source is never changed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.records import Attachment, Channel, Metadata, Schema

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import bag_directory, cdr, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_copy import BagCopy
from rigid_body_sim.recording.bag_writer import MANIFEST

_STATE_TYPES = {cdr.Clock.TYPE, cdr.PoseStamped.TYPE, cdr.TwistStamped.TYPE}


class Recovery(NamedTuple):
    """
    What was saved.

    messages  : number of messages in the copy
    dropped   : whole messages left out because their tick is not
    last_tick : the last whole tick; None in recordings that have no ticks
    torn_at   : [bytes] where the good part of the source ends; None when all of it was good
    problem   : what stands there
    """

    messages: int
    dropped: int
    last_tick: int | None
    torn_at: int | None
    problem: str


def recover(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> Recovery:
    """
    Copy what is whole in `source` (bag directory or .mcap file) to the new bag directory `target`.

    UserError for paths that cannot be used; RunError when there is nothing to save.
    """
    file = _locate(Path(source))
    with file.open('rb') as stream:
        found = _survey(stream, file)
        if found.messages == 0:
            raise RunError(
                f'{file}: nothing to save: {found.dropped} whole messages, no whole tick '
                f'({found.problem or "the recording is empty"})'
            )
        _copy(stream, found, Path(target))
    return found


def _locate(path: Path) -> Path:
    if not path.exists():
        raise UserError(
            f'{path}: no such file or directory; expected a bag directory or an .mcap file'
        )
    if not path.is_dir():
        return path
    files = sorted(path.glob('*.mcap'))
    if len(files) != 1:
        raise UserError(
            f'{path}: holds {len(files)} .mcap files, expected one; name the file to recover'
        )
    return files[0]


def _survey(stream: BinaryIO, file: Path) -> Recovery:
    """Find out how many messages are good, and where the last whole tick ends."""
    seen, whole, last_tick = 0, 0, None
    tick, arrived = -1, set[int]()
    state_channels, schemas, ours = set[int](), dict[int, str](), False
    torn_at, problem = None, ''
    try:
        for record in _good_records(stream):
            if record.opcode == mcap_file.MESSAGE:
                seen += 1
                message = mcap_scan.message(record)
                if message.channel not in state_channels:
                    continue
                if message.sequence != tick:
                    tick, arrived = message.sequence, set()
                arrived.add(message.channel)
                if arrived == state_channels:
                    whole, last_tick = seen, tick
            elif record.opcode == mcap_file.SCHEMA:
                schema = record.parse(Schema)
                schemas[schema.id] = schema.name
            elif record.opcode == mcap_file.CHANNEL:
                channel = record.parse(Channel)
                if schemas.get(channel.schema_id) in _STATE_TYPES:
                    state_channels.add(channel.id)
            elif record.opcode == mcap_file.METADATA:
                ours = ours or record.parse(Metadata).name == MANIFEST
            elif record.opcode == mcap_file.ATTACHMENT:
                record.parse(Attachment)
    except mcap_scan.Torn as error:
        if error.position == 0:
            raise UserError(f'{file}: not a bag: {error}') from error
        torn_at, problem = error.position, str(error)
    if not ours or not state_channels:
        whole, last_tick = seen, None
    elif torn_at is None:
        whole = seen if last_tick is not None else 0
    return Recovery(whole, seen - whole, last_tick, torn_at, problem)


def _copy(stream: BinaryIO, found: Recovery, target: Path) -> None:
    """Write the good records, up to the last whole tick, to a new bag."""
    bag_directory.create(target)
    try:
        with (target / bag_directory.file_name(target)).open('xb', buffering=0) as output:
            copy = BagCopy(output, found.messages)
            with suppress(mcap_scan.Torn):
                for record in _good_records(stream):
                    copy.take(record)
            copy.finish(
                target,
                {
                    'recovered': 'true',
                    'last_tick': '' if found.last_tick is None else str(found.last_tick),
                    'dropped': str(found.dropped),
                    'problem': found.problem,
                },
            )
    except OSError as error:
        raise RunError(
            f'{target}: writing failed ({error.strerror}); the source is unchanged; '
            'make room and try again'
        ) from error


def _good_records(stream: BinaryIO) -> Iterator[mcap_scan.Record]:
    """Yield the records of the data section, chunks unpacked; Torn where the good part ends."""
    for number, record in enumerate(mcap_scan.records(stream)):
        if number == 0 and record.opcode != mcap_file.HEADER:
            raise mcap_scan.Torn(record.position, 'the header is missing')
        if record.opcode == mcap_file.DATA_END:
            break
        if record.opcode == mcap_file.CHUNK:
            yield from mcap_scan.inner_records(record)
        else:
            yield record
