# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The static sink, taken out by the load of the last ticks, and the pace at which other overlap goes.

A soft contact at rest (`solve`) carries its impulse J per substep h by an overlap

    a = iota J / (m sigma beta) = F / (m omega_c^2)         F = J / h

Its points therefore see the separation s - delta, and rest at s = delta - a. Delta is one number
for a manifold, and slow:

    f = sum of F/(w m) / sum of min(1, F/(BEARS F_max)) over its points, at the end of a tick
    l <- l + RATE (f (1 - BAND) - l)  where that is more, (f (1 + BAND) - l) where that is less
    delta = l / omega_c^2,  at most MOST_SINK r/200, by which a contact gives way at most (`solve`)

with m the mass on which the spring of a point acts (`face_spring`), w its share of a surface of
several lines, else 1 (`softness`), and omega_c that of the whole, so that springs, dampers and
which points press are those of a contact without it. f is the mean over the points that bear: what
stands on two of its four points sinks in no deeper than on all. A point that begins to counts by
and by: else an arch near its limit never comes to rest. What has one spring has f = sum F/M
(`face_spring`). One number for each point that followed its load would do the work of a negative
damper on a body that rocks; without RATE the row would lose its only damping of wrong loads.
Within BAND of the load nothing follows: there the springs stand firm, and hold what statics leaves
open (which of five legs carries how much) where it is; followed all the way, it creeps over some
ten thousand ticks. The load is kept as an acceleration [m/s^2], so it stays the same when the
substep changes.

Overlap that no load explains was left by an impact, or by loads that begin. Bodies are lifted out
of it, which is energy that contact gives, so it goes slowly: beyond what carries the load of this
instant, the bias is at most

    pace = PACE r h + GAIN beta delta               r : [m] radius of the smaller of the two

and a tick lifts by some 1e-6 of the size of the body (4 ms), less as h^2 in shorter ones. A rim
has loads that change as it goes round, and no part with them.

An impulse counts as a load as far as the substep has started from it: an impact is none. What
stands when a scene begins has its load, and its whole sink, from the start
(`islands.first_loads`); and there each point takes its own part of that,

    delta_i = s_i delta        s_i = F_i/(w m f)

so that what is loaded beside the middle of its face stands level. s_i follows nothing: it stays
while the load of the point is s_i f, but for ABOUT of f, and goes to 1 at RATE where it is not;
1 is that of every other point.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.solver import constraint, contact_point
from rigid_body_sim.physics.contact.solver.softness import spring_mass

BEARS = 0.1  # [-] of the largest load: a point with more counts as one, with less as a part
BAND = 1e-3  # [-] of a load; so much of its sink is left, at most
RATE = 0.012  # [-] per tick; at 0.1 a stack of thirty falls, at 0.03 a cold stack gains energy
MOST_SINK = 5.0  # [-] of `constraint.DEEP`; more: what is heavy tips on springs too soft for it,
# less: it trembles, by micrometres
ABOUT = 0.1  # [-] of the load of a manifold: so much may that of a point be beside its share of it
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
    # 1/omega_c^2 = h iota/(sigma beta), of the whole surface
    compliance = (
        h * rows[lane + constraint.IMPULSE_SCALE] / (rows[lane + constraint.MASS_SCALE] * rate)
    ) * rows[lane + constraint.SHARE]
    rows[lane + constraint.LOAD] = load
    sink = min(load * compliance, MOST_SINK * rows[lane + constraint.DEEP])
    rows[lane + constraint.SINK] = sink
    pace = PACE * radius * h + GAIN * rate * sink
    is_rim = rows[lane + constraint.ROUNDNESS] < constraint.NOT_ROUND
    rows[lane + constraint.PACE] = PACE * radius * h if is_rim else pace


@inline
def begin(lane: int, h: float, load: float, rows: Array) -> None:
    """Give a constraint the load [m/s^2] with which a scene begins; its pace stays."""
    pace = rows[lane + constraint.PACE]
    recall(lane, h, 0.0, load / rows[lane + constraint.SHARE], rows)
    rows[lane + constraint.PACE] += pace


@inline
def of_point(lane: int, row: int, constraints: Array, points: Array) -> Any:
    """Return what its load takes out of the separation of a point [m]."""
    return points[row + contact_point.SINK_SHARE] * constraints[lane + constraint.SINK]


@inline
def lasting_impulse(row: int, normal_impulse: float, rows: Array) -> Any:
    """
    Return the impulse of a point that is its load: no more than what it started from, twice the
    half of it. An impact in this substep is no load.
    """
    return min(normal_impulse, 2.0 * rows[row + contact_point.WARM_NORMAL])


@inline
def load_of_point(lane: int, row: int, normal_impulse: float, h: float, rows: Array) -> Any:
    """Return the load of a point over the mass of its spring [m/s^2]; h: substep [s]."""
    mass = spring_mass(lane, row, rows, rows)
    return lasting_impulse(row, normal_impulse, rows) / (h * mass) if mass > 0.0 else 0.0


@inline
def share_that_bears(load: float, largest: float) -> Any:
    """Return as how much of a point one with a load counts, the largest of its manifold known."""
    return min(1.0, load / (BEARS * largest)) if largest > 0.0 else 0.0


@inline
def share_that_stays(share: float, load: float, of_all: float) -> Any:
    """Return the share of a point from which the next tick starts, from both loads of this one."""
    beside = abs(load - share * of_all) > ABOUT * of_all
    return share + RATE * (1.0 - share) if beside else share


@inline
def filtered(lane: int, load: float, rows: Array) -> Any:
    """Return what the next tick starts from, of the load [m/s^2] of this one."""
    before = rows[lane + constraint.LOAD]
    load /= rows[lane + constraint.SHARE]
    more, less = load * (1.0 - BAND) - before, load * (1.0 + BAND) - before
    return before + RATE * (more if more > 0.0 else (less if less < 0.0 else 0.0))
