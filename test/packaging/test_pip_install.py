# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`pip install` puts one command on the path; the verbs are where `ros2 run` looks, and work.
"""

import importlib.util
import os
import subprocess
import sys

import pytest

from ..patience import HANGING
from .test_colcon_build import NAME, VERBS, assert_has_every_config_file, copy_parts


@pytest.fixture(scope='module')
def prefix(tmp_path_factory):
    """
    Where pip installed a copy of the package, without what it requires.
    """
    for module in ('pip', 'setuptools'):  # not imported: setuptools wants to be before distutils
        if importlib.util.find_spec(module) is None:
            pytest.skip(f'no {module} here')
    folder = tmp_path_factory.mktemp('pip')
    copy_parts(folder / 'source')
    words = '-m pip install --quiet --no-deps --no-build-isolation --no-compile --no-index'
    done = subprocess.run(
        [sys.executable, *words.split(), '--prefix', folder / 'prefix', folder / 'source'],
        env={**os.environ, 'PYTHONPATH': '', 'PIP_DISABLE_PIP_VERSION_CHECK': '1'},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / 'prefix'


def say(prefix, program, *words):
    """
    Run an installed program; returns what it printed.
    """
    (modules,) = prefix.glob('lib/python*/*-packages')
    done = subprocess.run(
        [program, *words],
        cwd=prefix,
        env={**os.environ, 'PYTHONPATH': str(modules), 'AMENT_PREFIX_PATH': str(prefix)},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_one_command_is_on_the_path_and_runs(prefix):
    (command,) = (prefix / 'bin').iterdir()
    assert command.name == NAME
    overview = say(prefix, command, '--help')
    assert all(f'  {verb} ' in overview for verb in VERBS)


def test_ros2_run_finds_each_verb(prefix):
    programs = prefix / 'lib' / NAME
    assert sorted(path.name for path in programs.iterdir()) == VERBS
    assert all(os.access(path, os.X_OK) for path in programs.iterdir())
    assert_has_every_config_file(prefix)
    assert 'box' in say(prefix, programs / 'inspect', 'two_bodies')
