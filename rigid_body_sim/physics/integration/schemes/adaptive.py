# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An embedded Runge–Kutta pair with step size control; every tick is reached exactly.

    error of a substep  err = h sum_i (b_i - b*_i) K_i
    e = max over bodies and over r, p, q, omega_body of |err| / (atol + rtol |y|)
    accepted, e <= 1: next substep = substep * 0.9 e^(-1/8) e_before^(1/16), within [1/5, 5]
    refused:          next substep = substep * 0.9 e^(-1/4), at least 1/5; no growth after it

|.| is the length of each vector, so that the result does not depend on the directions of the axes.
The controller is that of Gustafsson (ACM TOMS 17, 1991) for a pair of orders five and four, with
exponents (0.125, 0.0625) in place of the customary (0.14, 0.08): these are square roots of square
roots, which every machine rounds alike, so the substeps are the same everywhere.

Each tick begins with one substep over all of it: what a tick does depends on the state at its
start alone, nothing is remembered from tick to tick, and a command needs to reset nothing. A tick
that wants n substeps costs about log5(n) refused ones more. The last slope is taken at the new
state and is the first of the next substep ("first same as last").

With `orientation: matrix` the rotation is (R, L), see `stages_of_matrices`, and its error that of
these: |.| of R is the root of the sum of its squares.

In a scene without forces that depend on the state each body has substeps of its own; else all
bodies share them. Where no substep down to 1e-12 of the tick is accepted, the state of the worst
body is set to NaN, which names it, and DID_NOT_CONVERGE is returned.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.compile.kernels import specialise, unbound
from rigid_body_sim.physics.integration.schemes.runge_kutta import no_forces, square
from rigid_body_sim.physics.integration.schemes.state_space import matrices as matrices
from rigid_body_sim.physics.integration.schemes.state_space import (
    no_rotation,
    substeps,
    substeps_of_matrices,
)
from rigid_body_sim.physics.integration.schemes.state_space import points as points
from rigid_body_sim.physics.integration.schemes.state_space import quaternions as turns
from rigid_body_sim.physics.integration.schemes.state_space.matrices import MATRIX
from rigid_body_sim.physics.integration.schemes.state_space.points import POINT
from rigid_body_sim.physics.integration.schemes.state_space.points import begin as begin_points
from rigid_body_sim.physics.integration.schemes.state_space.points import (
    slope_of as slope_of_points,
)
from rigid_body_sim.physics.integration.schemes.steps import finite, start_evaluation
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE
from rigid_body_sim.physics.state.blocks import QX, ROTATION, RX, TRANSLATION, at

HEAD = 64  # numbers at the head of the workspace: rtol, atol
SMALLEST = 1e-12  # [tick] substep at which the control gives up
MOST = 1_000_000  # substeps of one tick, likewise

# bound for each pair, and `evaluate` for each scene, by `specialise`
STAGES = 1  # without the slope at the new state
C: tuple[float, ...] = (0.0,)
TURN = TURN_START = 0  # numbers of a slope of a rotation in a block; where the slopes begin
evaluate: Callable[..., Any] = unbound
advance_one: Callable[..., Any] = unbound
move_points: Callable[..., Any] = unbound
end_points: Callable[..., Any] = unbound
error_of_points: Callable[..., Any] = unbound
begin_turns: Callable[..., Any] = unbound
move_turns: Callable[..., Any] = unbound
slope_of_turns: Callable[..., Any] = unbound
set_rate: Callable[..., Any] = unbound
save_turns: Callable[..., Any] = unbound
restore_turns: Callable[..., Any] = unbound
end_turns: Callable[..., Any] = unbound
error_of_turns: Callable[..., Any] = unbound
step_points: Callable[..., Any] = unbound


def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """Advance with substeps that all bodies share. Return 0, or DID_NOT_CONVERGE."""
    rtol, atol = workspace[0], workspace[1]
    point_blocks = (n_bodies + 63) // 64
    turn_blocks = (n_rigid + 63) // 64
    point_size = POINT * (STAGES + 3)
    turn_size = TURN_START + TURN * (STAGES + 2)
    turn_workspace = workspace[HEAD + point_blocks * point_size :]
    fresh = False  # whether y and the first slope are those of the present state
    for passed in range(ticks):
        elapsed = 0.0  # share of the tick
        share = 1.0
        before = 1.0
        refused = False
        count = 0
        while elapsed < 1.0:
            rest = 1.0 - elapsed
            last = share >= 0.999999 * rest
            if last:
                share = rest
            elif 2.0 * share > rest:
                share = 0.5 * rest
            step = share * h
            worst, culprit = 0.0, -1
            for stage in range(STAGES + 1):
                if stage == 0 and fresh:
                    continue
                for block in range(point_blocks):
                    lanes = min(64, n_bodies - 64 * block)
                    s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
                    y = workspace[HEAD + block * point_size : HEAD + (block + 1) * point_size]
                    if stage == 0:
                        begin_points(lanes, s, y)
                    elif stage < STAGES:
                        move_points(stage, lanes, step, s, y)
                    else:
                        substeps.save_points(lanes, s, y[POINT * (STAGES + 2) :])
                        end_points(lanes, step, s, y)
                for block in range(turn_blocks):
                    lanes = min(64, n_rigid - 64 * block)
                    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
                    y = turn_workspace[block * turn_size : (block + 1) * turn_size]
                    memory = method[block * MATRIX : (block + 1) * MATRIX]
                    if stage == 0:
                        begin_turns(lanes, s, y, memory)
                        save_turns(lanes, s, memory, y[TURN_START + TURN * (STAGES + 1) :])
                    elif stage < STAGES:
                        move_turns(stage, lanes, step, s, y)
                    else:
                        end_turns(lanes, step, s, y, memory)
                        set_rate(lanes, s, y)
                within = 1.0 if last and stage == STAGES else elapsed + C[stage] * share
                start_evaluation(n_bodies, n_rigid, translation, rotation)
                evaluate(0, (tick + passed + within) * h, translation, rotation, elements, ranges)
                for block in range(point_blocks):
                    lanes = min(64, n_bodies - 64 * block)
                    s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
                    place = HEAD + block * point_size + POINT * (stage + 1)
                    slope_of_points(lanes, s, workspace[place : place + POINT])
                for block in range(turn_blocks):
                    lanes = min(64, n_rigid - 64 * block)
                    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
                    y = turn_workspace[block * turn_size : (block + 1) * turn_size]
                    place = TURN_START + TURN * stage
                    slope_of_turns(lanes, s, y, y[place : place + TURN])
            for block in range(point_blocks):
                lanes = min(64, n_bodies - 64 * block)
                s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
                y = workspace[HEAD + block * point_size : HEAD + (block + 1) * point_size]
                worst, culprit = error_of_points(
                    lanes, step, s, y, rtol, atol, 64 * block, worst, culprit
                )
            for block in range(turn_blocks):
                lanes = min(64, n_rigid - 64 * block)
                y = turn_workspace[block * turn_size : (block + 1) * turn_size]
                worst, culprit = error_of_turns(
                    lanes, step, y, rtol, atol, 64 * block, worst, culprit
                )
            accepted = worst <= 1.0
            for block in range(point_blocks):
                lanes = min(64, n_bodies - 64 * block)
                s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
                y = workspace[HEAD + block * point_size : HEAD + (block + 1) * point_size]
                if accepted:
                    begin_points(lanes, s, y)
                    substeps.take_over(6, lanes, y[POINT * (STAGES + 1) :], y[POINT:])
                else:
                    substeps.restore_points(lanes, y, y[POINT * (STAGES + 2) :], s)
            for block in range(turn_blocks):
                lanes = min(64, n_rigid - 64 * block)
                s = rotation[block * ROTATION : block * ROTATION + ROTATION]
                y = turn_workspace[block * turn_size : (block + 1) * turn_size]
                memory = method[block * MATRIX : (block + 1) * MATRIX]
                saved = y[TURN_START + TURN * (STAGES + 1) :]
                if accepted:
                    begin_turns(lanes, s, y, memory)
                    save_turns(lanes, s, memory, saved)
                    slope = y[TURN_START + TURN * STAGES :]
                    substeps.take_over(TURN // 64, lanes, slope, y[TURN_START:])
                else:
                    restore_turns(lanes, saved, y, s)
            fresh = True
            count += 1
            if accepted:
                elapsed = 1.0 if last else elapsed + share
                share *= substeps.after_acceptance(worst, before, refused)
                before = max(worst, 1e-4)
            else:
                share *= substeps.after_refusal(worst)
            refused = not accepted
            if share < SMALLEST or count > MOST:
                if n_bodies > 0:
                    translation[at(max(culprit, 0), TRANSLATION) + RX] = math.nan
                else:
                    rotation[at(max(culprit, 0), ROTATION) + QX] = math.nan
                return DID_NOT_CONVERGE
    return finite(n_bodies, n_rigid, translation, rotation)


def _advance_free(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies on which only held forces act, each with substeps of its own: translation is
    exact.
    """
    for block in range((n_bodies + 63) // 64):
        lanes = min(64, n_bodies - 64 * block)
        s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
        for _tick in range(ticks):
            step_points(lanes, h, s)
    status = finite(n_bodies, 0, translation, rotation)
    for i in range(n_rigid):
        own = rotation[at(i, ROTATION) :]
        memory = method[at(i, MATRIX) :]
        one = advance_one(
            ticks, tick, h, 0, 1, translation[:0], own, memory, workspace, elements, ranges
        )
        if one != 0.0:
            status = one
    return status


@dataclass(frozen=True)
class EmbeddedPair:
    """
    An explicit Runge–Kutta pair whose last slope is the first of the next step.

    a     : rows of the tableau, without the last one
    b     : weights of the higher order, which goes on; also the last row of the tableau
    error : b - b*, with the weight of the slope at the new state as the last
    matrix, reorthonormalise, turning : as for `runge_kutta.RungeKutta`
    """

    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    error: tuple[float, ...]
    matrix: bool = False
    reorthonormalise: bool = True
    turning: bool = True

    def for_points(self) -> EmbeddedPair:
        """Return the same pair without rotation."""
        return replace(self, matrix=False, turning=False)

    def _constants(self) -> dict[str, Any]:
        stages = len(self.b)
        return {
            'STAGES': stages,
            'A': square(self.a),
            'B': self.b,
            'C': (*[math.fsum(row) for row in self.a], 1.0),
            'TOTAL': stages,
            'BC': 0.5,
            'ERROR': self.error,
            'TURN': self._family.TURN,
            'TURN_START': self._family.TURN_START,
            'REORTHONORMALISE': self.reorthonormalise,
        }

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        return specialise(
            _advance_free,
            name=name,
            step_points=specialise(points.step_under_held_force, name=name, **self._constants()),
            advance_one=self.coupled(
                name, scene='free', evaluate=no_forces, velocity_dependent=False
            ),
        )

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        if self.matrix:
            name = f'{name}_matrix{"_reorthonormalised" if self.reorthonormalise else ""}'
        constants = self._constants()

        def part(function: Any) -> Callable[..., Any]:
            return specialise(function, name=name, inlined=True, **constants)

        return specialise(
            _advance,
            name=f'{name}__{scene}',
            evaluate=evaluate,
            move_points=part(points.move),
            end_points=part(points.end),
            error_of_points=part(substeps.error_of_points),
            **self._turns(part),
            **constants,
        )

    @property
    def _family(self) -> Any:
        return matrices if self.matrix else turns

    def _turns(self, part: Callable[..., Any]) -> dict[str, Callable[..., Any]]:
        """Give the parts of a step that turn."""
        if not self.turning:
            stages: Any = no_rotation
            keeping: Any = no_rotation
        else:
            stages = self._family
            keeping = substeps_of_matrices if self.matrix else substeps
        bound: Any = part if self.turning else lambda function: function
        return {
            'begin_turns': stages.begin,
            'move_turns': bound(stages.move),
            'slope_of_turns': stages.slope_of,
            'end_turns': bound(stages.end),
            'set_rate': (keeping if self.matrix else stages).set_rate,
            'save_turns': keeping.save_turns,
            'restore_turns': keeping.restore_turns,
            'error_of_turns': bound(keeping.error_of_turns),
        }

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        stages, of = len(self.b), self._family
        turn = of.TURN_START + of.TURN * (stages + 2)
        return HEAD + max(blocks, 1) * (POINT * (stages + 3) + turn)
