# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contacts of a published tick as MCAP message records: one `sensor_msgs/PointCloud2` per body.

The topic `<body>/contacts` of a movable body holds a point for each of its contacts; a contact
between two movable bodies is told on both topics, each time as that body feels it.

    x y z     [m]  where they touch, midway between the surfaces, world
    nx ny nz  [-]  unit normal into this body, world axes
    gap       [m]  distance of the surfaces; negative: they overlap
    fx fy fz  [N]  mean force on this body over the last tick (impulse / dt), world axes
    other     [-]  which body it touches: its place in the scene, from 0

A body without contacts gets no message, but one empty message on the first published tick after
its last contact, so that a listener knows that it let go. Stamp and sequence are those of the
poses of the same tick, and the records lie before them: a tick that is whole has its contacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from struct import Struct

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.batch import (
    MESSAGE_HEAD,
    MESSAGE_HEAD_SIZE,
    MESSAGE_LENGTH_EXTRA,
    MESSAGE_OPCODE,
    Batch,
    TickLayout,
)
from rigid_body_sim.recording.cdr_parts import U32, string, up
from rigid_body_sim.recording.point_cloud import cloud_tail
from rigid_body_sim.recording.topics import body_topic

Array = NDArray[np.float64]

LEAF = 'contacts'
FIELDS = ('x', 'y', 'z', 'nx', 'ny', 'nz', 'gap', 'fx', 'fy', 'fz', 'other')
POINT, NORMAL, GAP, FORCE, OTHER = slice(0, 3), slice(3, 6), 6, slice(7, 10), 10
POINT_SIZE = 8 * len(FIELDS)  # [bytes]
_STAMP = Struct('<iI')


class ContactPacker:
    """
    Packs the contacts of movable bodies.

    topics   : what it writes; the channel id of topics[i] is first_channel_id + i
    touching : bodies (places in the scene) that had contacts at the last packed tick; what is
               written next depends on it
    """

    def __init__(
        self,
        bodies: Sequence[str],
        *,
        movable: Sequence[bool],
        dt_ns: int,
        namespace: str = '',
        frame_id: str = 'world',
        first_channel_id: int,
    ) -> None:
        self._movable = np.array(movable, dtype=bool)
        places = [place for place in range(len(bodies)) if movable[place]]
        self.topics = tuple(
            body_topic(namespace, bodies[place], LEAF, cdr.PointCloud2.TYPE) for place in places
        )
        self.touching: frozenset[int] = frozenset()
        self._channels = {place: first_channel_id + i for i, place in enumerate(places)}
        self._first_channel_id = first_channel_id
        self._dt_ns = dt_ns
        tail = cloud_tail(frame_id, FIELDS, b'')
        self._start = cdr.ENCAPSULATION + bytes(_STAMP.size) + tail[:-9]  # up to the row's length
        self._width_at = 12 + up(len(string(frame_id)), 4) + 4

    def pack(
        self,
        tick: int,
        *,
        bodies: NDArray[np.int64],
        point: Array,
        normal: Array,
        gap: Array,
        force: Array,
    ) -> Batch | None:
        """
        Pack the contacts of one published tick; None where there is nothing to say.

        bodies : (m, 2) [-]  places in the scene of the first and the second body
        point  : (m, 3) [m]  world
        normal : (m, 3) [-]  from the first to the second, world axes
        gap    : (m,)   [m]
        force  : (m, 3) [N]  on the second, world axes
        """
        owners, points = self._of_each_body(bodies, point, normal, gap, force)
        counts = np.bincount(owners)
        found = {place: int(counts[place]) for place in np.flatnonzero(counts).tolist()}
        told = sorted(found.keys() | self.touching)
        self.touching = frozenset(found)
        if not told:
            return None
        time_ns = tick * self._dt_ns
        content, at, records = points.tobytes(), 0, []
        for place in told:
            end = at + POINT_SIZE * found.get(place, 0)
            records.append(self._record(self._channels[place], tick, time_ns, content[at:end]))
            at = end
        layout = TickLayout.of_records(
            self.topics,
            self._first_channel_id,
            channels=[self._channels[place] for place in told],
            sizes=[len(record) for record in records],
            time_offsets=[0] * len(told),
        )
        return Batch(layout, b''.join(records), (time_ns,), None)

    def _of_each_body(
        self, bodies: NDArray[np.int64], point: Array, normal: Array, gap: Array, force: Array
    ) -> tuple[NDArray[np.int64], Array]:
        """Tell every contact from both sides; rows ordered by body, then as they were found."""
        count = len(gap)
        owners = np.concatenate((bodies[:, 1], bodies[:, 0]))
        points = np.empty((2 * count, len(FIELDS)), dtype='<f8')
        points[:, POINT] = np.concatenate((point, point))
        points[:, NORMAL] = np.concatenate((normal, -normal))
        points[:, GAP] = np.concatenate((gap, gap))
        points[:, FORCE] = np.concatenate((force, -force))
        points[:, OTHER] = np.concatenate((bodies[:, 0], bodies[:, 1]))
        kept = np.flatnonzero(self._movable[owners])
        order = kept[np.argsort(owners[kept], kind='stable')]
        return owners[order], points[order]

    def _record(self, channel: int, tick: int, time_ns: int, points: bytes) -> bytes:
        payload = bytearray(self._start)
        _STAMP.pack_into(payload, 4, *divmod(time_ns, 1_000_000_000))
        U32[1].pack_into(payload, self._width_at, len(points) // POINT_SIZE)
        size = len(payload) + 8 + len(points) + 1
        head = MESSAGE_HEAD.pack(
            MESSAGE_OPCODE, size + MESSAGE_LENGTH_EXTRA, channel, tick, time_ns, time_ns
        )
        lengths = U32[1].pack(len(points)) * 2  # of the row, and of all rows
        assert len(head) == MESSAGE_HEAD_SIZE
        return head + payload + lengths + points + b'\1'


def cloud_points(cloud: cdr.PointCloud2) -> Array:
    """Return the points of a message of a `contacts` topic, (k, number of FIELDS); CdrError."""
    if cloud.names != FIELDS:
        raise cdr.CdrError(
            f'{cloud.TYPE}: fields {" ".join(cloud.names)}, expected {" ".join(FIELDS)}'
        )
    return np.array(cloud.points, dtype=np.float64).reshape(-1, len(FIELDS))
