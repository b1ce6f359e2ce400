# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The nine numbers of R drift away from a rotation: R' = w* R, and nothing else holds them together.

    d = max |(R^T R - 1)_ij|
"""

from __future__ import annotations

from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.report.problem import (
    LECTURE,
    Final,
    Problem,
    ladder,
    principal,
    scene_document,
)

MOMENTS, RATE = (1.0, 2.0, 2.5), (0.5, 1.0, 1.5)  # [kg m^2], [rad/s] body axes
DURATION = 20.0  # [s]
AS_MATRIX = 'orientation=matrix'


def drift(simulation: Simulation) -> float:
    """Tell how far the matrices are from rotations [-]."""
    found = simulation.orientation_drift()
    return 0.0 if found is None else found


def unseen(final: Final) -> float:
    """A state shows the nearest rotation: nothing of the drift."""
    return 0.0


PROBLEM = Problem(
    name='drift_of_r',
    heading=LECTURE,
    title='The drift of R',
    description='A body with moments 1, 2 and 2.5 kg m^2 tumbles freely for 20 s, its attitude '
    'kept as a matrix of nine numbers.',
    shows='Six of the nine are redundant: they drift with the order of the method, unless the '
    'matrix is made orthogonal after each step.',
    document=scene_document(
        'drift_of_r',
        [
            {
                'name': 'body',
                'mass': 1.0,
                'inertia': principal(MOMENTS),
                'initial': {'angular_velocity_body': list(RATE)},
            }
        ],
    ),
    duration=DURATION,
    error=unseen,
    error_of_run=drift,
    error_unit='-',
    reference='R^T R = 1',
    useless=1.0,
    integrators=(
        f'explicit_euler:{AS_MATRIX}',
        f'midpoint:{AS_MATRIX}',
        f'rk4:{AS_MATRIX}',
        f'rk45:{AS_MATRIX}',
        f'rk8:{AS_MATRIX}',
        f'rk4:{AS_MATRIX},reorthonormalise=true',
    ),
    steps=ladder(0.5, 0.001),
    tick=5.0,
)
