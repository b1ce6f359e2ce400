# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The records of `docs/glossary.md`, from the code: which field stands where, in which unit.

    python tools/glossary.py           writes them into the page, below its last heading
    python tools/glossary.py --check   exit code 1 where the page is not what the code says
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / 'docs' / 'glossary.md'
PHYSICS = ROOT / 'rigid_body_sim' / 'physics'
HEADING = '## Records\n'
SHOWN = ('contact', 'state', 'model/material')  # rooms, and a module


def records() -> Iterator[str]:
    """Give the lines of the tables, a record each."""
    from rigid_body_sim.physics.arrays import Record, fields_of

    for path in sorted(PHYSICS.rglob('*.py')):
        place = path.relative_to(PHYSICS).with_suffix('').as_posix()
        if not place.startswith(SHOWN) or '/geometry' in place or '/pairs' in place:
            continue
        module = import_module(f'rigid_body_sim.physics.{place.replace("/", ".")}')
        own = {name: value for name, value in vars(module).items() if isinstance(value, Record)}
        for name, record in own.items():
            if f'\n{name} = Record(' not in path.read_text(encoding='utf-8'):
                continue  # of another module
            lanes = '' if record.stride == 1 else f', rows of {record.stride} lanes'
            yield f'\n### `{place}.{name}`{lanes}\n\n'
            yield '| field | numbers | unit | says |\n|---|---|---|---|\n'
            for field, what in fields_of(module, record).items():
                if field and not field.startswith('_'):
                    meaning = what.meaning.replace('|', '\\|')
                    yield f'| `{field}` | {what.count} | {what.unit} | {meaning} |\n'


def page() -> str:
    """Give the page as it should be."""
    text = PAGE.read_text(encoding='utf-8')
    head = text[: text.index(HEADING) + len(HEADING)]
    return head + ''.join(records())


if __name__ == '__main__':
    sys.path.insert(0, str(ROOT))
    wanted = page()
    if '--check' in sys.argv:
        sys.exit(wanted != PAGE.read_text(encoding='utf-8'))
    PAGE.write_text(wanted, encoding='utf-8')
