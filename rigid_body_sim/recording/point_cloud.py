# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
CDR bytes of `sensor_msgs/msg/PointCloud2` with float64 fields.

After frame_id, each number aligned to its own size:

    height, width, number of fields | each: name, offset, datatype, count | is_bigendian |
    point_step, row_step | number of bytes, the points | is_dense

Points are bytes of the message, so they are not aligned. DDS fills a message up to a multiple of
four bytes: up to three more are passed over at the end. Clouds with other kinds of fields are
refused: nobody here reads them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from struct import Struct
from typing import ClassVar

from rigid_body_sim.recording.cdr_parts import U32, PartReader, string

FLOAT64 = 8  # datatype of a point field: sensor_msgs/msg/PointField


@dataclass(frozen=True, slots=True)
class PointCloud2:
    """Points of float64 fields in the frame frame_id: `points[k][i]` is the field `names[i]`."""

    TYPE: ClassVar[str] = 'sensor_msgs/msg/PointCloud2'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = ()

    sec: int
    nanosec: int
    frame_id: str
    names: tuple[str, ...]
    points: tuple[tuple[float, ...], ...]


def cloud_tail(frame_id: str, names: Sequence[str], points: bytes) -> bytes:
    """Bytes from 12 on of a cloud with the given float64 fields and points (little endian)."""
    step = 8 * len(names)
    width = len(points) // step if step else 0
    parts = bytearray(string(frame_id))
    parts += bytes(-len(parts) % 4) + U32[1].pack(1) + U32[1].pack(width)
    parts += U32[1].pack(len(names))
    for index, name in enumerate(names):
        parts += string(name)
        parts += bytes(-len(parts) % 4) + U32[1].pack(8 * index) + bytes((FLOAT64,))
        parts += bytes(-len(parts) % 4) + U32[1].pack(1)
    parts += b'\0' + bytes(-(len(parts) + 1) % 4)  # little endian
    parts += U32[1].pack(step) + U32[1].pack(len(points)) + U32[1].pack(len(points))
    return bytes(parts) + points + b'\1'  # dense: no point is invalid


class CloudReader(PartReader):
    """Reads a cloud piece by piece: strings and lists of any length lie before its points."""

    def __init__(self, payload: bytes, order: int) -> None:
        super().__init__(PointCloud2.TYPE, payload, order)
        self._size = len(payload)

    def read(self, sec: int, nanosec: int) -> PointCloud2:
        """Read what follows the stamp."""
        frame_id = self.text()
        height, width, count = self.u32(), self.u32(), self.u32()
        self.need(count <= self._size, f'{count} fields')
        names = tuple(self._field(8 * index) for index in range(count))
        order = '>' if self.byte() else '<'
        step, row, size = self.u32(), self.u32(), self.u32()
        self.need(
            step == 8 * count and row == step * width and size == row * height,
            f'steps {step} and {row} and {size} bytes for {height} x {width} points',
        )
        points = self.take(size)
        self.byte()
        more = self.left
        self.need(more < 4 and (more == 0 or self._size % 4 == 0), f'{more} bytes more')
        rows = Struct(f'{order}{count}d').iter_unpack(points) if size else ()
        return PointCloud2(sec, nanosec, frame_id, names, tuple(rows))

    def _field(self, place: int) -> str:
        name, offset, datatype, count = self.text(), self.u32(), self.byte(), self.u32()
        self.need(
            (offset, datatype, count) == (place, FLOAT64, 1),
            f'field {name!r} at {offset} of type {datatype}, count {count}; read are single '
            f'float64 fields without gaps (here: at {place}, type {FLOAT64}, count 1)',
        )
        return name
