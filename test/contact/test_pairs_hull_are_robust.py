# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whatever polyhedra are and wherever they lie, a kernel answers with a manifold or with none, the
same bits with and without numba.
"""

import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    HULL,
    PLANE,
    SPHERE,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import NEAR, packed
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hulls import hull as hull_of
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3

from .. import inside
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
    sphere,
)

MARGIN = 0.01  # [m]

SCALES = st.sampled_from((1e-160, 1e-6, 0.1, 1.0, 1e6, 1e30, 1e160))
THICK = st.sampled_from((1.0, 1.0, 0.3, 1e-3, 1e-6, 1e-9, 1e-11))  # of flat bodies and needles
COORDINATES = st.one_of(st.floats(-1.0, 1.0), st.sampled_from((0.0, 1.0, -1.0, 1e-9, 1.0 - 1e-9)))
POINTS = st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES), min_size=4, max_size=14)
SHARES = st.one_of(
    st.sampled_from((0.0, 1e-300, 1e-17, 1e-9, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 2.0)),
    st.floats(-2.0, 2.0),
)
OFFSETS = st.sampled_from((0.0, 0.0, 1.0, -1e6, 1e15))
AXES = st.sampled_from(((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (1, 1, 1)))
ANGLES = st.one_of(
    st.sampled_from((0.0, 1e-300, 1e-17, 1e-9, 1e-4, np.pi / 4, np.pi / 2, np.pi)),
    st.floats(-4.0, 4.0),
)


def turned(axis, angle):
    """Return the rotation by an angle about an axis."""
    axis = np.asarray(axis) / np.linalg.norm(axis)
    return so3.matrix_from_quaternion((*np.sin(0.5 * angle) * axis, np.cos(0.5 * angle)))


TURNS = st.builds(turned, AXES, ANGLES)


@st.composite
def hard_hulls(draw):
    """Flat, needle, with coincident points, of few points, far from the origin of their shape."""
    size = draw(SCALES) * np.array([1.0, draw(THICK), draw(THICK)])
    points = np.array(draw(POINTS)) * size + draw(OFFSETS) * size[0]
    try:
        return hull(points)
    except InvalidModel:  # they span no solid
        corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
        return hull(corners * size)


@st.composite
def hard_pairs(draw):
    pair = draw(st.sampled_from((*PAIRS, (HULL, HULL), (HULL, HULL))))
    a, b = (draw(hard_shapes(kind)) for kind in pair)
    if a.kind == b.kind and draw(st.booleans()):
        b = a
    scale = draw(st.sampled_from((a.reach + b.reach, a.reach, min(a.half_width, b.half_width))))
    middle = np.array(draw(st.tuples(OFFSETS, OFFSETS, OFFSETS)))
    turn_a = draw(TURNS)
    along = turn_a @ np.array(draw(st.tuples(SHARES, SHARES, SHARES))) * scale
    return a, b, middle, along, turn_a, turn_a @ draw(TURNS)


@st.composite
def hard_shapes(draw, kind):
    if kind == HULL:
        return draw(hard_hulls())
    # thinner than a hull may be: the square of its ratio is subnormal
    thick = st.one_of(THICK, st.just(1e-160))
    sizes = draw(SCALES) * np.array([1.0, draw(thick), draw(thick)])
    if kind == SPHERE:
        return sphere(sizes[0])
    if kind == CAPSULE:
        return capsule(sizes[0], sizes[1])
    return box(sizes) if kind == BOX else cylinder(sizes[0], sizes[1])


def check(found, case):
    assert 0 <= len(found) <= 4, case
    if len(found):
        assert abs(np.linalg.norm(found.normal) - 1.0) < 1e-12, (case, found)
        assert np.all(np.isfinite(found.places)) and np.all(np.isfinite(found.features)), case
        assert np.all(found.gaps <= MARGIN) and np.all(np.isfinite(found.gaps)), (case, found)
        assert len(set(found.features)) == len(found), (case, found)


@pytest.mark.parametrize('draws', [30, pytest.param(300, marks=pytest.mark.long)])
def test_a_manifold_is_finite_and_within_the_margin_for_any_polyhedra(draws):
    @settings(max_examples=draws)
    @given(hard_pairs())
    def holds(case):
        a, b, middle, along, turn_a, turn_b = case
        pose_a = np.concatenate((middle - turn_a @ a.middle, turn_a.ravel()))
        pose_b = np.concatenate((middle + along - turn_b @ b.middle, turn_b.ravel()))
        check(collide(a, b, pose_a, pose_b, MARGIN), case)

    holds()


@pytest.mark.parametrize('size', [1e-160, 1e-154])
def test_the_normal_of_a_cylinder_whose_square_lost_digits_is_a_unit_vector(size):
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * size
    turn = np.eye(3).ravel()
    pose_b = np.concatenate(([0.0, 1.57313218 * size, 0.0], turn))
    pose_a = np.concatenate((np.zeros(3), turn))
    found = collide(cylinder(size, size), hull(corners), pose_a, pose_b, MARGIN)
    assert len(found)
    check(found, size)


@pytest.mark.parametrize('draws', [40, pytest.param(100, marks=pytest.mark.long)])
def test_a_hull_on_a_plane_touches_with_its_lowest_corner(draws):
    cases = given(hard_hulls(), TURNS, TURNS, SHARES)
    settings(max_examples=draws)(cases(_touches_with_its_lowest_corner))()


def _touches_with_its_lowest_corner(solid, turn, tilt, share):
    normal = tilt[2]
    offset = normal @ (turn @ solid.middle) + share * solid.reach
    plane = Shape(PLANE, np.array([*normal, offset]), radius=0.0)
    pose = np.concatenate((np.zeros(3), turn.ravel()))
    found = collide(solid, plane, pose, np.zeros(12), MARGIN)
    check(found, (solid, turn, tilt, share))
    heights = solid.vertices @ (turn.T @ normal) - offset
    rounding = 1e-14 * (abs(offset) + np.max(np.abs(solid.vertices)))
    assert (len(found) > 0) == (np.min(heights) <= MARGIN) or abs(
        np.min(heights) - MARGIN
    ) <= rounding
    if len(found):
        # Of corners as deep as another, up to TIE of the radius, the first counts.
        assert abs(found.gap - np.min(heights)) <= 1.1e-5 * solid.reach + rounding
        assert np.array_equal(found.normal, -normal)


@pytest.mark.parametrize('pair', PAIRS, ids=name)
def test_shapes_that_coincide_still_get_a_normal(pair):
    make = {SPHERE: sphere(0.5), CAPSULE: capsule(0.5, 0.5), BOX: box((0.5, 0.5, 0.5))}
    make |= {CYLINDER: cylinder(0.5, 0.5), HULL: hull(box((0.5, 0.5, 0.5)).vertices)}
    pose = np.concatenate((np.zeros(3), np.eye(3).ravel()))
    found = collide(make[pair[0]], make[pair[1]], pose, pose, MARGIN)
    check(found, pair)
    assert found.gap < -0.49  # they overlap by half their size at least


@pytest.mark.parametrize('pair', PAIRS, ids=name)
def test_not_a_number_in_a_pose_touches_nothing(pair):
    make = {SPHERE: sphere(0.5), CAPSULE: capsule(0.5, 0.5), BOX: box((0.5, 0.5, 0.5))}
    make |= {CYLINDER: cylinder(0.5, 0.5), HULL: hull(box((0.5, 0.5, 0.5)).vertices)}
    pose = np.concatenate((np.zeros(3), np.eye(3).ravel()))
    nowhere = pose.copy()
    nowhere[1] = np.nan
    assert not len(collide(make[pair[0]], make[pair[1]], pose, nowhere, MARGIN))


def digests(draws):
    """Of what the kernels of all pairs find between shapes at random."""
    for pair in PAIRS:
        digest = hashlib.sha256()
        for case in random_cases(pair, draws, np.random.default_rng(5), shapes=5):
            found = collide(*case, 0.3)
            digest.update(np.int64(len(found)).tobytes())
            if len(found):
                for array in (found.normal, found.places, found.gaps, found.features):
                    digest.update(array.tobytes())
        yield name(pair), digest.hexdigest()


@pytest.mark.skipif(
    not kernels.COMPILED, reason='numba is not installed: there is nothing to compare with'
)
@pytest.mark.parametrize('draws', [6, pytest.param(15, marks=pytest.mark.long)])
def test_polyhedra_meet_with_the_same_bits_with_and_without_numba(monkeypatch, draws):
    compiled = dict(digests(draws))
    inside.run_plain(monkeypatch)
    assert dict(digests(draws)) == compiled


@pytest.mark.parametrize('draws', [100, pytest.param(300, marks=pytest.mark.long)])
def test_climbing_finds_the_corner_that_looking_at_each_finds(draws):
    rng = np.random.default_rng(3)
    points = rng.normal(size=(400, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    solid = hull_of(points * (1.0, 0.5, 0.2))
    climbing, looking = packed(solid), packed(solid)
    looking[NEAR] = 0.0
    partner = box((0.4, 0.3, 0.2))
    for _ in range(draws):
        turn = so3.matrix_from_quaternion(so3.normalise(rng.normal(size=4)))
        pose = np.concatenate((rng.normal(size=3) * 0.5, turn.ravel()))
        one, other = (
            collide(
                partner, Shape(HULL, numbers, solid), np.r_[0, 0, 0, np.eye(3).ravel()], pose, 0.5
            )
            for numbers in (climbing, looking)
        )
        assert len(one) == len(other)
        if len(one):
            assert np.allclose(one.gaps, other.gaps, rtol=0.0, atol=1e-13)  # round-off of 1 m
