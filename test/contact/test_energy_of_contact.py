# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Energy of bodies that hit and rub: it never rises, whatever restitution and friction.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.simulation import Simulation

from .touching import box, ground, scene

SHAPES = [(0.2, 0.2, 0.2), (0.2, 0.3, 0.5), (0.5, 0.5, 0.2), (0.2, 0.2, 0.5)]


def rises(sim, ticks):
    """
    Largest gain of energy in one tick [J].
    """
    energy = [sim.energy()]
    for _ in range(ticks):
        sim.step()
        energy.append(sim.energy())
    return np.diff(energy).max()


def thrown(shape, seed, *, restitution, friction, dt=1 / 240):
    """
    A box of 1 kg that falls onto the ground, tumbling.
    """
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    material = {'restitution': restitution, 'friction': friction}
    body = box(
        'b', shape, (0, 0, 0.6), q=q / np.linalg.norm(q), velocity=rng.normal(size=3),
        turn=8 * rng.normal(size=3), material=material,
    )  # fmt: skip
    return scene([ground(material=material), body], dt=dt)


@pytest.mark.parametrize('friction', [0.3, 0.8])
def test_a_lively_box_with_friction_is_not_thrown_up_by_its_own_friction(friction):
    """
    Newton's law with friction creates energy at an eccentric impact (Kane and Levinson): here up
    to 2 J of 9 J in one bounce. A bounce must give back less than the impact took.
    """
    for shape in SHAPES:
        for seed in range(4):
            sim = Simulation(thrown(shape, seed, restitution=0.95, friction=friction))
            # energies of some ten joules, to rounding
            assert rises(sim, 480) < 1e-12
