# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The shapes a body can have.

Lengths are in metres, in shape coordinates: the axes in which the shape is given. Sphere, box,
cylinder and capsule have their centre at the origin; the other shapes lie where their points say.
A union joins others, each where its part says. A shape is geometry only: its mass properties come
from `mass_properties`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel


@dataclass(frozen=True)
class Particle:
    """A point mass at the origin: no orientation, no rotation."""


@dataclass(frozen=True)
class Sphere:
    """A solid ball; radius [m]."""

    radius: float

    def __post_init__(self) -> None:
        _need_positive('radius', self.radius)


@dataclass(frozen=True)
class Box:
    """A solid cuboid; size : (3,) [m], whole edge lengths along x, y, z."""

    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        for axis, edge in zip('xyz', self.size, strict=True):
            _need_positive(f'size along {axis}', edge)


@dataclass(frozen=True)
class Cylinder:
    """A solid cylinder about the z axis; radius [m], length [m] along z."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        _need_positive('radius', self.radius)
        _need_positive('length', self.length)


@dataclass(frozen=True)
class Capsule:
    """A solid cylinder about the z axis with a half ball on each end; length [m] without them."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        _need_positive('radius', self.radius)
        _need_positive('length', self.length)


@dataclass(frozen=True, eq=False)
class ConvexHull:
    """The solid hull of points; vertices : (n, 3) [m], at least four, not all in one plane."""

    vertices: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, 'vertices', _points('vertices', self.vertices, at_least=4))


@dataclass(frozen=True, eq=False)
class Mesh:
    """
    The solid inside a closed surface of triangles.

    vertices : (n, 3) [m]
    faces    : (m, 3) int  indices of the corners, counter-clockwise seen from outside
    name     : where the mesh came from
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    name: str = 'mesh'

    def __post_init__(self) -> None:
        vertices = _points(f'mesh {self.name!r}: vertices', self.vertices, at_least=4)
        faces = np.array(self.faces, dtype=np.int64)
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) < 4:
            raise InvalidModel(
                f'mesh {self.name!r}: faces have the shape {faces.shape}; '
                'a solid needs at least four triangles (m, 3)'
            )
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise InvalidModel(
                f'mesh {self.name!r}: faces name the vertices {faces.min()} to {faces.max()}; '
                f'there are 0 to {len(vertices) - 1}'
            )
        faces.setflags(write=False)
        object.__setattr__(self, 'vertices', vertices)
        object.__setattr__(self, 'faces', faces)


@dataclass(frozen=True, eq=False)
class Particles:
    """Point masses joined rigidly; positions : (n, 3) [m], masses : (n,) [kg], each positive."""

    positions: NDArray[np.float64]
    masses: NDArray[np.float64]

    def __post_init__(self) -> None:
        positions = _points('positions', self.positions, at_least=1)
        masses = np.array(self.masses, dtype=np.float64)
        if masses.shape != (len(positions),):
            raise InvalidModel(
                f'{len(positions)} positions need as many masses, got the shape {masses.shape}'
            )
        for number, mass in enumerate(masses):
            _need_positive(f'mass of particle {number}', mass, unit='kg')
        masses.setflags(write=False)
        object.__setattr__(self, 'positions', positions)
        object.__setattr__(self, 'masses', masses)


@dataclass(frozen=True)
class Plane:
    """
    The half space n . x <= offset, static.

    normal : (3,) [-]  unit vector n out of the solid (normalised here)
    offset : [m]       distance of the surface from the origin along n
    """

    normal: tuple[float, float, float]
    offset: float = 0.0

    def __post_init__(self) -> None:
        x, y, z = self.normal
        largest = max(abs(x), abs(y), abs(z))
        if not (math.isfinite(largest) and largest > 0.0 and math.isfinite(self.offset)):
            raise InvalidModel(
                f'normal {self.normal}, offset {self.offset} m: a plane needs a finite normal '
                'of non-zero length and a finite offset'
            )
        x, y, z = x / largest, y / largest, z / largest
        length = math.sqrt(x * x + y * y + z * z)
        normal = (x / length, y / length, z / length)
        object.__setattr__(self, 'normal', normal)


@dataclass(frozen=True, eq=False)
class Part:
    """
    One shape of a union, and where it is.

    mass, density : [kg], [kg/m^3]  of this part, one of them at most; with neither it has the
                    density of the whole
    position      : (3,) [m]  origin of the shape, in the axes of the union
    orientation   : (4,) [-]  unit quaternion xyzw, axes of the shape to those of the union
    """

    shape: Shape
    mass: float | None = None
    density: float | None = None
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        if isinstance(self.shape, Plane):
            raise InvalidModel('a plane has no mass and is no part of a union; remove it')
        if self.mass is not None and self.density is not None:
            raise InvalidModel('give either mass [kg] or density [kg/m^3], and not both')


@dataclass(frozen=True, eq=False)
class Union:
    """
    Shapes joined rigidly, each of its own density; overlaps count twice.

    Where bodies collide each solid part does; parts of one body do not meet each other.
    """

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        if not self.parts:
            raise InvalidModel('parts is empty; a union needs at least one part')


Shape = (
    Particle | Sphere | Box | Cylinder | Capsule | ConvexHull | Mesh | Particles | Plane | Union
)


def _need_positive(what: str, value: float, *, unit: str = 'm') -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidModel(f'{what} is {value} {unit}; it must be positive and finite')


def _points(what: str, points: object, *, at_least: int) -> NDArray[np.float64]:
    array = np.array(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) < at_least:
        raise InvalidModel(
            f'{what} have the shape {array.shape}; (n, 3) is needed: at least {at_least} '
            f'point{"s" if at_least > 1 else ""} of three coordinates [m]'
        )
    if not np.all(np.isfinite(array)):
        raise InvalidModel(f'{what} hold NaN or infinity; every coordinate must be finite [m]')
    array.setflags(write=False)
    return array
