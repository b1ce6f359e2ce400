# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Forces that depend on the state, in a substep with contacts: those of before the motion act for
half of it, those of after it for the other half (velocity Verlet).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.state.blocks import (
    FX,
    FY,
    FZ,
    LX,
    LY,
    LZ,
    PX,
    PY,
    PZ,
    ROTATION,
    TRANSLATION,
    TX,
    TY,
    TZ,
    at,
)

Array = NDArray[np.float64]


@kernel
def save_wrenches(n_bodies, n_rigid, translation, rotation, workspace):
    """Keep the forces of the instant."""
    for block in range((n_bodies + 63) // 64):
        s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
        saved = workspace[block * 384 : block * 384 + 192]
        for k in range(min(64, n_bodies - 64 * block)):
            saved[k], saved[k + 64], saved[k + 128] = s[k + FX], s[k + FY], s[k + FZ]
    for block in range((n_rigid + 63) // 64):
        s = rotation[block * ROTATION : block * ROTATION + ROTATION]
        saved = workspace[block * 384 + 192 : block * 384 + 384]
        for k in range(min(64, n_rigid - 64 * block)):
            saved[k], saved[k + 64], saved[k + 128] = s[k + TX], s[k + TY], s[k + TZ]


@kernel
def correct_momenta(n_bodies, n_rigid, half, translation, rotation, workspace):
    """Let the change of the forces act: p += h/2 (F - F_saved)."""
    for block in range((n_bodies + 63) // 64):
        s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
        saved = workspace[block * 384 : block * 384 + 192]
        for k in range(min(64, n_bodies - 64 * block)):
            s[k + PX] += half * (s[k + FX] - saved[k])
            s[k + PY] += half * (s[k + FY] - saved[k + 64])
            s[k + PZ] += half * (s[k + FZ] - saved[k + 128])
    for block in range((n_rigid + 63) // 64):
        s = rotation[block * ROTATION : block * ROTATION + ROTATION]
        saved = workspace[block * 384 + 192 : block * 384 + 384]
        for k in range(min(64, n_rigid - 64 * block)):
            s[k + LX] += half * (s[k + TX] - saved[k])
            s[k + LY] += half * (s[k + TY] - saved[k + 64])
            s[k + LZ] += half * (s[k + TZ] - saved[k + 128])


@kernel
def add_warm_start(
    i: int, n_rigid: int, sign: float, translation: Array, rotation: Array, bodies: Array
) -> None:
    """
    Let forces that depend on velocity see a carried body with the second half of its loads, which
    it gets later (sign 1), and take that back (sign -1).
    """
    o = i * solver_bodies.SIZE
    if not bodies[o + solver_bodies.CARRIED] > 0.0:
        return
    k = at(i, TRANSLATION)
    for axis in range(3):
        translation[k + PX + 64 * axis] += sign * bodies[o + solver_bodies.WARM_IMPULSE + axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            rotation[k + LX + 64 * axis] += (
                sign * bodies[o + solver_bodies.WARM_ANGULAR_IMPULSE + axis]
            )
