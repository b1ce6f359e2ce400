# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies on a pivot strike, rebound and lean: a contact changes the angular momentum about the pivot,
and the pivot takes the rest.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene

G = 9.81
BALL = {'type': 'sphere', 'radius': 0.1}
ROD = {'type': 'box', 'size': [0.1, 0.1, 1.0]}
FAR = [
    {'name': 'far_floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]},
     'initial': {'position': [0, 0, -90]}},
    {'name': 'far_box', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'fixed': True,
     'initial': {'position': [0, 0, -80]}},
    {'name': 'far_ball', 'shape': BALL, 'fixed': True, 'restitution': 0.1,
     'initial': {'position': [0, 0, -70]}},
]  # fmt: skip
# so all scenes of this file share one kernel


def about_y(angle):
    return [0.0, math.sin(0.5 * angle), 0.0, math.cos(0.5 * angle)]


def simulation(*bodies, gravity=0.0, dt=0.004, **contact):
    return Simulation(
        load_scene(
            {
                'dt': dt, 'gravity': [0, 0, -gravity], 'bodies': [*bodies, *FAR],
                'contact': {'mode': 'timestep', **contact},
            }
        )
    )  # fmt: skip


def bob(name='bob', *, at=(0, 0, 1), angle=0.0, rate=0.0, shape=BALL, mass=2.0, **more):
    """
    A pendulum of 1 m between pivot and centre; angle and rate about y.
    """
    return {
        'name': name, 'shape': shape, 'mass': mass, 'pivot': {'point': [0, 0, 1], 'at': list(at)},
        'initial': {'orientation': about_y(angle), 'angular_velocity': [0, rate, 0]}, **more,
    }  # fmt: skip


def angular_momentum(state, pivot):
    arms = state.position - np.array(pivot)
    return np.sum(state.angular_momentum + np.cross(arms, state.momentum), axis=0)


@pytest.mark.parametrize('restitution', [1.0, 0.5, 0.0])
def test_pendulum_strikes_a_ball_by_the_law_of_impact_about_its_pivot(restitution):
    material = {'restitution': restitution, 'friction': 0.0}
    sim = simulation(
        bob(angle=1.0, rate=-3.0, **material),
        {'name': 'ball', 'shape': BALL, 'mass': 1.0, 'initial': {'position': [0.2, 0, 0]},
         **material},
    )  # fmt: skip
    # released at an angle of 1, towards lower angles: x of the bob grows to 0 at the lowest place
    before, energy = angular_momentum(sim.state, (0, 0, 1)), sim.energy()
    sim.step(150)
    state, inertia = sim.state, 2.0 * (1.0 + 0.4 * 0.1**2)
    # round-off: no impulse changes the sum
    assert angular_momentum(state, (0, 0, 1)) == pytest.approx(before, abs=1e-13)
    # the line of centres is horizontal but for what the bob moves in a part of a tick, 12 mm
    rate = 3.0 * (inertia - restitution) / (inertia + 1.0)
    assert -state.angular_velocity[0, 1] == pytest.approx(rate, abs=2e-3)
    speed = 3.0 * (1.0 + restitution) * inertia / (inertia + 1.0)
    assert state.velocity[1, 0] == pytest.approx(speed, abs=2e-3)
    lost = 0.5 * inertia / (inertia + 1.0) * (1.0 - restitution**2) * 3.0**2
    assert energy - sim.energy() == pytest.approx(lost, abs=5e-3)
    assert sim.energy() <= energy * (1.0 + 1e-14)  # round-off


@pytest.mark.parametrize(('shape', 'gap'), [(BALL, 0.1), (ROD, 0.05)])
@pytest.mark.parametrize('restitution', [1.0, 0.7])
def test_pendulum_rebounds_from_a_wall_with_the_share_of_its_rate(shape, gap, restitution):
    material = {'restitution': restitution, 'friction': 0.3}
    wall = {'name': 'wall', 'shape': {'type': 'box', 'size': [1, 4, 4]}, 'fixed': True,
            'initial': {'position': [0.5 + gap, 0, 0]}, **material}  # fmt: skip
    sim = simulation(bob(angle=0.5, rate=-2.0, shape=shape, **material), wall)
    sim.step(100)
    # the bob meets the wall where it hangs straight: the impact is central for rotation, and
    # friction acts along the arm or not at all
    assert sim.state.angular_velocity[0, 1] == pytest.approx(2.0 * restitution, rel=1e-3)
    arm = sim.state.position[0] - [0, 0, 1]
    assert np.linalg.norm(arm) == pytest.approx(1.0, abs=1e-14)


def test_equal_pendulums_exchange_their_motion_and_back():
    material = {'restitution': 1.0, 'friction': 0.0}
    sim = simulation(
        bob('left', angle=0.4, **material),
        bob('right', at=(0.2, 0, 1), **material),
        gravity=G,
    )
    energy = sim.energy()
    swung = []
    for _ in range(390):  # a quarter of a period, half of one, half of one: 2.1 s in all
        sim.step()
        assert sim.energy() - energy < 1e-4 * 2.0 * G * (1.0 - math.cos(0.4))
        swung.append(sim.state.position[:2, 0] - [0.0, 0.2])
    left, right = np.array(swung).T
    reach = math.sin(0.4)
    # struck late by a part of a tick, 4 mm
    assert (left.min(), right.max()) == pytest.approx((-reach, reach), abs=5e-3)
    assert (left.max(), right.min()) == pytest.approx((0.0, 0.0), abs=5e-3)
    first = int(np.argmax(right > 0.5 * reach))
    assert np.abs(left[first : first + 50]).max() < 5e-3  # who struck stands still


def test_pendulum_leans_at_rest_on_a_block_with_the_force_of_its_weight():
    # hangs out by 0.3 rad, held by a wall at its bob: N l cos = m g l sin
    angle = 0.3
    x = -math.sin(angle)
    wall = {'name': 'wall', 'shape': {'type': 'box', 'size': [1, 4, 4]}, 'fixed': True,
            'friction': 0.0, 'initial': {'position': [x + 0.1 + 0.5, 0, 0]}}  # fmt: skip
    sim = simulation(bob(angle=angle, friction=0.0), wall, gravity=G)
    sim.step(500)
    force, torque = sim.contact_wrench('bob')
    assert force == pytest.approx([-2.0 * G * math.tan(angle), 0, 0], abs=1e-5)
    assert torque == pytest.approx([0, 0, 0], abs=1e-9)
    assert sim.state.position[0, 0] == pytest.approx(x, abs=1e-5)  # the sink of what rests
    assert np.abs(sim.state.angular_velocity[0]).max() < 1e-6


def test_block_under_an_arm_carries_the_moment_of_its_weight():
    # a horizontal arm on a free block: force is not determined, torque about the pivot is
    arm = bob(at=(0, 0, 0.25), angle=0.5 * math.pi, shape={'type': 'box', 'size': [0.1, 0.1, 0.4]})
    block = {'name': 'block', 'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]}, 'mass': 1.0,
             'initial': {'position': [-1, 0, 0.1]}}  # fmt: skip
    floor = {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
    sim = simulation(arm, block, floor, gravity=G)
    sim.step(250)
    force, torque = sim.contact_wrench('bob')
    about_pivot = torque + np.cross(sim.state.position[0] - [0, 0, 0.25], force)
    assert about_pivot[1] == pytest.approx(2.0 * G, rel=1e-4)
    floor_force, _ = sim.contact_wrench('floor')
    assert force[2] + 1.0 * G == pytest.approx(-floor_force[2], abs=1e-3)
    assert np.abs(sim.state.velocity[:2]).max() < 1e-5


def test_pendulum_that_touches_nothing_swings_as_without_contact():
    from rigid_body_sim.exact import pendulum

    sim = simulation(bob(angle=1.2), gravity=G, dt=0.002)
    inertia = 2.0 * (1.0 + 0.4 * 0.1**2)
    sim.step(1000)
    swing = pendulum.swing(2.0, inertia=inertia, weight_moment=2.0 * G, angle=1.2)
    arm = sim.state.position[0] - [0, 0, 1]
    # velocity Verlet with substeps of 0.5 ms over a period: (w h)^2 / 24 of the phase
    assert math.atan2(-arm[0], -arm[2]) == pytest.approx(swing.angle, abs=1e-5)


def test_wheel_on_its_axle_that_overlaps_the_ground_is_not_thrown_about():
    # every normal goes through the pivot: what presses is not known
    wheel = {'name': 'wheel', 'shape': BALL, 'mass': 1.0, 'pivot': {'point': [0, 0, 0]},
             'initial': {'position': [0, 0, 0.0999], 'angular_velocity': [0, 3, 0]}}  # fmt: skip
    floor = {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
    sim = simulation(wheel, floor, gravity=G)
    sim.step(100)
    assert sim.state.position[0] == pytest.approx([0, 0, 0.0999], abs=1e-15)
    assert sim.state.angular_velocity[0] == pytest.approx([0, 3, 0], abs=1e-12)


def test_wheel_on_its_axle_is_driven_by_what_slides_over_it():
    # friction turns it until both surfaces move alike; the axle carries the weight
    wheel = {'name': 'wheel', 'shape': {'type': 'sphere', 'radius': 0.5}, 'mass': 1.0,
             'pivot': {'point': [0, 0, 0], 'at': [0, 0, -0.5]}, 'friction': 0.5}  # fmt: skip
    board = {'name': 'board', 'shape': {'type': 'box', 'size': [9, 9, 0.2]}, 'mass': 3.0,
             'friction': 0.5,
             'initial': {'position': [0, 0, 0.1], 'velocity': [0.2, 0, 0]}}  # fmt: skip
    sim = simulation(wheel, board, gravity=G)
    sim.step(5)
    # inertia 0.4 m R^2 seen at the rim is 0.4 m: p = 3 * 0.2 = (3 + 0.4) v
    assert sim.state.velocity[1, 0] == pytest.approx(0.6 / 3.4, rel=1e-3)
    assert 0.5 * sim.state.angular_velocity[0, 1] == pytest.approx(0.6 / 3.4, rel=1e-2)


def test_contact_wrenches_are_the_whole_change_of_angular_momentum_about_a_pivot():
    """
    L' - L = (T + a x (F + m g)) dt, T about the centre of mass, with what ticks take back of
    gains. A bar swings down onto a stop and a box falls onto the bar: of both gains are taken.
    """
    sim = simulation(
        {'name': 'arm', 'shape': {'type': 'box', 'size': [1.0, 0.1, 0.1]}, 'mass': 1.0,
         'pivot': {'point': [-0.5, 0, 0], 'at': [0, 0, 0]}, 'restitution': 0.7, 'friction': 0.1,
         'initial': {'angular_velocity': [-2.5, 1.3, 8.4]}},
        {'name': 'box', 'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]}, 'mass': 8.2,
         'restitution': 0.5,
         'initial': {'position': [0.5, 0, 0.2], 'velocity': [0.3, 0, -5],
                     'angular_velocity': [-0.7, -0.8, 0.3]}},
        {'name': 'stop', 'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]}, 'fixed': True,
         'initial': {'position': [0.9, 0, -0.15]}},
        gravity=G, substeps=1,
    )  # fmt: skip

    def about_pivot():
        state = sim.state
        return state.position[0].copy(), state.angular_momentum[0] + np.cross(
            state.position[0], state.momentum[0]
        )

    taken = 0.0
    for _ in range(40):
        (begin, before), _ = about_pivot(), sim.step()
        end, after = about_pivot()
        found = sim.contacts()
        if 0 not in found.damped:
            continue
        force, torque = sim.contact_wrench('arm')
        weight = np.cross(0.5 * (begin + end), [0, 0, -G])
        change = (torque + np.cross(end, force) + weight) * sim.dt
        # points move by up to 4 mm in a tick, and with them the arms of 0.4 N s
        assert after - before == pytest.approx(change, abs=1e-3)
        taken = max(taken, np.abs(found.taken_back[found.damped == 0]).max())
    assert taken > 0.01  # [N s] and [N m s]: the law has to have it
