# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Verbs as a user calls them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
SCENES = ROOT / 'config' / 'scenes'
COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.05,box,wrench,world,1,0,0,0,0,0
0.10,box,torque,body,0,0,0,0.01,0,0
0.15,ball,impulse,world,0.3,0,0,0,0,0
0.203,box,wrench,world,0,0,0,0,0,0
"""


@pytest.fixture
def as_json(verb):
    """Call a verb with --json; give exit code and the object."""

    def call(*words):
        code, out, _ = verb(*words, '--json')
        return code, json.loads(out)

    return call


@pytest.fixture
def process():
    """Call a verb in a process of its own, with more environment."""

    def call(*words, **environment):
        return subprocess.run(
            [sys.executable, '-m', 'rigid_body_sim', *map(str, words)],
            env=os.environ | {'PYTHONPATH': str(ROOT)} | environment,
            capture_output=True,
            text=True,
            timeout=HANGING,
            check=False,
        )

    return call


@pytest.fixture
def commands(tmp_path):
    """A file of timed commands for the scene two_bodies."""
    path = tmp_path / 'commands.csv'
    path.write_text(COMMANDS)
    return path


@pytest.fixture
def bag(tmp_path, verb, commands):
    """A bag of two_bodies with commands, half a second."""
    path = tmp_path / 'run'
    code, _, err = verb(
        'simulate',
        SCENES / 'two_bodies.yaml',
        '-o',
        path,
        '--duration',
        0.5,
        '--commands',
        commands,
    )
    assert code == 0, err
    return path
