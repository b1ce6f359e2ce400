# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Vectors of three numbers in kernels: tuples (x, y, z), in and out.

They cost nothing: once inlined, the compiler keeps their numbers in registers. Sums are taken from
left to right, so that a line with vectors has the bits of the same line written out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline

Array = NDArray[np.float64]


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
        array[place],
        array[place + 1],
        array[place + 2],
        array[place + 3],
        array[place + 4],
        array[place + 5],
    )


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
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[2] * v[0] + m[4] * v[1] + m[5] * v[2],
    )


@inline
def invert_symmetric(m: Any) -> Any:
    """Return M^-1 of a regular symmetric matrix (xx, xy, xz, yy, yz, zz), by its adjugate."""
    xx, xy, xz = m[3] * m[5] - m[4] * m[4], m[2] * m[4] - m[1] * m[5], m[1] * m[4] - m[2] * m[3]
    determinant = m[0] * xx + m[1] * xy + m[2] * xz
    return (
        xx / determinant, xy / determinant, xz / determinant,
        (m[0] * m[5] - m[2] * m[2]) / determinant, (m[1] * m[2] - m[0] * m[4]) / determinant,
        (m[0] * m[3] - m[1] * m[1]) / determinant,
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
