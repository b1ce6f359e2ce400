# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The kernels of the forces of a scene, joined into one: those that it needs, and no others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise

accumulate = slot(
    'kernel (elements, start, count, time, translation, rotation): adds the wrenches of the '
    'elements of one type'
)
linearise = slot(
    'kernel (elements, start, count, time, translation, rotation, table, definite): adds their '
    'derivatives'
)
remaining = slot('kernel (place, time, …): does the same for the other types')


@inline
def _nothing(place, time, translation, rotation, elements, ranges):
    """End the chain."""


def _evaluate(place, time, translation, rotation, elements, ranges):
    """
    Add the wrenches of one type of force, then those of the others: ranges holds (start, count) of
    each.
    """
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
        chain = specialise(
            _evaluate, name=names, inlined=True, accumulate=accumulate_one, remaining=chain
        )
    return chain


@kernel
def _no_derivatives(place, time, translation, rotation, elements, ranges, table, definite):
    """End the chain."""


def _linearise(place, time, translation, rotation, elements, ranges, table, definite):
    """Add the derivatives of one type of force, then those of the others."""
    linearise(
        elements, ranges[place], ranges[place + 1], time, translation, rotation, table, definite
    )
    remaining(place + 2, time, translation, rotation, elements, ranges, table, definite)


def _pass_by(place, time, translation, rotation, elements, ranges):
    """Skip one type of force."""
    remaining(place + 2, time, translation, rotation, elements, ranges)


def _pass_by_derivatives(place, time, translation, rotation, elements, ranges, table, definite):
    """Skip one type of force."""
    remaining(place + 2, time, translation, rotation, elements, ranges, table, definite)


NO_DERIVATIVES = _no_derivatives


@dataclass(frozen=True)
class Derivatives:
    """
    How the wrenches of a scene change with its state.

    linearise : kernel (0, time, translation, rotation, elements, ranges, table, definite): the
                elements that know it
    rest      : kernel (0, time, translation, rotation, elements, ranges): the wrenches of the
                others; None: no others
    """

    linearise: Callable[..., Any]
    rest: Callable[..., Any] | None


def derivatives(elements: Sequence[tuple[str, Any]], *, by_differences: bool) -> Derivatives:
    """
    Join the derivatives of force elements.

        elements       : (name, element or module) in the order of their tables
        by_differences : as if none knew its derivatives: one of them changes what others do
    """
    known, rest, names, others = _no_derivatives, _nothing, '', 0
    for name, element in reversed(elements):
        names = f'{name}_{names}'
        kernel_of_one = None if by_differences else getattr(element, 'linearise', None)
        if kernel_of_one is None:
            others += 1
            known = specialise(_pass_by_derivatives, name=names, remaining=known)
            rest = specialise(
                _evaluate, name=f'rest_{names}', accumulate=element.accumulate, remaining=rest
            )
        else:
            known = specialise(_linearise, name=names, linearise=kernel_of_one, remaining=known)
            rest = specialise(_pass_by, name=names, remaining=rest)
    return Derivatives(known, rest if others else None)
