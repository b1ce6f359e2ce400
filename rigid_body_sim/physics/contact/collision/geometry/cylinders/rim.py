# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which point of a cylinder's round end is the lowest above a plane, and the points around it.

    m normal out of the plane, a axis, tau = m - (m . a) a, |tau| sine of the tilt, u = tau / |tau|

The lowest point of either end is at its middle - r u, exact for |tau| above FLAT. Where the end is
parallel to the plane u has no meaning: four axes d fixed in the end are held there, of which that
nearest to u stays for |tau| < STILL, and is blended with it above, so that nothing jumps:

    u ~ (1 - STILL / |tau|) tau + (FLAT - |tau|) d

Blended from nothing on, a point would turn by 1 / FLAT of a tilt, and its impulse with it: a light
cylinder that a spring presses down beside its axis never came to rest.

The four axes are those that the pair has held (`manifold.HELD`): the names of its points tell
where they are, in quarter turns. Where two of them bear all of the load and the cylinder tips over
the side between them, one of the others gives way to the middle of the arc beyond, as a corner of
a polygon does (`loaded_side`): the four close in on the place of the load. Who comes to stand
after a tilt has one where it was lowest, and the others a quarter turn apart.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import (
    NONE,
    TIPS,
    loaded_side,
    one_of,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    HELD,
    HELD_COUNT,
    MOST,
)

FLAT = 1e-4  # [-] sine of the tilt below which an end has points fixed in it
STILL = 0.5 * FLAT  # [-] sine of the tilt below which the lowest of them stays where it is
UPPER = 5.0  # features of the end at +z are larger by this, but for those of the lowest points
FIXED = 10.0  # features of points fixed in an end begin here
LAST_FIXED = 20.0  # and end before this
EXACT = -1.0  # in place of a place: none, the lowest point is where it is exactly
SHARES = 1024.0  # [-] of a quarter turn by which the axes may be turned: none is rounded in a name
QUARTER = 0.5 * math.pi  # [rad]
SHORT = 1.0 / 16.0  # [quarter turn]: an arc so short is not parted


@inline
def _within(turn: float) -> float:
    """Return quarter turns without whole turns: 0 to below 4."""
    return turn - 4.0 * math.floor(0.25 * turn)


@inline
def _direction(place: float) -> Any:
    """Return the direction of a place in quarter turns; those of whole ones are exact."""
    quarter = math.floor(place)
    cosine, sine = 1.0, 0.0
    if place > quarter:
        cosine, sine = math.cos((place - quarter) * QUARTER), math.sin((place - quarter) * QUARTER)
    if quarter == 0.0:
        return cosine, sine
    if quarter == 1.0:
        return -sine, cosine
    if quarter == 2.0:
        return -cosine, -sine
    return sine, -cosine


@inline
def _place_of(index: int, found: Array) -> float:
    """Return where a held point is fixed in its end, in quarter turns; EXACT: it is not."""
    name = found[HELD + index]
    if name < FIXED or name >= LAST_FIXED:
        return EXACT
    return name - (FIXED + UPPER if name >= FIXED + UPPER else FIXED)


@kernel
def _held_places(tilt_x: float, tilt_y: float, found: Array) -> Any:
    """
    Return the places of the four axes of a pair, in quarter turns: those that it has held, one of
    them moved to where it is needed. Or else they are a quarter turn apart, one of them where it
    held one, or along tau where it comes from a tilt.
    """
    count, fixed, share = int(found[HELD_COUNT]), 0, 0.0
    if count > 0:
        share = math.floor(math.atan2(tilt_y, tilt_x) / QUARTER * SHARES + 0.5) / SHARES
    for index in range(count):
        place = _place_of(index, found)
        if place != EXACT:
            fixed, share = fixed + 1, place
    if fixed < MOST:
        share -= math.floor(share)
        return share, share + 1.0, share + 2.0, share + 3.0
    places = _place_of(0, found), _place_of(1, found), _place_of(2, found), _place_of(3, found)
    one, other = loaded_side(found)
    if one == NONE:
        return places
    begin, end = _place_of(one, found), _place_of(other, found)
    arc, inside, gives_way, farthest = _within(end - begin), 0, NONE, -1.0
    middle = begin + 0.5 * arc
    for index in range(MOST):
        if index != one and index != other:
            inside += 1 if _within(_place_of(index, found) - begin) < arc else 0
    if inside == 1:  # the two bear across
        return places
    if inside == 2:  # the arc beyond is the other one
        arc, middle = 4.0 - arc, middle + 2.0
    if arc < SHORT:
        return places
    middle = _within(math.floor(middle * SHARES + 0.5) / SHARES)
    heavier = _place_of(one, found)
    lowest = -math.inf
    for index in range(MOST):
        place = _place_of(index, found)
        x, y = _direction(place)
        lowest = max(lowest, tilt_x * x + tilt_y * y)
        away = _within(place - heavier)
        if index != one and index != other and min(away, 4.0 - away) > farthest:
            gives_way, farthest = index, min(away, 4.0 - away)
    x, y = _direction(middle)
    if not tilt_x * x + tilt_y * y > lowest + TIPS:
        return places
    a, b, c, d = places
    a, b = (middle if gives_way == 0 else a), (middle if gives_way == 1 else b)
    c, d = (middle if gives_way == 2 else c), (middle if gives_way == 3 else d)
    return a, b, c, d


@kernel
def rim_directions(tilt_x: float, tilt_y: float, found: Array) -> Any:
    """
    Return u (2) of the four points of an end, in its axes, and their places in quarter turns, each
    as x, y, place: the lowest, the next to either side, the last; EXACT in place of all places
    where the lowest is exact.

    tilt_x, tilt_y : tau in the axes of the end
    found          : of the pair, with what it has held
    """
    sine = math.sqrt(tilt_x * tilt_x + tilt_y * tilt_y)
    if not sine < FLAT:
        x, y = tilt_x / sine, tilt_y / sine
        return (x, y, EXACT), (-y, x, EXACT), (y, -x, EXACT), (-x, -y, EXACT)
    a, b, c, d = _held_places(tilt_x, tilt_y, found)
    lowest, most = a, -math.inf
    for index in range(MOST):
        place = one_of(index, a, b, c, d)
        x, y = _direction(place)
        if tilt_x * x + tilt_y * y > most:
            lowest, most = place, tilt_x * x + tilt_y * y
    after, before, turns = 4.0, 0.0, 0.0
    for index in range(MOST):
        turn = _within(one_of(index, a, b, c, d) - lowest)
        after = min(after, turn) if turn > 0.0 else after
        before, turns = max(before, turn), turns + turn
    last = _within(lowest + turns - after - before)
    after, before = _within(lowest + after), _within(lowest + before)
    x, y = _direction(lowest)
    if sine > STILL:
        share, blend = 1.0 - STILL / sine, FLAT - sine
        x, y = share * tilt_x + blend * x, share * tilt_y + blend * y
        length = math.sqrt(x * x + y * y)
        x, y = x / length, y / length
    return (
        (x, y, lowest), (*_direction(after), after),
        (*_direction(before), before), (*_direction(last), last),
    )  # fmt: skip


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
def rim_feature(k: int, place: float, upper_end: bool) -> Any:
    """
    Name the point k of an end: 0 lowest, 1 and 2 a quarter turn to either side, 3 opposite.

    The lowest points of the two ends, 0 and 1, keep their names while a cylinder rolls.
    """
    if place != EXACT:
        return FIXED + place + UPPER * upper_end
    return 1.0 * upper_end if k == 0 else 1.0 + k + UPPER * upper_end
