# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where the bodies of a group lie while it passes its substeps changes no bit.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.contact import packed_bodies
from rigid_body_sim.physics.simulation import Simulation

from .touching import ball, box, ground, scene


def walls(lengths):
    """
    Walls of two rows of cubes that fall by a millimetre, and a ball in flight behind each cube.
    """
    bodies = [ground()]
    for wall, length in enumerate(lengths):
        for i in range(2 * length):
            row, place = divmod(i, length)
            at = (0.205 * place + 0.1025 * row, 5.0 * wall, 0.101 + 0.201 * row)
            bodies.append(box(f'cube_{wall}_{i}', 0.2, at))
            bodies.append(ball(f'ball_{wall}_{i}', 0.05, (at[0], at[1] + 2.0, 3.0 + 0.2 * i)))
    return bodies


@pytest.mark.parametrize('lengths', [(40,), (10, 25, 5)], ids=['one_island', 'three_islands'])
def test_groups_have_the_same_bits_packed_or_where_they_are(monkeypatch, lengths):
    found = []
    # the room is for whole blocks of 64: then 80 cubes stay where they are, among balls
    for capacity in (512, 1):
        monkeypatch.setattr(packed_bodies, 'CAPACITY', capacity)
        sim = Simulation(scene(walls(lengths)))
        for _ in range(6):
            sim.step(10)
            found.append(sim.state_bytes())
    assert found[:6] == found[6:]
    lowest = sim.state.position[1:, 2][: 2 * sum(lengths)].min()
    assert lowest == pytest.approx(0.1, abs=1e-3)  # they have come down
    assert np.abs(sim.state.velocity).max() > 1.0  # and balls fly
