# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies whose mass changes and that touch: contact feels the mass of the moment.
"""

from dataclasses import replace

import numpy as np
import pytest

from rigid_body_sim.physics.model.scene import MassFlow
from rigid_body_sim.physics.simulation import Simulation

from .. import inside
from .touching import DT, G, H, ball, box, ground, scene

LEAK = MassFlow(-0.2)  # [kg/s] of 1 kg; what leaves goes with the speed of the body


def leaking(body, flow=LEAK):
    return replace(body, mass_flow=flow)


def test_the_ground_carries_what_is_left_of_a_leaking_box_and_of_what_it_carries():
    bodies = [ground(), leaking(box('b', 0.2, (0, 0, 0.1))), box('top', 0.2, (0, 0, 0.3))]
    sim = Simulation(scene(bodies))
    sim.step(480)
    contacts = sim.contacts()
    of_ground = (contacts.bodies == 0).any(axis=1)
    force = np.abs(contacts.impulse[of_ground].sum(axis=0)[2]) / sim.dt
    mass = 1.0 - 0.2 * (sim.time - 0.5 * sim.dt)
    # soft contacts lag behind a weight that falls by 2 N/s by a few ticks
    assert force == pytest.approx((1.0 + mass) * G, rel=1e-3)
    force = np.abs(contacts.impulse[~of_ground].sum(axis=0)[2]) / sim.dt
    assert force == pytest.approx(G, rel=1e-3)
    assert np.abs(sim.state.velocity).max() < 1e-3


def test_what_stands_at_the_start_stands_beside_what_leaks_and_under_it():
    # without the loads of the start stacks sink in by 2e-5 m, at 6e-3 m/s
    others = [box(f'b{i}', 0.2, (0.01 * (i % 3), 0, 0.1 + 0.2 * i)) for i in range(6)]
    slow = MassFlow(-1e-9)
    far = leaking(box('far', 0.2, (9, 0, 0.1)))
    carried = [leaking(box('leaks', 0.2, (5, 0, 0.1)), slow), box('top', 0.2, (5.02, 0, 0.3))]
    sim = Simulation(scene([ground(), *others, *carried, far]))
    for _ in range(40):
        sim.step(5)
        assert np.abs(sim.state.velocity[1:9]).max() < 1e-7


def test_nothing_sleeps_before_its_mass_is_its_last():
    """Of a plank over an edge the load leaks: it must tip, and who stops leaking may sleep."""
    block = box('block', (2.0, 1.0, 0.5), (-1.0, 0.0, 0.25), fixed=True)
    plank = box('plank', (2.0, 0.2, 0.1), (0.3, 0.0, 0.55), mass=4.0)
    load = box('load', 0.1, (-0.6, 0.0, 0.65), mass=3.0)
    for last in (0.1, 2.5):  # [kg]: 4 kg * 0.3 m is held by 2 kg * 0.6 m
        bodies = [ground(), block, plank, leaking(load, MassFlow(-0.4, final_mass=last))]
        sim = Simulation(scene(bodies, sleeping=True))
        sim.step(round(2.4 / DT))
        assert np.abs(sim.state.velocity).max() < 1e-3
        sim.step(round(1.6 / DT))
        tips = sim.state.position[2, 2] < 0.5
        assert tips == (last < 2.0)
        assert tips or not sim.state.velocity.any()  # asleep


@pytest.mark.parametrize('ticks', [1, 600])
def test_a_central_impact_shares_the_momentum_of_the_masses_at_that_time(ticks):
    """
    Elastic: v' = (m1 - m2) v / (m1 + m2),  w' = 2 m1 v / (m1 + m2).
    """
    lively = {'restitution': 1.0, 'friction': 0.0}
    away = 0.2 + 1.0 * ticks / 240.0
    bodies = [
        leaking(ball('a', 0.1, (0, 0, 0), velocity=(1.0, 0, 0), material=lively)),
        leaking(ball('b', 0.1, (away, 0, 0), material=lively), MassFlow(0.1, final_mass=1.2)),
    ]
    sim = Simulation(scene(bodies, gravity=(0.0, 0.0, 0.0)))
    while sim.state.velocity[1, 0] == 0.0:
        sim.step()
    time = sim.time - 0.5 * sim.dt
    a, b = 1.0 - 0.2 * time, min(1.0 + 0.1 * time, 1.2)
    assert sim.state.velocity[0, 0] == pytest.approx((a - b) / (a + b), abs=1e-9)
    assert sim.state.velocity[1, 0] == pytest.approx(2.0 * a / (a + b), abs=1e-9)


def test_a_leaking_box_slides_as_far_as_any():
    """
    Friction goes with the weight: the mass does not matter.
    """
    slider = box('b', 0.2, (0, 0, 0.1), velocity=(2.0, 0, 0))
    sim = Simulation(scene([ground(), leaking(slider)]))
    sim.step(480)
    distance = 2.0**2 / (2 * 0.5 * G)
    # it stops within a substep, at most mu g h^2 too late or too early
    assert sim.state.position[1, 0] == pytest.approx(distance, abs=0.5 * G * H**2)
    assert np.abs(sim.state.velocity[1]).max() < 1e-3


def test_an_off_centre_impact_turns_a_body_by_the_inertia_that_is_left():
    smooth = {'restitution': 1.0, 'friction': 0.0}
    wall = box('wall', 1.0, (0.0, 0.55, 0.0), fixed=True, material=smooth)
    rod = box('rod', (0.4, 0.1, 0.1), (-0.6, -2.0, 0.0), velocity=(0, 2.0, 0), material=smooth)
    full = Simulation(scene([wall, rod], gravity=(0.0, 0.0, 0.0)))
    leak = Simulation(scene([wall, leaking(rod)], gravity=(0.0, 0.0, 0.0)))
    for sim in (full, leak):
        sim.step(300)
        assert abs(sim.state.angular_velocity[1, 2]) > 1.0
    for name in ('position', 'velocity', 'angular_velocity'):
        a, b = getattr(full.state, name)[1], getattr(leak.state, name)[1]
        # several points strike at once: the solver leaves them when a visit changes 1e-4 m/s
        assert np.abs(a - b).max() < 1e-6


def test_a_scene_in_which_no_mass_changes_keeps_nothing_for_it():
    sim = Simulation(scene([ground(), box('b', 0.2, (0, 0, 0.1))]))
    assert not inside.flows(sim).size


def test_a_restored_run_of_leaking_bodies_goes_on_to_the_bit():
    bodies = [ground(), leaking(box('b', 0.2, (0, 0, 0.3), turn=(1, 2, 3)))]
    sim = Simulation(scene(bodies))
    sim.step(100)
    middle = sim.state_bytes()
    sim.step(100)
    other = Simulation(scene(bodies))
    other.restore(tick=100, state=middle, slots={})
    other.step(100)
    assert other.state_bytes() == sim.state_bytes()
