# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The linearly implicit scheme: one linear solve for the velocities, then a free motion.

    ( M + h C + h^2 K ) (dv, dw) = h ( F + h K' (v, w) ),   K' = -K
    p <- p + m dv,   L <- L + R I R^T dw,   r <- r + h p / m,   q <- free rotation over h with the
    new L

        M    : m 1 and R I R^T
        K, C : stiffness and damping of the force elements that bring a kernel `linearise`: J^T k
               J, J^T c J for a spring between body points, J = [1, -[arm]x]; other forces are
               kicks

What a turning arm does to a given force (geometric stiffness) is left out, and so the matrix is
symmetric and positive definite: the solve cannot fail, whatever k and h are. It is implicit Euler
in the stiff directions: they die out within a step or two, and the anchors of a stiff spring part
by at most about (h |omega|)^2 |arm| / 2, what the arc of the drift leaves open.

Trap: k d^2 / 2 of that gap is no energy that the motion knows of; at large k h^2 it exceeds the
kinetic energy many times over. Limits: springs lose energy, soft ones too: 8 % in 2 s at k = 100
N/m, m = 1 kg, h = 1 ms.

Source: Baraff & Witkin, SIGGRAPH 1998; the free rotation is Moser & Veselov's, see
`free_rotation.moser_veselov`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.forces import derivatives as derivative_table
from rigid_body_sim.physics.forces.derivatives import (
    DAMPING_MATRIX,
    ROW,
    block_place,
    first_block,
    partner,
)
from rigid_body_sim.physics.forces.evaluator import Derivatives
from rigid_body_sim.physics.integration.schemes.implicit import banded
from rigid_body_sim.physics.integration.schemes.implicit.banded import (
    add_to_column,
    entry,
    weigh,
)
from rigid_body_sim.physics.integration.schemes.implicit.coupling import (
    BODY,
    FIRST_MEMBER,
    GROUP,
    POINT,
    RIGID,
    SCRATCH,
    UNKNOWN,
    members_of,
    opened,
    system_of,
)
from rigid_body_sim.physics.integration.schemes.implicit.stage import Blocks, along
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    add_to_vector,
    multiply,
    read_vector,
    write_vector,
)
from rigid_body_sim.physics.integration.schemes.steps import (
    finite,
    kick_and_drift,
    start_evaluation,
)
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    INVERSE_MASS,
    LANES,
    MOMENTS,
    MOMENTUM,
    MOMENTUM_RESIDUAL,
    POSITION,
    ROTATION,
    TORQUE,
    TRANSLATION,
    angular_velocity,
    at,
    block_count,
    lanes_in,
    orientation,
    rotated,
    rotated_back,
    velocity,
)
from rigid_body_sim.physics.vectors import add, load, scale, store

scratch = Record(begin=SCRATCH)  # of a body, beyond what `coupling` keeps there
VELOCITY = scratch.vector('m/s', 'world axes')
ANGULAR_VELOCITY = scratch.vector('rad/s', 'world axes')
COUPLED = scratch.number('-', '1 where its wrench has derivatives')

# bound for each scene
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')
linearise = slot(
    'kernel (place, time, translation, rotation, elements, ranges, table, definite): adds '
    'derivatives of wrenches'
)
# bound for each method
drift_rotation = slot('kernel (block, lanes, kick, h, rotation, method): kicks L and moves q')


@kernel
def _read_motion(i, b, blocks):
    """Keep velocity and angular velocity of a body."""
    store(b, VELOCITY, velocity(blocks.translation, i))
    if i < blocks.n_rigid:
        store(b, ANGULAR_VELOCITY, angular_velocity(blocks.rotation, i))


@inline
def _inertia(rotation, i, v):
    """R I R^T times a vector."""
    q = orientation(rotation, i)
    moments = read_vector(rotation, at(i, ROTATION) + MOMENTS)
    return rotated(q, multiply(rotated_back(q, v), moments))


@kernel
def _start_equations(i, h, bodies, table, blocks, system):
    """Write the rows of one body."""
    translation, band, matrix = blocks.translation, system.band, system.matrix
    b = bodies[BODY * i : BODY * (i + 1)]
    row = int(b[UNKNOWN]) - system.first
    place = at(i, TRANSLATION)
    for axis in range(3):
        mass = 1.0 / translation[place + INVERSE_MASS]
        matrix[entry(band, row + axis, row + axis)] += mass
        weigh(band, matrix, row + axis, mass)
        system.rhs[row + axis] = h * translation[place + LANES * axis + FORCE]
    if i < blocks.n_rigid:
        turning = row + POINT
        for axis in range(3):
            column = _inertia(blocks.rotation, i, along(axis, 1.0))
            add_to_column(band, matrix, turning, turning + axis, column)
            weigh(band, matrix, turning + axis, column[axis])
        torque = read_vector(blocks.rotation, at(i, ROTATION) + TORQUE)
        store(system.rhs, turning, scale(h, torque))
    total = 0.0
    for pair in range(first_block(table, i), first_block(table, i + 1)):
        j = partner(table, pair)
        other = bodies[BODY * j : BODY * (j + 1)]
        column = int(other[UNKNOWN]) - system.first
        for p in range(RIGID if i < blocks.n_rigid else POINT):
            place = block_place(table, pair) + ROW * p
            for q in range(RIGID if j < blocks.n_rigid else POINT):
                stiffness, damping = table[place + q], table[place + q + DAMPING_MATRIX]
                total += abs(stiffness) + abs(damping)
                matrix[entry(band, row + p, column + q)] -= h * damping + h * h * stiffness
                system.rhs[row + p] += h * h * stiffness * other[VELOCITY + q]
    b[COUPLED] = 1.0 if total > 0.0 else 0.0


@kernel
def _kick(i, h, b, blocks, system):
    """Change momentum and angular momentum of one body."""
    translation, place = blocks.translation, at(i, TRANSLATION)
    unknown = int(b[UNKNOWN]) - system.first
    alone = b[COUPLED] == 0.0
    if alone:
        kick = scale(h, read_vector(translation, place + FORCE))
    else:
        kick = scale(1.0 / translation[place + INVERSE_MASS], load(system.rhs, unknown))
    momentum = read_vector(translation, place + MOMENTUM)
    add_to_vector(translation, place + MOMENTUM, place + MOMENTUM_RESIDUAL, momentum, kick)
    if i < blocks.n_rigid:
        rotation, place = blocks.rotation, at(i, ROTATION)
        if alone:
            kick = scale(h, read_vector(rotation, place + TORQUE))
        else:
            kick = _inertia(rotation, i, load(system.rhs, unknown + POINT))
        momentum = read_vector(rotation, place + ANGULAR_MOMENTUM)
        write_vector(rotation, place + ANGULAR_MOMENTUM, add(momentum, kick))


@inline
def _solve_group(row, h, plan, blocks):
    """Solve for the velocities of a group and kick its bodies; return 0 for a singular matrix."""
    system = system_of(plan, row)
    banded.clear(system.size, system.band, system.matrix)
    for place in members_of(row):
        _start_equations(int(plan.members[place]), h, plan.bodies, plan.table, blocks, system)
    if banded.solve(system.size, system.band, system.matrix, system.rhs) == 0:
        return 0
    for place in members_of(row):
        i = int(plan.members[place])
        _kick(i, h, plan.bodies[BODY * i : BODY * (i + 1)], blocks, system)
    return 1


def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance a scene. Return DONE, NaN if a number left the finite ones, or DID_NOT_CONVERGE for a
    singular matrix.
    """
    plan, blocks = opened(workspace), Blocks(n_bodies, n_rigid, translation, rotation)
    for passed in range(ticks):
        time = (tick + passed) * h
        start_evaluation(n_bodies, n_rigid, translation, rotation)
        evaluate(0, time, translation, rotation, elements, ranges)
        derivative_table.clear(plan.table)
        linearise(0, time, translation, rotation, elements, ranges, plan.table, 1)
        for i in range(n_bodies):
            _read_motion(i, plan.bodies[BODY * i : BODY * (i + 1)], blocks)
        for number in range(plan.n_groups):
            row = plan.groups[GROUP * number : GROUP * (number + 1)]
            if _solve_group(row, h, plan, blocks) == 0:
                culprit = int(plan.members[int(row[FIRST_MEMBER])])
                translation[at(culprit, TRANSLATION) + POSITION] = math.nan
                return DID_NOT_CONVERGE
        for block in range(block_count(n_bodies)):
            kick_and_drift(block, lanes_in(block, n_bodies), 0.0, h, translation)
        for block in range(block_count(n_rigid)):
            drift_rotation(block, lanes_in(block, n_rigid), 0.0, h, rotation, method)
    return finite(n_bodies, n_rigid, translation, rotation)


def refuses(scene: Scene) -> str | None:
    """Tell what in a scene it cannot serve, or None."""
    for body in scene.bodies:
        if getattr(body, 'mass_flow', None) is not None:
            return (
                f'the mass of {body.name!r} changes, for which the solve has no stiffness; use'
                ' sdirk2 or dmv6'
            )
    pivoted = [body.name for body in scene.bodies if body.pivot is not None]
    for index, force in enumerate(scene.forces):
        if pivoted and not hasattr(force, 'linearise'):
            return (
                f'{pivoted[0]!r} turns about a pivot, and forces[{index}] ({force.TYPE}) does not '
                'tell how it changes, without which the solve has no stiffness; use sdirk2 or dmv6'
            )
    return None


@dataclass(frozen=True)
class LinearlyImplicit:
    """
    The scheme of the linearly implicit velocity solve.

    drift_rotation : kernel of a free-rotation propagator, see `free_rotation`
    """

    drift_rotation: Callable[..., Any]

    def for_points(self) -> LinearlyImplicit:
        """Return the same scheme without rotation."""
        return replace(self, drift_rotation=no_rotation.drift)

    def stability_function(self, z: complex) -> complex:
        """Give R(z) of linear springs, on which it is implicit Euler."""
        return 1.0 / (1.0 - z)

    def free(self, name: str) -> Callable[..., Any]:
        """
        Make the kernel for a scene without forces that depend on the state: a kick, then a drift.
        """
        scheme = Splitting(
            kicks=(1.0, 0.0), drifts=(1.0,), drift_rotation=self.drift_rotation, order=1
        )
        return scheme.free(name)

    def coupled(
        self,
        name: str,
        *,
        scene: str,
        evaluate: Callable[..., Any],
        velocity_dependent: bool,
        derivatives: Derivatives,
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        return specialise(
            _advance,
            name=f'{name}__{scene}',
            evaluate=evaluate,
            linearise=derivatives.linearise,
            drift_rotation=self.drift_rotation,
        )

    def workspace(self, blocks: int) -> int:
        """Count no numbers: the plan of the scene has room for all."""
        return 0
