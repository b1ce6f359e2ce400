# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The complete example of each page of docs/how-to is built and judged from that very page."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / 'docs' / 'how-to').glob('*.md'))
BLOCK = re.compile(r'^```(\w*)\n(.*?)^```$', flags=re.DOTALL | re.MULTILINE)
FILE = re.compile(r'`((?:rigid_body_sim|config)/\S+\.(?:py|yaml))`:\s*\Z')


def changed(text, diff):
    """
    Change a text as a page says: parts between lines `@@`, each found in it once.
    """
    for part in diff.split('@@\n'):
        lines = part.splitlines(keepends=True)
        old = ''.join(line[1:] for line in lines if line[0] in ' -')
        assert text.count(old) == 1, f'found {text.count(old)} times:\n{old}'
        text = text.replace(old, ''.join(line[1:] for line in lines if line[0] in ' +'))
    return text


def build(page, folder):
    """
    Copy package and configuration, add what the page writes, and give its checks.

    A block whose paragraph ends with a path and a colon is that file, or what changes in it; YAML
    is the scene; any other block of Python is a check.
    """
    for room in ('rigid_body_sim', 'config'):  # with what Python has compiled of it
        shutil.copytree(ROOT / room, folder / room)
    text = page.read_text(encoding='utf-8')
    checks = []
    for block in BLOCK.finditer(text):
        language, source = block.groups()
        named = FILE.search(text, 0, block.start())
        if named:
            path = folder / named.group(1)
            if language == 'diff':
                source = changed(path.read_text(encoding='utf-8'), source)
            path.write_text(source, encoding='utf-8')
        elif language == 'yaml':
            (folder / 'scene.yaml').write_text(source, encoding='utf-8')
        elif language == 'python':
            checks.append(source)
    return checks


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.stem)
def test_the_example_of_the_page_works_as_the_page_says(page, tmp_path):
    checks = build(page, tmp_path)
    assert checks, f'{page} has an example that nothing judges'
    for check in checks:
        result = subprocess.run(
            [sys.executable, '-c', check],
            cwd=tmp_path,
            env=os.environ | {'PYTHONPATH': str(tmp_path), 'RIGID_BODY_SIM_COMPILE': '0'},
            capture_output=True,
            text=True,
            timeout=HANGING,
            check=False,
        )
        assert result.returncode == 0, result.stdout + result.stderr


def test_there_is_a_page_for_each_family():
    families = ['force', 'friction', 'integrator', 'pair', 'problem', 'topic']
    assert [page.stem for page in PAGES] == families


def test_the_pair_of_the_page_is_the_one_that_ships():
    page = (ROOT / 'docs' / 'how-to' / 'pair.md').read_text(encoding='utf-8')
    (block,) = (found for found in BLOCK.finditer(page) if FILE.search(page, 0, found.start()))
    path = FILE.search(page, 0, block.start()).group(1)
    assert (ROOT / path).read_text(encoding='utf-8') == block.group(2)
