# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts on ground of triangles with `contact: {mode: event}`, at ticks of 4 ms: on a flat part as
on a plane, whatever the triangles are; on an edge or a corner along the normal that it has there.

Every scene has the same kinds of bodies, so that all share one kernel: two witnesses fall far
away, and what a scene has not of plane and ground lies far below.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import collision
from rigid_body_sim.physics.model.shapes import Surface
from rigid_body_sim.physics.state.impacts import KINDS

GRAVITY = 9.81  # [m/s^2]
DT = 0.004  # [s]
RADIUS = 0.1  # [m]
FAR = 1e6  # [m] the witnesses fall for longer than any run takes
BELOW = -1e5  # [m] nothing falls so far
WITNESSES = 4  # bodies of each scene that come first
FLAT = {'type': 'heightfield', 'spacing': 1.0, 'heights': [[0, 0], [0, 0]]}
TWO_SLOPES = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])  # faces of a ridge or valley
LOOKS_AT_RIDGE = 40
HALF = 3.0  # [m] of the side of a piece of ground


def ball(position, velocity=(0, 0, 0), *, e=1.0, mu=0.0, spin=(0, 0, 0), name='ball'):
    return _body(name, {'type': 'sphere', 'radius': RADIUS}, position, velocity, e, mu, spin)


def box(position, velocity=(0, 0, 0), *, e=1.0, mu=0.0, spin=(0, 0, 0), turn=(0, 0, 0, 1),
        name='box'):  # fmt: skip
    shape = {'type': 'box', 'size': [0.2, 0.3, 0.4]}
    found = _body(name, shape, position, velocity, e, mu, spin)
    found['initial']['orientation'] = [float(x) for x in turn]
    return found


def _body(name, shape, position, velocity, e, mu, spin):
    vectors = {'position': position, 'velocity': velocity, 'angular_velocity': spin}
    initial = {key: [float(x) for x in vector] for key, vector in vectors.items()}
    return {
        'name': name, 'mass': 1.0, 'restitution': e, 'friction': mu, 'shape': shape,
        'initial': initial,
    }  # fmt: skip


def world(*bodies, ground=None, plane=None, mu=0.0, mode='event', forces=()):
    """
    Start bodies over ground, a `Surface` or the shape of a scene; or over a plane, a unit normal.
    """
    of_scene = isinstance(ground, dict)
    normal = (0, 0, 1) if plane is None else plane
    flat = {'type': 'plane', 'normal': [float(x) for x in normal],
            'offset': BELOW if plane is None else 0}  # fmt: skip
    scene = load_scene({
        'version': 1, 'name': 'impacts_on_ground', 'dt': DT, 'gravity': [0, 0, -GRAVITY],
        'contact': {'mode': mode},
        'forces': list(forces),
        'bodies': [
            {'name': 'plane', 'shape': flat, 'friction': mu},
            {'name': 'ground', 'fixed': True, 'friction': mu,
             'shape': ground if of_scene else FLAT,
             'initial': {'position': [0, 0, 0 if of_scene else BELOW]}},
            ball((FAR, 0, FAR), mu=0.5, name='far_ball'), box((-FAR, 0, FAR), name='far_box'),
            *bodies,
        ],
    })  # fmt: skip
    if isinstance(ground, Surface):
        listed = list(scene.bodies)
        start = dataclasses.replace(listed[1].initial, position=(0.0, 0.0, 0.0))
        listed[1] = dataclasses.replace(listed[1], shape=ground, initial=start)
        scene = dataclasses.replace(scene, bodies=tuple(listed))
    return Simulation(scene)


def tiles(rng, *, count=30, half=HALF, height=lambda x, y: 0.0 * x):
    """
    A square of triangles about random points, which all face up.
    """
    corners = [[-half, -half], [half, -half], [-half, half], [half, half]]
    points = np.concatenate([corners, rng.uniform(-half, half, (count, 2))])
    faces = Delaunay(points).simplices
    sides = points[faces][:, 1:] - points[faces][:, :1]
    down = sides[:, 0, 0] * sides[:, 1, 1] < sides[:, 0, 1] * sides[:, 1, 0]
    faces[down] = faces[down][:, ::-1]
    return Surface(np.column_stack([points, height(*points.T)]), faces.astype(np.int64))


def rough(seed):
    """
    The shape of a bowl over a grid with heights at random, as a scene has it: no edge is flat.
    """
    x, y = np.meshgrid(*[np.linspace(-HALF, HALF, 21)] * 2)
    noise = np.random.default_rng(seed).normal(size=x.shape)
    heights = 0.15 * (x**2 + y**2) + 0.1 * noise
    return {
        'type': 'heightfield', 'spacing': 0.3, 'origin': [-HALF, -HALF, 0.0],
        'heights': heights.tolist(),
    }  # fmt: skip


def distance_from(ground, point):
    """
    Distance of a point from the nearest triangle, by brute force.
    """
    best = math.inf
    for a, b, c in ground.vertices[ground.faces]:
        normal = np.cross(b - a, c - a)
        inside = all(
            np.dot(np.cross(q - p, point - p), normal) >= 0 for p, q in ((a, b), (b, c), (c, a))
        )
        if inside:
            best = min(best, abs(np.dot(normal, point - a)) / np.linalg.norm(normal))
        for p, q in ((a, b), (b, c), (c, a)):
            share = np.clip(np.dot(point - p, q - p) / np.dot(q - p, q - p), 0, 1)
            best = min(best, float(np.linalg.norm(point - p - share * (q - p))))
    return best


def follow(sim, ticks):
    """
    Positions after each tick, and the impacts of all.
    """
    positions, found = [], []
    for _ in range(ticks):
        sim.step()
        positions.append(sim.state.position[WITNESSES:].copy())
        impacts = sim.impacts()
        found += list(zip(impacts.time, impacts.kind, impacts.approach, strict=True))
    return np.array(positions), found


# ---------------------------------------------------------------- a flat part is a plane


@pytest.mark.parametrize('e', [1.0, 0.8, 0.5])
def test_a_ball_bounces_on_tiled_ground_at_the_instants_of_the_closed_form(e):
    sim = world(ball((0.3, 0.2, 1 + RADIUS), e=e), ground=tiles(np.random.default_rng(1)))
    sim.step(1000)
    found = sim.impacts()
    found = found[found.kind == KINDS.index('impact')]
    law = collision.bounce_times(len(found), height=1.0, gravity=GRAVITY, restitution=e)
    assert len(found) >= {1.0: 4, 0.8: 10, 0.5: 12}[e]
    np.testing.assert_allclose(found.time, law, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize('e', [1.0, 0.8])
def test_a_ball_bounces_on_a_slope_of_triangles_as_on_a_plane(e):
    ground = tiles(np.random.default_rng(2), half=20.0, height=lambda x, y: 0.3 * x - 0.2 * y)
    normal = np.array([-0.3, 0.2, 1.0]) / math.sqrt(1.13)
    ends = [
        follow(world(ball((0.3, 0.2, 1.1), e=e), **over), 300)
        for over in ({'ground': ground}, {'plane': normal})
    ]
    (places, impacts), (law, impacts_of_law) = ends
    assert len(impacts) == len(impacts_of_law) > 0
    np.testing.assert_allclose(places, law, rtol=0, atol=1e-12)
    np.testing.assert_allclose([i[0] for i in impacts], [i[0] for i in impacts_of_law], atol=1e-12)


@pytest.mark.parametrize('seed', range(8))
def test_what_falls_on_tiles_at_random_moves_as_on_a_plane(seed):
    """Balls, tilted boxes and flat ones, e 0 to 1, smooth and rough; to the last digit."""
    rng = np.random.default_rng(seed)
    turn = rng.normal(size=4) if seed % 4 < 3 else np.array([0.0, 0.0, *rng.normal(size=2)])
    make = ball if seed % 4 == 0 else box
    more = {} if seed % 4 == 0 else {'turn': turn / np.linalg.norm(turn)}
    body = make(
        position=(*rng.uniform(-1, 1, 2), rng.uniform(0.4, 0.7)), velocity=rng.normal(size=3),
        e=float(rng.choice([0.0, 0.5, 1.0])), mu=float(rng.choice([0.0, 0.4])),
        spin=rng.normal(size=3) * (0 if seed % 4 == 3 else 3), **more,
    )  # fmt: skip
    ground = tiles(rng, count=int(rng.integers(3, 60)))
    places, impacts = follow(world(body, ground=ground, mu=0.4), 125)
    law, impacts_of_law = follow(world(body, plane=(0, 0, 1), mu=0.4), 125)
    assert len(impacts) == len(impacts_of_law)
    np.testing.assert_allclose(places, law, rtol=0, atol=1e-12)


def test_a_ball_that_rolls_over_tiles_meets_no_inner_edge():
    ground = tiles(np.random.default_rng(4), count=60)
    start = ball((-1, 0, RADIUS), (2, 0.3, 0), e=0.5, mu=0.4)
    places, impacts = follow(world(start, ground=ground, mu=0.4), 200)
    law, _ = follow(world(start, ground=ground, mu=0.4, mode='timestep'), 200)
    assert not impacts
    assert np.array_equal(places, law)


# ---------------------------------------------------------------- edges and corners


@pytest.mark.parametrize('beside', [0.0, 0.02, -0.05, 0.0699])
def test_a_ball_leaves_a_ridge_along_the_normal_between_edge_and_centre(beside):
    corners = [[-3, -3, -3], [0, -3, 0], [3, -3, -3], [-3, 3, -3], [0, 3, 0], [3, 3, -3]]
    ridge = Surface(np.array(corners, float), TWO_SLOPES)
    sim = world(ball((beside, 0.3, 0.5)), ground=ridge)
    _strikes_at(sim, np.array([beside, 0.3, 0.0]), (beside / RADIUS, 0.0), e=1.0)


@pytest.mark.parametrize('beside', [(0, 0), (0.02, 0.01), (0.03, -0.035)])
def test_a_ball_leaves_a_corner_along_the_normal_between_corner_and_centre(beside):
    corners = np.array([[0, 0, 0], [2, 2, -2], [-2, 2, -2], [-2, -2, -2], [2, -2, -2]], float)
    pyramid = Surface(corners, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]))
    sim = world(ball((*beside, 0.5), e=0.7), ground=pyramid)
    _strikes_at(sim, np.array([*beside, 0.0]), np.array(beside) / RADIUS, e=0.7)


@pytest.mark.parametrize('beside', ['nothing', pytest.param('drag', marks=pytest.mark.long)])
def test_an_edge_is_struck_where_it_crosses_the_ridge_it_falls_on(beside):
    """Also beside a force on something far away, with which ticks are cut at impacts."""
    drag = {'type': 'drag', 'body': 'far_ball', 'linear': 0.3}
    forces = [drag] if beside == 'drag' else []
    corners = [[-3, -3, -0.06], [0, -3, 0], [3, -3, -0.06]]
    corners += [[-3, 3, -0.06], [0, 3, 0], [3, 3, -0.06]]
    ridge = Surface(np.array(corners, float), TWO_SLOPES)
    for seed in range(LOOKS_AT_RIDGE):
        rng = np.random.default_rng(seed)
        heading, roll = rng.uniform(-0.4, 0.4), math.radians(rng.uniform(30, 60))
        turn = Rotation.from_euler('ZX', [heading, roll])  # the edges of 0.2 m are level
        spin = turn.apply(rng.normal(size=3) * [2.0, 0.02, 0.02])
        start = (rng.uniform(-0.02, 0.02), 0.0, rng.uniform(0.35, 0.45))
        falls = box(start, e=0.5, spin=spin, turn=turn.as_quat())
        sim = world(falls, ground=ridge, forces=forces)
        impacts = sim.impacts()
        while not len(impacts):
            sim.step()
            impacts = sim.impacts()
            assert sim.time < 0.3, seed
        np.testing.assert_allclose(impacts.point[0][[0, 2]], 0.0, rtol=0, atol=1e-9)


def _strikes_at(sim, under, across, e):
    """
    A ball that falls from 0.5 m meets once, at the instant and as the closed form says.

    across : horizontal part of the normal
    """
    normal = np.array([*across, math.sqrt(1 - across[0] ** 2 - across[1] ** 2)])
    drop = 0.5 - RADIUS * normal[2]
    instant = math.sqrt(2 * drop / GRAVITY)
    velocity = np.array([0, 0, -GRAVITY * instant])
    velocity -= (1 + e) * (velocity @ normal) * normal
    places, impacts = follow(sim, 85)
    assert len(impacts) == 1
    assert impacts[0][0] == pytest.approx(instant, abs=1e-12)
    since = 85 * DT - instant
    law = under + [0, 0, 0.5 - drop] + velocity * since - [0, 0, GRAVITY * since**2 / 2]
    np.testing.assert_allclose(places[-1][0], law, rtol=0, atol=1e-12)


@pytest.mark.parametrize('looks', [8, pytest.param(50, marks=pytest.mark.long)])
@pytest.mark.parametrize('make', [ball, box])
def test_what_bounces_over_rough_ground_keeps_its_energy_and_overlaps_nowhere(make, looks):
    ground = rough(7)
    sim = world(make((0.2, 0.1, 1.5), spin=(1, 2, 3)), ground=ground)
    energy, met = sim.energy(), 0
    for _ in range(looks):
        sim.step(50)  # 0.2 s
        met += len(sim.impacts())
        if make is ball:
            assert (
                distance_from(sim.scene.bodies[1].shape, sim.state.position[WITNESSES])
                > RADIUS - 1e-12
            )
    assert met > looks / 5
    assert sim.energy() == pytest.approx(energy, rel=1e-12)


def test_a_ball_in_a_valley_keeps_its_energy_over_10_s():
    corners = [[-3, -3, 3], [0, -3, 0], [3, -3, 3], [-3, 3, 3], [0, 3, 0], [3, 3, 3]]
    valley = Surface(np.array(corners, float), TWO_SLOPES)
    sim = world(ball((0.3, 0, 1.5)), ground=valley)
    energy = sim.energy()
    sim.step(2500)
    assert len(sim.impacts()) > 10
    assert sim.energy() == pytest.approx(energy, rel=1e-12)


# ---------------------------------------------------------------- with what rests, and bits


def test_a_ball_leaves_a_box_that_rests_on_ground_with_e_v():
    ground = tiles(np.random.default_rng(5), count=50)
    bodies = box((0, 0, 0.2), e=0.0, mu=0.4), ball((0.02, 0.03, 0.9), e=0.8)
    places, impacts = follow(world(*bodies, ground=ground, mu=0.4), 120)
    law, impacts_of_law = follow(world(*bodies, plane=(0, 0, 1), mu=0.4), 120)
    assert [KINDS[i[1]] for i in impacts] == [KINDS[i[1]] for i in impacts_of_law]
    np.testing.assert_allclose(places, law, rtol=0, atol=1e-9)  # sinks may differ by rounding
    strike = max(impacts, key=lambda impact: impact[2])
    assert KINDS[strike[1]] == 'joint'
    since = 120 * DT - strike[0]
    up = (places[-1][1][2] - 0.5 + GRAVITY * since**2 / 2) / since
    assert up == pytest.approx(0.8 * strike[2], abs=1e-5)  # the box stands 1e-6 m deep


def test_a_restored_run_and_a_run_beside_others_on_ground_have_the_same_bits(tmp_path):
    ground = rough(3)
    bodies = (
        box((0.2, 0.1, 1.5), spin=(1, 2, 3), e=0.5, mu=0.4), ball((0.5, 0.2, 0.9), e=0.7, mu=0.3),
    )  # fmt: skip
    sim = world(*bodies, ground=ground, mu=0.4)
    sim.step(100)
    sim.save(tmp_path / 'half')
    sim.step(150)
    assert len(sim.impacts()) > 3
    restored = Simulation.load(tmp_path / 'half')
    restored.step(150)
    more = world(*bodies, ball((-1.5, -1.5, 2), e=0.9, name='other'), ground=ground, mu=0.4)
    more.step(250)
    for other in (restored, more):
        assert np.array_equal(sim.state.position[WITNESSES:], other.state.position[4:6])
