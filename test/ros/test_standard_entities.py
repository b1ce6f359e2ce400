# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which bodies a client's filter means, judged without ROS: names, and what overlaps what.
"""

import ctypes
import random
import time

import numpy as np
import pytest

from rigid_body_sim import load_scene
from rigid_body_sim.physics.model.rotation import matrix_from_quaternion
from rigid_body_sim.ros.standard.extents import Pose, extent_of
from rigid_body_sim.ros.standard.posix_expressions import BadExpression, Expression

EXTENDED = 1  # REG_EXTENDED of POSIX


class Match(ctypes.Structure):
    """regmatch_t."""

    _fields_ = [('begin', ctypes.c_int), ('end', ctypes.c_int)]


def judged_by_libc(pattern, name):
    libc = ctypes.CDLL(None)
    compiled, match = ctypes.create_string_buffer(1024), Match()
    if libc.regcomp(compiled, f'^({pattern})$'.encode(), EXTENDED):
        return None
    found = libc.regexec(compiled, name.encode(), 1, ctypes.byref(match), 0) == 0
    libc.regfree(compiled)
    return found


def drawn_expression(rng, depth):
    kind = rng.random()
    if depth == 0 or kind < 0.4:
        return rng.choice(
            [
                'a',
                '_',
                '.',
                '[ab]',
                '[^a]',
                '[[:alpha:]]',
                '[a-c_]',
                r'\.',
                '[]a]',
                '[[:digit:]b-]',
            ]
        )
    if kind < 0.6:
        return drawn_expression(rng, depth - 1) + drawn_expression(rng, depth - 1)
    inner = drawn_expression(rng, depth - 1)
    if kind < 0.75:
        return f'({inner}|{drawn_expression(rng, depth - 1)})'
    return f'({inner}){rng.choice(["*", "+", "?", "{2}", "{1,3}", "{0,2}", "{2,}", "+?"])}'


def test_expressions_mean_what_they_mean_to_the_c_library():
    rng = random.Random(7)
    hits = 0
    for _ in range(2000):
        pattern = drawn_expression(rng, 4)
        name = ''.join(rng.choice('aabbc_1') for _ in range(rng.randrange(7)))
        expected = judged_by_libc(pattern, name)
        assert Expression(pattern).matches(name) is expected, (pattern, name)
        hits += expected
    assert hits > 100


@pytest.mark.parametrize(
    'text',
    [
        *('[', '(', ')', 'a{', 'a{3,1}', '*a', '\\', r'\d', '[[:foo:]]', '[z-a]', '[a-', '[[.'),
        *('a' * 1001, 'a{1001}', '((((a){9}){9}){9}){9}', '(' * 60 + ')' * 60),
    ],
)
def test_what_is_no_expression_is_refused_in_a_sentence(text):
    with pytest.raises(BadExpression, match=r' at character | characters|too often'):
        Expression(text)


def test_no_expression_takes_for_ever():
    begin = time.process_time()
    assert not Expression('(.+)+x').matches('a' * 1000)  # doubles with each letter elsewhere
    assert time.process_time() - begin < 1.0


CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
SHAPES = {
    'ball': {'type': 'sphere', 'radius': 0.4},
    'brick': {'type': 'box', 'size': [0.3, 0.5, 0.9]},
    'pill': {'type': 'capsule', 'radius': 0.2, 'length': 0.7},
    'can': {'type': 'cylinder', 'radius': 0.3, 'length': 0.5},
    'dots': {'type': 'particles', 'particles': [{'mass': 1, 'position': x} for x in CORNERS]},
    'shard': {'type': 'convex_hull', 'vertices': CORNERS},
}


def surface(shape, rng, count=4000):
    """
    Points of a shape in its own axes.
    """
    way = rng.normal(size=(count, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    match shape['type']:
        case 'sphere':
            return shape['radius'] * way
        case 'box':
            return np.array(shape['size']) * (rng.random((count, 3)) - 0.5)
        case 'capsule':
            along = np.array([0, 0, 1]) * shape['length'] * (rng.random(count) - 0.5)[:, None]
            return along + shape['radius'] * way
        case 'cylinder':
            angle, height = rng.random(count) * 2 * np.pi, rng.random(count) - 0.5
            side = shape['radius'] * np.array([np.cos(angle), np.sin(angle)])
            return np.array([*side, shape['length'] * height]).T
    return np.array(CORNERS, dtype=float)


@pytest.mark.parametrize('name', SHAPES)
def test_bounds_hold_the_body_and_overlaps_are_those_of_its_points(name):
    rng = np.random.default_rng(11)
    turn = rng.normal(size=4)
    given = {'name': name, 'shape': SHAPES[name]} | ({} if name == 'dots' else {'mass': 1.0})
    given['initial'] = {'position': [1, 2, 3], 'orientation': turn.tolist()}
    scene = load_scene({'version': 1, 'name': 'one', 'dt': 0.01, 'bodies': [given]})
    body = scene.bodies[0]
    extent = extent_of(body)
    points = surface(SHAPES[name], rng) - np.array(body.center_of_mass)
    low, high = extent.box
    assert np.all(points >= low - 1e-12)
    assert np.all(points <= high + 1e-12)
    # sampled surfaces reach the bounds up to a gap of a few thousandths
    assert np.allclose(np.min(points, axis=0), low, atol=0.02)
    assert np.allclose(np.max(points, axis=0), high, atol=0.02)
    pose = Pose.of(body.initial.position, body.initial.orientation)
    world = body.initial.position + points @ matrix_from_quaternion(body.initial.orientation).T
    for _ in range(200):
        center = np.array(body.initial.position) + rng.normal(size=3) * 0.7
        distance = float(np.min(np.linalg.norm(world - center, axis=1)))
        assert extent.meets_ball(pose, center, distance + 1e-9)
        half = rng.random(3) * 0.3
        if np.any(np.all(np.abs(world - center) <= half, axis=1)):
            assert extent.meets_box(pose, center, half)
        if name in ('ball', 'pill', 'dots') and distance > 0.1:  # sampled on the surface, dense
            assert not extent.meets_ball(pose, center, distance - 0.05) or _is_inside(
                name, body, pose, center
            )


def _is_inside(name, body, pose, center):
    """
    Whether a point is in the solid, where a ball of any radius overlaps it.
    """
    x = pose.axes.T @ (center - pose.origin)
    if name == 'ball':
        return np.linalg.norm(x) <= body.shape.radius
    if name == 'pill':
        along = np.clip(x[2], -0.5 * body.shape.length, 0.5 * body.shape.length)
        return np.linalg.norm(x - [0, 0, along]) <= body.shape.radius
    return False
