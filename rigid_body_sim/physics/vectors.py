# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Vectors of three numbers in kernels: tuples (x, y, z), in and out; quaternions (x, y, z, w) and
symmetric matrices (xx, xy, xz, yy, yz, zz) likewise.

They cost nothing: once inlined, the compiler keeps their numbers in registers. Sums are taken from
left to right, so that a line with vectors has the bits of the same line written out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline

Array = NDArray[np.float64]

W = 3  # of a quaternion: its scalar
XX, XY, XZ, YY, YZ, ZZ = range(6)  # of a symmetric matrix


@inline
def load(array: Array, place: int) -> Any:
    """Read three numbers that follow each other."""
    return array[place], array[place + 1], array[place + 2]


@inline
def store(array: Array, place: int, v: Any) -> None:
    """Write three numbers that follow each other."""
    array[place], array[place + 1], array[place + 2] = v


@inline
def load_strided(array: Array, place: int, stride: int) -> Any:
    """Read three numbers a stride apart: one lane of three rows."""
    return array[place], array[place + stride], array[place + 2 * stride]


@inline
def load_symmetric(array: Array, place: int) -> Any:
    """Read a symmetric matrix: xx, xy, xz, yy, yz, zz."""
    return (
        array[place + XX],
        array[place + XY],
        array[place + XZ],
        array[place + YY],
        array[place + YZ],
        array[place + ZZ],
    )


@inline
def store_symmetric(array: Array, place: int, m: Any) -> None:
    """Write a symmetric matrix."""
    array[place + XX], array[place + XY], array[place + XZ] = m[XX], m[XY], m[XZ]
    array[place + YY], array[place + YZ], array[place + ZZ] = m[YY], m[YZ], m[ZZ]


@inline
def load_quaternion(array: Array, place: int) -> Any:
    """Read a quaternion: x, y, z, w."""
    return array[place], array[place + 1], array[place + 2], array[place + W]


@inline
def store_quaternion(array: Array, place: int, q: Any) -> None:
    """Write a quaternion."""
    array[place], array[place + 1], array[place + 2], array[place + W] = q


@inline
def store_strided(array: Array, place: int, stride: int, v: Any) -> None:
    """Write three numbers a stride apart."""
    array[place], array[place + stride], array[place + 2 * stride] = v


@inline
def dot(a: Any, b: Any) -> Any:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline
def cross(a: Any, b: Any) -> Any:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inline
def add(a: Any, b: Any) -> Any:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inline
def subtract(a: Any, b: Any) -> Any:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inline
def scale(factor: float, v: Any) -> Any:
    """Return factor v."""
    return factor * v[0], factor * v[1], factor * v[2]


@inline
def add_scaled(a: Any, factor: float, v: Any) -> Any:
    """Return a + factor v."""
    return a[0] + factor * v[0], a[1] + factor * v[1], a[2] + factor * v[2]


@inline
def negate(v: Any) -> Any:
    """Return -v."""
    return -v[0], -v[1], -v[2]


@inline
def apply_symmetric(m: Any, v: Any) -> Any:
    """Return M v of a symmetric matrix (xx, xy, xz, yy, yz, zz)."""
    return (
        m[XX] * v[0] + m[XY] * v[1] + m[XZ] * v[2],
        m[XY] * v[0] + m[YY] * v[1] + m[YZ] * v[2],
        m[XZ] * v[0] + m[YZ] * v[1] + m[ZZ] * v[2],
    )


@inline
def add_symmetric(a: Any, b: Any) -> Any:
    """Return A + B of two symmetric matrices."""
    return (
        a[XX] + b[XX], a[XY] + b[XY], a[XZ] + b[XZ],
        a[YY] + b[YY], a[YZ] + b[YZ], a[ZZ] + b[ZZ],
    )  # fmt: skip


@inline
def trace(m: Any) -> Any:
    """Return the sum of the diagonal of a symmetric matrix."""
    return m[XX] + m[YY] + m[ZZ]


@inline
def invert_symmetric(m: Any) -> Any:
    """Return M^-1 of a regular symmetric matrix (xx, xy, xz, yy, yz, zz), by its adjugate."""
    xx, xy, xz, yy, yz, zz = m
    cofactors = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    determinant = dot((xx, xy, xz), cofactors)
    return (
        cofactors[0] / determinant, cofactors[1] / determinant, cofactors[2] / determinant,
        (xx * zz - xz * xz) / determinant, (xy * xz - xx * yz) / determinant,
        (xx * yy - xy * xy) / determinant,
    )  # fmt: skip


@inline
def add_strided(array: Array, place: int, stride: int, v: Any) -> None:
    """Add a vector to three numbers a stride apart."""
    array[place] += v[0]
    array[place + stride] += v[1]
    array[place + 2 * stride] += v[2]


@inline
def divide(v: Any, divisor: float) -> Any:
    """Return v / divisor, component by component."""
    return v[0] / divisor, v[1] / divisor, v[2] / divisor
