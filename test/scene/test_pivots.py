# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scene key `pivot`: what follows from it, and what is refused."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError

from .. import inside

HALF = math.sqrt(0.5)


def scene(**changes):
    bar = {
        'name': 'bar',
        'shape': {'type': 'box', 'size': [0.1, 0.1, 1.0]},
        'mass': 1.0,
        'pivot': {'point': [0, 0, 0.5]},
    }
    return {
        'dt': 0.001,
        'bodies': [{k: v for k, v in {**bar, **changes}.items() if v is not None}],
    }


def body(**changes):
    return load_scene(scene(**changes)).bodies[0]


def test_the_pivot_is_where_the_body_has_its_point():
    start = {'position': [1, 2, 3], 'orientation': [HALF, 0, 0, HALF]}
    bar = body(initial=start)
    assert bar.pivot.at == pytest.approx((1, 1.5, 3))
    assert bar.initial.position == (1, 2, 3)


def test_with_at_the_position_follows_and_so_does_the_velocity():
    start = {'orientation': [HALF, 0, 0, HALF], 'angular_velocity': [0, 0, 2]}
    bar = body(pivot={'point': [0, 0, 0.5], 'at': [0, 0, 2]}, initial=start)
    assert bar.initial.position == pytest.approx((0, 0.5, 2), abs=1e-15)
    assert bar.initial.velocity == pytest.approx((-1, 0, 0), abs=1e-15)
    read = Simulation(load_scene(scene(pivot={'point': [0, 0, 0.5]}, initial=start))).state
    assert read.velocity[0] == pytest.approx((-1, 0, 0), abs=1e-15)


def test_what_is_given_twice_and_agrees_is_taken():
    pivot = {'point': [0, 0, 0.5], 'at': [0, 0, 0.5]}
    bar = body(
        pivot=pivot,
        initial={'position': [0, 0, 0], 'velocity': [0, 0.5, 0], 'angular_velocity': [1, 0, 0]},
    )
    assert bar.initial.velocity == pytest.approx((0, 0.5, 0))


def test_a_body_without_a_shape_turns_about_a_point_seen_from_its_origin():
    bar = body(
        shape=None,
        center_of_mass=[0, 0, 0.5],
        inertia={'ixx': 1, 'iyy': 1, 'izz': 1},
        pivot={'point': [0, 0, 0], 'at': [0, 0, 0]},
    )
    assert bar.initial.position == (0, 0, 0.5)


REFUSED = [
    ({'fixed': True}, "pivot: 'bar' is fixed and does not turn; remove pivot, or fixed"),
    ({'shape': {'type': 'particle'}}, 'is a point mass, which does not turn about a pivot'),
    ({'mass_rate': -0.1}, 'a mass that changes is not modelled; remove mass_rate, or pivot'),
    ({'pivot': [0, 0, 1]}, 'a mapping such as {point: [0, 0, -0.5]} is needed'),
    ({'pivot': {'at': [0, 0, 1]}}, 'pivot: point is missing'),
    ({'pivot': {'point': [0, 0, 1], 'position': [0, 0, 0]}}, 'pivot.position: unknown key'),
    ({'pivot': {'point': [0, 0, math.inf]}}, 'pivot.point[2]: got inf'),
    (
        {'initial': {'velocity': [1, 0, 0]}},
        'initial.velocity: got [1.0, 0.0, 0.0]; with this pivot velocity is [',
    ),
    (
        {'pivot': {'point': [0, 0, 0.5], 'at': [0, 0, 0]}, 'initial': {'position': [0, 0, 1]}},
        'initial.position: got [0.0, 0.0, 1.0]; with this pivot position is [0, 0, -0.5] m',
    ),
    ({'pivot': {'point': [0, 0, 1e200]}}, 'so far from its centre of mass'),
]


@pytest.mark.parametrize(('changes', 'reason'), REFUSED)
def test_an_impossible_pivot_is_refused(changes, reason):
    with pytest.raises(UserError) as caught:
        load_scene(scene(**changes))
    assert reason in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_scene_without_a_pivot_has_nothing_of_it():
    free = Simulation(load_scene(scene(pivot=None)))
    hung = Simulation(load_scene(scene()))
    none, some = inside.elements(free), inside.elements(hung)
    assert [name for name, _ in none.chain()] == ['held_body_wrench']
    assert [name for name, _ in some.chain()] == ['held_body_wrench', 'pivot']
    assert none.do_nothing
    assert none.numbers.size == 0
    assert np.array_equal(some.numbers[:4], (0.0, 0.0, 0.0, -0.5))
