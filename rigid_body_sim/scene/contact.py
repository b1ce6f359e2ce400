# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read `contact`: whether bodies meet, and how.

    contact: {mode: none}                      bodies pass through each other; nothing is computed
    contact: {mode: timestep, substeps: 8}     contact by time stepping, with its settings

The settings of a mode are the fields of its dataclass, which is imported only when it is asked
for: `physics.contact.settings.ContactSettings`. `Scene.contact` holds what the scene gives.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from rigid_body_sim.scene.values import Value

MODES = ('none', 'timestep')
LATER_MODES = ('event',)


def read_contact(value: Value | None) -> dict[str, Any]:
    """Return the mode and the settings that are given."""
    if value is None:
        return {'mode': 'none'}
    value.need_mapping(f'a mapping such as {{mode: timestep}}, with one of {", ".join(MODES)},')
    mode_value = value.at('mode', what=f'one of {", ".join(MODES)}')
    if isinstance(mode_value.content, str) and mode_value.content in LATER_MODES:
        raise mode_value.error(
            f'contact {mode_value.content!r} comes in a later version; '
            f'this one supports: {", ".join(MODES)}'
        )
    mode = mode_value.choice(MODES, what='contact mode')
    if mode == 'none':
        value.need_known(('mode',))
        return {'mode': mode}
    from rigid_body_sim.physics.contact.settings import ContactSettings

    fields = {f.name: f for f in dataclasses.fields(ContactSettings) if f.name != 'mode'}
    value.need_known(('mode', *fields))
    settings = {}
    for name, field in fields.items():
        given = value.find(name)
        if given is not None:
            settings[name] = _setting(given, field)
    with value.blamed():
        ContactSettings(**settings)
    return {'mode': mode, **settings}


def _setting(value: Value, field: dataclasses.Field[Any]) -> Any:
    """Read one setting as what its field is: a truth, a whole number, or a number."""
    if field.type in ('bool', bool):
        return value.truth()
    known = field.metadata
    if field.type in ('int', int):
        return value.whole(minimum=known['minimum'], maximum=known['maximum'])
    return value.number(unit=known['unit'], minimum=known['minimum'])
