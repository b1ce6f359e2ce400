# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Direct kinematics of a point of a body: from the motion of the body to that of the point.

    x = r + R d,   v = r' + w x R d,   a = r'' + w' x R d + w x (w x R d)
        d : [m] the point less the centre of mass, body axes     w : [rad/s] angular velocity,
            world axes

Points are given in shape coordinates, like the anchors of springs. Of a body that is moved as told
(`motion`), r'' and w' are the second derivatives of its path, those of the spline of a table too
(`model.prescribed_motion`). Source: Goldstein, Classical
Mechanics, section 4.9.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.physics.model.plain_products import cross
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]


class PointMotion(NamedTuple):
    """
    Motion of points of a body, world axes.

    position     : (..., 3) [m]
    velocity     : (..., 3) [m/s]
    acceleration : (..., 3) [m/s^2]  under all that acts at the start of the coming tick
    """

    position: Array
    velocity: Array
    acceleration: Array


class Moving(Protocol):
    """What is asked of a simulation: `physics.simulation.Simulation`."""

    @property
    def scene(self) -> Scene:
        """What is simulated."""
        ...

    @property
    def state(self) -> State:
        """What moves, scene order."""
        ...

    def accelerations(self) -> tuple[Array, Array]:
        """Linear [m/s^2] and angular [rad/s^2] accelerations now, scene order, world axes."""
        ...

    def body_index(self, body: str) -> int:
        """Scene index of a body."""
        ...


def motion_of(simulation: Moving, body: str, point: ArrayLike) -> PointMotion:
    """
    Give the motion of points of a body now.

    point : (..., 3) [m]  shape coordinates

    Raises InvalidModel for an unknown body, and for anything but points of three finite numbers.
    """
    index = simulation.body_index(body)
    points = _points(body, point)
    state = simulation.state
    linear, angular = simulation.accelerations()
    arm = points - simulation.scene.bodies[index].center_of_mass
    arm = so3.rotate(state.orientation[index], arm)
    omega = state.angular_velocity[index]
    spin = cross(omega, arm)
    return PointMotion(
        state.position[index] + arm,
        state.velocity[index] + spin,
        linear[index] + cross(angular[index], arm) + cross(omega, spin),
    )


def _points(body: str, given: ArrayLike) -> Array:
    """Return points as an array (..., 3) [m]; InvalidModel for anything else."""
    try:
        plain = np.asarray(given)
        points = plain.astype(np.float64) if plain.dtype.kind in 'iuf' else np.full(3, np.nan)
    except (TypeError, ValueError, OverflowError):  # rows of different lengths
        points = np.full(3, np.nan)
    if points.ndim == 0 or points.shape[-1] != 3 or not np.isfinite(points).all():
        raise InvalidModel(
            f'motion_of {body!r}: point {shown(given)}; allowed: three finite numbers [m] in '
            'shape coordinates, or an array (..., 3) of them'
        )
    return points
