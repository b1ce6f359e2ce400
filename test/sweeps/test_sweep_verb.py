# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`sweep` as a user calls it."""

import csv
import json

import pyarrow.parquet
import pytest

from rigid_body_sim.recording.bag_reader import Bag

from .conftest import scene

MASSES = ('--vary', 'satellite.mass=uniform:10:14', '--runs', 8, '--seed', 3, '--duration', 0.5)


def test_a_sweep_writes_one_row_a_run(verb, tmp_path):
    path = tmp_path / 'runs.parquet'
    code, out, err = verb('sweep', 'satellite', *MASSES, '-o', path, '-j', 2)
    assert (code, err) == (0, '')
    assert out.startswith('satellite: 8 runs of 0.5 s in ') and str(path) in out
    table = pyarrow.parquet.read_table(path).to_pandas()
    assert list(table['run']) == list(range(8)) and set(table['status']) == {'done'}
    assert table['satellite.mass'].between(10, 14).all() and table['ticks'].eq(50).all()
    for column in ('satellite.orientation.w', 'beacon.position.z.max', 'energy.defect'):
        assert table[column].notna().all()


def test_one_run_again_has_the_bits_of_its_row_and_a_bag_that_replays(verb, tmp_path):
    path, bag = tmp_path / 'runs.parquet', tmp_path / 'bag'
    verb('sweep', 'satellite', *MASSES, '-o', path)
    code, out, _ = verb('sweep', 'satellite', *MASSES, '--only', 5, '--bag', bag, '--json')
    assert code == 0
    row, told = pyarrow.parquet.read_table(path).slice(5, 1).to_pylist()[0], json.loads(out)
    assert told.pop('bag') == str(bag)
    assert told == row
    assert Bag(bag).manifest['scene'] == 'satellite'
    assert verb('replay', bag)[0] == 0


def test_json_says_what_came_of_it(verb, tmp_path):
    words = ('--vary', 'satellite.mass=2,-1,0,3', '--duration', 0.1, '-j', 1)
    code, out, err = verb('sweep', 'satellite', *words, '-o', tmp_path / 'x.parquet', '--json')
    said = json.loads(out)
    assert (code, err) == (0, '')
    assert (said['runs'], said['made_now'], said['failed_now']) == (4, 4, 2)
    assert any('mass is -1.0 kg' in reason for reason in said['reasons'])


def test_a_sweep_of_which_nothing_comes_fails(verb, tmp_path):
    words = ('--vary', 'satellite.mass=-1,-2', '-j', 1, '-o', tmp_path / 'x.parquet')
    code, out, _ = verb('sweep', 'satellite', *words)
    assert code == 1 and '2 refused: their rows say why' in out
    assert (
        pyarrow.parquet.read_table(tmp_path / 'x.parquet')['status'].to_pylist() == ['refused'] * 2
    )


@pytest.mark.parametrize(
    ('words', 'told'),
    [
        (('--vary', 'satellite.mass'), 'allowed: KEY=VALUES'),
        (('--vary', 'satellite.mass=1', '--vary', 'satellite.mass=2'), 'is given twice'),
        (('--vary', 'satellite.mas=1'), "did you mean 'mass'?"),
        (('--vary', 'satellite.mass=1,2', '--only', '2'), '--only 2; allowed: a run from 0 to 1'),
        (('--vary', 'satellite.mass=1,-2', '--only', '1'), 'run 1: '),
        (('--vary', 'satellite.mass=1', '--bag', 'b'), 'say which, with --only K'),
        (('--vary', 'satellite.mass=1', '-j', '0'), 'workers 0; allowed'),
        (('--vary', 'satellite.mass=1', '--runs', '0'), 'runs 0; allowed'),
        ((), '-o FILE is missing'),
    ],
)
def test_mistakes_are_told_in_one_line(verb, tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    code, out, err = verb('sweep', 'satellite', *words)
    assert (code, out) == (2, '') and told in err and err.count('\n') == 1
    assert not list(tmp_path.iterdir())


def test_fewer_runs_than_combinations_are_told(verb, tmp_path):
    words = ('--vary', 'satellite.mass=1:2:5', '--runs', 2, '--duration', 0.1, '-j', 1)
    code, _, err = verb('sweep', 'satellite', *words, '-o', tmp_path / 'x.parquet')
    assert code == 0 and '2 runs of 5 combinations' in err


def test_a_run_that_ends_beside_the_duration_is_told_as_simulate_tells_it(verb, tmp_path):
    words = ('--vary', 'dt=0.003,0.01', '--duration', 1, '-j', 1, '-o', tmp_path / 'runs.csv')
    code, _, err = verb('sweep', 'satellite', *words)
    assert code == 0
    note = 'rigid_body_sim sweep: the duration of 1 s is no whole number of ticks in some runs, '
    assert err.count(note) == 1
    with (tmp_path / 'runs.csv').open() as file:
        short, whole = csv.DictReader(file)
    assert (short['time'], whole['time'], whole['warnings']) == ('0.999', '1.0', '')
    assert short['warnings'] == (
        'duration 1 s is no whole number of ticks of 0.003 s; the run takes 333 of them, 0.999 s'
    )


def test_a_run_that_diverges_has_its_bag_too(verb, tmp_path):
    spring = {'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': 1e9}
    path = tmp_path / 'scene.yaml'
    path.write_text(json.dumps(scene(forces=[spring], integrator='semi_implicit_euler')))
    words = ('sweep', path, '--vary', 'ball.mass=0.5,0.6', '--duration', 3)
    code, out, _ = verb(*words, '--only', 1, '--bag', tmp_path / 'bag')
    assert code == 1 and 'status: diverged' in out
    assert Bag(tmp_path / 'bag').ending['end_reason'] == 'diverged'
