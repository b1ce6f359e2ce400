# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the points of a manifold carry is not lost where others stand for them in the next tick.
"""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision import manifold_record, pose
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    cache_record,
    constraint,
    contact_point,
    lost_points,
)

RADIUS = 0.1  # [m] of the bodies
WIDTH = contact_point.SIZE
G = 9.81
NORMAL, TANGENT_1, TANGENT_2 = np.eye(3)[[2, 0, 1]]


def passed_on(points, gaps, impulses, lost, press, friction):
    """
    Impulses (n, 3) along normal and tangents of the points of a manifold, after what one point of
    the cache held has been passed on to them.
    """
    rows = np.zeros(constraint.SIZE + 5 * WIDTH)
    for field, axis in (
        (constraint.NORMAL, NORMAL),
        (constraint.TANGENT_1, TANGENT_1),
        (constraint.TANGENT_2, TANGENT_2),
    ):
        rows[field : field + 3 * constraint.LANES : constraint.LANES] = axis
    manifolds = np.zeros(manifold_record.SIZE)
    manifolds[manifold_record.POINT_COUNT] = len(points)
    for k, (point, gap, impulse) in enumerate(zip(points, gaps, impulses)):
        found = manifold_record.POINTS + k * manifold.POINT
        manifolds[found : found + 3] = point
        manifolds[found + manifold.SEPARATION] = gap
        row = constraint.SIZE + k * WIDTH + contact_point.NORMAL_IMPULSE
        rows[row : row + 3 * constraint.LANES : constraint.LANES] = impulse
    poses = np.zeros(pose.SIZE)
    poses[[pose.ROW_X, pose.ROW_Y + 1, pose.ROW_Z + 2]] = 1.0
    cache = np.zeros(cache_record.HEAD + cache_record.MOST_OF_MANIFOLD)
    cache[cache_record.HEAD + cache_record.POINTS] = 1.0
    place = cache_record.HEAD + cache_record.MANIFOLD_HEAD
    cache[place + cache_record.NORMAL_IMPULSE] = press
    cache[place + cache_record.FRICTION_IMPULSE :][:3] = friction
    cache[place + cache_record.ANCHOR :][:3] = lost
    lost_points.pass_on(
        0, cache_record.HEAD, 0, WIDTH, 1.0, RADIUS, argument(poses), argument(manifolds),
        argument(cache), argument(rows),
    )  # fmt: skip
    first, end = constraint.SIZE + contact_point.NORMAL_IMPULSE, 3 * constraint.LANES
    of_points = [rows[first + k * WIDTH :][: end : constraint.LANES] for k in range(len(points))]
    return np.array(of_points)


def wrench(points, impulses):
    """Force and torque of impulses along normal and tangents at some points."""
    impulses = np.atleast_2d(impulses) @ np.array([NORMAL, TANGENT_1, TANGENT_2])
    return impulses.sum(axis=0), np.cross(np.atleast_2d(points), impulses).sum(axis=0)


@pytest.mark.parametrize('count', [2, 3, 4])
def test_force_and_torque_of_a_lost_point_are_kept(count):
    rng = np.random.default_rng(count)
    seen = 0
    for _ in range(300):
        points = np.column_stack((rng.uniform(-0.1, 0.1, (count, 2)), np.zeros(count)))
        spread = np.linalg.svd(points[:, :2] - points[:, :2].mean(axis=0))[1]
        if count > 2 and spread[1] < 0.01:  # as good as a line
            continue
        share = rng.dirichlet(np.ones(count))
        lost = share @ points  # among the others: no point would pull
        impulses = rng.uniform(0.5, 1.0, (count, 3))
        friction = np.array([*rng.uniform(-0.3, 0.3, 2), 0.0])
        found = passed_on(points, np.zeros(count), impulses, lost, 0.4, friction)
        before = [wrench(points, impulses), wrench(lost, [0.4, friction[0], friction[1]])]
        wanted = np.add(*before)
        if np.abs(found[:, 0] - impulses[:, 0]).max() < 0.4:  # no weight was cut
            seen += 1
            assert np.allclose(wrench(points, found), wanted, rtol=0.0, atol=1e-12)
        assert np.allclose(found.sum(axis=0), wanted[0][[2, 0, 1]], rtol=0.0, atol=1e-12)
    assert seen > 100


def test_a_lost_point_leaves_nothing_to_points_that_are_apart():
    points = np.array([[0.1, 0, 0], [-0.1, 0, 0], [0, 0.1, 0.0], [0, -0.1, 0.0]])
    impulses = np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 0, 0], [0, 0, 0]])
    found = passed_on(points, [0, 0, 1e-3, 1e-3], impulses, [0.05, 0.02, 0], 0.5, np.zeros(3))
    assert np.all(found[2:] == 0.0)
    assert np.allclose(found[:2, 0], [1.375, 1.125], rtol=0.0, atol=1e-12)


def test_no_point_pulls_and_as_much_presses_as_before():
    rng = np.random.default_rng(7)
    for _ in range(200):
        points = np.column_stack((rng.uniform(-0.1, 0.1, (4, 2)), np.zeros(4)))
        impulses = np.column_stack((rng.uniform(0.0, 0.2, 4), np.zeros((4, 2))))
        lost = np.array([*rng.uniform(-0.2, 0.2, 2), 0.0])
        found = passed_on(points, np.zeros(4), impulses, lost, 1.0, np.zeros(3))
        assert np.all(found[:, 0] >= 0.0)
        assert math.isclose(found[:, 0].sum(), impulses[:, 0].sum() + 1.0, rel_tol=1e-12)


def prism(corners):
    """A prism that stands, of 1 kg and 0.1 m."""
    angles = 2.0 * np.pi * np.arange(corners) / corners
    vertices = [
        [RADIUS * math.cos(a), RADIUS * math.sin(a), z] for a in angles for z in (-0.05, 0.05)
    ]
    return {
        'name': 'prism',
        'shape': {'type': 'convex_hull', 'vertices': vertices},
        'mass': 1.0,
        'friction': 0.5,
        'initial': {'position': [0.0, 0.0, 0.05]},
    }


def scene(*bodies):
    return load_scene(
        {
            'version': 1,
            'name': 'points',
            'dt': 0.004,
            'gravity': [0.0, 0.0, -G],
            'contact': {'mode': 'timestep'},
            'bodies': list(bodies),
        }
    )


@pytest.mark.parametrize('corners', [5, 6, 9])
def test_a_prism_keeps_its_weight_on_the_ground_under_a_torque_that_goes_round(corners):
    # A torque of half of what tips it goes round; the four corners that stand for all of five
    # change with it. Where what they carried was lost, the force fell by 28 % for a tick; a
    # pentagon still rocks by micrometres, as no four of its corners span it.
    block = {
        'name': 'block',
        'shape': {'type': 'box', 'size': [1.0, 1.0, 0.2]},
        'fixed': True,
        'friction': 0.5,
        'initial': {'position': [0.0, 0.0, -0.1]},
    }
    simulation = Simulation(scene(block, prism(corners)))
    off = []
    for tick in range(500):
        angle = 2.0 * math.pi * 1.3 * 0.004 * tick
        torque = [0.4 * math.cos(angle), 0.4 * math.sin(angle), 0.0]
        simulation.set_wrench('prism', torque=torque)
        simulation.step()
        force, _ = simulation.contact_wrench('prism')
        off.append(abs(force[2] / G - 1.0))
    assert max(off[100:]) < (0.1 if corners == 5 else 1e-5)


def test_a_ladder_sinks_in_no_deeper_than_what_stands_on_all_points():
    # Two of the four points of each manifold press. The sink of the contact is taken out by the
    # load of those: of all four, half of it was left, 0.5 um.
    lean = math.radians(25.0)
    along = np.array([math.sin(lean), 0.0, math.cos(lean)])
    across = np.array([math.cos(lean), 0.0, -math.sin(lean)])
    corners = np.array([s * 0.004 * across + t * 0.5 * along for s in (-1, 1) for t in (-1, 1)])
    floor = {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.8}
    wall = {
        'name': 'wall',
        'shape': {'type': 'box', 'size': [0.2, 2.0, 3.0]},
        'fixed': True,
        'friction': 0.8,
        'initial': {'position': [0.1, 0.0, 1.5]},
    }
    ladder = {
        'name': 'ladder',
        'shape': {'type': 'box', 'size': [0.008, 0.1, 1.0]},
        'mass': 2.0,
        'friction': 0.8,
        'initial': {
            'position': [-corners[:, 0].max(), 0.0, -corners[:, 2].min()],
            'orientation': [0.0, math.sin(0.5 * lean), 0.0, math.cos(0.5 * lean)],
        },
    }
    simulation = Simulation(scene(floor, wall, ladder))
    simulation.step(1000)
    assert np.abs(simulation.state.velocity).max() < 1e-9
    assert simulation.contacts().gap.min() > -0.05e-6
