# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is not connected does not change a bit of each other: a heap with and without others far away,
that rest, move, bounce, are so fast that their ticks are cut, or feel a force that begins.
"""

import itertools
from functools import cache

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.solver import colouring
from rigid_body_sim.physics.forces.elements.time import TimeTable
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Plane,
    Sphere,
    Surface,
)

from .. import inside
from .touching import ball, box, ground, lean, motion, scene

TICK = 0.004  # [s]
TICKS = 600  # in which the heap falls and comes to rest
NEVER = 1e6  # [s]


def solid(kind, rng):
    """
    Shape and inertia over mass of some body.
    """
    size = rng.uniform(0.06, 0.14)
    directions = rng.normal(size=(12, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    shape = (
        Box((2 * size, 1.6 * size, 1.2 * size)),
        Sphere(size),
        Cylinder(size, 2 * size),
        Capsule(0.6 * size, 1.5 * size),
        ConvexHull(directions * size),
    )[kind]
    moments = ((0.5, 0.6, 0.7), (0.4, 0.4, 0.4), (0.5, 0.5, 0.45), (0.5, 0.5, 0.2), (0.4,) * 3)
    return shape, np.diag(moments[kind]) * size * size


ALL_KINDS, USUAL_KINDS, BALLS = range(5), (0, 1), (1,)  # of `solid`


def heap(restitution, seed, count=30, kinds=ALL_KINDS):
    """
    Bodies of some kinds that fall onto each other.
    """
    rng = np.random.default_rng(seed)
    bodies = [ground()]
    for i in range(count):
        shape, inertia = solid(kinds[i % len(kinds)], rng)
        q = rng.normal(size=4)
        place = (*rng.uniform(-0.25, 0.25, 2), 0.25 + 0.12 * i)
        bodies.append(
            Body(
                f'b{i}', shape, 1.0, inertia=inertia,
                initial=motion(place, q=q / np.linalg.norm(q), turn=rng.normal(size=3)),
                material=Material(friction=0.5, restitution=restitution),
            )
        )  # fmt: skip
    return bodies


LIVELY = {'restitution': 0.7}
OTHERS = {
    'a stack at rest': [box(f'far {i}', 0.2, (50, 0, 0.1 + 0.2 * i)) for i in range(9)],
    'a heap that falls': [
        box(f'far {i}', 0.2, (50 + 0.05 * i, 0.03 * i, 0.1 + 0.21 * i), turn=(0.1 * i, 0, 0))
        for i in range(9)
    ],
    'some that move': [
        ball('far 1', 0.1, (50, 0, 0.5), velocity=(1, 0, 0)),
        box('far 2', 0.2, (53, 0, 2), turn=(3, 2, 1)),
        ball('far 3', 0.1, (56, 0, 1), material=LIVELY),
    ],
    'bullets': [
        ball('far 1', 0.02, (50, 0, 2), velocity=(0, 90, -50)),
        box('wall', (1, 0.1, 4), (50, 2, 2), mass=5.0),
        *(
            ball(f'far 2 {i}', 0.02, (70, 3 * i, 2), velocity=(0, speed, 0))
            for i, speed in enumerate((40, -44, 48, -52, 56, -60))
        ),
    ],
}  # fmt: skip


def states(bodies, ticks=TICKS, make=scene, forces=()):
    """
    States of the heap, every twenty ticks.
    """
    sim = Simulation(make(bodies, dt=TICK, forces=tuple(forces)))
    of_heap = [
        i for i, body in enumerate(bodies) if body.name.startswith('b') or body.name == 'ground'
    ]
    found = []
    for _ in range(ticks // 20):
        sim.step(20)
        found.append(sim.state.values[of_heap].copy())
    return np.array(found)


@cache
def alone(restitution, seed):
    """
    States of a heap without others.
    """
    return states(heap(restitution, seed))


# a heap that does not bounce, and a lively one, beside one kind of others each
SHORT = {(0.0, 'a heap that falls'), (0.8, 'bullets'), (0.3, 'some that move')}
RESTITUTIONS = 0.0, 0.3, 0.8


@pytest.mark.parametrize(
    ('restitution', 'others'),
    [
        pytest.param(*case, marks=() if case in SHORT else pytest.mark.long)
        for case in itertools.product(RESTITUTIONS, OTHERS)
    ],
)
def test_a_heap_has_the_same_bits_with_and_without_others_far_away(restitution, others):
    together = states(heap(restitution, 0) + OTHERS[others])
    np.testing.assert_array_equal(together, alone(restitution, 0))


def tiles(size=0.5, reach=1.25):
    """
    Fixed boxes [m] that lie flush.
    """
    count = int(reach / size)
    return [
        box(f'tile {i} {j}', (size, size, 0.2), (size * i, size * j, -0.1), fixed=True)
        for i in range(-count, count + 1)
        for j in range(-count, count + 1)
    ]


def rough_ground():
    """
    A fixed surface of triangles, of random heights.
    """
    rng = np.random.default_rng(3)
    along = np.linspace(-2.5, 2.5, 8)
    places = [(x, y, rng.uniform(-0.08, 0.08)) for x in along for y in along]
    corners = [8 * i + j for i in range(7) for j in range(7)]
    faces = [f for a in corners for f in ((a, a + 8, a + 9), (a, a + 9, a + 1))]
    return [Body('mesh', Surface(np.array(places), np.array(faces)), 0.0, fixed=True)]


GROUNDS = {'plane': list, 'tiles': tiles, 'triangles': rough_ground}


def whatever(seed, floor):
    """
    Some bodies far away that fall onto a floor [m], of any kind and mass.
    """
    rng = np.random.default_rng(seed)
    others = []
    for i in range(rng.integers(1, 40)):
        shape, inertia = solid(i % len(ALL_KINDS), rng)
        mass = float(rng.uniform(0.1, 10.0))
        place = (50 + 0.3 * (i % 3), 0.2 * (i % 4), floor + 0.3 + 0.2 * i)
        material = Material(friction=rng.uniform(), restitution=rng.choice([0.0, 0.5]))
        others.append(
            Body(f'far {i}', shape, mass, inertia=mass * inertia, initial=motion(place),
                 material=material)
        )  # fmt: skip
    return others


@pytest.mark.parametrize(
    'seed', [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 9))]
)
@pytest.mark.parametrize(
    'on', [*(pytest.param(on, marks=pytest.mark.long) for on in ('plane', 'tiles')), 'triangles']
)
def test_a_heap_has_the_same_bits_wherever_others_come_in_the_list_of_bodies(on, seed):
    """
    Among the heap; in the long form also before and after it, and for 2,000 ticks.
    """
    ticks = 2000 if seed else TICKS
    floor = 0.0 if on == 'plane' else -3.0
    plane = Body('ground', Plane((0.0, 0.0, 1.0), floor), 0.0, fixed=True)
    bodies = [plane, *GROUNDS[on](), *heap(0.3, seed)[1:]]
    others = whatever(seed, floor)
    alone = states(bodies, ticks=ticks)
    half = len(bodies) - 15
    places = (half, 0, len(bodies)) if seed else (half,)
    for place in places:
        together = bodies[:place] + others + bodies[place:]
        np.testing.assert_array_equal(states(together, ticks=ticks), alone)


def on_small_tiles(restitution, seed, kinds=ALL_KINDS):
    """
    A heap whose faces lie on several tiles; a floor below, for others.
    """
    floor = Body('ground', Plane((0.0, 0.0, 1.0), -3.0), 0.0, fixed=True)
    return [floor, *tiles(0.17, 1.0), *heap(restitution, seed, 20, kinds)[1:]]


@pytest.mark.parametrize(
    'seed',
    [0, 18, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 41) if seed != 18)],
)
def test_what_lies_on_many_small_tiles_has_the_same_bits_beside_others(seed):
    """
    Their faces are surfaces of several manifolds, which come and go. In 0 a lane that has settled
    is let go by its surface; in 18 normals are alike one by one, and the first and the last not.
    """
    bodies = on_small_tiles(0.0, seed)
    alone = states(bodies, ticks=400)
    together = states(whatever(seed, -3.0) + bodies, ticks=400)
    np.testing.assert_array_equal(together, alone)


def compare_with_leftovers(ticks, seed, make):
    """
    Compare a run with one in which the rows of the solver hold random numbers before each tick.
    """
    rng = np.random.default_rng(seed)
    usual, with_leftovers = make(), make()
    drawn = np.zeros(0)
    for _ in range(ticks):
        arrays = inside.world(with_leftovers)
        arrays.counts[tick_counts.ASSEMBLED] = 0  # else rows are kept on purpose
        rows = arrays.rows[colouring.HEAD :]
        if len(drawn) < 2 * len(rows):
            drawn = rng.uniform(-1, 1, 2 * len(rows)) * 10.0 ** rng.uniform(-9, 0, 2 * len(rows))
        rows[:] = drawn[rng.integers(len(drawn) - len(rows)) :][: len(rows)]
        for sim in (usual, with_leftovers):
            sim.step(1)
        np.testing.assert_array_equal(with_leftovers.state.values, usual.state.values)


@pytest.mark.parametrize(
    ('kinds', 'seed'),
    [
        (ALL_KINDS, 2), (BALLS, 0),
        *(
            pytest.param(kinds, seed, marks=pytest.mark.long)
            for kinds in (ALL_KINDS, BALLS)
            for seed in range(3, 11)
        ),
    ],
)  # fmt: skip
def test_what_the_solver_has_written_in_earlier_ticks_changes_no_bit(kinds, seed):
    """
    What was never written, or is of another contact by now, is as good as any number.
    """
    bodies = on_small_tiles(0.8 if kinds == BALLS else 0.3 * (seed % 2), seed, kinds)
    compare_with_leftovers(300, seed, lambda: Simulation(scene(bodies, dt=TICK)))


def begins(body, instants):
    """
    Forces of zero that begin at instants [tick].
    """
    return [TimeTable(body, ((t * TICK, 0, 0, 0), (NEVER, 0, 0, 0))) for t in instants]


def test_a_heap_does_not_feel_that_a_force_begins_far_away_inside_a_tick():
    bodies = heap(0.3, 1, kinds=USUAL_KINDS) + [ball('far', 0.1, (50, 0, 0.1))]
    instants = np.cumsum(np.random.default_rng(0).uniform(0.2, 9, 100))
    calm = states(bodies, forces=begins('far', [1e6]))
    np.testing.assert_array_equal(states(bodies, forces=begins('far', instants)), calm)


def test_contacts_of_whom_a_cut_does_not_concern_are_those_of_a_whole_tick():
    bodies = [ground(), *(box(f'b{i}', 0.2, (i, 0, 0.1)) for i in range(4))]
    cut, whole = (
        Simulation(scene(bodies, dt=TICK, forces=tuple(begins('b2', instants))))
        for instants in ([40.3, 40.8], [1e6])
    )
    for sim in (cut, whole):
        sim.step(41)
    found, expected = cut.contacts(), whole.contacts()
    np.testing.assert_array_equal(found.bodies, expected.bodies)
    others = (found.bodies != 3).all(axis=1)
    np.testing.assert_array_equal(found.impulse[others], expected.impulse[others])
    # the load of a body that has come to rest to 1e-5, in the sum of three pieces
    carried = abs(found.impulse[~others].sum(axis=0)[2])
    np.testing.assert_allclose(carried, 9.81 * TICK, rtol=1e-5)


@pytest.mark.long
@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('others', list(OTHERS))
@pytest.mark.parametrize('restitution', RESTITUTIONS)
def test_a_heap_has_the_same_bits_for_long_in_a_kernel_of_its_own(restitution, others, seed):
    """
    Nothing else bounces in the scene: another kernel than with one that does, and the same bits.
    """
    bodies = heap(restitution, seed)
    together = states(bodies + OTHERS[others], ticks=2000, make=lean)
    np.testing.assert_array_equal(together, states(bodies, ticks=2000, make=lean))
