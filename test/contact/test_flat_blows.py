# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Blows of flat faces: whatever a face is made of, and whatever lies on it, a blow through the centre
of mass turns nothing. With `contact: {mode: event}` Newton's rule holds to the last digits.
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


@pytest.mark.parametrize('seed', seeds(4, 80))
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


def in_ticks(bodies, dropped, ticks):
    """The largest turn of the last bodies of a scene in a tick, mode `timestep` [rad/s]."""
    sim = Simulation(
        load_scene({
            'version': 1, 'name': 'flat', 'dt': DT, 'gravity': [0, 0, -9.81],
            'contact': {'mode': 'timestep'}, 'bodies': bodies,
        })
    )  # fmt: skip
    worst = 0.0
    for _ in range(ticks):
        sim.step()
        worst = max(worst, np.abs(sim.state.angular_velocity_body[-dropped:]).max())
    return worst, sim


def dropped_flat(rng, e, count=1):
    """Prisms one on another, that come down with their axes upright."""
    mu, speed, height = rng.choice([0.0, 0.5, 1.0]), rng.uniform(0.2, 3), rng.uniform(1e-3, 0.05)
    up = turn_about((0, 1, 0), -np.pi / 2)  # x of the frame is up
    bodies = []
    for number in range(count):
        body, thick = flying(rng, f'body{number}', height, -speed, up, e)
        if count > 1:
            while body['shape']['type'] in ('union', 'convex_hull'):
                body, thick = flying(rng, f'body{number}', height, -speed, up, e)
        body['friction'] = float(mu)
        bodies.append(body)
        height += thick + float(rng.choice([0.0, 0.01]))
    return bodies, float(mu)


def tiles_of(side, e, mu):
    """A floor of 49 square tiles with its middle at the origin."""
    return [
        {'name': f'tile{i}_{j}', 'shape': {'type': 'box', 'size': [side, side, 0.5]},
         'fixed': True, 'restitution': e, 'friction': mu,
         'initial': {'position': [side * (i - 3), side * (j - 3), -0.25]}}
        for i in range(7) for j in range(7)
    ]  # fmt: skip


# ticks: for several blows, and for what does not bounce to come to rest
TICKS = 75
E = 0.0, 0.5, 1.0


@pytest.mark.parametrize('e', E)
@pytest.mark.parametrize('seed', seeds(4, 60))
def test_tiles_turn_nothing_that_falls_flat_on_them_in_ticks(seed, e):
    """
    Boxes, cans, prisms and bodies of three parts, over joints of up to 49 tiles, or half on them;
    by no blow, nor where they come to rest.
    """
    rng = np.random.default_rng(seed)
    bodies, mu = dropped_flat(rng, e)
    bodies[0]['initial']['position'][:2] = rng.uniform(-0.3, 0.3, 2).tolist()
    tiles = tiles_of(rng.uniform(0.1, 0.5), e, mu)
    worst, sim = in_ticks([*tiles, *bodies], 1, TICKS)
    assert worst < 1e-9
    if e == 0.0:
        assert np.abs(sim.state.velocity[-1]).max() < 1e-6  # and it has come to rest


@pytest.mark.parametrize('e', E)
@pytest.mark.parametrize('seed', [*seeds(4, 60), 109])
def test_a_stack_that_falls_flat_is_not_turned_in_ticks(seed, e):
    """
    Two to four on a plane, each turned as it likes about the upright, with masses to 1:100. In
    that of seed 109 impulses go ahead by which one point would let go before the others.
    """
    rng = np.random.default_rng(seed)
    bodies, mu = dropped_flat(rng, e, count=int(rng.integers(2, 5)))
    ground = {
        'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': 0},
        'restitution': e, 'friction': mu,
    }  # fmt: skip
    worst, _ = in_ticks([ground, *bodies], len(bodies), TICKS)
    assert worst < 1e-9


@pytest.mark.parametrize('e', E)
@pytest.mark.parametrize('seed', [*seeds(4, 60), 156])
def test_a_prism_that_falls_flat_on_a_plane_is_not_turned_in_ticks(seed, e):
    """
    Of three to nine corners, from near and from afar: of those of a face that is still apart, no
    four are chosen on one side, as in that of seeds 0 and 156; and it gives way as a whole.
    """
    rng = np.random.default_rng(seed)
    count, wide, thick = int(rng.integers(3, 10)), *rng.uniform(0.05, 0.4, 2)
    ring = [(wide * np.cos(a), wide * np.sin(a)) for a in np.arange(count) * 2 * np.pi / count]
    vertices = [[*map(float, p), float(z)] for z in (-thick / 2, thick / 2) for p in ring]
    ground = {
        'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': 0},
        'restitution': e,
    }  # fmt: skip
    body = {
        'name': 'body', 'restitution': e, 'mass': 1.0,
        'shape': {'type': 'convex_hull', 'vertices': vertices},
        'initial': {
            'position': [0, 0, float(thick / 2 + rng.uniform(1e-3, 0.05))],
            'orientation': turn_about((0, 0, 1), rng.uniform(-3, 3)).tolist(),
            'velocity': [0, 0, -float(rng.uniform(0, 3))],
        },
    }  # fmt: skip
    worst, _ = in_ticks([ground, body], 1, TICKS)
    assert worst < 1e-9


def bouncing_prisms(rng, e, mu, corners):
    """
    Two or three prisms of unlike masses, each over the other as it stands or turned, that come
    down with their axes upright.
    """
    wide, thick = rng.uniform(0.05, 0.3, 2)
    angles = np.arange(corners) * 2 * np.pi / corners
    ring = [(wide * np.cos(a), wide * np.sin(a)) for a in angles]
    vertices = [[*map(float, p), float(z)] for z in (-thick / 2, thick / 2) for p in ring]
    bodies, turn, height = [], rng.uniform(-3, 3), rng.uniform(1e-3, 0.1)
    speed, place = float(rng.uniform(0, 2)), rng.uniform(-0.2, 0.2, 2).tolist()
    for number in range(int(rng.integers(2, 4))):
        turn = turn if rng.random() < 0.6 else rng.uniform(-3, 3)
        bodies.append({
            'name': f'body{number}', 'restitution': e, 'friction': mu,
            'mass': float(10 ** rng.uniform(-0.5, 0.5)),
            'shape': {'type': 'convex_hull', 'vertices': vertices},
            'initial': {
                'position': [*place, float(height + thick / 2)],
                'orientation': turn_about((0, 0, 1), turn).tolist(),
                'velocity': [0, 0, -speed],
            },
        })  # fmt: skip
        height += thick + rng.choice([0.0, 0.01, 0.2])
    return bodies


@pytest.mark.parametrize('floor', ['plane', 'block'])
@pytest.mark.parametrize('seed', seeds(6, 80))
def test_prisms_of_odd_corners_that_bounce_on_one_another_are_not_turned(seed, floor):
    """
    Of five, seven or nine: not as one bounces off another that bears it, nor where they come to
    rest. Each is held at four corners, which do not lie evenly about its middle.
    """
    rng = np.random.default_rng(seed)
    corners, e, mu = int(rng.choice([5, 7, 9])), float(rng.uniform(0, 0.7)), rng.choice([0.0, 0.5])
    ground = {'name': 'ground', 'restitution': e, 'friction': float(mu)}
    if floor == 'plane':
        ground |= {'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': 0}}
    else:
        ground |= {'shape': {'type': 'box', 'size': [9, 9, 1]}, 'fixed': True,
                   'initial': {'position': [0, 0, -0.5]}}  # fmt: skip
    bodies = bouncing_prisms(rng, e, float(mu), corners)
    worst, _ = in_ticks([ground, *bodies], len(bodies), 2 * TICKS)
    assert worst < 1e-9


@pytest.mark.parametrize('seed', seeds(6, 80))
def test_boxes_that_bounce_on_one_another_on_tiles_are_not_turned(seed):
    """
    Over joints of many tiles, of which some bear a sliver: it holds up no more than its part. Of
    what has odd corners or a rim one in ten turns by more: see docs/contact.md.
    """
    rng = np.random.default_rng(seed)
    e, mu, side = float(rng.uniform(0, 0.7)), float(rng.choice([0.0, 0.5])), rng.uniform(0.15, 0.5)
    tiles = tiles_of(side, e, mu)
    bodies = bouncing_prisms(rng, e, mu, 4)
    worst, _ = in_ticks([*tiles, *bodies], len(bodies), 2 * TICKS)
    # passes end where they change less than 1e-7 m/s, here some 0.1 m from the middle
    assert worst < 1e-6


@pytest.mark.parametrize('e', E)
@pytest.mark.parametrize('seed', seeds(4, 60))
def test_what_falls_flat_over_an_edge_is_not_turned_in_ticks(seed, e):
    """A box of which a part comes down on a block, with its middle over it: not by any blow."""
    rng = np.random.default_rng(seed)
    wide, deep = rng.uniform(0.05, 0.4, 2)
    block = {
        'name': 'block', 'shape': {'type': 'box', 'size': [2 * wide, 2 * deep, 0.5]},
        'fixed': True, 'restitution': e, 'initial': {'position': [0, 0, -0.25]},
    }  # fmt: skip
    size = rng.uniform(0.1, 0.8, 3)
    at = [*(rng.uniform(-0.85, 0.85, 2) * (wide, deep)), size[2] / 2 + rng.uniform(1e-3, 0.05)]
    body = {
        'name': 'body', 'restitution': e, 'mass': 1.0,
        'shape': {'type': 'box', 'size': size.tolist()},
        'initial': {
            'position': [float(x) for x in at],
            'orientation': turn_about((0, 0, 1), rng.uniform(-3, 3)).tolist(),
            'velocity': [0, 0, -float(rng.uniform(0, 3))],
        },
    }  # fmt: skip
    worst, _ = in_ticks([block, body], 1, TICKS)
    assert worst < 1e-9


FEET = [[-0.2, -0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [0.2, 0.15, 0.0]]
FOOT = {
    'ball': {'type': 'sphere', 'radius': 0.05},
    'pill': {'type': 'capsule', 'radius': 0.05, 'length': 0.3},
    'block': {'type': 'box', 'size': [0.1, 0.1, 0.1]},
}


@pytest.mark.parametrize('e', [0.0, 0.5])
@pytest.mark.parametrize('foot', FOOT)
def test_what_lands_on_four_feet_is_not_turned_in_ticks(foot, e):
    """Feet of one point, of a line and of a face, on one plane."""
    lying = turn_about((0, 1, 0), np.pi / 2).tolist() if foot == 'pill' else [0, 0, 0, 1]
    parts = [
        {'shape': FOOT[foot], 'position': at, 'orientation': lying, 'mass': 1.0} for at in FEET
    ]
    ground = {
        'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': 0},
        'restitution': e,
    }  # fmt: skip
    body = {
        'name': 'body', 'restitution': e, 'shape': {'type': 'union', 'parts': parts},
        'initial': {'position': [0, 0, 0.1], 'velocity': [0, 0, -1]},
    }  # fmt: skip
    worst, _ = in_ticks([ground, body], 1, 40)
    assert worst < 1e-9
