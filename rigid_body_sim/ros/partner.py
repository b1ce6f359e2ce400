# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The other side of lock-step: a controller in a node of its own that answers each state once.

    def damper(states):
        return {'satellite/torque': -0.9 * states['satellite'].angular_velocity}

    node = rclpy.create_node('damper')
    partner = Partner(node, damper, bodies=['satellite'], topics=['satellite/torque'])
    rclpy.spin(node)

What makes a run come out again, and what this class keeps: it publishes before it subscribes,
collects poses and twists by their stamp, gives the answer the stamp of its state, sends the same
bytes again where a state comes again, and leaves older states alone. What is left to the
controller: to be a function of the states and of its own memory, without a clock or dice.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message
from rclpy.subscription import Subscription

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.numbers import array_of_numbers
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.topics import COMMAND_TYPES
from rigid_body_sim.ros import conversions, qos
from rigid_body_sim.ros.listener import NotForExecutors, OwnWaitSet
from rigid_body_sim.ros.lockstep import parted
from rigid_body_sim.runs.commands import Command, encode, frame_id_of

LOOK = 0.05  # [s] between looks who is connected
NUMBERS = {'force': 3, 'torque': 3, 'wrench': 6, 'impulse': 6}
DEPTH = 100  # [messages] of states that may wait for the controller

Array = NDArray[np.float64]
Bytes = dict[str, bytes]


@dataclass(frozen=True)
class BodyState:
    """
    What one body does at an instant, world axes.

    position         : (3,) [m]      of the centre of mass
    orientation      : (4,) [-]      xyzw, body to world
    velocity         : (3,) [m/s]    of the centre of mass
    angular_velocity : (3,) [rad/s]
    """

    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array

    @cached_property
    def angular_velocity_body(self) -> Array:
        """Angular velocity in body axes (3,) [rad/s]: q* w q."""
        vector, scalar = self.orientation[:3], self.orientation[3]
        twice = 2.0 * np.cross(vector, self.angular_velocity)
        return self.angular_velocity - scalar * twice + np.cross(vector, twice)


class States(dict[str, BodyState]):
    """
    The states of the bodies that were asked for at one instant, by name.

    stamp : [ns] of simulation time
    """

    stamp: int = 0

    @property
    def time(self) -> float:
        """Simulation time [s], the double nearest to the stamp."""
        return self.stamp / 1e9


Controller = Callable[[States], Mapping[str, Any]]


class Partner:
    """
    Answers the states of a node in lock-step with what a function makes of them.

    node       : that publishes and subscribes
    controller : States -> {topic: command}; a value for every one of `topics`, each
                 force, torque    (3,) [N], [N m]
                 wrench, impulse  (2, 3) or (6,): force [N] and torque [N m], of an impulse
                                  [N s] and [N m s]
                 in world axes, or in the frame that `topics` names; or a message of the topic,
                 whose frame_id counts and whose stamp is set here
    bodies     : whose states it is given
    topics     : on which it answers, such as satellite/torque, or drone/wrench@front_left, as
                 the parameter lockstep_topics of the node names them
    period     : [s] lockstep_period of the node; other states are not answered. 0.0: all are
    namespace  : of the simulation; '': that of `node`
    spins      : whether `spin` serves the subscriptions, in place of an executor: three times as
                 fast

    The node may start before or after. What the controller raises goes through to whoever spins.
    Raises UserError for what the controller must not return.
    """

    def __init__(
        self,
        node: Node,
        controller: Controller,
        *,
        bodies: Sequence[str],
        topics: Sequence[str],
        period: float = 0.0,
        namespace: str = '',
        spins: bool = False,
    ) -> None:
        if not bodies or not topics:
            raise UserError(f'a partner needs bodies and topics; got {bodies!r} and {topics!r}')
        self.controller = controller
        self.states: States | None = None  # the last ones that were whole
        self.answered = -1  # [ns] stamp of the last answer
        self._node, self._bodies = node, tuple(bodies)
        self._prefix = f'{namespace.rstrip("/")}/' if namespace else ''
        self._period = round(period * 1e9)
        self._group = NotForExecutors() if spins else None
        self._topics = tuple(topics)
        self._publishers = {
            topic: self._publisher(topic) for topic in dict.fromkeys(parted(t)[0] for t in topics)
        }
        self._subscriptions: dict[str, Subscription] = {}
        self._latest: dict[str, int] = {}
        self._parts: dict[int, Bytes] = {}
        self._sent: Bytes = {}
        self._until = math.inf
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = None if spins else node.create_timer(LOOK, self._look, clock=clock)

    def _publisher(self, topic: str) -> Publisher:
        kind = COMMAND_TYPES.get(topic.rpartition('/')[2])
        if kind is None:
            raise UserError(
                f'topic {topic!r}: not one for commands; these end in {", ".join(COMMAND_TYPES)}'
            )
        return self._node.create_publisher(
            conversions.MESSAGE_TYPES[kind], self._prefix + topic, qos.of_commands()
        )

    def _look(self) -> None:
        """Subscribe when the answers have a listener; forget what a node that ended was told."""
        if self._subscriptions:
            if not any(one.get_publisher_count() for one in self._subscriptions.values()):
                self._forget()
        elif all(one.get_subscription_count() for one in self._publishers.values()):
            for body in self._bodies:
                self._subscribe(f'{body}/pose', cdr.PoseStamped.TYPE)
                self._subscribe(f'{body}/twist', cdr.TwistStamped.TYPE)

    def _subscribe(self, topic: str, kind: str) -> None:
        self._subscriptions[topic] = self._node.create_subscription(
            conversions.MESSAGE_TYPES[kind],
            self._prefix + topic,
            partial(self._hear, topic),
            DEPTH,
            callback_group=self._group,
            raw=True,
        )

    def _forget(self) -> None:
        self.states, self.answered, self._sent = None, -1, {}
        self._latest.clear()
        self._parts.clear()

    def _hear(self, topic: str, data: Any) -> None:
        """Collect what bears the same stamp; when it is whole, answer."""
        stamp = stamp_of(data)
        if stamp < self._latest.get(topic, 0):  # time never goes back on a topic of one node
            self._forget()
        self._latest[topic] = stamp
        if stamp < self.answered or (self._period and stamp % self._period):
            return
        parts = self._parts.setdefault(stamp, {})
        parts[topic] = bytes(data)
        if len(self._parts) > DEPTH:  # a topic is silent, or the node waits for nobody
            del self._parts[min(self._parts)]
        if len(parts) == len(self._subscriptions):
            self._parts = {later: kept for later, kept in self._parts.items() if later > stamp}
            self._meet(states_of(stamp, parts, self._bodies))

    def _meet(self, states: States) -> None:
        """Answer the states of an instant: as before, if it was answered before."""
        self.states = states
        if states.stamp > self.answered:
            if states.time >= self._until:
                return
            self._sent = self._encoded(states)
            self.answered = states.stamp
        for topic, data in self._sent.items():
            self._publishers[parted(topic)[0]].publish(data)

    def _encoded(self, states: States) -> Bytes:
        given = self.controller(states)
        if not isinstance(given, Mapping) or given.keys() != set(self._topics):
            got = ', '.join(map(str, given)) if isinstance(given, Mapping) else repr(given)
            raise UserError(
                f'the controller returned commands for {got or "no topic"}; needed: one for each '
                f'of {", ".join(self._topics)}'
            )
        return {topic: encoded(topic, given[topic], states.stamp) for topic in self._topics}

    def spin(
        self,
        *,
        until: float = math.inf,
        patience: float = math.inf,
        alive: Callable[[], bool] = lambda: True,
    ) -> States:
        """
        Answer in this thread up to a simulation time; needs `spins`.

        until    : [s] the first states at or after it are returned, and not answered yet: the
                   next call answers them
        patience : [s] of wall time without new states; TimeoutError after that
        alive    : asked every 0.05 s; False ends it with TimeoutError too
        """
        assert self._group is not None, 'make the partner with spins=True'
        self._until = until
        if self.states is not None and self.states.stamp > self.answered:
            self._meet(self.states)
        wait_set, heard = None, time.monotonic()
        try:
            while self.states is None or self.states.time < until:
                known = self.states
                if wait_set is None:
                    wait_set = self._open_wait_set()
                if wait_set is None:
                    time.sleep(LOOK)
                else:
                    wait_set.wait(round(LOOK * 1e9))
                if self.states is not known:
                    heard = time.monotonic()
                    continue
                self._look()
                if not alive() or time.monotonic() - heard > patience:
                    raise TimeoutError(self._standing())
        finally:
            if wait_set is not None:
                wait_set.close()
        return self.states

    def _open_wait_set(self) -> OwnWaitSet | None:
        if not self._subscriptions:
            self._look()
        if not self._subscriptions:
            return None
        takers = {one: partial(self._hear, topic) for topic, one in self._subscriptions.items()}
        return OwnWaitSet(self._node.context, takers)

    def _standing(self) -> str:
        silent = [t for t, p in self._publishers.items() if not p.get_subscription_count()]
        if silent:
            return f'nobody listens to {", ".join(silent)}'
        return f'no new states after {self.states.time if self.states else "the start"} s'

    def close(self) -> None:
        """Take the topics and the timer off the node."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        for subscription in self._subscriptions.values():
            self._node.destroy_subscription(subscription)
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)


def stamp_of(data: bytes) -> int:
    """Read the stamp [ns] of a message with a header."""
    order = 'little' if data[1] else 'big'
    return int.from_bytes(data[4:8], order, signed=True) * 10**9 + int.from_bytes(
        data[8:12], order
    )


def states_of(stamp: int, parts: Mapping[str, bytes], bodies: Sequence[str]) -> States:
    """Read the poses and twists of bodies, given by topic."""
    states = States()
    states.stamp = stamp
    for body in bodies:
        pose = cdr.decode(cdr.PoseStamped.TYPE, parts[f'{body}/pose'])
        twist = cdr.decode(cdr.TwistStamped.TYPE, parts[f'{body}/twist'])
        assert isinstance(pose, cdr.PoseStamped)
        assert isinstance(twist, cdr.TwistStamped)
        states[body] = BodyState(
            np.array(pose.position),
            np.array(pose.orientation),
            np.array(twist.linear),
            np.array(twist.angular),
        )
    return states


def encoded(topic: str, command: Any, stamp: int) -> bytes:
    """
    Return the message of a command with a stamp [ns]; UserError for what is none.

    topic   : on which it is sent, with the frame of plain numbers if need be; see `Partner`
    command : see `Partner`
    """
    name, frame = parted(topic)
    path, _, kind = name.rpartition('/')
    body = path.rpartition('/')[2]
    if hasattr(command, 'header'):
        if not isinstance(command, conversions.MESSAGE_TYPES[COMMAND_TYPES[kind]]):
            raise UserError(
                f'{topic}: the controller returned a {type(command).__name__}; allowed: numbers, '
                f'or a message of {COMMAND_TYPES[kind]}'
            )
        command.header.stamp.sec, command.header.stamp.nanosec = divmod(stamp, 10**9)
        return serialize_message(command)
    count = NUMBERS.get(kind, 0)
    given = array_of_numbers(command)
    numbers = [] if given is None else given.ravel().tolist()
    if not count or len(numbers) != count:
        raise UserError(
            f'{topic}: the controller returned {command!r}; allowed: '
            f'{f"{count} numbers, or " if count else ""}a message of {COMMAND_TYPES[kind]}'
        )
    first, second = tuple(numbers[:3]), tuple(numbers[3:]) or (0.0, 0.0, 0.0)
    force, torque = (second, first) if kind == 'torque' else (first, second)
    return encode(Command(body, kind, force, torque, frame_id_of(body, frame), stamp))
