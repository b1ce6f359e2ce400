# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Order four from two drifts: kick, drift, corrected kick, drift, kick, all forwards in time.

    kick h/6, drift h/2, kick 2h/3 with F*, drift h/2, kick h/6

A drift is a free motion with p and L held: it needs them right on the average over its half of the
step, which the kick of h/6 gives to order four. F* is the force of the middle, which depends on
what the forces are:

Forces that depend on position, attitude and time alone: F* is the force at the middle moved on by
h^2/24 of the acceleration that the force there gives,

    F* = F(x + h^2/24 M^-1 F(x)),   x = (r, q),   M^-1 F = (F/m, R I^-1 R^T torque)

the commutator [V, [T, V]] of Chin's scheme 4A (Suzuki 1995, Chin 1997) without a derivative: for
torques on rotations as well, because it moves the attitude and leaves L in world axes as it is.
Three evaluations a step, the last of one step being the first of the next; symmetric in time, and
but for terms of h^7 the flow of a Hamiltonian, so that the energy does not drift.

Forces that depend on velocity: the stages of Nyström (1925) for r'' = f(t, r, r') on the same two
drifts. With k1 .. k4 the forces and torques, from x_m behind the first drift and x_e behind the
second:

    k1  at the start
    k2  at x_m + h^2/24 M^-1 k1                 with p + h/2 k1
    k3  at the same place                       with p + h/2 k2
    k4  at x_e + h^2/6 M^-1 (2 k3 - k1 - k2)    with p + h k3
    F* = (k2 + k3)/2,  last kick h/6 k4

Four evaluations a step and no substep backwards, so dampers damp; order four for any smooth force,
but energy is kept no better than that.

Where nothing acts but what is held over the tick both are the same kicks and drifts, which need no
evaluation at all: `splitting`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    multiply,
    nearly_normalised,
    read_quaternion,
    read_vector,
    write_quaternion,
    write_vector,
)
from rigid_body_sim.physics.integration.schemes.steps import (
    finite,
    kick_and_drift,
    start_evaluation,
)
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    LANES,
    MOMENTUM,
    ORIENTATION,
    POSITION,
    ROTATION,
    TORQUE,
    TRANSLATION,
    block_count,
    lanes_in,
    rotated_back,
)
from rigid_body_sim.physics.vectors import add, add_scaled, cross, scale

KICKS = (1 / 6, 2 / 3, 1 / 6)
DRIFTS = (0.5, 0.5)

# a block of the workspace
rows = Record(stride=LANES)
KEPT_POSITION = rows.vector('m', 'r behind a drift')
KEPT_MOMENTUM = rows.vector('kg m/s', 'p there')
FORCE_1 = rows.vector('N', 'k1')
FORCE_2 = rows.vector('N', 'k2')
POINTS = rows.size
turning_rows = Record(stride=LANES)
KEPT_ORIENTATION = turning_rows.quaternion('-', 'q behind a drift')
KEPT_ANGULAR_MOMENTUM = turning_rows.vector('kg m^2/s', 'L there, world axes')
TORQUE_1 = turning_rows.vector('N m', 'torque of k1')
TORQUE_2 = turning_rows.vector('N m', 'torque of k2')
TURNS = turning_rows.size

# a place beside the motion at which forces are asked: shares of (k1, k2, what was evaluated last),
# of h^2 M^-1 k for r and q and of h k for p and L
AHEAD = 1 / 24  # of h^2 M^-1 k, for F*
SECOND = ((0.0, 0.0, AHEAD), (0.0, 0.0, 1 / 3))  # h/2 k1 = h/6 k1, which p has by then, + h/3 k1
THIRD = ((AHEAD, 0.0, 0.0), (-1 / 6, 0.0, 1 / 2))
FOURTH = ((-1 / 6, -1 / 2, 2 / 3), (-1 / 6, -1.0, 4 / 3))  # k3 = 2 F* - k2, F* the last
# what is kept on the way there
ALL, LAST, PLACE = 1, 2, 3  # place and k1; k2; the place alone

# bound for each integrator
drift_rotation = slot('kernel (block, lanes, kick, h, rotation, method): kicks L and moves q')
kick_all = slot('kernel (n_bodies, n_rigid, h, translation, rotation): kicks all bodies')
leave_attitude = slot('kernel (n_rigid, h, shares, keeping, rotation, work): `_leave_attitude`')
return_attitude = slot('kernel (n_rigid, averages, rotation, work): `_return_attitude`')
move_attitude_on = slot('kernel (n_rigid, h, rotation, work): `_move_attitude_on`')
put_attitude_back = slot('kernel (n_rigid, rotation, work): `_put_attitude_back`')
# bound for each scene
VELOCITY_DEPENDENT = slot('[-] whether a force depends on velocity')
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')


@inline
def _sum(shares, first, second, last):
    """Sum three vectors with their shares."""
    total = add_scaled(scale(shares[0], first), shares[1], second)
    return add_scaled(total, shares[2], last)


@kernel
def _leave_place(n_bodies, h, shares, keeping, translation, work):
    """Keep r and p, or the last forces, and go where forces are to be asked."""
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        kept = work[block * POINTS : (block + 1) * POINTS]
        for lane in range(lanes_in(block, n_bodies)):
            last = read_vector(state, lane + FORCE)
            if keeping != LAST:
                write_vector(kept, lane + KEPT_POSITION, read_vector(state, lane + POSITION))
                write_vector(kept, lane + KEPT_MOMENTUM, read_vector(state, lane + MOMENTUM))
            if keeping == ALL:
                write_vector(kept, lane + FORCE_1, last)
            elif keeping == LAST:
                write_vector(kept, lane + FORCE_2, last)
            first = read_vector(kept, lane + FORCE_1)
            second = read_vector(kept, lane + FORCE_2)
            push = _sum(shares[0], first, second, last)
            place = read_vector(kept, lane + KEPT_POSITION)
            place = add_scaled(place, h * h * state[lane + INVERSE_MASS], push)
            write_vector(state, lane + POSITION, place)
            push = _sum(shares[1], first, second, last)
            momentum = read_vector(kept, lane + KEPT_MOMENTUM)
            write_vector(state, lane + MOMENTUM, add_scaled(momentum, h, push))


@inline
def _turned_by(q, v):
    """Turn an attitude by a small rotation vector v, body axes: q (v/2, 1), of unit length."""
    x, y, z, w = q
    half = scale(0.5, v)
    a, b, c = add(add_scaled((x, y, z), w, half), cross((x, y, z), half))
    return nearly_normalised((a, b, c, w - (x * half[0] + y * half[1] + z * half[2])))


@kernel
def _leave_attitude(n_rigid, h, shares, keeping, rotation, work):
    """Keep q and L, or the last torques, and go where torques are to be asked."""
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        kept = work[block * TURNS : (block + 1) * TURNS]
        for lane in range(lanes_in(block, n_rigid)):
            last = read_vector(state, lane + TORQUE)
            if keeping != LAST:
                q = read_quaternion(state, lane + ORIENTATION)
                write_quaternion(kept, lane + KEPT_ORIENTATION, q)
                momentum = read_vector(state, lane + ANGULAR_MOMENTUM)
                write_vector(kept, lane + KEPT_ANGULAR_MOMENTUM, momentum)
            if keeping == ALL:
                write_vector(kept, lane + TORQUE_1, last)
            elif keeping == LAST:
                write_vector(kept, lane + TORQUE_2, last)
            first = read_vector(kept, lane + TORQUE_1)
            second = read_vector(kept, lane + TORQUE_2)
            push = _sum(shares[0], first, second, last)
            q = read_quaternion(kept, lane + KEPT_ORIENTATION)
            turn = multiply(rotated_back(q, push), read_vector(state, lane + INVERSE_MOMENTS))
            write_quaternion(state, lane + ORIENTATION, _turned_by(q, scale(h * h, turn)))
            push = _sum(shares[1], first, second, last)
            momentum = read_vector(kept, lane + KEPT_ANGULAR_MOMENTUM)
            write_vector(state, lane + ANGULAR_MOMENTUM, add_scaled(momentum, h, push))


@kernel
def _return_place(n_bodies, averages, translation, work):
    """Put r and p back; average the last two forces if asked to."""
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        kept = work[block * POINTS : (block + 1) * POINTS]
        for lane in range(lanes_in(block, n_bodies)):
            write_vector(state, lane + POSITION, read_vector(kept, lane + KEPT_POSITION))
            write_vector(state, lane + MOMENTUM, read_vector(kept, lane + KEPT_MOMENTUM))
            if averages:
                both = add(read_vector(kept, lane + FORCE_2), read_vector(state, lane + FORCE))
                write_vector(state, lane + FORCE, scale(0.5, both))


@kernel
def _return_attitude(n_rigid, averages, rotation, work):
    """Put q and L back; average the last two torques if asked to."""
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        kept = work[block * TURNS : (block + 1) * TURNS]
        for lane in range(lanes_in(block, n_rigid)):
            q = read_quaternion(kept, lane + KEPT_ORIENTATION)
            write_quaternion(state, lane + ORIENTATION, q)
            momentum = read_vector(kept, lane + KEPT_ANGULAR_MOMENTUM)
            write_vector(state, lane + ANGULAR_MOMENTUM, momentum)
            if averages:
                both = add(read_vector(kept, lane + TORQUE_2), read_vector(state, lane + TORQUE))
                write_vector(state, lane + TORQUE, scale(0.5, both))


@kernel
def _move_place_on(n_bodies, h, translation, work):
    """Keep r, and move it on by what the forces there give."""
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        kept = work[block * POINTS : (block + 1) * POINTS]
        for lane in range(lanes_in(block, n_bodies)):
            place = read_vector(state, lane + POSITION)
            write_vector(kept, lane + KEPT_POSITION, place)
            step = AHEAD * h * h * state[lane + INVERSE_MASS]
            place = add_scaled(place, step, read_vector(state, lane + FORCE))
            write_vector(state, lane + POSITION, place)


@kernel
def _move_attitude_on(n_rigid, h, rotation, work):
    """Keep q, and turn it on by what the torques there give."""
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        kept = work[block * TURNS : (block + 1) * TURNS]
        for lane in range(lanes_in(block, n_rigid)):
            q = read_quaternion(state, lane + ORIENTATION)
            write_quaternion(kept, lane + KEPT_ORIENTATION, q)
            torque = rotated_back(q, read_vector(state, lane + TORQUE))
            turn = multiply(torque, read_vector(state, lane + INVERSE_MOMENTS))
            write_quaternion(state, lane + ORIENTATION, _turned_by(q, scale(AHEAD * h * h, turn)))


@kernel
def _put_place_back(n_bodies, translation, work):
    """Put r back."""
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        kept = work[block * POINTS : (block + 1) * POINTS]
        for lane in range(lanes_in(block, n_bodies)):
            write_vector(state, lane + POSITION, read_vector(kept, lane + KEPT_POSITION))


@kernel
def _put_attitude_back(n_rigid, rotation, work):
    """Put q back."""
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        kept = work[block * TURNS : (block + 1) * TURNS]
        for lane in range(lanes_in(block, n_rigid)):
            q = read_quaternion(kept, lane + KEPT_ORIENTATION)
            write_quaternion(state, lane + ORIENTATION, q)


@inline
def _move_no_attitude_on(n_rigid, h, rotation, work):
    """Turn nothing: there are points alone."""


@inline
def _put_no_attitude_back(n_rigid, rotation, work):
    """Put nothing back: there are points alone."""


@inline
def _leave_no_attitude(n_rigid, h, shares, keeping, rotation, work):
    """Go nowhere: there are points alone."""


@inline
def _return_no_attitude(n_rigid, averages, rotation, work):
    """Put nothing back: there are points alone."""


def _evaluate_there(
    h, shares, keeping, time, n_bodies, n_rigid, translation, rotation, work, elements, ranges
):
    """Evaluate the forces beside the motion."""
    of_turns = work[block_count(n_bodies) * POINTS :]
    _leave_place(n_bodies, h, shares, keeping, translation, work)
    leave_attitude(n_rigid, h, shares, keeping, rotation, of_turns)
    start_evaluation(n_bodies, n_rigid, translation, rotation)
    evaluate(0, time, translation, rotation, elements, ranges)


def _return(averages, n_bodies, n_rigid, translation, rotation, work):
    """Go back to the motion."""
    of_turns = work[block_count(n_bodies) * POINTS :]
    _return_place(n_bodies, averages, translation, work)
    return_attitude(n_rigid, averages, rotation, of_turns)


def _kick_and_drift(kick, h, n_bodies, n_rigid, translation, rotation, method):
    """Kick over a time, then move freely over h."""
    for block in range(block_count(n_bodies)):
        kick_and_drift(block, lanes_in(block, n_bodies), kick, h, translation)
    for block in range(block_count(n_rigid)):
        drift_rotation(block, lanes_in(block, n_rigid), kick, h, rotation, method)


evaluate_there = slot('kernel: `_evaluate_there`')
go_back = slot('kernel: `_return`')
kick_and_move = slot('kernel: `_kick_and_drift`')


def _advance_coupled(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """
    Advance bodies whose forces depend on the state of any of them. Return DONE, or NaN if a
    number left the finite ones.
    """
    world = (n_bodies, n_rigid, translation, rotation)
    acting = (workspace, elements, ranges)
    for passed in range(ticks):
        time = (tick + passed) * h
        if VELOCITY_DEPENDENT or passed == 0:
            start_evaluation(*world)
            evaluate(0, time, translation, rotation, elements, ranges)
        kick_and_move(h / 6.0, 0.5 * h, *world, method)
        middle, end = (tick + passed + 0.5) * h, (tick + passed + 1.0) * h
        if VELOCITY_DEPENDENT:
            evaluate_there(h, SECOND, ALL, middle, *world, *acting)
            evaluate_there(h, THIRD, LAST, middle, *world, *acting)
            go_back(True, *world, workspace)
            kick_and_move(2.0 * h / 3.0, 0.5 * h, *world, method)
            evaluate_there(h, FOURTH, PLACE, end, *world, *acting)
            go_back(False, *world, workspace)
        else:
            start_evaluation(*world)
            evaluate(0, middle, translation, rotation, elements, ranges)
            _move_place_on(n_bodies, h, translation, workspace)
            of_turns = workspace[block_count(n_bodies) * POINTS :]
            move_attitude_on(n_rigid, h, rotation, of_turns)
            start_evaluation(*world)
            evaluate(0, middle, translation, rotation, elements, ranges)
            _put_place_back(n_bodies, translation, workspace)
            put_attitude_back(n_rigid, rotation, of_turns)
            kick_and_move(2.0 * h / 3.0, 0.5 * h, *world, method)
            start_evaluation(*world)
            evaluate(0, end, translation, rotation, elements, ranges)
        kick_all(n_bodies, n_rigid, h / 6.0, translation, rotation)
    return finite(n_bodies, n_rigid, translation, rotation)


@dataclass(frozen=True)
class ForceGradient:
    """
    The scheme of order four with corrected kicks.

    drift_rotation : kernel of a free-rotation propagator, see `free_rotation`
    """

    drift_rotation: Callable[..., Any]

    def for_points(self) -> ForceGradient:
        """Return the same scheme without rotation."""
        return replace(self, drift_rotation=no_rotation.drift)

    def _rotates(self) -> bool:
        return self.drift_rotation is not no_rotation.drift

    def _splitting(self) -> Splitting:
        return Splitting(KICKS, DRIFTS, self.drift_rotation, order=4)

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        return self._splitting().free(name)

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        rotates = self._rotates()
        offered = {
            'evaluate': evaluate,
            'drift_rotation': self.drift_rotation,
            'leave_attitude': _leave_attitude if rotates else _leave_no_attitude,
            'return_attitude': _return_attitude if rotates else _return_no_attitude,
            'move_attitude_on': _move_attitude_on if rotates else _move_no_attitude_on,
            'put_attitude_back': _put_attitude_back if rotates else _put_no_attitude_back,
            'kick_all': self._splitting().kick_all(),
            'VELOCITY_DEPENDENT': velocity_dependent,
        }
        both = f'{name}__{scene}'
        offered |= {
            'evaluate_there': specialise(_evaluate_there, name=both, offered=offered),
            'go_back': specialise(_return, name=name, offered=offered),
            'kick_and_move': specialise(_kick_and_drift, name=name, offered=offered),
        }
        return specialise(_advance_coupled, name=both, offered=offered)

    def evaluations(self, *, velocity_dependent: bool) -> int:
        """Count the evaluations of a step."""
        return 4 if velocity_dependent else 3

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a coupled step writes beside the state."""
        return (POINTS + TURNS) * blocks
