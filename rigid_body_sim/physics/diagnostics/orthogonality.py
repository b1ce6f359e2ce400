# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How far a matrix that should be a rotation is from one: the drift of R.

    d = max |(R^T R - 1)_ij|

An integrator with `orientation: matrix` carries the nine numbers of R as they are; six of them are
redundant, and nothing but the equation R' = w* R holds them together. Zero for a rotation, up to
rounding; it grows with the error of the method unless R is made orthogonal again after each step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model.plain_products import product

Array = NDArray[np.float64]


def orthogonality_defect(matrices: Array) -> float:
    """Return the largest d [-] of matrices (n, 3, 3); 0 where there are none."""
    defects = product(np.swapaxes(matrices, -1, -2), matrices) - np.eye(3)
    return float(np.max(np.abs(defects), initial=0.0))
