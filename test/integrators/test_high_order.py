# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The tableaux of rk8 and rk45: their conditions, and the tables of scipy."""

import math

import numpy as np
import pytest
from scipy.integrate import RK45
from scipy.integrate._ivp import dop853_coefficients

from rigid_body_sim.physics.integration.integrators import rk8, rk45

TABLEAUX = [(rk8.A, rk8.B, 8), (rk45.A, rk45.B, 5)]
# sums of terms up to 43 that cancel: some ulps of the largest
ROUND_OFF = 2e-14


def square(a):
    return np.array([[*row, *[0.0] * (len(a) - len(row))] for row in a])


def test_rk8_has_the_coefficients_of_dop853_to_the_last_bit():
    assert np.array_equal(square(rk8.A), dop853_coefficients.A[:12, :12])
    assert np.array_equal(rk8.B, dop853_coefficients.B)


def test_rk45_has_the_coefficients_of_scipy():
    ulp = 1e-15  # the same fractions, rounded once here and perhaps twice there
    assert square(rk45.A)[:, :5] == pytest.approx(RK45.A, rel=ulp)
    assert np.array(rk45.B) == pytest.approx(RK45.B, rel=ulp)
    assert -np.array(rk45.ERROR) == pytest.approx(RK45.E, rel=ulp)


@pytest.mark.parametrize(('a', 'b', 'order'), TABLEAUX, ids=['rk8', 'rk45'])
def test_weights_integrate_polynomials_below_the_order(a, b, order):
    c = [math.fsum(row) for row in a]
    for power in range(order):
        moment = math.fsum(weight * node**power for weight, node in zip(b, c, strict=True))
        assert moment == pytest.approx(1.0 / (power + 1), abs=ROUND_OFF)


@pytest.mark.parametrize(('a', 'b', 'order'), TABLEAUX, ids=['rk8', 'rk45'])
def test_tall_trees_up_to_the_order(a, b, order):
    """b A^(k-1) 1 = 1/k!: the linear equation y' = y is solved to the order."""
    vector = np.ones(len(b))
    for k in range(1, order + 1):
        assert np.dot(b, vector) == pytest.approx(1.0 / math.factorial(k), abs=ROUND_OFF)
        vector = square(a) @ vector


def test_the_error_weights_of_rk45_vanish_up_to_order_four():
    c = [*(math.fsum(row) for row in rk45.A), 1.0]
    for power in range(4):
        moment = math.fsum(e * x**power for e, x in zip(rk45.ERROR, c, strict=True))
        assert moment == pytest.approx(0.0, abs=1e-15)  # round-off
