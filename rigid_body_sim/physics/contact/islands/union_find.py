# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies that belong together, as a forest (union-find): each hangs on another one, or is a root.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline

Indices = NDArray[np.int64]


@inline
def root_of(i: int, parents: Indices) -> int:
    """Find the root of a body, and hang it higher on the way."""
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@inline
def join(i: int, j: int, parents: Indices) -> None:
    """Hang two trees together; the smaller number stays a root."""
    i, j = root_of(i, parents), root_of(j, parents)
    if i < j:
        parents[j] = i
    else:
        parents[i] = j
