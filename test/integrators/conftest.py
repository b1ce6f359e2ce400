# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Fewer compiled kernels for all scenes of this folder: where forces act, kernels know constant
forces, drag and springs, whether a scene has them or not.
"""

import pytest

from .. import inside


@pytest.fixture(autouse=True)
def share_kernels(monkeypatch):
    """
    Let all scenes with forces know constant ones, drag and springs.
    """
    inside.know_forces(monkeypatch, 'constant', 'drag', 'spring')
