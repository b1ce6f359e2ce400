# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts of a pair that carries load at other points, with `contact: {mode: event}`: the block that
rocks from edge to edge.

G. W. Housner, Bull. Seismol. Soc. Am. 53 (1963) 403: at each blow (e = 0) the block goes on about
the new edge with the angular momentum that it has about it,

    w' / w = 1 - 3/2 sin(a)^2,     tan(a) = width / height

and between two blows energy is kept, so each blow comes at that share of the speed of the last.
All scenes have the same kinds of bodies, so that they share one kernel.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.state.impacts import KINDS

GRAVITY = 9.81  # [m/s^2]
DT = 0.004  # [s]
DEPTH = 0.5  # [m]
FLAT = {
    'type': 'heightfield', 'spacing': 0.4, 'origin': [-2.0, -2.0, 0.0], 'heights': [[0] * 11] * 11,
}  # fmt: skip


def rocking(half_width, half_height, tilt, *, ground=False):
    """
    A block that stands at rest on one edge, on a plane or on ground of triangles.
    """
    cosine, sine = math.cos(tilt), math.sin(tilt)
    edge = [cosine * half_width - sine * half_height, -sine * half_width - cosine * half_height]
    below = -1e5
    plane = {'type': 'plane', 'normal': [0, 0, 1], 'offset': below if ground else 0}
    return Simulation(
        load_scene({
            'version': 1, 'name': 'rocking', 'dt': DT, 'gravity': [0, 0, -GRAVITY],
            'contact': {'mode': 'event'},
            'bodies': [
                {'name': 'plane', 'friction': 2.0, 'shape': plane},
                {'name': 'ground', 'fixed': True, 'friction': 2.0, 'shape': FLAT,
                 'initial': {'position': [0, 0, 0 if ground else 2 * below]}},
                {'name': 'block', 'mass': 2.0, 'friction': 2.0,
                 'shape': {'type': 'box', 'size': [2 * half_width, DEPTH, 2 * half_height]},
                 'initial': {'position': [-edge[0], 0, -edge[1]],
                             'orientation': [0, math.sin(tilt / 2), 0, math.cos(tilt / 2)]}},
            ],
        })
    )  # fmt: skip


def blows(sim, ticks):
    """
    Instants, kinds and approaches of the blows that are faster than what the solver leaves.
    """
    found = []
    for _ in range(ticks):
        sim.step()
        impacts = sim.impacts()
        strikes = impacts.approach > GRAVITY * DT
        found += zip(
            impacts.time[strikes], impacts.kind[strikes], impacts.approach[strikes], strict=True
        )
    return found


@pytest.mark.parametrize('ground', [False, True])
@pytest.mark.parametrize(('half_width', 'half_height'), [(0.1, 0.4), (0.15, 0.3)])
def test_a_rocking_block_goes_on_with_the_angular_momentum_about_its_new_edge(
    half_width, half_height, ground
):
    angle = math.atan(half_width / half_height)
    found = blows(rocking(half_width, half_height, 0.3 * angle, ground=ground), 240)
    assert len(found) >= 2
    assert all(KINDS[kind] == 'joint' for _, kind, _ in found)
    speeds = np.array([approach for _, _, approach in found])
    law = 1 - 1.5 * math.sin(angle) ** 2
    # sinks of 1e-6 m, and pivots that are as soft as that, over a fall of some millimetres
    np.testing.assert_allclose(speeds[1:3] / speeds[: len(speeds[1:3])], law, rtol=2e-3)


def test_the_first_blow_of_a_rocking_block_comes_at_its_instant():
    """
    From rest at a tilt: I w^2 / 2 = m g r (cos(a - tilt) - cos(a - x)) at the tilt x, integrated;
    I = 4/3 m r^2 about the edge. The pivot is as soft as its sink of 1e-6 m.
    """
    half_width, half_height, tilt = 0.1, 0.4, 0.05
    angle, size = math.atan(0.25), math.hypot(half_width, half_height)
    rate = 3 * GRAVITY / (4 * size)  # m g r / I about the edge
    # x = tilt (1 - s^2) makes the integrand smooth in s
    points, weights = np.polynomial.legendre.leggauss(40)
    share = 0.5 * (points + 1)
    at = tilt * (1 - share**2)
    speed = np.sqrt(2 * rate * (np.cos(angle - tilt) - np.cos(angle - at)))
    law = float(np.sum(0.5 * weights * 2 * tilt * share / speed))
    found = blows(rocking(half_width, half_height, tilt), 80)
    assert found[0][0] == pytest.approx(law, rel=2e-4)
