# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An overlap deeper than a tenth of the smaller body is a warning while it happens; heavy on light
stands where the solver can carry it.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.model import mass_properties
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Box, Part, Union
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.runs.run import Run, RunSettings

from .touching import ball, box, ground, motion, scene

EDGE = 0.2  # [m]


def heavy_on_light(ratio, **settings):
    """
    A cube of so many kilograms on one of 1 kg.
    """
    light = box('light', EDGE, (0, 0, 0.5 * EDGE))
    heavy = box('heavy', EDGE, (0, 0, 1.5 * EDGE), mass=ratio)
    return Simulation(scene([ground(), light, heavy], dt=0.004, **settings))


def sunk(sim):
    """
    How far the upper cube is too low [m].
    """
    return 1.5 * EDGE - sim.state.position[2, 2]


@pytest.mark.parametrize('ratio', [10.0, 100.0, 1000.0])
def test_a_heavy_cube_stands_on_a_light_one_without_a_warning(ratio):
    """
    The sink in the end is what is left of F/(m omega^2), 3 % of it: 0.15 mm at 1:1000.
    """
    sim = heavy_on_light(ratio)
    sim.step(1250)
    assert -1e-6 < sunk(sim) < 2e-7 * ratio
    assert not sim.overlap_warnings


def test_what_falls_through_says_so_while_it_happens_and_each_pair_once():
    sim = heavy_on_light(1e8)  # with 1e7 it stands
    said = []
    run = Run(sim, RunSettings(), warn=said.append)
    ticks = 0
    while not said and ticks < 500:
        run.advance(1)
        ticks += 1
    # the warning comes before it is through
    assert sunk(sim) < EDGE
    for _ in range(100):
        run.advance(1)
    of_pair = [text for text in said if "'light'" in text and "'heavy'" in text]
    assert len(of_pair) == 1
    assert 'sinking into each other' in of_pair[0]  # before they overlap by a tenth
    assert of_pair[0] in run.warnings


@pytest.mark.parametrize(('mass', 'speed'), [(1e3, 2.6), (1e4, 0.18), (2.5e4, 1.3), (4e5, 0.13)])
def test_an_overlap_is_told_at_the_end_of_the_tick_that_makes_it(mass, speed):
    """
    A cube that falls on a ball of 1 kg; the ball cannot give way but into the ground and the cube.
    """
    light = ball('light', 0.5 * EDGE, (0, 0, 0.5 * EDGE))
    heavy = box('heavy', EDGE, (0, 0, 1.6 * EDGE), mass=mass, velocity=(0, 0, -speed))
    sim = Simulation(scene([ground(), light, heavy], dt=0.004))
    for _ in range(100):
        sim.step(1)
        _, ball_at, cube_at = sim.state.position[:3, 2]
        depth = max(0.5 * EDGE - ball_at, EDGE - (cube_at - ball_at))
        if depth > 0.1 * EDGE:
            break
    assert depth > 0.1 * EDGE
    assert [text for text in sim.overlap_warnings.values() if 'more than a tenth' in text]


def test_bodies_that_overlap_from_the_start_are_named_with_their_depth():
    first = box('first', EDGE, (0, 0, 0.5 * EDGE))
    for depth, said in [
        (0.004, None),
        (0.09, "'first' and 'other' begin 0.018 m in each other"),
        (0.12, "'first' and 'other' overlap by 0.024 m, more than a tenth"),
    ]:
        other = box('other', EDGE, (0.05, 0, (1.5 - depth) * EDGE))
        sim = Simulation(scene([ground(), first, other], gravity=(0, 0, 0)))
        sim.step(3)
        assert len(sim.overlap_warnings) == (said is not None)
        if said:
            assert said in sim.overlap_warnings[1, 2]
            assert sim.overlap_warnings[1, 2] in sim.warnings()


def test_what_begins_in_the_ground_comes_out_slowly_and_only_the_start_is_told():
    """
    A cube that begins 1.5 mm in the ground rises by some 3e-6 of m g k in a tick; its contacts say
    how deep it then is, not how deep it was before it went back.
    """
    sim = Simulation(scene([ground(), box('cube', EDGE, (0, 0, 0.5 * EDGE - 1.5e-3))], dt=0.004))
    sim.step(1)
    assert 'begin 0.0015 m in each other' in sim.overlap_warnings[0, 1]
    # it goes back by 0.1 um and more; round-off of heights of 0.1 m is 1e-16 to 1e-14
    height = sim.state.position[1, 2] - 0.5 * EDGE
    assert sim.contacts().gap == pytest.approx(height, abs=1e-12)
    sim.step(999)
    risen = sim.state.position[1, 2] - 0.5 * EDGE + 1.5e-3
    assert 1000 * 0.15e-6 < risen < 1000 * 0.3e-6
    other = Simulation(scene([ground(), box('cube', EDGE, (0, 0, 0.5 * EDGE))], dt=0.004))
    other.step(1000)
    assert not other.overlap_warnings


def test_the_first_look_after_a_restore_knows_of_no_overlap_before():
    sim = heavy_on_light(1e8)  # with 1e7 it stands
    start = sim.state_bytes()
    while not sim.overlap_warnings:
        sim.step(10)
        assert sim.tick < 300
    sim.restore(tick=0, state=start, slots={})
    assert not sim.overlap_warnings


@pytest.mark.parametrize(
    ('edge', 'count', 'dt', 'told'),
    [(2e-3, 10, 0.004, True), (2e-3, 10, 0.001, False), (2e-3, 1, 0.004, False),
     (4e-3, 10, 0.004, False)],
)  # fmt: skip
def test_bodies_too_small_for_the_tick_are_named_before_their_stack_falls_over(
    edge, count, dt, told
):
    """
    The cure that is named is one: at that tick nothing is said.
    """
    cubes = [box(f'cube_{k}', edge, (0, 0, (k + 0.5) * edge)) for k in range(count)]
    found = Simulation(scene([ground(), *cubes], dt=dt)).scene_warnings
    assert [f"'cube_0' and {count - 1} more are too small" in text for text in found] == told * [
        True
    ]
    if told:
        cure = float(found[0].partition('at most ')[2].split()[0])
        assert Simulation(scene([ground(), *cubes], dt=cure)).scene_warnings == ()


def test_the_deepest_gap_is_that_of_every_tick_whoever_looks():
    """
    A ball that bounces touches for one tick; looks a second apart see nothing of it.
    """
    lively = {'restitution': 0.9}
    dropped = scene(
        [ground(material=lively), ball('ball', 0.1, (0, 0, 1.1), material=lively)], dt=0.004
    )
    seldom, often = Simulation(dropped), Simulation(dropped)
    assert seldom.deepest_gap() is None
    seen = []
    for _ in range(250):
        often.step(1)
        seen.append(often.contacts().gap.min(initial=1.0))
    seldom.step(250)
    assert not len(seldom.contacts().gap)
    assert seldom.deepest_gap() == often.deepest_gap()
    assert min(seen) - 1e-5 < seldom.deepest_gap() <= min(0.0, *seen)
    seldom.reset()
    assert seldom.deepest_gap() is None


@pytest.mark.parametrize('tilt', [0.0, pytest.param(0.1, marks=pytest.mark.long), 0.3])
@pytest.mark.parametrize(
    ('gap', 'mass'), [(0.06, 0.1), (0.08, 1e-3), pytest.param(0.075, 0.5, marks=pytest.mark.long)]
)
def test_what_is_jammed_in_a_clamp_that_is_too_narrow_stays_there_and_says_so(gap, mass, tilt):
    """
    Both jaws push it out, and it cannot obey both: what they give must not grow without end.
    """
    jaw = Box((0.1, 0.3, 0.3))
    places = [(sign * 0.5 * (0.1 + gap), 0.0, 0.0) for sign in (-1, 1)]
    shape = Union(tuple(Part(jaw, mass=60.0, position=place) for place in places))
    inertia = mass_properties.of_shape(shape).inertia
    clamp = Body('clamp', shape, 120.0, inertia=inertia, initial=motion((0, 0, 0)))
    turn = (0.0, math.sin(0.5 * tilt), 0.0, math.cos(0.5 * tilt))
    cube = box('cube', 0.1, (0.003, 0, 0.01), mass=mass, q=turn)
    sim = Simulation(scene([clamp, cube], dt=0.004, gravity=(0, 0, 0)))
    for _ in range(50):
        sim.step()
        assert np.abs(sim.state.velocity[:2]).max() < 1.0  # [m/s] it is pushed at 0.25 at most
    assert abs(sim.state.position[1, 0]) < 0.5 * gap  # [m] along the jaws nothing holds it
    assert any('more than a tenth' in text for text in sim.overlap_warnings.values())
