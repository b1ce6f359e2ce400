# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The inertia tensor alone: whether a rigid body can have it.

Source: Goldstein, Classical Mechanics, sections 5.3 and 5.4.
"""

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.principal_axes import principal_moments

# Relative to the largest moment. Round-off of sums and turns is near 1e-15; a rod of 1 m must be
# thinner than 0.8 um to be taken for a line. A larger value refuses thin bodies, a smaller one
# lets a line of particles pass.
MOMENT_TOLERANCE = 1e-12


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
    if not np.all(np.isfinite(inertia)):
        raise InvalidModel(
            'the inertia tensor holds NaN or infinity [kg m^2]; '
            'mass and size must stay within range'
        )
    largest = float(np.max(np.abs(inertia)))
    if np.max(np.abs(0.5 * inertia - 0.5 * inertia.T)) > MOMENT_TOLERANCE * largest:
        raise InvalidModel(
            'the inertia tensor is not symmetric; Ixy = Iyx, Ixz = Izx and Iyz = Izy are needed'
        )
    scale = largest if largest > 0.0 else 1.0
    moments = principal_moments(inertia / scale)
    slack = MOMENT_TOLERANCE * float(np.max(np.abs(moments)))
    shown = _shown(moments * scale)
    if moments[0] < -slack:
        raise InvalidModel(f'principal moments {shown} kg m^2; a rigid body needs positive ones')
    if not moments[0] > slack:
        raise InvalidModel(
            f'principal moments {shown} kg m^2 are not all positive; a line of particles has no '
            'moment about its own axis, nor has a single point: give it a thickness, or state the '
            'inertia'
        )
    if moments[0] + moments[1] < moments[2] - slack:
        raise InvalidModel(
            f'principal moments {shown} kg m^2 break the triangle inequality; '
            'a rigid body needs I1 + I2 >= I3'
        )
    if not largest * 1e-12 > np.finfo(np.float64).tiny:
        raise InvalidModel(
            f'principal moments {shown} kg m^2 are too small to compute with; '
            'check the units (m, kg)'
        )


def _shown(moments: ArrayLike) -> str:
    return '(' + ', '.join(f'{moment:.6g}' for moment in np.asarray(moments)) + ')'
