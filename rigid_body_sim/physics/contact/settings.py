# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a scene may set of contact by time stepping.

The contact frequency is no setting: f = 0.25 / h with the substep h, twice that against what
cannot move. A lower one lets a stack sink by a length that no smaller step mends; a higher one
never comes to rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from rigid_body_sim.physics.errors import InvalidModel

MODE = 'timestep'


@dataclass(frozen=True)
class ContactSettings:
    """
    The contact mode and its numbers; the fields are the keys of `contact` in a scene.

    substeps       : solver steps in a tick; the sink of a stack falls as their square, and heavy
                     bodies on light ones need more of them
    damping_ratio  : [-] of the soft contact, zeta
    relaxations    : passes that take the push-out velocity back and apply friction; 1 is quicker,
                     2 comes to rest
    restitution_threshold : [m/s] slower impacts do not bounce; larger ones cut visible bounces
    slop           : [m] overlap that is left alone: a constant error of height
    push_out_speed : [m/s] the fastest that overlap is undone
    margin         : [m] gap within which a contact is foreseen, at most a tenth of the radius of
                     the smaller body; motion over a tick is added
    sleeping       : true: islands at rest are left out until something reaches them, see
                     `sleeping`; false: every body is solved in every tick
    sleep_speed    : [m/s] slower bodies may fall asleep, with what is left of their momentum; a
                     larger one stops what creeps, a smaller one than the jitter of a heap lets
                     nothing sleep
    sleep_time     : [s] so long they must have been slower; a shorter one stops what is only about
                     to turn back or to fall over
    """

    mode: str = MODE
    substeps: int = 4
    damping_ratio: float = 2.0
    relaxations: int = 2
    restitution_threshold: float = 0.01
    slop: float = 0.0
    push_out_speed: float = 3.0
    margin: float = 0.01
    sleeping: bool = False
    sleep_speed: float = 0.01
    sleep_time: float = 0.5

    def __post_init__(self) -> None:
        if self.mode != MODE:
            raise InvalidModel(f'contact.mode: got {self.mode!r}; allowed: none, {MODE}')
        for name, most in (('substeps', 1000), ('relaxations', 100)):
            value: Any = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
                raise InvalidModel(
                    f'contact.{name}: got {value!r}; a whole number from 1 to {most} is needed'
                )
        for name in (
            'damping_ratio',
            'restitution_threshold',
            'slop',
            'push_out_speed',
            'margin',
            'sleep_speed',
            'sleep_time',
        ):
            value = getattr(self, name)
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if not is_number or not 0.0 <= value < math.inf:
                raise InvalidModel(
                    f'contact.{name}: got {value!r}; a finite number, not negative, is needed'
                )
        if not isinstance(self.sleeping, bool):
            raise InvalidModel(f'contact.sleeping: got {self.sleeping!r}; true or false is needed')

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> ContactSettings:
        """Read `contact` of a scene; InvalidModel for an unknown key or an impossible value."""
        allowed = [field.name for field in fields(cls)]
        for key in given:
            if key not in allowed:
                raise InvalidModel(f'contact has no key {key!r}; allowed: {", ".join(allowed)}')
        return cls(**given)
