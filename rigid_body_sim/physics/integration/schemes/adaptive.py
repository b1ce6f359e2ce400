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

With `orientation: matrix` the rotation is (R, L), see `state_space.matrices`, and its error that
of these: |.| of R is the root of the sum of its squares.

In a scene without forces that depend on the state each body has substeps of its own; else all
bodies share them. Where no substep down to 1e-12 of the tick is accepted, the state of the worst
body is set to NaN, which names it, and DID_NOT_CONVERGE is returned.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.integration.schemes.runge_kutta import (
    no_forces,
    square,
    with_orientation,
)
from rigid_body_sim.physics.integration.schemes.stages import SUBSTEP_SLOPES, substeps_of
from rigid_body_sim.physics.integration.schemes.state_space import points
from rigid_body_sim.physics.integration.schemes.state_space.matrices import MATRICES
from rigid_body_sim.physics.integration.schemes.state_space.no_rotation import NO_ROTATION
from rigid_body_sim.physics.integration.schemes.state_space.points import POINTS
from rigid_body_sim.physics.integration.schemes.state_space.protocol import StateSpace, bound
from rigid_body_sim.physics.integration.schemes.state_space.quaternions import QUATERNIONS
from rigid_body_sim.physics.integration.schemes.steps import finite, start_evaluation
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE, DONE
from rigid_body_sim.physics.state.blocks import (
    LANES,
    ORIENTATION,
    POSITION,
    ROTATION,
    TRANSLATION,
    at,
    block_count,
    lanes_in,
)

head = Record()  # of the workspace
RTOL = head.number('-', 'relative tolerance')
ATOL = head.number('SI unit of each vector', 'absolute tolerance')
TRIED = head.number('-', 'substeps tried since the workspace was made')
HEAD_SIZE = head.padding(LANES)

SMALLEST = 1e-12  # [tick] substep at which the control gives up
MOST_SUBSTEPS = 1_000_000  # of one tick, likewise
ALL_OF_THE_REST = 0.999999  # [-] a substep of so much of the rest of a tick takes all of it
SAFETY = 0.9  # [-] of the substep that would just be accepted; nearer to 1 more are refused
LEAST, LARGEST = 0.2, 5.0  # [-] change of the substep at once
SMALLEST_ERROR = 1e-10  # [-] a smaller one counts as this
LEAST_BEFORE = 1e-4  # [-] a smaller error counts as this where it is the one before

# bound for each pair
STAGES = slot('[-] stages of a substep, without the slope at the new state')
C = slot('[substep] time of each stage, and of the slope at the new state')
MEMORY_SIZE = slot('[-] numbers of a block of what the rotation does not hold')
POINTS_WORK = slot('[-] numbers of the workspace of a block of points')
begin_points = slot('kernel of `stages.Substeps`')
begin_rotation = slot('kernel of `stages.Substeps`')
prepare_points = slot('kernel of `stages.Substeps`')
prepare_rotation = slot('kernel of `stages.Substeps`')
take_slopes_of_points = slot('kernel of `stages.Substeps`')
take_slopes_of_rotation = slot('kernel of `stages.Substeps`')
error_of_points = slot('kernel of `stages.Substeps`')
error_of_rotation = slot('kernel of `stages.Substeps`')
end_points = slot('kernel of `stages.Substeps`')
end_rotation = slot('kernel of `stages.Substeps`')
step_points = slot('kernel (lanes, h, state, work): steps points under a held force')
advance_one = slot('kernel: `_advance` of a scene without forces that depend on the state')
# bound for each scene
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')


@inline
def _after_acceptance(error, before, refused):
    """Factor of the substep after one with this error: 0.9 e^(-1/8) e_before^(1/16)."""
    counted = max(error, SMALLEST_ERROR)
    factor = SAFETY * math.sqrt(math.sqrt(math.sqrt(math.sqrt(before) / counted)))
    factor = min(max(factor, LEAST), LARGEST)
    return min(factor, 1.0) if refused else factor


@inline
def _after_refusal(error):
    """
    Factor of the substep after one refused with this error, which may be no number: 0.9 e^(-1/4).
    """
    if error < math.inf:
        return max(LEAST, SAFETY / math.sqrt(math.sqrt(error)))
    return LEAST


def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """Advance with substeps that all bodies share. Return DONE, NaN, or DID_NOT_CONVERGE."""
    tolerances = workspace[RTOL], workspace[ATOL]
    points_work = workspace[HEAD_SIZE:]
    rotation_work = points_work[block_count(n_bodies) * POINTS_WORK :]
    fresh = False  # whether y and the first slope are those of the present state
    for passed in range(ticks):
        elapsed = 0.0  # share of the tick
        share = 1.0  # of the substep
        before = 1.0  # error of the substep before
        refused = False
        count = 0
        while elapsed < 1.0:
            rest = 1.0 - elapsed
            last = share >= ALL_OF_THE_REST * rest
            if last:
                share = rest
            elif 2.0 * share > rest:
                share = 0.5 * rest
            step = share * h
            if not fresh:
                begin_points(n_bodies, translation, points_work, method)
                begin_rotation(n_rigid, rotation, rotation_work, method)
            for stage in range(STAGES + 1):
                if stage == 0 and fresh:
                    continue
                prepare_points(stage, step, n_bodies, translation, points_work, method)
                prepare_rotation(stage, step, n_rigid, rotation, rotation_work, method)
                within = 1.0 if last and stage == STAGES else elapsed + C[stage] * share
                start_evaluation(n_bodies, n_rigid, translation, rotation)
                evaluate(0, (tick + passed + within) * h, translation, rotation, elements, ranges)
                take_slopes_of_points(stage, n_bodies, translation, points_work)
                take_slopes_of_rotation(stage, n_rigid, rotation, rotation_work)
            worst, culprit = 0.0, -1
            worst, culprit = error_of_points(
                step, n_bodies, translation, points_work, tolerances, worst, culprit
            )
            worst, culprit = error_of_rotation(
                step, n_rigid, rotation, rotation_work, tolerances, worst, culprit
            )
            accepted = worst <= 1.0
            end_points(accepted, n_bodies, translation, points_work, method)
            end_rotation(accepted, n_rigid, rotation, rotation_work, method)
            fresh = True
            count += 1
            workspace[TRIED] += 1.0
            if accepted:
                elapsed = 1.0 if last else elapsed + share
                share *= _after_acceptance(worst, before, refused)
                before = max(worst, LEAST_BEFORE)
            else:
                share *= _after_refusal(worst)
            refused = not accepted
            if share < SMALLEST or count > MOST_SUBSTEPS:
                if n_bodies > 0:
                    translation[at(max(culprit, 0), TRANSLATION) + POSITION] = math.nan
                else:
                    rotation[at(max(culprit, 0), ROTATION) + ORIENTATION] = math.nan
                return DID_NOT_CONVERGE
    return finite(n_bodies, n_rigid, translation, rotation)


def _advance_free(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies on which only held forces act, each with substeps of its own: translation is
    exact.
    """
    for block in range(block_count(n_bodies)):
        lanes = lanes_in(block, n_bodies)
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        for _tick in range(ticks):
            step_points(lanes, h, state, workspace)
    status = finite(n_bodies, 0, translation, rotation)
    for i in range(n_rigid):
        own = rotation[at(i, ROTATION) :]
        memory = method[at(i, MEMORY_SIZE) :]
        one = advance_one(
            ticks, tick, h, 0, 1, translation[:0], own, memory, workspace, elements, ranges
        )
        if one != DONE:
            status = one
    return status


@dataclass(frozen=True)
class EmbeddedPair:
    """
    An explicit Runge–Kutta pair whose last slope is the first of the next step.

    a     : rows of the tableau, without the last one
    b     : weights of the higher order, which goes on; also the last row of the tableau
    error : b - b*, with the weight of the slope at the new state as the last
    matrix, reorthonormalise, rotates : as for `runge_kutta.RungeKutta`
    """

    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    error: tuple[float, ...]
    matrix: bool = False
    reorthonormalise: bool = True
    rotates: bool = True

    def for_points(self) -> EmbeddedPair:
        """Return the same pair without rotation."""
        return replace(self, matrix=False, rotates=False)

    @property
    def _space(self) -> StateSpace:
        """The state space of rotations."""
        if not self.rotates:
            return NO_ROTATION
        return MATRICES if self.matrix else QUATERNIONS

    def _tableau(self) -> dict[str, Any]:
        stages = len(self.b)
        return {
            'STAGES': stages,
            'A': square(self.a),
            'B': self.b,
            'C': (*[math.fsum(row) for row in self.a], 1.0),
            'TOTAL': stages,
            'BC': 0.5,
            'ERROR': self.error,
            'FOR_FORCES': True,
            'REORTHONORMALISE': self.reorthonormalise,
        }

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        return specialise(
            _advance_free,
            name=name,
            MEMORY_SIZE=self._space.memory_size,
            step_points=bound(points.step_under_held_force, name=name, offered=self._tableau()),
            advance_one=self.coupled(
                name, scene='free', evaluate=no_forces, velocity_dependent=False
            ),
        )

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        tableau = self._tableau()
        of_points = substeps_of(POINTS, name=name, tableau=tableau)
        name = with_orientation(name, self._space)
        of_rotation = substeps_of(self._space, name=name, tableau=tableau)
        return specialise(
            _advance,
            name=f'{name}__{scene}',
            offered=tableau,
            POINTS_WORK=POINTS.work_size(len(self.b) + SUBSTEP_SLOPES),
            evaluate=evaluate,
            begin_points=of_points.begin,
            begin_rotation=of_rotation.begin,
            prepare_points=of_points.prepare,
            prepare_rotation=of_rotation.prepare,
            take_slopes_of_points=of_points.take_slopes,
            take_slopes_of_rotation=of_rotation.take_slopes,
            error_of_points=of_points.error,
            error_of_rotation=of_rotation.error,
            end_points=of_points.end,
            end_rotation=of_rotation.end,
        )

    def steps_taken(self, workspace: Any) -> float:
        """Count the substeps tried with a workspace so far."""
        return float(workspace[TRIED])

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        slopes = len(self.b) + SUBSTEP_SLOPES
        each = POINTS.work_size(slopes) + self._space.work_size(slopes)
        return HEAD_SIZE + max(blocks, 1) * each
