# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""How often a method asks for forces: what its scheme says is what a force element sees."""

import json
import os
import subprocess
import sys

import pytest

from rigid_body_sim import load_scene
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.report.evaluations import evaluations_per_step

METHODS = (
    'semi_implicit_euler',
    'dmv6',
    'blanes_moan4',
    'force_gradient4',
    'linearly_implicit',
    'linear_propagator',
    'rk4',
    'rk8',
)
# In a process without compilation a force element is plain Python and can count.
COUNT = """
import json, sys
from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.forces.elements import FORCES
seen = [0]
of_spring = FORCES['spring'].accumulate
def counting(*arguments):
    seen[0] += 1
    return of_spring(*arguments)
FORCES['spring'].accumulate = staticmethod(counting)
found = {}
for name, scene in json.loads(sys.argv[1]):
    simulation = Simulation(load_scene(scene), integrator=name)
    counts = []
    for ticks in (10, 30):  # of two runs the difference: the first evaluation of each falls out
        seen[0] = 0
        simulation.step(ticks)
        counts.append(seen[0])
    found[name + str(scene['forces'][0]['damping'])] = (counts[1] - counts[0]) / 20
print(json.dumps(found))
"""


def swing(damping):
    return {
        'version': 1,
        'name': 'swing',
        'dt': 0.01,
        'bodies': [{'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}],
        'forces': [
            {'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': 4.0, 'damping': damping}
        ],
    }


@pytest.fixture(scope='module')
def counted():
    wanted = [
        (name, swing(damping))
        for damping in (0.0, 0.5)
        for name in METHODS
        if not (damping and name == 'blanes_moan4')
    ]
    done = subprocess.run(
        [sys.executable, '-c', COUNT, json.dumps(wanted)],
        env=os.environ | {'RIGID_BODY_SIM_COMPILE': '0'},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.parametrize('damping', [0.0, 0.5])
@pytest.mark.parametrize('name', METHODS)
def test_evaluations_are_counted_as_the_scheme_makes_them(name, damping, counted):
    scene = load_scene(swing(damping))
    if INTEGRATORS[name].refuses(scene):
        pytest.skip('refuses damping')
    assert evaluations_per_step(INTEGRATORS[name], scene) == counted[f'{name}{damping}']
