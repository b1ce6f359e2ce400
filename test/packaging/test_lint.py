# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The text of the package keeps its conventions, which stand in pyproject.toml.
"""

import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
SOURCES = ('rigid_body_sim', 'test', 'tools', 'benchmark', 'examples', 'setup.py')


@pytest.mark.parametrize('words', [['check'], ['format', '--check']], ids=' '.join)
def test_ruff_finds_nothing(words):
    pytest.importorskip('ruff')
    result = subprocess.run(
        [sys.executable, '-m', 'ruff', *words, '--no-cache', *SOURCES],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr


def test_what_is_committed_is_source():
    """No kernel, recording or library is tracked, nor any other file above a megabyte."""
    if not (ROOT / '.git').exists():
        pytest.skip('no checkout: the tree was unpacked')
    listed = subprocess.run(
        ['git', 'ls-files', '-z'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    if listed.returncode:
        pytest.skip(f'git cannot read this checkout: {listed.stderr.strip()}')
    made = {'.kernel', '.bc', '.o', '.so', '.nbi', '.nbc', '.pyc', '.mcap', '.whl'}
    tracked = [ROOT / name for name in listed.stdout.split('\0') if name]
    wrong = [
        str(path.relative_to(ROOT))
        for path in tracked
        if path.suffix in made or (path.is_file() and path.stat().st_size > 1_000_000)
    ]
    assert len(tracked) > 500
    assert wrong == []
