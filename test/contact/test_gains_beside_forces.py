# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact gives no energy, whatever else acts: springs, drag, masses that flow, belts, decks and
pivots, on what touches or elsewhere. And what those give is theirs: nothing of it is taken back.

The rule is that of `test_energy_of_contact`: in no tick more than 1e-5 of the largest energy that
the scene has had, 5e-6 for up to three bodies. Energy is kinetic and potential, with that of
springs; the work of what is moved as told does not count.
"""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from rigid_body_sim.physics.forces.elements.drag import Drag
from rigid_body_sim.physics.forces.elements.spring import Spring
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import (
    Body,
    MassFlow,
    Material,
    Oscillation,
    Pivot,
    PrescribedMotion,
)
from rigid_body_sim.physics.model.shapes import ConvexHull
from rigid_body_sim.physics.simulation import Simulation

from .. import inside
from .touching import G, ball, box, ground, motion, scene

FEW, MANY = 5e-6, 1e-5  # [-] of the largest energy: up to three bodies, and more
ROUGH = {'friction': 0.5}
FLYER = box('flyer', 0.2, (9.0, 0, 5.0))
SLAB = box('slab', (4.0, 4.0, 0.2), (0, 0, 0.9), fixed=True, material=ROUGH)
BELT = replace(SLAB, surface_velocity=(1.5, 0.0, 0.0))
DECK = replace(
    SLAB,
    motion=PrescribedMotion(heave=(Oscillation(0.1, 1.2),), roll=(Oscillation(0.1, 0.9),)),
)  # fmt: skip
TABLE = replace(
    SLAB, motion=PrescribedMotion(), initial=motion((0, 0, 0.9), turn=(0, 0, 2.0))
)  # fmt: skip
# what acts far from what is looked at: bodies, forces
BESIDE = {
    'spring': ((FLYER,), (Spring('flyer', 'world', 10.0, b_point=(9.0, 0.0, 5.0)),)),
    'drag': ((FLYER,), (Drag('flyer', linear=0.1),)),
    'belt': ((replace(BELT, initial=motion((9.0, 0, 0.9))),), ()),
    'flow': ((replace(FLYER, mass_flow=MassFlow(-0.2)),), ()),
}
RIDGE = [[x, y, z] for x in (-1.0, 1.0) for y, z in ((-0.5, -0.3), (0.5, -0.3), (0.0, 0.0))]
GROUNDS = {
    'ball': ball('fixed', 0.4, (0, 0, 0.4), fixed=True, material=ROUGH),
    'ridge': Body(
        'fixed', ConvexHull(np.array(RIDGE)), 0.0, fixed=True, material=Material(**ROUGH),
        initial=motion((0, 0, 0.8)),
    ),
}  # fmt: skip


def disc(seed):
    """
    A prism of twelve sides, as flat as a disc, that falls and tumbles.
    """
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    rim = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    corners = [[0.1 * np.cos(a), 0.1 * np.sin(a), z] for a in rim for z in (-0.01, 0.01)]
    start = motion(
        (*(0.05 * rng.normal(size=2)), 1.2), q=q / np.linalg.norm(q), velocity=(0, 0, -1),
        turn=15 * rng.normal(size=3),
    )  # fmt: skip
    return Body(
        'disc', ConvexHull(np.array(corners)), 1.0, inertia=np.diag([4e-3, 4e-3, 3e-3]),
        material=Material(**ROUGH), initial=start,
    )  # fmt: skip


def energy_of(sim, name):
    """
    Kinetic energy of a body, and that of its weight above the ground [J].
    """
    number = [body.name for body in sim.scene.bodies].index(name)
    body, state = sim.scene.bodies[number], sim.state
    velocity = state.velocity[number]
    spin = so3.rotate_back(state.orientation[number], state.angular_velocity[number])
    kinetic = 0.5 * body.mass * velocity @ velocity + 0.5 * spin @ body.inertia @ spin
    return kinetic + body.mass * G * state.position[number, 2]


def largest_rise(sim, ticks, energy=None):
    """
    Largest rise of energy in a tick over the largest [-], less the work of what moves as told.
    """
    found, works = [(energy or sim.energy)()], [0.0]
    for _ in range(ticks):
        sim.step()
        found.append((energy or sim.energy)())
        works.append(inside.world(sim).work_of_drives)
    return (np.diff(found) - np.diff(works)).max() / max(found)


@pytest.mark.parametrize(('on', 'seed'), [('ball', 3), ('ball', 21), ('ridge', 7), ('ridge', 25)])
@pytest.mark.parametrize('beside', BESIDE)
def test_what_acts_elsewhere_lets_no_disc_gain_that_tumbles(beside, on, seed):
    """
    Its contacts give 1e-4 to 4e-4 of the energy, which is taken back.
    """
    others, forces = BESIDE[beside]
    bodies = [ground(material=ROUGH), GROUNDS[on], disc(seed), *others]
    sim = Simulation(scene(bodies, forces=forces, dt=0.004))
    assert largest_rise(sim, 300, lambda: energy_of(sim, 'disc')) < FEW


@pytest.mark.parametrize('ms', [4.0, 2.0])
@pytest.mark.parametrize(('on', 'seed'), [('ball', 3), ('ball', 21), ('ridge', 7), ('ridge', 25)])
def test_contact_gives_nothing_to_a_disc_on_a_spring(on, seed, ms):
    bodies = [ground(material=ROUGH), GROUNDS[on], disc(seed)]
    spring = Spring('disc', 'world', 2.0, a_point=(0.05, 0, 0), b_point=(0.1, 0.2, 0.6))
    sim = Simulation(scene(bodies, forces=[spring], dt=1e-3 * ms))
    assert largest_rise(sim, round(1200 / ms)) < FEW


TUMBLES = [('ball', 3), ('ball', 18), ('ridge', 2), ('ridge', 14)]
MOVED = {
    'heave': {'motion': PrescribedMotion(heave=(Oscillation(0.05, 0.7),))},
    'sway': {'motion': PrescribedMotion(sway=(Oscillation(0.1, 0.9),))},
    'pitch': {'motion': PrescribedMotion(pitch=(Oscillation(0.3, 0.9),))},
}


@pytest.mark.parametrize(
    ('on', 'seed', 'ms'),
    [
        *((on, seed, 4.0) for on, seed in TUMBLES),
        (*TUMBLES[2], 1.0),
        *(pytest.param(*one, 1.0, marks=pytest.mark.long) for one in TUMBLES if one != TUMBLES[2]),
    ],
)
@pytest.mark.parametrize('moved', MOVED)
def test_contact_gives_nothing_to_a_disc_that_tumbles_over_what_moves_as_told(
    moved, on, seed, ms
):  # fmt: skip
    """
    What it gives beside the work of what moves, up to 4e-4, is taken back, in shorter ticks as
    their square.
    """
    bodies = [ground(material=ROUGH), replace(GROUNDS[on], **MOVED[moved]), disc(seed)]
    sim = Simulation(scene(bodies, dt=1e-3 * ms))
    assert largest_rise(sim, round(1000 / ms)) < FEW * (ms / 4.0) ** 2


@pytest.mark.parametrize('seeds', [3, pytest.param(10, marks=pytest.mark.long)])
def test_contact_gives_nothing_to_boxes_that_springs_throw_at_each_other_in_free_space(seeds):
    """
    Up to 2e-4 of the energy is taken back, and momentum and angular momentum stay.
    """
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        bodies = []
        for i in range(6):
            q, place = rng.normal(size=4), (0.5 * (i % 3), 0.5 * (i // 3), 0.0)
            bodies.append(
                box(f'b{i}', rng.uniform(0.15, 0.35, 3), place, q=q / np.linalg.norm(q),
                    velocity=0.3 * rng.normal(size=3), turn=3 * rng.normal(size=3),
                    mass=rng.uniform(0.5, 2), material=ROUGH)
            )  # fmt: skip
        forces = [
            Spring(f'b{i}', f'b{(i + 1) % 6}', rng.uniform(5, 100), a_point=(0.03, 0.0, 0.02))
            for i in range(6)
        ]
        sim = Simulation(scene(bodies, forces=forces, gravity=(0, 0, 0), dt=0.004))
        linear, angular = sim.momentum(), sim.angular_momentum()
        assert largest_rise(sim, 375) < MANY, seed
        # some ten kg m/s and kg m^2/s, a thousand ticks of forces
        assert np.abs(sim.momentum() - linear).max() < 1e-12, seed
        assert np.abs(sim.angular_momentum() - angular).max() < 1e-12, seed


def heap(height, count=12):
    """
    Boxes and balls that fall onto each other.
    """
    rng = np.random.default_rng(5)
    bodies = []
    for i in range(count):
        place = (*rng.uniform(-0.15, 0.15, 2), height + 0.2 + 0.3 * i)
        q = rng.normal(size=4)
        how = {'mass': rng.uniform(0.3, 3.0), 'turn': rng.normal(size=3), 'material': ROUGH}
        if i % 3 == 2:
            bodies.append(ball(f'b{i}', 0.1, place, **how))
        else:
            size = rng.uniform(0.1, 0.25, 3)
            bodies.append(box(f'b{i}', size, place, q=q / np.linalg.norm(q), **how))
    return bodies


@pytest.mark.parametrize('driven', [BELT, DECK, TABLE], ids=['belt', 'deck', 'turntable'])
def test_contact_gives_nothing_to_a_heap_on_what_moves_as_told_beside_its_work(driven):
    bodies = [ground(material=ROUGH), driven, *heap(1.0)]
    assert largest_rise(Simulation(scene(bodies, dt=0.004)), 400) < MANY


def test_contact_gives_nothing_to_a_heap_whose_bodies_pull_at_each_other():
    bodies = [ground(material=ROUGH), *heap(0.0)]
    forces = [Spring(f'b{i}', f'b{i + 3}', 20.0, 0.1, 0.3, (0.02, 0, 0.03)) for i in range(9)]
    forces += [Drag(f'b{i}', linear=0.1, angular=1e-3) for i in range(0, 12, 2)]
    assert largest_rise(Simulation(scene(bodies, forces=forces, dt=0.004)), 400) < MANY


def test_contact_gives_nothing_to_an_arm_on_a_pivot_and_what_falls_onto_it():
    arm = box('arm', (0.8, 0.1, 0.05), (0, 0, 0.6), mass=2.0, material=ROUGH)
    arm = replace(arm, pivot=Pivot((-0.35, 0.0, 0.0), (-0.35, 0.0, 0.6)))
    sim = Simulation(scene([ground(material=ROUGH), arm, *heap(0.7, 6)], dt=0.004))
    assert largest_rise(sim, 400) < MANY


def rides_a_table():
    """
    A cube half a metre from the axis of a turntable, at rest on it.
    """
    cube = box('b', 0.2, (0.5, 0, 1.1), velocity=(0, 1.0, 0), turn=(0, 0, 2.0), material=ROUGH)
    return [TABLE, cube], ()


def rides_a_belt():
    """
    Two cubes put down on a belt.
    """
    cubes = [box(f'b{i}', 0.2, (0, 0, 1.1 + 0.2 * i), material=ROUGH) for i in range(2)]
    return [BELT, *cubes], ()


def climbs_a_wall():
    """
    A cube that a spring behind a wall presses against it and pulls up.
    """
    wall = box('wall', (0.2, 4, 6), (-0.1, 0, 3), fixed=True, material=ROUGH)
    cube = box('b', 0.2, (0.1, 0, 0.1), material=ROUGH)
    return [wall, cube], (Spring('b', 'world', 60.0, b_point=(-0.15, 0.0, 2.0)),)


def rolls_on_a_spring():
    """
    A ball that a spring pulls to and fro, rolling.
    """
    rolling = ball('b', 0.1, (0.3, 0, 0.1), material=ROUGH)
    return [rolling], (Spring('b', 'world', 40.0, b_point=(0.0, 0.0, 0.1)),)


def pushed_by_what_it_throws_out():
    """
    A cube that slides over the ground, as it throws out 0.05 kg/s at 160 m/s.
    """
    cube = box('b', 0.2, (0, 0, 0.1), material=ROUGH)
    return [replace(cube, mass_flow=MassFlow(-0.05, (-160.0, 0.0, 0.0)))], ()


THOSE_THAT_GIVE = (
    rides_a_table, rides_a_belt, climbs_a_wall, rolls_on_a_spring, pushed_by_what_it_throws_out,
)  # fmt: skip


@pytest.mark.parametrize(
    ('what', 'ms'),
    [
        *itertools.product(THOSE_THAT_GIVE, [4.0]),
        (rides_a_belt, 1.0),
        *(
            pytest.param(what, 1.0, marks=pytest.mark.long)
            for what in THOSE_THAT_GIVE
            if what is not rides_a_belt
        ),
    ],
)
def test_nothing_is_taken_back_of_what_drives_springs_and_flows_give(what, ms):
    """
    All they give is more than a hundred thousand times what may remain of a gain. A hundredth of
    what friction gives a cube in a tick of 1 ms is allowed: of two on a belt, an error of contact
    that gains 1e-5 N s is taken back in one tick of a thousand.
    """
    bodies, forces = what()
    sim = Simulation(scene([ground(material=ROUGH), *bodies], forces=forces, dt=1e-3 * ms))
    for _ in range(round(1000 / ms)):
        sim.step()
        taken = sim.contacts().taken_back
        assert not taken.size or np.abs(taken).max() < 1e-4  # [N s]


def test_work_of_a_turntable_by_torsional_friction_is_that_of_its_torque():
    """
    A ball on its axis is brought to its spin: the torque gives it I W, and so works I W^2, half of
    which becomes heat.
    """
    spins = ball('b', 0.1, (0, 0, 1.1), material={'torsional_friction': 0.02, **ROUGH})
    sim = Simulation(scene([TABLE, spins], dt=0.004))
    sim.keep_energy_balance()
    sim.step(100)
    assert sim.state.angular_velocity[1, 2] == pytest.approx(2.0, rel=1e-9)
    inertia = 0.4 * 0.1**2
    assert sim.energy_balance().work_of_drives == pytest.approx(inertia * 2.0**2, rel=1e-9)


def test_work_of_a_turntable_on_what_rides_it_is_nothing():
    """
    Friction holds the cube on its circle, square to its way: of the energy of half a joule a
    millionth would be seen.
    """
    bodies, _ = rides_a_table()
    sim = Simulation(scene(bodies, dt=0.004))
    sim.step(10)  # it learns of the force that holds it
    before = inside.world(sim).work_of_drives
    sim.step(round(math.pi / 0.004))
    assert inside.world(sim).work_of_drives == pytest.approx(before, abs=5e-7)
