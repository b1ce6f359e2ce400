# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kernels take indices as they are: compiled, -1 is not the last element but one before the first.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
SCENES = sorted((ROOT / 'config/scenes').glob('*.yaml'))
MANY = 20  # bodies, beyond which a scene takes too long without numba
SOME = 9  # beyond which it takes a second

# Of each kind of shape two meet each other, a plane, and a box that cannot move.
HEAP = """
version: 1
name: heap
dt: 0.01
gravity: [0, 0, -9.81]
contact: {mode: timestep, sleeping: true, substeps: 2}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}, rolling_friction: 0.001}
  - {name: step, shape: {type: box, size: [1, 1, 0.1]}, fixed: true}
"""
SHAPES = [
    '{type: sphere, radius: 0.1}',
    '{type: box, size: [0.2, 0.1, 0.15]}',
    '{type: capsule, radius: 0.05, length: 0.1}',
    '{type: cylinder, radius: 0.1, length: 0.1}',
    '{type: convex_hull, vertices: [[0.1, 0, 0], [0, 0.1, 0], [-0.1, -0.1, 0], [0, 0, 0.15]]}',
]

PROGRAM = """
import sys
from rigid_body_sim.physics.compile import kernels

class Strict:
    def __init__(self, array):
        self.view = memoryview(array)

    def __len__(self):
        return len(self.view)

    def _checked(self, index):
        ends = (index.start or 0, index.stop or 0) if isinstance(index, slice) else (index,)
        if min(ends) < 0:
            raise IndexError(f'{index} counts from the end')
        return index

    def __getitem__(self, index):
        taken = self.view[self._checked(index)]
        return Strict(taken) if isinstance(index, slice) else taken

    def __setitem__(self, index, value):
        self.view[self._checked(index)] = value.view if isinstance(value, Strict) else value

kernels.argument = Strict
from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.contact.islands import first_loads
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

assert not kernels.COMPILED
first_loads.VISITS = 100  # some passes over a stack: each reads and writes what the first does
folder, most, *texts = sys.argv[1:]
for text in texts:
    scene = load_scene(text if text.endswith('.yaml') else text.encode())
    if len(scene.bodies) <= int(most):
        Simulation(scene).step(3)  # in the third tick manifolds follow their bodies
        print('done')
if not texts:
    sys.path.insert(0, folder)
    import scenes

    for name in INTEGRATORS:
        turns = name in scenes.TURNING
        scene = scenes.linked_bodies(name) if turns else scenes.linked_points()
        Simulation(scene, integrator=name).step(3)
        print('done')
"""


def strictly(*scenes, most=MANY):
    """
    Run scenes for some ticks in the plain source, on arrays that refuse what counts from the end;
    without any, all integrators on bodies and points that are linked.
    """
    environment = os.environ | {'RIGID_BODY_SIM_COMPILE': '0', 'PYTHONPATH': str(ROOT)}
    done = subprocess.run(
        [sys.executable, '-c', PROGRAM, str(Path(__file__).parent), str(most), *scenes],
        env=environment,
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize('most', [SOME, pytest.param(MANY, marks=pytest.mark.long)])
def test_no_scene_counts_from_the_end_of_an_array(most):
    assert len(strictly(*map(str, SCENES), most=most)) > 20


def test_no_pair_of_shapes_counts_from_the_end_of_an_array():
    heaps = [heap_of_pairs(first) for first in range(len(SHAPES))]
    assert strictly(*heaps) == ['done'] * len(heaps)


def heap_of_pairs(first):
    """
    The text of a heap in which each shape from one on meets that one.
    """
    text = HEAP
    for i, second in enumerate(SHAPES[first:]):
        for k, shape in enumerate((SHAPES[first], second)):
            place = f'[{0.4 * i - 0.8}, {0.02 * k}, {0.11 + 0.13 * k}]'
            text += (
                f'  - {{name: b{i}_{k}, mass: 1, shape: {shape}, friction: 0.5, '
                f'initial: {{position: {place}, angular_velocity: [3, 1, 2]}}}}\n'
            )
    return text


def test_no_integrator_counts_from_the_end_of_an_array():
    assert len(strictly()) > 20
