# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Mutual gravity and the elastic push of two masses."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.exact.collision import impact
from rigid_body_sim.physics.errors import InvalidModel

ROUND_OFF = 1e-13  # [-] sums over some thousand ticks, compensated


def ball(name, mass, position=(0, 0, 0), velocity=(0, 0, 0), **more):
    return {
        'name': name,
        'shape': {'type': 'particle'},
        'mass': mass,
        'initial': {'position': list(position), 'velocity': list(velocity)},
        **more,
    }


def scene(bodies, *forces, dt=0.001):
    return load_scene(
        {'version': 1, 'name': 't', 'dt': dt, 'bodies': bodies, 'forces': list(forces)}
    )


def two_stars(eccentricity, dt):
    """
    Masses 3 and 1, G = 1, semi-major axis 1, from the near point: period 2 pi / sqrt(4) = pi.
    """
    near = 1.0 - eccentricity
    speed = math.sqrt(4.0 * (1.0 + eccentricity) / near)
    return scene(
        [
            ball('a', 3.0, (-0.25 * near, 0, 0), (0, -0.25 * speed, 0)),
            ball('b', 1.0, (0.75 * near, 0, 0), (0, 0.75 * speed, 0)),
        ],
        {'type': 'gravity', 'constant': 1.0},
        dt=dt,
    )


def test_two_bodies_return_after_the_period_of_kepler():
    errors = []
    for ticks in (4000, 8000):
        dt = round(math.pi / ticks, 9)
        sim = Simulation(two_stars(0.5, dt), integrator='rk4')
        start = sim.state.position.copy()
        sim.step(ticks)
        # dt is rounded to nanoseconds: over the period that is up to 4e-6 s of motion at 3.5 m/s
        late = sim.time - math.pi
        there = start + sim.state.velocity * late
        errors.append(np.max(np.abs(sim.state.position - there)))
    assert errors[0] < 1e-10  # truncation of rk4 at 4000 steps
    assert errors[1] < errors[0] / 10  # order four, down to the square of the late time


def test_mutual_gravity_keeps_momentum_angular_momentum_and_energy():
    sim = Simulation(two_stars(0.5, 0.0005))
    energy, spin = sim.energy(), sim.angular_momentum()
    sim.step(20_000)
    assert sim.momentum() == pytest.approx([0, 0, 0], abs=ROUND_OFF)
    assert sim.angular_momentum() == pytest.approx(spin, rel=ROUND_OFF, abs=ROUND_OFF)
    assert sim.energy() == pytest.approx(
        energy, rel=1e-5
    )  # truncation of order two, without drift
    assert energy == pytest.approx(-3.0 / 2.0, rel=ROUND_OFF)  # -G m m' / 2a


def test_attraction_follows_the_line_of_centres_and_the_inverse_square():
    forces = []
    for distance in (2.0, 4.0):
        bodies = [ball('a', 5.0), ball('b', 7.0, (0, 0.6 * distance, 0.8 * distance))]
        sim = Simulation(scene(bodies, {'type': 'gravity', 'constant': 2.0}, dt=1e-6))
        sim.step()
        forces.append(sim.state.momentum[0] / 1e-6)
        assert sim.state.momentum[1] == pytest.approx(-sim.state.momentum[0], rel=1e-15)
    # the distance changes by 1e-11 within the tick
    assert forces[0] == pytest.approx(np.array([0.0, 0.6, 0.8]) * 2.0 * 35.0 / 4.0, rel=1e-9)
    assert forces[1] == pytest.approx(forces[0] / 4.0, rel=1e-9)


def test_softened_gravity_conserves_energy_through_a_head_on_passage():
    bodies = [ball('a', 1.0, (-1, 0, 0)), ball('b', 1.0, (1, 0, 0))]
    sim = Simulation(scene(bodies, {'type': 'gravity', 'constant': 1.0, 'softening': 0.1}))
    energy = sim.energy()
    sim.step(5000)
    assert sim.energy() == pytest.approx(energy, rel=1e-4)  # truncation at 1 ms, passage in 0.1 s


def test_a_fixed_body_attracts_and_stays_and_a_plane_attracts_nothing():
    bodies = [
        ball('sun', 4.0, fixed=True) | {'initial': {'position': [1, 0, 0]}},
        {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': -5}},
        ball('planet', 1e-9, (2, 0, 0), (0, 2, 0)),
    ]
    sim = Simulation(scene(bodies, {'type': 'gravity', 'constant': 1.0}), integrator='rk4')
    sim.step(1000)
    around = sim.state.position[2] - [1, 0, 0]
    assert around == pytest.approx([math.cos(2.0), math.sin(2.0), 0.0], abs=1e-11)  # truncation
    assert sim.state.position[0].tolist() == [1.0, 0.0, 0.0]


def test_every_pair_attracts():
    bodies = [
        ball(name, 1.0, place) for name, place in zip('abc', np.eye(3).tolist(), strict=True)
    ]
    sim = Simulation(scene(bodies, {'type': 'gravity', 'constant': 1.0}, dt=1e-6))
    sim.step()
    toward_middle = (np.full((3, 3), 1 / 3) - np.eye(3)) * 3 / 2**1.5
    # the next order of the Taylor series is 1e-12
    assert sim.state.momentum / 1e-6 == pytest.approx(toward_middle, rel=1e-9, abs=1e-11)


@pytest.mark.parametrize('among', [['a'], ['a', 'a'], ['a', 'c'], 'a', []])
def test_gravity_among_less_than_two_known_bodies_is_refused(among):
    with pytest.raises(UserError, match=r'forces\[0\]'):
        scene([ball('a', 1.0), ball('b', 1.0)], {'type': 'gravity', 'among': among})


@pytest.mark.parametrize(
    'masses', [(1.0, 1.0), pytest.param((1.0, 3.0), marks=pytest.mark.long), (2.0, 500.0)]
)
@pytest.mark.parametrize('name', ['dmv6', 'rk4'])
def test_two_masses_on_a_bumper_part_as_after_an_elastic_impact(name, masses):
    bodies = [
        ball('a', masses[0], (-1.5, 0, 0), (2, 0.3, 0)),
        ball('b', masses[1], (0, 0, 0), (-0.5, 0.3, 0)),
    ]
    bumper = {'type': 'bumper', 'a': 'a', 'b': 'b', 'stiffness': 1e4, 'length': 0.5}
    sim = Simulation(scene(bodies, bumper, dt=2e-5), integrator=name)
    energy, momentum = sim.energy(), sim.momentum()
    sim.step(50_000)
    after = impact(
        mass_a=masses[0],
        mass_b=masses[1],
        velocity_a=(2, 0.3, 0),
        velocity_b=(-0.5, 0.3, 0),
        normal=(1, 0, 0),
        restitution=1.0,
    )
    # truncation: the kink at the touch, (h omega)^2 = 8e-6 at most
    assert sim.state.velocity[0] == pytest.approx(after.velocity_a, abs=2e-5)
    assert sim.state.velocity[1] == pytest.approx(after.velocity_b, abs=2e-5)
    assert sim.momentum() == pytest.approx(momentum, rel=ROUND_OFF, abs=ROUND_OFF)
    assert sim.energy() == pytest.approx(energy, rel=2e-5)
    assert sim.invariants.energy_is_conserved and sim.invariants.momentum_is_conserved


def test_a_bumper_stores_the_kinetic_energy_of_the_approach():
    """
    At rest against each other all of mu v^2 / 2 is in the bumper, and it is shortened by v sqrt(mu
    / k).
    """
    bodies = [ball('a', 1.0, (-0.5, 0, 0), (1, 0, 0)), ball('b', 1.0, (0, 0, 0), (-1, 0, 0))]
    bumper = {'type': 'bumper', 'a': 'a', 'b': 'b', 'stiffness': 200.0, 'length': 0.5}
    quarter = 0.5 * math.pi * math.sqrt(0.5 / 200.0)
    dt = round(quarter / 1000, 9)
    sim = Simulation(scene(bodies, bumper, dt=dt), integrator='rk4')
    sim.step(1000)
    distance = float(sim.state.position[1, 0] - sim.state.position[0, 0])
    assert distance == pytest.approx(0.5 - 2.0 * math.sqrt(0.5 / 200.0), abs=1e-9)  # truncation
    assert sim.invariants.potential_energy(sim.state) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.usefixtures('plain_source')
def test_a_bumper_pushes_off_a_wall_at_the_point_it_sits_on():
    """A box whose corner meets a bumper begins to turn: torque is arm times force."""
    box = {
        'name': 'box',
        'shape': {'type': 'box', 'size': [1, 1, 1]},
        'mass': 6.0,
        'initial': {'position': [0.9, 0, 0]},
    }
    bumper = {
        'type': 'bumper',
        'a': 'world',
        'a_point': [0, 0.5, 0.5],
        'b': 'box',
        'b_point': [-0.5, 0.5, 0.5],
        'stiffness': 10.0,
        'length': 0.5,
    }
    sim = Simulation(scene([box], bumper, dt=1e-6))
    sim.step()
    assert sim.state.momentum[0] / 1e-6 == pytest.approx([1.0, 0.0, 0.0], rel=1e-9)
    assert sim.state.angular_momentum[0] / 1e-6 == pytest.approx([0.0, 0.5, -0.5], rel=1e-9)


def test_bodies_that_attract_each_other_at_one_point_are_refused_with_who_and_where():
    bodies = [ball('a', 1.0), ball('b', 1.0), ball('c', 1.0, (1, 0, 0))]
    with pytest.raises(
        InvalidModel, match=r"'a' and 'b' attract .* both at \(0, 0, 0\) m"
    ) as said:
        Simulation(scene(bodies, {'type': 'gravity', 'constant': 1.0}))
    assert said.value.at == ('forces', 0) and 'softening > 0 m' in str(said.value)
    for more in ({'softening': 1e-3}, {'among': ['a', 'c']}, {'constant': 0.0}):
        Simulation(scene(bodies, {'type': 'gravity', 'constant': 1.0, **more})).step()


def test_bodies_that_come_to_attract_at_one_point_are_named_where_the_energy_has_no_number(
    tmp_path, verb
):
    (tmp_path / 'bodies.yaml').write_text(
        'version: 1\ndt: 0.5\nbodies:\n'
        '  - {name: a, shape: {type: particle}, mass: 1, initial: {velocity: [1, 0, 0]}}\n'
        '  - {name: b, shape: {type: particle}, mass: 1, initial: {position: [1, 0, 0]}}\n'
        'forces: [{type: gravity, constant: 1.0e-300}]\n'
    )
    words = ('-o', tmp_path / 'bag', '--duration', 2)
    code, _, err = verb('simulate', tmp_path / 'bodies.yaml', *words)
    assert code == 0
    assert "'a' and 'b' attract each other and are both at (1, 0, 0) m" in err
    assert 'last commands' not in err


@pytest.mark.parametrize('force', [{'type': 'spring', 'rest_length': 1.0},
                                   {'type': 'bumper', 'length': 1.0}])  # fmt: skip
def test_ends_at_one_point_that_have_no_direction_are_told(force):
    force = {'a': 'a', 'b': 'b', 'stiffness': 10.0, **force}
    at_one = Simulation(scene([ball('a', 1.0), ball('b', 1.0)], force))
    (told,) = at_one.scene_warnings
    assert f'forces[0]: the ends of the {force["type"]}' in told and 'aside' in told
    assert told in at_one.warnings()
    apart = Simulation(scene([ball('a', 1.0), ball('b', 1.0, (0.1, 0, 0))], force))
    assert apart.scene_warnings == ()
    spring = {'type': 'spring', 'a': 'a', 'b': 'b', 'stiffness': 10.0}
    assert Simulation(scene([ball('a', 1.0), ball('b', 1.0)], spring)).scene_warnings == ()
