# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an integrator says of itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class Scheme(Protocol):
    """
    How a tick is made: see `physics.schemes`.

    The kernels share one signature: (ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace,
    elements, ranges) -> 0.0, or NaN if a number left the finite ones.
    """

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        ...

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        ...

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        ...


def no_coefficients(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return no numbers: the method needs none of its own per body."""
    return np.zeros((len(moments), 0))


@dataclass(frozen=True)
class Integrator:
    """
    One time integration method.

    name         : what a scene calls it
    order        : power of h in the global error with smooth forces
    free_order   : the same for the attitude of a body on which no torque acts
    keeps        : what it conserves, in words
    stability    : its limit, in words
    source       : where it comes from
    coefficients : (n, 3) principal moments -> (n, rows) numbers per body that the kernel wants at hand
    """

    name: str
    order: int
    free_order: int
    keeps: str
    stability: str
    source: str
    scheme: Scheme
    coefficients: Callable[[NDArray[np.float64]], NDArray[np.float64]] = no_coefficients
