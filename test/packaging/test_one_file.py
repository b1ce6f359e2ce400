# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A force element is added by writing one file, an integrator by writing one file: nothing else.

The package is copied, one file of each kind is dropped into it, and a scene uses both.
"""

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

PACKAGE = Path(__file__).parents[2] / 'rigid_body_sim'

FORCE = '''
"""The force of a magnetic field on a charge: F = q v x B [N]."""

from dataclasses import dataclass

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.forces.element import key, pushed
from rigid_body_sim.physics.state.blocks import add_force, velocity
from rigid_body_sim.physics.vectors import cross, load

columns = Record()
BODY = columns.number('-', 'core index')
FIELD = columns.vector('C T', 'q B')
SIZE = columns.size


@inline
def accumulate(elements, start, count, time, translation, rotation):
    for number in range(count):
        row = start + SIZE * number
        body = int(elements[row + BODY])
        field = load(elements, row + FIELD)
        add_force(translation, body, cross(velocity(translation, body), field))


@dataclass(frozen=True)
class Lorentz:
    body: str = key('body')
    field: tuple[float, float, float] = key('vector', unit='T')
    charge: float = key('number', unit='C', default=1.0)

    TYPE = 'lorentz'
    COLUMNS = SIZE
    accumulate = staticmethod(accumulate)

    def row(self, places):
        index = pushed(places, self.body).index
        return (float(index), *(self.charge * component for component in self.field))

    def bodies(self):
        return (self.body,)

    def depends_on_velocity(self):
        return True

    def conserves_energy(self):
        return True

    def potential_energy(self, state):
        return 0.0


ELEMENT = Lorentz
'''

INTEGRATOR = '''
"""The three stages of Ralston, order three."""

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes.runge_kutta import RungeKutta

INTEGRATOR = Integrator(
    name='ralston3',
    order=3,
    free_order=3,
    keeps='nothing',
    stability='h |omega| <= 0.1',
    source='Ralston, Math. Comp. 16 (1962)',
    scheme=RungeKutta(a=((), (0.5,), (0.0, 0.75)), b=(2 / 9, 1 / 3, 4 / 9)),
)
'''

SCENE = """
# A charge circles in a magnetic field of 2 T.
dt: 0.01
integrator: ralston3
bodies:
  - {name: charge, shape: {type: particle}, mass: 1.0, initial: {velocity: [1, 0, 0]}}
  - {name: dipole, shape: {type: box, size: [1, 2, 3]}, mass: 1.0,
     initial: {angular_velocity: [1, 2, 3]}}
forces:
  - {type: lorentz, body: charge, field: [0, 0, 2]}
"""

PROGRAM = """
import json, math, sys
from rigid_body_sim import Simulation, load_scene
errors = []
for dt in (0.02, 0.01):
    sim = Simulation(load_scene('circle.yaml'), dt=dt)
    sim.step(round(2.0 / dt))
    x, y, _ = sim.state.position[0]
    errors.append(math.hypot(x - 0.5 * math.sin(4.0), y - 0.5 * (math.cos(4.0) - 1.0)))
print(json.dumps(errors))
"""

VERBS = """
import sys
from rigid_body_sim.__main__ import main
for words in sys.argv[1:]:
    code = main(words.split())
sys.exit(code)
"""


@pytest.fixture(scope='module')
def extended(tmp_path_factory):
    """A folder with the package and two files more, and a scene."""
    folder = tmp_path_factory.mktemp('extended')
    copy = folder / 'rigid_body_sim'
    shutil.copytree(PACKAGE, copy)  # with what Python has compiled of it
    (copy / 'physics' / 'forces' / 'elements' / 'lorentz.py').write_text(FORCE)
    (copy / 'physics' / 'integration' / 'integrators' / 'ralston3.py').write_text(INTEGRATOR)
    (folder / 'circle.yaml').write_text(SCENE)
    return folder


def called(folder, *words):
    """Call Python on the extended package, as plain source: nothing of it need be compiled."""
    environment = os.environ | {'PYTHONPATH': str(folder), 'RIGID_BODY_SIM_COMPILE': '0'}
    return subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )


def test_a_force_and_an_integrator_are_each_added_by_one_file(extended):
    result = called(extended, '-c', PROGRAM)
    assert result.returncode == 0, result.stderr
    coarse, fine = json.loads(result.stdout)
    assert math.log2(coarse / fine) == pytest.approx(3.0, abs=0.1)  # of its claimed order
    assert fine < 1e-5


def test_verbs_know_what_was_added(extended):
    (extended / 'wrong.yaml').write_text(SCENE.replace('field', 'feild'))
    simulate = ('simulate', 'circle.yaml', '-o', 'run', '--duration', '1', '--json')
    verbs = simulate, ('replay', 'run', '--json'), ('simulate', 'wrong.yaml', '-o', 'none')
    result = called(extended, '-c', VERBS, *map(' '.join, verbs))
    assert result.returncode == 2, result.stderr
    report, replayed = map(json.loads, result.stdout.splitlines())
    assert report['integrator'] == 'ralston3'
    assert report['energy_drift'] < 1e-6  # truncation; the field does no work
    assert replayed['identical'] is True
    assert "forces[0].feild: unknown key; did you mean 'field'?" in result.stderr
