# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The fields of `simulation_interfaces`, as installed: the only place that touches them.

Versions differ: 1.5 (Jazzy) sets pose and twist of an entity together, 2.1 asks which of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from numpy.typing import ArrayLike

from rigid_body_sim.physics.model.scene import Quaternion as Orientation
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.ros.standard.entities import (
    Ball,
    Category,
    Cuboid,
    Entity,
    Refused,
    Unsupported,
    Wanted,
)
from rigid_body_sim.ros.standard.named_poses import NamedPose

NS = 1_000_000_000  # [-] nanoseconds in a second


@dataclass(frozen=True)
class EntityMotion:
    """
    How an entity moves at a tick, or should.

    position, orientation  : [m], [-]         centre of mass, world; xyzw, body to world
    velocity, angular      : [m/s], [rad/s]   world axes
    acceleration, angular_acceleration : [m/s^2], [rad/s^2]  world axes
    """

    position: Vector
    orientation: Orientation
    velocity: Vector
    angular_velocity: Vector
    acceleration: Vector = (0.0, 0.0, 0.0)
    angular_acceleration: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class MotionAsked:
    """
    A state that a client asks for.

    frame_id        : of the header
    pose, twist, acceleration : whether each is to be set
    """

    entity: str
    frame_id: str
    motion: EntityMotion
    pose: bool
    twist: bool
    acceleration: bool


class Messages:
    """The types that are installed; ImportError where there are none."""

    def __init__(self) -> None:
        package = 'simulation_interfaces'
        self.msg: Any = import_module(f'{package}.msg')
        self.srv: Any = import_module(f'{package}.srv')
        self.action: Any = import_module(f'{package}.action')
        category = self.msg.EntityCategory
        self._categories = {
            Category.MOVABLE: category.CATEGORY_DYNAMIC_OBJECT,
            Category.FIXED: category.CATEGORY_STATIC_OBJECT,
        }

    def fill(self, response: Any, code: int, text: str = '') -> Any:
        """Put a result code and a sentence into a response, or the result of an action."""
        response.result.result = code
        response.result.error_message = text
        return response

    def features(self, response: Any, names: Iterable[str], info: str) -> Any:
        """Advertise features by their names in SimulatorFeatures; unknown ones are left out."""
        known = self.msg.SimulatorFeatures
        numbers = [getattr(known, name) for name in names if hasattr(known, name)]
        response.features.features = numbers
        response.features.custom_info = info
        return response

    def wanted(self, filters: Any) -> Wanted:
        """Read which entities a client asks for; Refused and Unsupported."""
        tags = self.msg.TagsFilter
        modes = {tags.FILTER_MODE_ANY: False, tags.FILTER_MODE_ALL: True}
        if filters.tags.filter_mode not in modes:
            raise Refused(
                f'filter_mode {filters.tags.filter_mode}; allowed: {tags.FILTER_MODE_ANY} (any '
                f'tag), {tags.FILTER_MODE_ALL} (all tags)'
            )
        named = {number: category for category, number in self._categories.items()}
        return Wanted(
            pattern=filters.filter,
            categories=[named.get(one.category) for one in filters.categories],
            tags=list(filters.tags.tags),
            every_tag=modes[filters.tags.filter_mode],
            within=self._within(filters.bounds),
        )

    def _within(self, bounds: Any) -> Ball | Cuboid | None:
        kinds = self.msg.Bounds
        if bounds.type == kinds.TYPE_EMPTY:
            return None
        if bounds.type == kinds.TYPE_CONVEX_HULL:
            raise Unsupported(
                'bounds of TYPE_CONVEX_HULL are not supported; ask with TYPE_SPHERE or TYPE_BOX'
            )
        if bounds.type not in (kinds.TYPE_SPHERE, kinds.TYPE_BOX):
            raise Refused(
                f'bounds of type {bounds.type}; allowed: {kinds.TYPE_EMPTY} (everywhere), '
                f'{kinds.TYPE_BOX} (box), {kinds.TYPE_SPHERE} (sphere)'
            )
        points = np.array([(p.x, p.y, p.z) for p in bounds.points]).reshape(-1, 3)
        if len(points) != 2:
            raise Refused(f'bounds hold {len(points)} points; a sphere and a box need two')
        if bounds.type == kinds.TYPE_SPHERE:
            radius = float(points[1, 0])
            if not (np.isfinite([*points[0], radius]).all() and radius >= 0.0):
                raise Refused('a sphere of bounds needs a finite center and radius, 0 and more')
            return Ball(points[0], radius)
        if not np.isfinite(points).all():
            raise Refused('the corners of a box of bounds must be finite')
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        return Cuboid(0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low)

    def info(self, entity: Entity) -> Any:
        """Say what an entity is."""
        info = self.msg.EntityInfo(description=entity.description, tags=list(entity.tags))
        info.category.category = self._categories[entity.category]
        return info

    def bounds(self, box: ArrayLike | None) -> Any:
        """Give a box by its high and low corner; no bounds for None."""
        kinds = self.msg.Bounds
        if box is None:
            return kinds(type=kinds.TYPE_EMPTY)
        low, high = np.asarray(box, dtype=np.float64)
        return kinds(type=kinds.TYPE_BOX, points=[_vector(high), _vector(low)])

    def state(self, motion: EntityMotion, *, stamp_ns: int, frame_id: str) -> Any:
        """Give the state of an entity."""
        state = self.msg.EntityState()
        state.header.frame_id = frame_id
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(stamp_ns, NS)
        state.pose = _pose(motion.position, motion.orientation)
        state.twist.linear = _vector(motion.velocity)
        state.twist.angular = _vector(motion.angular_velocity)
        state.acceleration.linear = _vector(motion.acceleration)
        state.acceleration.angular = _vector(motion.angular_acceleration)
        return state

    def motion_asked(self, request: Any) -> MotionAsked:
        """Read a SetEntityState."""
        state = request.state
        pose, twist, acceleration = state.pose, state.twist, state.acceleration
        return MotionAsked(
            request.entity,
            state.header.frame_id,
            EntityMotion(
                _numbers(pose.position),
                (pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w),
                _numbers(twist.linear),
                _numbers(twist.angular),
                _numbers(acceleration.linear),
                _numbers(acceleration.angular),
            ),
            pose=getattr(request, 'set_pose', True),
            twist=getattr(request, 'set_twist', True),
            acceleration=getattr(request, 'set_acceleration', False),
        )

    def named_poses(self, poses: Sequence[NamedPose], tags: Any) -> list[Any]:
        """Give those of the poses that a filter of tags means; Refused."""
        wanted = self.wanted(self.msg.EntityFilters(tags=tags))
        some_or_all = all if wanted.every_tag else any
        return [
            self.msg.NamedPose(
                name=one.name,
                description=one.description,
                tags=list(one.tags),
                pose=_pose(one.position, one.orientation),
            )
            for one in poses
            if not wanted.tags or some_or_all(tag in one.tags for tag in wanted.tags)
        ]


def _vector(values: Iterable[float]) -> Vector3:
    x, y, z = map(float, values)
    return Vector3(x=x, y=y, z=z)


def _numbers(vector: Any) -> Vector:
    return (vector.x, vector.y, vector.z)


def _pose(position: Iterable[float], orientation: Iterable[float]) -> Pose:
    x, y, z = map(float, position)
    qx, qy, qz, qw = map(float, orientation)
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))
