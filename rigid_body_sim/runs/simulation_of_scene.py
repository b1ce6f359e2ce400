# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From a scene that was read to a simulation of it: the one spot where a run is made from a file.

What only shows here, because it depends on how the scene is run (an integrator that does not suit,
a pivot beside contact, a hull without volume), is refused as the reader refuses: with file, place
and line.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene.refusal import refusal


def simulation_of(scene: Scene, *, integrator: str | None = None, **choices: Any) -> Simulation:
    """
    Make a simulation; arguments as `Simulation` takes them.

    Raises UserError for what the scene says wrongly; what the caller chose is left InvalidModel.
    """
    try:
        return Simulation(scene, integrator=integrator, **choices)
    except InvalidModel as error:
        chosen = integrator is not None and error.at[:1] == ('integrator',)
        if chosen or not error.at or not scene.source:
            raise
        raise refusal(scene, error) from error
