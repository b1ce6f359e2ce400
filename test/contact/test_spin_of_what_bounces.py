# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The acceleration of a separation: spin that moves no surface changes no bounce.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Box, Capsule, Cylinder, Plane
from rigid_body_sim.physics.simulation import Simulation

from .touching import G, ball, box, ground, motion, scene

DT = 0.004  # [s] the usual tick of the shipped scenes
R = 0.05  # [m]
LYING = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # axis along -y
SMOOTH = {'friction': 0.0}


def of_revolution(name, shape, position, *, material, **of_motion):
    """
    A solid cylinder of 1 kg in one of the shapes that are round about z.
    """
    across = R * R / 4 + shape.length**2 / 12
    return Body(
        name, shape, 1.0, inertia=np.diag([across, across, R * R / 2]),
        initial=motion(position, **of_motion), material=Material(**material),
    )  # fmt: skip


def spinning(kind, name, x, drop, spin, material):
    """
    A body that falls on a plane, spinning so that no point of its surface moves up or down.
    """
    place = (x, 0.0, R + drop)
    if kind == 'ball':
        return ball(name, R, place, turn=spin * np.array([0.6, 0.64, 0.48]), material=material)
    shape = Capsule(R, 0.1) if 'capsule' in kind else Cylinder(R, 2 * R)
    q, axis = ((0, 0, 0, 1), (0, 0, 1)) if 'standing' in kind else (LYING, (0, 1, 0))
    if 'turning' in kind:
        axis = (0, 0, 1)  # about the vertical, though it lies
    if kind == 'standing capsule':
        place = (x, 0.0, R + 0.05 + drop)
    return of_revolution(name, shape, place, q=q, turn=spin * np.array(axis), material=material)


KINDS = (
    'ball', 'lying capsule', 'standing capsule', 'lying cylinder', 'standing cylinder',
    'lying cylinder, turning',
)  # fmt: skip


def test_spin_does_not_change_how_high_a_round_body_bounces():
    e = 0.5
    material = SMOOTH | {'restitution': e}
    drops = np.linspace(0.5, 0.54, 4 * len(KINDS))  # [m] at all phases of the tick
    spins = [0.0, 30.0, 100.0, 500.0]
    bodies = [
        spinning(kind, f'{kind} {spin}', 0.5 * (4 * k + s), drops[4 * k + s], spin, material)
        for k, kind in enumerate(KINDS)
        for s, spin in enumerate(spins)
    ]
    sim = Simulation(scene([ground(material=SMOOTH), *bodies], dt=DT))
    start = sim.state.position[1 : len(bodies) + 1, 2]
    top = np.full(len(bodies), -1.0)
    for _ in range(120):
        sim.step()
        up = np.maximum(sim.state.velocity[1 : len(bodies) + 1, 2], 0.0)
        apex = sim.state.position[1 : len(bodies) + 1, 2] + up**2 / (2 * G)
        top = np.where(up > 0.0, np.maximum(top, apex), top)
    rise, law = top - (start - drops), e * e * drops
    # what they sink in by while they are held at the surface: g/(4 omega^2) of 0.125 m
    assert np.abs(rise / law - 1.0).max() < 3e-5


def _smooth_strikes(rng, draws):
    """
    Bodies of revolution at any attitude that fly at 3 m/s at what is fixed at any attitude, spin
    about their axes by 50 to 500 rad/s, and have no friction: fixed ones, then as many that fly.
    """
    fixed, flying = [], []
    for number in range(draws):
        radius, size = 10.0 ** rng.uniform(-1.3, -0.5), rng.uniform(1.0, 4.0)
        length, wide = radius * rng.uniform(0.3, 3.0), radius * size
        smooth = {'friction': 0.0, 'restitution': rng.uniform(0.0, 0.7)}
        at = np.array((20.0 * number, 0.0, 0.0))
        q, q_fixed = (x / np.linalg.norm(x) for x in rng.normal(size=(2, 4)))
        target = (
            Cylinder(wide, 2.0 * wide), Capsule(wide, 2.0 * wide), Box((2.0 * wide,) * 3),
        )[number % 3]  # fmt: skip
        shape = (Cylinder if number % 4 else Capsule)(radius, length)
        aside = wide * rng.uniform(-0.5, 0.5, 2)
        fixed.append(
            Body(
                f'target {number}',
                target,
                0.0,
                fixed=True,
                material=Material(**smooth),
                initial=motion(at, q=q_fixed),
            )
        )
        flying.append(
            Body(
                f'body {number}',
                shape,
                1.0,
                inertia=of_shape(shape, mass=1.0).inertia,
                material=Material(**smooth),
                initial=motion(
                    at + (*aside, 2.3 * wide + radius + length),
                    q=q,
                    velocity=(0.0, 0.0, -3.0),
                    turn=rng.uniform(50.0, 500.0) * rotation.rotate(q, (0.0, 0.0, 1.0)),
                ),
            )
        )
    return [*fixed, *flying]


def _spin_and_energy(sim, of):
    """
    Angular velocity [rad/s] about their axes of some bodies of 1 kg, and energy [J] without it.
    """
    turns = np.einsum('nji,nj->ni', sim.orientation_matrices()[of], sim.state.angular_velocity[of])
    across = np.array([body.inertia[0, 0] for body in sim.scene.bodies[of]])
    energy = 0.5 * (sim.state.velocity[of] ** 2).sum(axis=1)
    return turns[:, 2], energy + 0.5 * across * (turns[:, :2] ** 2).sum(axis=1)


def test_what_is_smooth_neither_brakes_nor_throws_what_spins_about_its_axis():
    """
    The force on a smooth surface of revolution passes through its axis. So in the tick in which
    they strike the sides, rims, edges and corners of cylinders, capsules and boxes, spins stay,
    but for the turn of the axis behind the impact in that tick (5e-3 in nearly all of 600 draws),
    and no other energy is won. By normals between chords of prisms up to a tenth of the spin was
    lost, and the rest of the energy grew up to 130-fold.
    """
    draws = 60
    sim = Simulation(scene(_smooth_strikes(np.random.default_rng(5), draws), gravity=(0, 0, 0)))
    of = slice(draws, 2 * draws)
    spin, energy = _spin_and_energy(sim, of)
    waits = np.ones(draws, dtype=bool)
    for _ in range(600):
        sim.step()
        contacts = sim.contacts()
        struck = np.unique(contacts.bodies[np.abs(contacts.impulse).max(axis=1) > 0.0]) - draws
        new = [number for number in struck[struck >= 0] if number < draws and waits[number]]
        spin_now, energy_now = _spin_and_energy(sim, of)
        for number in new:
            waits[number] = False
            assert energy_now[number] < (1.0 + 1e-3) * energy[number], number
            assert spin_now[number] == pytest.approx(spin[number], rel=6e-3), number
    assert waits.sum() < draws / 4  # the others miss


def test_a_rolling_ball_comes_back_from_a_smooth_wall_with_its_share():
    for speed in (1.0, 3.0, 10.0):
        wall = Body('wall', Plane((-1.0, 0.0, 0.0), -1.0), 0.0, fixed=True)
        rolls = ball(
            'ball', 0.1, (0, 0, 0.1), velocity=(speed, 0, 0), turn=(0, speed / 0.1, 0),
            material=SMOOTH | {'restitution': 0.8},
        )  # fmt: skip
        sim = Simulation(scene([ground(material=SMOOTH), wall, rolls], dt=DT))
        sim.step(round(1.5 / speed / DT))
        # what the soft contact of the impact leaves of its approach
        assert sim.state.velocity[2, 0] == pytest.approx(-0.8 * speed, rel=1e-7)


@pytest.mark.parametrize('friction', [0.2, 0.8])
@pytest.mark.parametrize('e', [0.4, 0.7, 1.0])
def test_a_ball_that_rolls_against_a_smooth_wall_on_rough_ground_rolls_back_by_the_law(
    e, friction
):
    """
    The wall takes (1 + e) v and no spin; friction lets it roll again, which keeps the angular
    momentum about the ground: 7/5 v' = v - (1 + e) v + 2/5 v. At all phases of the tick.
    """
    wall = Body('wall', Plane((-1.0, 0.0, 0.0), -1.0), 0.0, fixed=True)
    floor = ground(material={'friction': friction})
    speeds = np.linspace(0.8, 1.1, 7)  # [m/s]
    for speed in speeds:
        rolls = ball(
            'ball', 0.1, (0.8, 0, 0.1), velocity=(speed, 0, 0), turn=(0, speed / 0.1, 0),
            material={'friction': friction},
        )  # fmt: skip
        pairs = ({'bodies': ('ball', 'wall'), 'friction': 0.0, 'restitution': e},)
        sim = Simulation(scene([floor, wall, rolls], dt=0.004, pairs=pairs))
        sim.step(round((0.15 + speed / (friction * G)) / 0.004))
        law = (2.0 / 7.0 - 5.0 / 7.0 * e) * speed
        assert sim.state.velocity[2, 0] == pytest.approx(law, abs=1e-9)  # rounding; 2e-2 is a tick


@pytest.mark.parametrize('ways', [2, pytest.param(40, marks=pytest.mark.long)])
def test_it_rolls_back_by_the_law_also_if_it_meets_the_wall_at_the_end_of_a_substep(ways):
    """
    Whether it touches before or behind that end is rounding, by which friction of the ground must
    not count a substep more or less (mu g h, 2e-3 m/s).
    """
    wall = Body('wall', Plane((-1.0, 0.0, 0.0), -1.0), 0.0, fixed=True)
    floor = ground(material={'friction': 0.2})
    pairs = ({'bodies': ('ball', 'wall'), 'friction': 0.0, 'restitution': 0.4},)
    rng = np.random.default_rng(7)
    for number in range(ways):
        speed = 0.8 if number == 0 else rng.uniform(0.5, 3.0)
        for quarter in range(4):
            for beside in (0.0, 1e-15, -3e-14, -1e-12, 1e-12, 1e-9, 3e-7):
                way = speed * DT * (311 + quarter / 4 + beside)  # so far that roundings add up
                rolls = ball(
                    'ball', 0.1, (0.9 - way, 0, 0.1), velocity=(speed, 0, 0),
                    turn=(0, speed / 0.1, 0), material={'friction': 0.2},
                )  # fmt: skip
                sim = Simulation(scene([floor, wall, rolls], dt=DT, pairs=pairs))
                sim.step(round((way / speed + speed / (0.2 * G)) / DT))
                law = (2.0 / 7.0 - 5.0 / 7.0 * 0.4) * speed
                assert sim.state.velocity[2, 0] == pytest.approx(law, abs=2e-6 * speed)


@pytest.mark.parametrize(('friction', 'of_wall'), [(0.3, 0.3), (1.0, 1.0), (0.6, 0.1)])
@pytest.mark.parametrize('e', [0.3, 1.0])
def test_a_ball_that_rolls_against_a_rough_wall_rolls_back_by_the_law(e, friction, of_wall):
    """
    Friction lifts it by J = min(mu (1 + e), 2/7) m v, which leaves v - 5/2 J/m of its spin; where
    it lands it rolls in the end. What it weighs within the tick the wall has no part in.
    """
    wall = Body('wall', Plane((-1.0, 0.0, 0.0), -1.0), 0.0, fixed=True)
    floor = ground(material={'friction': friction})
    pairs = ({'bodies': ('ball', 'wall'), 'friction': of_wall, 'restitution': e},)
    for speed in np.linspace(0.8, 1.1, 5):  # [m/s] at all phases of the tick
        rolls = ball(
            'ball', 0.1, (0.8, 0, 0.1), velocity=(speed, 0, 0), turn=(0, speed / 0.1, 0),
            material={'friction': friction},
        )  # fmt: skip
        sim = Simulation(scene([floor, wall, rolls], dt=DT, pairs=pairs))
        sim.step(round((0.3 + 2 * speed / (friction * G)) / DT))
        spin = 1.0 - 2.5 * min(of_wall * (1 + e), 2 / 7)
        law = (-5 * e + 2 * spin) / 7 * speed
        # 2e-3 is what the wall carries of it in a substep; 4e-7 to 4e-6 are seen, by the phase
        assert sim.state.velocity[2, 0] == pytest.approx(law, abs=5e-6)


@pytest.mark.parametrize('draws', [6, pytest.param(60, marks=pytest.mark.long)])
def test_a_ball_that_bounces_on_a_slope_slips_on_by_what_pulls_behind_the_impact(draws):
    """
    Velocity along the slope and spin after one bounce: those of an impact at its instant.
    """
    rng = np.random.default_rng(3)
    for _ in range(draws):
        slope, e, friction = rng.uniform(0.2, 1.0), rng.uniform(0.3, 1.0), rng.uniform(0.5, 1.0)
        up = np.array([math.sin(slope), 0.0, math.cos(slope)])
        along = np.array([math.cos(slope), 0.0, -math.sin(slope)])
        down, slides, way = rng.uniform(2.0, 3.0), rng.uniform(-0.5, 0.5), rng.uniform(0.02, 0.1)
        velocity = slides * along - down * up
        material = {'friction': friction, 'restitution': e}
        flies = ball('ball', 0.1, (0.1 + way) * up, velocity=velocity, material=material)
        sim = Simulation(scene([ground(slope=slope, material=material), flies], dt=DT))
        pull = G * math.cos(slope)
        meets = (math.sqrt(down**2 + 2 * pull * way) - down) / pull
        sim.step(math.ceil(meets / DT) + 3)
        slip = slides + G * math.sin(slope) * meets  # it sticks: 2/7 of it
        after = G * math.sin(slope) * (sim.time - meets)
        # they meet when the velocity of approach has passed the gap: so much too early at most
        late = pull * DT**2 / (2 * down) * G * math.sin(slope)
        speed, spin = sim.state.velocity[1] @ along, sim.state.angular_velocity[1, 1] * 0.1
        assert speed == pytest.approx(5 / 7 * slip + after, abs=2 / 7 * late)
        assert spin == pytest.approx(5 / 7 * slip, abs=5 / 7 * late)


def test_a_ball_on_a_table_hands_its_speed_to_the_one_it_hits_however_it_spins():
    radius = 0.0286
    elastic = SMOOTH | {'restitution': 1.0}
    for speed in (0.5, 2.0, 6.0):
        cue = ball('cue', radius, (-0.3, 0, radius), velocity=(speed, 0, 0), material=elastic,
                   turn=(40.0, speed / radius, 10.0))  # fmt: skip
        other = ball('other', radius, (0, 0, radius), material=elastic)
        sim = Simulation(scene([ground(material=elastic), cue, other], dt=DT))
        sim.step(round(0.35 / speed / DT))
        # the table carries both: what one is sunk in more than the other tilts the normal
        assert sim.state.velocity[2, 0] == pytest.approx(speed, rel=1e-6)


@pytest.mark.parametrize('draws', [12, pytest.param(200, marks=pytest.mark.long)])
def test_a_billiard_shot_obeys_its_law_from_any_side_until_both_balls_roll(draws):
    """
    A ball that rolls, or slides, hits one at rest off its middle: smooth balls on a rough table.
    Each rolls in the end with 5/7 of what the shot gave it and 2/7 of what it spun with.
    """
    rng = np.random.default_rng(5)
    for _ in range(draws):
        radius, speed = rng.choice([0.0286, 0.1]), rng.uniform(0.5, 4.0)
        e, friction, aside = rng.choice([0.5, 0.95, 1.0]), 0.3, rng.uniform(-0.9, 0.9)
        ahead = 2 * radius * math.sqrt(1 - aside**2)
        material = {'friction': friction}
        rolls, way = rng.integers(2), rng.uniform(0.02, 0.04)
        cue = ball(
            'cue', radius, (-ahead - way, 2 * radius * aside, radius), material=material,
            velocity=(speed, 0, 0), turn=(0, rolls * speed / radius, 0),
        )  # fmt: skip
        other = ball('other', radius, (0, 0, radius), material=material)
        pairs = ({'bodies': ('cue', 'other'), 'friction': 0.0, 'restitution': e},)
        sim = Simulation(scene([ground(material=material), cue, other], dt=0.004, pairs=pairs))
        sim.step(round((0.05 / speed + speed / (friction * G)) / 0.004))
        normal = np.array([ahead / (2 * radius), -aside])
        slides = math.sqrt(max(speed**2 - 2 * friction * G * way, 0.0))
        there = speed if rolls else max(slides, 5 / 7 * speed)  # slower it rolls
        hit = 0.5 * (1 + e) * there * normal[0] * normal
        rolled = (5 + 2 * rolls) / 7 * speed
        law = np.array([(rolled, 0.0) - 5 / 7 * hit, 5 / 7 * hit])
        # friction until the shot is that of the tick before: the load trembles when it is put on,
        # and where the ball begins to roll in the tick of the shot, it is braked to the shot
        begins_to_roll = abs(slides - 5 / 7 * speed) < friction * G * DT
        braked = friction * G * DT if begins_to_roll else 1e-4 * speed
        off = np.abs(sim.state.velocity[1:3, :2] - law).max()
        assert off < (1e-9 * speed if rolls else braked)


@pytest.mark.parametrize('e', [0.5, 1.0])
@pytest.mark.parametrize('friction', [0.1, 0.3])
def test_friction_of_two_balls_that_meet_on_a_table_presses_neither_into_it(friction, e):
    """
    The one that rolls against the other presses it down, wherever in the tick they meet.
    """
    speed, radius, material = 4.0, 0.1, {'friction': 0.3}
    pairs = ({'bodies': ('cue', 'other'), 'friction': friction, 'restitution': e},)
    for phase in np.linspace(0.0, 1.0, 5):
        cue = ball(
            'cue', radius, (-2 * radius - 0.02 - phase * speed * 0.004, 0, radius),
            velocity=(speed, 0, 0), turn=(0, speed / radius, 0), material=material,
        )  # fmt: skip
        other = ball('other', radius, (0, 0, radius), material=material)
        sim = Simulation(scene([ground(material=material), cue, other], dt=0.004, pairs=pairs))
        for _ in range(12):
            sim.step()
            assert sim.state.position[1:3, 2].min() > radius - 1e-4  # 1e-3 is what a tick presses


@pytest.mark.parametrize('spin', [200.0, 500.0, -300.0])
def test_friction_of_an_impact_at_high_spin_is_that_of_coulomb(spin):
    e, mu, fall = 0.5, 0.3, 3.0
    drop = ball(
        'b', R, (0, 0, 0.5), velocity=(0.5, 0, -fall), turn=(0, spin, 0),
        material={'restitution': e, 'friction': mu},
    )  # fmt: skip
    floor = ground(material={'friction': mu})
    sim = Simulation(scene([floor, drop], gravity=(0, 0, 0), dt=DT))
    sim.step(60)
    change = math.copysign(mu * (1 + e) * fall, spin * R - 0.5)  # it slides throughout
    v, w = sim.state.velocity[1], sim.state.angular_velocity[1]
    assert v == pytest.approx([0.5 + change, 0.0, e * fall], rel=1e-9)
    assert w[1] == pytest.approx(spin - 2.5 * change / R, rel=1e-9)


def test_a_ball_bounces_off_a_face_that_turns_by_the_speed_of_that_face():
    material = SMOOTH | {'restitution': 0.8}
    errors = []
    for dt in (DT, DT / 4):
        paddle = box(
            'paddle', (1, 1, 0.1), (0, 0, -0.05), mass=2.0, turn=(0, 1.5, 0), material=material
        )
        hits = ball('ball', R, (0.3, 0, 0.2), velocity=(-1.0, 0, -2.0), turn=(50, 100, 0),
                    material=material)  # fmt: skip
        sim = Simulation(scene([paddle, hits], gravity=(0, 0, 0), dt=dt))
        energy = sim.energy()
        sim.step(round(0.1 / dt))
        assert sim.energy() < energy
        errors.append(_rebound_error(sim.state.velocity[1], 1.5, 0.8))
    # the impulse keeps the normal of the start of the tick: of first order, and none of what
    # the acceleration of a material point of the ball would add (0.4 m/s)
    assert errors[0] < 0.01
    assert errors[1] < 0.004


def _rebound_error(velocity, rate, e):
    """
    Distance of a velocity from that of the exact impact on the turning paddle [m/s].
    """
    inertia = 2.0 * (1.0 + 0.01) / 12

    def gap(t):
        normal = np.array([math.sin(rate * t), 0.0, math.cos(rate * t)])
        arm = np.array([0.3 - t, 0.0, 0.2 - 2.0 * t]) - [0.0, 0.0, -0.05]
        return normal @ arm - 0.05 - R, normal, arm

    low, high = 0.0, 0.2
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap(middle)[0] > 0.0 else (low, middle)
    _, normal, arm = gap(low)
    at = arm - R * normal
    lever = np.cross(at, normal)[1]
    approach = normal @ (np.array([-1.0, 0, -2.0]) - np.cross([0.0, rate, 0.0], at))
    impulse = -(1 + e) * approach / (1.0 + 0.5 + lever**2 / inertia)
    return np.abs(velocity - (np.array([-1.0, 0, -2.0]) + impulse * normal)).max()


def test_spin_about_its_centre_changes_nothing_of_the_path_of_a_smooth_ball():
    paths = []
    for spin in (0.0, 500.0):
        table = box('table', 1.0, (0, 0, -0.5), fixed=True, material=SMOOTH)
        rolls = ball('b', R, (-0.3, 0, R + 0.01), velocity=(1, 0, 0), turn=(spin, 0, 0.5 * spin),
                     material=SMOOTH | {'restitution': 0.3})  # fmt: skip
        sim = Simulation(scene([table, rolls], dt=DT))
        sim.step(200)
        paths.append(np.hstack([sim.state.position[1], sim.state.velocity[1]]))
    # round-off; ticks that were cut for its spin would differ by 1e-7
    assert paths[0] == pytest.approx(paths[1], abs=1e-12)
