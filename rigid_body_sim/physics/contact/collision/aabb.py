# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Axis-aligned bounding boxes (AABB) in the world, as the hash grid and the neighbour list keep them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline

Array = NDArray[np.float64]

aabb = Record()
LOW = aabb.vector('m', 'low corner')
HIGH = aabb.vector('m', 'high corner')
SIZE = aabb.size


@inline
def overlap(aabbs: Array, a: int, b: int) -> bool:
    """Tell, without a branch, whether two boxes overlap; a, b: where they begin."""
    return (
        (aabbs[a + LOW] <= aabbs[b + HIGH])
        & (aabbs[b + LOW] <= aabbs[a + HIGH])
        & (aabbs[a + LOW + 1] <= aabbs[b + HIGH + 1])
        & (aabbs[b + LOW + 1] <= aabbs[a + HIGH + 1])
        & (aabbs[a + LOW + 2] <= aabbs[b + HIGH + 2])
        & (aabbs[b + LOW + 2] <= aabbs[a + HIGH + 2])
    )


@inline
def extent(half_edges: Any, direction: Any) -> Any:
    """Return how far a box with these half edges reaches from its middle along a direction."""
    return (
        abs(direction[0]) * half_edges[0]
        + abs(direction[1]) * half_edges[1]
        + abs(direction[2]) * half_edges[2]
    )
