# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Pinocchio: it has dynamics but no stepper, so its users write the loop in Python: ABA, `integrate`.

Semi-implicit Euler, and the Runge–Kutta step of order four that is usually written: the mean of
the four velocities goes to `integrate`, which leaves the attitude of order two. A pivot is a
spherical joint, a point mass a translation joint whose spring is computed in the loop.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.report.peers.engine import Way
from rigid_body_sim.report.peers.task import End, Task

ENGINE = 'Pinocchio'
PACKAGE = 'pin'


def load() -> tuple[str, tuple[Way, ...]]:
    """Its version and two loops."""
    import pinocchio

    return pinocchio.__version__, (
        Way('semi-implicit Euler', partial(Euler, pinocchio), evaluations=1, most_bodies=10),
        Way('Runge–Kutta 4', partial(RungeKutta, pinocchio), evaluations=4, most_bodies=10),
    )


class Euler:
    """A run with v <- v + h a, q <- q (+) h v."""

    def __init__(self, pinocchio: Any, task: Task, dt: float) -> None:
        self.pinocchio, self.task, self.dt = pinocchio, task, dt
        self.steps = round(task.duration / dt)
        self.model = _model(pinocchio, task)
        self.data = self.model.createData()
        self.start = _start(task)
        self.no_torque = np.zeros(self.model.nv)
        self.anchor = np.array(task.anchor)
        self.has_spring = bool(task.stiffness or task.damping)
        self.fresh()

    def fresh(self) -> None:
        """Back to the start."""
        self.q, self.v = (part.copy() for part in self.start)

    def acceleration(self, q: Any, v: Any) -> Any:
        """Joint accelerations."""
        torque = self.no_torque
        if self.has_spring:
            torque = self.task.stiffness * (self.anchor - q) - self.task.damping * v
        return self.pinocchio.aba(self.model, self.data, q, v, torque)

    @np.errstate(all='ignore')  # what diverges is a row of the report
    def advance(self) -> None:
        """Step after step."""
        integrate, model, h = self.pinocchio.integrate, self.model, self.dt
        q, v = self.q, self.v
        for _ in range(self.steps):
            v = v + h * self.acceleration(q, v)
            q = integrate(model, q, h * v)
        self.q, self.v = q, v

    def final(self) -> End:
        """Read joint positions and velocities."""
        task, q, v = self.task, self.q, self.v
        if task.is_point:
            return End.of_points(q, v)
        if task.pivot is not None:
            return End.of_pivoted(task, q, so3.rotate(q, v))
        q, v = q.reshape(-1, 7), v.reshape(-1, 6)
        turns = q[:, 3:]
        return End(q[:, :3], turns, so3.rotate(turns, v[:, :3]), so3.rotate(turns, v[:, 3:]))


class RungeKutta(Euler):
    """A run with the classical step in the tangent space."""

    @np.errstate(all='ignore')  # what diverges is a row of the report
    def advance(self) -> None:
        """Step after step."""
        integrate, model, h = self.pinocchio.integrate, self.model, self.dt
        acceleration = self.acceleration
        q, v = self.q, self.v
        for _ in range(self.steps):
            a1 = acceleration(q, v)
            v2 = v + 0.5 * h * a1
            a2 = acceleration(integrate(model, q, 0.5 * h * v), v2)
            v3 = v + 0.5 * h * a2
            a3 = acceleration(integrate(model, q, 0.5 * h * v2), v3)
            v4 = v + h * a3
            a4 = acceleration(integrate(model, q, h * v3), v4)
            q = integrate(model, q, h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4))
            v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        self.q, self.v = q, v


def _model(pinocchio: Any, task: Task) -> Any:
    """One joint for each body, all of them at the world."""
    model = pinocchio.Model()
    model.gravity.linear = np.array(task.gravity)
    for index, body in enumerate(task.bodies):
        place = pinocchio.SE3.Identity()
        if task.is_point:
            joint = pinocchio.JointModelTranslation()
        elif task.pivot is None:
            joint = pinocchio.JointModelFreeFlyer()
        else:
            joint = pinocchio.JointModelSpherical()
            place.translation = np.array(task.pivot)
        inertia = np.eye(3) if body.inertia is None else body.inertia
        number = model.addJoint(0, joint, place, f'joint{index}')
        about = pinocchio.Inertia(body.mass, np.array(task.arm), inertia)
        model.appendBodyToJoint(number, about, pinocchio.SE3.Identity())
    return model


def _start(task: Task) -> tuple[Any, Any]:
    """Joint positions and velocities; those of a free flyer are in its own axes."""
    if task.is_point:
        start = task.body.initial
        return np.array(start.position), np.array(start.velocity)
    positions, velocities = [], []
    for body in task.bodies:
        q = np.asarray(body.initial.orientation)
        if task.pivot is None:
            positions.append(body.initial.position)
            velocities.append(so3.rotate_back(q, np.asarray(body.initial.velocity)))
        positions.append(q)
        velocities.append(task.spin(body))
    return np.concatenate(positions), np.concatenate(velocities)
