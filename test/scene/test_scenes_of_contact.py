# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Each scene of bodies that meet does what its second line promises."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene

FOLDER = Path(__file__).parents[2] / 'config' / 'scenes'
G = 9.81  # [m/s^2]
CREEP = 1e-4  # [m] of a body that should rest, while cold contacts begin to carry


def start(name: str) -> Simulation:
    """Return a scene of the package at its first tick, by the default integrator."""
    return Simulation(load_scene(FOLDER / f'{name}.yaml'))


def at(simulation: Simulation, time: float) -> Simulation:
    """Step to the tick nearest to a time [s]."""
    simulation.step(round(time / simulation.dt) - simulation.tick)
    return simulation


def substep(simulation: Simulation) -> float:
    """Return the length of a substep [s]: the default is four in a tick."""
    return simulation.dt / 4


def tilt(simulation: Simulation, body: int) -> float:
    """Return the angle between the z axis of a body and that of the world [rad]."""
    axis = rotation.rotate(simulation.state.orientation[body], (0.0, 0.0, 1.0))
    return math.acos(min(1.0, float(axis[2])))


def test_bouncing_ball_rises_by_the_square_of_its_restitution_and_comes_to_rest() -> None:
    ball = start('bouncing_ball')
    heights = []
    while ball.time < 4.8:
        ball.step()
        heights.append(float(ball.state.position[1, 2]) - 0.1)
    assert np.argmin(heights[:150]) * ball.dt == pytest.approx(0.452, abs=2 * ball.dt)
    tops = [b for a, b, c in zip(heights, heights[1:], heights[2:]) if a < b >= c]
    # The height is seen once a tick: up to g (dt / 2)^2 / 2 = 2e-5 m below the top.
    assert tops[:3] == pytest.approx([0.64, 0.4096, 0.262144], abs=1e-4)
    assert heights[-1] == pytest.approx(0.0, abs=1e-5)
    assert abs(ball.state.velocity[1, 2]) < 1e-6
    assert max(heights[round(4.3 / ball.dt) :]) < 1e-3  # Zeno's end at 4.06 s, seen in ticks


def test_a_ball_rolls_over_a_sea_bed_as_over_a_plane_and_is_turned_back_by_its_slope() -> None:
    ball = start('sea_bed')
    at(ball, 1.4)
    assert ball.state.velocity[-1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-5)
    assert ball.state.position[-1] == pytest.approx([1.4, 0.03, 0.1], abs=1e-5)
    at(ball, 2.4)
    assert ball.state.velocity[-1, 0] < -0.1 and ball.state.position[-1, 0] < 1.3


def test_sliding_blocks_stop_after_the_same_way_in_every_direction() -> None:
    blocks = start('sliding_block')
    before = blocks.state.position
    moving = at(blocks, 0.64).state
    assert np.all(np.linalg.norm(moving.velocity[1:], axis=1) > 0.05)
    after = at(blocks, 1.5).state
    way = np.linalg.norm((after.position - before)[1:, :2], axis=1)
    # v^2 / (2 mu g); they stop within a substep, at most mu g h^2 too late or too early.
    assert way == pytest.approx(2.0**2 / (2 * 0.3 * 9.81), abs=0.3 * 9.81 * substep(blocks) ** 2)
    assert way[1] == pytest.approx(way[0], rel=1e-3)
    assert after.position[1:, 2] == pytest.approx(0.1, abs=1e-5)
    assert np.abs(after.velocity).max() < 1e-6
    assert after.orientation[1:, 3] == pytest.approx(1.0, abs=1e-6)


def test_incline_holds_the_rough_block_and_lets_the_smooth_one_slide() -> None:
    slope = start('incline')
    before = slope.state.position
    after = at(slope, 2.0).state
    rough, smooth = np.linalg.norm(after.position - before, axis=1)[1:]
    assert rough < CREEP
    # x = a t^2 / 2; friction acts from the first substep on, which the block takes to settle: a
    # part of g sin(20) h^2.
    acceleration = G * (math.sin(math.radians(20)) - 0.3 * math.cos(math.radians(20)))
    late = G * math.sin(math.radians(20)) * substep(slope) ** 2
    assert smooth == pytest.approx(0.5 * acceleration * slope.time**2, abs=late)


def test_stack_stands_and_its_static_sink_is_taken_out() -> None:
    stack = start('stack')
    before = stack.state.position
    after = at(stack, 5.0).state
    drift = np.linalg.norm((after.position - before)[1:, :2], axis=1).max()
    # all of the sink of ten soft contacts (0.37 mm), whose loads are known from the start
    assert after.position[10, 2] == pytest.approx(1.9, abs=1e-9)
    assert drift < 2e-6  # what is left of the first ticks, in which loads are not known yet
    assert np.linalg.norm(after.velocity, axis=1).max() < 1e-5
    contacts = stack.contacts()
    on_ground = np.any(contacts.bodies == 0, axis=1)
    carried = np.abs(contacts.impulse[on_ground, 2].sum()) / stack.dt
    assert carried == pytest.approx(98.1, rel=1e-6)


def test_pyramid_stands() -> None:
    pyramid = start('pyramid')
    before = pyramid.state.position
    after = at(pyramid, 3.0).state
    moved = np.linalg.norm((after.position - before)[1:], axis=1)
    assert moved.max() < 5e-5  # boxes go 0.025 mm sideways while friction finds its forces
    assert (before - after.position)[1:, 2].max() < 1e-5  # what is left of the static sink
    assert np.linalg.norm(after.velocity, axis=1).max() < 1e-5


def test_newtons_cradle_hands_its_motion_to_the_last_ball() -> None:
    cradle = at(start('newtons_cradle'), 0.5)
    # Of each impact the speed is right to round-off; four of them in a row.
    assert cradle.state.velocity[:, 0] == pytest.approx((0, 0, 0, 0, 1.0), abs=1e-12)
    assert cradle.momentum() == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    assert cradle.energy() == pytest.approx(0.5, abs=1e-12)


def test_spinning_coin_goes_round_on_its_rim() -> None:
    coin = start('spinning_coin')
    first = math.degrees(tilt(coin, 1))
    assert first == pytest.approx(30.0, abs=1e-9)
    angles = []
    for _ in range(500):
        coin.step(2)
        x, y, _ = rotation.rotate(coin.state.orientation[1], (0.0, 0.0, 1.0))
        angles.append(math.atan2(y, x))
    turns = (np.unwrap(angles)[-1] - angles[0]) / (2 * math.pi)
    # to second order in dt: 3e-5 of the rate, two thousandths of a degree, 5 micrometres
    assert turns / (coin.time - 2 * coin.dt) == pytest.approx(40.149 / (2 * math.pi), rel=1e-4)
    assert math.degrees(tilt(coin, 1)) == pytest.approx(30.0, abs=5e-3)
    assert np.linalg.norm(coin.state.position[1, :2]) < 2e-5


def test_rolling_sphere_keeps_five_sevenths_of_its_speed() -> None:
    ball = start('rolling_sphere')
    sliding = at(ball, 0.188).state
    assert sliding.velocity[1, 0] == pytest.approx(2.0 - 0.3 * G * 0.188, abs=1e-3)
    rolling = at(ball, 2.0).state
    # Friction turns the same impulse into spin that it takes from the speed: to round-off.
    assert rolling.velocity[1, 0] == pytest.approx(2.0 * 5 / 7, rel=1e-12)
    assert rolling.velocity[1, 1:] == pytest.approx(0.0, abs=1e-12)
    assert rolling.angular_velocity[1] == pytest.approx((0.0, 100 / 7, 0.0), abs=1e-11)
    # v^2 / 2 a has the mean speed of each substep, the solver its last: h dv / 2.
    expected = 0.332855 + 10 / 7 * (2.0 - 0.194165)
    assert rolling.position[1, 0] == pytest.approx(expected, abs=1e-3)


def test_dominoes_knock_each_other_over() -> None:
    row = start('domino_row')
    at(row, 0.2)
    assert tilt(row, 20) < 0.01  # the last does not feel it yet
    falls = []
    while row.time < 2.0:
        row.step()
        falls += [row.time] * (sum(tilt(row, k) > 0.1 for k in range(1, 21)) - len(falls))
    assert len(falls) == 20
    assert 14 / (falls[-2] - falls[4]) == pytest.approx(14.83, abs=0.1)  # for every dt
    at(row, 2.5)
    assert min(tilt(row, k) for k in range(1, 21)) > math.radians(70)


def lowest_corners(pile: Simulation) -> NDArray[np.float64]:
    """Return the height of the lowest corner of each box of 0.2 m."""
    axes = rotation.matrix_from_quaternion(pile.state.orientation[1:])
    return pile.state.position[1:, 2] - 0.1 * np.abs(axes[:, 2, :]).sum(axis=1)


@pytest.mark.parametrize(
    ('reach', 'count', 'height'),
    [
        pytest.param(0.5, 40, 0.4, id='its middle'),
        pytest.param(0.9, 160, 0.6, id='more of it', marks=pytest.mark.long),
        pytest.param(2.2, 1000, 1.1, id='whole', marks=pytest.mark.long),
    ],
)
def test_pile_of_1000_settles_on_the_ground_and_loses_no_box(reach, count, height) -> None:
    scene = load_scene(FOLDER / 'pile_of_1000.yaml')
    middle = [b for b in scene.bodies[1:] if max(map(abs, b.initial.position[:2])) < reach]
    pile = at(Simulation(replace(scene, bodies=(scene.bodies[0], *middle))), 4.0)
    assert len(lowest_corners(pile)) == count
    # an overlap that an impact left goes fast down to r/200, and then, that energy may not rise,
    # at 0.6 r h = 0.1 mm/s
    assert lowest_corners(pile).min() > -0.1 * math.sqrt(3.0) / 200
    # a heap, by chance: that of 40 is 0.30 to 0.50 m high in twelve draws moved by 1e-6 m
    assert pile.state.position[:, 2].max() == pytest.approx(height, abs=0.2)
    assert np.percentile(np.abs(pile.state.position[:, :2]), 99) < 4.0
    moving = np.linalg.norm(pile.state.velocity, axis=1) > 0.01
    assert np.mean(moving) < 0.1


@pytest.mark.long
def test_what_overlaps_in_a_pile_of_1000_has_gone_after_twelve_seconds() -> None:
    """
    Up to five corners are as much as 0.75 mm deep after four seconds, and come out by 0.06 mm a
    second under a load, by 0.12 without.
    """
    assert lowest_corners(at(start('pile_of_1000'), 12.0)).min() > -1e-4


def test_striking_pendulum_gives_the_ball_what_the_law_of_impact_says():
    sim = start('striking_pendulum')
    after = at(sim, 0.7)  # the blow is at about 0.54 s
    assert after.state.velocity[2, 0] > 4.174 - 0.3 * 9.81 * 0.2  # it slides, at most that long
    # 5/7 of the speed of the blow; rolling leaves no other, which a tick of delay does not change
    assert at(sim, 1.2).state.velocity[2, 0] == pytest.approx(2.982, abs=2e-3)
    highest = 0.0
    sim = at(start('striking_pendulum'), 0.56)
    for _ in range(600):
        sim.step()
        arm = sim.state.position[1] - (0, 0, 1.1)
        highest = max(highest, math.degrees(math.atan2(arm[0], -arm[2])))
    assert highest == pytest.approx(19.25, abs=0.05)


def test_craft_lands_on_a_heaving_deck_and_keeps_its_place() -> None:
    sim = start('deck_landing')
    touched, places, tilts = 0.0, [], []
    while sim.time < 15.0:
        sim.step(5)
        state = sim.state
        touched = touched or (sim.time if len(sim.contacts()) else 0.0)
        if sim.time > 1.6:
            apart = state.position[1] - state.position[0]
            places.append(rotation.rotate_back(state.orientation[0], apart))
            tilts.append(math.degrees(tilt(sim, 0)))
    assert touched == pytest.approx(1.25, abs=0.025)  # seen every 0.02 s
    assert np.ptp(places, axis=0).max() < 1e-5
    assert max(tilts) == pytest.approx(6.0, abs=0.5)
