# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Another node, in the process of a test: it hears topics, publishes bytes, and calls services.

Everything happens in the thread that calls; what comes meanwhile waits in the middleware.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import SetBool, Trigger

from rigid_body_sim.ros import conversions, qos
from rigid_body_sim.ros.listener import NotForExecutors, OwnWaitSet

DEPTH = 1000  # [messages] that may wait while the test does something else
GLANCE = 0.02  # [s] between looks at what does not wake anybody

Taker = Callable[[str, bytes], object]


class Peer:
    """
    One node with a context of its own.

    domain : number of its DDS domain
    heard  : absolute topic name -> type name
    take   : called with topic and bytes of each message, by `hear`
    """

    def __init__(self, domain: int, heard: Mapping[str, str], take: Taker) -> None:
        self._context = Context()
        rclpy.init(
            args=[],
            context=self._context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        with warnings.catch_warnings():  # of what rclpy imports now, and the test cannot mend
            warnings.simplefilter('ignore', DeprecationWarning)
            self._node = Node(
                f'test_{time.monotonic_ns()}',
                context=self._context,
                start_parameter_services=False,
                enable_rosout=False,
            )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._publishers: dict[str, Publisher] = {}
        self._clients: dict[tuple[type, str], Any] = {}
        self._health = b''
        takers = {
            self._subscription(conversions.MESSAGE_TYPES[kind], name): _named(take, name)
            for name, kind in heard.items()
        }
        self._states = list(takers)
        takers[self._subscription(DiagnosticArray, '/diagnostics')] = self._take_health
        self._ears = OwnWaitSet(self._context, takers)

    def _subscription(self, kind: Any, name: str) -> Any:
        return self._node.create_subscription(
            kind,
            name,
            _nowhere,
            QoSProfile(depth=DEPTH),
            callback_group=NotForExecutors(),
            raw=True,
        )

    def _take_health(self, data: bytes) -> None:
        self._health = data

    def hear(self, seconds: float) -> None:
        """Take what has come, or comes within that time."""
        self._ears.wait(round(seconds * 1e9))

    @property
    def is_connected(self) -> bool:
        """Whether somebody publishes each topic that is heard."""
        return all(heard.get_publisher_count() for heard in self._states)

    def health(self) -> dict[str, str]:
        """Give the last figures of the node by name; empty before the first."""
        if not self._health:
            return {}
        array = deserialize_message(self._health, DiagnosticArray)
        return {pair.key: pair.value for status in array.status for pair in status.values}

    def forget_health(self) -> None:
        """Take the last figures for none."""
        self._health = b''

    def offer(self, name: str, kind: str) -> None:
        """Be ready to publish on a topic."""
        if name not in self._publishers:
            self._publishers[name] = self._node.create_publisher(
                conversions.MESSAGE_TYPES[kind], name, qos.of_commands()
            )

    def is_heard(self, name: str) -> bool:
        """Whether somebody listens to what is published on a topic."""
        return self._publishers[name].get_subscription_count() > 0

    def send(self, name: str, data: bytes) -> None:
        """Publish a message."""
        self._publishers[name].publish(data)

    def ask(self, name: str, request: Any, kind: Any, *, wait: Callable[[], None]) -> Any:
        """
        Call a service and give its response.

        request : True or False for a SetBool, None for a Trigger, or a request of the service
        kind    : type of the service; None for these two
        wait    : called over and over until the response is there; raises when it takes too long
        """
        if kind is None:
            kind = Trigger if request is None else SetBool
            request = kind.Request() if request is None else SetBool.Request(data=request)
        if (kind, name) not in self._clients:
            self._clients[kind, name] = self._node.create_client(kind, name)
        client = self._clients[kind, name]
        while not client.service_is_ready():
            wait()
            time.sleep(GLANCE)
        future = client.call_async(request)
        while not future.done():
            wait()
            self._executor.spin_once(timeout_sec=GLANCE)
        return future.result()

    def set(self, node: str, name: str, value: Any, *, wait: Callable[[], None]) -> str:
        """Set a parameter of a node; return why it was refused, empty if it was not."""
        parameter = Parameter(name, value=value).to_parameter_msg()
        request = SetParameters.Request(parameters=[parameter])
        response = self.ask(f'{node}/set_parameters', request, SetParameters, wait=wait)
        result = response.results[0]
        return '' if result.successful else result.reason or 'refused'

    def close(self) -> None:
        """Leave the domain."""
        self._ears.close()
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()
        # what the middleware made ends here, and not in whichever thread collects garbage later
        del self._ears, self._states, self._publishers, self._clients, self._executor, self._node


def _named(take: Taker, name: str) -> Callable[[bytes], object]:
    return lambda data: take(name, data)


def _nowhere(_: bytes) -> None:
    """Take what the wait set takes."""
