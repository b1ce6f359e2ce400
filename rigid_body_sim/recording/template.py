# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One large message as a template: a record of which only times, doubles and a tail change.

    pad | head of the record (31 bytes) | payload

The pad puts byte 4 of the payload, from which CDR counts its alignment, on a multiple of eight:
every double of the message can be written through one array of doubles, by its place.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording.batch import (
    MESSAGE_HEAD,
    MESSAGE_HEAD_SIZE,
    MESSAGE_LENGTH_EXTRA,
    MESSAGE_OPCODE,
    Batch,
    TickLayout,
)
from rigid_body_sim.recording.cdr_parts import up
from rigid_body_sim.recording.topics import Topic

_PAD = -(MESSAGE_HEAD_SIZE + 4) % 8
_START = _PAD + MESSAGE_HEAD_SIZE  # of the payload
_CACHED_LAYOUTS = 256  # cached layouts of tails; more only costs building them again


class MessageTemplate:
    """
    The message of one topic.

    payload : bytes of the message, with everything that never changes
    stamps  : where in the payload each stamp begins
    doubles : array of float64 that covers the message; `places` tells where a field lies in it
    words   : the same as uint32
    """

    def __init__(
        self, topic: Topic, channel: int, *, payload: bytes, stamps: Sequence[int]
    ) -> None:
        buffer = np.zeros(up(_START + len(payload), 8), np.uint8)
        buffer[_START : _START + len(payload)] = np.frombuffer(payload, np.uint8)
        self.doubles = buffer.view('<f8')
        self.words = buffer.view('<u4')
        self._topics = (topic,)
        self._channel = channel
        self._buffer = buffer
        self._size = len(payload)
        self._seconds = (_START + np.array(stamps, np.int64)) // 4
        self._layouts: dict[int, TickLayout] = {}

    @staticmethod
    def places(offsets: Sequence[int], width: int) -> NDArray[np.int64]:
        """Places (n, width) in `doubles` of fields that begin at some bytes of the payload."""
        return (_START + np.array(offsets, np.int64)[:, None]) // 8 + np.arange(width)

    @staticmethod
    def word(offset: int) -> int:
        """Place in `words` of a number that begins at a byte of the payload."""
        return (_START + offset) // 4

    def batch(self, sequence: int, time_ns: int, tail: bytes = b'') -> Batch:
        """
        Give the record as it is now, stamped.

        tail : what follows the payload of the template
        """
        size = self._size + len(tail)
        seconds, nanoseconds = divmod(time_ns, 1_000_000_000)
        self.words[self._seconds] = seconds
        self.words[self._seconds + 1] = nanoseconds
        MESSAGE_HEAD.pack_into(
            self._buffer,
            _PAD,
            *(MESSAGE_OPCODE, size + MESSAGE_LENGTH_EXTRA, self._channel),
            *(sequence, time_ns, time_ns),
        )
        data = self._buffer[_PAD : _START + self._size].tobytes() + tail
        return Batch(self._layout(len(data)), data, (time_ns,), None)

    def _layout(self, size: int) -> TickLayout:
        layout = self._layouts.get(size)
        if layout is None:
            if len(self._layouts) >= _CACHED_LAYOUTS:
                self._layouts.clear()
            layout = TickLayout.of_records(
                self._topics,
                self._channel,
                channels=[self._channel],
                sizes=[size],
                time_offsets=[0],
            )
            self._layouts[size] = layout
        return layout
