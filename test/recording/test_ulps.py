# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Distances between doubles follow from their bit patterns.
"""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rigid_body_sim.recording.ulps import ulp_distance

LARGEST = np.finfo(float).max
doubles = st.floats(-LARGEST, np.nextafter(LARGEST, 0.0))
patterns = st.integers(0, 2**64 - 1)


def of_bits(pattern):
    """
    The double of a bit pattern.
    """
    return np.array([pattern], np.uint64).view(np.float64)


@given(doubles)
def test_the_next_double_is_one_ulp_away(x):
    expected = 2 if x == 0.0 and np.signbit(x) else 1  # from -0 there is +0 in between
    assert ulp_distance(x, np.nextafter(x, np.inf)) == expected


@given(patterns, patterns)
def test_the_distance_is_zero_exactly_for_equal_bits(a, b):
    assert (ulp_distance(of_bits(a), of_bits(b))[0] == 0) == (a == b)
    assert ulp_distance(of_bits(a), of_bits(b)) == ulp_distance(of_bits(b), of_bits(a))


@given(doubles, doubles, doubles)
def test_distances_add_up_along_the_line(x, y, z):
    a, b, c = sorted((x, y, z))
    whole = int(ulp_distance(a, c))
    if len({a, b, c}) == 3:  # sorting cannot tell -0 from +0
        assert whole == int(ulp_distance(a, b)) + int(ulp_distance(b, c))


def test_zeros_and_nans_are_told_apart():
    assert ulp_distance(-0.0, 0.0) == 1
    assert ulp_distance(of_bits(0x7FF8000000000000), of_bits(0x7FF8000000000005)) == 5
    assert ulp_distance(np.finfo(float).max, np.inf) == 1
    assert ulp_distance(of_bits(0), of_bits(2**64 - 1)) == 2**63
