# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The services and the action of `simulation_interfaces`, the standard of ROS for simulators.

Whatever a service tells or does, it does between two ticks, in the thread of the run (`Visit`).
The executor's thread goes on meanwhile: each call is a coroutine that it looks at again when its
answer has come.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import Executor
from rclpy.node import Node

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.state import snapshot
from rigid_body_sim.physics.state.snapshot import State
from rigid_body_sim.ros.requests import Answer, Answered, Request
from rigid_body_sim.ros.run_loop import RunLoop, Visit
from rigid_body_sim.ros.standard.entities import Entities, Refused, Unsupported
from rigid_body_sim.ros.standard.messages import EntityMotion, Messages, MotionAsked
from rigid_body_sim.ros.standard.named_poses import named_poses
from rigid_body_sim.ros.standard.offered import ACTION, INFO, SERVICES, Service
from rigid_body_sim.ros.standard.simulate_steps import SimulateSteps
from rigid_body_sim.ros.stepping import StepsAsked
from rigid_body_sim.runs.asked_states import KIND, AskedState
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.felt_accelerations import felt_accelerations
from rigid_body_sim.runs.run import Run

_LAST_SPINS = 20  # of the executor, for answers that are on their way when a run has ended
_RESULTS = 5  # of them for the results of actions, which go out a task after their goals
_SPIN = 0.02  # [s]


class Standard:
    """
    The services of one node.

    world_frame : name of the world axes
    """

    def __init__(
        self, node: Node, loop: RunLoop, run: Run, messages: Messages, *, world_frame: str
    ) -> None:
        self._loop = loop
        self._messages = messages
        self._world_frame = world_frame
        scene = run.simulation.scene
        self._entities = Entities(scene)
        self._fixed = {body.name for body in scene.bodies if body.fixed}
        self._poses = named_poses(scene, run.simulation.state)
        self._codes = messages.msg.Result
        self._log = node.get_logger()
        self._calls = 0  # that wait for their answer
        self._action: SimulateSteps | None = None
        felt_accelerations(run.simulation)  # compiled now, and not between two ticks
        group = ReentrantCallbackGroup()  # a call that waits lets others in
        # triggered by the thread of the run: the executor then looks at the calls that wait
        self._answered = node.create_guard_condition(_nothing, callback_group=group)
        self._offered = [one for one in SERVICES if hasattr(self._types(one), one.type)]
        for one in self._offered:
            if one.type == ACTION:
                continue
            node.create_service(
                getattr(messages.srv, one.type),
                f'~/{one.name}',
                partial(self._call, getattr(self, f'_{one.name}')),
                callback_group=group,
            )
        if any(one.type == ACTION for one in self._offered):
            self._action = SimulateSteps(
                node, messages.action.SimulateSteps, group, post=self._post, end=self._end_steps
            )

    def _types(self, service: Service) -> Any:
        return self._messages.action if service.type == ACTION else self._messages.srv

    def settle(self, executor: Executor) -> None:
        """Let the answers of calls go out that the end of the run has met."""
        spins = 0
        while spins < _LAST_SPINS and (self._waiting or spins < _RESULTS):
            executor.spin_once(timeout_sec=_SPIN if self._waiting else 0.0)
            spins += 1

    @property
    def _waiting(self) -> int:
        return self._calls + (self._action.under_way if self._action is not None else 0)

    async def _call(
        self, handler: Callable[[Any, Any], Awaitable[Any]], request: Any, response: Any
    ) -> Any:
        """Answer a call; what a client may not wish is told by its code."""
        self._calls += 1
        try:
            return await handler(request, response)
        except Unsupported as problem:
            return self._fill(response, self._codes.RESULT_FEATURE_UNSUPPORTED, str(problem))
        except Refused as problem:
            return self._fail(response, str(problem))
        except (AttributeError, AssertionError, TypeError) as problem:  # fields of another version
            self._log.error(f'simulation_interfaces: {type(response).__name__}: {problem}')
            return self._fail(response, f'not as this node knows it: {problem}')
        finally:
            self._calls -= 1

    def _fill(self, response: Any, code: int, text: str = '') -> Any:
        return self._messages.fill(response, code, text)

    def _fail(self, response: Any, text: str) -> Any:
        return self._fill(response, self._codes.RESULT_OPERATION_FAILED, text)

    def _ok(self, response: Any, text: str = '') -> Any:
        return self._fill(response, self._codes.RESULT_OK, text)

    def _not_found(self, response: Any, entity: str) -> Any:
        names = [one.name for one in self._entities.all]
        listed = ', '.join(names[:10]) + ', …' * (len(names) > 10)
        return self._fill(
            response,
            self._codes.RESULT_NOT_FOUND,
            f'no entity is named {entity[:100]!r}; the scene has: {listed}',
        )

    def _post(self, name: str, value: object = 0.0) -> tuple[Request, Answered]:
        request = self._loop.requests.post(name, value, self._answered.trigger)
        return request, Answered(request, lambda: self._loop.ending is not None)

    async def _ask(self, name: str, value: object = 0.0) -> Answer:
        """Wait for the tick boundary at which the run's thread grants a request or refuses it."""
        return await self._post(name, value)[1]

    async def _visit(self, look: Callable[[Visit], Any]) -> Any:
        """Let the run's thread do something between two ticks; give what came of it."""
        found: list[Any] = []
        answer = await self._ask('visit', lambda visit: found.append(look(visit)))
        if not found:
            raise Refused(answer.message)
        return found[0]

    async def _get_simulator_features(self, _: Any, response: Any) -> Any:
        names = [name for one in self._offered for name in one.features]
        return self._messages.features(response, dict.fromkeys(names), INFO)

    async def _get_simulation_state(self, _: Any, response: Any) -> Any:
        states = self._messages.msg.SimulationState
        pausing = await self._visit(lambda visit: visit.paused and not visit.stepping)
        response.state.state = states.STATE_PAUSED if pausing else states.STATE_PLAYING
        return self._ok(response)

    async def _set_simulation_state(self, request: Any, response: Any) -> Any:
        states, asked = self._messages.msg.SimulationState, request.state.state
        if asked in (states.STATE_PAUSED, states.STATE_PLAYING):
            wanted = asked == states.STATE_PAUSED
            is_so, answer = await self._visit(partial(_set_paused, wanted))
            code = response.ALREADY_IN_TARGET_STATE if is_so else self._codes.RESULT_OK
            return self._fill(response, code, answer)
        if asked == states.STATE_QUITTING:
            answer = await self._ask('quit')
            return self._ok(response) if answer.granted else self._fail(response, answer.message)
        if asked == states.STATE_STOPPED:
            raise Unsupported(
                'STATE_STOPPED would take simulation time back to its start, and it goes on; '
                'set STATE_PAUSED, then call reset_simulation with SCOPE_STATE'
            )
        raise Unsupported(
            f'state {asked}: the scene is loaded when the node starts and stays; allowed: '
            f'{states.STATE_PLAYING} (playing), {states.STATE_PAUSED} (paused), '
            f'{states.STATE_QUITTING} (quitting)'
        )

    async def _reset_simulation(self, request: Any, response: Any) -> Any:
        kinds, scope = type(request), request.scope
        if scope != kinds.SCOPE_STATE:
            raise Unsupported(
                f'scope {scope}: only SCOPE_STATE ({kinds.SCOPE_STATE}) is supported; simulation '
                'time goes on at a reset, and nothing is spawned; nothing was reset'
            )
        answer = await self._ask('reset')
        if not answer.granted:
            return self._fail(response, answer.message)
        return self._ok(response, answer.message)

    async def _step_simulation(self, request: Any, response: Any) -> Any:
        answer = await self._ask('steps', StepsAsked(request.steps))
        if not answer.granted:
            return self._fail(response, answer.message)
        return self._ok(response, answer.message)

    def _end_steps(self, response: Any, answer: Answer) -> Any:
        """Put the end of steps into the result of an action."""
        if answer.granted:
            return self._ok(response, answer.message)
        return self._fail(response, answer.message)

    async def _get_entities(self, request: Any, response: Any) -> Any:
        found, _ = await self._found(request)
        response.entities = [self._entities.all[i].name for i in found]
        return self._ok(response)

    async def _get_entities_states(self, request: Any, response: Any) -> Any:
        found, scene = await self._found(request)
        response.entities = [self._entities.all[i].name for i in found]
        response.states = [self._state_of(scene, i) for i in found]
        return self._ok(response)

    async def _found(self, request: Any) -> tuple[Sequence[int], _Scene]:
        """Find the entities that meet the filters of a request, and how they move."""
        wanted = self._messages.wanted(request.filters)
        scene = await self._visit(_look)
        return self._entities.find(wanted, scene.state), scene

    async def _get_entity_info(self, request: Any, response: Any) -> Any:
        index = self._entities.index.get(request.entity)
        if index is None:
            return self._not_found(response, request.entity)
        response.info = self._messages.info(self._entities.all[index])
        return self._ok(response)

    async def _get_entity_state(self, request: Any, response: Any) -> Any:
        index = self._entities.index.get(request.entity)
        if index is None:
            return self._not_found(response, request.entity)
        response.state = self._state_of(await self._visit(_look), index)
        return self._ok(response)

    async def _get_entity_bounds(self, request: Any, response: Any) -> Any:
        index = self._entities.index.get(request.entity)
        if index is None:
            return self._not_found(response, request.entity)
        extent = self._entities.all[index].extent
        if extent.box is None and not extent.is_unbounded:
            raise Refused(f'{request.entity!r} has no shape, and so no bounds')
        response.bounds = self._messages.bounds(extent.box)
        return self._ok(response)

    async def _get_named_poses(self, request: Any, response: Any) -> Any:
        response.poses = self._messages.named_poses(self._poses, request.tags)
        return self._ok(response)

    def _state_of(self, scene: _Scene, index: int) -> Any:
        return self._messages.state(
            scene.motion(index), stamp_ns=scene.time_ns, frame_id=self._world_frame
        )

    async def _set_entity_state(self, request: Any, response: Any) -> Any:
        asked = self._messages.motion_asked(request)
        if asked.entity not in self._entities.index:
            return self._not_found(response, asked.entity)
        if asked.acceleration:
            raise Unsupported(
                'accelerations follow from forces and cannot be set; publish a force'
            )
        if asked.entity in self._fixed:
            raise Refused(f'{asked.entity!r} is fixed: it cannot be moved')
        if asked.frame_id not in ('', self._world_frame):
            raise Refused(
                f'a state of {asked.entity!r} in the frame {asked.frame_id[:100]!r}; allowed: '
                f"'', {self._world_frame!r}"
            )
        if not (asked.pose or asked.twist):
            return self._ok(response, 'nothing was set: set_pose and set_twist are false')
        index = self._entities.index[asked.entity]
        pose_is_bad, reason = await self._visit(partial(_put, asked, index))
        if reason is None:
            return self._ok(response)
        code = response.INVALID_POSE if pose_is_bad else self._codes.RESULT_OPERATION_FAILED
        return self._fill(response, code, reason)


def _nothing() -> None:
    """Wake the executor, which is all that is wanted."""


def _set_paused(wanted: bool, visit: Visit) -> tuple[bool, str]:
    """Pause or go on; whether it was so before."""
    is_so = visit.held if wanted else not visit.paused
    if is_so and not visit.stepping:
        return True, 'already paused' if wanted else 'already playing'
    return False, visit.ask('pause', wanted).message


@dataclass(frozen=True, eq=False)
class _Scene:
    """
    How the bodies move between two ticks.

    linear, angular : accelerations (n, 3) [m/s^2], [rad/s^2]
    """

    time_ns: int
    state: State
    linear: np.ndarray
    angular: np.ndarray

    def motion(self, index: int) -> EntityMotion:
        return EntityMotion(
            self.state.position[index],
            self.state.orientation[index],
            self.state.velocity[index],
            self.state.angular_velocity[index],
            self.linear[index],
            self.angular[index],
        )


def _look(visit: Visit) -> _Scene:
    """Read how the bodies move, those too that the coming tick begins by putting elsewhere."""
    simulation = visit.run.simulation
    linear, angular = felt_accelerations(simulation)
    state = _with_asked(simulation.state, visit)
    return _Scene(simulation.tick * simulation.dt_ns, state, linear, angular)


def _with_asked(state: State, visit: Visit) -> State:
    """Put in what waits in the inbox: it holds as soon as the coming tick begins."""
    asked = visit.inbox.asked_states()
    if not asked:
        return state
    values = state.values.copy()
    for name, one in asked.items():
        row = values[visit.run.simulation.body_index(name)]
        q = np.array(so3.unit_quaternion(one.orientation))
        linear, angular = np.array(one.linear), np.array(one.angular)
        if one.axes(name) == 'body':
            linear, angular = so3.rotate(q, linear), so3.rotate(q, angular)
        row[snapshot.POSITION : snapshot.POSITION + 3] = one.position
        row[snapshot.ORIENTATION : snapshot.ORIENTATION + 4] = q
        row[snapshot.VELOCITY : snapshot.VELOCITY + 3] = linear
        row[snapshot.ANGULAR_VELOCITY : snapshot.ANGULAR_VELOCITY + 3] = angular
    return State(values, state.masses)


def _put(asked: MotionAsked, index: int, visit: Visit) -> tuple[bool, str | None]:
    """Hand a state to the coming tick; whether its pose is bad, and why it is refused."""
    now = _with_asked(visit.run.simulation.state, visit)
    motion = asked.motion
    x, y, z = now.position[index].tolist()
    i, j, k, w = now.orientation[index].tolist()
    as_it_is = AskedState((x, y, z), (i, j, k, w))
    if not asked.pose:
        motion = replace(motion, position=(x, y, z), orientation=(i, j, k, w))
    if not asked.twist:
        x, y, z = now.velocity[index].tolist()
        a, b, c = now.angular_velocity[index].tolist()
        motion = replace(motion, velocity=(x, y, z), angular_velocity=(a, b, c))
    state = AskedState(
        motion.position, motion.orientation, motion.velocity, motion.angular_velocity
    )
    command = Command(asked.entity, KIND, state=state)
    reason = visit.inbox.receive(asked.entity, KIND, command.message)
    if reason is None:
        return False, None
    pose_alone = AskedState(motion.position, motion.orientation)
    refusals = (
        visit.run.rules.refusal(replace(command, state=one)) for one in (pose_alone, as_it_is)
    )
    pose_is_bad = next(refusals) is not None and next(refusals) is None  # or any would be refused
    return pose_is_bad, reason
