# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene of point masses pays nothing for rotation: no arrays, no kernels, no other bits."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.kernels import plain
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation

from .. import inside
from ..patience import HANGING
from . import scenes

ROOT = str(Path(__file__).parents[2])

# implicit schemes and references turn in the same lines that move
WITHOUT = sorted(
    name for name, method in INTEGRATORS.items() if hasattr(method.scheme, 'for_points')
)
TURNING = (
    'free_rotation.', 'state_space.quaternions', 'state_space.matrices', 'lie_group.',
    'steps.kick_rotation',
)  # fmt: skip

PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
from rigid_body_sim import Simulation
from rigid_body_sim.physics.compile import kernels
import scenes
ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}
sim = Simulation(scenes.scene([ball]), integrator='dmv6')
sim.prepare()
sim.step(2)
for path in kernels.CACHE.rglob('*.kernel'):
    print(path.name)
"""


@pytest.mark.parametrize('name', sorted(INTEGRATORS))
def test_point_masses_have_no_rotation_arrays(name):
    method = INTEGRATORS[name]
    scene = scenes.linked_points()
    if method.refuses(scene) is not None:
        pytest.skip('refuses damping')
    sim = Simulation(scene, integrator=name)
    assert inside.stepper(sim).rotation.size == 0
    assert inside.rows_of_method(sim).size == 0


def test_the_kernels_of_every_explicit_scheme_can_leave_rotation_out():
    implicit = {'implicit_euler', 'implicit_midpoint', 'sdirk2', 'linear_propagator'}
    references = {name for name, method in INTEGRATORS.items() if method.is_reference}
    assert set(INTEGRATORS) - set(WITHOUT) == implicit | references


@pytest.mark.parametrize('name', WITHOUT)
def test_kernels_of_point_masses_hold_nothing_that_turns(name):
    """The functions that a kernel is made of, found through the names bound into it."""
    scene = scenes.oscillator(dt=0.01)
    sim = Simulation(scene, integrator=name)
    seen: dict[int, str] = {}

    def visit(function):
        source = plain(function)
        if id(source) in seen or not hasattr(source, '__code__'):
            return
        seen[id(source)] = f'{source.__module__}.{source.__qualname__}'
        for used in source.__code__.co_names:
            value = source.__globals__.get(used)
            if callable(value) and str(getattr(value, '__module__', '')).startswith(
                'rigid_body_sim.physics'
            ):
                visit(value)

    for kernel in inside.kernels_of(sim):
        visit(kernel)
    turning = [made for made in seen.values() if any(word in made for word in TURNING)]
    assert turning == []
    assert any(no_rotation.__name__ in made for made in seen.values())


def test_a_ball_moves_by_the_same_bits_beside_a_rigid_body_and_without():
    ball = [{'name': 'a', 'shape': {'type': 'particle'}, 'mass': 1.0,
             'initial': {'position': [1.0, 0.0, 0.2], 'velocity': [0.1, 0.2, 0.3]}}]  # fmt: skip
    spring = {'type': 'spring', 'a': 'a', 'b': 'world', 'stiffness': 9.0, 'damping': 0.2}
    box = {'name': 'box', 'shape': {'type': 'box', 'size': [1, 2, 3]}, 'mass': 1.0}
    runs = [
        Simulation(scenes.scene([*more, *ball], forces=[spring]), integrator='rk4')
        for more in ([], [box])
    ]
    for run in runs:
        run.step(200)
    assert runs[0].state.position[-1].tobytes() == runs[1].state.position[-1].tobytes()
    assert np.array_equal(runs[0].state.momentum[-1], runs[1].state.momentum[-1])


@pytest.mark.skipif(not kernels.COMPILED, reason='numba is not installed: nothing is compiled')
def test_nothing_that_turns_is_compiled_for_point_masses(tmp_path):
    environment = os.environ | {'RIGID_BODY_SIM_CACHE': str(tmp_path), 'PYTHONPATH': ROOT}
    result = subprocess.run(
        [sys.executable, '-c', PROGRAM, str(Path(__file__).parent)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=HANGING,
    )
    names = result.stdout.splitlines()
    assert any(name.startswith('splitting._advance_free__points') for name in names)
    assert [name for name in names if 'moser' in name or 'kick_rotation' in name] == []
