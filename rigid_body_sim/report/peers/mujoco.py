# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
MuJoCo: the whole run in one call, `mj_step(m, d, nstep=n)`.

Contact and constraints are switched off, which nothing here needs and which saves 15 %. Point
masses are slide joints with joint stiffness and damping, along the axes on which they move; a
pivot is a ball joint.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from rigid_body_sim.physics import rotation as so3
from rigid_body_sim.physics.model import Body
from rigid_body_sim.report.peers.engine import Way
from rigid_body_sim.report.peers.task import End, Task

ENGINE = 'MuJoCo'
PACKAGE = 'mujoco'

METHODS = {'RK4': 4, 'Euler': 1, 'implicit': 1, 'implicitfast': 1, 'discrete': 1}
OPTION = (
    '<option timestep="{dt!r}" integrator="{method}" gravity="{gravity}">'
    '<flag contact="disable" constraint="disable" autoreset="disable"/></option>'
)


def load() -> tuple[str, tuple[Way, ...]]:
    """Its version, and one way for each of its integrators."""
    import mujoco

    # what diverges is a row of the report; a log file in the user's folder helps nobody
    mujoco.set_mju_user_warning(lambda _message: None)
    known = {name.removeprefix('mjINT_').lower() for name in mujoco.mjtIntegrator.__members__}
    return mujoco.__version__, tuple(
        Way(
            method,
            partial(Run, mujoco, method),
            evaluations=evaluations,
            finer=evaluations > 1,
            most_bodies=100 if method == 'implicit' else 1000,  # grows as their square
        )
        for method, evaluations in METHODS.items()
        if method.lower() in known
    )


class Run:
    """A run of MuJoCo."""

    def __init__(self, mujoco: Any, method: str, task: Task, dt: float) -> None:
        self.mujoco, self.task = mujoco, task
        self.model = mujoco.MjModel.from_xml_string(_document(task, method, dt))
        self.data = mujoco.MjData(self.model)
        self.steps = round(task.duration / dt)
        self._start = _start(task)
        self.fresh()
        mujoco.mj_step(self.model, self.data)

    def fresh(self) -> None:
        """Back to the start."""
        self.mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = self._start

    def advance(self) -> None:
        """All steps in one call."""
        self.mujoco.mj_step(self.model, self.data, nstep=self.steps)

    def final(self) -> End:
        """Read joint positions and velocities."""
        task, qpos, qvel = self.task, self.data.qpos.copy(), self.data.qvel.copy()
        if task.is_point:
            axes = task.axes()
            position, velocity = np.array(task.body.initial.position), np.zeros(3)
            position[axes], velocity[axes] = np.asarray(task.anchor)[axes] + qpos, qvel
            return End.of_points(position, velocity)
        if task.pivot is not None:
            q = qpos[[1, 2, 3, 0]]
            return End.of_pivoted(task, q, so3.rotate(q, qvel))
        qpos, qvel = qpos.reshape(-1, 7), qvel.reshape(-1, 6)
        q = qpos[:, [4, 5, 6, 3]]
        return End(qpos[:, :3], q, qvel[:, :3], so3.rotate(q, qvel[:, 3:]))


def _document(task: Task, method: str, dt: float) -> str:
    bodies = ''.join(_body(task, body) for body in task.bodies)
    option = OPTION.format(dt=dt, method=method, gravity=_numbers(task.gravity))
    return f'<mujoco>{option}<worldbody>{bodies}</worldbody></mujoco>'


def _body(task: Task, body: Body) -> str:
    if task.is_point:
        settings = f'stiffness="{task.stiffness!r}" damping="{task.damping!r}"'
        joints = ''.join(
            f'<joint type="slide" axis="{_numbers(np.eye(3)[axis])}" {settings}/>'
            for axis in task.axes()
        )
        inertia = 'diaginertia="1 1 1"'
    else:
        joints = '<freejoint/>' if task.pivot is None else '<joint type="ball"/>'
        inertia = _inertia(body)
    place = _numbers(task.pivot or task.anchor)
    center = _numbers(task.arm)
    return (
        f'<body pos="{place}">{joints}'
        f'<inertial pos="{center}" mass="{body.mass!r}" {inertia}/></body>'
    )


def _inertia(body: Body) -> str:
    assert body.inertia is not None
    moments = np.diag(body.inertia)
    if np.array_equal(body.inertia, np.diag(moments)):
        return f'diaginertia="{_numbers(moments)}"'
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    return f'fullinertia="{_numbers((xx, yy, zz, xy, xz, yz))}"'


def _start(task: Task) -> tuple[Any, Any]:
    """Joint positions and velocities."""
    if task.is_point:
        axes, start = task.axes(), task.body.initial
        return np.subtract(start.position, task.anchor)[axes], np.asarray(start.velocity)[axes]
    positions, velocities = [], []
    for body in task.bodies:
        start = body.initial
        x, y, z, w = start.orientation
        if task.pivot is None:
            positions += start.position
            velocities += start.velocity
        positions += (w, x, y, z)
        velocities += task.spin(body).tolist()
    return np.array(positions), np.array(velocities)


def _numbers(values: Any) -> str:
    return ' '.join(repr(float(value)) for value in values)
