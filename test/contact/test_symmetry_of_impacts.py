# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is symmetric stays symmetric: flat impacts turn nothing, and a plane motion stays plane.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Capsule, ConvexHull, Cylinder
from rigid_body_sim.physics.simulation import Simulation

from .touching import box, ground, motion, scene

LYING = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # axis along -y
GAP = 0.05  # [m]


def round_body(name, shape, position, speed, material, q=(0, 0, 0, 1)):
    r, length = shape.radius, shape.length
    across = r * r / 4 + length**2 / 12
    return Body(
        name, shape, 1.0, inertia=np.diag([across, across, r * r / 2]),
        initial=motion(position, q=q, velocity=(0, 0, -speed)), material=Material(**material),
    )  # fmt: skip


@pytest.mark.parametrize('dt', [0.004, 0.001])
@pytest.mark.parametrize(
    ('e', 'mu', 'speed'),
    [(0.0, 0.0, 1.0), (0.0, 0.5, 2.0), (0.5, 0.5, 1.0), (1.0, 0.0, 1.0), (0.3, 0.3, 0.2)],
)
def test_a_flat_impact_turns_no_symmetric_body(e, mu, speed, dt):
    material = {'friction': mu, 'restitution': e}
    down = {'velocity': (0, 0, -speed), 'material': material}
    can, pill = Cylinder(0.1, 0.3), Capsule(0.1, 0.3)
    bodies = [
        ground(material=material),
        box('cube', 0.2, (0, 0, 0.1 + GAP), **down),
        box('tall', (0.1, 0.2, 1.0), (2, 0, 0.5 + GAP), **down),
        round_body('standing', can, (4, 0, 0.15 + GAP), speed, material),
        round_body('lying', can, (6, 0, 0.1 + GAP), speed, material, LYING),
        round_body('capsule', pill, (8, 0, 0.1 + GAP), speed, material, LYING),
        box('table', (1, 1, 0.2), (10, 0, 0.1), fixed=True, material=material),
        box('on table', 0.2, (10, 0, 0.3 + GAP), **down),
        round_body('rolls', can, (10.4, 0, 0.3 + GAP), speed, material, LYING),
        box('struck', 0.2, (12, 0, 2.1), material=material),
        box('strikes', 0.2, (12, 0, 2.3 + GAP), **down),
    ]
    sim = Simulation(scene(bodies, dt=dt))
    worst = 0.0
    for _ in range(round(0.3 / dt)):
        sim.step()
        worst = max(worst, np.abs(sim.state.angular_velocity).max())
    assert worst < 1e-9


def prism(sides, radius, length):
    """
    A prism about y: corners, and inertia of 1 kg.
    """
    angles = 2 * math.pi * np.arange(sides) / sides
    ring = np.column_stack((radius * np.cos(angles), radius * np.sin(angles)))
    corners = [(x, y, z) for x, z in ring for y in (-length / 2, length / 2)]
    about = radius**2 / 6 * (2 + math.cos(2 * math.pi / sides))  # of a regular polygon
    across = about / 2 + length**2 / 12
    return ConvexHull(np.array(corners)), np.diag([across, about, across])


def tumblers(rng, material, count):
    """
    Boxes and prisms, far from each other, above the ground, that move in the plane x, z.
    """
    for i in range(count):
        turn, length = rng.uniform(0, 2 * math.pi), rng.uniform(0.05, 0.6)
        start = motion(
            (4 * i, 4 * (i % 7), 0.5), q=(0, math.sin(turn / 2), 0, math.cos(turn / 2)),
            velocity=(rng.uniform(-3, 3), 0, -1), turn=(0, rng.uniform(-10, 10), 0),
        )  # fmt: skip
        if i % 2:
            size = (rng.uniform(0.1, 0.5), length, rng.uniform(0.1, 0.5))
            yield replace(box(f'b{i}', size, (0, 0, 0), material=material), initial=start)
        else:
            hull, inertia = prism(int(rng.integers(3, 13)), 0.2, length)
            yield Body(
                f'b{i}', hull, 1.0, inertia=inertia, initial=start, material=Material(**material)
            )


@pytest.mark.parametrize(('e', 'mu'), [(0.0, 0.0), (0.0, 0.5), (0.5, 0.1), (1.0, 1.0)])
def test_a_plane_motion_stays_plane_over_edges_and_faces(e, mu):
    material = {'friction': mu, 'restitution': e}
    rng = np.random.default_rng(round(10 * (e + 7 * mu)))
    sim = Simulation(scene([ground(material=material), *tumblers(rng, material, 24)], dt=0.004))
    worst = 0.0
    for _ in range(150):
        sim.step()
        turns, speeds = sim.state.angular_velocity, sim.state.velocity
        worst = max(worst, np.abs(turns[:, (0, 2)]).max(), np.abs(speeds[:, 1]).max())
    # rounding, as often as it is amplified in an impact; solved point by point: 0.1 to 10 rad/s
    assert worst < 1e-9
