# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Sleep: what rests is left alone to the bit, and wakes as what never slept.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.elements.spring import Spring
from rigid_body_sim.physics.forces.elements.time import TimeTable
from rigid_body_sim.physics.model import mass_properties
from rigid_body_sim.physics.model.shapes import Box, Part, Union
from rigid_body_sim.physics.simulation import Simulation

from .. import inside
from .touching import DT, G, ball, box, ground, heap, lean, scene, stack

SINK_TIME = 4.0  # [s] 960 ticks: the static sink is out to e^-11 of it, as for who stays awake
SETTLED = 360  # [tick] 1.5 s: a stack of five falls asleep after 0.5 s


def both(bodies, **settings):
    """
    The same scene with and without sleep.
    """
    return (
        Simulation(scene(bodies, sleeping=True, **settings)),
        Simulation(scene(bodies, **settings)),
    )


def names(bodies):
    return {body.name for body in bodies if not body.fixed}


def test_a_body_put_elsewhere_wakes_who_slept_on_it_and_nobody_else():
    apart = box('far', 0.2, (5, 0, 0.1))
    sim = Simulation(scene([*stack(3), apart], sleeping=True))
    sim.step(SETTLED)
    everybody = names(stack(3)) | {'far'}
    assert inside.asleep(sim) == everybody
    lowest = min(everybody - {'far'}, key=lambda name: sim.state.position[sim.body_index(name), 2])
    others = [sim.body_index(name) for name in everybody - {'far', lowest}]
    height = sim.state.position[others, 2]
    sim.set_state(lowest, position=(2, 0, 0.1))
    assert inside.asleep(sim) == {'far'}
    sim.step(10)
    assert (sim.state.velocity[others, 2] < -0.9 * G * 10 * DT).all()
    assert (sim.state.position[others, 2] < height).all()
    sim.step(2 * SETTLED)
    assert inside.asleep(sim) == everybody
    # and who comes down on a sleeper wakes it
    sim.set_state(lowest, position=(5, 0, 0.3 + 1e-3))
    sim.step(30)
    assert 'far' not in inside.asleep(sim)


def test_a_sleeping_stack_holds_its_pose_to_the_bit_and_does_not_move():
    sim = Simulation(scene(stack(5), sleeping=True))
    sim.step(SETTLED)
    assert inside.asleep(sim) == names(stack(5))
    before = sim.state_bytes()
    assert not sim.state.velocity.any()
    assert not sim.state.angular_velocity.any()
    sim.step(1000)
    assert sim.state_bytes() == before


def test_the_contacts_of_a_sleeping_stack_still_carry_the_weight_above_them():
    sim = Simulation(scene(stack(5), sleeping=True, sleep_time=2.0))  # until it swings no more
    sim.step(600)
    assert inside.asleep(sim) == names(stack(5))
    contacts = sim.contacts()
    for k in range(1, 6):
        below = [
            i for i, pair in enumerate(contacts.bodies.tolist()) if sorted(pair) == [k - 1, k]
        ]
        force = abs(contacts.impulse[below].sum(axis=0)[2]) / DT
        # when it falls asleep it moves by less than 1e-6 m/s; g dt = 0.04 m/s
        assert force == pytest.approx((6 - k) * G, rel=1e-4)


def test_who_wakes_goes_on_as_if_it_had_never_slept():
    # until the static sink is out: of what is left of it, 2e-7 m after 2 s, the blow and the
    # rocking make 1e-4 m in 60 ticks
    awake = both(stack(5))[1]
    sleeping = Simulation(scene(stack(5), sleeping=True, sleep_time=2.0 * SINK_TIME))
    for sim in (sleeping, awake):
        sim.step(2400)
        assert sim is awake or inside.asleep(sim)
        sim.apply_impulse('b4', linear=(0.3, 0.0, 0.0))
        sim.step(1)
    assert not inside.asleep(sleeping)
    for sim in (sleeping, awake):
        sim.step(60)
    # a stack that sleeps keeps what was left of its sinking, e^-23 of 2e-5 m
    assert np.abs(sleeping.state.position - awake.state.position).max() < 1e-6
    assert np.abs(sleeping.state.velocity - awake.state.velocity).max() < 1e-5
    assert awake.state.position[5, 0] > 5e-3


def test_a_pushed_sleeping_box_slides_as_an_awake_one():
    bodies = [ground(), box('b', 0.2, (0, 0, 0.1))]
    sleeping, awake = both(bodies, sleep_time=SINK_TIME)
    for sim in (sleeping, awake):
        sim.step(3 * SETTLED)
        sim.set_wrench('b', force=(6.0, 0, 0))  # mu m g = 4.9 N
        sim.step(120)
    assert sleeping.state.velocity[1, 0] == pytest.approx(0.5 * (6.0 - 0.5 * G), rel=1e-2)
    # it sank by 1e-6 m, all but for 1e-10 m, before it fell asleep
    assert np.abs(sleeping.state.position - awake.state.position).max() < 1e-8


def test_a_force_that_friction_holds_wakes_too_and_lets_sleep_again():
    sim = Simulation(scene([ground(), box('b', 0.2, (0, 0, 0.1))], sleeping=True))
    sim.step(SETTLED)
    sim.set_wrench('b', force=(4.0, 0, 0))
    sim.step(1)
    assert not inside.asleep(sim)
    sim.step(SETTLED)
    assert inside.asleep(sim) == {'b'}
    # friction bears the force while it sleeps
    contacts = sim.contacts()
    on_box = np.where(contacts.bodies[:, 1] == 1, 1.0, -1.0) @ contacts.impulse
    assert on_box == pytest.approx([-4.0 * DT, 0.0, G * DT], abs=1e-6)
    sim.set_wrench('b')
    sim.step(1)
    assert not inside.asleep(sim)


@pytest.mark.usefixtures('own_kernels', 'plain_source')
def test_a_force_that_grows_while_all_sleep_acts_however_ticks_are_grouped():
    # kernels of many scenes evaluate forces more often than this one does; at 1/250 s the instants
    # of ticks are rounded
    grows = TimeTable('b', ((0.3, 0.0, 0.0, 0.0), (0.6, 360.0, 0.0, 0.0)), outside='hold')
    at_once, grouped = (
        Simulation(
            lean(
                [ground(), box('b', 0.2, (0, 0, 0.1))],
                forces=(grows,), dt=0.004, sleeping=True, sleep_time=0.05,
            )
        )
        for _ in range(2)
    )  # fmt: skip
    grouped.step(70)
    assert inside.asleep(grouped) == {'b'}
    at_once.step(95)
    for ticks in (5, 7, *[1] * 13):
        grouped.step(ticks)
    assert at_once.state.position[1, 0] > 0.02
    assert at_once.state_bytes() == grouped.state_bytes()


def test_an_impulse_to_one_body_wakes_its_island_and_no_other():
    other = [box(f'c{i}', 0.2, (3.0, 0, 0.1 + 0.2 * i)) for i in range(2)]
    sim = Simulation(scene([*stack(3), *other], sleeping=True))
    sim.step(SETTLED)
    assert inside.asleep(sim) == names(stack(3)) | names(other)
    sim.apply_impulse('b1', angular=(0.0, 0.0, 1e-3))
    sim.step(1)
    assert inside.asleep(sim) == names(other)


def test_what_lost_its_support_falls():
    plank = box('plank', (1.0, 0.3, 0.1), (0, 0, 0.05))
    bodies = [
        ground(material={'friction': 0.0}),
        replace(plank, material=replace(plank.material, friction=0.0)),
        box('b', 0.2, (0.45, 0, 0.2)),
    ]
    sleeping, awake = both(bodies)
    for sim in (sleeping, awake):
        sim.step(SETTLED)
    assert inside.asleep(sleeping) == {'plank', 'b'}
    for sim in (sleeping, awake):
        sim.apply_impulse('plank', linear=(-4.0, 0.0, 0.0))
        sim.step(240)
    assert sleeping.state.position[1, 0] < -3.0
    assert sleeping.state.position[2, 2] < 0.15  # it stood 0.2 m high
    # what it had still to sink, 1e-9 m, grows while it tumbles over an edge that moves
    assert np.abs(sleeping.state.position - awake.state.position).max() < 1e-3


def test_a_ball_that_hits_a_sleeping_stack_does_what_it_does_to_one_awake():
    bodies = [*stack(4), ball('ball', 0.1, (-3.0, 0, 0.5), mass=2.0)]
    sleeping, awake = both(bodies, sleep_time=SINK_TIME)
    for sim in (sleeping, awake):
        sim.step(3 * SETTLED)
    assert inside.asleep(sleeping) == names(bodies)
    for sim in (sleeping, awake):
        sim.apply_impulse('ball', linear=(12.0, 0.0, 6.0))
        sim.step(60)
    assert inside.asleep(sleeping) == names(stack(4))  # the ball is on its way
    for sim in (sleeping, awake):
        sim.step(80)
    assert not inside.asleep(sleeping)
    assert np.abs(awake.state.velocity).max() > 1.0
    # the impact multiplies what the stack had still to sink, 2e-8 m
    assert np.abs(sleeping.state.position - awake.state.position).max() < 1e-5


@pytest.mark.parametrize('speed', [300.0, 30.0])
def test_a_bullet_finds_a_sleeping_box(speed):
    bodies = [ground(), box('b', 0.2, (0, 0, 0.1)), ball('bullet', 0.1, (-2.0, 0, 0.1))]
    sleeping, awake = both(bodies)
    for sim in (sleeping, awake):
        sim.step(SETTLED)
    assert inside.asleep(sleeping) == {'b', 'bullet'}
    for sim in (sleeping, awake):
        sim.apply_impulse('bullet', linear=(speed, 0.0, 0.0))
    ticks = int(1.5 / speed / DT)  # it reaches the box after 1.8 m
    sleeping.step(ticks)
    awake.step(ticks)
    assert inside.asleep(sleeping) == {'b'}
    for _ in range(20):
        carried = []
        for sim in (sleeping, awake):
            sim.step()
            contacts = sim.contacts()
            sign = np.where(contacts.bodies[:, 1] == 1, 1.0, -1.0)
            of_box = (contacts.bodies == 1).any(axis=1)
            carried.append((sign[:, None] * contacts.impulse)[of_box].sum(axis=0))
        # also in the tick of the impact, which is cut into pieces
        assert carried[0] == pytest.approx(carried[1], abs=1e-4 * speed)
    for sim in (sleeping, awake):
        momentum = sim.momentum()[0]
        assert sim.state.position[2, 0] < sim.state.position[1, 0]
        assert 0.8 * speed < momentum < speed  # the ground took the rest
    assert not inside.asleep(sleeping)
    # the impact is solved from impulses that differ by what was left of settling
    assert np.abs(sleeping.state.velocity - awake.state.velocity).max() < 1e-4 * speed


def test_nothing_sleeps_in_flight_at_the_apex_of_a_throw():
    bodies = [ground(), box('b', 0.2, (0, 0, 0.1))]
    sleeping, awake = both(bodies, gravity=(0.0, 0.0, -0.01))
    for sim in (sleeping, awake):
        sim.apply_impulse('b', linear=(0.0, 0.0, 0.02))  # 4 s in flight, slower than 1 cm/s for 2
        for _ in range(2 * 240):
            sim.step()
            assert sim is awake or not inside.asleep(sim)
    assert sleeping.state.values.tobytes() == awake.state.values.tobytes()


def test_nothing_that_floats_falls_asleep_not_even_in_touch():
    bodies = [box('a', 0.2, (0, 0, 0)), box('b', 0.2, (0, 0, 0.2), velocity=(0, 0, -0.002))]
    sleeping, awake = both(bodies, gravity=(0.0, 0.0, 0.0))
    for sim in (sleeping, awake):
        sim.step(720)
    assert not inside.asleep(sleeping)
    assert sleeping.state.values.tobytes() == awake.state.values.tobytes()


def test_a_body_does_not_sleep_while_its_spring_pulls_it():
    # 2 cm about the length at which it hangs, at most 4.5 mm/s
    hanging = box('bob', 0.2, (0, 0, 1.0), mass=20.0)
    weak = Spring(a='bob', b='world', b_point=(0, 0, 3.0), stiffness=1.0, rest_length=0.0)
    swing = Simulation(
        scene([ground(), hanging], sleeping=True, forces=(weak,), gravity=(0.0, 0.0, -0.099))
    )
    swing.step(2400)
    assert not inside.asleep(swing)
    # slides without friction by 5 mm to either side, at most 7 mm/s, and presses on the ground
    smooth = {'friction': 0.0}
    cart = box('cart', 0.2, (0.005, 0, 0.1), mass=0.5, material=smooth)
    side = Spring(a='cart', b='world', b_point=(0, 0, 0.1), stiffness=1.0, rest_length=0.0)
    sim = Simulation(scene([ground(), cart], sleeping=True, forces=(side,)))
    sim.step(2400)
    assert not inside.asleep(sim)
    assert sim.state.position[1, 0] == pytest.approx(
        0.005 * math.cos(math.sqrt(2.0) * 10.0), abs=1e-5
    )


def test_bodies_that_a_spring_joins_sleep_and_wake_together():
    boxes = [box('a', 0.2, (0, 0, 0.1)), box('b', 0.2, (1.0, 0, 0.1))]
    spring = Spring(a='a', b='b', stiffness=10.0, rest_length=0.9)
    sim = Simulation(scene([ground(), *boxes], sleeping=True, forces=(spring,)))
    sim.step(1200)
    assert inside.asleep(sim) == {'a', 'b'}
    before = sim.state_bytes()
    sim.step(240)
    assert sim.state_bytes() == before
    sim.apply_impulse('a', linear=(0.5, 0.0, 0.0))
    sim.step(1)
    assert not inside.asleep(sim)


def test_a_body_of_several_parts_sleeps_and_wakes_as_one():
    # a table top on two legs, a box on it
    slab, leg = Box((0.6, 0.2, 0.1)), Box((0.1, 0.2, 0.2))
    parts = [Part(slab, mass=1.0, position=(0.0, 0.0, 0.05))]
    parts += [Part(leg, mass=0.5, position=(side * 0.25, 0.0, -0.1)) for side in (-1, 1)]
    of = mass_properties.of_shape(Union(tuple(parts)))
    table = replace(
        box('table', 0.2, (0.0, 0.0, 0.2 + of.center_of_mass[2]), mass=2.0),
        shape=Union(tuple(parts)), center_of_mass=tuple(of.center_of_mass.tolist()),
        inertia=of.inertia,
    )  # fmt: skip
    sim = Simulation(scene([ground(), table, box('b', 0.2, (0.1, 0, 0.4))], sleeping=True))
    sim.step(SETTLED)
    assert inside.asleep(sim) == {'table', 'b'}
    before = sim.state_bytes()
    sim.step(100)
    assert sim.state_bytes() == before
    sim.apply_impulse('b', linear=(0.0, 0.0, 1.0))
    sim.step(1)
    assert not inside.asleep(sim)
    sim.step(2 * SETTLED)
    assert inside.asleep(sim) == {'table', 'b'}


def test_without_anybody_asleep_the_bits_are_those_without_sleep():
    sleeping, awake = both(heap(6), sleep_speed=0.0)
    sleeping.step(300)
    awake.step(300)
    assert sleeping.state.values.tobytes() == awake.state.values.tobytes()


def test_a_heap_falls_asleep_where_it_would_have_rested():
    sleeping, awake = both(heap(6))
    sleeping.step(1200)
    awake.step(1200)
    bodies = heap(6)
    boxes = {body.name for body in bodies if isinstance(body.shape, Box)}
    speeds = np.linalg.norm(awake.state.velocity[: len(bodies)], axis=1)
    turns = np.linalg.norm(awake.state.angular_velocity[: len(bodies)], axis=1)
    # a ball that rolls on at 9 mm/s turns at 0.6 rad/s: its surface is not slow
    motions = zip(bodies, speeds, turns, strict=True)
    slow = {body.name for body, v, w in motions if v < 0.01 and w < 0.1}
    assert inside.asleep(sleeping) == slow - {'ground'}
    assert boxes < slow
    assert 'b2' not in slow  # a ball rolls on
    # slower than 1 cm/s for half a second, then stopped: of what rocks still 5 mm could be
    # missing; of a ball that rolled on at 2 mm/s all of its way is
    off = np.abs(sleeping.state.position - awake.state.position).max(axis=1)
    assert max(off[i] for i, body in enumerate(bodies) if body.name in boxes) < 5e-3


def test_a_sleeping_run_gives_the_same_bits_however_it_is_cut_and_when_restored():
    def drive(sim, tick):
        if tick == 700:
            sim.apply_impulse('b3', linear=(0.4, 0.1, 1.0))
        if tick == 1000:
            sim.set_wrench('b0', force=(1.0, 0.0, 0.0))

    whole = Simulation(scene(heap(6), sleeping=True))
    states = {}
    slept = woke = False
    for tick in range(1200):
        drive(whole, tick)
        states[tick] = whole.state_bytes(), whole.held_slots
        before = inside.asleep(whole)
        whole.step()
        slept = slept or bool(inside.asleep(whole) - before)
        woke = woke or bool(before - inside.asleep(whole))
    assert slept and woke
    cut = Simulation(scene(heap(6), sleeping=True))
    cut.step(700)
    drive(cut, 700)
    cut.step(300)
    drive(cut, 1000)
    cut.step(200)
    assert cut.state_bytes() == whole.state_bytes()
    for start in (400, 690, 705, 1010):
        state, slots = states[start]
        other = Simulation(scene(heap(6), sleeping=True))
        other.restore(tick=start, state=state, slots=slots)
        for tick in range(start, 1200):
            if tick > start:
                drive(other, tick)
            other.step()
        assert other.state_bytes() == whole.state_bytes()
        a, b = other.contacts(), whole.contacts()
        for field in ('bodies', 'point', 'normal', 'gap', 'impulse'):
            assert getattr(a, field).tobytes() == getattr(b, field).tobytes()


def asleep_and_awake():
    """How many islands sleep, one after the other, and the last state."""
    boxes = [box('a', 0.2, (0, 0, 0.1)), box('b', 0.2, (3, 0, 0.1), velocity=(0, 0.1, 0))]
    sim = Simulation(scene([ground(), *boxes], sleeping=True, sleep_time=0.05))
    counts = []
    for ticks in (40, 10):
        sim.step(ticks)
        counts.append(len(inside.islands(sim)))
    for body in 'ab':
        sim.apply_impulse(body, angular=(0.1, 0.2, 0.3))
    sim.step(5)
    return [*counts, len(inside.islands(sim))], sim.state_bytes()


def test_compiled_and_plain_kernels_sleep_and_wake_alike(monkeypatch):
    compiled = asleep_and_awake()
    assert compiled[0] == [2, 2, 0]
    inside.run_plain(monkeypatch)
    assert asleep_and_awake() == compiled


def test_a_reset_run_begins_awake():
    sim = Simulation(scene(heap(6), sleeping=True))
    sim.step(1200)
    end = sim.state_bytes()
    assert inside.asleep(sim)
    sim.reset()
    assert not inside.asleep(sim)
    assert not len(sim.contacts())
    sim.step(1200)
    assert sim.state_bytes() == end


def test_labels_of_bodies_change_nothing_of_sleep_beyond_rounding():
    bodies = heap(6)
    shuffled = [bodies[i] for i in np.random.default_rng(3).permutation(len(bodies))]
    one, other = (Simulation(scene(given, sleeping=True)) for given in (bodies, shuffled))
    for tick in range(700):
        one.step()
        other.step()
        assert inside.asleep(one) == inside.asleep(other), tick
    assert inside.asleep(one)
    for body in bodies:
        a = one.state.position[one.body_index(body.name)]
        b = other.state.position[other.body_index(body.name)]
        assert np.abs(a - b).max() < 1e-12


@pytest.mark.usefixtures('own_kernels')
def test_a_scene_without_sleep_keeps_nothing_for_it():
    sim = Simulation(lean(stack(2)))
    sleepers, arrays = inside.kept_for_sleep(sim)
    assert sleepers is None
    assert len(arrays)
    assert all(len(array) <= 1 for array in arrays)  # of no bodies: at most the end of a list


@pytest.mark.parametrize('given', [{'sleep_speed': -1.0}, {'sleep_time': math.inf}])
def test_impossible_limits_are_refused(given):
    with pytest.raises(InvalidModel, match='not negative'):
        Simulation(lean([ground()], **given))
