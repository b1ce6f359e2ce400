# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A few compiled kernels for all scenes of this folder: each knows all pairs of shapes, so that what
tells one from another is whether something bounces, resists rolling, sleeps, or feels forces.
"""

import pytest

from .. import inside


@pytest.fixture(autouse=True)
def share_kernels(monkeypatch):
    """
    Let all scenes know all pairs, and all scenes with forces the same forces.
    """
    inside.know_all_pairs(monkeypatch)
    inside.know_forces(monkeypatch, 'drag', 'gravity', 'spring', 'time')
