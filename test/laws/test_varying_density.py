# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Mass, centre and inertia of shapes whose density varies with position."""

import itertools
import math

import numpy as np
import pytest

from rigid_body_sim import load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import quadrature
from rigid_body_sim.physics.model.mass_properties import (
    of_density,
    of_linear_density,
    of_shape,
    parallel_axes,
    union,
)
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Particle,
    Plane,
    Sphere,
)

ROUND_OFF = 1e-12  # [-] sums over some ten thousand points
SIZE = (0.4, 0.2, 0.1)
CORNERS = np.array(list(itertools.product(*((-e / 2, e / 2) for e in SIZE))))
HULL = ConvexHull(CORNERS + [5.0, -2.0, 1.0])
SHAPES = [Sphere(0.3), Box(SIZE), Cylinder(0.2, 0.7), Capsule(0.2, 0.5), HULL]
NAMES = [type(shape).__name__ for shape in SHAPES]


def ell():
    """An L of three unit cubes, not convex, as triangles; and the same as a union of boxes."""
    outline = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
    flat = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    vertices = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in outline])
    faces = [(a, c, b) for a, b, c in flat] + [(a + 6, b + 6, c + 6) for a, b, c in flat]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    return Mesh(vertices, np.array(faces))


def assert_same(a, b, tolerance=ROUND_OFF):
    size = math.sqrt(np.trace(b.inertia) / b.mass)
    assert a.mass == pytest.approx(b.mass, rel=tolerance)
    assert a.center_of_mass == pytest.approx(b.center_of_mass, abs=tolerance * size)
    assert a.inertia == pytest.approx(b.inertia, abs=tolerance * np.trace(b.inertia))


@pytest.mark.parametrize('shape', [*SHAPES, ell()], ids=[*NAMES, 'L'])
def test_a_density_that_does_not_vary_gives_the_closed_forms(shape):
    found = of_density(shape, lambda x: np.full(len(x), 700.0))
    assert_same(found, of_shape(shape, density=700.0))


@pytest.mark.parametrize('shape', [*SHAPES, ell()], ids=[*NAMES, 'L'])
def test_the_first_moment_of_a_gradient_is_the_second_moment_of_the_shape(shape):
    """
    For rho = a + g . x about the centre c of the shape: m = V rho(c), m r = rho(c) V c + C g.
    """
    uniform = of_shape(shape, density=1.0)
    volume, middle = uniform.mass, uniform.center_of_mass
    second = 0.5 * np.trace(uniform.inertia) * np.eye(3) - uniform.inertia
    gradient = np.array([0.4, -0.3, 0.5])
    at_origin = 10.0
    found = of_linear_density(shape, at_origin=at_origin, gradient=gradient)
    at_middle = at_origin + gradient @ middle
    assert found.mass == pytest.approx(volume * at_middle, rel=ROUND_OFF)
    moved = second @ gradient / found.mass
    assert found.center_of_mass - middle == pytest.approx(moved, abs=ROUND_OFF)


def test_a_rod_that_gets_denser_along_its_length():
    """
    rho = rho0 (1 + z/l), z from -l/2 to l/2: centre at l/12, I = m l^2 (1/12 - 1/144) across a
    thin rod.
    """
    rod = Cylinder(1e-6, 1.0)
    found = of_linear_density(rod, at_origin=100.0, gradient=(0.0, 0.0, 100.0))
    assert found.center_of_mass == pytest.approx([0.0, 0.0, 1.0 / 12.0], abs=1e-12)
    assert found.inertia[0, 0] / found.mass == pytest.approx(
        1.0 / 12.0 - 1.0 / 144.0, rel=1e-9
    )  # radius 1e-6


def test_a_ball_whose_density_falls_from_its_centre():
    """rho = exp(-r^2): I = (8 pi / 3) integral r^4 exp(-r^2) dr, by parts with erf."""
    found = of_density(Sphere(1.0), lambda x: np.exp(-np.sum(x * x, axis=1)))
    shell = math.sqrt(math.pi) / 2.0 * math.erf(1.0)
    r2 = 0.5 * (shell - math.exp(-1.0))
    r4 = 0.5 * (3.0 * r2 - math.exp(-1.0))
    assert found.mass == pytest.approx(4.0 * math.pi * r2, rel=1e-10)
    assert np.diag(found.inertia) == pytest.approx(8.0 * math.pi / 3.0 * r4, rel=1e-10)


def test_quadrature_converges_faster_than_any_power_for_a_smooth_density():
    def mass(n):
        return sum(
            float(w @ np.exp(3.0 * x[:, 0] + x[:, 1] * x[:, 2]))
            for x, w in quadrature.nodes(ell(), n)
        )

    exact = mass(20)
    errors = [abs(mass(n) - exact) / exact for n in (2, 4, 6, 8)]
    assert all(b < a / 20 for a, b in itertools.pairwise(errors))
    assert errors[-1] < 1e-8


@pytest.mark.parametrize('n', [2, 3, pytest.param(5, marks=pytest.mark.long)])
@pytest.mark.parametrize('shape', SHAPES, ids=NAMES)
def test_n_points_integrate_polynomials_of_degree_2n_minus_1_exactly(shape, n):
    middle = of_shape(shape, density=1.0).center_of_mass
    for powers in itertools.product(range(2 * n), repeat=3):
        if sum(powers) not in (2 * n - 2, 2 * n - 1):
            continue
        few, many, size = (
            sum(
                float(w @ part(np.prod((x - middle) ** powers, axis=1)))
                for x, w in quadrature.nodes(shape, m)
            )
            for m, part in ((n, np.asarray), (n + 3, np.asarray), (n + 3, np.abs))
        )
        assert few == pytest.approx(many, abs=ROUND_OFF * size)


def test_parts_of_a_varying_density_join_to_the_whole():
    """Two halves of a box, each with its stretch of the gradient."""
    whole = of_linear_density(Box((2.0, 1.0, 1.0)), at_origin=10.0, gradient=(3.0, 0.0, 0.0))
    half = CORNERS / SIZE * [1.0, 1.0, 1.0]
    parts = [
        of_linear_density(
            ConvexHull(half + [shift, 0, 0]), at_origin=10.0, gradient=(3.0, 0.0, 0.0)
        )
        for shift in (-0.5, 0.5)
    ]
    assert_same(union(parts), whole)
    assert np.all(
        np.linalg.eigvalsh(parallel_axes(whole.inertia, mass=whole.mass, offset=(1, 0, 0))) > 0.0
    )


@pytest.mark.parametrize(
    ('shape', 'density', 'said'),
    [
        (Box(SIZE), lambda x: np.where(x[:, 0] > 0.0123, 1.0, 0.0), 'too rough'),
        (Box(SIZE), lambda x: np.full(len(x), np.nan), 'not finite'),
        (Box(SIZE), lambda x: x, 'one finite number'),
        (Box(SIZE), lambda x: np.full(len(x), -1.0), 'mass is -'),
        (Particle(), lambda x: np.ones(len(x)), 'has no volume'),
        (Plane((0.0, 0.0, 1.0)), lambda x: np.ones(len(x)), 'has no volume'),
    ],
)
def test_a_density_without_a_meaning_is_refused(shape, density, said):
    with pytest.raises(InvalidModel, match=said):
        of_density(shape, density)


@pytest.mark.parametrize('shape', SHAPES, ids=NAMES)
def test_a_density_may_fall_to_zero_at_the_surface_and_not_below(shape):
    points = np.concatenate([x for x, _ in quadrature.nodes(shape, 40)])
    direction = np.array([0.6, 0.3, -0.4])
    least = float(np.min(points @ direction))
    extent = float(np.ptp(points @ direction))
    of_linear_density(shape, at_origin=-least + 0.05 * extent, gradient=direction)
    with pytest.raises(InvalidModel, match='falls to -'):
        of_linear_density(shape, at_origin=-least - 1e-6 * extent, gradient=direction)


def body(**changes):
    box = {
        'name': 'box',
        'shape': {'type': 'box', 'size': list(SIZE)},
        'density': {'at_origin': 250, 'gradient': [0, 0, 100]},
    }
    scene = load_scene({'version': 1, 'dt': 0.01, 'bodies': [{**box, **changes}]})
    return scene.bodies[0]


def test_a_scene_may_give_a_density_with_a_gradient():
    found = body()
    volume = math.prod(SIZE)
    assert found.mass == pytest.approx(250.0 * volume, rel=ROUND_OFF)
    assert found.center_of_mass == pytest.approx(
        [0.0, 0.0, 100.0 / 250.0 * SIZE[2] ** 2 / 12.0], abs=1e-15
    )


@pytest.mark.parametrize(
    ('changes', 'said'),
    [
        ({'density': {'at_origin': 250}}, 'bodies[0].density: gradient is missing'),
        ({'density': {'gradient': [0, 0, 1]}}, 'bodies[0].density: at_origin is missing'),
        (
            {'density': {'at_origin': 4, 'gradient': [0, 0, 100]}},
            'bodies[0].density: the density falls to -1',
        ),
        (
            {'density': {'at_origin': 4, 'gradient': [0, 0, 1], 'x': 1}},
            'bodies[0].density.x: unknown key',
        ),
        ({'mass': 3}, 'bodies[0].density: a density that varies needs a shape and gives its mass'),
        ({'shape': {'type': 'particle'}}, 'bodies[0].density: a particle has no volume'),
    ],
)
def test_a_varying_density_that_cannot_be_is_refused(changes, said):
    with pytest.raises(UserError) as caught:
        body(**changes)
    assert said in str(caught.value)
