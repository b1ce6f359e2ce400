# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free bodies go on several threads, and nobody can tell: the same bits, whatever comes in between.
"""

import threading
import time

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics import stepper
from rigid_body_sim.physics.compile import kernels, side_by_side
from rigid_body_sim.physics.compile.side_by_side import SideBySide

from ..inside import parts_of_step

BODIES = 150  # three blocks
TICKS = 40


def many(integrator):
    """Bodies with and without extent, one fixed, over three blocks."""
    box = {'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]}, 'mass': 2.0}
    point = {'shape': {'type': 'particle'}, 'mass': 0.5}
    bodies = [
        {
            'name': f'b{i}',
            **(point if i % 5 == 4 else box),
            'initial': {'position': [2.0 * i, 0, 0], 'velocity': [0.1 * i, -1, 0.3]},
        }
        for i in range(BODIES)
    ]
    for body in bodies:
        if 'size' in body['shape']:
            body['initial']['angular_velocity'] = [0.3, 1.0, 0.01 * len(body['name'])]
    bodies[7] |= {'fixed': True, 'initial': {}}
    return {'integrator': integrator, 'dt': 0.01, 'bodies': bodies}


@pytest.fixture
def three_threads(monkeypatch):
    """Three threads, whatever the work is worth."""
    monkeypatch.setattr(stepper, 'threads', lambda: 3)
    monkeypatch.setattr(side_by_side, 'threads', lambda: 3)
    monkeypatch.setattr(stepper, 'WORTH_THREADS', 1)


def after_ticks(integrator):
    sim = Simulation(load_scene(many(integrator)))
    sim.set_wrench('b0', force=(1, 2, 3), torque=(0.1, 0, 0))
    sim.step(TICKS)
    return sim


@pytest.mark.skipif(not kernels.COMPILED, reason='plain Python has one lock')
@pytest.mark.parametrize('integrator', ['dmv6', 'semi_implicit_euler'])
def test_threads_change_no_bit(integrator, request):
    alone = after_ticks(integrator)
    assert not parts_of_step(alone) or side_by_side.threads() > 1
    request.getfixturevalue('three_threads')
    together = after_ticks(integrator)
    assert len(parts_of_step(together)) > 1
    assert together.state_bytes() == alone.state_bytes()


@pytest.mark.skipif(not kernels.COMPILED, reason='plain Python has one lock')
def test_an_interrupt_of_one_part_puts_all_back(three_threads):
    sim = after_ticks('dmv6')
    before = sim.tick, sim.state_bytes()

    def interrupted(*_):
        raise KeyboardInterrupt

    parts_of_step(sim).append(interrupted)
    with pytest.raises(KeyboardInterrupt):
        sim.step(TICKS)
    assert (sim.tick, sim.state_bytes()) == before
    parts_of_step(sim).remove(interrupted)
    sim.step(TICKS)
    other = after_ticks('dmv6')
    other.step(TICKS)
    assert sim.state_bytes() == other.state_bytes()


def test_all_calls_are_made_once_and_an_error_is_told_when_all_have_ended(three_threads):
    group, begun, made, lock = SideBySide(), [], [], threading.Lock()

    def call(number, factor):
        begun.append(number)
        time.sleep(0.002)  # [s] longer than it takes to give the next call away
        with lock:
            made.append(number)
        if number == 3:
            raise ArithmeticError
        return number * factor

    calls = [lambda factor, n=n: call(n, factor) for n in range(12) if n != 3]
    assert sorted(group.call(calls, (2,))) == sorted(2 * n for n in range(12) if n != 3)
    begun.clear()
    made.clear()
    with pytest.raises(ArithmeticError):
        group.call([*calls, lambda factor: call(3, factor)], (2,))
    assert sorted(begun) == sorted(made) == sorted(set(made))  # nothing goes on
    told = len(begun)
    group.rest()
    assert len(begun) == told


def test_environment_says_how_many_threads(monkeypatch):
    threads = side_by_side.threads.__wrapped__
    for name in side_by_side.NAMES:
        monkeypatch.delenv(name, raising=False)
    assert 1 <= threads() <= side_by_side.MOST
    monkeypatch.setenv('NUMBA_NUM_THREADS', '1')
    assert threads() == 1
    monkeypatch.setenv('RIGID_BODY_SIM_THREADS', '3')
    assert threads() == 3
    for odd in ('0', '-2', 'two', '2.5'):
        monkeypatch.setenv('RIGID_BODY_SIM_THREADS', odd)
        assert threads() == 1
