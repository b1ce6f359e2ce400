# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What two shapes find of each other depends neither on the axes of the world nor on who is first.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.contact.collision.collider import BOX, CAPSULE, PLANE, SPHERE
from rigid_body_sim.physics.contact.collision.pairs import box_box

from .pair_cases import ANALYTIC, collide, name, random_pairs, random_turns

MARGIN = 0.1  # [m]
ROUNDING = (
    1e-11  # [m] round-off of coordinates of metres, and of directions over tenths of a metre
)


def ordered(found):
    """Points in an order that round-off does not change."""
    return np.array(sorted(zip(found.features, found.gaps, *found.places.T)))


@pytest.mark.parametrize('draws', [150, pytest.param(500, marks=pytest.mark.long)])
@pytest.mark.parametrize('pair', ANALYTIC, ids=name)
def test_manifold_moves_with_the_two_shapes(pair, draws):
    rng = np.random.default_rng(11)
    turns, shifts = random_turns(rng, draws), rng.normal(size=(draws, 3))
    for (a, b), turn, shift in zip(random_pairs(pair, draws, rng), turns, shifts):
        here = collide(a, b, MARGIN)
        there = collide(a.moved(turn, shift), b.moved(turn, shift), MARGIN)
        if not len(here):
            assert not len(there)
            continue
        assert np.allclose(there.normal, turn @ here.normal, rtol=0.0, atol=ROUNDING), (a, b)
        assert np.array_equal(there.features, here.features), (a, b)
        assert np.allclose(there.gaps, here.gaps, rtol=0.0, atol=ROUNDING), (a, b)
        moved = here.places @ turn.T + shift
        assert np.allclose(there.places, moved, rtol=0.0, atol=100 * ROUNDING), (a, b)


@pytest.mark.parametrize('pair', [p for p in ANALYTIC if p[1] != PLANE], ids=name)
def test_a_million_metres_from_the_origin_the_manifold_is_the_same(pair):
    rng = np.random.default_rng(12)
    far = np.array([2.0**20, -(2.0**20), 2.0**19])  # a million metres, in round binary numbers
    for a, b in random_pairs(pair, 300, rng):
        a.origin, b.origin = (np.round(x * 2.0**30) / 2.0**30 for x in (a.origin, b.origin))
        here = collide(a, b, MARGIN)
        there = collide(a.moved(np.eye(3), far), b.moved(np.eye(3), far), MARGIN)
        assert np.array_equal(there.gaps, here.gaps), (a, b)  # differences come first: no bit lost
        assert np.array_equal(there.features, here.features), (a, b)
        assert not len(here) or np.array_equal(there.normal, here.normal), (a, b)
        # the places themselves are rounded to 1e-10 m there
        assert np.allclose(there.places - far, here.places, rtol=0.0, atol=1e-9), (a, b)


@pytest.mark.parametrize('draws', [600, pytest.param(2000, marks=pytest.mark.long)])
@pytest.mark.parametrize('kind', [SPHERE, CAPSULE, BOX], ids=lambda kind: name((kind,)))
def test_exchanging_the_two_shapes_turns_the_normal_and_nothing_else(kind, draws):
    rng = np.random.default_rng(13)
    same = hits = 0
    for a, b in random_pairs((kind, kind), draws, rng):
        one, two = collide(a, b, MARGIN), collide(b, a, MARGIN)
        assert (len(one) > 0) == (len(two) > 0), (a, b)
        if not len(one):
            continue
        hits += 1
        lead = 0.0
        if kind == BOX:  # which box has the reference side is settled in favour of the first
            lead = box_box.FACE_LEAD * min(a.sizes.min(), b.sizes.min())
        assert abs(one.gap - two.gap) <= 1.1 * lead + ROUNDING, (a, b)
        if one.normal @ two.normal < -1.0 + 1e-12 and len(one) == len(two):
            gaps = np.sort(one.gaps), np.sort(two.gaps)
            middles = np.mean(one.places, axis=0), np.mean(two.places, axis=0)
            same += all(np.allclose(x, y, rtol=0.0, atol=1e-5) for x, y in (gaps, middles))
    # Sides that are parallel may serve either way, and the nearest point of capsules side by side
    # is left out beside an end of the first: these differ by points that carry little.
    assert same >= (1.0 if kind == SPHERE else 0.97) * hits > draws / 2
