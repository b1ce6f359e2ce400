# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Explicit Runge–Kutta schemes on (r, p, q, omega_body), any tableau.

    Y_i = y + h sum_{j < i} a_ij K_j,   K_i = f(t + c_i h, Y_i),   y <- y + h sum_i b_i K_i

The body rate is integrated, not the angular momentum in world axes: with q' = q (I^-1 R^T L, 0) /
2 an attitude error would change omega by up to I_max / I_min times itself, which on a needle
raises the energy a thousandfold. L is rebuilt from omega after the step, so these methods do not
keep it.

With `orientation: matrix` the state is that of the lecture, (r, R, p, L): see
`stages_of_matrices`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, specialise, unbound
from rigid_body_sim.physics.integration.schemes.state_space import matrices as matrices
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation
from rigid_body_sim.physics.integration.schemes.state_space import points as points
from rigid_body_sim.physics.integration.schemes.state_space import quaternions as turns
from rigid_body_sim.physics.integration.schemes.state_space.matrices import MATRIX
from rigid_body_sim.physics.integration.schemes.state_space.points import POINT
from rigid_body_sim.physics.integration.schemes.state_space.points import begin as begin_points
from rigid_body_sim.physics.integration.schemes.state_space.points import (
    slope_of as slope_of_points,
)
from rigid_body_sim.physics.integration.schemes.steps import finite, start_evaluation
from rigid_body_sim.physics.state.blocks import ROTATION, TRANSLATION

# bound for each tableau, and `evaluate` for each scene, by `specialise`
STAGES = 1
C: tuple[float, ...] = (0.0,)
TURN = TURN_START = 0  # numbers of a slope of a rotation in a block; where the slopes begin
evaluate: Callable[..., Any] = unbound
step_points: Callable[..., Any] = unbound
step_turns: Callable[..., Any] = unbound
move_points: Callable[..., Any] = unbound
end_points: Callable[..., Any] = unbound
begin_turns: Callable[..., Any] = unbound
move_turns: Callable[..., Any] = unbound
slope_of_turns: Callable[..., Any] = unbound
end_turns: Callable[..., Any] = unbound


def _advance_free(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies on which only held forces act. Return 0, or NaN if a number left the finite
    ones.
    """
    for block in range((n_bodies + 63) // 64):
        lanes = min(64, n_bodies - 64 * block)
        s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
        for _tick in range(ticks):
            step_points(lanes, h, s)
    for block in range((n_rigid + 63) // 64):
        lanes = min(64, n_rigid - 64 * block)
        s = rotation[block * ROTATION : block * ROTATION + ROTATION]
        for _tick in range(ticks):
            step_turns(lanes, h, s, workspace)
    return finite(n_bodies, n_rigid, translation, rotation)


def _advance_coupled(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies whose forces depend on the state. Return 0, or NaN if a number left the finite
    ones.
    """
    point_blocks = (n_bodies + 63) // 64
    turn_blocks = (n_rigid + 63) // 64
    point_size = POINT * (STAGES + 1)
    turn_size = TURN_START + TURN * STAGES
    turn_workspace = workspace[point_blocks * point_size :]
    for passed in range(ticks):
        for stage in range(STAGES):
            for block in range(point_blocks):
                lanes = min(64, n_bodies - 64 * block)
                s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
                y = workspace[block * point_size : (block + 1) * point_size]
                if stage == 0:
                    begin_points(lanes, s, y)
                else:
                    move_points(stage, lanes, h, s, y)
            for block in range(turn_blocks):
                lanes = min(64, n_rigid - 64 * block)
                s = rotation[block * ROTATION : block * ROTATION + ROTATION]
                y = turn_workspace[block * turn_size : (block + 1) * turn_size]
                if stage == 0:
                    begin_turns(lanes, s, y, method[block * MATRIX : (block + 1) * MATRIX])
                else:
                    move_turns(stage, lanes, h, s, y)
            start_evaluation(n_bodies, n_rigid, translation, rotation)
            evaluate(0, (tick + passed + C[stage]) * h, translation, rotation, elements, ranges)
            for block in range(point_blocks):
                lanes = min(64, n_bodies - 64 * block)
                s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
                place = block * point_size + POINT * (stage + 1)
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
            end_points(lanes, h, s, workspace[block * point_size : (block + 1) * point_size])
        for block in range(turn_blocks):
            lanes = min(64, n_rigid - 64 * block)
            s = rotation[block * ROTATION : block * ROTATION + ROTATION]
            y = turn_workspace[block * turn_size : (block + 1) * turn_size]
            end_turns(lanes, h, s, y, method[block * MATRIX : (block + 1) * MATRIX])
    return finite(n_bodies, n_rigid, translation, rotation)


@inline
def no_forces(place, time, translation, rotation, elements, ranges):
    """Evaluate nothing."""


def square(a: tuple[tuple[float, ...], ...]) -> tuple[float, ...]:
    """Give a tableau row by row with its zeros, as the stages want it bound."""
    return tuple(x for row in a for x in (*row, *[0.0] * (len(a) - len(row))))


@dataclass(frozen=True)
class RungeKutta:
    """
    An explicit Runge–Kutta scheme.

    a                : rows of the tableau, row i with its i entries left of the diagonal
    b                : weights, sum 1
    matrix           : carry the orientation as a matrix, see `stages_of_matrices`, in place of a
                       quaternion
    reorthonormalise : then replace it by the nearest rotation after each step
    turning          : False for point masses alone
    """

    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    matrix: bool = False
    reorthonormalise: bool = True
    turning: bool = True

    def for_points(self) -> RungeKutta:
        """Return the same scheme without rotation."""
        return replace(self, matrix=False, turning=False)

    @property
    def c(self) -> tuple[float, ...]:
        """Nodes: row sums of the tableau."""
        return tuple(math.fsum(row) for row in self.a)

    def _is_ladder(self) -> bool:
        """Whether each of at most four stages builds on the one before it alone."""
        return len(self.b) <= 4 and not any(any(row[:-1]) for row in self.a)

    def _constants(self) -> dict[str, Any]:
        stages = len(self.b)
        b1, b2, b3 = (*self.b[1:4], 0.0, 0.0, 0.0)[:3]
        return {
            'STAGES': stages,
            'A': square(self.a),
            'B': self.b,
            'TOTAL': 0,
            'B1': b1,
            'B2': b2,
            'B3': b3,
            'C': self.c,
            'BC': math.fsum(b * c for b, c in zip(self.b, self.c, strict=True)),
            'LADDER': (*[row[-1] for row in self.a[1:]], 0.0, 0.0, 0.0)[:3],
            'TURN': matrices.TURN if self.matrix else turns.TURN,
            'TURN_START': matrices.TURN_START if self.matrix else turns.TURN_START,
            'REORTHONORMALISE': self.reorthonormalise,
        }

    def _part(self, name: str, function: Any, **more: Any) -> Callable[..., Any]:
        """Bind a part of a step, to be compiled into it."""
        return specialise(function, name=name, inlined=True, **self._constants(), **more)

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        if self.matrix:
            return self.coupled(name, scene='free', evaluate=no_forces, velocity_dependent=False)
        if not self.turning:
            step_turns = no_rotation.step
        elif self._is_ladder():
            step_turns = self._part(name, turns.step_on_a_ladder)
        else:
            step_turns = self._part(
                name,
                turns.step,
                move_=self._part(name, turns.move, FOR_FORCES=False),
                end_=self._part(name, turns.end),
            )
        return specialise(
            _advance_free,
            name=name,
            step_points=self._part(name, points.step_under_held_force),
            step_turns=step_turns,
            **self._constants(),
        )

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        family: Any = turns if self.turning else no_rotation
        if self.matrix:
            family = matrices
            name = f'{name}_matrix{"_reorthonormalised" if self.reorthonormalise else ""}'
        return specialise(
            _advance_coupled,
            name=f'{name}__{scene}',
            evaluate=evaluate,
            move_points=self._part(name, points.move),
            end_points=self._part(name, points.end),
            begin_turns=family.begin,
            move_turns=self._part(name, family.move) if self.turning else family.move,
            slope_of_turns=family.slope_of,
            end_turns=self._part(name, family.end) if self.turning else family.end,
            **self._constants(),
        )

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        stages = len(self.b)
        family: Any = matrices if self.matrix else turns
        return max(blocks, 1) * (POINT * (stages + 1) + family.TURN_START + family.TURN * stages)
