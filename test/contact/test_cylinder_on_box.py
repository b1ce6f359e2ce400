# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
On a side of a box a cylinder is as round as on a plane.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision.collider import BOX, CYLINDER, PLANE
from rigid_body_sim.physics.contact.collision.geometry.cylinders import on_face as on_face_module
from rigid_body_sim.physics.contact.collision.geometry.cylinders.on_face import UNDECIDED, on_face
from rigid_body_sim.physics.contact.collision.geometry.manifold import FOUND, POINT, POINTS

from .hard_shapes import LENGTHS, OFFSETS, SHARES, TURNS
from .pair_cases import Found, Oracle, Placed, about, collide, random_pairs

MARGIN = 0.01  # [m]
ROUNDING = 1e-14  # [m] round-off of coordinates of tenths of a metre
UPRIGHT = np.eye(3)
LYING = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # axis along world x
TABLE = Placed(BOX, np.array([1.0, 0.5, 0.2]), np.array([0.0, 0.0, -0.2]), np.eye(3))
GROUND = Placed(PLANE, np.array([0.0, 0.0, 1.0, 0.0]), np.zeros(3), np.eye(3))


def touch(box, cylinder, margin=MARGIN):
    """What `on_face` finds, or None where it leaves the pair to another kernel."""
    found = np.zeros(FOUND)
    numbers = np.concatenate((box.sizes, cylinder.sizes))
    turns = box.turn.ravel(), cylinder.turn.ravel()
    poses = np.concatenate((box.origin, turns[0], cylinder.origin, turns[1]))
    count = on_face(argument(numbers), 0, 3, argument(poses), 0, 12, margin, argument(found))
    if count == UNDECIDED:
        return None
    points = found[POINTS : POINTS + POINT * count].reshape(count, POINT)
    return Found(found[:3], points[:, :3], points[:, 3], points[:, 4])


def cylinder(sizes, origin, turn=UPRIGHT):
    return Placed(CYLINDER, np.array(sizes), np.array(origin, dtype=float), turn)


def plan(found):
    """The places seen from above, in order of the angle."""
    x, y = found.places[:, 0], found.places[:, 1]
    angles = np.arctan2(y - y.mean(), x - x.mean())
    return found.places[np.argsort(angles), :2]


@pytest.mark.parametrize('tilt', [0.0, 1e-9, 3e-5, 1e-3, 0.02, 0.7, 1.5, math.pi / 2])
@pytest.mark.parametrize('upside', [1.0, -1.0])
def test_on_a_large_table_a_cylinder_touches_as_on_the_ground(tilt, upside):
    radius, half = 0.12, 0.1
    for heading in np.linspace(-3.0, 3.0, 12):
        turn = about(2, heading) @ about(1, tilt) @ about(2, 1.0) * np.array([1, upside, upside])
        height = radius * math.sin(tilt) + half * math.cos(tilt) - 1e-5
        solid = cylinder([radius, half], [0.3, 0.1, height], turn)
        here, there = touch(TABLE, solid), collide(solid, GROUND, MARGIN)
        assert np.allclose(here.normal, -there.normal, rtol=0.0, atol=ROUNDING)
        names = dict(zip(there.features, zip(there.gaps, there.places)))
        assert set(here.features) == set(names)
        for feature, gap, place in zip(here.features, here.gaps, here.places):
            assert abs(gap - names[feature][0]) < ROUNDING
            assert np.allclose(place, names[feature][1], rtol=0.0, atol=ROUNDING)


def test_lying_cylinder_that_hangs_over_touches_up_to_the_edge():
    for angle in np.linspace(0.0, 6.0, 50):
        solid = cylinder([0.1, 0.3], [0.9, 0.0, 0.1 - 1e-5], about(0, angle) @ LYING)
        found = touch(TABLE, solid)
        assert np.allclose(np.sort(found.places[:, 0]), [0.6, 1.0], rtol=0.0, atol=1e-11)
        assert np.allclose(found.gaps, -1e-5, rtol=0.0, atol=ROUNDING)


def test_standing_cylinder_half_over_the_edge_rests_on_half_a_disc():
    found = touch(TABLE, cylinder([0.1, 0.3], [1.0, 0.1, 0.3]))
    assert len(found) >= 3
    assert np.max(found.places[:, 0]) <= 1.0 + 1e-11
    assert abs(np.min(found.places[:, 0]) - 0.9) < ROUNDING
    assert abs(np.ptp(found.places[:, 1]) - 0.2) < 1e-12  # the whole diameter lies on the edge


def test_small_box_on_the_end_of_a_cylinder_rests_on_its_four_corners():
    box = Placed(
        BOX, np.array([0.05, 0.04, 0.1]), np.array([0.02, 0.01, 0.4 - 1e-5]), about(2, 0.3)
    )
    found = touch(box, cylinder([0.2, 0.3], [0, 0, 0]))
    assert np.allclose(found.normal, [0, 0, -1], rtol=0.0, atol=ROUNDING)
    corners = [box.origin + box.turn @ [x, y, 0.0] for x in (-0.05, 0.05) for y in (-0.04, 0.04)]
    for corner in corners:
        assert np.min(np.linalg.norm(found.places[:, :2] - corner[:2], axis=1)) < ROUNDING


def test_cylinder_across_an_edge_touches_in_one_point_of_its_true_mantle():
    beam = Placed(BOX, np.array([1.0, 0.1, 0.1]), np.zeros(3), about(0, math.pi / 4))
    top = 0.1 * math.sqrt(2.0)
    for angle in np.linspace(0.0, 6.0, 50):
        turn = about(2, 0.5 * math.pi) @ about(0, angle) @ LYING
        found = collide(beam, cylinder([0.1, 0.3], [0.2, 0.05, top + 0.1 - 1e-3], turn), MARGIN)
        assert len(found) == 1
        assert abs(found.gap + 1e-3) < ROUNDING
        assert np.allclose(found.normal, [0, 0, 1], rtol=0.0, atol=ROUNDING)
        place = [0.2, 0.0, top - 0.5e-3]
        # a point that is within a millionth of the side is over it
        assert np.allclose(found.places[0], place, rtol=0.0, atol=1e-6)


def test_what_it_decides_is_the_distance_or_the_depth_by_coal():
    rng = np.random.default_rng(9)
    oracle = Oracle()
    decided = 0
    for box, solid in random_pairs((BOX, CYLINDER), 5000, rng, depth=0.4):
        found = touch(box, solid, 0.1)
        truth, _ = oracle(box, solid)
        if found is None or abs(truth - 0.1) < 1e-5:
            continue
        assert (len(found) > 0) <= (truth < 0.1), (box, solid)
        if not len(found):
            assert truth > 0.1, (box, solid)
            continue
        decided += 1
        smallest = min(box.sizes.min(), solid.sizes.min())
        share, lead = on_face_module.EDGE_SHARE, on_face_module.EDGE_LEAD
        deeper = (lead * smallest + share * abs(found.gap)) / (1.0 - share)
        # coal iterates on the round rim: 1e-5; what hangs over may be higher by HANGING
        assert found.gap > truth - 1e-5 - (deeper if truth < 0.0 else 0.0), (box, solid)
        higher = on_face_module.HANGING * solid.sizes[0]
        assert found.gap < truth + 1e-5 + higher, (box, solid)
    assert decided > 300


@pytest.mark.parametrize('draws', [60, pytest.param(300, marks=pytest.mark.long)])
def test_any_box_and_cylinder_give_a_finite_manifold(draws):
    settings(max_examples=draws)(given(st.data())(_gives_a_finite_manifold))()


def _gives_a_finite_manifold(data):
    sizes = np.array(data.draw(st.tuples(*[LENGTHS] * 5)))
    box = Placed(BOX, sizes[:3], np.array(data.draw(OFFSETS)), data.draw(TURNS))
    along = np.array(data.draw(st.tuples(SHARES, SHARES, SHARES)))
    scale = data.draw(st.sampled_from([sizes[0] + sizes[3], sizes[2] + sizes[4], sizes[4]]))
    origin = box.origin + box.turn @ along * scale
    found = touch(box, Placed(CYLINDER, sizes[3:], origin, box.turn @ data.draw(TURNS)))
    if found is not None and len(found):
        assert len(found) <= 4 and np.all(found.gaps <= MARGIN)
        assert abs(np.linalg.norm(found.normal) - 1.0) < 1e-12
        assert np.all(np.isfinite(found.places)) and np.all(np.isfinite(found.gaps))
