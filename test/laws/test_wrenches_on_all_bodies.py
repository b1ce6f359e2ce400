# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""One call that holds wrenches on all bodies is a call for each of them, to the bit."""

import sys

import numpy as np
import pytest

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene

BODIES = [
    {'name': 'plate', 'shape': {'type': 'box', 'size': [1, 0.5, 0.3]}, 'mass': 1},
    {'name': 'wall', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'fixed': True},
    {'name': 'ball', 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 2},
    {'name': 'stone', 'shape': {'type': 'particle'}, 'mass': 0.5},
]
SCENE = load_scene({'name': 'four', 'dt': 0.01, 'bodies': BODIES})
FORCE = np.array([[1, 2, 3], [0, 0, 0], [-1, 0.5, 0], [0, 0, -2]], dtype=float)
TORQUE = np.array([[0.1, 0, -0.2], [0, 0, 0], [0, 0, 0.3], [0, 0, 0]], dtype=float)


@pytest.mark.parametrize('frame', ['world', 'body'])
def test_it_is_a_call_for_each_body_to_the_bit(frame):
    force = FORCE * [[1], [1], [1], [frame == 'world']]
    at_once, one_by_one = Simulation(SCENE), Simulation(SCENE)
    for simulation in (at_once, one_by_one):
        simulation.hold('plate', 'force', force=(0, 0, 1), until=5)  # another source stays
    at_once.set_wrenches(force=force, torque=TORQUE, frame=frame)
    for i, body in enumerate(SCENE.bodies):
        if not body.fixed:
            axes = 'world' if body.name == 'stone' else frame
            one_by_one.set_wrench(body.name, force=force[i], torque=TORQUE[i], frame=axes)
    assert at_once.held_slots == one_by_one.held_slots
    for _ in range(2):
        at_once.step(4)
        one_by_one.step(4)
        assert at_once.state_bytes() == one_by_one.state_bytes()
        assert np.array_equal(at_once.applied_wrench(), one_by_one.applied_wrench())


@pytest.mark.parametrize('frame', ['world', 'body'])
def test_other_rows_in_each_tick_are_other_calls_for_each_body(frame):
    steady, one_by_one = Simulation(SCENE), Simulation(SCENE)
    rng = np.random.default_rng(4)
    for tick in range(24):
        force, torque = (rows * rng.normal(size=(4, 1)) for rows in (FORCE, TORQUE))
        if tick % 9 == 8:
            torque = np.zeros_like(TORQUE)
        force[3] *= frame == 'world'
        steady.set_wrenches(force=force, torque=torque, frame=frame)
        with pytest.raises(InvalidModel):  # changes nothing
            steady.set_wrenches(force=force * np.nan, torque=torque, frame=frame)
        for i, body in enumerate(SCENE.bodies):
            if not body.fixed:
                axes = 'world' if body.name == 'stone' else frame
                one_by_one.set_wrench(body.name, force=force[i], torque=torque[i], frame=axes)
        for simulation in (steady, one_by_one):
            if tick % 7 == 3:  # one of them alone, and another source
                simulation.set_wrench('ball', force=(7, 0, 0), frame='body')
                simulation.hold('plate', 'torque', torque=(0, 0, 1), until=tick + 2)
            if tick % 5 == 2:
                simulation.apply_impulse('stone', linear=(1, 0, 0))
            if tick == 11:
                kept = simulation.tick, simulation.state_bytes(), simulation.held_slots
                simulation.restore(tick=kept[0], state=kept[1], slots=kept[2])
        assert steady.held_slots == one_by_one.held_slots
        for simulation in (steady, one_by_one):
            simulation.step(1)
        assert steady.state_bytes() == one_by_one.state_bytes()
        assert np.array_equal(steady.applied_wrench(), one_by_one.applied_wrench())


@pytest.mark.parametrize('kind', ['i8', 'u2', 'f4', 'O', np.longdouble, 'masked', 'tuples'])
def test_numbers_of_any_kind_in_each_tick_are_those_of_doubles(kind):
    """
    Also what is none, in the middle of a quick sequence of others, is refused and changes nothing.
    """
    doubles, of_kind, one_by_one = (Simulation(SCENE) for _ in range(3))
    for tick in range(12):
        force = np.abs(np.round(FORCE)) * (tick % 5)
        given = force if kind in ('masked', 'tuples') else force.astype(kind)
        if kind == 'masked':
            given = np.ma.masked_array(force)
        elif kind == 'tuples':
            given = [tuple(int(x) for x in row) for row in force]
        doubles.set_wrenches(force=force)
        of_kind.set_wrenches(force=given)
        for body, row in zip(SCENE.bodies, given, strict=True):
            if not body.fixed:
                one_by_one.set_wrench(body.name, force=row)
        for none in (10**400, True):
            with pytest.raises(InvalidModel):
                one_by_one.set_wrench('plate', force=(none, 0, 0))
        with pytest.raises(InvalidModel):
            of_kind.set_wrenches(force=force > 0)
        for simulation in (doubles, of_kind, one_by_one):
            simulation.step(1)
        assert doubles.state_bytes() == of_kind.state_bytes() == one_by_one.state_bytes()


@pytest.mark.parametrize('rows', [list, tuple, np.array])
@pytest.mark.parametrize('kind', [float, int, np.float64])
def test_rows_as_lists_are_judged_all_at_once(rows, kind):
    """
    The price of a list is numpy's: as many functions are called for 400 bodies as for 4.
    """

    def calls(count):
        body = BODIES[0]
        bodies = [
            {**body, 'name': f'b{i}', 'initial': {'position': [i, 0, 0]}} for i in range(count)
        ]
        simulation = Simulation(load_scene({'name': 'many', 'dt': 0.01, 'bodies': bodies}))
        force = [rows([kind(i), kind(2), kind(-1)]) for i in range(count)]
        seen = []
        for _ in range(3):  # the first finds its kernel
            seen.clear()
            sys.setprofile(lambda _frame, event, _arg: seen.append(event))
            try:
                simulation.set_wrenches(force=force)
            finally:
                sys.setprofile(None)
        assert np.array_equal(simulation.applied_wrench()[0], force)
        return len(seen)

    assert calls(400) == calls(4)


def test_it_replaces_what_it_held_and_lets_go_of_all_without_arguments():
    simulation = Simulation(SCENE)
    simulation.set_wrenches(force=FORCE, torque=TORQUE)
    simulation.set_wrenches(force=2 * FORCE)
    force, torque = simulation.applied_wrench()
    assert np.array_equal(force, 2 * FORCE) and not torque.any()
    force = simulation.applied_wrench()[0]
    simulation.set_wrench('ball', force=(7, 0, 0))  # one of them may be changed alone
    assert simulation.applied_wrench()[0][2].tolist() == [7, 0, 0]
    assert np.array_equal(simulation.applied_wrench()[0][0], force[0])
    simulation.set_wrenches()
    assert not np.any(simulation.applied_wrench()) and not simulation.held_slots


def test_what_is_given_is_copied():
    simulation, force = Simulation(SCENE), FORCE.copy()
    simulation.set_wrenches(force=force)
    force[:] = 99
    assert np.array_equal(simulation.applied_wrench()[0], FORCE)


def _held(values):
    """
    Say what commands to all bodies and to each one make of the same rows.
    """
    said = []
    for each in (False, True):
        simulation = Simulation(SCENE)
        try:
            if each:
                for body, row in zip(simulation.scene.bodies, values, strict=True):
                    if not body.fixed:
                        simulation.set_wrench(body.name, force=row)
            else:
                simulation.set_wrenches(force=values)
        except InvalidModel as error:
            said.append(str(error))
        else:
            said.append(simulation.applied_wrench()[0].tolist())
    return said


MASKED = np.ma.masked_array(FORCE, mask=FORCE != 0.0)
OBJECTS = FORCE.astype(object)


@pytest.mark.parametrize(
    ('values', 'is_held'),
    [
        *((FORCE.astype('f4'), True), (FORCE.astype(int), True), (OBJECTS, True)),
        *((FORCE.tolist(), True), (list(FORCE), True), (FORCE.astype(np.longdouble), True)),
        *((np.ma.masked_array(FORCE), True), (MASKED, False), (FORCE.astype(str), False)),
        *((FORCE.astype(str).tolist(), False), (FORCE != 0.0, False), (FORCE * 1j, False)),
        ((FORCE != 0.0).tolist(), False),
        (FORCE.astype('m8[s]'), False),
        (list(FORCE.astype('m8[s]')), False),
        (np.where(FORCE != 0.0, 10**400, OBJECTS).tolist(), False),
        (np.where(FORCE != 0.0, 10**400, OBJECTS), False),
        (np.where(FORCE != 0.0, np.inf, FORCE).tolist(), False),
    ],
)
def test_what_is_a_number_does_not_depend_on_whether_one_body_is_asked_or_all(values, is_held):
    of_all, of_each = _held(values)
    assert isinstance(of_all, list) is isinstance(of_each, list) is is_held
    assert of_all == of_each if is_held else 'three finite numbers' in of_all


@pytest.mark.parametrize(
    ('asked', 'reason'),
    [
        ({'force': FORCE[:3]}, r'of shape \(3, 3\); allowed: an array \(4, 3\)'),
        ({'force': FORCE.T}, r'of shape \(3, 4\)'),
        ({'force': FORCE.T.tolist()}, r'of shape \(3, 4\)'),
        (
            {'force': [*FORCE.tolist()[:3], [1, 2]]},
            r"'stone': force \[1, 2\]; .*three finite numbers",
        ),
        ({'force': [*FORCE.tolist()[:3], [0, 0, None]]}, r"'stone': force \[0, 0, None\]"),
        ({'torque': [*TORQUE.tolist()[:3], [0, False, 0]]}, r"'stone': torque \[0, False, 0\]"),
        ({'force': [[], [], [], []]}, r'\(4, 0\)|three finite numbers'),
        ({'force': []}, r'of shape \(0,\)'),
        ({'torque': 'abc'}, "torque 'abc'"),
        ({'force': FORCE + [[0], [1], [0], [0]]}, "'wall' is fixed"),
        ({'torque': TORQUE + [[0], [0], [0], [1]]}, "'stone': torque .* on a point mass"),
        ({'force': FORCE, 'frame': 'body'}, "'stone' is a point mass and has no axes"),
        ({'force': FORCE * [[1], [0], [np.nan], [1]]}, "'ball': force"),
        ({'force': FORCE, 'frame': 'nose'}, "frame 'nose'; allowed: 'world', 'body'"),
        ({'force': FORCE, 'frame': None}, 'frame None'),
    ],
)
def test_what_cannot_be_held_is_refused_by_its_body_and_changes_nothing(asked, reason):
    simulation = Simulation(SCENE)
    simulation.set_wrenches(force=FORCE)
    with pytest.raises(InvalidModel, match=reason):
        simulation.set_wrenches(**asked)
    assert np.array_equal(simulation.applied_wrench()[0], FORCE)


def test_a_time_is_run_in_whole_ticks_or_refused():
    simulation = Simulation(SCENE)
    simulation.run_for(0.25)
    simulation.run_for(0)
    assert simulation.tick == 25
    for seconds in (0.005, -1, np.nan, np.inf, 'x', True, 1 / 3):
        with pytest.raises(InvalidModel, match='run_for: '):
            simulation.run_for(seconds)
    assert simulation.tick == 25
