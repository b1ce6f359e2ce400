# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
States that are asked of bodies, `set_state`: pose and twist of the centre of mass, as
nav_msgs/Odometry tells them.

    header.frame_id   the world frame, or empty: the pose is told in it
    child_frame_id    the name of the body: its twist stands along its axes, as they are turned
                      then; anything else: along those of the world
    covariances       recorded, not used

A state acts like a command: from the tick on with which it is recorded. The name of another body,
or of a named frame, is refused as child_frame_id: pose and twist would be those of something else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.named_frames import find_frame
from rigid_body_sim.physics.model.rotation import IDENTITY
from rigid_body_sim.physics.model.scene import Body, Quaternion, Vector
from rigid_body_sim.physics.state.placement import asked_placement, check_placement
from rigid_body_sim.recording import cdr

NO_VECTOR: Vector = (0.0, 0.0, 0.0)
KIND = 'set_state'
LONGEST_SHOWN = 100  # [-] letters of a name that a refusal shows


@dataclass(frozen=True)
class AskedState:
    """
    Pose and twist as they came.

    position, orientation : [m], [-]         world axes; xyzw, of any length but zero
    linear, angular       : [m/s], [rad/s]   along the axes that child_frame_id means
    """

    position: Vector = NO_VECTOR
    orientation: Quaternion = IDENTITY
    linear: Vector = NO_VECTOR
    angular: Vector = NO_VECTOR
    child_frame_id: str = ''

    def axes(self, body: str) -> str:
        """Axes of the twist, as `Simulation.set_state` names them."""
        return 'body' if self.child_frame_id == body else 'world'


def quoted(name: str) -> str:
    """Write a name that came over the wire, of a long one the beginning."""
    return repr(name if len(name) <= LONGEST_SHOWN else f'{name[:LONGEST_SHOWN]}…')


def encode(state: AskedState, *, stamp_ns: int, frame_id: str) -> bytes:
    """Give the message of a state."""
    sec, nanosec = divmod(stamp_ns, 1_000_000_000)
    return cdr.encode(
        cdr.Odometry(
            sec,
            nanosec,
            frame_id,
            state.child_frame_id,
            state.position,
            state.orientation,
            state.linear,
            state.angular,
        )
    )


def decode(message: cdr.Odometry) -> AskedState:
    """Read what a message asks for."""
    return AskedState(
        message.position,
        message.orientation,
        message.linear,
        message.angular,
        message.child_frame_id,
    )


def refusal(
    state: AskedState,
    body: Body,
    *,
    frame_id: str,
    world_frame: str,
    bodies: Mapping[str, Body],
) -> str | None:
    """Say why a movable body cannot be put into a state, in one line; None if it can."""
    if frame_id not in ('', world_frame):
        return (
            f'{KIND} for {body.name!r} in frame {quoted(frame_id)}; a pose is told in the world: '
            f"allowed: '', {world_frame!r}"
        )
    child = state.child_frame_id
    owner = child if child in bodies else _owner(child, bodies)
    if owner is not None and child != body.name:
        what = 'another body' if child in bodies else f'a frame fixed to {owner!r}'
        return (
            f'{KIND} for {body.name!r} with child_frame_id {child!r}, which is {what}; give '
            f'{body.name!r} for a twist in its axes, or {world_frame!r}'
        )
    try:
        check_placement(
            body,
            asked_placement(
                body,
                position=state.position,
                orientation=state.orientation,
                velocity=state.linear,
                angular_velocity=state.angular,
                frame=state.axes(body.name),
            ),
        )
    except InvalidModel as error:
        return str(error)
    return None


def _owner(frame: str, bodies: Mapping[str, Body]) -> str | None:
    if not frame:
        return None
    return next((b.name for b in bodies.values() if b.frames and find_frame(b, frame)), None)
