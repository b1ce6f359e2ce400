# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A chunk: the body that joins many batches, and the index that finds each message in it.

The index is built by numpy over all messages at once. Without it rosbags reads no message at all,
in silence.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording.batch import Batch, TickLayout

_INDEX_OPCODE = 7


class Chunk(NamedTuple):
    """
    Message records of one chunk.

    body     : the records
    channels : (N,)  channel id of each message, in any order
    times    : (N,)  [ns] log time
    offsets  : (N,)  [bytes] place of its record in the body
    """

    body: bytes
    channels: NDArray[np.uint16]
    times: NDArray[np.int64]
    offsets: NDArray[np.int64]


def join(batches: Sequence[Batch]) -> Chunk:
    """Join batches into one chunk."""
    blocks: dict[TickLayout, tuple[list[int], list[int]]] = {}
    base = 0
    for layout, data, times, _ in batches:
        bases, tick_times = blocks.setdefault(layout, ([], []))
        bases.extend(range(base, base + len(data), layout.size))
        tick_times.extend(times)
        base += len(data)
    channels, log_times, offsets = [], [], []
    for layout, (bases, tick_times) in blocks.items():
        channels.append(np.tile(layout.channels, len(bases)))
        log_times.append(np.add.outer(np.array(tick_times, np.int64), layout.time_offsets).ravel())
        offsets.append(np.add.outer(np.array(bases, np.int64), layout.offsets).ravel())
    return Chunk(
        b''.join([batch.data for batch in batches]),
        np.concatenate(channels),
        np.concatenate(log_times),
        np.concatenate(offsets),
    )


def message_indexes(chunk: Chunk) -> tuple[bytes, NDArray[np.uint16], NDArray[np.int64]]:
    """
    Build the MessageIndex records of a chunk.

    Returns their bytes, the channel ids, and the place of each channel's record in the bytes.
    Channels with equally many messages have records of equal size, so that one structured array
    holds them all.
    """
    order = np.argsort(chunk.channels.astype(np.int64) << 48 | chunk.offsets)
    channels, times, offsets = chunk.channels[order], chunk.times[order], chunk.offsets[order]
    starts = np.flatnonzero(np.diff(channels, prepend=-1))
    counts = np.diff(starts, append=len(channels))
    records: list[bytes] = []
    ids, places, base = [], [], 0
    for count in sorted(set(counts.tolist())):
        first = starts[counts == count]
        entries = first[:, None] + np.arange(count)
        table = np.empty(len(first), _index_dtype(count))
        table['opcode'] = _INDEX_OPCODE
        table['length'] = 6 + 16 * count
        table['channel'] = channels[first]
        table['size'] = 16 * count
        table['entries']['time'] = times[entries]
        table['entries']['offset'] = offsets[entries]
        records.append(table.tobytes())
        ids.append(channels[first])
        places.append(base + np.arange(len(first)) * table.itemsize)
        base += table.nbytes
    return b''.join(records), np.concatenate(ids), np.concatenate(places)


def _index_dtype(count: int) -> np.dtype[np.void]:
    return np.dtype(
        [
            ('opcode', 'u1'),
            ('length', '<u8'),
            ('channel', '<u2'),
            ('size', '<u4'),
            ('entries', [('time', '<u8'), ('offset', '<u8')], (count,)),
        ]
    )
