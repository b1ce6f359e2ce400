# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The static sink, taken out by the load of the last ticks, and the pace at which other overlap goes.

A soft contact at rest (`solve`) carries its impulse J per substep h by an overlap

    a = iota J / (m sigma beta) = F / (m omega_c^2)         F = J / h

Its points therefore see the separation s - delta, and rest at s = delta - a. Delta is one number
for a manifold, and slow:

    l <- l + RATE (mean over its points of F/m - l)         at the end of a tick
    delta = SHARE l / omega_c^2

so that springs, dampers and which points press are those of a contact without it. One number for
each point would do the work of a negative damper on a body that rocks; without RATE the row would
lose its only damping of wrong loads. The load is kept as an acceleration [m/s^2], so it stays the
same when the substep changes.

Overlap that no load explains was left by an impact, or by loads that begin. Bodies are lifted out
of it, which is energy that contact gives, so it goes slowly: beyond what carries the load of this
instant, the bias is at most

    pace = (PACE + |omega_B - omega_A|^2) r h + GAIN beta l / omega_c^2

    r : [m] radius of the smaller of the two

the middle term being what a surface that turns comes nearer by its curvature
and a tick lifts by some 1e-6 of the size of the body (4 ms), less as h^2 in shorter ones.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.solver import constraint, contact_point, wide_lanes
from rigid_body_sim.physics.vectors import dot, subtract

SHARE = 0.97  # [-] of the sink; with all of it nothing settles loads that are not determined
RATE = 0.03  # [-] per tick; at 0.1 a stack of thirty falls, at 0.01 one of ten takes ten seconds
PACE = 0.6  # [1/s^2] at ten times as much the energy of heaps rises too fast
GAIN = 0.3  # [-] of the bias that carries the load; less lets stacks rock, more heaps gain


@inline
def recall(lane: int, h: float, radius: float, load: float, rows: Array) -> None:
    """
    Give a constraint the load [m/s^2] of the last ticks, its sink and its pace.

    h      : [s] substep
    radius : [m] of the smaller of the two colliders
    """
    rate = rows[lane + constraint.BIAS_RATE]
    # 1/omega_c^2 = h iota/(sigma beta)
    compliance = (
        h * rows[lane + constraint.IMPULSE_SCALE] / (rows[lane + constraint.MASS_SCALE] * rate)
    )
    rows[lane + constraint.LOAD] = load
    rows[lane + constraint.SINK] = SHARE * load * compliance
    rows[lane + constraint.SPIN_PACE] = radius * h
    rows[lane + constraint.PACE] = PACE * radius * h + GAIN * rate * load * compliance


@kernel
def add_spin(lanes: int, constraints: Array, scratch: Array) -> None:
    """Add to the pace of each lane what the turn of its bodies calls for."""
    for lane in range(lanes):
        omega_a, omega_b = wide_lanes.angular_velocities(constraints, scratch, lane)
        omega = subtract(omega_b, omega_a)
        pace = constraints[lane + constraint.SPIN_PACE] * dot(omega, omega)
        constraints[lane + constraint.PACE] += pace


@inline
def load_of_point(row: int, normal_impulse: float, h: float, rows: Array) -> Any:
    """Return the load of a point over its effective mass [m/s^2]; h: substep [s]."""
    mass = rows[row + contact_point.NORMAL_MASS]
    return normal_impulse / (h * mass) if mass > 0.0 else 0.0


@inline
def filtered(lane: int, load: float, rows: Array) -> Any:
    """Return what the next tick starts from, of the load [m/s^2] of this one."""
    before = rows[lane + constraint.LOAD]
    return before + RATE * (load - before)
