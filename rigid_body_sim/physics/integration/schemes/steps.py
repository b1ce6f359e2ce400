# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Steps that every scheme needs: begin an evaluation, kick and drift points, look for numbers that
are none.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    read_quaternion,
    read_vector,
    write_vector,
)
from rigid_body_sim.physics.integration.status import DONE
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    HELD_FORCE,
    HELD_TORQUE,
    INVERSE_MASS,
    LANES,
    MOMENTUM,
    MOMENTUM_RESIDUAL,
    ORIENTATION,
    POSITION,
    POSITION_RESIDUAL,
    ROTATION,
    TORQUE,
    TRANSLATION,
    add_compensated,
    block_count,
    lanes_in,
)
from rigid_body_sim.physics.vectors import add_scaled


@inline
def start_evaluation(n_bodies, n_rigid, translation, rotation):
    """Set the sums of forces and torques to what is held over the tick."""
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        for lane in range(lanes_in(block, n_bodies)):
            write_vector(state, lane + FORCE, read_vector(state, lane + HELD_FORCE))
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        for lane in range(lanes_in(block, n_rigid)):
            write_vector(state, lane + TORQUE, read_vector(state, lane + HELD_TORQUE))


@inline
def _kick(place, duration, state):
    """Let one component of the force on a body act for a time; return that of the momentum."""
    state[place + MOMENTUM], state[place + MOMENTUM_RESIDUAL] = add_compensated(
        state[place + MOMENTUM], state[place + MOMENTUM_RESIDUAL], duration * state[place + FORCE]
    )
    return state[place + MOMENTUM]


@inline
def _kick_and_drift(place, kick_duration, time_per_mass, state):
    """Kick, then move, one component of a body."""
    momentum = _kick(place, kick_duration, state)
    state[place + POSITION], state[place + POSITION_RESIDUAL] = add_compensated(
        state[place + POSITION], state[place + POSITION_RESIDUAL], time_per_mass * momentum
    )


@kernel
def kick(block, lanes, duration, translation):
    """Let the forces act for a time: p <- p + duration F."""
    state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
    for lane in range(lanes):
        _kick(lane, duration, state)
        _kick(lane + LANES, duration, state)
        _kick(lane + 2 * LANES, duration, state)


@kernel
def kick_and_drift(block, lanes, kick_duration, duration, translation):
    """Kick, then move freely: p <- p + kick_duration F, r <- r + duration p / m."""
    state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
    for lane in range(lanes):
        time_per_mass = duration * state[lane + INVERSE_MASS]
        _kick_and_drift(lane, kick_duration, time_per_mass, state)
        _kick_and_drift(lane + LANES, kick_duration, time_per_mass, state)
        _kick_and_drift(lane + 2 * LANES, kick_duration, time_per_mass, state)


@kernel
def kick_rotation(block, lanes, duration, rotation):
    """Let the torques act for a time: L <- L + duration torque."""
    state = rotation[block * ROTATION : (block + 1) * ROTATION]
    for lane in range(lanes):
        momentum, torque = (
            read_vector(state, lane + ANGULAR_MOMENTUM),
            read_vector(state, lane + TORQUE),
        )
        write_vector(state, lane + ANGULAR_MOMENTUM, add_scaled(momentum, duration, torque))


@kernel
def finite(n_bodies, n_rigid, translation, rotation):
    """
    Return DONE if every position, momentum, orientation and angular momentum is finite, else NaN.
    """
    status = DONE
    for block in range(block_count(n_bodies)):
        state = translation[block * TRANSLATION : (block + 1) * TRANSLATION]
        for lane in range(lanes_in(block, n_bodies)):
            rx, ry, rz = read_vector(state, lane + POSITION)
            px, py, pz = read_vector(state, lane + MOMENTUM)
            status += 0.0 * (rx + ry + rz + px + py + pz)
    for block in range(block_count(n_rigid)):
        state = rotation[block * ROTATION : (block + 1) * ROTATION]
        for lane in range(lanes_in(block, n_rigid)):
            qx, qy, qz, qw = read_quaternion(state, lane + ORIENTATION)
            lx, ly, lz = read_vector(state, lane + ANGULAR_MOMENTUM)
            status += 0.0 * (qx + qy + qz + qw)
            status += 0.0 * (lx + ly + lz)
    return status
