# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is simulated: bodies with mass properties and initial motion, forces, gravity, tick length.

Plain frozen records without behaviour. SI units; world axes, z up; quaternions xyzw, body to
world.

Body axes are the axes in which the shape was given, unless `shape_orientation` turns it in them.
The position of a body is the position of its centre of mass; points on a body (spring anchors) are
given in body coordinates, whose origin lies at `-center_of_mass` as seen from the centre of mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import blaming
from rigid_body_sim.physics.model.locked_arrays import LockedArrays, locked, locked_mapping
from rigid_body_sim.physics.model.material import USUAL, Material
from rigid_body_sim.physics.model.rotation import IDENTITY, unit_quaternion
from rigid_body_sim.physics.model.shapes import Shape
from rigid_body_sim.physics.model.shown_scene import html_of, line_of

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True)
class Motion:
    """
    Position, orientation and velocities of one body at one instant.

    position         : (3,) [m]      centre of mass, world
    orientation      : (4,) [-]      unit quaternion xyzw, body to world
    velocity         : (3,) [m/s]    centre of mass, world; of a body that is moved as told, the
                       steady part of that of the point that follows the path
    angular_velocity : (3,) [rad/s]  world axes; of a body that is moved as told, the steady part

    An orientation of another length is scaled to one, as that of a scene file is.
    """

    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = IDENTITY
    velocity: Vector = (0.0, 0.0, 0.0)
    angular_velocity: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.orientation is not IDENTITY:
            with blaming('orientation'):
                object.__setattr__(self, 'orientation', unit_quaternion(self.orientation))


@dataclass(frozen=True)
class MassFlow:
    """
    Mass that a body loses or gains at a steady rate, from the start of the scene on.

    m(t) = m0 + rate t, until m is final_mass;   thrust = rate * exhaust_velocity
        rate             : [kg/s]      negative: loses
        exhaust_velocity : (3,) [m/s]  of that mass relative to the body as it leaves or before it
                           joins; body axes, world axes for a point mass
        final_mass       : [kg]        None: the flow never ends
    """

    rate: float
    exhaust_velocity: Vector = (0.0, 0.0, 0.0)
    final_mass: float | None = None


@dataclass(frozen=True)
class InertiaOverTime:
    """
    Principal moments that change over time while mass and axes stay, see
    `model.inertia_over_time`.

    table         : rows (time [s], ixx, iyy, izz [kg m^2]), times ascending
    interpolation : 'smooth' or 'linear'
    """

    table: tuple[tuple[float, float, float, float], ...]
    interpolation: str = 'smooth'


@dataclass(frozen=True)
class Pivot:
    """
    A point of a body that stays where it is: a ball joint to the world.

    point : (3,) [m]  shape coordinates
    at    : (3,) [m]  world
    """

    point: Vector
    at: Vector


@dataclass(frozen=True)
class Oscillation:
    """
    A sin(2 pi t/period + phase), see `model.prescribed_motion`.

    amplitude : A [m] or [rad];   period : [s];   phase : [rad]
    """

    amplitude: float
    period: float
    phase: float = 0.0


@dataclass(frozen=True)
class PrescribedMotion(LockedArrays):
    """
    How a body is moved, whatever acts on it, see `model.prescribed_motion`; its `initial` motion
    goes on beneath.

    surge, sway, heave : oscillations along x, y, z [m], world
    roll, pitch, yaw   : oscillations about x, y, z [rad], world
    table : rows (t, x, y, z) or (t, x, y, z, roll, pitch, yaw) [s, m, rad], times ascending
    point : (3,) [m] body coordinates: which follows the path, and about which the body turns;
            None: its centre of mass
    """

    surge: tuple[Oscillation, ...] = ()
    sway: tuple[Oscillation, ...] = ()
    heave: tuple[Oscillation, ...] = ()
    roll: tuple[Oscillation, ...] = ()
    pitch: tuple[Oscillation, ...] = ()
    yaw: tuple[Oscillation, ...] = ()
    table: tuple[tuple[float, ...], ...] = ()
    point: Vector | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, 'table', locked(self.table))


@dataclass(frozen=True)
class Frame:
    """
    Axes fixed to a body, where something acts on it: a thruster, a rotor.

    position    : (3,) [m]  its origin as seen from the centre of mass, body axes: where tf2 sees
                  it from the frame of the body; not shape coordinates
    orientation : (4,) [-]  unit quaternion xyzw, axes of the frame to body axes

    An orientation of another length is scaled to one.
    """

    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = IDENTITY

    def __post_init__(self) -> None:
        if self.orientation is not IDENTITY:
            with blaming('orientation'):
                object.__setattr__(self, 'orientation', unit_quaternion(self.orientation))


@dataclass(frozen=True, eq=False)
class Body(LockedArrays):
    """
    One body.

    mass           : [kg]       > 0 (0 for a fixed body without mass)
    center_of_mass : (3,) [m]   body coordinates
    inertia        : (3, 3) [kg m^2]  about the centre of mass, body axes; None for a point mass;
                     a copy that cannot be written to: all simulations of a scene share it
    fixed          : immovable: its inverse mass and inertia are zero
    mass_flow      : how the mass changes; then `mass` and `inertia` are those at the start
    inertia_over_time : how the inertia changes; then `inertia` is that at the start, and diagonal
    pivot          : the point about which it turns; then `initial` tells its orientation and
                     angular velocity, and its position and velocity follow from them
    shape_position, shape_orientation : where the shape lies: (3,) [m] its origin in body
        coordinates, (4,) [-] unit quaternion xyzw, shape axes to body axes
    frames         : axes fixed to the body, by name: commands may be given in them; a copy that
                     cannot be written to
    motion         : how the body is moved; then it is fixed for all that acts
    surface_velocity : (3,) [m/s] of the surface of a fixed body along its faces, body axes: a
        conveyor
    """

    name: str
    shape: Shape | None
    mass: float
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    inertia: NDArray[np.float64] | None = None
    fixed: bool = False
    initial: Motion = Motion()
    material: Material = USUAL
    mass_flow: MassFlow | None = None
    pivot: Pivot | None = None
    shape_position: Vector = (0.0, 0.0, 0.0)
    shape_orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    inertia_over_time: InertiaOverTime | None = None
    frames: Mapping[str, Frame] = field(default_factory=dict)
    motion: PrescribedMotion | None = None
    surface_velocity: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, 'inertia', locked(self.inertia))
        object.__setattr__(self, 'frames', locked_mapping(self.frames))

    @property
    def is_point(self) -> bool:
        """Whether the body is a point mass: no orientation, no torque."""
        return self.inertia is None and not self.fixed


@dataclass(frozen=True)
class Origin:
    """
    Where a scene comes from, for messages.

    name      : what they call its text
    has_lines : whether somebody wrote the text, and finds a line in it
    """

    name: str = 'scene'
    has_lines: bool = False


@dataclass(frozen=True, eq=False)
class Scene:
    """
    One experiment, read and checked.

    dt_ns      : int  tick length [ns]
    integrator : name in the registry
    integrator_options : what the scene sets of it, by name
    gravity    : (3,) [m/s^2] uniform, world
    forces     : force element records of `physics.forces`
    contact    : {'mode': 'none'} or the settings of a contact mode
    source     : the exact bytes the scene was read from
    origin     : what messages call them
    files      : further files the scene names (meshes): name -> bytes

    Mappings are copies that cannot be written to: all simulations of a scene share them.
    """

    name: str
    dt_ns: int
    bodies: tuple[Body, ...]
    integrator: str = 'dmv6'
    integrator_options: Mapping[str, Any] = field(default_factory=dict)
    gravity: Vector = (0.0, 0.0, 0.0)
    forces: tuple[Any, ...] = ()
    contact: Mapping[str, Any] = field(default_factory=lambda: {'mode': 'none'})
    source: bytes = b''
    origin: Origin = Origin()
    files: Mapping[str, bytes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ('integrator_options', 'contact', 'files'):
            object.__setattr__(self, name, locked_mapping(getattr(self, name)))

    def __repr__(self) -> str:
        return line_of(self)

    def _repr_html_(self) -> str:
        return html_of(self)
