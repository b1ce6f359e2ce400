# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Groups: bodies that press on each other in a tick, and how what cannot move holds them.

In a group, contacts only pass energy on, or take it. It is named by its first body, and has a row
of numbers, its account; so has what cannot move, the last row.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.islands.union_find import join, root_of
from rigid_body_sim.physics.contact.solver import batch_record, constraint, contact_point

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# of a group: first what a bounce may return, after that what it has gained
TAKEN, LINEAR, SQUARE, SHARE, FACTOR = range(5)  # see `returned_energy`
GAIN, FALL = 0, 1  # [J]; [J] of its bodies, if each fell for a substep from rest
FORCE = 2  # (3) [N] upon it, without contacts
BODIES = 5  # how many it has
HELD = 6  # CALM: has not gained; else how it is held by what cannot move
PRESS = 7  # (3) [N s] what it got from all that cannot move
NORMAL = 10  # (3) [-] of the plane on which it slides
MASS, CENTRE = 13, 14  # [kg]; (3) [m]
U, OMEGA = 17, 20  # (3) [m/s], (3) [rad/s] of its rigid motion; momenta on the way
INERTIA = 23  # (6) [kg m^2] about the centre: xx, xy, xz, yy, yz, zz
MOVING = 29  # [J] kinetic energy of the motion relative to u
DOWN = 30  # [m/(N s)] how far a body alone is let down, over the size of the impulse
# of a body, and of a place in an order: see `charged_impulses`
PARENT, ORDER = 31, 32
IMPULSE = 33  # (3) [N s] of a body: change of its momentum, to be attributed to contacts
ACCOUNT = 36

CALM, UNHELD, FREE, SLIDING, FAST = -2.0, -1.0, 0.0, 1.0, 2.0  # UNHELD: nothing presses
PARALLEL = 1e-12  # [-] 1 - cosine of normals of one plane, at most


@kernel
def join_pressing(
    count: int, touched: int, nothing: int, touching: Indices, batches: Indices, rows: Array,
    groups: Indices,
) -> None:  # fmt: skip
    """
    Give each body the first of its group: of those that press on each other, by way of whoever
    does; what cannot move, `nothing`, joins nobody.

        count : batches
    """
    for t in range(touched):
        groups[touching[t]] = touching[t]
    for batch in range(count):
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        for place in range(
            begin, begin + batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
        ):
            a, b = (
                int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE,
                int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE,
            )
            if a != nothing and b != nothing and rows[place + constraint.TOUCHED] > 0.0:
                join(a, b, groups)
    for t in range(touched):
        groups[touching[t]] = root_of(touching[t], groups)


@inline
def _note_plane(place: int, g: int, rows: Array, accounts: Array) -> None:
    """Note one manifold of a group with something that cannot move."""
    x, y, z = (
        rows[place + constraint.NORMAL],
        rows[place + constraint.NORMAL + 8],
        rows[place + constraint.NORMAL + 16],
    )
    slides = (
        rows[place + constraint.FRICTION]
        + rows[place + constraint.ROLLING_FRICTION]
        + rows[place + constraint.TORSIONAL_FRICTION]
        == 0.0
    )
    if slides and accounts[g + HELD] == SLIDING:
        i = g + NORMAL
        c = x * accounts[i] + y * accounts[i + 1] + z * accounts[i + 2]
        slides = 1.0 - abs(c) < PARALLEL
    accounts[g + HELD] = max(accounts[g + HELD], SLIDING if slides else FAST)
    accounts[g + NORMAL], accounts[g + NORMAL + 1], accounts[g + NORMAL + 2] = x, y, z


@inline
def _note_press(place: int, first: int, end: int, width: int, sign: float, g: int, rows: Array,
    accounts: Array,
) -> None:  # fmt: skip
    """Add up what the points of a manifold gave to its group, from `first` to `end`."""
    press = 0.0
    for q in range(first, end, width):
        press += rows[q + contact_point.TOTAL_IMPULSE] + rows[q + contact_point.NORMAL_IMPULSE]
    for axis in range(3):
        accounts[g + PRESS + axis] += sign * press * rows[place + constraint.NORMAL + 8 * axis]


@kernel
def find_held(
    count: int, nothing: int, width: int, batches: Indices, rows: Array, groups: Indices,
    accounts: Array,
) -> None:  # fmt: skip
    """
    Find how each group that is not calm is held by what cannot move, and how hard that presses.

        count : batches
        width : numbers of a point
    """
    for batch in range(count):
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        length = batches[batch * batch_record.SIZE + batch_record.POINT_COUNT] * width
        for lane in range(batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]):
            place = begin + lane
            if not rows[place + constraint.TOUCHED] > 0.0:
                continue
            a, b = (
                int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE,
                int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE,
            )
            g = groups[b if a == nothing else a] * ACCOUNT
            if accounts[g + HELD] == CALM:
                continue
            if a != nothing and b != nothing:
                accounts[g + HELD] = max(accounts[g + HELD], FREE)
                continue
            _note_plane(place, g, rows, accounts)
            first = place + constraint.SIZE
            sign = 1.0 if a == nothing else -1.0
            _note_press(place, first, first + length, width, sign, g, rows, accounts)
