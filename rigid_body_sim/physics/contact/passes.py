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

from rigid_body_sim.physics.contact.lanes import arms, cross, disc, relative, vector
from rigid_body_sim.physics.contact.rows import (
    BOUNCE,
    CA,
    CB,
    CHANGE,
    COUPLE_O,
    COUPLE_T,
    DA,
    DB,
    GAIN,
    GAP,
    GAP0,
    IA,
    IB,
    JN,
    JO,
    JT,
    KEEP,
    LA,
    LB,
    MASS_A,
    MASS_B,
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
    T2,
    UA,
    UB,
    A,
    B,
    N,
    T,
    V,
)
from rigid_body_sim.physics.contact.touching_bodies import CARRIED, II, IM, D, L, P
from rigid_body_sim.physics.kernels import inline, kernel

Array = NDArray[np.float64]


@kernel
def gather_inertia(used: int, s: Array, bodies: Array) -> None:
    """Fetch the inverse masses and inertias of the bodies of a batch."""
    for k in range(used):
        a, b = int(s[k + A]), int(s[k + B])
        s[k + MASS_A] = bodies[a + IM]
        s[k + MASS_B] = bodies[b + IM]
        for entry in range(6):
            s[k + IA + 8 * entry] = bodies[a + II + entry]
            s[k + IB + 8 * entry] = bodies[b + II + entry]


@kernel
def gather(lanes: int, used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch the momenta of the bodies of a batch; what empty lanes hold does not matter."""
    for k in range(lanes):
        g[k + PS] = 0.0
        g[k + PS + 8] = 0.0
        g[k + PS + 16] = 0.0
        g[k + PUSHED] = 0.0
        g[k + CHANGE] = 0.0
    for k in range(used):
        a, b = int(s[k + A]), int(s[k + B])
        m, n = s[k + MASS_A], s[k + MASS_B]
        for axis in range(3):
            row = k + 8 * axis
            g[row + V] = n * bodies[b + P + axis] - m * bodies[a + P + axis]
            g[row + LA] = bodies[a + L + axis]
            g[row + LB] = bodies[b + L + axis]


@kernel
def gather_motion(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch how the bodies of a batch have moved since the start of the tick."""
    for k in range(used):
        a, b = int(s[k + A]) + D, int(s[k + B]) + D
        for row in range(8):
            g[k + DA + 8 * row] = bodies[a + row]
            g[k + DB + 8 * row] = bodies[b + row]


@kernel
def scatter(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Give the bodies of a batch what a pass has changed."""
    for k in range(used):
        a, b = int(s[k + A]), int(s[k + B])
        for axis in range(3):
            row = k + 8 * axis
            bodies[a + P + axis] -= g[row + PS]
            bodies[b + P + axis] += g[row + PS]
            bodies[a + L + axis] = g[row + LA]
            bodies[b + L + axis] = g[row + LB]


@kernel
def mark_carried(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Mark the bodies that some point of a batch pushes."""
    for k in range(used):
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
        ox, oy, oz = vector(s, k + T2)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = relative(s, g, k, ax, ay, az, bx, by, bz)
        vn = nx * x + ny * y + nz * z
        gap = q[k + GAP]
        old, old_t, old_o = q[k + JN], q[k + JT], q[k + JO]
        most = q[k + MOST]
        sx, sy, sz = vector(q, k + SUM)
        px, py, pz = vector(g, k + PS)
        hx, hy, hz = vector(g, k + LA)
        lx, ly, lz = vector(g, k + LB)
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
        q[k + JN], q[k + JT], q[k + JO] = new, t, o
        q[k + MOST] = old if old > most else most
        q[k + SUM], q[k + SUM + 8], q[k + SUM + 16] = sx + old, sy + old_t, sz + old_o
        g[k + PUSHED] = 1.0 if presses else pushed
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + LA], g[k + LA + 8], g[k + LA + 16] = hx - ax, hy - ay, hz - az
        g[k + LB], g[k + LB + 8], g[k + LB + 16] = lx + bx, ly + by, lz + bz


@kernel
def relax_normals(lanes: int, s: Array, q: Array, g: Array, inverse_h: float) -> None:
    """Visit the normal of one point of each lane, without push-out."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + N)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = relative(s, g, k, ax, ay, az, bx, by, bz)
        gap = q[k + GAP]
        old = q[k + JN]
        px, py, pz = vector(g, k + PS)
        hx, hy, hz = vector(g, k + LA)
        lx, ly, lz = vector(g, k + LB)
        is_open = gap > 0.0
        bias = gap * inverse_h if is_open else 0.0
        new = old - q[k + GAIN] * ((nx * x + ny * y + nz * z) + bias)
        new = new if new > 0.0 else 0.0
        # what touches in the next substep bounces there: at the end of a tick here is too early
        waits = is_open & (s[k + BOUNCE] > 0.0) & (old <= 0.0)
        new = 0.0 if waits else new
        change = new - old
        x, y, z = change * nx, change * ny, change * nz
        ax, ay, az = cross(ax, ay, az, x, y, z)
        bx, by, bz = cross(bx, by, bz, x, y, z)
        q[k + JN] = new
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + LA], g[k + LA + 8], g[k + LA + 16] = hx - ax, hy - ay, hz - az
        g[k + LB], g[k + LB + 8], g[k + LB + 16] = lx + bx, ly + by, lz + bz


@kernel
def relax(lanes: int, s: Array, q: Array, g: Array, inverse_h: float) -> None:
    """
    Visit normal and friction of one point of each lane, without push-out.

    Friction sees the tangential velocity that the new normal impulse leaves.
    """
    for k in range(lanes):
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = relative(s, g, k, ax, ay, az, bx, by, bz)
        gap = q[k + GAP]
        old, old_t, old_o = q[k + JN], q[k + JT], q[k + JO]
        gain = q[k + SLIP_GAIN]
        px, py, pz = vector(g, k + PS)
        hx, hy, hz = vector(g, k + LA)
        lx, ly, lz = vector(g, k + LB)
        is_open = gap > 0.0
        bias = gap * inverse_h if is_open else 0.0
        new = old - q[k + GAIN] * ((nx * x + ny * y + nz * z) + bias)
        new = new if new > 0.0 else 0.0
        # as in `relax_normals`
        waits = is_open & (s[k + BOUNCE] > 0.0) & (old <= 0.0)
        new = 0.0 if waits else new
        change = new - old
        t = old_t - gain * ((tx * x + ty * y + tz * z) + q[k + COUPLE_T] * change)
        o = old_o - gain * ((ox * x + oy * y + oz * z) + q[k + COUPLE_O] * change)
        t, o = disc(t, o, s[k + MU] * new)
        dt, do = t - old_t, o - old_o
        x = change * nx + (dt * tx + do * ox)
        y = change * ny + (dt * ty + do * oy)
        z = change * nz + (dt * tz + do * oz)
        ax, ay, az = cross(ax, ay, az, x, y, z)
        bx, by, bz = cross(bx, by, bz, x, y, z)
        q[k + JN], q[k + JT], q[k + JO] = new, t, o
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + LA], g[k + LA + 8], g[k + LA + 16] = hx - ax, hy - ay, hz - az
        g[k + LB], g[k + LB + 8], g[k + LB + 16] = lx + bx, ly + by, lz + bz
