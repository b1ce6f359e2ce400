# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A batch: MCAP message records ready for the file, and where each message lies in them.

The records of one tick have fixed places, so a batch of many ticks is one block of bytes, one
`TickLayout` that describes a tick, and one time per tick. Nothing is done per message until a
chunk is closed, and then by numpy.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from struct import Struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording.topics import Topic

MESSAGE_OPCODE = 5
# opcode, length of the rest, channel id, sequence, log and publish time [ns]; then the payload
MESSAGE_HEAD = Struct('<BQHIQQ')
MESSAGE_HEAD_SIZE = MESSAGE_HEAD.size  # 31 bytes
MESSAGE_LENGTH_EXTRA = 22  # bytes of a message record that the length counts besides the payload


@dataclass(frozen=True, eq=False, slots=True)
class TickLayout:
    """
    Where the messages of one tick lie in its block of records.

    topics        : channel id of topics[i] is first_channel_id + i; not all need be in the tick
    channels      : (c,)  channel id of each message, in file order
    offsets       : (c,)  [bytes] start of each record in the tick's block
    time_offsets  : (c,)  [ns] log time of each message less the time of the tick
    payload_spans : (channel id, start, stop) of each CDR payload in the tick's block
    size          : [bytes] of the tick's block
    """

    topics: tuple[Topic, ...]
    first_channel_id: int
    channels: NDArray[np.uint16]
    offsets: NDArray[np.int64]
    time_offsets: NDArray[np.int64]
    payload_spans: tuple[tuple[int, int, int], ...]
    size: int

    @classmethod
    def of_records(
        cls,
        topics: tuple[Topic, ...],
        first_channel_id: int,
        *,
        channels: Sequence[int],
        sizes: Sequence[int],
        time_offsets: Sequence[int],
    ) -> TickLayout:
        """Lay out records of the given sizes [bytes] one after the other."""
        ends = np.cumsum(sizes)
        offsets = ends - sizes
        return cls(
            topics,
            first_channel_id,
            np.array(channels, np.uint16),
            offsets.astype(np.int64),
            np.array(time_offsets, np.int64),
            tuple(
                (channel, int(start) + MESSAGE_HEAD_SIZE, int(end))
                for channel, start, end in zip(channels, offsets, ends)
            ),
            int(ends[-1]),
        )


class Batch(NamedTuple):
    """
    Message records of one or more ticks.

    layout : the block of one tick
    data   : the blocks, one after the other
    times  : time of each tick [ns]
    tick   : number of ticks that are whole with this batch; None if it leaves a tick open
    """

    layout: TickLayout
    data: bytes
    times: Sequence[int]
    tick: int | None

    @property
    def message_count(self) -> int:
        """Number of messages."""
        return len(self.times) * len(self.layout.channels)

    def payloads(self) -> Iterator[tuple[int, bytes]]:
        """Yield (channel id, CDR payload) in file order: what a publisher sends."""
        for base in range(0, len(self.data), self.layout.size):
            block = self.data[base : base + self.layout.size] if base else self.data
            for channel, start, stop in self.layout.payload_spans:
                yield channel, block[start:stop]

    def records(self) -> Iterator[tuple[int, int, int, int, bytes]]:
        """Yield (channel id, sequence, log time, publish time, CDR payload) in file order."""
        for base in range(0, len(self.data), self.layout.size):
            for channel, start, stop in self.layout.payload_spans:
                head = MESSAGE_HEAD.unpack_from(self.data, base + start - MESSAGE_HEAD_SIZE)
                yield (channel, *head[3:], self.data[base + start : base + stop])
