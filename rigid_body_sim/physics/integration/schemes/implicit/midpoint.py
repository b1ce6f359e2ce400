# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The implicit midpoint rule: a lane kernel for free bodies, Newton's method for coupled ones; the
two give the same motion.

    r1 = r0 + h v,  p1 = p0 + h F,  L1 = L0 + h T      F, T, v of the state half-way
    I w + (h/2) w x I w = R0^T (L0 + (h/2) T),  q1 = q0 (h w / 2, 1) / |(h w / 2, 1)|

With a held torque that is half a kick, the propagator of `free_rotation.implicit_midpoint`, and
half a kick.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.forces.evaluator import Derivatives
from rigid_body_sim.physics.integration.free_rotation import implicit_midpoint
from rigid_body_sim.physics.integration.schemes.implicit.scheme import Implicit
from rigid_body_sim.physics.integration.schemes.splitting import Splitting


class ImplicitMidpoint:
    """The scheme of the implicit midpoint rule."""

    def __init__(self) -> None:
        self._free = Splitting(
            kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=implicit_midpoint.drift, order=2
        )
        self._coupled = Implicit(stages=1, gamma=0.5, midpoint=True)

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        return self._free.free(name)

    def coupled(
        self,
        name: str,
        *,
        scene: str,
        evaluate: Callable[..., Any],
        velocity_dependent: bool,
        derivatives: Derivatives,
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        return self._coupled.coupled(
            name,
            scene=scene,
            evaluate=evaluate,
            velocity_dependent=velocity_dependent,
            derivatives=derivatives,
        )

    def workspace(self, blocks: int) -> int:
        """Count no numbers: the plan of the scene has room for all."""
        return 0
