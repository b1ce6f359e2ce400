# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The text of the package keeps its conventions.

ament's linters judge where a ROS installation brings them.
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


def test_copyright_is_declared():
    main = pytest.importorskip('ament_copyright.main').main
    assert main(argv=[str(ROOT / name) for name in SOURCES]) == 0


def test_flake8_conventions():
    main = pytest.importorskip('ament_flake8.main').main_with_errors
    paths = [str(ROOT / name) for name in SOURCES]
    code, errors = main(argv=['--linelength', '99', *paths])
    assert code == 0, '\n'.join(errors)


def test_pep257_conventions():
    main = pytest.importorskip('ament_pep257.main').main
    assert main(argv=[str(ROOT / name) for name in SOURCES]) == 0


def test_package_xml_follows_its_schema():
    main = pytest.importorskip('ament_xmllint.main').main
    assert main(argv=[str(ROOT / 'package.xml')]) == 0
