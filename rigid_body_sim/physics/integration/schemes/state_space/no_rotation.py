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
from rigid_body_sim.physics.integration.schemes.state_space.protocol import (
    ErrorControl,
    StateSpace,
)
from rigid_body_sim.physics.state.blocks import ROTATION

T = TypeVar('T')


def for_points(scheme: T) -> T:
    """Return the scheme without its rotation, where it can do without."""
    of_points: Any = getattr(scheme, 'for_points', None)
    return scheme if of_points is None else of_points()


@inline
def drift(block, lanes, kick, h, rotation, method):
    """Move nothing freely."""


@inline
def kick(block, lanes, time, rotation):
    """Kick nothing."""


@inline
def step(lanes, h, state, work):
    """Step nothing."""


@inline
def begin(lanes, state, work, memory):
    """Begin nothing."""


@inline
def move(stage, lanes, h, state, work):
    """Move nothing."""


@inline
def slope_of(lanes, state, work, slope):
    """Find no slope."""


@inline
def end(lanes, h, state, work, memory):
    """End nothing."""


@inline
def renew(lanes, state, work):
    """Write nothing."""


@inline
def keep(lanes, state, memory, kept):
    """Keep nothing."""


@inline
def restore(lanes, kept, state, work):
    """Return to nothing."""


@inline
def error_of(lanes, h, state, work, tolerances, first, worst, culprit):
    """Err by nothing."""
    return worst, culprit


NO_ROTATION = StateSpace(
    state_size=ROTATION,
    memory_size=0,
    slopes_at=0,
    slope_size=0,
    begin=begin,
    move=move,
    slope_of=slope_of,
    end=end,
    control=ErrorControl(renew=renew, keep=keep, restore=restore, error_of=error_of),
)
