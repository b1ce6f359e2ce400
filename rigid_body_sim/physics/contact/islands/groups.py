# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies that force elements join, whether they touch or not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.integration.schemes.implicit.coupling import components, neighbours
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.layout import Layout


def groups_of(scene: Scene, layout: Layout) -> NDArray[np.int64]:
    """For each moving body the first of those that force elements join to it."""
    groups = np.arange(layout.n_moving)
    for members in components(neighbours(scene, layout)):
        groups[members] = min(members)
    return groups
