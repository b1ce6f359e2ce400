# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A break shot: a ball runs with 2 m/s into six that stand in a triangle, 4 mm apart.

Smooth and without loss; each impact at its instant, one after the other, by the quadratic equation
of two spheres. Nothing pulls at the balls: they hover over the ground, which engines want to have.
"""

from __future__ import annotations

import math

from rigid_body_sim.exact.hard_spheres import hard_spheres
from rigid_body_sim.report.problem import (
    CONTACT_ERRORS,
    Problem,
    ladder,
    position_error,
    scene_document,
    smooth_balls,
)

RADIUS, SPEED, PITCH, HOVER = 0.03, 2.0, 0.064, 1.0  # [m], [m/s], [m], [m]
ASIDE = 0.011  # [m] the first ball runs beside the axis of the triangle: no two meet at once
DURATION = 0.6  # [s]
RACK = [
    (row * PITCH * math.sqrt(0.75), PITCH * (place - 0.5 * row), HOVER)
    for row in range(3)
    for place in range(row + 1)
]
PLACES = [(-0.2, ASIDE, HOVER), *RACK]
SPEEDS = [(SPEED, 0.0, 0.0)] + [(0.0, 0.0, 0.0)] * len(RACK)
END, IMPACTS = hard_spheres(
    PLACES, SPEEDS, mass=0.2, radius=RADIUS, restitution=1.0, duration=DURATION
)

PROBLEM = Problem(
    name='billiards',
    title='Billiards: a break shot',
    description=f'A ball of 0.2 kg runs with 2 m/s into six that stand 4 mm apart; {IMPACTS} '
    'impacts, restitution 1.',
    shows='Each impact turns the error of its instant and direction into one of all that follow.',
    document=scene_document(
        'billiards',
        smooth_balls(PLACES, SPEEDS, mass=0.2, radius=RADIUS),
        contact={'mode': 'timestep'},
    ),
    duration=DURATION,
    error=position_error([(0.0, 0.0, 0.0), *map(tuple, END.position.tolist())]),
    error_unit='m',
    reference='quadratic equations of two spheres, impact after impact',
    useless=0.2,
    integrators=('dmv6', 'dmv6:contact=event'),
    steps=ladder(0.02, 0.0001),
    steps_of={'dmv6:contact=event': ladder(0.02, 0.002)},
    errors=CONTACT_ERRORS,
    tick=0.02,
)
