# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The moment of inertia of a body about an axis: I_n = n . I_C n + m |n x (r_c - point)|^2, with mass
and inertia of an instant where they change (`variable_mass`, `inertia_over_time`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.inertia_over_time import inertia_at
from rigid_body_sim.physics.model.mass_properties import MassProperties, moment_about
from rigid_body_sim.physics.model.numbers import checked_vector
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.variable_mass import mass_at


def moment_of_body(
    body: Body, *, direction: ArrayLike, point: ArrayLike | None = None, time: float = 0.0
) -> float:
    """
    Return the moment of inertia [kg m^2] of a body about an axis fixed to it.

    direction : (3,)      along the axis, body axes, of any length but zero
    point     : (3,) [m]  any point of the axis, shape coordinates; None: the centre of mass
    time      : [s] since the start of the scene, for a mass or an inertia that changes

    Raises InvalidModel for a fixed body without mass, and for an axis that is none.
    """
    if body.mass == 0.0 or (body.fixed and body.inertia is None):
        raise InvalidModel(f'{body.name!r} is fixed and states no inertia: it has no moment')
    center = np.asarray(body.center_of_mass, dtype=np.float64)
    said = f'the axis in {body.name!r}'
    along = checked_vector(said, 'direction', direction)
    at = center if point is None else np.array(checked_vector(said, 'point', point))
    tensor = inertia_at(body, time)
    if tensor is None:
        tensor = np.zeros((3, 3))
    properties = MassProperties(mass_at(body, time), center, tensor)
    return moment_about(properties, point=at, direction=along)
