# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a scene may set of an integrator, beside its name: tolerances, substeps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rigid_body_sim.physics.errors import InvalidModel, choose_from
from rigid_body_sim.physics.model.numbers import is_number, shown


@dataclass(frozen=True)
class Option:
    """
    One option: a number from `minimum` to `maximum` (with an int as default, a whole one), one of
    `choices`, or (with a bool as default) yes or no.
    """

    default: float | str | bool
    minimum: float = 0.0
    maximum: float = 1.0
    choices: tuple[str, ...] = ()

    def checked(self, name: str, value: Any) -> float | str | bool:
        """Return the value as it will be used; InvalidModel where it cannot be."""
        if self.choices:
            if not isinstance(value, str) or value not in self.choices:
                raise InvalidModel(
                    f'{name}: got {shown(value)}; allowed: {", ".join(self.choices)}'
                )
            return str(value)
        if isinstance(self.default, bool):
            if not isinstance(value, bool):
                raise InvalidModel(f'{name}: got {shown(value)}; true or false is needed')
            return value
        if not is_number(value):
            raise InvalidModel(f'{name}: got {shown(value)}; a finite number is needed')
        if not self.minimum <= value <= self.maximum:
            raise InvalidModel(
                f'{name}: got {shown(value)}; a number from {self.minimum!r} '
                f'to {self.maximum!r} is needed'
            )
        if isinstance(self.default, int):
            if value != int(value):
                raise InvalidModel(f'{name}: got {shown(value)}; a whole number is needed')
            return int(value)
        return float(value)


def checked(
    integrator: str, options: Mapping[str, Option], given: Mapping[str, Any]
) -> dict[str, Any]:
    """
    Return every option with its value; InvalidModel for an unknown option or an impossible value.
    """
    for name in given:
        if name not in options:
            cure = choose_from(name, options) if options else '; allowed: none'
            raise InvalidModel(f'integrator {integrator!r} has no option {shown(name)}{cure}')
    try:
        return {
            name: option.checked(name, given.get(name, option.default))
            for name, option in options.items()
        }
    except InvalidModel as error:
        raise InvalidModel(f'integrator {integrator!r}: {error}') from None


SUBSTEPS = Option(1, minimum=1, maximum=1_000_000)  # of every integrator: steps that make a tick


def tolerances(rtol: float, atol: float) -> dict[str, Option]:
    """
    Make the options of a method that controls its error, with their defaults.

    rtol : [-] of the length of each vector of the state; not below 1e-13, where rounding stands in
           the way
    atol : [SI unit of each vector]
    """
    return {
        'rtol': Option(rtol, minimum=1e-13, maximum=0.1),
        'atol': Option(atol, minimum=1e-300, maximum=1.0),
    }
