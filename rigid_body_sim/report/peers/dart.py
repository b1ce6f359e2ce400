# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
DART: a Python loop over `World.step()`, the only call it has.

A run that diverges writes lines without end to the standard streams; they are closed to it. Point
masses are translational joints with spring and damping; a pivot is a ball joint.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.report.peers.engine import Way
from rigid_body_sim.report.peers.task import End, Task

ENGINE = 'DART'
PACKAGE = 'dartpy'


def load() -> tuple[str, tuple[Way, ...]]:
    """Its version and its one way of stepping."""
    import dartpy

    return dartpy.__version__, (
        Way('semi-implicit Euler', partial(DartRunner, dartpy), evaluations=1, most_bodies=100),
    )


class DartRunner:
    """A run of DART."""

    def __init__(self, dartpy: Any, task: Task, dt: float) -> None:
        self.dartpy, self.task = dartpy, task
        self.steps = round(task.duration / dt)
        self.world = dartpy.simulation.World()
        self.world.setTimeStep(dt)
        self.world.setGravity(list(task.gravity))
        self.skeletons = [self._skeleton(index) for index in range(len(task.bodies))]
        for skeleton in self.skeletons:
            self.world.addSkeleton(skeleton)
        self.fresh()
        self.world.step()

    def _skeleton(self, index: int) -> Any:
        task, body = self.task, self.task.bodies[index]
        skeleton = self.dartpy.dynamics.Skeleton(f'body{index}')
        if task.is_point:
            joint, node = skeleton.createTranslationalJointAndBodyNodePair()
            for axis in range(3):
                joint.setSpringStiffness(axis, task.stiffness)
                joint.setDampingCoefficient(axis, task.damping)
                joint.setRestPosition(axis, float(task.anchor[axis]))
        elif task.pivot is None:
            _, node = skeleton.createFreeJointAndBodyNodePair()
        else:
            joint, node = skeleton.createBallJointAndBodyNodePair()
            pose = self.dartpy.math.Isometry3()
            pose.set_translation(np.array(task.pivot, dtype=float))
            joint.setTransformFromParentBodyNode(pose)
        inertia = np.eye(3) if body.inertia is None else body.inertia
        node.setInertia(self.dartpy.dynamics.Inertia(body.mass, np.array(task.arm), inertia))
        return skeleton

    def fresh(self) -> None:
        """Back to the start; the velocities of joints are those of the child in its own axes."""
        task = self.task
        self.world.reset()
        for skeleton, body in zip(self.skeletons, task.bodies, strict=True):
            start = body.initial
            if task.is_point:
                skeleton.setPositions(np.array(start.position))
                skeleton.setVelocities(np.array(start.velocity))
                continue
            q = np.asarray(start.orientation)
            turn = self._rotation_vector(q)
            spin = task.spin(body)
            if task.pivot is not None:
                skeleton.setPositions(turn)
                skeleton.setVelocities(spin)
                continue
            skeleton.setPositions(np.concatenate([turn, start.position]))
            velocity = so3.rotate_back(q, np.asarray(start.velocity))
            skeleton.setVelocities(np.concatenate([spin, velocity]))

    def _rotation_vector(self, q: Any) -> Any:
        turn = self.dartpy.math.AngleAxis(so3.matrix_from_quaternion(q))
        return turn.angle() * np.asarray(turn.axis())

    def advance(self) -> None:
        """Step after step."""
        step = self.world.step
        with _silence():
            for _ in range(self.steps):
                step()

    def final(self) -> End:
        """Read the transforms and velocities of the bodies."""
        with _silence():
            return self._read()

    def _read(self) -> End:
        task = self.task
        nodes = [skeleton.getBodyNode(0) for skeleton in self.skeletons]
        if task.is_point:
            return End.of_points(
                [node.getWorldTransform().translation() for node in nodes],
                [node.getLinearVelocity() for node in nodes],
            )
        matrices = np.array([node.getWorldTransform().rotation() for node in nodes])
        q = np.array([_quaternion(self.dartpy, matrix) for matrix in matrices])
        spin = np.array([node.getAngularVelocity() for node in nodes])
        if task.pivot is not None:
            return End.of_pivoted(task, q[0], spin[0])
        return End(
            np.array([node.getCOM() for node in nodes]),
            q,
            np.array([node.getCOMLinearVelocity() for node in nodes]),
            spin,
        )


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Turn what compiled code writes to the standard streams away."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
    finally:
        for stream, copy in enumerate(kept, start=1):
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)


def _quaternion(dartpy: Any, matrix: Any) -> Any:
    """From a rotation matrix to xyzw; NaN where the run diverged."""
    if not np.isfinite(matrix).all():
        return np.full(4, np.nan)
    return dartpy.math.Quaternion(matrix).wxyz()[[1, 2, 3, 0]]
