# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The laws of impacts with `contact: {mode: event}`, at ticks of 4 ms.

Every scene has the same kinds of bodies, so that all share one kernel: two witnesses fall far away
and meet nobody.
"""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import collision
from rigid_body_sim.exact.hard_spheres import hard_spheres
from rigid_body_sim.physics.state.impacts import KINDS

GRAVITY = 9.81  # [m/s^2]
DT = 0.004  # [s]
FAR = 1e6  # [m] the witnesses fall for longer than any run takes
RADIUS = 0.1  # [m]
WITNESSES = 3  # bodies of each scene that come first: the ground is one of them


def ball(name, position, velocity=(0, 0, 0), *, mass=1.0, radius=RADIUS, e=1.0, mu=0.0, spin=None):
    return {
        'name': name, 'mass': mass, 'restitution': e, 'friction': mu,
        'shape': {'type': 'sphere', 'radius': radius},
        'initial': {'position': list(position), 'velocity': list(velocity),
                    'angular_velocity': list(spin or (0, 0, 0))},
    }  # fmt: skip


def box(name, size, position, velocity=(0, 0, 0), *, mass=1.0, e=1.0, mu=0.0, spin=(0, 0, 0),
        turn=(0, 0, 0, 1)):  # fmt: skip
    return {
        'name': name, 'mass': mass, 'restitution': e, 'friction': mu,
        'shape': {'type': 'box', 'size': list(size)},
        'initial': {'position': list(position), 'velocity': list(velocity),
                    'angular_velocity': list(spin), 'orientation': list(turn)},
    }  # fmt: skip


def plane(name, normal, offset=0.0, mu=0.0):
    shape = {'type': 'plane', 'normal': list(normal), 'offset': offset}
    return {'name': name, 'shape': shape, 'friction': mu}


def world(*bodies, gravity=GRAVITY, ground=0.0, mu=0.0, dt=DT, mode='event'):
    """
    A simulation of bodies over the ground, with the witnesses.
    """
    witnesses = [
        plane('ground', (0, 0, 1), ground, mu),
        ball('far_ball', (FAR, 0, FAR), mu=0.5),
        box('far_box', (0.2, 0.3, 0.4), (-FAR, 0, FAR), mu=0.5),
    ]
    return Simulation(
        load_scene({
            'version': 1, 'name': 'impacts', 'dt': dt, 'gravity': [0, 0, -gravity],
            'contact': {'mode': mode}, 'bodies': [*witnesses, *bodies],
        })
    )  # fmt: skip


def steps(sim, duration):
    sim.step(round(duration / sim.dt))


# ---------------------------------------------------------------- bouncing


@pytest.mark.parametrize('e', [1.0, 0.8, 0.5])
def test_a_ball_bounces_at_the_instants_and_to_the_heights_of_the_closed_form(e):
    height = 1.0
    sim = world(ball('ball', (0, 0, height + RADIUS), e=e))
    steps(sim, 90.0 if e == 1.0 else 5.0)
    found = sim.impacts()
    found = found[found.kind == KINDS.index('impact')]
    law = collision.bounce_times(len(found), height=height, gravity=GRAVITY, restitution=e)
    assert len(found) >= {1.0: 100, 0.8: 40, 0.5: 12}[e]
    # round-off of a hundred flights: 1.4e-14 s
    np.testing.assert_allclose(found.time, law, rtol=1e-12, atol=1e-13)
    heights = (e * found.approach) ** 2 / (2 * GRAVITY)
    laws = height * e ** (2 * np.arange(1, len(found) + 1))
    np.testing.assert_allclose(heights, laws, rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(heights[:20], laws[:20], rtol=1e-12)


@pytest.mark.parametrize('e', [0.8, 0.5])
def test_the_series_of_bounces_is_summed_and_ends_at_the_instant_of_the_law(e):
    sim = world(ball('ball', (0, 0, 1 + RADIUS), e=e))
    steps(sim, 5.0)
    found = sim.impacts()
    fall = math.sqrt(2 / GRAVITY)
    assert found.time[-1] == pytest.approx(fall * (1 + e) / (1 - e), abs=1e-9)
    assert KINDS[found.kind[-1]] == 'summed'
    # all impulses together took the momentum of the fall, and bore the weight until the last one;
    # from there to the end of the series, which it stands for, the solver bears it
    last = found.time[-1] - 2 * e * found.approach[-1] / (GRAVITY * (1 - e))
    assert -found.impulse[:, 2].sum() == pytest.approx(GRAVITY * last, rel=1e-12)
    assert sim.state.position[WITNESSES][2] == pytest.approx(RADIUS, abs=1e-6)  # its sink
    assert abs(sim.state.velocity[WITNESSES][2]) < 1e-9


def test_an_elastic_ball_is_where_the_closed_form_says_after_100_s():
    sim = world(ball('ball', (0, 0, 1 + RADIUS)))
    energy = sim.energy()
    steps(sim, 100.0)
    assert sim.energy() == pytest.approx(energy, rel=1e-13)
    fall = math.sqrt(2 / GRAVITY)
    since = (100.0 + fall) % (2 * fall) - fall
    law = RADIUS + 1 - GRAVITY * since**2 / 2
    assert sim.state.position[WITNESSES][2] == pytest.approx(law, abs=1e-10)


def test_an_elastic_ball_between_six_planes_keeps_energy_and_place_over_100_s():
    start, velocity, half = np.array([0.1, -0.2, 0.3]), np.array([1.1, -0.7, 0.9]), 1.0
    walls = [
        plane('west', (1, 0, 0), -half), plane('east', (-1, 0, 0), -half),
        plane('south', (0, 1, 0), -half), plane('north', (0, -1, 0), -half),
        plane('ceiling', (0, 0, -1), -half),
    ]  # fmt: skip
    sim = world(*walls, ball('ball', start, velocity), gravity=0.0, ground=-half)
    energy = sim.energy()
    steps(sim, 100.0)
    assert sim.energy() == pytest.approx(energy, rel=1e-13)
    reach = half - RADIUS  # the way unfolds: a triangle wave along each axis
    unfolded = (start + velocity * 100.0 + reach) % (4 * reach)
    law = np.where(unfolded < 2 * reach, unfolded, 4 * reach - unfolded) - reach
    np.testing.assert_allclose(sim.state.position[-1], law, rtol=0, atol=1e-10)


def test_the_tick_does_not_matter_to_a_bounce():
    ends = []
    for dt in (0.02, 0.004, 0.001):
        sim = world(ball('ball', (0, 0, 1 + RADIUS), (0.3, 0, 0)), dt=dt)
        steps(sim, 8.8)
        ends.append(sim.state.position[WITNESSES])
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=0, atol=1e-12)


# ---------------------------------------------------------------- spheres


@pytest.mark.parametrize('e', [1.0, 0.9])
@pytest.mark.parametrize('gap', [0.0, 1e-3])
def test_in_a_cradle_an_impact_runs_from_ball_to_ball(e, gap):
    places = [(-0.5, 0, 1), *((number * (2 * RADIUS + gap), 0, 1) for number in range(4))]
    speeds = [(1, 0, 0)] + [(0, 0, 0)] * 4
    sim = world(
        *(ball(f'b{i}', x, v, e=e) for i, (x, v) in enumerate(zip(places, speeds, strict=True))),
        gravity=0.0,
    )
    steps(sim, 0.4)
    law, count = hard_spheres(places, speeds, mass=1.0, radius=RADIUS, restitution=e, duration=0.4)
    np.testing.assert_allclose(sim.state.velocity[WITNESSES:], law.velocity, rtol=0, atol=1e-12)
    np.testing.assert_allclose(sim.state.position[WITNESSES:], law.position, rtol=0, atol=1e-12)
    assert len(sim.impacts()) == count
    last = ((1 + e) / 2) ** 4
    assert sim.state.velocity[-1, 0] == pytest.approx(last, abs=1e-12)


@pytest.mark.parametrize('side', [1, -1])
@pytest.mark.parametrize('order', [(0, 1, 2), (2, 1, 0), (1, 0, 2)])
def test_of_impacts_at_one_instant_that_with_the_greatest_approach_comes_first(side, order):
    """
    Into a ball at rest run two that touch it, with 2 and 1 m/s, e = 1/2: by hand the first blow is
    that of the faster one, whichever side it comes from and wherever it stands in the scene. The
    other way round they would end at -0.0625, 0.140625 and 0.921875 m/s.
    """
    radius, speeds = 0.125, (2.0, 0.0, -1.0)  # gaps of zero to the last bit
    balls = [
        ball(f'b{i}', (side * 2 * radius * (i - 1), 0, 1), (side * v, 0, 0), radius=radius, e=0.5)
        for i, v in enumerate(speeds)
    ]
    sim = world(*(balls[i] for i in order), gravity=0.0)
    sim.step(1)
    after = [sim.state.velocity[WITNESSES + order.index(i), 0] for i in range(3)]
    by_hand = side * np.array([-0.15625, 0.28125, 0.875])
    np.testing.assert_allclose(after, by_hand, rtol=0, atol=1e-15)  # of a few roundings
    assert len(sim.impacts()) == 3


@pytest.mark.parametrize('mass', [1.0, 1e-2, 1e4])
@pytest.mark.parametrize('e', [0.0, 0.7, 1.0])
def test_an_oblique_impact_of_two_spheres_is_that_of_newton(mass, e):
    at, velocity = np.array([0.3, 0.12, 1.05]), np.array([-2.0, -0.1, 0.2])
    sim = world(ball('a', (0, 0, 1), e=e), ball('b', at, velocity, mass=mass, e=e), gravity=0.0)
    steps(sim, 0.2)
    free, _ = hard_spheres(
        [(0, 0, 1), at], [(0, 0, 0), velocity], mass=[1.0, mass], radius=RADIUS, restitution=e,
        duration=0.2,
    )  # fmt: skip
    size = np.abs(velocity).max()
    np.testing.assert_allclose(sim.state.velocity[-2:], free.velocity, atol=1e-12 * size, rtol=0)
    np.testing.assert_allclose(sim.state.position[-2:], free.position, atol=1e-12, rtol=0)


@pytest.mark.parametrize('mu', [0.05, 0.1, 0.3, 1.0])
@pytest.mark.parametrize('e', [0.0, 0.6, 1.0])
def test_a_sphere_that_strikes_a_rough_plane_slips_or_sticks(mu, e):
    sim = world(ball('ball', (0, 0, 0.5), (1.5, 0, -1), e=e, mu=mu), mu=mu, gravity=0.0)
    steps(sim, 0.5)
    if mu >= 2 * 1.5 / (7 * (1 + e)):
        law, spin = 5 * 1.5 / 7, 5 * 1.5 / 7 / RADIUS
    else:
        law, spin = 1.5 - mu * (1 + e), 5 * mu * (1 + e) / (2 * RADIUS)
    state = sim.state
    np.testing.assert_allclose(state.velocity[-1], (law, 0, e), rtol=0, atol=1e-12)
    np.testing.assert_allclose(state.angular_velocity[-1], (0, spin, 0), rtol=0, atol=1e-11)


@pytest.mark.parametrize('dt', [0.001, DT, 0.02])
@pytest.mark.parametrize('phase', [0.0, 0.23, 0.61, 0.97])
def test_a_bullet_meets_a_thin_wall_at_its_instant_whatever_the_tick(dt, phase):
    """300 m/s in front of 2 cm: six metres in a tick of 20 ms, and never through."""
    e, speed, mass, radius = 0.5, 300.0, 0.01, 0.005
    gap = speed * dt * (3 + phase)
    bullet = ball(
        'bullet', (-gap - radius - 0.01, 0, 0), (speed, 0, 0), mass=mass, radius=radius, e=e
    )
    sim = world(box('wall', (0.02, 1, 1), (0, 0, 0), mass=1000.0, e=e), bullet,
                gravity=0.0, ground=-10.0, dt=dt)  # fmt: skip
    sim.step(8)
    (instant,) = sim.impacts().time
    wall = mass * (1 + e) * speed / (1000.0 + mass)
    assert instant == pytest.approx(gap / speed, abs=1e-12)
    np.testing.assert_allclose(sim.state.velocity[-2:, 0], (wall, wall - e * speed), rtol=1e-12)
    left = 8 * dt - gap / speed
    at = -radius - 0.01 + (wall - e * speed) * left
    assert sim.state.position[-1, 0] == pytest.approx(at, abs=1e-12 * gap)


def test_216_elastic_balls_keep_their_energy_and_do_not_overlap():
    rng = np.random.default_rng(1)
    grid = np.stack(np.meshgrid(*[np.arange(6) * 0.21] * 3), axis=-1).reshape(-1, 3)
    places = grid + (0, 0, 1.101) + rng.uniform(-1e-3, 1e-3, grid.shape)
    sim = world(*(ball(f'b{i}', x, mass=10.0) for i, x in enumerate(places)))
    energy, count = sim.energy(), 0
    for _ in range(50):
        sim.step(25)
        count += len(sim.impacts())
        centers = sim.state.position[WITNESSES:]
        apart = np.linalg.norm(centers[:, None] - centers, axis=2) + np.eye(len(centers))
        assert apart.min() > 2 * RADIUS - 1e-10
        assert centers[:, 2].min() > RADIUS - 1e-10
    assert count > 3000
    assert sim.energy() == pytest.approx(energy, rel=1e-12)


# ---------------------------------------------------------------- boxes


@pytest.mark.parametrize('e', [0.0, 0.5, 1.0])
def test_a_rod_struck_beside_its_middle_takes_the_impulse_of_its_lever(e):
    length, arm, mass = 1.0, 0.37, 0.8
    rod = box('rod', (length, 0.1, 0.1), (0, 0, 1), mass=mass, e=e)
    sim = world(rod, ball('ball', (arm, 0.4, 1), (0, -2, 0), mass=0.3, e=e), gravity=0.0)
    steps(sim, 0.2)
    inertia = mass * (length**2 + 0.1**2) / 12
    impulse = (1 + e) * 2 / (1 / 0.3 + 1 / mass + arm**2 / inertia)
    assert np.linalg.norm(sim.impacts().impulse[0]) == pytest.approx(impulse, rel=1e-12)
    if e == 0.0:
        return  # they stay together, and the solver goes on with them
    state = sim.state
    np.testing.assert_allclose(state.velocity[-2], (0, -impulse / mass, 0), atol=1e-12)
    np.testing.assert_allclose(
        state.angular_velocity[-2], (0, 0, -arm * impulse / inertia), atol=1e-12
    )
    assert state.velocity[-1, 1] == pytest.approx(impulse / 0.3 - 2, abs=1e-12)


def test_an_elastic_smooth_cube_tumbles_without_loss():
    sim = world(box('cube', (0.2, 0.2, 0.2), (0, 0, 0.8), (0.5, 0.1, 0), spin=(3, 2, 5)))
    energy, spin = sim.energy(), sim.angular_momentum()
    state, mass = sim.state, 1.0
    push = mass * state.velocity[-1, :2]
    own = 0.2**2 / 6 * state.angular_velocity[-1, 2]
    steps(sim, 10.0)
    far = sim.angular_momentum() - spin
    assert sim.energy() == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(sim.state.velocity[-1, :2], push, rtol=0, atol=1e-12)
    assert 0.2**2 / 6 * sim.state.angular_velocity[-1, 2] == pytest.approx(own, abs=1e-12)
    assert abs(far[2]) < 1e-9 * FAR
    assert len(sim.impacts()) > 15


@pytest.mark.parametrize('seed', range(6))
def test_rough_boxes_that_tumble_never_gain_energy(seed):
    rng = np.random.default_rng(seed)
    turn = rng.normal(size=4)
    e, mu = rng.random(), rng.uniform(0, 1.5)
    sim = world(
        box('box', rng.uniform(0.1, 0.4, 3), (0, 0, 0.8), rng.normal(size=3), e=e, mu=mu,
            spin=4 * rng.normal(size=3), turn=turn / np.linalg.norm(turn)), mu=mu,
    )  # fmt: skip
    start = before = own_energy(sim)
    for _ in range(250):
        sim.step()
        now = own_energy(sim)
        assert now < before + OF_THE_SINK
        before = now
    assert now < start


# [J] what the solver may give back in a tick, between impacts: the weight of 1 kg times its sink
# g (m / m_eff) / omega^2 on a corner, m / m_eff <= 4, omega = pi / h with the substep h = 1 ms
OF_THE_SINK = 4 * GRAVITY**2 / (math.pi / (DT / 4)) ** 2


def own_energy(sim):
    """
    Energy [J] of the last body, of 1 kg: a box.
    """
    state, size = sim.state, np.array(sim.scene.bodies[-1].shape.size)
    moments = (np.sum(size**2) - size**2) / 12
    kinetic = state.velocity[-1] @ state.velocity[-1] / 2
    kinetic += moments @ state.angular_velocity_body[-1] ** 2 / 2
    return kinetic + GRAVITY * state.position[-1, 2]


def test_a_painleve_rod_jams_without_nan_or_gain():
    """
    A rod slides on its end at about tan a = 2 with mu = 2: no force keeps that end out while it
    slips, f_n = K_nn - mu K_tn < 0, and its impact runs on until slip stops.
    """
    angle, length, thick, mu = math.atan(2), 1.0, 0.06, 2.0
    c, s = math.cos(angle), math.sin(angle)
    turn = (0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2))  # its far end points down
    arm_x, arm_z = length / 2 * c - thick / 2 * s, -length / 2 * s - thick / 2 * c
    inertia = (length**2 + thick**2) / 12
    assert 1 + arm_x**2 / inertia + mu * arm_x * arm_z / inertia < 0
    rod = box('rod', (length, thick, thick), (0, 0, 0.02 - arm_z), (-1, 0, -0.2), e=0.5, mu=mu,
              turn=turn)  # fmt: skip
    sim = world(rod, mu=mu)
    start = before = own_energy(sim)
    for _ in range(300):
        sim.step()
        assert np.isfinite(sim.state.position).all()
        now = own_energy(sim)
        assert now < before + OF_THE_SINK
        before = now
    assert now < start


# ---------------------------------------------------------------- read-out and bits


def test_who_meets_nobody_keeps_the_bits_that_he_has_alone():
    alone = world()
    beside = world(ball('ball', (0, 0, 1 + RADIUS)))
    for sim in (alone, beside):
        steps(sim, 2.0)
    assert len(beside.impacts()) > 1
    assert (alone.state.values[1:] == beside.state.values[1:WITNESSES]).all()


def test_a_restored_run_goes_on_with_the_same_bits():
    def made():
        return world(
            ball('ball', (0, 0, 0.5), e=0.7), box('box', (0.2, 0.2, 0.2), (2, 0, 0.6),
                                                  spin=(1, 2, 3), e=0.4, mu=0.3), mu=0.3,
        )  # fmt: skip

    sim, other = made(), made()
    steps(sim, 0.6)
    other.restore(tick=sim.tick, state=sim.state_bytes(), slots={})
    for each in (sim, other):
        steps(each, 0.6)
    assert sim.state_bytes() == other.state_bytes()
    np.testing.assert_array_equal(sim.impacts().time, other.impacts().time)


def test_impacts_are_those_of_the_last_call_of_step_and_no_others():
    sim = world(ball('ball', (0, 0, 1 + RADIUS)))
    one = world(ball('ball', (0, 0, 1 + RADIUS)))
    steps(sim, 2.0)
    times, impulses = [], []
    for _ in range(round(2.0 / DT)):
        one.step()
        found = one.impacts()
        times += found.time.tolist()
        impulses += found.impulse.tolist()
        ticks = np.array(found.tick_ns) == round((one.tick - 1) * DT * 1e9)
        assert ticks.all()
    assert times == sim.impacts().time.tolist()
    assert impulses == sim.impacts().impulse.tolist()
    one.step(0)
    assert len(one.impacts()) == 0
    found = sim.impacts()
    assert found.bodies[0].tolist() in ([0, WITNESSES], [WITNESSES, 0])
    np.testing.assert_allclose(np.abs(found.normal[0]), (0, 0, 1), atol=1e-15)
    np.testing.assert_allclose(found.point[0], (0, 0, 0), atol=1e-14)
