# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A density over space in a scene: linear, polynomial, or a table."""

import math
from itertools import pairwise

import numpy as np
import pytest

from rigid_body_sim import load_scene
from rigid_body_sim.errors import UserError

BOX = {'type': 'box', 'size': [1.0, 2.0, 3.0]}
BALL = {'type': 'sphere', 'radius': 2.0}
TUBE = {'type': 'cylinder', 'radius': 0.5, 'length': 2.0}


def body(shape, density, **more):
    bodies = [{'name': 'b', 'shape': shape, 'density': density, **more}]
    return load_scene({'dt': 0.01, 'bodies': bodies}).bodies[0]


def polynomial(*terms):
    return {
        'type': 'polynomial',
        'terms': [{'coefficient': c, 'powers': list(p)} for c, p in terms],
    }


def table(along, *rows):
    return {'type': 'table', 'along': along, 'rows': [list(row) for row in rows]}


def same(a, b, tolerance=1e-12):
    assert a.mass == pytest.approx(b.mass, rel=tolerance)
    assert a.center_of_mass == pytest.approx(b.center_of_mass, abs=tolerance)
    assert a.inertia == pytest.approx(b.inertia, abs=tolerance * np.trace(b.inertia))


def test_a_polynomial_of_even_powers_by_hand():
    found = body(BOX, polynomial((3.0, (0, 0, 0)), (12.0, (2, 0, 0))))
    # m = 6 (3 + 12 / 12);  integral x^2 dm = 6 (3 / 12 + 12 / 80), y^2 and z^2 as of 24 kg
    assert found.mass == pytest.approx(24.0, rel=1e-12)
    xx, yy, zz = 6 * (3 / 12 + 12 / 80), 24 * 4 / 12, 24 * 9 / 12
    assert np.diag(found.inertia) == pytest.approx((yy + zz, xx + zz, xx + yy), rel=1e-12)


@pytest.mark.parametrize('shape', [BOX, TUBE, BALL])
def test_three_laws_that_say_the_same_give_the_same(shape):
    same(
        body(shape, {'type': 'linear', 'at_origin': 900.0, 'gradient': [0, 0, 100.0]}),
        body(shape, polynomial((900.0, (0, 0, 0)), (100.0, (0, 0, 1)))),
    )
    if shape is not BALL:
        same(
            body(shape, {'at_origin': 900.0, 'gradient': [0, 0, 100.0]}),
            body(shape, table('z', (-2, 700), (-0.3, 870), (0.2, 920), (2, 1100))),
        )


@pytest.mark.parametrize('along', 'xyz')
def test_a_table_is_the_union_of_its_slices(along):
    """A kink where no row of quadrature points would see it."""
    axis = 'xyz'.index(along)
    edge = BOX['size'][axis]
    rows = [(-edge / 2, 100.0), (0.1, 400.0), (edge / 2, 50.0)]
    parts = []
    for (a, at_a), (b, at_b) in pairwise(rows):
        size, middle, gradient = list(BOX['size']), [0.0] * 3, [0.0] * 3
        size[axis], middle[axis], gradient[axis] = b - a, (a + b) / 2, (at_b - at_a) / (b - a)
        slice_of = body(
            {'type': 'box', 'size': size}, {'at_origin': (at_a + at_b) / 2, 'gradient': gradient}
        )
        parts.append((slice_of, np.array(middle)))
    found = body(BOX, table(along, *rows))
    masses = np.array([part.mass for part, _ in parts])
    centers = np.array([np.array(part.center_of_mass) + at for part, at in parts])
    center = masses @ centers / masses.sum()
    inertia = sum(
        part.inertia
        + part.mass * ((c - center) @ (c - center) * np.eye(3) - np.outer(c - center, c - center))
        for (part, _), c in zip(parts, centers)
    )
    assert found.mass == pytest.approx(masses.sum(), rel=1e-12)
    assert found.center_of_mass == pytest.approx(center, abs=1e-12)
    assert found.inertia == pytest.approx(inertia, rel=1e-10)


def test_a_hollow_ball_and_a_ball_of_shells():
    hollow = body(BALL, table('radius', (0, 0), (1.0, 0), (1.0 + 1e-9, 5), (2.0, 5)))
    of = 4 / 3 * math.pi * 5
    assert hollow.mass == pytest.approx(of * (8 - 1), rel=1e-8)
    assert hollow.inertia[0, 0] == pytest.approx(0.4 * of * (32 - 1), rel=1e-8)
    cone = body(BALL, table('radius', (0, 0), (2.0, 6)))  # rho = 3 s
    assert cone.mass == pytest.approx(math.pi * 3 * 16, rel=1e-14)
    assert cone.inertia[2, 2] == pytest.approx(8 * math.pi / 3 * 3 * 64 / 6, rel=1e-14)


@pytest.mark.parametrize(
    ('shape', 'density', 'reason'),
    [
        (BOX, {'type': 'cubic'}, "density.type: density 'cubic' is unknown"),
        (BOX, polynomial((1, (0, 0, 0)), (-20, (2, 0, 0))), 'the density falls to -'),
        (BOX, polynomial((1, (0.5, 0, 0))), 'terms[0].powers: got [0.5, 0.0, 0.0]'),
        (BOX, polynomial((1, (30, 0, 0))), 'together at most 20'),
        (BOX, polynomial((1, (-1, 0, 0))), 'whole numbers of at least 0'),
        (BOX, polynomial(), 'mass is 0.0 kg'),
        (BALL, table('z', (-2, 1), (2, 1)), "a table along 'z' is known of"),
        (BOX, table('z', (-1, 1), (2, 1)), 'it must span the shape'),
        (BOX, table('z', (-2, 0), (2, 0)), 'the density is zero everywhere'),
        (BOX, table('z', (-2, 1)), 'at least two rows'),
        (BOX, table('z', (-2, 1), (-2, 1)), 'must ascend'),
        (BOX, table('z', (-2, 1), (2, -1)), 'rows[1][1]'),
        (BOX, table('z', (-2, 1, 1), (2, 1)), 'rows[0]: got 3 numbers'),
    ],
)
def test_an_impossible_density_is_refused(shape, density, reason):
    with pytest.raises(UserError) as caught:
        body(shape, density)
    assert reason in str(caught.value) and '\n' not in str(caught.value)
