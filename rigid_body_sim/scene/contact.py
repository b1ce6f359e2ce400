# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read `contact`: whether bodies meet, and how.

    contact: {mode: none}                      bodies pass through each other; nothing is computed
    contact: {mode: timestep, substeps: 8}     contact by time stepping, with its settings
    contact: {mode: event}                     impacts at their instants; what rests, slides and
                                               rolls as by time stepping, with the same settings
    contact: {mode: timestep, ignore: [[door, frame]],
              pairs: [{bodies: [tyre, ice], friction: 0.05}]}

No two bodies of an entry of `ignore` meet; an entry of `pairs` replaces what the materials of the
two give. The name of a body with `repeat` stands for all its copies; `[ball, ball]` are its copies
among themselves.

The settings are the fields of a dataclass, which is imported only when it is asked for:
`physics.contact.settings.ContactSettings`. `Scene.contact` holds what the scene gives.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any

from rigid_body_sim.physics.model.material import MATERIAL
from rigid_body_sim.scene.material import read_material
from rigid_body_sim.scene.values import Value

MODES = ('none', 'timestep', 'event')
NO_COPIES: Mapping[str, Collection[str]] = MappingProxyType({})


def read_contact(
    value: Value | None, copies: Mapping[str, Collection[str]] = NO_COPIES
) -> dict[str, Any]:
    """
    Return the mode and the settings that are given.

    copies : names of the copies of a body that is repeated, by the name that is written
    """
    if value is None:
        return {'mode': 'none'}
    value.need_mapping(f'a mapping such as {{mode: timestep}}, with one of {", ".join(MODES)},')
    mode_value = value.at('mode', what=f'one of {", ".join(MODES)}')
    mode = mode_value.choice(MODES, what='contact mode')
    if mode == 'none':
        value.need_known(('mode',))
        return {'mode': mode}
    from rigid_body_sim.physics.contact.settings import ContactSettings

    fields = {f.name: f for f in dataclasses.fields(ContactSettings) if f.name != 'mode'}
    value.need_known(('mode', *fields))
    readers = {'ignore': _ignored, 'pairs': _pairs}
    settings = {}
    for name, field in fields.items():
        given = value.find(name)
        if given is not None:
            settings[name] = (
                readers[name](given, copies) if name in readers else _setting(given, field)
            )
    with value.blamed():
        ContactSettings(mode=mode, **settings)
    return {'mode': mode, **settings}


def _setting(value: Value, field: dataclasses.Field[Any]) -> Any:
    """Read one setting as what its field is: a truth, a whole number, or a number."""
    if field.type in ('bool', bool):
        return value.truth()
    known = field.metadata
    if field.type in ('int', int):
        return value.whole(minimum=known['minimum'], maximum=known['maximum'])
    return value.number(unit=known['unit'], minimum=known['minimum'])


def _ignored(value: Value, copies: Mapping[str, Collection[str]]) -> tuple[Any, ...]:
    """Read the pairs that do not meet."""
    return tuple(_members(entry, copies) for entry in value.items('a list of lists of bodies'))


def _pairs(value: Value, copies: Mapping[str, Collection[str]]) -> tuple[dict[str, Any], ...]:
    """Read the pairs with a material of their own."""
    pairs = []
    for entry in value.items('a list of mappings'):
        entry.need_mapping('a mapping such as {bodies: [a, b], friction: 0.1}')
        entry.need_known(('bodies', *MATERIAL))
        pair: dict[str, Any] = {'bodies': _members(entry.at('bodies', what='two bodies'), copies)}
        pairs.append(pair | read_material(entry))
    return tuple(pairs)


def _members(value: Value, copies: Mapping[str, Collection[str]]) -> tuple[Any, ...]:
    """Read bodies; a name that is repeated stands for its copies."""
    names = [item.text('the name of a body') for item in value.items('a list of bodies')]
    return tuple(tuple(copies[name]) if name in copies else name for name in names)
