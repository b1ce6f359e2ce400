# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pivoted body in a run: recorded, replayed, turned around by `inverse`."""

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.felt_accelerations import felt_accelerations

from .conftest import SCENES

COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.05,top,wrench,world,1,0,0,0,0,0
0.10,top,torque,body,0,0,0,0.01,0,0
0.15,top,impulse,world,0.3,0,0,0,0.1,0
0.20,top,wrench,world,0,0,0,0,0,0
"""


@pytest.mark.parametrize('integrator', [None, 'rk8'])
def test_replay_of_a_commanded_top_is_identical(verb, as_json, tmp_path, integrator):
    (tmp_path / 'commands.csv').write_text(COMMANDS)
    words = ['--duration', 0.6, '--commands', tmp_path / 'commands.csv']
    words += ['--integrator', integrator] if integrator else []
    assert verb('simulate', SCENES / 'heavy_top.yaml', '-o', tmp_path / 'b', *words)[0] == 0
    code, result = as_json('replay', tmp_path / 'b')
    assert (code, result['identical'], result['ticks']) == (0, True, 60)


def columns(bag, topic):
    kind = bag.topics[topic].type
    decoded = [cdr.decode(kind, message.data) for message in bag.messages([topic])]
    return np.array([[x for name, _ in d.PARTS for x in getattr(d, name)] for d in decoded])


def test_inverse_finds_the_force_of_the_pivot(verb, tmp_path):
    """N = m (a - g) and torque a x N about the centre of mass; steady precession: a = -W^2 rho."""
    words = ('--duration', 3)
    assert verb('simulate', SCENES / 'heavy_top.yaml', '-o', tmp_path / 'b', *words)[0] == 0
    assert verb('inverse', tmp_path / 'b', '-o', tmp_path / 'i')[0] == 0
    bag = Bag(tmp_path / 'i')
    pose, wrench = columns(bag, '/top/pose'), columns(bag, '/top/wrench')
    inner = slice(20, -20)  # a spline is worst at its ends
    center = pose[inner, :3]
    force = -4.0 * center * (1.0, 1.0, 0.0) + (0.0, 0.0, 9.81)
    # of a spline of degree five through samples 0.2 rad of spin apart
    assert np.allclose(wrench[inner, :3], force, atol=1e-6)
    assert np.allclose(wrench[inner, 3:], np.cross(-center, force), atol=5e-3)
    assert np.allclose(rotation.rotate(pose[inner, 3:], (0, 0, 0.5)), center, atol=1e-12)


def arm_on(support, **initial):
    """A bar of 1 m that turns about its end, at the origin, and touches what supports it."""
    arm = {
        'name': 'arm',
        'mass': 1.0,
        'shape': {'type': 'box', 'size': [1.0, 0.1, 0.1]},
        'pivot': {'point': [-0.5, 0, 0], 'at': [0, 0, 0]},
        'initial': initial,
    }
    contact = {'mode': 'timestep'}
    support = {'name': 'support', 'fixed': True, **support}
    return Simulation(
        load_scene(
            {'dt': 0.004, 'gravity': [0, 0, -9.81], 'contact': contact, 'bodies': [support, arm]}
        )
    )


def test_an_arm_that_rests_on_a_stop_feels_no_acceleration():
    stop = {'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]}}
    sim = arm_on({**stop, 'initial': {'position': [0.9, 0, -0.15]}})
    sim.step(100)
    linear, angular = felt_accelerations(sim)
    # of 9.81 m/s^2 and 14.7 rad/s^2 what the solver leaves over
    assert np.abs(linear).max() < 1e-6 and np.abs(angular).max() < 1e-6


def test_an_arm_that_slides_round_its_pivot_feels_how_its_motion_changes():
    floor = {'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.3}
    sim = arm_on({**floor, 'initial': {'position': [0, 0, -0.05]}}, angular_velocity=[0, 0, 5.0])
    sim.step(20)
    before = sim.state
    sim.step()
    linear, angular = (found[1] for found in felt_accelerations(sim))
    after, dt = sim.state, sim.dt
    slowed = (after.angular_velocity - before.angular_velocity)[1] / dt
    assert slowed[2] < -1.0
    # of the mean over the tick, which its middle has and its end not: the arm turns by 0.02 rad
    changed = (after.velocity - before.velocity)[1] / dt
    for found, expected in ((angular, slowed), (linear, changed)):
        assert np.linalg.norm(found - expected) < 0.02 * np.linalg.norm(expected)
