# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
CDR bytes of the messages that this package writes and reads, without ROS.

A payload starts with 4 encapsulation bytes (`00 01 00 00`: plain CDR, little endian). Alignment
counts from byte 4:

    4 int32 sec | 8 uint32 nanosec | 12 uint32 F | 16 frame_id, NUL (F bytes) | zeros | D doubles
    D = 4 + up(12 + F, 8)        up(x, a): x rounded up to a multiple of a

`Clock` ends after nanosec; `PointCloud2` is laid out in `point_cloud`, `Odometry` in `odometry`.
`encode` writes little endian with zeroed padding, so equal messages have equal bytes; `decode`
reads both byte orders and any padding, and refuses every other length or content with `CdrError`;
`canonical` keeps the bytes that came where they are those that `encode` would write. What is only
published for viewers (`DESCRIBED`) is read as its definition says, see `described`.

Source: OMG DDS-XTYPES 1.3, section 7.4 (plain CDR version 1). Not a general decoder: only the
types in `TYPES`.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct
from typing import ClassVar

from rigid_body_sim.recording.cdr_parts import U32, CdrError, require, text_of, up
from rigid_body_sim.recording.described import (
    Described,
    decode_described,
    encode_described,
    flat,
)
from rigid_body_sim.recording.odometry import (
    Odometry,
    odometry_doubles,
    odometry_tail,
    read_odometry,
)
from rigid_body_sim.recording.point_cloud import CloudReader, PointCloud2, cloud_tail

ENCAPSULATION = b'\x00\x01\x00\x00'

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_HEAD = {0: Struct('>iI'), 1: Struct('<iI')}
_DOUBLES = {
    (order, count): Struct(f'{"><"[order]}{count}d') for order in (0, 1) for count in (3, 6, 7)
}


@dataclass(frozen=True, slots=True)
class Clock:
    """Simulation time: sec [s] and nanosec [ns]."""

    TYPE: ClassVar[str] = 'rosgraph_msgs/msg/Clock'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = ()

    sec: int
    nanosec: int


@dataclass(frozen=True, slots=True)
class PoseStamped:
    """Position [m] and orientation (unit quaternion xyzw) in the frame frame_id."""

    TYPE: ClassVar[str] = 'geometry_msgs/msg/PoseStamped'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = (('position', 3), ('orientation', 4))

    sec: int
    nanosec: int
    frame_id: str
    position: Vector
    orientation: Quaternion


@dataclass(frozen=True, slots=True)
class TwistStamped:
    """Linear [m/s] and angular [rad/s] velocity along the axes of frame_id."""

    TYPE: ClassVar[str] = 'geometry_msgs/msg/TwistStamped'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = (('linear', 3), ('angular', 3))

    sec: int
    nanosec: int
    frame_id: str
    linear: Vector
    angular: Vector


@dataclass(frozen=True, slots=True)
class AccelStamped:
    """Linear [m/s^2] and angular [rad/s^2] acceleration along the axes of frame_id."""

    TYPE: ClassVar[str] = 'geometry_msgs/msg/AccelStamped'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = (('linear', 3), ('angular', 3))

    sec: int
    nanosec: int
    frame_id: str
    linear: Vector
    angular: Vector


@dataclass(frozen=True, slots=True)
class WrenchStamped:
    """Force [N] and torque [N m] (impulse topics: N s and N m s) along the axes of frame_id."""

    TYPE: ClassVar[str] = 'geometry_msgs/msg/WrenchStamped'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = (('force', 3), ('torque', 3))

    sec: int
    nanosec: int
    frame_id: str
    force: Vector
    torque: Vector


@dataclass(frozen=True, slots=True)
class Vector3Stamped:
    """One vector along the axes of frame_id; its meaning is the topic's."""

    TYPE: ClassVar[str] = 'geometry_msgs/msg/Vector3Stamped'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = (('vector', 3),)

    sec: int
    nanosec: int
    frame_id: str
    vector: Vector


Stamped = PoseStamped | TwistStamped | AccelStamped | WrenchStamped | Vector3Stamped
Message = Clock | Stamped | PointCloud2 | Odometry | Described

POSE_ARRAY = 'geometry_msgs/msg/PoseArray'
TWIST_ARRAY = 'sensor_msgs/msg/MultiDOFJointState'  # the standard type with names and twists
TRANSFORMS = 'tf2_msgs/msg/TFMessage'
MARKERS = 'visualization_msgs/msg/MarkerArray'
DESCRIBED = (POSE_ARRAY, TWIST_ARRAY, TRANSFORMS, MARKERS)

TYPES: dict[str, type[Message]] = {
    kind.TYPE: kind
    for kind in (
        Clock,
        PoseStamped,
        TwistStamped,
        AccelStamped,
        WrenchStamped,
        Vector3Stamped,
        PointCloud2,
        Odometry,
    )
} | dict.fromkeys(DESCRIBED, Described)


def header_tail(frame_id: str) -> bytes:
    """
    Bytes 12 to D of a stamped message: the length word, the frame's name, its NUL, and zeros.

    They do not change from message to message: templates copy them.
    """
    name = frame_id.encode()
    if b'\0' in name:
        raise CdrError(f'frame_id {frame_id!r} contains NUL; a CDR string cannot hold it')
    length = len(name) + 1
    return (U32[1].pack(length) + name).ljust(up(12 + length, 8) - 8, b'\0')


def encode(message: Message) -> bytes:
    """Return the little-endian payload of a message, padding zeroed."""
    if isinstance(message, Described):
        return ENCAPSULATION + encode_described(message)
    try:
        head = ENCAPSULATION + _HEAD[1].pack(message.sec, message.nanosec)
    except Exception as error:
        stamp = (message.sec, message.nanosec)
        raise CdrError(f'{message.TYPE}: stamp {stamp} is not (int32, uint32)') from error
    if isinstance(message, Clock):
        return head
    if isinstance(message, PointCloud2):
        points = b''.join(Struct(f'<{len(point)}d').pack(*point) for point in message.points)
        return head + cloud_tail(message.frame_id, message.names, points)
    if isinstance(message, Odometry):
        names = odometry_tail(message.frame_id, message.child_frame_id)
        return head + names + odometry_doubles(message)
    values = [value for name, _ in message.PARTS for value in getattr(message, name)]
    return head + header_tail(message.frame_id) + _DOUBLES[1, len(values)].pack(*values)


def decode(type_name: str, payload: bytes) -> Message:
    """
    Read one payload, strictly.

    Raises CdrError for an unknown type, a truncated or overlong payload, and text that is not
    UTF-8 with one NUL at its end.
    """
    kind = TYPES.get(type_name)
    if kind is None:
        raise CdrError(f'{type_name}: unknown type; known: {", ".join(TYPES)}')
    size = len(payload)
    require(size >= 4, type_name, f'{size} bytes, but the encapsulation alone has 4')
    order = payload[1]
    require(
        payload[0] == 0 and order <= 1,
        type_name,
        f'encapsulation {bytes(payload[:2]).hex(" ")}, allowed: 00 00 and 00 01 (plain CDR)',
    )
    if kind is Described:
        return decode_described(type_name, payload, order)
    require(size >= 12, type_name, f'{size} bytes, but the stamp ends at byte 12')
    sec, nanosec = _HEAD[order].unpack_from(payload, 4)
    if kind is Clock:
        require(size == 12, type_name, f'{size} bytes, expected 12')
        return Clock(sec, nanosec)
    require(size >= 16, type_name, f'{size} bytes, but the length of frame_id ends at byte 16')
    if kind is PointCloud2:
        return CloudReader(payload, order).read(sec, nanosec)
    if kind is Odometry:
        return read_odometry(payload, order, sec, nanosec)
    (length,) = U32[order].unpack_from(payload, 12)
    start = 4 + up(12 + length, 8)
    count = sum(width for _, width in kind.PARTS)
    require(
        size == start + 8 * count,
        type_name,
        f'{size} bytes, expected {start + 8 * count} with a frame_id of {length} bytes',
    )
    frame_id = text_of(payload[16 : 16 + length], type_name)
    values = _DOUBLES[order, count].unpack_from(payload, start)
    if count == 3:
        return Vector3Stamped(sec, nanosec, frame_id, values)
    return kind(sec, nanosec, frame_id, values[:3], values[3:])  # type: ignore[call-arg]


def canonical(message: Message, payload: bytes) -> bytes:
    """
    Return what `encode` would write for a payload that was decoded: the payload itself, if it is
    little endian and its encapsulation options and padding are zero, as most senders write it.

    What a sender left in the padding is not kept: it is whatever its memory held, and would make
    equal messages differ.
    """
    if isinstance(message, PointCloud2 | Odometry | Described):  # padding in more places than one
        ours = encode(message)
        return payload if payload == ours else ours
    if payload[:4] == ENCAPSULATION:
        if isinstance(message, Clock):
            return payload
        (length,) = U32[1].unpack_from(payload, 12)
        end = 16 + length
        if length and not any(payload[end : 4 + up(12 + length, 8)]):
            return payload
    return encode(message)


def fields(message: Message) -> dict[str, int | float | str]:
    """Every scalar of a message by its name, in the order of the bytes: `position.x` and so on."""
    if isinstance(message, Described):
        return flat(message.values)
    named: dict[str, int | float | str] = {
        'stamp.sec': message.sec,
        'stamp.nanosec': message.nanosec,
    }
    if not isinstance(message, Clock):
        named['frame_id'] = message.frame_id
    if isinstance(message, PointCloud2):
        named |= {'fields': ' '.join(message.names), 'width': len(message.points)}
        for index, point in enumerate(message.points):
            named |= {f'points[{index}].{n}': x for n, x in zip(message.names, point)}
    if isinstance(message, Odometry):
        named['child_frame_id'] = message.child_frame_id
    for part, width in message.PARTS:
        axes = 'xyzw' if width <= 4 else range(width)
        for axis, value in zip(axes, getattr(message, part)):
            named[f'{part}.{axis}'] = value
    return named
