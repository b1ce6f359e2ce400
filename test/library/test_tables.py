# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tables have the numbers of the bag, to the bit; `export` writes them, or says why not."""

import csv
import json

import numpy as np
import pytest
from pyarrow import parquet

import rigid_body_sim as rbs
from rigid_body_sim.__main__ import main
from rigid_body_sim.library import tables

QUANTITIES = {'position': 'xyz', 'orientation': 'xyzw', 'velocity': 'xyz',
              'angular_velocity': 'xyz', 'force': 'xyz', 'torque': 'xyz'}  # fmt: skip
ENERGIES = ['kinetic_energy', 'potential_energy', 'energy']


@pytest.fixture
def pd():
    """Imported by who reads a table, not by each worker that reads the tests."""
    import pandas

    return pandas


def bits(values):
    """The bytes of doubles."""
    return np.asarray(values, dtype=np.float64).tobytes()


@pytest.mark.parametrize('suffix', ['csv', 'parquet'])
def test_an_export_has_the_numbers_of_the_bag_to_the_bit(pd, bag, suffix, tmp_path):
    file = tmp_path / f'run.{suffix}'
    assert main(['export', str(bag), '-o', str(file)]) == 0
    if suffix == 'csv':
        with file.open(newline='') as stream:  # pandas' own reader may be off by a bit
            names, *rows = csv.reader(stream)
        table = pd.DataFrame([[float(value) for value in row] for row in rows], columns=names)
    else:
        table = pd.read_parquet(file)
        assert parquet.read_table(file).column_names == list(table)
    run = rbs.open_bag(bag)
    names = [f'{b}.{q}.{axis}' for b in run for q in QUANTITIES for axis in QUANTITIES[q]]
    assert list(table) == ['time', *names, *ENERGIES]
    assert len(table) == len(run.time) == 21 and table.time[0] == 0.0
    assert bits(table.time) == bits(run.time)
    for name in names:
        body, quantity, axis = name.split('.')
        column = getattr(run[body], quantity)[:, QUANTITIES[quantity].index(axis)]
        assert bits(table[name]) == bits(column), name
    for name in ENERGIES:
        assert bits(table[name]) == bits(getattr(run, name))


def test_a_run_in_memory_gives_the_same_table_as_its_bag(run, bag):
    table, other = run.to_pandas(), rbs.open_bag(bag).to_pandas()
    assert list(table) == list(other)
    exact = [name for name in table if name not in ENERGIES]
    assert len(exact) > 10
    assert all(bits(table[name]) == bits(other[name]) for name in exact)
    assert table.attrs['scene'] == 'satellite'
    table.iloc[0, 0] = 7.0  # a copy: the run keeps its own
    assert run.time[0] == 0.0


def test_a_dataset_names_its_dimensions_and_units(run):
    data = run.to_xarray()
    assert data.sizes == {'time': 21, 'body': 3, 'axis': 3, 'quaternion': 4}
    beacon = data.position.sel(body='beacon', axis='y')
    assert bits(beacon) == bits(run['beacon'].position[:, 1])
    assert data.torque.attrs['units'] == 'N m' and data.energy.dims == ('time',)


def test_files_of_a_run_are_replaced_as_a_whole(pd, run, tmp_path):
    for write, name in ((run.to_parquet, 'run.parquet'), (run.to_csv, 'run.csv')):
        (tmp_path / name).write_text('old')
        write(tmp_path / name)
        with pytest.raises(rbs.UserError, match='does not exist'):
            write(tmp_path / 'no' / name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['run.csv', 'run.parquet']
    assert bits(pd.read_parquet(tmp_path / 'run.parquet').time) == bits(run.time)


def test_names_with_commas_and_quotes_are_one_column_each(tmp_path):
    name = 'a, "b"'
    ball = rbs.make_body(name, rbs.Sphere(0.1), mass=1, position=(0, 0, 0.1), velocity=(0, 0, -1))
    ground = rbs.make_body('ground', rbs.Plane((0, 0, 1)))
    scene = rbs.make_scene([ground, ball], dt=0.01, contact={'mode': 'event'})
    run = rbs.simulate(scene, 0.1)
    run.to_csv(tmp_path / 'run.csv')
    with (tmp_path / 'run.csv').open(newline='') as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == len(run.time)
    rows = [float(row[f'{name}.position.z']) for row in table]
    assert bits(rows) == bits(run[name].position[:, 2])
    tables.write_impacts(run, tmp_path / 'impacts.csv')
    with (tmp_path / 'impacts.csv').open(newline='') as stream:
        struck = list(csv.DictReader(stream))
    assert [{row['a'], row['b']} for row in struck] == [{'ground', name}] * len(run.impacts.time)
    assert len(struck) > 0


def test_json_says_what_was_written(bag, tmp_path, capsys):
    file = tmp_path / 'x.csv'
    assert main(['export', str(bag), '-o', str(file), '--json']) == 0
    said = json.loads(capsys.readouterr().out)
    assert said == {
        'output': str(file), 'rows': 21, 'columns': 61, 'bodies': 3, 'end_reason': 'duration',
    }  # fmt: skip


def test_what_cannot_be_exported_ends_with_one_line_and_leaves_no_file(bag, tmp_path, capsys):
    cases = [
        ((bag, tmp_path / 'x.txt'), 2, 'no table is written as .txt'),
        ((bag, tmp_path / 'x'), 2, 'without a suffix'),
        ((bag, tmp_path / 'no' / 'x.csv'), 2, 'does not exist'),
        ((tmp_path / 'none', tmp_path / 'x.csv'), 2, 'no such file'),
    ]
    for (source, output), code, reason in cases:
        assert main(['export', str(source), '-o', str(output)]) == code
        said = capsys.readouterr().err
        assert reason in said and said.count('\n') == 1
    assert not [*tmp_path.iterdir()]


def test_a_package_that_is_missing_is_named_with_its_cure(run, monkeypatch, tmp_path):
    for package, call in (
        ('pandas', run.to_pandas),
        ('xarray', run.to_xarray),
        ('pyarrow', lambda: run.to_parquet(tmp_path / 'x.parquet')),
    ):
        monkeypatch.setitem(__import__('sys').modules, package, None)
        with pytest.raises(rbs.UserError, match=f'{package} is missing: pip install {package}'):
            call()
