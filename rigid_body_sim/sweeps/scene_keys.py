# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Places in a scene, as people write them: `satellite.initial.velocity[2]`, `gravity[2]`,
`forces[0].stiffness`, `contact.mode`.

A path begins with a key of the scene or with the name of a body; where both are the same word, it
is the key. What is put at a place takes the place of what cannot stand beside it: an
`angular_velocity` goes when `angular_velocity_body` comes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import choose_from, path_text
from rigid_body_sim.scene.document import Path
from rigid_body_sim.scene.grammar import INITIAL, SCENE, SPINS, ZERO

_STEP = re.compile(r'\.?([A-Za-z_][A-Za-z0-9_]*)|\[(\d{1,9})\]')
NOT_VARIED = ('version', 'name')
ALTERNATIVES = {  # what stands at a place in place of another
    **dict(zip(SPINS, reversed(SPINS), strict=True)),
    'mass': 'density',
    'density': 'mass',
}
ABSENT = {  # what a list of numbers holds where a scene does not give it
    'gravity': SCENE.keys['gravity'].default,
    **{key: INITIAL.keys[key].default or ZERO for key in INITIAL.keys},
    'center_of_mass': ZERO,
}
ABSENT_KEYS = {'contact': SCENE.keys['contact'].default}  # what a mapping holds that is not there
NAMED = 'integrator'  # `integrator: rk45` is short for `integrator: {name: rk45}`

__all__ = ['parse', 'path_text', 'replaced', 'value_at']


def parse(text: str, scene: Mapping[str, Any]) -> Path:
    """
    Find the place that a text names in a scene; UserError, with the nearest word, if there is
    none.
    """
    steps, place = [], 0
    while place < len(text):
        step = _STEP.match(text, place)
        if step is None or (place == 0 and (step[1] is None or step[0].startswith('.'))):
            raise UserError(
                f'vary {text!r}: not a path in a scene; write one as in satellite.mass, '
                'bodies[0].initial.velocity[2] or gravity[2]'
            )
        steps.append(step[1] if step[1] is not None else int(step[2]))
        place = step.end()
    if not steps:
        raise UserError('vary: a key is empty; write one as in satellite.mass')
    path = _from_root(steps, scene, text)
    _check_steps(path, scene, text)
    return path


def _from_root(steps: list[Any], scene: Mapping[str, Any], text: str) -> Path:
    first = str(steps[0])
    if first in NOT_VARIED:
        raise UserError(
            f'vary {text}: {first} says nothing of how a scene moves; vary another key'
        )
    if first in SCENE.keys:
        return tuple(steps)
    names = [str(body.get('name')) for body in scene['bodies']]
    if first in names:
        return ('bodies', names.index(first), *steps[1:])
    stem = first.rpartition('_')[0]
    if stem in names and scene['bodies'][names.index(stem)].get('repeat'):
        raise UserError(
            f'vary {text}: {first} is one of the copies of {stem}, which differ in nothing but '
            f'their place; vary {stem}{text[len(first) :]}, or write the bodies one by one'
        )
    raise UserError(
        f'vary {text}: {first!r} is neither a key of the scene nor one of its bodies'
        f'{choose_from(first, [*(k for k in SCENE.keys if k not in NOT_VARIED), *names])}'
    )


def _check_steps(path: Path, scene: Mapping[str, Any], text: str) -> None:
    """Refuse what cannot be reached; a key that is not there yet is for the reader to judge."""
    if len(path) == 1 and path[0] in ('bodies', 'forces'):
        raise UserError(f'vary {text}: one value of a {path[0][:-1]} is varied, not all of them; '
                        f'write {text}[0].…')  # fmt: skip
    if path[0] == 'bodies' and path[-1] == 'name':
        raise UserError(f'vary {text}: bodies are told apart by their names; vary another key')
    content: Any = scene
    for depth, step in enumerate(path):
        if content is None:
            content = _absent(path[:depth])
        if isinstance(step, int):
            if not isinstance(content, list):
                raise UserError(
                    f'vary {text}: {path_text(path[:depth])} holds no list to take [{step}] of'
                )
            if step >= len(content):
                raise UserError(
                    f'vary {text}: {path_text(path[:depth])} has {len(content)} entries, numbered '
                    f'from 0; there is no [{step}]'
                )
            content = content[step]
        elif isinstance(content, dict):
            content = content.get(step)
        elif content is None:
            continue
        elif path[:depth] == (NAMED,):
            content = None
        else:
            raise UserError(
                f'vary {text}: {path_text(path[:depth])} holds no keys, so none called {step!r}'
            )


def _absent(path: Path) -> Any:
    """Give what stands at a place that the scene leaves out."""
    return ABSENT.get(str(path[-1])) if path and path[-1] != NAMED else None


def value_at(scene: Any, path: Path) -> Any:
    """Give the value at a place, or what it is by default; None where neither is known."""
    content = scene
    for depth, step in enumerate(path):
        if content is None:
            content = _absent(path[:depth])
        if isinstance(step, int):
            content = content[step] if isinstance(content, list) else None
        else:
            content = content.get(step) if isinstance(content, dict) else None
    return _absent(path) if content is None else content


def replaced(content: Any, path: Path, value: Any, *, above: Path = ()) -> Any:
    """Give the content of a scene with another value at a place; what was given stays."""
    if not path:
        return value
    step, rest = path[0], path[1:]
    if isinstance(step, int):
        items = list(content if content is not None else ABSENT[str(above[-1])])
        items[step] = replaced(items[step], rest, value, above=(*above, step))
        return items
    if above == (NAMED,) and isinstance(content, str):
        content = {'name': content}
    keys = dict(content or ABSENT_KEYS.get(str(above[-1]) if above else '', {}))
    keys[step] = replaced(keys.get(step), rest, value, above=(*above, step))
    keys.pop(ALTERNATIVES.get(step, ''), None)
    return keys
