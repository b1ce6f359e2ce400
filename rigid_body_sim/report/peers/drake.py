# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Drake: `Simulator.AdvanceTo` of a multibody plant, the whole run in one call.

Continuous plants with error-controlled integrators (accuracy 1e-2 to 1e-12) and one of fixed step;
the time-stepping plant. Point masses are chains of prismatic joints with springs and damping, free
ones bodies of their own; a pivot is a ball joint of roll, pitch and yaw, the only one it has.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.report.peers.engine import TOLERANCES, Way
from rigid_body_sim.report.peers.task import End, Task

ENGINE = 'Drake'
PACKAGE = 'drake'

CONTROLLED = ('runge_kutta3', 'runge_kutta5', 'radau3')
FIXED = 'runge_kutta3'
LONGEST = 0.1  # [s] step of an error-controlled method: the default of its `Simulator`


def load() -> tuple[str, tuple[Way, ...]]:
    """Its version and three kinds of integration."""
    import pydrake
    from pydrake import all as drake

    controlled = [
        Way(name, partial(DrakeRunner, drake, integrator=name), tolerances=TOLERANCES)
        for name in CONTROLLED
    ]
    return getattr(pydrake, '__version__', _version()), (
        *controlled,
        Way(
            f'{FIXED}, fixed step',
            partial(DrakeRunner, drake, integrator=FIXED, fixed=True),
            evaluations=3,
            most_bodies=100,
        ),
        Way(
            'time stepping',
            partial(DrakeRunner, drake),
            evaluations=1,
            most_bodies=100,
        ),
    )


def _version() -> str:
    from importlib.metadata import version

    return version('drake')


class DrakeRunner:
    """
    A run of Drake.

    setting    : dt [s] of a fixed step, or the accuracy
    integrator : None: the time-stepping plant
    fixed      : whether the step is fixed
    """

    def __init__(
        self,
        drake: Any,
        task: Task,
        setting: float,
        *,
        integrator: str | None = None,
        fixed: bool = False,
    ) -> None:
        self.drake, self.task, self.setting = drake, task, setting
        self.integrator, self.fixed = integrator, fixed
        builder = drake.DiagramBuilder()
        self.plant = builder.AddSystem(
            drake.MultibodyPlant(time_step=setting if integrator is None else 0.0)
        )
        self.plant.mutable_gravity_field().set_gravity_vector(list(task.gravity))
        self.bodies = [_add_body(drake, self.plant, task, i) for i in range(len(task.bodies))]
        self.plant.Finalize()
        self.simulator = drake.Simulator(builder.Build())
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self._set_start()
        self._start = self.simulator.get_context().Clone()
        self.fresh()
        self.simulator.AdvanceTo(min(task.duration, setting if fixed else 1e-3))

    def _set_start(self) -> None:
        task, plant, context = self.task, self.plant, self.context
        if task.is_point and task.stiffness + task.damping:
            axes, start = task.axes(), task.body.initial
            plant.SetPositions(context, np.subtract(start.position, task.anchor)[axes])
            plant.SetVelocities(context, np.asarray(start.velocity)[axes])
            return
        for body, description in zip(self.bodies, task.bodies, strict=True):
            start = description.initial
            x, y, z, w = start.orientation
            R = self.drake.RotationMatrix(self.drake.Quaternion(_unit((w, x, y, z))))
            if task.pivot is not None:
                joint = plant.GetJointByName('pivot')
                joint.set_angles(context, self.drake.RollPitchYaw(R).vector())
                joint.set_angular_velocity(context, start.angular_velocity)
                return
            plant.SetFreeBodyPose(
                context, body, self.drake.RigidTransform(R, np.array(start.position))
            )
            velocity = self.drake.SpatialVelocity(start.angular_velocity, start.velocity)
            plant.SetFreeBodySpatialVelocity(context, body, velocity)

    def fresh(self) -> None:
        """Back to the start, with the step that the method begins with."""
        self.simulator.get_mutable_context().SetTimeStateAndParametersFrom(self._start)
        if self.integrator is not None:
            self._set_method()
        self.simulator.Initialize()

    def _set_method(self) -> None:
        longest = self.setting if self.fixed else LONGEST
        self.drake.ResetIntegratorFromFlags(self.simulator, self.integrator, longest)
        method = self.simulator.get_mutable_integrator()
        method.set_fixed_step_mode(self.fixed)
        method.set_maximum_step_size(longest)
        if not self.fixed:
            method.set_target_accuracy(self.setting)

    def advance(self) -> None:
        """All of the time in one call."""
        try:
            self.simulator.AdvanceTo(self.task.duration)
        except RuntimeError as error:  # a ball joint at its singularity, a step that shrinks away
            raise SimulationDiverged(body=self.task.body.name, tick=0, cause=str(error)) from None

    def final(self) -> End:
        """Read poses and spatial velocities of the bodies."""
        poses = [self.plant.EvalBodyPoseInWorld(self.context, body) for body in self.bodies]
        rates = [
            self.plant.EvalBodySpatialVelocityInWorld(self.context, body) for body in self.bodies
        ]
        spin = np.array([rate.rotational() for rate in rates])
        wxyz = [pose.rotation().ToQuaternion().wxyz() for pose in poses]
        q = np.array(wxyz)[:, [1, 2, 3, 0]]
        if self.task.pivot is not None:
            return End.of_pivoted(self.task, q[0], spin[0])
        position = np.array([pose.translation() for pose in poses])
        return End(position, q, np.array([rate.translational() for rate in rates]), spin)


def _add_body(drake: Any, plant: Any, task: Task, index: int) -> Any:
    """Add a body, and the joints that hold it."""
    description = task.bodies[index]
    mass = description.mass
    inertia = np.eye(3) if description.inertia is None else description.inertia
    about = drake.RotationalInertia(*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2])
    central = drake.SpatialInertia(
        mass, np.zeros(3), drake.UnitInertia().SetFromRotationalInertia(about, mass)
    )
    body = plant.AddRigidBody(f'body{index}', central.Shift(-np.asarray(task.arm)))
    if task.pivot is not None:
        anchor = _anchor(drake, plant, task.pivot)
        plant.AddJoint(drake.BallRpyJoint('pivot', anchor, body.body_frame()))
    elif task.is_point and task.stiffness + task.damping:
        _add_slides(drake, plant, task, body)
    return body


def _add_slides(drake: Any, plant: Any, task: Task, body: Any) -> None:
    """Join a point mass to its anchor, one prismatic joint for each axis along which it moves."""
    frame = _anchor(drake, plant, task.anchor)
    axes = task.axes()
    for axis in axes:
        child = body if axis == axes[-1] else plant.AddRigidBody(f'link{axis}', _nothing(drake))
        joint = plant.AddJoint(
            drake.PrismaticJoint(
                f'slide{axis}',
                frame,
                child.body_frame(),
                np.eye(3)[axis],
                damping=task.damping,
            )
        )
        if task.stiffness:
            plant.AddForceElement(drake.PrismaticSpring(joint, 0.0, task.stiffness))
        frame = child.body_frame()


def _anchor(drake: Any, plant: Any, place: Any) -> Any:
    pose = drake.RigidTransform(np.array(place, dtype=float))
    return plant.AddFrame(drake.FixedOffsetFrame('anchor', plant.world_frame(), pose))


def _nothing(drake: Any) -> Any:
    return drake.SpatialInertia.Zero()


def _unit(q: Any) -> Any:
    return np.asarray(q, dtype=float) / np.linalg.norm(q)
