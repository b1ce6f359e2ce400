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
… 64 substeps; other groups do not notice. Where that does not help either, the run stops and says
so.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rigid_body_sim.physics.compile.kernels import kernel, slot, specialise
from rigid_body_sim.physics.forces import derivatives as derivative_table
from rigid_body_sim.physics.forces.derivatives import first_block, partner
from rigid_body_sim.physics.forces.evaluator import NO_DERIVATIVES, Derivatives, evaluator
from rigid_body_sim.physics.integration.schemes.implicit import banded
from rigid_body_sim.physics.integration.schemes.implicit.coupling import (
    BODY,
    CHANGE,
    COLOUR,
    GROUP,
    OF_GROUP,
    POINT,
    RIGID,
    STATUS,
    UNKNOWN,
    members_of,
    opened,
    status_of,
    system_of,
)
from rigid_body_sim.physics.integration.schemes.implicit.stage import (
    BASE_MOMENTUM,
    BASE_POSITION,
    DELTA,
    RATE,
    VELOCITY_CHANGE,
    Blocks,
    set_stage,
    start_equations,
    subtract_blocks,
    subtract_wrench,
)
from rigid_body_sim.physics.integration.schemes.implicit.step import (
    begin_substep,
    correct_impulse,
    end_of_midpoint,
    end_stage,
    keep,
    restore,
    save_wrench,
    shift,
    wrench_change,
)
from rigid_body_sim.physics.integration.schemes.steps import finite, start_evaluation
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE
from rigid_body_sim.physics.state.blocks import INVERSE_MASS, POSITION, TRANSLATION, at
from rigid_body_sim.physics.vectors import load, scale

ITERATIONS = 25  # of Newton; it takes 3 to 6 where it converges
CONVERGED = 1e-15  # [-] estimated error of the unknowns, relative; round-off
ROUNDING = 1e-8  # [-] a change that no longer shrinks is round-off when it is below this
NO_LONGER_SHRINKS = 0.3  # [-] of a change relative to the one before: from here on
# [-] share of length / a and 1 / a below which velocities count as zero when errors are judged
FLOOR = 1e-6
LEAST_CHANGE = 1e-300  # [-] a smaller one counts as this where it is the one before
DIVERGED = 1e100  # [-] relative change from which on the iteration has diverged
MOST_SUBSTEPS = 64  # of a tick; more means that the equations have no solution nearby

IDLE, SOLVING, SOLVED, FAILED = 0.0, 1.0, 2.0, 3.0  # status of a group

# bound for each method
STAGES = slot('[-] stages of a step')
GAMMA = slot('[tick] diagonal entry of the tableau')
MIDPOINT = slot('[-] whether L in world axes is integrated, and the stage lies half-way')
# bound for each scene
HAS_REST = slot('[-] whether there are forces without derivatives of their own')
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')
linearise = slot(
    'kernel (place, time, translation, rotation, elements, ranges, table, definite): adds '
    'derivatives of wrenches'
)
evaluate_rest = slot('kernel as `evaluate`: adds wrenches of forces without derivatives')
add_differences = slot('kernel (a, time, plan, blocks, elements, ranges): completes the Jacobian')
assemble = slot('kernel (a, plan, blocks): writes the equations of all groups')
solve_stage = slot('kernel (a, time, plan, blocks, elements, ranges): solves a stage')
attempt = slot('kernel (h, time, substeps, plan, blocks, elements, ranges): takes a tick')


@kernel
def _set_status(old, new, groups):
    """Set the status of all groups that have the old one; return how many."""
    changed = 0
    for place in range(STATUS, len(groups), GROUP):
        if groups[place] == old:
            groups[place] = new
            changed += 1
    return changed


@kernel
def _update(a, row, length, members, bodies, blocks, system):
    """
    Take a Newton step in one group; return the relative size of the change, NaN where it is not
    finite.
    """
    change_v = change_w = size_v = size_w = total = 0.0
    reach, rhs = length, system.rhs
    for place in members_of(row):
        i = int(members[place])
        b = bodies[BODY * i : BODY * (i + 1)]
        over_mass = blocks.translation[at(i, TRANSLATION) + INVERSE_MASS]
        unknown = int(b[UNKNOWN]) - system.first
        for axis in range(3):
            error = rhs[unknown + axis]
            b[VELOCITY_CHANGE + axis] -= error
            total += error
            change_v = max(change_v, abs(error))
            velocity = b[VELOCITY_CHANGE + axis] + over_mass * b[BASE_MOMENTUM + axis]
            size_v = max(size_v, abs(velocity))
            reach = max(reach, abs(b[BASE_POSITION + axis]))
        if i < blocks.n_rigid:
            correct_impulse(i, a, b, blocks.rotation, load(rhs, unknown + POINT))
            for axis in range(3):
                error = rhs[unknown + POINT + axis]
                b[RATE + axis] -= error
                total += error
                change_w = max(change_w, abs(error))
                size_w = max(size_w, abs(b[RATE + axis]))
    relative = 0.0 * total
    if change_v > 0.0:
        relative += change_v / (size_v + FLOOR * reach / a)
    if change_w > 0.0:
        relative += change_w / (size_w + FLOOR / a)
    return relative


def _add_differences(a, time, plan, blocks, elements, ranges):
    """
    Subtract the derivatives of the remaining forces from the Jacobian: one evaluation for each
    colour and component.
    """
    n_bodies, n_rigid, translation, rotation = blocks
    start_evaluation(n_bodies, n_rigid, translation, rotation)
    evaluate_rest(0, time, translation, rotation, elements, ranges)
    for i in range(n_bodies):
        save_wrench(i, blocks, plan.wrenches)
    for colour in range(plan.n_colours):
        for component in range(RIGID):
            for i in range(n_bodies):
                b = plan.bodies[BODY * i : BODY * (i + 1)]
                if b[COLOUR] == colour and status_of(plan, b) == SOLVING:
                    shift(MIDPOINT, component, i, a, plan.length, b, blocks)
            start_evaluation(n_bodies, n_rigid, translation, rotation)
            evaluate_rest(0, time, translation, rotation, elements, ranges)
            for j in range(n_bodies):
                other = plan.bodies[BODY * j : BODY * (j + 1)]
                solving = status_of(plan, other) == SOLVING
                if other[COLOUR] != colour or not solving or other[DELTA] == 0.0:
                    continue
                set_stage(MIDPOINT, j, a, other, blocks)
                number = int(other[OF_GROUP])
                system = system_of(plan, plan.groups[GROUP * number : GROUP * (number + 1)])
                column = int(other[UNKNOWN]) - system.first + component
                over = 1.0 / other[DELTA]
                for pair in range(first_block(plan.table, j), first_block(plan.table, j + 1)):
                    i = partner(plan.table, pair)
                    force, torque = wrench_change(i, blocks, plan.wrenches)
                    b = plan.bodies[BODY * i : BODY * (i + 1)]
                    force, torque = scale(over, force), scale(over, torque)
                    subtract_wrench(MIDPOINT, i, a, column, b, blocks, system, force, torque)


def _assemble(a, plan, blocks):
    """Write the equations of all groups that are SOLVING, and what is known of their Jacobian."""
    for number in range(plan.n_groups):
        row = plan.groups[GROUP * number : GROUP * (number + 1)]
        if row[STATUS] == SOLVING:
            system = system_of(plan, row)
            banded.clear(system.size, system.band, system.matrix)
            for place in members_of(row):
                i = int(plan.members[place])
                start_equations(
                    MIDPOINT, i, a, plan.bodies[BODY * i : BODY * (i + 1)], blocks, system
                )
                subtract_blocks(MIDPOINT, i, a, plan.bodies, plan.table, blocks, system)


@kernel
def _step_of_newton(iteration, a, plan, blocks):
    """
    Take a Newton step in all groups that are SOLVING: some become SOLVED or FAILED. Return how
    many do not.
    """
    still_open = 0
    for number in range(plan.n_groups):
        row = plan.groups[GROUP * number : GROUP * (number + 1)]
        if row[STATUS] != SOLVING:
            continue
        system = system_of(plan, row)
        if banded.solve(system.size, system.band, system.matrix, system.rhs) == 0:
            row[STATUS] = FAILED
            continue
        change = _update(a, row, plan.length, plan.members, plan.bodies, blocks, system)
        shrunk = 1.0
        if iteration > 0:
            shrunk = min(1.0, change / row[CHANGE])
        row[CHANGE] = max(change, LEAST_CHANGE)
        if not change < DIVERGED:
            row[STATUS] = FAILED
        elif change * shrunk <= CONVERGED or (
            change <= ROUNDING and shrunk > NO_LONGER_SHRINKS and iteration > 0
        ):
            row[STATUS] = SOLVED
        else:
            still_open += 1
    return still_open


def _solve_stage(a, time, plan, blocks, elements, ranges):
    """Solve the stage of all groups that are SOLVING: they become SOLVED or FAILED."""
    n_bodies, n_rigid, translation, rotation = blocks
    for iteration in range(ITERATIONS):
        for i in range(n_bodies):
            b = plan.bodies[BODY * i : BODY * (i + 1)]
            if status_of(plan, b) == SOLVING:
                set_stage(MIDPOINT, i, a, b, blocks)
        start_evaluation(n_bodies, n_rigid, translation, rotation)
        evaluate(0, time, translation, rotation, elements, ranges)
        derivative_table.clear(plan.table)
        linearise(0, time, translation, rotation, elements, ranges, plan.table, 0)
        assemble(a, plan, blocks)
        if HAS_REST:
            add_differences(a, time, plan, blocks, elements, ranges)
        if _step_of_newton(iteration, a, plan, blocks) == 0:
            return
    _set_status(SOLVING, FAILED, plan.groups)


def _attempt(h, time, substeps, plan, blocks, elements, ranges):
    """Take a tick in equal substeps, all groups that are SOLVED; those that fail become FAILED."""
    step = h / substeps
    for substep in range(substeps):
        for i in range(blocks.n_bodies):
            b = plan.bodies[BODY * i : BODY * (i + 1)]
            if status_of(plan, b) == SOLVED:
                begin_substep(i, b, blocks)
        elapsed = 0.0
        for stage in range(STAGES):
            elapsed += GAMMA if stage == 0 else 1.0 - GAMMA
            _set_status(SOLVED, SOLVING, plan.groups)
            now = time + (substep + elapsed) * step
            solve_stage(GAMMA * step, now, plan, blocks, elements, ranges)
            for i in range(blocks.n_bodies):
                b = plan.bodies[BODY * i : BODY * (i + 1)]
                if status_of(plan, b) == SOLVED:
                    if MIDPOINT:
                        end_of_midpoint(i, step, b, blocks)
                    else:
                        end_stage(i, step, GAMMA, stage + 1 == STAGES, b, blocks)


def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance a scene. Return DONE, NaN if a number left the finite ones, or DID_NOT_CONVERGE.
    """
    plan, blocks = opened(workspace), Blocks(n_bodies, n_rigid, translation, rotation)
    for passed in range(ticks):
        for i in range(n_bodies):
            keep(i, plan.bodies[BODY * i : BODY * (i + 1)], blocks)
        for number in range(plan.n_groups):
            plan.groups[GROUP * number + STATUS] = SOLVED
        substeps = 1
        while True:
            attempt(h, (tick + passed) * h, substeps, plan, blocks, elements, ranges)
            _set_status(SOLVED, IDLE, plan.groups)
            if _set_status(FAILED, SOLVED, plan.groups) == 0:
                break
            for i in range(n_bodies):
                b = plan.bodies[BODY * i : BODY * (i + 1)]
                if status_of(plan, b) == SOLVED:
                    restore(i, b, blocks)
                    if substeps == MOST_SUBSTEPS:
                        translation[at(i, TRANSLATION) + POSITION] = math.nan
            if substeps == MOST_SUBSTEPS:
                return DID_NOT_CONVERGE
            substeps *= 2
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

    def stability_function(self, z: complex) -> complex:
        """Give R(z): y1 = R(h l) y0 for y' = l y."""
        if self.midpoint:
            return (1.0 + 0.5 * z) / (1.0 - 0.5 * z)
        first = 1.0 if self.stages == 1 else 1.0 / (1.0 - self.gamma * z)
        return (1.0 + (1.0 - self.gamma) * z * first) / (1.0 - self.gamma * z)

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
        offered = {
            'STAGES': self.stages,
            'GAMMA': self.gamma,
            'MIDPOINT': self.midpoint,
            'HAS_REST': derivatives.rest is not None,
            'evaluate': evaluate,
            'linearise': derivatives.linearise,
            'evaluate_rest': derivatives.rest or evaluator([]),
        }
        for slot_name, function in (
            ('add_differences', _add_differences),
            ('assemble', _assemble),
            ('solve_stage', _solve_stage),
            ('attempt', _attempt),
        ):
            offered[slot_name] = specialise(function, name=name, offered=offered)
        return specialise(_advance, name=name, offered=offered)

    def workspace(self, blocks: int) -> int:
        """Count no numbers: the plan of the scene has room for all."""
        return 0
