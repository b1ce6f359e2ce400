# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The number nearest to another within limits.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.compile.kernels import inline


@inline
def clamp(x: float, limit: float) -> Any:
    """Return the number nearest to x between -limit and limit."""
    if x > limit:
        return limit
    if x < -limit:
        return -limit
    return x
