# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Mass, centre of mass and inertia tensor of a shape of uniform or varying density.

    m = integral dm,   r_c = (1/m) integral x dm,   I = integral (|d|^2 1 - d d^T) dm,   d = x -
    r_c

The products of inertia are the elements of this tensor: Ixy = -integral d_x d_y dm.
Point masses are summed, simple solids have closed forms, and solids bounded by triangles are
integrated exactly over tetrahedra (`volume_integrals`). A density that varies with position is
integrated by quadrature (`quadrature`) with more and more points until nothing changes. Closed
forms: Goldstein, Classical Mechanics, chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.model import quadrature, rotation
from rigid_body_sim.physics.model.inertia_tensor import check_inertia
from rigid_body_sim.physics.model.numbers import number, shown
from rigid_body_sim.physics.model.plain_products import dot, length, times, turned_tensor
from rigid_body_sim.physics.model.principal_axes import principal_axes
from rigid_body_sim.physics.model.self_overlap import need_single
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Particle,
    Particles,
    Plane,
    Shape,
    Sphere,
    Surface,
    Union,
)
from rigid_body_sim.physics.model.volume_integrals import (
    ROUND_OFF,
    hull_faces,
    need_closed,
    second_moments,
    volume_integrals,
)

Array = NDArray[np.float64]

__all__ = [
    'MassProperties',
    'check_inertia',
    'moment_about',
    'moved',
    'of_density',
    'of_linear_density',
    'of_shape',
    'parallel_axes',
    'principal_axes',
    'states_its_mass',
    'union',
]

POINTS = (3, 6, 12, 24, 48)  # [-] of the quadrature along each direction, until two agree
MOST_POINTS = 20_000_000  # [-] evaluations of a density: some seconds
MASS_AGREEMENT = 1e-9  # [-] how near a stated mass of a particle union must be to the sum


@dataclass(frozen=True, eq=False)
class MassProperties:
    """
    What Newton and Euler need to know of a body.

    mass           : [kg]
    center_of_mass : (3,) [m]          shape coordinates
    inertia        : (3, 3) [kg m^2]   about the centre of mass, axes of the shape
    """

    mass: float
    center_of_mass: Array
    inertia: Array


def of_shape(
    shape: Shape, *, mass: float | None = None, density: float | None = None
) -> MassProperties:
    """
    Return the mass properties of a shape, from its mass [kg] or its density [kg/m^3].

    The inertia of a particle is zero; that of particles is whatever their sum gives
    (`check_inertia`). The density is that of those parts of a union that have none of their own.
    """
    if not isinstance(shape, Shape):
        raise InvalidModel(
            f'got {shown(shape)}; a shape is needed, such as Box((0.4, 0.2, 0.1))', at=('shape',)
        )
    if mass is not None:
        with blaming('mass'):
            mass = number(mass, unit='kg')
    if density is not None:
        with blaming('density'):
            density = number(density, unit='kg/m^3')
    if isinstance(shape, Plane):
        raise InvalidModel('a plane has no mass: it is static; remove mass and density')
    if isinstance(shape, Surface):
        raise InvalidModel(
            'ground of triangles has no mass: it is static; remove mass and density'
        )
    with np.errstate(
        all='ignore'
    ):  # absurd sizes overflow to infinity and are refused by name below
        if isinstance(shape, Particle | Particles):
            return _of_points(shape, mass=mass, density=density)
        if isinstance(shape, Union):
            return _of_parts(shape, mass=mass, density=density)
        volume, center, per_mass = _solid(shape)
        mass = _mass(volume, mass=mass, density=density)
        return MassProperties(mass, center, mass * per_mass)


def of_density(
    shape: Shape, density: Callable[[Array], Array], *, tolerance: float = 1e-10
) -> MassProperties:
    """
    Return the mass properties of a shape whose density varies with position.

    density   : points (k, 3) [m], shape coordinates -> (k,) [kg/m^3], smooth
    tolerance : [-] change of mass, centre (in radii of gyration) and inertia between the last two
                quadratures; InvalidModel if it is not met: layers belong into a `union`
    """
    if isinstance(shape, Mesh):
        need_single(shape.vertices, shape.faces, name=shape.name)
    before = None
    change = math.inf
    for n in POINTS:
        if quadrature.count(shape, n) > MOST_POINTS:
            break
        now = _by_quadrature(shape, density, n)
        if before is not None:
            change = _change(before, now)
            if change <= tolerance:
                return now
        before = now
    raise InvalidModel(
        f'the density is too rough for quadrature: refining still changes the result by '
        f'{change:.1e}, more than {tolerance:.1e}; join parts of smooth density by a union, '
        'or allow a larger tolerance'
    )


def of_linear_density(shape: Shape, *, at_origin: float, gradient: ArrayLike) -> MassProperties:
    """
    Return the mass properties of a shape of density at_origin + gradient . x.

        at_origin : [kg/m^3]         at the origin of the shape
        gradient  : (3,) [kg/m^4]    shape axes
    """
    slope = np.asarray(gradient, dtype=np.float64)
    least = at_origin + _least(shape, slope)
    if not least >= 0.0:
        raise InvalidModel(
            f'the density falls to {least:.6g} kg/m^3 within the shape; '
            'it must stay zero or positive'
        )
    return of_density(shape, lambda x: at_origin + dot(x, slope))


def parallel_axes(inertia: ArrayLike, *, mass: float, offset: ArrayLike) -> Array:
    """
    Move the reference point of an inertia tensor away from the centre of mass (Steiner).

    I_O = I_C + m (|d|^2 1 - d d^T)
        inertia : (3, 3) [kg m^2]  I_C, about the centre of mass
        offset  : (3,) [m]         d, from the centre of mass to the new point or back
    """
    return np.asarray(inertia, dtype=np.float64) + mass * _turned_out(_outer(offset))


def moment_about(properties: MassProperties, *, point: ArrayLike, direction: ArrayLike) -> float:
    """
    Return the moment of inertia [kg m^2] about an axis.

    I_n = n . I_C n + m |n x (r_c - point)|^2
        point     : (3,) [m]  any point of the axis, shape coordinates
        direction : (3,)      along the axis, of any length but zero
    """
    n = np.asarray(direction, dtype=np.float64)
    size = float(np.max(np.abs(n)))
    if n.shape != (3,) or not (0.0 < size < math.inf):
        raise InvalidModel(
            f'an axis needs a finite direction of non-zero length, got {np.asarray(direction)}'
        )
    n = n / size
    n = n / length(n)
    with np.errstate(over='ignore', invalid='ignore'):
        lever = np.cross(n, properties.center_of_mass - np.asarray(point, dtype=np.float64))
        moment = dot(n, times(properties.inertia, n)) + properties.mass * dot(lever, lever)
    if not math.isfinite(moment):
        raise InvalidModel(
            f'the moment about an axis through {np.asarray(point)} is beyond all numbers'
        )
    return float(moment)


def moved(
    properties: MassProperties, *, position: ArrayLike, orientation: ArrayLike
) -> MassProperties:
    """
    See the same body from other axes: x' = position + R x, I' = R I R^T.

        position    : (3,) [m]  origin of the shape in the new axes
        orientation : (4,) [-]  unit quaternion xyzw, shape axes to new axes
    """
    r = rotation.matrix_from_quaternion(orientation)
    center = np.asarray(position, dtype=np.float64) + times(r, properties.center_of_mass)
    return MassProperties(properties.mass, center, turned_tensor(r, properties.inertia))


def union(parts: Sequence[MassProperties]) -> MassProperties:
    """Join bodies rigidly; all parts are in the same coordinates, and overlaps count twice."""
    if not parts:
        raise InvalidModel('a union needs at least one part')
    masses = np.array([part.mass for part in parts])
    centers = np.array([part.center_of_mass for part in parts])
    mass, center, inertia = _sums(masses, centers)
    return MassProperties(mass, center, inertia + np.sum([part.inertia for part in parts], axis=0))


def _of_points(
    shape: Particle | Particles, *, mass: float | None, density: float | None
) -> MassProperties:
    if density is not None:
        raise InvalidModel('particles have no volume, so a density says nothing; give their mass')
    if isinstance(shape, Particle):
        if mass is None:
            raise InvalidModel('a particle needs a mass [kg]')
        with blaming('mass'):
            mass = _positive_mass(mass)
        return MassProperties(mass, np.zeros(3), np.zeros((3, 3)))
    total, center, inertia = _sums(shape.masses, shape.positions)
    _need_agreement(mass, total, 'particles')
    return MassProperties(_positive_mass(total), center, inertia)


def _of_parts(shape: Union, *, mass: float | None, density: float | None) -> MassProperties:
    parts = []
    for place, part in enumerate(shape.parts):
        own = part.density
        if part.mass is None and own is None and not isinstance(part.shape, Particle | Particles):
            own = density
            if own is None and not isinstance(
                part.shape, Union
            ):  # whose parts speak for themselves
                raise InvalidModel(
                    f'parts[{place}]: neither mass nor density is given, and a mass of the whole '
                    'is not shared out; give the part a mass [kg], or the whole a density '
                    '[kg/m^3]',
                    at=('shape',),
                )
        try:
            of = of_shape(part.shape, mass=part.mass, density=own)
        except InvalidModel as error:
            raise InvalidModel(f'parts[{place}]: {error}', at=('shape',)) from error
        parts.append(moved(of, position=part.position, orientation=part.orientation))
    whole = union(parts)
    _need_agreement(mass, whole.mass, 'parts')
    return MassProperties(_positive_mass(whole.mass), whole.center_of_mass, whole.inertia)


def states_its_mass(shape: Shape) -> bool:
    """Tell whether particles, or all parts of a union, say what they weigh."""
    if isinstance(shape, Union):
        return all(
            part.mass is not None or part.density is not None or states_its_mass(part.shape)
            for part in shape.parts
        )
    return isinstance(shape, Particles)


def _need_agreement(mass: float | None, total: float, of: str) -> None:
    if mass is not None and not abs(mass - total) <= MASS_AGREEMENT * total:
        raise InvalidModel(
            f'mass {mass} kg is not the sum of the {of}, {total} kg; remove mass', at=('mass',)
        )


def _sums(masses: Array, positions: Array) -> tuple[float, Array, Array]:
    """Sum point masses, from coordinates shifted to their mean: a far origin costs no digits."""
    mass = float(np.sum(masses))
    origin = np.mean(positions, axis=0)
    center = np.sum(masses[:, None] * (positions - origin), axis=0) / mass
    d = positions - origin - center
    return mass, origin + center, _turned_out(second_moments(masses, d))


def _solid(
    shape: Sphere | Box | Cylinder | Capsule | ConvexHull | Mesh,
) -> tuple[float, Array, Array]:
    """Return volume [m^3], centre [m] and inertia per mass [m^2] about the centre."""
    match shape:
        case Sphere(radius=r):
            return 4.0 / 3.0 * math.pi * r * r * r, np.zeros(3), 0.4 * r * r * np.eye(3)
        case Box(size=(a, b, c)):
            return (
                a * b * c,
                np.zeros(3),
                np.diag((b * b + c * c, a * a + c * c, a * a + b * b)) / 12.0,
            )
        case Cylinder(radius=r, length=h):
            across = r * r / 4.0 + h * h / 12.0
            return math.pi * r * r * h, np.zeros(3), np.diag((across, across, r * r / 2.0))
        case Capsule(radius=r, length=h):
            return _capsule(r, h)
        case ConvexHull(vertices=vertices):
            return volume_integrals(vertices, hull_faces(vertices))
        case Mesh(vertices=vertices, faces=faces, name=name):
            need_closed(faces, name=name)
            need_single(vertices, faces, name=name)
            return volume_integrals(vertices, faces, name=f'mesh {name!r}')


def _by_quadrature(shape: Shape, density: Callable[[Array], Array], n: int) -> MassProperties:
    """Sum over the nodes, about a point inside the shape: a far origin costs no digits."""
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    origin = None
    for points, weights in quadrature.nodes(shape, n):
        values = np.asarray(density(points), dtype=np.float64)
        if values.shape != weights.shape or not np.all(np.isfinite(values)):
            raise InvalidModel(
                f'the density gave {values.shape} values for {weights.shape} points, '
                'or some that are '
                'not finite; one finite number [kg/m^3] for each point is needed'
            )
        origin = np.mean(points, axis=0) if origin is None else origin
        d, dm = points - origin, weights * values
        mass += float(np.sum(dm))
        first += np.sum(dm[:, None] * d, axis=0)
        second += second_moments(dm, d)
    assert origin is not None
    mass = _positive_mass(mass)
    center = first / mass
    inertia = _turned_out(second - mass * _outer(center))
    inertia[np.abs(inertia) <= ROUND_OFF * np.trace(inertia)] = 0.0
    return MassProperties(mass, origin + center, _symmetric(inertia))


def _change(a: MassProperties, b: MassProperties) -> float:
    """Largest relative change of mass, centre and inertia."""
    size = float(np.trace(b.inertia))
    apart = float(length(a.center_of_mass - b.center_of_mass)) / math.sqrt(abs(size) / b.mass)
    tensor = float(np.max(np.abs(a.inertia - b.inertia))) / abs(size)
    return max(abs(a.mass - b.mass) / b.mass, apart, tensor)


def _least(shape: Shape, slope: Array) -> float:
    """Least value of slope . x within a shape."""
    across, along = math.hypot(slope[0], slope[1]), abs(float(slope[2]))
    match shape:
        case Sphere(radius=r):
            return -r * math.hypot(across, along)
        case Box(size=size):
            return -0.5 * float(dot(np.abs(slope), size))
        case Cylinder(radius=r, length=h):
            return -r * across - 0.5 * h * along
        case Capsule(radius=r, length=h):
            return -r * math.hypot(across, along) - 0.5 * h * along
        case ConvexHull(vertices=vertices) | Mesh(vertices=vertices):
            return float(np.min(dot(vertices, slope)))
        case _:
            return 0.0  # has no volume, and is refused for that


def _capsule(r: float, h: float) -> tuple[float, Array, Array]:
    """
    Join a cylinder and two half balls, whose centres lie 3r/8 beyond the ends.

    I_x = m_c (h^2/12 + r^2/4) + m_s (2 r^2/5 + h^2/4 + 3 h r/8),  I_z = m_c r^2/2 + m_s 2 r^2/5
    """
    tube = h / (h + 4.0 / 3.0 * r)  # share of the cylinder in the mass
    balls = 1.0 - tube
    across = tube * (h * h / 12.0 + r * r / 4.0) + balls * (
        0.4 * r * r + h * h / 4.0 + 0.375 * h * r
    )
    along = tube * r * r / 2.0 + balls * 0.4 * r * r
    volume = math.pi * r * r * (h + 4.0 / 3.0 * r)
    return volume, np.zeros(3), np.diag((across, across, along))


def _mass(volume: float, *, mass: float | None, density: float | None) -> float:
    if mass is None and density is None:
        raise InvalidModel('neither mass nor density is given; give mass [kg] or density [kg/m^3]')
    if mass is not None and density is not None:
        raise InvalidModel('give either mass [kg] or density [kg/m^3], and not both')
    if mass is not None:
        with blaming('mass'):
            return _positive_mass(mass)
    assert density is not None
    with blaming('density'):
        if not (math.isfinite(density) and density > 0.0):
            raise InvalidModel(f'density is {density} kg/m^3; it must be positive and finite')
        return _positive_mass(density * volume)


def _positive_mass(mass: float) -> float:
    if not (mass > 0.0 and math.isfinite(mass) and math.isfinite(1.0 / mass)):
        raise InvalidModel(
            f'mass is {mass} kg; it must be positive and finite, and so must be its inverse'
        )
    return float(mass)


def _outer(d: ArrayLike) -> Array:
    d = np.asarray(d, dtype=np.float64)
    return np.outer(d, d)


def _turned_out(second_moments: Array) -> Array:
    """Return tr(C) 1 - C: the inertia tensor of the second moments C = integral d d^T dm."""
    xx, yy, zz = np.diag(second_moments)
    inertia = -second_moments
    inertia[0, 0], inertia[1, 1], inertia[2, 2] = yy + zz, xx + zz, xx + yy
    return inertia


def _symmetric(matrix: Array) -> Array:
    return 0.5 * (matrix + matrix.T)
