# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Vectors and quaternions of one body in a block: tuples (x, y, z) and (x, y, z, w), one lane of
successive rows.

`place` is the lane plus the offset of the first row: `read_vector(state, lane + MOMENTUM)`. Sums
and products are taken from left to right, as in `vectors`.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.state.blocks import LANES, add_compensated

VECTOR = 3 * LANES  # numbers of a vector in a block


@inline
def read_vector(block, place):
    """Read x, y, z."""
    return block[place], block[place + LANES], block[place + 2 * LANES]


@inline
def write_vector(block, place, v):
    """Write x, y, z."""
    block[place], block[place + LANES], block[place + 2 * LANES] = v


@inline
def read_quaternion(block, place):
    """Read x, y, z, w."""
    return block[place], block[place + LANES], block[place + 2 * LANES], block[place + VECTOR]


@inline
def write_quaternion(block, place, q):
    """Write x, y, z, w."""
    block[place], block[place + LANES], block[place + 2 * LANES], block[place + VECTOR] = q


@inline
def multiply(a, b):
    """Multiply component by component: a diagonal matrix times a vector."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


@inline
def normalised(q):
    """Scale a quaternion to unit length."""
    x, y, z, w = q
    over = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return x * over, y * over, z * over, w * over


@inline
def nearly_normalised(q):
    """
    Scale a quaternion q of about unit length by 1.5 - |q|^2 / 2: a smooth map that is one on the
    unit sphere.
    """
    x, y, z, w = q
    factor = 1.5 - 0.5 * (x * x + y * y + z * z + w * w)
    return x * factor, y * factor, z * factor, w * factor


@inline
def add_to_vector(block, place, lost, start, increment):
    """
    Write start + increment at `place`, and what rounding lost at `lost`: see
    `blocks.add_compensated`.
    """
    block[place], block[lost] = add_compensated(start[0], block[lost], increment[0])
    block[place + LANES], block[lost + LANES] = add_compensated(
        start[1], block[lost + LANES], increment[1]
    )
    block[place + 2 * LANES], block[lost + 2 * LANES] = add_compensated(
        start[2], block[lost + 2 * LANES], increment[2]
    )


@inline
def copy_rows(lanes, first, end, source, target):
    """Copy the rows from `first` up to `end`."""
    for row in range(first, end, LANES):
        for place in range(row, row + lanes):
            target[place] = source[place]


@kernel
def scale_rows(lanes, first, end, factor, slope, target):
    """Write factor K into the rows from `first` up to `end`."""
    for row in range(first, end, LANES):
        for place in range(row, row + lanes):
            target[place] = factor * slope[place]


@kernel
def add_rows(lanes, first, end, base, factor, slope, target):
    """Write base + factor K into the rows from `first` up to `end`."""
    for row in range(first, end, LANES):
        for place in range(row, row + lanes):
            target[place] = base[place] + factor * slope[place]
