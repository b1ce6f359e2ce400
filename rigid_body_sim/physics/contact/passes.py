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
    twist:    J_s <- J_s - g_s omega_n,      |J_s| <= spin J_n
    rolling:  J_r <- J_r - g_r omega_t,      |J_r| <= roll J_n

m = 1/(n-entry of J M^-1 J^T); lambda_max largest eigenvalue of its tangential block. A step by
1/lambda_max and not by the inverse of the block: only so is the friction of a slide opposite to
its velocity.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.rows import (
    APPROACH,
    BN,
    BO,
    BOUNCE,
    BT,
    CHANGE,
    DA,
    DB,
    GAIN,
    GAP,
    GAP0,
    HA,
    HB,
    IA,
    IB,
    JN,
    JO,
    JQ,
    JR,
    JS,
    JT,
    KEEP,
    MA,
    MB,
    MOST,
    MU,
    PS,
    PUSHED,
    RA,
    RATE,
    RB,
    ROLL,
    ROLL_GAIN,
    SCALE,
    SLIP_GAIN,
    SPIN,
    SPIN_GAIN,
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
def _relative(g: Array, s: Array, p: int, k: int) -> Any:
    """Velocity of B relative to A at a point [m/s]."""
    ax, ay, az = s[p + RA + k], s[p + RA + 8 + k], s[p + RA + 16 + k]
    bx, by, bz = s[p + RB + k], s[p + RB + 8 + k], s[p + RB + 16 + k]
    ux, uy, uz = g[k + WA], g[k + WA + 8], g[k + WA + 16]
    vx, vy, vz = g[k + WB], g[k + WB + 8], g[k + WB + 16]
    return (
        (g[k + VB] - g[k + VA]) + ((vy * bz - vz * by) - (uy * az - uz * ay)),
        (g[k + VB + 8] - g[k + VA + 8]) + ((vz * bx - vx * bz) - (uz * ax - ux * az)),
        (g[k + VB + 16] - g[k + VA + 16]) + ((vx * by - vy * bx) - (ux * ay - uy * ax)),
    )


@inline
def _twist(
    g: Array, k: int, ax: float, ay: float, az: float, bx: float, by: float, bz: float
) -> None:
    """Give A the angular impulse -a and B the angular impulse b [N m s]."""
    g[k + HA] += ax
    g[k + HA + 8] += ay
    g[k + HA + 16] += az
    g[k + HB] += bx
    g[k + HB + 8] += by
    g[k + HB + 16] += bz
    g[k + WA] -= g[k + IA] * ax + g[k + IA + 8] * ay + g[k + IA + 16] * az
    g[k + WA + 8] -= g[k + IA + 8] * ax + g[k + IA + 24] * ay + g[k + IA + 32] * az
    g[k + WA + 16] -= g[k + IA + 16] * ax + g[k + IA + 32] * ay + g[k + IA + 40] * az
    g[k + WB] += g[k + IB] * bx + g[k + IB + 8] * by + g[k + IB + 16] * bz
    g[k + WB + 8] += g[k + IB + 8] * bx + g[k + IB + 24] * by + g[k + IB + 32] * bz
    g[k + WB + 16] += g[k + IB + 16] * bx + g[k + IB + 32] * by + g[k + IB + 40] * bz


@inline
def _strike(g: Array, s: Array, p: int, k: int, x: float, y: float, z: float) -> None:
    """Give B the impulse (x, y, z) at a point, and A its opposite [N s]."""
    g[k + PS] += x
    g[k + PS + 8] += y
    g[k + PS + 16] += z
    a, b = g[k + MA], g[k + MB]
    g[k + VA] -= a * x
    g[k + VA + 8] -= a * y
    g[k + VA + 16] -= a * z
    g[k + VB] += b * x
    g[k + VB + 8] += b * y
    g[k + VB + 16] += b * z
    ax, ay, az = s[p + RA + k], s[p + RA + 8 + k], s[p + RA + 16 + k]
    bx, by, bz = s[p + RB + k], s[p + RB + 8 + k], s[p + RB + 16 + k]
    _twist(
        g, k,
        ay * z - az * y, az * x - ax * z, ax * y - ay * x,
        by * z - bz * y, bz * x - bx * z, bx * y - by * x,
    )  # fmt: skip


@inline
def _shift(g: Array, u: int, k: int, x: float, y: float, z: float) -> Any:
    """Motion of a point at arm (x, y, z) by the turn of its body: w t + c u x t, t = 2 u x r."""
    ux, uy, uz = g[u + k], g[u + 8 + k], g[u + 16 + k]
    w, c = g[u + 24 + k], g[u + 32 + k]
    tx, ty, tz = 2.0 * (uy * z - uz * y), 2.0 * (uz * x - ux * z), 2.0 * (ux * y - uy * x)
    return (
        w * tx + c * (uy * tz - uz * ty),
        w * ty + c * (uz * tx - ux * tz),
        w * tz + c * (ux * ty - uy * tx),
    )


@kernel
def gaps(lanes: int, s: Array, p: int, g: Array) -> None:
    """Find the gap of a point of each lane from the motion of the bodies."""
    for k in range(lanes):
        ax, ay, az = _shift(g, UA, k, s[p + RA + k], s[p + RA + 8 + k], s[p + RA + 16 + k])
        bx, by, bz = _shift(g, UB, k, s[p + RB + k], s[p + RB + 8 + k], s[p + RB + 16 + k])
        dx = (g[k + DB] - g[k + DA]) + (bx - ax)
        dy = (g[k + DB + 8] - g[k + DA + 8]) + (by - ay)
        dz = (g[k + DB + 16] - g[k + DA + 16]) + (bz - az)
        s[p + GAP + k] = s[p + GAP0 + k] + (s[k + N] * dx + s[k + N + 8] * dy + s[k + N + 16] * dz)


@kernel
def push(
    lanes: int, s: Array, p: int, g: Array, inverse_h: float, slop: float, cap: float
) -> None:
    """Visit the normals of one point of each lane, soft where the surfaces overlap."""
    for k in range(lanes):
        nx, ny, nz = s[k + N], s[k + N + 8], s[k + N + 16]
        x, y, z = _relative(g, s, p, k)
        vn = nx * x + ny * y + nz * z
        gap = s[p + GAP + k]
        old = s[p + JN + k]
        is_open = gap > 0.0
        depth = gap + slop
        depth = depth if depth < 0.0 else 0.0
        soft = s[k + RATE] * depth
        soft = soft if soft > -cap else -cap
        bias = gap * inverse_h if is_open else soft
        scale = 1.0 if is_open else s[k + SCALE]
        keep = 0.0 if is_open else s[k + KEEP]
        new = old - s[p + GAIN + k] * scale * (vn + bias) - keep * old
        new = new if new > 0.0 else 0.0
        s[p + JN + k] = new
        most = s[p + MOST + k]
        s[p + MOST + k] = new if new > most else most
        g[k + PUSHED] = 1.0 if new > 0.0 else g[k + PUSHED]
        change = new - old
        # where nothing presses there is no friction either
        t = s[p + JT + k] if new > 0.0 else 0.0
        o = s[p + JO + k] if new > 0.0 else 0.0
        dt, do = t - s[p + JT + k], o - s[p + JO + k]
        s[p + JT + k] = t
        s[p + JO + k] = o
        _strike(
            g, s, p, k,
            change * nx + (dt * s[k + T] + do * s[k + O]),
            change * ny + (dt * s[k + T + 8] + do * s[k + O + 8]),
            change * nz + (dt * s[k + T + 16] + do * s[k + O + 16]),
        )  # fmt: skip


@kernel
def relax(lanes: int, s: Array, p: int, g: Array, inverse_h: float, share: float) -> None:
    """
    Visit normal and friction of one point of each lane, without push-out.

    share : 1 in the last visit of a substep, which counts into the sums over the tick; else 0
    """
    for k in range(lanes):
        nx, ny, nz = s[k + N], s[k + N + 8], s[k + N + 16]
        x, y, z = _relative(g, s, p, k)
        vn = nx * x + ny * y + nz * z
        gap = s[p + GAP + k]
        bias = gap * inverse_h if gap > 0.0 else 0.0
        old = s[p + JN + k]
        new = old - s[p + GAIN + k] * (vn + bias)
        new = new if new > 0.0 else 0.0
        s[p + JN + k] = new
        most = s[p + MOST + k]
        s[p + MOST + k] = new if new > most else most
        change = new - old
        _strike(g, s, p, k, change * nx, change * ny, change * nz)
        x, y, z = _relative(g, s, p, k)
        tx, ty, tz = s[k + T], s[k + T + 8], s[k + T + 16]
        ox, oy, oz = s[k + O], s[k + O + 8], s[k + O + 16]
        gain = s[p + SLIP_GAIN + k]
        old_t, old_o = s[p + JT + k], s[p + JO + k]
        t = old_t - gain * (tx * x + ty * y + tz * z)
        o = old_o - gain * (ox * x + oy * y + oz * z)
        limit = s[k + MU] * new
        size = t * t + o * o
        over = size > limit * limit
        factor = limit / math.sqrt(size if over else 1.0) if over else 1.0
        t *= factor
        o *= factor
        s[p + JT + k] = t
        s[p + JO + k] = o
        dt, do = t - old_t, o - old_o
        _strike(g, s, p, k, dt * tx + do * ox, dt * ty + do * oy, dt * tz + do * oz)
        s[p + SUM + k] += share * new
        s[p + SUM + 8 + k] += share * t
        s[p + SUM + 16 + k] += share * o


@kernel
def resist(lanes: int, s: Array, p: int, g: Array) -> None:
    """Visit rolling and torsional friction of one point of each lane."""
    for k in range(lanes):
        nx, ny, nz = s[k + N], s[k + N + 8], s[k + N + 16]
        tx, ty, tz = s[k + T], s[k + T + 8], s[k + T + 16]
        ox, oy, oz = s[k + O], s[k + O + 8], s[k + O + 16]
        x, y, z = (
            g[k + WB] - g[k + WA],
            g[k + WB + 8] - g[k + WA + 8],
            g[k + WB + 16] - g[k + WA + 16],
        )
        push = s[p + JN + k]
        old_r, old_q, old_s = s[p + JR + k], s[p + JQ + k], s[p + JS + k]
        r = old_r - s[k + ROLL_GAIN] * (tx * x + ty * y + tz * z)
        q = old_q - s[k + ROLL_GAIN] * (ox * x + oy * y + oz * z)
        limit = s[k + ROLL] * push
        size = r * r + q * q
        over = size > limit * limit
        factor = limit / math.sqrt(size if over else 1.0) if over else 1.0
        r *= factor
        q *= factor
        limit = s[k + SPIN] * push
        turn = old_s - s[k + SPIN_GAIN] * (nx * x + ny * y + nz * z)
        turn = turn if turn < limit else limit
        turn = turn if turn > -limit else -limit
        s[p + JR + k] = r
        s[p + JQ + k] = q
        s[p + JS + k] = turn
        dr, dq, ds = r - old_r, q - old_q, turn - old_s
        x = dr * tx + dq * ox + ds * nx
        y = dr * ty + dq * oy + ds * ny
        z = dr * tz + dq * oz + ds * nz
        _twist(g, k, x, y, z, x, y, z)


@kernel
def release(lanes: int, s: Array, p: int, g: Array) -> None:
    """Drop the angular impulses of points that do not press any more."""
    for k in range(lanes):
        presses = s[p + JN + k] > 0.0
        r = 0.0 if presses else -s[p + JR + k]
        q = 0.0 if presses else -s[p + JQ + k]
        turn = 0.0 if presses else -s[p + JS + k]
        s[p + JR + k] += r
        s[p + JQ + k] += q
        s[p + JS + k] += turn
        x = r * s[k + T] + q * s[k + O] + turn * s[k + N]
        y = r * s[k + T + 8] + q * s[k + O + 8] + turn * s[k + N + 8]
        z = r * s[k + T + 16] + q * s[k + O + 16] + turn * s[k + N + 16]
        _twist(g, k, x, y, z, x, y, z)


@kernel
def bounce(lanes: int, s: Array, p: int, g: Array, threshold: float) -> None:
    """
    Visit one point of each lane after the last substep: v_n <- -e v_approach where it bounces,
    v_n >= 0 elsewhere; friction on the impulse of the bounce.
    """
    for k in range(lanes):
        nx, ny, nz = s[k + N], s[k + N + 8], s[k + N + 16]
        x, y, z = _relative(g, s, p, k)
        vn = nx * x + ny * y + nz * z
        approach = s[p + APPROACH + k]
        touched = s[p + MOST + k] > 0.0
        bounces = (s[k + BOUNCE] > 0.0) & (approach < -threshold)
        aim = -s[k + BOUNCE] * approach if bounces else 0.0
        old = s[p + BN + k]
        new = old - s[p + GAIN + k] * (vn - aim)
        new = new if new > 0.0 else 0.0
        new = new if touched else 0.0
        s[p + BN + k] = new
        change = new - old
        size = abs(change)
        g[k + CHANGE] = size if size > g[k + CHANGE] else g[k + CHANGE]
        _strike(g, s, p, k, change * nx, change * ny, change * nz)
        x, y, z = _relative(g, s, p, k)
        tx, ty, tz = s[k + T], s[k + T + 8], s[k + T + 16]
        ox, oy, oz = s[k + O], s[k + O + 8], s[k + O + 16]
        gain = s[p + SLIP_GAIN + k]
        old_t, old_o = s[p + BT + k], s[p + BO + k]
        t = old_t - gain * (tx * x + ty * y + tz * z)
        o = old_o - gain * (ox * x + oy * y + oz * z)
        limit = s[k + MU] * new
        size = t * t + o * o
        over = size > limit * limit
        factor = limit / math.sqrt(size if over else 1.0) if over else 1.0
        t *= factor
        o *= factor
        s[p + BT + k] = t
        s[p + BO + k] = o
        dt, do = t - old_t, o - old_o
        _strike(g, s, p, k, dt * tx + do * ox, dt * ty + do * oy, dt * tz + do * oz)
