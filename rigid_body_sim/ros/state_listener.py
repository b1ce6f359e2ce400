# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Listens to the states of a running node, for a page that shows them live.

Bodies are whatever has a topic `NAMESPACE/<body>/pose` (PoseStamped) in one namespace. The scene
is asked of the node that publishes them, by its parameter `scene`; where that cannot be read here,
bodies are drawn without their shapes.
"""

from __future__ import annotations

import time

import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.ros import conversions
from rigid_body_sim.ros.domain import check_domain
from rigid_body_sim.scene import load_scene
from rigid_body_sim.stop_signals import STOP
from rigid_body_sim.view.growing_motion import KINDS, GrowingMotion, tells_motion
from rigid_body_sim.view.recorded_motion import RecordedMotion

FINDING = 15.0  # [s] for a node to be found; discovery takes up to 2.5 s on a quiet machine
SETTLING = 1.0  # [s] after the first topic, for the others
FIRST = 10.0  # [s] for the first state of all bodies; a paused node repeats it every second
ANSWER = 5.0  # [s] for a parameter
DEPTH = 1000  # [messages] that may wait between two looks
MOST_AT_ONCE = 25  # instants of one look


class StateListener:
    """
    A node that listens; use it in a `with`.

    scene, title, about : known after `begin`
    ended               : never: who publishes may come back
    """

    def __init__(self, namespace: str | None = None) -> None:
        """Listen to a namespace; None: the first in which there are poses."""
        check_domain()
        self._namespace = None if namespace is None else f'/{namespace.strip("/")}'.rstrip('/')
        self.scene: Scene | None = None
        self.title, self.about = 'running node', ''
        self.ended = False
        self._context = Context()
        rclpy.init(args=[], context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(
            f'view_{time.monotonic_ns()}',
            context=self._context,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._motion = GrowingMotion((), ())

    def __enter__(self) -> StateListener:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def begin(self) -> RecordedMotion:
        """Find the node and wait for its first state; RunError if there is none."""
        topics = self._find()
        poses = [name for name in topics if name.endswith('/pose')]
        self._ask_scene(poses[0])
        if self.scene is not None:  # scene order, which colours follow
            order = {body.name: place for place, body in enumerate(self.scene.bodies)}
            poses.sort(key=lambda name: order.get(name.split('/')[-2], len(order)))
        self._motion = GrowingMotion(poses, topics, late=True)
        for name in topics:
            kind = conversions.MESSAGE_TYPES[KINDS[name.rpartition('/')[2]]]
            self._node.create_subscription(
                *(kind, name, self._taker(name), QoSProfile(depth=DEPTH)), raw=True
            )
        deadline = time.monotonic() + FIRST
        while (first := self.more()) is None:
            if time.monotonic() > deadline or STOP.number:
                raise RunError(
                    f'{len(poses)} bodies have topics, but no state of all of them came within '
                    f'{FIRST:g} s'
                )
            self._executor.spin_once(timeout_sec=0.05)
        return first

    def more(self) -> RecordedMotion | None:
        """Give what came since the last call."""
        deadline = time.monotonic() + 0.05
        while time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.005)
        return self._motion.whole(most=MOST_AT_ONCE)

    def _taker(self, name: str):
        return lambda data: self._motion.take(name, bytes(data))

    def _find(self) -> list[str]:
        """Topics of states, once they stay the same for a moment."""
        deadline, since, known = time.monotonic() + FINDING, 0.0, []
        while not STOP.number:
            found = sorted(
                name
                for name, kinds in self._node.get_topic_names_and_types()
                if any(tells_motion(name, kind) for kind in kinds)
                and self._node.count_publishers(name)
            )
            found = self._of_one_namespace(found)
            poses = [name for name in found if name.endswith('/pose')]
            now = time.monotonic()
            if found != known:
                since, known = now, found
            elif poses and now - since > SETTLING:
                return found
            if now > deadline:
                break
            self._executor.spin_once(timeout_sec=0.1)
        raise RunError(
            f'no topic …/pose is published in this ROS domain (looked for {FINDING:g} s): start '
            'the node, or name a BAG that is being written'
        )

    def _of_one_namespace(self, topics: list[str]) -> list[str]:
        spaces = {name: name.rsplit('/', 2)[0] for name in topics}
        poses = [space for name, space in spaces.items() if name.endswith('/pose')]
        wanted = min(poses, default='') if self._namespace is None else self._namespace
        return [name for name, space in spaces.items() if space == wanted]

    def _ask_scene(self, topic: str) -> None:
        """Read the scene that the publisher of a topic names, if it can be read here."""
        publishers = self._node.get_publishers_info_by_topic(topic)
        if not publishers:  # it has gone since it was found, and may come back
            return
        about = publishers[0]
        node = f'{about.node_namespace.rstrip("/")}/{about.node_name}'
        client = self._node.create_client(GetParameters, f'{node}/get_parameters')
        deadline = time.monotonic() + ANSWER
        while not client.service_is_ready() and time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.05)
        if not client.service_is_ready():
            return
        future = client.call_async(GetParameters.Request(names=['scene', 'integrator']))
        while not future.done() and time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.05)
        answer = future.result() if future.done() else None
        texts = [value.string_value for value in answer.values] if answer else []
        self.about = node
        try:
            self.scene = load_scene(texts[0]) if texts and texts[0] else None
        except (UserError, RunError, InvalidModel, OSError):
            return
        if self.scene is not None:
            self.title = self.scene.name
