# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
MuJoCo: the whole run in one call, `mj_step(m, d, nstep=n)`.

Contact and constraints are switched off, which nothing here needs and which saves 15 %. Point
masses are slide joints with joint stiffness and damping, along the axes on which they move; a
pivot is a ball joint.

With contact: pyramidal and elliptic cones; contacts as stiff as the step allows, with a time
constant of two steps and 1 ms at least, and an impedance of 0.99, or as near to one as it takes
("stiff"). It knows no restitution: a bounce without loss is a spring without damping, whose
contact takes twenty steps.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Box, Sphere
from rigid_body_sim.report.peers.engine import Way
from rigid_body_sim.report.peers.task import End, Task
from rigid_body_sim.report.problem import Control

ENGINE = 'MuJoCo'
PACKAGE = 'mujoco'

METHODS = {'RK4': 4, 'Euler': 1, 'implicit': 1, 'implicitfast': 1, 'discrete': 1}
CONES = {'pyramidal': 1, 'elliptic': 10}  # with the ratio of the impedances of friction
IMPEDANCES = {'': 0.99, ', stiff': 0.9999}  # [-] the largest that it takes
SHORTEST = 1e-3  # [s] time constant of a contact
LASTS = 20.0  # [step] what a contact without loss takes
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
    contact = [
        Way(
            f'implicitfast, {cone} cone{words}',
            partial(MujocoRunner, mujoco, 'implicitfast', cone=cone, impedance=impedance),
            evaluations=1,
            contact=True,
        )
        for cone in CONES
        for words, impedance in IMPEDANCES.items()
    ]
    return mujoco.__version__, (
        *contact,
        *(
            Way(
                method,
                partial(MujocoRunner, mujoco, method),
                evaluations=evaluations,
                finer=evaluations > 1,
                most_bodies=100 if method == 'implicit' else 1000,  # grows as their square
                commanded=True,
            )
            for method, evaluations in METHODS.items()
            if method.lower() in known
        ),
    )


START = """
import sys
import mujoco
model = mujoco.MjModel.from_xml_string(sys.stdin.read())
mujoco.mj_step(model, mujoco.MjData(model))
"""


def start(task: Task, dt: float) -> tuple[str, str]:
    """Give a program that makes one step, and the model that it reads; from its zero position."""
    if task.ground is None:
        return START, _document(task, 'Euler', dt)
    return START, _contact(task, 'implicitfast', dt, 'pyramidal', IMPEDANCES[''])


class MujocoRunner:
    """A run of MuJoCo."""

    def __init__(
        self,
        mujoco: Any,
        method: str,
        task: Task,
        dt: float,
        *,
        cone: str | None = None,
        impedance: float = 0.99,
    ) -> None:
        self.mujoco, self.task = mujoco, task
        document = (
            _document(task, method, dt)
            if cone is None
            else _contact(task, method, dt, cone, impedance)
        )
        self.model = mujoco.MjModel.from_xml_string(document)
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
        """All steps in one call, or one by one where each is commanded."""
        if self.task.control is None:
            self.mujoco.mj_step(self.model, self.data, nstep=self.steps)
        else:
            self._command(self.task.control)

    def _command(self, control: Control) -> None:
        """
        Read, command, step, by views of its arrays. Angular velocities are in body axes: the same
        for bodies that begin unturned and keep their axis of rotation.
        """
        step, model, data = self.mujoco.mj_step, self.model, self.data
        rates, wrenches = data.qvel.reshape(-1, 6), data.xfrc_applied[1:]
        velocity, spin = rates[:, :3], rates[:, 3:]
        for _ in range(self.steps):
            wrenches[:, :3], wrenches[:, 3:] = control(velocity, spin)
            step(model, data)

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
        end = End(qpos[:, :3], q, qvel[:, :3], so3.rotate(q, qvel[:, 3:]))
        return end if task.ground is None else end.on_ground()


def _document(task: Task, method: str, dt: float) -> str:
    bodies = ''.join(_body(task, body) for body in task.bodies)
    option = OPTION.format(dt=dt, method=method, gravity=_numbers(task.gravity))
    return f'<mujoco>{option}<worldbody>{bodies}</worldbody></mujoco>'


def _contact(task: Task, method: str, dt: float, cone: str, impedance: float) -> str:
    """Write a scene with a ground; friction and restitution are those of the first body."""
    material = task.body.material
    impedances = f'solimp="{impedance} {impedance} 0.001"'
    if material.restitution == 0.0:
        spring = f'solref="{max(2.0 * dt, SHORTEST)!r} 1" {impedances}'
    elif material.restitution == 1.0:
        spring = f'solref="{-((math.pi / (LASTS * dt)) ** 2)!r} 0" {impedances}'
    else:
        raise InvalidModel('it has no restitution between 0 and 1')
    shared = f'condim="3" friction="{material.friction!r} 0 0" {spring}'
    bodies = ''.join(
        f'<body><freejoint/><inertial pos="0 0 0" mass="{body.mass!r}" {_inertia(body)}/>'
        f'<geom {_shape(body)} mass="0" {shared}/></body>'
        for body in task.bodies
    )
    return (
        f'<mujoco><option timestep="{dt!r}" integrator="{method}" cone="{cone}" '
        f'impratio="{CONES[cone]}" gravity="{_numbers(task.gravity)}">'
        '<flag autoreset="disable"/></option>'
        f'<worldbody><geom type="plane" size="0 0 1" {shared}/>{bodies}</worldbody></mujoco>'
    )


def _shape(body: Body) -> str:
    if isinstance(body.shape, Sphere):
        return f'type="sphere" size="{body.shape.radius!r}"'
    assert isinstance(body.shape, Box)
    return f'type="box" size="{_numbers(0.5 * np.asarray(body.shape.size))}"'


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
