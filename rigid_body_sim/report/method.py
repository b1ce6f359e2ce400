# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A method as a user names it: an integrator, with options behind it.

    rk8    blanes_moan4:drift=exact    rk4:orientation=matrix,reorthonormalise=true
    dmv6:contact=event                 where bodies meet: impacts at their instants
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import yaml

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.contact.settings import MODES
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.report.names import chosen

CONTACT = 'contact'  # beside the options of the integrator: the mode of contact


@dataclass(frozen=True)
class Method:
    """
    One method.

    text       : as the user wrote it
    integrator : its name
    options    : those given
    contact    : mode in which bodies meet; '': that of the problem
    """

    text: str
    integrator: str
    options: Mapping[str, Any] = field(default_factory=dict)
    contact: str = ''

    def configured(self) -> Integrator:
        """Give the integrator that obeys the options."""
        return INTEGRATORS[self.integrator].configured(self.options)

    def scene_of(self, scene: Scene) -> Scene:
        """Give a scene with the mode of contact of this method, where its bodies meet."""
        if not self.contact or scene.contact.get('mode', 'none') == 'none':
            return scene
        return replace(scene, contact={**scene.contact, 'mode': self.contact})


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
    contact = options.pop(CONTACT, '')
    if contact not in ('', *MODES):
        raise UserError(f'{option}: {text!r}: {CONTACT}={contact}; allowed: {", ".join(MODES)}')
    found = Method(text, name, options, contact)
    try:
        found.configured()
    except InvalidModel as error:
        raise UserError(f'{option}: {text!r}: {error}') from None
    return found
