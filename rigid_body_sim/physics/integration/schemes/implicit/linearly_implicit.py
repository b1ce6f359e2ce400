# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The linearly implicit scheme: one linear solve for the velocities, then a free drift.

    ( M + h C + h^2 K ) (dv, dw) = h ( F + h K' (v, w) ),   K' = -K
    p <- p + m dv,   L <- L + R I R^T dw,   r <- r + h p / m,   q <- free rotation over h with the
    new L

        M    : m 1 and R I R^T
        K, C : stiffness and damping of the force elements that bring a kernel `linearise`: J^T k
               J, J^T c J for a spring
               between body points, J = [1, -[arm]x]; other forces are kicks

What a turning arm does to a given force (geometric stiffness) is left out, and so the matrix is
symmetric and positive definite: the solve cannot fail, whatever k and h are. It is implicit Euler
in the stiff directions: they die out within a step or two, and the anchors of a stiff spring part
by at most about (h |omega|)^2 |arm| / 2, what the arc of the drift leaves open.

Trap: k d^2 / 2 of that gap is no energy that the motion knows of; at large k h^2 it exceeds the
kinetic energy many times over. Limits: springs lose energy, soft ones too: 8 % in 2 s at k = 100
N/m, m = 1 kg, h = 1 ms.

Source: Baraff & Witkin, SIGGRAPH 1998; the drift is Moser & Veselov's, see `drifts.moser_veselov`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.compile.kernels import kernel, specialise, unbound
from rigid_body_sim.physics.forces.derivatives import block_place, clear, first_block, partner
from rigid_body_sim.physics.forces.evaluator import Derivatives
from rigid_body_sim.physics.integration.schemes.implicit.banded import entry, solve
from rigid_body_sim.physics.integration.schemes.implicit.coupling import (
    BAND,
    BODIES_AT,
    BODY,
    FIRST,
    FIRST_MEMBER,
    GROUP,
    GROUPS,
    HEADER,
    MATRIX,
    MATRIX_AT,
    MEMBERS,
    MEMBERS_AT,
    TABLE_AT,
    UNKNOWN,
    UNKNOWNS,
    VECTOR_AT,
)
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation
from rigid_body_sim.physics.integration.schemes.steps import (
    finite,
    kick_and_drift,
    start_evaluation,
)
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.blocks import (
    FX,
    GX,
    I1,
    I2,
    I3,
    IM,
    LX,
    LY,
    LZ,
    PX,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    RX,
    TRANSLATION,
    TX,
    add_compensated,
    angular_velocity,
    at,
    rotate,
    velocity,
)

MOTION = 3  # where the row of a body keeps its velocity and angular velocity, world axes
COUPLED = 9  # 1 where its wrench has derivatives

# bound by `specialise`
evaluate: Callable[..., Any] = unbound
linearise: Callable[..., Any] = unbound
drift_rotation: Callable[..., Any] = unbound


@kernel
def _read_motion(i, n_rigid, b, translation, rotation):
    """Keep velocity and angular velocity of a body."""
    b[MOTION], b[MOTION + 1], b[MOTION + 2] = velocity(translation, i)
    if i < n_rigid:
        b[MOTION + 3], b[MOTION + 4], b[MOTION + 5] = angular_velocity(rotation, i)


@kernel
def _start_equations(
    i, n_rigid, h, first, band, bodies, translation, rotation, table, matrix, rhs
):
    """Write the rows of one body."""
    b = bodies[BODY * i : BODY * (i + 1)]
    row = int(b[UNKNOWN]) - first
    size = 6 if i < n_rigid else 3
    k = at(i, TRANSLATION)
    for axis in range(3):
        matrix[entry(band, row + axis, row + axis)] += 1.0 / translation[k + IM]
        rhs[row + axis] = h * translation[k + FX + 64 * axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
        for axis in range(3):
            e1, e2, e3 = (
                1.0 if axis == 0 else 0.0,
                1.0 if axis == 1 else 0.0,
                1.0 if axis == 2 else 0.0,
            )
            e1, e2, e3 = _inertia(rotation, k, x, y, z, w, e1, e2, e3)
            matrix[entry(band, row + 3, row + 3 + axis)] += e1
            matrix[entry(band, row + 4, row + 3 + axis)] += e2
            matrix[entry(band, row + 5, row + 3 + axis)] += e3
            rhs[row + 3 + axis] = h * rotation[k + TX + 64 * axis]
    total = 0.0
    for number in range(first_block(table, i), first_block(table, i + 1)):
        j = partner(table, number)
        m = block_place(table, number)
        column = int(bodies[BODY * j + UNKNOWN]) - first
        for p in range(size):
            for q in range(6 if j < n_rigid else 3):
                stiffness, damping = table[m + 6 * p + q], table[m + 6 * p + q + 36]
                total += abs(stiffness) + abs(damping)
                matrix[entry(band, row + p, column + q)] -= h * damping + h * h * stiffness
                rhs[row + p] += h * h * stiffness * bodies[BODY * j + MOTION + q]
    b[COUPLED] = 1.0 if total > 0.0 else 0.0


@kernel
def _inertia(rotation, k, x, y, z, w, a, b, c):
    """R I R^T times a vector."""
    a, b, c = rotate(-x, -y, -z, w, a, b, c)
    return rotate(x, y, z, w, a * rotation[k + I1], b * rotation[k + I2], c * rotation[k + I3])


@kernel
def _push(i, n_rigid, h, first, b, translation, rotation, rhs):
    """Change momentum and angular momentum of one body."""
    u = int(b[UNKNOWN]) - first
    k = at(i, TRANSLATION)
    mass = 1.0 / translation[k + IM]
    free = b[COUPLED] == 0.0
    for axis in range(3):
        push = h * translation[k + FX + 64 * axis] if free else mass * rhs[u + axis]
        place = k + 64 * axis
        translation[place + PX], translation[place + GX] = add_compensated(
            translation[place + PX], translation[place + GX], push
        )
    if i < n_rigid:
        k = at(i, ROTATION)
        x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
        p, q, r = _inertia(rotation, k, x, y, z, w, rhs[u + 3], rhs[u + 4], rhs[u + 5])
        rotation[k + LX] += h * rotation[k + TX] if free else p
        rotation[k + LY] += h * rotation[k + TX + 64] if free else q
        rotation[k + LZ] += h * rotation[k + TX + 128] if free else r


def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance a scene. Return 0, NaN if a number left the finite ones, or DID_NOT_CONVERGE for a
    singular matrix.
    """
    n_groups = int(workspace[GROUPS])
    groups = workspace[HEADER : int(workspace[MEMBERS_AT])]
    members = workspace[int(workspace[MEMBERS_AT]) : int(workspace[BODIES_AT])]
    bodies = workspace[int(workspace[BODIES_AT]) : int(workspace[TABLE_AT])]
    table = workspace[int(workspace[TABLE_AT]) : int(workspace[MATRIX_AT])]
    matrices = workspace[int(workspace[MATRIX_AT]) : int(workspace[VECTOR_AT])]
    vector = workspace[int(workspace[VECTOR_AT]) : len(workspace)]
    for passed in range(ticks):
        time = (tick + passed) * h
        start_evaluation(n_bodies, n_rigid, translation, rotation)
        evaluate(0, time, translation, rotation, elements, ranges)
        clear(table)
        linearise(0, time, translation, rotation, elements, ranges, table, 1)
        for i in range(n_bodies):
            _read_motion(i, n_rigid, bodies[BODY * i : BODY * (i + 1)], translation, rotation)
        for g in range(n_groups):
            row = groups[GROUP * g : GROUP * (g + 1)]
            n, band, first = int(row[UNKNOWNS]), int(row[BAND]), int(row[FIRST])
            matrix = matrices[int(row[MATRIX]) :]
            rhs = vector[first : first + n]
            for place in range(n * (3 * band + 1)):
                matrix[place] = 0.0
            start = int(row[FIRST_MEMBER])
            end = start + int(row[MEMBERS])
            for place in range(start, end):
                _start_equations(
                    int(members[place]), n_rigid, h, first, band, bodies,
                    translation, rotation, table, matrix, rhs,
                )  # fmt: skip
            if solve(n, band, matrix, rhs) == 0:
                translation[at(int(members[start]), TRANSLATION) + RX] = math.nan
                return DID_NOT_CONVERGE
            for place in range(start, end):
                i = int(members[place])
                b = bodies[BODY * i : BODY * (i + 1)]
                _push(i, n_rigid, h, first, b, translation, rotation, rhs)
        for block in range((n_bodies + 63) // 64):
            kick_and_drift(block, min(64, n_bodies - 64 * block), 0.0, h, translation)
        for block in range((n_rigid + 63) // 64):
            drift_rotation(block, min(64, n_rigid - 64 * block), 0.0, h, rotation, method)
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

    drift_rotation : kernel of `physics.drifts`
    """

    drift_rotation: Callable[..., Any]

    def for_points(self) -> LinearlyImplicit:
        """Return the same scheme without rotation."""
        return replace(self, drift_rotation=no_rotation.drift)

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
