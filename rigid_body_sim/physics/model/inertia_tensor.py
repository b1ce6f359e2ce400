# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The inertia tensor alone: whether a rigid body can have it.

Source: Goldstein, Classical Mechanics, sections 5.3 and 5.4.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.principal_axes import moments_of

# Relative to the largest moment. Round-off of sums and turns is near 1e-15; a rod of 1 m must be
# thinner than 0.8 um to be taken for a line. A larger value refuses thin bodies, a smaller one
# lets a line of particles pass.
MOMENT_TOLERANCE = 1e-12
SMALLEST = float(np.finfo(np.float64).tiny)


def check_inertia(inertia: ArrayLike) -> None:
    """
    Refuse a tensor that no rigid body of positive density has.

    Needed: finite, symmetric, I1 > 0, and I1 + I2 >= I3 for the ordered principal moments. Moments
    and sums are compared to within MOMENT_TOLERANCE of the largest moment, so that a thin plate
    (I1 + I2 = I3) passes.
        inertia : (3, 3) [kg m^2]  about the centre of mass
    """
    inertia = np.asarray(inertia, dtype=np.float64)
    if inertia.shape != (3, 3):
        raise InvalidModel(f'an inertia tensor is (3, 3), got {inertia.shape}')
    _, xy, xz, yx, _, yz, zx, zy, _ = elements = inertia.ravel().tolist()
    if not all(map(math.isfinite, elements)):
        raise InvalidModel(
            'the inertia tensor holds NaN or infinity [kg m^2]; '
            'mass and size must stay within range'
        )
    largest = max(map(abs, elements))
    apart = max(abs(0.5 * xy - 0.5 * yx), abs(0.5 * xz - 0.5 * zx), abs(0.5 * yz - 0.5 * zy))
    if apart > MOMENT_TOLERANCE * largest:
        raise InvalidModel(
            'the inertia tensor is not symmetric; Ixy = Iyx, Ixz = Izx and Iyz = Izy are needed'
        )
    scale = largest if largest > 0.0 else 1.0
    scaled = [x / scale for x in elements]
    moments = moments_of([scaled[:3], scaled[3:6], scaled[6:]])
    slack = MOMENT_TOLERANCE * max(map(abs, moments))
    if moments[0] < -slack:
        raise InvalidModel(
            f'principal moments {_shown(moments, scale)} kg m^2; a rigid body needs positive ones'
        )
    if not moments[0] > slack:
        raise InvalidModel(
            f'principal moments {_shown(moments, scale)} kg m^2 are not all positive; a line of '
            'particles has no moment about its own axis, nor has a single point: give it a '
            'thickness, or state the inertia'
        )
    if moments[0] + moments[1] < moments[2] - slack:
        raise InvalidModel(
            f'principal moments {_shown(moments, scale)} kg m^2 break the triangle inequality; '
            'a rigid body needs I1 + I2 >= I3'
        )
    if not largest * 1e-12 > SMALLEST:
        raise InvalidModel(
            f'principal moments {_shown(moments, scale)} kg m^2 are too small to compute with; '
            'check the units (m, kg)'
        )


def _shown(moments: Sequence[float], scale: float) -> str:
    return '(' + ', '.join(f'{moment * scale:.6g}' for moment in moments) + ')'
