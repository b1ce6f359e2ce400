# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
CDR bytes of `nav_msgs/msg/Odometry`.

After the stamp: frame_id, child_frame_id, zeros up to a multiple of eight from byte 4, then 85
doubles: position (3), orientation (4), covariance of the pose (36), linear velocity (3), angular
velocity (3), covariance of the twist (36). The pose is that of child_frame_id in frame_id, the
twist stands along the axes of child_frame_id. A covariance of zeros says that nothing is known
about it, which is how exact values are told.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct
from typing import ClassVar

from rigid_body_sim.recording.cdr_parts import PartReader, string, up

WIDTHS = {
    'position': 3,
    'orientation': 4,
    'pose_covariance': 36,
    'linear': 3,
    'angular': 3,
    'twist_covariance': 36,
}
COUNT = sum(WIDTHS.values())  # doubles of a message
UNKNOWN = (0.0,) * 36
_DOUBLES = {0: Struct(f'>{COUNT}d'), 1: Struct(f'<{COUNT}d')}

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Odometry:
    """
    Pose of child_frame_id in frame_id, and its twist along the axes of child_frame_id.

    position [m], orientation (unit quaternion xyzw), linear [m/s], angular [rad/s]; covariances
    row by row, of x, y, z and the rotations about them
    """

    TYPE: ClassVar[str] = 'nav_msgs/msg/Odometry'
    PARTS: ClassVar[tuple[tuple[str, int], ...]] = tuple(WIDTHS.items())

    sec: int
    nanosec: int
    frame_id: str
    child_frame_id: str
    position: Vector
    orientation: tuple[float, float, float, float]
    linear: Vector
    angular: Vector
    pose_covariance: tuple[float, ...] = UNKNOWN
    twist_covariance: tuple[float, ...] = UNKNOWN


def odometry_tail(frame_id: str, child_frame_id: str) -> bytes:
    """Bytes from 12 up to the doubles: both names and zeros."""
    names = string(frame_id)
    names = names.ljust(up(len(names), 4), b'\0') + string(child_frame_id)
    return names.ljust(up(len(names), 8), b'\0')


def odometry_doubles(message: Odometry) -> bytes:
    """Return the 85 doubles of a message, little endian."""
    return _DOUBLES[1].pack(*(value for name in WIDTHS for value in getattr(message, name)))


def read_odometry(payload: bytes, order: int, sec: int, nanosec: int) -> Odometry:
    """Read what follows the stamp; CdrError."""
    reader = PartReader(Odometry.TYPE, payload, order)
    names = reader.text(), reader.text()
    reader.align(8)
    values = _DOUBLES[order].unpack(reader.take(8 * COUNT))
    reader.need_end()
    parts, at = {}, 0
    for name, width in WIDTHS.items():
        parts[name] = values[at : at + width]
        at += width
    return Odometry(sec, nanosec, *names, **parts)
