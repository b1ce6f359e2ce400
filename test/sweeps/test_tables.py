# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Tables of sweeps: the same bytes whoever makes the runs and however often he is killed.

`rk45` chooses its steps, so its runs are made one by one: there is work to share.
"""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import pyarrow.parquet
import pytest

import rigid_body_sim as rbs
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.sweeps import ensemble, formats
from rigid_body_sim.sweeps.executors import Answer, Processes
from rigid_body_sim.sweeps.parts import SUFFIX
from rigid_body_sim.sweeps.plan import plan_sweep

from ..patience import HANGING, PATIENCE
from .conftest import ROOT, scene

VARY = {'tumbler.mass': 'uniform:1:3', 'ball.initial.velocity': 'normal:0:1'}


def alone(**more):
    """A sweep whose runs are made one by one."""
    settings = {'runs': 12, 'duration': 0.2, 'seed': 5, **more}
    return plan_sweep(scene(integrator='rk45'), VARY, **settings)


def made(sweep, path, **more):
    """The bytes of the file of a sweep."""
    ensemble.to_file(sweep, path, **{'workers': 1, **more})
    assert not path.with_name(path.name + SUFFIX).exists()
    return path.read_bytes()


@pytest.fixture(scope='module')
def undisturbed(tmp_path_factory):
    """The bytes that one process makes."""
    return made(alone(), tmp_path_factory.mktemp('one') / 'runs.parquet')


def test_one_worker_and_two_make_the_same_bytes(undisturbed, tmp_path):
    assert made(alone(), tmp_path / 'two.parquet', workers=2) == undisturbed


def test_a_dask_cluster_makes_the_same_bytes_also_when_a_worker_dies(undisturbed, tmp_path):
    pytest.importorskip('distributed')
    asked = {
        'scene': scene(integrator='rk45'),
        'vary': VARY,
        'runs': 12,
        'duration': 0.2,
        'seed': 5,
    }
    (tmp_path / 'asked.json').write_text(json.dumps(asked))
    script = Path(__file__).with_name('dask_session.py')
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path / 'asked.json'), str(tmp_path)],
        env=os.environ | {'PYTHONPATH': str(ROOT)},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / 'plain.parquet').read_bytes() == undisturbed
    assert (tmp_path / 'killed.parquet').read_bytes() == undisturbed


@pytest.mark.parametrize(
    'who', [pytest.param(['worker'] * 3, marks=pytest.mark.long), ['nursery', 'worker']]
)
def test_a_process_that_is_killed_loses_no_run(undisturbed, tmp_path, who):
    """Three workers: some of them as soon as they are there, before they have begun."""
    seen, killed = {}, []

    def kill_one(done, _runs):
        for nursery in psutil.Process().children():
            for one in nursery.children():
                seen.update(nursery=nursery, worker=one)
        if done >= 1 and seen and len(killed) < len(who):
            killed.append(seen[who[len(killed)]])
            killed[-1].send_signal(signal.SIGKILL)

    path = tmp_path / 'runs.parquet'
    assert made(alone(), path, workers=2, progress=kill_one) == undisturbed
    assert len(killed) == len(who)


def test_who_asks_and_is_killed_leaves_no_process(tmp_path, started):
    path = tmp_path / 'scene.yaml'
    path.write_text(json.dumps(scene(contact={'mode': 'timestep'})))
    words = ('--vary', 'tumbler.mass=uniform:1:3', '--runs', 500, '--duration', 1000, '-j', 2)
    process = started(path, *words, '-o', tmp_path / 'runs.parquet')
    deadline, family = time.monotonic() + PATIENCE, []
    while len(family) < 3:  # the nursery and two workers
        assert time.monotonic() < deadline and process.poll() is None, process.stderr.read()
        family = psutil.Process(process.pid).children(recursive=True)
        time.sleep(0.01)
    process.kill()
    _gone, alive = psutil.wait_procs(family, timeout=PATIENCE)
    assert all(p.status() == psutil.STATUS_ZOMBIE for p in alive), alive


class _Fragile:
    """Makes runs, but every process that has run 5 dies."""

    def __init__(self, sweep):
        from rigid_body_sim.sweeps.executors import Here

        self._here, self._task = Here(sweep, lambda _done: None), None

    def wants(self, _seconds_left):
        return self._task is None

    def submit(self, task):
        self._task = task
        self._here.submit(task)

    def wait(self, seconds):
        (first, end), self._task = self._task, None
        answers = self._here.wait(seconds)
        return [Answer((first, end), None, [], died='it ended')] if first <= 5 < end else answers

    def under_way(self):
        return 0.0

    def close(self):
        pass


def test_a_run_that_brings_its_process_down_is_a_row_with_the_reason(tmp_path, monkeypatch):
    monkeypatch.setattr(ensemble, 'make_executor', lambda sweep, **_: _Fragile(sweep))
    sweep = plan_sweep(scene(), VARY, runs=12, duration=0.1)
    outcome = ensemble.to_file(sweep, tmp_path / 'runs.parquet', workers=1)
    table = pyarrow.parquet.read_table(tmp_path / 'runs.parquet').to_pandas()
    assert outcome.failed == 1 and list(table['run']) == list(range(12))
    assert list(table['status']) == ['done'] * 5 + ['failed'] + ['done'] * 6
    assert table['reason'][5] == 'it ended, and so did another one'
    assert np.isnan(table['ball.position.x'][5]) and table['tumbler.mass'][5] > 0


def test_workers_that_cannot_start_end_the_sweep(monkeypatch):
    monkeypatch.setattr(sys, 'executable', '/bin/false')
    with pytest.raises(RunError, match='no worker process can be started'):
        processes = Processes(alone(), 2, lambda _done: None)
        processes.submit((0, 1))
        try:
            while True:
                processes.wait(1.0)
        finally:
            processes.close()


@pytest.mark.parametrize(
    ('number', 'workers'),
    [
        (signal.SIGKILL, 2),
        pytest.param(signal.SIGTERM, 1, marks=pytest.mark.long),
        (signal.SIGINT, 2),
    ],
)
def test_a_sweep_that_is_ended_goes_on_where_it_was(tmp_path, started, number, workers):
    path = tmp_path / 'scene.yaml'
    path.write_text(json.dumps(scene(integrator='rk45')))
    vary = [word for key, values in VARY.items() for word in ('--vary', f'{key}={values}')]
    file, parts = tmp_path / 'runs.parquet', tmp_path / f'runs.parquet{SUFFIX}'
    settings = ('--runs', 40, '--duration', 0.5, '--seed', 5)
    process = started(path, *vary, *settings, '-j', workers, '-o', file)
    deadline = time.monotonic() + PATIENCE
    while len(list(parts.glob('*-*.parquet'))) < 2:
        assert time.monotonic() < deadline and process.poll() is None, process.stderr.read()
        time.sleep(0.005)
    children = psutil.Process(process.pid).children()
    process.send_signal(number)
    _, said = process.communicate(timeout=HANGING)
    assert not file.exists()
    psutil.wait_procs(children, timeout=PATIENCE)
    assert not any(child.is_running() for child in children)
    if number != signal.SIGKILL:
        assert process.returncode == 128 + number
        assert 'stopped by ' in said and ' of 40 runs; what is done is kept' in said
        return
    assert process.returncode == -9
    sweep = plan_sweep(path, VARY, runs=40, duration=0.5, seed=5)
    outcome = ensemble.to_file(sweep, file, workers=1)
    assert 0 < outcome.made < 40
    assert file.read_bytes() == made(sweep, tmp_path / 'undisturbed.parquet')


class Cut(Exception):
    """Somebody who watches ends the sweep."""


def cut_at(path, parts):
    """Who watches a sweep, and ends it as soon as it has so many parts."""

    def watch(_done, _runs):
        if len(list(path.with_name(path.name + SUFFIX).glob('*-*.parquet'))) >= parts:
            raise Cut

    return watch


def test_parts_of_every_cut_make_the_same_bytes(undisturbed, tmp_path):
    path = tmp_path / 'runs.parquet'
    for parts in (1, 2, 3):
        with pytest.raises(Cut):
            made(alone(), path, progress=cut_at(path, parts))
        assert not path.exists() and path.with_name(path.name + SUFFIX).is_dir()
    assert made(alone(), path) == undisturbed


@pytest.mark.parametrize(
    ('masses', 'parts', 'code', 'told'),
    [
        ('-1,1,-2,-1', 1, 0, ('4 runs of', '1 of them was made', '3 refused, 1 of them before')),
        ('1,-1,-2,2', 1, 0, ('4 runs of', '1 of them was made', '2 refused: their rows')),
        (
            '-1,1,2,3',
            1,
            0,
            ('4 runs of', '1 of them was made', '1 refused, 1 of them before: its row says why'),
        ),
        ('-1,-1,-2,-3', 1, 1, ('4 runs of', '4 refused, 1 of them before: their', '2 runs: ')),
    ],
)
def test_a_sweep_that_goes_on_tells_the_failures_of_its_whole_table(
    verb, tmp_path, masses, parts, code, told
):
    path, file = tmp_path / 'scene.yaml', tmp_path / 'runs.parquet'
    path.write_text(json.dumps(scene(integrator='rk45')))
    sweep = plan_sweep(path, {'ball.mass': masses}, duration=0.1)
    with pytest.raises(Cut):
        made(sweep, file, progress=cut_at(file, parts))
    words = ('sweep', path, '--vary', f'ball.mass={masses}', '--duration', 0.1, '-j', 1)
    found, out, _ = verb(*words, '-o', file)
    assert found == code and all(words in out for words in told), out
    rows = pyarrow.parquet.read_table(file)['status'].to_pylist()
    assert f'  {rows.count("refused")} refused' in out and {*rows} <= {'done', 'refused'}


@pytest.mark.parametrize('damage', ['cut short', 'empty', 'of other runs'])
def test_a_part_that_is_not_whole_is_made_again(undisturbed, tmp_path, damage):
    path = tmp_path / 'runs.parquet'
    with pytest.raises(Cut):
        made(alone(), path, progress=cut_at(path, 1))
    part = sorted(path.with_name(path.name + SUFFIX).glob('*.parquet'))[0]
    if damage == 'of other runs':
        part.rename(part.with_name('000000000000-000000000007.parquet'))
    else:
        part.write_bytes(part.read_bytes()[:-9] if damage == 'cut short' else b'')
    outcome = ensemble.to_file(alone(), path, workers=1)
    assert path.read_bytes() == undisturbed
    assert outcome.made == 12 and outcome.before is None
    (note,) = outcome.notes
    assert 'does not hold whole rows of its runs; they are made again' in note


def test_a_process_killed_between_file_and_clean_up_is_finished(
    undisturbed, tmp_path, monkeypatch
):
    path = tmp_path / 'runs.parquet'
    with monkeypatch.context() as patch:
        patch.setattr('shutil.rmtree', lambda _folder: (_ for _ in ()).throw(OSError))
        ensemble.to_file(alone(), path, workers=1)
    assert path.with_name(path.name + SUFFIX).is_dir()
    outcome = ensemble.to_file(alone(), path, workers=1)
    assert outcome.made == 0 and path.read_bytes() == undisturbed
    assert not path.with_name(path.name + SUFFIX).exists()


@pytest.mark.parametrize(
    ('other', 'told'),
    [
        ({'seed': 6}, 'another seed: 5, now 6'),
        ({'runs': 13}, 'another runs: 12, now 13'),
        ({'duration': 0.3}, 'another duration'),
        ({'keep': ['last']}, 'another keep'),
    ],
)
def test_parts_of_another_sweep_are_not_gone_on_with(tmp_path, other, told):
    path = tmp_path / 'runs.parquet'

    with pytest.raises(Cut):
        made(alone(), path, progress=cut_at(path, 1))
    with pytest.raises(UserError) as refused:
        made(alone(**other), path)
    assert told in str(refused.value) and 'remove the folder' in str(refused.value)


def test_two_processes_do_not_work_on_one_sweep(tmp_path):
    path = tmp_path / 'runs.parquet'

    asked = []

    def beside(done, _runs):
        if done and not asked:
            asked.append(done)
            with pytest.raises(UserError, match='another process is at work'):
                made(alone(), path)

    made(alone(), path, progress=beside)
    assert asked


def test_what_is_there_already_is_left_alone(tmp_path):
    path = tmp_path / 'runs.parquet'
    path.write_text('mine')
    with pytest.raises(UserError, match='exists already'):
        made(alone(), path)
    assert path.read_text() == 'mine' and list(tmp_path.iterdir()) == [path]
    with pytest.raises(UserError, match='does not exist; create it first'):
        made(alone(), tmp_path / 'none' / 'runs.parquet')
    with pytest.raises(UserError, match='is a folder'):
        made(alone(), tmp_path)


def test_a_sweep_that_did_nothing_leaves_nothing(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise UserError('nobody there')

    with monkeypatch.context() as patch:
        patch.setattr(ensemble, 'make_executor', refuse)
        with pytest.raises(UserError, match='nobody there'):
            made(alone(), tmp_path / 'runs.parquet')
    assert not list(tmp_path.iterdir())
    folder = tmp_path / f'runs.parquet{SUFFIX}'  # as a kill before the first part leaves it
    folder.mkdir()
    (folder / 'sweep.json').write_text('{"seed": 8}')
    assert made(alone(runs=2), tmp_path / 'runs.parquet')


def test_a_full_disk_keeps_what_is_done(undisturbed, tmp_path, monkeypatch):
    path, replace = tmp_path / 'runs.parquet', type(tmp_path).replace

    def full(self, target):
        if target.name.startswith('000000000005'):
            raise OSError(28, 'No space left on device')
        return replace(self, target)

    with monkeypatch.context() as patch:
        patch.setattr(ensemble, 'LASTS', 1e-9)  # [s]: a run a task
        patch.setattr(type(tmp_path), 'replace', full)
        with pytest.raises(RunError, match='No space left on device; 5 of 12 runs are safe'):
            made(alone(), path)
    assert made(alone(), path) == undisturbed


def test_rows_of_many_groups_come_in_order(tmp_path, monkeypatch):
    from rigid_body_sim.sweeps import table

    monkeypatch.setattr(table, 'ROWS', 7)
    vary = {'tumbler.mass': [2.0, -1.0], 'integrator': ['dmv6', 'nonsense']}
    sweep = plan_sweep(scene(), vary, runs=30, duration=0.05)
    made(sweep, tmp_path / 'runs.parquet')
    file = pyarrow.parquet.ParquetFile(tmp_path / 'runs.parquet')
    assert [file.metadata.row_group(i).num_rows for i in range(5)] == [7, 7, 7, 7, 2]
    rows = file.read().to_pandas()
    assert list(rows['run']) == list(range(30))
    assert list(rows['status'][:4]) == ['done', 'refused', 'refused', 'refused']
    assert json.loads(file.schema_arrow.metadata[table.FACTS])['vary']['tumbler.mass']


def test_a_table_in_memory_is_that_of_the_file(tmp_path):
    settings = {'runs': 12, 'duration': 0.2, 'seed': 5, 'workers': 1}
    source = scene(integrator='rk45')
    in_memory = rbs.sweep(source, VARY, **settings)
    of_file = rbs.sweep(source, VARY, **settings, output=tmp_path / 'runs.parquet')
    assert in_memory.equals(of_file) and len(in_memory) == 12


def test_a_csv_file_holds_the_rows_of_the_parquet_file_also_when_it_was_cut(tmp_path):
    vary = {'tumbler.mass': 'normal:1:1', 'integrator': ['dmv6', 'rk45']}  # some masses are none
    sweep = plan_sweep(scene(), vary, runs=12, duration=0.2, seed=5)
    made(sweep, tmp_path / 'runs.parquet')
    file = tmp_path / 'runs.csv'
    with pytest.raises(Cut):
        ensemble.to_file(sweep, file, workers=1, progress=cut_at(file, 1))
    assert ensemble.to_file(sweep, file, workers=1).made < 12
    parquet = pyarrow.parquet.read_table(tmp_path / 'runs.parquet').to_pandas()
    assert {'done', 'refused'} == set(parquet['status'])
    names, *rows = csv.reader(file.read_text().splitlines())
    assert names == list(parquet) and len(rows) == 12
    assert [row[names.index('tumbler.mass')] for row in rows] == list(
        map(repr, parquet['tumbler.mass'].tolist())
    )
    assert formats.format_of(file).read(sweep, file).to_pandas().equals(parquet)
    folder = file.with_name(file.name + SUFFIX)  # a process ended between its last two deeds
    folder.mkdir()
    (folder / 'sweep.json').write_text(sweep.facts_text())
    again = ensemble.to_file(sweep, file, workers=1)
    assert again.made == 0 and again.before is not None and again.before.ends['refused']


@pytest.mark.parametrize('name', ['runs', 'runs.txt', 'runs.csv.gz'])
def test_a_suffix_that_no_table_has_is_refused_before_any_run(tmp_path, verb, name):
    words = ('sweep', 'satellite', '--vary', 'satellite.mass=1,2', '--duration', 0.1, '-j', 1)
    code, out, err = verb(*words, '-o', tmp_path / name)
    assert code == 2 and not out and not list(tmp_path.iterdir())
    assert f'{name}: no table of a sweep is written ' in err
    assert err.endswith('; give FILE.parquet or FILE.csv\n')


def test_where_bodies_meet_extremes_of_contact_are_told():
    source = scene(
        gravity=[0, 0, -9.81], contact={'mode': 'timestep'},
        bodies=[
            {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}},
            {'name': 'ball', 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 2.0,
             'initial': {'position': [0, 0, 0.1]}},
        ],
    )  # fmt: skip
    table = rbs.sweep(source, {'ball.mass': [1.0, 2.0]}, duration=1.0, workers=1)
    weight = table['ball.mass'] * 9.81
    # a ball at rest: the load of the last tick is its weight, but for what settles at first
    assert np.allclose(table['ball.contact_force.max'], weight, rtol=0.05)
    assert (table['contact.deepest_gap'].abs() < 1e-3).all()
    assert (table['energy.gain'] < 1e-3).all() and (table['status'] == 'done').all()
