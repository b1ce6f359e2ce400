# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is simulated: bodies with mass properties and initial motion, forces, gravity, tick length.

Plain frozen records without behaviour. SI units; world axes, z up; quaternions xyzw, body to world.

Body axes are the axes in which the shape was given. The position of a body is the position of its centre of mass;
points on a body (spring anchors, vertices) are given in shape coordinates, whose origin lies at
`-center_of_mass` as seen from the centre of mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.shapes import Shape

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True)
class Motion:
    """
    Position, orientation and velocities of one body at one instant.

    position         : (3,) [m]      centre of mass, world
    orientation      : (4,) [-]      unit quaternion xyzw, body to world
    velocity         : (3,) [m/s]    centre of mass, world
    angular_velocity : (3,) [rad/s]  world axes
    """

    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    velocity: Vector = (0.0, 0.0, 0.0)
    angular_velocity: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Material:
    """Contact material [-]; rolling and torsional friction are lengths [m]."""

    restitution: float = 0.0
    friction: float = 0.5
    rolling_friction: float = 0.0
    torsional_friction: float = 0.0


@dataclass(frozen=True, eq=False)
class Body:
    """
    One body.

    mass           : [kg]       > 0 (0 for a fixed body without mass)
    center_of_mass : (3,) [m]   shape coordinates
    inertia        : (3, 3) [kg m^2]  about the centre of mass, body axes; None for a point mass
    fixed          : immovable: its inverse mass and inertia are zero
    """

    name: str
    shape: Shape | None
    mass: float
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    inertia: NDArray[np.float64] | None = None
    fixed: bool = False
    initial: Motion = Motion()
    material: Material = Material()

    @property
    def is_point(self) -> bool:
        """Whether the body is a point mass: no orientation, no torque."""
        return self.inertia is None and not self.fixed


@dataclass(frozen=True, eq=False)
class Scene:
    """
    One experiment, read and checked.

    dt_ns      : int  tick length [ns]
    integrator : name in the registry
    gravity    : (3,) [m/s^2] uniform, world
    forces     : force element records of `physics.forces`
    contact    : {'mode': 'none'} or the settings of a contact mode
    source     : the exact bytes the scene was read from
    files      : further files the scene names (meshes): name -> bytes
    """

    name: str
    dt_ns: int
    bodies: tuple[Body, ...]
    integrator: str = 'dmv6'
    gravity: Vector = (0.0, 0.0, 0.0)
    forces: tuple[Any, ...] = ()
    contact: Mapping[str, Any] = field(default_factory=lambda: {'mode': 'none'})
    source: bytes = b''
    files: Mapping[str, bytes] = field(default_factory=dict)
