# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Takes messages off many subscriptions, in a thread with one wait set of its own.

rclpy's executor builds its wait set anew for every message, twice: with the 40 command topics of
10 bodies that took 1.1 ms of processor per message, during which the stepping thread hardly gets
the interpreter. This loop takes 0.2 ms. It uses what the executor itself uses below (`WaitSet`,
`take_message`), which rclpy does not promise to keep; that is in this file alone.

A subscription belongs into one wait set only: two that wait for it take its messages from each
other, and one of them sleeps on although they came.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.subscription import Subscription

WAIT = 1_000_000_000  # [ns] between looks whether to end, if nobody wakes it
LONGEST_DRAIN = 5_000_000  # [ns] of one topic in a row; then others and whoever waits have a turn
FOR_EVER = 2**63  # [ns]
Taker = Callable[[bytes], object]


class NotForExecutors(ReentrantCallbackGroup):
    """The group of subscriptions that an `OwnWaitSet` serves: an executor never waits for them."""

    def can_execute(self, entity: object) -> Any:  # rclpy says: always True
        """Never."""
        return False


class OwnWaitSet:
    """
    Subscriptions that one thread waits for; another may wake it.

    takers : subscription -> function, called with the bytes of each message by the thread that
             waits
    unread : messages that had come and that nobody took; known when it is closed
    """

    def __init__(self, context: Context, takers: Mapping[Subscription, Taker]) -> None:
        self.unread = 0
        assert context.handle is not None  # it was initialised before a node was made
        self._guard = GuardCondition(None, None, context=context)
        self._kept = ExitStack()
        for held in (context.handle, self._guard.handle, *(one.handle for one in takers)):
            self._kept.enter_context(held)
        self._handles = [subscription.handle for subscription in takers]
        self._takers = {one.handle.pointer: (one, taker) for one, taker in takers.items()}
        self._wait_set = rclpy_implementation.WaitSet(
            len(self._handles), 1, 0, 0, 0, 0, context.handle
        )

    def wait(self, longest: int) -> None:
        """
        Take what has come, or comes within so many nanoseconds; of much that has, a part: the
        next call goes on with it.
        """
        wait_set = self._wait_set
        wait_set.clear_entities()
        for handle in self._handles:
            wait_set.add_subscription(handle)
        wait_set.add_guard_condition(self._guard.handle)
        wait_set.wait(max(0, longest))
        for pointer in wait_set.get_ready_entities('subscription'):
            _take(*self._takers[pointer], until=time.monotonic_ns() + LONGEST_DRAIN)

    def take(self) -> None:
        """Take all that has come."""
        for subscription, taker in self._takers.values():
            _take(subscription, taker)

    def wake(self) -> None:
        """Let the thread that waits, or will wait next, go on at once; from any thread."""
        self._guard.trigger()

    def close(self) -> None:
        """Let go of the subscriptions; no thread waits any more."""
        self.unread = sum(_take(one, _nobody) for one, _ in self._takers.values())
        self._kept.close()
        self._guard.destroy()


class Listener:
    """
    Calls a function with the bytes of each message.

    takers : subscription -> function; called in the listener's thread
    unread : messages that had come and that nobody took; known when it has stopped
    """

    def __init__(self, context: Context, takers: Mapping[Subscription, Taker]) -> None:
        self._context = context
        self._takers = takers
        self._ending = False
        self.unread = 0
        self._wait_set: OwnWaitSet | None = None
        self._thread = threading.Thread(target=self._listen, name='listener', daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._wait_set = OwnWaitSet(self._context, self._takers)
        self._thread.start()

    def stop(self) -> None:
        """End."""
        self._ending = True
        if self._wait_set is not None:
            self._wait_set.wake()
            self._thread.join()
            self._wait_set.close()
            self.unread = self._wait_set.unread

    def _listen(self) -> None:
        assert self._wait_set is not None
        while not self._ending:
            self._wait_set.wait(WAIT)


def _take(subscription: Subscription, taker: Taker, *, until: int = FOR_EVER) -> int:
    """
    Take what has come, up to a time [ns] of the monotonic clock.

    returns : number of messages
    """
    count = 0
    while (taken := subscription.handle.take_message(subscription.msg_type, True)) is not None:
        taker(taken[0])
        count += 1
        if time.monotonic_ns() >= until:
            break
    return count


def _nobody(_: bytes) -> None:
    """Count a message, and leave it at that."""
