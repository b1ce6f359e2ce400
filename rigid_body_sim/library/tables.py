# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A run as one table: a row per instant, the first where it began.

    time                                                    [s]
    BODY.position.x … z                                     [m]      world
    BODY.orientation.x … w                                  [-]      xyzw, body to world
    BODY.velocity.x … z, BODY.angular_velocity.x … z        [m/s], [rad/s]  world axes
    BODY.force.x … z, BODY.torque.x … z                     [N], [N m]      world axes
    kinetic_energy, potential_energy, energy                [J]      where the scene is known

The numbers are those of the run, so those of the bag from which it came, to the bit; CSV has the
up to 17 digits that say as much. Missing numbers are NaN. pandas, pyarrow and xarray are the extra
`tables` and are imported here alone.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.library.run_arrays import RunArrays
from rigid_body_sim.missing_packages import missing
from rigid_body_sim.physics.state.impacts import KINDS
from rigid_body_sim.recording.new_output import replacing
from rigid_body_sim.recording.paths import path_of

if TYPE_CHECKING:
    import pandas
    import xarray

Array = NDArray[np.float64]
Progress = Callable[[int], object]  # told how many rows were written since the last time

VECTORS = {
    'position': 'xyz',
    'orientation': 'xyzw',
    'velocity': 'xyz',
    'angular_velocity': 'xyz',
    'force': 'xyz',
    'torque': 'xyz',
}
UNITS = {
    'position': 'm',
    'orientation': '-',
    'velocity': 'm/s',
    'angular_velocity': 'rad/s',
    'angular_velocity_body': 'rad/s',
    'force': 'N',
    'torque': 'N m',
}
ENERGIES = ('kinetic_energy', 'potential_energy', 'energy')
ROWS = 1000  # of a CSV file between two looks at the progress


def columns(run: RunArrays) -> dict[str, Array]:
    """Give the table, column by column: name -> (m,)."""
    table: dict[str, Array] = {'time': run.time}
    for name in run:
        body = run[name]
        for quantity, axes in VECTORS.items():
            array = getattr(body, quantity)
            for i, axis in enumerate(axes):
                table[f'{name}.{quantity}.{axis}'] = array[:, i]
    if run.scene is not None:
        table |= {name: getattr(run, name) for name in ENERGIES}
    return table


def impact_columns(run: RunArrays) -> dict[str, Any]:
    """
    Give the impacts as a table, column by column: name -> (m,).

    time [s]; tick_ns [ns] and remainder [s], from which it is rounded; kind; the bodies a and b;
    point.x … z [m], normal.x … z from a to b, impulse.x … z [N s] on b, world axes; approach [m/s]
    """
    impacts = run.impacts
    scene = run.scene
    names = np.array(run.names if scene is None else [body.name for body in scene.bodies])
    table: dict[str, Any] = {
        'time': impacts.time,
        'tick_ns': impacts.tick_ns,
        'remainder': impacts.remainder,
        'kind': np.array(KINDS)[impacts.kind],
        'a': names[impacts.bodies[:, 0]],
        'b': names[impacts.bodies[:, 1]],
    }
    for quantity in ('point', 'normal', 'impulse'):
        array = getattr(impacts, quantity)
        table |= {f'{quantity}.{axis}': array[:, i] for i, axis in enumerate('xyz')}
    return table | {'approach': impacts.approach}


def to_pandas(run: RunArrays) -> pandas.DataFrame:
    """Give the table as a DataFrame of its own numbers."""
    frame = _need('pandas').DataFrame(columns(run), copy=True)
    frame.attrs |= _facts(run)
    return frame


def to_xarray(run: RunArrays) -> xarray.Dataset:
    """Give the arrays with named dimensions: time, body, axis and quaternion."""
    xr = _need('xarray')
    arrays: dict[str, Any] = {}
    for quantity, unit in UNITS.items():
        last = 'quaternion' if quantity == 'orientation' else 'axis'
        data = np.stack([getattr(run[name], quantity) for name in run], axis=1)
        arrays[quantity] = (('time', 'body', last), data, {'units': unit})
    if run.scene is not None:
        arrays |= {
            name: (('time',), getattr(run, name).copy(), {'units': 'J'}) for name in ENERGIES
        }
    places = {
        'time': ('time', run.time.copy(), {'units': 's'}),
        'body': list(run.names),
        'axis': list('xyz'),
        'quaternion': list('xyzw'),
    }
    return xr.Dataset(arrays, coords=places, attrs=_facts(run))


def _facts(run: RunArrays) -> dict[str, Any]:
    """Say what the run was, as plain values."""
    return {
        'scene': '' if run.scene is None else run.scene.name,
        'integrator': run.integrator,
        'dt': run.dt,
        'end_reason': run.end_reason,
        'end_time': run.end_time,
    }


def write_parquet(
    run: RunArrays, path: str | os.PathLike[str], *, progress: Progress = lambda _rows: None
) -> None:
    """Write the table as a Parquet file, as a whole or not at all."""
    pyarrow = _need('pyarrow')
    _write_parquet(pyarrow, run, columns(run), path_of(path, said='to_parquet'))
    progress(len(run.time))


def _write_parquet(pyarrow: Any, run: RunArrays, table: dict[str, Any], path: Path) -> None:
    parquet = import_module('pyarrow.parquet')
    arrays = {name: np.ascontiguousarray(values) for name, values in table.items()}
    made = pyarrow.table({n: pyarrow.array(a, from_pandas=False) for n, a in arrays.items()})
    told = {f'rigid_body_sim.{key}': str(value) for key, value in _facts(run).items()}
    with replacing(path) as new, new.open('wb') as file:  # of a path it removes what failed
        parquet.write_table(made.replace_schema_metadata(told), file)


def write_impacts(run: RunArrays, path: str | os.PathLike[str]) -> None:
    """Write the impacts of a run as CSV or Parquet, by the suffix; see `impact_columns`."""
    table, place = impact_columns(run), path_of(path, said='impacts')
    if place.suffix.lower() == '.parquet':
        _write_parquet(_need('pyarrow'), run, table, place)
        return
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    with replacing(place) as new, new.open('w', encoding='utf-8', newline='') as file:
        csv.writer(file, lineterminator='\n').writerows([table, *rows])


def write_csv(
    run: RunArrays, path: str | os.PathLike[str], *, progress: Progress = lambda _rows: None
) -> None:
    """Write the table as a CSV file, numbers as `repr` has them, as a whole or not at all."""
    table = columns(run)
    arrays = [*table.values()]
    place = path_of(path, said='to_csv')
    with replacing(place) as new, new.open('w', encoding='utf-8', newline='') as file:
        csv.writer(file, lineterminator='\n').writerow(table)  # names with commas in quotes
        for start in range(0, len(run.time), ROWS):
            rows = np.stack([array[start : start + ROWS] for array in arrays], axis=1).tolist()
            file.writelines(','.join(map(repr, row)) + '\n' for row in rows)
            progress(len(rows))


def _need(package: str) -> Any:
    """Import an optional package; UserError that says how to come by it."""
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        raise UserError(missing(error.name or package)) from None
