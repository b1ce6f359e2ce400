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

from rigid_body_sim.physics.contact.lanes import (
    arms,
    cross,
    disc,
    inertia,
    relative,
    times,
    vector,
)
from rigid_body_sim.physics.contact.rows import (
    APPROACH,
    BN,
    BO,
    BOUNCE,
    BT,
    CHANGE,
    GAIN,
    HA,
    HB,
    MA,
    MB,
    MOST,
    MU,
    PS,
    SLIP_GAIN,
    T2,
    VA,
    VB,
    WA,
    WB,
    N,
    T,
)
from rigid_body_sim.physics.kernels import kernel

Array = NDArray[np.float64]


@kernel
def bounce(lanes: int, s: Array, q: Array, g: Array, threshold: float) -> None:
    """
    Visit one point of each lane after the last substep: v_n <- -e v_approach where it bounces,
    v_n >= 0 elsewhere; friction on the impulse of the bounce.
    """
    for k in range(lanes):
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        ax, ay, az, bx, by, bz = arms(q, k)
        ux, uy, uz = vector(g, k + VA)
        fx, fy, fz = vector(g, k + WA)
        vx, vy, vz = vector(g, k + VB)
        wx, wy, wz = vector(g, k + WB)
        ma, a1, a2, a3, a4, a5, a6 = inertia(g, k + MA)
        mb, b1, b2, b3, b4, b5, b6 = inertia(g, k + MB)
        x, y, z = relative(ux, uy, uz, fx, fy, fz, ax, ay, az, vx, vy, vz, wx, wy, wz, bx, by, bz)
        vn = nx * x + ny * y + nz * z
        approach = q[k + APPROACH]
        elastic = s[k + BOUNCE]
        bounces = (elastic > 0.0) & (approach < -threshold)
        aim = -elastic * approach if bounces else 0.0
        old, old_t, old_o = q[k + BN], q[k + BT], q[k + BO]
        gain = q[k + SLIP_GAIN]
        new = old - q[k + GAIN] * (vn - aim)
        new = new if new > 0.0 else 0.0
        new = new if q[k + MOST] > 0.0 else 0.0
        change = new - old
        x, y, z = change * nx, change * ny, change * nz
        cx, cy, cz = cross(ax, ay, az, x, y, z)
        dx, dy, dz = cross(bx, by, bz, x, y, z)
        ux, uy, uz = ux - ma * x, uy - ma * y, uz - ma * z
        vx, vy, vz = vx + mb * x, vy + mb * y, vz + mb * z
        cx, cy, cz = times(a1, a2, a3, a4, a5, a6, cx, cy, cz)
        fx, fy, fz = fx - cx, fy - cy, fz - cz
        dx, dy, dz = times(b1, b2, b3, b4, b5, b6, dx, dy, dz)
        wx, wy, wz = wx + dx, wy + dy, wz + dz
        ex, ey, ez = relative(
            ux, uy, uz, fx, fy, fz, ax, ay, az, vx, vy, vz, wx, wy, wz, bx, by, bz
        )
        t = old_t - gain * (tx * ex + ty * ey + tz * ez)
        o = old_o - gain * (ox * ex + oy * ey + oz * ez)
        t, o = disc(t, o, s[k + MU] * new)
        dt, do = t - old_t, o - old_o
        ex, ey, ez = dt * tx + do * ox, dt * ty + do * oy, dt * tz + do * oz
        ux, uy, uz = ux - ma * ex, uy - ma * ey, uz - ma * ez
        vx, vy, vz = vx + mb * ex, vy + mb * ey, vz + mb * ez
        cx, cy, cz = cross(ax, ay, az, ex, ey, ez)
        dx, dy, dz = cross(bx, by, bz, ex, ey, ez)
        cx, cy, cz = times(a1, a2, a3, a4, a5, a6, cx, cy, cz)
        dx, dy, dz = times(b1, b2, b3, b4, b5, b6, dx, dy, dz)
        x, y, z = x + ex, y + ey, z + ez
        ax, ay, az = cross(ax, ay, az, x, y, z)
        bx, by, bz = cross(bx, by, bz, x, y, z)
        px, py, pz = vector(g, k + PS)
        hx, hy, hz = vector(g, k + HA)
        lx, ly, lz = vector(g, k + HB)
        size = abs(change)
        largest = g[k + CHANGE]
        q[k + BN] = new
        q[k + BT] = t
        q[k + BO] = o
        g[k + CHANGE] = size if size > largest else largest
        g[k + VA], g[k + VA + 8], g[k + VA + 16] = ux, uy, uz
        g[k + WA], g[k + WA + 8], g[k + WA + 16] = fx - cx, fy - cy, fz - cz
        g[k + VB], g[k + VB + 8], g[k + VB + 16] = vx, vy, vz
        g[k + WB], g[k + WB + 8], g[k + WB + 16] = wx + dx, wy + dy, wz + dz
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + HA], g[k + HA + 8], g[k + HA + 16] = hx + ax, hy + ay, hz + az
        g[k + HB], g[k + HB + 8], g[k + HB + 16] = lx + bx, ly + by, lz + bz
