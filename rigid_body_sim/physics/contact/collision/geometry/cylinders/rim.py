# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which point of a cylinder's round end is the lowest above a plane, and the points around it.

    m normal out of the plane, a axis, tau = m - (m . a) a, |tau| sine of the tilt, u = tau / |tau|

The lowest point of either end is at its middle - r u. Where the end is parallel to the plane u has
no meaning: for |tau| < FLAT it is blended with the nearest of four axes d fixed in the end,
u ~ tau + (FLAT - |tau|) d. So a standing cylinder keeps its points, and above FLAT the lowest
point is exact.

The four axes are those that the pair has held (`manifold.HELD`): the names of its points tell by
what share of a quarter turn they are turned. A load beside the square of the four points is
carried by two of them, and would tilt the cylinder over the side between them: then one of the
axes turns to where these two bear it. Who comes to stand after a tilt has one where it was lowest.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    HELD,
    HELD_COUNT,
    HELD_IMPULSES,
    MOST,
)

FLAT = 1e-4  # [-] sine of the tilt below which an end keeps points fixed in it
UPPER = 5.0  # features of the end at +z are larger by this, but for those of the lowest points
FIXED = 10.0  # features of points fixed in an end begin here
LAST_FIXED = 20.0  # and end before this
EXACT = -1.0  # in place of an axis: none, the lowest point is where it is exactly
SHARES = 1024.0  # [-] of a quarter turn by which the axes may be turned: none is rounded in a name
QUARTER = 0.5 * math.pi  # [rad]
ON_A_SIDE = 0.97  # [-] of the way to a side of the square: there two points bear nearly all
AT_A_CORNER = 0.9  # [-] of the way to a corner: from there on no turn brings it nearer
TILTED = -1.0  # in place of a turn: the pair has held none


@inline
def _turn_of(x: float, y: float) -> float:
    """Return the turn of four axes of which one is along (x, y), in whole SHARES: 0 to below 1."""
    share = math.floor(math.atan2(y, x) / QUARTER * SHARES + 0.5) / SHARES
    return share - math.floor(share)


@inline
def _held_turn(found: Array) -> float:
    """
    Return the turn of the four axes of a pair, in quarter turns: 0 to below 1, 0 where it was not
    near, and TILTED where its lowest point was exact.
    """
    count = int(found[HELD_COUNT])
    turn = 0.0 if count == 0 else TILTED
    x, y, sum_of_all = 0.0, 0.0, 0.0
    fixed = 0
    for point in range(count):
        name = found[HELD + point]
        if name < FIXED or name >= LAST_FIXED:
            continue
        turn = name - math.floor(name)
        quarter = math.floor(name) - (FIXED + UPPER if name >= FIXED + UPPER else FIXED)
        pressed = found[HELD_IMPULSES + point]
        along = pressed if quarter < 2.0 else -pressed
        x += along if quarter == 0.0 or quarter == 2.0 else 0.0
        y += along if quarter == 1.0 or quarter == 3.0 else 0.0
        sum_of_all += pressed
        fixed += 1
    is_beside = abs(x) + abs(y) > ON_A_SIDE * sum_of_all
    is_beside = is_beside and max(abs(x), abs(y)) < AT_A_CORNER * sum_of_all
    if fixed == MOST and is_beside:
        turn += _turn_of(x, y)
        turn -= math.floor(turn)
    return turn


@inline
def lowest_direction(tilt_x: float, tilt_y: float, found: Array) -> Any:
    """
    Return u (2) in the axes of the end, and the axis d: 0 to 3 for +x, +y, -x, -y and the turn of
    these, or EXACT.

    tilt_x, tilt_y : tau in the axes of the end
    found          : of the pair, with what it has held
    """
    sine = math.sqrt(tilt_x * tilt_x + tilt_y * tilt_y)
    if not sine < FLAT:
        return tilt_x / sine, tilt_y / sine, EXACT
    held = _held_turn(found)
    turn = _turn_of(tilt_x, tilt_y) if held == TILTED else held
    cosine, across = 1.0, 0.0
    if turn > 0.0:
        cosine, across = math.cos(turn * QUARTER), math.sin(turn * QUARTER)
    x, y = cosine * tilt_x + across * tilt_y, cosine * tilt_y - across * tilt_x
    blend = FLAT - sine
    if abs(y) > abs(x):
        axis = 3.0 if y < 0.0 else 1.0
        y += -blend if y < 0.0 else blend
    else:
        axis = 2.0 if x < 0.0 else 0.0
        x += -blend if x < 0.0 else blend
    length = math.sqrt(x * x + y * y)
    x, y = x / length, y / length
    return cosine * x - across * y, cosine * y + across * x, axis + turn


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
def rim_feature(k: int, axis: float, upper_end: bool) -> Any:
    """
    Name the point k of an end: 0 lowest, 1 and 2 a quarter turn to either side, 3 opposite.

    The lowest points of the two ends, 0 and 1, keep their names while a cylinder rolls.
    """
    if axis != EXACT:
        step = k if k < 2 else 5 - k  # in quarter turns: 0, 1, 3, 2
        place = axis + step
        return FIXED + (place - 4.0 if place >= 4.0 else place) + UPPER * upper_end
    return 1.0 * upper_end if k == 0 else 1.0 + k + UPPER * upper_end
