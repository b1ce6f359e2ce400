# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`inspect`: what a scene holds, before it runs."""

import json

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

from .conftest import SCENES

DUMBBELL = {
    'dt': 0.01,
    'name': 'dumbbell',
    'bodies': [
        {
            'name': 'four',
            'shape': {
                'type': 'particles',
                'particles': [
                    {'mass': 1, 'position': [1, 0, 0]},
                    {'mass': 1, 'position': [-1, 0, 0]},
                    {'mass': 2, 'position': [0, 1, 1]},
                    {'mass': 2, 'position': [0, -1, -1]},
                ],
            },
        },
        {'name': 'dot', 'shape': {'type': 'particle'}, 'mass': 0.5},
        {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}},
    ],
    'forces': [{'type': 'spring', 'a': 'four', 'b': 'dot', 'stiffness': 1e4}],
}


@pytest.fixture
def dumbbell(tmp_path):
    path = tmp_path / 'dumbbell.yaml'
    path.write_text(json.dumps(DUMBBELL))
    return path


def test_the_numbers_of_a_body_are_those_of_its_points(dumbbell, as_json):
    code, facts = as_json('inspect', dumbbell)
    assert code == 0
    four, dot, floor = facts['bodies']
    assert four['mass'] == 6.0
    assert four['center_of_mass'] == pytest.approx([0, 0, 0])
    # by hand: Ixx = 2 * 2 (1 + 1), Iyy = 2 + 4, Izz = 2 + 4, Iyz = -2 * 2
    assert np.array(four['inertia']) == pytest.approx(
        np.array([[8, 0, 0], [0, 6, -4], [0, -4, 6]], dtype=float)
    )
    axes, moments = np.array(four['principal_axes']), four['principal_moments']
    assert axes @ np.diag(moments) @ axes.T == pytest.approx(np.array(four['inertia']))
    assert sorted(moments) == pytest.approx([2, 8, 10])
    # six degrees of freedom in place of twelve coordinates
    assert (four['degrees_of_freedom'], four['coordinates'], four['constraints']) == (6, 12, 6)
    assert (dot['degrees_of_freedom'], dot['principal_moments']) == (3, [0, 0, 0])
    assert (floor['mass'], floor['inertia'], floor['degrees_of_freedom']) == (None, None, 0)
    assert facts['needs']['degrees_of_freedom'] == 9
    assert facts['needs']['coupled'] == ['spring']


def test_every_integrator_is_judged_at_the_dt_that_is_asked_for(dumbbell, as_json):
    _, facts = as_json('inspect', dumbbell)
    rows = {row['name']: row for row in facts['integrators']}
    assert rows.keys() == INTEGRATORS.keys()
    assert "'four' can turn" in rows['linear_propagator']['refused']
    # w^2 = k (1/6 + 1/0.5) of the spring between the centres
    swing = next(s for s in rows['rk4']['steps'] if s['kind'] == 'oscillation')
    assert swing['product'] == pytest.approx(0.01 * np.sqrt(1e4 * (1 / 6 + 2)), rel=1e-9)
    assert not rows['rk4']['beyond']  # but it damps
    assert not rows['rk4']['recommended'] and rows['rk8']['recommended']
    _, facts = as_json('inspect', dumbbell, '--dt', '0.1')
    rows = {row['name']: row for row in facts['integrators']}
    assert not rows['rk4']['recommended']
    assert 'rk4 is stable only up to' in rows['rk4']['beyond'][0]
    assert rows['rk45']['recommended']  # which divides the tick by itself
    assert not (rows['sdirk2']['recommended'] or rows['sdirk2']['beyond'])  # of lower order


def test_the_moment_about_an_axis(dumbbell, as_json, verb):
    words = ('--axis', 'four', '0', '0', '-3', '--point', '2', '0', '5')
    _, facts = as_json('inspect', dumbbell, *words)
    assert facts['axis']['moment'] == pytest.approx(6 + 6 * 4)
    assert facts['axis']['moment_through_center'] == pytest.approx(6)
    assert facts['axis']['radius_of_gyration'] == pytest.approx(np.sqrt(5))
    sim = Simulation(load_scene(DUMBBELL))
    assert sim.moment_of_inertia('four', direction=(0, 0, 1), point=(2, 0, 5)) == pytest.approx(30)
    assert sim.moment_of_inertia('dot', direction=(0, 0, 1), point=(2, 0, 0)) == pytest.approx(2)
    for bad, said in (
        (('--axis', 'for', '0', '0', '1'), "no body is named 'for'"),
        (('--axis', 'four', '0', '0', '0'), 'non-zero length'),
        (('--axis', 'four', 'x', '0', '0'), 'three numbers'),
        (('--axis', 'floor', '0', '0', '1'), "'floor' is fixed"),
        (('--point', '0', '0', '1'), 'give --axis'),
        (
            ('--axis', 'four', '-1e-3', '0', '0', '--point', '0', '1e200', '0'),
            'beyond all numbers',
        ),
        (('--dt', '0'), 'dt'),
    ):
        code, out, err = verb('inspect', dumbbell, *bad)
        assert (code, out, err.count('\n')) == (2, '', 1) and said in err
    with pytest.raises(InvalidModel, match='three finite numbers'):
        sim.moment_of_inertia('four', direction=(0, 0, 1), point=(np.nan, 0, 0))


@pytest.mark.parametrize('scene', sorted(path.stem for path in SCENES.glob('*.yaml')))
def test_every_shipped_scene_can_be_read_aloud(scene, verb):
    code, out, err = verb('inspect', scene)
    assert (code, err) == (0, '')
    assert 'what it needs' in out and 'recommended' in out


def test_a_point_of_a_body_moves_as_the_lecture_says():
    """x = r + R d, v = r' + w x R d, a = r'' + w' x R d + w x (w x R d)."""
    scene = {
        'dt': 0.01,
        'gravity': [0, 0, -9.81],
        'bodies': [
            {
                'name': 'wheel',
                'shape': {'type': 'cylinder', 'radius': 1.0, 'length': 0.1},
                'mass': 1.0,
                'initial': {'velocity': [1, 0, 0], 'angular_velocity': [0, 0, 2]},
            }
        ],
    }
    moved = Simulation(load_scene(scene)).motion_of('wheel', [(1, 0, 0), (0, 1, 0)])
    assert moved.position == pytest.approx(np.array([[1, 0, 0], [0, 1, 0]]))
    assert moved.velocity == pytest.approx(np.array([[1, 2, 0], [-1, 0, 0]]))
    assert moved.acceleration == pytest.approx(np.array([[-4, 0, -9.81], [0, -4, -9.81]]))


def test_frames_are_told_from_the_centre_of_mass(verb, as_json):
    code, facts = as_json('inspect', 'quadrotor')
    assert code == 0
    frames = facts['bodies'][0]['frames']
    assert frames['rear_left'] == {'position': [-0.15, 0.15, 0.02], 'orientation': [0, 0, 0, 1]}
    code, said, _ = verb('inspect', 'quadrotor')
    assert code == 0 and 'frame rear_left (-0.15, 0.15, 0.02) m from the centre of mass' in said
