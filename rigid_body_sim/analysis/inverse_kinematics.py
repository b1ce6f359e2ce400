# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From positions and what is known at the ends to velocities and accelerations.

    r(t_i), boundary conditions  ->  v = r'  ->  a = r''

The other way round than a simulation (a -> v -> r), which needs a start instead. r is a spline of
degree five through the samples, or near noisy ones (`derivatives_with_bands`), that keeps each
condition exactly:

    start_velocity, end_velocity, start_acceleration, end_acceleration   given
    ends = 'free'      nothing more is known: the spline is one polynomial near each end
    ends = 'natural'   r''' = r'''' = 0 at both ends: the least integral of |r'''|^2
    ends = 'periodic'  r', r'', r''', r'''' are the same at both ends: the motion repeats

What is true of the motion makes the result better where it is worst, at the ends; what is not true
makes it wrong there, and the estimate of the error does not know.

    from rigid_body_sim import inverse_kinematics
    found = inverse_kinematics(t, r, start_velocity=(0, 0, 0), end_velocity=(0, 0, 0))
    found.velocity, found.acceleration, found.acceleration_error

Source: de Boor, A Practical Guide to Splines, chapter IV (complete, natural, periodic splines).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.analysis.derivatives_with_bands import (
    Errors,
    Followed,
    blind_spots,
    errors,
    follow,
    noise_of,
    unsure,
)
from rigid_body_sim.analysis.piecewise_spline import BEFORE, DEGREE, Break, End, Undetermined, cut
from rigid_body_sim.analysis.samples import need_bandwidth, need_motion, vector_of
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.numbers import array_of_numbers, shown

Array = NDArray[np.float64]

ENDS = ('free', 'natural', 'periodic')
SAME = 1e-9  # [-] of the largest position: how far apart ends that repeat may be, beside noise


@dataclass(frozen=True, eq=False)
class Kinematics:
    """
    A motion with its derivatives at the samples.

    position           : (n, 3) [m]      of the spline: the samples, or smoothed
    velocity           : (n, 3) [m/s]
    acceleration       : (n, 3) [m/s^2]
    velocity_deviation, acceleration_deviation : (n, 3) one standard deviation of each number
    velocity_error     : [m/s]    estimated root of the mean square of the error
    acceleration_error : [m/s^2]  likewise
    noise              : [m]      found in the samples, along each axis
    bandwidth          : [Hz]     faster motion is not followed
    jumps              : [s]      instants of jumps that were not given, found in the samples
    """

    position: Array
    velocity: Array
    acceleration: Array
    velocity_deviation: Array
    acceleration_deviation: Array
    velocity_error: float
    acceleration_error: float
    noise: float
    bandwidth: float
    jumps: tuple[float, ...]


def inverse_kinematics(
    time: ArrayLike,
    position: ArrayLike,
    *,
    start_velocity: ArrayLike | None = None,
    end_velocity: ArrayLike | None = None,
    start_acceleration: ArrayLike | None = None,
    end_acceleration: ArrayLike | None = None,
    ends: str = 'free',
    breaks: Sequence[float | Break] = (),
    bandwidth: float | None = None,
) -> Kinematics:
    """
    Derive velocities and accelerations from positions and boundary conditions.

        time      : (n,) [s]   ascending, n >= 6
        position  : (n, 3) [m] in axes that do not turn
        start_…, end_… : (3,) [m/s], [m/s^2] at the first and the last sample; None: not known
        ends      : 'free', 'natural' or 'periodic'; the last one takes no velocities or
                    accelerations besides
        breaks    : [s] instants at which the acceleration jumps, or a `Break` for the velocity
        bandwidth : [Hz] faster motion is taken for noise; None: found from the samples
        returns   : what was found, with its errors

    Raises UserError for samples that tell no motion and for conditions that contradict each other.
    """
    stamps, samples = _samples(time, position)
    given = {
        ('start_velocity', 1, 0): start_velocity,
        ('end_velocity', 1, -1): end_velocity,
        ('start_acceleration', 2, 0): start_acceleration,
        ('end_acceleration', 2, -1): end_acceleration,
    }
    conditions = [
        End(order, vector_of(name, value), side)
        for (name, order, side), value in given.items()
        if value is not None
    ]
    conditions += _of_ends(ends, bool(conditions))
    need_bandwidth(bandwidth)
    if ends == 'periodic':
        _must_repeat(samples, noise_of(cut(stamps), samples))
    try:
        followed = follow(
            stamps,
            samples,
            [b if isinstance(b, Break) else Break(float(b)) for b in breaks],
            conditions,
            bandwidth=bandwidth,
        )
    except Undetermined as error:
        raise UserError(f'{error} with these conditions; leave some of them out') from error
    lasts = float(stamps[-1] - stamps[0])
    found, noise = followed.fit, followed.noise
    velocity, acceleration = (_told(followed, stamps, order) for order in (BEFORE, 2))
    return Kinematics(
        found.own[0],
        found.own[BEFORE],
        found.own[2],
        velocity.deviation,
        acceleration.deviation,
        velocity.rms,
        acceleration.rms,
        float(np.sqrt(np.mean(np.square(noise)))),
        0.5 * found.free / lasts,
        tuple(b.instant for kink in followed.kinks for b in kink.breaks),
    )


def _samples(time: ArrayLike, position: ArrayLike) -> tuple[Array, Array]:
    stamps, samples = array_of_numbers(time), array_of_numbers(position)
    if stamps is None or samples is None:
        wrong = time if stamps is None else position
        raise UserError(f'got {shown(wrong)}; times and positions must be numbers')
    if stamps.ndim != 1 or samples.shape != (len(stamps), 3):
        raise UserError(
            f'times of shape {stamps.shape}, positions of shape {samples.shape}; needed: (n,) '
            'and (n, 3)'
        )
    need_motion(stamps, samples)
    return stamps, samples


def _of_ends(ends: str, given: bool) -> list[End]:
    if ends not in ENDS:
        raise UserError(f'ends {ends!r}; allowed: {", ".join(ENDS)}')
    if ends == 'periodic':
        if given:
            raise UserError(
                'velocities or accelerations at the ends of a motion that repeats; '
                "leave them out, or ends='periodic'"
            )
        return [End(order, None) for order in range(1, DEGREE)]
    if ends == 'natural':
        return [End(order, np.zeros(3), side) for side in (0, -1) for order in (3, 4)]
    return []


def _must_repeat(samples: Array, noise: Array) -> None:
    apart = float(np.linalg.norm(samples[-1] - samples[0]))
    allowed = SAME * float(np.max(np.abs(samples))) + 6.0 * float(np.linalg.norm(noise))
    if apart > allowed:
        raise UserError(
            f'the last position is {apart:.3g} m from the first; a motion that repeats ends where '
            'it begins: give one whole period, both ends included'
        )


def _told(followed: Followed, time: Array, order: int) -> Errors:
    """Errors of the first or the second derivative."""
    found, square = followed.fit, np.square(followed.noise)
    blind = blind_spots(found, time, found.own[2])
    if order != 2:
        blind *= 0.5 * found.span[:, None]
    blind += unsure(followed, time)[2 if order == 2 else 1][:, None]
    return errors(
        found,
        found.own[order],
        found.judge[order],
        found.response[order][:, None] * square,
        found.disagreement[order][:, None] * square,
        blind,
    )
