# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Pairs of bodies that do not meet, and pairs with friction and restitution of their own.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.material import MATERIAL, material_of_pair
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene

SCENE = """
dt: 0.004
gravity: [0, 0, -9.81]
contact:
  mode: timestep
  ignore: [[ghost, floor], [twin, twin]]
  pairs:
    - {bodies: [slider, floor], friction: 0.1}
    - {bodies: [bouncer, floor], restitution: 1.0}
bodies:
  - {name: floor, shape: {type: plane, normal: [0, 0, 1]}, friction: 0.5}
  - {name: ghost, shape: {type: sphere, radius: 0.1}, mass: 1, initial: {position: [0, 0, 0.1]}}
  - {name: slider, shape: {type: box, size: [0.2, 0.2, 0.2]}, mass: 1, friction: 0.5,
     initial: {position: [5, 0, 0.1], velocity: [1, 0, 0]}}
  - {name: usual, shape: {type: box, size: [0.2, 0.2, 0.2]}, mass: 1, friction: 0.5,
     initial: {position: [5, 5, 0.1], velocity: [1, 0, 0]}}
  - {name: bouncer, shape: {type: sphere, radius: 0.1}, mass: 1,
     initial: {position: [0, 5, 0.6]}}
  - name: twin
    shape: {type: box, size: [0.2, 0.2, 0.2]}
    mass: 1
    initial: {position: [0, -5, 0.1]}
    repeat: {count: [2, 1, 1], spacing: [0.1, 0, 0]}
"""


@pytest.fixture(scope='module')
def after_a_second():
    simulation = simulation_of(load_scene(SCENE.encode()))
    simulation.step(250)
    return simulation


def place(simulation, name):
    return simulation.state.position[simulation.body_index(name)]


def test_ignored_pair_passes_through_in_free_fall(after_a_second):
    # nothing touches it: the fall of a point, to round-off of 250 ticks
    fallen = 0.1 - 0.5 * 9.81
    assert place(after_a_second, 'ghost')[2] == pytest.approx(fallen, abs=1e-12)


def test_copies_that_ignore_each_other_overlap_and_stand(after_a_second):
    for name, x in (('twin_1', 0.0), ('twin_2', 0.1)):
        # half inside each other and not pushed apart; the sink of rest is 1e-6 m
        assert place(after_a_second, name) == pytest.approx([x, -5, 0.1], abs=5e-6)


@pytest.mark.parametrize(('name', 'friction'), [('slider', 0.1), ('usual', 0.5)])
def test_sliding_body_stops_by_the_friction_of_its_pair(after_a_second, name, friction):
    time = min(1.0, 1.0 / (friction * 9.81))
    way = time - 0.5 * friction * 9.81 * time**2
    # the first substeps of a contact are without friction: h v
    assert place(after_a_second, name)[0] - 5 == pytest.approx(way, abs=2e-3)


def test_ball_bounces_by_the_restitution_of_its_pair(after_a_second):
    velocity = after_a_second.state.velocity[after_a_second.body_index('bouncer')]
    energy = 9.81 * place(after_a_second, 'bouncer')[2] + 0.5 * velocity @ velocity
    assert energy == pytest.approx(9.81 * 0.6, rel=1e-3)  # a bounce comes late by part of a tick


def test_rules_do_not_depend_on_the_order_of_names_and_entries():
    given = SCENE.replace('[ghost, floor]', '[floor, ghost]').replace(
        '[slider, floor]', '[floor, slider]'
    )
    simulation, other = (simulation_of(load_scene(t.encode())) for t in (SCENE, given))
    for each in (simulation, other):
        each.step(100)
    assert simulation.state_bytes() == other.state_bytes()


def with_rules(rules):
    text = SCENE.split('\n')
    kept = [line for line in text if not line.startswith(('contact', '  mode', '  ignore'))]
    kept = [line for line in kept if not line.startswith(('  pairs', '    - {bodies'))]
    return ('\n'.join(kept) + f'\ncontact: {{mode: timestep, {rules}}}\n').encode()


@pytest.mark.parametrize(
    ('rules', 'said'),
    [
        ('ignore: [[gost, floor]]', "contact.ignore[0][0]: body 'gost' is unknown; did you mean"),
        ('ignore: [[ghost]]', 'a list of at least two bodies is needed'),
        ('ignore: [[ghost, ghost]]', 'a body does not meet itself'),
        ('ignore: [[ghost, floor], [floor, ghost]]', 'ignored by an earlier entry'),
        ('ignore: ghost', 'contact.ignore: got'),
        ('pairs: [{bodies: [ghost, flor], friction: 1}]', "did you mean 'floor'?"),
        ('pairs: [{bodies: [ghost, floor, usual], friction: 1}]', 'a pair has two'),
        ('pairs: [{bodies: [ghost, floor]}]', 'give one of restitution, friction'),
        ('pairs: [{bodies: [ghost, floor], frictoin: 1}]', "did you mean 'friction'?"),
        ('pairs: [{bodies: [ghost, floor], friction: -1}]', 'of at least 0'),
        ('pairs: [{bodies: [ghost, floor], restitution: 1.5}]', 'from 0.0 to 1.0'),
        ('pairs: [{friction: 1}]', 'bodies is missing'),
        (
            'pairs: [{bodies: [ghost, floor], friction: 1}, '
            '{bodies: [floor, ghost], restitution: 1}]',
            'given twice',
        ),
        (
            'ignore: [[ghost, floor]], pairs: [{bodies: [ghost, floor], friction: 1}]',
            'ignored, so they never meet',
        ),
    ],
)
def test_rules_that_cannot_be_are_refused_with_place_and_cure(rules, said):
    with pytest.raises(UserError) as caught:
        load_scene(with_rules(rules))
    assert said in str(caught.value)
    assert 'contact.' in str(caught.value)
    assert '\n' not in str(caught.value)


def test_rule_that_repeats_the_materials_changes_no_bit():
    other = SCENE.replace(
        '    - {bodies: [sl', '    - {bodies: [usual, floor], friction: 0.5}\n    - {bodies: [sl'
    )
    assert other != SCENE
    simulation, other = (simulation_of(load_scene(t.encode())) for t in (SCENE, other))
    for each in (simulation, other):
        each.step(100)
    assert simulation.state_bytes() == other.state_bytes()


def test_a_pair_has_what_it_is_given_else_the_larger_or_the_geometric_mean():
    columns = tuple(MATERIAL)
    assert columns == ('restitution', 'friction', 'rolling_friction', 'torsional_friction')
    of_colliders = np.array([[0.2, 0.4, 0.0, 3e-3], [0.5, 0.9, 1e-3, 2e-3], [0.0, 0.1, 0.0, 0.0]])
    both = (0.5, math.sqrt(0.4 * 0.9), 1e-3, 3e-3)
    nan = math.nan
    of_pairs = np.array([[nan, 0.7, nan, nan, 1 * 3 + 0], [0.9, nan, 4e-3, 0.0, 2 * 3 + 1]])
    for a, b in ((0, 1), (1, 0)):  # whoever is A
        pair = a, b, of_colliders.ravel()
        assert material_of_pair(*pair, np.zeros(0)) == both
        assert material_of_pair(*pair, of_pairs.ravel()) == (both[0], 0.7, *both[2:])
        assert material_of_pair(*pair, of_pairs[1:].ravel()) == both
    of_last = material_of_pair(2, 1, of_colliders.ravel(), of_pairs.ravel())
    assert of_last == (0.9, math.sqrt(0.1 * 0.9), 4e-3, 0.0)
