# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at their instants of bodies whose mass changes, by the masses of the instant, and of bodies
on a pivot, by their inertia about it.
"""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene

BALL = {'type': 'sphere', 'radius': 0.1}
ROD = {'type': 'box', 'size': [0.1, 0.1, 1.0]}
FAR = [
    {'name': 'far_wall', 'shape': ROD, 'fixed': True, 'initial': {'position': [0, 0, -80]}},
    {'name': 'far_ball', 'shape': BALL, 'mass': 1.0, 'initial': {'position': [0, 0, -70]}},
    {'name': 'far_tank', 'shape': ROD, 'mass': 1.0, 'mass_rate': -1e-3,
     'initial': {'position': [0, 0, -60]}},
    {'name': 'far_arm', 'shape': ROD, 'mass': 1.0, 'pivot': {'point': [0, 0, 0.5]},
     'initial': {'position': [0, 0, -50]}},
]  # fmt: skip
# so all scenes of this file share one kernel


def simulation(*bodies, dt=0.004):
    contact = {'mode': 'event'}
    scene = {'dt': dt, 'gravity': [0, 0, 0], 'bodies': [*bodies, *FAR], 'contact': contact}
    return Simulation(load_scene(scene))


def body(name, shape, at, velocity=(0, 0, 0), *, e=1.0, mu=0.0, mass=1.0, **more):
    keys = ('orientation', 'angular_velocity')
    initial = {key: more.pop(key) for key in keys if key in more}
    initial |= {'position': list(at), 'velocity': list(velocity)}
    if 'pivot' in more:
        del initial['velocity'], initial['position']
    return {
        'name': name, 'shape': shape, 'mass': mass, 'restitution': e, 'friction': mu,
        'initial': initial, **more,
    }  # fmt: skip


def test_a_central_impact_shares_the_momentum_of_the_masses_at_its_instant():
    """
    Elastic: v' = (m1 - m2) v / (m1 + m2),  w' = 2 m1 v / (m1 + m2).
    """
    way = 0.6007  # [m] at 1 m/s, inside a tick
    sim = simulation(
        body('a', BALL, (0, 0, 0), (1, 0, 0), mass_rate=-0.2),
        body('b', BALL, (0.2 + way, 0, 0), mass_rate=0.1),
    )
    while not len(sim.impacts()):
        sim.step()
    a, b = 1.0 - 0.2 * way, 1.0 + 0.1 * way
    assert sim.impacts().impulse[0] == pytest.approx([2 * a * b / (a + b), 0, 0], abs=1e-12)
    assert sim.state.velocity[0, 0] == pytest.approx((a - b) / (a + b), abs=1e-12)
    assert sim.state.velocity[1, 0] == pytest.approx(2 * a / (a + b), abs=1e-12)


def drawn(rng):
    """Five boxes and balls that fly at each other; three of them gain or lose mass."""
    mu, bodies = float(rng.choice([0.0, 0.5])), []
    for number in range(5):
        way, turn = rng.normal(size=3), rng.normal(size=4)
        way /= np.linalg.norm(way)
        shape = {'type': 'sphere', 'radius': float(rng.uniform(0.1, 0.2))}
        if number % 2:
            shape = {'type': 'box', 'size': rng.uniform(0.1, 0.4, 3).tolist()}
        more = {'mass_rate': float(rng.uniform(-0.4, 0.4))} if number < 3 else {}
        bodies.append(body(
            f'body_{number}', shape, (way * rng.uniform(0.8, 2.0)).tolist(),
            (-way * rng.uniform(1.0, 4.0)).tolist(), mu=mu, mass=float(rng.uniform(0.5, 2.0)),
            orientation=(turn / np.linalg.norm(turn)).tolist(),
            angular_velocity=rng.normal(size=3).tolist(), **more,
        ))  # fmt: skip
    return bodies, mu


def test_impacts_keep_momenta_and_energy_of_the_masses_at_their_instants():
    seen = 0
    for seed in range(6):
        bodies, mu = drawn(np.random.default_rng(seed))
        sim = simulation(*bodies)
        masses = np.array([one['mass'] for one in bodies])
        rates = np.array([one.get('mass_rate', 0.0) for one in bodies])

        def now(masses=masses, rates=rates, sim=sim):
            """Position, velocity, angular velocity, and angular momentum per mass."""
            state = sim.state
            of_mass = state.angular_momentum[:5] / (masses + rates * sim.time)[:, None]
            return state.position[:5], state.velocity[:5], state.angular_velocity[:5], of_mass

        for _ in range(250):
            begin, (x, v, w, spin) = sim.time, (array.copy() for array in now())
            sim.step()
            times = sim.impacts().time
            if not len(times) or np.ptp(times) > 0.0 or len(sim.contacts().impulse) > len(times):
                continue
            seen += 1
            _, v_after, w_after, spin_after = now()
            m = (masses + rates * times[0])[:, None]
            place = x + v * (times[0] - begin)
            turned = m * (spin_after - spin + np.cross(place, v_after - v))
            assert np.sum(m * (v_after - v), axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
            assert np.sum(turned, axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
            gained = np.sum(m * (v_after**2 - v**2 + spin_after * w_after - spin * w))
            assert gained < 1e-11
            if mu == 0.0:
                assert gained == pytest.approx(0.0, abs=1e-11)
    assert seen > 15


@pytest.mark.parametrize('restitution', [1.0, 0.5])
def test_a_pendulum_strikes_by_its_inertia_about_the_pivot(restitution):
    """A ball that flies by, and a wall on the other side; friction has no lever at the first."""
    inertia = 2.0 * (1.0 + 0.4 * 0.1**2)
    arm = {'point': [0, 0, 1], 'at': [0, 0, 1]}
    angle = 0.3
    turn = [0.0, math.sin(0.5 * angle), 0.0, math.cos(0.5 * angle)]
    sim = simulation(
        body('bob', BALL, (), e=restitution, mass=2.0, pivot=arm, orientation=turn,
             angular_velocity=[0, -3, 0]),
        body('ball', BALL, (0.2, 0, 0), e=restitution),
        {'name': 'wall', 'shape': {'type': 'box', 'size': [1, 4, 4]}, 'fixed': True,
         'restitution': restitution, 'friction': 0.0, 'initial': {'position': [2.0, 0, 0]}},
    )  # fmt: skip
    while not len(sim.impacts()):
        sim.step()
    # at the lowest place: the line of centres is square to the arm
    assert sim.impacts().time == pytest.approx([0.1], abs=1e-12)
    rate = 3.0 * (inertia - restitution) / (inertia + 1.0)
    speed = 3.0 * (1.0 + restitution) * inertia / (inertia + 1.0)
    assert sim.state.angular_velocity[0] == pytest.approx([0, -rate, 0], abs=1e-12)
    assert sim.state.velocity[1] == pytest.approx([speed, 0, 0], abs=1e-12)
    force, torque = sim.contact_wrench('bob')
    about_pivot = torque + np.cross(sim.state.position[0] - [0, 0, 1], force)
    assert about_pivot[1] * sim.dt == pytest.approx(inertia * (3.0 - rate), rel=1e-12)
