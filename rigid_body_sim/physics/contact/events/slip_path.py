# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Routh's path of an impact while the point slips and the direction of its slip turns.

The impact takes no time: what runs is the normal impulse p_n. Coulomb friction opposes the slip
sigma (c, s), so that dp = (-mu c, -mu s, 1) dp_n and du = K dp. With dp_n = sigma dt the equations
are polynomials, and regular down to the end of slip:

    (f_1, f_2, f_n) = K (-mu c, -mu s, 1)      g = c f_1 + s f_2       h = c f_2 - s f_1

    c' = -s h     s' = c h     sigma' = sigma g     u_n' = sigma f_n     W' = sigma u_n
    p_n' = sigma              p_t' = -mu sigma (c, s)

    u_n : normal velocity of B against A [m/s], approach < 0        W : work of p_n [J]

h = 0 are the directions in which slip keeps straight; at the end of slip the path runs into one.
One step is Gragg's midpoint rule, extrapolated (Hairer, Norsett & Wanner, Solving Ordinary
Differential Equations I, II.9): order 12, with the difference to order 10 as the error.

E. J. Routh, Dynamics of a System of Rigid Bodies, Part I (1905), art. 187; V. Bhatt and
J. Koechling, J. Appl. Mech. 62 (1995) 893.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.events.collision_matrix import CollisionMatrix

COLUMNS = 6  # of the extrapolation: with 2, 4, ... 12 midpoint steps
LONGEST = 0.5  # [-] first step times the rate of the path
MATRIX_ROUND_OFF = 2e-15  # [-] of K: less than that is what rounding left of zero
ACCURACY = (
    3e-12  # [-] of the speed before the impact: error of order 10; that of order 12 is 1e-15
)
SLOWEST = 1e-16  # [-] of the speed before the impact: slower slip has stopped
CLOSE = 1e-5  # [-] of the way so far: so near, one step of third order ends at the last digit
SHORTEST = 1e-6  # [-] of the longest step: shorter ones are not tried again
TINIEST = 1e-300  # [m/s] in place of an error of zero
EXPONENT = 1.0 / (2 * COLUMNS - 1)  # of the error estimate, in the length of the step
GROWN = 5.0  # [-] times the first step: the longest, where speed hardly counts any more
MOST_STEPS = 400  # a path has 3 to 60

DONE, STOPPED, PRESSED, STRAIGHT = 0, 1, 2, 3  # how a piece of path ends


def _weights(columns: int) -> tuple[float, ...]:
    """Weights of the columns in their extrapolation to a step of length zero."""
    squares = [(2 * j) ** 2 for j in range(1, columns + 1)]
    return tuple(
        math.prod(own / (own - other) for other in squares if other != own) for own in squares
    )


WEIGHTS = _weights(COLUMNS)
ERROR_WEIGHTS = tuple(
    high - low for high, low in zip(WEIGHTS, (*_weights(COLUMNS - 1), 0.0), strict=True)
)


class Slip(NamedTuple):
    """
    Where a path stands.

    cosine, sine         : direction of slip in the axes of the contact
    speed                : sigma [m/s]
    normal_velocity      : u_n [m/s]
    work                 : W [J], of this phase
    normal_impulse       : p_n [N s]
    tangent_1, tangent_2 : p_t [N s]
    """

    cosine: float
    sine: float
    speed: float
    normal_velocity: float
    work: float
    normal_impulse: float
    tangent_1: float
    tangent_2: float


@inline
def push(matrix: CollisionMatrix, friction: float, cosine: float, sine: float) -> Any:
    """Return (f_1, f_2, f_n): the change of velocity per normal impulse while it slips."""
    x, y = -friction * cosine, -friction * sine
    return (
        matrix.k_11 * x + matrix.k_12 * y + matrix.k_1n,
        matrix.k_12 * x + matrix.k_22 * y + matrix.k_2n,
        matrix.k_1n * x + matrix.k_2n * y + matrix.k_nn,
    )


@inline
def _rate(slip: Slip, matrix: CollisionMatrix, friction: float) -> Slip:
    """Return the derivative of all that runs along the path."""
    c, s, speed = slip.cosine, slip.sine, slip.speed
    f_1, f_2, f_n = push(matrix, friction, c, s)
    turn = c * f_2 - s * f_1
    rubbed = -friction * speed
    return Slip(
        -s * turn, c * turn, speed * (c * f_1 + s * f_2), speed * f_n,
        speed * slip.normal_velocity, speed, rubbed * c, rubbed * s,
    )  # fmt: skip


@inline
def _moved(slip: Slip, length: float, rate: Slip) -> Slip:
    """Return slip + length rate."""
    return Slip(
        slip.cosine + length * rate.cosine,
        slip.sine + length * rate.sine,
        slip.speed + length * rate.speed,
        slip.normal_velocity + length * rate.normal_velocity,
        slip.work + length * rate.work,
        slip.normal_impulse + length * rate.normal_impulse,
        slip.tangent_1 + length * rate.tangent_1,
        slip.tangent_2 + length * rate.tangent_2,
    )


@kernel
def step(slip: Slip, length: float, matrix: CollisionMatrix, friction: float) -> Any:
    """
    Go on by a length [kg] of the path: where it then stands, and the error of that [m/s].
    """
    first = _rate(slip, matrix, friction)
    none = Slip(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    change, error = none, none
    for column in range(COLUMNS):
        midpoints = 2 * (column + 1)
        part = length / midpoints
        before, now = none, _moved(none, part, first)  # changes since the start keep their digits
        for _ in range(midpoints - 1):
            rate = _rate(_moved(slip, 1.0, now), matrix, friction)
            before, now = now, _moved(before, 2.0 * part, rate)
        change = _moved(change, WEIGHTS[column], now)
        error = _moved(error, ERROR_WEIGHTS[column], now)
    after = _moved(slip, 1.0, change)
    size = math.sqrt(after.cosine * after.cosine + after.sine * after.sine)
    after = Slip(
        after.cosine / size, after.sine / size, after.speed, after.normal_velocity, after.work,
        after.normal_impulse, after.tangent_1, after.tangent_2,
    )  # fmt: skip
    off = abs(error.speed) + abs(error.normal_velocity)
    return after, off + slip.speed * (abs(error.cosine) + abs(error.sine))


@inline
def _to_end(slip: Slip, returned: float, matrix: CollisionMatrix, friction: float) -> float:
    """
    Return how far the end of the phase is, to second order: the smaller root in size of
    a + b t + c t^2 / 2; infinity where there is none ahead.
    """
    f_1, f_2, f_n = push(matrix, friction, slip.cosine, slip.sine)
    turn = slip.cosine * f_2 - slip.sine * f_1
    growth = slip.cosine * f_1 + slip.sine * f_2
    faster = slip.speed * f_n
    if returned < 0.0:  # compression: to u_n = 0
        turned = -friction * turn * (matrix.k_2n * slip.cosine - matrix.k_1n * slip.sine)
        a, b, c = slip.normal_velocity, faster, slip.speed * (growth * f_n + turned)
    else:
        a, b = slip.work - returned, slip.speed * slip.normal_velocity
        c = slip.speed * (growth * slip.normal_velocity + faster)
    inside = b * b - 2.0 * a * c
    if inside < 0.0:
        return math.inf
    root = math.sqrt(inside)
    if b <= 0.0:  # falling, then rising
        return (root - b) / c if c > 0.0 and a < 0.0 else math.inf
    return -2.0 * a / (b + root)


@inline
def _longest(slip: Slip, matrix: CollisionMatrix, friction: float) -> float:
    """Return a step that the rates of speed and direction allow [kg]."""
    f_1, f_2, _ = push(matrix, friction, slip.cosine, slip.sine)
    unlike = 0.5 * (matrix.k_11 - matrix.k_22)
    turning = 2.0 * friction * math.sqrt(unlike * unlike + matrix.k_12 * matrix.k_12)
    turning += math.sqrt(matrix.k_1n * matrix.k_1n + matrix.k_2n * matrix.k_2n)
    return LONGEST / (abs(slip.cosine * f_1 + slip.sine * f_2) + turning)


@inline
def stopped(slip: Slip) -> Slip:
    """Return a path at the end of slip."""
    return Slip(
        slip.cosine, slip.sine, 0.0, slip.normal_velocity, slip.work, slip.normal_impulse,
        slip.tangent_1, slip.tangent_2,
    )  # fmt: skip


@inline
def turns_no_more(slip: Slip, size: float, matrix: CollisionMatrix, friction: float) -> bool:
    """
    Whether the rest of the path is straight to round-off: in a plane of symmetry, or because what
    is left of slip, and dies, is too slow for the turn that is left of its direction.

    size : speed before the impact [m/s]
    """
    f_1, f_2, _ = push(matrix, friction, slip.cosine, slip.sine)
    rate = friction * (matrix.k_11 + matrix.k_22) + abs(matrix.k_1n) + abs(matrix.k_2n)
    turn = abs(slip.cosine * f_2 - slip.sine * f_1)
    dies = slip.cosine * f_1 + slip.sine * f_2 < 0.0
    return turn * (slip.speed if dies else max(slip.speed, size)) <= MATRIX_ROUND_OFF * rate * size


@kernel
def follow(
    slip: Slip, returned: float, size: float, matrix: CollisionMatrix, friction: float
) -> Any:
    """
    Follow the path to the end of its phase (DONE), or to where slip stops (STOPPED), where the
    bodies are pressed together again (PRESSED), or where it turns no more (STRAIGHT).

    returned : work at the end of restitution [J]; negative: compression, which ends at u_n = 0
    size     : speed before the impact [m/s]
    """
    longest = _longest(slip, matrix, friction)
    limit, gone = GROWN * longest, 0.0
    for _ in range(MOST_STEPS):
        end = _to_end(slip, returned, matrix, friction)
        length = min(end, longest)
        after, error = step(slip, length, matrix, friction)
        fits = ACCURACY * size / max(error, TINIEST)
        if not fits >= 0.1 and abs(length) > SHORTEST * longest:
            longest = 0.5 * abs(length)
            continue
        slip = after
        if length == end and abs(end) <= CLOSE * gone:
            return slip, DONE
        gone += abs(length)
        if slip.speed <= SLOWEST * size:
            return stopped(slip), STOPPED
        if returned >= 0.0 and slip.normal_velocity < 0.0:
            return slip, PRESSED
        if turns_no_more(slip, size, matrix, friction):
            return slip, STRAIGHT
        if length == longest:
            longest = min(longest * min(fits**EXPONENT, 2.0), limit)
    return slip, DONE
