# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
When something hits: to the tick, so to first order.
"""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation

from .touching import G, ball, ground, scene

ELASTIC = {'restitution': 1.0}


def lateness(tick, height):
    """
    How late an elastic ball leaves the ground onto which it falls from a height [m], in ticks: its
    flight is traced back to the ground.
    """
    bodies = [ground(material=ELASTIC), ball('ball', 0.1, (0, 0, 0.1 + height), material=ELASTIC)]
    sim = Simulation(scene(bodies, dt=tick))
    hit = math.sqrt(2.0 * height / G)
    sim.step(int(hit / tick) - 2)
    while sim.state.velocity[1, 2] < 0.0:
        sim.step()
    up, above = sim.state.velocity[1, 2], sim.state.position[1, 2] - 0.1
    start = math.sqrt(up * up + 2.0 * G * above)
    assert start == pytest.approx(G * hit, rel=1e-3)  # the bounce keeps its energy
    return (sim.time - (start - up) / G - hit) / tick


@pytest.mark.parametrize('tick', [0.008, 0.004, 0.002, 0.001, 0.0005])
def test_an_impact_comes_late_by_part_of_a_tick_so_its_instant_is_right_to_first_order(tick):
    late = [lateness(tick, height) for height in np.linspace(1.0, 1.3, 6)]
    # a ball lies on the ground to the end of the tick in which it hits
    assert min(late) > -1e-3
    assert max(late) < 1.0 + 1e-3
