# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Newton's cradle: five steel balls in a row that touch, the first comes with 1 m/s.

Without loss the last leaves with it, and the others stay where they are. Nothing pulls at them:
they hover over the ground, which engines want to have.
"""

from __future__ import annotations

from rigid_body_sim.exact.hard_spheres import hard_spheres
from rigid_body_sim.report.problem import (
    CONTACT_ERRORS,
    Problem,
    ladder,
    position_error,
    scene_document,
    smooth_balls,
)

COUNT, RADIUS, SPEED, GAP, HOVER = 5, 0.05, 1.0, 0.0503, 1.0  # [-], [m], [m/s], [m], [m]
DURATION = 0.4  # [s]
PLACES = [(-2.0 * RADIUS - GAP, 0.0, HOVER)]
PLACES += [(2.0 * RADIUS * number, 0.0, HOVER) for number in range(COUNT - 1)]
SPEEDS = [(SPEED, 0.0, 0.0)] + [(0.0, 0.0, 0.0)] * (COUNT - 1)


def _end() -> list[tuple[float, ...]]:
    end, _ = hard_spheres(
        PLACES, SPEEDS, mass=1.0, radius=RADIUS, restitution=1.0, duration=DURATION
    )
    return [(0.0, 0.0, 0.0), *map(tuple, end.position.tolist())]


PROBLEM = Problem(
    name='cradle',
    title="Newton's cradle: five balls that touch",
    description='A ball of 1 kg runs with 1 m/s into four that touch in a row, restitution 1.',
    shows='Balls that touch take an impact one after the other; solved all at once, the wrong '
    'ones leave.',
    document=scene_document(
        'cradle',
        smooth_balls(PLACES, SPEEDS, mass=1.0, radius=RADIUS),
        contact={'mode': 'timestep'},
    ),
    duration=DURATION,
    error=position_error(_end()),
    error_unit='m',
    reference='impacts of pairs, one after the other',
    useless=0.05,
    integrators=('dmv6', 'dmv6:contact=event'),
    steps=ladder(0.02, 0.0001),
    steps_of={'dmv6:contact=event': ladder(0.02, 0.002)},
    errors=CONTACT_ERRORS,
    tick=0.02,
)
