# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sizes, places and turns that make shapes flat, needles, tiny, huge, coincident or parallel."""

import numpy as np
from hypothesis import strategies as st

LENGTHS = st.one_of(
    st.sampled_from([1e-300, 1e-160, 1e-6, 0.1, 0.5, 1.0, 1e6, 1e160, 1e300]),
    st.floats(1e-6, 1e3),
)
SHARES = st.one_of(
    st.sampled_from([0.0, 1e-300, 1e-17, 1e-9, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 2.0]),
    st.floats(-2.0, 2.0),
)
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (1, 1, 1))
ANGLES = st.one_of(
    st.sampled_from([0.0, 1e-300, 1e-17, 1e-9, 1e-4, np.pi / 4, np.pi / 2, np.pi]),
    st.floats(-4.0, 4.0),
)


def turned(axis, angle):
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)


TURNS = st.builds(turned, st.sampled_from(AXES), ANGLES)
OFFSETS = st.tuples(*[st.sampled_from([0.0, 1.0, -1e6, 1e15])] * 3)
