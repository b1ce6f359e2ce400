# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is said to be somewhere is there: `module.name` in docstrings and comments, paths on pages.

A name that has moved or gone leaves nothing behind that would send a reader to where it was.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PHYSICS = ROOT / 'rigid_body_sim' / 'physics'
READ = (PHYSICS, ROOT / 'test')
PAGES = ('ARCHITECTURE.md', 'CONTRIBUTING.md', 'docs/contact.md', 'docs/event_contact.md')
SAID = re.compile(r'`(?:\w+[./])*([a-z]\w*)\.(\w+)(?:\(\))?`')
KEYS = {'contact', 'motion', 'state', 'energy_balance'}  # of a scene or a run: `contact.ignore`
ENDINGS = {'md', 'py', 'rst', 'txt', 'yaml', 'json'}


def words_about(path: Path) -> str:
    """Docstrings and comments of a module."""
    text = path.read_text(encoding='utf-8')
    if not SAID.search(text):  # to parse it takes longer
        return ''
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef
    found = [
        ast.get_docstring(one) or '' for one in ast.walk(ast.parse(text)) if isinstance(one, kinds)
    ]
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return '\n'.join([*found, *(one.string for one in tokens if one.type == tokenize.COMMENT)])


def bound_in(path: Path) -> Iterator[str]:
    """Names that a module binds, methods too, and what it imports."""
    for one in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        match one:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name.removeprefix('_')
            case ast.Name(id=name, ctx=ast.Store()) | ast.arg(arg=name):
                yield name
            case ast.alias(name=name, asname=other):
                yield other or name


@cache
def known() -> dict[str, set[str]]:
    """What is in each module and each folder of physics, by its last name."""
    found: dict[str, set[str]] = {}
    for path in PHYSICS.rglob('*.py'):
        own = path.parent.name if path.name == '__init__.py' else path.stem
        found.setdefault(own, set()).update(bound_in(path))
        found.setdefault(path.parent.name, set()).add(path.stem)
    for path in PHYSICS.rglob('*'):
        if path.is_dir():
            found.setdefault(path.parent.name, set()).add(path.name)
    return found


def test_what_is_named_with_its_module_is_there():
    gone = []
    for room in READ:
        for path in sorted(room.rglob('*.py')):
            for module, name in SAID.findall(words_about(path)):
                if module in KEYS or name in ENDINGS or module not in known():
                    continue
                if name.removeprefix('_') not in known()[module]:
                    gone.append(f'{path.relative_to(ROOT)}: {module}.{name}')
    assert not gone


def test_every_path_that_the_pages_of_the_house_name_is_there():
    files = [
        path.relative_to(ROOT).as_posix()
        for top in ('rigid_body_sim', 'test', 'tools', 'docs', 'benchmark', 'config', 'examples')
        for path in (ROOT / top).rglob('*')
    ]
    ends = {'/' + file.removesuffix('.py') for file in files} | {'/' + file for file in files}
    gone = []
    for page in PAGES:
        text = re.sub(r'```.*?```', '', (ROOT / page).read_text(encoding='utf-8'), flags=re.DOTALL)
        for said in re.findall(r'`([a-z_]\w*(?:/\w+)+(?:\.\w+)?)/?`', text):
            path, _, name = said.partition('.')
            wanted = said if name in ENDINGS else path
            is_message = said.partition('/')[0].endswith('_msgs')
            if not is_message and not any(end.endswith('/' + wanted) for end in ends):
                gone.append(f'{page}: {said}')
    assert not gone
