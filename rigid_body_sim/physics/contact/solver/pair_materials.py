# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Pairs with a material of their own: it replaces what their materials give, key by key.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.ignored_pairs import pairs_of_colliders
from rigid_body_sim.physics.contact.pair_rules import PairRules
from rigid_body_sim.physics.contact.solver import constraint
from rigid_body_sim.physics.contact.solver.pair_material_record import (
    FRICTION,
    MATERIAL,
    PAIR_ID,
    RESTITUTION,
    ROLLING,
    SIZE,
    TORSIONAL,
)


@inline
def _given(value: Any, otherwise: Any) -> Any:
    """Choose what is given; NaN is not."""
    return value if value == value else otherwise


@kernel
def use_pair_materials(
    pair_materials: Array, order: Indices, manifolds: Array, rows: Array
) -> None:
    """Write the materials of the pairs of a group that have their own; order: its manifolds."""
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        pair_id = manifolds[record + manifold_record.PAIR_ID]
        low, high = 0, len(pair_materials) // SIZE
        while low < high:
            middle = (low + high) // 2
            if pair_materials[middle * SIZE + PAIR_ID] < pair_id:
                low = middle + 1
            else:
                high = middle
        place = low * SIZE
        if place == len(pair_materials) or pair_materials[place + PAIR_ID] != pair_id:
            continue
        lane = int(manifolds[record + manifold_record.LANE])
        rows[lane + constraint.FRICTION] = _given(
            pair_materials[place + FRICTION], rows[lane + constraint.FRICTION]
        )
        rows[lane + constraint.RESTITUTION] = _given(
            pair_materials[place + RESTITUTION], rows[lane + constraint.RESTITUTION]
        )
        rows[lane + constraint.ROLLING_FRICTION] = _given(
            pair_materials[place + ROLLING], rows[lane + constraint.ROLLING_FRICTION]
        )
        rows[lane + constraint.TORSIONAL_FRICTION] = _given(
            pair_materials[place + TORSIONAL], rows[lane + constraint.TORSIONAL_FRICTION]
        )


def materials_of_colliders(rules: PairRules, table: Indices, body_count: int) -> Array:
    """Give the rows of pairs with their own material, one-dimensional, in rising order."""
    ids, of_rule = pairs_of_colliders(rules.of_pairs, table, body_count)
    found = np.zeros((len(ids), SIZE))
    found[:, PAIR_ID] = ids
    found[:, MATERIAL] = rules.materials[of_rule]
    return found[np.argsort(ids)].ravel()
