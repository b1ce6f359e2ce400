# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
No ghost contacts: flush surfaces are one surface, and what misses is not touched.

The long form, on random tiles, shapes, headings and speeds: benchmark/ghost_contacts.py.
"""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene

_path = Path(__file__).parents[2] / 'benchmark' / 'ghost_contacts.py'
_spec = importlib.util.spec_from_file_location('ghost_contacts', _path)
ghosts = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(ghosts)

MOVERS = ('box', 'hull', 'ball', 'capsule', 'puck')
OPTIONS = SimpleNamespace(
    seed=1, dt=0.004, substeps=4, speed=(0.1, 10.0), spin=1, gravity=False, longest=1.0
)
SPEED = 1e-3  # [-] of the speed: what the sink of a contact in motion, some 1e-6 m, may cost
HOP = 1e-5  # [m] ten times that sink


@pytest.mark.parametrize('draws', [2, pytest.param(5, marks=pytest.mark.long)])
@pytest.mark.parametrize('floor', ghosts.FLOORS)
def test_a_flush_floor_is_one_surface(floor, draws):
    """
    Speed and height stay over random joints, sliding and rolling.

    Cylinders roll in the long form.
    """
    for kind, how, speed, _, error, hop in ghosts.run_floors(floor, MOVERS, draws, OPTIONS):
        assert error < SPEED, (kind, how, speed)
        assert hop < HOP, (kind, how, speed)


@pytest.mark.parametrize('draws', [6, pytest.param(12, marks=pytest.mark.long)])
@pytest.mark.parametrize('floor', [name for name in ghosts.FLOORS if name != 'plane'])
def test_what_rolls_on_a_line_is_not_tilted_where_its_line_goes_over_to_another_tile(floor, draws):
    """
    In ticks of which each moves the joint along the line by a good part of it: slow discs, above
    all. Without the loads as the body has felt them half of them are swayed by more than SPEED.
    """
    options = SimpleNamespace(**{**vars(OPTIONS), 'seed': 4, 'speed': (0.1, 1.5)})
    found = ghosts.run_floors(floor, ('disc',), draws, options)
    assert sum(how == 'rolls' for _, how, *_ in found) >= draws / 3
    for kind, how, speed, _, error, hop in found:
        assert error < SPEED, (kind, how, speed)
        assert hop < HOP, (kind, how, speed)


def test_what_rolls_slowly_is_not_tilted_where_passes_over_its_constraints_end():
    """
    On a plane with boxes flush with it, where a line goes from three manifolds to two. Where
    passes leave changes of 1 mm/s alone, two of these discs are swayed, by up to 3e-3.
    """
    options = SimpleNamespace(**{**vars(OPTIONS), 'seed': 2, 'speed': (0.1, 0.3)})
    found = ghosts.run_floors('plane', ('disc', 'capsule'), 12, options)
    assert sum(how == 'rolls' for _, how, *_ in found) > 3
    for kind, how, speed, _, error, hop in found:
        assert error < SPEED, (kind, how, speed)
        assert hop < HOP, (kind, how, speed)


@pytest.mark.parametrize('draws', [2, pytest.param(8, marks=pytest.mark.long)])
@pytest.mark.parametrize('floor', ghosts.FLOORS)
def test_a_slow_ball_leaves_no_load_with_the_edge_behind_it(floor, draws):
    """A share of 1e-3 of its weight for two ticks is 1e-3 of 0.1 m/s."""
    options = SimpleNamespace(**{**vars(OPTIONS), 'seed': 4, 'speed': (0.1, 0.3)})
    for _, how, speed, _, error, hop in ghosts.run_floors(floor, ('ball',), draws, options):
        assert error < 2e-5, (how, speed)
        assert hop < HOP, (how, speed)


def test_flush_prisms_are_seen_along_their_faces_not_along_what_leans_on_one():
    """A disc that leaned by 2e-5 rad was stopped by a prism 0.3 m away, at 2.7 m/s."""
    options = SimpleNamespace(**{**vars(OPTIONS), 'seed': 2, 'speed': (1.0, 10.0)})
    for kind, how, speed, _, error, hop in ghosts.run_floors(
        'prisms', ('cylinder', 'puck'), 10, options
    ):
        assert error < SPEED, (kind, how, speed)
        assert hop < HOP, (kind, how, speed)


MISSES = pytest.mark.parametrize('draws', [25, pytest.param(80, marks=pytest.mark.long)])


@MISSES
def test_what_misses_keeps_every_bit(draws):
    """Random pairs that pass at 1e-4 m and more, moving and spinning: exactly nothing."""
    found = ghosts.run_misses(draws, OPTIONS)
    assert len(found) == draws
    for label, change in found:
        assert change == 0.0, label


@MISSES
def test_what_passes_above_what_stands_keeps_every_bit(draws):
    """The same, level: rims of cylinders that stand pass ends, faces and edges at 1e-4 m."""
    found = ghosts.run_misses(draws, OPTIONS, ghosts.passing_above)
    assert len(found) == draws
    for label, change in found:
        assert change == 0.0, label


def turning_apart(number, shape, gap, rate):
    """Two cubes that turn as one body about their middle, a gap apart, until they are let go."""
    rng = np.random.default_rng(number)
    spin = np.append(0.0, rng.normal(size=2))
    spin *= rate / np.linalg.norm(spin)
    half = np.array([0.1 + 0.5 * gap, 0.03, 0.02])
    return [
        {
            'name': f'{name}_{number}', 'mass': 1.0, 'friction': 0.5, 'shape': shape,
            'initial': {
                'position': (np.array([0.0, 30.0 * number, 0.0]) + side * half).tolist(),
                'velocity': np.cross(spin, side * half).tolist(),
                'angular_velocity': spin.tolist(),
            },
        }
        for name, side in (('left', -1.0), ('right', 1.0))
    ]  # fmt: skip


def test_what_turns_with_its_neighbour_and_leaves_it_keeps_every_bit():
    """
    Faces that turn together separate all the way, axes that stand still for a moment only.

    A row of now would stop the far edges, which go towards where the face was: by up to 24 m/s^2.
    """
    corners = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
    shapes = {'type': 'convex_hull', 'vertices': corners}, {'type': 'box', 'size': [0.2] * 3}
    cases = [(s, g, w) for s in shapes for g in (1e-3, 1e-4, 1e-5) for w in (5.0, 20.0, 60.0)]
    bodies = [body for n, case in enumerate(cases) for body in turning_apart(n, *case)]
    sim = Simulation(load_scene(scene(bodies, gravity=0.0)))
    before = sim.state.velocity.copy()
    sim.step(3)
    assert np.array_equal(sim.state.velocity, before)


def scene(bodies, gravity=-9.81):
    """A scene of such bodies at 4 ms."""
    return {
        'name': 'flush', 'dt': 0.004, 'gravity': [0, 0, gravity],
        'contact': {'mode': 'timestep'}, 'bodies': bodies,
    }  # fmt: skip


def tile(name, position, size=(1.0, 1.0, 0.1), **more):
    """A smooth fixed box."""
    return {
        'name': name, 'fixed': True, 'friction': 0.0,
        'shape': {'type': 'box', 'size': list(size)}, 'initial': {'position': list(position)},
        **more,
    }  # fmt: skip


def cube(position, velocity, **more):
    """A smooth cube of 0.2 m."""
    return {
        'name': 'cube', 'mass': 1.0, 'friction': 0.0,
        'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]},
        'initial': {'position': list(position), 'velocity': list(velocity)}, **more,
    }  # fmt: skip


@pytest.mark.parametrize('off', [0.0, 1e-9, -1e-9, 1e-7, -1e-7])
def test_a_face_that_begins_at_the_joint_passes(off):
    """The front of the cube stands at the joint to the last digit, or to either side of it."""
    bodies = [tile('one', (0, 0, -0.05)), tile('two', (1, 0, -0.05))]
    simulation = Simulation(load_scene(scene([*bodies, cube((0.4 + off, 0, 0.1), (1, 0, 0))])))
    simulation.step(100)
    assert abs(simulation.state.velocity[-1, 0] - 1.0) < 1e-12
    assert simulation.state.position[-1, 2] < 0.1


@pytest.mark.parametrize('rise', [1e-7, 1e-6, 1e-5])
def test_tiles_that_differ_less_than_they_are_placed_are_flush(rise):
    """
    A step of so little is no step: `FLUSH_STEP` is 1.7e-5 m here. The speed is kept but for the
    way up.
    """
    bodies = [tile('one', (0, 0, -0.05)), tile('two', (1, 0, -0.05 + rise))]
    simulation = Simulation(load_scene(scene([*bodies, cube((0.2, 0, 0.1), (1, 0, 0))])))
    simulation.step(150)
    # m g rise is 1e-4 of its energy at 1e-5 m; the soft contact makes some blow of it
    assert abs(simulation.state.velocity[-1, 0] - 1.0) < 1e-3


@pytest.mark.parametrize('step', [1e-3, 1e-2])
def test_a_step_takes_what_a_blow_at_the_lower_edge_takes(step):
    """
    A millimetre is a wall. The blow J at depth r below the centre of a cube of edge a = 2 r:

        J (1/m + r^2/I) = m v,   I = m a^2/6:   v' = v (1 - 1/(1 + 6/4)) = 0.6 v
    """
    bodies = [tile('one', (0, 0, -0.05)), tile('two', (1, 0, -0.05 + step))]
    simulation = Simulation(load_scene(scene([*bodies, cube((0.3, 0, 0.1), (1, 0, 0))])))
    simulation.step(24)
    assert abs(simulation.state.velocity[-1, 0] - 1.0) < 1e-9
    simulation.step(1)
    # 0.6 is left by a blow at the edge itself; one above it, up to the top of the step, and what
    # follows while the cube begins to tip take more
    assert 0.0 < simulation.state.velocity[-1, 0] < 0.6 + 1e-3
    assert simulation.state.position[-1, 0] < 0.4 + 2e-3  # it tips, and goes no farther in


@pytest.mark.parametrize('restitution', [0.0, 0.5, 1.0])
def test_a_wall_on_a_tiled_floor_gives_back_what_it_should(restitution):
    """v' = -e v: covered joints on the way, and the wall none of them."""
    bodies = [tile(f'tile_{i}', (0.5 * i, 0, -0.05), (0.5, 1.0, 0.1)) for i in range(4)]
    bodies.append(tile('wall', (1.8, 0, 0.3), (0.1, 1.0, 0.6)))
    ball = {
        'name': 'ball', 'mass': 1.0, 'friction': 0.0, 'restitution': restitution,
        'shape': {'type': 'sphere', 'radius': 0.1},
        'initial': {'position': [0.0, 0.0, 0.1], 'velocity': [2, 0, 0]},
    }  # fmt: skip
    simulation = Simulation(load_scene(scene([*bodies, ball])))
    simulation.step(250)
    assert simulation.state.velocity[-1, 0] == pytest.approx(-2.0 * restitution, abs=1e-3)


def test_a_landing_on_a_joint_is_one_on_one_floor():
    """A cube falls flat across a joint and bounces: as over one box, to the tolerance of relax."""
    one = [tile('one', (0.5, 0, -0.05), (2.0, 1.0, 0.1))]
    two = [tile('one', (0, 0, -0.05)), tile('two', (1, 0, -0.05))]
    ways = []
    for floor in (one, two):
        falling = cube((0.45, 0.1, 0.3), (1.5, 0.3, -1.0), restitution=0.6)
        simulation = Simulation(load_scene(scene([*floor, falling])))
        states = []
        for _ in range(100):
            simulation.step(1)
            states.append(simulation.state.position[-1].copy())
        ways.append(np.array(states))
    assert np.abs(ways[0] - ways[1]).max() < 1e-4


def test_movable_flush_tiles_are_one_floor():
    """Ten loose tiles on a plane: each sinks under the cube, by less than `FLUSH_STEP`."""
    plane = {'name': 'ground', 'friction': 0.5, 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
    loose = [
        tile(f'tile_{i}', (0.3 * i, 0, 0.05), (0.3, 0.6, 0.1)) | {'fixed': False, 'mass': 5.0}
        for i in range(8)
    ]
    for one in loose:
        one['friction'] = 0.5
    moving = cube((0.3, 0, 0.2), (1, 0, 0))
    simulation = Simulation(load_scene(scene([plane, *loose, moving])))
    simulation.step(300)
    assert abs(simulation.state.velocity[-1, 0] - 1.0) < SPEED


def test_a_run_over_joints_resumes_with_the_same_bits():
    """What is left out follows from the state alone: a restored run knows no less."""
    bodies = [tile(f'tile_{i}', (0.25 * i, 0, -0.05), (0.25, 1.0, 0.1)) for i in range(8)]
    text = scene([*bodies, cube((0.1, 0, 0.1), (3, 0.2, 0))])
    straight, cut = Simulation(load_scene(text)), Simulation(load_scene(text))
    straight.step(100)
    cut.step(37)
    resumed = Simulation(load_scene(text))
    resumed.restore(tick=37, state=cut.state_bytes(), slots={})
    resumed.step(63)
    assert resumed.state_bytes() == straight.state_bytes()


def test_what_falls_together_passes_as_without_gravity():
    """Random pairs in free fall."""
    options = SimpleNamespace(**{**vars(OPTIONS), 'gravity': True, 'seed': 4})
    found = ghosts.run_misses(20, options)
    assert len(found) == 20
    # against the same fall 1 km higher: rounding of places
    assert max(change for _, change in found) < 1e-11


def courses(rng, wide=2.0):
    """A wall behind y = 0: courses of bricks of random sizes, their joints in the way."""
    bricks, low = [], -0.6
    while low < 0.6:
        high, left = rng.uniform(0.1, 0.5), -wide / 2 - rng.uniform(0.0, 0.5)
        while left < wide / 2:
            long, deep = rng.uniform(0.1, 0.5), rng.uniform(0.05, 0.2)
            place = (left + long / 2, -deep / 2, low + high / 2)
            bricks.append(tile(f'brick_{len(bricks)}', tuple(map(float, place)),
                               (float(long), float(deep), float(high))))  # fmt: skip
            left += long
        low += high
    return bricks


@pytest.mark.parametrize('draws', [40, pytest.param(200, marks=pytest.mark.long)])
def test_an_upright_cylinder_that_comes_to_a_wall_of_bricks_at_an_angle_slides_along_it(draws):
    """
    Without friction and gravity: it loses its speed across, not that along, and does not turn. A
    brick above its rim or beside it is met along the line to its corner, sooner than the wall as
    the cylinder moves along that; where this counted, 1 in 20 was thrown about, by up to 20 rad/s
    and a fifth of its speed. Faster ones go by joints within the tick: see the limits.
    """
    rng = np.random.default_rng(3)
    for draw in range(draws):
        bricks = courses(rng)
        along = 10 ** rng.uniform(-0.5, 0.3)
        across = along * rng.uniform(0.1, 1.5)
        radius, length = rng.uniform(0.03, 0.15), rng.uniform(0.06, 0.3)
        takes = min(0.15, 0.4 / along)
        place = [-0.5 * along * takes, radius + across * takes, rng.uniform(-0.2, 0.2)]
        body = {
            'name': 'puck', 'mass': 1.0, 'friction': 0.0,
            'shape': {'type': 'cylinder', 'radius': float(radius), 'length': float(length)},
            'initial': {'position': [*map(float, place)], 'velocity': [along, -across, 0.0]},
        }  # fmt: skip
        simulation = Simulation(load_scene(scene([*bricks, body], 0.0)))
        simulation.step(round(2 * takes / simulation.dt))
        velocity, spin = simulation.state.velocity[-1], simulation.state.angular_velocity[-1]
        # what the passes leave of a line that is struck: some 1e-5 m/s and rad/s, at worst
        assert np.abs(velocity - (along, 0.0, 0.0)).max() < 1e-5 * max(along, across), draw
        assert np.abs(spin).max() < 1e-3, draw


@pytest.mark.parametrize('draws', [20, pytest.param(60, marks=pytest.mark.long)])
def test_a_disc_that_leans_by_a_hair_strikes_joined_hulls_as_one_wall(draws):
    """
    What leans over a tile is nearest where its rim crosses the edge of that. Where this was the
    contact, it had one point, along a normal of its own, which the next tile covered: discs that
    leaned by 1e-7 rad and more struck one of two tiles, and were turned by up to 1 rad/s.
    """
    rng, upright = np.random.default_rng(5), np.sqrt(0.5)
    for draw in range(draws):
        turn = rng.uniform(0.0, np.pi)
        cosine, sine = np.cos(turn), np.sin(turn)
        off, lean = rng.uniform(-0.03, 0.03), 10 ** rng.uniform(-8.0, -4.0)
        hulls = []
        for number, far in enumerate((-0.3, 0.3)):
            corners = [(x, y, z) for x in (-0.1, 0.0) for y in (-0.3, 0.3) for z in (0.0, far)]
            corners = [[x, cosine * y - sine * (z + off), sine * y + cosine * (z + off)]
                       for x, y, z in corners]  # fmt: skip
            middle = np.mean(corners, axis=0)
            shape = {'type': 'convex_hull', 'vertices': (corners - middle).tolist()}
            hulls.append({'name': f'tile_{number}', 'shape': shape, 'fixed': True,
                          'friction': 0.0, 'initial': {'position': middle.tolist()}})  # fmt: skip
        x = rng.uniform(0.08, 0.084)
        disc = {
            'name': 'disc', 'mass': 1.0, 'friction': 0.0,
            'shape': {'type': 'cylinder', 'radius': 0.08, 'length': 0.06},
            'initial': {
                'position': [float(x), 0.0, 0.0], 'velocity': [-1.0, 0.0, 0.0],
                'orientation': [lean, upright, 0.0, upright],
            },
        }  # fmt: skip
        simulation = Simulation(load_scene(scene([*hulls, disc], 0.0)))
        simulation.step(30)
        assert np.abs(simulation.state.angular_velocity[-1]).max() < 1e-9, (draw, lean)
        assert abs(simulation.state.velocity[-1, 0]) < 1e-9, (draw, lean)
