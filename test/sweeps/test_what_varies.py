# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What keys take from run to run: places in a scene, lists, draws; and what is refused before."""

import math
from dataclasses import replace

import numpy as np
import pytest

import rigid_body_sim as rbs
from rigid_body_sim.errors import UserError
from rigid_body_sim.sweeps import ensemble
from rigid_body_sim.sweeps.distributions import spec_of
from rigid_body_sim.sweeps.plan import plan_sweep

from .conftest import scene


def values(vary, runs=None, seed=0, source=None):
    """What the axes hold, run by run."""
    sweep = plan_sweep(source or scene(), vary, runs=runs, seed=seed)
    return [sweep.values(run) for run in range(sweep.runs)]


def test_a_run_depends_on_seed_and_number_alone():
    vary = {'tumbler.mass': 'uniform:1:3', 'ball.initial.velocity': rbs.normal(0.0, 1.0)}
    few, many = values(vary, runs=5, seed=7), values(vary, runs=50, seed=7)
    assert many[:5] == few
    backwards = plan_sweep(scene(), vary, runs=50, seed=7)
    assert [backwards.values(run) for run in reversed(range(50))] == many[::-1]
    assert values(vary, runs=5, seed=8) != few


def test_what_else_varies_and_how_a_key_is_called_changes_no_draw():
    alone = values({'tumbler.mass': rbs.uniform(1, 3)}, runs=9)
    beside = values({'ball.mass': 'normal:1:0.1', 'bodies[0].mass': 'uniform(1, 3)'}, runs=9)
    assert [row[0] for row in alone] == [row[1] for row in beside]
    same_law = values({'ball.mass': rbs.uniform(1, 3), 'tumbler.mass': rbs.uniform(1, 3)}, runs=9)
    assert len(same_law) == 9
    assert all(one != other for one, other in same_law)


def test_lists_are_combined_in_full_the_last_key_fastest_and_begin_anew():
    vary = {'dt': [0.01, 0.02], 'tumbler.mass': '1:3:3'}
    expected = [[0.01, 1.0], [0.01, 2.0], [0.01, 3.0], [0.02, 1.0], [0.02, 2.0], [0.02, 3.0]]
    assert values(vary) == expected
    assert values(vary, runs=8) == [*expected, *expected[:2]]


@pytest.mark.parametrize(
    ('text', 'numbers'),
    [
        ('1e-3, 5e-4', [1e-3, 5e-4]),
        ('0.5,1e0,2', [0.5, 1.0, 2]),
        ('choice:1e0:2E0', [1.0, 2.0]),
        ('[1e0,0,0],[-1e+0,0,.5e0]', [[1.0, 0, 0], [-1.0, 0, 0.5]]),
        ('{mass: 1e1}', [{'mass': 10.0}]),
        ('010, 1_0, word', ['010', '1_0', 'word']),
    ],
)
def test_a_number_is_what_a_scene_takes_for_one(text, numbers):
    spec = spec_of(text, key='key')
    found = list(getattr(spec, 'values', None) or spec.arguments)
    assert (found, list(map(type, found))) == (numbers, list(map(type, numbers)))


def test_a_grid_has_both_ends_to_the_bit():
    (first, *_, last) = [row[0] for row in values({'tumbler.mass': '0.1:0.7:7'})]
    assert (first, last) == (0.1, 0.7)


@pytest.mark.parametrize(
    ('law', 'mean', 'deviation'),
    [
        (rbs.uniform(2, 5), 3.5, 3 / math.sqrt(12)),
        (rbs.normal(-1, 0.5), -1.0, 0.5),
        ('truncated_normal:0:1:-1:1', 0.0, 0.5396),  # of the textbook: 1 - 2 phi(1) / (2 Phi(1)-1)
        (rbs.integers(1, 6), 3.5, math.sqrt(35 / 12)),
    ],
)
def test_draws_have_the_mean_and_deviation_of_their_law(law, mean, deviation):
    drawn = np.array(values({'tumbler.mass': law}, runs=2000, seed=3))[:, 0]
    # four standard errors of a mean and, near enough, of a deviation of 2000 draws
    near = 4 * deviation / math.sqrt(len(drawn))
    assert abs(drawn.mean() - mean) < near
    assert abs(drawn.std() - deviation) < near


def test_the_logarithm_of_a_loguniform_draw_is_uniform():
    drawn = np.log10([row[0] for row in values({'dt': 'loguniform:1e-4:1e-2'}, runs=1000)])
    assert (drawn >= -4).all() and (drawn <= -2).all()
    assert abs(drawn.mean() + 3) < 4 * 2 / math.sqrt(12 * len(drawn))  # four standard errors


def test_rotations_and_directions_have_unit_length_and_no_preference():
    vary = {
        'tumbler.initial.orientation': rbs.random_rotation(),
        'ball.initial.velocity': rbs.direction(3.0),
    }
    drawn = values(vary, runs=1000)
    q, v = np.array([row[0] for row in drawn]), np.array([row[1] for row in drawn])
    assert np.allclose((q * q).sum(axis=1), 1.0, atol=1e-15)  # round-off
    assert np.allclose((v * v).sum(axis=1), 9.0, atol=1e-14)
    # four standard errors: the variance of a coordinate is 1/4 and 9/3
    assert (abs(q.mean(axis=0)) < 4 * 0.5 / math.sqrt(1000)).all()
    assert (abs(v.mean(axis=0)) < 4 * math.sqrt(3) / math.sqrt(1000)).all()


def test_values_that_are_lists_mappings_texts_and_arrays_reach_the_scene():
    shapes = [{'type': 'sphere', 'radius': 0.1}, {'type': 'box', 'size': [1, 1, 1]}]
    source = scene(bodies=[{'name': 'b', 'shape': shapes[0], 'mass': 1.0}])
    sweep = plan_sweep(
        source,
        {'b.shape': shapes, 'b.initial.position': np.eye(3), 'integrator': ['rk4', 'dmv2']},
    )
    assert sweep.runs == 12
    last = sweep.scene(sweep.values(11))
    assert last.bodies[0].initial.position == (0.0, 0.0, 1.0)
    assert last.integrator == 'dmv2' and last.bodies[0].shape.size == (1.0, 1.0, 1.0)
    assert plan_sweep(source, {'b.shape': shapes}).axes[0].columns == {'b.shape': 'text'}
    for text in ('[0, 0, 1], [0, 2, 0]', '[[0, 0, 1], [0, 2, 0]]'):
        sweep = plan_sweep(source, {'b.initial.position': text})
        assert [sweep.values(run) for run in range(2)] == [[[0, 0, 1]], [[0, 2, 0]]]


def test_a_place_that_the_scene_leaves_out_is_made():
    sweep = plan_sweep(
        scene(),
        {'gravity[2]': [-1.6], 'ball.initial.velocity[1]': [4.0], 'integrator.substeps': [3]},
    )
    made = sweep.scene(sweep.values(0))
    assert made.gravity == (0.0, 0.0, -1.6)
    assert made.bodies[1].initial.velocity == (0.0, 4.0, 0.0)
    assert made.integrator == 'dmv6' and made.integrator_options == {'substeps': 3.0}


def test_what_is_put_in_place_of_something_else_replaces_it():
    sweep = plan_sweep(scene(), {'tumbler.initial.angular_velocity': [[0, 0, 1]]})
    assert sweep.scene(sweep.values(0)).bodies[0].initial.angular_velocity == (0.0, 0.0, 1.0)


def test_runs_differ_only_in_what_varies_from_the_scene_as_it_is_read():
    whole = rbs.load_scene('satellite')
    sweep = plan_sweep('satellite', {'satellite.mass': [12.0]})
    made, again = sweep.scene(sweep.values(0)), rbs.load_scene(sweep.text(0))
    for one, other, third in zip(whole.bodies, made.bodies, again.bodies, strict=True):
        for name in ('name', 'shape', 'mass', 'center_of_mass', 'initial', 'material'):
            assert getattr(one, name) == getattr(other, name) == getattr(third, name)
        assert one.inertia is None or (one.inertia == other.inertia).all()


@pytest.mark.parametrize(
    ('vary', 'told'),
    [
        ({'tumbler.masss': [1]}, "bodies[0].masss: unknown key; did you mean 'mass'?"),
        ({'tumblr.mass': [1]}, "did you mean 'tumbler'?"),
        ({'gravty[2]': [1]}, "did you mean 'gravity'?"),
        ({'contact.mod': ['none']}, "contact.mod: unknown key; did you mean 'mode'?"),
        ({'bodies[2].mass': [1]}, 'has 2 entries'),
        ({'tumbler.mass[0]': [1]}, 'holds no list'),
        ({'tumbler.mass.x': [1]}, 'holds no keys'),
        ({'tumbler.name': ['a']}, 'told apart by their names'),
        ({'name': ['a']}, 'vary another key'),
        ({'bodies': [[]]}, 'bodies[0]'),
        ({'': [1]}, 'a key is empty'),
        ({'tumbler..mass': [1]}, 'not a path'),
        ({3: [1]}, 'is no text'),
        ({'tumbler.mass': []}, 'empty list'),
        ({'tumbler.mass': lambda: 1}, 'allowed: numbers, texts, lists'),
        ({'tumbler.mass': 'unform:1:2'}, "did you mean 'uniform'?"),
        ({'tumbler.mass': 'uniform(1)'}, 'written uniform(LOW, HIGH)'),
        ({'tumbler.mass': 'uniform(1, 2'}, 'no closing bracket'),
        ({'tumbler.mass': 'uniform:2:1'}, 'must not be above the second'),
        ({'tumbler.mass': 'uniform:nan:1'}, 'a finite number is needed'),
        ({'tumbler.mass': 'normal:0:-1'}, 'must not be negative'),
        ({'tumbler.mass': 'loguniform:0:1'}, 'must be positive'),
        ({'tumbler.mass': 'truncated_normal:0:1:8:9'}, 'more than three deviations outside'),
        ({'tumbler.mass': 'integers:1.5:3'}, 'two whole numbers'),
        ({'tumbler.mass': 'choice()'}, 'nothing to choose from'),
        ({'tumbler.mass': '1:2:0'}, '1 to 1000000 points'),
        ({'tumbler.mass': '1:nan:3'}, 'finite'),
        ({'tumbler.mass': '1:2:three'}, 'FIRST:LAST:POINTS'),
        ({'tumbler.mass': '1,,2'}, "got '1,,2'; allowed: a list such as 1,2,5"),
        ({'ball.initial.velocity': '1:2:3'}, 'holds a list of 3 numbers'),
        ({'tumbler.mass': [1], 'bodies[0].mass': [2]}, 'are the same place'),
        ({'gravity': [[0, 0, 1]], 'gravity[2]': [1]}, 'lie inside of each other'),
        ({'ball.mass': [1], 'ball.density': [2]}, 'cannot both be given'),
        ([('tumbler.mass', 1)], 'a mapping is needed'),
    ],
)
def test_what_makes_no_run_is_refused_before_any(vary, told):
    with pytest.raises(UserError) as refused:
        plan_sweep(scene(), vary, runs=3)
    assert told in str(refused.value)
    assert '\n' not in str(refused.value)


@pytest.mark.parametrize(
    ('settings', 'told'),
    [
        ({'runs': 0}, 'runs 0; allowed: a whole number from 1'),
        ({'runs': 2.5}, 'runs 2.5'),
        ({'runs': True}, 'runs True'),
        ({'runs': 10**13}, 'allowed: a whole number'),
        ({'runs': None}, 'say how many runs'),
        ({'seed': -1}, 'seed -1'),
        ({'duration': 0.0}, 'duration 0.0 s'),
        ({'duration': math.nan}, 'duration nan s'),
        ({'every': -1.0}, 'every -1.0 s'),
        ({'keep': ['lost']}, "keep 'lost'; allowed: last, extremes, energy"),
        ({'bodies': ['tumblr']}, "did you mean 'tumbler'?"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(settings, told):
    with pytest.raises(UserError) as refused:
        plan_sweep(scene(), {'tumbler.mass': 'uniform:1:2'}, **{'runs': 3, **settings})
    assert told in str(refused.value)


def test_a_scene_changed_in_python_is_varied_as_it_is_now():
    whole = rbs.load_scene(scene())
    changed = replace(whole, gravity=(0.0, 0.0, -1.5), source=whole.source)
    sweep = plan_sweep(changed, {'tumbler.mass': [2.5]})
    made = sweep.scene(sweep.values(0))
    assert made.gravity == (0.0, 0.0, -1.5) and made.bodies[0].mass == 2.5


def test_a_package_that_is_missing_is_told_before_any_run(monkeypatch):
    monkeypatch.setattr(ensemble, 'find_spec', lambda name: None if name == 'pandas' else name)
    with pytest.raises(UserError, match='pip install pandas'):
        rbs.sweep(scene(), {'tumbler.mass': [2.5]})


def test_a_copy_of_a_repeated_body_is_told_apart_from_an_unknown_one():
    body = {'name': 'b', 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1.0}
    source = scene(bodies=[{**body, 'repeat': {'count': [3, 1, 1], 'spacing': [1, 0, 0]}}])
    with pytest.raises(UserError, match='b_2 is one of the copies of b'):
        plan_sweep(source, {'b_2.mass': [1.0]})
