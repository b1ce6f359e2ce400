# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What stands for the rotation in the kernels of a scene of point masses: nothing.

A scheme that can do without rotation says so by `for_points()`; what it would compile for rigid
bodies is then neither compiled nor called.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.kernels import inline


def for_points(scheme: Any) -> Any:
    """Return the scheme without its rotation, where it can do without."""
    return scheme.for_points() if hasattr(scheme, 'for_points') else scheme


@inline
def drift(block, lanes, kick, h, rotation, method):
    """Turn nothing."""


@inline
def kick(block, lanes, time, rotation):
    """Kick nothing."""


@inline
def step(lanes, h, s, y):
    """Step nothing."""


@inline
def begin(lanes, s, y, memory):
    """Begin nothing."""


@inline
def move(stage, lanes, h, s, y):
    """Move nothing."""


@inline
def slope_of(lanes, s, y, slope):
    """Find no slope."""


@inline
def end(lanes, h, s, y, memory):
    """End nothing."""


@inline
def set_rate(lanes, s, y):
    """Write nothing."""


@inline
def error_of(lanes, h, y, rtol, atol, first, worst, culprit):
    """Err by nothing."""
    return worst, culprit
