# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Splitting schemes: the forces act (kick), the bodies move freely (drift), in turn.

    kick b1 h, drift a1 h, kick b2 h, drift a2 h, …, kick b(s+1) h         sum a = sum b = 1

A kick changes momentum p and angular momentum L by the forces and torques of the instant; a drift
moves r by p/m and q by a propagator of the free rotation, with L fixed. With s = 1, b = (1/2, 1/2)
this is the method of Strang (1968) and Störmer–Verlet, of order two and time-symmetric whatever
the drift, exact for a constant force.

Where a force depends on velocity the kick is itself a differential equation; schemes of order two
and more take it by the explicit midpoint rule with positions at rest: the order stays.

Forces that depend on nothing (commands in world axes, uniform gravity) need no evaluation: each
block of bodies then runs through all ticks by itself while it is in the fastest cache. The result
has the same bits either way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import kernel, slot, specialise
from rigid_body_sim.physics.integration.schemes import steps
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    read_vector,
    write_vector,
)
from rigid_body_sim.physics.integration.schemes.steps import (
    finite,
    kick,
    kick_and_drift,
    start_evaluation,
)
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    LANES,
    MOMENTUM,
    MOMENTUM_RESIDUAL,
    ROTATION,
    TRANSLATION,
    block_count,
    lanes_in,
)

saved_rows = Record(stride=LANES)  # of a block, what the midpoint rule goes back to
SAVED_MOMENTUM = saved_rows.vector('kg m/s', 'p')
SAVED_RESIDUAL = saved_rows.vector('kg m/s', 'what rounding lost of p')
SAVED_ANGULAR_MOMENTUM = saved_rows.vector('kg m^2/s', 'L, world axes')
SAVED = saved_rows.size

# bound for each integrator
STAGES = slot('[-] drifts of a step')
KICKS = slot('[tick] share of the kick before each drift')
DRIFTS = slot('[tick] share of each drift')
LAST_KICK = slot('[tick] share of the kick after the last drift')
MIDPOINT_KICK = slot('[-] whether a kick takes the midpoint rule')
drift_rotation = slot('kernel (block, lanes, kick, h, rotation, method): kicks L and moves q')
kick_rotation = slot('kernel (block, lanes, h, rotation): kicks L')
kick_all = slot('kernel (n_bodies, n_rigid, h, translation, rotation): kicks all bodies')
# bound for each scene
VELOCITY_DEPENDENT = slot('[-] whether a force depends on velocity')
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')


def _advance_free(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies on which only held forces act, block by block. Return DONE, or NaN if a number
    left the finite ones.
    """
    for block in range(block_count(n_bodies)):
        lanes = lanes_in(block, n_bodies)
        for _tick in range(ticks):
            for stage in range(STAGES):
                kick_and_drift(block, lanes, KICKS[stage] * h, DRIFTS[stage] * h, translation)
            if LAST_KICK != 0.0:
                kick(block, lanes, LAST_KICK * h, translation)
    for block in range(block_count(n_rigid)):
        lanes = lanes_in(block, n_rigid)
        for _tick in range(ticks):
            for stage in range(STAGES):
                drift_rotation(block, lanes, KICKS[stage] * h, DRIFTS[stage] * h, rotation, method)
            if LAST_KICK != 0.0:
                kick_rotation(block, lanes, LAST_KICK * h, rotation)
    return finite(n_bodies, n_rigid, translation, rotation)


@kernel
def _save_momenta(n_bodies, n_rigid, translation, rotation, workspace):
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        saved = workspace[block * SAVED : (block + 1) * SAVED]
        for lane in range(lanes_in(block, n_bodies)):
            write_vector(saved, lane + SAVED_MOMENTUM, read_vector(state, lane + MOMENTUM))
            residual = read_vector(state, lane + MOMENTUM_RESIDUAL)
            write_vector(saved, lane + SAVED_RESIDUAL, residual)
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        saved = workspace[block * SAVED : (block + 1) * SAVED]
        for lane in range(lanes_in(block, n_rigid)):
            momentum = read_vector(state, lane + ANGULAR_MOMENTUM)
            write_vector(saved, lane + SAVED_ANGULAR_MOMENTUM, momentum)


@kernel
def _restore_momenta(n_bodies, n_rigid, translation, rotation, workspace):
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        saved = workspace[block * SAVED : (block + 1) * SAVED]
        for lane in range(lanes_in(block, n_bodies)):
            write_vector(state, lane + MOMENTUM, read_vector(saved, lane + SAVED_MOMENTUM))
            residual = read_vector(saved, lane + SAVED_RESIDUAL)
            write_vector(state, lane + MOMENTUM_RESIDUAL, residual)
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        saved = workspace[block * SAVED : (block + 1) * SAVED]
        for lane in range(lanes_in(block, n_rigid)):
            momentum = read_vector(saved, lane + SAVED_ANGULAR_MOMENTUM)
            write_vector(state, lane + ANGULAR_MOMENTUM, momentum)


def _kick_all(n_bodies, n_rigid, time, translation, rotation):
    for block in range(block_count(n_bodies)):
        kick(block, lanes_in(block, n_bodies), time, translation)
    for block in range(block_count(n_rigid)):
        kick_rotation(block, lanes_in(block, n_rigid), time, rotation)


def _advance_coupled(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies whose forces depend on the state of any of them. Return DONE, or NaN if a
    number left the finite ones.
    """
    fresh = False  # whether the forces are those of the present state
    for passed in range(ticks):
        elapsed = 0.0  # share of the tick
        for stage in range(STAGES + 1):
            share = LAST_KICK if stage == STAGES else KICKS[stage]
            if share != 0.0:
                time = (tick + passed + elapsed) * h
                if not fresh:
                    start_evaluation(n_bodies, n_rigid, translation, rotation)
                    evaluate(0, time, translation, rotation, elements, ranges)
                if MIDPOINT_KICK:
                    _save_momenta(n_bodies, n_rigid, translation, rotation, workspace)
                    kick_all(n_bodies, n_rigid, 0.5 * share * h, translation, rotation)
                    start_evaluation(n_bodies, n_rigid, translation, rotation)
                    evaluate(0, time, translation, rotation, elements, ranges)
                    _restore_momenta(n_bodies, n_rigid, translation, rotation, workspace)
                fresh = not VELOCITY_DEPENDENT
            if stage < STAGES:
                drift = DRIFTS[stage]
                for block in range(block_count(n_bodies)):
                    lanes = lanes_in(block, n_bodies)
                    kick_and_drift(block, lanes, share * h, drift * h, translation)
                for block in range(block_count(n_rigid)):
                    lanes = lanes_in(block, n_rigid)
                    drift_rotation(block, lanes, share * h, drift * h, rotation, method)
                elapsed += drift
                fresh = False
            elif share != 0.0:
                kick_all(n_bodies, n_rigid, share * h, translation, rotation)
    return finite(n_bodies, n_rigid, translation, rotation)


@dataclass(frozen=True)
class Splitting:
    """
    A splitting scheme.

    kicks, drifts  : shares of the tick; one kick more than drifts
    drift_rotation : kernel of a free-rotation propagator, see `free_rotation`: kicks L and moves q
                     of one block
    """

    kicks: tuple[float, ...]
    drifts: tuple[float, ...]
    drift_rotation: Callable[..., Any]
    order: int

    def for_points(self) -> Splitting:
        """Return the same scheme without rotation."""
        return replace(self, drift_rotation=no_rotation.drift)

    def _shares(self) -> dict[str, Any]:
        return {
            'STAGES': len(self.drifts),
            'KICKS': self.kicks[:-1],
            'LAST_KICK': self.kicks[-1],
            'DRIFTS': self.drifts,
            'drift_rotation': self.drift_rotation,
        }

    def _rotates(self) -> bool:
        return self.drift_rotation is not no_rotation.drift

    def _kick_rotation(self) -> Callable[..., Any]:
        return steps.kick_rotation if self._rotates() else no_rotation.kick

    def kick_all(self) -> Callable[..., Any]:
        """Make the kernel that lets all forces act for a time."""
        return specialise(
            _kick_all,
            name='all' if self._rotates() else 'points',
            kick_rotation=self._kick_rotation(),
        )

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        return specialise(
            _advance_free, name=name, kick_rotation=self._kick_rotation(), **self._shares()
        )

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        return specialise(
            _advance_coupled,
            name=f'{name}__{scene}',
            evaluate=evaluate,
            VELOCITY_DEPENDENT=velocity_dependent,
            MIDPOINT_KICK=velocity_dependent and self.order > 1,
            kick_all=self.kick_all(),
            **self._shares(),
        )

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a coupled step writes beside the state."""
        return SAVED * blocks
