# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Sends commands to a node: one wrench over and over, an impulse once, or what a bag holds.

Deadlines are absolute; messages are sent as bytes. All of a burst is kept until it has arrived,
and beyond BURST it is sent no faster than FASTEST: what overflows a history at either end is lost
without a word. Acknowledgements cannot pace it: with Fast DDS each takes up to 3 s, measured.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import NameValidationException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.publisher import Publisher

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.topics import COMMAND_TYPES, Topic, body_topic
from rigid_body_sim.ros import conversions, qos
from rigid_body_sim.ros.domain import check_domain
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.stop_signals import STOP

MATCHING = 10.0  # [s] for a subscriber to be found; discovery takes up to 2.5 s on a quiet machine
LOOK_EVERY = 0.02  # [s] between looks for it, or for a signal
LONGEST = 255  # [-] letters of a topic that a message shows
LAST_WORDS = 30.0  # [s] for the last message to arrive; what was lost on the way is sent again
BURST = 1000  # [messages] of a topic that are sent at once; more than the node keeps may be lost
ROUNDING = 1e-6  # [messages] by which a time may miss that of a whole number of them
FASTEST = 2000.0  # [1/s] messages of a topic beyond; the node takes 5000 a second of all


class Message(NamedTuple):
    """When to send which bytes on which topic; time [s] from the start."""

    time: float
    topic: str
    data: bytes


class Sender:
    """A node that sends; use it in a `with`."""

    def __init__(self) -> None:
        check_domain()
        self._context = Context()
        rclpy.init(args=[], context=self._context)
        # several senders at once are usual, hence a name of its own
        self._node = Node(
            f'wrench_pub_{time.monotonic_ns()}',
            context=self._context,
            start_parameter_services=False,
        )
        self._publishers: dict[str, Publisher] = {}
        self._taken: dict[str, float] = {}  # [s] when all of a topic would be, at FASTEST

    def __enter__(self) -> Sender:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._node.destroy_node()
        self._context.try_shutdown()

    def now(self) -> int:
        """Wall time [ns], for stamps."""
        return self._node.get_clock().now().nanoseconds

    def open(self, topics: Sequence[Topic], *, most: int = 1) -> None:
        """
        Publish on these topics; RunError if after 10 s one of them has no listener.

        most : messages that one of them will have, all of which are kept until they have arrived
        """
        profile = qos.of_commands(depth=max(most, qos.COMMAND_DEPTH))
        for topic in topics:
            kind = conversions.MESSAGE_TYPES[topic.type]
            try:
                publisher = self._node.create_publisher(kind, topic.name, profile)
            except (NameValidationException, rclpy_implementation.RCLError) as error:
                said = ' '.join(str(error).split()).partition(', at /')[0]
                raise UserError(f'topic {topic.name[:LONGEST]!r}: {said}') from None
            self._publishers[topic.name] = publisher
        deadline = time.monotonic() + MATCHING
        while lonely := [n for n, p in self._publishers.items() if not p.get_subscription_count()]:
            if time.monotonic() > deadline:
                raise RunError(
                    f'nobody listens to {", ".join(lonely)} after {MATCHING:g} s; is the node '
                    'running, with this body, in this namespace and ROS_DOMAIN_ID?'
                )
            STOP.check(lambda: 'before anything was sent')
            time.sleep(LOOK_EVERY)

    def send(self, topic: str, data: bytes) -> None:
        """Send one message."""
        self._publishers[topic].publish(data)

    def play(self, messages: Iterator[Message] | Sequence[Message]) -> int:
        """Send each message at its time, a burst as fast as it is taken; return how many."""
        start = time.monotonic()
        count = 0
        for message in messages:
            _sleep_until(max(start + message.time, self._room_from(message.topic)))
            STOP.check(lambda: f'after {count} messages')  # noqa: B023  (called at once)
            self.send(message.topic, message.data)
            count += 1
        return count

    def _room_from(self, topic: str) -> float:
        """Count one more message on a topic; tell from when on [s] it may be sent."""
        now = time.monotonic()
        taken = max(now, self._taken.get(topic, now))
        self._taken[topic] = taken + 1.0 / FASTEST
        return taken - BURST / FASTEST

    def finish(self) -> list[str]:
        """Wait until what was sent has arrived; name the topics on which not all has."""
        return [
            name
            for name, publisher in self._publishers.items()
            if not publisher.wait_for_all_acked(Duration(seconds=LAST_WORDS))
        ]


def _sleep_until(end: float) -> None:
    """Sleep up to an instant of the monotonic clock [s], no longer than until a signal comes."""
    while not STOP.number and (left := end - time.monotonic()) > 0.0:
        time.sleep(min(left, LOOK_EVERY))


def publish_command(command: Command, *, namespace: str, rate_hz: float, seconds: float) -> int:
    """
    Send a command: an impulse once; a wrench at `rate_hz` for `seconds`, at whose end a zero one.

    returns : messages sent
    """
    topic = body_topic(namespace, command.body, command.kind, COMMAND_TYPES[command.kind])
    held = command.kind != 'impulse'
    count = max(1, math.ceil(seconds * rate_hz - ROUNDING)) if held else 1
    with Sender() as sender:
        sender.open([topic])
        begin = time.monotonic()
        try:
            sender.play(
                Message(k / rate_hz, topic.name, _stamped(command, sender)) for k in range(count)
            )
            if held:
                _sleep_until(begin + seconds)
        finally:  # also when stopped
            if held:
                ended = Command(command.body, command.kind, frame_id=command.frame_id)
                sender.send(topic.name, _stamped(ended, sender))
            sender.finish()
    return count + held


def _stamped(command: Command, sender: Sender) -> bytes:
    return replace(command, stamp_ns=sender.now(), received=None).message


def play_bag(path: Path, *, topics: Sequence[str], rate_factor: float) -> int:
    """
    Send the commands of a bag, of any rosbag2 recorder, with the spacing of their log times.

    topics      : names to send; empty: every command topic of the bag
    rate_factor : 2 plays twice as fast
    returns     : messages sent; RunError where not all of them have arrived
    """
    chosen, messages = commands_of_bag(path, topics=topics, rate_factor=rate_factor)
    most = max(Counter(message.topic for message in messages).values())
    with Sender() as sender:
        sender.open(chosen, most=most)
        count = sender.play(messages)
        missed = sender.finish()
    if missed:
        raise RunError(
            f'{path}: {count} messages sent, but after {LAST_WORDS:g} s not all of them have '
            f'arrived on {", ".join(missed)}; is the node still running, and not stopped?'
        )
    return count


def commands_of_bag(
    path: Path, *, topics: Sequence[str], rate_factor: float
) -> tuple[list[Topic], list[Message]]:
    """
    Read the command topics of a bag and their messages by log time; UserError if none. What was
    remapped is sent under the name on the wire.
    """
    bag = Bag(path)
    present = {
        bag.wire_name(topic.name): Topic(bag.wire_name(topic.name), topic.type)
        for topic in bag.topics.values()
        if is_command(topic) and bag.counts[topic.name]
    }
    missing = [name for name in topics if name not in present]
    if missing or not present:
        raise UserError(
            f'{path}: no commands on {", ".join(missing) or "any topic"}; '
            f'command topics in this bag: {", ".join(sorted(present)) or "none"}'
        )
    chosen = [topic for name, topic in present.items() if not topics or name in topics]
    recorded = list(bag.messages_by_time([bag.own_name(topic.name) for topic in chosen]))
    first = recorded[0].log_time
    return chosen, [
        Message(
            (message.log_time - first) / 1e9 / rate_factor,
            bag.wire_name(message.topic),
            message.data,
        )
        for message in recorded
    ]


def is_command(topic: Topic) -> bool:
    """Whether a topic is one on which a body takes commands: by its last name and its type."""
    return COMMAND_TYPES.get(topic.name.rsplit('/', 1)[-1]) == topic.type
