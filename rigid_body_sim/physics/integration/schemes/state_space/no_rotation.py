# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What stands for the rotation in the kernels of a scene of point masses: nothing.

A scheme that can do without rotation says so by `for_points()`; what it would compile for rigid
bodies is then neither compiled nor called.
"""

from __future__ import annotations

from typing import Any, TypeVar

from rigid_body_sim.physics.compile.kernels import inline

T = TypeVar('T')


def for_points(scheme: T) -> T:
    """Return the scheme without its rotation, where it can do without."""
    of_points: Any = getattr(scheme, 'for_points', None)
    return scheme if of_points is None else of_points()


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
def save_turns(lanes, s, memory, saved):
    """Keep nothing."""


@inline
def restore_turns(lanes, saved, y, s):
    """Return to nothing."""


@inline
def error_of_turns(lanes, h, y, rtol, atol, first, worst, culprit):
    """Err by nothing."""
    return worst, culprit
