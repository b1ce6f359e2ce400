# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sweeps of small scenes, and verbs in processes of their own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def scene(*, integrator='dmv6', dt=0.01, bodies=None, **more):
    """A rigid body that tumbles and a point mass, as a mapping."""
    tumbler = {
        'name': 'tumbler',
        'mass': 2.0,
        'inertia': {'ixx': 0.3, 'iyy': 0.2, 'izz': 0.15, 'ixy': 0.02},
        'initial': {'angular_velocity_body': [0.1, 2.0, 0.3], 'velocity': [0.0, 1.0, 0.0]},
    }
    ball = {
        'name': 'ball',
        'shape': {'type': 'particle'},
        'mass': 0.5,
        'initial': {'position': [1.0, 0.0, 0.0]},
    }
    return {
        'version': 1,
        'name': 'pair',
        'dt': dt,
        'integrator': integrator,
        'bodies': bodies or [tumbler, ball],
        **more,
    }


@pytest.fixture
def started():
    """Start a sweep in a process of its own."""
    processes = []

    def start(*words, **more):
        process = subprocess.Popen(
            [sys.executable, '-m', 'rigid_body_sim', 'sweep', *map(str, words)],
            env=os.environ | {'PYTHONPATH': str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            **more,
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()
