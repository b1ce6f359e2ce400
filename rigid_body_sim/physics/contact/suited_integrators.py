# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which integrators can move bodies that touch: those with one free rotation between two kicks."""

from __future__ import annotations

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

METHODS = (
    'dmv2, dmv4, dmv6, dmv8, dmv10, five_rotations, five_rotations_kl6, exact_rotor, taylor16'
)


def unsuited(integrator: Integrator) -> str | None:
    """Tell why an integrator cannot move bodies that touch, or None."""
    scheme = integrator.scheme
    if isinstance(scheme, Splitting) and scheme.kicks == (0.5, 0.5) and scheme.drifts == (1.0,):
        return None
    return (
        'with contact a substep needs one free rotation between its two kicks; '
        f'take one of: {METHODS}'
    )
