# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bits: repeats, whole runs and single ticks, restored and reset runs, labels, refusals.
"""

import copy
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.simulation import Simulation

from .. import inside
from . import bits_of_contact
from .touching import H, ball, box, ground, heap, lean, scene, stack

HERE = Path(__file__).parent
PATHS = str(HERE.parent), str(HERE.parents[1])


def test_what_a_shared_kernel_knows_beside_its_scene_changes_no_bit():
    """
    Of a state. Of what does not roll, contacts may remember -0 in place of 0.
    """
    done = subprocess.run(
        [sys.executable, str(HERE / 'shared_cases.py')],
        env={**os.environ, 'RIGID_BODY_SIM_COMPILE': '0', 'PYTHONPATH': ':'.join(PATHS)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    scenes = dict(line.split(': ') for line in done.stdout.splitlines())
    assert len(scenes) >= 24 and {*scenes.values()} == {'True True True'}, scenes


def test_many_ticks_at_once_give_the_bits_of_one_by_one_and_of_every_run():
    at_once, one_by_one = Simulation(scene(heap(6))), Simulation(scene(heap(6)))
    at_once.step(400)
    for _ in range(400):
        one_by_one.step()
    assert at_once.state_bytes() == one_by_one.state_bytes()


def test_a_restored_run_and_a_reset_one_give_the_same_bits():
    sim = Simulation(scene(heap(6)))
    sim.step(200)
    middle = sim.state_bytes()
    sim.step(200)
    end = sim.state_bytes()
    other = Simulation(scene(heap(6)))
    other.restore(tick=200, state=middle, slots={})
    other.step(200)
    assert other.state_bytes() == end
    sim.reset()
    assert not len(sim.contacts())
    sim.step(400)
    assert sim.state_bytes() == end


@pytest.mark.parametrize('ticks', [1, 60])
def test_what_stands_at_the_start_stands_the_same_after_a_reset_and_where_its_start_is_restored(
    ticks,
):
    """
    The first tick finds the loads of what stands, whatever its number is.
    """
    fresh = Simulation(scene(stack(4)))
    start = fresh.state_bytes()
    fresh.step(ticks)
    end, depth = fresh.state_bytes(), fresh.deepest_gap()
    for tick in (1, 33):
        again = Simulation(scene(stack(4)))
        again.step(tick)
        again.reset()
        assert again.state_bytes() == start
        others = [copy.copy(again), pickle.loads(pickle.dumps(again)), Simulation(again.scene)]
        others[-1].restore(tick=tick, state=start, slots={})
        for one in (again, *others):
            for _ in range(ticks):
                one.step()
            assert one.state_bytes() == end and one.deepest_gap() == depth
            assert one.scene_time == fresh.scene_time


def test_what_was_under_way_goes_on_as_it_was_from_tick_0_too():
    sim = Simulation(scene(stack(4)))
    sim.step(3)
    middle = sim.state_bytes()
    other = Simulation(sim.scene)
    other.restore(tick=0, state=middle, slots={})
    for one in (sim, other):
        one.step(20)
    assert other.state_bytes() == sim.state_bytes()


@pytest.mark.parametrize('cut', [8, 80, -8])
def test_a_state_whose_contacts_are_kept_otherwise_is_refused_and_the_run_goes_on(cut):
    """
    As of another version, which keeps more or fewer numbers of a contact: shorter or longer.
    """
    sim = Simulation(scene(heap(6)))
    sim.step(200)
    state = sim.state_bytes()
    other = state[:-cut] if cut > 0 else state + state[cut:]
    with pytest.raises(InvalidModel, match='another version'):
        sim.restore(tick=200, state=other, slots={})
    assert sim.state_bytes() == state


def test_labels_of_bodies_change_nothing_beyond_rounding():
    bodies = heap(6)
    shuffled = [bodies[i] for i in np.random.default_rng(3).permutation(len(bodies))]
    one, other = Simulation(scene(bodies)), Simulation(scene(shuffled))
    one.step(300)
    other.step(300)
    for body in bodies:
        a = one.state.position[one.body_index(body.name)]
        b = other.state.position[other.body_index(body.name)]
        assert np.abs(a - b).max() < 1e-12


@pytest.mark.parametrize('how', [[], pytest.param(['in full'], marks=pytest.mark.long)])
def test_compiled_and_plain_kernels_give_the_same_bits(how):
    """Compiled in this process: as all tests know them."""
    run = subprocess.run(
        [sys.executable, bits_of_contact.__file__, *how],
        env={**os.environ, 'RIGID_BODY_SIM_COMPILE': '0', 'PYTHONPATH': ':'.join(PATHS)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    first, *plain = run.stdout.splitlines()
    assert first == 'False'
    assert plain == list(bits_of_contact.lines(*how))


@pytest.mark.long
def test_a_kernel_that_knows_nothing_but_weight_and_impacts_gives_the_bits_of_the_plain_one():
    """Of which scenes of tests share one that knows more."""
    first, second = (
        subprocess.run(
            [sys.executable, bits_of_contact.__file__, bits_of_contact.OWN],
            env={**os.environ, 'RIGID_BODY_SIM_COMPILE': wanted, 'PYTHONPATH': ':'.join(PATHS)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.splitlines()
        for wanted in '01'
    )
    assert (first[0], second[0]) == ('False', 'True')
    assert first[1:] == second[1:]


def test_lists_that_are_too_short_grow_without_a_trace():
    sim, other = Simulation(scene(heap(6))), Simulation(scene(heap(6)))
    inside.shorten(other, pair_ids=1, manifolds=32, cache=2, rows=500)
    sim.step(300)
    other.step(300)
    assert other.state_bytes() == sim.state_bytes()


@pytest.mark.parametrize('tilt', np.linspace(0.05, 0.35, 13))
def test_bodies_far_apart_do_not_feel_each_other(tilt):
    # on an edge, two points of contact; it shares a batch, and sweeps of a bounce, with boxes that
    # have four
    turned = box('b', 0.2, (0, 0, 0.15), q=(math.sin(tilt), 0, 0, math.cos(tilt)))
    others = [box(f'c{i}', 0.2, (3.0 + i, 0, 0.1)) for i in range(2)]
    alone = Simulation(scene([ground(), turned]))
    among = Simulation(scene([ground(), turned, *others]))
    alone.step(120)
    among.step(120)
    assert alone.state.position[1, 2] == pytest.approx(0.1, abs=1e-5)
    assert alone.state.position[1].tobytes() == among.state.position[1].tobytes()


def test_momentum_of_bodies_that_touch_each_other_alone_stays():
    rng = np.random.default_rng(5)
    bodies = [
        box(f'b{i}', 0.3, rng.uniform(-0.6, 0.6, 3), velocity=rng.normal(size=3),
            turn=rng.normal(size=3))
        for i in range(8)
    ]  # fmt: skip
    sim = Simulation(scene(bodies, gravity=(0, 0, 0)))
    momentum = sim.momentum()
    scale = sum(np.linalg.norm(body.initial.velocity) for body in bodies)
    sim.step(240)
    assert np.abs(sim.momentum() - momentum).max() < 1e-12 * scale


def test_a_held_force_and_an_impulse_act_on_bodies_that_touch():
    sim = Simulation(lean([ground(), box('b', 0.2, (0, 0, 0.1))]))
    sim.step(10)
    sim.set_wrench('b', force=(4.0, 0, 0))  # less than mu m g = 4.9 N
    sim.step(240)
    assert abs(sim.state.velocity[1, 0]) < 1e-9
    sim.set_wrench('b', force=(6.0, 0, 0))
    sim.step(240)
    assert sim.state.velocity[1, 0] == pytest.approx(6.0 - 0.5 * 9.81, abs=6.0 * H)
    sim.set_wrench('b')
    sim.apply_impulse('b', linear=(0, 0, 1.0))
    assert sim.state.velocity[1, 2] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize('integrator', ['rk4', 'semi_implicit_euler', 'blanes_moan4', 'rk45'])
def test_integrators_that_do_not_suit_contact_say_so(integrator):
    with pytest.raises(InvalidModel, match=r'refuses the scene .* take one of: dmv2'):
        Simulation(lean([ground(), ball('b', 0.1, (0, 0, 1))]), integrator=integrator)


def test_auto_takes_a_splitting_method_and_says_why():
    sim = Simulation(lean([ground(), ball('b', 0.1, (0, 0, 1))]), integrator='auto')
    assert sim.integrator.name == 'dmv6'
    assert sim.choice is not None and 'contact' in sim.choice.reason


@pytest.mark.parametrize(
    ('given', 'said'),
    [
        ({'substep': 4}, "no key 'substep'"),
        ({'substeps': 0}, 'a whole number from 1 to 1000'),
        ({'damping_ratio': -1.0}, 'not negative'),
        ({'margin': math.nan}, 'a finite number'),
        ({'sleeping': 1}, 'true or false'),
    ],
)
def test_impossible_settings_are_refused(given, said):
    with pytest.raises(InvalidModel, match=said):
        Simulation(lean([ground()], **given))


def test_a_scene_without_contact_has_no_contacts_and_loads_none_of_it():
    code = (
        'import sys; from rigid_body_sim import Simulation, load_scene\n'
        "sim = Simulation(load_scene({'bodies': [{'name': 'b', 'mass': 1, "
        "'shape': {'type': 'sphere', 'radius': 1}}], 'dt': 0.01}))\n"
        'assert len(sim.contacts()) == 0\n'
        "assert not [m for m in sys.modules if m.startswith('rigid_body_sim.physics.contact.')]\n"
    )
    run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
