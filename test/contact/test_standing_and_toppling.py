# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What stands and what falls: a tall block on a slope, cards, a house of cards, arches; balls in a
heap.

Each threshold follows from the statics of the very bodies that are built. Soft contacts give way
by some g/omega^2, which moves a threshold by that over the width of a support: the finer step of
most tests makes this less than their bracket.
"""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from rigid_body_sim import rotation
from rigid_body_sim.physics.forces.elements.spring import Spring
from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import ConvexHull, Cylinder, Plane
from rigid_body_sim.physics.simulation import Simulation

from .touching import CORNERS, DT, G, ball, box, ground, lean, motion, scene

FINE = DT / 8.0  # [s]


def _on_a_slope(angle, friction, *, base=0.1, height=0.4):
    q = (0, math.sin(angle / 2), 0, math.cos(angle / 2))
    place = (height / 2 * math.sin(angle), 0, height / 2 * math.cos(angle))
    rough = {'friction': friction}
    block = box('b', (base, base, height), place, q=q, material=rough)
    sim = Simulation(scene([ground(slope=angle, material=rough), block], dt=FINE))
    sim.step(round(3.0 / FINE))
    q_now = sim.state.orientation[1]
    turned = 2 * math.degrees(math.acos(min(1.0, abs(q_now @ np.array(q)))))
    return turned, float(np.linalg.norm(sim.state.position[1] - place))


@pytest.mark.parametrize(('factor', 'topples'), [(0.999, False), (1.001, True)])
def test_a_tall_block_topples_exactly_beyond_its_base_over_height(factor, topples):
    turned, way = _on_a_slope(math.atan(factor * 0.25), 1.0)
    assert turned > 80 if topples else turned < 1e-3 and way < 1e-5


@pytest.mark.parametrize(('factor', 'topples'), [(0.999, False), (1.001, True)])
def test_a_sliding_block_topples_exactly_with_more_friction_than_base_over_height(factor, topples):
    slope = math.atan(1.1 * 0.25)
    turned, way = _on_a_slope(slope, factor * 0.25)
    if topples:
        assert turned > 80
    else:
        # nearly all its weight slides on the lower edge, which sinks deeper than the upper one
        assert turned < 1.0
        sliding = G * (math.sin(slope) - factor * 0.25 * math.cos(slope))
        assert way == pytest.approx(0.5 * sliding * 9.0, rel=1e-3)


def _foot_on_a_slope(under, yaw, friction, share, *, radius=0.05):
    """
    A cylinder whose load lies at a share of its radius from the middle of its foot, at 0.6 of the
    friction of a slope on which it stands by itself: how far it creeps, and how it turns at last.
    """
    slope = 0.6 * friction
    angle, half = math.atan(slope), share * radius / slope
    normal = np.array((math.sin(angle), 0.0, math.cos(angle)))
    rough = {'friction': friction}
    tilt = np.array((0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2)))
    spin = np.array((0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))
    floors = {
        'plane': ground(slope=angle, material=rough),
        'box': box('g', (1, 1, 0.2), -0.1 * normal, q=tilt, fixed=True, material=rough),
        'hull': Body(
            'g', ConvexHull((0.5, 0.5, 0.1) * CORNERS), 0.0, fixed=True,
            material=Material(**rough), initial=motion(-0.1 * normal, q=tilt),
        ),
        'cylinder': Body(
            'g', Cylinder(0.5, 0.2), 0.0, fixed=True, material=Material(**rough),
            initial=motion(-0.1 * normal, q=tilt),
        ),
    }  # fmt: skip
    can = Body(
        'can', Cylinder(radius, 2 * half), 1.0, material=Material(**rough),
        inertia=of_shape(Cylinder(radius, 2 * half), mass=1.0).inertia,
        initial=motion(half * normal, q=rotation.multiply(tilt, spin)),
    )  # fmt: skip
    sim = Simulation(scene([floors[under], can], dt=0.004))
    sim.step(500)
    moved = sim.state.position[1] - half * normal
    return float(np.linalg.norm(moved)), float(np.abs(sim.state.angular_velocity[1]).max())


@pytest.mark.parametrize(
    'under',
    ['plane', 'box', *(pytest.param(one, marks=pytest.mark.long) for one in ('hull', 'cylinder'))],
)
def test_a_cylinder_stands_on_a_slope_whatever_side_of_its_four_points_bears_it(under):
    """
    They span a square, of which a side is 0.71 of the radius from the middle. Where they stayed
    where they were, loads at 0.8 of it let it rock at 0.1 rad/s and creep by 2 mm in 2 s. While
    the points find to the load it moves by some h^2 g more than by its sink, 1e-5 m at most, and
    by up to 1e-3 m at the edge.
    """
    rng = np.random.default_rng(3)
    for share in (0.5, 0.68, 0.72, 0.76, 0.8, 0.9, 0.95):
        most, turns = (2e-5, 1e-7) if share < 0.9 else (1e-3, 1e-3)
        for friction, yaw in zip((0.3, 0.5, 0.8), rng.uniform(0, 2 * math.pi, 3), strict=True):
            way, turning = _foot_on_a_slope(under, yaw, friction, share)
            assert way < most and turning < turns, (share, friction, yaw, way, turning)


def test_a_light_cylinder_pressed_on_a_heavy_block_beside_its_axis_comes_to_rest():
    """
    A spring of 110 times its weight, 0.24 of the radius beside its axis, begins in balance. Where
    its points turned with each tilt, by 1e4 of it, what they bore turned with them: the tilt grew
    8-fold in each tick up to 1e-3, and the cylinder never stood still again.
    """
    at, stiffness, pull = (0.02, 0.013, 0.0), 317.0, 0.41 * 10.0 * G
    rough = {'friction': 0.6}
    can = Cylinder(0.1, 0.1)
    bodies = [
        ground(material=rough),
        box('block', (0.6, 0.6, 0.2), (0, 0, 0.1), mass=10.0, material=rough),
        Body(
            'can', can, 0.037, inertia=of_shape(can, mass=0.037).inertia,
            initial=motion((0, 0, 0.25)), material=Material(**rough),
        ),
    ]  # fmt: skip
    spring = Spring(
        'block', 'can', a_point=at, b_point=at, stiffness=stiffness,
        rest_length=0.15 - pull / stiffness,
    )  # fmt: skip
    sim = Simulation(lean(bodies, dt=0.004, forces=(spring,)))
    sim.step(500)
    assert np.abs(sim.state.angular_velocity).max() < 1e-9
    assert np.abs(sim.orientation_matrices()[2, :2, 2]).max() < 1e-9
    assert np.abs(sim.state.position[2] - (0, 0, 0.25)).max() < 1e-9


def _cut(direction, faces):
    """How far a point may go from the origin, in the plane, within all faces; n . x <= c."""
    return min(c / (n @ direction) for n, c in faces if n @ direction > 0.0)


def _faces(corners):
    """Sides of a convex polygon (n, 2) about the origin, n . x <= c, corners in a turn."""
    sides = np.roll(corners, -1, axis=0) - corners
    out = np.stack([sides[:, 1], -sides[:, 0]], axis=1)
    return [(n, n @ corner) for n, corner in zip(out, corners, strict=True)]


def _turned(corners, angle):
    """Points (n, 2), turned in their plane."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return corners @ np.array([[cosine, sine], [-sine, cosine]])


def _solid(kind, corners, high, material, at, q, *, fixed=False):
    """A box, or a hull, with a face of these corners and a height."""
    if kind == 'box':
        size = (*(2.0 * np.abs(corners).max(axis=0)), high)
        return box('', size, at, q=q, fixed=fixed, material=material)
    points = [(x, y, z) for x, y in corners for z in (-0.5 * high, 0.5 * high)]
    shape = ConvexHull(np.array(points))
    return Body(
        '', shape, 1.0, inertia=of_shape(shape, mass=1.0).inertia, fixed=fixed,
        material=Material(**material), initial=motion(at, q=q),
    )  # fmt: skip


def _rectangle(width, depth):
    return 0.5 * np.array([(width, depth), (-width, depth), (-width, -depth), (width, -depth)])


def _feet(case, rng):
    """Kinds and faces, corners (n, 2) about the middle, of a foot and of what it stands on."""
    count = int(rng.integers(5, 17))
    regular = 0.05 * np.array(
        [(math.cos(t), math.sin(t)) for t in 2.0 * math.pi * np.arange(count) / count]
    )
    one, other = (_rectangle(0.1, 0.1 * rng.uniform(0.6, 1.0)) for _ in range(2))
    return {
        'prism on a wide box': ('hull', regular, 'box', _rectangle(2.0, 2.0)),
        'prism on a like one': ('hull', regular, 'hull', 1.2 * regular),
        'box on a box': ('box', one, 'box', other),
        'hull on a hull': ('hull', one, 'hull', other),
    }[case]


@pytest.mark.parametrize('share', [0.8, 0.95])
@pytest.mark.parametrize(
    'case', ['prism on a wide box', 'prism on a like one', 'box on a box', 'hull on a hull']
)
def test_a_face_of_many_corners_stands_on_a_slope_wherever_its_load_is(case, share):
    """
    The load lies at a share of the way to the edge of what touches, at 0.6 of the friction: bodies
    that stand by themselves, turned at random about the normal. Where the four points that were
    held stayed the same, at 0.95 every fifth fell over, and others crept by millimetres. While the
    points find to the load it moves by some h^2 g, and slides a bit; afterwards it stands flat.
    """
    rng = np.random.default_rng(13)
    floors, feet, places = [], [], []
    for number in range(6):
        friction, yaw, yaw_below = rng.uniform(0.3, 0.8), *rng.uniform(0.0, 2.0 * math.pi, 2)
        kind, corners, kind_below, below = _feet(case, rng)
        slope = 0.6 * friction
        angle, material = math.atan(slope), {'friction': friction}
        edge = _cut(
            np.array((1.0, 0.0)),
            [*_faces(_turned(corners, yaw)), *_faces(_turned(below, yaw_below))],
        )
        half = share * edge / slope
        normal = np.array((math.sin(angle), 0.0, math.cos(angle)))
        tilt = np.array((0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2)))
        origin = np.array((0.0, 4.0 * number, 0.0))
        turns = (
            rotation.multiply(tilt, np.array((0.0, 0.0, math.sin(t / 2), math.cos(t / 2))))
            for t in (yaw, yaw_below)
        )
        places.append(origin + half * normal)
        feet.append(_solid(kind, corners, 2.0 * half, material, places[-1], next(turns)))
        at = origin - 0.05 * normal
        floors.append(_solid(kind_below, below, 0.1, material, at, next(turns), fixed=True))
    bodies = [replace(body, name=f'b{k}') for k, body in enumerate([*floors, *feet])]
    sim = Simulation(scene(bodies, dt=0.004))
    up = sim.orientation_matrices()[6:12, :, 2]
    sim.step(500)
    ways = np.linalg.norm(sim.state.position[6:12] - places, axis=1)
    tilts = np.linalg.norm(sim.orientation_matrices()[6:12, :, 2] - up, axis=1)
    assert np.all(ways < (2e-5 if share < 0.9 else 5e-4)), ways
    assert np.all(tilts < 1e-9), tilts
    assert np.abs(sim.state.angular_velocity).max() < 1e-3


def prism(name, corners, friction, *, depth=0.1):
    """
    A solid of 1000 kg/m^3 with these corners (n, 2) in the x-z plane; its place is theirs.
    """
    points = [(x, y, z) for x, z in corners for y in (-depth / 2, depth / 2)]
    mass = of_shape(ConvexHull(np.array(points)), density=1000.0)
    shape = ConvexHull(np.array(points) - mass.center_of_mass)
    return Body(
        name, shape, mass.mass, inertia=mass.inertia, initial=motion(mass.center_of_mass),
        material=Material(friction=friction),
    )  # fmt: skip


def card(angle, *, length=0.2, thickness=0.01, bevel=0.002):
    """
    A card that leans to the right, its foot at height 0, its bevelled top against the plane x = 0.
    """
    along = np.array((math.sin(angle), math.cos(angle)))
    across = np.array((math.cos(angle), -math.sin(angle)))
    foot = np.array((bevel - length * math.sin(angle), 0.0))
    top = foot + length * along
    return np.array(
        [
            foot,
            top - bevel / math.sin(angle) * along,
            top - bevel / math.cos(angle) * across,
            top - thickness * across,
            foot - thickness * across,
        ]
    )


def _needed(corners):
    """
    Friction a leaning card needs, mu >= c/h: its weight acts c from the foot, the thrust h above.
    """
    center = of_shape(
        ConvexHull(np.array([(x, y, z) for x, z in corners for y in (0.0, 1.0)])), mass=1.0
    ).center_of_mass
    return (center[0] - corners[0, 0]) / corners[2, 1]


def _fallen(bodies, *, seconds=2.0, dt=FINE):
    """Let it stand; return by how much the highest body has come down, and the run."""
    sim = Simulation(lean(bodies, dt=dt))
    highest = int(np.argmax(sim.state.position[:, 2]))
    before = sim.state.position[highest, 2]
    sim.step(round(seconds / dt))
    return before - sim.state.position[highest, 2], sim


def test_a_thin_card_needs_half_the_tangent_of_its_angle():
    corners = card(0.4, thickness=1e-6, bevel=1e-7)
    assert _needed(corners) == pytest.approx(math.tan(0.4) / 2, rel=1e-4)


@pytest.mark.parametrize('degrees', [20, 30])
@pytest.mark.parametrize(('factor', 'stands'), [(0.999, False), (1.001, True)])
def test_two_cards_lean_on_each_other_exactly_with_enough_friction(degrees, factor, stands):
    corners = card(math.radians(degrees))
    mu = factor * _needed(corners)
    mirrored = corners * (-1.0, 1.0)
    fell, sim = _fallen(
        [ground(material={'friction': mu}), prism('left', corners, mu),
         prism('right', mirrored, mu)]
    )  # fmt: skip
    assert fell < 2e-5 if stands else fell > 0.05
    if stands:
        assert np.abs(sim.state.velocity).max() < 1e-9


@pytest.mark.parametrize(('factor', 'stands'), [(0.999, False), (1.001, True)])
def test_a_card_leans_on_a_smooth_wall_exactly_with_enough_friction(factor, stands):
    length, thickness, angle = 0.2, 0.01, math.radians(30)
    # weight at L/2 sin - t/2 cos from the foot, thrust at L cos above it
    mu = factor * (math.tan(angle) - thickness / length) / 2
    along = np.array((math.sin(angle), 0.0, math.cos(angle)))
    across = np.array((math.cos(angle), 0.0, -math.sin(angle)))
    place = length / 2 * along - thickness / 2 * across - (length * math.sin(angle), 0.0, 0.0)
    leaning = box(
        'card', (thickness, 0.1, length), place, material={'friction': mu},
        q=(0, math.sin(angle / 2), 0, math.cos(angle / 2)),
    )  # fmt: skip
    wall = Body('wall', Plane((-1.0, 0.0, 0.0)), 0.0, fixed=True, material=Material(friction=0.0))
    sim = Simulation(scene([ground(material={'friction': mu}), leaning, wall], dt=FINE))
    sim.step(round(2.0 / FINE))
    fell = place[2] - sim.state.position[1, 2]
    assert fell < 1e-6 if stands else fell > 0.05


def arch(voussoirs, thickness, *, radius=1.0):
    """
    Corners of the blocks of a semicircular arch, from left to right; radius of its middle line.
    """
    inner, outer = radius - thickness / 2, radius + thickness / 2
    angles = np.linspace(math.pi, 0.0, voussoirs + 1)
    rays = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    return [
        np.array([inner * a, inner * b, outer * b, outer * a]) for a, b in itertools.pairwise(rays)
    ]


def _has_equilibrium(voussoirs, thickness, friction):
    """
    Tell whether forces at the corners of the joints, within their cones, can carry the arch.
    """
    blocks = arch(voussoirs, thickness)
    unknowns = 4 * (voussoirs + 1)  # at each joint: inner and outer corner, press and friction
    balance, loads = np.zeros((3 * voussoirs, unknowns)), np.zeros(3 * voussoirs)
    angles = np.linspace(math.pi, 0.0, voussoirs + 1)
    for i, corners in enumerate(blocks):
        solid = ConvexHull(np.array([(x, y, z) for x, z in corners for y in (0.0, 1.0)]))
        mass = of_shape(solid, density=1.0)
        loads[3 * i + 1] = mass.mass
        for joint, sign in ((i, 1.0), (i + 1, -1.0)):
            ray = np.array((math.cos(angles[joint]), math.sin(angles[joint])))
            for k, radius in enumerate((1.0 - thickness / 2, 1.0 + thickness / 2)):
                arm = radius * ray - mass.center_of_mass[[0, 2]]
                for axis, force in enumerate((np.array((ray[1], -ray[0])), ray)):
                    column = 4 * joint + 2 * k + axis
                    balance[3 * i : 3 * i + 2, column] = sign * force
                    balance[3 * i + 2, column] = sign * (arm[0] * force[1] - arm[1] * force[0])
    cones = np.zeros((unknowns, unknowns))
    for row in range(unknowns):
        press = row - row % 2
        cones[row, press], cones[row, press + 1] = -friction, 1.0 if row % 2 else -1.0
    found = linprog(
        np.zeros(unknowns), A_ub=cones, b_ub=np.zeros(unknowns), A_eq=balance, b_eq=loads,
        bounds=[(0.0, None), (None, None)] * (unknowns // 2),
    )  # fmt: skip
    return found.status == 0


def _least(holds, low, high):
    """Bisect for the least number for which something holds."""
    for _ in range(14):  # to 1e-4, of brackets of 2e-2
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def test_statics_give_the_least_thickness_and_friction_of_a_semicircular_arch():
    # known for joints everywhere: t/R = 0.1075 of the middle line (Milankovitch 1907), mu = 0.31
    for sign in (-1, 1):
        assert _has_equilibrium(101, 0.1075 + sign * 1e-4, 1.0) == (sign > 0)
        assert _has_equilibrium(41, 0.2, 0.31 + sign * 2e-3) == (sign > 0)


def _built(voussoirs, thickness, friction):
    blocks = arch(voussoirs, thickness)
    return [
        ground(material={'friction': friction}),
        *(prism(f'v{i}', c, friction, depth=0.3) for i, c in enumerate(blocks)),
    ]


@pytest.mark.parametrize('voussoirs', [7, pytest.param(9, marks=pytest.mark.long)])
def test_an_arch_stands_exactly_above_its_least_thickness(voussoirs):
    least = _least(lambda t: _has_equilibrium(voussoirs, t, 1.0), 0.05, 0.2)
    fell, _ = _fallen(_built(voussoirs, 0.98 * least, 1.0))
    assert fell > 0.3
    fell, sim = _fallen(_built(voussoirs, 1.02 * least, 1.0))
    assert fell < 1e-4
    assert np.abs(sim.state.velocity).max() < 1e-4


@pytest.mark.parametrize('seconds', [9, pytest.param(21, marks=pytest.mark.long)])
def test_an_arch_stands_exactly_above_its_least_friction(seconds):
    least = _least(lambda mu: _has_equilibrium(7, 0.2, mu), 0.1, 1.0)
    fell, _ = _fallen(_built(7, 0.2, 0.98 * least))
    assert fell > 0.1
    fell, sim = _fallen(_built(7, 0.2, 1.02 * least))
    assert fell < 1e-4
    before = sim.state.position
    # joints so near their limit slide 0.2 um more before all is at rest
    sim.step(round(seconds / FINE))
    assert np.abs(sim.state.position - before).max() < 1e-6
    assert np.abs(sim.state.velocity).max() < 1e-9


def test_a_house_of_cards_stands():
    mu, angle = 0.6, math.radians(20)
    left = card(angle)
    right = left * (-1.0, 1.0)
    half, top = 0.08, left[3, 1]
    bodies = [ground(material={'friction': mu})]
    for i, x in enumerate((-half, half)):
        bodies += [
            prism(f'left {i}', left + (x, 0.0), mu),
            prism(f'right {i}', right + (x, 0), mu),
        ]
    floor = np.array([(-0.12, 0.0), (0.12, 0.0), (0.12, 0.01), (-0.12, 0.01)])
    bodies.append(prism('floor', floor + (0.0, top), mu))
    bodies += [
        prism('left', left + (0, top + 0.01), mu),
        prism('right', right + (0, top + 0.01), mu),
    ]
    fell, sim = _fallen(bodies, seconds=5.0)
    assert fell < 1e-4
    assert np.abs(sim.state.velocity).max() < 1e-6


def test_the_overlap_in_a_heap_of_balls_falls_faster_than_the_step():
    """
    6 x 6 x 6 balls of 10 kg, 0.21 m apart, each up to 1 mm off its place, without restitution.
    """

    def overlap(dt, looks):
        rng = np.random.default_rng(0)
        places = 0.21 * np.array(np.unravel_index(np.arange(216), (6, 6, 6))).T + (0, 0, 0.11)
        places += rng.uniform(-1e-3, 1e-3, (216, 3))
        balls = [ball(f'b{i}', 0.1, place, mass=10.0) for i, place in enumerate(places)]
        sim = Simulation(scene([ground(), *balls], dt=dt))
        found = []
        for _ in range(looks):
            sim.step(round(0.1 / dt))
            gap = sim.contacts().gap
            found.append(-gap[gap < 0.0].mean())
        return np.array(found)

    coarse, fine = overlap(DT, 30), overlap(DT / 4, 20)
    assert coarse[15:20].max() < 2e-5
    # what carries loads is taken out, what impacts leave falls with the step
    # itself, and goes at the pace of `static_sink`: 4 in sum while it tumbles, and more
    assert coarse[:20].mean() > 4.0 * fine.mean()
    # at the end loads leave nothing; what an impact left is gone but for 1e-7 of what rolls on
    assert coarse[-1] < 2e-7


def cylinder(name, radius, length, position, tilt):
    """
    A solid cylinder of 1 kg that leans towards +x.
    """
    shape = Cylinder(radius, length)
    q = (0.0, math.sin(0.5 * tilt), 0.0, math.cos(0.5 * tilt))
    inertia = of_shape(shape, mass=1.0).inertia
    return Body(name, shape, 1.0, inertia=inertia, initial=motion(position, q=q))


def lowest(state, index, shape):
    """
    Height of the lowest point of a cylinder.
    """
    x, y = state.orientation[index, :2]
    rise = abs(1.0 - 2.0 * (x * x + y * y))
    across = math.sqrt(max(1.0 - rise * rise, 0.0))
    return state.position[index, 2] - 0.5 * shape.length * rise - shape.radius * across


@pytest.mark.parametrize('under', ['plane', 'box'])
def test_the_far_end_of_what_falls_over_is_foreseen(under):
    """
    Rods whose upper end falls by more than their diameter in a tick of 4 ms, and discs. What is
    left is the sink of an impact, some um; of discs, whose lowest point runs round the rim, more.
    """
    floor = ground() if under == 'plane' else box('floor', (60, 60, 1), (0, 0, -0.5), fixed=True)
    rods = [
        (0.0032, 1.81, 0.49), (0.0032, 1.81, 0.59), (0.0079, 1.58, 0.3), (0.0055, 1.1, 0.8),
        (0.0046, 1.14, 0.6), (0.01, 0.87, 1.06),
    ]  # fmt: skip
    discs = [(0.39, 0.0015, 0.3), (0.24, 0.0014, 0.2), (0.4, 0.0026, 0.5)]
    bodies = [
        cylinder(f'c{k}', radius, length, (0, 3 * k - 12, height), tilt)
        for k, (radius, length, tilt) in enumerate(rods + discs)
        for height in [0.5 * length * math.cos(tilt) + radius * math.sin(tilt) + 1e-3]
    ]
    sim = Simulation(lean([floor, *bodies], dt=0.004))
    depth = np.zeros(len(bodies))
    for _ in range(500):
        sim.step(1)
        at = [lowest(sim.state, k, body.shape) for k, body in enumerate(bodies, start=1)]
        depth = np.maximum(depth, np.negative(at))
    assert np.all(depth[: len(rods)] < 1e-5)
    assert np.all(depth[len(rods) :] < 5e-4)


def test_what_a_blow_on_one_side_throws_down_on_the_other_is_held():
    """
    A plate of 20 corners and 1.8 mm that falls on its rim, nearly flat: where all four points were
    on the side that comes down first, it went through the ground with the other one.
    """
    angles = 2.0 * math.pi * np.arange(20) / 20
    corners = [
        (0.38402588 * math.cos(angle), 0.38402588 * math.sin(angle), z)
        for angle in angles
        for z in (-0.00088122438, 0.00088122438)
    ]
    shape = ConvexHull(tuple(corners))
    axis = np.array([1.6187762, -1.2055581, 0.0])
    half = 0.5 * 0.12398902
    q = (*(math.sin(half) * axis / np.linalg.norm(axis)), math.cos(half))
    start = motion((0, 0, 0.48402588), q=q, turn=(-0.31347774, -0.66033161, -0.05387625))
    plate = Body('plate', shape, 1.0, inertia=of_shape(shape, mass=1.0).inertia, initial=start)
    sim = Simulation(scene([ground(material={'friction': 0.0}), plate], dt=0.004))
    depth = 0.0
    for _ in range(120):
        sim.step(1)
        x, y, z, w = sim.state.orientation[1]
        up = 2.0 * np.array([x * z - w * y, y * z + w * x, 0.5 - x * x - y * y])
        depth = max(depth, -np.min(np.array(corners) @ up) - sim.state.position[1, 2])
    assert depth < 1e-4
