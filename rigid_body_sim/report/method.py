# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A method as a user names it: an integrator, with options behind it.

    rk8    blanes_moan4:drift=exact    rk4:orientation=matrix,reorthonormalise=true
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.report.names import chosen


@dataclass(frozen=True)
class Method:
    """
    One method.

    text       : as the user wrote it
    integrator : its name
    options    : those given
    """

    text: str
    integrator: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def configured(self) -> Integrator:
        """Give the integrator that obeys the options."""
        return INTEGRATORS[self.integrator].configured(self.options)


def method(text: str, *, option: str = '--integrators') -> Method:
    """
    Read a method; UserError for an unknown integrator, which names the nearest, or a bad option.

    option : of the command line, for the message
    """
    name, _, rest = text.partition(':')
    chosen([name], INTEGRATORS, option=option, what='integrator')
    options: dict[str, Any] = {}
    for pair in filter(None, rest.split(',')):
        key, equals, value = pair.partition('=')
        if not equals:
            raise UserError(f'{option}: {text!r}: {pair!r} is no option=value; see the README')
        options[key.strip()] = yaml.safe_load(value)
    found = Method(text, name, options)
    try:
        found.configured()
    except InvalidModel as error:
        raise UserError(f'{option}: {text!r}: {error}') from None
    return found
