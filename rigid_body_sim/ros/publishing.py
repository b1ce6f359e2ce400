# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From packed batches to publishers: a message is sent where somebody listens.

Asking whether a topic has subscribers costs a fifth of sending to nobody (0.4 against 2
microseconds in rclpy), and a volatile message that nobody is there for is lost either way. It is
asked at every message, so that a subscriber misses nothing from its match on. That, and no cut of
bytes for nobody, is what lets a thousand bodies have topics of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rclpy.publisher import Publisher

from rigid_body_sim.recording.batch import Batch, TickLayout
from rigid_body_sim.recording.topics import Topic

_KEPT_PLANS = 1024  # layouts; more only costs looking up their publishers again

Count = Callable[[], int]
Send = Callable[[bytes], None]
Plan = tuple[tuple[Count, Send, int, int], ...]


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
        self._plans: dict[TickLayout, Plan] = {}

    def send(self, batch: Batch) -> None:
        """Send the messages of a batch, in its order."""
        layout, data = batch.layout, batch.data
        plan = self._plans.get(layout)
        if plan is None:
            plan = self._plan(layout)
        for base in range(0, len(data), layout.size):
            for count, send, start, stop in plan:
                if count():
                    send(data[base + start : base + stop])

    def _plan(self, layout: TickLayout) -> Plan:
        if len(self._plans) >= _KEPT_PLANS:
            self._plans.clear()
        handles = self._handles
        plan = self._plans[layout] = tuple(
            (handles[channel].get_subscription_count, handles[channel].publish_raw, start, stop)
            for channel, start, stop in layout.payload_spans
            if channel in handles
        )
        return plan
