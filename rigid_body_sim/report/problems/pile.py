# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Boxes by the thousand fall flat on the ground and stay there: what a step with contact costs.

Each falls 0.05 m without touching its neighbours and rests where it landed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.report.problem import THROUGHPUT, Final, Problem, scene_document

GRAVITY, SIZE, DROP, GAP = 9.81, 0.2, 0.05, 0.3  # [m/s^2], [m], [m], [m] from box to box
STEP = 0.005  # [s]


def spread(scene: Scene, bodies: int) -> Scene:
    """Lay out so many boxes on a square grid."""
    ground, one = scene.bodies
    side = int(np.ceil(np.sqrt(bodies)))
    boxes = []
    for index in range(bodies):
        row, column = divmod(index, side)
        place = (GAP * column, GAP * row, SIZE / 2.0 + DROP)
        boxes.append(
            replace(one, name=f'box_{index}', initial=replace(one.initial, position=place))
        )
    return replace(scene, bodies=(ground, *boxes))


def error(final: Final) -> float:
    """Largest distance [m] of a box from where it belongs; overlap with the ground is such."""
    boxes = final.position[1:]
    side = int(np.ceil(np.sqrt(len(boxes))))
    rows, columns = np.divmod(np.arange(len(boxes)), side)
    exact = np.stack([GAP * columns, GAP * rows, np.full(len(boxes), SIZE / 2.0)], axis=1)
    return float(np.max(np.linalg.norm(boxes - exact, axis=1)))


PROBLEM = Problem(
    name='pile',
    title='Throughput with contact: 1 to 1000 boxes on the ground',
    description='Boxes of 1 kg and 0.2 m fall 0.05 m onto the ground, friction 0.5, and rest; 400 '
    'steps of 5 ms.',
    shows='Finding and solving contacts costs a hundred times a free step.',
    document=scene_document(
        'pile',
        [
            {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.5},
            {
                'name': 'box_0',
                'shape': {'type': 'box', 'size': [SIZE] * 3},
                'mass': 1.0,
                'friction': 0.5,
                'initial': {'position': [0.0, 0.0, SIZE / 2.0 + DROP]},
            },
        ],
        gravity=(0.0, 0.0, -GRAVITY),
        contact={'mode': 'timestep'},
    ),
    duration=2.0,
    error=error,
    error_unit='m',
    reference='they lie where they fell',
    useless=0.05,
    integrators=('dmv6',),
    steps=(STEP,),
    tick=STEP,
    kind=THROUGHPUT,
    bodies=(1, 10, 100, 1_000),
    spread=spread,
)
