# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Friction: stopping distance, headings, threshold of a ramp, rolling, twisting.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import ConvexHull
from rigid_body_sim.physics.simulation import Simulation

from .touching import G, H, ball, box, ground, lean, motion, scene


@pytest.mark.parametrize(('speed', 'edge', 'mu'), [(2.0, 0.2, 0.3), (6.0, 0.1, 0.5)])
def test_a_sliding_box_stops_at_the_same_distance_for_every_heading(speed, edge, mu):
    material = {'friction': mu}
    wanted = speed**2 / (2 * mu * G)
    found = []
    for heading in np.radians([0, 17, 45, 77]):
        v = (speed * math.cos(heading), speed * math.sin(heading), 0)
        sim = Simulation(
            scene(
                [
                    ground(material=material),
                    box('b', edge, (0, 0, edge / 2), velocity=v, material=material),
                ]
            )
        )
        for _ in range(10):
            sim.step(50)
            assert sim.state.position[1, 2] < edge / 2 + 1e-9  # no lift
        found.append(np.linalg.norm(sim.state.position[1, :2]))
        assert np.abs(sim.state.velocity).max() < 1e-12
    assert np.ptp(found) < 1e-3 * wanted
    # it stops within a substep, at most mu g h^2 too late or too early
    assert np.abs(np.array(found) - wanted).max() < mu * G * H**2


@pytest.mark.parametrize(('share', 'creep'), [(0.9, 5e-5), (0.99, 1e-4)])
def test_a_block_on_a_ramp_holds_below_the_angle_of_friction(share, creep):
    angle = share * math.atan(0.5)
    sim = Simulation(scene(_on_a_ramp(angle)))
    start = sim.state.position[1].copy()
    sim.step(1200)
    assert np.linalg.norm(sim.state.position[1] - start) < creep
    assert np.abs(sim.state.velocity).max() < 1e-9


def test_a_block_on_a_ramp_slides_above_the_angle_of_friction():
    angle = 1.01 * math.atan(0.5)
    sim = Simulation(scene(_on_a_ramp(angle)))
    sim.step(240)
    early = np.linalg.norm(sim.state.velocity[1])
    sim.step(240)
    gained = (np.linalg.norm(sim.state.velocity[1]) - early) / (240 * sim.dt)
    assert gained == pytest.approx(G * (math.sin(angle) - 0.5 * math.cos(angle)), rel=1e-9)


def _on_a_ramp(angle):
    q = (0, math.sin(angle / 2), 0, math.cos(angle / 2))
    place = (0.1 * math.sin(angle), 0, 0.1 * math.cos(angle))
    return [ground(slope=angle), box('b', 0.2, place, q=q)]


def test_a_sliding_ball_ends_up_rolling_at_five_sevenths():
    mu = 0.3
    material = {'friction': mu}
    sim = Simulation(
        scene(
            [
                ground(material=material),
                ball('b', 0.1, (0, 0, 0.1), velocity=(1, 0, 0), material=material),
            ]
        )
    )
    sim.step(480)
    assert sim.state.velocity[1, 0] == pytest.approx(5 / 7, rel=1e-12)
    assert sim.state.angular_velocity[1, 1] * 0.1 == pytest.approx(5 / 7, rel=1e-12)
    time = 2 / (7 * mu * G)
    distance = 12 / (49 * mu * G) + 5 / 7 * (2 - time)
    assert sim.state.position[1, 0] == pytest.approx(distance, rel=1e-3)


def test_a_ball_rolls_down_a_ramp_with_five_sevenths_of_gravity():
    angle = math.radians(20)
    place = (0.1 * math.sin(angle), 0, 0.1 * math.cos(angle))
    sim = Simulation(scene([ground(slope=angle), ball('b', 0.1, place)]))
    sim.step(240)
    early = np.linalg.norm(sim.state.velocity[1])
    sim.step(240)
    gained = (np.linalg.norm(sim.state.velocity[1]) - early) / (240 * sim.dt)
    assert gained == pytest.approx(5 / 7 * G * math.sin(angle), rel=1e-12)


def test_rolling_resistance_stops_a_ball_at_its_distance():
    length, radius = 0.002, 0.1
    rolls = {'friction': 0.5, 'rolling_friction': length}
    sim = Simulation(
        scene(
            [
                ground(material=rolls),
                ball('b', radius, (0, 0, radius), velocity=(0.5, 0, 0), turn=(0, 5, 0),
                     material=rolls),
            ]
        )
    )  # fmt: skip
    sim.step(240)
    v, time = sim.state.velocity[1, 0], sim.time
    sim.step(240)
    # the torque is length * N about the contact: a = -(5/7) g length / R
    braking = (v - sim.state.velocity[1, 0]) / (sim.time - time)
    assert braking == pytest.approx(5 / 7 * G * length / radius, rel=1e-12)
    sim.step(720)
    way = 7 * 0.25 * radius / (10 * G * length)
    assert sim.state.position[1, 0] == pytest.approx(way, rel=1e-6)
    assert np.abs(sim.state.velocity).max() < 1e-9


def test_torsional_friction_brings_a_spinning_ball_to_rest_in_time():
    length, radius, spin = 0.004, 0.1, 10.0
    twists = {'torsional_friction': length}
    sim = Simulation(
        scene(
            [
                ground(material=twists),
                ball('b', radius, (0, 0, radius), turn=(0, 0, spin), material=twists),
            ]
        )
    )
    sim.step(120)
    lost = length * G / (0.4 * radius**2) * 0.5
    assert sim.state.angular_velocity[1, 2] == pytest.approx(spin - lost, rel=1e-3)
    sim.step(480)
    assert np.abs(sim.state.angular_velocity).max() < 1e-9


def test_a_wedge_gives_way_to_a_block_of_a_tenth_of_its_mass_by_the_law():
    # smooth: the wedge goes with a = m g sin cos / (M + m sin^2), the block down along it with
    # (M + m) g sin / (M + m sin^2); both constant, so the integrator makes no error
    slope, mass = math.radians(20), 10.0
    run, rise = 2.0, 2.0 * math.tan(slope)
    corners = [[x, y, z] for y in (-0.5, 0.5) for x, z in ((0, 0), (run, 0), (0, rise))]
    middle = np.mean(corners, axis=0)
    smooth = Material(friction=0.0)
    wedge = Body(
        'wedge', ConvexHull(np.array(corners) - middle), mass, inertia=np.eye(3),
        initial=motion(middle), material=smooth,
    )  # fmt: skip
    down = np.array([math.cos(slope), 0, -math.sin(slope)])
    up = np.array([math.sin(slope), 0, math.cos(slope)])
    place = np.array([0.0, 0.0, rise]) + 0.6 * down + 0.05 * up
    turned = (0.0, math.sin(slope / 2), 0.0, math.cos(slope / 2))
    block = box('block', 0.1, place, q=turned, material={'friction': 0.0})
    sim = Simulation(lean([ground(material={'friction': 0.0}), wedge, block], dt=0.004))
    sim.step(100)
    sine, cosine = math.sin(slope), math.cos(slope)
    share = G * sine / (mass + sine * sine)
    of_wedge = np.array([-share * cosine, 0, 0])
    of_block = of_wedge + (mass + 1) * share * down
    # without a cold start the wedge would have its load in the first substep: it has in the second
    assert sim.state.velocity[1] / sim.time == pytest.approx(of_wedge, abs=1e-5 * G)
    assert sim.state.velocity[2] / sim.time == pytest.approx(of_block, abs=1e-5 * G)
