# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One visit to one batch of contacts: the equations of a contact point, lane by lane.

With relative velocity at the point v = v_B + omega_B x r_B - v_A - omega_A x r_A, v_n = n . v,
gap s, substep h, omega_c = 2 pi f, a1 = 2 zeta + h omega_c, a2 = h omega_c a1, a3 = 1/(1 + a2),
beta = omega_c / a1, sigma = a2 a3, iota = a3:

    pushed:   s > 0: dJ = -m (v_n + s/h)
              s <= 0: dJ = -m sigma (v_n + max(beta (s + slop), -cap)) - iota J
              J_n - J_load/2 >= 0: the other half of the load is still to come
    relaxed:  dJ = -m (v_n + max(s, 0)/h),  J_n >= 0; with a load: dJ = -m v_n
    friction: J_t <- J_t - v_t / lambda_max, then onto the disc |J_t| <= mu J_n

m = 1/(n-entry of J M^-1 J^T); lambda_max largest eigenvalue of its tangential block. A step by
1/lambda_max and not by the inverse of the block: only so is the friction of a slide opposite to
its velocity.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.solver.constraint import (
    ACTIVE,
    BOUNCE,
    CHANGE,
    COUPLE_O,
    COUPLE_T,
    GAIN,
    GAP,
    HN,
    HO,
    HT,
    IA,
    IB,
    JN,
    JO,
    JT,
    KEEP,
    LA,
    LARGEST,
    LB,
    MASS_A,
    MASS_B,
    MU,
    PS,
    PUSHED,
    RATE,
    SCALE,
    SLIP_GAIN,
    T2,
    TOUCHED,
    UNREST,
    A,
    B,
    N,
    T,
    V,
)
from rigid_body_sim.physics.contact.solver.wide_lanes import arms, disc, relative, strike, vector
from rigid_body_sim.physics.contact.solver_bodies import CARRIED, II, IM, L, P

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
        g[k + LARGEST] = 0.0
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


@inline
def wait(used: int, s: Array, g: Array) -> bool:
    """Let the lanes stand still that the last pass left at rest; tell whether any is left."""
    left = False
    for k in range(used):
        g[k + ACTIVE] = s[k + UNREST]
        left = left or s[k + UNREST] > 0.0
    return left


@inline
def note_unrest(used: int, s: Array, g: Array) -> None:
    """Note which lanes this pass has changed by more than rest."""
    for k in range(used):
        s[k + UNREST] = 1.0 if g[k + LARGEST] > 0.0 else 0.0
        if g[k + LARGEST] > 0.0:
            s[k + TOUCHED] = 1.0


@kernel
def mark_carried(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Mark the bodies that some point of a batch pushes."""
    for k in range(used):
        if g[k + PUSHED] > 0.0:
            s[k + TOUCHED] = 1.0
            bodies[int(s[k + A]) + CARRIED] = 1.0
            bodies[int(s[k + B]) + CARRIED] = 1.0


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
        pushed = g[k + PUSHED]
        is_open = gap > 0.0
        depth = gap + slop
        depth = depth if depth < 0.0 else 0.0
        soft = s[k + RATE] * depth
        soft = soft if soft > -cap else -cap
        bias = gap * inverse_h if is_open else soft
        scale = 1.0 if is_open else s[k + SCALE]
        keep = 0.0 if is_open else s[k + KEEP]
        # half of the load is still to come, of what presses
        pressed = old > 0.0
        hn, ht, ho = q[k + HN], q[k + HT], q[k + HO]
        before = old - hn if pressed else 0.0
        before_t = old_t - ht if pressed else 0.0
        before_o = old_o - ho if pressed else 0.0
        now = before - gain * scale * (vn + bias) - keep * old
        now = now if now > 0.0 else 0.0
        active = g[k + ACTIVE] > 0.0
        now = now if active else before
        presses = now > 0.0
        # friction of the last substep is none of this one where less presses: it keeps its share
        less = now < before
        share = now / (before if less else 1.0) if less else 1.0
        t, o = share * before_t, share * before_o
        change, dt, do = now - before, t - before_t, o - before_o
        x = change * nx + (dt * tx + do * ox)
        y = change * ny + (dt * ty + do * oy)
        z = change * nz + (dt * tz + do * oz)
        new = now + hn if presses else 0.0
        t = t + ht if presses else 0.0
        o = o + ho if presses else 0.0
        # a lane that is not visited keeps its bits
        q[k + JN] = new if active else old
        q[k + JT] = t if active else old_t
        q[k + JO] = o if active else old_o
        size = abs(change) - calm * gain
        g[k + CHANGE] = size if size > largest else largest
        g[k + PUSHED] = 1.0 if presses else pushed
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)


@kernel
def relax(
    lanes: int, s: Array, q: Array, g: Array, inverse_h: float, calm: float, rest: float
) -> None:  # fmt: skip
    """
    Visit normal and friction of one point of each lane, without push-out.

    Friction sees the tangential velocity that the new normal impulse leaves. What came with a load
    touches: a motion along a curve has opened it by h^2 only. To send it back at s/h, as what is
    still apart, would take energy of first order in h.
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
        unrest = g[k + LARGEST]
        is_open = gap > 0.0
        bias = gap * inverse_h if is_open & (q[k + HN] <= 0.0) else 0.0
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
        size, slip = abs(change), abs(dt) + abs(do)
        either = (size if size > slip else slip) - rest * gain
        size = size - calm * gain
        g[k + CHANGE] = size if size > largest else largest
        g[k + LARGEST] = either if either > unrest else unrest
        q[k + JN], q[k + JT], q[k + JO] = new, t, o
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)
