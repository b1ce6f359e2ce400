# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read a material: of a body, or of a pair of bodies.
"""

from __future__ import annotations

from rigid_body_sim.physics.model.material import MATERIAL
from rigid_body_sim.scene.values import Value


def read_material(value: Value) -> dict[str, float]:
    """Return the quantities that are given, by their keys."""
    given = {key: value.find(key) for key in MATERIAL}
    return {
        key: item.number(unit=known.unit, minimum=known.least, maximum=known.most)
        for (key, item), known in zip(given.items(), MATERIAL.values(), strict=True)
        if item is not None
    }
