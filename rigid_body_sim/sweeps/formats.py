# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the file of a whole sweep may be, by its suffix: Parquet or CSV. Its parts are Parquet always.

A CSV file has a row of names, then a row a run: numbers as `repr` has them, that is to the bit;
nothing where a run has no value; no metadata.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import UserError
from rigid_body_sim.sweeps import table
from rigid_body_sim.sweeps.plan import Sweep
from rigid_body_sim.sweeps.rows import Row


@dataclass(frozen=True)
class Format:
    """
    How such a file is written and read.

    write    : joins parts, in the order of their runs, into one file
    rows_in  : counts the rows of a file; None: it is no such file
    statuses : gives status and reason of its rows, group by group
    read     : gives it as an Arrow table
    """

    write: Callable[[Sweep, Sequence[Path], Path], None]
    rows_in: Callable[[Path], int | None]
    statuses: Callable[[Path], Iterator[list[Row]]]
    read: Callable[[Sweep, Path], Any]


def format_of(path: Path) -> Format:
    """Give the format that a suffix asks for; UserError for one that none has."""
    found = FORMATS.get(path.suffix.lower())
    if found is None:
        got = f'as {path.suffix}' if path.suffix else 'without a suffix'
        raise UserError(
            f'{path}: no table of a sweep is written {got}; give FILE.parquet or FILE.csv'
        )
    return found


def _read_parquet(_sweep: Sweep, path: Path) -> Any:
    import pyarrow.parquet

    return pyarrow.parquet.read_table(path)


def _write_csv(sweep: Sweep, parts: Sequence[Path], path: Path) -> None:
    schema = table.schema_of(sweep, parts)
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(schema.names)
        for group in table.groups(parts, schema):
            writer.writerows(zip(*(column.to_pylist() for column in group.columns), strict=True))


def _csv_rows(path: Path) -> Iterator[Row]:
    """Give status and reason row by row; ValueError for what is no such file."""
    with path.open(encoding='utf-8', newline='') as file:
        try:
            for row in csv.DictReader(file):
                yield {'status': row['status'], 'reason': row['reason'] or None}
        except (KeyError, csv.Error) as error:
            raise ValueError(f'{path}: {error}') from error


def _csv_rows_in(path: Path) -> int | None:
    try:
        return sum(1 for _ in _csv_rows(path))
    except (OSError, ValueError):
        return None


def _csv_statuses(path: Path) -> Iterator[list[Row]]:
    rows = _csv_rows(path)
    while group := list(islice(rows, table.ROWS)):
        yield group


def _read_csv(sweep: Sweep, path: Path) -> Any:
    """Read a file back, its types as the sweep has them."""
    arrow: Any = import_module('pyarrow.csv')
    with path.open(encoding='utf-8', newline='') as file:
        names = next(csv.reader(file))
    return arrow.read_csv(
        path,
        parse_options=arrow.ParseOptions(newlines_in_values=True),
        convert_options=arrow.ConvertOptions(
            column_types={name: table.type_of(sweep, name) for name in names},
            null_values=[''],
            strings_can_be_null=True,
        ),
    )


FORMATS = {
    '.parquet': Format(table.write, table.rows_in, table.statuses, _read_parquet),
    '.csv': Format(_write_csv, _csv_rows_in, _csv_statuses, _read_csv),
}
