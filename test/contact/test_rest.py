# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Rest: stacks, mass ratios, energy that only falls.
"""

import math
from functools import cache

import numpy as np
import pytest

from rigid_body_sim import load_scene
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Plane
from rigid_body_sim.physics.simulation import Simulation

from .touching import DT, G, ball, box, ground, lean, scene, stack


@cache
def settled_stack():
    """
    Ten cubes that have stood for ten seconds.
    """
    sim = Simulation(lean(stack(10)))
    sim.step(2400)
    return sim.state


def test_a_stack_of_ten_stands_at_its_height_without_drift():
    s = settled_stack()
    assert s.position[-1, 2] == pytest.approx(1.9, abs=1e-9)  # its loads are known from the start
    assert np.abs(s.position[1:, :2]).max() < 2e-4


def test_a_stack_of_ten_comes_to_rest():
    s = settled_stack()
    assert np.abs(s.velocity).max() < 1e-6
    assert np.abs(s.angular_velocity).max() < 1e-6


def leaning_stack(seed, *, counts=(2, 7), sides_of=(3, 4, 6, 8)):
    """
    Boxes, cans or prisms a few millimetres beside each other, put down or dropped by a centimetre:
    from so many up to less than so many, prisms of so many sides.
    """
    rng = np.random.default_rng(seed)
    count, gap, high = int(rng.integers(*counts)), rng.choice([0, 0.01]), rng.uniform(0.05, 0.3)
    wide, sides = rng.uniform(0.1, 0.3), int(rng.choice(sides_of))
    kind = str(rng.choice(['box', 'box', 'cylinder', 'convex_hull']))
    angles = np.arange(sides) * 2 * np.pi / sides
    ring = [(float(wide / 2 * np.cos(a)), float(wide / 2 * np.sin(a))) for a in angles]
    corners = [[x, y, z] for z in (-high / 2, high / 2) for x, y in ring]
    shape = {
        'box': {'size': [wide, wide * rng.uniform(0.8, 1.2), high]},
        'cylinder': {'radius': wide / 2, 'length': high},
        'convex_hull': {'vertices': corners},
    }[kind]
    material = {'friction': rng.choice([0.3, 1.0]), 'restitution': rng.choice([0.0, 0.4])}
    bodies = [{'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, **material}]
    for i in range(count):
        yaw = rng.uniform(-3, 3) if seed % 2 else 0.0
        at = [*rng.uniform(-0.05, 0.05, 2) * wide, high / 2 + (high + gap) * i + gap]
        bodies.append({
            'name': f'b{i}', 'mass': 3 ** rng.uniform(-1, 1), 'shape': {'type': kind, **shape},
            **material,
            'initial': {
                'position': at, 'orientation': [0, 0, np.sin(yaw / 2), np.cos(yaw / 2)],
            },
        })  # fmt: skip
    return load_scene({
        'version': 1, 'name': 'leaning', 'dt': 0.004, 'gravity': [0, 0, -G], 'bodies': bodies,
        'contact': {'mode': 'timestep'},
    })  # fmt: skip


@pytest.mark.parametrize(
    'seed',
    [
        *range(10),
        166,
        *(pytest.param(i, marks=pytest.mark.long) for i in range(10, 200) if i != 166),
    ],
)
def test_a_stack_that_is_not_straight_comes_to_rest(seed):
    # In that of seed 166 a box tips on one point, which must not count as a line for rounding.
    # All are far below; of the next 500 three are not, and rock by up to 4e-3 rad/s. With one
    # spring a face three boxes never fell below 5e-3 rad/s
    sim = Simulation(leaning_stack(seed))
    sim.step(1000)
    for _ in range(20):
        sim.step(5)
        assert np.abs(sim.state.angular_velocity).max() < 5e-4
        assert np.abs(sim.state.velocity).max() < 1e-4


def unlike_boxes(seed):
    """
    Three to six boxes of 5 to 25 cm and 200 to 2000 kg/m^3, a centimetre beside each other, turned
    about the vertical.
    """
    rng = np.random.default_rng(seed)
    rough, top = {'friction': 0.6}, 0.0
    bodies = [{'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, **rough}]
    for i in range(int(rng.integers(3, 7))):
        size = np.maximum(rng.uniform(0.05, 0.25, 3), [0.12, 0.12, 0.0])
        yaw, at = rng.uniform(-3, 3), [*(0.01 * rng.normal(size=2)), top + size[2] / 2]
        top += size[2]
        bodies.append({
            'name': f'b{i}', 'density': 10 ** rng.uniform(2.3, 3.3), **rough,
            'shape': {'type': 'box', 'size': size},
            'initial': {
                'position': at, 'orientation': [0, 0, np.sin(yaw / 2), np.cos(yaw / 2)],
            },
        })  # fmt: skip
    return load_scene({
        'version': 1, 'name': 'unlike', 'dt': 0.004, 'gravity': [0, 0, -G], 'bodies': bodies,
        'contact': {'mode': 'timestep'},
    })  # fmt: skip


UNLIKE = [0, 2, 4, 32]


@pytest.mark.parametrize(
    'seed',
    [*UNLIKE, *(pytest.param(i, marks=pytest.mark.long) for i in range(40) if i not in UNLIKE)],
)
def test_a_stack_of_unlike_boxes_comes_to_rest(seed):
    # up to 50 kg on 1 kg: loads that are followed late let one of three rock for ever, at up to
    # 5e-2 rad/s
    sim = Simulation(unlike_boxes(seed))
    sim.step(1000)
    for _ in range(20):
        sim.step(10)
        assert np.abs(sim.state.angular_velocity).max() < 1e-3


def boxes_beside_each_other(seed):
    """
    Two to five cubes of 0.1 to 10 kg, each up to 2 cm beside the one below along both axes, on
    ground that is level or tilted: statics lets all stand.
    """
    rng = np.random.default_rng(seed)
    side, slope, count = 0.2, float(rng.choice([0.0, 0.1])), int(rng.integers(2, 6))
    at = np.cumsum(rng.uniform(-0.02, 0.02, (count, 2)), axis=0)
    masses = 10 ** rng.uniform(-1, 1, count)
    bodies = [box(f'b{i}', side, (*at[i], side * (0.5 + i)), mass=masses[i]) for i in range(count)]
    gravity = (G * math.sin(slope), 0.0, -G * math.cos(slope))
    return lean([ground(), *bodies], gravity=gravity)


@pytest.mark.parametrize(
    'seed', [*range(4), *(pytest.param(i, marks=pytest.mark.long) for i in range(4, 40))]
)
def test_what_stands_at_the_start_stands_wherever_its_faces_are_loaded(seed):
    # with one sink for all points of a manifold they begin with 1e-4 to 5e-3 m/s, and tilt by 1e-5
    # to 4e-4 rad; what is left is what the search for the loads leaves
    sim = Simulation(boxes_beside_each_other(seed))
    begin = sim.state
    for _ in range(50):
        sim.step(5)
        assert np.abs(sim.state.velocity).max() < 1e-6
    assert np.abs(sim.state.position - begin.position).max() < 1e-8


@pytest.mark.parametrize('seed', [3, 13, 36])
def test_a_stack_of_pentagons_does_not_lean_round_for_ever(seed):
    # with corners that are chosen anew at each tremble: 7e-3 to 4e-2 rad/s. Not a law yet: of
    # thirteen draws one still leans round, that of seed 17
    sim = Simulation(leaning_stack(seed, counts=(5, 9), sides_of=(5,)))
    sim.step(1500)
    for _ in range(20):
        sim.step(5)
        assert np.abs(sim.state.angular_velocity).max() < 5e-4


def tipped(angle):
    """
    A cube on one edge, turned by an angle beyond its balance about y.
    """
    a = math.pi / 4 + angle
    height = 0.1 * (math.sin(a) + math.cos(a))
    q = (0.0, math.sin(a / 2), 0.0, math.cos(a / 2))
    return box('tipped', 0.2, (0, 0, height), q=q)


def test_a_body_moves_alike_whatever_rests_far_away():
    # two contact points beside manifolds of four, which the solver treats in one batch
    alone = Simulation(lean([ground(), tipped(0.1)]))
    others = [box(f'flat{i}', 0.2, (5.0 + i, 0, 0.1)) for i in range(3)]
    among = Simulation(lean([ground(), tipped(0.1), *others]))
    for _ in range(20):
        alone.step(10)
        among.step(10)
        assert np.array_equal(alone.state.position[1], among.state.position[1])
        assert np.array_equal(alone.state.orientation[1], among.state.orientation[1])
    assert alone.state.position[1, 2] == pytest.approx(0.1, abs=1e-3)  # it has fallen on a face


def test_each_interface_of_a_stack_carries_the_weight_above_it():
    sim = Simulation(lean(stack(10)))
    sim.step(2400)
    contacts = sim.contacts()
    for k in range(1, 11):
        below = [
            i for i, pair in enumerate(contacts.bodies.tolist()) if sorted(pair) == [k - 1, k]
        ]
        force = abs(contacts.impulse[below].sum(axis=0)[2]) / DT
        assert force == pytest.approx((11 - k) * G, rel=1e-6)
        assert np.all(contacts.gap[below] < 1e-12)  # the sink is taken out whole: they touch
        assert contacts.point[below][:, 2] == pytest.approx(0.2 * (k - 1), abs=1e-3)


def many_corners(kind, rng):
    """
    A box of 0.1 to 0.3 m, or a prism of three to eight corners.
    """
    if kind == 'boxes':
        return {'type': 'box', 'size': rng.uniform(0.1, 0.3, 3).tolist()}
    n, r, half = int(rng.integers(3, 9)), rng.uniform(0.08, 0.15), rng.uniform(0.05, 0.15)
    angle = 2.0 * np.pi * np.arange(n) / n
    ring = np.column_stack((r * np.cos(angle), r * np.sin(angle)))
    vertices = [[*corner, z] for corner in ring.tolist() for z in (-half, half)]
    return {'type': 'convex_hull', 'vertices': vertices}


def pile(kind, seed):
    """
    Sixty bodies over a pit, at random attitudes.
    """
    rng = np.random.default_rng(seed)
    bodies = [{'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}]
    for i, (x, y) in enumerate(((0.65, 0.0), (-0.65, 0.0), (0.0, 0.65), (0.0, -0.65))):
        size = [0.2, 1.5, 4.0] if x else [1.5, 0.2, 4.0]
        wall = {'type': 'box', 'size': size}
        bodies.append(
            {'name': f'wall{i}', 'shape': wall, 'fixed': True, 'initial': {'position': [x, y, 2]}}
        )
    for k in range(60):
        q = rng.normal(size=4)
        place = [0.36 * (k % 3 - 1), 0.36 * (k // 3 % 3 - 1), 0.25 + 0.36 * (k // 9)]
        initial = {'position': place, 'orientation': (q / np.linalg.norm(q)).tolist()}
        body = {'name': f'b{k}', 'shape': many_corners(kind, rng), 'initial': initial}
        bodies.append(body | {'mass': float(rng.uniform(0.5, 2.0))})
    return {
        'version': 1, 'name': 'pile', 'dt': 0.004, 'gravity': [0, 0, -G],
        'bodies': [body | {'friction': 0.5} for body in bodies], 'contact': {'mode': 'timestep'},
    }  # fmt: skip


@pytest.mark.parametrize(
    ('kind', 'rest', 'most'),
    [
        ('prisms', 1, 3),
        *(pytest.param(k, 3, 5, marks=pytest.mark.long) for k in ('boxes', 'prisms')),
    ],
)
def test_most_piles_of_what_touches_at_many_corners_come_to_rest(kind, rest, most):
    """
    Where the four that stand for them changed with every tremble, such piles kept moving, by 160
    to 3,900 um/s; half of the least of that is allowed. Of twenty seeds half of the piles of boxes
    and three in four of prisms move by less than 20, one in six by more than 80: so it is the
    middle one of five: of three, one in five drawings would fail. In the short form one of up to
    three rests: of those that kept moving, none.
    """
    speeds = []
    while sum(speed < 8e-5 for speed in speeds) < rest:  # what is left can change nothing more
        assert len(speeds) < most, speeds
        sim = Simulation(load_scene(pile(kind, 7 - len(speeds))))
        sim.step(1000)
        squares = []
        for _ in range(50):
            sim.step(5)
            squares.append(np.sum(sim.state.velocity**2, axis=1))
        speeds.append(math.sqrt(np.mean(squares)))


def test_the_sink_of_what_comes_to_rest_falls_with_the_square_of_the_substep():
    sunk = []
    for substeps in (2, 4, 8):
        falling = [box(f'b{i}', 0.2, (0, 0, 0.1 + 0.2 * i + 1e-4 * (i + 1))) for i in range(4)]
        sim = Simulation(lean([ground(), *falling], substeps=substeps))
        sim.step(2400)
        sunk.append(0.7 - sim.state.position[-1, 2])
        # BAND of `static_sink` of the sum over the interfaces of 2 W / omega^2, W / (4 omega^2)
        most = 1e-3 * (12 + 1) * G / (2 * math.pi * 0.25 * substeps / DT) ** 2
        assert sunk[-1] == pytest.approx(most, rel=1e-3)
    assert np.log2(np.array(sunk[:-1]) / np.array(sunk[1:])) == pytest.approx(2.0, abs=1e-3)


@pytest.mark.parametrize('slide', [0.0, 0.5])
@pytest.mark.parametrize('steep', [30, 45, 60, 70, 73, 77, 80, 82])
def test_a_ball_in_a_groove_presses_on_both_walls_by_its_weight(steep, slide):
    """
    On smooth walls at an angle a to the ground, at rest or sliding down along them, each bears
    m g / (2 cos a). What passes leave shrinks by cos^2 of the angle between the walls in each, so
    steep ones are found to 5e-5 after a second (82 degrees), in place of rounding.
    """
    a, smooth = math.radians(steep), {'friction': 0.0}
    walls = [
        Body(f'wall {i}', Plane((side * math.sin(a), 0.0, math.cos(a))), 0.0, fixed=True,
             material=Material(**smooth))
        for i, side in enumerate((1.0, -1.0))
    ]  # fmt: skip
    lies = ball('ball', 0.1, (0, 0, 0.1 / math.cos(a)), material=smooth)
    gravity = (0.0, G * math.sin(slide), -G * math.cos(slide))
    sim = Simulation(scene([*walls, lies], dt=0.004, gravity=gravity))
    sim.step(250)
    load = G * math.cos(slide) / (2.0 * math.cos(a)) * sim.dt
    for _ in range(50):
        sim.step(1)
        contacts = sim.contacts()
        pressed = (contacts.impulse * contacts.normal).sum(axis=1)
        assert pressed == pytest.approx([load, load], rel=1e-4)
        assert np.abs(contacts.gap).max() < 1e-6


@pytest.mark.parametrize('substeps', [4, 16])
def test_a_thousand_kilograms_stand_on_one(substeps):
    bodies = [ground(), box('light', 0.2, (0, 0, 0.1)), box('heavy', 0.2, (0, 0, 0.3), mass=1000)]
    sim = Simulation(lean(bodies, substeps=substeps))
    sim.step(4800)  # 20 s: the rocking of the light cube's corners has died out
    s = sim.state
    assert s.position[2, 2] == pytest.approx(0.3, abs=1e-9)  # its load is known from the start
    assert np.abs(s.position[1:, :2]).max() < 5e-3
    assert np.abs(s.velocity).max() < 5e-3  # 0.02 after 5 s


@pytest.mark.parametrize('seed', range(4))
def test_a_tumbling_box_without_bounce_gains_no_energy_at_any_tick(seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    tumbler = box(
        'b', (0.2, 0.3, 0.4), (0, 0, 1), q=q / np.linalg.norm(q), velocity=rng.normal(size=3),
        turn=6 * rng.normal(size=3),
    )  # fmt: skip
    sim = Simulation(scene([ground(), tumbler]))
    energy = [sim.energy()]
    for _ in range(900):
        sim.step()
        energy.append(sim.energy())
    # what a corner that sank in by g/(4 omega^2) = 1e-6 m, m g times that = 1e-5 J, gives back
    # when it is unloaded; while it tumbles it carries a few times its weight
    assert np.diff(energy).max() < 5e-5
    assert energy[-1] < 0.9 * energy[0]


def test_a_body_without_contact_moves_to_the_bit_as_without_a_contact_mode():
    flying = box('b', (0.1, 0.2, 0.3), (0, 0, 50), velocity=(1, 2, 3), turn=(5, 1, 2))
    touching = Simulation(lean([ground(), flying]))
    free = Simulation(
        lean([ground(), flying]).__class__(
            'free', round(DT * 1e9), (ground(), flying), gravity=(0.0, 0.0, -G)
        ),
        integrator_options={'substeps': 4},
    )
    touching.step(240)
    free.step(240)
    assert touching.state.values.tobytes() == free.state.values.tobytes()
