# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How long a step of an integrator may be, in numbers: beyond them a run is warned
(`diagnostics.step_limits`).

All three are products with the step h, so they hold for any body and any scene.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slender:
    """
    How the limit of free rotation falls with r = I_max/I_min, the ratio of the moments of a body:
    times (ratio/r)^power where r is larger than `ratio`, and never below `least`.

    L is kept in world axes, so an error d of the attitude changes its part along the thin axis by
    |L| d, and the energy by up to r d^2 of itself. The numbers are measured, on 3500 to 26,000
    random bodies of ratios 1 to 1e6 for each method over 5000 steps (`docs/stability.md`), and
    stay below the first failure, by 10 % to 30 % but for implicit_midpoint: on a flat rod it has
    no unique solution from h |omega| = 2 on, the rate at which a turn about the middle axis flips.

    ratio : [-]   I_max/I_min from which on the limit falls
    power : [-]
    least : [rad]
    """

    ratio: float
    power: float
    least: float = 0.0


@dataclass(frozen=True)
class Limits:
    """
    Largest steps; infinite where there is no limit.

    rotation    : [rad] h |omega| of a free body that keeps energy and |L| within 1 % over 5000
                  steps, on the worst of four bodies, a thin rod among them
                  (`benchmark/stability_limits.py`; 4 is the largest tried there)
    gyroscopic  : the error is that of the term omega x I omega, so that the limit is the longer
                  the nearer to one another the moments are
    slender     : how `rotation` falls with I_max/I_min; None: it holds for needles too
    matrix      : [rad] `rotation` with `orientation: matrix`
    matrix_slender : `slender` of it
    oscillation : [rad] h omega of a spring without damping up to which it does not grow: the
                  largest z at which |R(i z)| <= 1, R the stability function; where there is none,
                  up to which the energy grows by less than 1 % over 5000 steps
    bent        : [rad] the same where a force of a spring is not linear in the state: it has a
                  rest length, or holds a body off its centre of mass. The largest step that kept
                  the energy of random chains (`benchmark/stiff_chains.py`)
    resists     : that the latter holds: damping c >= h k makes such a spring stable
    oscillation_with_velocity : [rad] `oscillation` in a scene where a force depends on velocity,
                  of a method that makes its steps otherwise there
    relaxation  : [-] h k of linear drag, v' = -k v, up to which v does not grow: |R(-z)| <= 1
    """

    rotation: float = math.inf
    gyroscopic: bool = False
    slender: Slender | None = None
    matrix: float | None = None
    matrix_slender: Slender | None = None
    oscillation: float = math.inf
    oscillation_with_velocity: float | None = None
    bent: float = math.inf
    resists: bool = False
    relaxation: float = math.inf

    def with_matrix(self) -> Limits:
        """Give the limits of the same method on the state with a rotation matrix."""
        if self.matrix is None:
            return self
        slender = self.matrix_slender
        return replace(self, rotation=self.matrix, slender=slender, gyroscopic=False)

    def rotation_of(self, ratio: Array) -> Array:
        """Limits of free rotation (n,) [rad] of bodies by their I_max/I_min (n,), 1 or more."""
        rotation = np.full(len(ratio), self.rotation)
        if self.gyroscopic:
            rotation /= np.minimum(ratio - 1.0, 1.0)
        if self.slender is not None:
            falls = np.minimum(self.slender.ratio / ratio, 1.0) ** self.slender.power
            rotation = np.maximum(rotation * falls, self.slender.least)
        return rotation
