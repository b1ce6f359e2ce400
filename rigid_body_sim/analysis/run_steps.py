# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the steps of a run leave in its recorded poses: the wrench that explains these is not quite
the one that acted.

    kick, drift, kick   x_n+1 - 2 x_n + x_n-1 = h^2 a_n,   so   r'' = a - h^2 a'' / 12 + O(h^4)
                        v_n = (x_n+1 - x_n-1) / 2 h,       so   r'  = v - h^2 a' / 6

The implicit midpoint rule has half of these constants, h^2 / 24 and h^2 / 12; other methods of
order two have such of the same size, taken as these. A method of order one
is wrong by h a' and h a / 2. Of a method of order three and above nothing is added: where its
steps resolve the motion, the spline through samples that are no nearer to each other is worse.
Splittings whose drift turns a free body to a higher order err as far as torques act:
h^2 (torque'' + w^2 torque) / 12; others with all that changes the angular velocity.

Source: Hairer, Lubich and Wanner, Geometric Numerical Integration, section I.1.4 and chapter IX
(modified equations).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.integration.schemes.implicit.midpoint import ImplicitMidpoint
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

Array = NDArray[np.float64]

KINK, KINK_DECAY = 1.5, 0.1  # r'' that a spline makes of a jump of r', in that per sample spacing
KINK_REACH = 3  # [sample]


@dataclass(frozen=True)
class RunSteps:
    """
    Steps of a run.

    length   : [s]
    order    : 1 or 2, of the path
    turn_order : 1 or 2, of the orientation
    turns_free : whether a free body turns to a higher order
    share    : of the constants above: half where forces are met half-way
    """

    length: float
    order: int
    turn_order: int
    turns_free: bool
    share: float = 1.0


def steps_of(manifest: Mapping[str, str]) -> RunSteps | None:
    """Read the steps of a recorded run; None where they are not known, or of a higher order."""
    try:
        integrator = INTEGRATORS[manifest['integrator']]
        options = json.loads(manifest.get('integrator_options', '{}'))
        length = int(manifest['dt_ns']) / 1e9 / max(1, int(options.get('substeps', 1)))
    except (KeyError, ValueError, TypeError, AttributeError):
        return None
    splits = isinstance(integrator.scheme, Splitting)
    # a kick and a drift are, seen from positions, what two half kicks about it are
    order = 2 if splits and integrator.order == 1 else integrator.order
    if order > 2 or not 0.0 < length < np.inf:
        return None
    turn_order = min(order, integrator.free_order) if splits else order
    free = splits and integrator.free_order > 2
    half_way = isinstance(integrator.scheme, ImplicitMidpoint)
    return RunSteps(length, int(order), int(turn_order), free, 0.5 if half_way else 1.0)


def left_in_second(
    steps: RunSteps,
    order: int,
    time: Array,
    piece: NDArray[np.int64],
    second: Array,
    rest: Array | float = 0.0,
) -> Array:
    """
    Size (k, 3) of what is left in a second derivative, or a wrench, by its own derivatives.

        time, piece : (k,) [s], and which stretch without jumps a sample lies in
        rest        : what comes to its own second derivative [1/s^2 of it]
    """
    first = _rate(time, piece, second)
    by_kinks = _at_jumps(time, piece, left_in_first(steps, order, time, piece, second, sign=True))
    if order == 1:
        return steps.length * np.abs(first) + by_kinks
    second_order = steps.share * steps.length**2 / 12.0
    return second_order * (np.abs(_rate(time, piece, first)) + rest) + by_kinks


def left_in_first(
    steps: RunSteps,
    order: int,
    time: Array,
    piece: NDArray[np.int64],
    second: Array,
    *,
    sign: bool = False,
) -> Array:
    """Size (k, 3) of what is left in a velocity, from the second derivative; `sign`: as it is."""
    if order == 1:
        left = 0.5 * steps.length * second
    else:
        left = steps.share * steps.length**2 / 6.0 * _rate(time, piece, second)
    return left if sign else np.abs(left)


def _at_jumps(time: Array, piece: NDArray[np.int64], first: Array) -> Array:
    """
    What the spline makes of r' that jumps, though little, where only r'' should: the steps leave
    another share in r' on either side of a jump.

        first   : (k, 3) what is left in r'
        returns : (k, 3) in r'', near jumps
    """
    found = np.zeros_like(first)
    for i in np.flatnonzero(np.diff(piece)).tolist():
        size = KINK * np.abs(first[i + 1] - first[i]) / (time[i + 1] - time[i])
        for away in range(KINK_REACH):
            for k in (i - away, i + 1 + away):
                if 0 <= k < len(found):
                    found[k] += size * KINK_DECAY**away
    return found


def _rate(time: Array, piece: NDArray[np.int64], values: Array) -> Array:
    """Rates of change (k, 3) by differences that do not reach over jumps."""
    steps = np.diff(values, axis=0) / np.diff(time)[:, None]
    inside = (np.diff(piece) == 0)[:, None]
    steps = np.where(inside, steps, 0.0)
    padded = np.concatenate(
        (np.zeros((1, values.shape[1])), steps, np.zeros((1, values.shape[1])))
    )
    counts = np.concatenate(([[0.0]], inside.astype(float), [[0.0]]))
    return (padded[:-1] + padded[1:]) / np.maximum(counts[:-1] + counts[1:], 1.0)
