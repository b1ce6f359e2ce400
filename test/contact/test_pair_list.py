# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The list of pairs that is kept over ticks gives in each tick what comparing all with all gives.

Sets of pairs are compared, and their order: no tolerance.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.collision import bounds_record, collider_record
from rigid_body_sim.physics.contact.collision.collider import (
    PLANE,
    SPHERE,
    BroadPhase,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.hash_grid import SIZE as CELL
from rigid_body_sim.physics.contact.collision.hash_grid import size_of_heads
from rigid_body_sim.physics.contact.collision.neighbour_list import (
    AGE,
    BRUTE,
    LENGTH,
    find_pairs,
    size_of_fat_aabbs,
    size_of_list,
)
from rigid_body_sim.physics.contact.collision.swept_aabbs import (
    EXPANSION,
    HALF,
    MARGIN,
    TURNING,
    VELOCITY,
    may_meet,
    may_meet_plane,
)
from rigid_body_sim.physics.contact.collision.swept_aabbs import SIZE as ROW
from rigid_body_sim.physics.simulation import Simulation

from .. import inside
from .touching import ball, box, ground, heap, scene

DT = 1.0 / 240.0  # [s]


def all_pairs(n, planes, h, colliders):
    """
    Keys of the pairs that may meet, each compared with each.
    """
    keys = []
    table, reaches = colliders.table, colliders.swept_aabbs
    for j in range(planes, n):
        moves = table[j * collider_record.SIZE + collider_record.BODY] >= 0
        for i in range(j):
            if not moves and (
                i < planes or table[i * collider_record.SIZE + collider_record.BODY] < 0
            ):
                continue
            if i < planes:
                meets = may_meet_plane(
                    table[i * collider_record.SIZE + collider_record.PARAMETERS], j, h, colliders
                )
            else:
                meets = may_meet(reaches, i * ROW, j * ROW, h)
            if meets:
                keys.append(j * n + i)
    return keys


@dataclass
class Crowd:
    """
    Balls that fly as they like, and planes; every third of `statics` balls stands still.
    """

    radii: np.ndarray
    seed: int
    planes: int = 2
    statics: int = 0
    room: int = 4000

    def __post_init__(self):
        self.rng = rng = np.random.default_rng(self.seed)
        balls, planes = len(self.radii), self.planes
        self.n = n = balls + planes
        normals = rng.normal(size=(planes, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        self.numbers = np.column_stack((normals, rng.uniform(-3.0, -1.0, planes))).ravel()
        table = np.zeros((n, collider_record.SIZE), dtype=np.int64)
        table[:, 0] = [PLANE] * planes + [SPHERE] * balls
        table[:planes, collider_record.PARAMETERS] = 4 * np.arange(planes)
        table[:, collider_record.BODY] = -1
        table[planes + self.statics :, collider_record.BODY] = np.arange(balls - self.statics)
        bounds = np.zeros((n, bounds_record.SIZE))
        bounds[:, bounds_record.RADIUS] = [math.inf] * planes + list(self.radii)
        self.table, self.bounds = table.ravel(), bounds.ravel()
        self.position = rng.uniform(-2.0, 2.0, (n, 3))
        self.velocity = rng.normal(size=(n, 3))
        self.velocity[: planes + self.statics] = 0.0
        self.rooms = np.zeros(size_of_fat_aabbs(n))
        self.grid = np.zeros(CELL * n, dtype=np.int64)
        self.heads = np.zeros(size_of_heads(n), dtype=np.int64)
        self.make_room(self.room)

    def make_room(self, room):
        self.room = room
        self.kept = np.zeros(size_of_list(room), dtype=np.int64)
        self.keys = np.zeros(room, dtype=np.int64)

    def reaches(self, h):
        """
        Rows as `find_swept_aabbs` writes them.
        """
        rows = np.zeros((self.n, ROW))
        radius = np.array([0.0] * self.planes + list(self.radii))
        rows[:, :3] = self.position
        rows[:, HALF : HALF + 3] = radius[:, None]
        rows[:, VELOCITY : VELOCITY + 3] = self.velocity
        rows[:, TURNING] = (
            9.81 * h * h * (self.table[collider_record.BODY :: collider_record.SIZE] >= 0)
        )
        rows[:, MARGIN] = np.where(radius > 0.0, np.minimum(0.02, 0.1 * radius), 0.02)
        speed = np.linalg.norm(self.velocity, axis=1) * h
        rows[:, EXPANSION] = 0.5 * rows[:, MARGIN] + speed + rows[:, TURNING]
        return rows.ravel()

    def compare(self, h=DT):
        """
        Find the pairs, and assert that they are those of all pairs, in their order.
        """
        reaches = self.reaches(h)
        radius = float(np.median(self.radii))
        arrays = (self.numbers, self.table, self.bounds, np.zeros(0), reaches)
        work = (self.rooms, self.grid, self.heads, self.kept, self.keys)
        colliders = ColliderArrays(*(argument(array) for array in arrays))
        broad_phase = BroadPhase(*(argument(array) for array in work))
        count = find_pairs(self.n, self.planes, h, radius, self.room, colliders, broad_phase)
        expected = all_pairs(self.n, self.planes, h, colliders)
        assert count > self.room or self.keys[:count].tolist() == expected
        return count

    def fly(self, h=DT):
        self.position += h * self.velocity


RADII = {
    'few': lambda rng: rng.uniform(0.1, 0.3, BRUTE - 4),
    'equal': lambda rng: np.full(60, 0.2),
    'pebbles and a boulder': lambda rng: np.append(rng.uniform(0.02, 0.06, 60), 1.5),
    'a thousandfold': lambda rng: 10.0 ** rng.uniform(-3.0, 0.0, 60),
    'with points': lambda rng: np.append(np.full(30, 0.15), np.zeros(30)),
}


@pytest.mark.parametrize(
    ('kind', 'speed'),
    [
        pytest.param(*one, marks=() if i % 5 == 0 or i == 18 else pytest.mark.long)
        for i, one in enumerate(itertools.product(RADII, (0.0, 0.05, 2.0, 100.0)))
    ],
)
def test_a_list_that_is_kept_gives_the_pairs_of_all_with_all(kind, speed):
    rng = np.random.default_rng(len(kind))
    crowd = Crowd(RADII[kind](rng), seed=len(kind), statics=7)
    crowd.velocity *= speed
    made = found = 0
    for turn in range(60):
        found += crowd.compare()
        made += crowd.kept[AGE] == 1
        crowd.fly()
        moving = crowd.table[collider_record.BODY :: collider_record.SIZE] >= 0
        crowd.velocity[moving] += 0.1 * speed * rng.normal(size=(moving.sum(), 3))
        if turn % 20 == 10:  # a jump of one
            crowd.position[-1] = rng.uniform(-1.0, 1.0, 3)
        if turn == 40:  # a fixed one as well
            crowd.position[crowd.planes] *= 0.5
    assert found > 0
    assert made < 60 or speed > 2.0  # else nothing was kept


def test_ticks_in_pieces_and_whole_ones_share_a_list():
    crowd = Crowd(np.full(50, 0.2), seed=3)
    for turn in range(80):
        h = DT / 16.0 if 20 <= turn < 52 else DT
        crowd.compare(h)
        crowd.fly(h)


def test_a_tower_meets_its_neighbours_wherever_it_stands():
    # the cells of a tower follow each other in the hash, and somewhere go around its end
    crowd = Crowd(np.full(60, 0.2), seed=2, planes=0)
    crowd.velocity[:] = 0.0
    for turn in range(60):
        crowd.position[:] = 0.0
        crowd.position[:, 2] = 0.4 * np.arange(60) + 7.3 * turn
        assert crowd.compare() == 59


def test_what_sinks_to_a_plane_is_found_when_it_gets_near():
    crowd = Crowd(np.full(60, 0.2), seed=4, planes=1)
    crowd.numbers[:] = 0.0, 0.0, 1.0, 0.0
    crowd.position[1:, 0] = np.arange(60)
    crowd.position[1:, 2] = np.linspace(0.2, 0.6, 60)
    crowd.velocity[:] = 0.0
    near = []
    for _ in range(200):  # by less than any skin in a tick, so that all of it is used up
        near.append(crowd.compare())
        crowd.position[1:, 2] -= 0.001
    assert near[0] < 10
    assert near[-1] > 30


@pytest.mark.parametrize('far', [1e4, 1e9, 1e14])
def test_rounding_far_from_the_origin_hides_no_pair(far):
    crowd = Crowd(np.full(40, 0.2), seed=5, planes=0)
    spacing = np.spacing(far)
    crowd.position = far + np.round(crowd.position / spacing) * spacing
    crowd.position[:20, 1] = crowd.position[20:, 1]
    for _ in range(20):
        crowd.compare()
        crowd.fly()


def test_a_list_too_short_says_how_long_it_must_be():
    crowd = Crowd(np.full(40, 0.5), seed=1, room=50)
    crowd.position *= 0.3
    needed = crowd.compare()
    assert needed > 50
    crowd.make_room(2 * needed)
    assert crowd.compare() <= crowd.kept[LENGTH] <= needed


class Watched:
    """
    A simulation whose pairs are compared in every tick with those of all with all.
    """

    def __init__(self, bodies):
        self.simulation = Simulation(scene(bodies))
        self.world = inside.world(self.simulation)
        self.made = self.cut = 0
        self._last = self.simulation.dt  # [s] of the last piece of a tick
        inside.watch_pieces(self.simulation, self._watch_pieces)

    def _watch_pieces(self, lengths):
        self._last = lengths[-1]
        self.cut += 1

    def step(self, ticks):
        world, counts = self.world, self.world.counts
        for _ in range(ticks):
            self._last = self.simulation.dt
            self.simulation.step()
            h = self._last
            found = world.pair_ids[: counts[tick_counts.PAIRS]].tolist()
            n, planes = int(counts[tick_counts.COLLIDERS]), int(counts[tick_counts.PLANES])
            arrays = (
                world.shape_parameters, world.table, world.local_bounds, world.poses, world.swept,
            )  # fmt: skip
            colliders = ColliderArrays(*(argument(array) for array in arrays))
            assert found == all_pairs(n, planes, h, colliders)
            self.made += world.neighbours[AGE] == 1
        return self.simulation.state_bytes()


def test_a_heap_that_falls_and_rests_meets_the_pairs_of_all_with_all_also_after_a_reset():
    bodies = [
        *heap(12),
        *[ball(f'pebble{i}', 0.03, (0.07 * i - 0.5, 0.3, 1.0 + 0.1 * i)) for i in range(16)],
        ball('boulder', 0.8, (0.0, 0.0, 4.0), mass=50.0, velocity=(0.0, 0.0, -5.0)),
        box('wall', 0.5, (1.5, 0.0, 0.25), fixed=True),
    ]
    watched = Watched(bodies)
    middle = watched.step(150)
    assert watched.made < 100
    assert watched.cut > 0  # the boulder hits a pebble at more than half its radius per tick
    end = watched.step(30)
    watched.simulation.restore(tick=150, state=middle, slots={})
    assert watched.step(30) == end
    watched.simulation.reset()
    assert watched.step(150) == middle


def test_planes_are_kept_only_for_what_is_near():
    bodies = [ground(), *[ball(f'b{i}', 0.1, (0.3 * i, 0.0, 0.5 * i + 0.1)) for i in range(8)]]
    bodies.append(box('box', 0.2, (-1.0, 0.0, 9.0)))
    sim = Simulation(scene(bodies))
    sim.step()
    assert 0 < inside.world(sim).neighbours[LENGTH] < 8
