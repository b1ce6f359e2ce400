# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is to be seen of an instant as one `visualization_msgs/MarkerArray`.

Every message is whole: all shapes and frames where they are then, in the world frame, and all
arrows. So it needs no transform, no message before it and no subscriber that was there from the
start: the last message before any instant of a bag shows that instant. What is dear about that,
the points of a mesh, is a constant of the template; less is sent by asking for fewer messages a
second.

    namespace       id                                 action
    shapes          place of the body in the scene     ADD
                    + number of bodies * part
    frames          count of named frames before it    ADD
    forces          place of the body in the scene     ADD while a force is commanded, then DELETE
                                                       once
    torques         the same                           the same, for torques
    contact_forces  from 0, in the order in which      ADD; DELETE for those that the last message
                    contacts were found                had more

An arrow is `metres` times as long as its force, but never longer than `longest`: an impact would
hide all else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from struct import Struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.cdr_parts import PartWriter, up
from rigid_body_sim.recording.template import MessageTemplate
from rigid_body_sim.recording.topics import Topic

Array = NDArray[np.float64]
Color = tuple[float, float, float, float]
Quaternion = tuple[float, float, float, float]
Vector = tuple[float, float, float]

ARROW, CUBE, SPHERE, CYLINDER = range(4)  # visualization_msgs/msg/Marker
LINE_LIST, SPHERE_LIST, TRIANGLE_LIST = 5, 7, 11
ADD, DELETE = 0, 2

SHAPES, FRAMES, FORCES, TORQUES, CONTACT_FORCES = (
    *('shapes', 'frames'),
    *('forces', 'torques', 'contact_forces'),
)
_COLORS: dict[str, Color] = {
    FORCES: (0.90, 0.25, 0.10, 1.0),
    TORQUES: (0.20, 0.35, 0.90, 1.0),
    CONTACT_FORCES: (0.95, 0.75, 0.05, 1.0),
}
_SHAFT, _HEAD_WIDTH, _HEAD_LENGTH = 0.06, 0.14, 0.2  # [-] of the reference length of arrows
_ENDS = Struct('<6d')
_TIME = Struct('<iI')
_WORD = Struct('<I')
_GAP = bytes(3)  # behind the last field of a marker, which is one byte, if another follows
_IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
_ORIGIN: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Form:
    """
    One marker that goes with a body.

    body        : place in the scene
    position    : (3,) [m]  of the marker as seen from the centre of mass, body axes
    orientation : (4,) [-]  unit quaternion xyzw, axes of the marker to body axes
    scale       : (3,)      as its type reads it
    points      : (k, 3) [m]  axes of the marker; colors: (k, 4), of the points, or none
    """

    namespace: str
    number: int
    body: int
    kind: int
    scale: Vector
    color: Color
    position: Vector = _ORIGIN
    orientation: Quaternion = _IDENTITY
    points: Array | None = None
    colors: Array | None = None


class Arrows(NamedTuple):
    """
    What acts at one instant, world axes.

    center        : (n, 3) [m]  centre of mass of every body
    force, torque : (n, 3) [N], [N m]  commanded, of every body
    point         : (m, 3) [m]  of each contact
    contact_force : (m, 3) [N]  on a body that can move
    """

    center: Array
    force: Array
    torque: Array
    point: Array
    contact_force: Array


_NO_ARROWS = Arrows(*[np.zeros((0, 3))] * 5)


class Poses(NamedTuple):
    """
    Where the markers of the forms stand, in their order.

    position    : (m, 3) [m]  world
    orientation : (m, 4) [-]  unit quaternions xyzw, axes of the marker to world
    """

    position: Array
    orientation: Array


@dataclass(frozen=True)
class Scale:
    """
    How long arrows are.

    metres_per_newton, metres_per_newton_metre : [m/N], [m/(N m)]
    reference                                  : [m] usual length; thickness follows from it
    longest                                    : [m]
    """

    metres_per_newton: float
    metres_per_newton_metre: float
    reference: float
    longest: float


@dataclass(frozen=True)
class Shown:
    """
    The arrows of the last message: what the next one has to delete depends on it.

    forces, torques : places of the bodies
    contacts        : how many
    """

    forces: frozenset[int] = frozenset()
    torques: frozenset[int] = frozenset()
    contacts: int = 0


class MarkerPacker:
    """
    Packs the markers of a scene.

    topics : the one it writes
    shown  : the arrows of the last packed message
    """

    def __init__(
        self,
        forms: Sequence[Form],
        *,
        topic: Topic,
        frame_id: str,
        scale: Scale,
        first_channel_id: int,
    ) -> None:
        self.topics = (topic,)
        self.shown = Shown()
        self._scale = scale
        writer, stamps, poses = PartWriter(), [], []
        self._count_at = writer.words(0)
        for form in forms:
            stamp, pose = _write_marker(writer, form, frame_id, action=ADD)
            stamps.append(stamp)
            poses.append(pose)
        self._fixed = len(forms)
        size = len(writer.content) - 4
        self._gap, self._phase = bytes(-size % 4), up(size, 4) % 8  # up to the first arrow
        self._template = MessageTemplate(
            topic, first_channel_id, payload=bytes(writer.content), stamps=stamps
        )
        places = self._template.places(poses, 7)
        self._positions, self._orientations = places[:, :3], places[:, 3:]
        self._arrows = {
            (namespace, action): tuple(
                _Arrow(namespace, action, frame_id, scale.reference, phase) for phase in (0, 4)
            )
            for namespace in _COLORS
            for action in (ADD, DELETE)
        }

    def pack(self, tick: int, time_ns: int, poses: Poses, arrows: Arrows) -> Batch:
        """Pack one instant, and remember its arrows."""
        batch, self.shown = self._packed(tick, time_ns, poses, arrows)
        return batch

    def pack_start(self, tick: int, time_ns: int, poses: Poses) -> Batch:
        """Pack an instant at which nothing acts yet; nothing is remembered."""
        return self._packed(tick, time_ns, poses, None)[0]

    def _packed(
        self, tick: int, time_ns: int, poses: Poses, arrows: Arrows | None
    ) -> tuple[Batch, Shown]:
        doubles = self._template.doubles
        doubles[self._positions] = poses.position
        doubles[self._orientations] = poses.orientation
        entries, shown = self._entries(_NO_ARROWS if arrows is None else arrows)
        words = self._template.words
        words[self._template.word(self._count_at)] = self._fixed + len(entries)
        stamp, phase = _TIME.pack(*divmod(time_ns, 1_000_000_000)), self._phase
        tail = []
        for namespace, number, ends in entries:
            tail.append(self._gap if not tail else _GAP)
            action = DELETE if ends is None else ADD
            arrow = self._arrows[namespace, action][phase // 4]
            tail.append(arrow.filled(stamp, number, ends))
            phase = (phase + len(tail[-1]) + len(_GAP)) % 8
        return self._template.batch(tick, time_ns, b''.join(tail)), shown

    def _entries(self, arrows: Arrows) -> tuple[list[tuple[str, int, list[float] | None]], Shown]:
        """Give namespace, id and both ends of every arrow, no ends where it is to be deleted."""
        scale, entries = self._scale, []
        found: dict[str, frozenset[int]] = {}
        for namespace, vectors, metres, before in (
            (FORCES, arrows.force, scale.metres_per_newton, self.shown.forces),
            (TORQUES, arrows.torque, scale.metres_per_newton_metre, self.shown.torques),
        ):
            acting = np.flatnonzero(vectors.any(axis=1))
            starts = arrows.center[acting]
            ends = starts + self._limited(vectors[acting], metres)
            both = dict(zip(acting.tolist(), np.hstack((starts, ends)).tolist()))
            found[namespace] = frozenset(both)
            entries += [(namespace, k, both.get(k)) for k in sorted(both.keys() | before)]
        steps = self._limited(arrows.contact_force, scale.metres_per_newton)
        both = np.hstack((arrows.point, arrows.point + steps)).tolist()
        both += [None] * (self.shown.contacts - len(both))
        entries += [(CONTACT_FORCES, k, ends) for k, ends in enumerate(both)]
        count = len(arrows.point)
        return entries, Shown(found[FORCES], found[TORQUES], count)

    def _limited(self, vectors: Array, metres: float) -> Array:
        """Give arrows (k, 3) [m] for vectors (k, 3)."""
        largest = np.max(np.abs(vectors), axis=1, initial=0.0, keepdims=True)
        direction = np.divide(vectors, largest, out=np.zeros_like(vectors), where=largest > 0.0)
        x, y, z = direction.T
        size = np.sqrt(x * x + y * y + z * z)[:, None]  # 1 to 1.7, or 0
        with np.errstate(over='ignore'):
            length = np.minimum(size * largest * metres, self._scale.longest)
        return np.divide(direction, size, out=np.zeros_like(vectors), where=size > 0.0) * length


class _Arrow:
    """The bytes of one arrow that begins `phase` bytes behind a multiple of eight."""

    def __init__(
        self, namespace: str, action: int, frame_id: str, reference: float, phase: int
    ) -> None:
        writer = PartWriter()
        writer.raw(bytes(phase))
        thickness = (
            _SHAFT * reference,
            _HEAD_WIDTH * reference,
            _HEAD_LENGTH * reference,
        )
        form = Form(
            *(namespace, 0, 0, ARROW, thickness, _COLORS[namespace]),
            points=np.zeros((2, 3)) if action == ADD else None,
        )
        places = _MarkerPlaces()
        _write_marker(writer, form, frame_id, action=action, places=places)
        begin = 4 + phase
        self._bytes = bytearray(writer.content[begin:])
        assert len(self._bytes) % 4 == 1  # the last field is one byte
        self._number_at, self._points_at = places.number - begin, places.points - begin

    def filled(self, stamp: bytes, number: int, ends: list[float] | None) -> bytes:
        """Give the marker of one arrow."""
        self._bytes[: len(stamp)] = stamp
        _WORD.pack_into(self._bytes, self._number_at, number)
        if ends is not None:
            _ENDS.pack_into(self._bytes, self._points_at, *ends)
        return bytes(self._bytes)


@dataclass
class _MarkerPlaces:
    """Where the id and the points of a marker begin."""

    number: int = 0
    points: int = 0


def _write_marker(
    writer: PartWriter,
    form: Form,
    frame_id: str,
    *,
    action: int,
    places: _MarkerPlaces | None = None,
) -> tuple[int, int]:
    """Write one marker; returns where its stamp and its pose begin."""
    stamp = writer.words(0, 0)
    writer.text(frame_id)
    writer.text(form.namespace)
    number = writer.words(form.number)
    writer.words(form.kind, action)
    pose = writer.doubles(*_ORIGIN, *_IDENTITY)
    writer.doubles(*form.scale)
    writer.floats(*form.color)
    writer.words(0, 0)  # lifetime: for ever
    writer.raw(b'\0')  # not locked to a frame
    points = np.zeros((0, 3)) if form.points is None else form.points
    writer.words(len(points))
    at = writer.align(8) if len(points) else 0
    writer.raw(points.astype('<f8').tobytes())
    colors = np.zeros((0, 4)) if form.colors is None else form.colors
    writer.words(len(colors))
    writer.raw(colors.astype('<f4').tobytes())
    writer.text('')  # texture_resource
    writer.words(0, 0)  # texture: stamp, frame, format, data
    writer.text('')
    writer.text('')
    writer.words(0)
    writer.words(0)  # uv_coordinates
    writer.text('')  # text
    writer.text('')  # mesh_resource
    writer.text('')  # mesh_file
    writer.words(0)
    writer.raw(b'\0')  # mesh_use_embedded_materials
    if places is not None:
        places.number, places.points = number, at
    return stamp, pose
