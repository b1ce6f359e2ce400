# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Pairs with a material of their own: it replaces what their materials give, key by key.
"""

from __future__ import annotations

import numpy as np

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.contact.collision.ignored_pairs import pairs_of_colliders
from rigid_body_sim.physics.contact.pair_rules import PairRules
from rigid_body_sim.physics.model.material import PAIR_ID, SIZE, SIZE_OF_PAIR


def materials_of_colliders(rules: PairRules, table: Indices, body_count: int) -> Array:
    """Give the rows of pairs with their own material (`model.material`), in rising order."""
    ids, of_rule = pairs_of_colliders(rules.of_pairs, table, body_count)
    found = np.zeros((len(ids), SIZE_OF_PAIR))
    found[:, :SIZE] = rules.materials[of_rule]
    found[:, PAIR_ID] = ids
    return found[np.argsort(ids)].ravel()
