# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A problem in words that every engine knows: bodies, gravity, springs to the world, drag, a pivot.

Read from the scene, so that all engines get the same masses, inertias and starts. Springs and drag
on point masses only: those are what engines have as joint springs and joint damping. A force that
stays the same in world axes and acts beside the centre of mass becomes a weight on a pivot, which
engines have as a ball joint: the attitude obeys the same equation, and it alone is compared.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body, Scene, Vector
from rigid_body_sim.physics.model.shapes import Box, Plane, Sphere
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.report.problem import Control, Problem

Array = NDArray[np.float64]

ZERO: Vector = (0.0, 0.0, 0.0)
NO_TURN = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class End:
    """
    The end of a run, rows in scene order; `report.problem.Final` has the meaning of its fields.
    """

    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array

    @classmethod
    def of_points(cls, position: Any, velocity: Any) -> End:
        """Make the end of point masses."""
        position = np.atleast_2d(np.asarray(position, dtype=float))
        velocity = np.atleast_2d(np.asarray(velocity, dtype=float))
        return cls(
            position, np.tile(NO_TURN, (len(position), 1)), velocity, np.zeros_like(position)
        )

    def on_ground(self) -> End:
        """Add the ground, which is the first body of the scene."""
        still = np.zeros((1, 3))
        return End(
            np.concatenate([still, self.position]),
            np.concatenate([np.array([NO_TURN]), self.orientation]),
            np.concatenate([still, self.velocity]),
            np.concatenate([still, self.angular_velocity]),
        )

    @classmethod
    def of_pivoted(cls, task: Task, orientation: Any, angular_velocity: Any) -> End:
        """Make the end of a body on a pivot; xyzw, world axes."""
        q, w = np.asarray(orientation, dtype=float), np.asarray(angular_velocity, dtype=float)
        arm = so3.rotate(q, np.asarray(task.arm))
        return cls((np.asarray(task.pivot) + arm)[None], q[None], np.cross(w, arm)[None], w[None])


@dataclass(frozen=True, eq=False)
class Task:
    """
    What is to be simulated.

    bodies    : as in the scene
    gravity   : (3,) [m/s^2]
    stiffness : [N/m]    of a spring without rest length, from a point mass to `anchor`
    damping   : [N s/m]  of that spring and of linear drag
    anchor    : (3,) [m]
    pivot     : (3,) [m] where the one body is held, world; None: it is free
    arm       : (3,) [m] from the pivot to the centre of mass, body axes
    duration  : [s]
    ground    : the plane z = 0, first body of the scene; None: nothing touches
    control   : who commands all bodies before each step; None: nobody
    """

    bodies: tuple[Body, ...]
    gravity: Vector
    duration: float
    stiffness: float = 0.0
    damping: float = 0.0
    anchor: Vector = ZERO
    pivot: Vector | None = None
    arm: Vector = ZERO
    ground: Body | None = None
    control: Control | None = None

    @property
    def body(self) -> Body:
        """The first body."""
        return self.bodies[0]

    @property
    def is_point(self) -> bool:
        """Whether the bodies are point masses."""
        return self.body.is_point

    def spin(self, body: Body) -> Array:
        """Angular velocity at the start in body axes (3,) [rad/s]."""
        start = body.initial
        return so3.rotate_back(np.asarray(start.orientation), np.asarray(start.angular_velocity))

    def axes(self) -> list[int]:
        """World axes along which the one point mass moves: a user gives it no others."""
        start = self.body.initial
        moves = (np.subtract(start.position, self.anchor) != 0.0) & (self.stiffness != 0.0)
        moves |= (np.asarray(start.velocity) != 0.0) | (np.asarray(self.gravity) != 0.0)
        return [axis for axis in range(3) if moves[axis]] or [0]

    @classmethod
    def of(cls, problem: Problem, bodies: int = 1) -> Task:
        """
        Read a problem; InvalidModel where it holds what engines do not have in common.
        """
        task = cls.of_scene(problem.scene(bodies), problem.duration)
        return dataclasses.replace(task, control=problem.control)

    @classmethod
    def of_scene(cls, scene: Scene, duration: float) -> Task:
        """Read a scene."""
        if any(flow_of(body) or body.inertia_over_time for body in scene.bodies):
            raise InvalidModel('mass and inertia that change over time are not in common')
        if scene.contact['mode'] != 'none' or any(body.fixed for body in scene.bodies):
            return cls(scene.bodies[1:], scene.gravity, duration, ground=_ground(scene))
        found: dict[str, Any] = {'bodies': scene.bodies, 'gravity': scene.gravity}
        pivot = getattr(scene.bodies[0], 'pivot', None)
        if pivot is not None:
            arm = np.subtract(scene.bodies[0].center_of_mass, pivot.point).tolist()
            found |= {'pivot': tuple(pivot.at), 'arm': tuple(arm)}
        for force in scene.forces:
            found |= _force(force, scene, found)
        return cls(duration=duration, **found)


def _ground(scene: Scene) -> Body:
    """
    Return the ground; InvalidModel unless spheres and boxes alone, each about its centre of mass,
    lie on the plane z = 0.
    """
    ground, *others = scene.bodies
    start = ground.initial
    level = isinstance(ground.shape, Plane) and ground.shape == Plane((0.0, 0.0, 1.0), 0.0)
    level = level and (start.position[2], start.orientation) == (0.0, so3.IDENTITY)
    plain = all(
        isinstance(body.shape, (Sphere, Box))
        and not body.fixed
        and body.shape_position == body.center_of_mass
        and body.shape_orientation == so3.IDENTITY
        for body in others
    )
    if not (level and plain) or scene.forces:
        raise InvalidModel(
            'contact is written for spheres and boxes about their centres of mass on the plane '
            'z = 0 only'
        )
    return ground


def _force(force: Any, scene: Scene, found: dict[str, Any]) -> dict[str, Any]:
    """Return what a force element adds."""
    one_point = len(scene.bodies) == 1 and scene.bodies[0].is_point
    if one_point and force.TYPE == 'spring' and force.b == 'world' and not force.rest_length:
        return {
            'stiffness': force.stiffness,
            'damping': found.get('damping', 0.0) + force.damping,
            'anchor': force.b_point or ZERO,
        }
    if one_point and force.TYPE == 'drag' and not force.quadratic:
        return {'damping': found.get('damping', 0.0) + force.linear}
    if _is_weight(force, scene):
        return _on_pivot(force, scene)
    raise InvalidModel(
        f'the force element {force.TYPE} of this problem has no counterpart that is written for '
        'this engine'
    )


def _is_weight(force: Any, scene: Scene) -> bool:
    """Whether it is a constant force on the one rigid body, and nothing else acts beside it."""
    return (
        len(scene.bodies) == 1
        and not scene.bodies[0].is_point
        and len(scene.forces) == 1
        and force.TYPE == 'constant'
        and force.frame == 'world'
        and not any(force.torque)
        and force.point is not None
    )


def _on_pivot(force: Any, scene: Scene) -> dict[str, Any]:
    """
    Hold the body at its centre of mass and put its mass where the force acts.

    I w' + w x I w = a x R^T F,   I = I_c + m (|a|^2 - a a^T),   F = m g
        I : inertia of the scene   I_c : about the centre of mass of the body on the pivot
    """
    body = scene.bodies[0]
    assert body.inertia is not None  # of what is no point
    arm = np.subtract(force.point, body.center_of_mass)
    inertia = body.inertia - body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] <= 0.0 or moments[0] + moments[1] < moments[2]:
        raise InvalidModel('no body on a pivot turns as this one does under its force')
    return {
        'bodies': (dataclasses.replace(body, inertia=inertia),),
        'gravity': tuple(np.asarray(force.force) / body.mass),
        'pivot': ZERO,
        'arm': tuple(arm.tolist()),
    }
