# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at their instants on belts and on what is moved as told: friction is that against the
material, whose velocity no impulse changes, and the work of the drive is in the balance.
"""

import copy
import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene

pytestmark = pytest.mark.usefixtures('plain_source')

G = 9.81  # [m/s^2]
BALL = {'type': 'sphere', 'radius': 0.1}
DECK = {'type': 'box', 'size': [8, 8, 0.5]}
ROLLER = {'type': 'cylinder', 'radius': 0.5, 'length': 4.0}
ALONG_X = [0, math.sqrt(0.5), 0, math.sqrt(0.5)]  # the axis z of a shape
FAR = [
    {'name': 'far_deck', 'shape': DECK, 'motion': {},
     'initial': {'position': [-500, 0, -500], 'velocity': [0, 0, 1e-3]}},
    {'name': 'far_roller', 'shape': ROLLER, 'fixed': True, 'surface_velocity': [1, 0, 0],
     'initial': {'position': [-600, 0, -500]}},
    {'name': 'far_box', 'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]}, 'mass': 1.0,
     'initial': {'position': [-700, 0, -500]}},
]  # fmt: skip
# so all scenes of this file share one kernel


def simulation(*bodies, dt=0.004):
    contact = {'mode': 'event'}
    scene = {'dt': dt, 'gravity': [0, 0, -G], 'bodies': [*bodies, *FAR], 'contact': contact}
    return Simulation(load_scene(scene))


def ball(height, *, velocity=(0, 0, 0), turn=(0, 0, 0), mu=0.3, e=0.7, x=0.0):
    return {
        'name': 'ball', 'shape': BALL, 'mass': 2.0, 'friction': mu, 'restitution': e,
        'initial': {'position': [x, 0, height], 'velocity': list(velocity),
                    'angular_velocity': list(turn)},
    }  # fmt: skip


def driven(how, speed, mu):
    """What has its top at z = 0, and a surface there that runs along y."""
    told = {
        'belt': {'shape': DECK, 'fixed': True, 'surface_velocity': [0, speed, 0]},
        'deck': {'shape': DECK, 'motion': {}},
        'roller': {'shape': ROLLER, 'motion': {}},
    }[how]
    start = {
        'belt': {'position': [0, 0, -0.25]},
        'deck': {'position': [0, 0, -0.25], 'velocity': [0, speed, 0]},
        'roller': {'position': [0, 0, -0.5], 'orientation': ALONG_X,
                   'angular_velocity': [-speed / 0.5, 0, 0]},
    }[how]  # fmt: skip
    return {'name': 'driven', 'friction': mu, 'initial': start, **told}


@pytest.mark.parametrize('how', ['belt', pytest.param('deck', marks=pytest.mark.long), 'roller'])
@pytest.mark.parametrize(('mu', 'speed'), [(0.2, 3.0), (1.0, 1.5)], ids=['slips', 'sticks'])
def test_friction_of_an_impact_is_that_against_the_material_that_runs_by(how, mu, speed):
    radius, fall = 0.1, 0.2
    sim = simulation(driven(how, speed, mu), ball(radius + fall, mu=mu, turn=(0, 0, 4.0)))
    sim.keep_energy_balance()
    down = math.sqrt(2 * G * fall)
    while not len(sim.impacts()):
        sim.step()
    rub = min(mu * 1.7 * down, 2 / 7 * speed)  # [m/s]
    assert sim.state.velocity[1, :2] == pytest.approx([0, rub], abs=1e-13)
    turn = sim.state.angular_velocity[1]
    assert turn == pytest.approx([rub / (0.4 * radius), 0, 4.0], rel=1e-12, abs=1e-12)
    # the drive pushes with what it rubs, as fast as it runs
    balance = sim.energy_balance()
    assert balance.work_of_drives == pytest.approx(2.0 * rub * speed, rel=1e-12)


def test_what_falls_on_a_load_of_an_even_motion_does_what_it_does_at_rest():
    """The contacts that carry the load take part, and they move."""
    steady = np.array([0.7, -0.4, 1.1])
    load = {
        'name': 'load', 'shape': {'type': 'box', 'size': [0.4, 0.4, 0.2]}, 'mass': 1.0,
        'initial': {'position': [0, 0, 0.1]},
    }  # fmt: skip
    still = [
        {'name': 'driven', 'shape': DECK, 'fixed': True, 'initial': {'position': [0, 0, -0.25]}},
        load,
        ball(0.6, velocity=(0.3, 0.2, -1.0), turn=(3.0, -5.0, 1.0), x=0.05),
    ]
    moved = copy.deepcopy(still)
    del moved[0]['fixed']
    moved[0]['motion'] = {}
    for body in moved:
        velocity = np.array(body['initial'].get('velocity', [0, 0, 0])) + steady
        body['initial']['velocity'] = velocity.tolist()
    still, moved = simulation(*still), simulation(*moved)
    joint = 0
    for _ in range(60):
        still.step()
        moved.step()
        joint += np.count_nonzero(still.impacts().kind == 2)
        # what sinks, or slips, meanwhile differs by the last digits of the places
        assert moved.state.velocity[1:3] - steady == pytest.approx(
            still.state.velocity[1:3], abs=1e-5
        )
    assert joint > 1


@pytest.mark.parametrize('draws', [3, pytest.param(20, marks=pytest.mark.long)])
def test_what_does_not_bounce_comes_down_on_an_even_motion_at_the_instant_of_one_at_rest(draws):
    """Also where it sticks to an edge, with next to no approach after its impact."""
    rng, steady = np.random.default_rng(2), np.array([1.3, -0.7, 0.4])
    for _ in range(draws):
        turns = rng.normal(size=(2, 4))
        slab, attitude = (turns / np.linalg.norm(turns, axis=1)[:, None]).tolist()
        mu = float(rng.choice([0.0, 0.5]))
        still = [
            {'name': 'slab', 'shape': {'type': 'box', 'size': [0.6, 0.6, 0.4]}, 'fixed': True,
             'friction': mu, 'initial': {'position': [0, 0, 0], 'orientation': slab}},
            {'name': 'body', 'shape': {'type': 'box', 'size': rng.uniform(0.1, 0.4, 3).tolist()},
             'mass': 1.0, 'friction': mu, 'initial': {
                 'position': [*rng.uniform(-0.2, 0.2, 2).tolist(), 0.8], 'velocity': [0, 0, -1],
                 'orientation': attitude, 'angular_velocity': (3 * rng.normal(size=3)).tolist()}},
        ]  # fmt: skip
        moved = copy.deepcopy(still)
        del moved[0]['fixed']
        moved[0]['motion'] = {}
        for body in moved:
            velocity = steady + body['initial'].get('velocity', np.zeros(3))
            body['initial']['velocity'] = velocity.tolist()
        still, moved = simulation(*still), simulation(*moved)
        seen = 0
        while not seen and still.time < 0.5:
            still.step()
            moved.step()
            seen = len(still.impacts())
            assert len(moved.impacts()) == seen
        if seen:
            assert still.impacts().time == pytest.approx(moved.impacts().time, abs=1e-12)
            assert still.impacts().impulse == pytest.approx(moved.impacts().impulse, abs=1e-11)
            # the rest of the tick is the solver's, to the tolerance of its passes
            velocity = moved.state.velocity[1] - steady
            assert velocity == pytest.approx(still.state.velocity[1], abs=1e-4)


@pytest.mark.parametrize('motion', ['heave', 'pitch'])
def test_the_balance_has_the_work_of_impacts_on_what_is_moved_as_told(motion):
    amplitude = 0.02 if motion == 'heave' else 0.1
    deck = {
        'name': 'driven', 'shape': DECK, 'restitution': 1.0,
        'motion': {motion: {'amplitude': amplitude, 'period': 0.3}},
        'initial': {'position': [0, 0, -0.25]},
    }  # fmt: skip
    sim = simulation(deck, ball(0.5, x=1.0, e=1.0, mu=0.0))
    sim.keep_energy_balance()
    sim.step(150)
    balance = sim.energy_balance()
    assert balance.work_of_drives > 2.0
    assert abs(balance.unexplained) < 1e-11


@pytest.mark.parametrize('how', ['belt', 'deck'])
def test_what_falls_flat_on_tiles_that_move_as_one_does_not_turn(how):
    """All of its corners strike at one instant, on whichever tile they are."""
    told = {'belt': {'fixed': True, 'surface_velocity': [0, 0.5, 0]}, 'deck': {'motion': {}}}[how]
    tiles = []
    for k, (x, y) in enumerate([(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)]):
        tile = {'name': f'tile_{k}', 'shape': {'type': 'box', 'size': [1, 1, 0.5]},
                'friction': 0.0, 'initial': {'position': [x, y, -0.25]}, **told}  # fmt: skip
        if how == 'deck':
            tile['initial']['velocity'] = [0.2, 0.5, 0]
        tiles.append(tile)
    box = {
        'name': 'box', 'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]}, 'mass': 1.0,
        'restitution': 0.5, 'friction': 0.0, 'initial': {'position': [0.03, -0.02, 0.15]},
    }  # fmt: skip
    sim = simulation(*tiles, box)
    while not len(sim.impacts()):
        sim.step()
    assert sim.state.angular_velocity[4] == pytest.approx(np.zeros(3), abs=1e-12)
    assert sim.state.velocity[4, 2] > 0.4


@pytest.mark.parametrize('shape', ['box', 'puck'])
def test_what_slides_over_flush_tiles_is_struck_by_none(shape):
    """It sinks in by some 1e-7 m, and what is ahead is a wall as high as that: it was stopped."""
    tiles = [
        {'name': f'tile_{k}', 'shape': {'type': 'box', 'size': [1, 4, 0.5]}, 'friction': 0.0,
         'fixed': True, 'initial': {'position': [x, 0, -0.25]}}
        for k, x in enumerate((-0.5, 0.5))
    ]  # fmt: skip
    load = ball(0.1, velocity=(1.5, 0.4, 0), turn=(0, 0, 2.0), mu=0.0, e=0.0, x=-0.145)
    load['shape'] = {'type': 'box', 'size': [0.2, 0.2, 0.2]}
    if shape == 'puck':
        load['shape'] = {'type': 'cylinder', 'radius': 0.12, 'length': 0.2}
    sim = simulation(*tiles, load)
    for _ in range(20):
        sim.step()
        assert len(sim.impacts()) == 0
    assert sim.state.velocity[2] == pytest.approx([1.5, 0.4, 0], abs=1e-12)
    assert sim.state.angular_velocity[2] == pytest.approx([0, 0, 2.0], abs=1e-12)
