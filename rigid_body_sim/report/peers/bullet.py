# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
PyBullet: a Python loop over `stepSimulation()`, in reduced and in maximal coordinates.

Damping, sleeping and the limit on joint velocities are off. A spring is a force from Python before
each step, a pivot a point-to-point constraint. There are no wheels for recent Pythons: pip builds
it from source, which takes a quarter of an hour.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.report.peers.engine import Way
from rigid_body_sim.report.peers.task import End, Task

ENGINE = 'PyBullet'
PACKAGE = 'pybullet'

FAST = 1e9  # [rad/s] in place of the limit of 100


def load() -> tuple[str, tuple[Way, ...]]:
    """Its version, and its two kinds of coordinates."""
    from importlib.metadata import version

    import pybullet

    return version('pybullet'), (
        Way('reduced coordinates', partial(BulletRunner, pybullet, False), evaluations=1),
        Way('maximal coordinates', partial(BulletRunner, pybullet, True), evaluations=1),
    )


class BulletRunner:
    """A run of PyBullet, in a world of its own."""

    def __init__(self, bullet: Any, maximal: bool, task: Task, dt: float) -> None:
        self.bullet, self.task = bullet, task
        self.steps = round(task.duration / dt)
        self.world = bullet.connect(bullet.DIRECT)
        bullet.setPhysicsEngineParameter(fixedTimeStep=dt, physicsClientId=self.world)
        bullet.setGravity(*task.gravity, physicsClientId=self.world)
        self.bodies = [self._add(index, maximal) for index in range(len(task.bodies))]
        if task.pivot is not None:
            bullet.createConstraint(
                self.bodies[0],
                -1,
                -1,
                -1,
                bullet.JOINT_POINT2POINT,
                [0.0, 0.0, 0.0],
                [-part for part in task.arm],
                list(task.pivot),
                physicsClientId=self.world,
            )
        self.fresh()

    def _add(self, index: int, maximal: bool) -> int:
        bullet, body = self.bullet, self.task.bodies[index]
        inertia = np.eye(3) if body.inertia is None else body.inertia
        if np.any(inertia != np.diag(np.diag(inertia))):
            raise InvalidModel('it takes the principal moments only, along the axes of the body')
        made = bullet.createMultiBody(
            baseMass=body.mass,
            basePosition=self._place(index),
            baseOrientation=body.initial.orientation,
            useMaximalCoordinates=maximal,
            physicsClientId=self.world,
        )
        bullet.changeDynamics(
            made,
            -1,
            localInertiaDiagonal=np.diag(inertia).tolist(),
            linearDamping=0.0,
            angularDamping=0.0,
            maxJointVelocity=FAST,
            activationState=bullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self.world,
        )
        return made

    def _place(self, index: int) -> list[float]:
        """Where the centre of mass is at the start."""
        task, start = self.task, self.task.bodies[index].initial
        if task.pivot is None:
            return list(start.position)
        arm = so3.rotate(np.asarray(start.orientation), np.asarray(task.arm))
        return (np.asarray(task.pivot) + arm).tolist()

    def fresh(self) -> None:
        """Back to the start."""
        task = self.task
        for index, (made, body) in enumerate(zip(self.bodies, task.bodies, strict=True)):
            start = body.initial
            velocity = np.asarray(start.velocity)
            if task.pivot is not None:
                arm = so3.rotate(np.asarray(start.orientation), np.asarray(task.arm))
                velocity = np.cross(start.angular_velocity, arm)
            self.bullet.resetBasePositionAndOrientation(
                made, self._place(index), start.orientation, physicsClientId=self.world
            )
            self.bullet.resetBaseVelocity(
                made, velocity.tolist(), start.angular_velocity, physicsClientId=self.world
            )

    def advance(self) -> None:
        """Step after step; a spring is the caller's."""
        task, world, step = self.task, self.world, self.bullet.stepSimulation
        if not task.stiffness and not task.damping:
            for _ in range(self.steps):
                step(world)
            return
        place, speed = self.bullet.getBasePositionAndOrientation, self.bullet.getBaseVelocity
        push, frame = self.bullet.applyExternalForce, self.bullet.WORLD_FRAME
        body, k, c, (ax, ay, az) = self.bodies[0], task.stiffness, task.damping, task.anchor
        for _ in range(self.steps):
            x, y, z = at = place(body, world)[0]
            u, v, w = speed(body, world)[0]
            force = (k * (ax - x) - c * u, k * (ay - y) - c * v, k * (az - z) - c * w)
            push(body, -1, force, at, frame, world)
            step(world)

    def final(self) -> End:
        """Read places and velocities."""
        states = [
            (
                *self.bullet.getBasePositionAndOrientation(body, self.world),
                *self.bullet.getBaseVelocity(body, self.world),
            )
            for body in self.bodies
        ]
        position, q, velocity, spin = (np.array(part) for part in zip(*states, strict=True))
        if self.task.is_point:
            return End.of_points(position, velocity)
        return End(position, q, velocity, spin)

    def __del__(self) -> None:
        if hasattr(self, 'world'):
            self.bullet.disconnect(self.world)
