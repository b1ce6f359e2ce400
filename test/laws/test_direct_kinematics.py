# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Velocities and accelerations of points of bodies."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.diagnostics.point_motion import motion_of
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.scene.grammar import INITIAL

TURN = 2 * math.pi
ROUND_OFF = 1e-13  # [-] some ten products


def scene(*bodies, forces=(), gravity=(0, 0, 0), dt=0.001):
    return load_scene(
        {
            'version': 1,
            'dt': dt,
            'gravity': list(gravity),
            'bodies': list(bodies),
            'forces': list(forces),
        }
    )


BOX = {
    'name': 'box',
    'shape': {'type': 'box', 'size': [0.3, 0.2, 0.4]},
    'mass': 2.0,
    'inertia': {'ixx': 0.2, 'iyy': 0.3, 'izz': 0.25, 'ixy': 0.02, 'iyz': -0.01},
    'center_of_mass': [0.01, 0.02, -0.03],
    'initial': {
        'position': [1, 2, 3],
        'velocity': [0.1, -0.2, 0.3],
        'angular_velocity': [1, 2, 3],
    },
}
SPRING = {
    'type': 'spring',
    'a': 'box',
    'a_point': [0.1, 0, 0],
    'b': 'world',
    'stiffness': 7,
    'damping': 0.5,
}


def test_a_wheel_that_rolls_rests_at_its_foot():
    wheel = {
        'name': 'wheel',
        'shape': {'type': 'cylinder', 'radius': 0.5, 'length': 0.1},
        'mass': 1.0,
        'initial': {'velocity': [2, 0, 0], 'angular_velocity': [0, 0, -4]},
    }
    sim = Simulation(scene(wheel))
    points = motion_of(sim, 'wheel', [[0, -0.5, 0], [0, 0.5, 0], [0, 0, 0]])
    assert points.velocity == pytest.approx(
        np.array([[0, 0, 0], [4, 0, 0], [2, 0, 0]]), abs=ROUND_OFF
    )
    assert points.acceleration == pytest.approx(
        np.array([[0, 8, 0], [0, -8, 0], [0, 0, 0]]), abs=ROUND_OFF
    )


@pytest.mark.parametrize('name', ['dmv6', 'rk4'])
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(name):
    """
    Central differences over two ticks of a tumbling box on a damped spring, under gravity and a
    command.
    """
    h = 1e-4
    sim = Simulation(scene(BOX, forces=[SPRING], gravity=(0, 0, -9.81), dt=h), integrator=name)
    sim.set_wrench('box', force=(1, 2, 3), torque=(0.1, 0.2, -0.3), frame='body')
    point = (0.12, -0.05, 0.2)
    sim.step(50)
    seen = []
    for _ in range(3):
        seen.append(motion_of(sim, 'box', point))
        sim.step()
    before, now, after = seen
    # truncation h^2 x''' / 6 with x''' near 1e2 m/s^3, and round-off of positions over h^2
    assert (after.position - before.position) / (2 * h) == pytest.approx(now.velocity, abs=1e-6)
    second = (after.velocity - before.velocity) / (2 * h)
    assert second == pytest.approx(now.acceleration, abs=1e-4)


def test_asking_changes_nothing():
    a, b = (Simulation(scene(BOX, forces=[SPRING])) for _ in range(2))
    for _ in range(20):
        a.accelerations()
        a.step()
        b.step()
    assert a.state_bytes() == b.state_bytes()


def test_a_body_on_which_nothing_acts_falls():
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 3.0}
    post = {'name': 'post', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'fixed': True}
    linear, angular = Simulation(
        scene(ball, BOX | {'initial': {}}, post, gravity=(0, 0, -9.81))
    ).accelerations()
    assert linear == pytest.approx(
        np.array([[0, 0, -9.81], [0, 0, -9.81], [0, 0, 0]]), rel=ROUND_OFF
    )
    assert not np.any(angular)


@pytest.mark.usefixtures('plain_source')
def test_the_acceleration_of_a_rocket_jumps_at_its_burn_out():
    rocket = {
        'name': 'rocket',
        'shape': {'type': 'particle'},
        'mass': 10.0,
        'mass_rate': -1.0,
        'exhaust_velocity': 100.0,
        'final_mass': 9.0,
    }
    sim = Simulation(scene(rocket, dt=0.01))
    found = []
    for ticks in (0, 50, 50):
        sim.step(ticks)
        found.append(sim.accelerations()[0][0, 2])
    assert found == pytest.approx([100 / 10, 100 / 9.5, 0.0], rel=1e-12)


def told(initial=None, **motion):
    """A box that is moved as told."""
    return {
        'name': 'deck',
        'shape': {'type': 'box', 'size': [1, 1, 1]},
        'motion': motion,
        'initial': initial or {},
    }


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('way', ['surge', 'sway', 'heave', 'roll', 'pitch', 'yaw'])
def test_at_the_crest_of_a_wave_the_acceleration_is_its_amplitude_times_the_rate_squared(way):
    size, period = 0.5, 1.0
    sim = Simulation(scene(told(**{way: {'amplitude': size, 'period': period}}), dt=0.01))
    sim.step(25)
    place = ['surge', 'sway', 'heave', 'roll', 'pitch', 'yaw'].index(way)
    expected = np.zeros((2, 3))
    expected[place // 3, place % 3] = -size * (TURN / period) ** 2
    found = np.array(sim.accelerations())[:, 0]
    assert found == pytest.approx(expected, abs=1e-12 * abs(expected).max())
    at_centre = sim.motion_of('deck', (0, 0, 0)).acceleration
    assert at_centre == pytest.approx(found[0], abs=1e-12)


def test_acceleration_of_what_moves_as_told_is_the_derivative_of_its_velocity_at_every_point():
    """All six ways at once, a table, spin, and a followed point off the centre."""
    wave = {'amplitude': 0.3, 'period': 0.7, 'phase': 0.4}
    table = [[0, 0, 0, 0, 0, 0, 0], [0.2, 0.1, -0.2, 0.3, 0.2, -0.1, 0.4], [0.5] + [0] * 6]
    ways = dict.fromkeys(('surge', 'heave', 'roll', 'pitch', 'yaw'), wave)
    start = {'velocity': [0.1, 0.2, 0.3], 'angular_velocity': [1, -2, 0.5]}
    deck = told(start, **ways, table=table, point=[0.3, -0.2, 0.1])
    h = 1e-5
    sim = Simulation(scene(deck, dt=h))
    points = [[0, 0, 0], [0.3, -0.2, 0.1], [0.4, 0.5, -0.5]]
    sim.step(30_000)
    seen = []
    for _ in range(3):
        motion = sim.motion_of('deck', points)
        seen.append((motion, sim.state.angular_velocity[0], sim.accelerations()[1][0]))
        sim.step()
    (before, spin_before, _), (now, _, alpha), (after, spin_after, _) = seen
    # truncation h^2 x/6 with x near 1e4 m/s^4, and round-off of velocities over h
    second = (after.velocity - before.velocity) / (2 * h)
    assert now.acceleration == pytest.approx(second, abs=1e-6)
    assert alpha == pytest.approx((spin_after - spin_before) / (2 * h), abs=1e-6)
    assert np.linalg.norm(now.acceleration, axis=1).min() > 1.0


def test_acceleration_by_a_table_jumps_at_its_ends_and_is_none_beyond():
    """One span from rest to rest is 3 u^2 - 2 u^3: its acceleration begins with 6 D/T^2."""
    span, way = 0.3, 0.2
    sim = Simulation(scene(told(table=[[0.1, 0, 0, 0], [0.1 + span, way, 0, 0]]), dt=0.001))
    found = []
    for ticks in (0, 100, 150, 149, 1, 1):
        sim.step(ticks)
        found.append(sim.accelerations()[0][0, 0])
    most = 6 * way / span**2
    assert found == pytest.approx([0, most, 0, -most * 149 / 150, 0, 0], abs=1e-11 * most)


def test_the_initial_velocity_of_what_is_told_is_that_of_the_point_that_follows_the_path():
    """`position` is that of the centre, which circles about the point; so the reference says."""
    start = {'position': [1, 2, 3], 'velocity': [0.1, 0.2, 0], 'angular_velocity': [0, 0, 2]}
    point = [0.5, 0, 0]
    sim = Simulation(scene(told(start, point=point), dt=0.01))
    assert sim.state.position[0] == pytest.approx([1, 2, 3], abs=ROUND_OFF)
    assert sim.state.velocity[0] == pytest.approx([0.1, 0.2 - 1.0, 0], abs=ROUND_OFF)
    for _ in range(2):
        assert sim.motion_of('deck', point).velocity == pytest.approx([0.1, 0.2, 0], abs=1e-12)
        sim.step(100)
    assert 'of the point that follows the path' in INITIAL.keys['velocity'].meaning


def test_the_acceleration_of_what_is_told_goes_by_the_time_since_the_reset():
    sim = Simulation(scene(told(heave={'amplitude': 0.5, 'period': 1.0}), dt=0.01))
    sim.step(37)
    sim.reset()
    sim.step(25)
    assert sim.accelerations()[0][0, 2] == pytest.approx(-0.5 * TURN**2, rel=1e-12)


@pytest.mark.parametrize(
    'point', [(math.nan, 0, 0), (1, 2), 'abc', ('a', 0, 0), 3.0, None, [[0, 0, 0], [1, 2]], 1j]
)
def test_a_point_or_an_axis_that_is_none_is_refused_with_what_is_allowed(point):
    sim = Simulation(scene(BOX))
    with pytest.raises(InvalidModel, match=r"motion_of 'box': point .*; allowed: three finite"):
        sim.motion_of('box', point)
    for key in ('direction', 'point'):
        if point is not None:
            axis = {'direction': (0, 0, 1), key: point}
            with pytest.raises(InvalidModel, match=rf"'box': {key} .*; allowed: three finite"):
                sim.moment_of_inertia('box', **axis)
    assert sim.motion_of('box', np.zeros((2, 4, 3))).velocity.shape == (2, 4, 3)
    assert sim.motion_of('box', np.zeros((0, 3), dtype=int)).position.shape == (0, 3)


def test_an_unknown_body_is_refused():
    with pytest.raises(InvalidModel, match="no body is named 'crate'"):
        motion_of(Simulation(scene(BOX)), 'crate', (0, 0, 0))
