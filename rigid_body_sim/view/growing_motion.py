# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A motion that grows: messages come in any order, instants at which all bodies are known go out.

An instant is a stamp. It is whole when every body has its pose and, as far as they have topics for
it, its twist; those that are never whole, because somebody began to listen in the middle, are left
out. Contacts are told of bodies that have some, before the states of their tick: who hears them
in another order (`late`) waits for a later instant before one goes out. Impacts have instants of
their own: they go out as they came. Bodies without topics of their own are cut out of an array of
all, at the instants that go out.

On a topic of one run stamps never go back. Where one does, another run has begun, as of a node
that was started again or of a player in a loop: what came before it is forgotten.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields
from struct import Struct
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.analysis.recorded_contacts import read_points
from rigid_body_sim.analysis.recorded_impacts import impacts_of
from rigid_body_sim.physics.state import impacts
from rigid_body_sim.physics.state.impacts import Impacts
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.every_body import BodyArray
from rigid_body_sim.recording.impact_packing import impact_points
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track, track_of

Array = NDArray[np.float64]

_STAMP = Struct('<iI')  # behind the four bytes that begin every payload
SECOND = 10**9  # [ns]
MOST_ROWS = 100  # bodies times instants, for each of the instants that are asked for
OBJECT_BYTES = 112  # [byte] of an array besides its numbers
CONTACTS, IMPACTS = 'contacts', 'impacts'
KINDS = {
    'pose': cdr.PoseStamped.TYPE,
    'twist': cdr.TwistStamped.TYPE,
    'applied_wrench': cdr.WrenchStamped.TYPE,
    CONTACTS: cdr.PointCloud2.TYPE,
    IMPACTS: cdr.PointCloud2.TYPE,
}  # of the topics that end so; what has another type is of somebody else


def tells_motion(name: str, kind: str) -> bool:
    """Whether a topic of a type is one of those that a motion is made of."""
    return KINDS.get(name.rpartition('/')[2]) == kind


class GrowingMotion:
    """
    Takes payloads, gives motions.

    poses  : topics of the poses of all bodies
    others : topics of twists, applied wrenches, contacts and impacts, as far as there are any;
             what comes on a topic that is named nowhere here, or on the twist of a body without
             pose, is left out
    arrays : topics that hold bodies which have none of their own, and what to cut out of them;
             their poses are among `poses`
    late   : whether contacts may come behind the states of their tick
    run    : how often the run that was heard has begun anew
    began  : [s] when its scene began, as far as somebody knows: see `RecordedMotion`
    """

    def __init__(
        self,
        poses: Iterable[str],
        others: Iterable[str],
        *,
        arrays: Mapping[str, BodyArray] = MappingProxyType({}),
        late: bool = False,
    ) -> None:
        self._arrays = arrays
        cut = {topic.name for array in arrays.values() for topic in array.parts.values()}
        self.poses = list(poses)
        others = {*others, *cut}
        self._twists = {name for name in map(_twist, self.poses) if name in others}
        self._needed = {*self.poses, *self._twists, *arrays} - cut
        self._others = others
        self._tells_contacts = any(name.endswith(f'/{CONTACTS}') for name in others)
        self._late = late and self._tells_contacts
        self._tells_impacts = any(name.endswith(f'/{IMPACTS}') for name in others)
        self.run = -1
        self.began: tuple[float, ...] = ()
        self._begin()

    def _begin(self) -> None:
        """Forget what came: it is of another run."""
        self.run += 1
        self._waiting: dict[int, dict[str, bytes]] = {}
        self._wrenches: dict[str, list[bytes]] = {}
        self._contacts: dict[int, dict[str, bytes]] = {}
        self._impacts: list[Impacts] = []
        self._stamps: dict[str, int] = {}  # of the last message of each topic
        self._newest = -1  # whole instant at the last call
        self._last = -1

    def take(self, topic: str, payload: bytes) -> None:
        """Take a message."""
        if topic in self._needed:
            stamp = _stamp(payload)
            if stamp < self._stamps.get(topic, -1):
                self._begin()
            self._stamps[topic] = stamp
            if stamp > self._last:
                self._waiting.setdefault(stamp, {})[topic] = payload
        elif topic not in self._others:
            return
        elif topic.endswith('/applied_wrench'):
            self._wrenches.setdefault(topic, []).append(payload)
        elif topic.endswith(f'/{IMPACTS}'):
            self._impacts.append(impacts_of(impact_points(payload)))
        elif topic.endswith(f'/{CONTACTS}') and (stamp := _stamp(payload)) > self._last:
            self._contacts.setdefault(stamp, {})[topic] = payload

    def whole(self, *, most: int) -> RecordedMotion | None:
        """
        Give what is whole since the last call, thinned to so many instants, of many bodies to
        fewer; None: nothing.
        """
        stamps = sorted(t for t, found in self._waiting.items() if len(found) == len(self._needed))
        if self._late and stamps and stamps[-1] != self._newest:
            self._newest = stamps.pop()  # its contacts may be on the way: at the next call
        if not stamps:
            return None
        self._last = stamps[-1]
        most = max(1, most * MOST_ROWS // max(MOST_ROWS, len(self.poses)))
        shown = stamps[:: -(-len(stamps) // most)]
        if shown[-1] != stamps[-1]:
            shown.append(stamps[-1])
        rows = [self._opened(self._waiting[stamp]) for stamp in shown]
        self._waiting = {t: found for t, found in self._waiting.items() if t > self._last}
        wrenches, self._wrenches = self._wrenches, {}
        touching = tuple(self._touching(stamp) for stamp in shown)
        self._contacts = {t: found for t, found in self._contacts.items() if t > self._last}
        struck, self._impacts = impacts.joined(self._impacts), []
        return RecordedMotion(
            tuple(
                track_of(
                    name,
                    [row[name] for row in rows],
                    [row[_twist(name)] for row in rows] if _twist(name) in self._twists else [],
                    wrenches.get(name.removesuffix('pose') + 'applied_wrench', []),
                )
                for name in self.poses
            ),
            np.empty(0),
            touching=touching if self._tells_contacts else None,
            impacts=struck if self._tells_impacts else None,
            began=self.began,
        )

    def _opened(self, found: dict[str, bytes]) -> dict[str, bytes]:
        """Give the messages of an instant with those that are cut out of arrays."""
        if not self._arrays:
            return found
        cut = (array.cut(found[topic]) for topic, array in self._arrays.items())
        return found | {topic: data for parts in cut for topic, data in parts}

    def _touching(self, stamp: int) -> dict[str, Array]:
        """Read the contacts of an instant, by body."""
        told = self._contacts.get(stamp, {})
        return {topic.split('/')[-2]: read_points(payload) for topic, payload in told.items()}


def _stamp(payload: bytes) -> int:
    sec, nanosec = _STAMP.unpack_from(payload, 4)
    return sec * SECOND + nanosec


def _twist(pose: str) -> str:
    return pose.removesuffix('pose') + 'twist'


def joined(blocks: Iterable[RecordedMotion]) -> RecordedMotion:
    """Put motions of the same bodies one behind the other."""
    blocks = list(blocks)
    arrays = [field.name for field in fields(Track) if field.name != 'name']
    tracks = zip(*(block.tracks for block in blocks), strict=True)
    return RecordedMotion(
        tuple(
            Track(
                parts[0].name,
                *[np.concatenate([getattr(part, name) for part in parts]) for name in arrays],
            )
            for parts in tracks
        ),
        np.empty(0),
        touching=None
        if blocks[0].touching is None
        else tuple(each for block in blocks for each in block.touching or ()),
        impacts=None
        if blocks[0].impacts is None
        else impacts.joined([block.impacts for block in blocks if block.impacts is not None]),
        began=blocks[-1].began,
    )


def size_of(motion: RecordedMotion) -> int:
    """Memory that a motion takes [byte]."""
    held = [getattr(t, each.name) for t in motion.tracks for each in fields(Track)[1:]]
    held += [rows for told in motion.touching or () for rows in told.values()]
    if motion.impacts is not None:
        held += [getattr(motion.impacts, each.name) for each in fields(Impacts)]
    return sum(each.nbytes + OBJECT_BYTES for each in held)


def thinned(motion: RecordedMotion, most: int) -> RecordedMotion:
    """
    Keep so many instants at most, evenly over time, first and last among them; of the wrenches
    between two the largest, and of impacts the hardest, as many as instants.
    """
    time = motion.tracks[0].time
    kept = np.unique(np.searchsorted(time, np.linspace(time[0], time[-1], max(2, most))))
    touching, struck = motion.touching, motion.impacts
    return RecordedMotion(
        tuple(_thinned(track, kept) for track in motion.tracks),
        motion.command_time,
        touching=None if touching is None else tuple(touching[k] for k in kept),
        impacts=None if struck is None else impacts.hardest(struck, most),
        began=motion.began,
    )


def _thinned(track: Track, kept: NDArray[np.int64]) -> Track:
    found = {'time': track.time[kept]}
    for name in ('position', 'orientation'):
        found[name] = getattr(track, name)[kept]
    of_twist = kept[: len(track.twist_time)]  # all, or it has none
    for name in ('twist_time', 'velocity', 'angular_velocity'):
        found[name] = getattr(track, name)[of_twist]
    rows = _largest(track, found['time'])
    for name in ('wrench_time', 'force', 'torque'):
        found[name] = getattr(track, name)[rows]
    return Track(track.name, **{name: values.copy() for name, values in found.items()})


def _largest(track: Track, times: Array) -> NDArray[np.int64]:
    """Rows of the largest wrench before each of some times, and of the last one."""
    stretch = np.searchsorted(times, track.wrench_time)
    size = np.sum(np.square(track.force), axis=1) + np.sum(np.square(track.torque), axis=1)
    order = np.lexsort((size, stretch))
    ends = np.flatnonzero(np.diff(stretch[order], append=-1))
    return order[ends]
