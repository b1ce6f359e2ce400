# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rod swings about a fixed point, from 2 rad: the period depends on the amplitude."""

from __future__ import annotations

import math

from rigid_body_sim.exact.pendulum import swing
from rigid_body_sim.report.problem import (
    LECTURE,
    Problem,
    attitude_error,
    ladder,
    principal,
    scene_document,
)

MASS, ARM, ACROSS, ALONG = 1.0, 0.5, 1.0 / 12.0, 0.001  # [kg], [m], [kg m^2], [kg m^2]
GRAVITY, ANGLE = 9.81, 2.0  # [m/s^2], [rad] from the lowest position, about y
DURATION = 10.0  # [s]


def attitude(angle: float) -> list[float]:
    """Attitude turned about y by an angle [rad]."""
    return [0.0, math.sin(0.5 * angle), 0.0, math.cos(0.5 * angle)]


END = swing(
    DURATION, inertia=ACROSS + MASS * ARM * ARM, weight_moment=MASS * GRAVITY * ARM, angle=ANGLE
)

PROBLEM = Problem(
    name='pendulum',
    heading=LECTURE,
    title='Pendulum: a rod swings far out',
    description='A rod of 1 kg and 1 m, held at its end, falls from 2 rad above its lowest '
    'position and swings for 10 s.',
    shows='A torque that depends on the attitude, without a closed form by elementary functions: '
    'what the small angles of the textbook leave out.',
    document=scene_document(
        'pendulum',
        [
            {
                'name': 'rod',
                'mass': MASS,
                'inertia': principal((ACROSS, ACROSS, ALONG)),
                'pivot': {'point': [0.0, 0.0, ARM], 'at': [0.0, 0.0, 0.0]},
                'initial': {'orientation': attitude(ANGLE)},
            }
        ],
        gravity=(0.0, 0.0, -GRAVITY),
    ),
    duration=DURATION,
    error=attitude_error(attitude(float(END.angle))),
    error_unit='rad',
    reference="Jacobi's elliptic functions",
    useless=0.5,
    integrators=(
        'explicit_euler',
        'semi_implicit_euler',
        'dmv6',
        'force_gradient4',
        'blanes_moan4',
        'implicit_midpoint',
        'rk4',
        'rk45',
        'rk8',
    ),
    steps=ladder(0.2, 0.0005),
    tick=2.0,
)
