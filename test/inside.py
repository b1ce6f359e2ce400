# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What tests see of the inside of the package: the only module of the tests that names what is
private there, so that a change inside is followed here and nowhere else.
"""

from rigid_body_sim.physics.contact.collider import NAMES, Colliders

PAIRS = tuple((a, b) for a in range(len(NAMES) - 1) for b in range(a, len(NAMES)))


def know_all_pairs(patch):
    """
    Let the kernel of each scene of contact know all pairs of shapes, also those that cannot meet
    in it: scenes of other shapes then share one kernel, which gives each the same bits.

    patch : pytest's monkeypatch
    """
    patch.setattr(Colliders, 'pairs', lambda _: PAIRS)
