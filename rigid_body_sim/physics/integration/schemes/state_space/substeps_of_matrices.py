# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The error of a substep of rotations kept as matrices, and what is kept for the case that it is
refused: as `substeps`, for the state (R, L) of `stages_of_matrices`.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.integration.schemes.state_space.matrices import (
    TURN,
    TURN_START,
    write_quaternion,
)
from rigid_body_sim.physics.state.blocks import LX, LY, LZ

LENGTH = 1.7320508075688772  # [-] of a rotation matrix: the root of the sum of its squares

# bound for each pair by `specialise`
STAGES = 1
ERROR: tuple[float, ...] = (1.0, -1.0)


def error_of_turns(lanes, h, y, rtol, atol, first, worst, culprit):
    """
    Largest relative error of R and of L of the bodies of a block and whose it is, or what was
    before where that is larger; y holds the new state.
    """
    for k in range(lanes):
        e = f = size = 0.0
        for row in range(12):
            total = 0.0
            for j in range(STAGES + 1):
                total += ERROR[j] * y[TURN_START + TURN * j + k + 64 * row]
            if row < 9:
                e += total * total
            else:
                f += total * total
                size += y[k + 64 * row] * y[k + 64 * row]
        e = h * math.sqrt(e) / (atol + rtol * LENGTH)
        f = h * math.sqrt(f) / (atol + rtol * math.sqrt(size))
        if f > e or f != f:
            e = f
        if e > worst or e != e:
            worst, culprit = e, first + k
    return worst, culprit


@inline
def set_rate(lanes, s, y):
    """Make the new matrix that of the next stage."""
    for k in range(lanes):
        for row in range(9):
            y[k + 64 * row + TURN] = y[k + 64 * row]


@inline
def save_turns(lanes, s, memory, saved):
    """Keep R and L."""
    for k in range(lanes):
        for row in range(9):
            saved[k + 64 * row] = memory[k + 64 * row]
        saved[k + 576], saved[k + 640], saved[k + 704] = s[k + LX], s[k + LY], s[k + LZ]


@inline
def restore_turns(lanes, saved, y, s):
    """Return to the start of the substep."""
    for k in range(lanes):
        for row in range(12):
            y[k + 64 * row] = saved[k + 64 * row]
        s[k + LX], s[k + LY], s[k + LZ] = saved[k + 576], saved[k + 640], saved[k + 704]
        write_quaternion(k, s, y, 0)
