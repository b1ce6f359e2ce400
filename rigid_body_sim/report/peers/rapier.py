# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Rapier: a Python loop over `PhysicsWorld.step()`, in single precision: its package has no other.

Gyroscopic forces are on, sleeping is off, and the limit on fast rotation is lifted. A spring is
applied from Python before each step, which is more accurate than its spring joint; a pivot is a
spherical joint.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Box, Sphere
from rigid_body_sim.report.peers.engine import Way
from rigid_body_sim.report.peers.task import End, Task
from rigid_body_sim.report.problem import Control

ENGINE = 'Rapier'
PACKAGE = 'rapier3d'
PRECISION = 'f32'


def load() -> tuple[str, tuple[Way, ...]]:
    """Its version; one substep in a step, and the default of four."""
    import rapier3d

    return rapier3d.__version__, (
        *(
            Way(
                f'{substeps} substep{"s" * (substeps > 1)}',
                partial(RapierRunner, rapier3d, substeps),
                evaluations=1,
                commanded=True,
            )
            for substeps in (1, 4)
        ),
        Way('4 substeps', partial(RapierRunner, rapier3d, 4), contact=True),
        Way('20 substeps', partial(RapierRunner, rapier3d, 20), contact=True),
    )


class RapierRunner:
    """A run of Rapier."""

    def __init__(self, rapier: Any, substeps: int, task: Task, dt: float) -> None:
        self.rapier, self.task, self.dt, self.substeps = rapier, task, dt, substeps
        self.steps = round(task.duration / dt)
        self.fresh()

    def fresh(self) -> None:
        """Build the world anew: its handles and caches have no way back."""
        task = self.task
        self.world = self.rapier.PhysicsWorld(gravity=tuple(task.gravity))
        self.world.integration_parameters.dt = self.dt
        self.world.integration_parameters.num_solver_iterations = self.substeps
        self.handles = [self._add(index) for index in range(len(task.bodies))]
        if task.ground is not None:
            plane = self.rapier.Collider.halfspace((0.0, 0.0, 1.0))
            self.world.add_collider(self._rough(plane))
        if task.pivot is not None:
            ground = self.rapier.RigidBodyBuilder(self.rapier.RigidBodyType.FIXED)
            anchor = self.world.add_body(ground.translation(tuple(task.pivot)))
            joint = self.rapier.SphericalJointBuilder()
            joint = joint.local_anchor1((0.0, 0.0, 0.0)).local_anchor2((0.0, 0.0, 0.0))
            self.world.impulse_joints.insert(anchor, self.handles[0], joint.build())

    def _add(self, index: int) -> Any:
        task, body = self.task, self.task.bodies[index]
        rapier, start = self.rapier, body.initial
        q = np.asarray(start.orientation)
        arm = so3.rotate(q, np.asarray(task.arm))
        place = start.position if task.pivot is None else task.pivot
        velocity = np.asarray(start.velocity)
        if task.pivot is not None:
            velocity = np.cross(start.angular_velocity, arm)
        moments, frame = (np.ones(3), np.eye(3))
        if body.inertia is not None:
            moments, frame = np.linalg.eigh(body.inertia)
            frame *= np.sign(np.linalg.det(frame))
        mass = rapier.MassProperties(
            local_com=tuple(task.arm),
            mass=body.mass,
            principal_inertia=tuple(moments),
            principal_inertia_local_frame=_turn(rapier, so3.quaternion_from_matrix(frame)),
        )
        builder = (
            rapier.RigidBodyBuilder(rapier.RigidBodyType.DYNAMIC)
            .position(rapier.Isometry3(tuple(place), _turn(rapier, q)))
            .linvel(tuple(velocity))
            .angvel(tuple(start.angular_velocity))
            .linear_damping(0.0 if task.stiffness else task.damping / body.mass)
            .additional_mass_properties(mass)
            .gyroscopic_forces(True)
            .allow_fast_rotation(True)
            .can_sleep(False)
        )
        handle = self.world.add_body(builder)
        if task.ground is not None:
            self.world.add_collider(self._rough(_collider(rapier, body)).density(0.0), handle)
        return handle

    def _rough(self, collider: Any) -> Any:
        """Give a collider friction and restitution: those of the first body, on both sides."""
        material = self.task.body.material
        return collider.friction(material.friction).restitution(material.restitution)

    def advance(self) -> None:
        """Step after step; a spring is the caller's."""
        step, task = self.world.step, self.task
        if task.control is not None:
            self._command(task.control)
            return
        if not task.stiffness:
            for _ in range(self.steps):
                step()
            return
        body = self.world.rigid_bodies[self.handles[0]]
        stiffness, damping, (ax, ay, az) = task.stiffness, task.damping, task.anchor
        for _ in range(self.steps):
            at, rate = body.translation, body.linvel
            body.reset_forces()
            body.add_force(
                (
                    stiffness * (ax - at.x) - damping * rate.x,
                    stiffness * (ay - at.y) - damping * rate.y,
                    stiffness * (az - at.z) - damping * rate.z,
                )
            )
            step()

    def _command(self, control: Control) -> None:
        """Read, command, step, body by body: it has no arrays of them."""
        bodies = [self.world.rigid_bodies[handle] for handle in self.handles]
        for _ in range(self.steps):
            velocity = np.array([_vector(body.linvel) for body in bodies])
            spin = np.array([_vector(body.angvel) for body in bodies])
            forces, torques = (part.tolist() for part in control(velocity, spin))
            for body, force, torque in zip(bodies, forces, torques, strict=True):
                body.reset_forces()
                body.reset_torques()
                body.add_force(tuple(force))
                body.add_torque(tuple(torque))
            self.world.step()

    def final(self) -> End:
        """Read translations, rotations and velocities."""
        task = self.task
        bodies = [self.world.rigid_bodies[handle] for handle in self.handles]
        position = np.array([_vector(body.translation) for body in bodies])
        velocity = np.array([_vector(body.linvel) for body in bodies])
        if task.is_point:
            return End.of_points(position, velocity)
        q = np.array([_xyzw(body.rotation) for body in bodies])
        q /= np.linalg.norm(q, axis=1)[:, None]
        spin = np.array([_vector(body.angvel) for body in bodies])
        if task.pivot is not None:
            return End.of_pivoted(task, q[0], spin[0])
        end = End(position, q, velocity, spin)
        return end if task.ground is None else end.on_ground()


def _collider(rapier: Any, body: Body) -> Any:
    if isinstance(body.shape, Sphere):
        return rapier.Collider.ball(body.shape.radius)
    assert isinstance(body.shape, Box)
    x, y, z = body.shape.size
    return rapier.Collider.cuboid(0.5 * x, 0.5 * y, 0.5 * z)


def _turn(rapier: Any, q: Any) -> Any:
    """From xyzw."""
    x, y, z, w = (float(part) for part in q)
    return rapier.Rotation3.from_quaternion(w, x, y, z)


def _xyzw(rotation: Any) -> tuple[float, ...]:
    return rotation.i, rotation.j, rotation.k, rotation.w


def _vector(vector: Any) -> tuple[float, ...]:
    return vector.x, vector.y, vector.z
