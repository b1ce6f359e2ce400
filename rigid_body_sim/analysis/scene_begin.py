# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
When the scene of a recording began: at t = 0, or at the last reset before, as time goes on there.

Forces over time, masses and inertias count from then, and the stamps of a bag from t = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rigid_body_sim.physics.forces.acting_elements import is_timed
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording.bag_reader import Bag, DamagedBag
from rigid_body_sim.runs.manifest_values import MOST_NS
from rigid_body_sim.runs.recorder import START_FILE


def scene_began(bag: Bag, scene: Scene) -> int:
    """
    Tell when a scene began [ns]; 0 where nothing of it depends on time.

    scene : the one that the bag holds

    Raises DamagedBag where the state of its start tells an instant that is none.
    """
    return began_of(bag.attachments, scene, path=bag.path) if bag.holds_run else 0


def began_of(files: Mapping[str, bytes], scene: Scene, *, path: Path) -> int:
    """
    Tell the same of a run of this package by what stands before its first message.

    files : attachments, by name;   path : of the bag
    """
    state = files.get(START_FILE) if is_timed(scene) else None
    if state is None:
        return 0
    began = int.from_bytes(state[-8:], 'little', signed=True)  # see `Simulation.state_bytes`
    if not 0 <= began < MOST_NS:
        raise DamagedBag(
            f'{path}: damaged: the state of its start says that the scene began at '
            f'{began * 1e-9:g} s'
        )
    return began
