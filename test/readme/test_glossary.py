# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The glossary says what the code says."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PHYSICS = ROOT / 'rigid_body_sim' / 'physics'
TEXT = (ROOT / 'docs' / 'glossary.md').read_text(encoding='utf-8')
ROW = re.compile(r'^\| (.+?) \|.*\| `([\w/]+\.py)` \|$', flags=re.MULTILINE)
SMALL = {'a', 'an', 'and', 'at', 'by', 'each', 'for', 'in', 'not', 'of', 'on', 'or', 'that', 'the'}


def test_each_word_stands_in_the_file_that_the_glossary_names():
    rows = ROW.findall(TEXT)
    assert len(rows) > 40
    missing = []
    for words, file in rows:
        source = (PHYSICS / file).read_text(encoding='utf-8').lower()
        first = re.split(r'[;:,(]', words)[0].lower()
        content = [word for word in re.findall(r'[\w-]+', first) if word not in SMALL]
        missing += [
            f'{file}: {word}' for word in content if word not in source and word[:-1] not in source
        ]
    assert not missing


def test_the_records_of_the_page_are_those_of_the_code():
    result = subprocess.run(
        [sys.executable, str(ROOT / 'tools' / 'glossary.py'), '--check'],
        cwd=ROOT,
        env=os.environ | {'RIGID_BODY_SIM_COMPILE': '0'},
        timeout=300,
        check=False,
    )
    assert result.returncode == 0, 'run `python tools/glossary.py`'


def test_every_file_that_the_contact_page_names_is_there():
    page = (ROOT / 'docs' / 'contact.md').read_text(encoding='utf-8')
    named = set(re.findall(r'`(?:(?:collision|solver|energy|islands)/)?([a-z_]+)`', page))
    modules = {path.stem for path in PHYSICS.rglob('*.py')}
    assert named - modules <= {'sleeping', 'true'}


def test_the_contact_page_names_all_who_read_the_coefficient_of_friction():
    page = (ROOT / 'docs' / 'contact.md').read_text(encoding='utf-8')
    rows = [line for line in page.splitlines() if line.startswith('| `')]
    named = {name for row in rows for name in re.findall(r'`([a-z]+/[a-z_]+)`', row)}
    contact = PHYSICS / 'contact'
    reads = re.compile(r'\b(constraint|record)\.FRICTION\b|\bmaterial_of\(')
    found = {
        path.relative_to(contact).with_suffix('').as_posix()
        for path in contact.rglob('*.py')
        if reads.search(path.read_text(encoding='utf-8'))
    }
    assert len(found) > 10
    assert found <= named
    assert all((contact / f'{name}.py').is_file() for name in named)
