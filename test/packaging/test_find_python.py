# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
tools/find_python.sh finds a Python that works, wherever it is kept, and takes no shim for one.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

FIND = Path(__file__).parents[2] / 'tools' / 'find_python.sh'
TOOLS = ('sed', 'tr')  # what the script itself calls


def executable(path: Path, body: str) -> Path:
    """
    Write a shell script that can be started.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'#!/bin/sh\n{body}\n')
    path.chmod(0o755)
    return path


def python(path: Path, version: str) -> Path:
    """
    A Python that has venv and ensurepip: it answers the script's question with its version.
    """
    return executable(path, f'echo {version}')


def shim(path: Path) -> Path:
    """
    What pyenv puts on PATH for a version that is not switched on.
    """
    return executable(path, 'echo "pyenv: command not found" >&2; exit 127')


@pytest.fixture
def bare(tmp_path):
    """
    A PATH that holds sed and tr and nothing else.
    """
    folder = tmp_path / 'bare'
    folder.mkdir()
    for tool in TOOLS:
        found = next(p for p in (Path('/usr/bin') / tool, Path('/bin') / tool) if p.exists())
        (folder / tool).symlink_to(found)
    return folder


def find(*path: Path, **environment: Path) -> subprocess.CompletedProcess:
    """
    Run the script with this PATH and environment and nothing besides.
    """
    return subprocess.run(
        ['/bin/sh', str(FIND)],
        env={'PATH': os.pathsep.join(map(str, path))}
        | {k: str(v) for k, v in environment.items()},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )


def test_a_failing_shim_is_passed_over_for_the_version_pyenv_keeps(tmp_path, bare):
    root = tmp_path / 'somewhere'
    shim(root / 'shims/python3.12')
    kept = python(root / 'versions/3.12.1/bin/python', '3.12')
    assert find(root / 'shims', bare).stdout.strip() == str(
        kept
    )  # no HOME, no PYENV_ROOT: the shim reveals the root


def test_a_working_python_behind_a_failing_shim_on_path_is_taken(tmp_path, bare):
    shim(tmp_path / 'shims/python3.12')
    real = python(tmp_path / 'real/python3.12', '3.12')
    assert find(tmp_path / 'shims', tmp_path / 'real', bare).stdout.strip() == str(real)


@pytest.mark.parametrize(
    ('variable', 'root', 'python_path'),
    [
        ('HOME', '', '.pyenv/versions/3.12.7/bin/python'),
        ('PYENV_ROOT', '', 'versions/3.12.7/bin/python'),
        ('HOME', '', '.local/share/uv/python/cpython-3.12.7-linux-x86_64-gnu/bin/python3.12'),
        ('XDG_DATA_HOME', '', 'uv/python/cpython-3.12.7-linux-x86_64-gnu/bin/python3.12'),
    ],
)
def test_pythons_kept_off_the_path_are_found(tmp_path, bare, variable, root, python_path):
    kept = python(tmp_path / 'kept here' / python_path, '3.12')
    assert find(bare, **{variable: tmp_path / 'kept here'}).stdout.strip() == str(kept)


def test_jazzys_version_wins_over_a_newer_and_an_older_one(tmp_path, bare):
    python(tmp_path / 'bin/python3.13', '3.13')
    python(tmp_path / 'bin/python3.11', '3.11')
    kept = python(tmp_path / '.pyenv/versions/3.12.1/bin/python', '3.12')
    assert find(tmp_path / 'bin', bare, HOME=tmp_path).stdout.strip() == str(kept)


@pytest.mark.parametrize('version', ['3.13', '3.11', '3.10'])
def test_another_supported_version_serves_where_jazzys_is_missing(tmp_path, bare, version):
    other = python(tmp_path / 'bin' / f'python{version}', version)
    assert find(tmp_path / 'bin', bare).stdout.strip() == str(other)


def test_a_real_python_without_venv_is_not_taken(tmp_path, bare):
    inside = f'exec {sys.executable} -S -c "import no_such_venv_module"'
    executable(tmp_path / 'bin/python3.12', inside)
    assert find(tmp_path / 'bin', bare).returncode == 1


def test_without_any_python_one_sentence_says_what_to_do(bare):
    result = find(bare)
    assert result.returncode == 1
    assert result.stdout == ''
    assert len(result.stderr.splitlines()) == 1
    assert 'Python 3.12' in result.stderr and 'PYENV_ROOT' in result.stderr
