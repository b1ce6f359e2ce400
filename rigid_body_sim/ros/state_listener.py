# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Listens to the states of a running node, for a page that shows them live.

Of the nodes that publish poses (PoseStamped on `…/pose`), the first that has a parameter `scene`
is the simulation; all of its topics are listened to, wherever they are remapped, and those of
nobody else; bodies without topics of their own are taken from the arrays `poses` and `twists`, in
the order of the scene. Where that scene cannot be read here, bodies are drawn without their
shapes, and arrays, which tell no names, not at all. Where no node has one, bodies are whatever has
a topic `NAMESPACE/<body>/pose` in one namespace.

Where the node goes and comes back, or another one in its place, or its time goes back, all of this
is done again, and another run begins.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import GetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.acting_elements import is_timed
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.every_body import ARRAYS, BodyArray, arrays_of
from rigid_body_sim.recording.topic_names import own_by_kind
from rigid_body_sim.ros import conversions
from rigid_body_sim.ros.domain import check_domain
from rigid_body_sim.ros.health import SCENE_BEGAN
from rigid_body_sim.scene import load_scene
from rigid_body_sim.stop_signals import STOP, say
from rigid_body_sim.view.growing_motion import KINDS, GrowingMotion, tells_motion
from rigid_body_sim.view.recorded_motion import RecordedMotion

FINDING = 15.0  # [s] for a node to be found; discovery takes up to 2.5 s on a quiet machine
SETTLING = 1.0  # [s] after the last topic, for others
MISSING = 4.0  # [s] likewise where a body of the scene has none: what got lost comes after 3 s
FIRST = 10.0  # [s] for the first state of all bodies; a paused node repeats it every second
ANSWER = 5.0  # [s] for a parameter
DEPTH = 1000  # [messages] that may wait between two looks
MOST_AT_ONCE = 25  # instants of one look
CHECK = 1.0  # [s] between looks whether the node is still there

Wires = dict[str, str]  # topic on the wire -> its type


class _Publisher(NamedTuple):
    """A node that publishes."""

    namespace: str
    name: str

    @property
    def path(self) -> str:
        return f'{self.namespace.rstrip("/")}/{self.name}'


class StateListener:
    """
    A node that listens; use it in a `with`.

    scene, title, about : known after `begin`
    ended               : never: who publishes may come back
    run                 : another number where another run begins
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
        self._subscriptions: list[Subscription] = []
        self._health_topic = ''  # on which the node that has the scene tells of resets
        self._source = ''  # a topic of poses that is listened to, and who publishes it
        self._endpoints: set[bytes] = set()
        self._checked = 0.0
        self.run = 0

    def __enter__(self) -> StateListener:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def begin(self) -> RecordedMotion:
        """Find the node and wait for its first state; RunError if there is none."""
        self._listen_to(self._find())
        deadline = time.monotonic() + FIRST
        while (first := self._next()) is None:
            STOP.check(lambda: 'before a state came')
            if time.monotonic() > deadline:
                bodies = len(self._motion.poses)
                raise RunError(
                    f'{bodies} bodies have topics, but no state of all of them came within '
                    f'{FIRST:g} s'
                )
            self._executor.spin_once(timeout_sec=0.05)
        return first

    def more(self) -> RecordedMotion | None:
        """Give what came since the last call; of another run from its begin on."""
        block = self._next()
        if self._motion.run == 0 and not self._has_changed():
            return block
        self.run += 1
        with suppress(RunError):  # it may still come
            return self.begin()
        return None

    def _next(self) -> RecordedMotion | None:
        deadline = time.monotonic() + 0.05
        while time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.005)
        return self._motion.whole(most=MOST_AT_ONCE)

    def _has_changed(self) -> bool:
        """Whether somebody else publishes now, here or, where nobody does, elsewhere."""
        if time.monotonic() - self._checked < CHECK:
            return False
        self._checked = time.monotonic()
        now = self._endpoints_of(self._source)
        if now:
            return not now & self._endpoints
        return bool(self._candidates())

    def _endpoints_of(self, topic: str) -> set[bytes]:
        return {
            bytes(each.endpoint_gid) for each in self._node.get_publishers_info_by_topic(topic)
        }

    def _listen_to(self, names: dict[str, str]) -> None:
        """Subscribe to topics on the wire, and take each as what it is: wire -> own."""
        for each in self._subscriptions:
            self._node.destroy_subscription(each)
        arrays = self._arrays_among(names)
        cut = [topic.name for array in arrays.values() for topic in array.parts.values()]
        own_names = [*names.values(), *cut]
        poses = list(filter(_is_pose, own_names))
        if self.scene is not None:  # scene order, which colours follow
            order = {body.name: place for place, body in enumerate(self.scene.bodies)}
            poses.sort(key=lambda name: order.get(name.split('/')[-2], len(order)))
        self._motion = motion = GrowingMotion(poses, own_names, arrays=arrays, late=True)
        names = {wire: own for wire, own in names.items() if own in arrays or _leaf(own) in KINDS}
        self._subscriptions = [
            self._node.create_subscription(
                conversions.MESSAGE_TYPES[(KINDS | ARRAYS)[_leaf(own)]],
                wire,
                _taker(motion, own),
                QoSProfile(depth=DEPTH),
                raw=True,
            )
            for wire, own in names.items()
        ]
        if self._health_topic:
            self._subscriptions.append(
                self._node.create_subscription(
                    DiagnosticArray, self._health_topic, self._take_health, QoSProfile(depth=DEPTH)
                )
            )
        self._source = next(
            wire for wire, own in names.items() if _is_pose(own) or _leaf(own) == 'poses'
        )
        self._endpoints = self._endpoints_of(self._source)

    def _take_health(self, told: DiagnosticArray) -> None:
        """Note when the scene began, where something in it depends on time."""
        figures = conversions.figures(told, node_name=self.about.lstrip('/'))
        with suppress(KeyError, ValueError):
            began, known = float(figures[SCENE_BEGAN]), self._motion.began
            if not known or began > known[-1]:
                self._motion.began = (*known, began)

    def _arrays_among(self, names: dict[str, str]) -> dict[str, BodyArray]:
        """Find the arrays that hold bodies without topics of their own."""
        if self.scene is None:
            return {}
        kinds = {own: (KINDS | ARRAYS)[_leaf(own)] for own in names.values()}
        space = next((_folder(own) for own in kinds if _leaf(own) in ARRAYS), '')
        return arrays_of([body.name for body in self.scene.bodies], kinds, namespace=space)

    def _find(self) -> dict[str, str]:
        """Topics of states, wire -> own, once they stay the same for a moment."""
        deadline, since = time.monotonic() + FINDING, 0.0
        known: dict[_Publisher, Wires] = {}
        chosen: dict[str, str] | None = None
        while True:
            STOP.check(lambda: 'before a node was found')
            found, now = self._candidates(), time.monotonic()
            if found != known:
                since, known, chosen = now, found, None
            elif found and now - since > SETTLING:
                chosen = self._chosen(found) if chosen is None else chosen
                if self._has_every_body(chosen) or now - since > MISSING:
                    return chosen
            if now > deadline:
                raise RunError(self._nobody())
            self._executor.spin_once(timeout_sec=0.1)

    def _has_every_body(self, names: dict[str, str]) -> bool:
        """Whether among topics, wire -> own, there are states of all bodies of the scene."""
        arrays = self._arrays_among(names).values()
        cut = [topic.name for array in arrays for topic in array.parts.values()]
        told = {tuple(own.rsplit('/', 2)[1:]) for own in (*names.values(), *cut)}
        bodies = () if self.scene is None else self.scene.bodies
        return all((body.name, part) in told for body in bodies for part in ('pose', 'twist'))

    def _published(self) -> dict[_Publisher, Wires]:
        """What each node publishes."""
        found: dict[_Publisher, Wires] = defaultdict(dict)
        for name, namespace in self._node.get_node_names_and_namespaces():
            with suppress(NodeNameNonExistentError):  # it has gone
                topics = self._node.get_publisher_names_and_types_by_node(name, namespace)
                found[_Publisher(namespace, name)] = {wire: kinds[0] for wire, kinds in topics}
        return found

    def _candidates(self) -> dict[_Publisher, Wires]:
        """Nodes that publish poses in the namespace, those first that tell twists too."""
        found = {}
        for node, wires in sorted(self._published().items()):
            known = {*KINDS.values(), *ARRAYS.values()}
            told = {wire: kind for wire, kind in wires.items() if kind in known}
            spaces = {node.namespace.rstrip('/')}
            poses = [wire for wire in told if tells_motion(wire, told[wire]) and _is_pose(wire)]
            spaces.update(map(_space, poses))
            if (poses or _array_wires(told)) and (
                self._namespace is None or self._namespace in spaces
            ):
                found[node] = told
        twist = KINDS['twist']
        return dict(sorted(found.items(), key=lambda each: twist not in each[1].values()))

    def _chosen(self, found: dict[_Publisher, Wires]) -> dict[str, str]:
        """Topics, wire -> own, of the node that has a scene, else of one namespace."""
        self.scene, self.about, self._health_topic = None, next(iter(found)).path, ''
        for node, wires in found.items():
            STOP.check(lambda: 'before a node told its scene')
            name = self._scene_of(node)
            if not name:
                continue
            self.about = node.path
            with suppress(UserError, RunError, InvalidModel, OSError):
                self.scene = load_scene(name)
                self.title = self.scene.name
            if self.scene is not None and is_timed(self.scene):
                self._health_topic = self._health_topic_of(node)
            bodies = [] if self.scene is None else [body.name for body in self.scene.bodies]
            names, lost = own_by_kind(wires, bodies, namespace=node.namespace, kinds=KINDS)
            if lost:
                say(
                    f'{node.path}: remapping rules give {", ".join(sorted(lost))} names of which '
                    'nobody can tell the bodies; these are left out'
                )
            if self.scene is not None:
                names |= _array_wires(wires, node.namespace)
            if any(_is_pose(own) or _leaf(own) in ARRAYS for own in names.values()):
                return names
        every = [each for wires in found.values() for each in wires.items()]
        told = {wire for wire, kind in every if tells_motion(wire, kind)}
        spaces = [_space(wire) for wire in told if _is_pose(wire)]
        if not spaces:
            raise RunError(self._nobody())
        wanted = self._namespace if self._namespace in spaces else min(spaces)
        return {wire: wire for wire in sorted(told) if _space(wire) == wanted}

    def _health_topic_of(self, node: _Publisher) -> str:
        """Where a node publishes its diagnostics; empty: nowhere."""
        told = self._published().get(node, {})
        return next((wire for wire, kind in told.items() if kind == conversions.DIAGNOSTICS), '')

    def _nobody(self) -> str:
        """Say what is missing."""
        space = self._namespace
        where = 'this ROS domain' if space is None else f'the namespace {space}'
        for node, wires in sorted(self._published().items()):
            own = space in (None, node.namespace.rstrip('/'))
            if own and any(kind == cdr.POSE_ARRAY for kind in wires.values()):
                return (
                    f'{node.path} publishes no topic …/pose of a body, but all poses in an array, '
                    'and its scene, which tells whose they are, cannot be read here: start it '
                    'with body_topics:=NAMES, or record it and name its BAG'
                )
        return (
            f'no topic …/pose is published in {where} (looked for {FINDING:g} s): start the node, '
            'or name a BAG that is being written'
        )

    def _scene_of(self, node: _Publisher) -> str:
        """Ask a node for its parameter `scene`; empty where it has none."""
        client = self._node.create_client(GetParameters, f'{node.path}/get_parameters')
        deadline = time.monotonic() + ANSWER
        try:
            while not client.service_is_ready() and time.monotonic() < deadline:
                STOP.check(lambda: 'before a node told its scene')
                self._executor.spin_once(timeout_sec=0.05)
            if not client.service_is_ready():
                return ''
            future = client.call_async(GetParameters.Request(names=['scene']))
            while not future.done() and time.monotonic() < deadline:
                self._executor.spin_once(timeout_sec=0.05)
            answer = future.result() if future.done() else None
            return answer.values[0].string_value if answer and answer.values else ''
        finally:
            self._node.destroy_client(client)


def _taker(motion: GrowingMotion, own: str) -> Callable[[bytes], None]:
    return lambda data: motion.take(own, bytes(data))


def _is_pose(topic: str) -> bool:
    return topic.endswith('/pose')


def _leaf(topic: str) -> str:
    return topic.rpartition('/')[2]


def _folder(topic: str) -> str:
    return topic.rpartition('/')[0]


def _array_wires(wires: Wires, namespace: str = '') -> dict[str, str]:
    """Topics of the arrays, wire -> own, of a node that publishes each of them once; else none."""
    found = {
        wire: f'{namespace.rstrip("/")}/{array}'
        for array, kind in ARRAYS.items()
        for wire, its_kind in wires.items()
        if its_kind == kind
    }
    return found if len(found) == len(set(found.values())) == len(ARRAYS) else {}


def _space(topic: str) -> str:
    return topic.rsplit('/', 2)[0]
