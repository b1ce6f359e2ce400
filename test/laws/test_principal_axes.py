# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rule of the principal axes: given axes, equal moments, order and sign."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import plain_products, rotation
from rigid_body_sim.physics.model.principal_axes import (
    is_diagonal,
    moments_of,
    principal_axes,
    spread_axes,
)

ROUND_OFF = 1e-14  # [-] of the largest moment: some tens of roundings
EPS = float(np.finfo(np.float64).eps)
ATTITUDES = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: sum(x * x for x in q) > 1e-3)
    .map(rotation.normalise)
)
UNIT_OF_MASS = st.integers(-200, 200).map(lambda n: 2.0**n)


def tensor(moments, r):
    """Return the tensor of a body whose principal axes are the columns of r."""
    return plain_products.turned_tensor(r, np.diag(moments))


def assert_explains(inertia, moments, axes):
    """Check I = V diag V^T, V^T V = 1, det V = +1, and the direction of each axis."""
    largest = np.max(np.abs(inertia))
    assert axes @ np.diag(moments) @ axes.T == pytest.approx(inertia, abs=ROUND_OFF * largest)
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=ROUND_OFF)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=ROUND_OFF)
    assert np.all(np.diag(axes) > 0.0)


@settings(max_examples=30)
@given(ATTITUDES, st.tuples(*[st.floats(1e-6, 1.0)] * 3), UNIT_OF_MASS)
def test_the_axes_explain_any_tensor_in_any_unit(q, moments, unit):
    inertia = tensor(np.array(moments) * unit, rotation.matrix_from_quaternion(q))
    found, axes = principal_axes(inertia)
    assert_explains(inertia, found, axes)
    scaled, same = principal_axes(inertia * 4.0)
    assert np.array_equal(scaled, 4.0 * found)
    assert np.array_equal(same, axes)
    rounding = ROUND_OFF * np.max(found)
    assert moments_of(inertia.tolist()) == pytest.approx(np.sort(found), abs=rounding)


@settings(max_examples=30)
@given(ATTITUDES, st.integers(0, 2), st.sampled_from((0.5, 1.9)), st.floats(-3, 3))
def test_an_axis_of_symmetry_is_met_by_the_shortest_turn(q, odd, moment, ulps):
    moments = np.ones(3)
    moments[odd] = moment
    moments[odd - 1] += ulps * EPS  # what rounding leaves
    r = rotation.matrix_from_quaternion(q)
    found, axes = principal_axes(tensor(moments, r))
    assert_explains(tensor(moments, r), found, axes)
    n = r[:, odd]
    k = int(np.argmax(np.abs(n)))
    if np.sort(np.abs(n))[1] < np.abs(n[k]) - 1e-6:  # no tie
        assert found[k] == pytest.approx(moment, rel=ROUND_OFF)
        assert axes[:, k] == pytest.approx(n * np.sign(n[k]), abs=1e-13)
        turn = rotation.quaternion_from_matrix(axes)
        assert turn[k] == pytest.approx(0.0, abs=1e-13)  # none about the axis itself
    if not is_diagonal(tensor(moments, r).tolist()):
        least, middle, most = np.sort(found)
        assert middle == (most if moment < 1.0 else least)


def test_of_axes_as_near_the_first_is_taken_whatever_rounding_says():
    for n in itertools.product((1.0, -1.0), repeat=3):
        for ulps in itertools.product((0, 1, -1), repeat=3):
            v = np.array(n) * (1.0 + EPS * np.array(ulps))
            v /= np.sqrt(3.0)
            found, axes = principal_axes(np.eye(3) + np.outer(v, v))
            assert found == pytest.approx((2, 1, 1), rel=ROUND_OFF)
            assert axes[:, 0] == pytest.approx(np.array(n) * n[0] / np.sqrt(3.0), abs=1e-14)


@settings(max_examples=30)
@given(ATTITUDES)
def test_where_all_moments_are_equal_the_given_axes_stay(q):
    inertia = tensor((2.0, 2.0, 2.0), rotation.matrix_from_quaternion(q))
    found, axes = principal_axes(inertia)
    assert np.array_equal(axes, np.eye(3))
    assert np.array_equal(found, np.diag(inertia))


def test_what_rounding_leaves_off_the_diagonal_turns_nothing():
    inertia = np.diag((1.0, 1.0 + 1e-12, 0.3))
    inertia[0, 1] = inertia[1, 0] = 4 * EPS
    found, axes = principal_axes(inertia)
    assert np.array_equal(axes, np.eye(3))
    assert np.array_equal(found, np.diag(inertia))


@settings(max_examples=30)
@given(ATTITUDES, st.permutations((1.0, 2.0, 2.5)))
def test_turning_a_body_turns_its_axes(q, moments):
    """Moments that differ fix the axes: only their numbers and directions are left to the rule."""
    r = rotation.matrix_from_quaternion(q)
    _, axes = principal_axes(tensor(moments, r))
    among = np.abs(r.T @ axes)
    assert among[among > 0.5] == pytest.approx(np.ones(3), abs=1e-13)
    assert np.sum(among) == pytest.approx(3.0, abs=1e-12)


def test_a_tensor_that_is_not_finite_has_no_axes():
    with pytest.raises(InvalidModel, match='NaN or infinity'):
        principal_axes(np.full((3, 3), np.nan))


def test_points_spread_along_the_given_axes_of_a_square_and_of_a_tilted_needle():
    square = np.array(list(itertools.product((-0.5, 0.5), (-0.5, 0.5), (0.0,))))
    assert np.array_equal(spread_axes(square), np.eye(3))
    r = rotation.matrix_from_quaternion(rotation.normalise((0.3, -0.2, 0.6, 0.7)))
    needle = np.random.default_rng(3).normal(size=(40, 3)) * (1.0, 1e-6, 1e-11)
    turned = needle @ r.T - np.mean(needle @ r.T, axis=0)
    found = plain_products.length((turned @ spread_axes(turned)).T)
    singular = np.linalg.svd(needle - np.mean(needle, axis=0), compute_uv=False)  # LAPACK's
    assert np.sort(found)[::-1] == pytest.approx(singular, rel=1e-4)
