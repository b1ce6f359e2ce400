# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The first word on a body whose inertia changes over time: the moments of the instant.

    I <- I_a + w(u) (I_b - I_a),   u = (t - a) / (b - a),   w = u, or 3 u^2 - 2 u^3

Not an element that a scene names, and no force: it writes the moments, and their inverses, at the
time of each evaluation, before any force reads an angular velocity; see `model.inertia_over_time`
for the equations and the model. One row is one piece between two rows of the table of the scene;
the schedule switches it on for as long as it holds.
"""

from __future__ import annotations

import math
from itertools import pairwise

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.element import Places
from rigid_body_sim.physics.forces.power import DRIVES
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import (
    LANES,
    ROTATION,
    angular_velocity,
    at,
    orientation,
    rotated_back,
)
from rigid_body_sim.physics.vectors import add, load, scale, store_strided, subtract

NAME = 'inertia_over_time'

columns = Record()
RIGID = columns.number('-', 'index among the rigid bodies')
BEGIN = columns.number('s', 'a: when the piece begins')
PER_SECOND = columns.number('1/s', '1 / (b - a); 0 where the moments stay')
SMOOTH = columns.number('-', '1: along 3 u^2 - 2 u^3, else straight')
FIRST_MOMENTS = columns.vector('kg m^2', 'I_a')
LAST_MOMENTS = columns.vector('kg m^2', 'I_b')
HOLDS = columns.number('-', '1 while the piece lasts, else 0: the switch')
COLUMNS = columns.size
SWITCH = HOLDS


@inline
def moments_of(elements, row, time):
    """Moments at a time [kg m^2]."""
    share = (time - elements[row + BEGIN]) * elements[row + PER_SECOND]
    if elements[row + SMOOTH] != 0.0:
        share = share * share * (3.0 - 2.0 * share)
    first = load(elements, row + FIRST_MOMENTS)
    return add(first, scale(share, subtract(load(elements, row + LAST_MOMENTS), first)))


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Write the moments of the instant."""
    for number in range(count):
        row = start + COLUMNS * number
        if elements[row + HOLDS] != 0.0:
            a, b, c = moments_of(elements, row, time)
            k = at(int(elements[row + RIGID]), ROTATION)
            store_strided(rotation, k + blocks.MOMENTS, LANES, (a, b, c))
            inverses = (1.0 / a, 1.0 / b, 1.0 / c)
            store_strided(rotation, k + blocks.INVERSE_MOMENTS, LANES, inverses)


@kernel
def power(elements, start, count, time, translation, rotation, out):
    """Add what moves inside the bodies gives: -omega . I' omega / 2; write the moments before."""
    accumulate(elements, start, count, time, translation, rotation)
    for number in range(count):
        row = start + COLUMNS * number
        if elements[row + HOLDS] != 0.0:
            rigid = int(elements[row + RIGID])
            slope = elements[row + PER_SECOND]
            share = (time - elements[row + BEGIN]) * slope
            if elements[row + SMOOTH] != 0.0:
                slope *= 6.0 * share * (1.0 - share)
            first = load(elements, row + FIRST_MOMENTS)
            a, b, c = scale(slope, subtract(load(elements, row + LAST_MOMENTS), first))
            omega = angular_velocity(rotation, rigid)
            x, y, z = rotated_back(orientation(rotation, rigid), omega)
            out[DRIVES] -= 0.5 * (a * x * x + b * y * y + c * z * z)


def rows(body: Body, places: Places) -> list[tuple[tuple[float, ...], float, float]]:
    """Give the rows of one body, each with the instants [s] at which it begins and ends."""
    law = body.inertia_over_time
    assert law is not None
    rigid = float(places.place(body.name, None).turns)
    smooth = 1.0 if law.interpolation == 'smooth' else 0.0
    first, last = law.table[0], law.table[-1]
    found = [((rigid, 0.0, 0.0, 0.0, *first[1:], *first[1:], 1.0), -math.inf, first[0])]
    for one, other in pairwise(law.table):
        per_second = 1.0 / (other[0] - one[0])
        row = (rigid, one[0], per_second, smooth, *one[1:], *other[1:], 1.0)
        found.append((row, one[0], other[0]))
    found.append(((rigid, 0.0, 0.0, 0.0, *last[1:], *last[1:], 1.0), last[0], math.inf))
    return found
