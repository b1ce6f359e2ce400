# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What steps take from a swing, |R(i h omega)|, and that a loss of energy which nothing took is told.
"""

import json
import math
import warnings

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene, simulate
from rigid_body_sim.library.simulation import Simulation as Kept
from rigid_body_sim.physics.diagnostics.energy_balance import LOOKS_AT_LEAST, unexplained_loss
from rigid_body_sim.physics.diagnostics.numerical_damping import (
    damps_no_spring,
    stability_function,
)
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

LOST = 'which no force, damper or command took'


def swing(product: float, **spring):
    """A kilogram on a spring, h omega a tick of 1/64 s."""
    dt = 2.0**-6
    return {
        'dt': dt,
        'bodies': [
            {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0,
             'initial': {'position': [1, 0, 0]}},
        ],
        'forces': [
            {'type': 'spring', 'a': 'ball', 'b': 'world', 'b_point': [0, 0, 0],
             'stiffness': (product / dt) ** 2, **spring},
        ],
    }  # fmt: skip


def eigenvalue(name: str, product: float) -> float:
    """Spectral radius of a step of x'' = -omega^2 x, from the steps of two starts."""
    columns = []
    for start in ({'position': [1, 0, 0]}, {'velocity': [1, 0, 0]}):
        scene = swing(product)
        scene['bodies'][0]['initial'] = start
        sim = Simulation(load_scene(scene), integrator=name)
        sim.step()
        columns.append([sim.state.position[0, 0], sim.state.velocity[0, 0]])
    return float(np.max(np.abs(np.linalg.eigvals(np.array(columns).T))))


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('name', sorted(n for n, i in INTEGRATORS.items() if not i.is_reference))
def test_a_step_multiplies_a_swing_by_the_stability_function(name):
    integrator = INTEGRATORS[name]
    of = stability_function(integrator)
    for product in (0.3, 1.0):
        if of is not None:
            expected = abs(of(1j * product))
            if name == 'rk4':  # 1 - z^6/72 + z^8/576 under the root
                series = 1.0 - product**6 / 72.0 + product**8 / 576.0
                assert expected == pytest.approx(math.sqrt(series), rel=1e-14)
        elif damps_no_spring(integrator):
            expected = 1.0
        else:
            continue
        # round-off; Newton's iteration of the implicit ones stops at about 1e-12
        assert eigenvalue(name, product) == pytest.approx(expected, rel=1e-10)


def told(scene, seconds: float, **options) -> list[str]:
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        run = simulate(scene, seconds, **options)
    return [text for text in run.warnings if LOST in text]


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize(
    ('name', 'product', 'loses'),
    [('rk4', 1.0, True), ('rk4', 0.1, False), ('implicit_euler', 0.1, True),
     ('linearly_implicit', 0.1, True), ('sdirk2', 1.0, True), ('dmv6', 0.3, False),
     ('implicit_midpoint', 1.0, False), ('semi_implicit_euler', 0.01, False)],
)  # fmt: skip
def test_energy_that_the_steps_take_is_told_once(name, product, loses):
    found = told(swing(product), 4.0, integrator=name)
    assert len(found) == loses
    sim = Kept(swing(product), integrator=name)
    sim.step(256)
    assert any(LOST in text for text in sim.warnings()) == loses
    if loses:
        assert f'{name} damps' in found[0] and 'take dt <=' in found[0]
        assert "'ball' may swing" in found[0]


def test_what_contacts_take_is_no_loss_of_the_method():
    falls = swing(0.1)
    falls['gravity'] = [0, 0, -9.81]
    falls['bodies'][0]['shape'] = {'type': 'sphere', 'radius': 0.1}
    falls['bodies'].append({'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}})
    falls['forces'] = []
    falls['contact'] = {'mode': 'timestep'}
    assert told(falls, 1.0) == []


@pytest.mark.usefixtures('plain_source')
def test_what_dampers_and_commands_take_is_no_loss_of_the_method(tmp_path, verb):
    assert told(swing(0.1, damping=2.0), 4.0, integrator='rk4') == []
    # and by the balance of the verb, which knows what dampers take
    for damping, name, loses in ((2.0, 'rk4', 0), (1e-3, 'implicit_euler', 1)):
        path = tmp_path / f'{name}.yaml'
        path.write_text(json.dumps(swing(0.1, damping=damping)))
        words = ('--integrator', name, '--duration', 4)
        code, _, err = verb('simulate', path, '-o', tmp_path / f'{name}_bag', *words)
        assert (code, err.count(LOST)) == (0, loses)


def test_a_swing_of_the_energy_is_no_loss_and_few_looks_tell_none():
    swinging = [math.sin(0.7 * k) for k in range(64)]
    # the highest of each is one of a dozen samples of a period: within 1 - cos(0.35)
    assert unexplained_loss(swinging) < 0.06
    assert unexplained_loss([-0.1 * k for k in range(64)]) == pytest.approx(4.8)
    assert unexplained_loss([-0.1 * k for k in range(LOOKS_AT_LEAST - 1)]) == 0.0


def test_inspect_recommends_no_method_that_damps_the_springs_of_the_scene(tmp_path, verb):
    def rows_of(path):
        facts = json.loads(verb('inspect', path, '--json')[1])
        return {row['name']: row for row in facts['integrators']}

    path = tmp_path / 'swing.yaml'
    path.write_text(json.dumps(swing(1.0)))
    rows = rows_of(path)
    assert not (rows['rk4']['recommended'] or rows['lie_rk4']['recommended'])
    assert rows['linear_propagator']['recommended'] and rows['force_gradient4']['recommended']
    # |R|^2 = 1 - 1/72 + 1/576 a step of a radian
    lost = 1.0 - (1.0 - 1.0 / 72.0 + 1.0 / 576.0) ** (2.0 * math.pi)
    assert rows['rk4']['damping']['per_period'] == pytest.approx(lost, rel=1e-12)
    assert rows['dmv6']['damping'] is None
    assert 'within its limits, but rk4 damps: ' in verb('inspect', path)[1]
    path.write_text(json.dumps(swing(0.3)))  # 2e-4 a period
    rows = rows_of(path)
    assert rows['rk4']['recommended'] and rows['rk4']['damping'] is None
    path.write_text(json.dumps(swing(1.0, damping=60.0)))  # which take 60 / 1.2 times as much
    rows = rows_of(path)
    assert rows['rk4']['damping'] is None
