# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Wheels and discs on a rough plane: rolling with any inertia, upright discs, Euler's disc; a box
that spins on its face.

A disc of radius R, thickness far below R, inertia C about its axis and A across it. Upright on a
rough plane with a small lean e it obeys

    rolling at W = v/R:   (A + m R^2) e'' = -[(C + m R^2) C W^2 / A - m g R] e
    spinning at W:        (A + m R^2) e'' = -[(A + m R^2) W^2 - m g R] e

where it yaws at W C e / A, or turns about its axis at m R^2 W e / (C + m R^2), as the balance of
angular momentum about the vertical and the axis ask. With A = m R^2/4, C = m R^2/2 the brackets
change sign at v^2 = g R/3 and W^2 = 4 g/(5 R).
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Cylinder
from rigid_body_sim.physics.simulation import Simulation

from .touching import G, box, ground, motion, scene

R = 0.1  # [m] radius of every wheel
THIN = 1e-8 * R  # [m] thickness of a disc: THIN / (R LEAN) of what leans it would hold it up
ROUGH = {'friction': 1.0}
ON_ITS_SIDE = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # the axis along -y


def wheel(length, position, *, share=0.5, across=None, material=None, **of_motion):
    """
    A cylinder of 1 kg; inertia `share` R^2 about its axis, `across` R^2 across it: at least half
    of that.
    """
    across = max(0.25, 0.5 * share) if across is None else across
    return Body(
        'wheel', Cylinder(R, length), 1.0, inertia=np.diag([across, across, share]) * R**2,
        initial=motion(position, **of_motion), material=Material(**(material or {})),
    )  # fmt: skip


# solid ball, solid cylinder, hoop
SHARES = pytest.mark.parametrize('share', [0.4, 0.5, 1.0])


@SHARES
def test_a_sliding_wheel_ends_up_rolling_at_the_speed_its_inertia_allows(share):
    mu = {'friction': 0.3}
    start = wheel(R, (0, 0, R), share=share, q=ON_ITS_SIDE, velocity=(1, 0, 0), material=mu)
    sim = Simulation(scene([ground(material=mu), start]))
    sim.step(480)
    v, turn = sim.state.velocity[1], sim.state.angular_velocity[1]
    # two points take turns at the friction of the slide and turn its heading by 3e-5: 1e-9 of v
    assert v[0] == pytest.approx(1 / (1 + share), rel=1e-8)
    assert turn[1] * R == pytest.approx(v[0], rel=1e-12)
    assert abs(v[1]) < 5e-5


@SHARES
def test_a_wheel_rolls_down_a_slope_and_slips_exactly_below_its_friction(share):
    slope = math.radians(20)
    pull, press = G * math.sin(slope), G * math.cos(slope)
    gained, slips = [], []
    limit = share / (1 + share) * math.tan(slope)
    for mu in (0.99 * limit, 1.01 * limit):
        material = {'friction': mu}
        start = wheel(
            R, (R * math.sin(slope), 0, R * math.cos(slope)), share=share, q=ON_ITS_SIDE,
            material=material,
        )  # fmt: skip
        sim = Simulation(scene([ground(slope=slope, material=material), start]))
        sim.step(240)
        early = np.linalg.norm(sim.state.velocity[1])
        sim.step(240)
        late = np.linalg.norm(sim.state.velocity[1])
        gained.append((late - early) / (240 * sim.dt))
        slips.append(late - sim.state.angular_velocity[1, 1] * R)
    slides, rolls = gained
    # the two points take turns at its friction, which turns its heading
    assert rolls == pytest.approx(pull / (1 + share), rel=1e-8)
    assert abs(slips[1]) < 1e-7
    assert slides == pytest.approx(pull - 0.99 * limit * press, rel=1e-7)
    # after 2 s; the cold first substep, without friction, adds to it
    assert slips[0] == pytest.approx(2 * (pull - 0.99 * limit * press * (1 + 1 / share)), rel=3e-2)


def rolling(shift, heading, floor, *, speed=0.1, length=0.03):
    """
    A wheel that rolls along a heading, and its changes of speed and the speed to the side that it
    gets, over that speed, at worst in 2 s.
    """
    c, s = math.cos(heading), math.sin(heading)
    q = rotation.multiply(np.array((0, 0, math.sin(heading / 2), math.cos(heading / 2))),
                          np.array(ON_ITS_SIDE))  # fmt: skip
    start = wheel(
        length, (shift * c, shift * s, R), q=tuple(q), velocity=(speed * c, speed * s, 0),
        turn=(-s * speed / R, c * speed / R, 0), material={'friction': 0.3},
    )  # fmt: skip
    sim = Simulation(scene([*floor, start], dt=0.004))
    worst = np.zeros(2)
    for _ in range(500):
        sim.step(1)
        x, y, _ = sim.state.velocity[len(floor)] / speed
        worst = np.maximum(worst, (abs(c * x + s * y - 1), abs(c * y - s * x)))
    return worst


@pytest.mark.parametrize('heading', [0.0, 0.7, -2.1])
def test_what_rolls_slowly_is_put_down_without_a_push_to_the_side(heading):
    """Its line presses at both ends alike, though it turns about that by more than 1 rad/s."""
    along, side = rolling(0.0, heading, [ground(material={'friction': 0.3})], speed=0.15)
    # the first substep has no friction: the sink of then, 2e-7 m, and what it takes of the speed
    assert along < 2e-4
    assert side < 1e-4


def test_a_box_that_spins_on_its_face_is_braked_by_mu_times_weight_at_its_mean_radius():
    mu, edge, spin = 0.3, 0.2, 10.0
    rough = {'friction': mu}
    start = box('b', edge, (0, 0, edge / 2), turn=(0, 0, spin), material=rough)
    sim = Simulation(scene([ground(material=rough), start]))
    # the mean distance of a square from its middle
    radius = edge / 6 * (math.sqrt(2) + math.asinh(1))
    braking = mu * G * radius / (edge**2 / 6)
    sim.step(60)
    # of the fit of `solver.patch_friction`; the cold first substep
    assert spin - sim.state.angular_velocity[1, 2] == pytest.approx(braking * sim.time, rel=1e-4)
    # the cold start presses its corners one after the other, which pushes it aside
    assert np.abs(sim.state.velocity[1]).max() < 1e-4
    sim.step(100)
    # the load of its corners settles still
    assert np.abs(sim.state.angular_velocity[1]).max() < 1e-6


LEAN = 1e-3  # [rad] at the start: e^2 is left out of the equations


def _upright(angular_velocity, *, dt):
    """An upright disc that leans by LEAN about the x axis and touches the ground without slip."""
    q = rotation.from_rotation_vector((LEAN - math.pi / 2, 0.0, 0.0))
    axis = np.array((0.0, math.cos(LEAN), math.sin(LEAN)))
    down = np.array((0.0, math.sin(LEAN), -math.cos(LEAN)))
    arm = R * down - 0.5 * THIN * axis
    turn = np.array(angular_velocity(axis))
    start = wheel(
        THIN, (0, 0, -arm[2]), q=tuple(q), velocity=tuple(-np.cross(turn, arm)), turn=tuple(turn),
        material=ROUGH,
    )  # fmt: skip
    return Simulation(scene([ground(material=ROUGH), start], dt=dt))


def _leans(sim, seconds):
    """Lean at the end of each tenth of a second, in parts of that at the start."""
    found = []
    for _ in range(round(10 * seconds)):
        sim.step(round(0.1 / sim.dt))
        axis = rotation.rotate(sim.state.orientation[1], (0.0, 0.0, 1.0))
        found.append(math.asin(axis[2]) / LEAN)
    return np.array(found)


def _expected(rate_squared, seconds):
    times = 0.1 * np.arange(1, round(10 * seconds) + 1)
    rate = math.sqrt(abs(rate_squared))
    return np.cos(rate * times) if rate_squared > 0 else np.cosh(rate * times)


@pytest.mark.parametrize('factor', [0.98, 1.02, 1.1])
def test_an_upright_disc_rolls_stably_exactly_above_a_third_of_g_r(factor):
    turn = math.sqrt(factor * G / (3 * R))
    sim = _upright(lambda axis: turn * axis + np.array((0, 0, -2 * turn * LEAN)), dt=1e-3)
    # [(C + m R^2) C W^2 / A - m g R] / (A + m R^2)
    wanted = _expected((3 * turn**2 * R**2 - G * R) / (1.25 * R**2), 1.2)
    # of second order in dt and e; at 0.98 and 1.02 the two laws part by 2.3 in 1.2 s
    assert _leans(sim, 1.2) == pytest.approx(wanted, abs=5e-4)


@pytest.mark.parametrize('factor', [0.9, 0.98, 1.02, 1.1])
def test_an_upright_disc_spins_stably_exactly_above_four_fifths_of_g_over_r(factor):
    turn = math.sqrt(factor * 4 * G / (5 * R))
    sim = _upright(
        lambda axis: np.array((0, 0, turn)) - (turn * LEAN / 1.5 + turn * axis[2]) * axis,
        dt=1e-3,
    )
    wanted = _expected(turn**2 - G * R / (1.25 * R**2), 0.6)
    # of second order in dt; at 0.98 and 1.02 the two laws part by 0.57 in 0.6 s
    assert _leans(sim, 0.6) == pytest.approx(wanted, abs=5e-4)


@pytest.mark.parametrize('degrees', [10.0, 30.0])
def test_eulers_disc_goes_round_at_the_rate_of_its_inclination(degrees):
    """
    Centre at rest: W^2 R sin a = 4 g, E = (3/2) m g R sin a.
    """
    a = math.radians(degrees)
    q = rotation.from_rotation_vector((a, 0.0, 0.0))
    axis = rotation.rotate(q, (0.0, 0.0, 1.0))
    rate = math.sqrt(4 * G / (R * math.sin(a)))
    start = wheel(
        THIN, (0, 0, R * math.sin(a) + 0.5 * THIN * math.cos(a)), q=tuple(q),
        turn=tuple(np.array((0, 0, rate)) - rate * math.cos(a) * axis), material=ROUGH,
    )  # fmt: skip
    sim = Simulation(scene([ground(material=ROUGH), start], dt=1e-3))
    headings, tilts = [], []
    for _ in range(100):
        sim.step(10)
        x, y, z = rotation.rotate(sim.state.orientation[1], (0.0, 0.0, 1.0))
        headings.append(math.atan2(y, x))
        tilts.append(math.acos(z))
    turned = np.unwrap(headings)
    seen = (turned[-1] - turned[0]) / (99 * 10 * sim.dt)
    # of second order in dt: in a substep it goes round by 0.012
    assert seen**2 * R * np.mean(np.sin(tilts)) == pytest.approx(4 * G, rel=1e-3)
    assert sim.energy() == pytest.approx(1.5 * G * R * math.sin(tilts[-1]), rel=1e-3)
    assert np.linalg.norm(sim.state.position[1, :2]) < 1e-3 * R
    assert abs(tilts[-1] - a) < 2e-3 * a


def _coin(*, dt=1 / 240, tilt=0.5, thick=0.1 * R, friction=0.8, roll=0.0, bounce=0.0, drop=0.0):
    """
    A coin that rolls on its rim, its centre nearly at rest, `drop` above the ground.
    """
    material = {'friction': friction, 'rolling_friction': roll, 'restitution': bounce}
    rate = math.sqrt(4 * G / (R * math.sin(tilt)))
    q = rotation.from_rotation_vector((tilt, 0.0, 0.0))
    turn = rate * np.array((0, 0, 1)) - rate * math.cos(tilt) * rotation.rotate(q, (0.0, 0.0, 1.0))
    height = R * math.sin(tilt) + 0.5 * thick * math.cos(tilt) + drop
    start = wheel(thick, (0, 0, height), q=tuple(q), turn=tuple(turn), material=material)
    return Simulation(scene([ground(material=material), start], dt=dt))


def test_a_coin_that_nothing_brakes_keeps_rolling_on_its_rim():
    losses = []
    for rate in (120, 240):
        sim = _coin(dt=1 / rate)
        sim.step(rate)  # after the start, which is not that of its thickness: it slips once
        before = sim.energy()
        sim.step(4 * rate)
        losses.append((before - sim.energy()) / before)
    # of second order in dt: 8e-5 in a second at 1/240 s; order 1.6 between these
    assert 0 < losses[1] < 5e-4
    assert losses[0] > 3 * losses[1]


@pytest.mark.parametrize('roll', [0.002, 0.004])
def test_a_coin_with_rolling_resistance_falls_flat_in_finite_time_and_rests(roll):
    """
    With s = sin a, E = (3/2) m g R s, and the power roll m g W s cos a:

        d sqrt(s)/dt = -(2 roll / (3 R)) (g/R)^(1/2) (1 - s^2)^(1/2)
    """
    sim = _coin(roll=roll)
    roots = np.linspace(0.0, math.sqrt(math.sin(0.5)), 2001)
    share = np.trapezoid(1 / np.sqrt(1 - roots**4), roots)
    lasts = share * 3 * R / (2 * roll) * math.sqrt(R / G)
    sim.step(round(0.9 * lasts / sim.dt))
    before = sim.state.position[1, 2]
    # its centre does not stay quite at rest: some per cent; a tenth of the time leaves s / 100
    assert 1e-3 * R < before - 0.05 * R < 0.03 * R
    sim.step(round(0.2 * lasts / sim.dt))
    sim.step(1500)  # its static sink goes with 0.012 of it in a tick: to e^-18
    state = sim.state
    assert state.position[1, 2] == pytest.approx(0.05 * R, abs=1e-5)  # less its sink
    # to rest: rounding of what it was
    assert np.abs(state.velocity[1]).max() < 1e-12
    assert np.abs(state.angular_velocity[1]).max() < 1e-12


FEW = 5e-6  # [-] of the largest energy: what may come in a tick, as of all that touches


def _largest_rise(**start):
    """
    Largest gain of energy in a tick of 4 ms over the largest energy, without and with a bounce.
    """
    found = []
    for bounce in (0.0, 0.5):
        sim = _coin(dt=0.004, bounce=bounce, **start)
        energy = [sim.energy()]
        for _ in range(1000):
            sim.step()
            energy.append(sim.energy())
        found.append(np.diff(energy).max() / max(energy))
    return max(found)


@pytest.mark.parametrize('friction', [0.0, 0.2, 0.8])
def test_energy_of_a_coin_rises_in_no_tick_while_it_rolls_on_its_rim(friction):
    assert _largest_rise(friction=friction) < FEW


@pytest.mark.parametrize(
    ('friction', 'roll'),
    [
        (0.0, 0.0), (0.2, 0.004), (0.8, 0.0),
        *(
            pytest.param(*one, marks=pytest.mark.long)
            for one in ((0.0, 0.004), (0.2, 0.0), (0.8, 0.004))
        ),
    ],
)  # fmt: skip
def test_energy_of_a_short_cylinder_rises_in_no_tick_while_it_tumbles(friction, roll):
    assert _largest_rise(thick=2 * R, drop=0.05, friction=friction, roll=roll) < FEW


@pytest.mark.parametrize(
    'friction', [*(pytest.param(mu, marks=pytest.mark.long) for mu in (0.0, 0.2)), 0.8]
)
def test_energy_of_a_coin_rises_in_no_tick_while_it_tumbles_and_falls_flat(friction):
    assert _largest_rise(drop=0.05, friction=friction) < FEW
    for drop in (0.0, 0.05):
        assert _largest_rise(drop=drop, friction=friction, roll=0.004) < FEW


@pytest.mark.parametrize('seed', range(6))
def test_energy_of_cylinders_thrown_at_random_rises_in_no_tick(seed):
    """
    Thin and thick, of any attitude and spin, rough and smooth, with and without bounce.
    """
    rng = np.random.default_rng(seed)
    radius = rng.uniform(0.02, 0.2)
    thick = radius * 10 ** rng.uniform(-1.5, 0.5)
    across = (3 * radius**2 + thick**2) / 12
    material = {
        'friction': float(rng.choice([0.0, 0.2, 0.8])),
        'rolling_friction': float(rng.choice([0.0, 0.04])) * radius,
        'restitution': float(rng.choice([0.0, 0.5])),
    }
    q = rng.normal(size=4)
    thrown = Body(
        'thrown', Cylinder(radius, thick), 1.0,
        inertia=np.diag([across, across, 0.5 * radius**2]), material=Material(**material),
        initial=motion(
            (0, 0, math.hypot(radius, 0.5 * thick) + rng.uniform(0, 0.2)),
            q=tuple(q / np.linalg.norm(q)), velocity=tuple(rng.normal(size=3)),
            turn=tuple(rng.normal(size=3) * 10 ** rng.uniform(0, 1.3)),
        ),
    )  # fmt: skip
    sim = Simulation(scene([ground(material=material), thrown], dt=0.004))
    energy = [sim.energy()]
    for _ in range(600):
        sim.step()
        energy.append(sim.energy())
    assert np.diff(energy).max() < FEW * max(energy)
