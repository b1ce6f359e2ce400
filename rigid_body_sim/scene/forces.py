# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read force elements: the keys of each type are the fields of its dataclass in `physics.forces`.

A field says what it holds by its metadata: `kind` (body, bodies, body_or_world, point, vector,
number, choice, table), `unit`, `minimum`, `positive`, `choices`. A field without a default is a
key that must be there.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from typing import Any

from rigid_body_sim.scene.values import Value

WORLD = 'world'


def read_force(value: Value, bodies: Collection[str]) -> Any:
    """Return one force element."""
    from rigid_body_sim.physics.forces.elements import FORCES

    value.need_mapping('a mapping such as {type: drag, body: ball, linear: 0.1}')
    kind = value.at('type', what=f'one of {", ".join(FORCES)}').choice(FORCES, what='force')
    element: Any = FORCES[kind]
    fields = dataclasses.fields(element)
    value.need_known(('type', *(field.name for field in fields)))
    settings = {}
    for field in fields:
        given = value.find(field.name)
        if given is not None:
            settings[field.name] = _setting(given, field.metadata, bodies)
        elif field.metadata['kind'] == 'bodies':
            settings[field.name] = tuple(bodies)  # none named: all of them
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise value.error(
                f'{field.name} is missing; {_wanted(field.metadata)} is needed by a {kind}'
            )
    with value.blamed():
        return element(**settings)


def _setting(value: Value, metadata: Any, bodies: Collection[str]) -> Any:
    kind, unit = metadata['kind'], metadata.get('unit') or '-'
    if kind == 'body':
        return value.choice(bodies, what='body')
    if kind == 'body_or_world':
        return value.choice((*bodies, WORLD), what='body')
    if kind == 'bodies':
        return tuple(item.choice(bodies, what='body') for item in value.items('a list of bodies'))
    if kind == 'table':
        return _table(value, unit=unit)
    if kind == 'choice':
        return value.choice(metadata['choices'], what='choice')
    if kind in ('point', 'vector'):
        return value.vector(unit=unit)
    return value.number(
        unit=unit, minimum=metadata.get('minimum'), positive=metadata.get('positive', False)
    )


def _table(value: Value, *, unit: str) -> tuple[tuple[float, ...], ...]:
    """Return rows of equal width; the width is that of the first row."""
    rows = value.items('a list of rows of numbers')
    width = len(rows[0].items('a row of numbers')) if rows else 0
    return tuple(row.numbers(width, unit=unit) for row in rows)


def _wanted(metadata: Any) -> str:
    unit = f' [{metadata["unit"]}]' if metadata.get('unit') else ''
    return {
        'body': 'the name of a body',
        'bodies': 'a list of bodies',
        'table': f'a list of rows{unit}',
        'body_or_world': "the name of a body, or 'world',",
        'point': f'three numbers{unit}',
        'vector': f'three numbers{unit}',
        'choice': f'one of {", ".join(metadata.get("choices", ()))}',
    }.get(metadata['kind'], f'a number{unit}')
