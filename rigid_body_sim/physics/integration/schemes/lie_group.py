# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The commutator-free Lie-group Runge–Kutta method of order four on (r, p, q, L).

Attitudes are composed of rotations, so that every stage is one and the last needs no projection:

    k_i = I^-1 R(q_i)^T L_i                      omega of a stage, body axes
    q2 = q exp(h k1/2),   q3 = q exp(h k2/2),   q4 = q2 exp(h (k3 - k1/2))
    q <- q exp(h (3 k1 + 2 k2 + 2 k3 - k4)/12) exp(h (-k1 + 2 k2 + 2 k3 + 3 k4)/12)

r, p and L' = torque take the classical method of order four, L_i = L + a_i h torque_(i-1).
Without torque L is not touched. The price of L in world axes: an error of the attitude changes
omega by up to I_max / I_min times itself, so a thin rod needs small steps.

Source: Celledoni, Marthinsen & Owren, Future Gener. Comput. Syst. 19 (2003); Hairer, Lubich &
Wanner, IV.8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.integration.free_rotation.euler import exponential
from rigid_body_sim.physics.integration.schemes.runge_kutta import (
    coupled_kernel,
    free_kernel,
    of_explicit,
)
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    multiply,
    normalised,
    read_quaternion,
    read_vector,
    write_quaternion,
    write_vector,
)
from rigid_body_sim.physics.integration.schemes.state_space.no_rotation import NO_ROTATION
from rigid_body_sim.physics.integration.schemes.state_space.points import POINTS
from rigid_body_sim.physics.integration.schemes.state_space.protocol import StateSpace
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    INVERSE_MOMENTS,
    LANES,
    ORIENTATION,
    ROTATION,
    TORQUE,
    rotated_back,
)
from rigid_body_sim.physics.vectors import add, add_scaled, scale, subtract

slope_rows = Record(stride=LANES)
K_RATE = slope_rows.vector('rad/s', 'k, omega of the stage, body axes')
K_TORQUE = slope_rows.vector('N m', 'of the stage, world axes')
SLOPE_SIZE = slope_rows.size

work_rows = Record(stride=LANES)
Y_ORIENTATION = work_rows.quaternion('-', 'q at the start of the step')
Y_MOMENTUM = work_rows.vector('kg m^2/s', 'L at the start of the step, world axes')
SECOND = work_rows.quaternion('-', 'q2')
FIRST_SLOPE = work_rows.size  # where the slope of each stage begins
SECOND_SLOPE = FIRST_SLOPE + SLOPE_SIZE
THIRD_SLOPE = SECOND_SLOPE + SLOPE_SIZE
LAST_SLOPE = THIRD_SLOPE + SLOPE_SIZE
LAST_STAGE = 3

# the classical tableau, which points take
CLASSICAL: dict[str, Any] = {
    'STAGES': 4,
    'A': (0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
    'B': (1 / 6, 1 / 3, 1 / 3, 1 / 6),
    'C': (0.0, 0.5, 0.5, 1.0),
    'BC': 0.5,
    'TOTAL': 0,
}


@inline
def _after(q, angle):
    """q exp(angle), a rotation vector in body axes."""
    x, y, z, w = q
    ex, ey, ez, ew = exponential(0.5 * angle[0], 0.5 * angle[1], 0.5 * angle[2])
    return (
        x * ew + w * ex + (y * ez - z * ey),
        y * ew + w * ey + (z * ex - x * ez),
        z * ew + w * ez + (x * ey - y * ex),
        w * ew - (x * ex + y * ey + z * ez),
    )


@inline
def _rate(q, momentum, inverses):
    """Omega in body axes: I^-1 R^T L."""
    return multiply(rotated_back(q, momentum), inverses)


@inline
def _last(q, h, k1, k2, k3, k4):
    """Attitude at the end of the step, of unit length."""
    twelfth = h / 12.0
    middle = scale(2.0, add(k2, k3))
    q = _after(q, scale(twelfth, add(middle, subtract(scale(3.0, k1), k4))))
    q = _after(q, scale(twelfth, add(middle, subtract(scale(3.0, k4), k1))))
    return normalised(q)


@kernel
def step(lanes, h, state, work):
    """Step free or steadily torqued rotations."""
    half = 0.5 * h
    for lane in range(lanes):
        start = read_quaternion(state, lane + ORIENTATION)
        momentum = read_vector(state, lane + ANGULAR_MOMENTUM)
        inverses = read_vector(state, lane + INVERSE_MOMENTS)
        kick = scale(h, read_vector(state, lane + TORQUE))
        k1 = _rate(start, momentum, inverses)
        second = _after(start, scale(half, k1))
        half_way = add_scaled(momentum, 0.5, kick)
        k2 = _rate(second, half_way, inverses)
        third = _after(start, scale(half, k2))
        k3 = _rate(third, half_way, inverses)
        fourth = _after(second, subtract(scale(h, k3), scale(half, k1)))
        momentum = add(momentum, kick)
        k4 = _rate(fourth, momentum, inverses)
        write_quaternion(state, lane + ORIENTATION, _last(start, h, k1, k2, k3, k4))
        write_vector(state, lane + ANGULAR_MOMENTUM, momentum)


@kernel
def begin(lanes, state, work, memory):
    """Remember the state at the start of the step."""
    for lane in range(lanes):
        write_quaternion(work, lane + Y_ORIENTATION, read_quaternion(state, lane + ORIENTATION))
        write_vector(work, lane + Y_MOMENTUM, read_vector(state, lane + ANGULAR_MOMENTUM))


@kernel
def slope_of(lanes, state, work, slope):
    """Keep omega and torque of a stage."""
    for lane in range(lanes):
        rate = _rate(
            read_quaternion(state, lane + ORIENTATION),
            read_vector(state, lane + ANGULAR_MOMENTUM),
            read_vector(state, lane + INVERSE_MOMENTS),
        )
        write_vector(slope, lane + K_RATE, rate)
        write_vector(slope, lane + K_TORQUE, read_vector(state, lane + TORQUE))


@kernel
def _rotate_by(lanes, start, factor, slope, back, first, state):
    """Attitude of a stage: start exp(factor k - back k1)."""
    for lane in range(lanes):
        angle = subtract(
            scale(factor, read_vector(slope, lane + K_RATE)),
            scale(back, read_vector(first, lane + K_RATE)),
        )
        write_quaternion(state, lane + ORIENTATION, _after(read_quaternion(start, lane), angle))


@kernel
def _kick_by(lanes, factor, slope, work, state):
    """L of a stage: L at the start + factor torque."""
    for lane in range(lanes):
        momentum = read_vector(work, lane + Y_MOMENTUM)
        torque = read_vector(slope, lane + K_TORQUE)
        write_vector(state, lane + ANGULAR_MOMENTUM, add_scaled(momentum, factor, torque))


@kernel
def move(stage, lanes, h, state, work):
    """Make the state of a stage from those before it."""
    place = FIRST_SLOPE + SLOPE_SIZE * (stage - 1)
    slope, first = work[place : place + SLOPE_SIZE], work[FIRST_SLOPE:SECOND_SLOPE]
    if stage == LAST_STAGE:
        _rotate_by(lanes, work[SECOND:FIRST_SLOPE], h, slope, 0.5 * h, first, state)
        _kick_by(lanes, h, slope, work, state)
    else:
        start = work[Y_ORIENTATION:Y_MOMENTUM]
        _rotate_by(lanes, start, 0.5 * h, slope, 0.0, first, state)
        _kick_by(lanes, 0.5 * h, slope, work, state)
    if stage == 1:
        for lane in range(lanes):
            write_quaternion(work, lane + SECOND, read_quaternion(state, lane + ORIENTATION))


@kernel
def end(lanes, h, state, work, memory):
    """Put the stages together."""
    sixth = h / 6.0
    for lane in range(lanes):
        orientation = _last(
            read_quaternion(work, lane + Y_ORIENTATION),
            h,
            read_vector(work, lane + FIRST_SLOPE + K_RATE),
            read_vector(work, lane + SECOND_SLOPE + K_RATE),
            read_vector(work, lane + THIRD_SLOPE + K_RATE),
            read_vector(work, lane + LAST_SLOPE + K_RATE),
        )
        write_quaternion(state, lane + ORIENTATION, orientation)
        outer = add(
            read_vector(work, lane + FIRST_SLOPE + K_TORQUE),
            read_vector(work, lane + LAST_SLOPE + K_TORQUE),
        )
        inner = add(
            read_vector(work, lane + SECOND_SLOPE + K_TORQUE),
            read_vector(work, lane + THIRD_SLOPE + K_TORQUE),
        )
        momentum = read_vector(work, lane + Y_MOMENTUM)
        total = add_scaled(outer, 2.0, inner)
        write_vector(state, lane + ANGULAR_MOMENTUM, add_scaled(momentum, sixth, total))


ROTATIONS = StateSpace(
    state_size=ROTATION,
    memory_size=0,
    slopes_at=FIRST_SLOPE,
    slope_size=SLOPE_SIZE,
    begin=begin,
    move=move,
    slope_of=slope_of,
    end=end,
)


@dataclass(frozen=True)
class LieRungeKutta4:
    """
    The commutator-free method of order four; points take the classical one.

    rotates : False for point masses alone
    """

    rotates: bool = True

    def for_points(self) -> LieRungeKutta4:
        """Return the same scheme without rotation."""
        return replace(self, rotates=False)

    @property
    def _space(self) -> StateSpace:
        """The state space of rotations."""
        return ROTATIONS if self.rotates else NO_ROTATION

    def stability_function(self, z: complex) -> complex:
        """Give R(z): y1 = R(h l) y0 for y' = l y."""
        n = CLASSICAL['STAGES']
        rows = [CLASSICAL['A'][i * n : (i + 1) * n] for i in range(n)]
        return of_explicit(rows, CLASSICAL['B'], z)

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        return free_kernel(
            step if self.rotates else no_rotation.step, name=name, tableau=CLASSICAL
        )

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        return coupled_kernel(
            self._space, name=name, scene=scene, evaluate=evaluate, tableau=CLASSICAL
        )

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        stages = CLASSICAL['STAGES']
        return max(blocks, 1) * (POINTS.work_size(stages) + self._space.work_size(stages))
