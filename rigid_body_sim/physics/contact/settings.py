# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a scene may set of contact: by time stepping, or with impacts at their instants.

The contact frequency of the soft constraint is no setting: f = 0.25 / h with the substep h, twice
that against what cannot move. A lower one lets a stack sink by a length that no smaller step
mends; a higher one never comes to rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

from rigid_body_sim.physics.contact.pair_rules import check_form
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.numbers import shown

MODE = 'timestep'
EVENT = 'event'
MODES = (MODE, EVENT)


def _number(default: float, unit: str) -> Any:
    """Declare a setting that is a number, not negative."""
    return field(default=default, metadata={'unit': unit, 'minimum': 0.0})


def _count(default: int, most: int) -> Any:
    """Declare a setting that is a whole number from 1 to `most`."""
    return field(default=default, metadata={'unit': '-', 'minimum': 1, 'maximum': most})


@dataclass(frozen=True)
class ContactSettings:
    """
    The contact mode and its numbers; the fields are the keys of `contact` in a scene.

    substeps       : solver steps in a tick; the sink of a stack falls as their square, and heavy
                     bodies on light ones need more of them
    damping_ratio  : [-] of the soft contact, zeta
    relaxations    : iterations that relax: they take the push-out velocity back and apply
                     friction; 1 is a tenth quicker, and what friction only just holds creeps,
                     0.1 mm in 5 s
    restitution_threshold : [m/s] slower impacts do not bounce; larger ones cut visible bounces;
                     with `mode: event` what is in flight bounces down to 1e-5 m/s unless this is
                     given
    slop           : [m] overlap that is left alone: a constant error of height
    push_out_speed : [m/s] the fastest that overlap is undone
    margin         : [m] separation within which a contact is foreseen (speculative contact), at
                     most a tenth of the radius of the smaller body; motion over a tick is added
    sleeping       : true: islands at rest are left out until something reaches them, see
                     `islands.sleep`; false: every body is solved in every tick
    sleep_speed    : [m/s] slower bodies may fall asleep, with what is left of their momentum; a
                     larger one stops what creeps, a smaller one than the jitter of a heap lets
                     nothing sleep
    sleep_time     : [s] so long they must have been slower; a shorter one stops what is only about
                     to turn back or to fall over
    ignore, pairs  : pairs that do not meet, and pairs with a material of their own: see
                     `pair_rules`
    """

    mode: str = MODE
    substeps: int = _count(4, most=1000)
    damping_ratio: float = _number(2.0, '-')
    relaxations: int = _count(2, most=100)
    restitution_threshold: float = _number(0.01, 'm/s')
    slop: float = _number(0.0, 'm')
    push_out_speed: float = _number(3.0, 'm/s')
    margin: float = _number(0.01, 'm')
    sleeping: bool = False
    sleep_speed: float = _number(0.01, 'm/s')
    sleep_time: float = _number(0.5, 's')
    ignore: tuple[Any, ...] = ()
    pairs: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise InvalidModel(
                f'contact.mode: got {shown(self.mode)}; allowed: none, {", ".join(MODES)}'
            )
        for setting in fields(self):
            if setting.metadata:
                self._check_number(setting.name, setting.metadata)
        check_form(self.ignore, self.pairs)
        if not isinstance(self.sleeping, bool):
            raise InvalidModel(
                f'contact.sleeping: got {shown(self.sleeping)}; true or false is needed'
            )

    def _check_number(self, name: str, known: Mapping[str, Any]) -> None:
        value = getattr(self, name)
        least, most, unit = known['minimum'], known.get('maximum'), known['unit']
        if most is not None:
            is_whole = isinstance(value, int) and not isinstance(value, bool)
            if not is_whole or not least <= value <= most:
                raise InvalidModel(
                    f'contact.{name}: got {shown(value)}; a whole number from {least} '
                    f'to {most} is needed'
                )
            return
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not least <= value < math.inf:
            raise InvalidModel(
                f'contact.{name}: got {shown(value)}; a finite number [{unit}], not negative, '
                'is needed'
            )

    # [m/s] of what flies: slower approach is no impact at an instant. Larger: the last bounces of
    # a series are missing; smaller: more of them cost time
    impact_speed: ClassVar[float] = 1e-5

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> ContactSettings:
        """Read `contact` of a scene; InvalidModel for an unknown key or an impossible value."""
        allowed = [field.name for field in fields(cls)]
        for key in given:
            if key not in allowed:
                raise InvalidModel(
                    f'contact has no key {shown(key)}; allowed: {", ".join(allowed)}'
                )
        made = cls(**given)
        if 'restitution_threshold' in given:
            object.__setattr__(made, 'impact_speed', made.restitution_threshold)
        return made
