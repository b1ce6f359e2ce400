# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How an implicit step of one body begins and ends, how its state is kept, and how it is shifted for
differences.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.integration.schemes.implicit.coupling import POINT, WRENCH
from rigid_body_sim.physics.integration.schemes.implicit.stage import (
    BASE_MOMENTUM,
    BASE_ORIENTATION,
    BASE_POSITION,
    BASE_SPIN,
    DELTA,
    HELD_THROUGH,
    IMPULSE,
    KEPT_ROTATION,
    KEPT_TRANSLATION,
    KICKED,
    MOVED,
    ONLY_HELD_FORCE,
    ONLY_HELD_TORQUE,
    RATE,
    ROTATION_NUMBERS,
    START_ANGULAR_MOMENTUM,
    START_MOMENTUM,
    START_POSITION,
    TRANSLATION_NUMBERS,
    VELOCITY_CHANGE,
    load_quaternion,
    set_stage,
    store_quaternion,
    turned,
)
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    add_to_vector,
    multiply,
    read_quaternion,
    read_vector,
    write_quaternion,
    write_vector,
)
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    HELD_FORCE,
    HELD_TORQUE,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    LANES,
    MOMENTS,
    MOMENTUM,
    MOMENTUM_RESIDUAL,
    ORIENTATION,
    POSITION,
    POSITION_RESIDUAL,
    ROTATION,
    TORQUE,
    TRANSLATION,
    at,
    rotated,
    rotated_back,
)
from rigid_body_sim.physics.vectors import add, load, scale, store, subtract

# [-] relative step of the differences: the square root of the rounding of doubles
DIFFERENCE = 1e-8
SAVED_TORQUE = 3  # where the torque of a saved wrench begins
NONE = (0.0, 0.0, 0.0)


@kernel
def keep(i, b, blocks):
    """Keep the state of a body at the start of a tick."""
    place = at(i, TRANSLATION)
    for number in range(TRANSLATION_NUMBERS):  # r, p and their residuals
        b[KEPT_TRANSLATION + number] = blocks.translation[place + LANES * number]
    if i < blocks.n_rigid:
        place = at(i, ROTATION)
        for number in range(ROTATION_NUMBERS):
            b[KEPT_ROTATION + number] = blocks.rotation[place + LANES * number]


@kernel
def restore(i, b, blocks):
    """Go back to the state at the start of the tick."""
    place = at(i, TRANSLATION)
    for number in range(TRANSLATION_NUMBERS):
        blocks.translation[place + LANES * number] = b[KEPT_TRANSLATION + number]
    if i < blocks.n_rigid:
        place = at(i, ROTATION)
        for number in range(ROTATION_NUMBERS):
            blocks.rotation[place + LANES * number] = b[KEPT_ROTATION + number]


@kernel
def begin_substep(i, b, blocks):
    """Take the state of a body as base of the first stage, and as first guess."""
    place = at(i, TRANSLATION)
    position = read_vector(blocks.translation, place + POSITION)
    momentum = read_vector(blocks.translation, place + MOMENTUM)
    store(b, BASE_POSITION, position)
    store(b, START_POSITION, position)
    store(b, BASE_MOMENTUM, momentum)
    store(b, START_MOMENTUM, momentum)
    store(b, MOVED, NONE)
    store(b, KICKED, NONE)
    store(b, VELOCITY_CHANGE, NONE)
    b[HELD_THROUGH] = 1.0
    if i < blocks.n_rigid:
        place = at(i, ROTATION)
        attitude = read_quaternion(blocks.rotation, place + ORIENTATION)
        momentum = read_vector(blocks.rotation, place + ANGULAR_MOMENTUM)
        spin = rotated_back(attitude, momentum)
        store_quaternion(b, BASE_ORIENTATION, attitude)
        store(b, START_ANGULAR_MOMENTUM, momentum)
        store(b, BASE_SPIN, spin)
        store(b, RATE, multiply(spin, read_vector(blocks.rotation, place + INVERSE_MOMENTS)))


@kernel
def _end_translation(place, h, b, translation):
    """Add the sums of the stages to the state at the start."""
    b[HELD_THROUGH] *= b[ONLY_HELD_FORCE]
    kicked = load(b, KICKED)
    if b[HELD_THROUGH] != 0.0:
        kicked = scale(h, read_vector(translation, place + HELD_FORCE))
    position, momentum = load(b, START_POSITION), load(b, START_MOMENTUM)
    add_to_vector(
        translation, place + POSITION, place + POSITION_RESIDUAL, position, load(b, MOVED)
    )
    add_to_vector(translation, place + MOMENTUM, place + MOMENTUM_RESIDUAL, momentum, kicked)


@kernel
def _add(b, place, v):
    """Add a vector to one of the row."""
    store(b, place, add(load(b, place), v))


@kernel
def end_stage(i, h, gamma, last, b, blocks):
    """
    Make the base of the next stage of a Runge–Kutta method, or the new state.

        y0 + (1 - gamma) h K,   K = (Y - base) / (gamma h)
    """
    place = at(i, TRANSLATION)
    over_mass = blocks.translation[place + INVERSE_MASS]
    share = gamma if last else 1.0 - gamma
    change = load(b, VELOCITY_CHANGE)
    velocity = add(scale(over_mass, load(b, BASE_MOMENTUM)), change)
    moved = scale(share * h, velocity)
    kicked = scale(share / gamma * (1.0 / over_mass), change)
    _add(b, MOVED, moved)
    _add(b, KICKED, kicked)
    _add(b, BASE_POSITION, moved)
    _add(b, BASE_MOMENTUM, kicked)
    store(b, VELOCITY_CHANGE, NONE)
    if last:
        _end_translation(place, h, b, blocks.translation)
    else:
        b[HELD_THROUGH] *= b[ONLY_HELD_FORCE]
    if i < blocks.n_rigid:
        place = at(i, ROTATION)
        rate = load(b, RATE)
        spin = multiply(read_vector(blocks.rotation, place + MOMENTS), rate)
        attitude = turned(load_quaternion(b, BASE_ORIENTATION), scale(0.5 * share * h, rate))
        if last:
            write_quaternion(blocks.rotation, place + ORIENTATION, attitude)
            write_vector(blocks.rotation, place + ANGULAR_MOMENTUM, rotated(attitude, spin))
        else:
            store_quaternion(b, BASE_ORIENTATION, attitude)
            _add(b, BASE_SPIN, scale(share / gamma, subtract(spin, load(b, BASE_SPIN))))


@kernel
def end_of_midpoint(i, h, b, blocks):
    """
    Make the new state from the one half-way.

        r1 = r0 + h v,   p1 = p0 + 2 m d,   q1 = q0 (a w, 1) / |(a w, 1)|
        L1 = L0 + 2 R0 (a T_B),   a = h/2
    """
    place = at(i, TRANSLATION)
    over_mass = blocks.translation[place + INVERSE_MASS]
    change = load(b, VELOCITY_CHANGE)
    store(b, MOVED, scale(h, add(scale(over_mass, load(b, BASE_MOMENTUM)), change)))
    store(b, KICKED, scale(2.0 * (1.0 / over_mass), change))
    _end_translation(place, h, b, blocks.translation)
    if i < blocks.n_rigid:
        place = at(i, ROTATION)
        base = load_quaternion(b, BASE_ORIENTATION)
        if b[ONLY_HELD_TORQUE] != 0.0:
            kicked = scale(h, read_vector(blocks.rotation, place + HELD_TORQUE))
        else:
            kicked = scale(2.0, rotated(base, load(b, IMPULSE)))
        momentum = add(load(b, START_ANGULAR_MOMENTUM), kicked)
        write_vector(blocks.rotation, place + ANGULAR_MOMENTUM, momentum)
        attitude = turned(base, scale(0.5 * h, load(b, RATE)))
        write_quaternion(blocks.rotation, place + ORIENTATION, attitude)


@kernel
def correct_impulse(i, a, b, rotation, error):
    """
    Add to the torque what the Newton step w <- w - e changes in the inertial part of the
    equations.
    """
    e1, e2, e3 = error
    w1, w2, w3 = load(b, RATE)
    i1, i2, i3 = read_vector(rotation, at(i, ROTATION) + MOMENTS)
    change = (
        i1 * e1 + a * (i3 - i2) * (w3 * e2 + w2 * e3),
        i2 * e2 + a * (i1 - i3) * (w1 * e3 + w3 * e1),
        i3 * e3 + a * (i2 - i1) * (w2 * e1 + w1 * e2),
    )
    store(b, IMPULSE, subtract(load(b, IMPULSE), change))


@kernel
def save_wrench(i, blocks, wrenches):
    """Save force and torque on a body, to subtract them from shifted ones."""
    saved = WRENCH * i
    store(wrenches, saved, read_vector(blocks.translation, at(i, TRANSLATION) + FORCE))
    if i < blocks.n_rigid:
        torque = read_vector(blocks.rotation, at(i, ROTATION) + TORQUE)
        store(wrenches, saved + SAVED_TORQUE, torque)


@kernel
def wrench_change(i, blocks, wrenches):
    """Difference of force and torque from the saved wrench."""
    saved = WRENCH * i
    force = read_vector(blocks.translation, at(i, TRANSLATION) + FORCE)
    change = NONE
    if i < blocks.n_rigid:
        torque = read_vector(blocks.rotation, at(i, ROTATION) + TORQUE)
        change = subtract(torque, load(wrenches, saved + SAVED_TORQUE))
    return subtract(force, load(wrenches, saved)), change


@kernel
def shift(midpoint, component, i, a, length, b, blocks):
    """Change one unknown of a body a little; DELTA = 0 where it has no such unknown."""
    if component < POINT:
        over_mass = blocks.translation[at(i, TRANSLATION) + INVERSE_MASS]
        change = b[VELOCITY_CHANGE + component]
        velocity = b[BASE_MOMENTUM + component] * over_mass + change
        reach = max(length, abs(b[BASE_POSITION + component]))
        size = abs(velocity) + abs(change) + reach / a
        place = VELOCITY_CHANGE + component
    elif i < blocks.n_rigid:
        size = abs(b[RATE]) + abs(b[RATE + 1]) + abs(b[RATE + 2]) + 1.0 / a
        place = RATE + component - POINT
    else:
        b[DELTA] = 0.0
        return
    before = b[place]
    delta = (before + DIFFERENCE * size) - before
    b[DELTA] = delta
    b[place] = before + delta
    set_stage(midpoint, i, a, b, blocks)
    b[place] = before
