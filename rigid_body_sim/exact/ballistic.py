# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ballistic flight: a point in a uniform field.

r = r0 + v0 t + a t^2/2,  v = v0 + a t
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.motion import Translation, column


def flight(
    t: ArrayLike, *, position: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike
) -> Translation:
    """
    Position and velocity under a constant acceleration.

    t            : (*T) [s]
    position     : (d,) [m]      at t = 0, world
    velocity     : (d,) [m/s]    at t = 0, world
    acceleration : (d,) [m/s^2]  world; gravity, say
    """
    s = column(t)
    r0, v0, a = (np.asarray(x, dtype=float) for x in (position, velocity, acceleration))
    return Translation(r0 + s * (v0 + 0.5 * a * s), v0 + a * s)
