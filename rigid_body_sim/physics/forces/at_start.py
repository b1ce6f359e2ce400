# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where force elements have no energy or no direction: what the start of a scene is asked."""

from __future__ import annotations

from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.forces.element import BodyState
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.physics.state.snapshot import State, StateReader

MOST_TOLD = 8  # forces without direction that are told of one by one


def asks_the_start(scene: Scene) -> bool:
    """Whether a force of a scene may have no energy or no direction anywhere."""
    return any(hasattr(f, 'no_energy') or hasattr(f, 'no_direction') for f in scene.forces)


def bodies_in(scene: Scene, state: State) -> BodyState:
    """Give the bodies of a scene by name, where a state has them."""
    matrices = so3.matrix_from_quaternion(state.orientation)
    return BodyState(
        {body.name: (body, state.position[i], matrices[i]) for i, body in enumerate(scene.bodies)}
    )


def without_energy(scene: Scene, state: State) -> tuple[int, str] | None:
    """Find a force that has no energy in a state: its place in the scene, and why."""
    asked = [(i, f) for i, f in enumerate(scene.forces) if hasattr(f, 'no_energy')]
    view = bodies_in(scene, state) if asked else None
    for i, force in asked:
        said = force.no_energy(view)
        if said is not None:
            return i, said
    return None


def need_energy(scene: Scene, state: State) -> None:
    """Refuse a scene that begins where a force has no energy."""
    found = without_energy(scene, state)
    if found is not None:
        i, said = found
        with blaming('forces', i):
            raise InvalidModel(said)


def start_warnings(scene: Scene) -> tuple[str, ...]:
    """Warn of forces that have no direction where a scene begins, a line each."""
    if not asks_the_start(scene):
        return ()
    layout = Layout(scene)
    begin = StateReader(layout).read(layout.translation(), layout.rotation(), 0.0)
    return without_direction(scene, begin)


def without_direction(scene: Scene, state: State) -> tuple[str, ...]:
    """Warn of forces that have no direction in a state, a line each."""
    asked = [(i, f) for i, f in enumerate(scene.forces) if hasattr(f, 'no_direction')]
    view = bodies_in(scene, state) if asked else None
    told = [f'forces[{i}]: {said}' for i, f in asked if (said := f.no_direction(view)) is not None]
    more = len(told) - MOST_TOLD
    return (*told[:MOST_TOLD], *([f'{more} more forces have no direction'] if more > 0 else []))
