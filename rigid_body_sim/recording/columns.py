# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Topics of a bag as arrays: times and numbers of all their messages, a million in a second.

Chunks are walked through record by record, and their messages cut out by numpy at once where all
of a topic are laid out alike, as a run writes them; elsewhere they are decoded one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording import cdr, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_files import damaged
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.cdr_parts import CdrError

Array = NDArray[np.float64]
Progress = Callable[[int], object]  # told how many messages were read since the last time

_HEAD = Struct('<BQH')  # opcode, length and channel id at the start of a message record
_FRAME = 9  # [bytes] of opcode and length
_FIXED = 31  # [bytes] of a message record before its payload
_STAMP = 4  # [bytes] of a payload before its stamp
TYPES: dict[str, Any] = {
    kind.TYPE: kind for kind in (cdr.PoseStamped, cdr.TwistStamped, cdr.WrenchStamped)
}


@dataclass(frozen=True, eq=False)
class Columns:
    """
    The messages of one topic, in file order.

    stamp    : (k,) int [ns]  of the headers
    numbers  : (k, w)  the doubles of the message: PARTS of its type
    frame_id : axes of the first message; '' where there is none
    """

    stamp: NDArray[np.int64]
    numbers: Array
    frame_id: str


def read_columns(
    bag: Bag, topics: Collection[str], *, progress: Progress = lambda _count: None
) -> dict[str, Columns]:
    """
    Read poses, twists and wrenches; DamagedBag for a message that is none, and torn chunks.

    topics : their names; each of a type in TYPES
    """
    pieces: dict[str, list[tuple[int, bytes]]] = {name: [] for name in topics}
    direct = [name for name in topics if name in bag.recorded_topics]
    for name, size, payloads in _payloads(bag, direct, progress):
        pieces[name].append((size, payloads))
    others = [name for name in topics if name not in direct]
    if others:
        for message in bag.messages(others):
            pieces[message.topic].append((len(message.data), message.data))
            progress(1)
    return {name: _columns(bag, name, found) for name, found in pieces.items()}


def _payloads(
    bag: Bag, topics: Collection[str], progress: Progress
) -> Iterator[tuple[str, int, bytes]]:
    """Yield (topic, size of a payload, payloads one after the other), chunk by chunk."""
    for file, names in bag.names_in_files():
        wanted = {channel: name for channel, name in names.items() if name in topics}
        with file.open('rb') as stream:
            try:
                for record in mcap_scan.records(stream):
                    if record.opcode == mcap_file.CHUNK:
                        body = mcap_scan.opened_chunk(record)[1]
                        yield from _of_chunk(body, record, wanted, names, progress)
                    elif record.opcode == mcap_file.MESSAGE:
                        single = mcap_scan.message(record)
                        if single.channel in wanted:
                            yield wanted[single.channel], len(single.data), single.data
                    elif record.opcode == mcap_file.DATA_END:
                        break
            except mcap_scan.Torn as error:
                raise damaged(file, error) from error


def _of_chunk(
    body: bytes,
    record: mcap_scan.Record,
    wanted: dict[int, str],
    known: Collection[int],
    progress: Progress,
) -> Iterator[tuple[str, int, bytes]]:
    places: dict[tuple[int, int], list[int]] = {}
    position, end, head = 0, len(body), _HEAD.unpack_from
    while position + _FIXED <= end:
        opcode, length, channel = head(body, position)
        if opcode == mcap_file.MESSAGE:
            key = (channel, length)
            if key in places:
                places[key].append(position)
            else:
                places[key] = [position]
        elif opcode == 0:
            raise mcap_scan.Torn(record.position, 'chunk holds a record with opcode 0')
        position += _FRAME + length
    if position != end:
        _need_whole(body, position, record)
    flat = np.frombuffer(body, dtype=np.uint8)
    for (channel, length), found in places.items():
        size = length + _FRAME - _FIXED
        if channel not in known:
            problem = f'message of the unknown channel {channel}'
            raise mcap_scan.Torn(record.position, problem)
        if size < 0 or found[-1] + _FIXED + size > end:
            raise mcap_scan.Torn(record.position, 'chunk ends within a record')
        if channel in wanted:
            starts = np.array(found, dtype=np.int64) + _FIXED
            rows = np.lib.stride_tricks.sliding_window_view(flat, size)[starts] if size else flat
            yield wanted[channel], size, rows[: len(found)].tobytes() if size else b''
            progress(len(found))


def _need_whole(body: bytes, position: int, record: mcap_scan.Record) -> None:
    """Refuse a chunk whose records do not fill it; what is left may be small records."""
    end = len(body)
    while position < end:
        if position + _FRAME > end:
            raise mcap_scan.Torn(record.position, 'chunk ends within a record')
        length = int.from_bytes(body[position + 1 : position + _FRAME], 'little')
        if body[position] in (0, mcap_file.MESSAGE):
            raise mcap_scan.Torn(record.position, 'message record is too short')
        position += _FRAME + length
    if position != end:
        raise mcap_scan.Torn(record.position, 'chunk ends within a record')


def _columns(bag: Bag, name: str, pieces: list[tuple[int, bytes]]) -> Columns:
    """Read the payloads of one topic, all at once where they are laid out alike."""
    kind = TYPES[bag.topics[name].type]
    width = sum(count for _, count in kind.PARTS)
    sizes = {size for size, _ in pieces}
    if not pieces:
        return Columns(np.zeros(0, dtype=np.int64), np.zeros((0, width)), '')
    size = min(sizes)
    try:
        first: Any = cdr.decode(kind.TYPE, pieces[0][1][: pieces[0][0]])
        if len(sizes) == 1:
            data = b''.join(payloads for _, payloads in pieces)
            found = _alike(data, size, width, first.frame_id)
            if found is not None:
                return found
        return _one_by_one(kind, pieces, first.frame_id)
    except CdrError as error:
        raise damaged(bag.path, f'a message on {name}: {error}') from error


def _alike(data: bytes, size: int, width: int, frame_id: str) -> Columns | None:
    """Cut stamps and doubles out; None where messages differ in more than these."""
    rows = np.frombuffer(data, dtype=np.uint8).reshape(-1, size)
    doubles = size - 8 * width
    constant = (*range(_STAMP), *range(_STAMP + 8, doubles))  # encapsulation and frame
    head = rows[:, list(constant)]
    if doubles < _STAMP + 8 or rows[0, 1] != 1 or (head != head[0]).any():
        return None
    layout = np.dtype(
        {
            'names': ['sec', 'nanosec', 'numbers'],
            'formats': ['<i4', '<u4', ('<f8', (width,))],
            'offsets': [_STAMP, _STAMP + 4, doubles],
            'itemsize': size,
        }  # type: ignore[arg-type]  # numpy's own stubs do not know this form with subarrays
    )
    table = np.frombuffer(data, dtype=layout)
    stamp = 10**9 * table['sec'].astype(np.int64) + table['nanosec']
    return Columns(stamp, table['numbers'].astype(np.float64), frame_id)


def _one_by_one(kind: Any, pieces: list[tuple[int, bytes]], frame_id: str) -> Columns:
    """Decode every message."""
    messages: list[Any] = [
        cdr.decode(kind.TYPE, payloads[start : start + size])
        for size, payloads in pieces
        for start in range(0, len(payloads), size)
    ]
    stamp = [10**9 * message.sec + message.nanosec for message in messages]
    numbers = [[x for part, _ in kind.PARTS for x in getattr(m, part)] for m in messages]
    return Columns(np.array(stamp, dtype=np.int64), np.array(numbers, dtype=np.float64), frame_id)
