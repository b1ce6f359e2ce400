# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The registry of force elements: every module of this folder that defines `ELEMENT`.

To add one, write one file. `evaluator` joins the kernels that a scene needs, and no others, into one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from rigid_body_sim.physics.forces.element import ForceElement
from rigid_body_sim.physics.kernels import kernel, specialise, unbound


def _found() -> dict[str, type[ForceElement]]:
    found = {}
    for module in iter_modules(__path__):
        element = getattr(import_module(f'{__name__}.{module.name}'), 'ELEMENT', None)
        if element is not None:
            found[element.TYPE] = element
    return found


FORCES = _found()

# bound for each link of the chain by `specialise`
accumulate: Callable[..., Any] = unbound
remaining: Callable[..., Any] = unbound


@kernel
def _nothing(place, time, translation, rotation, elements, ranges):
    """End the chain."""


def _evaluate(place, time, translation, rotation, elements, ranges):
    """Add the wrenches of one type of force, then those of the others: ranges holds (start, count) of each."""
    accumulate(elements, ranges[place], ranges[place + 1], time, translation, rotation)
    remaining(place + 2, time, translation, rotation, elements, ranges)


def evaluator(kernels: Sequence[tuple[str, Callable[..., Any]]]) -> Callable[..., Any]:
    """
    Join force kernels.

        kernels : (name, kernel) in the order of their tables
        returns : kernel (0, time, translation, rotation, elements, ranges)
    """
    chain, names = _nothing, ''
    for name, accumulate_one in reversed(kernels):
        names = f'{name}_{names}'
        chain = specialise(_evaluate, name=names, accumulate=accumulate_one, remaining=chain)
    return chain
