# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Friction of a face on a face: the laws of a patch of uniform pressure.

A patch that turns brakes with mu N tau_0, tau_0 = <|r|> the mean distance from its middle: 2/3 R
of a disc, L/4 of a line. One that slides with v as it turns with w feels

    f = -mu N <(v + w x r)/|v + w x r|>,   tau = -mu N <r x (v + w x r)/|v + w x r|>

Thin bodies: the pressure of a thick one that brakes is not uniform.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Capsule, ConvexHull, Cylinder
from rigid_body_sim.physics.simulation import Simulation

from .touching import G, box, ground, lean, motion, scene

DT = 0.004  # [s]
MU = 0.3
ROUGH = {'friction': MU}
LYING = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # the axis of a cylinder along -y
THIN = 0.004  # [m]


def solid(shape, inertia, position, *, material=None, **of_motion):
    """
    A body of 1 kg with principal moments of inertia.
    """
    return Body(
        'body', shape, 1.0, inertia=np.diag(inertia), initial=motion(position, **of_motion),
        material=Material(**(material or ROUGH)),
    )  # fmt: skip


def disc(radius, position=None, *, thick=THIN, **others):
    """
    A disc on the ground.
    """
    across = (3 * radius**2 + thick**2) / 12
    position = (0, 0, thick / 2) if position is None else position
    return solid(
        Cylinder(radius, thick), (across, across, radius**2 / 2), position, **others
    )  # fmt: skip


def plate(length, width, **others):
    """
    A thin plate on the ground.
    """
    return box(
        'body', (length, width, THIN), (0, 0, THIN / 2), **{'material': ROUGH, **others}
    )  # fmt: skip


def points_of_a_disc(radius, count=30):
    """
    Points (n, 2) that stand for equal parts of a disc.
    """
    r = radius * np.sqrt((np.arange(count) + 0.5) / count)
    angle = 2 * np.pi * (np.arange(4 * count) + 0.5) / (4 * count)
    return np.stack((np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))), -1).reshape(-1, 2)


def points_of_a_plate(length, width, count=40):
    """
    Points (n, 2) that stand for equal parts of a rectangle.
    """
    x = (np.arange(count) + 0.5) / count - 0.5
    return np.stack(np.meshgrid(length * x, width * x), -1).reshape(-1, 2)


def _polygon(count, radius):
    angle = 2 * np.pi * np.arange(count) / count + 0.1
    corners = radius * np.stack((np.cos(angle), np.sin(angle)), 1)
    return ConvexHull(np.array([[x, y, z] for z in (-0.02, 0.02) for x, y in corners]))


def _polygon_inertia(count, radius):
    about = radius**2 / 6 * (2 + math.cos(2 * math.pi / count))
    return about / 2 + 0.04**2 / 12, about / 2 + 0.04**2 / 12, about


R, L = 0.1, 0.2
FLAT = {
    # body, tau_0, tolerance: of the fit of tau_0 (`patch_friction`), and of the four points that
    # stand for a face of more corners
    'disc': (disc(R, turn=(0, 0, 20)), 2 * R / 3, 1e-4),
    'square': (plate(0.2, 0.2, turn=(0, 0, 20)), 0.0765196, 1e-4),
    'two to one': (plate(0.2, 0.1, turn=(0, 0, 20)), 0.0593233, 6e-4),
    'four to one': (plate(0.4, 0.1, turn=(0, 0, 20)), 0.1060779, 6e-4),
    'lying cylinder': (
        solid(
            Cylinder(0.05, L), ((3 * 0.05**2 + L**2) / 12,) * 2 + (0.05**2 / 2,), (0, 0, 0.05),
            q=LYING, turn=(0, 0, 20),
        ),
        L / 4,
        1e-4,
    ),
    'lying capsule': (
        solid(Capsule(0.05, L), (0.004, 0.004, 0.001), (0, 0, 0.05), q=LYING, turn=(0, 0, 20)),
        L / 4,
        1e-4,
    ),
    'hull of four corners': (
        solid(_polygon(4, R), _polygon_inertia(4, R), (0, 0, 0.02), turn=(0, 0, 20)),
        0.0765196 / math.sqrt(2),
        1e-4,
    ),
    'hull of three corners': (
        solid(_polygon(3, R), _polygon_inertia(3, R), (0, 0, 0.02), turn=(0, 0, 20)),
        0.0460056,
        2e-2,
    ),
    'hull of sixteen corners': (
        solid(_polygon(16, R), _polygon_inertia(16, R), (0, 0, 0.02), turn=(0, 0, 20)),
        0.0658144,
        2e-2,
    ),
}  # fmt: skip


@pytest.mark.parametrize('name', FLAT)
def test_what_spins_on_a_face_is_braked_by_the_law_of_the_uniform_patch(name):
    body, radius, tolerance = FLAT[name]
    sim = Simulation(scene([ground(material=ROUGH), body], dt=DT))
    inertia = body.inertia[1, 1] if 'lying' in name else body.inertia[2, 2]
    braking = MU * G * radius / inertia
    lasts = 20 / braking
    sim.step(round(0.6 * lasts / DT))
    lost = 20 - sim.state.angular_velocity[1, 2]
    # the first substep is a cold start
    assert lost == pytest.approx(braking * sim.time, rel=tolerance + 1e-4)
    # what lies on a line comes to rest within some ticks: a visit takes a third of its last turn
    sim.step(math.ceil(0.4 * lasts * (1 + tolerance) / DT) + 8)
    assert abs(sim.state.angular_velocity[1, 2]) < 1e-6


def hull_of_a_face(corners):
    """
    A prism of 1 kg over a convex polygon (n, 2), its middle at the origin; and the mean distance
    of the polygon from there, by a fine grid of points.
    """
    x, y = np.asarray(corners).T
    next_x, next_y = np.roll(x, -1), np.roll(y, -1)
    doubled = x * next_y - next_x * y
    middle = np.array([(x + next_x) @ doubled, (y + next_y) @ doubled]) / (3 * doubled.sum())
    corners = np.asarray(corners) - middle
    low, high = corners.min(axis=0), corners.max(axis=0)
    grid = np.stack(np.meshgrid(*(np.linspace(*ends, 801)[:-1] for ends in zip(low, high))), -1)
    points = grid.reshape(-1, 2) + (high - low) / 1600
    edges = np.roll(corners, -1, axis=0) - corners
    for corner, edge in zip(corners, edges):
        away = points - corner
        points = points[edge[0] * away[:, 1] - edge[1] * away[:, 0] >= 0]
    square_x, square_y = (points**2).mean(axis=0)
    inertia = (square_y + THIN**2 / 12, square_x + THIN**2 / 12, square_x + square_y)
    shape = ConvexHull(np.array([[*c, z] for z in (-THIN / 2, THIN / 2) for c in corners]))
    body = solid(shape, inertia, (0, 0, THIN / 2), turn=(0, 0, 20))
    return body, np.linalg.norm(points, axis=1).mean()


FACES = {
    'five corners': [(0.09, 0.0), (0.02, 0.08), (-0.1, 0.05), (-0.06, -0.06), (0.03, -0.07)],
    'six corners': [
        (0.12, 0.01), (0.08, 0.05), (-0.03, 0.06), (-0.11, 0.0), (-0.07, -0.04), (0.06, -0.05),
    ],
    'nine corners': [
        (0.1, 0.02), (0.07, 0.06), (0.03, 0.08), (-0.02, 0.085), (-0.06, 0.06), (-0.1, 0.0),
        (-0.05, -0.05), (0.02, -0.06), (0.08, -0.03),
    ],
}  # fmt: skip


def law_of_braking(sim, body, radius, share):
    """
    What a body of the scene has lost of 20 rad/s over a share of its time, over the law.
    """
    braking = MU * G * radius / body.inertia[2, 2]
    sim.step(round(share * 20 / braking / DT))
    return (20 - sim.state.angular_velocity[-1, 2]) / (braking * sim.time)


@pytest.mark.parametrize(
    'on_plane',
    [True, pytest.param(False, marks=pytest.mark.long)],
    ids=['on a plane', 'on a box'],
)
@pytest.mark.parametrize('name', FACES)
def test_a_face_of_many_corners_is_braked_by_the_law_of_its_polygon(name, on_plane):
    # its four points stand for a face that is none of a rectangle or a disc
    body, radius = hull_of_a_face(FACES[name])
    floor = ground(material=ROUGH)
    if not on_plane:
        floor = box('floor', (2, 2, 0.1), (0, 0, -0.05), fixed=True, material=ROUGH)
    sim = Simulation(lean([floor, body], dt=DT))
    # four points carry the pressure of the polygon, but as they may: a tremble of the body leaves
    # one of them out for a tick
    assert law_of_braking(sim, body, radius, 0.6) == pytest.approx(1.0, abs=1e-2)


def tiled_floor(joint):
    """Four tiles that meet at a joint."""
    return [
        box(
            f'tile{i}{j}', (1, 1, 0.1), (joint[0] + i - 0.5, joint[1] + j - 0.5, -0.05),
            fixed=True, material=ROUGH,
        )
        for i in (0, 1)
        for j in (0, 1)
    ]  # fmt: skip


JOINTS = pytest.mark.parametrize('joint', [(0.0, 0.0), (0.05, 0.0), (0.07, -0.05)])


@pytest.mark.parametrize(
    ('radius', 'offset'), [(0.06, 0), (R, 0), (0.1001, 0), (0.21, 0), (0.21, 0.4), (1.0, 0.9)]
)
def test_a_disc_is_braked_by_its_law_on_the_round_end_of_a_cylinder(radius, offset):
    """
    The smaller one is the face, however they are turned; as prisms they missed 1.3e-2.
    """
    below = Body(
        'below', Cylinder(radius, 0.1), 0.0, initial=motion((0, 0, -0.05)), fixed=True,
        material=Material(**ROUGH),
    )  # fmt: skip
    away = offset * abs(radius - R)
    face = min(R, radius)
    sim = Simulation(scene([below, disc(R, (away, 0, THIN / 2), turn=(0, 0, 20))], dt=DT))
    sim.step(25)
    spun = 20.0 - sim.state.angular_velocity[1, 2]
    braked = MU * G * 2 / 3 * face / (R**2 / 2) * 25 * DT
    # one tick of 25, in which other corners are chosen, brakes 1.4e-2 less
    assert spun == pytest.approx(braked, rel=1e-3)


@JOINTS
def test_what_is_put_down_on_tiles_is_braked_by_the_law_from_its_first_tick(joint):
    drills = Simulation(lean([*tiled_floor(joint), plate(0.2, 0.2, turn=(0, 0, 20))], dt=DT))
    drills.step()
    braking = MU * G * 0.0765196 / (0.2**2 / 6)
    # what its four corners and the joint leave of the uniform patch; without a first load 0.6
    assert 20 - drills.state.angular_velocity[-1, 2] == pytest.approx(braking * DT, rel=5e-3)
    slides = Simulation(lean([*tiled_floor(joint), plate(0.2, 0.2, velocity=(1, 0, 0))], dt=DT))
    slides.step()
    assert 1 - slides.state.velocity[-1, 0] == pytest.approx(MU * G * DT, rel=1e-3)


@JOINTS
def test_a_floor_of_tiles_brakes_what_drills_on_it_as_one_surface(joint):
    body = plate(0.2, 0.2, turn=(0, 0, 20))
    sim = Simulation(lean([*tiled_floor(joint), body], dt=DT))
    assert law_of_braking(sim, body, 0.0765196, 0.6) == pytest.approx(1.0, abs=1e-2)
    carried = np.zeros(4)
    touching = sim.contacts()
    np.add.at(carried, touching.bodies.min(axis=1), np.abs(touching.impulse[:, 2]) / DT)
    assert carried.sum() == pytest.approx(G, rel=1e-4)


def uniform(points, velocity, spin, inertia, yaw):
    """
    Slide and turn of 1 kg on a patch until it stops, by the midpoint rule: time, velocity, spin,
    place, row after row.
    """
    velocity, place, time, rows = np.array(velocity), np.zeros(2), 0.0, []
    reach = np.linalg.norm(points, axis=1).max()
    start = np.linalg.norm(velocity) + abs(spin) * reach
    h = start / (MU * G) / 800

    def acceleration(velocity, spin, yaw):
        c, s = math.cos(yaw), math.sin(yaw)
        arms = points @ np.array([[c, s], [-s, c]])
        slip = velocity + spin * np.stack((-arms[:, 1], arms[:, 0]), 1)
        slip /= np.maximum(np.linalg.norm(slip, axis=1), 1e-9)[:, None]
        turning = np.mean(arms[:, 0] * slip[:, 1] - arms[:, 1] * slip[:, 0])
        return -MU * G * slip.mean(axis=0), -MU * G * turning / inertia

    while np.linalg.norm(velocity) + abs(spin) * reach > 0.005 * start:
        rows.append((time, *velocity, spin, *place))
        a, alpha = acceleration(velocity, spin, yaw)
        middle, turn = velocity + 0.5 * h * a, spin + 0.5 * h * alpha
        a, alpha = acceleration(middle, turn, yaw + 0.5 * h * spin)
        place, yaw, time = place + h * middle, yaw + h * turn, time + h
        velocity, spin = velocity + h * a, spin + h * alpha
    return np.array([*rows, (time, *velocity, spin, *place)])


# of the limit surface of a disc 6e-4, of a square 6e-3 (and the direction of the slip 0.02); of
# rectangles it is the mean of all directions
WITHIN = {(R,): 1e-2, (0.2, 0.2): 1e-2, (0.2, 0.1): 1e-1, (0.4, 0.1): 1e-1}


@pytest.mark.parametrize(
    ('size', 'within', 'share'),
    [
        pytest.param(size, within, share, marks=() if (i + j) % 2 == 0 else pytest.mark.long)
        for i, (size, within) in enumerate(WITHIN.items())
        for j, share in enumerate((0.5, 2.0))
    ],
)
def test_what_slides_and_turns_on_a_face_stops_by_the_law_of_the_uniform_patch(
    size, within, share
):
    rng = np.random.default_rng(round(10 * share) + len(size))
    heading, yaw = rng.uniform(0, 6, 2)
    speed = 0.6
    velocity = (speed * math.cos(heading), speed * math.sin(heading))
    reach = R if len(size) == 1 else 0.5 * math.hypot(*size)
    start = {
        'velocity': (*velocity, 0), 'turn': (0, 0, share * speed / reach),
        'q': (0, 0, math.sin(yaw / 2), math.cos(yaw / 2)),
    }  # fmt: skip
    body = disc(R, **start) if len(size) == 1 else plate(*size, **start)
    points = points_of_a_disc(R) if len(size) == 1 else points_of_a_plate(*size)
    law = uniform(points, velocity, share * speed / reach, body.inertia[2, 2], yaw)
    sim = Simulation(scene([ground(material=ROUGH), body], dt=DT))
    sim.step(round(0.5 * law[-1, 0] / DT))
    state = sim.state
    wanted = [np.interp(sim.time, law[:, 0], law[:, k]) for k in range(1, 6)]
    if within < 0.1:
        spin = share * speed / reach
        assert np.linalg.norm(state.velocity[1, :2] - wanted[:2]) < 1.5 * within * speed
        assert abs(state.angular_velocity[1, 2] - wanted[2]) < 1.5 * within * spin
    lasts = law[-1, 0] / 0.995
    while np.abs(sim.state.velocity[1]).max() > 2e-3 and sim.time < 2 * lasts:
        sim.step()
    assert sim.time == pytest.approx(lasts, rel=within, abs=2 * DT)


def _on_a_ramp(size, angle, yaw):
    tilt, turn = angle / 2, yaw / 2
    # first the yaw about z, then the tilt about y
    q = (
        math.sin(tilt) * math.sin(turn), math.sin(tilt) * math.cos(turn),
        math.cos(tilt) * math.sin(turn), math.cos(tilt) * math.cos(turn),
    )  # fmt: skip
    place = (size[2] / 2 * math.sin(angle), 0, size[2] / 2 * math.cos(angle))
    return Simulation(scene([ground(slope=angle), box('b', size, place, q=q)], dt=DT))


BLOCKS = [((0.2, 0.2, 0.2), 0.0), ((0.2, 0.3, 0.15), 0.7), ((0.4, 0.1, 0.1), 1.1)]


@pytest.mark.parametrize(('size', 'yaw'), BLOCKS)
@pytest.mark.parametrize('share', [0.9, 0.985, 0.999])
def test_a_block_below_the_limit_of_friction_does_not_creep(size, yaw, share):
    sim = _on_a_ramp(size, math.atan(share * 0.5), yaw)
    sim.step(50)
    before = sim.state.position[1].copy()
    sim.step(1250)
    # what is left of settling
    assert np.linalg.norm(sim.state.position[1] - before) < 1e-6
    assert np.abs(sim.state.velocity[1]).max() < 1e-12


@pytest.mark.parametrize(('size', 'yaw'), BLOCKS)
def test_a_block_above_the_limit_of_friction_has_slipped_none_when_it_starts(size, yaw):
    angle = math.atan(1.01 * 0.5)
    sim = _on_a_ramp(size, angle, yaw)
    start = sim.state.position[1].copy()
    sim.step(1250)
    way = np.linalg.norm(sim.state.position[1] - start)
    pull = G * (math.sin(angle) - 0.5 * math.cos(angle))
    # friction acts from the first substep: a slip of 1e-4 m/s at the start is 8e-4
    assert way == pytest.approx(0.5 * pull * sim.time**2, rel=1e-3)


@pytest.mark.parametrize('e', [0.0, 0.5])
@pytest.mark.parametrize('shape', ['disc', 'cube'])
def test_a_face_that_strikes_while_it_spins_loses_mu_times_the_impulse_at_its_radius(shape, e):
    """
    I (w - w') = mu J tau_0 for the whole impulse J = m (v' - v), of impact and bounce.
    """
    material = {'friction': MU, 'restitution': e}
    start = {'turn': (0, 0, 60), 'material': material}
    if shape == 'disc':
        body, inertia, radius = disc(R, (0, 0, 0.21), thick=0.02, **start), R**2 / 2, 2 * R / 3
    else:
        body, inertia, radius = box('b', 0.2, (0, 0, 0.3), **start), 0.2**2 / 6, 0.0765196
    sim = Simulation(scene([ground(material=material), body], dt=DT))
    sim.step(round(math.sqrt(0.4 / G) / DT) + 3)
    impulse = sim.state.velocity[1, 2] + G * sim.time
    lost = 60 - sim.state.angular_velocity[1, 2]
    # a blow is solved to `substeps.STRUCK`: what is left of it comes without friction of its own
    assert lost == pytest.approx(MU * impulse * radius / inertia, rel=1e-2)


@pytest.mark.parametrize('e', [0.3, 0.7, 1.0])
def test_a_box_that_lands_a_hair_off_flat_slides_and_turns_on_as_one_that_lands_flat(e):
    """
    By what the hair, of a millionth of a radian, turns of its speeds of up to 20: not by its
    friction, which is that of all that presses in the bounce.
    """
    hair = 1e-6
    rng = np.random.default_rng(3)
    for _ in range(8):
        friction, speed, spin = rng.choice([0.2, 0.6]), rng.uniform(0, 3), rng.uniform(-20, 20)
        height, ends = rng.uniform(0.002, 0.01), []
        material = {'friction': friction, 'restitution': e}
        for tilt in (0.0, hair):
            lands = box(
                'box', (0.2, 0.3, 0.1), (0, 0, 0.05 + height), q=(0.3 * tilt, 0.4 * tilt, 0, 1),
                velocity=(speed, 0.3 * speed, -1), turn=(0, 0, spin), material=material,
            )  # fmt: skip
            sim = Simulation(scene([ground(material=material), lands], dt=DT))
            sim.step(int(height / DT) + 2)
            ends.append((sim.state.velocity[1], sim.state.angular_velocity[1]))
        assert np.abs(np.array(ends[1]) - ends[0]).max() < 15 * hair
