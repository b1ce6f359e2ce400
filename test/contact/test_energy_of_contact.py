# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Energy of bodies that hit and rub: it does not rise, whatever restitution and friction.

The rule: in no tick by more than 1e-5 of the largest energy that the scene has had, 5e-6 for up to
three bodies, and less in shorter ticks. The long form, with other kinds of scenes, is
`benchmark/energy_of_contact.py`.
"""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Box, Capsule, ConvexHull, Cylinder, Sphere
from rigid_body_sim.physics.simulation import Simulation

from .touching import G, ball, box, ground, motion, scene

SHAPES = [(0.2, 0.2, 0.2), (0.2, 0.3, 0.5), (0.5, 0.5, 0.2), (0.2, 0.2, 0.5)]


FEW, MANY = 5e-6, 1e-5  # [-] of the largest energy: up to three bodies, and more


def rises(sim, ticks):
    """
    Largest gain of energy in one tick [J].
    """
    energy = [sim.energy()]
    for _ in range(ticks):
        sim.step()
        energy.append(sim.energy())
    return np.diff(energy).max()


def largest_rise(sim, ticks):
    """
    Largest gain of energy in one tick over the largest energy, of weights above the ground [-].
    """
    energy = [sim.energy()]
    for _ in range(ticks):
        sim.step()
        energy.append(sim.energy())
    return np.diff(energy).max() / max(energy)


def thrown(shape, seed, *, restitution, friction, dt=1 / 240):
    """
    A box of 1 kg that falls onto the ground, tumbling.
    """
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    material = {'restitution': restitution, 'friction': friction}
    body = box(
        'b', shape, (0, 0, 0.6), q=q / np.linalg.norm(q), velocity=rng.normal(size=3),
        turn=8 * rng.normal(size=3), material=material,
    )  # fmt: skip
    return scene([ground(material=material), body], dt=dt)


@pytest.mark.parametrize('friction', [0.3, 0.8])
def test_a_lively_box_with_friction_is_not_thrown_up_by_its_own_friction(friction):
    """
    Newton's law with friction creates energy at an eccentric impact (Kane and Levinson): here up
    to 2 J of 9 J in one bounce. A bounce must give back less than the impact took.
    """
    for shape in SHAPES:
        for seed in range(4):
            sim = Simulation(thrown(shape, seed, restitution=0.95, friction=friction))
            # energies of some ten joules, to rounding
            assert rises(sim, 480) < 1e-12


@pytest.mark.parametrize(
    ('restitution', 'friction'),
    [
        pytest.param(*one, marks=() if i % 3 != 1 else pytest.mark.long)
        for i, one in enumerate(itertools.product((0.0, 0.2, 0.5, 0.8), (0.0, 0.3, 0.8)))
    ],
)
@pytest.mark.parametrize('seeds', [1, pytest.param(3, marks=pytest.mark.long)])
def test_energy_of_a_tumbling_box_rises_in_no_tick(restitution, friction, seeds):
    for shape in SHAPES:
        for seed in range(seeds):
            sim = Simulation(thrown(shape, seed, restitution=restitution, friction=friction))
            assert largest_rise(sim, 480) < FEW


def corner_drop():
    """
    A cube that falls exactly onto its corner.
    """
    half, turn = 0.5 * np.arctan(np.sqrt(2.0)), np.pi / 8
    q = (
        np.sin(half) * np.cos(turn), -np.sin(half) * np.sin(turn),
        np.cos(half) * np.sin(turn), np.cos(half) * np.cos(turn),
    )  # fmt: skip
    return [ground(), box('b', 0.2, (0, 0, 0.5), q=q)]


def cold_stack():
    """
    A cube of 10 kg on one of 1 kg, which begin to press in the first tick.
    """
    return [ground(), box('light', 0.2, (0, 0, 0.1)), box('heavy', 0.2, (0, 0, 0.3), mass=10.0)]


@pytest.mark.parametrize('bodies', [corner_drop, cold_stack])
@pytest.mark.parametrize('ms', [4.0, 1.0])
def test_energy_of_few_bodies_rises_in_no_tick_and_less_in_shorter_ones(bodies, ms):
    sim = Simulation(scene(bodies(), dt=1e-3 * ms))
    assert largest_rise(sim, round(1000 / ms)) < FEW * (ms / 4.0) ** 2


def begins_at_rest(count, ratio):
    """
    A stack of cubes that stand on each other when the scene begins; the top one has another mass.
    """
    cubes = [box(f'b{i}', 0.2, (0, 0, 0.1 + 0.2 * i)) for i in range(count - 1)]
    top = box('top', 0.2, (0, 0, 0.2 * count - 0.1), mass=float(ratio))
    return Simulation(scene([ground(material={'friction': 0.5}), *cubes, top], dt=0.004))


@pytest.mark.parametrize(
    ('count', 'ratio'), [(1, 1), (10, 1), (2, 10), (2, 100), (2, 1000), (2, 10_000), (10, 30)]
)
def test_what_stands_when_the_scene_begins_goes_on_standing(count, ratio):
    """
    Its loads are there before the first tick. What it sinks by is what the static sink leaves, 3 %
    of 2 W/omega^2 at each joint and of W/(4 omega^2) at the ground, W the weight above over that
    of a cube.
    """
    sim = begins_at_rest(count, ratio)
    before, top = sim.energy(), sim.state.position[-1, 2]
    omega = np.pi / 2 / 0.001
    loads = [G * (ratio + i) for i in range(count)]
    sinks = 0.03 * (2 * sum(loads[:-1]) + loads[-1] / 4) / omega**2
    largest = before
    for _ in range(250):
        sim.step()
        energy = sim.energy()
        if ratio <= 1000:  # what rocks under 10^4 gains 2e-5
            assert energy - before < (FEW if count < 4 else MANY) * largest
        before = energy
        assert sim.state.position[-1, 2] > top - 1.2 * sinks - 1e-9
    assert np.abs(sim.state.velocity).max() < 2 * sinks + 1e-9
    assert np.abs(sim.state.angular_velocity).max() < 1e-2
    assert not list(sim.warnings())


def test_what_begins_in_an_impact_has_no_load_of_its_own():
    """
    A cube that touches and comes with 1 m/s: its impulse is that of the impact and of its weight.
    """
    cube = box('b', 0.2, (0, 0, 0.1), velocity=(0, 0, -1.0))
    sim = Simulation(scene([ground(), cube], dt=0.004))
    sim.step()
    pressed = np.abs(sim.contacts().impulse[:, 2].sum())
    assert pressed == pytest.approx(1.0 + G * 0.004, rel=1e-9)
    assert abs(sim.state.velocity[1, 2]) < 1e-9


def test_energy_of_a_heap_and_of_a_pyramid_rises_in_no_tick():
    """
    A grid of boxes that falls, and a pyramid whose boxes begin to press in the first tick.
    """
    rng = np.random.default_rng(5)
    places = np.stack(np.meshgrid(*[np.arange(3.0)] * 3), axis=-1).reshape(-1, 3)
    places = 0.22 * places + (0, 0, 0.15) + rng.uniform(-0.01, 0.01, size=places.shape)
    heap = [box(f'b{i}', 0.2, place) for i, place in enumerate(places)]
    pyramid = [
        box(f'p{row}_{i}', 0.2, (0.21 * (i + 0.5 * row), 5.0, 0.1 + 0.2 * row))
        for row in range(6)
        for i in range(6 - row)
    ]
    for bodies in (heap, pyramid):
        sim = Simulation(scene([ground(), *bodies], dt=0.004))
        assert largest_rise(sim, 250) < MANY


def test_momenta_that_contact_cannot_change_stay():
    """
    On a plane without friction a tumbling box keeps momentum along it and angular momentum about
    its normal.
    """
    for seed in range(4):
        sim = Simulation(thrown(SHAPES[1], seed, restitution=0.0, friction=0.0))
        momentum, angular = sim.momentum()[:2], sim.state.angular_momentum[1, 2]
        sim.step(480)
        assert np.abs(sim.momentum()[:2] - momentum).max() < 1e-13
        assert abs(sim.state.angular_momentum[1, 2] - angular) < 1e-13


@pytest.mark.parametrize('count', [1, 3])
def test_impulses_of_contacts_are_the_whole_change_of_momentum(count):
    """
    m (v' - v - g dt) = sum of the impulses that are read, for bodies that tumble onto each other,
    and of what ticks take back of gains: of the three 2e-4 of the impulses at most.
    """
    rng = np.random.default_rng(3)
    bodies = [
        box(f'b{i}', (0.2, 0.3, 0.25), (0.1 * i, 0, 0.3 + 0.35 * i), velocity=(0.3 * i, 0, 0),
            turn=4 * rng.normal(size=3))
        for i in range(count)
    ]  # fmt: skip
    sim = Simulation(scene([ground(), *bodies]))
    for _ in range(360):
        before = sim.momentum()
        sim.step()
        found = sim.contacts()
        upon = (found.bodies[:, 1] != 0) * 1.0 - (found.bodies[:, 0] != 0)
        given = (upon[:, None] * found.impulse).sum(axis=0)
        change = sim.momentum() - before + (0, 0, count * G * sim.dt)
        taken_back = found.taken_back[:, :3].sum(axis=0)
        assert given + taken_back == pytest.approx(change, abs=1e-12)
        assert np.linalg.norm(taken_back) < 5e-4 * np.linalg.norm(given) + 1e-12


@pytest.mark.parametrize('restitution', [0.0, 0.5, 0.9])
def test_energy_of_boxes_that_hit_each_other_in_free_space_rises_in_no_tick(restitution):
    rng = np.random.default_rng(7)
    material = {'restitution': restitution, 'friction': 0.5}
    bodies = [
        box(f'b{i}', (0.2, 0.3, 0.25), (0.5 * (i % 3), 0.5 * (i // 3), 0.1 * i),
            velocity=rng.normal(size=3), turn=5 * rng.normal(size=3), material=material)
        for i in range(6)
    ]  # fmt: skip
    sim = Simulation(scene(bodies, gravity=(0, 0, 0)))
    start = sim.energy()
    assert largest_rise(sim, 480) < MANY
    assert sim.energy() < 0.999 * start


@pytest.mark.parametrize('restitution', [0.0, 0.5, 1.0])
@pytest.mark.parametrize('friction', [0.0, 0.6])
@pytest.mark.parametrize('kinds', ['ball ball', 'box box', 'ball box'])
def test_momentum_and_angular_momentum_of_two_that_collide_stay_to_the_last_digits(
    kinds, friction, restitution
):
    rng = np.random.default_rng(1)
    material = {'restitution': restitution, 'friction': friction}

    def body(kind, name, place, velocity):
        motion = {'velocity': velocity, 'turn': 3 * rng.normal(size=3), 'material': material}
        if kind == 'ball':
            return ball(name, 0.1, place, **motion)
        return box(name, (0.2, 0.3, 0.15), place, **motion)

    first, second = kinds.split()
    pair = [
        body(first, 'a', (-0.6, 0.03, 0.02), (3, 0.1, 0)),
        body(second, 'b', (0, 0, 0), (-1, 0, 0.2)),
    ]
    sim = Simulation(scene(pair, gravity=(0, 0, 0)))
    linear, angular = sim.momentum(), sim.angular_momentum()
    spin = sim.state.angular_velocity[:2].copy()
    sim.step(100)
    assert sim.state.velocity[0, 0] < 2.5  # they met
    # both arms end in one point, in every substep
    assert np.abs(sim.momentum() - linear).max() < 1e-13 * 4
    assert np.abs(sim.angular_momentum() - angular).max() < 1e-13
    if friction == 0.0 and kinds == 'ball ball':
        # impulses act along the line of centres: no torque
        assert np.abs(sim.state.angular_velocity[:2] - spin).max() < 1e-12


def block_of_balls(spacing, restitution, dt, *, seed=2):
    """
    6 x 6 x 6 balls of 10 kg and radius 0.1 m that fall (V25 and V26, after SimBenchmark).
    """
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(*[np.arange(6.0)] * 3), axis=-1).reshape(-1, 3)
    places = spacing * places + (0, 0, 1.101) + rng.uniform(-0.001, 0.001, size=places.shape)
    material = {'restitution': restitution, 'friction': 0.0}
    bodies = [
        ball(f'b{i}', 0.1, place, mass=10.0, material=material) for i, place in enumerate(places)
    ]
    return Simulation(scene([ground(material=material), *bodies], dt=dt))


@pytest.mark.parametrize(
    'seed', [2, *(pytest.param(seed, marks=pytest.mark.long) for seed in (0, 1, 3, 4, 5))]
)
def test_balls_that_pile_up_overlap_less_in_shorter_ticks(seed):
    """
    Verification case V25: inelastic balls overlap by no more than what the first go in a substep
    when they land, sqrt(2 g z) h, and in the mean less in shorter ones. As h: 0.25; 0.6 since they
    are not the same impacts (six draws: 0.42 to 0.54).
    """
    overlap = []
    for dt in (0.004, 0.001):
        sim = block_of_balls(0.21, 0.0, dt, seed=seed)
        found, most = [], (2 * G * 1.0) ** 0.5 * dt / 4
        for _ in range(round(1.0 / (5 * dt))):
            sim.step(5)
            gaps = sim.contacts().gap
            found += (-gaps[gaps < 0.0]).tolist()
            assert -gaps.min(initial=0.0) < most
        overlap.append(np.mean(found))
    assert 0.0 < overlap[1] < 0.6 * overlap[0]


@pytest.mark.parametrize(
    ('count', 'ratio', 'most'), [(3, 10, FEW), (5, 1, MANY), (5, 10, MANY), (6, 100, MANY)]
)
@pytest.mark.parametrize(
    'seed', [0, 1, *(pytest.param(seed, marks=pytest.mark.long) for seed in (2, 3))]
)
def test_energy_of_boxes_that_fall_onto_each_other_rises_in_no_tick(count, ratio, most, seed):
    """
    A column of boxes of 1 to `ratio` kg, 5 cm apart, each up to 2 cm off its place. Passes that
    end before a blow has gone through all of them leave overlap, and that is lifted again: by ten
    passes alone, energy rises by 1e-5 to 5e-3 of the largest.
    """
    rng = np.random.default_rng(seed)
    masses = np.exp(rng.uniform(0, np.log(ratio), count)).tolist()
    column = [
        box(f'b{i}', 0.2, (*rng.uniform(-0.02, 0.02, 2), 0.15 + 0.25 * i), mass=mass)
        for i, mass in enumerate(masses)
    ]
    sim = Simulation(scene([ground(), *column], dt=0.004))
    assert largest_rise(sim, 250) < most


@pytest.mark.parametrize(
    ('seed', 'ms'),
    [
        *((seed, 4.0) for seed in (0, 7, 19, 31)),
        (0, 1.0),
        *(pytest.param(seed, 2.0, marks=pytest.mark.long) for seed in (0, 7, 19, 31)),
        *(pytest.param(seed, 1.0, marks=pytest.mark.long) for seed in (7, 19, 31)),
    ],
)
def test_what_comes_out_of_its_sink_while_nothing_moves_gains_no_energy(seed, ms):
    """
    A stack of 2 to 7 boxes of 1 to 100 kg, each put down exactly, from a millimetre or from 5 cm:
    it sinks in and is lifted again by micrometres, as springs do, and there is hardly any motion
    from which that could be taken. The height is: without that 1.1e-5 to 1.4e-5. In shorter ticks
    it is less, as their square.
    """
    rng = np.random.default_rng(seed)
    bodies, top = [ground()], 0.0
    for i in range(int(rng.integers(2, 8))):
        size = rng.uniform(0.15, 0.3, 3)
        middle = top + size[2] / 2 + rng.choice([0, 1e-3, 0.05])
        place = (*(0.02 * rng.normal(size=2)), middle)
        bodies.append(box(f'b{i}', size, place, mass=float(np.exp(rng.uniform(0, np.log(100))))))
        top = middle + size[2] / 2
    sim = Simulation(scene(bodies, dt=1e-3 * ms))
    assert largest_rise(sim, round(1500 / ms)) < 0.6 * MANY * (ms / 4.0) ** 2


@pytest.mark.parametrize('seed', [11, 14])
def test_balls_that_press_each_other_apart_on_ice_keep_their_momentum_and_gain_nothing(seed):
    """
    A block of balls of unlike mass falls onto a plane without friction, and spreads: what ice
    cannot change is the momentum of all along it and the angular momentum of all about its normal,
    not that of each of them: what they give each other by their errors was 6e-6 and 1.3e-5.
    """
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 6))
    material = {'friction': 0.0, 'restitution': 0.5}
    bodies = [ground(material=material)]
    for i in range(n**3):
        place = 0.21 * np.array([i % n, i // n % n, i // n**2 % n]) + (0, 0, 0.2)
        place += rng.uniform(-1e-3, 1e-3, 3)
        mass = float(np.exp(rng.uniform(0, np.log(10))))
        bodies.append(ball(f'b{i}', 0.1, place, mass=mass, material=material))
    sim = Simulation(scene(bodies, dt=0.004))
    assert largest_rise(sim, 250) < 0.2 * MANY
    # of some hundred kg m/s and kg m^2/s that the balls give each other
    assert np.abs(sim.momentum()[:2]).max() < 1e-12
    assert abs(sim.angular_momentum()[2]) < 1e-12


def test_loads_that_change_lift_no_capsule_in_a_jump():
    """
    A capsule that turns and spins on ice, one end 1.24 mm in it: the other end clatters, and with
    each blow the first sinks a little deeper, until it comes out. At once, that is 1e-4.
    """
    tilt = 0.5 * np.arcsin((1.24e-3 + 5e-5) / 0.28)
    body = Body(
        'capsule', Capsule(0.112, 0.28), 96.0, inertia=np.diag([1.6, 1.6, 0.8]),
        initial=motion(
            (0, 0, 0.112 - 0.6e-3), q=(0, np.sin(np.pi / 4 + tilt), 0, np.cos(np.pi / 4 + tilt)),
            turn=(4.4, 1.0, -7.63),
        ), material=Material(friction=0.0, restitution=0.3),
    )  # fmt: skip
    sim = Simulation(scene([ground(material={'friction': 0.0}), body], dt=0.004))
    assert largest_rise(sim, 300) < FEW


@pytest.mark.parametrize('seed', [3, 6, 9, 37, 47, 55])
def test_a_hull_that_tumbles_over_the_ground_sinks_in_no_deeper_than_others(seed):
    """
    Corners that come down within a tick are foreseen, also where more than four are near: else
    such a hull of 10 cm sinks in by 2 to 9 mm. What is deeper than a thousandth of the size comes
    out at a rate, so a half of a millimetre may be seen.
    """
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(14, 3))
    corners *= 0.1 / np.linalg.norm(corners, axis=1)[:, None]
    q = rng.normal(size=4)
    start = motion(
        (0, 0, 0.2), q=q / np.linalg.norm(q), velocity=(0, 0, -1), turn=15 * rng.normal(size=3)
    )
    shape = ConvexHull(corners)
    body = Body('hull', shape, 1.0, inertia=np.eye(3) * 0.004, initial=start)
    sim = Simulation(scene([ground(), body], dt=0.004))
    least = 0.0
    for _ in range(250):
        sim.step()
        of_hull = sim.state.values[1]
        turned = shape.vertices @ so3.matrix_from_quaternion(of_hull[3:7]).T
        least = min(least, of_hull[2] + turned[:, 2].min())
    assert least > -5e-4


@pytest.mark.parametrize('draws', [5, pytest.param(10, marks=pytest.mark.long)])
@pytest.mark.parametrize('spin', [15.0, 80.0])
@pytest.mark.parametrize(
    'shape', [Capsule(0.05, 0.15), Box((0.1, 0.14, 0.2))], ids=['capsule', 'box']
)
def test_what_spins_on_an_end_or_a_corner_sinks_in_no_deeper_than_what_rests(shape, spin, draws):
    """
    A point that turns moves on an arc: along its tangent, of ten draws some sink in by 0.3 to 0.7
    mm. What is left is the overlap of impacts, 0.04 mm at most in 80 draws.
    """
    ends = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * (
        (0, 0, shape.length) if isinstance(shape, Capsule) else shape.size
    )
    layer = shape.radius if isinstance(shape, Capsule) else 0.0
    least = 0.0
    for seed in range(draws):
        rng = np.random.default_rng(seed)
        start = motion(
            (0, 0, 0.2), q=Rotation.random(random_state=seed).as_quat(), velocity=(0, 0, -1),
            turn=spin * rng.normal(size=3),
        )  # fmt: skip
        body = Body('body', shape, 1.0, inertia=np.diag([4e-3, 4e-3, 3e-3]), initial=start)
        sim = Simulation(scene([ground(), body], dt=0.004))
        for _ in range(200):
            sim.step()
            state = sim.state.values[1]
            turned = ends @ so3.matrix_from_quaternion(state[3:7]).T
            least = min(least, state[2] + turned[:, 2].min() - layer)
    assert least > -6e-5


def test_a_ball_that_spins_off_its_centre_sinks_in_no_deeper_than_others():
    """
    Nothing of it but the arc of its middle tells such a ball, its inertia a number, from one that
    turns about its centre: along the tangent it sinks in by 0.6 mm and gains 2e-5.
    """
    least = 0.0
    for seed in range(10):
        start = motion(
            (0, 0, 0.3), q=Rotation.random(random_state=seed).as_quat(), velocity=(0, 0, -1),
            turn=15 * np.random.default_rng(seed).normal(size=3),
        )  # fmt: skip
        body = Body(
            'ball', Sphere(0.1), 1.0, inertia=np.eye(3) * 4e-3, center_of_mass=(0, 0, 0.05),
            initial=start,
        )  # fmt: skip
        sim = Simulation(scene([ground(), body], dt=0.004))
        for _ in range(200):
            sim.step()
            state = sim.state.values[1]
            middle = state[2] - 0.05 * so3.matrix_from_quaternion(state[3:7])[2, 2]
            least = min(least, middle - 0.1)
    assert least > -6e-5


@pytest.mark.parametrize('on', ['plane', 'box', 'hull'])
@pytest.mark.parametrize('seed', [32, 36])
def test_a_disc_that_tumbles_gains_no_energy_whatever_the_ground_is_made_of(on, seed):
    """
    As a prism, on a fixed hull, it would sink in by 4 mm and gain 8e-4.
    """
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    start = motion(
        (0, 0, 0.2), q=q / np.linalg.norm(q), velocity=(0, 0, -1), turn=15 * rng.normal(size=3)
    )
    disc = Body(
        'disc', Cylinder(0.1, 0.02), 1.0, inertia=np.diag([4e-3, 4e-3, 3e-3]), initial=start
    )
    block = np.array(list(itertools.product((-2.0, 2.0), (-2.0, 2.0), (-1.0, 0.0))))
    grounds = {
        'plane': ground(),
        'box': box('ground', (4.0, 4.0, 1.0), (0, 0, -0.5), fixed=True),
        'hull': Body('ground', ConvexHull(block), 0.0, fixed=True),
    }
    sim = Simulation(scene([grounds[on], disc], dt=0.004))
    assert largest_rise(sim, 250) < FEW


def drawn_shape(rng, size):
    """
    Box, ball, cylinder, disc or capsule, `size` its largest half width.
    """
    shares = rng.uniform(0.4, 1.0, 3)
    return (
        Box(2 * size * shares), Sphere(size), Cylinder(size * shares[0], 2 * size * shares[1]),
        Cylinder(size, 0.3 * size * shares[0]),
        Capsule(0.7 * size * shares[0], 2 * size * shares[1]),
    )[rng.integers(5)]  # fmt: skip


def drawn_body(name, rng, size, place, *, velocity, spin, **material):
    """
    A body of a drawn shape, turned at random.
    """
    shape = drawn_shape(rng, size)
    mass = float(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))
    inertia = mass * size**2 * np.diag(rng.uniform(0.35, 0.5, 3))
    q = rng.normal(size=4)
    start = motion(
        place, q=q / np.linalg.norm(q), velocity=velocity, turn=spin * rng.normal(size=3)
    )
    return Body(name, shape, mass, inertia=inertia, material=Material(**material), initial=start)


RIDGE = [[x, y, z] for x in (-1.0, 1.0) for y, z in ((-0.5, -0.3), (0.5, -0.3), (0.0, 0.0))]
LYING = (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))
# fixed, 0.8 m high and some 0.8 m wide: its shape, its attitude, and where it is
ROUND_GROUND = {
    'ball': (Sphere(0.4), None, 0.4),
    'capsule': (Capsule(0.3, 0.6), LYING, 0.5),
    'ridge': (ConvexHull(np.array(RIDGE)), None, 0.8),
    'block': (Box((0.5, 0.5, 0.8)), None, 0.4),
    'drum': (Cylinder(0.4, 0.8), None, 0.4),
}


@pytest.mark.parametrize('seeds', [7, pytest.param(20, marks=pytest.mark.long)])
@pytest.mark.parametrize('on', ROUND_GROUND)
def test_what_tumbles_over_round_ground_and_edges_gains_no_energy(on, seeds):
    """
    The normal turns within the tick, so contacts give what they should not: up to 4e-4 of the
    energy in ten of these draws. It is taken back.
    """
    shape, q, height = ROUND_GROUND[on]
    fixed = Body(
        on, shape, 0.0, fixed=True, material=Material(friction=0.5),
        initial=motion((0, 0, height), q=q or (0, 0, 0, 1)),
    )  # fmt: skip
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        place = (*(0.05 * rng.normal(size=2)), 1.2)
        body = drawn_body('body', rng, 0.1, place, velocity=(0, 0, -1), spin=8.0, friction=0.5)
        sim = Simulation(scene([ground(material={'friction': 0.5}), fixed, body], dt=0.004))
        assert largest_rise(sim, 300) < FEW, seed


@pytest.mark.parametrize('friction', [0.0, 0.5])
@pytest.mark.parametrize('seeds', [7, pytest.param(20, marks=pytest.mark.long)])
def test_what_floats_and_gains_keeps_its_momenta_all_the_same(friction, seeds):
    """
    Six mixed bodies meet in free space: what is taken back of gains is motion of the bodies
    against each other, never of their whole.
    """
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        bodies = []
        for i in range(6):
            place = 0.6 * np.array([i % 3, i // 3, 0.0])
            velocity = np.array([0.6, 0.3, 0.0]) - place + 0.1 * rng.normal(size=3)
            bodies.append(
                drawn_body(f'b{i}', rng, 0.15, place, velocity=velocity, spin=4.0,
                           friction=friction, restitution=0.5)
            )  # fmt: skip
        sim = Simulation(scene(bodies, gravity=(0, 0, 0), dt=0.004))
        linear, angular = sim.momentum(), sim.angular_momentum()
        assert largest_rise(sim, 400) < MANY, seed
        # some ten kg m/s and kg m^2/s, some hundred impulses
        assert np.abs(sim.momentum() - linear).max() < 1e-13, seed
        assert np.abs(sim.angular_momentum() - angular).max() < 1e-13, seed


@pytest.mark.parametrize('seed', [10, 21, 30])
def test_a_disc_whose_end_hits_a_ridge_is_not_thrown_as_if_it_rolled_on_its_rim(seed):
    """
    The end lies on the edge of a fixed prism: points that went round with a rim would gain 0.07 to
    0.2, and what edges of prisms and corners of discs leave unforeseen, up to 7e-4, is taken back.
    """
    rng = np.random.default_rng(seed)
    q = Rotation.random(random_state=seed).as_quat()
    ridge = [[x, y, z] for x in (-1.0, 1.0) for y, z in ((-0.5, -0.3), (0.5, -0.3), (0.0, 0.0))]
    material = {'friction': 0.5}
    prism = Body(
        'prism', ConvexHull(np.array(ridge)), 0.0, fixed=True, material=Material(**material),
        initial=motion((0, 0, 0.4)),
    )  # fmt: skip
    disc = Body(
        'disc', Cylinder(0.1, 0.02), 1.0, inertia=np.diag([4e-3, 4e-3, 3e-3]),
        material=Material(**material),
        initial=motion(
            (*(0.05 * rng.normal(size=2)), 1.2), q=q, velocity=(0, 0, -1),
            turn=8 * rng.normal(size=3),
        ),
    )  # fmt: skip
    sim = Simulation(scene([ground(material=material), prism, disc], dt=0.004))
    assert largest_rise(sim, 250) < FEW


def test_energy_of_elastic_balls_rises_in_no_tick():
    """
    Verification case V26, of what falls and bounces.
    """
    assert largest_rise(block_of_balls(0.21, 1.0, 0.004), 250) < MANY


def inelastic_columns():
    """
    Five columns of five rough balls, a centimetre apart: all but the lowest land on what lands.
    """
    rng = np.random.default_rng(1)
    balls = []
    for i in range(25):
        place = (0.3 * (i % 5) + rng.normal() * 1e-3, rng.normal() * 1e-3, 0.11 + 0.21 * (i // 5))
        balls.append(ball(f'b{i}', 0.1, place, mass=10.0, material={'friction': 0.5}))
    return Simulation(scene([ground(material={'friction': 0.5}), *balls], dt=0.004))


def test_energy_of_inelastic_balls_that_fall_onto_each_other_rises_in_no_tick():
    assert largest_rise(inelastic_columns(), 150) < MANY


@pytest.mark.parametrize('size', [0.2, 0.02])
def test_energy_of_boxes_that_begin_in_each_other_rises_in_no_tick(size):
    """
    Cubes in the air that overlap by up to half of their size: they part without being thrown.
    """
    rng = np.random.default_rng(10)
    bodies = []
    for i in range(40):
        q = rng.normal(size=4)
        place = (*(size * rng.uniform(-1.5, 1.5, 2)), size * (1.5 + 0.8 * i))
        bodies.append(box(f'b{i}', size, place, q=q / np.linalg.norm(q)))
    sim = Simulation(scene([ground(material={'friction': 0.5}), *bodies], dt=0.004))
    assert largest_rise(sim, 60) < MANY
