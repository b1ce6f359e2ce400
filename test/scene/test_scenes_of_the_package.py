# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Each scene of the package does what its second line promises, to the digits printed there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state.snapshot import State
from rigid_body_sim.scene import load_scene

FOLDER = Path(__file__).parents[2] / 'config' / 'scenes'
SCENES = sorted(FOLDER.glob('*.yaml'))
G = 9.81  # [m/s^2]


def start(name: str) -> Simulation:
    """Return a scene of the package at its first tick, by the default integrator."""
    return Simulation(load_scene(FOLDER / f'{name}.yaml'))


def at(simulation: Simulation, time: float) -> Simulation:
    """Step to the tick nearest to a time [s]."""
    simulation.step(round(time / simulation.dt) - simulation.tick)
    return simulation


def turnings(simulation: Simulation, *, body: int, until: float) -> list[float]:
    """Return the times [s] at which the spin about body axis y changes sign, interpolated."""
    times, before = [], simulation.state.angular_velocity_body[body, 1]
    while simulation.time < until:
        simulation.step()
        spin = simulation.state.angular_velocity_body[body, 1]
        if spin * before < 0.0:
            times.append(simulation.time - simulation.dt * spin / (spin - before))
        before = spin
    return times


@pytest.mark.parametrize('path', SCENES, ids=lambda path: path.stem)
def test_a_scene_is_prose_and_loads(path: Path) -> None:
    lines = path.read_text().splitlines()
    assert lines[0].startswith('# ') and lines[1].startswith('# Expected')
    assert not lines[2].startswith('#')
    assert load_scene(path).name == path.stem


def test_the_package_has_scenes() -> None:
    assert len(SCENES) >= 8
    assert len(load_scene(FOLDER / 'ten_bodies.yaml').bodies) == 10


def test_free_fall_takes_the_root_of_two_h_over_g() -> None:
    fall = at(start('free_fall'), 2.019)
    rest = 2.0193 - fall.time
    assert fall.state.position[0, 2] == pytest.approx(19.809 * rest, abs=1.5e-3)
    assert fall.state.velocity[0, 2] == pytest.approx(-19.809 + G * rest, abs=1e-3)


def test_projectile_returns_at_the_range_of_the_parabola() -> None:
    stone = start('projectile')
    assert at(stone, 2.039).state.position[0, 2] == pytest.approx(20.387, abs=5e-4)
    x, _, z = at(stone, 4.0775).state.position[0]
    late = stone.time - 4.0775
    # 4.0775 s is rounded by 3e-5 s, worth 20 m/s times that in height.
    assert (x, z) == pytest.approx((61.162 + 15 * late, -20 * late), abs=1e-3)


def test_tumbling_box_turns_over_as_often_as_it_says() -> None:
    box = start('tumbling_box')
    energy, angular_momentum = box.energy(), box.angular_momentum()
    first, second, third = turnings(box, body=0, until=10.0)
    assert (first, second - first, third - second) == pytest.approx(
        (1.933, 3.866, 3.866), abs=6e-4
    )
    assert box.energy() == pytest.approx(energy, rel=1e-12)
    assert np.array_equal(box.angular_momentum(), angular_momentum)


def test_the_axis_of_the_symmetric_top_runs_on_a_cone() -> None:
    disc = start('symmetric_top')
    momentum = disc.angular_momentum()
    direction = momentum / np.linalg.norm(momentum)
    axes = []
    for _ in range(166):
        axes.append(rotation.rotate(disc.state.orientation[0], (0.0, 0.0, 1.0)))
        disc.step()
    cone = np.degrees(
        np.arctan2(np.linalg.norm(np.cross(axes, direction), axis=1), axes @ direction)
    )
    assert cone == pytest.approx(np.full(len(axes), 1.508), abs=6e-4)
    round_trip = np.linalg.norm(np.array(axes[1:]) - axes[0], axis=1)
    assert np.argmin(round_trip[80:]) + 81 == 165  # the tick nearest to 0.1654 s


def test_satellite_keeps_its_angular_momentum_and_the_beacon_drifts() -> None:
    satellite = at(start('satellite'), 60.0)
    momentum = satellite.state.angular_momentum[0]
    assert np.linalg.norm(momentum) == pytest.approx(0.01669, abs=5e-6)
    assert satellite.state.position[2, 2] == pytest.approx(0.6, rel=1e-12)


def test_oscillator_comes_back_after_its_period() -> None:
    mass = start('oscillator')
    assert at(mass, 0.314).state.position[0, 0] == pytest.approx(0.6, abs=1e-5)
    assert at(mass, 0.628).state.position[0, 0] == pytest.approx(1.0, abs=1e-5)
    positions = []
    for _ in range(630):
        mass.step()
        positions.append(mass.state.position[0, 0])
    assert max(positions) == pytest.approx(1.0, abs=1e-5)  # off by at most half a tick


def test_spring_ball_comes_to_rest_where_the_spring_carries_it() -> None:
    ball = start('spring_ball')
    heights = []
    for _ in range(10_000):
        ball.step()
        heights.append(ball.state.position[0, 2] - 0.3886875)
    lows = [k for k in range(1, 3000) if heights[k - 1] > heights[k] < heights[k + 1]]
    assert np.diff(lows) * ball.dt == pytest.approx(np.full(len(lows) - 1, 0.499), abs=1.1e-3)
    ratio = heights[lows[3]] / heights[lows[0]]
    assert ratio == pytest.approx(math.exp(-1.2 * 3 * 0.499), rel=5e-3)  # low point off by a tick
    assert ball.state.position[0, 2] == pytest.approx(0.38869, abs=5e-6)


def test_quadrotor_falls_and_hovers_on_four_rotors() -> None:
    drone = at(start('quadrotor'), 1.0)
    assert drone.state.position[0] == pytest.approx((0, 0, 10 - 0.5 * G), abs=1e-12)
    drone = start('quadrotor')
    for rotor in ('front_left', 'front_right', 'rear_left', 'rear_right'):
        drone.set_wrench('drone', force=(0, 0, 2.943), frame=rotor)
    at(drone, 10.0)
    assert drone.state.position[0] == pytest.approx((0, 0, 10), abs=1e-12)  # round-off
    assert drone.state.angular_velocity[0] == pytest.approx((0, 0, 0), abs=1e-12)


def test_hovering_drone_is_stopped_by_drag() -> None:
    drone = at(start('hovering_drone'), 8.0)
    assert drone.state.position[0] == pytest.approx((17.293, 0.0, 10.0), abs=5e-4)
    assert drone.state.velocity[0, 0] == pytest.approx(5 * math.exp(-2.0), abs=1e-5)
    assert drone.state.angular_velocity[0, 2] == pytest.approx(2 * math.exp(-8 / 11), abs=1e-5)


def test_two_bodies_tumble_and_come_to_rest() -> None:
    bodies = start('two_bodies')
    first, second = turnings(bodies, body=0, until=15.0)
    assert (first, second - first) == pytest.approx((4.832, 9.664), abs=6e-4)
    # the swings have faded by exp(-0.6 * 15) = 1e-4 of 0.1 m
    assert bodies.state.position[1] == pytest.approx((1.0, 0.0, 0.1019), abs=5e-5)
    assert bodies.state.position[0, 2] == pytest.approx(1.0 - G / 2 * bodies.time**2, rel=1e-12)


def test_tetrahedron_turns_about_its_threefold_axis() -> None:
    corner = start('tetrahedron')
    body = corner.scene.bodies[0]
    assert body.mass == pytest.approx(2.7, rel=1e-14)
    assert body.center_of_mass == pytest.approx((0.075, 0.075, 0.075), rel=1e-14)
    at(corner, 3.6276)
    rest = math.sqrt(3.0) * corner.time - 2.0 * math.pi
    turned = rotation.angle_between(corner.state.orientation[0], rotation.IDENTITY)
    assert turned == pytest.approx(rest, abs=1e-9)  # round-off of 3628 ticks
    assert corner.state.angular_velocity[0] == pytest.approx((1.0, 1.0, 1.0), rel=1e-9)


def test_ten_bodies_keep_places_and_angular_momenta() -> None:
    ten = start('ten_bodies')
    before = ten.state
    _, second = turnings(ten, body=1, until=6.0)
    assert second == pytest.approx(1.933 + 3.866, abs=1.2e-3)
    assert np.array_equal(ten.state.position, before.position)
    assert np.array_equal(ten.state.angular_momentum, before.angular_momentum)


def test_the_heavy_top_precesses_at_the_rate_and_tilt_it_says() -> None:
    top = start('heavy_top')
    for time in (1.57, 3.14, 10.0):
        x, y, z = at(top, time).state.position[0]
        angle = 2.0 * top.time - math.pi / 2  # the axis leans towards -y at the start
        # truncation of order four: 3e-10 rad in 10 s
        assert (x, y) == pytest.approx((math.cos(angle) / 4, math.sin(angle) / 4), abs=1e-9)
        assert z == pytest.approx(math.sqrt(3.0) / 4.0, abs=1e-9)


def test_the_pendulum_swings_in_the_time_and_at_the_rate_it_says() -> None:
    bar = start('pendulum')
    turns, passes = [], []
    before = bar.state
    while bar.time < 4.0:
        bar.step()
        now = bar.state
        a, b = before.angular_velocity[0, 0], now.angular_velocity[0, 0]
        if bar.tick > 10 and a * b < 0.0:
            turns.append(bar.time - bar.dt * b / (b - a))
        if before.position[0, 1] * now.position[0, 1] < 0.0:
            passes.append(max(abs(a), abs(b)))
        before = now
    # kick-drift-kick errs by 5e-7 of a swing; two turns make one
    assert turns[1] == pytest.approx(1.93394, abs=6e-6)
    assert passes == pytest.approx([5.4232] * len(passes), abs=6e-5)
    assert len(passes) == 4


def test_the_rocket_burns_out_as_tsiolkovsky_says() -> None:
    rocket = at(start('rocket'), 60.0)
    assert rocket.state.velocity[0, 2] == pytest.approx(1702.1, abs=0.05)
    assert rocket.state.position[0, 2] == pytest.approx(40713.0, abs=0.5)
    assert rocket.state.masses[0] == 400.0
    assert at(rocket, 70.0).state.velocity[0, 2] == pytest.approx(1702.127 - 10 * G, abs=1e-3)


def test_an_elastic_push_parts_two_masses_as_an_impact_does() -> None:
    push = start('elastic_push')
    energy = push.energy()
    at(push, 2.0)
    # kick-drift-kick in 57 ticks of contact, of which the first and the last are cut by its kink
    assert push.state.velocity[:, 0] == pytest.approx((1.0, 4.0), abs=2e-3)
    assert push.momentum()[0] == pytest.approx(6.0, rel=1e-14)
    assert push.energy() == pytest.approx(energy, rel=1e-3)


def test_demo_keeps_what_it_promises() -> None:
    demo = start('demo')
    before = demo.state
    swings = np.array([_swing(at(demo, 0.001 * k)) for k in range(1, 10_001)])
    after = demo.state
    assert np.array_equal(after.angular_momentum[:2], before.angular_momentum[:2])
    assert _joint(after) == pytest.approx(_joint(before), abs=1e-12)  # round-off of 10,000 ticks
    peaks = [k for k in range(1, len(swings) - 1) if swings[k - 1] < swings[k] > swings[k + 1]]
    fading = swings[peaks[-1]] / swings[peaks[0]]
    # Peaks fall between ticks: up to (w h)^2 / 8 = 5e-6 of the swing.
    assert fading == pytest.approx(math.exp(-(peaks[-1] - peaks[0]) * 1e-3 / 10), rel=1e-3)


def _swing(simulation: Simulation) -> float:
    """Return how far the ball of the demo is from the rest length of its spring [m]."""
    return float(simulation.state.position[4, 2]) - 0.5


def _joint(state: State) -> np.ndarray:
    """Return momentum and angular momentum of rock and cross, about the origin of the world."""
    pair = slice(2, 4)
    orbital = np.cross(state.position[pair], state.momentum[pair])
    angular = state.angular_momentum[pair] + orbital
    return np.concatenate((state.momentum[pair].sum(axis=0), angular.sum(axis=0)))
