# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The node, recording included, needs of Python numpy, numba and what rclpy needs (PyYAML) alone.
"""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rigid_body_sim.__main__ import main

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
NEEDED = {'numpy', 'numba', 'PyYAML', 'setuptools'}
UNDERNEATH = {'lz4', 'zstandard', 'mcap_ros2', 'networkx', 'PIL', 'pandas', 'xarray', 'pyarrow'}
RUN = """
import sys
for name in sys.argv[1].split(','):
    sys.modules[name] = None  # as if it were not installed
from rigid_body_sim.__main__ import main
sys.exit(main(sys.argv[2:]))
"""


def others():
    """What setup.py lists beside them: required, or for some purpose."""
    tree = ast.parse((ROOT / 'setup.py').read_text(encoding='utf-8'))
    call = next(
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == 'setup'
    )
    given = {word.arg: word.value for word in call.keywords}
    listed = set(ast.literal_eval(given['install_requires']))
    for names in ast.literal_eval(given['extras_require']).values():
        listed |= set(names)
    assert listed > NEEDED
    return sorted({name.replace('-', '_') for name in listed - NEEDED} | UNDERNEATH)


def run(*words, cwd):
    return subprocess.run(
        [sys.executable, '-c', RUN, ','.join(others()), *words],
        cwd=cwd,
        env={**os.environ, 'PYTHONPATH': str(ROOT)},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )


def test_the_node_runs_and_records_without_the_other_packages(tmp_path):
    pytest.importorskip('rclpy')
    words = 'scene:=two_bodies stop_time:=0.2 real_time_factor:=0.0 record:=true record_path:=bag'
    given = [part for word in words.split() for part in ('-p', word)]
    done = run('sim_node', '--ros-args', *given, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert main(['replay', str(tmp_path / 'bag')]) == 0

    reading = run('replay', 'bag', cwd=tmp_path)
    assert reading.returncode == 2
    assert 'pip install' in reading.stderr
    assert 'Traceback' not in reading.stderr


def test_where_ros_is_missing_the_node_says_how_to_come_by_it(tmp_path):
    hidden = 'rclpy,rcl_interfaces,geometry_msgs,std_srvs'
    done = subprocess.run(
        [sys.executable, '-c', RUN, hidden, 'sim_node'],
        cwd=tmp_path,
        env={**os.environ, 'PYTHONPATH': str(ROOT)},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert 'source a ROS 2 Jazzy installation' in line
    assert 'requirements/ros.txt' in line
