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
