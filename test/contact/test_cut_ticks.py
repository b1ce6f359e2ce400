# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ticks that are cut, by forces that begin or end inside them: what rests does not feel it.
"""

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.forces.elements.time import TimeTable

from .touching import ball, box, ground, scene

TICK = 0.004  # [s]
SETTLED = 4000  # [tick] after which ten cubes still sink by 1e-8 m in forty ticks
FOREVER = 1e6  # [s]


def stacks(begins=(), *, on=('one 0', 'five 2', 'ten 4')):
    """
    Stacks of 1, 5 and 10 cubes on the ground, with forces of zero on some that begin at instants
    [tick].
    """
    bodies = [ground()]
    for place, (name, count) in enumerate((('one', 1), ('five', 5), ('ten', 10))):
        bodies += [
            box(f'{name} {i}', 0.2, (3.0 * place, 0, 0.2 * (i + 0.5))) for i in range(count)
        ]
    forces = [
        TimeTable(body, ((begin * TICK, 0, 0, 0), (FOREVER, 0, 0, 0)))
        for begin in begins
        for body in on
    ]
    return scene(bodies, dt=TICK, forces=tuple(forces))


@pytest.fixture(scope='module')
def at_rest():
    """
    The state of the stacks after sixteen seconds, by how many ticks later.
    """
    sim = Simulation(stacks([FOREVER]))
    sim.step(SETTLED)
    state = sim.state_bytes()
    later = []
    for _ in range(40):
        sim.step()
        later.append(sim.state.position.copy())
    return state, np.array(later)


def way_of(begins, at_rest, **more):
    """
    How far a scene with these instants [tick after the rest] strays from one without [m].
    """
    state, expected = at_rest
    sim = Simulation(stacks(SETTLED + np.asarray(begins), **more))
    sim.restore(tick=SETTLED, state=state, slots={})
    most = 0.0
    for positions in expected:
        sim.step()
        most = max(most, float(np.max(abs(sim.state.position - positions))))
    return most


INSTANTS = [1e-8, 1e-6, 1e-4, 0.01, 0.1, 0.5, 0.9, 0.9999, 1 - 1e-6, 1 - 1e-8]


@pytest.mark.parametrize('instant', INSTANTS)
def test_a_cut_anywhere_in_a_tick_moves_no_stack_at_rest(instant, at_rest):
    assert way_of([instant], at_rest) < 1e-9  # ten cubes settle by more, five by round-off


@pytest.mark.parametrize('seed', range(3))
def test_cuts_in_many_places_of_many_ticks_move_no_stack_at_rest(seed, at_rest):
    """
    Several in one tick, slivers among them, and in consecutive ticks.
    """
    rng = np.random.default_rng(seed)
    inside = np.sort(rng.uniform(0, 1, 4))
    slivers = np.arange(1, 6) + 10.0 ** rng.uniform(-8, 0, 5)
    # ten cubes settle by more
    assert way_of([*inside, inside[0] + 1e-6, *slivers], at_rest) < 1e-9


def test_a_contact_that_begins_in_a_cut_tick_begins_as_in_a_whole_one():
    """
    A cube that is dropped stands still, and as deep as its load asks: g / omega_c^2, a micrometre.
    """
    bodies = [ground(), box('cube', 0.2, (0, 0, 0.11)), ball('far', 0.1, (9, 0, 5))]
    heights = []
    for begins in ([FOREVER], np.arange(20) + 0.97, np.arange(40) * 0.5 + 0.03):
        forces = [TimeTable('cube', ((b * TICK, 0, 0, 0), (FOREVER, 0, 0, 0))) for b in begins]
        sim = Simulation(scene(bodies, dt=TICK, forces=tuple(forces)))
        sim.step(250)
        assert np.max(abs(sim.state.velocity[1])) < 1e-9
        heights.append(sim.state.position[1, 2])
    # what overlaps by less than the sink may keep it: to lift it would bring energy
    assert np.ptp(heights) < 1e-6


def test_a_cut_run_that_is_restored_goes_on_with_the_same_bits():
    begins = SETTLED + np.array([0.3, 0.301, 3.7, 5.2, 5.9])
    whole, parted = (Simulation(stacks(begins)) for _ in range(2))
    whole.step(SETTLED + 10)
    parted.step(SETTLED + 4)
    state = parted.state_bytes()
    other = Simulation(stacks(begins))
    other.restore(tick=SETTLED + 4, state=state, slots={})
    other.step(6)
    assert other.state_bytes() == whole.state_bytes()
    parted.step(1)
    parted.restore(tick=SETTLED + 4, state=state, slots={})
    parted.step(6)
    assert parted.state_bytes() == whole.state_bytes()


def test_contacts_of_a_cut_tick_have_the_impulses_of_all_its_pieces():
    sim = Simulation(stacks([4.25, 4.5], on=('one 0',)))
    sim.step(5)
    contacts = sim.contacts()
    carried = contacts.impulse[(contacts.bodies == 1).any(axis=1), 2].sum()
    assert abs(carried) == pytest.approx(9.81 * TICK, rel=0.2)
