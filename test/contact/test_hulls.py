# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws of convex polyhedra made of points."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CLIP,
    COUNT,
    EDGES,
    FACES,
    LOOP,
    LOOPS,
    SIZE,
    packed,
    record,
)
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.shapes import ConvexHull, Cylinder, Mesh

ROUND_OFF = 1e-14  # [-] relative: sums of some hundred products
CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
GRID = np.array(list(itertools.product(np.linspace(-1.0, 1.0, 5), repeat=3)))
TILT = so3.matrix_from_quaternion(so3.normalise((0.3, -0.2, 0.6, 0.7)))


def ball(n, seed=0):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1)[:, None]


def counts(solid):
    return len(solid.vertices), len(solid.edges), len(solid.loops)


def check(solid, points, *, tolerance):
    """Euler's formula, no point outside, each edge between the two faces that it names."""
    v, e, f = counts(solid)
    assert v - e + f == 2
    heights = (points - solid.center) @ solid.planes[:, :3].T - solid.planes[:, 3]
    assert np.max(heights) <= tolerance
    sides = {}
    for face, loop in enumerate(solid.loops):
        for start, end in zip(loop.tolist(), np.roll(loop, -1).tolist()):
            sides[start, end] = face
    assert len(sides) == 2 * e
    for start, end, left, right in solid.edges.tolist():
        assert sides[start, end] == left and sides[end, start] == right


@pytest.mark.parametrize('points', (CUBE, GRID, GRID @ TILT.T, np.repeat(GRID, 3, axis=0)))
def test_points_of_a_cube_give_its_eight_corners_twelve_edges_and_six_faces(points):
    solid = hulls.hull(points)
    assert counts(solid) == (8, 12, 6)
    assert solid.volume == pytest.approx(8.0, rel=ROUND_OFF)
    check(solid, points, tolerance=1e-14)


@pytest.mark.parametrize('n', (4, 12, 100, 1000))
def test_points_on_a_ball_are_all_corners_of_triangles(n):
    points = ball(n)
    solid = hulls.hull(points)
    assert counts(solid) == (n, 3 * n - 6, 2 * n - 4)
    check(solid, points, tolerance=1e-14)


@pytest.mark.parametrize('thickness', (1e-3, 1e-6, 1e-9, 1e-11))
@pytest.mark.parametrize('thin', ((2,), (1, 2)), ids=('plate', 'needle'))
def test_a_thin_solid_keeps_its_thickness(thin, thickness):
    size = np.ones(3)
    size[list(thin)] = thickness
    solid = hulls.hull((GRID * size) @ TILT.T)
    # Coordinates of 1 m are rounded to 1e-16 m.
    assert solid.volume == pytest.approx(8.0 * np.prod(size), rel=1e-14 / thickness + 1e-13)
    check(solid, (GRID * size) @ TILT.T, tolerance=1e-15)
    if thickness >= 1e-6:
        assert counts(solid) == (8, 12, 6)


@pytest.mark.parametrize(
    'points',
    (
        GRID * (1.0, 1.0, 0.0),
        (GRID * (1.0, 1.0, 0.0)) @ TILT.T,
        (GRID * (1.0, 1.0, 1e-14)) @ TILT.T,
        (GRID * (1.0, 0.0, 0.0)) @ TILT.T,
        np.ones((5, 3)),
        CUBE + 1e17,
        GRID * (1.0, 1.0, 1e-3) + 1e15,
        CUBE * 1.7e308,
        CUBE[:3],
    ),
)
def test_points_without_a_solid_are_refused_with_what_is_missing(points):
    with pytest.raises(InvalidModel, match=r'no solid|beyond 1e308|thicker') as refusal:
        hulls.hull(points, name="mesh 'plate'")
    assert str(refusal.value).startswith("mesh 'plate': ") and '\n' not in str(refusal.value)


@pytest.mark.parametrize('offset', (1e3, 1e6, 1e9))
def test_a_far_origin_costs_only_the_digits_the_coordinates_have_lost(offset):
    solid = hulls.hull(GRID @ TILT.T + offset)
    rounding = 1e-16 * offset
    assert solid.volume == pytest.approx(8.0, rel=100 * rounding + ROUND_OFF)
    assert solid.center == pytest.approx(np.full(3, offset), abs=4 * rounding)
    assert solid.half_width == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize('scale', (1e-300, 1e-20, 1e20, 1e300))
def test_the_unit_of_length_does_not_matter(scale):
    solid = hulls.hull((GRID @ TILT.T) * scale)
    assert counts(solid) == (8, 12, 6)
    assert solid.vertices / scale == pytest.approx(hulls.hull(GRID @ TILT.T).vertices, rel=1e-14)


COORDINATES = st.one_of(st.floats(-2.0, 2.0), st.sampled_from((0.0, 1.0, -1.0, 1e-9, 1.0 + 1e-12)))
POINTS = st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES), min_size=1, max_size=20)


@pytest.mark.parametrize('draws', [100, pytest.param(300, marks=pytest.mark.long)])
def test_any_points_give_a_closed_surface_around_them_or_a_clear_refusal(draws):
    cases = example([(0.0, 0.0, 0.0)] * 5)(given(POINTS)(_give_a_closed_surface_or_a_refusal))
    settings(max_examples=draws)(cases)()


def _give_a_closed_surface_or_a_refusal(points):
    points = np.array(points)
    try:
        solid = hulls.hull(points)
    except InvalidModel as refusal:
        assert 'convex hull: ' in str(refusal)
        return
    # Points are merged into a plane within 1e-9 of the extent (COPLANAR).
    check(solid, points, tolerance=1e-8)
    assert np.all(np.isfinite(packed(solid)))


@pytest.mark.parametrize('sides', (8, hulls.SIDES))
def test_the_edges_of_the_prism_of_a_cylinder_lie_on_its_mantle(sides):
    solid = hulls.prism(0.5, 1.0, sides=sides)
    assert counts(solid) == (2 * sides, 3 * sides, sides + 2)
    check(solid, solid.vertices, tolerance=1e-15)
    across = np.hypot(solid.vertices[:, 0], solid.vertices[:, 1])
    assert np.allclose(across, 0.5, rtol=0.0, atol=ROUND_OFF)
    inner = np.min(solid.planes[2:, 3])
    assert inner / 0.5 == pytest.approx(math.cos(math.pi / sides), rel=ROUND_OFF)


@pytest.mark.parametrize('thin', [1e-290, 1e-183, 1e-160, 1e-80, 1.0])
def test_the_sides_of_a_needle_and_of_a_card_have_unit_normals(thin):
    # the square of their areas is less than the smallest float
    for solid in (hulls.prism(thin, 4.0), hulls.prism(4.0, thin), hulls.box((thin, 1.0, 4.0))):
        assert np.allclose(np.linalg.norm(solid.planes[:, :3], axis=1), 1.0, rtol=0.0, atol=1e-15)
        assert solid.half_width == pytest.approx(thin, rel=0.01)  # 32 sides for a circle


def test_a_cylinder_too_thin_for_numbers_is_refused():
    with pytest.raises(InvalidModel, match='narrower than 1e-300'):
        record(Cylinder(1e-310, 2.0))


def test_the_box_is_the_hull_of_its_corners():
    solid = hulls.box((0.5, 0.2, 0.1))
    check(solid, CUBE * (0.5, 0.2, 0.1), tolerance=0.0)
    assert solid.volume == pytest.approx(0.08, rel=ROUND_OFF)
    assert np.array_equal(solid.planes[:, :3], np.kron(np.eye(3), [[1], [-1]]))


def test_the_record_counts_what_it_holds():
    for solid in (hulls.box((1, 2, 3)), hulls.prism(1, 1), hulls.hull(ball(100))):
        numbers = packed(solid)
        head = numbers.astype(int)
        assert (head[COUNT], head[EDGES], head[FACES]) == counts(solid)
        assert head[SIZE] == len(numbers)
        assert head[LOOP] - 1 == min(CLIP, max(len(loop) for loop in solid.loops))
        first = numbers[head[LOOPS] : head[LOOPS] + head[LOOP]].astype(int)
        assert set(first[1 : 1 + first[0]]) <= set(solid.loops[0].tolist())
    assert len(record(Cylinder(1.0, 2.0))) == len(packed(hulls.prism(1.0, 1.0)))


def dented(depth):
    """A cube whose upper side is drawn in to a pit of square rim, as a mesh."""
    corners = [*CUBE.tolist(), [0.0, 0.0, 1.0 - depth]]
    # Corner 4 i + 2 j + k; two triangles on five sides, four around the pit.
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7)]
    faces += [(2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 8), (5, 7, 8), (7, 3, 8), (3, 1, 8)]
    return Mesh(np.array(corners), np.array(faces))


def test_convexity_defect_is_the_empty_share_of_the_hull():
    assert hulls.convexity_defect(dented(0.0)) == pytest.approx(0.0, abs=ROUND_OFF)
    # A pyramid of base 4 m^2 and height 1.5 m is missing from 8 m^3.
    assert hulls.convexity_defect(dented(1.5)) == pytest.approx(2.0 / 8.0, rel=ROUND_OFF)


@pytest.mark.parametrize('offset', (0.0, 1e3, 1e6))
def test_mass_properties_of_hull_and_mesh_do_not_depend_on_where_the_origin_lies(offset):
    here = of_shape(Mesh(dented(0.0).vertices @ TILT.T, dented(0.0).faces), density=1.0)
    moved = GRID @ TILT.T + offset
    mesh = Mesh(dented(0.0).vertices @ TILT.T + offset, dented(0.0).faces)
    for shape in (ConvexHull(moved), mesh):
        there = of_shape(shape, density=1.0)
        # Only the rounding of the coordinates themselves is left, with a factor for the products.
        tolerance = 1e-14 + 1e-15 * offset
        assert there.mass == pytest.approx(8.0, rel=tolerance)
        assert there.inertia == pytest.approx(here.inertia, abs=tolerance * 16.0)
        assert there.center_of_mass == pytest.approx(np.full(3, offset), abs=tolerance)
