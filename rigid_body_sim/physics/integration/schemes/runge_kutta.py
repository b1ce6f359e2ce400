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
`state_space.matrices`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.integration.schemes.stages import stages_of
from rigid_body_sim.physics.integration.schemes.state_space import (
    no_rotation,
    points,
    quaternions,
)
from rigid_body_sim.physics.integration.schemes.state_space.matrices import MATRICES
from rigid_body_sim.physics.integration.schemes.state_space.no_rotation import NO_ROTATION
from rigid_body_sim.physics.integration.schemes.state_space.points import POINTS
from rigid_body_sim.physics.integration.schemes.state_space.protocol import StateSpace, bound
from rigid_body_sim.physics.integration.schemes.state_space.quaternions import (
    LADDER_STAGES,
    QUATERNIONS,
)
from rigid_body_sim.physics.integration.schemes.steps import finite, start_evaluation
from rigid_body_sim.physics.state.blocks import ROTATION, TRANSLATION, block_count, lanes_in

# bound for each tableau
STAGES = slot('[-] stages of a step')
C = slot('[tick] time of each stage')
POINTS_WORK = slot('[-] numbers of the workspace of a block of points')
step_points = slot('kernel (lanes, h, state, work): steps points under a held force')
step_rotation = slot('kernel (lanes, h, state, work): steps rotations under a held torque')
prepare_points = slot('kernel of `stages.Stages`')
prepare_rotation = slot('kernel of `stages.Stages`')
take_slopes_of_points = slot('kernel of `stages.Stages`')
take_slopes_of_rotation = slot('kernel of `stages.Stages`')
finish_points = slot('kernel of `stages.Stages`')
finish_rotation = slot('kernel of `stages.Stages`')
# bound for each scene
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')


def _advance_free(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies on which only held forces act. Return DONE, or NaN if a number left the finite
    ones.
    """
    for block in range(block_count(n_bodies)):
        lanes = lanes_in(block, n_bodies)
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        for _tick in range(ticks):
            step_points(lanes, h, state, workspace)
    for block in range(block_count(n_rigid)):
        lanes = lanes_in(block, n_rigid)
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        for _tick in range(ticks):
            step_rotation(lanes, h, state, workspace)
    return finite(n_bodies, n_rigid, translation, rotation)


def _advance_coupled(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies whose forces depend on the state. Return DONE, or NaN if a number left the
    finite ones.
    """
    rotation_work = workspace[block_count(n_bodies) * POINTS_WORK :]
    for passed in range(ticks):
        for stage in range(STAGES):
            prepare_points(stage, h, n_bodies, translation, workspace, method)
            prepare_rotation(stage, h, n_rigid, rotation, rotation_work, method)
            start_evaluation(n_bodies, n_rigid, translation, rotation)
            evaluate(0, (tick + passed + C[stage]) * h, translation, rotation, elements, ranges)
            take_slopes_of_points(stage, n_bodies, translation, workspace)
            take_slopes_of_rotation(stage, n_rigid, rotation, rotation_work)
        finish_points(h, n_bodies, translation, workspace, method)
        finish_rotation(h, n_rigid, rotation, rotation_work, method)
    return finite(n_bodies, n_rigid, translation, rotation)


@inline
def no_forces(place, time, translation, rotation, elements, ranges):
    """Evaluate nothing."""


def of_explicit(a: Sequence[Sequence[float]], b: Sequence[float], z: complex) -> complex:
    """Give R(z) = 1 + sum b_i k_i,   k_i = z (1 + sum_j a_ij k_j), of an explicit tableau."""
    slopes: list[complex] = []
    for row in a:
        slopes.append(z * (1.0 + sum(x * k for x, k in zip(row, slopes, strict=False))))
    return 1.0 + sum(weight * k for weight, k in zip(b, slopes, strict=True))


def square(a: tuple[tuple[float, ...], ...]) -> tuple[float, ...]:
    """Give a tableau row by row with its zeros, as the stages want it bound."""
    return tuple(x for row in a for x in (*row, *[0.0] * (len(a) - len(row))))


def coupled_kernel(
    space: StateSpace, *, name: str, scene: str, evaluate: Callable[..., Any], tableau: Any
) -> Callable[..., Any]:
    """Make the kernel that advances points, and rotations in a state space."""
    of_points = stages_of(POINTS, name=name, tableau=tableau)
    of_rotation = stages_of(space, name=with_orientation(name, space), tableau=tableau)
    return specialise(
        _advance_coupled,
        name=f'{with_orientation(name, space)}__{scene}',
        offered=tableau,
        POINTS_WORK=POINTS.work_size(tableau['STAGES']),
        evaluate=evaluate,
        prepare_points=of_points.prepare,
        prepare_rotation=of_rotation.prepare,
        take_slopes_of_points=of_points.take_slopes,
        take_slopes_of_rotation=of_rotation.take_slopes,
        finish_points=of_points.finish,
        finish_rotation=of_rotation.finish,
    )


def free_kernel(
    step_rotation: Callable[..., Any], *, name: str, tableau: Any
) -> Callable[..., Any]:
    """Make the kernel that advances bodies under held forces, each block by itself."""
    return specialise(
        _advance_free,
        name=name,
        step_points=bound(points.step_under_held_force, name=name, offered=tableau),
        step_rotation=step_rotation,
    )


def with_orientation(name: str, space: StateSpace) -> str:
    """Name a method after the state space of its rotation."""
    return f'{name}_matrix' if space is MATRICES else name


@dataclass(frozen=True)
class RungeKutta:
    """
    An explicit Runge–Kutta scheme.

    a                : rows of the tableau, row i with its i entries left of the diagonal
    b                : weights, sum 1
    matrix           : carry the orientation as a matrix, see `state_space.matrices`, in place of a
                       quaternion
    reorthonormalise : then replace it by the nearest rotation after each step
    rotates          : False for point masses alone
    """

    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    matrix: bool = False
    reorthonormalise: bool = True
    rotates: bool = True

    def for_points(self) -> RungeKutta:
        """Return the same scheme without rotation."""
        return replace(self, matrix=False, rotates=False)

    @property
    def c(self) -> tuple[float, ...]:
        """Nodes: row sums of the tableau."""
        return tuple(math.fsum(row) for row in self.a)

    @property
    def _space(self) -> StateSpace:
        """The state space of rotations."""
        if not self.rotates:
            return NO_ROTATION
        return MATRICES if self.matrix else QUATERNIONS

    def _is_ladder(self) -> bool:
        """Whether each of a few stages builds on the one before it alone."""
        return len(self.b) <= LADDER_STAGES and not any(any(row[:-1]) for row in self.a)

    def _tableau(self) -> dict[str, Any]:
        zeros = (0.0,) * LADDER_STAGES
        return {
            'STAGES': len(self.b),
            'A': square(self.a),
            'B': self.b,
            'C': self.c,
            'BC': math.fsum(b * c for b, c in zip(self.b, self.c, strict=True)),
            'TOTAL': 0,
            'FOR_FORCES': True,
            'WEIGHTS': (*self.b, *zeros)[:LADDER_STAGES],
            'LADDER': (0.0, *[row[-1] for row in self.a[1:]], *zeros)[:LADDER_STAGES],
            'REORTHONORMALISE': self.reorthonormalise,
        }

    def _step_of_rotation(self, name: str) -> Callable[..., Any]:
        """Make the kernel of a step of quaternions under held torques."""
        tableau = self._tableau()
        if self._is_ladder():
            return bound(quaternions.step_on_a_ladder, name=name, offered=tableau)
        move = bound(quaternions.move, name=name, offered={**tableau, 'FOR_FORCES': False})
        end = bound(quaternions.end, name=name, offered=tableau)
        whole = {**tableau, 'move_stage': move, 'end_step': end}
        return bound(quaternions.step, name=name, offered=whole)

    def stability_function(self, z: complex) -> complex:
        """Give R(z): y1 = R(h l) y0 for y' = l y."""
        return of_explicit(self.a, self.b, z)

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        if self.matrix:
            return self.coupled(name, scene='free', evaluate=no_forces, velocity_dependent=False)
        step = self._step_of_rotation(name) if self.rotates else no_rotation.step
        return free_kernel(step, name=name, tableau=self._tableau())

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        return coupled_kernel(
            self._space, name=name, scene=scene, evaluate=evaluate, tableau=self._tableau()
        )

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        stages = len(self.b)
        return max(blocks, 1) * (POINTS.work_size(stages) + self._space.work_size(stages))
