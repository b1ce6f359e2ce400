# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws of mass, centre of mass and inertia."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.inertia_tensor import MOMENT_TOLERANCE
from rigid_body_sim.physics.model.mass_properties import (
    MassProperties,
    check_inertia,
    moment_about,
    moved,
    of_shape,
    parallel_axes,
    principal_axes,
    union,
)
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Part,
    Particle,
    Particles,
    Plane,
    Shape,
    Sphere,
    Union,
)

ROUND_OFF = 1e-14  # [-] relative: sums of some hundred products
TILT = rotation.normalise((0.3, -0.2, 0.6, 0.7))
SIZE = (0.4, 0.2, 0.1)
CORNERS = np.array(list(itertools.product(*((-e / 2, e / 2) for e in SIZE))))
# Two triangles on each side of the box, counter-clockwise seen from outside; corner 4 i + 2 j + k.
BOX_FACES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5)),
        *((0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)),
        *((0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ]
)


def assert_same(a: MassProperties, b: MassProperties, *, tolerance: float = ROUND_OFF) -> None:
    """Compare mass, centre and tensor; the tensor relative to its largest element."""
    assert a.mass == pytest.approx(b.mass, rel=tolerance)
    extent = math.sqrt(np.max(np.abs(b.inertia)) / b.mass)
    assert a.center_of_mass == pytest.approx(b.center_of_mass, abs=tolerance * extent)
    assert a.inertia == pytest.approx(b.inertia, abs=tolerance * np.max(np.abs(b.inertia)))


def turned(points: np.ndarray, *, offset: tuple[float, float, float]) -> np.ndarray:
    """Return points tilted and moved."""
    return rotation.rotate(TILT, points) + np.array(offset)


def test_closed_forms_of_the_textbook() -> None:
    # Goldstein, chapter 5; numbers by hand for m = 3 kg.
    ball = of_shape(Sphere(2.0), mass=3.0).inertia
    assert ball == pytest.approx(4.8 * np.eye(3), rel=ROUND_OFF)
    box = of_shape(Box((1.0, 2.0, 3.0)), mass=12.0).inertia
    assert np.array_equal(box, np.diag((13.0, 10.0, 5.0)))
    cylinder = of_shape(Cylinder(radius=2.0, length=6.0), mass=3.0).inertia
    assert np.array_equal(cylinder, np.diag((12.0, 12.0, 6.0)))


@pytest.mark.parametrize(
    ('shape', 'volume'),
    (
        (Sphere(0.5), math.pi / 6),
        (Box((1.0, 2.0, 3.0)), 6.0),
        (Cylinder(radius=0.5, length=2.0), math.pi / 2),
        (Capsule(radius=0.5, length=2.0), math.pi * 2 / 3),
        (ConvexHull(CORNERS), 0.008),
    ),
)
def test_density_times_volume_is_the_mass(shape: Shape, volume: float) -> None:
    by_density = of_shape(shape, density=250.0)
    assert by_density.mass == pytest.approx(250.0 * volume, rel=ROUND_OFF)
    assert_same(of_shape(shape, mass=by_density.mass), by_density)


def test_capsule_is_the_union_of_a_cylinder_and_two_half_balls() -> None:
    r, h, density = 0.3, 0.8, 700.0
    ball = of_shape(Sphere(r), density=density)
    # Half ball: mass m/2, centre 3r/8 above its flat side, about which it has half the moments.
    half_mass = ball.mass / 2
    halves = []
    for side in (1.0, -1.0):
        lever = np.array((0.0, 0.0, side * 3 * r / 8))
        about_center = parallel_axes(ball.inertia / 2, mass=-half_mass, offset=lever)
        halves.append(MassProperties(half_mass, lever + (0, 0, side * h / 2), about_center))
    whole = union([of_shape(Cylinder(r, h), density=density), *halves])
    assert_same(of_shape(Capsule(r, h), density=density), whole)


def test_a_capsule_without_length_tends_to_a_sphere() -> None:
    assert_same(
        of_shape(Capsule(0.5, 1e-14), mass=2.0), of_shape(Sphere(0.5), mass=2.0), tolerance=1e-12
    )  # the rest of the cylinder is 1e-14 of the radius, times some units


def test_hull_of_the_corners_of_a_box_is_the_box() -> None:
    hull, box = of_shape(ConvexHull(CORNERS), mass=2.0), of_shape(Box(SIZE), mass=2.0)
    assert_same(hull, box)
    assert np.array_equal(hull.inertia, np.diag(np.diag(hull.inertia)))


def test_points_inside_a_hull_change_nothing() -> None:
    inside = np.random.default_rng(3).uniform(-0.04, 0.04, size=(40, 3))
    on_a_side = CORNERS[[0, 1, 3, 2]].mean(axis=0)
    more = np.concatenate((inside, CORNERS, [on_a_side]))
    assert_same(of_shape(ConvexHull(more), mass=2.0), of_shape(Box(SIZE), mass=2.0))


def test_hull_of_many_points_on_a_ball_tends_to_the_ball() -> None:
    # Fibonacci lattice: n points leave out a share 4 pi / (sqrt(3) n) = 0.36 % of the volume.
    n = 2000
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, k * math.pi * (3 - math.sqrt(5))
    ring = np.sqrt(1 - z * z)
    points = np.stack((ring * np.cos(turn), ring * np.sin(turn), z), axis=-1)
    hull = of_shape(ConvexHull(points), density=1.0)
    assert hull.mass == pytest.approx(4 / 3 * math.pi, rel=0.005)
    assert np.diag(hull.inertia) == pytest.approx(np.full(3, 8 / 15 * math.pi), rel=0.01)


@pytest.mark.parametrize('offset', ((0.0, 0.0, 0.0), (1.0, -2.0, 3.0), (1e3, 1e3, -1e3)))
def test_mesh_and_hull_follow_their_points(offset: tuple[float, float, float]) -> None:
    expected = moved(of_shape(Box(SIZE), mass=2.0), position=offset, orientation=TILT)
    corners = turned(CORNERS, offset=offset)
    # The corners themselves are rounded: eps times distance over size.
    tolerance = ROUND_OFF + 1e-15 * np.max(np.abs(offset)) / 0.1
    assert_same(of_shape(Mesh(corners, BOX_FACES), mass=2.0), expected, tolerance=tolerance)
    assert_same(of_shape(ConvexHull(corners), mass=2.0), expected, tolerance=tolerance)


def test_a_million_metres_from_the_origin_no_digit_is_lost() -> None:
    # Corners in multiples of 1/16 m stay exact there: what differs is the arithmetic alone.
    corners = np.array(list(itertools.product((0.0, 0.5), (0.0, 1.0), (0.0, 0.0625))))
    offset = np.array((1e6, -1e6, 1e6))
    near = of_shape(Mesh(corners, BOX_FACES), density=1000.0)
    far = of_shape(Mesh(corners + offset, BOX_FACES), density=1000.0)
    assert np.array_equal(far.inertia, near.inertia)
    assert far.mass == near.mass
    assert np.array_equal(far.center_of_mass, near.center_of_mass + offset)
    hull = of_shape(ConvexHull(corners + offset), density=1000.0)
    assert hull.inertia == pytest.approx(near.inertia, rel=ROUND_OFF)
    masses = np.arange(1.0, 9.0)
    near, far = (of_shape(Particles(corners + o, masses)) for o in (0.0, offset))
    assert far.inertia == pytest.approx(near.inertia, rel=ROUND_OFF)


def test_a_mesh_turned_inside_out_is_turned_back() -> None:
    right, wrong = Mesh(CORNERS, BOX_FACES), Mesh(CORNERS, BOX_FACES[:, ::-1])
    assert_same(of_shape(wrong, density=250.0), of_shape(right, density=250.0))


def test_a_cavity_is_subtracted() -> None:
    shell = Mesh(
        np.concatenate((CORNERS, CORNERS / 2)),
        np.concatenate((BOX_FACES, BOX_FACES[:, ::-1] + len(CORNERS))),
    )
    full = of_shape(Box(SIZE), density=250.0)
    hole = of_shape(Box((0.2, 0.1, 0.05)), density=250.0)
    hollow = of_shape(shell, density=250.0)
    assert hollow.mass == pytest.approx(full.mass - hole.mass, rel=ROUND_OFF)
    assert hollow.inertia == pytest.approx(full.inertia - hole.inertia, rel=ROUND_OFF)


def test_an_open_mesh_is_refused() -> None:
    with pytest.raises(InvalidModel, match=r'open: 3 edges.*close the holes'):
        of_shape(Mesh(CORNERS, BOX_FACES[1:], 'bowl'), mass=1.0)


def test_a_mesh_with_one_twisted_face_is_refused() -> None:
    twisted = BOX_FACES.copy()
    twisted[0] = twisted[0, ::-1]
    with pytest.raises(InvalidModel, match='disagree about the outside'):
        of_shape(Mesh(CORNERS, twisted), mass=1.0)


@pytest.mark.parametrize('flat', (CORNERS * (1, 1, 0), CORNERS * (1, 0, 0), CORNERS * 0))
def test_a_flat_solid_is_refused(flat: np.ndarray) -> None:
    with pytest.raises(InvalidModel, match='plane'):
        of_shape(ConvexHull(flat), mass=1.0)
    with pytest.raises(InvalidModel, match='finite volume'):
        of_shape(Mesh(flat, BOX_FACES), mass=1.0)


def test_a_thin_plate_is_a_solid() -> None:
    plate = of_shape(ConvexHull(CORNERS * (1, 1, 1e-5)), mass=2.0)
    assert_same(plate, of_shape(Box((0.4, 0.2, 1e-6)), mass=2.0), tolerance=1e-10)
    check_inertia(plate.inertia)  # I1 + I2 = I3 to within round-off


def test_dumbbell_has_the_reduced_mass_times_the_square_of_its_length() -> None:
    dumbbell = of_shape(
        Particles(np.array(((1.0, 5.0, 0.0), (1.0, 5.0, 3.0))), np.array((1.0, 2.0)))
    )
    assert dumbbell.mass == 3.0
    assert dumbbell.center_of_mass == pytest.approx((1.0, 5.0, 2.0), rel=ROUND_OFF)
    assert dumbbell.inertia == pytest.approx(np.diag((6.0, 6.0, 0.0)), abs=ROUND_OFF)


def test_a_line_of_particles_is_refused_with_the_cure() -> None:
    along = rotation.rotate(TILT, (1.0, 0.0, 0.0))
    line = of_shape(Particles(np.outer((0.0, 1.0, 3.0), along), np.ones(3)))
    with pytest.raises(InvalidModel, match=r'line of particles.*give it a thickness, or state'):
        check_inertia(line.inertia)


def test_a_plane_of_particles_is_a_lamina() -> None:
    square = np.array(((1.0, 1.0, 0.0), (-1.0, 1.0, 0.0), (-1.0, -1.0, 0.0), (1.0, -1.0, 0.0)))
    lamina = of_shape(Particles(rotation.rotate(TILT, square), np.ones(4)))
    check_inertia(lamina.inertia)
    moments = np.sort(principal_axes(lamina.inertia)[0])
    assert moments == pytest.approx((4.0, 4.0, 8.0), rel=ROUND_OFF)


def test_union_of_the_parts_is_the_whole() -> None:
    halves = [
        moved(
            of_shape(Box((0.2, 0.2, 0.1)), density=250.0),
            position=(x, 0.0, 0.0),
            orientation=rotation.IDENTITY,
        )
        for x in (-0.1, 0.1)
    ]
    assert_same(union(halves), of_shape(Box(SIZE), density=250.0))


def test_particles_are_the_union_of_single_particles() -> None:
    random = np.random.default_rng(5)
    positions, masses = random.normal(size=(7, 3)), random.uniform(0.1, 2.0, size=7)
    singles = [
        moved(of_shape(Particle(), mass=m), position=p, orientation=TILT)
        for p, m in zip(positions, masses, strict=True)
    ]
    assert_same(union(singles), of_shape(Particles(positions, masses)))


def test_parallel_axes_move_there_and_back() -> None:
    inertia, d = np.diag((1.0, 2.0, 2.5)), np.array((0.3, -0.4, 1.2))
    there = parallel_axes(inertia, mass=3.0, offset=d)
    assert there[0, 1] == pytest.approx(-3.0 * d[0] * d[1], rel=ROUND_OFF)
    assert np.trace(there) == pytest.approx(5.5 + 2 * 3.0 * d @ d, rel=ROUND_OFF)
    assert parallel_axes(there, mass=-3.0, offset=-d) == pytest.approx(inertia, abs=ROUND_OFF)


def test_moment_about_an_axis_is_the_sum_of_squared_distances() -> None:
    random = np.random.default_rng(8)
    positions, masses = random.normal(size=(9, 3)), random.uniform(0.1, 2.0, size=9)
    point, direction = np.array((0.2, 1.0, -3.0)), np.array((1.0, -2.0, 0.5))
    n = direction / np.linalg.norm(direction)
    distances = np.linalg.norm(np.cross(positions - point, n), axis=1)
    moment = moment_about(of_shape(Particles(positions, masses)), point=point, direction=direction)
    assert moment == pytest.approx(masses @ distances**2, rel=ROUND_OFF)


def test_moment_does_not_depend_on_the_point_of_the_axis_nor_its_sense() -> None:
    body = moved(of_shape(Box(SIZE), mass=2.0), position=(1, 2, 3), orientation=TILT)
    n = np.array((1.0, 1.0, -0.5))
    first = moment_about(body, point=(1, 0, 0), direction=n)
    second = moment_about(body, point=np.array((1, 0, 0)) + 5 * n, direction=-3 * n)
    assert second == pytest.approx(first, rel=ROUND_OFF)


def test_turning_the_body_turns_the_tensor() -> None:
    body = of_shape(Box(SIZE), mass=2.0)
    tilted = moved(body, position=(0, 0, 0), orientation=TILT)
    n = np.array((0.2, -0.5, 0.8))
    about_n = moment_about(body, point=(0, 0, 0), direction=n)
    about_turned_n = moment_about(tilted, point=(0, 0, 0), direction=rotation.rotate(TILT, n))
    assert about_turned_n == pytest.approx(about_n, rel=ROUND_OFF)
    assert np.array_equal(tilted.inertia, tilted.inertia.T)


@pytest.mark.parametrize(
    'moments', list(itertools.permutations((1.0, 2.0, 2.5))) + [(2.0, 2.0, 2.0)]
)
def test_a_diagonal_tensor_keeps_its_axes_and_their_order(moments: tuple[float, ...]) -> None:
    found, axes = principal_axes(np.diag(moments))
    assert np.array_equal(found, moments)
    assert np.array_equal(axes, np.eye(3))


@given(
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 1e-3),
    st.sampled_from(list(itertools.permutations((1.0, 2.0, 2.5))) + [(2.0, 2.0, 3.0)]),
)
def test_principal_axes_diagonalise_any_tensor(
    q: tuple[float, ...], moments: tuple[float, ...]
) -> None:
    r = rotation.matrix_from_quaternion(rotation.normalise(q))
    inertia = r @ np.diag(moments) @ r.T
    inertia = 0.5 * (inertia + inertia.T)
    found, axes = principal_axes(inertia)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=ROUND_OFF)
    # so much off the diagonal counts as rounding of a tensor in its own axes
    round_off = ROUND_OFF * inertia.trace()
    assert axes @ np.diag(found) @ axes.T == pytest.approx(inertia, abs=round_off)
    assert np.sort(found) == pytest.approx(np.sort(moments), rel=ROUND_OFF)


@pytest.mark.parametrize('moments', list(itertools.permutations((1.0, 2.0, 2.5))))
def test_a_small_tilt_is_a_small_turn_of_the_axes(moments: tuple[float, ...]) -> None:
    r = rotation.matrix_from_quaternion(rotation.from_rotation_vector((1e-3, -2e-3, 3e-3)))
    found, axes = principal_axes(r @ np.diag(moments) @ r.T)
    assert axes == pytest.approx(r, abs=ROUND_OFF * 10)  # the gaps between moments are 0.5 and up
    assert found == pytest.approx(moments, rel=ROUND_OFF)


@pytest.mark.parametrize(
    ('inertia', 'reason'),
    (
        (np.diag((1.0, 1.0, 3.0)), r'principal moments \(1, 1, 3\) kg m\^2 break the triangle'),
        (np.diag((1.0, -1.0, 1.0)), 'needs positive ones'),
        (np.diag((0.0, 1.0, 1.0)), 'not all positive'),
        (np.zeros((3, 3)), 'not all positive'),
        (np.diag((math.nan, 1.0, 1.0)), 'NaN or infinity'),
        (np.diag((math.inf, 1.0, 1.0)), 'NaN or infinity'),
        (np.array(((2.0, 0.1, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.0))), 'not symmetric'),
        (np.array(((1.0, 2.0, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 1.0))), 'needs positive ones'),
        (1e-310 * np.eye(3), 'too small'),
        (np.eye(2), r'\(3, 3\)'),
    ),
)
def test_an_impossible_tensor_is_refused(inertia: np.ndarray, reason: str) -> None:
    with pytest.raises(InvalidModel, match=reason):
        check_inertia(inertia)


def test_the_triangle_inequality_has_the_stated_tolerance() -> None:
    check_inertia(np.diag((1.0, 1.0, 2.0 * (1.0 + 0.9 * MOMENT_TOLERANCE))))
    with pytest.raises(InvalidModel):
        check_inertia(np.diag((1.0, 1.0, 2.0 * (1.0 + 1.2 * MOMENT_TOLERANCE))))


@pytest.mark.parametrize(
    ('shape', 'amount', 'reason'),
    (
        (Sphere(1.0), {}, 'either mass'),
        (Sphere(1.0), {'mass': 1.0, 'density': 1.0}, 'either mass'),
        (Sphere(1.0), {'mass': -1.0}, 'must be positive'),
        (Sphere(1.0), {'mass': math.nan}, 'a finite number'),
        (Sphere(1.0), {'density': 0.0}, 'must be positive'),
        (Sphere(1e-200), {'density': 1.0}, 'must be positive'),
        (Box((1e200, 1e200, 1.0)), {'density': 1.0}, 'must be positive and finite'),
        (Particle(), {}, 'needs a mass'),
        (Particle(), {'density': 1.0}, 'no volume'),
        (Particles(np.eye(3), np.ones(3)), {'density': 1.0}, 'no volume'),
        (Particles(np.eye(3), np.ones(3)), {'mass': 2.0}, 'not the sum'),
        (Plane((0.0, 0.0, 1.0)), {'mass': 1.0}, 'static'),
    ),
)
def test_mass_must_be_told_once_and_be_positive(
    shape: Shape, amount: dict[str, float], reason: str
) -> None:
    with pytest.raises(InvalidModel, match=reason):
        of_shape(shape, **amount)


@pytest.mark.parametrize('length', (0.0, -1.0, math.nan, math.inf))
def test_a_length_must_be_positive(length: float) -> None:
    for make in (
        lambda: Sphere(length),
        lambda: Box((1.0, length, 1.0)),
        lambda: Cylinder(1.0, length),
        lambda: Cylinder(length, 1.0),
        lambda: Capsule(1.0, length),
    ):
        with pytest.raises(
            InvalidModel, match=r'must be positive and finite|three finite numbers'
        ):
            make()


def test_the_normal_of_a_plane_is_made_a_unit_vector() -> None:
    assert Plane((0.0, 3.0, 4.0)).normal == pytest.approx((0.0, 0.6, 0.8), rel=ROUND_OFF)
    with pytest.raises(InvalidModel, match='non-zero length'):
        Plane((0.0, 0.0, 0.0))


def test_a_union_shape_is_the_sum_of_its_parts_by_parallel_axes() -> None:
    """A dumbbell: a rod and two balls, by Steiner's law."""
    rod, ball, arm = 0.4, 1.5, 0.3
    shape = Union(
        (
            Part(Cylinder(0.02, 0.5), mass=rod),
            Part(Sphere(0.1), density=ball / (4 / 3 * math.pi * 0.1**3), position=(0, 0, arm)),
            Part(Sphere(0.1), mass=ball, position=(0, 0, -arm)),
        )
    )
    found = of_shape(shape)
    across = rod * (0.02**2 / 4 + 0.5**2 / 12) + 2 * ball * (0.4 * 0.1**2 + arm**2)
    along = rod * 0.02**2 / 2 + 2 * ball * 0.4 * 0.1**2
    expected = MassProperties(rod + 2 * ball, np.zeros(3), np.diag((across, across, along)))
    assert_same(found, expected)


def test_a_union_of_turned_parts_is_the_whole_box_turned() -> None:
    """Halves of a box, each given in axes of its own; the density is that of the whole."""
    half = (SIZE[0] / 2, SIZE[1], SIZE[2])
    quarter = 0.5 * math.sqrt(2.0)
    turned = (half[1], half[0], half[2])  # seen from axes turned by a right angle about z
    shape = Union(
        (
            Part(Box(half), position=(-half[0] / 2, 0, 0)),
            Part(Box(turned), position=(half[0] / 2, 0, 0), orientation=(0, 0, quarter, quarter)),
        )
    )
    assert_same(of_shape(shape, density=250.0), of_shape(Box(SIZE), density=250.0))
    inner = Union((Part(shape, position=(0, 0, 1)), Part(Particle(), mass=1e-9)))
    assert of_shape(inner, density=250.0).mass == pytest.approx(250.0 * math.prod(SIZE) + 1e-9)


@pytest.mark.parametrize(
    ('parts', 'given', 'reason'),
    [
        ((), {}, 'at least one part'),
        ((Part(Sphere(0.1)),), {}, r'parts\[0\]: neither mass nor density is given'),
        ((Part(Sphere(0.1), mass=1.0),), {'mass': 2.0}, 'not the sum of the parts, 1.0 kg'),
        ((Part(Particle(), density=1.0),), {}, r'parts\[0\]: particles have no volume'),
    ],
)
def test_an_impossible_union_is_refused(parts, given, reason) -> None:
    with pytest.raises(InvalidModel, match=reason):
        of_shape(Union(parts), **given)
