# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The arrays of this room: written and read within one tick, a row for each body and one for all that
cannot move.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.energy import gain_record, impact_record

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

taken = Record()
OF_MOMENTUM = taken.vector('kg m/s', 'what the last tick took back of its momentum')
OF_SPIN = taken.vector('kg m^2/s', 'of its angular momentum')
OF_PLACE = taken.vector('m', 'of its displacement')
TAKEN = taken.size


class EnergyScratch(NamedTuple):
    """
    What the bounds write down.

    order   : of bodies, in which what they give is summed: `pressing_groups`
    roots   : union-find of bodies that press on each other: first body of the group
    impacts : see `impact_record`
    gains   : see `gain_record`
    taken   : what the last tick took back of each body, by the names above; the first number of
              what cannot move is 1 where it is not all zero
    """

    order: Indices
    roots: Indices
    impacts: Array
    gains: Array
    taken: Array


def make_scratch(body_count: int) -> EnergyScratch:
    """Make the arrays of so many moving bodies."""
    size = body_count + 1
    return EnergyScratch(
        order=np.zeros(size, dtype=np.int64),
        roots=np.zeros(size, dtype=np.int64),
        impacts=np.zeros(size * impact_record.SIZE),
        gains=np.zeros(size * gain_record.SIZE),
        taken=np.zeros(size * TAKEN),
    )
