# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the steps of a run leave in its recorded poses: the wrench that explains these is not quite
the one that acted.

    kick, drift, kick   x_n+1 - 2 x_n + x_n-1 = h^2 a_n,   so   r'' = a - h^2 a'' / 12 + O(h^4)
                        v_n = (x_n+1 - x_n-1) / 2 h,       so   r'  = v - h^2 a' / 6

Other methods of order two have constants of the same size, taken as these. A method of order one
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
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RunSteps:
    """
    Steps of a run.

    length   : [s]
    order    : 1 or 2
    turns_free : whether a free body turns to a higher order
    """

    length: float
    order: int
    turns_free: bool


def steps_of(manifest: Mapping[str, str]) -> RunSteps | None:
    """Read the steps of a recorded run; None where they are not known, or of a higher order."""
    try:
        integrator = INTEGRATORS[manifest['integrator']]
        options = json.loads(manifest.get('integrator_options', '{}'))
        length = int(manifest['dt_ns']) * 1e-9 / max(1, int(options.get('substeps', 1)))
    except (KeyError, ValueError, TypeError, AttributeError):
        return None
    splits = isinstance(integrator.scheme, Splitting)
    # a kick and a drift are, seen from positions, what two half kicks about it are
    order = 2 if splits and integrator.order == 1 else integrator.order
    if order > 2 or not 0.0 < length < np.inf:
        return None
    return RunSteps(length, int(order), splits and integrator.free_order > 2)


def left_in_second(
    steps: RunSteps,
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
    if steps.order == 1:
        return steps.length * np.abs(first)
    return steps.length**2 / 12.0 * (np.abs(_rate(time, piece, first)) + rest)


def left_in_first(steps: RunSteps, time: Array, piece: NDArray[np.int64], second: Array) -> Array:
    """Size (k, 3) of what is left in a velocity, from the second derivative."""
    if steps.order == 1:
        return 0.5 * steps.length * np.abs(second)
    return steps.length**2 / 6.0 * np.abs(_rate(time, piece, second))


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
