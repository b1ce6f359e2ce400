# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Energy of bodies that hit and rub: it never rises, whatever restitution and friction.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.simulation import Simulation

from .touching import G, ball, box, ground, scene

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


@pytest.mark.parametrize('friction', [0.0, 0.3, 0.8])
@pytest.mark.parametrize('restitution', [0.0, 0.2, 0.5, 0.8])
def test_energy_of_a_tumbling_box_never_rises_at_any_tick(restitution, friction):
    """
    Energies are of some ten joules; 5e-11 J is what is left alone of a gain: 1e-6 of what a fall
    from rest for a substep gives.
    """
    for shape in SHAPES:
        for seed in range(3):
            sim = Simulation(thrown(shape, seed, restitution=restitution, friction=friction))
            assert rises(sim, 480) < 1e-10


def test_what_is_taken_back_of_a_gain_keeps_momenta_that_contact_cannot_change():
    """
    On a plane without friction a tumbling box keeps momentum along it and angular momentum about
    its normal; energy is taken in most ticks.
    """
    for seed in range(4):
        sim = Simulation(thrown(SHAPES[1], seed, restitution=0.0, friction=0.0))
        momentum, angular = sim.momentum()[:2], sim.state.angular_momentum[1, 2]
        sim.step(480)
        assert np.abs(sim.momentum()[:2] - momentum).max() < 1e-13
        assert abs(sim.state.angular_momentum[1, 2] - angular) < 1e-13


@pytest.mark.parametrize('count', [1, 3])
def test_impulses_of_contacts_are_the_whole_change_of_momentum_though_energy_was_taken(count):
    """
    m (v' - v - g dt) = sum of the impulses that are read, for bodies that tumble onto each other.
    """
    rng = np.random.default_rng(3)
    bodies = [
        box(f'b{i}', (0.2, 0.3, 0.25), (0.1 * i, 0, 0.3 + 0.35 * i), velocity=(0.3 * i, 0, 0),
            turn=4 * rng.normal(size=3))
        for i in range(count)
    ]  # fmt: skip
    sim = Simulation(scene([ground(), *bodies]))
    for _ in range(360):
        before = sim.momentum()
        sim.step()
        found = sim.contacts()
        upon = (found.bodies[:, 1] != 0) * 1.0 - (found.bodies[:, 0] != 0)
        given = (upon[:, None] * found.impulse).sum(axis=0)
        change = sim.momentum() - before + (0, 0, count * G * sim.dt)
        assert given == pytest.approx(change, abs=1e-12)


@pytest.mark.parametrize('restitution', [0.0, 0.5, 0.9])
def test_energy_of_boxes_that_hit_each_other_in_free_space_never_rises(restitution):
    rng = np.random.default_rng(7)
    material = {'restitution': restitution, 'friction': 0.5}
    bodies = [
        box(f'b{i}', (0.2, 0.3, 0.25), (0.5 * (i % 3), 0.5 * (i // 3), 0.1 * i),
            velocity=rng.normal(size=3), turn=5 * rng.normal(size=3), material=material)
        for i in range(6)
    ]  # fmt: skip
    sim = Simulation(scene(bodies, gravity=(0, 0, 0)))
    start = sim.energy()
    # rounding of an energy of some ten joules
    assert rises(sim, 480) < 1e-11
    assert sim.energy() < 0.999 * start


@pytest.mark.parametrize('restitution', [0.0, 0.5, 1.0])
@pytest.mark.parametrize('friction', [0.0, 0.6])
@pytest.mark.parametrize('kinds', ['ball ball', 'box box', 'ball box'])
def test_momentum_and_angular_momentum_of_two_that_collide_stay_to_the_last_digits(
    kinds, friction, restitution
):
    rng = np.random.default_rng(1)
    material = {'restitution': restitution, 'friction': friction}

    def body(kind, name, place, velocity):
        motion = {'velocity': velocity, 'turn': 3 * rng.normal(size=3), 'material': material}
        if kind == 'ball':
            return ball(name, 0.1, place, **motion)
        return box(name, (0.2, 0.3, 0.15), place, **motion)

    first, second = kinds.split()
    pair = [
        body(first, 'a', (-0.6, 0.03, 0.02), (3, 0.1, 0)),
        body(second, 'b', (0, 0, 0), (-1, 0, 0.2)),
    ]
    sim = Simulation(scene(pair, gravity=(0, 0, 0)))
    linear, angular = sim.momentum(), sim.angular_momentum()
    spin = sim.state.angular_velocity[:2].copy()
    sim.step(100)
    assert sim.state.velocity[0, 0] < 2.5  # they met
    # both arms end in one point, in every substep
    assert np.abs(sim.momentum() - linear).max() < 1e-13 * 4
    assert np.abs(sim.angular_momentum() - angular).max() < 1e-13
    if friction == 0.0 and kinds == 'ball ball':
        # impulses act along the line of centres: no torque
        assert np.abs(sim.state.angular_velocity[:2] - spin).max() < 1e-12
