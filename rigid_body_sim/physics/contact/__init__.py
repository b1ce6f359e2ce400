# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact of rigid bodies by time stepping; imported only by scenes that ask for it.

`plan` what a scene needs; `tick` what happens in a tick; `collider` of one solid, `compound` of
several. `finding` tells who meets where, with `pairs` and what `geometry` knows of two shapes;
`solving` makes rows of it and finds impulses; `resting` lets islands sleep.
"""

from __future__ import annotations

from rigid_body_sim.physics.contact.plan import ContactPlan
from rigid_body_sim.physics.integrators.integrator import Integrator
from rigid_body_sim.physics.layout import Layout
from rigid_body_sim.physics.model import Scene


def prepare(scene: Scene, layout: Layout, integrator: Integrator) -> ContactPlan:
    """
    Make the contact plan of a scene.

    Raises InvalidModel for an unknown key or value, an integrator that does not suit, or a body
    that cannot collide.
    """
    return ContactPlan(scene, layout, integrator)
