# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Motions as told that ticks do not resolve: their velocity changes too much within one.

    max |x''| dt > MOST max |x'|   and   max |x''| > g    x: a way of the path, or an arc

What lies on a surface follows it, however fast, while its acceleration stays below that of
gravity. What is thrown leaves with the velocity that the surface has where the substep ends, and
not where it parted. With impacts at their instants that is told of what flies, so that only what
lies has to be resolved.
"""

from __future__ import annotations

import math

import numpy as np

from rigid_body_sim.physics.contact.settings import EVENT, ContactSettings
from rigid_body_sim.physics.model.prescribed_motion import WAYS, greatest_rates
from rigid_body_sim.physics.model.reach import reach
from rigid_body_sim.physics.model.scene import Body, Scene

# [-] of the greatest velocity. With 8 ticks in a period of a heave, 0.8, what bounces off is wrong
# by 0.1 of that in the median and 0.4 at worst; with 32, by 0.02 and 0.1
MOST = 0.8
MOST_OF_EVENTS = 3.2  # two ticks in a period


def unresolved_motion_warnings(scene: Scene) -> tuple[str, ...]:
    """Say which bodies move so that ticks do not resolve it."""
    is_event = ContactSettings.of(scene.contact).mode == EVENT
    most = MOST_OF_EVENTS if is_event else MOST
    gravity, dt = math.hypot(*scene.gravity), 1e-9 * scene.dt_ns
    found = []
    for body in scene.bodies:
        way, change = _swiftest(body, gravity)
        if change * dt > most:
            cure = f'set dt to at most {0.95 * most / change:.2g} s'
            if not is_event:
                cure += ', or contact: {mode: event} if it throws what flies'
            found.append(
                f'{body.name!r} moves faster than ticks of {dt:.3g} s can follow: in one its '
                f'{way} changes its velocity by {change * dt:.3g} times the greatest that it has, '
                f'and with which speed it throws things depends on where ticks fall; {cure}'
            )
    return tuple(found)


def _swiftest(body: Body, gravity: float) -> tuple[str, float]:
    """Return the way whose velocity changes most, and how fast, by its greatest one [1/s]."""
    way, most = '', 0.0
    if body.motion is None or body.shape is None:
        return way, most
    speeds, changes = greatest_rates(body)
    lever = np.repeat((1.0, reach(body)), 3)  # of angles their arcs
    for index, name in enumerate(WAYS):
        if changes[index] * lever[index] > gravity and changes[index] > most * speeds[index]:
            way, most = name, float(changes[index] / speeds[index])
    return way, most
