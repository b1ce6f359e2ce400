# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at their instants as MCAP message records: one `sensor_msgs/PointCloud2` per published tick
in which, or since the one before which, there was any.

The topic `<node>/impacts` (`~/impacts` of the node) holds a point for each impact, in their order:

    x y z     [m]    where the surfaces met, world
    nx ny nz  [-]    unit normal from body a to body b, world axes
    jx jy jz  [N s]  impulse on b, world axes; a gets the opposite
    approach  [m/s]  speed at which they met, along the normal
    a b       [-]    the bodies: their places in the scene, from 0
    kind      [-]    0 impact of a pair, 1 the summed rest of a series of ever smaller ones,
                     2 joint impact of several pairs, 3 a cluster that did not settle
    sec nanosec      start of the tick of the simulation in which it happened
    remainder [s]    from there to its instant

The stamp is that of the states published with it; where a run or a recording ends between two
published ticks, that of its end. Nothing is written where nothing happened.
"""

from __future__ import annotations

from struct import Struct

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.batch import (
    MESSAGE_HEAD,
    MESSAGE_LENGTH_EXTRA,
    MESSAGE_OPCODE,
    Batch,
    TickLayout,
)
from rigid_body_sim.recording.point_cloud import cloud_tail
from rigid_body_sim.recording.topics import node_topic

Array = NDArray[np.float64]

LEAF = 'impacts'
FIELDS = (
    'x', 'y', 'z', 'nx', 'ny', 'nz', 'jx', 'jy', 'jz', 'approach', 'a', 'b', 'kind', 'sec',
    'nanosec', 'remainder',
)  # fmt: skip
POINT, NORMAL, IMPULSE, APPROACH = slice(0, 3), slice(3, 6), slice(6, 9), 9
BODIES, KIND, SECONDS, NANOSECONDS, REMAINDER = slice(10, 12), 12, 13, 14, 15
BILLION = 1_000_000_000
_STAMP = Struct('<iI')


class ImpactPacker:
    """
    Packs impacts.

    topics : what it writes: one, with the channel id `channel_id`
    """

    def __init__(
        self, *, node: str, dt_ns: int, namespace: str, frame_id: str, channel_id: int
    ) -> None:
        self.topics = (node_topic(namespace, f'{node}/{LEAF}', cdr.PointCloud2.TYPE),)
        self._channel_id, self._dt_ns, self._frame_id = channel_id, dt_ns, frame_id

    def pack(
        self,
        tick: int,
        *,
        tick_ns: NDArray[np.int64],
        remainder: Array,
        bodies: NDArray[np.int64],
        point: Array,
        normal: Array,
        impulse: Array,
        approach: Array,
        kind: NDArray[np.int64],
    ) -> Batch | None:
        """
        Pack the impacts up to one published tick; None where there are none.

        tick_ns   : (m,) [ns]   start of the tick of the simulation in which each happened
        remainder : (m,) [s]    from there to its instant
        bodies    : (m, 2) [-]  places in the scene of the first and the second body
        point, normal, impulse : (m, 3) [m], [-], [N s]  world axes; impulse on the second
        approach  : (m,) [m/s]
        kind      : (m,) [-]
        """
        if not len(remainder):
            return None
        points = np.empty((len(remainder), len(FIELDS)), dtype='<f8')
        points[:, POINT], points[:, NORMAL], points[:, IMPULSE] = point, normal, impulse
        points[:, APPROACH], points[:, BODIES], points[:, KIND] = approach, bodies, kind
        points[:, SECONDS], points[:, NANOSECONDS] = np.divmod(tick_ns, BILLION)
        points[:, REMAINDER] = remainder
        time_ns = tick * self._dt_ns
        stamp = _STAMP.pack(*divmod(time_ns, BILLION))
        payload = cdr.ENCAPSULATION + stamp
        payload += cloud_tail(self._frame_id, FIELDS, points.tobytes())
        head = MESSAGE_HEAD.pack(
            MESSAGE_OPCODE, len(payload) + MESSAGE_LENGTH_EXTRA, self._channel_id, tick, time_ns,
            time_ns,
        )  # fmt: skip
        layout = TickLayout.of_records(
            self.topics,
            self._channel_id,
            channels=[self._channel_id],
            sizes=[len(head) + len(payload)],
            time_offsets=[0],
        )
        return Batch(layout, head + payload, (time_ns,), None)


def impact_points(payload: bytes) -> Array:
    """Return the impacts of a message of an `impacts` topic, (k, number of FIELDS); CdrError."""
    cloud = cdr.decode(cdr.PointCloud2.TYPE, payload)
    assert isinstance(cloud, cdr.PointCloud2)
    if cloud.names != FIELDS:
        raise cdr.CdrError(
            f'{cloud.TYPE}: fields {" ".join(cloud.names)}, expected {" ".join(FIELDS)}'
        )
    return np.array(cloud.points, dtype=np.float64).reshape(-1, len(FIELDS))
