# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Manifolds that follow their bodies (`collision.recycling`): what they may differ by from what a
full detection finds, that they are part of the state, and that they know no names.
"""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision import (
    collider_record,
    manifold_record,
    pose,
    recycled_record,
)
from rigid_body_sim.physics.contact.collision.collider import BOX, CYLINDER
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.pairs import collide_kernel
from rigid_body_sim.physics.contact.collision.recycling import RECYCLED_KINDS, TOLERANCE
from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.scene import Body, Material, Oscillation, PrescribedMotion
from rigid_body_sim.physics.model.shapes import Box, ConvexHull, Cylinder
from rigid_body_sim.physics.simulation import Simulation

from .. import inside
from .touching import CORNERS, DT, G, box, ground, motion, scene

SIZE = 0.1  # [m] half width of the bodies
NEAR = 2.0 * TOLERANCE * SIZE * math.sqrt(3.0)  # [m] of the largest ball about one of them
FELL, RESTS = 240, 500  # [tick] the pile has fallen, but still moves; is at rest


def solid(name, shape, place, *, fixed=False, friction=0.5, **moves):
    """
    A body of 1 kg.
    """
    known = of_shape(shape, mass=1.0)
    return Body(
        name, shape, 1.0, inertia=known.inertia, fixed=fixed, material=Material(friction=friction),
        initial=motion(np.add(place, known.center_of_mass), **moves),
        center_of_mass=known.center_of_mass,
    )  # fmt: skip


def block(name, place, **moves):
    """
    A cube that is a hull.
    """
    return solid(name, ConvexHull(SIZE * CORNERS), place, **moves)


def stone(rng):
    """
    A hull of twelve points on a ball.
    """
    points = rng.normal(size=(12, 3))
    return ConvexHull(SIZE * points / np.linalg.norm(points, axis=1)[:, None])


def pile(count=12, seed=4):
    """
    Hulls, cylinders and boxes that fall onto each other in a pit.
    """
    rng = np.random.default_rng(seed)
    bodies = [ground()]
    for i, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        size = (0.2, 0.8, 2.0) if x else (0.8, 0.2, 2.0)
        bodies.append(box(f'w{i}', size, (0.3 * x, 0.3 * y, 1.0), fixed=True))
    for i in range(count):
        q = rng.normal(size=4)
        shape = (stone(rng), Cylinder(0.09, 0.16), Box((0.16, 0.14, 0.12)))[i % 3]
        place = (*rng.uniform(-0.1, 0.1, 2), 0.2 + 0.22 * i)
        bodies.append(solid(f'b{i}', shape, place, q=q / np.linalg.norm(q)))
    return bodies


def records(sim):
    """
    What is kept of each pair: by its id, the types of both, its manifold and its record.
    """
    arrays = inside.world(sim)
    types = arrays.table[collider_record.TYPE :: collider_record.SIZE]
    found = {}
    for row in np.array(arrays.manifolds_in_use).reshape(-1, manifold_record.SIZE):
        place = int(row[manifold_record.RECYCLED])
        if place >= 0:
            a, b = int(row[manifold_record.COLLIDER_A]), int(row[manifold_record.COLLIDER_B])
            kept = arrays.recycled_records[place : place + recycled_record.SIZE].copy()
            found[int(row[manifold_record.PAIR_ID])] = (int(types[a]), int(types[b])), row, kept
    return found


def followed(before, after):
    """
    Ids of the pairs whose manifold was not detected anew in between.
    """
    return {
        pair for pair, (_, _, kept) in after.items()
        if pair in before and before[pair][2].tobytes() == kept.tobytes()
    }  # fmt: skip


def detected(sim, row):
    """
    Deepest gap and normal of a pair, detected in full where the last tick has found its bodies.
    """
    arrays = inside.world(sim)
    a, b = int(row[manifold_record.COLLIDER_A]), int(row[manifold_record.COLLIDER_B])
    shape_a, shape_b = (
        int(arrays.table[one * collider_record.SIZE + collider_record.PARAMETERS])
        for one in (a, b)
    )
    types = tuple(int(arrays.table[one * collider_record.SIZE]) for one in (a, b))
    found = np.zeros(manifold.FOUND)
    points = collide_kernel(*types)(
        argument(arrays.shape_parameters), shape_a, shape_b, argument(arrays.poses),
        a * pose.SIZE, b * pose.SIZE, SIZE, argument(found),
    )  # fmt: skip
    gaps = found[manifold.POINTS + manifold.SEPARATION :: manifold.POINT][:points]
    return min(gaps), found[:3].copy()


def gaps_of(row):
    """
    Gaps of the points of a manifold [m].
    """
    count = int(row[manifold_record.POINT_COUNT])
    return row[manifold_record.POINTS + manifold.SEPARATION :: manifold.POINT][:count]


def poses_of(sim, row):
    """
    Places and frames of the two shapes of a manifold, as the last tick has found them.
    """
    poses = np.array(inside.world(sim).poses).reshape(-1, pose.SIZE)
    a, b = (
        poses[int(row[place])]
        for place in (manifold_record.COLLIDER_A, manifold_record.COLLIDER_B)
    )
    return a[:3], a[3:].reshape(3, 3), b[:3], b[3:].reshape(3, 3)


@pytest.fixture(scope='module')
def at_rest():
    """
    A pile that has come to rest.
    """
    sim = Simulation(scene(pile()))
    sim.step(RESTS)
    return sim.state_bytes()


def resting(at_rest):
    sim = Simulation(scene(pile()))
    sim.restore(tick=RESTS, state=at_rest, slots={})
    sim.step(1)
    return sim


def place_of(feature, row):
    """
    Where the point of a manifold with a feature begins: far ones were put behind near ones.
    """
    places = manifold_record.POINTS + manifold.POINT * np.arange(
        int(row[manifold_record.POINT_COUNT])
    )
    (place,) = places[row[places + manifold.FEATURE] == feature]
    return place


def test_each_record_is_of_its_own_pair_also_where_ghosts_are_taken_out():
    """
    In a pile that falls together manifolds of what passes by are taken out of the list. What is
    kept of a pair are the points of its manifold, wherever that stands in the list: to rounding,
    and of what rolls, whose frame turns with the normal, not looked at.
    """
    sim = Simulation(scene(pile(15, seed=0)))
    sim.step(60)
    seen = 0
    for _ in range(60):
        sim.step(1)
        for _, row, kept in records(sim).values():
            if kept[recycled_record.TURNED] != manifold.NEITHER:
                continue
            x_a, r_a, x_b, r_b = poses_of(sim, row)
            for point in range(int(kept[recycled_record.POINT_COUNT])):
                place = recycled_record.POINTS + point * recycled_record.POINT
                on_a, on_b = (
                    kept[place + axis : place + axis + 3]
                    for axis in (recycled_record.ON_A, recycled_record.ON_B)
                )
                middle = 0.5 * (x_a + r_a @ on_a + x_b + r_b @ on_b)
                found = place_of(kept[place + recycled_record.FEATURE], row)
                assert np.abs(middle - row[found : found + 3]).max() < 1e-12
                seen += 1
    assert seen > 500


def test_what_rests_is_not_detected_anew():
    """
    Two towers with the pairs of shapes of which records are kept; a cylinder on the face of a box
    is found without one. (In a heap some body rocks by more than the limit now and then.)
    """
    cylinder = Cylinder(0.09, 0.16)
    towers = [
        box('floor', (2.0, 2.0, 0.2), (0, 0, -0.1), fixed=True),
        block('b0', (0, 0, 0.1)),
        block('b1', (0.01, 0, 0.3)),
        solid('b2', cylinder, (0, 0.02, 0.48)),
        solid('b3', cylinder, (0.5, 0, 0.08)),
        solid('b4', cylinder, (0.51, 0, 0.24)),
    ]
    sim = Simulation(scene(towers))
    sim.step(250)
    before = records(sim)
    sim.step(20)
    after = records(sim)
    assert {types for types, _, _ in after.values()} == RECYCLED_KINDS - {(BOX, CYLINDER)}
    assert followed(before, after) == after.keys()


@pytest.mark.parametrize('begin', [FELL, RESTS])
def test_a_manifold_that_follows_is_that_of_a_full_detection_within_three_limits(begin):
    """
    Three limits: by so much a corner beside the points, or another axis, may be nearer (see
    `recycling`); and by the gain that another axis needs to win, 1e-3 of the half width.
    """
    sim = Simulation(scene(pile()))
    sim.step(begin)
    before, compared, worst = records(sim), 0, 0.0
    for _ in range(20):
        sim.step(4)
        after = records(sim)
        for pair in followed(before, after):
            _, row, _ = after[pair]
            worst = max(worst, abs(gaps_of(row).min() - detected(sim, row)[0]))
            compared += 1
        before = after
    assert compared > (10 if begin == FELL else 100)  # of 300: it still rocks now and then
    assert worst < 3.0 * NEAR + 1e-3 * SIZE


def test_drift_is_counted_from_the_last_full_detection():
    """
    A block slides by a thirtieth of the limit in each tick: some thirty ticks from one full
    detection to the next, and never further than the limit from the last.
    """
    limit = 2.0 * TOLERANCE * SIZE * math.sqrt(3.0)
    speed = limit / 30.0 / DT
    sim = Simulation(
        scene([
            solid('floor', ConvexHull((1.0, 1.0, 0.1) * CORNERS), (0, 0, -0.1), fixed=True,
                  friction=0.0),
            block('b', (0, 0, SIZE), velocity=(speed, 0, 0), friction=0.0),
        ])
    )  # fmt: skip
    sim.step(2)
    renewed, farthest, before = 0, 0.0, records(sim)
    for _ in range(150):
        sim.step(1)
        after = records(sim)
        (pair,) = after
        renewed += pair not in followed(before, after)
        _, row, kept = after[pair]
        x_a, r_a, x_b, r_b = poses_of(sim, row)
        normal = row[manifold_record.NORMAL : manifold_record.NORMAL + 3]
        for point in range(int(kept[recycled_record.POINT_COUNT])):
            place = recycled_record.POINTS + point * recycled_record.POINT
            on_a, on_b = (
                kept[place + axis : place + axis + 3]
                for axis in (recycled_record.ON_A, recycled_record.ON_B)
            )
            apart = x_b + r_b @ on_b - x_a - r_a @ on_a
            gap = kept[place + recycled_record.SEPARATION]
            farthest = max(farthest, np.linalg.norm(apart - gap * normal))
        before = after
    assert 4 <= renewed <= 6  # 150 ticks of a thirtieth each
    assert 0.9 * limit < farthest <= limit * (1.0 + 1e-9)  # round-off
    assert sim.state.velocity[1, 0] == pytest.approx(speed, rel=1e-9)  # and it slides on


def test_a_block_that_slides_by_more_is_detected_in_each_tick():
    bodies = [
        solid('floor', ConvexHull((2.0, 1.0, 0.1) * CORNERS), (0, 0, -0.1), fixed=True),
        block('b', (-1, 0, SIZE), velocity=(1.0, 0, 0)),
    ]
    sim = Simulation(scene(bodies))
    sim.step(2)
    before = records(sim)
    for _ in range(30):
        sim.step(1)
        after = records(sim)
        assert len(after) == 1 and not followed(before, after)
        before = after
    time = (sim.tick) * DT
    assert sim.state.velocity[1, 0] == pytest.approx(1.0 - 0.5 * G * time, abs=1e-6)


def test_a_pile_at_rest_sinks_no_deeper_than_what_it_weighs(at_rest):
    """
    The deepest overlap, of a full detection: below a twentieth of a millimetre, twice the deepest
    that manifolds say; and the pile stays where it is, once no stone tips over any more: of twelve
    piles three still had one that did so after two seconds.
    """
    sim = resting(at_rest)
    deepest = min(detected(sim, row)[0] for _, row, _ in records(sim).values())
    said = min(gaps_of(row).min() for _, row, _ in records(sim).values())
    assert said < 0.0 and deepest > 2.0 * said - 3.0 * NEAR
    sim.step(500)
    place = sim.state.position.copy()
    sim.step(240)
    assert np.abs(sim.state.position - place).max() < 1e-3


@pytest.mark.parametrize('tick', [FELL, RESTS])
def test_what_is_kept_is_state_and_goes_on_bit_for_bit(at_rest, tick):
    sim = Simulation(scene(pile()))
    sim.step(tick)
    middle = sim.state_bytes()
    sim.step(90)
    assert records(sim)
    other = Simulation(scene(pile()))
    other.step(33)  # it has kept something else
    other.restore(tick=tick, state=middle, slots={})
    for _ in range(90):
        other.step(1)
    assert other.state_bytes() == sim.state_bytes()


def test_lists_that_are_too_short_for_records_grow_without_a_trace():
    sim, other = Simulation(scene(pile())), Simulation(scene(pile()))
    inside.shorten(other, pair_ids=1, recycled_places=1, held_features=5, cache=2)
    sim.step(FELL)
    other.step(FELL)
    assert other.state_bytes() == sim.state_bytes()


def test_a_cut_tick_leaves_no_other_trace_in_a_pile_far_away():
    """
    A ball that meets a wall at 60 m/s cuts ticks into pieces; what lies at rest far away is
    recalled in each piece, and gets the bits of a pile whose ticks are cut by another ball.
    """
    wall = box('wall', (0.02, 2.0, 2.0), (40.0, 0, 1.0), fixed=True)

    def run(y):
        bullet = solid('bullet', ConvexHull(0.1 * SIZE * CORNERS), (39.0, y, 1.5),
                       velocity=(60.0, 0, 0))  # fmt: skip
        sim = Simulation(scene([*pile(6), wall, bullet]))
        sim.step(FELL)
        return sim.state.values[: len(pile(6))]

    assert run(0.0).tobytes() == run(0.5).tobytes()


def test_names_of_bodies_change_nothing_beyond_rounding():
    """
    Two blocks on a floor, one on the other, in both orders: 1e-12, as of any pile. Before the
    limit was the angle, and that of the nearer way, one order would have been detected anew in
    other ticks than the other.
    """
    floor = solid('floor', ConvexHull((1.0, 1.0, 0.1) * CORNERS), (0, 0, -0.1), fixed=True)
    lower = block('lower', (0, 0, SIZE + 1e-3), turn=(0.01, 0.02, 0.2))
    upper = block('upper', (0.03, 0.02, 3 * SIZE + 3e-3), turn=(0.02, -0.03, 0.1))
    places = []
    for order in itertools.permutations((floor, lower, upper)):
        sim = Simulation(scene(list(order)))
        sim.step(200)
        index = [sim.body_index(name) for name in ('lower', 'upper')]
        places.append(sim.state.position[index])
    assert max(np.abs(place - places[0]).max() for place in places) < 1e-12


def test_a_body_put_elsewhere_is_forgotten(at_rest):
    """
    Put back into the same place at once, a body is detected anew; the others are not.
    """
    sim = resting(at_rest)
    before = records(sim)
    index = sim.body_index('b0')
    sim.set_state('b0', position=sim.state.position[index])
    sim.step(1)
    after = records(sim)
    still = followed(before, after)
    assert still and still != {*after}


DECK = replace(
    solid('deck', ConvexHull((1.0, 1.0, 0.1) * CORNERS), (5.0, 0, -0.1), fixed=True),
    motion=PrescribedMotion(heave=(Oscillation(0.05, 0.5),)),
)


def test_who_wakes_knows_what_it_knew_when_it_fell_asleep():
    """
    A pile that sleeps for 60 ticks, and one that is asked for its state there and goes on from it:
    the same bits after both are woken; and the manifolds follow on, none is detected anew.
    """
    floor = solid('floor', ConvexHull((1.0, 1.0, 0.1) * CORNERS), (0, 0, -0.1), fixed=True)
    bodies = [floor, block('b', (0, 0, SIZE)), block('c', (0.02, 0.01, 3 * SIZE)), DECK]
    asleep, again = (Simulation(scene(bodies, sleeping=True, sleep_time=0.1)) for _ in range(2))
    asleep.step(20)
    before = records(asleep)
    asleep.step(80)
    assert inside.asleep(asleep) == {'b', 'c'}
    again.restore(tick=100, state=asleep.state_bytes(), slots={})
    ends = []
    for sim in (asleep, again):
        sim.step(60)
        sim.apply_impulse('c', linear=(0, 0, 1e-9))
        sim.step(1)
        assert not inside.asleep(sim)
        assert len(followed(before, records(sim))) == 2
        ends.append(sim.state_bytes())
    assert ends[0] == ends[1]


def test_a_block_on_a_deck_that_heaves_follows_it():
    """
    The deck is moved as told, with the block on it: neither has moved against the other, so the
    manifold follows, and the block heaves with the deck to 1e-5 m (the contact gives by m a / k).
    """
    sim = Simulation(scene([DECK, block('b', (5.0, 0, SIZE))], sleeping=True, sleep_time=0.1))
    sim.step(60)
    heights = []
    for _ in range(20):
        before = records(sim)
        sim.step(3)
        assert len(followed(before, records(sim))) == 1
        heights.append(sim.state.position[:2, 2])
    decks, blocks = np.transpose(heights)
    assert np.ptp(decks) > 0.01 and np.ptp(blocks - decks) < 1e-5


def test_a_cylinder_that_rolls_slowly_on_a_hull_rolls_as_on_a_plane():
    """
    Its frame turns with the normal, so it is recalled although its surface moves on; to 1e-6 of
    its way in 1 s.
    """
    speed = 0.05
    lying = {'q': (math.sin(math.pi / 4), 0, 0, math.cos(math.pi / 4))}
    places = []
    for floor in (
        solid('floor', ConvexHull((1.0, 1.0, 0.1) * CORNERS), (0, 0, -0.1), fixed=True),
        ground(material={'friction': 0.5}),
    ):
        wheel = solid('wheel', Cylinder(SIZE, 0.1), (0, 0, SIZE), velocity=(speed, 0, 0),
                      turn=(0, speed / SIZE, 0), **lying)  # fmt: skip
        sim = Simulation(scene([floor, wheel]))
        sim.step(240)
        places.append(sim.state.position[sim.body_index('wheel')])
    assert np.abs(places[1] - places[0]).max() < 1e-6 * speed
    assert places[0][0] == pytest.approx(speed * 240 * DT, rel=1e-6)
