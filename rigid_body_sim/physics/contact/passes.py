# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One visit to one batch of contacts: the equations of a contact point, lane by lane.

With relative velocity at the point v = v_B + omega_B x r_B - v_A - omega_A x r_A, v_n = n . v,
gap s, substep h, omega_c = 2 pi f, a1 = 2 zeta + h omega_c, a2 = h omega_c a1, a3 = 1/(1 + a2),
beta = omega_c / a1, sigma = a2 a3, iota = a3:

    biased:   s > 0: dJ = -m (v_n + s/h)
              s <= 0: dJ = -m sigma (v_n + max(beta (s + slop), -cap)) - iota J
    relaxed:  dJ = -m (v_n + max(s, 0)/h)
              J_n <- max(J_n + dJ, 0)
    friction: J_t <- J_t - v_t / lambda_max, then onto the disc |J_t| <= mu J_n

m = 1/(n-entry of J M^-1 J^T); lambda_max largest eigenvalue of its tangential block. A step by
1/lambda_max and not by the inverse of the block: only so is the friction of a slide opposite to
its velocity.
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
    CA,
    CB,
    CHANGE,
    DA,
    DB,
    GAIN,
    GAP,
    GAP0,
    HA,
    HB,
    JN,
    JO,
    JT,
    KEEP,
    MA,
    MB,
    MOST,
    MU,
    PS,
    PUSHED,
    RATE,
    SA,
    SB,
    SCALE,
    SLIP_GAIN,
    SUM,
    UA,
    UB,
    VA,
    VB,
    WA,
    WB,
    A,
    B,
    N,
    O,
    T,
)
from rigid_body_sim.physics.contact.touching_bodies import (
    CARRIED,
    II,
    IM,
    D,
    L,
    P,
)
from rigid_body_sim.physics.kernels import inline, kernel

Array = NDArray[np.float64]


@kernel
def gather(lanes: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch the velocities of the bodies of a batch."""
    for k in range(lanes):
        for side in range(2):
            o = int(s[k + B]) if side == 1 else int(s[k + A])
            to = k + VB if side == 1 else k
            m = bodies[o + IM]
            g[to] = bodies[o + P] * m
            g[to + 8] = bodies[o + P + 1] * m
            g[to + 16] = bodies[o + P + 2] * m
            x, y, z = bodies[o + L], bodies[o + L + 1], bodies[o + L + 2]
            xx, xy, xz = bodies[o + II], bodies[o + II + 1], bodies[o + II + 2]
            yy, yz, zz = bodies[o + II + 3], bodies[o + II + 4], bodies[o + II + 5]
            g[to + 24] = xx * x + xy * y + xz * z
            g[to + 32] = xy * x + yy * y + yz * z
            g[to + 40] = xz * x + yz * y + zz * z
            g[to + 48] = m
            g[to + 56] = xx
            g[to + 64] = xy
            g[to + 72] = xz
            g[to + 80] = yy
            g[to + 88] = yz
            g[to + 96] = zz
        for row in range(9):
            g[k + PS + 8 * row] = 0.0
        g[k + PUSHED] = 0.0
        g[k + CHANGE] = 0.0


@kernel
def gather_motion(lanes: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch how the bodies of a batch have moved since the start of the tick."""
    for k in range(lanes):
        a, b = int(s[k + A]) + D, int(s[k + B]) + D
        for row in range(8):
            g[k + DA + 8 * row] = bodies[a + row]
            g[k + DB + 8 * row] = bodies[b + row]


@kernel
def scatter(lanes: int, s: Array, g: Array, bodies: Array) -> None:
    """Give the bodies of a batch the impulses of a pass."""
    for k in range(lanes):
        a, b = int(s[k + A]), int(s[k + B])
        for axis in range(3):
            row = k + 8 * axis
            bodies[a + P + axis] -= g[row + PS]
            bodies[b + P + axis] += g[row + PS]
            bodies[a + L + axis] -= g[row + HA]
            bodies[b + L + axis] += g[row + HB]


@kernel
def mark_carried(lanes: int, s: Array, g: Array, bodies: Array) -> None:
    """Mark the bodies that some point of a batch pushes."""
    for k in range(lanes):
        if g[k + PUSHED] > 0.0:
            bodies[int(s[k + A]) + CARRIED] = 1.0
            bodies[int(s[k + B]) + CARRIED] = 1.0


@inline
def _shift(ux, uy, uz, w, c, x, y, z):
    """Motion of a point at arm (x, y, z) by the turn of its body: w t + c u x t, t = 2 u x r."""
    tx, ty, tz = cross(ux, uy, uz, x, y, z)
    tx, ty, tz = 2.0 * tx, 2.0 * ty, 2.0 * tz
    sx, sy, sz = cross(ux, uy, uz, tx, ty, tz)
    return w * tx + c * sx, w * ty + c * sy, w * tz + c * sz


@kernel
def gaps(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Find the gap of a point of each lane from the motion of the bodies."""
    for k in range(lanes):
        ax, ay, az, bx, by, bz = arms(q, k)
        ux, uy, uz = vector(g, k + UA)
        ax, ay, az = _shift(ux, uy, uz, g[k + SA], g[k + CA], ax, ay, az)
        ux, uy, uz = vector(g, k + UB)
        bx, by, bz = _shift(ux, uy, uz, g[k + SB], g[k + CB], bx, by, bz)
        dx = (g[k + DB] - g[k + DA]) + (bx - ax)
        dy = (g[k + DB + 8] - g[k + DA + 8]) + (by - ay)
        dz = (g[k + DB + 16] - g[k + DA + 16]) + (bz - az)
        q[k + GAP] = q[k + GAP0] + (s[k + N] * dx + s[k + N + 8] * dy + s[k + N + 16] * dz)


@kernel
def push(
    lanes: int, s: Array, q: Array, g: Array, inverse_h: float, slop: float, cap: float
) -> None:
    """Visit the normals of one point of each lane, soft where the surfaces overlap."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + O)
        ax, ay, az, bx, by, bz = arms(q, k)
        ux, uy, uz = vector(g, k + VA)
        fx, fy, fz = vector(g, k + WA)
        vx, vy, vz = vector(g, k + VB)
        wx, wy, wz = vector(g, k + WB)
        ma, a1, a2, a3, a4, a5, a6 = inertia(g, k + MA)
        mb, b1, b2, b3, b4, b5, b6 = inertia(g, k + MB)
        x, y, z = relative(ux, uy, uz, fx, fy, fz, ax, ay, az, vx, vy, vz, wx, wy, wz, bx, by, bz)
        vn = nx * x + ny * y + nz * z
        gap = q[k + GAP]
        old = q[k + JN]
        old_t, old_o = q[k + JT], q[k + JO]
        most = q[k + MOST]
        pushed = g[k + PUSHED]
        is_open = gap > 0.0
        depth = gap + slop
        depth = depth if depth < 0.0 else 0.0
        soft = s[k + RATE] * depth
        soft = soft if soft > -cap else -cap
        bias = gap * inverse_h if is_open else soft
        scale = 1.0 if is_open else s[k + SCALE]
        keep = 0.0 if is_open else s[k + KEEP]
        new = old - q[k + GAIN] * scale * (vn + bias) - keep * old
        presses = new > 0.0
        new = new if presses else 0.0
        change = new - old
        # friction of the last substep is none of this one where less presses: it keeps its share
        less = new < old
        share = new / (old if less else 1.0) if less else 1.0
        t = share * old_t
        o = share * old_o
        dt, do = t - old_t, o - old_o
        x = change * nx + (dt * tx + do * ox)
        y = change * ny + (dt * ty + do * oy)
        z = change * nz + (dt * tz + do * oz)
        ax, ay, az = cross(ax, ay, az, x, y, z)
        bx, by, bz = cross(bx, by, bz, x, y, z)
        cx, cy, cz = times(a1, a2, a3, a4, a5, a6, ax, ay, az)
        dx, dy, dz = times(b1, b2, b3, b4, b5, b6, bx, by, bz)
        px, py, pz = vector(g, k + PS)
        hx, hy, hz = vector(g, k + HA)
        lx, ly, lz = vector(g, k + HB)
        q[k + JN] = new
        q[k + JT] = t
        q[k + JO] = o
        q[k + MOST] = new if new > most else most
        g[k + PUSHED] = 1.0 if presses else pushed
        g[k + VA], g[k + VA + 8], g[k + VA + 16] = ux - ma * x, uy - ma * y, uz - ma * z
        g[k + WA], g[k + WA + 8], g[k + WA + 16] = fx - cx, fy - cy, fz - cz
        g[k + VB], g[k + VB + 8], g[k + VB + 16] = vx + mb * x, vy + mb * y, vz + mb * z
        g[k + WB], g[k + WB + 8], g[k + WB + 16] = wx + dx, wy + dy, wz + dz
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + HA], g[k + HA + 8], g[k + HA + 16] = hx + ax, hy + ay, hz + az
        g[k + HB], g[k + HB + 8], g[k + HB + 16] = lx + bx, ly + by, lz + bz


@kernel
def relax(lanes: int, s: Array, q: Array, g: Array, inverse_h: float, share: float) -> None:
    """
    Visit normal and friction of one point of each lane, without push-out.

    share : 1 in the last visit of a substep, which counts into the sums over the tick; else 0
    """
    for k in range(lanes):
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + O)
        ax, ay, az, bx, by, bz = arms(q, k)
        ux, uy, uz = vector(g, k + VA)
        fx, fy, fz = vector(g, k + WA)
        vx, vy, vz = vector(g, k + VB)
        wx, wy, wz = vector(g, k + WB)
        ma, a1, a2, a3, a4, a5, a6 = inertia(g, k + MA)
        mb, b1, b2, b3, b4, b5, b6 = inertia(g, k + MB)
        x, y, z = relative(ux, uy, uz, fx, fy, fz, ax, ay, az, vx, vy, vz, wx, wy, wz, bx, by, bz)
        vn = nx * x + ny * y + nz * z
        gap = q[k + GAP]
        old = q[k + JN]
        old_t, old_o = q[k + JT], q[k + JO]
        most = q[k + MOST]
        gain = q[k + SLIP_GAIN]
        bias = gap * inverse_h if gap > 0.0 else 0.0
        new = old - q[k + GAIN] * (vn + bias)
        new = new if new > 0.0 else 0.0
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
        ex, ey, ez = vector(q, k + SUM)
        q[k + JN] = new
        q[k + JT] = t
        q[k + JO] = o
        q[k + MOST] = new if new > most else most
        q[k + SUM], q[k + SUM + 8], q[k + SUM + 16] = (
            ex + share * new,
            ey + share * t,
            ez + share * o,
        )
        g[k + VA], g[k + VA + 8], g[k + VA + 16] = ux, uy, uz
        g[k + WA], g[k + WA + 8], g[k + WA + 16] = fx - cx, fy - cy, fz - cz
        g[k + VB], g[k + VB + 8], g[k + VB + 16] = vx, vy, vz
        g[k + WB], g[k + WB + 8], g[k + WB + 16] = wx + dx, wy + dy, wz + dz
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + HA], g[k + HA + 8], g[k + HA + 16] = hx + ax, hy + ay, hz + az
        g[k + HB], g[k + HB + 8], g[k + HB + 16] = lx + bx, ly + by, lz + bz
