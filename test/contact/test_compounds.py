# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies of several parts: they rest, topple, bounce and roll as one body.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.model import mass_properties
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import (
    Box,
    ConvexHull,
    Cylinder,
    Part,
    Particle,
    Sphere,
    Union,
)
from rigid_body_sim.physics.simulation import Simulation

from .touching import G, H, ball, box, ground, motion, scene


def joined(name, parts, position, *, mass=1.0, fixed=False, material=None, **of_motion):
    """
    A body of parts (shape, place, quaternion) of one density; `position` is that of its axes.
    """
    volumes = [mass_properties.of_shape(shape, density=1.0).mass for shape, *_ in parts]
    shape = Union(
        tuple(
            Part(shape, mass=mass * volume / sum(volumes), position=place, orientation=turn)
            for (shape, place, turn), volume in zip(parts, volumes, strict=True)
        )
    )
    of = mass_properties.of_shape(shape)
    q = of_motion.get('q', (0.0, 0.0, 0.0, 1.0))
    center = np.asarray(position) + so3.rotate(np.asarray(q, dtype=float), of.center_of_mass)
    return Body(
        name, shape, mass, center_of_mass=tuple(of.center_of_mass.tolist()), inertia=of.inertia,
        fixed=fixed, initial=motion(center, **of_motion), material=Material(**(material or {})),
    )  # fmt: skip


NO_TURN = (0.0, 0.0, 0.0, 1.0)


def halves(name, position, **more):
    """
    A cube of 0.2 m in two halves.
    """
    half = Box((0.1, 0.2, 0.2))
    parts = [(half, (-0.05, 0.0, 0.0), NO_TURN), (half, (0.05, 0.0, 0.0), NO_TURN)]
    return joined(name, parts, position, **more)


def dumbbell(name, position, *, apart=0.4, **more):
    """
    Two balls of radius 0.1 m on a line along y.
    """
    parts = [(Sphere(0.1), (0.0, side * 0.5 * apart, 0.0), NO_TURN) for side in (-1, 1)]
    return joined(name, parts, position, **more)


def gallows(reach, position, **more):
    """
    A foot 0.2 m wide under the origin and an arm along x at its top, of the length given.
    """
    foot, arm = Box((0.2, 0.2, 0.4)), Box((reach, 0.2, 0.1))
    parts = [(foot, (0.0, 0.0, 0.2), NO_TURN), (arm, (0.1 + 0.5 * reach, 0.0, 0.35), NO_TURN)]
    return joined('gallows', parts, position, **more)


def upward(sim, body):
    """
    Points and vertical forces on a body by the ground.
    """
    contacts = sim.contacts()
    with_ground = (contacts.bodies == 0).any(axis=1) & (contacts.bodies == body).any(axis=1)
    sign = np.where(contacts.bodies[with_ground, 1] == body, 1.0, -1.0)
    return contacts.point[with_ground], sign * contacts.impulse[with_ground, 2] / sim.dt


def test_a_gallows_stands_on_its_foot_with_its_weight_below_its_centre_of_mass():
    sim = Simulation(scene([ground(), gallows(0.2, (0, 0, 0))]))
    center = sim.state.position[1].copy()
    assert 0.0 < center[0] < 0.1
    sim.step(1200)
    points, forces = upward(sim, 1)
    assert forces.sum() == pytest.approx(G, rel=1e-9)
    # statics: the pressure acts where the weight does; what the tilt of the soft contacts adds is
    # as small as their sink, 1e-6 m
    assert forces @ points[:, :2] / forces.sum() == pytest.approx(center[:2], abs=1e-5)
    right = forces[points[:, 0] > 0.0].sum()
    assert right == pytest.approx(G * (0.5 + center[0] / 0.2), rel=1e-4)
    assert sim.state.position[1] == pytest.approx(center, abs=1e-5)


@pytest.mark.parametrize(('reach', 'falls'), [(0.38, False), (0.42, True)])
def test_a_gallows_topples_when_its_centre_of_mass_leaves_its_foot(reach, falls):
    sim = Simulation(scene([ground(), gallows(reach, (0, 0, 0))]))
    center = sim.state.position[1].copy()
    assert (center[0] > 0.1) == falls
    sim.step(1200)
    if falls:
        assert 0.05 < sim.state.position[1, 2] < center[2] - 0.05
    else:
        assert sim.state.position[1] == pytest.approx(center, abs=1e-4)


def test_halves_of_a_box_hit_as_the_whole_box_does():
    q = np.array([0.3, 0.2, 0.1, 0.9])
    q /= np.linalg.norm(q)
    lively = {'restitution': 0.6}
    thrown = {'q': q, 'velocity': (0.5, 0.2, -2.0), 'turn': (1.0, 2.0, 3.0), 'material': lively}
    whole = Simulation(scene([ground(), box('b', 0.2, (0, 0, 0.3), **thrown)]))
    split = Simulation(scene([ground(), halves('b', (0, 0, 0.3), **thrown)]))
    for sim in (whole, split):
        sim.step(24)  # one corner has hit
    assert whole.state.velocity[1, 2] > 0.0
    for name in ('position', 'velocity', 'angular_velocity'):
        a, b = getattr(whole.state, name)[1], getattr(split.state, name)[1]
        assert np.abs(a - b).max() < 1e-12


def test_halves_of_a_box_slide_and_rest_as_the_whole_box_does():
    whole = Simulation(scene([ground(), box('b', 0.2, (0, 0, 0.1), velocity=(2.0, 0, 0))]))
    split = Simulation(scene([ground(), halves('b', (0, 0, 0.1), velocity=(2.0, 0, 0))]))
    for sim in (whole, split):
        sim.step(480)
        distance = 2.0**2 / (2 * 0.5 * G)
        # it stops within a substep, at most mu g h^2 too late or too early
        assert sim.state.position[1, 0] == pytest.approx(distance, abs=0.5 * G * H**2)
        assert np.abs(sim.state.velocity[1]).max() < 1e-6
    # eight points carry what four did; a soft contact sinks by micrometres
    assert split.state.position[1, 2] == pytest.approx(whole.state.position[1, 2], abs=1e-6)


def test_a_dumbbell_that_lands_on_both_balls_bounces_straight_up():
    smooth = {'friction': 0.0, 'restitution': 0.8}
    sim = Simulation(scene([ground(), dumbbell('d', (0, 0, 0.6), material=smooth)]))
    sim.step(2)
    energy = sim.energy()
    while sim.state.velocity[1, 2] < 0.0:
        sim.step()
    height = 0.1 + 0.64 * (energy / G - 0.1)
    assert sim.energy() / G == pytest.approx(height, rel=1e-4)
    assert np.abs(sim.state.angular_velocity[1]).max() < 1e-9


def test_a_dumbbell_that_lands_on_one_ball_takes_the_impulse_of_its_lever():
    """
    J = (1 + e) v_n / (1/m + r_t^2/I), frictionless.
    """
    smooth = {'friction': 0.0, 'restitution': 0.7}
    tilt = 0.3
    q = (math.sin(tilt / 2), 0.0, 0.0, math.cos(tilt / 2))
    fall = dumbbell('d', (0, 0, 0.3), q=q, velocity=(0.0, 0.0, -3.0), material=smooth)
    sim = Simulation(scene([ground(), fall], gravity=(0.0, 0.0, 0.0)))
    while sim.state.velocity[1, 2] == -3.0:
        sim.step()
    lever = 0.2 * math.cos(tilt)
    inertia = fall.inertia[0, 0]
    impulse = 1.7 * 3.0 / (1.0 + lever**2 / inertia)
    assert sim.state.velocity[1, 2] == pytest.approx(impulse - 3.0, rel=1e-9)
    assert abs(sim.state.angular_velocity[1, 0]) == pytest.approx(
        impulse * lever / inertia, rel=1e-9
    )


def test_a_sliding_dumbbell_ends_rolling_with_five_sevenths_of_its_speed():
    sim = Simulation(scene([ground(), dumbbell('d', (0, 0, 0.1), velocity=(2.0, 0, 0))]))
    sim.step(240)
    # the balls are solved one after the other, which lets it turn by 1e-5 while it slides
    assert sim.state.velocity[1] == pytest.approx([10.0 / 7.0, 0.0, 0.0], abs=5e-5)
    assert sim.state.angular_velocity[1] == pytest.approx([0.0, 100.0 / 7.0, 0.0], abs=5e-4)
    speed = np.linalg.norm(sim.state.velocity[1])
    sim.step(240)
    assert np.linalg.norm(sim.state.velocity[1]) == pytest.approx(speed, rel=1e-9)  # rolls on


def test_two_wheels_on_an_axle_roll_on():
    turned = (math.sin(math.pi / 4), 0.0, 0.0, math.cos(math.pi / 4))  # z to -y
    wheel = Cylinder(0.1, 0.05)
    parts = [(wheel, (0.0, side * 0.2, 0.0), turned) for side in (-1, 1)]
    parts.append((Cylinder(0.02, 0.35), (0.0, 0.0, 0.0), turned))
    cart = joined('w', parts, (0, 0, 0.1), velocity=(1.0, 0, 0), turn=(0, 10.0, 0))
    sim = Simulation(scene([ground(), cart]))
    # the wheels begin to press one after the other; what that turns it by, 2e-8 m/s across, is
    # halved in 80 ticks
    sim.step(720)
    # it sinks in at the start; what lifts it to rest, m g times some micrometres, is taken from
    # its motion: some 1e-5 J of 0.75 J
    assert sim.state.velocity[1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-5)
    assert sim.state.velocity[1, 1:] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert sim.state.position[1, 2] == pytest.approx(0.1, abs=1e-5)


def test_compounds_that_meet_in_space_keep_momentum_and_angular_momentum():
    bodies = [
        gallows(0.3, (-0.6, 0, 0), velocity=(1.5, 0.1, 0.0), turn=(1.0, 2.0, -1.0)),
        dumbbell('d', (0.5, 0.1, 0.2), velocity=(-1.0, 0.0, 0.1), turn=(0.0, -1.0, 2.0)),
        halves('h', (0.0, 0.5, 0.1), velocity=(0.0, -1.0, 0.0)),
    ]
    sim = Simulation(scene(bodies, gravity=(0.0, 0.0, 0.0)))
    momentum, angular = sim.momentum(), sim.angular_momentum()
    velocity = sim.state.velocity.copy()
    energy = sim.energy()
    sim.step(240)
    assert np.abs(sim.state.velocity - velocity).max() > 0.1
    assert np.abs(sim.momentum() - momentum).max() < 1e-12
    # arms are those of the start of a tick: the order of J v dt = 1 kg m/s 1 m/s 4e-3 s
    assert np.abs(sim.angular_momentum() - angular).max() < 2e-3
    assert sim.energy() < energy


def test_parts_that_overlap_do_not_push_each_other():
    parts = [
        (Box((0.2, 0.2, 0.2)), (0.0, 0.0, 0.0), NO_TURN),
        (Sphere(0.12), (0.05, 0.0, 0.0), NO_TURN),
        (Particle(), (0.0, 0.0, -5.0), NO_TURN),
    ]
    volumes = (0.5, 0.4, 0.1)
    shape = Union(
        tuple(
            Part(shape, mass=mass, position=place)
            for (shape, place, _), mass in zip(parts, volumes, strict=True)
        )
    )
    of = mass_properties.of_shape(shape)
    body = Body(
        'b', shape, 1.0, center_of_mass=tuple(of.center_of_mass.tolist()), inertia=of.inertia,
        initial=motion((0, 0, 20.0), turn=(1, 2, 3)),
    )  # fmt: skip
    sim = Simulation(scene([ground(), body]))
    sim.step(48)
    assert not len(sim.contacts())
    assert sim.state.velocity[1] == pytest.approx([0.0, 0.0, -G * 48 * sim.dt], abs=1e-12)


def test_a_bullet_does_not_pass_a_wall_of_parts():
    wall = joined(
        'wall', [(Box((0.02, 1.0, 0.5)), (0, 0, z), NO_TURN) for z in (0.25, 0.75)], (0, 0, 0),
        fixed=True,
    )  # fmt: skip
    for phase in range(5):
        shot = dumbbell('d', (-3.0 - 0.1 * phase, 0, 0.7), velocity=(300.0, 0, 0))
        sim = Simulation(scene([wall, shot]))
        sim.step(6)
        assert sim.state.position[1, 0] < 0.0


def test_two_hulls_make_a_mould_that_holds_a_ball():
    """
    A shape that is not convex: a trough of two wedges.
    """
    wedge = np.array([[x, y, z] for y in (-0.5, 0.5) for x, z in ((0, 0), (0.5, 0), (0.5, 0.5))])
    left = wedge * [-1.0, 1.0, 1.0]
    parts = [(ConvexHull(wedge), (0, 0, 0), NO_TURN), (ConvexHull(left), (0, 0, 0), NO_TURN)]
    trough = joined('trough', parts, (0, 0, 0), fixed=True)
    sim = Simulation(scene([trough, ball('b', 0.1, (0.05, 0, 0.3), material={'friction': 0.0})]))
    sim.step(960)
    # between planes at 45 degrees the centre lies at sqrt(2) R
    assert sim.state.position[1] == pytest.approx([0.0, 0.0, 0.1 * math.sqrt(2.0)], abs=2e-3)


def test_a_shuffled_heap_of_compounds_differs_by_rounding_alone_and_repeats_to_the_bit():
    bodies = [ground()]
    for i in range(6):
        place = (0.02 * i, 0.01 * i, 0.3 + 0.45 * i)
        body = (
            dumbbell(f'd{i}', place, turn=(0.3, 0.1 * i, 0.2))
            if i % 2
            else halves(f'h{i}', place, turn=(0.1, 0.2 * i, 0.1))
        )
        bodies.append(body)
    shuffled = [bodies[i] for i in np.random.default_rng(3).permutation(len(bodies))]
    one, again, other = (Simulation(scene(given)) for given in (bodies, bodies, shuffled))
    for sim in (one, again, other):
        sim.step(240)
    assert one.state_bytes() == again.state_bytes()
    for body in bodies:
        a = one.state.position[one.body_index(body.name)]
        b = other.state.position[other.body_index(body.name)]
        assert np.abs(a - b).max() < 1e-11
