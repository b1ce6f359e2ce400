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


@dataclass(frozen=True)
class Limits:
    """
    Largest steps; infinite where there is no limit.

    rotation    : [rad] h |omega| of a free body that keeps energy and |L| within 1 % over 5000
                  steps, on the worst of four bodies, a thin rod among them
                  (`benchmark/stability_limits.py`; 4 is the largest tried there)
    gyroscopic  : the error is that of the term omega x I omega, so that the limit is the longer
                  the nearer to one another the moments are
    matrix      : [rad] `rotation` with `orientation: matrix`
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
    matrix: float | None = None
    oscillation: float = math.inf
    oscillation_with_velocity: float | None = None
    bent: float = math.inf
    resists: bool = False
    relaxation: float = math.inf

    def with_matrix(self) -> Limits:
        """Give the limits of the same method on the state with a rotation matrix."""
        if self.matrix is None:
            return self
        return replace(self, rotation=self.matrix, gyroscopic=False)
