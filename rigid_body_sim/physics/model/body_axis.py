# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The moment of inertia of a body about an axis: I_n = n . I_C n + m |n x (r_c - point)|^2."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.mass_properties import MassProperties, moment_about
from rigid_body_sim.physics.model.scene import Body


def moment_of_body(body: Body, *, direction: ArrayLike, point: ArrayLike | None = None) -> float:
    """
    Return the moment of inertia [kg m^2] of a body about an axis fixed to it.

    direction : (3,)      along the axis, body axes, of any length but zero
    point     : (3,) [m]  any point of the axis, shape coordinates; None: the centre of mass

    Raises InvalidModel for a fixed body without mass, and for an axis that is none.
    """
    if body.mass == 0.0 or (body.fixed and body.inertia is None):
        raise InvalidModel(f'{body.name!r} is fixed and states no inertia: it has no moment')
    center = np.asarray(body.center_of_mass, dtype=np.float64)
    at = center if point is None else np.asarray(point, dtype=np.float64)
    if at.shape != (3,) or not np.all(np.isfinite(at)):
        raise InvalidModel(f'the point of an axis is three finite numbers, got {at.tolist()}')
    tensor = np.zeros((3, 3)) if body.inertia is None else body.inertia
    return moment_about(MassProperties(body.mass, center, tensor), point=at, direction=direction)
