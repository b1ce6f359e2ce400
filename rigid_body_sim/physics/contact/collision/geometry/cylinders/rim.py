# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which point of a cylinder's round end is the lowest above a plane, and the points around it.

    m normal out of the plane, a axis, tau = m - (m . a) a, |tau| sine of the tilt, u = tau / |tau|

The lowest point of either end is at its middle - r u. Where the end is parallel to the plane u has
no meaning: for |tau| < FLAT it is blended with the nearest of the four axes d fixed in the end,
u ~ tau + (FLAT - |tau|) d. So a standing cylinder keeps its points, and above FLAT the lowest
point is exact.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline

FLAT = 1e-4  # [-] sine of the tilt below which an end keeps points fixed in it
UPPER = 5.0  # features of the end at +z are larger by this, but for those of the lowest points
FIXED = 10.0  # features of points fixed in an end begin here
EXACT = -1  # in place of an axis: none, the lowest point is where it is exactly


@inline
def lowest_direction(tilt_x: float, tilt_y: float) -> Any:
    """
    Return u (2) in the axes of the end, and the axis d: 0 to 3 for +x, +y, -x, -y, or EXACT.

    tilt_x, tilt_y : tau in the axes of the end
    """
    sine = math.sqrt(tilt_x * tilt_x + tilt_y * tilt_y)
    axis = EXACT
    if sine < FLAT:
        blend = FLAT - sine
        if abs(tilt_y) > abs(tilt_x):
            axis = 3 if tilt_y < 0.0 else 1
            tilt_y += -blend if tilt_y < 0.0 else blend
        else:
            axis = 2 if tilt_x < 0.0 else 0
            tilt_x += -blend if tilt_x < 0.0 else blend
        sine = math.sqrt(tilt_x * tilt_x + tilt_y * tilt_y)
    return tilt_x / sine, tilt_y / sine, axis


@inline
def lies(rise: float, sine: float, half: float, fall: float, lower: float, margin: float) -> bool:
    """
    Tell whether a cylinder lies rather than stands: whether the lowest point of its other end is
    nearer than the point opposite of its lower one.

    By height; but where both may touch within the tick, by the angle that it has to turn by: the
    other end of a slender rod comes down by many diameters in a tick, and a disc falls flat.

        rise, sine : cosine and sine of the angle between axis and normal
        fall       : [m] of the lowest point below the middle of its end;  lower : height of that
    """
    if max(lower + fall, lower - fall + 2.0 * half * abs(rise)) <= margin:
        return abs(rise) < sine
    return half * abs(rise) < fall


@inline
def rim_feature(k: int, axis: int, upper_end: bool) -> Any:
    """
    Name the point k of an end: 0 lowest, 1 and 2 a quarter turn to either side, 3 opposite.

    The lowest points of the two ends, 0 and 1, keep their names while a cylinder rolls.
    """
    if axis != EXACT:
        step = k if k < 2 else 5 - k  # in quarter turns: 0, 1, 3, 2
        return FIXED + (axis + step) % 4 + UPPER * upper_end
    return 1.0 * upper_end if k == 0 else 1.0 + k + UPPER * upper_end
