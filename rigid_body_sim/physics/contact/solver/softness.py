# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How soft the normals of a constraint are.

Normals are soft constraints (TGS-Soft, as in Box2D v3 and Box3D): a spring and a damper whose
frequency is that of the substep, so that an overlap goes within a few of them,

    omega_c = sqrt(w) (pi/h' where one of the two cannot move, else pi/(2 h'))
    a1 = 2 zeta + h omega_c, a2 = h omega_c a1
    bias rate omega_c/a1,  mass scale a2/(1 + a2),  impulse scale 1/(1 + a2)

h : [s] substep, h' : that of a tick which is not cut, zeta : [-] damping ratio, w : [-] share of a
face in the surface that it is a part of, else 1 (`common_pressure`): then all parts give way alike
under one pressure, and one that is just covered by a sliver holds up no more than that.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.solver import constraint, contact_point

DEEP = 0.005  # [-] of the radius: what is deeper comes out at a rate: `solve`


class Softness(NamedTuple):
    """
    What softness depends on beside the pair.

    h, whole : [s] substep, and that of a tick which is not cut: contacts of a piece stay as soft
               as in the whole, or what rests would be thrown up by the overlap with which it rests
    zeta     : [-] damping ratio
    """

    h: float
    whole: float
    zeta: float


@inline
def soften(lane: int, softness: Softness, fixed: bool, share: float, rows: Array) -> None:
    """Write the softness of a constraint; fixed: one of the two cannot move, share: w."""
    h = softness.h
    omega = (math.pi if fixed else 0.5 * math.pi) / max(h, softness.whole) * math.sqrt(share)
    a1 = 2.0 * softness.zeta + h * omega
    a2 = h * omega * a1
    impulse_scale = 1.0 / (1.0 + a2)
    rows[lane + constraint.BIAS_RATE] = omega / a1
    rows[lane + constraint.MASS_SCALE] = a2 * impulse_scale
    rows[lane + constraint.IMPULSE_SCALE] = impulse_scale
    rows[lane + constraint.SHARE] = share


@inline
def spring_mass(lane: int, row: int, constraints: Array, points: Array) -> Any:
    """Return the mass on which the own spring of a point of a lane acts [kg]: `face_spring`."""
    of_mean = constraints[lane + constraint.MEAN_SPRING_MASS]
    of_part = points[row + contact_point.SPRING_SHARE] * of_mean
    return of_part if of_mean > 0.0 else points[row + contact_point.NORMAL_MASS]
