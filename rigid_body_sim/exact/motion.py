# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a closed form returns: one row per instant.

Closed forms take times `t` of any shape `T`; a vector gains one trailing axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Translation(NamedTuple):
    """
    Motion of a point.

    position : (*T, d) [m]    world
    velocity : (*T, d) [m/s]  world
    """

    position: Array
    velocity: Array


class Rotation(NamedTuple):
    """
    Turning of a rigid body about its centre of mass, or about its pivot.

    orientation           : (*T, 4) [-]      unit quaternion xyzw, body to world
    angular_velocity_body : (*T, 3) [rad/s]  body axes
    """

    orientation: Array
    angular_velocity_body: Array


def column(t: object) -> Array:
    """Return times as an array that broadcasts against vectors: (*T, 1) [s]."""
    return np.asarray(t, dtype=float)[..., np.newaxis]
