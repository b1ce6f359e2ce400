# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From packed batches to publishers: a message is sent where somebody listens.

Asking whether a topic has subscribers costs a fifth of sending to nobody (0.4 against 2
microseconds in rclpy), and a volatile message that nobody is there for is lost either way. It is
asked at every message, so that a subscriber misses nothing from its match on. In a crowd of topics
those without subscribers are asked twenty times a second, and after `look` at the next message:
that lets a thousand bodies have topics of their own.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy

from rigid_body_sim.recording.batch import Batch, TickLayout
from rigid_body_sim.recording.topics import Topic

CROWD = 1000  # [topics] from which on not every one is asked at every message
ASK_EVERY = 50_000_000  # [ns] of wall time, in a crowd
_KEPT_PLANS = 1024  # layouts; more only costs looking up their publishers again

Count = Callable[[], int]
Send = Callable[[bytes], None]
Way = tuple[Count, Send, int, int]  # of one message: publisher, first byte, end


class _Plan:
    """
    Where the messages of one layout go.

    ways  : of all that have a publisher
    heard : those that somebody listened to when it was asked, at the time `asked` [ns]
    """

    def __init__(self, ways: tuple[Way, ...]) -> None:
        self.ways = ways
        self.heard: list[Way] = []
        self.asked = -ASK_EVERY


class Senders:
    """The publishers of a run by the channels of its batches."""

    def __init__(self, topics: Sequence[Topic], publishers: Mapping[str, Publisher]) -> None:
        """
        Take publishers by the names of their topics; what has none is recorded only.

        Sending goes below `publish`, whose guard against destruction costs as much again: the node
        keeps its publishers until the thread that sends has ended.
        """
        self._handles = {
            channel: publishers[topic.name].handle
            for channel, topic in enumerate(topics, start=1)
            if topic.name in publishers
        }
        self._kept = {  # by the middleware, for who comes later: an override of the user
            channel
            for channel, topic in enumerate(topics, start=1)
            if topic.name in publishers
            and publishers[topic.name].qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        }
        self._ask_every = ASK_EVERY if len(self._handles) > CROWD else 0
        self._looked = 0
        self._plans: dict[TickLayout, _Plan] = {}

    def look(self) -> None:
        """Ask all topics at their next message; from any thread."""
        self._looked = time.monotonic_ns()

    def send(self, batch: Batch) -> None:
        """Send the messages of a batch, in its order."""
        layout, data = batch.layout, batch.data
        plan = self._plans.get(layout)
        if plan is None:
            plan = self._plan(layout)
        now = time.monotonic_ns()
        if now - plan.asked >= self._ask_every or plan.asked <= self._looked:
            plan.heard = [way for way in plan.ways if way[0]()]
            plan.asked = now
        for base in range(0, len(data), layout.size):
            for _, send, start, stop in plan.heard:
                send(data[base + start : base + stop])

    def _plan(self, layout: TickLayout) -> _Plan:
        if len(self._plans) >= _KEPT_PLANS:
            self._plans.clear()
        handles = self._handles
        plan = self._plans[layout] = _Plan(
            tuple(
                (
                    _always if channel in self._kept else handles[channel].get_subscription_count,
                    handles[channel].publish_raw,
                    start,
                    stop,
                )
                for channel, start, stop in layout.payload_spans
                if channel in handles
            )
        )
        return plan


def _always() -> int:
    """Count whoever may come."""
    return 1
