# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The motion in a bag as arrays: one track per body, thinned evenly to what a picture can show.

Any bag with `…/pose` (PoseStamped) and `…/twist` (TwistStamped) topics can be read; times are
those of the stamps.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from rigid_body_sim.analysis.recorded_contacts import (
    contact_topics,
    read_points,
    scene_has_contact,
)
from rigid_body_sim.analysis.recorded_impacts import impact_topic, read_impacts
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.state.impacts import Impacts
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.columns import need_time_forward
from rigid_body_sim.recording.contact_packing import FORCE
from rigid_body_sim.recording.every_body import with_every_body
from rigid_body_sim.recording.topics import Topic

Array = NDArray[np.float64]

WRENCH_BYTES = 48  # force and torque at the end of a WrenchStamped payload
NO_WRENCH = bytes(WRENCH_BYTES)
# behind the four bytes of a payload that say which
_STAMP, _STAMP_BIG = Struct('<iI'), Struct('>iI')
_NO_TIME, _NO_VECTORS = np.empty(0), np.empty((0, 3))


@dataclass(frozen=True, eq=False)
class Track:
    """
    One body through time; in bags of other recorders the velocities may have times of their own.

    time                       : (k,) [s]
    position, orientation      : (k, 3) [m], (k, 4) [-] xyzw, world
    twist_time                 : (j,) [s]
    velocity, angular_velocity : (j, 3) [m/s], (j, 3) [rad/s], world axes
    wrench_time                : (w,) [s]  starts of the ticks over which a command acted
    force, torque              : (w, 3) [N], (w, 3) [N m]  at the centre of mass, world axes
    """

    name: str
    time: Array
    position: Array
    orientation: Array
    twist_time: Array
    velocity: Array
    angular_velocity: Array
    wrench_time: Array = field(default_factory=_NO_TIME.copy)
    force: Array = field(default_factory=_NO_VECTORS.copy)
    torque: Array = field(default_factory=_NO_VECTORS.copy)


@dataclass(frozen=True, eq=False)
class Load:
    """
    What touches a body through time.

    time  : (k,) [s]  of its messages: none while nothing touches it
    force : (k,) [N]  sum of the magnitudes over its contact points, mean over a tick
    """

    time: Array
    force: Array


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """
    Every body of a bag.

    tracks       : in the order of the bag's topics
    command_time : (c,) [s]  starts of the ticks on which a command acted, ascending
    loads        : what touching others exerts, by body; empty: not recorded; None: bodies pass
                   through each other
    touching     : of a run that goes on: at each instant the contacts that each body was told of,
                   rows as `recording.contact_packing` has them; None: no topic tells contacts
    impacts      : at their instants; None: no topic tells them
    beyond       : [s] first instant that is left out as nothing can draw it (`drawn_part`); None:
                   it is whole
    began        : (b,) [s] when the scene began, ascending: at t = 0 or at the reset before (see
                   `analysis.scene_begin`), and of a run that goes on at each reset since; of
                   earlier instants nobody knows it, and time counts from t = 0
    """

    tracks: tuple[Track, ...]
    command_time: Array
    loads: dict[str, Load] | None = None
    touching: tuple[Mapping[str, Array], ...] | None = None
    impacts: Impacts | None = None
    beyond: float | None = None
    began: tuple[float, ...] = (0.0,)

    def passed(self, time: Array) -> Array:
        """Give instants [s], which are whole nanoseconds, since the scene began."""
        if not any(self.began):
            return time
        began = np.array((0.0, *self.began))
        last = np.searchsorted(began, time, side='right') - 1
        return np.round((time - began[np.maximum(last, 0)]) * 1e9) / 1e9

    @property
    def begin_is_known(self) -> bool:
        """Whether somebody told when the scene of the first instant began."""
        first = min(track.time[0] for track in self.tracks)
        return bool(self.began) and self.began[0] <= first


def read_motion(bag: Bag, *, samples: int) -> RecordedMotion:
    """
    Read the motion of every body.

    samples : at most about so many instants of each body are kept, first and last among them; of
              the wrenches of a stretch the largest, so that a short one is not lost
    """
    bag = with_every_body(bag)
    poses = {name: t for name, t in bag.topics.items() if _is(t, 'pose', cdr.PoseStamped.TYPE)}
    twists = {name: t for name, t in bag.topics.items() if _is(t, 'twist', cdr.TwistStamped.TYPE)}
    wrenches = {
        name for name, t in bag.topics.items() if _is(t, 'applied_wrench', cdr.WrenchStamped.TYPE)
    }
    impulses = {
        name for name, t in bag.topics.items() if _is(t, 'impulse', cdr.WrenchStamped.TYPE)
    }
    kept: dict[str, list[bytes]] = {name: [] for name in (*poses, *twists)}
    stamps = {name: array('q') for name in kept}  # [ns] also of those that are not kept
    seen = dict.fromkeys((*kept, *wrenches), 0)
    pushed: dict[str, dict[int, bytes]] = {name: {} for name in wrenches}
    commands: set[int] = set()
    touching = contact_topics(bag)
    loads: dict[str, list[tuple[float, float]]] = {name: [] for name in touching}
    wanted = {*kept, *wrenches, *impulses, *touching}
    total = sum(bag.counts.get(name, 0) for name in wanted)
    for message in tqdm(bag.messages_by_time(wanted), total=total, unit=' messages', disable=None):
        name = message.topic
        if name in kept:
            place, count = seen[name], bag.counts[name]
            stamps[name].append(_stamp(message.data))
            if place % -(-count // samples) == 0 or place == count - 1:
                kept[name].append(message.data)
            seen[name] = place + 1
        elif name in touching:
            forces = read_points(message.data)[:, FORCE]
            load = float(np.sum(np.linalg.norm(forces, axis=1)))
            loads[name].append((message.log_time / 1e9, load))
        elif name in impulses or message.data[-WRENCH_BYTES:] != NO_WRENCH:
            commands.add(message.log_time)
        if name in wrenches:
            poses_of = name.removesuffix('applied_wrench') + 'pose'  # stretches are between these
            stretch = seen[name] // -(-bag.counts.get(poses_of, bag.counts[name]) // samples)
            before = pushed[name].get(stretch)
            if before is None or _strength(message.data) > _strength(before):
                pushed[name][stretch] = message.data
            seen[name] += 1
    for name, times in stamps.items():
        need_time_forward(np.array(times), f'{bag.path}: {name}', reordered=name in bag.reordered)
    tracks = [
        track_of(
            name,
            kept[name],
            kept.get(name.removesuffix('pose') + 'twist', []),
            list(pushed.get(name.removesuffix('pose') + 'applied_wrench', {}).values()),
        )
        for name in poses
        if kept[name]
    ]
    if not tracks:
        raise UserError(
            f'{bag.path}: holds no poses to draw; expected messages of {cdr.PoseStamped.TYPE} '
            'on topics that end in /pose'
        )
    return RecordedMotion(
        _from_zero(tracks, bag),
        np.array(sorted(commands), dtype=float) / 1e9,
        {touching[name]: _load(rows, samples) for name, rows in loads.items()}
        if touching or scene_has_contact(bag)
        else None,
        impacts=None if impact_topic(bag) is None else read_impacts(bag),
    )


def _stamp(data: bytes) -> int:
    """Return the stamp [ns] of a message that begins with one."""
    sec, nanosec = (_STAMP if data[1] == 1 else _STAMP_BIG).unpack_from(data, 4)
    return 10**9 * sec + nanosec


def _load(rows: list[tuple[float, float]], samples: int) -> Load:
    """Thin to so many instants, each with the largest of the forces that it stands for."""
    time, force = np.array(rows, dtype=np.float64).reshape(-1, 2).T
    starts = np.arange(0, len(time), -(-len(time) // samples) if len(time) else 1)
    return Load(time[starts], np.maximum.reduceat(force, starts) if len(time) else force)


def _is(topic: Topic, leaf: str, type_name: str) -> bool:
    return topic.name.endswith(f'/{leaf}') and topic.type == type_name


def _strength(payload: bytes) -> float:
    """Sum of the squares of a wrench: zero for most of them, which is seen without reading."""
    numbers = payload[-WRENCH_BYTES:]
    return 0.0 if numbers == NO_WRENCH else float(np.sum(np.square(np.frombuffer(numbers))))


def track_of(topic: str, poses: list[bytes], twists: list[bytes], wrenches: list[bytes]) -> Track:
    """Read a body from the payloads of its messages; `topic` is that of its poses."""
    time, pose = _columns(cdr.PoseStamped, poses)
    twist_time, twist = _columns(cdr.TwistStamped, twists)
    wrench_time, wrench = _columns(cdr.WrenchStamped, wrenches)
    return Track(
        topic.split('/')[-2] or topic,
        time,
        pose[:, :3],
        pose[:, 3:],
        twist_time,
        twist[:, :3],
        twist[:, 3:],
        wrench_time,
        wrench[:, :3],
        wrench[:, 3:],
    )


def _columns(
    kind: type[cdr.PoseStamped | cdr.TwistStamped | cdr.WrenchStamped], payloads: list[bytes]
) -> tuple[Array, Array]:
    """Times [s] and numbers of payloads of one topic: at once where all are laid out alike."""
    width = sum(count for _, count in kind.PARTS)
    if not payloads:
        return np.empty(0), np.empty((0, width))
    size = len(payloads[0])
    cdr.decode(kind.TYPE, payloads[0])  # refuses what is no such message
    alike = all(len(payload) == size and payload[1] == 1 for payload in payloads)
    if not alike:
        messages: list[Any] = [cdr.decode(kind.TYPE, payload) for payload in payloads]
        stamps = np.array([10**9 * message.sec + message.nanosec for message in messages])
        rows = [[x for part, _ in kind.PARTS for x in getattr(m, part)] for m in messages]
        return stamps / 1e9, np.array(rows, dtype=np.float64)
    fields: Any = {
        'names': ['sec', 'nanosec', 'numbers'],
        'formats': ['<i4', '<u4', ('<f8', width)],
        'offsets': [4, 8, size - 8 * width],
        'itemsize': size,
    }
    layout = np.dtype(fields)
    table = np.frombuffer(b''.join(payloads), dtype=layout)
    stamps = 10**9 * table['sec'].astype(np.int64) + table['nanosec']
    return stamps / 1e9, table['numbers'].astype(np.float64)


def _from_zero(tracks: list[Track], bag: Bag) -> tuple[Track, ...]:
    """Count time from the first stamp in bags of other recorders; ours begin at zero."""
    if bag.holds_run:
        return tuple(tracks)
    start = min(track.time[0] for track in tracks)
    return tuple(
        replace(
            track,
            time=track.time - start,
            twist_time=track.twist_time - start,
            wrench_time=track.wrench_time - start,
        )
        for track in tracks
    )
