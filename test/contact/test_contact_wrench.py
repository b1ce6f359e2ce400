# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The summed contact wrench of a body: force and torque about its centre of mass, world axes.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Capsule, Cylinder, Sphere
from rigid_body_sim.physics.simulation import Simulation

from .touching import G, ball, box, ground, heap, motion, scene


@pytest.fixture(scope='module')
def settled():
    crowd = [
        ground(),
        box('low', 0.2, (0, 0, 0.1), mass=2.0),
        box('high', 0.2, (0.02, 0, 0.3), mass=1.0),
        box('slides', (0.4, 0.4, 0.1), (5, 0, 0.05), velocity=(3, 0, 0), mass=1.5),
        ball('rolls', 0.1, (0, 5, 0.1), velocity=(1, 0, 0), turn=(0, 10, 0),
             material={'rolling_friction': 0.002}),
    ]  # fmt: skip
    sim = Simulation(scene(crowd))
    sim.step(120)
    return sim


def test_contacts_carry_the_weight_of_what_rests(settled):
    # at rest to 1e-6 m/s a tick: 1e-6 N beside 10 N and 30 N
    force, torque = settled.contact_wrench('high')
    assert force == pytest.approx([0, 0, G], abs=1e-4)
    assert torque == pytest.approx([0, 0, 0], abs=1e-4)
    force, torque = settled.contact_wrench('low')
    assert force == pytest.approx([0, 0, 2 * G], abs=1e-4)
    assert torque == pytest.approx([0, 0, 0], abs=1e-4)


def test_ground_feels_the_weight_of_all(settled):
    force, _ = settled.contact_wrench('ground')
    assert force[2] == pytest.approx(-(2 + 1 + 1.5 + 1) * G, abs=1e-3)


def test_sliding_body_feels_coulomb_friction_and_no_torque(settled):
    force, torque = settled.contact_wrench('slides')
    assert force == pytest.approx([-0.5 * 1.5 * G, 0, 1.5 * G], abs=1e-3)
    assert torque == pytest.approx([0, 0, 0], abs=1e-2)  # friction acts half a box below


def test_rolling_ball_feels_the_torque_of_its_rolling_friction(settled):
    # I alpha = T about the centre, v = R omega: a = -g d R / (0.4 R^2 + R^2)
    deceleration = G * 0.002 * 0.1 / (1.4 * 0.1**2)
    force, torque = settled.contact_wrench('rolls')
    assert force == pytest.approx([-deceleration, 0, G], abs=1e-4)
    assert torque[1] == pytest.approx(-0.4 * 0.1 * deceleration, abs=1e-5)


def test_contact_force_is_the_change_of_momentum_without_the_weight():
    sim = Simulation(scene(heap(4)))
    masses = np.array([body.mass for body in sim.scene.bodies])
    movable = np.array([not body.fixed for body in sim.scene.bodies])
    largest = 0.0
    for _ in range(100):
        before = sim.state.momentum.copy()
        sim.step()
        change = sim.state.momentum - before
        change[:, 2] += masses * G * sim.dt
        force, _ = sim.contact_wrenches()
        largest = max(largest, np.abs(force).max())
        # round-off of impulses of some N s
        assert np.abs(force * sim.dt - change)[movable].max() < 1e-9
    assert largest > 50.0  # they did meet


def thrown_at_each_other(shapes, place, chance):
    """
    Two bodies that meet beside the line of their centres, and spin.
    """
    for side, shape in zip((-1.0, 1.0), shapes):
        middle = np.array([0.3 * side, place, 0.0]) + chance.uniform(-0.04, 0.04, 3) * [0, 1, 1]
        q = chance.normal(size=4)
        start = motion(
            middle,
            q=q / np.linalg.norm(q),
            velocity=(-side * chance.uniform(0.5, 3.0), 0, 0),
            turn=chance.normal(size=3) * 5.0,
        )
        mass = float(chance.uniform(0.3, 3.0))
        yield Body(
            f'{shape.__class__.__name__} {place} {side}',
            shape,
            mass,
            inertia=of_shape(shape, mass=mass).inertia,
            initial=start,
            material=Material(restitution=0.3, friction=0.5),
        )


def test_the_force_of_round_bodies_is_the_change_of_momentum_where_their_normal_turns():
    """
    Read along the axes of the end of the tick, it was up to 8 % beside it.
    """
    chance = np.random.default_rng(3)
    sphere, capsule, drum = Sphere(0.1), Capsule(0.07, 0.2), Cylinder(0.08, 0.2)
    pairs = (sphere, sphere), (capsule, capsule), (drum, drum), (capsule, sphere), (drum, capsule)
    bodies = [
        body
        for number, shapes in enumerate(pairs * 3)
        for body in thrown_at_each_other(shapes, 2.0 * number, chance)
    ]
    sim = Simulation(scene(bodies, gravity=(0.0, 0.0, 0.0), dt=0.004))
    met = set()
    for _ in range(120):
        before = sim.state.momentum.copy()
        sim.step()
        change = sim.state.momentum - before
        force, _ = sim.contact_wrenches()
        assert np.abs(force * sim.dt - change)[: len(bodies)].max() < 1e-12  # round-off of 5 N s
        met |= set(np.flatnonzero(force.any(axis=1)).tolist())
    assert len(met) > 20


def test_without_contact_there_is_no_wrench():
    sim = Simulation(scene([ball('b', 0.1, (0, 0, 5))]))
    sim.step(3)
    assert not np.any(sim.contact_wrenches())
