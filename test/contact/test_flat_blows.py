# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Blows of flat faces with `contact: {mode: event}`: whatever a face is made of, a blow through the
centre of mass turns nothing, and Newton's rule holds.
"""

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene

DT = 0.004  # [s]
TURNED = 1e-10  # [rad/s] round-off of a gap over the approach, at 0.1 m/s
LAW = 1e-10  # [-] the same of a velocity


def seeds(few, many):
    return [*range(few), *(pytest.param(i, marks=pytest.mark.long) for i in range(few, many))]


def times(p, q):
    """The quaternion product p q, (x, y, z, w)."""
    v, w = np.array(p[:3]), p[3]
    u, s = np.array(q[:3]), q[3]
    return np.append(w * u + s * v + np.cross(v, u), w * s - v @ u)


def rotated(q, vector):
    v = np.asarray(q[:3])
    return vector + 2 * np.cross(v, np.cross(v, vector) + q[3] * np.asarray(vector))


def turn_about(axis, angle):
    return np.append(np.sin(angle / 2) * np.array(axis, dtype=float), np.cos(angle / 2))


def prism(rng):
    """A body with two faces across its x, about its middle: shape, thickness, its own turn."""
    thick, wide, deep = rng.uniform(0.05, 0.4, 3)
    kind = rng.choice(['box', 'cylinder', 'convex_hull', 'union'])
    turn = (0.0, 0.0, 0.0, 1.0)
    if kind == 'box':
        shape = {'size': [thick, wide, deep]}
    elif kind == 'cylinder':
        shape, turn = {'radius': wide, 'length': thick}, turn_about((0, 1, 0), np.pi / 2)
    elif kind == 'convex_hull':
        count = int(rng.integers(3, 8))
        ring = [(wide * np.cos(a), wide * np.sin(a)) for a in np.arange(count) * 2 * np.pi / count]
        shape = {'vertices': [[x, *map(float, p)] for x in (-thick / 2, thick / 2) for p in ring]}
    else:
        part = {'type': 'box', 'size': [thick, wide, deep]}
        places = ([0, -wide, 0], [0, 0, 0], [0, wide, 0])
        shape = {'parts': [{'shape': part, 'position': at, 'mass': 1.0} for at in places]}
    return {'type': str(kind), **shape}, thick, turn


def flying(rng, name, x, velocity, frame, e):
    """A prism at a place along the normal of a frame, turned about it; and its thickness."""
    shape, thick, own = prism(rng)
    turn = times(frame, times(turn_about((1, 0, 0), rng.uniform(-3, 3)), own))
    body = {
        'name': name, 'shape': shape, 'restitution': e, 'friction': rng.choice([0.0, 0.5]),
        'initial': {
            'position': rotated(frame, [x + thick / 2, 0, 0]).tolist(),
            'orientation': turn.tolist(),
            'velocity': rotated(frame, [velocity, 0, 0]).tolist(),
        },
    }  # fmt: skip
    if shape['type'] != 'union':
        body['mass'] = float(10 ** rng.uniform(-1, 1))
    return body, thick


def drawn(seed):
    rng = np.random.default_rng(seed)
    frame = rng.normal(size=4)
    frame /= np.linalg.norm(frame)
    e = float(rng.choice([0.0, 0.5, 0.9, 0.99, 1.0]))
    approach, gap = rng.uniform(0.1, 5), rng.uniform(1e-3, 0.05)
    return rng, frame, e, approach, gap


def after_the_blow(bodies, gap, approach, gravity=(0, 0, 0)):
    sim = Simulation(
        load_scene({
            'version': 1, 'name': 'flat', 'dt': DT, 'gravity': list(gravity),
            'contact': {'mode': 'event'}, 'bodies': bodies,
        })
    )  # fmt: skip
    sim.step(int(gap / approach / DT) + 2)
    return sim


@pytest.mark.parametrize('seed', seeds(8, 80))
def test_what_a_moving_wall_bats_flat_is_not_turned(seed, plain_source):
    """v' = w + e (w - v), at any speed of the wall, e and shape."""
    rng, frame, e, approach, gap = drawn(seed)
    wall_speed = rng.uniform(-5, 10)
    body, _ = flying(rng, 'body', 0.1 + gap, wall_speed - approach, frame, e)
    wall = {
        'name': 'wall', 'shape': {'type': 'box', 'size': [0.2, 3, 3]}, 'motion': {},
        'initial': {
            'orientation': frame.tolist(),
            'velocity': rotated(frame, [wall_speed, 0, 0]).tolist(),
        },
    }  # fmt: skip
    sim = after_the_blow([wall, body], gap, approach)
    law = rotated(frame, [wall_speed + e * approach, 0, 0])
    assert sim.state.velocity[1] == pytest.approx(law, abs=LAW * (approach + abs(wall_speed)))
    assert np.abs(sim.state.angular_velocity_body[1]).max() < TURNED


@pytest.mark.parametrize('seed', seeds(8, 80))
def test_two_that_meet_flat_in_flight_are_not_turned(seed):
    """Momentum stays, and v_B' - v_A' = -e (v_B - v_A)."""
    rng, frame, e, approach, gap = drawn(seed)
    speed = rng.uniform(-2, 2)
    first, thick = flying(rng, 'first', 0.0, speed, frame, e)
    second, _ = flying(rng, 'second', thick + gap, speed - approach, frame, e)
    sim = after_the_blow([first, second], gap, approach)
    masses = np.array([body.mass for body in sim.scene.bodies])
    mean = (masses @ [speed, speed - approach]) / masses.sum()
    share = e * approach * masses[::-1] / masses.sum()
    for place, law in enumerate((mean - share[0], mean + share[1])):
        expected = rotated(frame, [law, 0, 0])
        assert sim.state.velocity[place] == pytest.approx(expected, abs=LAW * (approach + 2))
        assert np.abs(sim.state.angular_velocity_body[place]).max() < TURNED


@pytest.mark.parametrize('seed', seeds(6, 60))
def test_what_falls_flat_on_flush_tiles_falls_as_on_one(seed):
    """Three tiles, of which the body meets one, two or three at once."""
    rng, _, e, approach, gap = drawn(seed)
    up = turn_about((0, 1, 0), -np.pi / 2)  # x of the frame is up
    body, _ = flying(rng, 'body', gap, -approach, up, e)
    body['initial']['position'][0] = rng.uniform(-0.5, 0.5)
    shape = {'type': 'box', 'size': [0.4, 5, 1]}
    tiles = [
        {'name': f'tile{i}', 'shape': shape, 'fixed': True,
         'initial': {'position': [0.4 * (i - 2), 0, -0.5]}}
        for i in range(5)
    ]  # fmt: skip
    sim = after_the_blow([*tiles, body], gap, approach)
    law = [0.0, 0.0, e * approach]
    assert sim.state.velocity[-1] == pytest.approx(law, abs=LAW * approach)
    assert np.abs(sim.state.angular_velocity_body[-1]).max() < TURNED


@pytest.mark.parametrize('seed', seeds(6, 60))
def test_what_flies_flat_between_two_walls_goes_on_flat(seed):
    """Its speed is e^n v after n blows; round-off of each is turned into a tilt by the next."""
    rng, frame, _, _, room = drawn(seed)
    e, speed = float(rng.choice([0.9, 1.0])), 2.0
    body, thick = flying(rng, 'body', 0.0, speed, frame, e)
    walls = [
        {'name': name, 'shape': {'type': 'box', 'size': [0.2, 3, 3]}, 'fixed': True,
         'initial': {'position': rotated(frame, [x, 0, 0]).tolist(),
                     'orientation': frame.tolist()}}
        for name, x in (('left', -0.1 - room), ('right', 0.1 + thick + room))
    ]  # fmt: skip
    sim = after_the_blow([*walls, body], 20 * room, speed)
    left, blows = np.linalg.norm(sim.state.velocity[-1]), 0
    while e < 1.0 and left < speed * e**blows * (1 - 1e-9):
        blows += 1
    assert left == pytest.approx(speed * e**blows, rel=1e-9)
    assert np.abs(sim.state.angular_velocity_body[-1]).max() < 1e-9


@pytest.mark.parametrize('seed', seeds(6, 60))
def test_what_falls_flat_on_a_body_that_rests_leaves_it_flat_with_e_v(seed):
    """With e = 0 it would stay, and belong to the solver."""
    rng, _, e, _, height = drawn(seed)
    e = e or 0.8
    up = turn_about((0, 1, 0), -np.pi / 2)
    body, _ = flying(rng, 'body', 0.5 + height, 0.0, up, e)
    body['initial']['position'][:2] = rng.uniform(-0.2, 0.2, 2)
    ground = {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': 0}}
    base = {
        'name': 'base', 'mass': 5.0, 'shape': {'type': 'box', 'size': [3, 3, 0.5]},
        'initial': {'position': [0, 0, 0.25]},
    }  # fmt: skip
    sim = after_the_blow([ground, base, body], -2 * DT, 1.0, gravity=(0, 0, -9.81))
    while not len(sim.impacts()):
        assert sim.time < 1.0
        sim.step()
    struck = sim.impacts().time[0]
    law = e * 9.81 * struck - 9.81 * (sim.time - struck)
    assert sim.state.velocity[-1] == pytest.approx([0, 0, law], abs=1e-9)
    assert np.abs(sim.state.angular_velocity_body[-1]).max() < 1e-9
