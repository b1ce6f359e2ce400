# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A series of ever smaller bounces, summed: after a rebound with speed v against a steady
deceleration a, impacts follow at times that shrink by e, infinitely many in a finite time (Zeno).

    time      2 v / (a (1 - e))
    path      v^2 / (a (1 - e^2))           up and down along the normal
    impulse   m v (1 + e) / (1 - e)         m: effective mass along the normal

While the point slips, each impact takes mu K_tt times its impulse of the slip; between them a
tangential acceleration g_t adds to it. With t_k the flight after the k-th impact, t_0 = 2 v / a:

    t_k = t_0 e^k     slip_k = slip_0 + (g_t t_0 - mu K_tt m (1 + e) v) (1 - e^k)/(1 - e)

All of this is exact for a central impact: a ball, or a body that falls flat.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline


@inline
def rest_of_series(speed: float, deceleration: float, restitution: float) -> Any:
    """
    Return time [s], path [m] and impulse over mass [m/s] of all that follows a rebound.

    speed        : of the rebound, along the normal [m/s]
    deceleration : by which the flight ends again [m/s^2], > 0
    restitution  : e < 1
    """
    lost = 1.0 - restitution
    time = 2.0 * speed / (deceleration * lost)
    path = speed * speed / (deceleration * lost * (1.0 + restitution))
    return time, path, speed * (1.0 + restitution) / lost


@inline
def slip_of_series(
    slip: float, gain: float, loss: float, flight: float, restitution: float
) -> Any:
    """
    Return how far a point slips during a series of bounces [m], and the slip that is left [m/s].

    slip   : speed of the slip after the rebound [m/s]
    gain   : acceleration of the slip between the impacts [m/s^2]
    loss   : what friction takes of it at the next impact, while it slips [m/s]
    flight : time to the next impact, t_0 [s]

    slip_k = slip + (gain t_0 - loss) (1 - e^k)/(1 - e) after impact k. Where that falls to zero
    the point sticks to the end.
    """
    lost = 1.0 - restitution
    change = gain * flight - loss
    left = slip + change / lost
    flights, squares = 1.0 / lost, 1.0 / (lost * (1.0 + restitution))  # sums of e^k, of e^2k
    if left < 0.0:
        # the last flight with slip: the largest k with (1 - e^k) <= slip (1 - e) / -change
        share = 1.0 + slip * lost / change
        count = 1.0
        if restitution > 0.0:
            count += math.floor(math.log(share) / math.log(restitution))
        power = restitution**count
        flights *= 1.0 - power
        squares *= 1.0 - power * power
        left = 0.0
    # each flight goes slip_k t_k + gain t_k^2 / 2
    steady = (slip + change / lost) * flights
    return flight * (steady + (0.5 * gain * flight - change / lost) * squares), left
