# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies that turn about a fixed point: heavy tops, pendulums.

    L' = torque + a x F,   L = R I_O R^T omega            about the pivot O, world axes
    I_O = I_C + m (|a|^2 1 - a a^T)                       [kg m^2]  its own principal axes
    r = O + a,   v = omega x a                            of the centre of mass
        a         : [m]       arm, from the pivot to the centre of mass, turns with the body
        F, torque : [N, N m]  all that acts, weight too, about the centre of mass

The kernels keep q and L about the pivot, of which any integrator makes a free rotation with the
inertia I_O and a torque. The row of the body among the translations stands still at O without
momentum. The element `forces.elements.pivot` shows the other elements the centre of mass that they
ask for, and turns what they answer into a torque about O. The pivot takes the rest of the forces;
what it takes is not part of a wrench anywhere.

Source: Goldstein, Classical Mechanics, sections 5.1 and 5.7.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.mass_properties import parallel_axes
from rigid_body_sim.physics.model.scene import Body, Vector

Array = NDArray[np.float64]


AGREEMENT = 1e-6  # [-] of the numbers: what is given twice is often rounded by hand


def check_given(given: Vector, wanted: Vector, *, what: str, unit: str, why: str) -> None:
    """Refuse a position or velocity that is not the one that follows from the pivot."""
    size = max(1.0, float(np.max(np.abs(wanted))))
    if not np.allclose(given, wanted, rtol=0.0, atol=AGREEMENT * size):
        numbers = ', '.join(f'{number:.9g}' for number in wanted)
        raise InvalidModel(
            f'got {list(given)}; with this pivot {what} is [{numbers}] {unit}, for {why}: leave '
            'it out',
            at=(what,),
        )


def check_pivot(body: Body) -> None:
    """Refuse a pivot that the body cannot have."""
    if body.pivot is None:
        return
    name = repr(body.name)
    if body.fixed:
        raise InvalidModel(f'{name} is fixed and does not turn; remove pivot, or fixed')
    if body.is_point:
        raise InvalidModel(
            f'{name} is a point mass, which does not turn about a pivot; give it a shape with '
            'extent, or hold it by a spring'
        )
    if body.mass_flow is not None:
        raise InvalidModel(
            f'{name} turns about a pivot, for which a mass that changes is not modelled; remove '
            'mass_rate, or pivot'
        )
    if not np.all(np.isfinite([*body.pivot.point, *body.pivot.at])):
        raise InvalidModel(f'the pivot of {name} must be finite, got {body.pivot}')
    with np.errstate(over='ignore', invalid='ignore'):
        about_pivot = None if body.inertia is None else inertia_of(body)
    if about_pivot is not None and not np.all(np.isfinite(about_pivot)):
        raise InvalidModel(
            f'the pivot of {name} is so far from its centre of mass that its inertia about it is '
            'beyond all numbers; put point nearer to the body'
        )


def arm_of(body: Body) -> Array:
    """Arm from the pivot to the centre of mass (3,) [m], body axes."""
    assert body.pivot is not None
    return np.subtract(body.center_of_mass, body.pivot.point)


def inertia_of(body: Body) -> Array:
    """Inertia (3, 3) [kg m^2] about the pivot, or about the centre of mass where there is none."""
    assert body.inertia is not None
    if body.pivot is None:
        return body.inertia
    return parallel_axes(body.inertia, mass=body.mass, offset=arm_of(body))
