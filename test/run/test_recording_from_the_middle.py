# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A recording that begins while commands act, bodies touch or things happen between two published
ticks holds what a replay needs, to the bit; and where it ends between two, it tells what happened.
"""

import json

import numpy as np
import pytest

from rigid_body_sim.analysis.recorded_impacts import read_impacts
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state.impacts import joined
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.replay import compare, measure
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.runs.view import ViewSettings
from rigid_body_sim.scene import load_scene

SCENE = {
    'dt': 0.001,
    'bodies': [
        {
            'name': 'b',
            'shape': {'type': 'box', 'size': [0.1, 0.2, 0.3]},
            'mass': 1.0,
            'initial': {'position': [0, 0, 0], 'angular_velocity': [0, 1.0, 2.0]},
        }
    ],
}
WORLD = Command('b', 'force', (1.0, 0.0, 0.0))
BODY = Command('b', 'force', (1.0, 0.0, 0.0), frame_id='b')


@pytest.mark.parametrize('held', [WORLD, BODY], ids=['world axes', 'body axes'])
@pytest.mark.parametrize(
    'then',
    [
        [],
        [WORLD],
        [BODY],
        [Command('b', 'force')],
        [Command('b', 'impulse', (1.0, 0.0, 0.0))],
        [Command('b', 'torque', torque=(0.0, 0.0, 1.0))],
    ],
    ids=['nothing', 'world axes', 'body axes', 'zero', 'impulse', 'torque'],
)
@pytest.mark.parametrize(
    'timeout_ns', [pytest.param(0, marks=pytest.mark.long), 50_000_000], ids=['for ever', '50 ms']
)
def test_a_recording_begun_under_a_held_command_replays_identically(
    tmp_path, held, then, timeout_ns
):
    simulation = Simulation(load_scene(SCENE))
    run = Run(simulation, RunSettings(command_timeout_ns=timeout_ns))
    run.advance(1, [held])
    while simulation.tick < 33:
        run.advance(1)
    recorder = RunRecorder(run, tmp_path / 'bag')
    commands = then
    while (
        simulation.tick < 105
    ):  # tick by tick, as the node does; the replay does as many as it can at once
        tick = simulation.tick
        recorder.record(run.advance(1, commands), tick=tick)
        commands = [held] if simulation.tick == 67 else []
    recorder.close('stopped')
    outcome = compare(RecordedRun(tmp_path / 'bag'), output=None, progress=lambda tick, last: None)
    assert outcome.difference is None
    assert outcome.messages > 0


# Two balls that bounce every 13 ms or so on a floor, published each 10 ms: between two published
# ticks there are 0 to 4 impacts.
BOUNCING = {
    'dt': 0.001,
    'gravity': [0, 0, -9.81],
    'contact': {'mode': 'event'},
    'bodies': [
        {'name': 'floor', 'fixed': True, 'shape': {'type': 'plane', 'normal': [0, 0, 1]}},
        *(
            {
                'name': name,
                'shape': {'type': 'sphere', 'radius': 0.1},
                'mass': 1.0,
                'restitution': 1.0,
                'initial': {'position': [x, 0, 0.1], 'velocity': [0, 0, -speed]},
            }
            for name, x, speed in (('low', 0.0, 0.05), ('high', 1.0, 0.07))
        ),
    ],
}
VIEW = ViewSettings(frozenset({'markers', 'arrays', 'contact_wrenches'}))
PUSH = Command('low', 'force', (0.3, 0.0, 0.0))


def bouncing(mode='event', integrator=None, **settings):
    scene = load_scene({**BOUNCING, 'contact': {'mode': mode}})
    return Run(simulation_of(scene, integrator=integrator), RunSettings(**settings))


def recorded(run, path, ticks, commands=None):
    """Record tick by tick; return the impacts that were made."""
    simulation, made = run.simulation, []
    recorder = RunRecorder(run, path)
    for _ in range(ticks):
        tick = simulation.tick
        recorder.record(run.advance(1, (commands or {}).get(tick, ())), tick=tick)
        made.append(simulation.impacts())
    recorder.close('stopped')
    return joined(made)


def replayed(path):
    return compare(RecordedRun(path), output=None, progress=lambda tick, last: None)


@pytest.mark.parametrize(
    'settings',
    [
        {},
        {'publish_contacts': True},
        {'publish_contacts': True, 'view': VIEW},
        {'publish_phase': 3},
    ],
    ids=['states', 'contacts', 'views', 'phase'],
)
@pytest.mark.parametrize('mode', ['event', 'timestep'])
@pytest.mark.parametrize('draws', [3, pytest.param(8, marks=pytest.mark.long)])
def test_a_recording_begun_and_ended_at_any_ticks_replays_identically(
    tmp_path, mode, settings, draws
):
    draw = np.random.default_rng(20)
    run = bouncing(mode, **settings)
    waiting = 0
    for number in range(draws):
        idle, ticks = draw.integers(1, 25, size=2).tolist()
        for _ in range(idle):
            run.advance(1)
        waiting += len(run.untold_impacts)
        at = run.simulation.tick + ticks // 2
        recorded(run, tmp_path / str(number), ticks, {at: [PUSH]})
        outcome = replayed(tmp_path / str(number))
        assert outcome.difference is None
    assert (waiting > 0) == (mode == 'event')  # the draws are of what they are to be of


def test_a_recording_of_auto_begun_between_published_ticks_replays_identically(tmp_path):
    run = bouncing(integrator='auto')
    for _ in range(17):
        run.advance(1)
    assert len(run.untold_impacts)
    recorded(run, tmp_path / 'bag', 30)
    assert replayed(tmp_path / 'bag').difference is None


@pytest.mark.parametrize('ticks', [25, 30, 36])
def test_a_recording_tells_the_impacts_after_its_last_published_tick(tmp_path, ticks):
    made = recorded(bouncing(), tmp_path / 'bag', ticks)
    told = read_impacts(Bag(tmp_path / 'bag'))
    assert len(made)
    np.testing.assert_array_equal(told.tick_ns, made.tick_ns)
    np.testing.assert_array_equal(told.remainder, made.remainder)
    np.testing.assert_array_equal(told.impulse, made.impulse)


def test_what_a_closed_recording_told_last_is_published_all_the_same(tmp_path):
    alone, cut = bouncing(), bouncing()
    recorded(alone, tmp_path / 'whole', 40)
    recorded(cut, tmp_path / 'first', 25)
    recorded(cut, tmp_path / 'second', 15)
    whole, second = (
        [m for m in Bag(tmp_path / name).messages() if m.sequence in (30, 40)]
        for name in ('whole', 'second')
    )
    assert second == whole and whole


@pytest.mark.usefixtures('plain_source')  # no other test has a kernel of impacts beside forces
def test_a_run_that_diverged_tells_the_impacts_of_the_ticks_before(tmp_path):
    wild = {
        'name': 'wild',
        'mass': 1.0,
        'shape': {'type': 'particle'},
        'initial': {'position': [0.01, 0, 5.0]},
    }
    # beyond 10^150 m in tick 40
    spring = {'type': 'spring', 'a': 'wild', 'b': 'world', 'stiffness': 1e10}
    bodies = [*BOUNCING['bodies'], wild]
    scene = load_scene({**BOUNCING, 'bodies': bodies, 'forces': [spring]})
    run = Run(Simulation(scene), RunSettings(publish_every=1000))
    recorder = RunRecorder(run, tmp_path / 'bag')
    with pytest.raises(SimulationDiverged):
        recorder.record(run.advance(500), tick=0)
    recorder.close('diverged')
    assert len(read_impacts(Bag(tmp_path / 'bag')))
    assert replayed(tmp_path / 'bag').difference is None


def test_an_old_recording_that_does_not_tell_its_last_impacts_replays(tmp_path, monkeypatch):
    run = bouncing()
    monkeypatch.setattr(Run, 'rest', lambda run: ())
    manifest = RunRecorder._manifest
    monkeypatch.setattr(
        RunRecorder,
        '_manifest',
        lambda *given: {
            key: value for key, value in manifest(*given).items() if key != 'impacts_at_start'
        },
    )
    recorded(run, tmp_path / 'bag', 9)  # no published tick, whose impacts `rest` packs too
    monkeypatch.undo()
    assert len(run.untold_impacts)
    assert replayed(tmp_path / 'bag').difference is None


GOOD = [0, 0.0, [0, 1], [0.0] * 3, [0.0] * 3, [0.0] * 3, 0.0, 0]


@pytest.mark.parametrize(
    ('place', 'value'),
    [(0, -1), (0, 0.5), (1, 'x'), (2, [0, 9]), (2, [0]), (3, [0.0]), (6, True), (7, 4), (7, None)],
)
def test_a_manifest_with_impacts_that_cannot_be_is_damaged(tmp_path, monkeypatch, place, value):
    recorded(bouncing(), tmp_path / 'bag', 5)
    need = Bag.need_run

    def claim(row):
        said = {'impacts_at_start': json.dumps([row])}
        monkeypatch.setattr(Bag, 'need_run', lambda bag: {**need(bag), **said})

    claim(GOOD)
    RecordedRun(tmp_path / 'bag')
    claim([value if place == number else good for number, good in enumerate(GOOD)])
    with pytest.raises(Exception, match='damaged: impacts_at_start'):
        RecordedRun(tmp_path / 'bag')


def test_a_command_of_a_recording_ends_at_its_instant_in_ticks_of_any_length(tmp_path):
    """
    A force held at the start of the bag and one of a timeout of 12.3 ms, 13 ticks, push as long.
    """
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 2.0}
    simulation = Simulation(load_scene({'dt': 0.001, 'bodies': [ball]}))
    simulation.step(300)
    simulation.hold('ball', 'force', force=(1.0, 0.0, 0.0), until=350)
    run = Run(simulation, RunSettings(command_timeout_ns=12_300_000))
    recorder = RunRecorder(run, tmp_path / 'bag')
    taken = {320: [Command('ball', 'wrench', (0.0, 1.0, 0.0))]}
    for tick, output in run.follow(taken, 400):
        recorder.record(output, tick=tick)
    recorder.close('stopped')
    recorded = RecordedRun(tmp_path / 'bag')
    for dt, longer, late in ((0.0005, 0.0, 0), (0.00025, 0.0, 0), (0.002, 0.001, 1)):
        again, errors = measure(
            recorded, integrator=None, dt=dt, output=None, progress=lambda tick, last: None
        )
        velocity = again.simulation.state.velocity[0]
        # by hand: 50 ms of 1 N along x, 13 ms along y, 14 ms in ticks of 2 ms; rounding
        assert velocity == pytest.approx([0.025, 0.0065 + longer / 2, 0.0], abs=1e-15)
        assert errors['ball'].last['velocity'] == pytest.approx(longer / 2, abs=1e-15)
        assert sum('timed out within a tick' in text for text in again.warnings) == late
