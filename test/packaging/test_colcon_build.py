# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`colcon build` makes a package that `ros2 run` can start.

Every verb is an executable, every scene and parameter file stands below share.
"""

import ast
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from ..patience import HANGING

NAME = 'rigid_body_sim'
ROOT = Path(__file__).parents[2]
PARTS = (
    *(NAME, 'config', 'launch', 'resource'),
    *('package.xml', 'setup.py', 'setup.cfg', 'pyproject.toml'),
)
VERBS = sorted(
    path.stem for path in (ROOT / NAME / 'verbs').glob('*.py') if path.stem != '__init__'
)
NEED_ROS = {'sim_node', 'wrench_pub'}


def run(
    *command: str | Path, environment: dict[str, str], cwd: Path
) -> subprocess.CompletedProcess:
    """
    Run to the end, output kept.
    """
    return subprocess.run(
        [str(part) for part in command],
        env=environment,
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )


def copy_parts(source: Path) -> None:
    """
    Copy what the package is built from into a new folder.
    """
    source.mkdir(parents=True)
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(
                ROOT / part, source / part, ignore=shutil.ignore_patterns('__pycache__')
            )
        else:
            shutil.copy(ROOT / part, source / part)


@pytest.fixture(scope='module')
def environment():
    """
    The environment without the way to this tree, so that only what was installed can be imported.
    """
    foreign = [
        entry
        for entry in os.environ.get('PYTHONPATH', '').split(os.pathsep)
        if entry and Path(entry).resolve() != ROOT
    ]
    return {**os.environ, 'PYTHONPATH': os.pathsep.join(foreign)}


@pytest.fixture(scope='module')
def workspace(tmp_path_factory, environment):
    """
    A temporary colcon workspace in which a copy of the package was built.
    """
    pytest.importorskip('colcon_core')
    workspace = tmp_path_factory.mktemp('workspace')
    copy_parts(workspace / 'src' / NAME)
    built = run(sys.executable, '-m', 'colcon', 'build', environment=environment, cwd=workspace)
    assert built.returncode == 0, built.stdout + built.stderr
    return workspace


@pytest.fixture(scope='module')
def installed(workspace):
    """
    Where the package was installed.
    """
    return workspace / 'install' / NAME


def test_the_verbs_of_setup_are_the_modules_of_the_verbs_room():
    tree = ast.parse((ROOT / 'setup.py').read_text(encoding='utf-8'))
    listed = next(
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == 'VERBS'
    )
    assert sorted(listed) == VERBS


ASK_FOR_HELP = """
import runpy, sys
for program in sys.argv[1:]:
    sys.argv = [program, '--help']
    try:
        runpy.run_path(program, run_name='__main__')
    except SystemExit as end:
        print('ended with', end.code, 'after', program)
"""


@pytest.mark.long  # in the short form, of what pip installs by the same setup.py: test_pip_install
def test_each_verb_is_an_executable_that_starts(workspace, installed, environment):
    """
    As the system starts it: one of them. Of the others what it reads there, the mark of an
    executable and the first line, is the same, and Python runs them one after the other.
    """
    modules = next(installed.glob('lib/python*/site-packages'))
    path = os.pathsep.join([str(modules), environment['PYTHONPATH']])
    environment = {**environment, 'PYTHONPATH': path}
    has_ros = find_spec('rclpy') is not None
    programs = {verb: installed / 'lib' / NAME / verb for verb in VERBS}
    assert all(os.access(program, os.X_OK) for program in programs.values())
    assert len({program.read_text().partition('\n')[0] for program in programs.values()}) == 1
    started = run(programs['bag'], '--help', environment=environment, cwd=workspace)
    assert started.returncode == 0, started.stderr
    assert 'bag' in started.stdout
    runnable = [verb for verb in VERBS if has_ros or verb not in NEED_ROS]
    asked = (programs[verb] for verb in runnable)
    every = run(sys.executable, '-c', ASK_FOR_HELP, *asked, environment=environment, cwd=workspace)
    *said, rest = every.stdout.split('ended with ')
    assert every.returncode == 0 and len(said) == len(runnable), every.stderr
    for verb, text, end in zip(runnable, said, [*said[1:], rest]):
        assert f'usage: {NAME} {verb}' in text or f'{verb} ' in text, text
        assert end.startswith(f'0 after {programs[verb]}'), end


@pytest.mark.long
def test_every_config_file_is_installed_below_share(installed):
    assert_has_every_config_file(installed)


def assert_has_every_config_file(installed):
    """
    Whether share holds all that `config` does, and what ROS finds a package by.
    """
    kept = {path.relative_to(ROOT) for path in (ROOT / 'config').rglob('*') if path.is_file()}
    share = installed / 'share' / NAME
    assert {
        path.relative_to(share) for path in (share / 'config').rglob('*') if path.is_file()
    } == kept
    assert (share / 'package.xml').is_file()
    assert (installed / 'share/ament_index/resource_index/packages' / NAME).is_file()
