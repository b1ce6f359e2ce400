# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be read of contacts after a tick."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model.plain_products import cross

Array = NDArray[np.float64]

OF_POINTS = (
    'bodies',
    'point',
    'normal',
    'gap',
    'impulse',
    'angular_impulse',
)  # fields, a row each


@dataclass(frozen=True, eq=False)
class Contacts:
    """
    The points at which bodies touched in the last tick: those that overlap or pushed.

    bodies  : (m, 2) int      scene indices
    point   : (m, 3) [m]      world, midway between the two surfaces
    normal  : (m, 3) [-]      unit vector from the first body to the second, world
    gap     : (m,)   [m]      distance of the surfaces, negative where they overlap
    impulse : (m, 3) [N s]    on the second body over the last tick, world; its opposite acts on
                              the first
    angular_impulse : (m, 3) [N m s]  beside it, of rolling and torsional friction; that of the
                              last substep for each of them

    What contacts gave by their errors, and the tick took back at its end, is no impulse of a point
    (it would leave the cone of friction), but one of contact all the same:

    damped     : (k,) int              scene indices of the bodies from which it was taken
    taken_back : (k, 6) [N s, N m s]   change of their momentum, and of their angular momentum
                                       about the centre of mass; of a body on a pivot a couple,
                                       the same about any point, for the pivot takes the rest
    """

    bodies: NDArray[np.int64]
    point: Array
    normal: Array
    gap: Array
    impulse: Array
    angular_impulse: Array
    damped: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    taken_back: Array = field(default_factory=lambda: np.zeros((0, 6)))

    def __len__(self) -> int:
        return len(self.gap)

    def wrenches(self, centers: Array, dt: float) -> tuple[Array, Array]:
        """
        Sum what contacts exert on each body, as the mean over the tick.

        F = sum J / dt,   T = sum ((x - r) x J + J_angular) / dt,   with what was taken back
            centers : (n, 3) [m]  r: centres of mass at the end of the tick, scene order
            dt      : [s] tick

        returns : forces (n, 3) [N] and torques (n, 3) [N m] about the centres of mass, world axes
        """
        force, torque = np.zeros_like(centers), np.zeros_like(centers)
        for side, sign in ((1, 1.0 / dt), (0, -1.0 / dt)):
            body = self.bodies[:, side]
            about = cross(self.point - centers[body], self.impulse) + self.angular_impulse
            np.add.at(force, body, sign * self.impulse)
            np.add.at(torque, body, sign * about)
        np.add.at(force, self.damped, self.taken_back[:, :3] / dt)
        np.add.at(torque, self.damped, self.taken_back[:, 3:] / dt)
        return force, torque


NO_CONTACTS = Contacts(
    np.zeros((0, 2), dtype=np.int64),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros(0),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
)
