# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Topics of a bag as arrays: times and numbers of all their messages, a million in a second.

Messages come in the order of their log times, those of one time in file order: MCAP promises no
order in the file, and recorders that write in threads keep none.

Chunks are walked through record by record; their messages are cut out by numpy, those of one size
at once whatever their topic, then parted. A topic whose messages are not laid out alike, as
a run writes them, is decoded one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from struct import Struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import cdr, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_files import damaged
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.cdr_parts import CdrError

Array = NDArray[np.float64]
Progress = Callable[[int], object]  # told how many messages were read since the last time

_FRAMED = Struct('<BQ')  # opcode and length at the start of a record
_HEAD = np.dtype(
    [
        ('opcode', 'u1'),
        ('length', '<u8'),
        ('channel', '<u2'),
        ('sequence', '<u4'),
        ('log_time', '<u8'),
    ]
)  # of a message record
_FRAME = 9  # [bytes] of opcode and length
_FIXED = 31  # [bytes] of a message record before its payload
_STAMP = 4  # [bytes] of a payload before its stamp
_BATCH = 1 << 16  # [-] messages, and those of a topic more, that are cut up at once
_UNKNOWN, _UNWANTED = -2, -1  # in place of the number of a topic
TYPES: dict[str, Any] = {
    kind.TYPE: kind for kind in (cdr.PoseStamped, cdr.TwistStamped, cdr.WrenchStamped)
}


@dataclass(frozen=True, eq=False)
class Columns:
    """
    The messages of one topic, in the order of their log times.

    stamp     : (k,) int [ns]  of the headers
    numbers   : (k, w)  the doubles of the message: PARTS of its type
    frame_id  : axes of the first message; '' where there is none
    reordered : whether they stand in the file in another order
    """

    stamp: NDArray[np.int64]
    numbers: Array
    frame_id: str
    reordered: bool = False


def need_time_forward(stamps: NDArray[np.int64], where: str, *, reordered: bool) -> None:
    """
    Refuse what another program recorded over two runs: a time would stand for two states.

    A clock that went back with the run shows in the file alone: its times are there twice.

    stamps    : [ns] of the messages of a topic, in the order of their log times
    where     : bag and topic
    reordered : whether they stand in the file in another order
    """
    back = np.flatnonzero(stamps[1:] < stamps[:-1])
    twice = np.flatnonzero(stamps[1:] == stamps[:-1]) if reordered else back[:0]
    if back.size:
        before, at = (stamps[back[0] + k] / 1e9 for k in (0, 1))
        what = (
            f'message {back[0] + 2} by log time, of {at:.15g} s, comes after that of '
            f'{before:.15g} s; times must not go back'
        )
    elif twice.size:
        what = (
            f'two messages are of {stamps[twice[0]] / 1e9:.15g} s, and log times go back in the '
            'file; every time must be there once'
        )
    else:
        return
    raise UserError(f'{where}: {what}: record each run, and each turn of a loop, into its own bag')


class _Group(NamedTuple):
    """
    The messages of one topic that have one size, in the order of their log times.

    place : (k,) int  which messages of the bag they are, in that order
    rows  : (k, size) bytes
    cut   : stamps and numbers, where they differ in nothing else; None elsewhere
    """

    place: NDArray[np.int64]
    rows: NDArray[np.uint8]
    cut: tuple[NDArray[np.int64], Array] | None


class _Gathered:
    """
    Payloads, those of one size and width together whatever their topic.

    widths : doubles in a message of each topic

    They are taken in file order and given in that of their log times.
    """

    def __init__(self, widths: Sequence[int]) -> None:
        self._widths = np.array(widths, dtype=np.int64)
        self._found: dict[tuple[int, int], list[tuple[NDArray[Any], ...]]] = {}
        self._lone: list[tuple[int, int, bytes]] = []
        self._heads: list[tuple[NDArray[np.int64], NDArray[np.uint64]]] = []  # topic, log time
        self._count = 0

    def add(self, topic: int, log_time: int, data: bytes) -> None:
        """Take a message that stands alone."""
        self._lone.append((topic, log_time, data))

    def add_all(
        self,
        topics: NDArray[np.int64],
        log_times: NDArray[np.uint64],
        starts: NDArray[np.int64],
        sizes: NDArray[np.int64],
        body: NDArray[np.uint8],
    ) -> None:
        """Cut messages out of the bytes that hold them all."""
        self._take_lone()
        place = np.arange(self._count, self._count + len(topics))
        self._count += len(topics)
        self._heads.append((topics, log_times))
        widths = self._widths[topics]
        for size in np.unique(sizes).tolist():
            for width in np.unique(widths[sizes == size]).tolist():
                chosen = np.flatnonzero((sizes == size) & (widths == width))
                rows = np.zeros((len(chosen), 0), dtype=np.uint8)
                if size:
                    windows = np.lib.stride_tricks.sliding_window_view(body, size)
                    rows = windows[starts[chosen]]
                found = self._found.setdefault((size, width), [])
                found.append((topics[chosen], place[chosen], rows))

    def by_topic(self) -> tuple[list[list[_Group]], set[int]]:
        """Give all, and the topics that stood in another order, and forget them."""
        self._take_lone()
        moved_to, reordered = self._places_in_time()
        groups: list[list[_Group]] = [[] for _ in self._widths]
        for size, width in [*self._found]:
            found = self._found.pop((size, width))
            topics, place, rows = map(np.concatenate, zip(*found, strict=True))
            if moved_to is not None:
                place = moved_to[place]
            order = np.lexsort((place, topics))
            ends = np.append(np.flatnonzero(np.diff(topics[order])) + 1, len(order))
            last = np.append(np.diff(ends // _BATCH) > 0, True)
            begin = 0
            for end in ends[last].tolist():
                some = order[begin:end]
                begin = end
                for topic, group in _parted(topics[some], place[some], rows[some], width):
                    groups[topic].append(group)
        return groups, reordered

    def _places_in_time(self) -> tuple[NDArray[np.int64] | None, set[int]]:
        """
        Say where messages stand by log time, None: where they do in the file; and which topics
        stand in the file in another order.
        """
        if not self._heads:
            return None, set()
        topics, log_times = map(np.concatenate, zip(*self._heads, strict=True))
        self._heads = []
        if np.all(log_times[1:] >= log_times[:-1]):
            return None, set()
        places = np.empty(len(log_times), dtype=np.int64)
        places[np.argsort(log_times, kind='stable')] = np.arange(len(log_times))
        by_topic = np.argsort(topics, kind='stable')
        same = np.diff(topics[by_topic]) == 0
        back = np.flatnonzero(same & (np.diff(places[by_topic]) < 0))
        return places, {*topics[by_topic][back].tolist()}

    def _take_lone(self) -> None:
        lone, self._lone = self._lone, []
        if lone:
            topics = np.array([topic for topic, _, _ in lone])
            log_times = np.array([log_time for _, log_time, _ in lone], dtype=np.uint64)
            sizes = np.array([len(data) for _, _, data in lone])
            body = np.frombuffer(b''.join(data for _, _, data in lone), dtype=np.uint8)
            self.add_all(topics, log_times, np.cumsum(sizes) - sizes, sizes, body)


def read_columns(
    bag: Bag, topics: Collection[str], *, progress: Progress = lambda _count: None
) -> dict[str, Columns]:
    """
    Read poses, twists and wrenches; DamagedBag for a message that is none, and torn chunks.

    topics : their names; each of a type in TYPES
    """
    numbers = {name: number for number, name in enumerate(topics)}
    kinds = [TYPES[bag.topics[name].type] for name in numbers]
    gathered = _Gathered([sum(count for _, count in kind.PARTS) for kind in kinds])
    recorded = bag.recorded_topics
    _gather(bag, {n: k for n, k in numbers.items() if n in recorded}, gathered, progress)
    others = [name for name in numbers if name not in recorded]
    if others:
        for message in bag.messages(others):
            gathered.add(numbers[message.topic], message.log_time, message.data)
            progress(1)
    by_topic, reordered = gathered.by_topic()
    found = zip(numbers, kinds, by_topic, strict=True)
    return {
        name: replace(_columns(bag, name, kind, groups), reordered=numbers[name] in reordered)
        for name, kind, groups in found
    }


def _gather(bag: Bag, numbers: dict[str, int], gathered: _Gathered, progress: Progress) -> None:
    """Find the payloads of topics, which have numbers, file by file."""
    for file, names in bag.names_in_files():
        topic_of = np.full(1 << 16, _UNKNOWN, dtype=np.int64)  # by channel
        for channel, name in names.items():
            topic_of[channel] = numbers.get(name, _UNWANTED)
        with file.open('rb') as stream:
            try:
                for record in mcap_scan.records(stream, message_indexes=False):
                    if record.opcode == mcap_file.CHUNK:
                        body = mcap_scan.opened_chunk(record)[1]
                        progress(_of_chunk(body, record, topic_of, gathered))
                    elif record.opcode == mcap_file.MESSAGE:
                        single = mcap_scan.message(record)
                        if topic_of[single.channel] >= 0:
                            topic = int(topic_of[single.channel])
                            gathered.add(topic, single.log_time, single.data)
                    elif record.opcode == mcap_file.DATA_END:
                        break
            except mcap_scan.Torn as error:
                raise damaged(file, error) from error


def _of_chunk(
    body: bytes, record: mcap_scan.Record, topic_of: NDArray[np.int64], gathered: _Gathered
) -> int:
    """Take the messages of a chunk; returns how many there were of wanted topics."""
    found = _places(body, record)
    if not found:
        return 0
    places = np.array(found, dtype=np.int64)
    flat = np.frombuffer(body, dtype=np.uint8)
    heads = np.lib.stride_tricks.sliding_window_view(flat, _HEAD.itemsize)[places].view(_HEAD)
    channels = heads['channel'][:, 0]
    topics = topic_of[channels]
    sizes = heads['length'][:, 0].astype(np.int64) + (_FRAME - _FIXED)
    wrong = np.flatnonzero((topics == _UNKNOWN) | (sizes < 0))
    if len(wrong):
        problem = 'chunk ends within a record'
        if topics[wrong[0]] == _UNKNOWN:
            problem = f'message of the unknown channel {channels[wrong[0]]}'
        raise mcap_scan.Torn(record.position, problem)
    wanted = topics >= 0
    log_times = heads['log_time'][wanted, 0]
    gathered.add_all(topics[wanted], log_times, places[wanted] + _FIXED, sizes[wanted], flat)
    return int(np.count_nonzero(wanted))


def _places(body: bytes, record: mcap_scan.Record) -> list[int]:
    """Find where the messages of a chunk begin; Torn unless its records fill it."""
    found: list[int] = []
    position, end, framed = 0, len(body), _FRAMED.unpack_from
    while position + _FIXED <= end:
        opcode, length = framed(body, position)
        if opcode == mcap_file.MESSAGE:
            found.append(position)
        elif opcode == 0:
            raise mcap_scan.Torn(record.position, 'chunk holds a record with opcode 0')
        position += _FRAME + length
    if position != end:
        _need_whole(body, position, record)
    return found


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


def _parted(
    topics: NDArray[np.int64], place: NDArray[np.int64], rows: NDArray[np.uint8], width: int
) -> Iterator[tuple[int, _Group]]:
    """Part messages of one size and width that are sorted by topic."""
    begins = np.flatnonzero(np.diff(topics, prepend=-1))
    ends = np.append(begins[1:], len(topics))
    stamp, numbers, alike = _cut(rows, width, begins, ends)
    for begin, end, is_cut in zip(begins.tolist(), ends.tolist(), alike, strict=True):
        cut = (stamp[begin:end], numbers[begin:end]) if is_cut else None
        yield int(topics[begin]), _Group(place[begin:end], rows[begin:end], cut)


def _cut(
    rows: NDArray[np.uint8], width: int, begins: NDArray[np.int64], ends: NDArray[np.int64]
) -> tuple[NDArray[np.int64], Array, list[bool]]:
    """
    Cut stamps and doubles out of messages of several topics; the last value tells of each topic
    whether its messages differ in nothing more than these.
    """
    size = rows.shape[1]
    doubles = size - 8 * width
    if doubles < _STAMP + 8:
        return np.zeros(0, dtype=np.int64), np.zeros((0, width)), [False] * len(begins)
    constant = (*range(_STAMP), *range(_STAMP + 8, doubles))  # encapsulation and frame
    head = rows[:, list(constant)]
    other = (head != np.repeat(head[begins], ends - begins, axis=0)).any(axis=1)
    alike = (rows[begins, 1] == 1) & ~np.logical_or.reduceat(other, begins)
    layout = np.dtype(
        {
            'names': ['sec', 'nanosec', 'numbers'],
            'formats': ['<i4', '<u4', ('<f8', (width,))],
            'offsets': [_STAMP, _STAMP + 4, doubles],
            'itemsize': size,
        }  # type: ignore[arg-type]  # numpy's own stubs do not know this form with subarrays
    )
    table = rows.reshape(-1).view(layout)
    stamp = 10**9 * table['sec'].astype(np.int64) + table['nanosec']
    return stamp, table['numbers'].astype(np.float64), alike.tolist()


def _columns(bag: Bag, name: str, kind: Any, groups: list[_Group]) -> Columns:
    """Put the messages of one topic together; they are decoded where they are not alike."""
    if not groups:
        width = sum(count for _, count in kind.PARTS)
        return Columns(np.zeros(0, dtype=np.int64), np.zeros((0, width)), '')
    try:
        opening = min(groups, key=lambda group: group.place[0])
        first: Any = cdr.decode(kind.TYPE, opening.rows[0].tobytes())
        if len(groups) == 1 and opening.cut is not None:
            return Columns(*opening.cut, first.frame_id)
        return _one_by_one(kind, groups, first.frame_id)
    except CdrError as error:
        raise damaged(bag.path, f'a message on {name}: {error}') from error


def _one_by_one(kind: Any, groups: list[_Group], frame_id: str) -> Columns:
    """Decode every message, in the order of their places."""
    rows = [row for group in groups for row in group.rows]
    order = np.argsort(np.concatenate([group.place for group in groups]))
    messages: list[Any] = [cdr.decode(kind.TYPE, rows[i].tobytes()) for i in order.tolist()]
    stamp = [10**9 * message.sec + message.nanosec for message in messages]
    numbers = [[x for part, _ in kind.PARTS for x in getattr(m, part)] for m in messages]
    return Columns(np.array(stamp, dtype=np.int64), np.array(numbers, dtype=np.float64), frame_id)
