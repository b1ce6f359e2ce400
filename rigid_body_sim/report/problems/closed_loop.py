# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A controller in Python brakes 1 to 1000 bodies: what it pays for reading, commanding and one step.

Before each tick it reads all velocities and commands -c v and -d w, which act over the tick:

    v_{k+1} = (1 - c h / m) v_k        x_{k+1} = x_k + h (v_k + v_{k+1}) / 2

and the same about the axis of rotation, which a body with three equal moments keeps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.exact.attitude import angle_between
from rigid_body_sim.report.problem import (
    THROUGHPUT,
    Final,
    Problem,
    principal,
    scene_document,
)
from rigid_body_sim.report.problems.throughput import rates, spread

Array = NDArray[np.float64]

MOMENT = 0.1  # [kg m^2]
DRAG = 0.2  # [N m s] d; the bodies do not travel
DURATION, STEP = 0.5, 0.001  # [s]
JUDGED = 100  # bodies whose end is compared


def control(velocity: Array, angular_velocity: Array) -> tuple[Array, Array]:
    """Brake all bodies."""
    return -DRAG * velocity, -DRAG * angular_velocity


def _exact() -> Array:
    """Attitudes (JUDGED, 4) at the end."""
    kept = 1.0 - DRAG * STEP / MOMENT
    ticks = round(DURATION / STEP)
    spins = kept ** np.arange(ticks + 1)  # of the start, at each tick
    angle = STEP * float(np.sum(spins[:-1] + spins[1:])) / 2.0
    axes = rates(JUDGED)  # unit vectors: the bodies begin with 1 rad/s
    return np.hstack([np.sin(angle / 2.0) * axes, np.full((JUDGED, 1), np.cos(angle / 2.0))])


EXACT = _exact()


def error(final: Final) -> float:
    """Largest angle [rad] of the first hundred bodies from their exact attitudes."""
    judged = min(len(final.orientation), JUDGED)
    return float(np.max(angle_between(final.orientation[:judged], EXACT[:judged])))


PROBLEM = Problem(
    name='closed_loop',
    title='Closed loop: a controller in Python commands 1 to 1000 bodies',
    description='Bodies that turn at 1 rad/s are braked by a controller that reads all velocities '
    'and commands all bodies before each of 500 steps of 1 ms.',
    shows='Calls and copies cost more than the step itself, until there are hundreds of bodies.',
    document=scene_document(
        'closed_loop', [{'name': 'b0', 'mass': 2.0, 'inertia': principal([MOMENT] * 3)}]
    ),
    duration=DURATION,
    error=error,
    error_unit='rad',
    reference='a geometric series',
    useless=0.5,
    integrators=('dmv6', 'rk4'),
    steps=(STEP,),
    tick=STEP,
    kind=THROUGHPUT,
    bodies=(1, 10, 100, 1_000),
    spread=spread,
    control=control,
)
