# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A bag seen as if every body had its topics `pose` and `twist`.

A run may give few of its bodies, or none, topics of their own and record all of them in the arrays
`poses` and `twists`. Whoever reads the motion of bodies reads it here: the missing messages are
cut out of the arrays, with their bytes as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_files import DamagedBag
from rigid_body_sim.recording.bag_reader import Bag, RecordedMessage
from rigid_body_sim.recording.cdr_parts import CdrError, PartReader
from rigid_body_sim.recording.record_values import RecordValues
from rigid_body_sim.recording.topics import Topic, body_topic, node_topic

_KINDS = (
    ('poses', cdr.POSE_ARRAY, 'pose', cdr.PoseStamped.TYPE, 56),
    ('twists', cdr.TWIST_ARRAY, 'twist', cdr.TwistStamped.TYPE, 48),
)  # array, leaf of a body, and bytes of its doubles
ARRAYS = {array: kind for array, kind, *_ in _KINDS}  # leaf of an array -> its type


@dataclass(frozen=True)
class BodyArray:
    """
    A topic whose messages hold all bodies, of which some are cut out.

    bodies : in a message
    width  : of the doubles of a body [byte]
    tail   : what stands between stamp and doubles of each part (`cdr.header_tail`)
    parts  : place of a body in scene order -> topic of its part
    """

    bodies: int
    width: int
    tail: bytes
    parts: Mapping[int, Topic]

    def only(self, topics: Collection[str]) -> BodyArray:
        """Cut out no other topics than these."""
        kept = {place: topic for place, topic in self.parts.items() if topic.name in topics}
        return replace(self, parts=kept)

    def cut(self, payload: bytes) -> Iterator[tuple[str, bytes]]:
        """Yield topic and payload of each part of a message; CdrError."""
        head, rows = _rows(payload, self.bodies, self.width)
        head += self.tail
        for place, topic in self.parts.items():
            yield topic.name, head + rows[self.width * place : self.width * (place + 1)]


def arrays_of(
    bodies: Sequence[str], topics: Mapping[str, str], *, namespace: str, world_frame: str = ''
) -> dict[str, BodyArray]:
    """
    Find the arrays that hold bodies without topics of their own, and what to cut out of each.

    bodies : of the scene, in its order
    topics : name -> type, of all that there are
    """
    found, tail = {}, cdr.header_tail(world_frame)
    for array, array_type, leaf, kind, width in _KINDS:
        source = node_topic(namespace, array, array_type)
        if topics.get(source.name) != source.type:
            continue
        missing = {
            place: topic
            for place, body in enumerate(bodies)
            if (topic := body_topic(namespace, body, leaf, kind)).name not in topics
        }
        if missing:
            found[source.name] = BodyArray(len(bodies), width, tail, missing)
    return found


def with_every_body(bag: Bag) -> Bag:
    """Give the bag itself where every body has its topics, or no array holds the others."""
    if not bag.holds_run or 'bodies' not in bag.manifest:
        return bag
    found = _BagWithEveryBody(bag)
    return cast(Bag, found) if found.has_more else bag


class _BagWithEveryBody:
    """Everything else is that of the bag."""

    def __init__(self, bag: Bag) -> None:
        self._bag = bag
        self.topics: dict[str, Topic] = dict(bag.topics)
        self.counts: dict[str, int] = dict(bag.counts)
        values = RecordValues(bag.path, 'manifest', bag.manifest)
        self._arrays = arrays_of(
            values.names('bodies'),
            {name: topic.type for name, topic in bag.topics.items()},
            namespace=values.text('namespace', ''),
            world_frame=values.text('world_frame', 'world'),
        )
        for source, array in self._arrays.items():
            for topic in array.parts.values():
                self.topics[topic.name] = topic
                self.counts[topic.name] = bag.counts[source]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bag, name)

    @property
    def recorded_topics(self) -> Collection[str]:
        """Names of the topics that the files themselves hold."""
        return self._bag.topics

    @property
    def has_more(self) -> bool:
        """Whether it has a topic that the bag has not."""
        return bool(self._arrays)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[RecordedMessage]:
        """Yield the messages of the given topics, all of the bag by default, in file order."""
        return self._with_bodies(topics, self._bag.messages)

    def messages_by_time(self, topics: Collection[str] | None = None) -> Iterator[RecordedMessage]:
        """Yield them in the order of their log times."""
        return self._with_bodies(topics, self._bag.messages_by_time)

    def _with_bodies(
        self,
        topics: Collection[str] | None,
        messages: Callable[[Collection[str] | None], Iterator[RecordedMessage]],
    ) -> Iterator[RecordedMessage]:
        if topics is None:
            yield from messages(None)
            return
        wanted = set(topics)
        cut = {name: array.only(wanted) for name, array in self._arrays.items()}
        cut = {name: array for name, array in cut.items() if array.parts}
        for message in messages(wanted | cut.keys()):
            if message.topic in wanted:
                yield message
            if message.topic in cut:
                yield from self._of_bodies(message, cut[message.topic])

    def _of_bodies(self, message: RecordedMessage, array: BodyArray) -> Iterator[RecordedMessage]:
        try:
            for topic, data in array.cut(message.data):
                yield message._replace(topic=topic, data=data)
        except CdrError as error:
            raise DamagedBag(f'{self._bag.path}: damaged: {message.topic}: {error}') from error


def _rows(payload: bytes, bodies: int, width: int) -> tuple[bytes, bytes]:
    """Give encapsulation and stamp, and the doubles of all bodies; CdrError."""
    reader = PartReader('array of bodies', payload, 1)
    reader.need(payload[:4] == cdr.ENCAPSULATION, 'not little endian')
    reader.text()
    count = reader.u32()
    reader.need(count == bodies, f'{count} bodies, expected {bodies}')
    end = len(payload) - (4 if width == 48 else 0)  # behind the twists: no wrenches
    reader.need(reader.left >= width * bodies, f'{len(payload)} bytes')
    return payload[:12], payload[end - width * bodies : end]
