# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a pair has held in the last tick it holds while another choice is hardly better: so what
trembles between two choices does not change with every tick. `test_manifolds` has the same of
corners of faces.
"""

import itertools

import numpy as np
import pytest

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision import held_features
from rigid_body_sim.physics.contact.collision.collider import BOX, NAMES, PLANE
from rigid_body_sim.physics.contact.collision.geometry.boxes.edges import CORNERS_A, EDGES
from rigid_body_sim.physics.contact.collision.geometry.manifold import FOUND, HELD_COUNT

from . import hull_cases as cases
from .pair_cases import about

MARGIN = 0.01  # [m]


def changes(meet, chooses_second, values):
    """
    Where the second choice begins on the way through the values, and where it ends on the way
    back.
    """
    held, turning = (), []
    for way, wanted in ((values, True), (values[::-1], False)):
        chosen = []
        for value in way:
            found = meet(value, held)
            held = found.features
            chosen.append(chooses_second(found))
        assert chosen == sorted(chosen, reverse=not wanted)  # no more than one change
        turning.append(way[chosen.index(wanted)])
    return turning


def as_hull(half):
    return cases.hull(np.array(list(itertools.product(*([-h, h] for h in half)))))


@pytest.mark.parametrize('gap', [-1e-4, pytest.param(1e-4, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ('lower', 'upper'),
    [
        (cases.box, cases.box),
        (as_hull, as_hull),
        pytest.param(cases.box, as_hull, marks=pytest.mark.long),
    ],
)
def test_the_face_that_gives_the_normal_gives_it_until_another_is_better(lower, upper, gap):
    """
    The upper one leans by a tenth of a milliradian, so the face of the one that is wider
    separates by so much more as its half edge is longer than the other, 0.1 m.
    """
    lean, low = 1e-4, np.array([0.1, 0.1, 0.02])

    def meet(half, held):
        a, b = lower(low), upper(np.array([half, 0.1, 0.02]))
        turn = about(1, lean)
        pose_a = cases.place(a, np.zeros(3), np.eye(3))
        pose_b = cases.place(b, np.array([0.0, 0.0, 0.04 + gap + lean * 0.1]), turn)
        return cases.collide(a, b, pose_a, pose_b, MARGIN, held=held)

    up, down = changes(meet, lambda found: found.normal[0] != 0.0, np.linspace(0.06, 0.14, 81))
    lead = 1e-4 * 0.02 / lean  # FACE_LEAD of the least half edge, as a half edge
    step = 1e-3
    assert up == pytest.approx(0.1 + lead, abs=1.1 * step)
    assert down == pytest.approx(0.1 - lead, abs=1.1 * step)


def test_edges_of_boxes_that_met_meet_until_a_face_is_nearly_as_good():
    """
    Over a high edge of the lower box lies one of the upper: what it leans by makes their
    separation the better one.
    """
    a, b = cases.box(np.array([0.3, 0.1, 0.1])), cases.box(np.array([0.1, 0.3, 0.1]))
    turn_b = about(2, 0.5) @ about(1, np.pi / 4)

    def meet(lean, held):
        pose_a = cases.place(a, np.zeros(3), about(0, lean))
        height = 0.1 * (np.cos(lean) + np.sin(lean)) + 0.1 * np.sqrt(2.0) + 1e-5
        pose_b = cases.place(b, np.array([0.0, 0.0, height]), turn_b)
        return cases.collide(a, b, pose_a, pose_b, MARGIN, held=held)

    def edges_meet(found):
        return EDGES <= found.features[0] < CORNERS_A

    up, down = changes(meet, edges_meet, np.linspace(5e-5, 1.5e-3, 146))
    assert 0.4 * up < down < 0.6 * up  # HELD_LEAD


@pytest.mark.parametrize('draws', [120, pytest.param(400, marks=pytest.mark.long)])
def test_boxes_that_lie_nearly_flat_on_each_other_meet_as_sides(draws):
    """
    Within 2 mrad of parallel no crossing of edges stands for the patch of two sides.
    """
    rng = np.random.default_rng(4)
    for _ in range(draws):
        a, b = (cases.box(rng.uniform(0.05, 0.15, 3)) for _ in range(2))
        leans = rng.uniform(-1.0, 1.0, 2) * 1.3e-3  # together below 2 mrad
        turn = about(2, rng.uniform(0.0, np.pi)) @ about(0, leans[0]) @ about(1, leans[1])
        pose_a = cases.place(a, np.zeros(3), np.eye(3))
        middle = np.array([*rng.uniform(-0.15, 0.15, 2), a.sizes[2] + b.sizes[2] + 1e-3])
        apart = cases.collide(a, b, pose_a, cases.place(b, middle, turn), MARGIN)
        if len(apart) == 0:
            continue
        middle[2] -= apart.gap + 1e-5  # the lowest overlaps
        found = cases.collide(a, b, pose_a, cases.place(b, middle, turn), MARGIN)
        assert np.all(found.features < EDGES)


def test_a_normal_is_that_of_a_face_of_b_only_where_the_last_tick_had_one():
    """
    Whatever stood first in it: nearest points are no face of either.
    """
    a, b = as_hull([0.1, 0.1, 0.02]), as_hull([0.1, 0.1, 0.02])
    pose_a = cases.place(a, np.zeros(3), np.eye(3))
    pose_b = cases.place(b, np.array([0.0, 0.0, 0.04 - 1e-5]), about(1, 1e-5))
    for held in ((), (-1.0,), (-(2.0**30) - 1.0,)):
        assert cases.collide(a, b, pose_a, pose_b, MARGIN, held=held).normal[0] == 0.0


def test_a_hull_on_a_plane_holds_the_corners_that_it_held():
    """
    Any four of seven that are level; but the lowest is among them, where it is DEEPER.
    """
    angle = 2.0 * np.pi * np.arange(7) / 7
    ring = np.column_stack((0.1 * np.cos(angle), 0.1 * np.sin(angle)))
    prism = cases.hull(np.array([[*corner, z] for corner in ring for z in (-0.05, 0.05)]))
    plane = cases.Shape(PLANE, np.array([0.0, 0.0, 1.0, 0.0]))
    still = np.concatenate((np.zeros(3), np.eye(3).ravel()))

    def meet(lean, held):
        pose = cases.place(prism, np.array([0.0, 0.0, 0.05]), lean)
        return cases.collide(prism, plane, pose, still, MARGIN, held=held)

    bottom = set()
    for yaw in angle:
        lean = about(2, -yaw) @ about(1, 1e-3) @ about(2, yaw)
        found = meet(lean, ())
        bottom.add(float(found.features[np.argmin(found.gaps)]))
    assert len(bottom) == 7
    for held in itertools.combinations(sorted(bottom), 4):
        assert sorted(meet(np.eye(3), held).features) == list(held)
        lean = about(1, 6e-4)
        found, fresh = meet(lean, held), meet(lean, ())
        assert found.gap == fresh.gap  # the lowest is there


def test_no_pair_is_told_what_another_has_held():
    """
    Of a pair that is not known, nothing is.
    """
    found, rows = np.zeros(FOUND), np.zeros(3 * held_features.SIZE)
    row = held_features.SIZE
    rows[row + held_features.COUNT] = 2.0
    rows[row + held_features.FEATURES : row + held_features.FEATURES + 2] = 7.0, 8.0
    for index, count in ((1, 2.0), (0, 0.0), (2, 0.0)):
        held_features.tell(index, BOX, BOX, argument(rows), argument(found))
        assert found[HELD_COUNT] == count
    held_features.tell(1, BOX, BOX, argument(np.zeros(0)), argument(found))
    assert found[HELD_COUNT] == 0.0


def test_only_pairs_that_hold_points_are_told_whatever_else_a_scene_has():
    """
    Cylinders met otherwise beside a hull 700 m away, which asks for what is held.
    """
    found, rows = np.zeros(FOUND), np.zeros(held_features.SIZE)
    rows[held_features.COUNT] = 2.0
    for pair in itertools.product(range(len(NAMES)), repeat=2):
        held_features.tell(0, *pair, argument(rows), argument(found))
        if pair in held_features.KINDS:
            assert found[HELD_COUNT] == 2.0
        elif pair[::-1] not in held_features.KINDS:  # no pair is asked that way round
            assert found[HELD_COUNT] == 0.0
