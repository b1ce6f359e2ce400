# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Poses and twists of a published tick once more, as viewers and controllers ask for them.

    <body>/odom  nav_msgs/Odometry             pose in the world frame, twist in the axes of the
                                               child frame, which is the body; covariances are zero
    /tf          tf2_msgs/TFMessage            world frame to each body, body to each of its frames
    poses        geometry_msgs/PoseArray       every body, scene order, world
    twists       sensor_msgs/MultiDOFJointState  every body by its name, scene order, world axes;
                                               its lists of transforms and wrenches are empty

There is no array of twists among the standard types; `MultiDOFJointState` has one beside names,
and every installation has it. The frame of a body has its origin in the centre of mass.

Everything that never changes is written once; a tick writes stamps and doubles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

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
from rigid_body_sim.recording.cdr_parts import PartWriter
from rigid_body_sim.recording.odometry import COUNT, odometry_tail
from rigid_body_sim.recording.template import MessageTemplate
from rigid_body_sim.recording.topics import Topic, body_topic, node_topic

Array = NDArray[np.float64]

TF_TOPIC = '/tf'
_STAMP_AT = MESSAGE_HEAD_SIZE + 4  # [bytes] of a record
_DOUBLES_AT = _STAMP_AT + 8  # less the names
_TWIST_AT = 8 * (3 + 4 + 36)  # [bytes] from the first double of an odometry to its twist


class Motions(NamedTuple):
    """
    How bodies move at one instant.

    position         : (n, 3) [m]      centre of mass, world
    orientation      : (n, 4) [-]      unit quaternions xyzw, body to world
    velocity         : (n, 3) [m/s]    centre of mass, world
    angular_velocity : (n, 3) [rad/s]  world axes
    """

    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array

    def of(self, places: NDArray[np.int64]) -> Motions:
        """Give those of some bodies."""
        return Motions(*(array[places] for array in self))


class OdometryPacker:
    """
    One message per body.

    Records of equal size lie together: those of one size are one array of records.

    topics : in the order of the bodies; the channel id of topics[i] is first_channel_id + i
    """

    def __init__(
        self,
        bodies: Sequence[str],
        *,
        namespace: str,
        frame_id: str,
        frame_prefix: str,
        first_channel_id: int,
    ) -> None:
        self.topics = tuple(
            body_topic(namespace, body, 'odom', cdr.Odometry.TYPE) for body in bodies
        )
        tails = [odometry_tail(frame_id, frame_prefix + body) for body in bodies]
        order = sorted(range(len(bodies)), key=lambda place: len(tails[place]))
        sizes = [_DOUBLES_AT + len(tails[place]) + 8 * COUNT for place in order]
        self._block = bytearray()
        for place, size in zip(order, sizes):
            length = size - MESSAGE_HEAD_SIZE + MESSAGE_LENGTH_EXTRA
            channel = first_channel_id + place
            record = MESSAGE_HEAD.pack(MESSAGE_OPCODE, length, channel, 0, 0, 0)
            record += cdr.ENCAPSULATION + bytes(8) + tails[place]
            self._block += record.ljust(size, b'\0')
        self._groups: list[tuple[NDArray[np.void], NDArray[np.int64]]] = []
        places, all_sizes, begin = np.array(order, np.int64), np.array(sizes, np.int64), 0
        for size in sorted(set(sizes)):
            of_group = places[all_sizes == size]
            dtype = _odometry_dtype(size)
            rows = np.frombuffer(self._block, dtype, count=len(of_group), offset=begin)
            self._groups.append((rows, of_group))
            begin += size * len(of_group)
        self._layout = TickLayout.of_records(
            self.topics,
            first_channel_id,
            channels=[first_channel_id + place for place in order],
            sizes=sizes,
            time_offsets=[0] * len(order),
        )

    def pack(
        self,
        sequence: int,
        time_ns: int,
        motions: Motions,
        *,
        velocity_body: Array,
        angular_velocity_body: Array,
    ) -> Batch:
        """
        Pack the message of every body.

        velocity_body, angular_velocity_body : (n, 3) [m/s], [rad/s]  body axes
        """
        sec, nanosec = divmod(time_ns, 1_000_000_000)
        for rows, places in self._groups:
            rows['sequence'], rows['log_time'], rows['publish_time'] = sequence, time_ns, time_ns
            rows['sec'], rows['nanosec'] = sec, nanosec
            rows['position'] = motions.position[places]
            rows['orientation'] = motions.orientation[places]
            rows['linear'] = velocity_body[places]
            rows['angular'] = angular_velocity_body[places]
        return Batch(self._layout, bytes(self._block), (time_ns,), None)


def _odometry_dtype(size: int) -> np.dtype[np.void]:
    """Return the dtype of one record of an odometry with its changing parts alone."""
    start = size - 8 * COUNT
    fields: list[tuple[str, object, int]] = [
        ('sequence', '<u4', 11),
        ('log_time', '<u8', 15),
        ('publish_time', '<u8', 23),
        ('sec', '<i4', _STAMP_AT),
        ('nanosec', '<u4', _STAMP_AT + 4),
        ('position', ('<f8', (3,)), start),
        ('orientation', ('<f8', (4,)), start + 24),
        ('linear', ('<f8', (3,)), start + _TWIST_AT),
        ('angular', ('<f8', (3,)), start + _TWIST_AT + 24),
    ]
    names, formats, offsets = zip(*fields)
    return np.dtype(
        {
            'names': list(names),
            'formats': list(formats),
            'offsets': list(offsets),
            'itemsize': size,
        }  # type: ignore[arg-type]  # numpy's own stubs do not know this form with subarrays
    )


class TransformPacker:
    """
    All transforms in one message.

    frames : of each body, by name: position (3,) [m] and orientation (4,) [-] in the body, 7
             numbers
    topics : the one it writes
    """

    def __init__(
        self,
        bodies: Sequence[str],
        frames: Sequence[Mapping[str, Sequence[float]]],
        *,
        frame_id: str,
        frame_prefix: str,
        first_channel_id: int,
    ) -> None:
        self.topics = (Topic(TF_TOPIC, cdr.TRANSFORMS),)
        writer, stamps, numbers = PartWriter(), [], []
        writer.words(len(bodies) + sum(map(len, frames)))
        for body in bodies:
            stamps.append(writer.words(0, 0))
            writer.text(frame_id)
            writer.text(frame_prefix + body)
            numbers.append(writer.doubles(*[0.0] * 7))
        for body, own in zip(bodies, frames):
            for name, frame in own.items():
                stamps.append(writer.words(0, 0))
                writer.text(frame_prefix + body)
                writer.text(f'{frame_prefix}{body}/{name}')
                writer.doubles(*frame)
        self._template = MessageTemplate(
            self.topics[0], first_channel_id, payload=bytes(writer.content), stamps=stamps
        )
        places = self._template.places(numbers, 7)
        self._translation, self._rotation = places[:, :3], places[:, 3:]

    def pack(self, sequence: int, time_ns: int, motions: Motions) -> Batch:
        """Pack the transforms of every body and frame."""
        doubles = self._template.doubles
        doubles[self._translation] = motions.position
        doubles[self._rotation] = motions.orientation
        return self._template.batch(sequence, time_ns)


class ArrayPacker:
    """
    Poses and twists of all bodies, a message each.

    topics : those of the poses and of the twists
    """

    def __init__(
        self, bodies: Sequence[str], *, namespace: str, frame_id: str, first_channel_id: int
    ) -> None:
        self.topics = (
            node_topic(namespace, 'poses', cdr.POSE_ARRAY),
            node_topic(namespace, 'twists', cdr.TWIST_ARRAY),
        )
        count = len(bodies)
        poses, twists = PartWriter(), PartWriter()
        for writer in (poses, twists):
            writer.words(0, 0)
            writer.text(frame_id)
        poses.words(count)
        of_poses = poses.doubles(*[0.0] * 7 * count)
        twists.words(count)
        for body in bodies:
            twists.text(body)
        twists.words(0, count)
        of_twists = twists.doubles(*[0.0] * 6 * count)
        twists.words(0)
        self._poses, self._twists = (
            MessageTemplate(topic, channel, payload=bytes(writer.content), stamps=[4])
            for channel, (topic, writer) in enumerate(
                zip(self.topics, (poses, twists)), start=first_channel_id
            )
        )
        self._of_poses = _rows(self._poses, of_poses, count, 7)
        self._of_twists = _rows(self._twists, of_twists, count, 6)

    def pack(self, sequence: int, time_ns: int, motions: Motions) -> tuple[Batch, Batch]:
        """Pack both messages."""
        self._of_poses[:, :3] = motions.position
        self._of_poses[:, 3:] = motions.orientation
        self._of_twists[:, :3] = motions.velocity
        self._of_twists[:, 3:] = motions.angular_velocity
        return self._poses.batch(sequence, time_ns), self._twists.batch(sequence, time_ns)


def _rows(template: MessageTemplate, offset: int, count: int, width: int) -> Array:
    """View the doubles from a byte of the payload on as (count, width)."""
    first = int(template.places([offset], 1)[0, 0])
    return template.doubles[first : first + count * width].reshape(count, width)
