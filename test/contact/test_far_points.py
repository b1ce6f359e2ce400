# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Points that cannot be reached in a substep are left out of its visits, and not one bit changes.
"""

import itertools
import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    constraint,
    far_points,
    lane_scratch,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES

from .. import inside

FLOOR = {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.5}
BOX = {'type': 'box', 'size': [0.3, 0.2, 0.1]}
HULL = {
    'type': 'convex_hull',
    'vertices': [
        [x * s, y * s, 0.3 * x * y * s + z * s]
        for s, (x, y, z) in zip(
            (0.1, 0.12) * 4, itertools.product((-1.0, 1.0), repeat=3), strict=True
        )
    ],
}
CAPSULE = {'type': 'capsule', 'radius': 0.08, 'length': 0.2}
CYLINDER = {'type': 'cylinder', 'radius': 0.1, 'length': 0.15}


def leaning(shape, at, turn, **motion):
    """A body a little above the floor, turned by `turn` radians about y."""
    return {
        'name': 'upper' if motion else 'lower', 'shape': shape, 'mass': 1.0, 'friction': 0.5,
        'initial': {
            'position': at, 'orientation': [0.0, math.sin(turn / 2), 0.0, math.cos(turn / 2)],
            **motion,
        },
    }  # fmt: skip


def scene(shape, **material):
    """One body that tips over from an edge, and one that lands on it and hits it at one end."""
    speed = {'velocity': [0.4, 0.1, -2.0], 'angular_velocity': [0.3, 3.0, 0.0]}
    bodies = [
        leaning(shape, [0.0, 0.0, 0.1], 0.02),
        leaning(shape, [0.08, 0.01, 0.34], -0.05, **speed),
    ]
    return {
        'version': 1, 'name': 'far', 'dt': 0.004, 'gravity': [0, 0, -9.81],
        'contact': {'mode': 'timestep'}, 'bodies': [FLOOR, *(body | material for body in bodies)],
    }  # fmt: skip


def run(shape, ticks, **material):
    """States after each tick, and how many points were left out at the end of it."""
    simulation = Simulation(load_scene(scene(shape, **material)))
    states, left_out = [], []
    for _ in range(ticks):
        simulation.step()
        states.append(simulation.state.values[1].copy())
        left_out.append(inside.points_left_out(simulation))
    return np.array(states), np.array(left_out)


@pytest.mark.parametrize(
    ('shape', 'material'),
    [
        pytest.param(BOX, {}, marks=pytest.mark.long),  # bouncing or not: the same visits
        (BOX, {'restitution': 0.5}),
        pytest.param(HULL, {}, marks=pytest.mark.long),
        (CAPSULE, {'rolling_friction': 0.01}),
        (CYLINDER, {}),
    ],
    ids=['box', 'bouncing box', 'hull', 'rolling capsule', 'cylinder'],
)
@pytest.mark.parametrize('ticks', [24, pytest.param(45, marks=pytest.mark.long)])
def test_what_is_left_out_changes_no_bit(shape, material, ticks, monkeypatch):
    states, left_out = run(shape, ticks, **material)
    inside.run_plain(monkeypatch)  # a compiled kernel would not see what is replaced
    monkeypatch.setattr(far_points, 'may_press', lambda *_: True)
    all_asked, none_left = run(shape, ticks, **material)
    assert np.array_equal(states, all_asked)
    assert left_out.max() > 0
    assert none_left.max() == 0


def test_what_a_visit_itself_sends_towards_the_ground_is_asked_in_the_same_visit(monkeypatch):
    """A plate that lands on one edge is stopped there, and its other one comes down faster."""
    scenes = []
    fast = itertools.product((2.0,), (0.007, 0.008, 0.009, 0.01), (1e-4, 2e-4, 3e-4))
    slow = itertools.product((0.3,), (0.0011, 0.0013, 0.0015), (2.5e-4, 2.7e-4, 2.9e-4))
    for speed, tilt, gap in (*fast, *slow):
        height = gap + 0.05 * math.cos(tilt) + 0.15 * math.sin(tilt)
        plate = leaning(BOX, [0.0, 0.0, height], tilt, velocity=[0.0, 0.0, -speed])
        document = scene(BOX)
        document['bodies'] = [FLOOR, plate]
        scenes.append(document)

    def states():
        simulations = [Simulation(load_scene(document)) for document in scenes]
        for simulation in simulations:
            simulation.step()
        return np.array([simulation.state.values[1] for simulation in simulations])

    found = states()
    inside.run_plain(monkeypatch)
    monkeypatch.setattr(far_points, 'may_press', lambda *_: True)
    assert np.array_equal(found, states())


def lane_of(random, rows, scratch):
    """Write a random pair of bodies into lane 0; its velocity at an arm of each, by hand."""
    inverse = []
    for first in (constraint.INVERSE_INERTIA_A, constraint.INVERSE_INERTIA_B):
        root = random.normal(size=(3, 3))
        matrix = root @ root.T * 10.0 ** random.uniform(-2, 2)
        rows[first : first + 6 * LANES : LANES] = matrix[np.triu_indices(3)]
        inverse.append(matrix)
    rows[constraint.INVERSE_MASS_A], rows[constraint.INVERSE_MASS_B] = random.uniform(0, 2, 2)
    momenta = random.normal(size=(2, 3)) * 10.0 ** random.uniform(-2, 0)
    relative = random.normal(size=3)
    for field, vector in (
        (lane_scratch.ANGULAR_MOMENTUM_A, momenta[0]),
        (lane_scratch.ANGULAR_MOMENTUM_B, momenta[1]),
        (lane_scratch.RELATIVE_VELOCITY, relative),
    ):
        scratch[field : field + 3 * LANES : LANES] = vector
    spins = [matrix @ momentum for matrix, momentum in zip(inverse, momenta, strict=True)]
    return relative, spins


def turned(spin, h, arm):
    """Way of the end of an arm of a body that turns at a constant rate over a substep."""
    angle = np.linalg.norm(spin) * h
    axis = spin / np.linalg.norm(spin)
    along = axis * (axis @ arm)
    across = arm - along
    return (
        (math.cos(angle) - 1.0) * across + math.sin(angle) * np.cross(axis, across)
    )  # fmt: skip


def test_no_far_point_is_reached_while_none_may_press():
    random, h = np.random.default_rng(5), 0.004
    answers = []
    for _ in range(2000):
        rows, scratch = np.zeros(constraint.SIZE), np.zeros(lane_scratch.SIZE)
        relative, spins = lane_of(random, rows, scratch)
        arms = random.normal(size=(2, 3))
        longest = np.linalg.norm(arms, axis=1)
        separation = 10.0 ** random.uniform(-3, 0)
        rows[constraint.FAR_SEPARATION :][:LANES] = far_points.NOWHERE
        rows[constraint.FAR_SEPARATION] = separation
        rows[constraint.FAR_ARM_A], rows[constraint.FAR_ARM_B] = longest
        may = far_points.may_press(LANES, 1.0 / h, True, argument(rows), argument(scratch))
        answers.append(may)
        way = h * relative + turned(spins[1], h, arms[1]) - turned(spins[0], h, arms[0])
        straight = h * (relative + np.cross(spins[1], arms[1]) - np.cross(spins[0], arms[0]))
        assert may or max(np.linalg.norm(way), np.linalg.norm(straight)) < separation
    assert 0.1 < np.mean(answers) < 0.9


@pytest.mark.parametrize('gaps', [*itertools.product((-1e-5, 1e-5, 0.01), repeat=4)])
def test_far_points_stand_behind_near_ones_each_as_they_stood(gaps):
    manifolds = np.zeros(manifold_record.SIZE)
    manifolds[manifold_record.POINT_COUNT] = len(gaps)
    points = manifolds[manifold_record.POINTS :][: len(gaps) * manifold.POINT]
    points = points.reshape(len(gaps), -1)
    points[:] = np.arange(points.size).reshape(points.shape)
    points[:, manifold.SEPARATION] = gaps
    limit = far_points.FAR * 0.1
    expected = np.concatenate(
        [points[points[:, 3] <= limit], points[points[:, 3] > limit]]
    )  # fmt: skip
    assert far_points.count_near(0, 0.1, argument(manifolds)) == sum(gap <= limit for gap in gaps)
    far_points.put_behind(0, 0.1, argument(manifolds))
    assert np.array_equal(points, expected)
