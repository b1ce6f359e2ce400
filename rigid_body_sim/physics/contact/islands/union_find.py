# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Union-find: bodies that belong together, as a forest of trees. Each body names a parent, or itself
if it is a root.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline

Indices = NDArray[np.int64]


@inline
def find(body: int, parents: Indices) -> int:
    """Find the root of a body; halve the path on the way."""
    while parents[body] != body:
        parents[body] = parents[parents[body]]
        body = parents[body]
    return body


@inline
def unite(first: int, second: int, parents: Indices) -> None:
    """Unite the trees of two bodies; the smaller root stays one."""
    first, second = find(first, parents), find(second, parents)
    if first < second:
        parents[second] = first
    else:
        parents[first] = second
