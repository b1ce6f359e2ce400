# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Springs, drag, tables over time, attraction and commands in a scene with contact.

They act as with every integrator: of second order on what touches nothing. What they press on
presses back: the contact carries their share exactly at rest, and friction holds them up to mu N.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.exact.oscillator import oscillation
from rigid_body_sim.physics.forces.elements.drag import Drag
from rigid_body_sim.physics.forces.elements.gravity import Gravity
from rigid_body_sim.physics.forces.elements.spring import Spring
from rigid_body_sim.physics.forces.elements.time import TimeTable
from rigid_body_sim.physics.simulation import Simulation

from .touching import DT, G, H, ball, box, ground, scene

MU = 0.4
ROUGH = {'friction': MU}


def block(position=(0, 0, 0.1), **of_motion):
    """
    A cube of 2 kg and 0.2 m, whose weight on the ground is 2 G.
    """
    return box('b', 0.2, position, mass=2.0, material=ROUGH, **of_motion)


def acted_on(bodies, forces=(), **settings):
    """
    A scene with every kind of force element on a bystander far away: all share one kernel.
    """
    asteroid = ball('asteroid', 0.1, (0, 0, 1e6))
    on_it = (
        Spring('asteroid', 'world', 1.0, 0.1, b_point=(0.0, 0.0, 1e6)),
        Drag('asteroid', linear=0.1),
        TimeTable('asteroid', ((0.0, 1.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0))),
        Gravity(('asteroid', 'far box')),
    )
    return scene([*bodies, asteroid], forces=(*forces, *on_it), **settings)


def pressed(sim, body, other):
    """Force [N] that a body gets from another one, by scene index, over the last tick."""
    found = sim.contacts()
    sign = (found.bodies == [other, body]).all(axis=1) * 1.0
    sign -= (found.bodies == [body, other]).all(axis=1)
    return (sign[:, None] * found.impulse).sum(axis=0) / sim.dt


def test_the_ground_carries_the_weight_and_what_a_damped_spring_adds():
    down = Spring('b', 'world', 300.0, 5.0, 0.05, (0.0, 0.0, -0.1), (0.0, 0.0, -0.2))
    sim = Simulation(acted_on([ground(material=ROUGH), block()], [down]))
    sim.step(480)
    s = sim.state
    end = s.position[1] + (0.0, 0.0, -0.1)
    spring = np.array((0.0, 0.0, -0.2)) - end
    length = np.linalg.norm(spring)
    assert length == pytest.approx(0.2, abs=1e-5)
    pull = 300.0 * (length - 0.05) / length * spring
    # what creeps at the start, 1e-5 m, friction holds from then on
    assert pressed(sim, 1, 0) == pytest.approx(-pull + (0, 0, 2 * G), abs=1e-4)
    assert np.abs(s.velocity[1]).max() < 1e-9


@pytest.mark.parametrize('heading', [0.0, 0.7])
@pytest.mark.parametrize(('share', 'holds'), [(0.99, True), (1.01, False)])
def test_a_spring_pulls_a_block_loose_exactly_above_mu_times_its_weight(share, holds, heading):
    stiffness = 100.0
    pull = share * MU * 2 * G / stiffness
    away = (pull * math.cos(heading), pull * math.sin(heading), 0.1)
    spring = Spring('b', 'world', stiffness, b_point=away)
    sim = Simulation(acted_on([ground(material=ROUGH), block()], [spring]))
    sim.step(480)
    way = np.linalg.norm(sim.state.position[1, :2])
    assert np.abs(sim.state.velocity[1]).max() < 1e-9
    if holds:
        # the cold first substep carries no friction: a slip of mu g h, which 1 % of mu g stops
        assert way < 2.5e-4
        stretched = np.linalg.norm(sim.state.position[1] - away)
        friction = np.linalg.norm(pressed(sim, 1, 0)[:2])
        assert friction == pytest.approx(stiffness * stretched, rel=1e-4)
    else:
        # friction drops out of balance by 1 %: half a swing of that, to -0.01 beyond the limit
        assert way == pytest.approx(2 * (pull - MU * 2 * G / stiffness), abs=4e-4)
        assert way > 1e-3


def test_a_block_on_a_spring_loses_two_mu_m_g_over_k_in_each_half_swing():
    stiffness, start = 200.0, 0.35
    spring = Spring('b', 'world', stiffness, b_point=(0.0, 0.0, 0.1))
    held = MU * 2 * G / stiffness
    half = math.pi * math.sqrt(2.0 / stiffness)

    def ends(dt):
        bodies = [ground(material=ROUGH), block((start, 0, 0.1))]
        sim = Simulation(acted_on(bodies, [spring], dt=dt))
        at, found = start, []
        while abs(at) > held:
            at = -(at - math.copysign(2 * held, at))
            found.append(at)
            sim.step(round(len(found) * half / dt) - sim.tick)
            found[-1] -= sim.state.position[1, 0]
        sim.step(round(1.0 / dt))
        assert np.abs(sim.state.velocity[1]).max() < 1e-9
        assert sim.state.position[1, 0] == pytest.approx(at, abs=2.0 * dt)
        return np.abs(found)

    coarse, fine = ends(DT / 4), ends(DT / 16)
    assert len(coarse) == 4
    # friction turns its sign within a substep: mu g h^2 a turn, and of second order
    assert coarse.max() < 2e-5
    assert fine.max() < 0.1 * coarse.max()


@pytest.mark.parametrize('frame', ['world', 'body'])
def test_a_command_moves_a_block_exactly_above_mu_m_g(frame):
    limit = MU * 2 * G
    for share in (0.99, 1.01, 1.5):
        sim = Simulation(acted_on([ground(material=ROUGH), block()]))
        sim.step(24)
        sim.set_wrench('b', force=(share * limit, 0, 0), frame=frame)
        sim.step(240)
        before, time = sim.state.velocity[1, 0], sim.time
        sim.step(240)
        if share < 1:
            assert abs(sim.state.velocity[1, 0]) < 1e-9
            # the block turns by some 1e-5 while it creeps, and the force of the body with it
            assert pressed(sim, 1, 0) == pytest.approx((-share * limit, 0, 2 * G), abs=5e-4)
            assert sim.state.position[1, 0] < 5e-4
        else:
            gained = (sim.state.velocity[1, 0] - before) / (sim.time - time)
            assert gained == pytest.approx((share - 1) * limit / 2.0, abs=2e-5)


def test_a_force_that_grows_moves_a_block_when_it_reaches_mu_m_g():
    growth = 20.0  # [N/s]
    table = TimeTable('b', ((0.0, 0.0, 0.0, 0.0), (2.0, 2.0 * growth, 0.0, 0.0)))
    sim = Simulation(acted_on([ground(material=ROUGH), block()], [table]))
    start = MU * 2 * G / growth
    sim.step(math.floor(start / sim.dt) - 1)
    assert np.linalg.norm(sim.state.position[1, :2]) < 1e-5
    sim.step(round(1.8 / sim.dt) - sim.tick)
    since = sim.time - start
    # of first order in the substep: its friction starts to slip h late
    assert sim.state.velocity[1, 0] == pytest.approx(growth * since**2 / 4, rel=1e-3)
    assert sim.state.position[1, 0] == pytest.approx(growth * since**3 / 12, rel=2e-3)


def test_drag_and_friction_together_stop_a_block():
    """
    m v' = -mu m g - c v: at rest after t = (m/c) ln(1 + c v0/(mu m g)).
    """
    speed, drag = 3.0, 2.0
    air = Drag('b', linear=drag)
    sim = Simulation(acted_on([ground(material=ROUGH), block(velocity=(speed, 0, 0))], [air]))
    brake, rate = MU * G, drag / 2.0
    stop = math.log1p(rate * speed / brake) / rate
    sim.step(round(0.5 * stop / sim.dt))
    expected = (speed + brake / rate) * math.exp(-rate * sim.time) - brake / rate
    assert sim.state.velocity[1, 0] == pytest.approx(expected, rel=1e-3)
    sim.step(round(stop / sim.dt) + 60 - sim.tick)
    assert np.abs(sim.state.velocity[1]).max() < 1e-9
    way = speed / rate - brake / rate * stop
    # it stops within a substep, at most mu g h^2 too late or too early
    assert sim.state.position[1, 0] == pytest.approx(way, abs=brake * H**2)


def test_two_balls_that_attract_each_other_press_with_their_attraction():
    constant, mass, radius = 1e-2, 3.0, 0.1
    pair = [ball(f'b{i}', radius, (x, 0, 0), mass=mass) for i, x in enumerate((-0.11, 0.11))]
    attraction = Gravity(('b0', 'b1'), constant)
    sim = Simulation(acted_on(pair, [attraction], gravity=(0.0, 0.0, 0.0)))
    sim.step(1200)
    s = sim.state
    distance = s.position[1, 0] - s.position[0, 0]
    assert distance == pytest.approx(2 * radius, abs=1e-6)
    force = constant * mass**2 / distance**2
    assert pressed(sim, 1, 0) == pytest.approx((force, 0, 0), rel=1e-6, abs=1e-12)
    assert mass * (s.velocity[0] + s.velocity[1]) == pytest.approx(0.0, abs=1e-14)


def on_springs(bodies, forces, *, dt):
    """
    A scene of ground, box 'b' and ball 'm' without drag, in which the energy is known.
    """
    return Simulation(scene([ground(), *bodies], dt=dt, forces=tuple(forces)))


def _beside_a_resting_box(dt, damping):
    spring = Spring('m', 'world', 90.0, damping, b_point=(5.0, 0.0, 3.0))
    lively = {'restitution': 1.0, 'friction': 0.0}
    mass = ball('m', 0.1, (5.3, 0, 3), velocity=(0, 1, 0), material=lively)
    return on_springs([box('b', 0.2, (0, 0, 0.1)), mass], [spring], dt=dt)


@pytest.mark.parametrize('damping', [0.0, 2.0])
def test_an_oscillator_beside_a_contact_follows_its_closed_form_to_second_order(damping):
    errors = []
    for dt in (DT, DT / 2, DT / 4):
        sim = _beside_a_resting_box(dt, damping)
        sim.step(round(2.0 / dt))
        exact = oscillation(
            sim.time, mass=1.0, stiffness=90.0, damping=damping, force=(0, 0, -G),
            position=(0.3, 0, 0), velocity=(0, 1, 0),
        )  # fmt: skip
        errors.append(np.abs(sim.state.position[2] - (5, 0, 3) - exact.position).max())
    assert errors[0] < 1e-5
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.05)


def test_the_energy_of_an_oscillator_beside_a_contact_does_not_drift():
    sim = _beside_a_resting_box(DT, 0.0)
    sim.step(240)
    first, late = [], []
    for found in (first, late):
        for _ in range(240):
            sim.step()
            found.append(sim.energy())
        sim.step(240 * 60)
    # Verlet: a share of (w h)^2 = 1e-4 of some joules goes to and fro, w = 9.5/s
    assert np.ptp(first) < 1.5e-4
    assert np.mean(late) == pytest.approx(np.mean(first), abs=1e-6)


def test_a_ball_bounces_elastically_on_a_platform_that_hangs_on_a_spring():
    """
    The first impact as Newton says, all of them with the energy of the first fall.
    """
    mass, light, stiffness, fall = 4.0, 0.5, 400.0, 0.5
    hangs = Spring('b', 'world', stiffness, b_point=(0.0, 0.0, 2.0 + mass * G / stiffness))
    smooth = {'friction': 0.0}
    lively = {'restitution': 1.0, **smooth}
    drift = []
    for dt in (DT, DT / 4):
        platform = box('b', (0.4, 0.4, 0.1), (0, 0, 2.0), mass=mass, material=smooth)
        drop = ball('m', 0.1, (0, 0, 2.15 + fall), mass=light, material=lively)
        sim = on_springs([platform, drop], [hangs], dt=dt)
        before = sim.energy()
        while sim.state.velocity[2, 2] <= 0.0:
            sim.step()
        late = sim.time - math.sqrt(2 * fall / G)
        speed = math.sqrt(2 * G * fall)
        after = speed * np.array((-2 * light, mass - light)) / (mass + light)
        # the end of the tick is up to dt late
        assert 0.0 < late < dt
        assert sim.state.velocity[1:3, 2] == pytest.approx(after, abs=G * dt)
        sim.step(round(10.0 / dt))
        drift.append(abs(sim.energy() - before) / (light * G * fall))
    assert drift[0] < 5e-3  # some twenty impacts, each wrong by dt^2
    assert drift[1] < drift[0] / 8
