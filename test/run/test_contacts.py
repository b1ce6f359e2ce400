# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contacts of a run in its messages: they carry the weight, obey the third law, and replay.
"""

from __future__ import annotations

import numpy as np
import pytest

from rigid_body_sim.analysis.recorded_contacts import contact_topics, read_points
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.contact_packing import FORCE, GAP, NORMAL, OTHER, POINT
from rigid_body_sim.runs.asked_states import AskedState
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.replay import compare
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.scene import load_scene

from .. import inside

WEIGHT = 9.81  # [N] of each box
SETTLED = 400  # [tick] 1.6 s: the swings of the soft contacts have faded below a thousandth
SCENE = {
    'name': 'tower',
    'dt': 0.004,
    'gravity': [0, 0, -9.81],
    'contact': {'mode': 'timestep'},
    'bodies': [
        {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}},
        {
            'name': 'box',
            'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]},
            'mass': 1.0,
            'initial': {'position': [0, 0, 0.1]},
            'repeat': {'count': [1, 1, 3], 'spacing': [0, 0, 0.2]},
        },
    ],
}
LIFT = Command('box_3', 'force', (0.0, 0.0, 3 * WEIGHT))  # flies off
DROP = Command('box_3', 'force')


def make_run(**settings):
    settings = {'publish_every': 5, 'publish_contacts': True, 'command_timeout_ns': 0} | settings
    return Run(Simulation(load_scene(SCENE)), RunSettings(**settings))


def record(run, path, ticks, commands=None):
    """Record a stretch of a run tick by tick, as the node does."""
    recorder = RunRecorder(run, path)
    end = run.simulation.tick + ticks
    while run.simulation.tick < end:
        tick = run.simulation.tick
        recorder.record(run.advance(1, (commands or {}).get(tick, ())), tick=tick)
        if tick % 100 == 57:  # chunks that end anywhere, as those of the node do
            inside.flush(recorder)
    recorder.close('stopped')
    return path


def replay(path):
    return compare(RecordedRun(path), output=None, progress=lambda tick, last: None)


def clouds(path):
    """Body -> [(tick, points)]."""
    bag = Bag(path)
    topics = contact_topics(bag)
    found = {body: [] for body in topics.values()}
    for message in bag.messages(topics):
        found[topics[message.topic]].append((message.sequence, read_points(message.data)))
    return found


@pytest.fixture(scope='module')
def tower(tmp_path_factory):
    """A bag of the tower while its top box is lifted off and let fall again."""
    commands = {SETTLED + 23: [LIFT], SETTLED + 48: [DROP]}
    path = tmp_path_factory.mktemp('tower') / 'run'
    return record(make_run(), path, SETTLED + 200, commands)


def test_each_interface_carries_what_stands_on_it(tower):
    last = {body: dict(messages)[SETTLED] for body, messages in clouds(tower).items()}
    for level, body in enumerate(('box_1', 'box_2', 'box_3')):
        points = last[body]
        below = points[points[:, OTHER] == level]
        assert len(below) == 4
        # The swings of the soft contacts fade with e^-t/tau; a thousandth is left by now.
        assert below[:, FORCE].sum(axis=0) == pytest.approx((0, 0, (3 - level) * WEIGHT), abs=0.02)
        assert below[:, NORMAL] == pytest.approx(np.tile((0.0, 0.0, 1.0), (4, 1)), abs=1e-4)
        assert below[:, POINT][:, 2] == pytest.approx(0.2 * level, abs=1e-4)
        assert np.all(np.abs(below[:, GAP]) < 1e-12)  # the sink is taken out whole: they touch


def test_action_and_reaction_are_equal_to_the_bit(tower):
    found = {body: dict(messages) for body, messages in clouds(tower).items()}
    for tick, points in found['box_1'].items():
        of_other = found['box_2'][tick]
        mine, theirs = points[points[:, OTHER] == 2], of_other[of_other[:, OTHER] == 1]
        assert np.array_equal(mine[:, FORCE], -theirs[:, FORCE])
        assert np.array_equal(mine[:, NORMAL], -theirs[:, NORMAL])
        assert np.array_equal(mine[:, POINT], theirs[:, POINT])


def test_a_box_that_flies_off_says_so_once(tower):
    counts = {tick: len(points) for tick, points in clouds(tower)['box_3']}
    flying = list(range(SETTLED + 25, SETTLED + 50, 5))
    assert counts[SETTLED] == 4
    assert [counts.get(tick) for tick in flying[:3]] in ([4, 0, None], [0, None, None])
    assert counts[SETTLED + 200] == 4  # it has fallen back


def test_contacts_replay_bit_for_bit(tower):
    outcome = replay(tower)
    assert outcome.difference is None and outcome.messages > 1000


def test_a_torn_bag_with_contacts_is_recovered_to_a_tick_that_replays(tower, tmp_path, verb):
    (file,) = tower.glob('*.mcap')
    content = file.read_bytes()
    (tmp_path / 'torn').mkdir()
    (tmp_path / 'torn' / 'torn_0.mcap').write_bytes(content[: len(content) * 2 // 3])
    code, _, err = verb('bag', 'recover', tmp_path / 'torn', '-o', tmp_path / 'saved')
    assert code == 0, err
    assert replay(tmp_path / 'saved').difference is None
    assert len(clouds(tmp_path / 'saved')['box_1']) > 20


@pytest.mark.parametrize('begin', (33, SETTLED + 24, SETTLED + 26), ids=lambda k: f'tick {k}')
def test_a_recording_begun_among_contacts_replays_identically(tmp_path, begin):
    run = make_run()
    commands = {SETTLED + 23: [LIFT], SETTLED + 48: [DROP]}
    while run.simulation.tick < begin:
        run.advance(1, commands.get(run.simulation.tick, ()))
    path = record(run, tmp_path / 'late', 90, commands)
    assert replay(path).difference is None


@pytest.mark.parametrize(
    'begin',
    (0, pytest.param(330, marks=pytest.mark.long), SETTLED + 24),
    ids=lambda k: f'tick {k}',
)
def test_a_tower_that_sleeps_and_is_woken_replays_with_its_contacts(tmp_path, begin):
    scene = load_scene({**SCENE, 'contact': {'mode': 'timestep', 'sleeping': True}})
    settings = RunSettings(publish_every=5, publish_contacts=True, command_timeout_ns=0)
    run = Run(Simulation(scene), settings)
    commands = {SETTLED + 23: [LIFT], SETTLED + 48: [DROP]}
    while run.simulation.tick < begin:
        run.advance(1, commands.get(run.simulation.tick, ()))
    path = record(run, tmp_path / 'sleep', 500, commands)
    assert replay(path).difference is None
    said = dict(clouds(path)['box_1'])
    if begin < SETTLED:
        assert np.array_equal(said[SETTLED], said[SETTLED + 20])  # asleep, and still told


def test_the_ending_says_what_contact_cost(tower):
    ending = Bag(tower).ending
    assert 'energy_drift' not in ending and 'momentum_drift' not in ending
    assert 0.0 <= float(ending['energy_rise']) < 1e-3
    assert -1e-2 < float(ending['deepest_gap']) < 0.0  # the box fell from about half a metre


def test_without_asking_nothing_is_told_of_contacts(tmp_path):
    path = record(make_run(publish_contacts=False), tmp_path / 'silent', 50)
    assert not contact_topics(Bag(path))
    assert replay(path).difference is None


def test_simulate_reports_the_laws_that_are_left(as_json, verb, tmp_path):
    (tmp_path / 'tower.yaml').write_bytes(load_scene(SCENE).source)
    words = ('simulate', tmp_path / 'tower.yaml', '--duration', '0.4', '--contacts')
    code, result = as_json(*words, '-o', tmp_path / 'a')
    assert code == 0
    assert (result['energy_drift'], result['momentum_drift']) == (None, None)
    assert 0.0 <= result['energy_rise'] < 1e-3 and -1e-3 < result['deepest_gap'] < 0.0
    assert sum(points.shape[0] for _, points in clouds(tmp_path / 'a')['box_1']) >= 8 * 4
    code, out, _ = verb(*words, '-o', tmp_path / 'b')
    assert result['energy_balance']['contact'] >= 0.0 <= result['energy_balance']['defect']
    for said in ('energy balance: change ', 'energy rise: ', 'deepest overlap: '):
        assert said in out
    assert (code, verb('bag', 'diff', tmp_path / 'a', tmp_path / 'b')[0]) == (0, 0)


def test_an_estimate_of_the_error_is_refused_where_bodies_meet(verb, tmp_path):
    (tmp_path / 'tower.yaml').write_bytes(load_scene(SCENE).source)
    code, _, err = verb(
        'simulate', tmp_path / 'tower.yaml', '-o', tmp_path / 'a', '--estimate-error'
    )
    assert code == 2 and 'says nothing where bodies meet' in err


def test_a_box_put_elsewhere_is_replayed_with_all_its_contacts(tmp_path):
    """Out of a tower, onto it again, and where it was; nothing holds where it touched before."""
    there = [(2.0, 0.0, 0.1), (0.05, 0.0, 0.55), (0.0, 0.0, 0.1)]
    commands = {
        103 + 60 * i: [Command('box_1', 'set_state', state=AskedState(position=place))]
        for i, place in enumerate(there[:2])
    }
    run = make_run()
    bag = record(run, tmp_path / 'a', 103, commands)
    assert replay(bag).difference is None
    simulation = run.simulation
    simulation.set_state('box_1', position=there[0])
    assert not len(simulation.contacts().bodies)  # of the last tick, which was another world
    simulation.step()
    found = simulation.contacts().bodies
    # box_2 and box_3 fall and do not press on each other; the box touches the ground alone
    assert {tuple(sorted(pair)) for pair in found.tolist()} == {(0, 1)}
    again = make_run()
    bag = record(again, tmp_path / 'b', 400, commands)
    compared = replay(bag)
    assert compared.difference is None and compared.ticks == 400
    balance = again.energy_balance()
    # what overlap stores at most; impacts take the rest of what was brought
    assert abs(balance.defect) < 1e-3 * balance.turnover and balance.contact > 0.0


def test_impulses_of_contacts_are_forgotten_with_the_place(tmp_path):
    """A box set down where it stood begins without the impulses that carried it there."""
    run = make_run()
    simulation = run.simulation
    simulation.step(SETTLED)
    kept = simulation.state_bytes()
    simulation.set_state('box_2', velocity=simulation.state.velocity[2])
    numbers = len(simulation.state_bytes())
    assert numbers < len(kept)  # of box_1 on the ground alone
    simulation.set_state('box_1', velocity=simulation.state.velocity[1])
    assert len(simulation.state_bytes()) < numbers
    simulation.step(SETTLED)
    # they come back: the tower stands where it stood
    assert simulation.state.position[:, 2] == pytest.approx([0, 0.1, 0.3, 0.5], abs=1e-3)
