# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a Runge–Kutta method keeps orientation, as a scene may set it: quaternions or matrices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import plain
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.options import Option
from rigid_body_sim.physics.integration.schemes.state_space.matrices import matrix

Array = NDArray[np.float64]

ORIENTATION = {
    'orientation': Option('quaternion', choices=('quaternion', 'matrix')),
    'reorthonormalise': Option(False),
}


def oriented(integrator: Integrator, settings: Mapping[str, Any]) -> Integrator:
    """
    Choose how a Runge–Kutta scheme keeps orientation; `reorthonormalise` matters to a matrix
    alone.
    """
    if settings['orientation'] == 'quaternion':
        return integrator
    scheme: Any = integrator.scheme
    return replace(
        integrator,
        scheme=replace(scheme, matrix=True, reorthonormalise=settings['reorthonormalise']),
        remembers=matrices,
        limits=integrator.limits.with_matrix(),
        follows_inertia=True,
    )


def matrices(quaternions: Array) -> Array:
    """Matrices (n, 9), row by row, of unit quaternions (n, 4)."""
    return np.stack(matrix_source(*quaternions.T), axis=1)


matrix_source = plain(matrix)
