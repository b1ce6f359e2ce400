# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Contact: a block on a slope holds below the angle of friction, and slides as tan says above."""

import numpy as np
from lesson import claim, follow

MU, G = 0.5, 9.81  # its angle of friction: 26.565 degrees


def on_slope(degrees):
    """A block on a slope: the plane stays level, gravity leans."""
    lean = np.radians(degrees)
    return {
        'dt': 0.004,
        'gravity': [G * np.sin(lean), 0, -G * np.cos(lean)],
        'contact': {'mode': 'timestep'},
        'bodies': [
            {'name': 'slope', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': MU},
            {
                'name': 'block',
                'shape': {'type': 'box', 'size': [0.2, 0.2, 0.1]},
                'mass': 1.0,
                'friction': MU,
                'initial': {'position': [0, 0, 0.05]},
            },
        ],
    }


runs = {angle: follow(on_slope(angle), 0.8, 0.02) for angle in (26.0, 27.0, 35.0)}
held = runs[26.0].velocity[-1, 1]
claim('at 26° it stands, for tan 26° < µ', held, within=1e-6, unit='m/s')
for angle in (27.0, 35.0):
    lean = np.radians(angle)
    a = G * (np.sin(lean) - MU * np.cos(lean))
    x = runs[angle].position[:, 1, 0]
    claim(
        f'at {angle:g}° it slides a t²/2, a = g (sin α - µ cos α)',
        x - a * runs[angle].time ** 2 / 2,
        within=2e-3,
        unit='m',
    )


def draw(axes):
    """Way over time."""
    for angle, run in runs.items():
        axes.plot(run.time, run.position[:, 1, 0], label=f'{angle:g}°')
    axes.set(xlabel='time [s]', ylabel='way [m]')
