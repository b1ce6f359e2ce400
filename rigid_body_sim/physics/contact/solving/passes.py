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

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.solving.lanes import arms, cross, disc, relative, vector
from rigid_body_sim.physics.contact.solving.rows import (
    ACTIVE,
    APPROACH,
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
    MU,
    PS,
    PUSHED,
    RA,
    RATE,
    RB,
    ROUND_PAIR,
    SA,
    SB,
    SCALE,
    SLIP_GAIN,
    T2,
    UA,
    UB,
    WEIGHT,
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
        g[k + ACTIVE] = 1.0
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
    """Fetch how the bodies of a batch have moved over the substep."""
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
def follow(lanes: int, s: Array, q: Array, g: Array) -> None:
    """
    Find gap and arms of a point of each lane after the motion over a substep.

    The point moves as the surface of A, of B, or in the middle (`WEIGHT`), and both arms end in
    it: impulses at it keep the angular momentum of the two to the last digits. What bounces off
    something that cannot move keeps its arms: it bounces at the end of the tick by the law of the
    place where it hit.
    """
    for k in range(lanes):
        ax, ay, az, bx, by, bz = arms(q, k)
        fixed = (s[k + MASS_A] == 0.0) | (s[k + MASS_B] == 0.0)
        stays = fixed & (s[k + BOUNCE] > 0.0) & (q[k + APPROACH] < 0.0)
        f = 0.0 if stays else 1.0
        c = g[k + CA]
        ux, uy, uz = vector(g, k + UA)
        ux, uy, uz = _shift(ux, uy, uz, g[k + SA], c, ax, ay, az)
        d = g[k + CB]
        vx, vy, vz = vector(g, k + UB)
        vx, vy, vz = _shift(vx, vy, vz, g[k + SB], d, bx, by, bz)
        x, y, z = (
            g[k + DB] - g[k + DA],
            g[k + DB + 8] - g[k + DA + 8],
            g[k + DB + 16] - g[k + DA + 16],
        )
        nx, ny, nz = vector(s, k + N)
        q[k + GAP] += nx * (x + (vx - ux)) + ny * (y + (vy - uy)) + nz * (z + (vz - uz))
        # the nearest point of a ball does not turn with it
        ux, uy, uz = c * ux, c * uy, c * uz
        vx, vy, vz = d * vx, d * vy, d * vz
        x, y, z = x + (vx - ux), y + (vy - uy), z + (vz - uz)
        w = s[k + WEIGHT]
        q[k + RA] = ax + f * (ux + w * x)
        q[k + RA + 8] = ay + f * (uy + w * y)
        q[k + RA + 16] = az + f * (uz + w * z)
        w = 1.0 - w
        q[k + RB] = bx + f * (vx - w * x)
        q[k + RB + 8] = by + f * (vy - w * y)
        q[k + RB + 16] = bz + f * (vz - w * z)


@kernel
def gather_way(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch how far the bodies of a batch have moved over the substep."""
    for k in range(used):
        a, b = int(s[k + A]) + D, int(s[k + B]) + D
        for axis in range(3):
            g[k + DA + 8 * axis] = bodies[b + axis] - bodies[a + axis]


@kernel
def follow_balls(lanes: int, s: Array, q: Array, g: Array) -> None:
    """
    Do what `follow` does where a ball meets a ball, or what cannot move.

    Between two balls the normal turns into their line of centres, and the gap is not linearised:

        d = x_B - x_A = r_A - r_B,  n' = d / |d|,  s' = s + |d'| - |d|
        t' = t - (n' . t)/(1 + n . n') (n + n'), the smallest turn that takes n to n'
    """
    for k in range(lanes):
        ax, ay, az, bx, by, bz = arms(q, k)
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        vx, vy, vz = vector(g, k + DA)
        gap = q[k + GAP]
        w = s[k + WEIGHT]
        x, y, z = ax - bx + vx, ay - by + vy, az - bz + vz
        square = x * x + y * y + z * z
        balls = (s[k + ROUND_PAIR] > 1.0) & (square > 0.0)
        now = math.sqrt(square if balls else 1.0)
        before = nx * (ax - bx) + ny * (ay - by) + nz * (az - bz)
        closer = now - before if balls else nx * vx + ny * vy + nz * vz
        ux = x / now if balls else nx
        uy = y / now if balls else ny
        uz = z / now if balls else nz
        arm = (nx * ax + ny * ay + nz * az) + w * closer
        ax = arm * ux if balls else ax + w * vx
        ay = arm * uy if balls else ay + w * vy
        az = arm * uz if balls else az + w * vz
        q[k + GAP] = gap + closer
        q[k + RA], q[k + RA + 8], q[k + RA + 16] = ax, ay, az
        q[k + RB], q[k + RB + 8], q[k + RB + 16] = ax - x, ay - y, az - z
        s[k + N], s[k + N + 8], s[k + N + 16] = ux, uy, uz
        share = 1.0 / (1.0 + (nx * ux + ny * uy + nz * uz))
        nx, ny, nz = nx + ux, ny + uy, nz + uz
        turn = share * (tx * ux + ty * uy + tz * uz)
        s[k + T], s[k + T + 8], s[k + T + 16] = tx - turn * nx, ty - turn * ny, tz - turn * nz
        turn = share * (ox * ux + oy * uy + oz * uz)
        s[k + T2], s[k + T2 + 8], s[k + T2 + 16] = ox - turn * nx, oy - turn * ny, oz - turn * nz


@kernel
def push(
    lanes: int,
    s: Array,
    q: Array,
    g: Array,
    inverse_h: float,
    slop: float,
    cap: float,
    calm: float,
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
        gain, largest = q[k + GAIN], g[k + CHANGE]
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
        new = old - gain * scale * (vn + bias) - keep * old
        new = new if new > 0.0 else 0.0
        new = new if g[k + ACTIVE] > 0.0 else old
        presses = new > 0.0
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
        size = abs(change) - calm * gain
        g[k + CHANGE] = size if size > largest else largest
        g[k + PUSHED] = 1.0 if presses else pushed
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + LA], g[k + LA + 8], g[k + LA + 16] = hx - ax, hy - ay, hz - az
        g[k + LB], g[k + LB + 8], g[k + LB + 16] = lx + bx, ly + by, lz + bz


@kernel
def relax(lanes: int, s: Array, q: Array, g: Array, inverse_h: float, calm: float) -> None:
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
        gain, slip_gain, largest = q[k + GAIN], q[k + SLIP_GAIN], g[k + CHANGE]
        px, py, pz = vector(g, k + PS)
        hx, hy, hz = vector(g, k + LA)
        lx, ly, lz = vector(g, k + LB)
        is_open = gap > 0.0
        bias = gap * inverse_h if is_open else 0.0
        new = old - gain * ((nx * x + ny * y + nz * z) + bias)
        new = new if new > 0.0 else 0.0
        # what touches in the next substep bounces there: at the end of a tick here is too early
        waits = is_open & (s[k + BOUNCE] > 0.0) & (old <= 0.0)
        new = 0.0 if waits else new
        active = g[k + ACTIVE] > 0.0
        new = new if active else old
        change = new - old
        t = old_t - slip_gain * ((tx * x + ty * y + tz * z) + q[k + COUPLE_T] * change)
        o = old_o - slip_gain * ((ox * x + oy * y + oz * z) + q[k + COUPLE_O] * change)
        t, o = disc(t, o, s[k + MU] * new)
        t, o = (t, o) if active else (old_t, old_o)
        dt, do = t - old_t, o - old_o
        x = change * nx + (dt * tx + do * ox)
        y = change * ny + (dt * ty + do * oy)
        z = change * nz + (dt * tz + do * oz)
        ax, ay, az = cross(ax, ay, az, x, y, z)
        bx, by, bz = cross(bx, by, bz, x, y, z)
        size = abs(change) - calm * gain
        g[k + CHANGE] = size if size > largest else largest
        q[k + JN], q[k + JT], q[k + JO] = new, t, o
        g[k + PS], g[k + PS + 8], g[k + PS + 16] = px + x, py + y, pz + z
        g[k + LA], g[k + LA + 8], g[k + LA + 16] = hx - ax, hy - ay, hz - az
        g[k + LB], g[k + LB + 8], g[k + LB + 16] = lx + bx, ly + by, lz + bz
