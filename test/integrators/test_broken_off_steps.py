# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A step that is broken off leaves tick and state that belong together; what is no number of ticks is
refused; one simulation is stepped by one thread at a time.
"""

import dis
import sys
import threading
import time
from pathlib import Path

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import InvalidModel, SimulationBusy

SCENE = Path(__file__).parents[2] / 'config' / 'scenes' / 'two_bodies.yaml'

POINTS = 48  # of some hundreds where Python may be interrupted


class Interrupt:
    """
    Raises KeyboardInterrupt at given places, as Python does: after a call, at the start of a
    function, at the end of a loop.
    """

    def __init__(self, *places):
        self.places, self.seen, self._last = list(places), 0, {}

    def __call__(self, frame, event, _argument):
        if f'rigid_body_sim{"/"}physics' not in frame.f_code.co_filename:
            return None
        frame.f_trace_opcodes = True
        if event == 'return':
            self._last.pop(frame, None)
        if event == 'opcode':
            before = self._last.get(frame, '')
            self._last[frame] = dis.opname[frame.f_code.co_code[frame.f_lasti]]
            if before.startswith(('CALL', 'RESUME', 'JUMP_BACKWARD')):
                self.seen += 1
                if self.seen in self.places:
                    raise KeyboardInterrupt
        return self

    def __enter__(self):
        sys.settrace(self)
        return self

    def __exit__(self, *_exception):
        sys.settrace(None)


OPERATIONS = [
    lambda sim: sim.step(3),
    lambda sim: sim.hold(
        'box', 'wrench', force=(1, 2, 3), torque=(0.1, 0, 0), frame='body', until=8
    ),
    lambda sim: sim.step(7),
    lambda sim: sim.apply_impulse('box', linear=(1, 0, 0), angular=(0, 1, 0.5)),
    lambda sim: sim.reset(),
    lambda sim: sim.step(3),
]


def made():
    simulation = Simulation(load_scene(SCENE))
    simulation.prepare(commands_in_body_axes=True)
    return simulation


def key(sim):
    held = {k: slot for k, slot in sim.held_slots.items() if slot.until > sim.tick}
    return sim.tick, sim.state_bytes(), sim.scene_time, repr(sorted(held.items()))


@pytest.fixture(scope='module')
def lawful():
    """
    Where a run may be before, in and after each operation: ticks one by one.
    """
    sim, found = made(), []
    for operation in OPERATIONS:
        places = [key(sim)]
        end = sim.tick + {0: 3, 2: 7, 5: 3}.get(OPERATIONS.index(operation), 0)
        if sim.tick == end:
            operation(sim)
            places.append(key(sim))
        while sim.tick < end:
            sim.step()
            places.append(key(sim))
        found.append(places)
    return found


@pytest.mark.parametrize(
    'more', [(), pytest.param((3,), marks=pytest.mark.long)], ids=['one', 'two']
)
def test_an_interrupt_anywhere_leaves_tick_and_state_that_belong_together(lawful, more):
    for _ in range(2):  # Python counts instructions from the second time on
        with Interrupt() as seen:
            sim = made()
            for operation in OPERATIONS:
                operation(sim)
    begin = Interrupt()
    with begin:
        made()
    total = seen.seen - begin.seen
    assert total > 300
    for k in range(POINTS):
        place = 1 + k * total // POINTS
        sim = made()
        with Interrupt(place, *(place + gap for gap in more)):
            number = 0
            try:
                while number < len(OPERATIONS):
                    OPERATIONS[number](sim)
                    number += 1
            except KeyboardInterrupt:
                pass
        if number == len(OPERATIONS):
            continue
        assert key(sim) in lawful[number], (place, number)
        # and it goes on as if nothing had been
        at, last = lawful[number].index(key(sim)), len(lawful[number]) - 1
        if number in (0, 2, 5):
            sim.step(last - at)
        elif at < last:
            OPERATIONS[number](sim)
        assert key(sim) == lawful[number][-1]


@pytest.mark.parametrize('ticks', [1.5, -1, '3', None, float('nan'), -(10**40)])
def test_what_is_no_number_of_ticks_is_refused_with_the_cure(ticks):
    sim = made()
    with pytest.raises(InvalidModel, match=r'a whole number of at least 0.*seconds / sim.dt'):
        sim.step(ticks)
    assert sim.tick == 0


def test_two_threads_in_one_simulation_are_refused():
    sim, alone = made(), made()
    worker = threading.Thread(target=sim.step, args=(600_000,))
    worker.start()
    while not sim.tick:
        time.sleep(0)
    with pytest.raises(SimulationBusy, match='one thread at a time'):
        while worker.is_alive():
            sim.step(0)
    worker.join()
    alone.step(600_000)
    assert sim.state_bytes() == alone.state_bytes() and sim.tick == alone.tick
