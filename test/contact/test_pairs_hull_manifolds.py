# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where polyhedra touch, and that it depends on nothing but where they are to each other."""

import itertools

import numpy as np
import pytest

from rigid_body_sim.physics.contact.collision.collider import CYLINDER, HULL, PLANE
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls, two_polyhedra
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.extreme_points import MUCH_DEEPER
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import packed
from rigid_body_sim.physics.model import rotation as so3

from .hull_cases import (
    PAIRS,
    Shape,
    box,
    capsule,
    collide,
    cylinder,
    hull,
    name,
    random_cases,
    random_turns,
    sphere,
)

MARGIN = 0.1  # [m]
ROUND_OFF = 1e-11  # [m] of coordinates of metres, and of directions over tenths of a metre
CUBE = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
UPRIGHT = np.eye(3)


def at(x, y, z, turn=UPRIGHT):
    return np.concatenate(((x, y, z), np.asarray(turn).ravel()))


def about(axis, angle):
    axis = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    return so3.matrix_from_quaternion((*np.sin(0.5 * angle) * axis, np.cos(0.5 * angle)))


def corners(found):
    return sorted(map(tuple, np.round(found.places, 9).tolist()))


@pytest.mark.parametrize('gap', (-1e-3, -1e-6, 0.0, 1e-6, 1e-3))
@pytest.mark.parametrize('lower', (hull(2.0 * CUBE), box((1.0, 1.0, 1.0))), ids=('hull', 'box'))
def test_a_cube_on_a_larger_one_stands_on_its_four_corners(lower, gap):
    found = collide(lower, hull(CUBE), at(0, 0, 0), at(0.2, 0.1, 1.5 + gap), 0.01)
    assert np.allclose(found.normal, (0, 0, 1), rtol=0.0, atol=1e-15)
    assert np.allclose(found.gaps, gap, rtol=0.0, atol=1e-15)
    middle = 1.0 + 0.5 * gap
    expected = [(x, y, middle) for x in (-0.3, 0.7) for y in (-0.4, 0.6)]
    assert np.allclose(corners(found), expected, rtol=0.0, atol=1e-9)
    assert len(set(found.features)) == 4


def test_a_cube_over_the_rim_stands_on_what_lies_under_it():
    found = collide(hull(CUBE), hull(CUBE), at(0, 0, 0), at(0.7, 0.0, 0.999), 0.01)
    expected = [(x, y, 0.4995) for x in (0.2, 0.5) for y in (-0.5, 0.5)]
    # Sides stand off by 1e-6 of the half width, so that flush faces keep their corners.
    assert np.allclose(corners(found), expected, rtol=0.0, atol=1e-6)


def test_crossed_edges_touch_in_one_place_along_their_common_normal():
    lower = at(0, 0, 0, about((1, 0, 0), np.pi / 4))
    upper = at(0, 0, np.sqrt(2) - 0.002, about((0, 1, 0), np.pi / 4))
    found = collide(hull(CUBE), hull(CUBE), lower, upper, 0.0)
    assert np.allclose(found.normal, (0, 0, 1), rtol=0.0, atol=1e-14)
    assert found.gap == pytest.approx(-0.002, abs=1e-14)
    deepest = found.places[np.argmin(found.gaps)]
    assert np.allclose(deepest, (0, 0, np.sqrt(0.5) - 0.001), rtol=0.0, atol=1e-6)


def test_corner_above_a_corner_is_as_far_as_the_corners_are():
    tip = about((1, -1, 0), np.arccos(1.0 / np.sqrt(3)))  # a corner of the cube points along z
    lower, upper = at(0, 0, 0, tip), at(0.0, 0.0, np.sqrt(3) + 0.05, tip)
    found = collide(hull(CUBE), hull(CUBE), lower, upper, 0.06)
    assert found.gap == pytest.approx(0.05, abs=1e-14)
    assert np.allclose(found.normal, (0, 0, 1), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize('shape', (hull(2.0 * CUBE), cylinder(1.0, 1.0)), ids=('hull', 'cylinder'))
def test_a_lying_capsule_touches_at_both_ends(shape):
    lying = at(0.1, 0.0, 1.25 - 1e-4, about((0, 1, 0), np.pi / 2))
    found = collide(capsule(0.25, 0.5), shape, lying, at(0, 0, 0), 0.01)
    assert np.allclose(found.normal, (0, 0, -1), rtol=0.0, atol=1e-14)
    assert np.allclose(found.gaps, -1e-4, rtol=0.0, atol=1e-14)
    expected = [(-0.4, 0.0, 1.0 - 5e-5), (0.6, 0.0, 1.0 - 5e-5)]
    assert np.allclose(corners(found), expected, rtol=0.0, atol=1e-9)


def test_stacked_cylinders_carry_each_other_on_a_patch_around_the_axis():
    can = cylinder(0.5, 0.5)
    found = collide(can, can, at(0, 0, 0), at(0.01, 0.0, 1.0 - 1e-5, about((0, 0, 1), 0.3)), 0.01)
    assert len(found) == 4
    assert np.allclose(found.normal, (0, 0, 1), rtol=0.0, atol=1e-15)
    assert np.allclose(found.gaps, -1e-5, rtol=0.0, atol=1e-14)
    around = np.sort(np.arctan2(found.places[:, 1], found.places[:, 0]))
    assert np.all(np.diff([*around, around[0] + 2 * np.pi]) < 0.6 * np.pi)
    assert np.all(np.hypot(*found.places[:, :2].T) > 0.45)


def test_a_tilted_hull_on_a_plane_reports_the_corners_within_the_margin_and_no_others():
    plane = Shape(PLANE, np.array([0.0, 0.0, 1.0, 0.25]))
    tilt = 0.004
    found = collide(hull(CUBE), plane, at(3, 4, 0.75, about((0, 1, 0), tilt)), at(0, 0, 0), 0.001)
    depth = 0.5 * (1.0 - np.cos(tilt)) - 0.5 * np.sin(tilt)
    assert len(found) == 2
    assert np.allclose(found.gaps, depth, rtol=0.0, atol=1e-15)
    assert np.array_equal(found.normal, (0, 0, -1))
    assert np.allclose(found.places[:, 2], 0.25 + 0.5 * depth, rtol=0.0, atol=1e-15)


DRAWS = pytest.mark.parametrize('draws', [30, pytest.param(300, marks=pytest.mark.long)])


@DRAWS
def test_of_many_corners_near_a_plane_the_one_that_comes_down_first_is_a_point(draws):
    """
    A hull of fourteen corners, all within the margin, turns by up to 0.4 rad in the tick.
    """
    rng = np.random.default_rng(5)
    plane = Shape(PLANE, np.array([0.0, 0.0, 1.0, 0.0]))
    for turn in random_turns(rng, draws):
        body = hull(0.1 * rng.normal(size=(14, 3)))
        shift, turned = 0.01 * rng.normal(size=3), rng.uniform(-0.2, 0.2, 3)
        origin = np.array([0.0, 0.0, 0.2])
        pose = at(*origin, turn)
        found = collide(body, plane, pose, at(0, 0, 0), 1.0, (*shift, *turned))
        angle = np.linalg.norm(turned)
        places = body.vertices @ turn.T
        now = origin[2] + places[:, 2]
        after = origin[2] + shift[2] + (places @ about(turned, angle).T)[:, 2]
        lowest = np.minimum(now, after)
        of_points = lowest[(found.features / 3.0).astype(int)]
        # the kernel turns by 2 atan(theta/2) in place of theta: 4e-3 rad of 0.35
        assert of_points.min() < lowest.min() + 2e-3


BLOCK, SLAB = hull(CUBE * (6, 5, 2)), box((3.0, 2.5, 1.0))


@pytest.mark.parametrize('draws', [25, pytest.param(60, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ('ground', 'kind'), [(BLOCK, 'hull'), (BLOCK, 'cylinder'), (SLAB, 'hull')],
    ids=('hull-hull', 'hull-cylinder', 'box-hull'),
)  # fmt: skip
def test_over_the_middle_of_a_face_a_polyhedron_is_ground_as_a_plane_is(ground, kind, draws):
    """
    Points, gaps, normal and features are those of the plane of the face.
    """
    rng = np.random.default_rng(8)
    for turn, of_ground in zip(*(random_turns(rng, draws) for _ in range(2)), strict=True):
        body = hull(0.1 * rng.normal(size=(14, 3))) if kind == 'hull' else cylinder(0.2, 0.05)
        x, y = rng.uniform(-1.0, 1.0, 2)
        place = of_ground @ (x, y, 1.0 + rng.uniform(0.15, 0.35)) + (1.0, 2.0, 3.0)
        out = of_ground[:, 2]
        plane = Shape(PLANE, np.array([*out, 1.0 + out @ (1.0, 2.0, 3.0)]))
        on_plane = collide(body, plane, at(*place, turn), at(0, 0, 0), 0.1)
        if ground.kind == HULL:
            found = collide(body, ground, at(*place, turn), at(1, 2, 3, of_ground), 0.1)
        else:
            found = collide(ground, body, at(1, 2, 3, of_ground), at(*place, turn), 0.1)
            found.normal *= -1.0
        assert len(found) == len(on_plane)
        if len(found):
            assert np.allclose(found.normal, on_plane.normal, rtol=0.0, atol=ROUND_OFF)
            assert np.allclose(found.gaps, on_plane.gaps, rtol=0.0, atol=ROUND_OFF)
            assert np.allclose(found.places, on_plane.places, rtol=0.0, atol=ROUND_OFF)
            assert np.array_equal(found.features, on_plane.features)


@DRAWS
@pytest.mark.parametrize('pair', PAIRS, ids=name)
def test_manifold_moves_with_the_two_shapes(pair, draws):
    rng = np.random.default_rng(11)
    turns, shifts = random_turns(rng, draws), rng.normal(size=(draws, 3))
    for (a, b, *poses), turn, shift in zip(random_cases(pair, draws, rng), turns, shifts):
        moved = [
            np.concatenate((turn @ p[:3] + shift, (turn @ p[3:].reshape(3, 3)).ravel()))
            for p in poses
        ]
        here, there = collide(a, b, *poses, MARGIN), collide(a, b, *moved, MARGIN)
        assert len(here) == len(there)
        if len(here):
            assert np.allclose(there.normal, turn @ here.normal, rtol=0.0, atol=1e-9), (a, b)
            # on an end that is flush all four are the lowest: rounding tells which comes first
            one, other = np.argsort(here.features), np.argsort(there.features)
            gaps, places = here.gaps[one], here.places[one] @ turn.T + shift
            assert np.allclose(there.gaps[other], gaps, rtol=0.0, atol=ROUND_OFF), (a, b)
            assert np.allclose(there.places[other], places, rtol=0.0, atol=100 * ROUND_OFF), (a, b)


@pytest.mark.parametrize('pair', [(HULL, HULL), (CYLINDER, CYLINDER)], ids=name)
@pytest.mark.parametrize('draws', [200, pytest.param(500, marks=pytest.mark.long)])
def test_exchanging_the_two_shapes_turns_the_normal(pair, draws):
    rng = np.random.default_rng(12)
    same = hits = 0
    for a, b, pose_a, pose_b in random_cases(pair, draws, rng):
        one, other = collide(a, b, pose_a, pose_b, MARGIN), collide(b, a, pose_b, pose_a, MARGIN)
        assert (len(one) > 0) == (len(other) > 0) or abs(one.gap - MARGIN) < 1e-3
        if not len(one) or not len(other):
            continue
        # A face of B must beat one of A by FACE_LEAD, so the two may choose differently.
        half = min(a.half_width, b.half_width)
        lead = (two_polyhedra.EDGE_LEAD + 2.0 * two_polyhedra.FACE_LEAD) * half
        lead += 3.0 * MUCH_DEEPER * min(a.reach, b.reach)
        lead += 2.2 * two_polyhedra.EDGE_SHARE * max(0.0, -one.gap)
        assert abs(one.gap - other.gap) < lead
        hits += 1
        same += np.allclose(one.normal, -other.normal, rtol=0.0, atol=1e-9)
    assert same > 0.9 * hits > 0.18 * draws


def test_a_million_metres_from_the_origin_the_manifold_is_the_same():
    rng = np.random.default_rng(13)
    far = np.array([2.0**20, -(2.0**20), 2.0**19])  # a million metres, in round binary numbers
    for a, b, *poses in random_cases((HULL, HULL), 300, rng):
        for pose in poses:
            pose[:3] = np.round(pose[:3] * 2.0**30) / 2.0**30
        here = collide(a, b, *poses, MARGIN)
        there = collide(a, b, *(pose + np.r_[far, np.zeros(9)] for pose in poses), MARGIN)
        # Differences come first: no bit of gap and normal is lost.
        assert np.array_equal(there.gaps, here.gaps)
        assert np.array_equal(there.features, here.features)
        assert not len(here) or np.array_equal(there.normal, here.normal)
        assert np.allclose(there.places - far, here.places, rtol=0.0, atol=1e-9)  # rounded there


def test_a_hull_far_from_the_origin_of_its_shape_meets_as_if_it_were_near():
    rng = np.random.default_rng(14)
    offset = np.array([3e3, -2e3, 1e3])
    points = rng.normal(size=(20, 3))
    near, far = hull(points), hull(points + offset)
    for a, b, *poses in random_cases((HULL, HULL), 200, rng):
        turn = poses[1][3:].reshape(3, 3)
        middle = poses[1][:3] + turn @ b.middle
        here = collide(a, near, poses[0], at(*middle, turn), MARGIN)
        there = collide(a, far, poses[0], at(*(middle - turn @ offset), turn), MARGIN)
        # Coordinates of 3 km are rounded to 5e-13 m.
        assert len(here) == len(there)
        assert np.allclose(here.gaps, there.gaps, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize('draws', [25, pytest.param(60, marks=pytest.mark.long)])
def test_small_motion_changes_the_smallest_gap_by_as_little(draws):
    """Gap and depth are continuous through touching, apart from the gains of the edges."""
    rng = np.random.default_rng(15)
    for a, b, pose_a, pose_b in random_cases((HULL, HULL), draws, rng):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        half = min(a.half_width, b.half_width)
        before = None
        for step in np.linspace(-0.02, 0.02, 81):
            moved = pose_b + np.r_[direction * step, np.zeros(9)]
            gap = collide(a, b, pose_a, moved, 10.0).gap
            if before is not None:
                lead = (two_polyhedra.EDGE_LEAD + two_polyhedra.FACE_LEAD) * half
                lead += 1.1 * two_polyhedra.EDGE_SHARE * max(0.0, -gap)
                lead += 3.0 * MUCH_DEEPER * min(a.reach, b.reach)
                assert abs(gap - before) < 0.0005 * (1 + 1e-9) + lead, (a, b, step)
            before = gap


def test_a_large_mesh_meets_as_its_hull_of_few_corners_does():
    # A cube with each side a grid of 20 x 20 triangles' corners: one polygon a side.
    line = np.linspace(-0.5, 0.5, 20)
    grid = np.array([p for p in itertools.product(line, repeat=3) if max(map(abs, p)) == 0.5])
    many, few = hull(grid), hull(CUBE)
    assert len(packed(many.solid)) == len(packed(few.solid))
    assert len(hulls.hull(grid).vertices) == 8


def test_features_stay_with_their_corners_while_a_body_slides():
    before = None
    for step in range(20):
        x = 0.7 + 1e-3 * step
        found = collide(hull(CUBE), hull(CUBE), at(0, 0, 0), at(x, 0.2, 0.999), 0.01)
        here = dict(zip(found.features.tolist(), found.places))
        assert len(here) == 4
        if before is not None:
            assert here.keys() == before.keys()
            for feature, place in here.items():
                assert np.linalg.norm(place - before[feature]) < 1.01e-3
        before = here


@pytest.mark.parametrize('beyond', [3e-6, 2e-5, 9e-5])
@pytest.mark.parametrize('round_one', [sphere(0.1), capsule(0.1, 0.2)], ids=['ball', 'capsule'])
def test_what_is_past_the_border_of_a_face_by_less_than_flush_has_its_normal(round_one, beyond):
    """
    Past it by `beyond` of the radius, where the next tile lies flush. The gap is the true one.
    """
    height = 0.1 + 1e-5
    pose = at(0.5 + 0.1 * beyond, 0.1, 0.5 + height, about((1, 0, 0), np.pi / 2))
    found = collide(round_one, hull(CUBE), pose, at(0, 0, 0), 0.01)
    assert np.array_equal(np.abs(found.normal), (0, 0, 1))
    true = np.hypot(height, 0.1 * beyond) - 0.1
    assert found.gap == pytest.approx(true, abs=1e-11)
