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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.model.locked_arrays import LockedArrays
from rigid_body_sim.physics.model.numbers import is_list, is_number, numbers, shown
from rigid_body_sim.physics.model.rotation import unit_quaternion

MOST_TRIANGLES = 1 << 22  # [-] of a surface: their numbers are part of the keys of its contacts


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
        if not is_list(self.size) or len(self.size) != 3:
            raise InvalidModel(f'size: got {shown(self.size)}; three lengths [m] are needed')
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
class ConvexHull(LockedArrays):
    """The solid hull of points; vertices : (n, 3) [m], at least four, not all in one plane."""

    vertices: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, 'vertices', _points('vertices', self.vertices, at_least=4))


@dataclass(frozen=True, eq=False)
class Mesh(LockedArrays):
    """
    The solid inside a closed surface of triangles.

    vertices : (n, 3) [m]
    faces    : (m, 3) int  indices of the corners, counter-clockwise seen from outside
    name     : where the mesh came from
    parts    : what it collides as; none: its convex hull
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    name: str = 'mesh'
    parts: tuple[ConvexHull, ...] = ()

    def __post_init__(self) -> None:
        vertices = _points(f'mesh {self.name!r}: vertices', self.vertices, at_least=4)
        faces = _faces(self.faces, len(vertices), at_least=4, what=f'mesh {self.name!r}')
        object.__setattr__(self, 'vertices', vertices)
        object.__setattr__(self, 'faces', faces)


@dataclass(frozen=True, eq=False)
class Surface(LockedArrays):
    """
    Ground made of triangles as they are, open or closed, of a body that is fixed.

    Its outside is where its triangles are seen counter-clockwise; what comes from there meets it.
    `height_field.height_field` makes one of heights over a grid.

    vertices : (n, 3) [m]
    faces    : (m, 3) int  indices of the corners, counter-clockwise seen from outside
    name     : where it came from
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    name: str = 'surface'

    def __post_init__(self) -> None:
        vertices = _points(f'surface {self.name!r}: vertices', self.vertices, at_least=3)
        faces = _faces(self.faces, len(vertices), at_least=1, what=f'surface {self.name!r}')
        if len(faces) > MOST_TRIANGLES:
            raise InvalidModel(
                f'surface {self.name!r}: got {len(faces)} triangles; at most {MOST_TRIANGLES} '
                'collide; cut it into several bodies'
            )
        object.__setattr__(self, 'vertices', vertices)
        object.__setattr__(self, 'faces', faces)


@dataclass(frozen=True, eq=False)
class Particles(LockedArrays):
    """Point masses joined rigidly; positions : (n, 3) [m], masses : (n,) [kg], each positive."""

    positions: NDArray[np.float64]
    masses: NDArray[np.float64]

    def __post_init__(self) -> None:
        positions = _points('positions', self.positions, at_least=1)
        masses = _array('masses', self.masses)
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
        with blaming('normal'):
            x, y, z = numbers(self.normal, 3, unit='-')
        largest = max(abs(x), abs(y), abs(z))
        if not (largest > 0.0 and is_number(self.offset)):
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
        if isinstance(self.shape, Surface):
            raise InvalidModel(
                'triangles that are ground have no mass and are no part of a union; give them a '
                'body of their own with fixed: true'
            )
        if not isinstance(self.shape, Shape):
            raise InvalidModel(f'got {shown(self.shape)}; a shape is needed', at=('shape',))
        if self.mass is not None and self.density is not None:
            raise InvalidModel('give either mass [kg] or density [kg/m^3], and not both')
        for name, unit in (('mass', 'kg'), ('density', 'kg/m^3')):
            given = getattr(self, name)
            if given is not None:
                _need_positive(name, given, unit=unit)
        with blaming('position'):
            numbers(self.position, 3, unit='m')
        with blaming('orientation'):
            object.__setattr__(self, 'orientation', unit_quaternion(self.orientation))


@dataclass(frozen=True, eq=False)
class Union:
    """
    Shapes joined rigidly, each of its own density; overlaps count twice.

    Where bodies collide each solid part does; parts of one body do not meet each other.
    """

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.parts, list | tuple) or not self.parts:
            raise InvalidModel('parts is empty; a union needs at least one part')
        for i, part in enumerate(self.parts):
            if not isinstance(part, Part):
                raise InvalidModel(f'got {shown(part)}; a Part is needed', at=('parts', i))


Shape = (
    Particle
    | Sphere
    | Box
    | Cylinder
    | Capsule
    | ConvexHull
    | Mesh
    | Particles
    | Plane
    | Surface
    | Union
)


def _need_positive(what: str, value: float, *, unit: str = 'm') -> None:
    if not (is_number(value) and value > 0.0):
        got = value if isinstance(value, float) else shown(value)
        raise InvalidModel(f'{what} is {got} {unit}; it must be positive and finite')


def _array(what: str, values: Any) -> NDArray[np.float64]:
    try:
        if np.asarray(values).dtype.kind in 'iuf':
            return np.array(values, dtype=np.float64)
    except ValueError:  # rows of different lengths
        pass
    raise InvalidModel(f'{what}: got {shown(values)}; an array of numbers is needed')


def _faces(values: Any, n_vertices: int, *, at_least: int, what: str) -> NDArray[np.int64]:
    """Return triangles (m, 3) as indices of vertices."""
    found = _array(f'{what}: faces', values)
    with np.errstate(invalid='ignore'):
        faces = found.astype(np.int64)
    if not np.array_equal(faces, found):
        raise InvalidModel(
            f'{what}: faces hold {shown(values)}; whole numbers of vertices are needed'
        )
    if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) < at_least:
        needs = 'a solid needs at least four triangles' if at_least > 1 else 'need one or more'
        raise InvalidModel(f'{what}: faces have the shape {faces.shape}; {needs} (m, 3)')
    if faces.min() < 0 or faces.max() >= n_vertices:
        raise InvalidModel(
            f'{what}: faces name the vertices {faces.min()} to {faces.max()}; '
            f'there are 0 to {n_vertices - 1}'
        )
    faces.setflags(write=False)
    return faces


def _points(what: str, points: object, *, at_least: int) -> NDArray[np.float64]:
    array = _array(what, points)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) < at_least:
        raise InvalidModel(
            f'{what} have the shape {array.shape}; (n, 3) is needed: at least {at_least} '
            f'point{"s" if at_least > 1 else ""} of three coordinates [m]'
        )
    if not np.all(np.isfinite(array)):
        raise InvalidModel(f'{what} hold NaN or infinity; every coordinate must be finite [m]')
    array.setflags(write=False)
    return array
