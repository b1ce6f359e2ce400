# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The node: topics, services and parameters of a run. It hands bytes on and decides nothing.

The `Listener`'s thread judges and stores commands (`Inbox`), the executor's passes wishes on
(`RequestQueue`), that of the `RunLoop` publishes.
"""

from __future__ import annotations

import time
from collections.abc import Hashable, Sequence
from dataclasses import replace
from functools import partial

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.subscription import Subscription
from std_srvs.srv import SetBool, Trigger

from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.topics import CLOCK_TOPIC, COMMAND_TYPES, Topic, body_topic
from rigid_body_sim.ros import conversions, parameters, qos
from rigid_body_sim.ros.endpoints import Endpoints
from rigid_body_sim.ros.health import Health
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.ros.listener import Listener, OwnWaitSet, Taker
from rigid_body_sim.ros.lockstep import Gate
from rigid_body_sim.ros.neighbours import Neighbours
from rigid_body_sim.ros.publishing import Senders
from rigid_body_sim.ros.remarks import Remarks
from rigid_body_sim.ros.requests import ENDED, Answer, Answered, Request
from rigid_body_sim.ros.run_loop import RunLoop
from rigid_body_sim.runs.commands import KINDS

NAME = 'rigid_body_sim'
LOOK_AROUND = 1.0  # [s] between looks for neighbours, at most
SERVICES = {'~/pause': SetBool, '~/record': SetBool, '~/step': Trigger, '~/reset': Trigger}
ARRIVAL = 0.5  # [s] for the last messages to arrive, all together
LAST_SPINS, LAST_SPIN = 20, 0.02  # looks, and [s] of each, for answers when a run has ended
ANSWER_PERIOD = (
    0.05  # [s] between looks whether the run has ended while a service waits for its answer
)


class SimNode(Node):
    """The ROS side of one run: first the parameters (`settings`), then, with `open`, the rest."""

    def __init__(self, context: Context) -> None:
        super().__init__(NAME, context=context)
        self.settings = parameters.declare(self)
        for warning in parameters.strangers(list(self._parameter_overrides)):
            self.get_logger().warning(warning)
        self._endpoints = Endpoints(self, self._parameter_overrides)
        self._neighbours = Neighbours(
            self, clock=self.resolve_topic_name(CLOCK_TOPIC) if self.settings.publish_clock else ''
        )
        self._health: Health | None = None
        self._door: OwnWaitSet | None = None
        self._remarks = Remarks()  # of the listener's thread
        self._answer_remarks = Remarks()  # of the thread that waits for answers

    def open_topics(
        self, topics: Sequence[Topic], bodies: Sequence[str], inbox: Inbox, gate: Gate | None
    ) -> None:
        """Publish the states and take commands: those that answer states for the gate."""
        state = qos.of_states(self.settings.state_depth or qos.depth_of_states(len(topics)))
        command = qos.of_commands(self.settings.command_reliability)
        for name, kind in SERVICES.items():
            self._endpoints.claim('service', name, kind)
        self._endpoints.begin(len(topics) + len(KINDS) * len(bodies), len(bodies))
        publishers = {
            topic.name: self._endpoints.publisher(
                conversions.MESSAGE_TYPES[topic.type], topic.name, state
            )
            for topic in topics
            if (topic.name != CLOCK_TOPIC or self.settings.publish_clock)
            and self._is_installed(topic)
        }
        self._senders = Senders(topics, publishers)
        answered = gate.terms.targets if gate is not None else ()
        targets = {(body, kind) for body, kind, _ in answered}
        takers: dict[Subscription, Taker] = {}
        self._answering: dict[tuple[str, str], Subscription] = {}  # topics of lock-step
        self._answered = answered
        for body in bodies:
            for kind in KINDS:
                subscription = self._endpoints.subscription(
                    conversions.MESSAGE_TYPES[COMMAND_TYPES[kind]],
                    body_topic(self.get_namespace(), body, kind, '').name,
                    command,
                    must_be_reliable=(body, kind) in targets,
                )
                if gate is not None and (body, kind) in targets:
                    self._answering[body, kind] = subscription
                else:
                    takers[subscription] = partial(self._receive, inbox, body, kind)
        self.listener = Listener(self.context, takers)
        self._states = list(publishers.values())
        self._events = qos.NowAndThen()
        self._events.adopt([*publishers.values(), *takers, *self._answering.values()])
        self._diagnostics = self._endpoints.publisher(DiagnosticArray, '/diagnostics', state)
        for warning in self._endpoints.warnings():
            self.get_logger().warning(warning)
        self._reported = self.create_guard_condition(self._publish_health)

    @property
    def is_crowd(self) -> bool:
        """Whether it has more topics than can be watched."""
        return not self._endpoints.watched

    def _is_installed(self, topic: Topic) -> bool:
        """Whether the message type of a topic can be published here; say it if not."""
        if topic.type in conversions.MESSAGE_TYPES:
            return True
        package = topic.type.partition('/')[0]
        self.get_logger().warning(
            f'{topic.name} is not published: the ROS package {package} is not installed '
            f'(sudo apt install ros-jazzy-{package.replace("_", "-")}); it is recorded all the '
            'same'
        )
        return False

    def _receive(self, inbox: Inbox, body: str, kind: str, data: bytes) -> None:
        reason = inbox.receive(body, kind, data)
        if reason is not None and self._remarks.is_due(reason):
            self.warn(f'refused: {reason}')

    def _answer(self, gate: Gate, body: str, kind: str, data: bytes) -> None:
        remark = gate.receive(body, kind, data)
        if remark is not None and self._answer_remarks.is_due(remark.cause):
            self.warn(remark.text)

    def open_door(self, gate: Gate) -> OwnWaitSet:
        """Make what a run in lock-step waits with; call its `close` when the run has ended."""
        answering = self._answering.items()
        takers = {one: partial(self._answer, gate, *target) for target, one in answering}
        self._door = OwnWaitSet(self.context, takers)
        return self._door

    def links(self) -> Hashable:
        """Tell who is connected by states and answers: it changes with them."""
        asked = (publisher.get_subscription_count() for publisher in self._states)
        peers = (
            bytes(info.endpoint_gid)
            for subscription in self._answering.values()
            for info in self.get_publishers_info_by_topic(subscription.topic_name)
        )
        answering = (one.handle.get_publisher_count() for one in self._answering.values())
        return (*asked, *answering, *sorted(peers))

    def silence(self, index: int) -> str:
        """Say why no answer can come on a topic of lock-step; empty: one can."""
        body, kind, _ = self._answered[index]
        subscription = self._answering[body, kind]
        if subscription.handle.get_publisher_count():
            return ''
        found = self.get_publishers_info_by_topic(subscription.topic_name)
        if found:
            return f'the publisher of {found[0].node_name} does not match: is it best effort?'
        return 'nobody publishes it'

    def publish(self, batch: Batch) -> None:
        """Send what was packed; called by the run's thread."""
        self._senders.send(batch)

    def warn(self, text: str) -> None:
        """Log a warning of the run; called by the thread that runs it."""
        self.get_logger().warning(text)

    def say(self, text: str) -> None:
        """Log what somebody asked of the run; called by the thread that runs it."""
        self.get_logger().info(text)

    def report(self, health: Health) -> None:
        """Hand the figures to the executor's thread, which publishes them."""
        self._health = health
        self._reported.trigger()

    def _publish_health(self) -> None:
        self._events.look()
        health = self._whole_health()
        if health is not None:
            stamp = self.get_clock().now().to_msg()
            name = self.get_fully_qualified_name().lstrip('/')
            message = conversions.diagnostics(health, node_name=name, stamp=stamp)
            self._diagnostics.publish(message)

    def _whole_health(self) -> Health | None:
        """Add to the figures of the run what only the node knows."""
        if self._health is None:
            return None
        warnings = (
            *self._health.warnings,
            *self._neighbours.warnings,
            *self._endpoints.misfits(),
        )
        unread = self.listener.unread + (self._door.unread if self._door is not None else 0)
        return replace(self._health, lost=self._endpoints.lost, unread=unread, warnings=warnings)

    def _look_around(self) -> None:
        before = self._neighbours.warnings
        for warning in self._neighbours.look():
            self.warn(warning)
        if self._neighbours.warnings != before:
            self._publish_health()

    def last_words(self) -> str:
        """Publish the figures of the end, let all messages arrive, and put them in a sentence."""
        self._publish_health()
        deadline = time.monotonic() + ARRIVAL
        for publisher in self.publishers:
            left = max(0.0, deadline - time.monotonic())
            publisher.wait_for_all_acked(Duration(seconds=left))
        health = self._whole_health()
        return health.summary() if health is not None else ''

    def serve(self, loop: RunLoop) -> None:
        """Offer the services and the live parameters."""
        self._loop = loop
        self._last_step: Request | None = None
        self._steps_asked = 0
        period = min(LOOK_AROUND, self.settings.diagnostics_period)
        self.create_timer(period, self._look_around, clock=Clock(clock_type=ClockType.STEADY_TIME))
        answers = {
            '~/pause': partial(self._switch, 'pause'),
            '~/record': partial(self._switch, 'record'),
            '~/step': self._step,
            '~/reset': self._reset,
        }
        group = ReentrantCallbackGroup()  # a step that takes long lets others in
        groups = {'~/step': group}
        self._stepped = self.create_guard_condition(_nothing, callback_group=group)
        for name, kind in SERVICES.items():
            self.create_service(kind, name, answers[name], callback_group=groups.get(name))
        self.add_on_set_parameters_callback(self._judge)
        self.add_post_set_parameters_callback(self._apply)

    def _switch(
        self, name: str, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        return conversions.answered(response, self._ask(name, conversions.wanted(request)))

    async def _step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Answer when the last tick is done; the executor goes on meanwhile."""
        self._senders.look()
        ticks = self.get_parameter('step_count').value
        request = Request('step', ticks, self._stepped.trigger)
        before, self._last_step = self._last_step, request
        self._steps_asked += 1
        try:
            if before is not None:  # calls that come together are done one after the other
                await Answered(before, self._has_ended)
            answer = await Answered(self._loop.requests.put(request), self._has_ended)
        finally:
            self._steps_asked -= 1
        if not answer.granted:
            self.get_logger().info(f'step: {answer.message}')
        return conversions.answered(response, answer)

    def _has_ended(self) -> bool:
        return self._loop.ending is not None

    def settle(self, executor: Executor) -> None:
        """Let the answers to ~/step go out that the end of the run has met."""
        spins = 0
        while self._steps_asked and spins < LAST_SPINS:
            executor.spin_once(timeout_sec=LAST_SPIN)
            spins += 1

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return conversions.answered(response, self._ask('reset'))

    def _ask(self, name: str, value: float = 0.0) -> Answer:
        """Wait for the tick boundary at which the run's thread answers."""
        self._senders.look()  # who asks may have begun to listen just before
        request = self._loop.requests.post(name, value)
        while not request.answered.wait(ANSWER_PERIOD):
            if self._loop.ending is not None:
                request.give(Answer(False, ENDED))
        assert request.answer is not None
        if name == 'record' or not request.answer.granted:
            said = request.answer.message.removeprefix(f'{name}: ')  # some refusals begin so
            self.get_logger().info(f'{name}: {said}')
        return request.answer

    def _judge(self, given: list[Parameter]) -> SetParametersResult:
        for parameter in given:
            if parameter.name == 'use_sim_time' and parameter.value:
                return _refused('this node makes the simulation time and must not wait for it')
            if parameter.name in ('real_time_factor', 'command_timeout'):
                assert isinstance(parameter.value, float)  # as they were declared
                problem = parameters.problem_of(parameter.name, parameter.value)
                if problem is not None:
                    return _refused(problem)
        wanted = [each.value for each in given if each.name == 'command_timeout']
        if wanted:  # the thread of the run alone knows whether a recording goes on
            assert isinstance(wanted[-1], float)  # as it was declared
            answer = self._ask('command_timeout', wanted[-1])
            if not answer.granted:
                return _refused(answer.message)
        return SetParametersResult(successful=True)

    def _apply(self, given: list[Parameter]) -> None:
        for parameter in given:
            if parameter.name in ('real_time_factor', 'stop_time'):
                assert isinstance(parameter.value, int | float)  # as they were declared
                self._loop.requests.post(parameter.name, parameter.value)


def _nothing() -> None:
    """Wake the executor, which is all that is wanted."""


def _refused(reason: str) -> SetParametersResult:
    return SetParametersResult(successful=False, reason=reason)
