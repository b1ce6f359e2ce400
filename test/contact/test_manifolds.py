# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The points of a manifold carry a body as its whole surface would, and stay the same while it rests.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision.collider import BOX, CAPSULE, CYLINDER, PLANE
from rigid_body_sim.physics.contact.collision.geometry.cylinders import rim
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FOUND,
    HELD,
    HELD_COUNT,
    LEAD,
    POINT,
    POINTS,
    SCRATCH,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold_reduction import (
    DEEPER,
    FLAT_POINT,
    SKIN,
    keep_four,
    keep_four_flat,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.extreme_points import (
    MUCH_DEEPER,
    keep_extremes,
)

from .pair_cases import Placed, about, collide, random_turns

MARGIN = 0.01  # [m]
ROUNDING = 1e-14  # [m] round-off of coordinates of tenths of a metre
UPRIGHT = np.eye(3)
LYING = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # shape z along world x
GROUND = Placed(PLANE, np.array([0.0, 0.0, 1.0, 0.0]), np.zeros(3), np.eye(3))


def at(kind, sizes, origin, turn=UPRIGHT):
    return Placed(kind, np.array(sizes, dtype=float), np.array(origin, dtype=float), turn)


def plan(found):
    """The places seen from above, in order."""
    return np.array(sorted(found.places[:, :2].tolist()))


# box on plane


@pytest.mark.parametrize('half_height', [1e-6, 1e-3, 0.1])
@pytest.mark.parametrize('tilt', [0.0, 1e-9, 1e-4, 0.02])
def test_plate_thinner_than_the_margin_rests_on_its_lower_corners(half_height, tilt):
    box = at(BOX, [0.2, 0.1, half_height], [0, 0, half_height - 1e-4], about(0, tilt))
    found = collide(box, GROUND, MARGIN)
    assert len(found) == 4
    corners = [
        box.origin + box.turn @ np.array([x, y, -half_height])
        for x in (-0.2, 0.2)
        for y in (-0.1, 0.1)
    ]
    expected = sorted(corner[2] for corner in corners)
    assert np.allclose(np.sort(found.gaps), expected, rtol=0.0, atol=ROUNDING)


def test_box_deep_in_the_ground_is_held_by_its_lowest_side():
    box = at(BOX, [0.2, 0.1, 0.05], [0, 0, -1.0], about(1, 0.1))
    found = collide(box, GROUND, MARGIN)
    assert len(found) == 4
    lowest = -1.0 - 0.2 * math.sin(0.1) - 0.05 * math.cos(0.1)
    assert abs(found.gap - lowest) < ROUNDING
    assert np.all(found.gaps < -1.0 + 0.2 * math.sin(0.1))


# box on box


@pytest.mark.parametrize('yaw', [0.0, 1e-9, 0.3, math.pi / 4, math.pi / 2])
def test_box_on_a_larger_box_touches_with_its_four_corners(yaw):
    low = at(BOX, [1.0, 1.0, 0.1], [0, 0, -0.1])
    high = at(BOX, [0.1, 0.2, 0.3], [0.2, 0.1, 0.3 - 1e-5], about(2, yaw))
    found = collide(low, high, MARGIN)
    assert len(found) == 4
    assert np.allclose(found.normal, [0, 0, 1], rtol=0.0, atol=ROUNDING)
    assert np.allclose(found.gaps, -1e-5, rtol=0.0, atol=ROUNDING)
    corners = [
        high.origin[:2] + high.turn[:2, :2] @ np.array([x, y])
        for x in (-0.1, 0.1)
        for y in (-0.2, 0.2)
    ]
    # the depth counts from the upper face of the lower box; midway is half of it below
    assert np.allclose(found.places[:, 2], -0.5e-5, rtol=0.0, atol=ROUNDING)
    assert np.allclose(plan(found), sorted(c.tolist() for c in corners), rtol=0.0, atol=1e-13)


def test_crossed_boxes_touch_over_their_common_rectangle():
    low = at(BOX, [1.0, 0.1, 0.1], [0, 0, 0])
    high = at(BOX, [0.1, 1.0, 0.1], [0.3, 0.2, 0.2])
    found = collide(low, high, MARGIN)
    expected = [[0.2, -0.1], [0.2, 0.1], [0.4, -0.1], [0.4, 0.1]]
    # edges are cut ROUNDING of `boxes/faces` beyond the other ones
    assert np.allclose(plan(found), expected, rtol=0.0, atol=1e-12)


def test_eight_corners_of_two_turned_squares_are_reduced_to_four_that_span_most_of_them():
    low = at(BOX, [0.1, 0.1, 0.1], [0, 0, 0])
    high = at(BOX, [0.1, 0.1, 0.1], [0, 0, 0.2], about(2, math.pi / 4))
    found = collide(low, high, MARGIN)
    assert len(found) == 4
    x, y = found.places[np.argsort(np.arctan2(found.places[:, 1], found.places[:, 0])), :2].T
    area = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    octagon = 8.0 * 0.1**2 * (math.sqrt(2.0) - 1.0)
    assert area > 0.6 * octagon  # sqrt(2)/2 of it, at best


def test_crossing_edges_touch_in_one_point_midway():
    low = at(BOX, [1.0, 0.1, 0.1], [0, 0, 0], about(0, math.pi / 4))
    high = at(BOX, [0.1, 1.0, 0.1], [0, 0, 0.2 * math.sqrt(2.0) - 1e-3], about(1, math.pi / 4))
    found = collide(low, high, MARGIN)
    assert len(found) == 1
    assert np.allclose(found.normal, [0, 0, 1], rtol=0.0, atol=ROUNDING)
    assert abs(found.gap + 1e-3) < ROUNDING
    middle = [0, 0, 0.1 * math.sqrt(2.0) - 0.5e-3]
    assert np.allclose(found.places[0], middle, rtol=0.0, atol=ROUNDING)


def test_corner_before_corner_has_the_true_distance():
    gap = 0.004
    one = at(BOX, [0.1, 0.2, 0.3], [0, 0, 0])
    step = gap / math.sqrt(3.0)
    two = at(BOX, [0.3, 0.1, 0.2], [0.4 + step, 0.3 + step, 0.5 + step])
    found = collide(one, two, MARGIN)
    assert len(found) == 1
    assert abs(found.gap - gap) < ROUNDING
    assert np.allclose(found.normal, np.full(3, 1.0 / math.sqrt(3.0)), rtol=0.0, atol=1e-12)


@settings(max_examples=100)
@given(st.tuples(*[st.floats(-1e-6, 1e-6)] * 6), st.floats(0.0, 3.0))
def test_resting_box_keeps_its_points_and_their_names_while_it_trembles(shake, yaw):
    low = at(BOX, [0.1, 0.1, 0.1], [0, 0, 0])
    place = np.array([0.03, 0.02, 0.2 - 1e-5])
    high = at(BOX, [0.08, 0.09, 0.1], place, about(2, yaw))
    before = collide(low, high, MARGIN)
    turn = about(0, shake[3]) @ about(1, shake[4]) @ about(2, shake[5]) @ high.turn
    after = collide(low, Placed(BOX, high.sizes, place + shake[:3], turn), MARGIN)
    assert len(before) == len(after)
    for feature, point, gap in zip(after.features, after.places, after.gaps):
        if feature in before.features:
            k = before.features.tolist().index(feature)
            # a point of the patch moves as the corner of two edges that meet at a flat angle may
            assert np.linalg.norm(point - before.places[k]) < 1e-3
            assert abs(gap - before.gaps[k]) < 2e-6
    assert len(set(before.features) & set(after.features)) >= 3


def test_cube_hardly_off_a_like_one_loses_no_corner():
    """Edges that coincide but for rounding, or for the tolerance of clipping, cross anywhere."""
    rng = np.random.default_rng(1)
    low = at(BOX, [0.1, 0.1, 0.1], [0, 0, 0])
    for _ in range(2000):
        x, y, z = rng.choice([-1.0, 0.0, 1.0], 3) * 10.0 ** rng.uniform(-20, -11, 3)
        turn = np.eye(3) + np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        shift = rng.choice([-1.0, 0.0, 1.0], 2) * 10.0 ** rng.choice([-17, -15, -14, -13], 2)
        shift *= rng.choice([1.0, 1.0 + 1e-4, 1.0 - 1e-4], 2)
        places = collide(low, at(BOX, low.sizes, [*shift, 0.2], turn), MARGIN).places[:, :2]
        # points of an edge that are as good but for LEAD of the area
        assert np.abs(np.abs(places) - 0.1).max() < LEAD * 0.2
        assert len({tuple(signs) for signs in np.sign(places)}) == len(places) == 4


def common_patch(half, corners):
    """What a parallelogram, (4, 3) with gaps in front, has over a rectangle about the origin."""
    for axis, sign in ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)):
        inside = half[axis] - sign * corners[:, axis]
        kept = []
        for k in range(len(corners)):
            here, there = inside[k - 1], inside[k]
            if here >= 0.0:
                kept.append(corners[k - 1])
            if here * there < 0.0:
                share = here / (here - there)
                kept.append(corners[k - 1] + share * (corners[k] - corners[k - 1]))
        corners = np.array(kept).reshape(-1, 3)
    return corners


def area(plan):
    """Of a convex polygon (n, 2), its corners in any order [m^2]."""
    middle = plan.mean(axis=0)
    x, y = plan[np.argsort(np.arctan2(*(plan - middle).T[::-1]))].T - middle[:, None]
    return 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def nearly_flush_boxes(n, seed):
    """Yield flat box, box upon it, hardly tilted, and the corners of what they have in common."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        below = np.exp(rng.uniform(-2.0, 1.0, 3))
        above = below.copy() if rng.random() < 0.5 else np.exp(rng.uniform(-2.0, 1.0, 3))
        small = min(*below[:2], *above[:2])
        yaw = rng.choice([0.0, 10.0 ** rng.uniform(-14, -2), 0.5 * np.pi, rng.uniform(-3, 3)])
        tilt = rng.choice([0.0, 10.0 ** rng.uniform(-16, -4)]) * rng.normal(size=2)
        shift = rng.choice([0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.3]) * small * rng.normal(size=2)
        if rng.random() < 0.3:  # one side flush
            shift[0] = below[0] - above[0]
        turn = about(0, tilt[0]) @ about(1, tilt[1]) @ about(2, yaw)
        low = at(BOX, below, [0, 0, -below[2]])
        high = at(BOX, above, [*shift, above[2] * turn[2, 2]], turn)
        signs = np.array([[1, 1, -1], [-1, 1, -1], [-1, -1, -1], [1, -1, -1]])
        yield low, high, common_patch(below[:2], high.origin + (signs * above) @ turn.T), yaw


def test_box_is_held_at_the_deepest_corner_of_the_patch_and_at_three_that_lie_far_apart():
    """Edges that nearly coincide cross somewhere, close to a corner or halfway between two."""
    compared = 0
    for low, high, patch, yaw in nearly_flush_boxes(1200, 5):
        found = collide(low, high, 1.0)
        if not np.array_equal(found.normal, [0, 0, 1]) or len(patch) < 3:
            continue  # a side of the upper one is the reference
        compared += 1
        extent = np.ptp(patch[:, :2], axis=0).max()
        # round-off of sizes of metres, and of depths that count as the same
        assert abs(found.gap - patch[:, 2].min()) < 1e-12
        ways = [a - b for i, a in enumerate(found.places) for b in found.places[:i]]
        assert len(ways) == 0 or np.linalg.norm(ways, axis=1).min() > 1e-6 * extent
        whole = area(patch[:, :2])
        if whole < 1e-4 * extent * extent:
            continue
        held = area(found.places[:, :2])
        # a regular octagon has sqrt(2)/2 in a square; where the deepest lies between two corners,
        # a triangle is lost
        assert held > 0.5 * whole
        if 0.0 <= yaw < 1e-4 or yaw == 0.5 * np.pi:  # as good as a rectangle
            is_flat = np.ptp(patch[:, 2]) < 1e-13 * extent
            assert held > (0.99 if is_flat else 0.74) * whole
    assert compared > 600


def test_depth_changes_no_faster_than_the_boxes_move():
    """The deepest gap is 1-Lipschitz in the position, up to the lead of sides over edges."""
    rng = np.random.default_rng(3)
    for turn_a, turn_b in zip(random_turns(rng, 200), random_turns(rng, 200)):
        a = at(BOX, [0.1, 0.2, 0.15], [0, 0, 0], turn_a)
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        last = None
        for depth in np.arange(0.0, 0.05, 5e-4):
            b = at(BOX, [0.2, 0.1, 0.1], direction * (0.4 - depth), turn_b)
            found = collide(a, b, MARGIN)
            if not len(found):
                last = None
                continue
            if last is not None:
                assert abs(found.gap - last) < 5e-4 + 1.2e-4 + 0.06 * abs(found.gap)
            last = found.gap


# capsules


def test_capsule_lying_on_a_box_touches_at_both_ends_of_the_stretch_above_it():
    box = at(BOX, [0.2, 0.2, 0.1], [0, 0, 0])
    capsule = at(CAPSULE, [0.05, 0.3], [0.1, 0, 0.15 - 1e-4], LYING)
    found = collide(capsule, box, MARGIN)
    assert np.allclose(plan(found), [[-0.2, 0.0], [0.2, 0.0]], rtol=0.0, atol=ROUNDING)
    assert np.allclose(found.normal, [0, 0, -1], rtol=0.0, atol=ROUNDING)
    assert np.allclose(found.gaps, -1e-4, rtol=0.0, atol=ROUNDING)


def test_capsule_along_an_edge_touches_in_two_points():
    box = at(BOX, [0.2, 0.1, 0.1], [0, 0, 0])
    reach = 0.1 + 0.05 / math.sqrt(2.0)
    found = collide(at(CAPSULE, [0.05, 0.1], [0.02, reach, reach], LYING), box, MARGIN)
    assert np.allclose(np.sort(found.places[:, 0]), [-0.08, 0.12], rtol=0.0, atol=ROUNDING)
    assert np.allclose(found.normal, [0, -math.sqrt(0.5), -math.sqrt(0.5)], rtol=0.0, atol=1e-12)


def test_capsule_across_an_edge_touches_in_one_point():
    box = at(BOX, [0.2, 0.1, 0.1], [0, 0, 0], about(0, math.pi / 4))
    top = 0.1 * math.sqrt(2.0)
    found = collide(
        at(CAPSULE, [0.05, 0.3], [0, 0.0, top + 0.05], about(0, 0.5 * math.pi)), box, 1e-4
    )
    assert len(found) == 1
    assert np.allclose(found.places[0], [0, 0, top], rtol=0.0, atol=ROUNDING)


def test_capsule_through_a_box_leaves_by_the_nearest_side():
    box = at(BOX, [0.2, 0.3, 0.1], [0, 0, 0])
    found = collide(at(CAPSULE, [0.05, 0.5], [0, 0, 0.02], LYING), box, MARGIN)
    assert np.allclose(found.normal, [0, 0, -1], rtol=0.0, atol=ROUNDING)
    assert np.allclose(found.gaps, -0.13, rtol=0.0, atol=ROUNDING)
    assert np.allclose(np.sort(found.places[:, 0]), [-0.2, 0.2], rtol=0.0, atol=ROUNDING)


@pytest.mark.parametrize('flip', [1.0, -1.0])
def test_parallel_capsules_touch_at_both_ends_of_the_stretch_side_by_side(flip):
    one = at(CAPSULE, [0.05, 0.3], [0, 0, 0], LYING)
    two = at(CAPSULE, [0.07, 0.2], [0.2, 0, 0.12], LYING * np.array([flip, 1.0, flip]))
    found = collide(one, two, MARGIN)
    assert np.allclose(plan(found), [[0.0, 0.0], [0.3, 0.0]], rtol=0.0, atol=ROUNDING)
    assert np.allclose(found.places[:, 2], 0.05, rtol=0.0, atol=ROUNDING)


def test_crossed_capsules_touch_in_one_point():
    one = at(CAPSULE, [0.05, 0.3], [0, 0, 0], LYING)
    two = at(CAPSULE, [0.07, 0.2], [0.1, 0.05, 0.12], about(2, 1.0) @ LYING)
    found = collide(one, two, MARGIN)
    assert len(found) == 1
    assert np.allclose(found.normal, [0, 0, 1], rtol=0.0, atol=ROUNDING)


# cylinder on plane


def test_lying_cylinder_rolls_without_bumps():
    """At every angle: the two ends of its lowest line, a radius below the axis."""
    rng = np.random.default_rng(4)
    for angle in rng.uniform(-10.0, 10.0, 1000):
        turn = about(0, angle) @ LYING
        found = collide(at(CYLINDER, [0.1, 0.3], [0, 0, 0.1 - 1e-5], turn), GROUND, MARGIN)
        assert np.allclose(plan(found), [[-0.3, 0], [0.3, 0]], rtol=0.0, atol=ROUNDING)
        assert np.allclose(found.gaps, -1e-5, rtol=0.0, atol=ROUNDING)
        assert sorted(found.features) == [0.0, 1.0]


@pytest.mark.parametrize('tilt', [1e-3, 0.02, 0.7, 1.4])
@pytest.mark.parametrize('upside', [1.0, -1.0])
def test_tilted_coin_touches_with_the_true_lowest_point_of_its_rim(tilt, upside):
    radius, half = 0.012, 0.001
    for heading in np.linspace(-3.0, 3.0, 50):
        for spin in (0.0, 1.0, 2.5):
            turn = (
                about(2, heading) @ about(1, tilt) @ about(2, spin) * np.array([1, upside, upside])
            )
            height = radius * math.sin(tilt) + half * math.cos(tilt)
            found = collide(at(CYLINDER, [radius, half], [1, 2, height], turn), GROUND, MARGIN)
            lowest = int(np.argmin(found.gaps))
            assert abs(found.gap) < ROUNDING
            assert found.features[lowest] == (upside < 0.0)  # an end keeps its name while it rolls
            arm = radius * math.cos(tilt) - half * math.sin(tilt)
            place = [1 + arm * math.cos(heading), 2 + arm * math.sin(heading), 0.0]
            assert np.allclose(found.places[lowest], place, rtol=0.0, atol=1e-13)


def test_standing_cylinder_rests_on_four_points_a_quarter_turn_apart():
    found = collide(at(CYLINDER, [0.1, 0.3], [0, 0, 0.3], about(2, 0.4)), GROUND, MARGIN)
    assert len(found) == 4
    c, s = 0.1 * math.cos(0.4), 0.1 * math.sin(0.4)
    expected = sorted([[c, s], [-s, c], [-c, -s], [s, -c]])
    assert np.allclose(plan(found), expected, rtol=0.0, atol=1e-13)


@settings(max_examples=100)
@given(
    st.tuples(st.floats(-3e-5, 3e-5), st.floats(-3e-5, 3e-5)), st.sampled_from([1e-9, 1e-6, 1e-5])
)
def test_standing_cylinder_keeps_its_points_while_it_trembles(tilt, shake):
    def stand(x, y):
        turn = about(0, x) @ about(1, y) @ about(2, 0.4)
        return collide(at(CYLINDER, [0.1, 0.3], [0, 0, 0.3], turn), GROUND, MARGIN)

    one, two = stand(*tilt), stand(tilt[0] + shake, tilt[1] - shake)
    places = dict(zip(two.features, two.places))
    assert set(one.features) == set(two.features)
    for feature, place in zip(one.features, one.places):
        # up to a third of FLAT the blend turns by at most shake / (FLAT / 3) · sqrt(2), twice that
        # where it changes the axis it leans on
        jump = np.linalg.norm(place - places[feature])
        assert jump < 0.1 * (6.0 * shake / rim.FLAT + 0.8)


def test_cylinder_of_any_tilt_is_as_deep_as_its_true_lowest_point():
    for tilt in (0.0, 1e-12, 3e-5, 9e-5, 1.1e-4, 1e-2, 1.0, math.pi / 2):
        height = 0.1 * math.sin(tilt) + 0.3 * math.cos(tilt)
        for spin in np.linspace(0.0, 6.0, 20):
            turn = about(1, tilt) @ about(2, spin)
            found = collide(at(CYLINDER, [0.1, 0.3], [0, 0, height], turn), GROUND, MARGIN)
            # below FLAT the points lean on axes fixed in the end
            missed = 0.3 * 0.1 * min(tilt, rim.FLAT) if tilt < rim.FLAT else 0.0
            assert -ROUNDING < found.gap < missed + ROUNDING


# choice of four


def reduced(points, gaps):
    found = np.zeros(FOUND)
    found[2] = 1.0
    for k, (point, gap) in enumerate(zip(points, gaps)):
        found[SCRATCH + k * POINT : SCRATCH + (k + 1) * POINT] = [*point, gap, k]
    count = keep_four(argument(found), SCRATCH, len(points))
    return found[POINTS + 4 : POINTS + POINT * count : POINT].astype(int).tolist()


def test_of_many_points_the_deepest_the_farthest_and_the_widest_are_kept():
    rng = np.random.default_rng(6)
    for _ in range(200):
        n = int(rng.integers(1, 13))
        points, gaps = np.column_stack((rng.normal(size=(n, 2)), np.zeros(n))), rng.normal(size=n)
        kept = reduced(points, gaps)
        assert len(kept) == len(set(kept)) <= 4
        deepest = int(np.argmin(gaps))  # no two are within a tie here
        assert kept[0] == deepest
        if n == 1:
            continue
        reach = np.linalg.norm(points - points[deepest], axis=1)
        assert reach[kept[1]] >= (1.0 - LEAD) * np.max(reach)
        along = points[kept[1]] - points[deepest]
        areas = [np.cross(along, p - points[deepest])[2] for p in points]
        widest = [areas[k] for k in kept] + [0.0]
        assert max(widest) >= (1.0 - LEAD) * max(areas)
        assert min(widest) <= (1.0 - LEAD) * min(areas)


def test_points_that_coincide_or_lie_on_a_line_are_kept_once():
    assert reduced([[1, 2, 0]] * 6, [0.0] * 6) == [0]
    line = [[x, 2.0 * x, 0.0] for x in (0.0, 1.0, 3.0, 2.0, 3.0)]
    assert reduced(line, [0.0] * 5) == [0, 2]


def remember(found, held):
    """
    What the points of the last tick were.
    """
    found[HELD_COUNT] = len(held)
    found[HELD : HELD + len(held)] = held


def extremes(points, gaps, held=()):
    found = np.zeros(FOUND)
    remember(found, held)
    found[2] = 1.0
    for k, (point, gap) in enumerate(zip(points, gaps)):
        found[SCRATCH + k * POINT : SCRATCH + (k + 1) * POINT] = [*point, gap, k]
    count = keep_extremes(argument(found), SCRATCH, len(points), (1.0, 0.3, 0.0))
    return found[POINTS + 4 : POINTS + POINT * count : POINT].astype(int).tolist()


def flat_ones(points, gaps, held=()):
    found = np.zeros(FOUND)
    remember(found, held)
    for k, ((u, v, _), gap) in enumerate(zip(points, gaps)):
        place = SCRATCH + k * FLAT_POINT
        found[place : place + FLAT_POINT] = [u, v, gap, k]
    to = SCRATCH + FLAT_POINT * len(points)
    count = keep_four_flat(argument(found), SCRATCH, len(points), to, 0.0)
    return found[to + 3 : to + FLAT_POINT * count : FLAT_POINT].astype(int).tolist()


@pytest.mark.parametrize('draws', [100, pytest.param(300, marks=pytest.mark.long)])
@pytest.mark.parametrize('chosen', [extremes, flat_ones])
def test_what_presses_is_kept_before_what_is_apart_wherever_it_lies(chosen, draws):
    rng = np.random.default_rng(8)
    for _ in range(draws):
        n = int(rng.integers(5, 13))
        points = np.column_stack((rng.normal(size=(n, 2)), np.zeros(n)))
        skin = SKIN * max(np.abs(points - points[0]).max(), 1e-9)
        near = rng.random(n) < rng.random()
        gaps = np.where(near, rng.uniform(-20.0, 1.0, n), rng.uniform(2.0, 30.0, n)) * skin
        kept = chosen(points, gaps)
        assert len(kept) == len(set(kept)) <= 4
        among = set(np.flatnonzero(near).tolist())
        assert among <= set(kept) if len(among) <= 4 else set(kept) <= among


def corners(rng):
    """
    The corners of a face, in order: up to twelve on a ring that is not round.
    """
    n = int(rng.integers(5, 13))
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, n))
    return np.column_stack((np.cos(angle), rng.uniform(0.3, 1.0) * np.sin(angle), np.zeros(n)))


@pytest.mark.parametrize('chosen', [extremes, flat_ones])
def test_what_was_held_is_held_while_a_body_trembles(chosen):
    """
    By a third of DEEPER, as seen from the first; what is not told forgets, now and then.
    """
    rng = np.random.default_rng(9)
    forgot = 0
    for _ in range(300):
        points = corners(rng)
        tremble = DEEPER / 3.0 * np.abs(points - points[0]).max()
        gaps = tremble * rng.uniform(-1.0, 0.0, len(points))
        held = first = chosen(points, gaps)
        for _ in range(5):
            gaps = tremble * rng.uniform(-1.0, 0.0, len(points))
            held = chosen(points, gaps, held)
            assert sorted(held) == sorted(first)
        turned = points + np.array([[0.0, 1.0, 0.0]]) * 1e-3 * rng.normal(size=(len(points), 1))
        assert sorted(chosen(turned, gaps, held)) == sorted(first)
        forgot += sorted(chosen(turned, gaps)) != sorted(first)
    assert forgot > 0


@pytest.mark.parametrize(('chosen', 'deeper'), [(extremes, MUCH_DEEPER), (flat_ones, DEEPER)])
def test_what_was_held_gives_way_to_what_is_deeper_and_to_what_spans_more(chosen, deeper):
    """
    What is deepest by more than so much is among the points, whatever was held; and so are those
    that span much more than four that lie in a corner.
    """
    rng = np.random.default_rng(10)
    for _ in range(300):
        points = corners(rng)
        extent = np.abs(points - points[0]).max()
        gaps = np.zeros(len(points))
        held = rng.choice(len(points), 4, replace=False).tolist()
        deepest = int(rng.integers(len(points)))
        gaps[deepest] = -1.1 * deeper * extent
        assert deepest in chosen(points, gaps, held)
    ring = np.array([[np.cos(t), np.sin(t), 0.0] for t in np.arange(12) * np.pi / 6.0])
    spans = chosen(ring, [0.0] * 12)
    assert sorted(chosen(ring, [0.0] * 12, [0, 1, 2, 3])) == sorted(spans)
