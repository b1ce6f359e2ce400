# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Implicit schemes: implicit Euler, SDIRK2, and the implicit midpoint rule, for any forces.

    implicit Euler   y1 = y0 + h f(y1)
    SDIRK2           g = 1 - 1/sqrt 2:  Y = y0 + g h f(Y),  y1 = y0 + (1 - g) h f(Y) + g h f(y1)
    midpoint         y1 = y0 + h f((y0 + y1) / 2)

Each stage is solved by Newton's method, one system of equations for each group of bodies that
forces connect. Its Jacobian is analytic for the inertia and for the force elements that bring a
kernel `linearise`; for the others it is found by differences, bodies of one colour at a time.

Where Newton does not converge, the group goes back to the start of the tick and takes it in 2, 4,
… 64 parts; other groups do not notice. Where that does not help either, the run stops and says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rigid_body_sim.physics.compile.kernels import kernel, specialise, unbound
from rigid_body_sim.physics.forces.derivatives import clear, first_block, partner
from rigid_body_sim.physics.forces.evaluator import NO_DERIVATIVES, Derivatives, evaluator
from rigid_body_sim.physics.integration.schemes.implicit.banded import solve
from rigid_body_sim.physics.integration.schemes.implicit.coupling import (
    BAND,
    BODIES_AT,
    BODY,
    CHANGE,
    COLOUR,
    COLOURS,
    END,
    FIRST,
    FIRST_MEMBER,
    FORCES_AT,
    GROUP,
    GROUPS,
    HEADER,
    LENGTH,
    MATRIX,
    MATRIX_AT,
    MEMBERS,
    MEMBERS_AT,
    OF_GROUP,
    STATUS,
    TABLE_AT,
    UNKNOWN,
    UNKNOWNS,
    VECTOR_AT,
)
from rigid_body_sim.physics.integration.schemes.implicit.stage import (
    BASE_P,
    BASE_R,
    D,
    W,
    set_stage,
    start_equations,
    subtract_blocks,
    subtract_column,
)
from rigid_body_sim.physics.integration.schemes.implicit.step import (
    DELTA,
    begin_part,
    correct_torque,
    end_of_midpoint,
    end_stage,
    keep,
    restore,
    save_wrench,
    shift,
    unshift,
    wrench_change,
)
from rigid_body_sim.physics.integration.schemes.steps import finite, start_evaluation
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE
from rigid_body_sim.physics.state.blocks import IM, RX, TRANSLATION, at

ITERATIONS = 25  # of Newton; it takes 3 to 6 where it converges
CONVERGED = 1e-15  # [-] estimated error of the unknowns, relative; round-off
ROUNDING = 1e-8  # [-] a change that no longer shrinks is round-off when it is below this
# [-] share of length / a and 1 / a below which velocities count as zero when errors are judged
FLOOR = 1e-6
DIFFERENCE = (
    1e-8  # [-] relative step of the differences: the square root of the rounding of doubles
)
MOST_PARTS = 64  # of a tick; more means that the equations have no solution nearby

IDLE, SOLVING, SOLVED, FAILED = 0.0, 1.0, 2.0, 3.0  # status of a group

# bound by `specialise`
STAGES = 1
GAMMA = 1.0
midpoint = False
HAS_REST = False
evaluate: Callable[..., Any] = unbound
linearise: Callable[..., Any] = unbound
evaluate_rest: Callable[..., Any] = unbound
solve_stage: Callable[..., Any] = unbound
attempt: Callable[..., Any] = unbound
add_differences: Callable[..., Any] = unbound


@kernel
def _set_status(old, new, groups, count):
    changed = 0
    for g in range(count):
        if groups[GROUP * g + STATUS] == old:
            groups[GROUP * g + STATUS] = new
            changed += 1
    return changed


@kernel
def _update(n_rigid, a, length, row, members, bodies, rhs, translation, rotation):
    """
    Take a Newton step in one group; return the relative size of the change, NaN where it is not
    finite.
    """
    change_v = change_w = size_v = size_w = total = 0.0
    reach = length
    start = int(row[FIRST_MEMBER])
    for place in range(start, start + int(row[MEMBERS])):
        i = int(members[place])
        b = bodies[BODY * i : BODY * (i + 1)]
        im = translation[at(i, TRANSLATION) + IM]
        u = int(b[UNKNOWN]) - int(row[FIRST])
        for axis in range(3):
            b[D + axis] -= rhs[u + axis]
            total += rhs[u + axis]
            change_v = max(change_v, abs(rhs[u + axis]))
            size_v = max(size_v, abs(b[D + axis] + im * b[BASE_P + axis]))
            reach = max(reach, abs(b[BASE_R + axis]))
        if i < n_rigid:
            correct_torque(i, a, b, rotation, rhs[u + 3], rhs[u + 4], rhs[u + 5])
            for axis in range(3):
                b[W + axis] -= rhs[u + 3 + axis]
                total += rhs[u + 3 + axis]
                change_w = max(change_w, abs(rhs[u + 3 + axis]))
                size_w = max(size_w, abs(b[W + axis]))
    error = 0.0 * total
    if change_v > 0.0:
        error += change_v / (size_v + FLOOR * reach / a)
    if change_w > 0.0:
        error += change_w / (size_w + FLOOR / a)
    return error


def _add_differences(
    n_bodies, n_rigid, a, time, length, colours, translation, rotation, groups, bodies, table,
    matrix, saved,
    elements, ranges,
):  # fmt: skip
    """
    Subtract the derivatives of the remaining forces from the Jacobian: one evaluation for each
    colour and component.
    """
    start_evaluation(n_bodies, n_rigid, translation, rotation)
    evaluate_rest(0, time, translation, rotation, elements, ranges)
    for i in range(n_bodies):
        save_wrench(i, n_rigid, translation, rotation, saved)
    for colour in range(colours):
        for component in range(6):
            for i in range(n_bodies):
                b = bodies[BODY * i : BODY * (i + 1)]
                if b[COLOUR] == colour and groups[GROUP * int(b[OF_GROUP]) + STATUS] == SOLVING:
                    shift(midpoint, component, i, n_rigid, a, length, b, translation, rotation)
            start_evaluation(n_bodies, n_rigid, translation, rotation)
            evaluate_rest(0, time, translation, rotation, elements, ranges)
            for j in range(n_bodies):
                other = bodies[BODY * j : BODY * (j + 1)]
                row = groups[GROUP * int(other[OF_GROUP]) : GROUP * (int(other[OF_GROUP]) + 1)]
                if other[COLOUR] != colour or row[STATUS] != SOLVING or other[DELTA] == 0.0:
                    continue
                unshift(midpoint, component, j, n_rigid, a, other, translation, rotation)
                column = int(other[UNKNOWN] - row[FIRST]) + component
                for number in range(first_block(table, j), first_block(table, j + 1)):
                    i = partner(table, number)
                    b = bodies[BODY * i : BODY * (i + 1)]
                    f1, f2, f3, t1, t2, t3 = wrench_change(
                        i, n_rigid, translation, rotation, saved
                    )
                    over = 1.0 / other[DELTA]
                    subtract_column(
                        midpoint, i, n_rigid, a, int(b[UNKNOWN] - row[FIRST]), column,
                        int(row[BAND]), b,
                        rotation, matrix[int(row[MATRIX]) :], f1 * over, f2 * over, f3 * over,
                        t1 * over, t2 * over, t3 * over,
                    )  # fmt: skip


def _solve_stage(
    n_bodies, n_rigid, a, time, length, colours, translation, rotation, groups, n_groups, members,
    bodies, table,
    matrices, vector, saved, elements, ranges,
):  # fmt: skip
    """Solve the stage of all groups that are SOLVING: they become SOLVED or FAILED."""
    for iteration in range(ITERATIONS):
        for i in range(n_bodies):
            b = bodies[BODY * i : BODY * (i + 1)]
            if groups[GROUP * int(b[OF_GROUP]) + STATUS] == SOLVING:
                set_stage(midpoint, i, n_rigid, a, b, translation, rotation)
        start_evaluation(n_bodies, n_rigid, translation, rotation)
        evaluate(0, time, translation, rotation, elements, ranges)
        clear(table)
        linearise(0, time, translation, rotation, elements, ranges, table, 0)
        for g in range(n_groups):
            row = groups[GROUP * g : GROUP * (g + 1)]
            if row[STATUS] == SOLVING:
                n, band, first = int(row[UNKNOWNS]), int(row[BAND]), int(row[FIRST])
                matrix = matrices[int(row[MATRIX]) :]
                rhs = vector[first : first + n]
                for place in range(n * (3 * band + 1)):
                    matrix[place] = 0.0
                start = int(row[FIRST_MEMBER])
                for place in range(start, start + int(row[MEMBERS])):
                    i = int(members[place])
                    b = bodies[BODY * i : BODY * (i + 1)]
                    start_equations(
                        midpoint, i, n_rigid, a, first, band, b, translation, rotation, matrix, rhs
                    )
                    subtract_blocks(
                        midpoint, i, n_rigid, a, first, band, bodies, rotation, table, matrix
                    )
        if HAS_REST:
            add_differences(
                n_bodies, n_rigid, a, time, length, colours, translation, rotation, groups, bodies,
                table,
                matrices, saved, elements, ranges,
            )  # fmt: skip
        open_groups = 0
        for g in range(n_groups):
            row = groups[GROUP * g : GROUP * (g + 1)]
            if row[STATUS] != SOLVING:
                continue
            n, band, first = int(row[UNKNOWNS]), int(row[BAND]), int(row[FIRST])
            rhs = vector[first : first + n]
            if solve(n, band, matrices[int(row[MATRIX]) :], rhs) == 0:
                row[STATUS] = FAILED
                continue
            change = _update(n_rigid, a, length, row, members, bodies, rhs, translation, rotation)
            shrunk = 1.0
            if iteration > 0:
                shrunk = min(1.0, change / row[CHANGE])
            row[CHANGE] = max(change, 1e-300)
            if not change < 1e100:
                row[STATUS] = FAILED
            elif change * shrunk <= CONVERGED or (
                change <= ROUNDING and shrunk > 0.3 and iteration > 0
            ):
                row[STATUS] = SOLVED
            else:
                open_groups += 1
        if open_groups == 0:
            return
    _set_status(SOLVING, FAILED, groups, n_groups)


def _attempt(
    n_bodies, n_rigid, h, time, parts, length, colours, translation, rotation, groups, n_groups,
    members, bodies,
    table, matrices, vector, saved, elements, ranges,
):  # fmt: skip
    """Take a tick in equal parts, all groups that are SOLVED; those that fail become FAILED."""
    k = h / parts
    for part in range(parts):
        for i in range(n_bodies):
            b = bodies[BODY * i : BODY * (i + 1)]
            if groups[GROUP * int(b[OF_GROUP]) + STATUS] == SOLVED:
                begin_part(i, n_rigid, b, translation, rotation)
        elapsed = 0.0
        for stage in range(STAGES):
            elapsed += GAMMA if stage == 0 else 1.0 - GAMMA
            _set_status(SOLVED, SOLVING, groups, n_groups)
            solve_stage(
                n_bodies, n_rigid, GAMMA * k, time + (part + elapsed) * k, length, colours,
                translation, rotation,
                groups, n_groups, members, bodies, table, matrices, vector, saved, elements,
                ranges,
            )  # fmt: skip
            for i in range(n_bodies):
                b = bodies[BODY * i : BODY * (i + 1)]
                if groups[GROUP * int(b[OF_GROUP]) + STATUS] == SOLVED:
                    if midpoint:
                        end_of_midpoint(i, n_rigid, k, b, translation, rotation)
                    else:
                        end_stage(
                            i, n_rigid, k, GAMMA, stage + 1 == STAGES, b, translation, rotation
                        )


def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """Advance a scene. Return 0, NaN if a number left the finite ones, or DID_NOT_CONVERGE."""
    n_groups, colours = int(workspace[GROUPS]), int(workspace[COLOURS])
    length = workspace[LENGTH]
    groups = workspace[HEADER : int(workspace[MEMBERS_AT])]
    members = workspace[int(workspace[MEMBERS_AT]) : int(workspace[BODIES_AT])]
    bodies = workspace[int(workspace[BODIES_AT]) : int(workspace[TABLE_AT])]
    table = workspace[int(workspace[TABLE_AT]) : int(workspace[MATRIX_AT])]
    matrices = workspace[int(workspace[MATRIX_AT]) : int(workspace[VECTOR_AT])]
    vector = workspace[int(workspace[VECTOR_AT]) : int(workspace[FORCES_AT])]
    saved = workspace[int(workspace[FORCES_AT]) : int(workspace[END])]
    for passed in range(ticks):
        for i in range(n_bodies):
            keep(i, n_rigid, bodies[BODY * i : BODY * (i + 1)], translation, rotation)
        for g in range(n_groups):
            groups[GROUP * g + STATUS] = SOLVED
        parts = 1
        while True:
            attempt(
                n_bodies, n_rigid, h, (tick + passed) * h, parts, length, colours, translation,
                rotation, groups,
                n_groups, members, bodies, table, matrices, vector, saved, elements, ranges,
            )  # fmt: skip
            _set_status(SOLVED, IDLE, groups, n_groups)
            failed = _set_status(FAILED, SOLVED, groups, n_groups)
            if failed == 0:
                break
            for i in range(n_bodies):
                b = bodies[BODY * i : BODY * (i + 1)]
                if groups[GROUP * int(b[OF_GROUP]) + STATUS] == SOLVED:
                    restore(i, n_rigid, b, translation, rotation)
                    if parts == MOST_PARTS:
                        translation[at(i, TRANSLATION) + RX] = math.nan
            if parts == MOST_PARTS:
                return DID_NOT_CONVERGE
            parts *= 2
    return finite(n_bodies, n_rigid, translation, rotation)


@dataclass(frozen=True)
class Implicit:
    """
    A singly diagonally implicit Runge–Kutta scheme whose last stage is its result, or the midpoint
    rule.

    stages   : 1, or 2 for SDIRK2
    gamma    : diagonal entry of the tableau
    midpoint : L in world axes is integrated, and the stage lies half-way
    """

    stages: int
    gamma: float
    midpoint: bool = False

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        nothing = Derivatives(NO_DERIVATIVES, None)
        return self._kernel(f'{name}__free', evaluator([]), nothing)

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
        return self._kernel(f'{name}__{scene}', evaluate, derivatives)

    def _kernel(
        self, name: str, evaluate: Callable[..., Any], derivatives: Derivatives
    ) -> Callable[..., Any]:
        def bind(function: Any, **more: Any) -> Callable[..., Any]:
            return specialise(
                function,
                name=name,
                STAGES=self.stages,
                GAMMA=self.gamma,
                midpoint=self.midpoint,
                HAS_REST=derivatives.rest is not None,
                **more,
            )

        rest = derivatives.rest or evaluator([])
        differences = bind(_add_differences, evaluate_rest=rest)
        stage = bind(
            _solve_stage,
            evaluate=evaluate,
            linearise=derivatives.linearise,
            add_differences=differences,
        )
        return bind(_advance, attempt=bind(_attempt, solve_stage=stage))

    def workspace(self, blocks: int) -> int:
        """Count no numbers: the plan of the scene has room for all."""
        return 0
