# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ground of triangles: what moves on a flat part moves as on a plane, whatever the triangles are;
what comes to an edge, a wall, or at any speed, meets what is there and nothing else.

A scene has one shape, so that all cases of it share a kernel.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.height_field import height_field
from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.shapes import (
    ConvexHull,
    Cylinder,
    Part,
    Sphere,
    Surface,
    Union,
)

G = 9.81  # [m/s^2]
DT = 0.004  # [s]
SPEED_KEPT = 1e-3  # [-] demanded of flat parts; observed 6e-5 and less
HEIGHT = 1e-5  # [m] demanded of flat parts; observed 2e-6: the sink of a resting body is 1e-6 m
SHAPES = {  # and the height of its centre
    'ball': ('{type: sphere, radius: 0.1}', 0.1),
    'box': ('{type: box, size: [0.2, 0.2, 0.2]}', 0.1),
    'disc': ('{type: cylinder, radius: 0.1, length: 0.02}', 0.01),
}
SCENE = """
version: 1
name: on_ground
dt: 0.004
gravity: [0, 0, {gravity}]
contact: {{mode: timestep}}
bodies:
  - {{name: ground, fixed: true, friction: {friction}, shape: {ground}}}
  - {{name: body, mass: 1.0, friction: {friction}, shape: {shape}, initial: {initial}}}
"""
UPRIGHT = np.eye(3)
FLAT = '{type: heightfield, spacing: 1.0, heights: [[0, 0], [0, 0]]}'


def on(surface, shape, position, velocity, *, turn=(0, 0, 0, 1), spin=(0, 0, 0), **more):
    """
    Start a body over a surface.
    """
    initial = ', '.join(
        f'{key}: {[float(x) for x in value]}'
        for key, value in {
            'position': position,
            'velocity': velocity,
            'orientation': turn,
            'angular_velocity': spin,
        }.items()
    )
    text = SCENE.format(
        gravity=more.get('gravity', -G),
        friction=more.get('friction', 0.0),
        ground=FLAT,
        shape=SHAPES[shape][0],
        initial=f'{{{initial}}}',
    )
    scene = load_scene(text.encode())
    ground, body = scene.bodies
    return Simulation(
        dataclasses.replace(scene, bodies=(dataclasses.replace(ground, shape=surface), body))
    )


def states(simulation, ticks, every=4):
    """
    Return positions and velocities of the body every few ticks.
    """
    found = []
    for _ in range(ticks // every):
        simulation.step(every)
        state = simulation.state
        found.append((state.position[-1].copy(), state.velocity[-1].copy()))
    return tuple(np.array(one) for one in zip(*found, strict=True))


def triangulated_plane(count, *, seed, turn=UPRIGHT, shift=(0.0, 0.0, 0.0), single=False):
    """
    A square of 12 m in random triangles, turned and shifted; single: in single precision.
    """
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(seed)
    corners = [[-6.0, -6.0], [6.0, -6.0], [6.0, 6.0], [-6.0, 6.0]]
    points = np.concatenate((rng.uniform(-6.0, 6.0, (count, 2)), corners))
    faces = Delaunay(points).simplices
    first, second = (points[faces[:, k]] - points[faces[:, 0]] for k in (1, 2))
    flipped = first[:, 0] * second[:, 1] < first[:, 1] * second[:, 0]
    faces[flipped] = faces[flipped, ::-1]
    vertices = np.column_stack((points, np.zeros(len(points)))) @ turn.T + shift
    if single:
        vertices = vertices.astype(np.float32).astype(np.float64)
    return Surface(vertices, faces)


def tiled_floor(*, yaw):
    """
    Closed boxes of 0.3 m side by side in one mesh, whose walls stand against each other.
    """
    vertices, faces = [], []
    quads = (
        (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5),
    )  # fmt: skip
    cosine, sine = np.cos(yaw), np.sin(yaw)
    for i in range(-8, 9):
        for j in range(-3, 4):
            begin = len(vertices)
            for corner in range(8):
                x = 0.3 * i + (0.15 if corner & 1 else -0.15)
                y = 0.3 * j + (0.15 if corner & 2 else -0.15)
                z = 0.0 if corner & 4 else -0.1
                vertices.append((cosine * x - sine * y, sine * x + cosine * y, z))
            for a, b, c, d in quads:
                faces += [(begin + a, begin + b, begin + c), (begin + a, begin + c, begin + d)]
    return Surface(np.array(vertices), np.array(faces))


def grid(height, *, half, spacing):
    """
    A height field of a function of x and y over a square around the origin.
    """
    x = np.arange(-half, half + 0.5 * spacing, spacing)
    heights = np.broadcast_to(height(*np.meshgrid(x, x)), (len(x), len(x)))
    return height_field(heights, spacing=spacing, origin=(x[0], x[0], 0.0))


def about_y(angle):
    """
    Rotation matrix and quaternion of a turn about y [rad].
    """
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return turn, (0.0, np.sin(0.5 * angle), 0.0, np.cos(0.5 * angle))


@pytest.mark.parametrize('shape', SHAPES)
def test_a_flat_mesh_in_random_triangles_is_a_plane(shape):
    height = SHAPES[shape][1]
    for seed, yaw, speed in ((0, 0.0, 0.1), (1, 0.7, 1.0), (2, 2.1, 10.0)):
        cosine, sine = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        surface = triangulated_plane(3000, seed=seed, turn=turn, single=True)
        body = on(surface, shape, (-3.0, 0.123, height), (speed, 0.0, 0.0))
        position, velocity = states(body, min(300, int(6.0 / speed / DT)))
        assert np.abs(velocity - (speed, 0.0, 0.0)).max() < SPEED_KEPT * speed
        assert np.abs(position[:, 2] - height).max() < HEIGHT


@pytest.mark.parametrize('shape', SHAPES)
def test_an_inclined_mesh_is_an_inclined_plane(shape):
    height, angle = SHAPES[shape][1], 0.35
    turn, quaternion = about_y(angle)
    shift = np.array((100.0, 50.0, -20.0))  # where single precision leaves 1e-5 m
    surface = triangulated_plane(3000, seed=3, turn=turn, shift=shift, single=True)
    down, out = turn @ (1.0, 0.0, 0.0), turn @ (0.0, 0.0, 1.0)
    body = on(surface, shape, shift - 3.0 * down + height * out, 0.3 * down, turn=quaternion)
    position, velocity = states(body, 200)
    times = 4 * DT * np.arange(1, len(position) + 1)
    law = (0.3 + G * np.sin(angle) * times)[:, None] * down
    assert np.abs(velocity - law).max() < SPEED_KEPT * np.abs(law).max()
    assert np.abs((position - shift) @ out - height).max() < HEIGHT


def foot_of(kind, radius, half):
    """
    A cylinder, or a prism of seven corners from the x axis on, with a foot of a radius.
    """
    if kind == 'cylinder':
        return Cylinder(radius, 2.0 * half)
    looks = 2.0 * np.pi * np.arange(7) / 7
    ring = radius * np.stack((np.cos(looks), np.sin(looks)), axis=1)
    return ConvexHull(np.array([(*xy, z) for xy in ring for z in (-half, half)]))


@pytest.mark.parametrize('kind', ['cylinder', pytest.param('prism', marks=pytest.mark.long)])
def test_what_stands_on_a_slope_of_triangles_stands_wherever_its_load_is(kind):
    """
    As on a plane: at 0.6 of the friction, its load at a share of the way to the edge of its foot,
    it moves by its sink and some h^2 g while its four points find to the load, 1e-5 m at most.
    Where they stayed the same it rocked at 0.03 to 0.2 rad/s, and crept by 0.03 of its radius.
    """
    rng, radius, friction = np.random.default_rng(3), 0.05, 0.5
    surface = triangulated_plane(300, seed=4)
    angle = np.arctan(0.6 * friction)
    for share in (0.5, 0.68, 0.72, 0.76, 0.8, 0.85):
        yaw, down = rng.uniform(0.0, 2.0 * np.pi, 2)
        edge = radius
        if kind == 'prism':
            way = (down - yaw + np.pi / 7) % (2.0 * np.pi / 7) - np.pi / 7
            edge = radius * np.cos(np.pi / 7) / np.cos(np.pi / 7 - abs(way))
        half = share * edge / np.tan(angle)
        shape = foot_of(kind, radius, half)
        body = on(
            surface, 'disc', (0.3, 0.2, half), (0, 0, 0), friction=friction,
            turn=(0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)),
        )  # fmt: skip
        pull = np.sin(angle) * np.array((np.cos(down), np.sin(down), 0.0))
        scene = dataclasses.replace(body.scene, gravity=tuple(G * (pull - (0, 0, np.cos(angle)))))
        ground, foot = scene.bodies
        inertia = of_shape(shape, mass=1.0).inertia
        foot = dataclasses.replace(foot, shape=shape, inertia=inertia)
        body = Simulation(dataclasses.replace(scene, bodies=(ground, foot)))
        body.step(500)
        assert np.abs(body.state.position[-1] - (0.3, 0.2, half)).max() < 2e-5, share
        assert np.abs(body.state.angular_velocity[-1]).max() < 1e-7, share


@pytest.mark.parametrize('shape', SHAPES)
def test_walls_inside_a_flush_mesh_stop_nothing(shape):
    height = SHAPES[shape][1]
    for yaw, speed in ((0.0, 0.3), (0.3, 1.0), (0.3, 5.0)):
        body = on(tiled_floor(yaw=yaw), shape, (-1.5, 0.043, height), (speed, 0.0, 0.0))
        position, velocity = states(body, min(250, int(2.6 / speed / DT)))
        assert np.abs(velocity - (speed, 0.0, 0.0)).max() < SPEED_KEPT * speed
        assert np.abs(position[:, 2] - height).max() < HEIGHT


def test_a_ball_swings_in_a_bowl_like_a_pendulum():
    bowl = grid(
        lambda x, y: 1.0 - np.sqrt(1.0 - np.minimum(x * x + y * y, 0.5)), half=0.4, spacing=0.01
    )
    length, start = 0.9, 0.2  # [m], [rad] of the centre about that of the bowl
    ball = on(bowl, 'ball', (length * np.sin(start), 0.0, 1.0 - length * np.cos(start)), (0, 0, 0))
    position, velocity = states(ball, 1000, every=1)
    x, times = position[:, 0], DT * np.arange(1, 1001)
    passes = np.flatnonzero(x[:-1] * x[1:] < 0.0)
    zeros = times[passes] + DT * x[passes] / (x[passes] - x[passes + 1])
    period = 2.0 * np.pi * np.sqrt(length / G) * (1.0 + start * start / 16.0)
    # each facet is a blow that takes (v theta)^2/2 of 0.01 rad: the swing, not the period
    assert 2.0 * np.diff(zeros).mean() == pytest.approx(period, rel=2e-3)
    energy = 0.5 * np.sum(velocity * velocity, axis=1) + G * position[:, 2]
    # the load of a facet is not known when the ball comes to it: the sink of its weight, 1e-6 m
    assert np.diff(energy).max() < 1.0 * G * 1e-6


@pytest.mark.parametrize('shape', ['ball', 'box'])
def test_a_wall_in_a_height_field_stops_what_runs_into_it(shape):
    wall = grid(lambda x, y: np.where(x > 0.5, 1.0, 0.0), half=1.5, spacing=0.05)
    height = SHAPES[shape][1]
    body = on(wall, shape, (-1.0, 0.01, height), (1.0, 0.0, 0.0))
    position, velocity = states(body, 500)
    assert position[:, 0].max() < 0.55
    assert velocity[-1, 0] < 0.1 and position[:, 2].min() > height - HEIGHT


@pytest.mark.parametrize(
    'speeds',
    [(30.0, 500.0), pytest.param((5.0, 30.0, 100.0, 300.0, 500.0), marks=pytest.mark.long)],
    ids=['two', 'five'],
)
@pytest.mark.parametrize('shape', SHAPES)
def test_nothing_falls_through_at_any_speed(shape, speeds):
    rng = np.random.default_rng(7)
    rough = grid(
        lambda x, y: 0.3 * np.sin(3.0 * x) * np.cos(2.0 * y) + 0.05 * rng.normal(size=x.shape),
        half=4.0, spacing=0.1,
    )  # fmt: skip
    heights = rough.vertices[:, 2].reshape(81, 81)
    for speed in speeds:
        way = rng.normal(size=3)
        way *= speed / np.sqrt(way @ way)
        way[2] = -abs(way[2])
        body = on(rough, shape, (0.0, 0.0, 0.9), way, spin=rng.normal(size=3) * 20.0, friction=0.3)
        position, _ = states(body, 60)
        row, column = np.floor((position[:, [1, 0]] + 4.0) / 0.1).astype(int).T
        over = (np.minimum(row, column) >= 0) & (np.maximum(row, column) < 80)
        row, column = row[over], column[over]
        lowest = np.min([heights[row + i, column + j] for i in (0, 1) for j in (0, 1)], axis=0)
        assert np.all(position[over, 2] > lowest)


CYLINDER = {'type': 'cylinder', 'radius': 0.08, 'length': 0.36}


def rolling(ground, yaw, speed):
    """
    A cylinder that rolls over the origin of a floor, in a direction, and its velocity.
    """
    half = 0.5 * yaw
    turn = np.array([np.cos(half), np.sin(half), np.sin(half), np.cos(half)]) * np.sqrt(0.5)
    heading = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    body = {
        'name': 'body', 'mass': 1.0, 'friction': 0.3, 'shape': CYLINDER,
        'initial': {
            'position': [0, 0, 0.08], 'velocity': (speed * heading).tolist(),
            'orientation': turn.tolist(),
            'angular_velocity': (speed / 0.08 * np.cross([0, 0, 1], heading)).tolist(),
        },
    }  # fmt: skip
    floor = [
        {'name': f'floor_{k}', 'fixed': True, 'friction': 0.3,
         'shape': {'type': 'heightfield', 'heights': [[0, 0], [0, 0]], 'spacing': [x, y],
                   'origin': [*corner, 0]}}
        for k, (x, y, corner) in enumerate(ground)
    ]  # fmt: skip
    scene = {'dt': DT, 'gravity': [0, 0, -G], 'contact': {'mode': 'timestep'},
             'bodies': [*floor, body]}  # fmt: skip
    return Simulation(load_scene(scene)), speed * heading


@pytest.mark.parametrize('speed', [0.3, 1.0, 3.0, 4.6])
@pytest.mark.parametrize(
    ('ground', 'yaw'),
    [
        ([(3.15, 3.0, (-3.0, -1.5)), (4.85, 3.0, (0.15, -1.5))], 0.3),
        ([(3.15, 3.0, (-3.0, -1.5)), (4.85, 3.0, (0.15, -1.5))], 0.0),
        ([(6.0, 2.0, (-1.0, -1.94))], 0.0),
    ],
    ids=['over a joint at an angle', 'over a joint', 'partly over the border'],
)
def test_the_line_of_a_cylinder_is_carried_as_far_as_ground_lies_under_it(ground, yaw, speed):
    """
    Two fields, flush; and one whose border it overhangs by a third.
    """
    sim, velocity = rolling(ground, yaw, speed)
    for _ in range(int(0.5 / speed / DT)):
        sim.step(1)
        assert np.linalg.norm(sim.state.velocity[-1] - velocity) < SPEED_KEPT * speed
        assert abs(sim.state.position[-1, 2] - 0.08) < HEIGHT


def height_over(surface, x, y):
    """
    Height of a surface over points, which lie over one triangle at least each.
    """
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    to = np.linalg.inv(np.stack((b - a, c - a), axis=-1)[:, :2])
    u, v = np.moveaxis(to @ (np.stack((x, y)) - a[:, :2, None]), 1, 0)
    over = np.minimum(np.minimum(u, v), 1.0 - u - v) > -1e-9
    on = a[:, 2:] + u * (b - a)[:, 2:] + v * (c - a)[:, 2:]
    return np.where(over, on, -np.inf).max(axis=0)


def drawn_shape(kind, rng):
    """
    Draw a box or a cylinder of some decimetres.
    """
    if kind == 'box':
        return {'type': 'box', 'size': rng.uniform(0.15, 0.3, 3).tolist()}
    radius, length = rng.uniform((0.07, 0.05), (0.14, 0.3)).tolist()
    return {'type': 'cylinder', 'radius': radius, 'length': length}


def samples_of(shape):
    """
    Points on the surface of a box or a cylinder, in its axes.
    """
    if isinstance(shape, Cylinder):
        half = 0.5 * shape.length
        section = [(1.0, z) for z in np.linspace(-half, half, 9)]
        section += [(share, z) for share in (0.25, 0.5, 0.75) for z in (-half, half)]
        return np.array(
            [
                (share * shape.radius * np.cos(angle), share * shape.radius * np.sin(angle), z)
                for angle in np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
                for share, z in section
            ]
        )
    samples = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 9)] * 3), axis=-1).reshape(-1, 3)
    return samples[np.abs(samples).max(axis=1) == 0.5] * shape.size


@pytest.mark.parametrize(
    ('kind', 'seed'),
    [
        ('box', 1),
        ('cylinder', 15),
        *(
            pytest.param(*one, marks=pytest.mark.long)
            for one in (('box', 3), ('box', 5), ('cylinder', 4))
        ),
    ],
)
def test_what_tumbles_on_rough_ground_is_no_deeper_in_it_than_contacts_tell(kind, seed):
    """
    Ridges, peaks and saddles: what lies over one facet is not what is in front of its plane. The
    sink of an impact on a corner is 2 to 3 mm, in ticks of 4 ms at 1 to 2 m/s.
    """
    rng = np.random.default_rng(seed)
    ground = height_field(
        rng.uniform(0.0, 0.12, (12, 12)), spacing=0.25, origin=(-1.375, -1.375, 0.0)
    )
    spots = np.array([(x, y, 0.45) for y in (-0.4, 0.4) for x in (-0.7, 0.0, 0.7)])
    bodies = [
        {
            'name': f'body_{index}', 'density': 500.0, 'friction': 0.3,
            'shape': drawn_shape(kind, rng),
            'initial': {
                'position': spot.tolist(), 'orientation': rng.normal(size=4).tolist(),
                'velocity': rng.uniform(-1, 1, 3).tolist(),
                'angular_velocity': rng.uniform(-3, 3, 3).tolist(),
            },
        }
        for index, spot in enumerate(spots)
    ]  # fmt: skip
    for body in bodies:
        turn = np.array(body['initial']['orientation'])
        body['initial']['orientation'] = (turn / np.linalg.norm(turn)).tolist()
    plane = {'type': 'heightfield', 'spacing': 1.0, 'heights': [[0, 0], [0, 0]]}
    flat = {'name': 'ground', 'fixed': True, 'friction': 0.3, 'shape': plane}
    scene = load_scene(
        {'dt': DT, 'gravity': [0, 0, -G], 'contact': {'mode': 'timestep'},
         'bodies': [flat, *bodies]}
    )  # fmt: skip
    below, *above = scene.bodies
    below = dataclasses.replace(below, shape=ground)
    sim = Simulation(dataclasses.replace(scene, bodies=(below, *above)))
    samples_of_each = [samples_of(body.shape) for body in above]
    for tick in range(200):
        sim.step(1)
        contacts = sim.contacts()
        assert contacts.gap.min(initial=0.0) > -8e-3
        if tick % 4:
            continue
        state = sim.state
        for index, samples in enumerate(samples_of_each, start=1):
            points = so3.rotate(state.orientation[index], samples)
            x, y, z = (points + state.position[index]).T
            assert np.all(z - height_over(ground, x, y) > -5e-3)
    assert not sim.overlap_warnings


@pytest.mark.parametrize('shape', SHAPES)
def test_what_passes_over_an_edge_keeps_all_bits_of_its_velocity(shape):
    plate = tiled_floor(yaw=0.2)
    for speed in (0.3, 3.0, 30.0):
        for clearance in (1e-4, 1e-2):
            start = (-3.5, 0.3, SHAPES[shape][1] + clearance)
            body = on(plate, shape, start, (speed, 0.1 * speed, 0.0), gravity=0.0)
            body.step(int(min(400, 7.0 / speed / DT)))
            assert body.state.velocity[-1].tolist() == [speed, 0.1 * speed, 0.0]


def test_a_restored_run_goes_on_bit_for_bit():
    rough = grid(lambda x, y: 0.1 * np.sin(5.0 * x) * np.cos(4.0 * y), half=2.0, spacing=0.1)

    def start():
        return on(rough, 'box', (0.0, 0.0, 0.5), (0.5, 0.2, 0.0), spin=(1, 2, 3), friction=0.4)

    whole, cut = start(), start()
    whole.step(300)
    cut.step(170)
    resumed = start()
    resumed.restore(tick=170, state=cut.state_bytes(), slots={})
    resumed.step(130)
    assert resumed.state_bytes() == whole.state_bytes()


def test_ground_of_triangles_is_fixed_and_stands_alone():
    moving = SCENE.format(
        gravity=-G, friction=0.1, ground=SHAPES['ball'][0], shape=FLAT, initial='{}'
    )
    with pytest.raises(UserError, match=r'bodies\[1\]\.shape.*fixed: true'):
        load_scene(moving.encode())
    with pytest.raises(InvalidModel, match='no part of a union'):
        Union((Part(Sphere(0.1)), Part(height_field(np.zeros((2, 2)), spacing=1.0))))
    swaying = SCENE.format(
        gravity=-G, friction=0.1, ground=SHAPES['ball'][0], shape=SHAPES['ball'][0], initial='{}'
    ).replace('fixed: true,', 'motion: {heave: {amplitude: 0.1, period: 1}},')
    moved = swaying.replace(f'shape: {SHAPES["ball"][0]}', f'shape: {FLAT}', 1)
    with pytest.raises(UserError, match='stands still'):
        load_scene(moved.encode())
    with pytest.raises(InvalidModel, match='two rows'):
        height_field([[0.0, 1.0]], spacing=1.0)
    with pytest.raises(InvalidModel, match='positive'):
        height_field(np.zeros((2, 2)), spacing=0.0)
    with pytest.raises(UserError, match='heights or file'):
        load_scene(
            SCENE.format(
                gravity=0, friction=0, shape=SHAPES['ball'][0], initial='{}',
                ground='{type: heightfield, spacing: 1, heights: [[0, 0], [0, 0]], file: a.csv}',
            ).encode()
        )  # fmt: skip


def test_a_mesh_file_collides_as_its_triangles_where_it_is_asked_to(tmp_path):
    (tmp_path / 'bed.off').write_text(
        'OFF\n4 2 0\n-5 -5 0\n5 -5 0\n5 5 0\n-5 5 0\n3 0 1 2\n3 0 2 3\n'
    )
    (tmp_path / 'bed.csv').write_text('0,0,0\n0,0,0\n')
    for ground in (
        '{type: mesh, file: bed.off, as: triangles}',
        '{type: heightfield, file: bed.csv, spacing: [5, 10], origin: [-5, -5, 0]}',
    ):
        text = SCENE.format(
            gravity=-G, friction=0.0, ground=ground, shape=SHAPES['ball'][0],
            initial='{position: [0.3, 0.2, 0.1], velocity: [1, 0, 0]}',
        )  # fmt: skip
        path = tmp_path / 'on_ground.yaml'
        path.write_text(text)
        body = Simulation(load_scene(path))
        assert not body.warnings()
        position, velocity = states(body, 100)
        assert np.abs(position[:, 2] - 0.1).max() < HEIGHT
        assert np.abs(velocity[:, 0] - 1.0).max() < SPEED_KEPT
