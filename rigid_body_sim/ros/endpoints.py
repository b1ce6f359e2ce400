# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Makes the publishers and subscriptions of a node, with the quality of service that the user gave
for a topic, counts the messages that the middleware says were lost on their way here, and knows
the peers whose quality of service does not fit.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import product
from typing import Any

from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    QoSCompatibility,
    QoSProfile,
    qos_check_compatible,
    qos_policy_name_from_kind,
)
from rclpy.qos_overriding_options import InvalidQosOverridesError
from rclpy.subscription import Subscription

from rigid_body_sim.errors import UserError
from rigid_body_sim.ros.listener import NotForExecutors
from rigid_body_sim.ros.qos import MOST_WATCHED
from rigid_body_sim.ros.qos_overrides import ALLOWED, PUBLISHER, SUBSCRIPTION, QosOverrides

MOST_MISFITS = 20  # [topics] that are looked at for peers that do not fit
PEER_OF = {PUBLISHER: 'subscription', SUBSCRIPTION: 'publisher'}
WITHOUT = {PUBLISHER: 'it gets nothing', SUBSCRIPTION: 'nothing comes from it'}
TELL_EVERY = 5.0  # [s] between two lines that say how many are made
_REFUSALS = (
    InvalidParameterTypeException,
    InvalidQosOverridesError,
    OverflowError,
    RuntimeError,
    TypeError,
    ValueError,
    rclpy_implementation.RCLError,
)


class Endpoints:
    """
    What one node publishes and takes.

    given   : names of all given parameters, of which the overrides are taken
    watched : whether they are few enough to be watched, see `watch`
    """

    def __init__(self, node: Node, given: Iterable[str]) -> None:
        self._node = node
        self._overrides = QosOverrides(given)
        self.watched = True
        self._made = 0
        self._asked = 0
        self._began = self._told = 0.0
        self._lost: dict[int, int] = {}  # by subscription
        self._misfitting: dict[tuple[str, str], None] = {}  # those that a peer did not fit once
        self._taken: dict[tuple[str, str], tuple[str, type]] = {}  # wire name -> own name, type
        self.claim('topic', '/rosout', Log)  # every node has these two
        self.claim('topic', '/parameter_events', ParameterEvent)

    @property
    def lost(self) -> int | None:
        """
        Messages that never came, of all subscriptions, as far as the middleware tells; None: they
        are too many to watch.
        """
        return sum(self._lost.values()) if self.watched else None

    def begin(self, topics: int, bodies: int) -> None:
        """
        Begin to make so many topics of so many bodies.

        They are watched for peers that do not fit and messages that are lost, unless there are too
        many of them; that takes long to make too, and is said.
        """
        self.watched = topics <= MOST_WATCHED
        self._asked, self._made = topics, 0
        self._began = self._told = time.monotonic()
        if not self.watched:
            self._node.get_logger().info(
                f'making {topics} topics of {bodies} bodies, which takes a while; where they are '
                'not all needed: body_topics:=none, or names, with publish_arrays:=true'
            )

    def _note_made(self) -> None:
        """Count one of the topics; say now and then how far it is."""
        self._made += 1
        now = time.monotonic()
        if now - self._told >= TELL_EVERY:
            self._told = now
            self._node.get_logger().info(
                f'made {self._made} of {self._asked} topics, {now - self._began:.0f} s so far'
            )

    def claim(self, what: str, own: str, kind: type) -> str:
        """
        Take the name on the wire; UserError where remapping leads another type there.

        what    : topic, service
        own     : its name before remapping
        returns : the name on the wire
        """
        node = self._node
        resolve = node.resolve_topic_name if what == 'topic' else node.resolve_service_name
        wire = resolve(own)
        other, its_kind = self._taken.setdefault((what, wire), (own, kind))
        if its_kind is not kind:
            raise UserError(
                f'arguments for ROS: remapping makes one {what} {wire} of {other} '
                f'({_type_name(its_kind)}) and {own} ({_type_name(kind)}), and it can have one '
                'type only; leave one of them its own name, or give it one that is free'
            )
        return wire

    def publisher(self, kind: type, topic: str, profile: QoSProfile) -> Publisher:
        """Publish on a topic; UserError for overrides that cannot be, or a name that is taken."""
        self._note_made()
        name = self.claim('topic', topic, kind)
        options = self._overrides.options(name, PUBLISHER)
        more: dict[str, Any] = {} if options is None else {'qos_overriding_options': options}
        events = PublisherEventCallbacks(
            incompatible_qos=partial(self._note_misfit, (PUBLISHER, name))
            if self.watched
            else None,
            use_default_callbacks=self.watched,
        )
        with _refusing(name):
            return self._node.create_publisher(
                kind,
                topic,
                _copy(profile),
                event_callbacks=events,
                **more,
            )

    def subscription(
        self, kind: type, topic: str, profile: QoSProfile, *, must_be_reliable: bool = False
    ) -> Subscription:
        """
        Take the bytes of a topic, for an `OwnWaitSet`; UserError for overrides that cannot be, or
        a name that is taken.

        must_be_reliable : refuse best effort, where the run waits for every message
        """
        self._note_made()
        name = self.claim('topic', topic, kind)
        profile = _copy(profile)
        options = self._overrides.options(name, SUBSCRIPTION, must_be_reliable=must_be_reliable)
        place = len(self._lost)
        self._lost[place] = 0
        events = SubscriptionEventCallbacks(
            incompatible_qos=partial(self._note_misfit, (SUBSCRIPTION, name))
            if self.watched
            else None,
            message_lost=partial(self._note_lost, place) if self.watched else None,
            use_default_callbacks=self.watched,
        )
        with _refusing(name):
            return self._node.create_subscription(
                kind,
                topic,
                _nowhere,
                profile,
                callback_group=NotForExecutors(),
                raw=True,
                event_callbacks=events,
                **({} if options is None else {'qos_overriding_options': options}),
            )

    def _note_misfit(self, place: tuple[str, str], event: Any) -> None:
        """Say that a peer was found with which nothing can be exchanged, and remember where."""
        what, name = place
        policy = qos_policy_name_from_kind(event.last_policy_kind)
        self._node.get_logger().warning(
            f'{name}: found a {PEER_OF[what]} with incompatible QoS ({policy}); {WITHOUT[what]}'
        )
        if len(self._misfitting) < MOST_MISFITS:
            self._misfitting[place] = None

    def misfits(self) -> list[str]:
        """One line for each peer that is there and whose quality of service does not fit."""
        return [line for place in self._misfitting for line in self._misfits_of(*place)]

    def _misfits_of(self, what: str, name: str) -> Iterator[str]:
        node = self._node
        named = node.get_name(), node.get_namespace()
        publishers = node.get_publishers_info_by_topic(name)
        subscriptions = node.get_subscriptions_info_by_topic(name)
        ours, peers = publishers, subscriptions
        if what == SUBSCRIPTION:
            ours, peers = peers, ours
        own = [info for info in ours if (info.node_name, info.node_namespace) == named][:1]
        for end, peer in product(own, peers):
            both = (end, peer) if what == PUBLISHER else (peer, end)
            fit, why = qos_check_compatible(*(info.qos_profile for info in both))
            if fit == QoSCompatibility.ERROR:
                why = why.replace('ERROR: ', '').strip(' ;').replace(';', ', ')
                yield (
                    f'{name}: the {PEER_OF[what]} of {peer.node_namespace.rstrip("/")}/'
                    f'{peer.node_name} has incompatible QoS ({why}); {WITHOUT[what]}'
                )

    def _note_lost(self, place: int, status: Any) -> None:
        self._lost[place] = status.total_count

    def warnings(self) -> list[str]:
        """One line for each given override that no topic took; after all were made."""
        return self._overrides.warnings()


@contextmanager
def _refusing(topic: str) -> Iterator[None]:
    try:
        yield
    except _REFUSALS as error:
        said = ' '.join(str(error).split()).partition(', at /')[0]
        raise UserError(f'quality of service of {topic}: {said}; allowed: {ALLOWED}') from None


def _type_name(kind: type) -> str:
    return f'{kind.__module__.partition(".")[0]}/{kind.__name__}'


def _copy(profile: QoSProfile) -> QoSProfile:
    """Copy a profile: rclpy writes overrides into the one that it is given."""
    return QoSProfile(
        **{name.removeprefix('_'): getattr(profile, name) for name in profile.__slots__}
    )


def _nowhere(_: bytes) -> None:
    """Take a message that an executor would have taken."""
