# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Quality of service of the node's topics, and the word about a peer whose own does not fit.

State: reliable, volatile: it serves reliable and best-effort subscribers. As many are kept for one
that lags as `depth_of_states` says: of 300 messages at 100 Hz, a subscriber that was stopped for
the second hundred lost 84 where 10 were kept, none at 1000; a message that waits takes 0.9 kB, and
one that nobody waits for nothing (60 topics, measured). Commands:
reliable, or best effort on request, and a deep queue, because a burst of impulses must not be cut
where the machine lets the node wait. A best-effort publisher never matches a reliable
subscription, which looks like a dead topic; that is why it is logged.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.subscription import Subscription

STATE_DEPTH = 1000  # [messages] of a topic
MOST_KEPT = 300_000  # [messages] of all topics together, a quarter of a GB if all wait
LEAST_DEPTH = 10  # [messages]
# [messages] of a topic that wait where the node is busy, or for one that was lost on the way and
# is repeated after up to 3 s. With 1000, half of a burst of 5000 was lost; what nobody waits for
# takes no memory
COMMAND_DEPTH = 10_000
MOST_WATCHED = 1000  # [topics] whose peers are watched: the executor goes through all each time
LOOK = 0.01  # [s] enough for a few rounds of the executor


def depth_of_states(topics: int) -> int:
    """Choose how many messages each of so many topics keeps for a subscriber that lags."""
    return min(STATE_DEPTH, max(LEAST_DEPTH, MOST_KEPT // max(1, topics)))


def of_states(depth: int) -> QoSProfile:
    """Make the profile of what the node publishes."""
    return _profile(depth, 'reliable')


def of_commands(reliability: str = 'reliable', *, depth: int = COMMAND_DEPTH) -> QoSProfile:
    """Make the profile of commands, at either end; reliability: 'reliable' or 'best_effort'."""
    return _profile(depth, reliability)


def _profile(depth: int, reliability: str) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy[reliability.upper()],
        durability=DurabilityPolicy.VOLATILE,
    )


class NowAndThen(ReentrantCallbackGroup):
    """
    Event handlers that the executor looks at only for a short while after `look`.

    Each topic has two of them, and an executor that waits for all those of 10 bodies takes 0.6 ms
    longer for whatever it does (measured), while the stepping thread waits for the interpreter.
    """

    def __init__(self) -> None:
        super().__init__()
        self._until = 0.0

    def look(self) -> None:
        """Let the executor look at the events now."""
        self._until = time.monotonic() + LOOK

    def can_execute(self, entity: object) -> Any:  # rclpy says: always True
        """Whether the executor may wait for the event now."""
        return time.monotonic() < self._until

    def adopt(self, endpoints: Iterable[Publisher | Subscription]) -> None:
        """Take over the event handlers of publishers and subscriptions."""
        for endpoint in endpoints:
            handlers: Any = endpoint.event_handlers  # a list, whatever rclpy says
            for handler in handlers:
                handler.callback_group = self
                self.add_entity(handler)
