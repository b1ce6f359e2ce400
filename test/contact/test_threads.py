# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What bodies that meet do does not depend on how many threads do it, to the bit, whatever comes in
between: a restore, sleep, a cut tick, an interrupt.
"""

import threading

import numpy as np
import pytest

from rigid_body_sim.physics.compile import kernels, side_by_side
from rigid_body_sim.physics.contact import crew, ticks
from rigid_body_sim.physics.simulation import Simulation

from .. import inside
from .touching import ball, box, ground, scene

pytestmark = pytest.mark.skipif(not kernels.COMPILED, reason='plain Python has one lock')
# towers of five to nine in a row have more manifolds than one group of islands holds (`FEW`)
TOWERS = 70


def towers(seed, count=TOWERS, **of_each):
    """
    Towers of cubes, some of which lean on the next one, and some balls beside that roll, fly and
    fall on them: many islands, of which some join, and bodies that touch nobody.
    """
    draw = np.random.default_rng(seed)
    bodies = [ground()]
    for tower in range(count):
        x, y = 0.45 * (tower % 10), 0.45 * (tower // 10)
        for layer in range(int(draw.integers(5, 10))):
            at = (x + draw.uniform(-0.02, 0.02), y, 0.101 + 0.201 * layer)
            bodies.append(box(f'cube_{tower}_{layer}', 0.2, at, **of_each))
        at = (x + 0.2, y + 0.2, draw.uniform(0.1, 3.0))
        velocity = tuple(draw.uniform(-1, 1, 3))
        bodies.append(ball(f'ball_{tower}', 0.05, at, velocity=velocity))
    return bodies


@pytest.fixture(params=[(1, 3), pytest.param((1, 2, 3), marks=pytest.mark.long)], ids=str)
def counts(request):
    """How many threads do the same."""
    return request.param


@pytest.fixture
def on(monkeypatch):
    """A simulation on so many threads, however many bodies there are."""
    monkeypatch.setattr(ticks, 'WORTH_HELP', 0)

    def make(threads, described):
        for module in (ticks, side_by_side):
            monkeypatch.setattr(module, 'threads', lambda: threads)
        return Simulation(described)

    return make


def after(sim, ticks, calls=1):
    for _ in range(calls):
        sim.step(ticks // calls)
    return sim.state_bytes()


@pytest.mark.parametrize('seed', [1, pytest.param(2, marks=pytest.mark.long)])
def test_threads_change_no_bit_of_many_islands(on, counts, seed):
    found = []
    for threads in counts:
        sim = on(threads, scene(towers(seed)))
        with inside.helped(sim) as helpers:
            found.append([after(sim, 8, calls=2) for _ in range(3)])
        assert {*helpers} == {threads - 1} - {0}
        contacts = sim.contacts()
        found[-1] += [contacts.point.tobytes(), contacts.impulse.tobytes()]
    assert found[1:] == found[:-1]
    assert inside.groups(sim) > 1


def test_who_helps_does_something(on):
    """Else the other tests would tell nothing. It may come too late for many a tick."""
    sim = on(2, scene(towers(1)))
    worlds = inside.scratch_of_helpers(sim)
    sim.step(1)
    (helper,) = worlds
    written = helper.constraints.scratch, helper.detection.found  # of solver and narrow phase
    for _ in range(200):
        if all(scratch.any() for scratch in written):
            break
        sim.step(5)
    assert all(scratch.any() for scratch in written)


@pytest.mark.parametrize(
    ('count', 'looks'), [(200, 2), pytest.param(450, 4, marks=pytest.mark.long)]
)
def test_threads_change_no_bit_of_a_falling_pile(on, counts, count, looks):
    """One island in the end, and before that many that join."""
    draw = np.random.default_rng(3)
    bodies = [ground()]
    for i in range(count):
        at = np.array([i % 10, i // 10 % 5, i // 50]) * 0.22 + (0, 0, 0.12)
        at += draw.uniform(-0.02, 0.02, 3)
        bodies.append(box(f'b{i}', 0.2, tuple(at)))
    first = [on(threads, scene(bodies)) for threads in counts]
    for _ in range(looks):
        found = {after(sim, 25) for sim in first}
        assert len(found) == 1


def test_threads_change_no_bit_over_a_restore(on):
    described = scene(towers(4))
    found = []
    for threads in (1, 3):
        sim = on(threads, described)
        sim.step(12)
        other = on(4 - threads, described)
        other.restore(tick=sim.tick, state=sim.state_bytes(), slots={})
        found += [after(other, 12), after(sim, 12)]
    assert len(set(found)) == 1


def test_threads_change_no_bit_of_what_falls_asleep(on):
    described = scene(towers(5), sleeping=True, sleep_time=0.05)
    found = []
    for threads in (1, 3):
        sim = on(threads, described)
        found.append([after(sim, 30) for _ in range(3)])
        assert 0 < len(inside.islands(sim))
    assert found[1:] == found[:-1]


@pytest.mark.parametrize('ticks', [6, pytest.param(10, marks=pytest.mark.long)])
def test_threads_change_no_bit_of_what_bounces_at_its_instant(on, counts, ticks):
    """From the seventh tick on the towers are full of impacts, some thousand in each."""
    described = scene(towers(6, material={'restitution': 0.5}), mode='event')
    sims = [on(threads, described) for threads in counts]
    assert len({after(sim, ticks) for sim in sims}) == 1
    assert {len(sim.impacts()) > 500 for sim in sims} == {True}


def test_an_interrupt_in_the_midst_puts_all_back(on):
    sim, other = (on(3, scene(towers(7))) for _ in range(2))
    for each in (sim, other):
        each.step(10)
    before = sim.tick, sim.state_bytes()

    def interrupted(*_):
        raise KeyboardInterrupt

    with inside.helped(sim, interrupted), pytest.raises(KeyboardInterrupt):
        sim.step(5)
    assert (sim.tick, sim.state_bytes()) == before
    assert after(sim, 10) == after(other, 10)


def test_nobody_helps_when_the_call_is_over(on):
    running = threading.active_count()
    sim = on(3, scene(towers(8)))
    sim.step(5)
    board = inside.board(sim)
    assert board[crew.OVER] == 1
    assert board[crew.HELPERS] == 0
    assert threading.active_count() == running


def test_few_bodies_are_left_alone(monkeypatch):
    """A tick of few is over before another thread has begun."""
    monkeypatch.setattr(ticks, 'threads', lambda: 2)
    few = Simulation(scene([ground(), box('b', 0.2, (0, 0, 0.1))]))
    with inside.helped(few) as helpers:
        few.step(50)
    assert not helpers
