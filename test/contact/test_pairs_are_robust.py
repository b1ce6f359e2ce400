# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whatever two shapes are and wherever they lie, a kernel answers with a manifold or with none.
"""

import hashlib

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rigid_body_sim.physics.contact.collision.collider import BOX, CAPSULE, CYLINDER, PLANE, SPHERE

from .. import inside
from .hard_shapes import LENGTHS, OFFSETS, SHARES, TURNS, turned
from .pair_cases import ANALYTIC, COUNT, Placed, collide, name, random_pairs

MARGIN = 0.01  # [m]


@st.composite
def hard_pairs(draw):
    """Flat, needle, tiny, huge, coincident, barely touching, parallel, far from the origin."""
    first, second = draw(st.sampled_from(ANALYTIC))
    sizes = np.array(draw(st.tuples(*[LENGTHS] * COUNT[first])))
    a = Placed(first, sizes, np.array(draw(OFFSETS)), draw(TURNS))
    along = a.turn @ np.array(draw(st.tuples(SHARES, SHARES, SHARES)))
    if second == PLANE:
        normal = a.turn @ draw(TURNS)[2]
        offset = normal @ a.origin - draw(SHARES) * sizes[0]
        return a, Placed(PLANE, np.array([*normal, offset]), np.zeros(3), np.eye(3))
    same = first == second and draw(st.booleans())
    other = sizes if same else np.array(draw(st.tuples(*[LENGTHS] * COUNT[second])))
    scale = draw(st.sampled_from([sizes[0] + other[0], sizes[-1] + other[-1], sizes[-1]]))
    return a, Placed(second, other, a.origin + along * scale, a.turn @ draw(TURNS))


def check(found, a, b):
    assert 0 <= len(found) <= 4, (a, b)
    if len(found):
        assert abs(np.linalg.norm(found.normal) - 1.0) < 1e-12, (a, b, found)
        assert np.all(np.isfinite(found.places)) and np.all(np.isfinite(found.features)), (a, b)
        assert np.all(found.gaps <= MARGIN) and np.all(np.isfinite(found.gaps)), (a, b)
        assert len(set(found.features)) == len(found), (a, b, found)


def placed(kind, sizes, origin, turn):
    return Placed(kind, np.array(sizes), np.array(origin), np.array(turn))


# Lengths whose squares are subnormal; and a ball at the rim of a wire, near whose axis the way to
# the ball is round-off.
NEEDLE = placed(CAPSULE, [1e-300, 1e-160], [0.0, 0.0, 0.0], np.eye(3))
LEANING = turned((1, 2, 3), 0.7)
WIRE = placed(CYLINDER, [1e-16, 1.0], [0.0, 0.0, 0.0], LEANING)
RIM = LEANING @ (4e-16, 0.0, 1.0 + 6e-16)


@pytest.mark.parametrize('draws', [100, pytest.param(500, marks=pytest.mark.long)])
def test_a_manifold_is_finite_and_within_the_margin_for_any_shapes(draws):
    @settings(max_examples=draws)
    @given(hard_pairs())
    @example((NEEDLE, placed(CAPSULE, [1e-300, 1e-160], [1e-160, 0.0, 0.0], np.eye(3))))
    @example((NEEDLE, placed(BOX, [1e-160, 1e-160, 1e-160], [3e-160, 0.0, 0.0], np.eye(3))))
    @example((placed(SPHERE, [1e-3], RIM, np.eye(3)), WIRE))
    def holds(pair):
        check(collide(*pair, MARGIN), *pair)

    holds()


@pytest.mark.parametrize('half', [1e-300, 1e-160, 1e-150, 1e-100, 1e-3])
def test_boxes_nearer_than_the_margin_touch_however_small_they_are(half):
    a = placed(BOX, [half] * 3, [0.0, 0.0, 0.0], np.eye(3))
    for way in ((3.0, 0.0, 0.0), (3.0, 3.0, 0.0), (3.0, 3.0, 3.0)):  # side, edge, corner
        found = collide(a, placed(BOX, [half] * 3, half * np.array(way), LEANING), MARGIN)
        check(found, a, way)
        assert 0.0 <= found.gap <= 3.0 * half * np.sqrt(3.0), (half, way)


@pytest.mark.parametrize('pair', ANALYTIC, ids=name)
def test_shapes_that_coincide_with_everything_equal_still_get_a_normal(pair):
    a = Placed(pair[0], np.full(COUNT[pair[0]], 0.5), np.zeros(3), np.eye(3))
    sizes = np.array([0.0, 0.0, 1.0, 0.0]) if pair[1] == PLANE else np.full(COUNT[pair[1]], 0.5)
    found = collide(a, Placed(pair[1], sizes, np.zeros(3), np.eye(3)), MARGIN)
    check(found, a, None)
    assert found.gap < -0.4  # they overlap by half their size at least


@pytest.mark.parametrize('pair', ANALYTIC, ids=name)
def test_not_a_number_in_a_pose_touches_nothing(pair):
    a, b = next(random_pairs(pair, 1, np.random.default_rng(1)))
    a.origin = a.origin * np.nan
    assert len(collide(a, b, MARGIN)) == 0


def digests():
    """Of what the kernels of all pairs find between shapes at random."""
    for pair in ANALYTIC:
        digest = hashlib.sha256()
        for a, b in random_pairs(pair, 100, np.random.default_rng(5)):
            found = collide(a, b, 0.3)
            digest.update(np.int64(len(found)).tobytes())
            if len(found):
                for array in (found.normal, found.places, found.gaps, found.features):
                    digest.update(array.tobytes())
        yield name(pair), digest.hexdigest()


def test_compiled_and_plain_kernels_find_the_same_bits(monkeypatch):
    compiled = dict(digests())
    assert hashlib.sha256(b'').hexdigest() not in compiled.values()
    inside.run_plain(monkeypatch)
    assert dict(digests()) == compiled
