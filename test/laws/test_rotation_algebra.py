# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws of rotations: a group, an isometry, and its matrix form."""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation

ROUND_OFF = 4e-15  # a few dozen operations on numbers of order one


@pytest.fixture
def attitudes() -> np.ndarray:
    """Return 500 attitudes spread evenly over the sphere, and the half turns where w = 0."""
    random = np.random.default_rng(20260)
    q = random.normal(size=(500, 4))
    half_turns = np.eye(4)[:3]
    return np.concatenate((rotation.normalise(q), half_turns, np.eye(4)[3:]))


def test_quarter_turn_about_z_takes_x_to_y() -> None:
    q = rotation.from_rotation_vector((0.0, 0.0, math.pi / 2))
    assert rotation.rotate(q, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0), abs=ROUND_OFF)


def test_rotate_back_undoes_rotate(attitudes: np.ndarray) -> None:
    v = np.array((0.3, -1.2, 0.7))
    there = rotation.rotate(attitudes, v)
    assert rotation.rotate_back(attitudes, there) == pytest.approx(
        np.broadcast_to(v, there.shape), abs=ROUND_OFF
    )


def test_rotation_keeps_lengths_and_angles(attitudes: np.ndarray) -> None:
    a, b = np.array((0.3, -1.2, 0.7)), np.array((2.0, 0.1, -0.4))
    dots = np.sum(rotation.rotate(attitudes, a) * rotation.rotate(attitudes, b), axis=-1)
    assert dots == pytest.approx(np.full(len(attitudes), a @ b), abs=ROUND_OFF)


def test_product_turns_by_the_right_factor_first(attitudes: np.ndarray) -> None:
    p, q, v = attitudes, np.roll(attitudes, 7, axis=0), np.array((0.3, -1.2, 0.7))
    one_by_one = rotation.rotate(p, rotation.rotate(q, v))
    assert rotation.rotate(rotation.multiply(p, q), v) == pytest.approx(one_by_one, abs=ROUND_OFF)


def test_conjugate_is_the_inverse(attitudes: np.ndarray) -> None:
    product = rotation.multiply(attitudes, rotation.conjugate(attitudes))
    assert product == pytest.approx(
        np.broadcast_to(rotation.IDENTITY, product.shape), abs=ROUND_OFF
    )


def test_matrix_turns_vectors_as_the_quaternion_does(attitudes: np.ndarray) -> None:
    v = np.array((0.3, -1.2, 0.7))
    matrices = rotation.matrix_from_quaternion(attitudes)
    assert matrices @ v == pytest.approx(rotation.rotate(attitudes, v), abs=ROUND_OFF)
    assert np.linalg.det(matrices) == pytest.approx(np.ones(len(attitudes)), abs=ROUND_OFF)


def test_matrix_and_back_is_the_same_attitude(attitudes: np.ndarray) -> None:
    back = rotation.quaternion_from_matrix(rotation.matrix_from_quaternion(attitudes))
    assert rotation.angle_between(back, attitudes) == pytest.approx(
        np.zeros(len(attitudes)), abs=ROUND_OFF
    )
    assert np.all(back[:, 3] >= 0.0)


@pytest.mark.parametrize('angle', (0.0, 1e-300, 1e-12, 1e-8, 1e-3, 1.0, 3.0, math.pi))
def test_angle_is_exact_from_the_smallest_to_half_a_turn(angle: float) -> None:
    start = rotation.normalise((0.1, -0.7, 0.2, 0.5))
    q = rotation.from_rotation_vector(angle * np.array((0.6, 0.0, 0.8)))
    assert rotation.angle_between(q, rotation.IDENTITY) == pytest.approx(angle, rel=1e-15)
    turned = rotation.multiply(q, start)
    # Round-off of the product, in quaternions of length one, is an angle of the same size.
    assert rotation.angle_between(turned, start) == pytest.approx(angle, abs=ROUND_OFF)


def test_both_signs_are_one_attitude(attitudes: np.ndarray) -> None:
    assert np.all(rotation.angle_between(attitudes, -attitudes) == 0.0)


def test_rotation_vector_turns_about_its_own_direction() -> None:
    vector = np.array(((0.2, -0.5, 1.0), (0.0, 0.0, 0.0), (1e-200, 0.0, 0.0)))
    q = rotation.from_rotation_vector(vector)
    assert rotation.rotate(q, vector) == pytest.approx(vector, abs=ROUND_OFF)
    assert q[2, 0] == 5e-201
    assert np.all(q[1] == rotation.IDENTITY)


def test_normalising_leaves_unit_quaternions_bit_for_bit(attitudes: np.ndarray) -> None:
    assert np.array_equal(rotation.normalise(attitudes), attitudes)
    lengthened = attitudes * (1.0 + 3.0 * np.finfo(float).eps)
    assert np.array_equal(rotation.normalise(lengthened[-1]), lengthened[-1])
    longer = np.array((0.0, 0.0, 0.0, 1.0 + 64.0 * np.finfo(float).eps))
    assert np.array_equal(rotation.normalise(longer), (0.0, 0.0, 0.0, 1.0))


@pytest.mark.parametrize('length', (5e-324, 1e-200, 1.7, 1e200, 1.7e308))
def test_normalising_survives_every_length(length: float) -> None:
    q = rotation.normalise((length, 0.0, -length, 0.0))
    half = math.sqrt(0.5)
    assert q == pytest.approx((half, 0.0, -half, 0.0), abs=ROUND_OFF)


@pytest.mark.parametrize(
    'q', ((0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0), (math.inf, 0, 0, 0))
)
def test_no_attitude_is_made_of_zero_or_nan(q: tuple[float, ...]) -> None:
    with pytest.raises(InvalidModel):
        rotation.normalise(q)


def test_leading_shapes_broadcast() -> None:
    q = np.broadcast_to(rotation.IDENTITY, (2, 3, 4))
    assert rotation.rotate(q, np.ones((3, 3))).shape == (2, 3, 3)
    assert rotation.multiply(q, rotation.IDENTITY).shape == (2, 3, 4)
    assert rotation.matrix_from_quaternion(q).shape == (2, 3, 3, 3)
    assert rotation.quaternion_from_matrix(np.broadcast_to(np.eye(3), (2, 3, 3, 3))).shape == (
        2,
        3,
        4,
    )
