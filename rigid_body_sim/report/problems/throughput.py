# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free bodies by the hundred thousand: what a step of one of them costs.

Each tumbles with a rate of its own under gravity; the error is that of the attitude of the first
hundred, from Jacobi's solution.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.exact import free_asymmetric_top
from rigid_body_sim.exact.attitude import angle_between
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.report.problem import (
    SEED,
    THROUGHPUT,
    Final,
    Problem,
    principal,
    scene_document,
)

MOMENTS = (1.0, 2.0, 2.5)  # [kg m^2]
DURATION = 0.5  # [s]
STEP = 0.001  # [s]
JUDGED = 100  # bodies whose end is compared


def rates(bodies: int) -> NDArray[np.float64]:
    """Angular velocities (n, 3) [rad/s] of length 1, any direction."""
    drawn = np.random.default_rng(SEED).normal(size=(bodies, 3))
    return drawn / np.linalg.norm(drawn, axis=1)[:, None]


def spread(scene: Scene, bodies: int) -> Scene:
    """Make many of the one body, each with a rate of its own."""
    one = scene.bodies[0]
    return replace(
        scene,
        bodies=tuple(
            replace(
                one,
                name=f'b{index}',
                initial=replace(one.initial, angular_velocity=tuple(rate)),
            )
            for index, rate in enumerate(rates(bodies).tolist())
        ),
    )


EXACT = np.stack(
    [
        free_asymmetric_top.rotation(
            DURATION, inertia=MOMENTS, angular_velocity_body=rate
        ).orientation
        for rate in rates(JUDGED)
    ]
)


def error(final: Final) -> float:
    """Largest angle [rad] of the first hundred bodies from their exact attitudes."""
    judged = min(len(final.orientation), JUDGED)
    return float(np.max(angle_between(final.orientation[:judged], EXACT[:judged])))


PROBLEM = Problem(
    name='throughput',
    title='Throughput: 1 to 100 000 free bodies',
    description='Bodies with moments 1, 2 and 2.5 kg m^2 tumble at 1 rad/s in all directions '
    'under gravity; 500 steps of 1 ms.',
    shows='The cost of a body and step falls until the blocks of 64 are full and stays there.',
    document=scene_document(
        'throughput',
        [{'name': 'b0', 'mass': 1.0, 'inertia': principal(MOMENTS)}],
        gravity=(0.0, 0.0, -9.81),
    ),
    duration=DURATION,
    error=error,
    error_unit='rad',
    reference="Jacobi's elliptic functions",
    useless=0.5,
    integrators=('semi_implicit_euler', 'five_rotations', 'dmv6', 'rk4'),
    steps=(STEP,),
    tick=STEP,
    kind=THROUGHPUT,
    bodies=(1, 10, 100, 1_000, 10_000, 100_000),
    spread=spread,
)
