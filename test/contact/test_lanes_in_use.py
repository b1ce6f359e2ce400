# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body feels nothing of how many others the solver takes beside it, bit for bit."""

from typing import Any

import numpy as np
import pytest

from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene


def boxes(count: int, restitution: float = 0.0) -> Simulation:
    """Let boxes fall on the ground, far from one another; the first one is always the same."""
    bodies: list[dict[str, Any]] = [
        {
            'name': f'box{i}',
            'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
            'mass': 2.0,
            'friction': 0.4,
            'restitution': restitution,
            # the later ones land later: batches become wider, and narrower when they bounce
            'initial': {
                'position': [3.0 * i, 0, 0.2 + 0.01 * i],
                'orientation': [0.05, 0.1, 0, 1],
                'velocity': [0.3, 0, 0],
                'angular_velocity': [0.3, 1.0, 0.5],
            },
        }
        for i in range(count)
    ]
    plane = {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
    scene = {'dt': 0.004, 'gravity': [0, 0, -9.81], 'contact': {'mode': 'timestep'}}
    return Simulation(load_scene({**scene, 'bodies': [plane, *bodies]}))


@pytest.mark.parametrize('restitution', [0.0, 0.5])
def test_a_box_among_others_moves_as_it_moves_alone_to_the_bit(restitution):
    alone = boxes(1, restitution)
    others = [boxes(count, restitution) for count in (3, 9)]
    for _ in range(30):
        alone.step(5)
        for among in others:
            among.step(5)
            assert np.array_equal(among.state.values[1], alone.state.values[1])
    assert len(alone.contacts().point) and all(len(s.contacts().point) for s in others)
