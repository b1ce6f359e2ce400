# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run as arrays is what stepping by hand gives; controllers, ends, what may not be written."""

import copy
import dataclasses
import json
import os
import pickle
import signal
import threading
import warnings

import numpy as np
import pytest

import rigid_body_sim as rbs
from rigid_body_sim.errors import RunError
from rigid_body_sim.physics.errors import SimulationBusy

from ..patience import PATIENCE
from .conftest import VECTORS, damper, same_bits

STATE = (*VECTORS[:4], 'angular_velocity_body', 'momentum', 'angular_momentum')


def test_a_run_has_the_bits_of_stepping_by_hand():
    run = rbs.simulate('two_bodies', 0.2, every=0.02)
    sim = rbs.Simulation('two_bodies')
    for row, time in enumerate(run.time):
        assert time == sim.time
        for i, name in enumerate(run):
            for quantity in STATE:
                assert same_bits(
                    getattr(run[name], quantity)[row], getattr(sim.state, quantity)[i]
                )
        assert run.energy[row] == sim.energy()
        sim.step(20)
    assert run.complete and run.end_time == 0.2 and len(run.time) == 11


def test_an_instant_is_the_number_that_its_decimals_write(tmp_path):
    run = rbs.simulate('two_bodies', 0.1, every=0.01)
    written = [f'0.{k:02d}' for k in range(10)] + ['0.1']
    assert run.time.tolist() == list(map(float, written))  # 30000000 * 1e-9 is none
    run.save(tmp_path / 'bag')
    read = rbs.open_bag(tmp_path / 'bag')
    assert read.time.tolist() == run.time.tolist()
    sim = rbs.Simulation('two_bodies')
    sim.step(30)
    assert sim.time == 0.03
    assert sim.run(0.04).end_time == 0.07


def test_stretches_one_after_the_other_are_one_run(run):
    sim = rbs.Simulation('satellite')
    parts = [sim.run(0.5, every=0.05, controller=damper) for _ in range(2)]
    assert parts[1].time[0] == parts[0].time[-1] == 0.5
    for name in run:
        for quantity in STATE:
            first, second = (getattr(part[name], quantity) for part in parts)
            assert same_bits(np.concatenate([first, second[1:]]), getattr(run[name], quantity))


def test_a_controller_is_asked_from_the_start_and_held_until_it_is_asked_again():
    asked = []

    def ramp(t, state):
        asked.append((t, state['beacon'].position[1]))
        return {'beacon': rbs.Wrench(force=(0, 1 + t, 0))}

    run = rbs.simulate('satellite', 0.5, every=0.1, controller=ramp)
    assert [t for t, _ in asked] == run.time[:-1].tolist()  # at the end it would never act
    assert [y for _, y in asked] == run['beacon'].position[:-1, 1].tolist()
    force = run['beacon'].force[:, 1]
    assert force.tolist() == [1 + t for t in run.time[:-1]] + [force[-2]]
    velocity = run['beacon'].velocity[:, 1]  # F dt / m in every period: round-off
    assert np.allclose(np.diff(velocity), 0.1 * force[:-1] / 0.2, rtol=1e-14)


def test_who_is_not_named_gets_nothing_and_nothing_holds_after_the_run():
    sim = rbs.Simulation('satellite')
    sim.set_wrench('inspector', force=(0, 0, 1))
    run = sim.run(
        0.4,
        every=0.1,
        controller=lambda t, state: {'beacon': rbs.Wrench(force=(1, 0, 0))} if t < 0.15 else None,
    )
    assert run['beacon'].force[:, 0].tolist() == [1, 1, 0, 0, 0]
    assert run['inspector'].force[:, 2].tolist() == [1, 1, 1, 1, 1]  # what is held stays
    force, _ = sim.applied_wrench()
    assert force[:, 2].tolist() == [0, 1, 0] and not force[:, 0].any()


def test_a_controller_takes_the_place_of_what_set_wrench_held_and_says_so():
    sim = rbs.Simulation('satellite')
    sim.set_wrench('beacon', force=(5, 0, 0))
    with pytest.warns(rbs.RunWarning, match='took the place of the wrench .* held on .beacon.'):
        run = sim.run(
            0.2, every=0.1, controller=lambda t, s: {'beacon': rbs.Wrench(force=(1, 0, 0))}
        )
    assert run['beacon'].force[:, 0].tolist() == [1, 1, 1]
    assert 'took the place' in repr(run)


def test_several_thrusters_of_a_body_push_at_once():
    def two(t, state):
        frames = ('front_left', 'drone/front_right')
        return {'drone': [rbs.Wrench(force=(0, 0, 3), frame=frame) for frame in frames]}

    run = rbs.simulate('quadrotor', 0.01, every=0.001, controller=two)
    assert np.allclose(run['drone'].force[0], (0, 0, 6))


@pytest.mark.parametrize(
    ('answer', 'reason'),
    [
        (5, 'it answered 5; allowed: a mapping'),
        ({'satelite': rbs.Wrench()}, "no body is named 'satelite'; did you mean 'satellite'"),
        ({'satellite': (1, 0, 0)}, r'it answered \(1, 0, 0\) for .satellite.; allowed: a Wrench'),
        ({'satellite': rbs.Wrench(force=(1, 2))}, 'three finite numbers'),
        ({'satellite': rbs.Wrench(torque=(np.nan, 0, 0))}, 'three finite numbers'),
        ({'satellite': rbs.Wrench(force='abc')}, 'three finite numbers'),
        ({'satellite': rbs.Wrench(frame='nozzle')}, "frame 'nozzle'; allowed: world, body"),
        ({'beacon': rbs.Wrench(torque=(1, 0, 0))}, 'point mass'),
        ({'satellite': [rbs.Wrench(), rbs.Wrench(frame='body')]}, 'two wrenches'),
        ({3: rbs.Wrench()}, 'no body is named 3'),
    ],
)
def test_an_answer_that_is_none_is_refused_with_its_time_and_holds_nothing(answer, reason):
    sim = rbs.Simulation('satellite')
    with pytest.raises(rbs.InvalidModel, match=f'controller at 0 s: .*{reason}') as refused:
        sim.run(1, controller=lambda t, state: answer)
    assert not sim.held_slots and sim.tick == 0
    assert len(refused.value.run.time) == 1


@pytest.mark.parametrize('every', [0, -1, 0.003, 1e-9, np.inf, np.nan, 'x', True, None])
@pytest.mark.parametrize('duration', [0.03, -1, np.nan, np.inf, 'x', 1e30, 0.005])
def test_times_that_are_no_whole_ticks_are_refused(duration, every):
    if (duration, every) == (0.03, None):
        assert len(rbs.simulate('satellite', duration, every=every).time) == 4
        return
    with pytest.raises(rbs.InvalidModel, match=r'^(duration|every): .*(allowed)'):
        rbs.simulate('satellite', duration, every=every)


def test_the_nearest_ticks_are_named():
    with pytest.raises(rbs.InvalidModel, match=r'nearest allowed: 0.02 or 0.03 s'):
        rbs.simulate('satellite', 1, every=0.025)
    with pytest.raises(rbs.InvalidModel, match='GB; take a longer every'):
        rbs.simulate('satellite', 1e9)


def test_no_time_at_all_is_the_present_state_alone():
    run = rbs.simulate('satellite', 0)
    assert run.time.tolist() == [0] and run.complete


def test_a_row_that_is_missing_at_the_end_is_told():
    with pytest.warns(rbs.RunWarning, match='ends at 1 s and its last row is that of 0.9 s'):
        run = rbs.simulate('satellite', 1, every=0.3)
    assert run.time.tolist() == pytest.approx([0, 0.3, 0.6, 0.9]) and run.end_time == 1


@pytest.mark.parametrize('dt', [0.001, 0.002, 0.004, 0.005, 0.01])
@pytest.mark.parametrize('duration', [0.1, 0.5, 1.5, 2.1])
def test_rows_that_nobody_chose_end_where_the_run_ends(dt, duration):
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        run = rbs.simulate('satellite', duration, dt=dt)
    assert run.time[-1] == run.end_time == duration
    assert 0.004 <= run.time[1] <= 0.01


def spring(stiffness):
    """A point on a spring that a step of 0.1 s does not resolve."""
    ball = rbs.make_body('ball', rbs.Particle(), mass=1, position=(1, 0, 0))
    return rbs.make_scene([ball], [rbs.Spring('ball', 'world', stiffness=stiffness)], dt=0.1)


def test_a_run_that_diverges_gives_what_was_reached_and_says_so(tmp_path):
    with pytest.warns(rbs.RunWarning, match="'ball' diverged in tick"):
        run = rbs.simulate(spring(1e6), 100, every=0.1, integrator='explicit_euler')
    assert run.end_reason == 'diverged' and not run.complete and 5 < len(run.time) < 1000
    assert np.isfinite(run['ball'].position).all()
    assert 'ended early (diverged)' in repr(run)
    run.save(tmp_path / 'bag')
    assert rbs.open_bag(tmp_path / 'bag').end_reason == 'diverged'


def test_what_a_controller_raises_goes_on_with_what_was_reached():
    def fails(t, state):
        if t >= 0.5:
            raise ZeroDivisionError('late')
        return {'satellite': rbs.Wrench(torque=(0, 0, 0.1))}

    sim = rbs.Simulation('satellite')
    with pytest.raises(ZeroDivisionError, match='late') as raised:
        sim.run(1, every=0.1, controller=fails)
    reached = raised.value.run
    assert len(reached.time) == 6 and reached.end_reason == 'error'
    assert sim.tick == 50 and not sim.held_slots


@pytest.fixture
def ctrl_c():
    """
    Ctrl-C raises, also where the suite was started in the background, which ignores it.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_goes_on_with_what_was_reached_and_can_be_saved(tmp_path, ctrl_c):
    def until_late(t, state):
        if t > 0.2:
            os.kill(os.getpid(), signal.SIGINT)
        return {'satellite': rbs.Wrench(torque=(0, 0, 0.1))}

    sim = rbs.Simulation('satellite')
    with pytest.raises(KeyboardInterrupt) as raised:
        sim.run(1000, every=0.01, controller=until_late)
    reached = raised.value.run
    assert reached.end_reason == 'stopped' and len(reached.time) >= 20
    assert not sim.held_slots and reached.end_time == sim.time
    reached.save(tmp_path / 'bag')
    again = rbs.open_bag(tmp_path / 'bag')['satellite'].position[: len(reached.time)]
    assert same_bits(again, reached['satellite'].position)


def test_a_controller_that_steps_its_own_simulation_is_refused():
    sim = rbs.Simulation('satellite')
    with pytest.raises(rbs.InvalidModel, match='it moved the simulation that asks it'):
        sim.run(1, controller=lambda t, state: sim.step(1))


def test_what_changes_a_run_behind_its_back_is_found_when_it_is_saved(tmp_path):
    sim = rbs.Simulation('satellite')
    run = sim.run(
        0.1,
        every=0.05,
        controller=lambda t, s: sim.apply_impulse('beacon', linear=(1, 0, 0)) and {},
    )
    with pytest.raises(rbs.RunError, match='ends in another state'):
        run.save(tmp_path / 'bag')
    assert not (tmp_path / 'bag').exists()


def test_one_simulation_runs_in_one_thread():
    sim, found = rbs.Simulation('satellite'), []
    under_way, refused = threading.Event(), threading.Event()

    def wait(t, state):
        under_way.set()
        refused.wait(PATIENCE)

    thread = threading.Thread(target=lambda: found.append(sim.run(5, every=0.01, controller=wait)))
    thread.start()
    assert under_way.wait(PATIENCE)
    try:
        for _ in range(2):
            with pytest.raises(SimulationBusy):
                sim.run(5, every=0.01)
    finally:
        refused.set()
        thread.join()
    (run,) = found
    assert sim.time == 5  # the others changed nothing
    once = rbs.simulate('satellite', 5, every=0.01)
    assert same_bits(run['satellite'].orientation, once['satellite'].orientation)


@pytest.mark.parametrize('copied', [copy.deepcopy, lambda run: pickle.loads(pickle.dumps(run))])
def test_a_copy_is_the_same_run_and_is_as_read_only(run, copied, tmp_path):
    other = copied(run)
    for name in run:
        for quantity in STATE:
            assert same_bits(getattr(other[name], quantity), getattr(run[name], quantity))
    assert same_bits(other.energy, run.energy)
    for array in (other.time, other.energy, other['beacon'].force, other['beacon'].position):
        with pytest.raises(ValueError, match='read-only'):
            array[0] = 1
    other.save(tmp_path / 'bag')


@pytest.mark.parametrize(
    'error',
    [
        rbs.SimulationDiverged(body='box', tick=7, cause='too stiff', found='h omega 9'),
        SimulationBusy(),
        rbs.InvalidModel('why', at=('bodies', 3)),
        rbs.UserError('why'),
        rbs.RunError('why'),
    ],
    ids=lambda error: type(error).__name__,
)
def test_what_fails_in_a_process_of_a_pool_can_be_told_to_who_asked(error):
    told = pickle.loads(pickle.dumps(error))  # which a pool does, and else breaks or hangs
    assert type(told) is type(error)
    assert str(told) == str(error) and told.__dict__ == error.__dict__


def test_wrenches_are_equal_where_their_numbers_are():
    push = rbs.Wrench(np.array([1.0, 0, 0]), frame='body')
    assert {'box': push} == {'box': rbs.Wrench((1, 0, 0), [0, 0, 0], 'body')}
    assert hash(push) == hash(rbs.Wrench((1, 0, 0), frame='body'))
    for other in (rbs.Wrench((1, 0, 0)), rbs.Wrench((1, 0, 1), frame='body'), (1, 0, 0), None):
        assert push != other
    assert push != rbs.Wrench((1, 0, 0), (0, 0, 1), frame='body')


def test_a_body_that_is_not_there_is_a_key_error_with_a_proposal(run):
    with pytest.raises(KeyError, match=r"^no body is named 'becon'; did you mean 'beacon'\?"):
        run['becon']
    with pytest.raises(KeyError, match='did you mean'):
        rbs.Simulation('satellite').state['satelite']
    assert 'beacon' in run and list(run) == ['satellite', 'inspector', 'beacon']


def test_names_that_are_nearly_right_are_proposed():
    with pytest.raises(rbs.UserError, match="did you mean 'satellite'"):
        rbs.simulate('satelite', 1)
    with pytest.raises(rbs.InvalidModel, match="did you mean 'dmv8'"):
        rbs.simulate('satellite', 1, integrator='dmv7')
    with pytest.raises(AttributeError, match="did you mean 'simulate'"):
        rbs.simulat  # noqa: B018
    with pytest.raises(rbs.UserError, match='YAML itself is given as bytes'):
        rbs.load_scene('version: 1\ndt: 0.1\n')


def test_a_bag_that_is_called_as_its_scene_does_not_hide_the_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rbs.simulate('satellite', 0.1).save('satellite')
    assert rbs.load_scene('satellite').name == 'satellite'
    with pytest.raises(rbs.UserError, match='folder'):
        rbs.load_scene(str(tmp_path))


def test_auto_runs_and_its_bag_replays(tmp_path):
    from rigid_body_sim.__main__ import main

    push = {'box': rbs.Wrench(force=(0.1, 0, 0))}
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        run = rbs.simulate('two_bodies', 0.3, integrator='auto', controller=lambda t, s: push)
    run.save(tmp_path / 'bag')
    assert main(['replay', str(tmp_path / 'bag')]) == 0


@pytest.mark.parametrize('scene', ['spring_ball', 'bouncing_ball', 'rocket'])
def test_the_energy_balance_is_that_of_the_verb_and_of_the_bag_to_the_bit(scene, tmp_path, verb):
    run = rbs.simulate(scene, 0.48)
    code, out, _ = verb('simulate', scene, '-o', tmp_path / 'bag', '--duration', 0.48, '--json')
    assert code == 0
    assert dataclasses.asdict(run.energy_balance) == json.loads(out)['energy_balance']
    back = rbs.open_bag(tmp_path / 'bag')
    assert back.energy_balance == run.energy_balance
    assert back.summary().splitlines()[1] == run.summary().splitlines()[1]


def test_the_energy_balance_of_commands_closes_with_what_the_energy_did(run):
    balance = run.energy_balance
    assert balance.work_of_commands != 0.0 and balance.gain is None
    # the works are integrals known to `uncertainty`; energies of some 1e-3 J, read to round-off
    assert balance.change == pytest.approx(run.energy[-1] - run.energy[0], abs=1e-15)
    accounted = balance.work_of_commands + balance.work_of_drives - balance.dissipation
    assert balance.change - accounted == pytest.approx(balance.defect, abs=1e-15)
    assert 'commands' in run.summary() and 'commands' in run._repr_html_().partition('<iframe')[0]


def test_a_run_that_took_long_is_not_made_again_unasked(run):
    slow = dataclasses.replace(run, _cost=100.0)
    assert 'run.energy_balance makes the run again for it, some 100 s' in slow.summary()
    assert slow.energy_balance == run.energy_balance
    assert 'commands' in slow.summary()  # now it is known


def test_what_changes_a_run_behind_its_back_leaves_no_balance():
    sim = rbs.Simulation('satellite')

    def push(_t, _state):
        sim.apply_impulse('beacon', linear=(1, 0, 0))

    run = sim.run(0.1, controller=push)
    with pytest.raises(RunError, match='the run ends in another state'):
        _ = run.energy_balance
    assert 'energy balance: not known' in run.summary()


@pytest.mark.parametrize(('method', 'gains'), [('explicit_euler', True), ('dmv6', False)])
def test_a_passive_run_that_gains_energy_says_so_as_the_verb_does(method, gains):
    with warnings.catch_warnings(record=True):
        warnings.simplefilter('always')
        run = rbs.simulate('oscillator', 3, integrator=method)
    assert any('the scene gained' in text for text in run.warnings) == gains
    assert run.energy_balance.gains == gains
