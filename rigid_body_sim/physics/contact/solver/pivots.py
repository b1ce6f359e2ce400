# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact of bodies that turn about a pivot: see `model.pivot`.

The pivot O is the point of reference of such a body in the solver, in place of its centre of mass:

    arms r from O,   L and I about O,   1/m = 0
    1/m_eff = (r x n) . I_O^-1 (r x n) + that of the other body

An impulse J at r changes L by r x J and no momentum: what is missing the pivot takes. So impulses
are those of the constrained motion, without a constraint, and angular momentum about O changes by
them alone. Solver bodies hold 1/m = HELD in place of zero, which says `cannot move` elsewhere; no
impulse that numbers hold moves the pivot by it.

A normal that goes through O has no effective mass: what presses a body there against something
that cannot move is not known, and counts as nothing.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.solver_bodies import HELD
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.vectors import store, store_strided

NO_VECTOR = (0.0, 0.0, 0.0)


@kernel
def hold(pivoted: Indices, bodies: Array) -> None:
    """Let the solver take the bodies on a pivot by it; pivoted: their core indices."""
    for number in range(len(pivoted)):
        row = pivoted[number] * solver_bodies.SIZE
        bodies[row + solver_bodies.INVERSE_MASS] = HELD
        store(bodies, row + solver_bodies.FREE_ACCELERATION, NO_VECTOR)


@kernel
def stand_still(pivoted: Indices, translation: Array) -> None:
    """Forget what impulses gave to pivots."""
    for number in range(len(pivoted)):
        place = blocks.at(pivoted[number], blocks.TRANSLATION)
        store_strided(translation, place + blocks.PX, blocks.LANES, NO_VECTOR)
        store_strided(translation, place + blocks.EX, blocks.LANES, NO_VECTOR)
