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
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch
from rigid_body_sim.physics.contact.solver.wide_lanes import arms, disc, relative, strike, vector

Array = NDArray[np.float64]


@kernel
def gather_inertia(used: int, s: Array, bodies: Array) -> None:
    """Fetch the inverse masses and inertias of the bodies of a batch."""
    for k in range(used):
        a, b = int(s[k + constraint.BODY_A]), int(s[k + constraint.BODY_B])
        s[k + constraint.INVERSE_MASS_A] = bodies[a + solver_bodies.INVERSE_MASS]
        s[k + constraint.INVERSE_MASS_B] = bodies[b + solver_bodies.INVERSE_MASS]
        for entry in range(6):
            s[k + constraint.INVERSE_INERTIA_A + 8 * entry] = bodies[
                a + solver_bodies.INVERSE_INERTIA + entry
            ]
            s[k + constraint.INVERSE_INERTIA_B + 8 * entry] = bodies[
                b + solver_bodies.INVERSE_INERTIA + entry
            ]


@kernel
def gather(lanes: int, used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch the momenta of the bodies of a batch; what empty lanes hold does not matter."""
    for k in range(lanes):
        g[k + lane_scratch.IMPULSE] = 0.0
        g[k + lane_scratch.IMPULSE + 8] = 0.0
        g[k + lane_scratch.IMPULSE + 16] = 0.0
        g[k + lane_scratch.PUSHES] = 0.0
        g[k + lane_scratch.NORMAL_CHANGE] = 0.0
        g[k + lane_scratch.LARGEST_CHANGE] = 0.0
        g[k + lane_scratch.ACTIVE] = 1.0
    for k in range(used):
        a, b = int(s[k + constraint.BODY_A]), int(s[k + constraint.BODY_B])
        m, n = s[k + constraint.INVERSE_MASS_A], s[k + constraint.INVERSE_MASS_B]
        for axis in range(3):
            row = k + 8 * axis
            g[row + lane_scratch.RELATIVE_VELOCITY] = (
                n * bodies[b + solver_bodies.MOMENTUM + axis]
                - m * bodies[a + solver_bodies.MOMENTUM + axis]
            )
            g[row + lane_scratch.ANGULAR_MOMENTUM_A] = bodies[
                a + solver_bodies.ANGULAR_MOMENTUM + axis
            ]
            g[row + lane_scratch.ANGULAR_MOMENTUM_B] = bodies[
                b + solver_bodies.ANGULAR_MOMENTUM + axis
            ]


@kernel
def scatter(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Give the bodies of a batch what a pass has changed."""
    for k in range(used):
        a, b = int(s[k + constraint.BODY_A]), int(s[k + constraint.BODY_B])
        for axis in range(3):
            row = k + 8 * axis
            bodies[a + solver_bodies.MOMENTUM + axis] -= g[row + lane_scratch.IMPULSE]
            bodies[b + solver_bodies.MOMENTUM + axis] += g[row + lane_scratch.IMPULSE]
            bodies[a + solver_bodies.ANGULAR_MOMENTUM + axis] = g[
                row + lane_scratch.ANGULAR_MOMENTUM_A
            ]
            bodies[b + solver_bodies.ANGULAR_MOMENTUM + axis] = g[
                row + lane_scratch.ANGULAR_MOMENTUM_B
            ]


@inline
def wait(used: int, s: Array, g: Array) -> bool:
    """Let the lanes stand still that the last pass left at rest; tell whether any is left."""
    left = False
    for k in range(used):
        g[k + lane_scratch.ACTIVE] = s[k + constraint.UNSETTLED]
        left = left or s[k + constraint.UNSETTLED] > 0.0
    return left


@inline
def note_unrest(used: int, s: Array, g: Array) -> None:
    """Note which lanes this pass has changed by more than rest."""
    for k in range(used):
        s[k + constraint.UNSETTLED] = 1.0 if g[k + lane_scratch.LARGEST_CHANGE] > 0.0 else 0.0
        if g[k + lane_scratch.LARGEST_CHANGE] > 0.0:
            s[k + constraint.TOUCHED] = 1.0


@kernel
def mark_carried(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Mark the bodies that some point of a batch pushes."""
    for k in range(used):
        if g[k + lane_scratch.PUSHES] > 0.0:
            s[k + constraint.TOUCHED] = 1.0
            bodies[int(s[k + constraint.BODY_A]) + solver_bodies.CARRIED] = 1.0
            bodies[int(s[k + constraint.BODY_B]) + solver_bodies.CARRIED] = 1.0


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
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = relative(s, g, k, ax, ay, az, bx, by, bz)
        vn = nx * x + ny * y + nz * z
        gap = q[k + contact_point.SEPARATION]
        old, old_t, old_o = (
            q[k + contact_point.NORMAL_IMPULSE],
            q[k + contact_point.TANGENT_IMPULSE_1],
            q[k + contact_point.TANGENT_IMPULSE_2],
        )
        gain, largest = q[k + contact_point.NORMAL_MASS], g[k + lane_scratch.NORMAL_CHANGE]
        pushed = g[k + lane_scratch.PUSHES]
        is_open = gap > 0.0
        depth = gap + slop
        depth = depth if depth < 0.0 else 0.0
        soft = s[k + constraint.BIAS_RATE] * depth
        soft = soft if soft > -cap else -cap
        bias = gap * inverse_h if is_open else soft
        scale = 1.0 if is_open else s[k + constraint.MASS_SCALE]
        keep = 0.0 if is_open else s[k + constraint.IMPULSE_SCALE]
        # half of the load is still to come, of what presses
        pressed = old > 0.0
        hn, ht, ho = (
            q[k + contact_point.WARM_NORMAL],
            q[k + contact_point.WARM_TANGENT_1],
            q[k + contact_point.WARM_TANGENT_2],
        )
        before = old - hn if pressed else 0.0
        before_t = old_t - ht if pressed else 0.0
        before_o = old_o - ho if pressed else 0.0
        now = before - gain * scale * (vn + bias) - keep * old
        now = now if now > 0.0 else 0.0
        active = g[k + lane_scratch.ACTIVE] > 0.0
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
        q[k + contact_point.NORMAL_IMPULSE] = new if active else old
        q[k + contact_point.TANGENT_IMPULSE_1] = t if active else old_t
        q[k + contact_point.TANGENT_IMPULSE_2] = o if active else old_o
        size = abs(change) - calm * gain
        g[k + lane_scratch.NORMAL_CHANGE] = size if size > largest else largest
        g[k + lane_scratch.PUSHES] = 1.0 if presses else pushed
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
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = relative(s, g, k, ax, ay, az, bx, by, bz)
        gap = q[k + contact_point.SEPARATION]
        old, old_t, old_o = (
            q[k + contact_point.NORMAL_IMPULSE],
            q[k + contact_point.TANGENT_IMPULSE_1],
            q[k + contact_point.TANGENT_IMPULSE_2],
        )
        gain, slip_gain, largest = (
            q[k + contact_point.NORMAL_MASS],
            q[k + contact_point.TANGENT_MASS],
            g[k + lane_scratch.NORMAL_CHANGE],
        )
        unrest = g[k + lane_scratch.LARGEST_CHANGE]
        is_open = gap > 0.0
        bias = gap * inverse_h if is_open & (q[k + contact_point.WARM_NORMAL] <= 0.0) else 0.0
        new = old - gain * ((nx * x + ny * y + nz * z) + bias)
        new = new if new > 0.0 else 0.0
        # what touches in the next substep bounces there: at the end of a tick here is too early
        waits = is_open & (s[k + constraint.RESTITUTION] > 0.0) & (old <= 0.0)
        new = 0.0 if waits else new
        active = g[k + lane_scratch.ACTIVE] > 0.0
        new = new if active else old
        change = new - old
        t = old_t - slip_gain * (
            (tx * x + ty * y + tz * z) + q[k + contact_point.CROSS_TERM_1] * change
        )
        o = old_o - slip_gain * (
            (ox * x + oy * y + oz * z) + q[k + contact_point.CROSS_TERM_2] * change
        )
        t, o = disc(t, o, s[k + constraint.FRICTION] * new)
        t, o = (t, o) if active else (old_t, old_o)
        dt, do = t - old_t, o - old_o
        x = change * nx + (dt * tx + do * ox)
        y = change * ny + (dt * ty + do * oy)
        z = change * nz + (dt * tz + do * oz)
        size, slip = abs(change), abs(dt) + abs(do)
        either = (size if size > slip else slip) - rest * gain
        size = size - calm * gain
        g[k + lane_scratch.NORMAL_CHANGE] = size if size > largest else largest
        g[k + lane_scratch.LARGEST_CHANGE] = either if either > unrest else unrest
        (
            q[k + contact_point.NORMAL_IMPULSE],
            q[k + contact_point.TANGENT_IMPULSE_1],
            q[k + contact_point.TANGENT_IMPULSE_2],
        ) = new, t, o
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)
