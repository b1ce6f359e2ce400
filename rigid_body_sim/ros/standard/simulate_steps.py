# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The action SimulateSteps: so many steps while paused, with feedback, until done or cancelled.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from rclpy.action.server import ActionServer, CancelResponse, ServerGoalHandle
from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node

from rigid_body_sim.ros.requests import Answer
from rigid_body_sim.ros.stepping import StepsAsked


class SimulateSteps:
    """
    The server of the action.

    post : posts a request, and gives it with what to await for its answer
    end  : puts the answer into a result
    """

    def __init__(
        self,
        node: Node,
        kind: Any,
        group: CallbackGroup,
        *,
        post: Callable[[str, object], tuple[Any, Awaitable[Answer]]],
        end: Callable[[Any, Answer], Any],
    ) -> None:
        self._kind = kind
        self._post = post
        self._end = end
        self._goals: dict[bytes, Any] = {}  # what was posted, by the identity of the goal
        self.server = ActionServer(
            node,
            kind,
            '~/simulate_steps',
            self._execute,
            callback_group=group,
            cancel_callback=self._cancel,
        )

    @property
    def under_way(self) -> int:
        """Goals that are still being worked on."""
        return len(self._goals)

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        def progress(done: int, left: int) -> None:
            goal.publish_feedback(self._kind.Feedback(completed_steps=done, remaining_steps=left))

        identity = bytes(goal.goal_id.uuid)
        request, answered = self._post('steps', StepsAsked(goal.request.steps, progress))
        self._goals[identity] = request
        try:
            if goal.is_cancel_requested:  # between its acceptance and now
                self._post('stop_steps', request)
            answer = await answered
            if answer.granted:
                goal.succeed()
            elif goal.is_cancel_requested:
                goal.canceled()
            else:
                goal.abort()
            return self._end(self._kind.Result(), answer)
        finally:
            del self._goals[identity]

    def _cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        request = self._goals.get(bytes(goal.goal_id.uuid))
        if request is not None:
            self._post('stop_steps', request)
        return CancelResponse.ACCEPT
