# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`list scenes|integrators|forces|shapes|problems`: what there is, a line each with its purpose.

The lines are those with which scenes, modules and records themselves begin.
"""

from __future__ import annotations

import argparse
import inspect
import json
import re
from collections.abc import Callable, Iterator
from importlib import import_module

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import choose_from

SUMMARY = 'what there is: scenes, integrators, forces, shapes, problems, a line each'

Lines = Iterator[tuple[str, str]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare `list KIND [--json]`."""
    parser.add_argument('kind', metavar='KIND', help=', '.join(KINDS))
    parser.add_argument('--json', action='store_true', help='print one JSON object')


def run(arguments: argparse.Namespace) -> int:
    """Print the names of one kind with their purposes; exit code 0."""
    if arguments.kind not in KINDS:
        raise UserError(f'unknown kind {arguments.kind!r}{choose_from(arguments.kind, KINDS)}')
    found = dict(KINDS[arguments.kind]())
    if arguments.json:
        print(json.dumps({arguments.kind: found}, ensure_ascii=False))
        return 0
    width = max(map(len, found))
    for name, purpose in found.items():
        print(f'{name:{width}}  {purpose}')
    return 0


def first_sentence(text: str | None) -> str:
    """Return the first sentence of a docstring, on one line, without its full stop."""
    summary = inspect.cleandoc(text or '').partition('\n\n')[0]
    line = ' '.join(summary.split())
    return re.split(r'(?<=[\w)\]])\.(?:\s|$)', line, maxsplit=1)[0]


def scenes() -> Lines:
    """Shipped scenes, by the first line of their comment."""
    from rigid_body_sim.scene.shipped_scenes import shipped_scenes

    for name, path in sorted(shipped_scenes().items()):
        with path.open(encoding='utf-8') as file:
            yield name, file.readline().lstrip('# ').strip().rstrip('.')


def integrators() -> Lines:
    """Methods, by the docstring of their file."""
    from rigid_body_sim.physics.integration import choose
    from rigid_body_sim.physics.integration import integrators as room

    for name in sorted(room.INTEGRATORS):
        yield name, first_sentence(import_module(f'{room.__name__}.{name}').__doc__)
    yield choose.NAME, first_sentence(choose.__doc__).replace('`integrator: auto`: ', '')


def forces() -> Lines:
    """Force elements, by the docstring of their file."""
    from rigid_body_sim.physics.forces.elements import FORCES

    for name, element in sorted(FORCES.items()):
        yield name, first_sentence(import_module(element.__module__).__doc__)


def shapes() -> Lines:
    """Shapes, by the grammar of scenes."""
    from rigid_body_sim.scene.grammar import SHAPES

    for name, shape in SHAPES.items():
        yield name, first_sentence(shape.about)


def problems() -> Lines:
    """Problems of the report, by the docstring of their file."""
    from rigid_body_sim.report import problems as room

    for name in sorted(room.PROBLEMS):
        yield name, first_sentence(import_module(f'{room.__name__}.{name}').__doc__)


KINDS: dict[str, Callable[[], Lines]] = {
    'scenes': scenes,
    'integrators': integrators,
    'forces': forces,
    'shapes': shapes,
    'problems': problems,
}
