# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Gap and normal of the analytic pairs are those of the library coal, on 1.5e4 pairs in all, and on
1e5 in the long form.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision.collider import BOX, CAPSULE, CYLINDER, SPHERE
from rigid_body_sim.physics.contact.collision.geometry.boxes import two_boxes
from rigid_body_sim.physics.contact.collision.geometry.boxes.edges import EDGES, nearest_points
from rigid_body_sim.physics.contact.collision.geometry.manifold import FOUND, POINTS, SEPARATION
from rigid_body_sim.physics.contact.collision.pairs import box_box, capsule_box

from .pair_cases import ANALYTIC, Oracle, collide, name, random_pairs

MARGIN = 0.1  # [m]
EXACT = 1e-12  # [m] round-off of closed forms on shapes of metres
ITERATED = 1e-5  # [m] coal's tolerance for pairs that it solves by iteration is 1e-6
PAIRS = {pair: 30_000 if pair == (BOX, BOX) else 7_000 for pair in ANALYTIC}
SHARES = [0.15, pytest.param(1.0, marks=pytest.mark.long)]  # of them


def allowance(a, b, gap):
    """How much deeper than the truth a manifold may be because edges must beat sides clearly."""
    if (a.kind, b.kind) == (BOX, BOX):
        smallest = min(a.sizes.min(), b.sizes.min())
        lead = box_box.EDGE_LEAD + box_box.FACE_LEAD
        # the winner beats |s| of the side, which is larger than the true depth by that share
        return lead * smallest + box_box.EDGE_SHARE / (1.0 - box_box.EDGE_SHARE) * abs(gap)
    if (a.kind, b.kind) == (CAPSULE, BOX) and gap <= -a.sizes[0]:
        share = capsule_box.EDGE_SHARE
        return (capsule_box.EDGE_LEAD * b.sizes.min() + share * abs(gap)) / (1.0 - share)
    return 0.0


def coal_is_wrong(a, b, gap):
    """
    Of a ball whose centre lies in a cylinder coal 3.0.3 takes the farther of side and end: pushed
    out by our shorter depth the two only touch, by coal's own distance. Others check this case.
    """
    return (a.kind, b.kind) == (SPHERE, CYLINDER) and gap < -a.sizes[0]


@pytest.mark.parametrize('share', SHARES)
@pytest.mark.parametrize('pair', ANALYTIC, ids=name)
def test_gap_and_normal_are_those_of_coal(pair, share):
    rng = np.random.default_rng(2026)
    oracle = Oracle()
    agreeing = hits = alone = 0
    count = round(share * PAIRS[pair])
    for a, b in random_pairs(pair, count, rng):
        truth, normal = oracle(a, b)
        found = collide(a, b, MARGIN)
        if abs(truth - MARGIN) < ITERATED:
            continue
        assert (len(found) > 0) == (truth < MARGIN), (a, b, truth)
        if not len(found) or coal_is_wrong(a, b, found.gap):
            continue
        hits += 1
        if truth > 0.0 and pair == (BOX, BOX):
            assert found.gap > truth - ITERATED, (a, b, truth)
            if found.features[0] >= EDGES:  # no patch of sides: the pair of nearest points
                assert found.gap < truth + ITERATED, (a, b, truth)
                alone += 1
        else:
            assert found.gap < truth + ITERATED, (a, b, truth, found.gap)
            assert found.gap > truth - ITERATED - allowance(a, b, found.gap), (a, b, truth)
        agreeing += found.normal @ normal > 1.0 - 1e-6
    assert hits > 0.5 * count
    assert pair != (BOX, BOX) or alone > count / 60
    # Where two normals are nearly as good, or a side goes before an edge, ours may be the other.
    assert agreeing > (0.9 if pair == (BOX, BOX) else 0.98) * hits


def test_ball_inside_a_cylinder_leaves_by_the_nearest_way():
    """Pushed back by the reported depth it touches, and it cannot be free after less."""
    rng = np.random.default_rng(7)
    oracle = Oracle()
    inside = 0
    for a, b in random_pairs((SPHERE, CYLINDER), 3000, rng):
        found = collide(a, b, MARGIN)
        if not coal_is_wrong(a, b, found.gap):
            continue
        inside += 1
        local = b.turn.T @ (a.origin - b.origin)
        to_side, to_end = b.sizes[0] - np.hypot(*local[:2]), b.sizes[1] - abs(local[2])
        assert abs(found.gap + a.sizes[0] + min(to_side, to_end)) < EXACT
        a.origin = a.origin + found.normal * (found.gap - 1e-3)
        assert abs(oracle(a, b)[0] - 1e-3) < EXACT
    assert inside > 300


def test_nearest_points_of_boxes_that_are_apart_are_those_of_coal():
    """Corners, sides and crossing edges alike."""
    rng = np.random.default_rng(8)
    oracle = Oracle()
    apart = 0
    for a, b in random_pairs((BOX, BOX), 6000, rng, depth=0.2):
        truth, normal = oracle(a, b)
        if truth < 1e-3:
            continue
        apart += 1
        found = argument(np.zeros(FOUND))
        numbers = argument(np.concatenate((a.sizes, b.sizes)))
        poses = np.concatenate((a.origin, a.turn.ravel(), b.origin, b.turn.ravel()))
        two_boxes.relate(numbers, 0, 3, argument(poses), 0, 12, found)
        assert nearest_points(argument(poses), 0, 10.0, found) == 1
        assert abs(found[POINTS + SEPARATION] - truth) < ITERATED, (a, b)
        assert normal @ np.array(found[:3]) > 1.0 - 1e-5, (a, b)
    assert apart > 2000
