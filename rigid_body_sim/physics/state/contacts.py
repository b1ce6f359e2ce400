# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be read of contacts after a tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Contacts:
    """
    The points at which bodies touched in the last tick: those that overlap or pushed.

    bodies  : (m, 2) int      scene indices
    point   : (m, 3) [m]      world, midway between the two surfaces
    normal  : (m, 3) [-]      unit vector from the first body to the second, world
    gap     : (m,)   [m]      distance of the surfaces, negative where they overlap
    impulse : (m, 3) [N s]    on the second body over the last tick, world; its opposite acts on
                              the first
    """

    bodies: NDArray[np.int64]
    point: Array
    normal: Array
    gap: Array
    impulse: Array

    def __len__(self) -> int:
        return len(self.gap)


NO_CONTACTS = Contacts(
    np.zeros((0, 2), dtype=np.int64),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros(0),
    np.zeros((0, 3)),
)
