# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An island of many bodies has fewer passes beyond the usual ones than one of few, by the root of
their number, and what its crash leaves gains no energy and sinks in no deeper than its law.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.simulation import Simulation

from ..inside import most_passes
from .touching import G, box, ground, scene

EDGE = 0.2  # [m]


def block(wide, high, speed):
    """
    Cubes that touch in a block, and come down on the ground.
    """
    places = [(x, y, z) for z in range(high) for y in range(wide) for x in range(wide)]
    bodies = [
        box(f'b{i}', EDGE, (EDGE * x, EDGE * y, EDGE * (z + 0.5)), velocity=(0, 0, -speed))
        for i, (x, y, z) in enumerate(places)
    ]
    return Simulation(scene([ground(), *bodies], dt=0.004))


@pytest.mark.parametrize(
    ('wide', 'high'), [(3, 10), *(pytest.param(n, 10, marks=pytest.mark.long) for n in (2, 4, 6))]
)
def test_passes_grow_fewer_by_the_root_of_the_bodies_of_an_island(wide, high):
    count = wide * wide * high
    sim = block(wide, high, 3.0)
    for _ in range(20):
        sim.step()
        islands = most_passes(sim)
        if count in islands[:, 0]:
            break
    most = dict(islands.tolist())[float(count)]
    assert most == pytest.approx(150 * math.sqrt(min(40 / count, 1.0)))


def energy(sim):
    """
    Kinetic energy, and potential above the ground [J].
    """
    s = sim.state
    spin = EDGE**2 / 6 * np.sum(s.angular_velocity**2)
    height = s.position[1:-3, 2].sum()  # the last three are bystanders
    return 0.5 * (np.sum(s.velocity**2) + spin) + G * height


@pytest.mark.parametrize('wide', [3, *(pytest.param(n, marks=pytest.mark.long) for n in (4, 6))])
def test_a_large_island_that_crashes_gains_no_energy_and_does_not_sink_in(wide):
    """
    90 cubes, in the long form 160 and 360, at 3 m/s: to 1e-5 of the largest energy, the law of
    energy, and to a twentieth of an edge, half of what is a warning.
    """
    sim = block(wide, 10, 3.0)
    before = largest = energy(sim)
    for _ in range(100):
        sim.step()
        now = energy(sim)
        assert now - before < 1e-5 * largest
        before = now
        gaps = sim.contacts().gap
        assert gaps.size == 0 or gaps.min() > -0.05 * EDGE
    assert not sim.overlap_warnings
