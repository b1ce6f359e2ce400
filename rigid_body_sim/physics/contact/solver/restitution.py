# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bounce of one batch of contacts, lane by lane: Newton's law after the last substep.

    J <- J - m (v_n + e v_approach),  J >= 0,  for contacts that pushed in this tick

v_approach: see `preparation`. Contacts that press but do not bounce keep v_n >= 0. Friction acts
on the impulse of the bounce: with that of the substeps it adds up to Coulomb's law for the whole.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch
from rigid_body_sim.physics.contact.solver.wide_lanes import arms, disc, relative, strike, vector

Array = NDArray[np.float64]

SETTLED = 1e-12  # [-] of what a point gives in this tick: what changes by less has settled


@kernel
def bounce(lanes: int, s: Array, q: Array, g: Array) -> None:
    """
    Visit one point of each lane after the last substep: v_n <- -e v_approach where it bounces,
    v_n >= 0 elsewhere; friction on the impulse of the bounce.
    """
    for k in range(lanes):
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = relative(s, g, k, ax, ay, az, bx, by, bz)
        approach = q[k + contact_point.APPROACH_VELOCITY]
        aim = -s[k + constraint.RESTITUTION] * approach if approach < 0.0 else 0.0
        old, old_t, old_o = (
            q[k + contact_point.RESTITUTION_NORMAL],
            q[k + contact_point.RESTITUTION_TANGENT_1],
            q[k + contact_point.RESTITUTION_TANGENT_2],
        )
        gain = q[k + contact_point.TANGENT_MASS]
        largest = g[k + lane_scratch.NORMAL_CHANGE]
        new = old - q[k + contact_point.NORMAL_MASS] * ((nx * x + ny * y + nz * z) - aim)
        new = new if new > 0.0 else 0.0
        press = q[k + contact_point.LARGEST_NORMAL_IMPULSE] + q[k + contact_point.NORMAL_IMPULSE]
        new = new if press > 0.0 else 0.0
        change = new - old
        t = old_t - gain * (
            (tx * x + ty * y + tz * z) + q[k + contact_point.CROSS_TERM_1] * change
        )
        o = old_o - gain * (
            (ox * x + oy * y + oz * z) + q[k + contact_point.CROSS_TERM_2] * change
        )
        t, o = disc(t, o, s[k + constraint.FRICTION] * new)
        size = abs(change) + (abs(t - old_t) + abs(o - old_o))
        # what is settled keeps its bits, however long others take
        moves = size > SETTLED * (press + new)
        size = size if moves else 0.0
        new, t, o = (new, t, o) if moves else (old, old_t, old_o)
        change, dt, do = new - old, t - old_t, o - old_o
        x = change * nx + (dt * tx + do * ox)
        y = change * ny + (dt * ty + do * oy)
        z = change * nz + (dt * tz + do * oz)
        (
            q[k + contact_point.RESTITUTION_NORMAL],
            q[k + contact_point.RESTITUTION_TANGENT_1],
            q[k + contact_point.RESTITUTION_TANGENT_2],
        ) = new, t, o
        g[k + lane_scratch.NORMAL_CHANGE] = size if size > largest else largest
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)
