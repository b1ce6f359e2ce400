# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Rows as an Arrow table, and as one Parquet file.

Columns stand in the order in which rows first have them: the first six, what was varied, then last
states, extremes and energies. Types come from the sweep, not from the values that happen to occur;
a row without a column holds null there. The file is written in groups of rows that depend on the
table alone, so that its bytes do too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rigid_body_sim.errors import RunError
from rigid_body_sim.sweeps.plan import Sweep
from rigid_body_sim.sweeps.rows import Row

ROWS = 8192  # of one row group: columns of it are read at once, and this many rows held in memory
FACTS = b'rigid_body_sim_sweep'  # key of the facts of a sweep in the metadata of the file
_FIRST = {'run': 'int', 'status': 'text', 'reason': 'text', 'warnings': 'text', 'ticks': 'int',
          'time': 'float'}  # fmt: skip
_TEXTS = {'chosen_integrator': 'text'}


def known_columns(sweep: Sweep) -> dict[str, str]:
    """Name the columns that every table of the sweep has, and what they hold."""
    found = dict(_FIRST)
    for axis in sweep.axes:
        found |= axis.columns
    return found


def _arrow_type(kind: str) -> Any:
    import pyarrow

    return {
        'int': pyarrow.int64(),
        'float': pyarrow.float64(),
        'bool': pyarrow.bool_(),
        'text': pyarrow.string(),
    }[kind]


def type_of(sweep: Sweep, name: str) -> Any:
    """Give the Arrow type of a column."""
    return _arrow_type((known_columns(sweep) | _TEXTS).get(name, 'float'))


def table_of(sweep: Sweep, rows: Sequence[Row]) -> Any:
    """Make an Arrow table of rows."""
    import pyarrow

    known = known_columns(sweep) | _TEXTS
    names = dict.fromkeys(known_columns(sweep))
    for row in rows:
        names |= dict.fromkeys(row)
    arrays = {
        name: _array([row.get(name) for row in rows], known.get(name, 'float')) for name in names
    }
    return pyarrow.table(list(arrays.values()), names=list(arrays))


def _array(values: list[Any], kind: str) -> Any:
    """
    Make an Arrow array of plain values; None is null.

    By its buffers: `pyarrow.array` would import pandas to ask whether this is something of it.
    """
    import pyarrow

    known = np.array([value is not None for value in values], dtype=bool)
    buffers = [pyarrow.py_buffer(np.packbits(known, bitorder='little').tobytes())]
    if kind == 'text':
        words = [b'' if value is None else str(value).encode() for value in values]
        ends = np.cumsum([0, *map(len, words)])
        if ends[-1] >= 2**31:
            raise RunError(f'a column of {ends[-1]} bytes of text in one part; keep less')
        buffers += [pyarrow.py_buffer(ends.astype('<i4').tobytes())]
        buffers += [pyarrow.py_buffer(b''.join(words))]
    elif kind == 'bool':
        truths = np.array([bool(value) for value in values], dtype=bool)
        buffers += [pyarrow.py_buffer(np.packbits(truths, bitorder='little').tobytes())]
    else:
        kept = [0 if value is None else value for value in values]
        numbers = np.array(kept, dtype='<i8' if kind == 'int' else '<f8')
        buffers += [pyarrow.py_buffer(numbers.tobytes())]
    return pyarrow.Array.from_buffers(_arrow_type(kind), len(values), buffers)


def write(sweep: Sweep, parts: Sequence[Path], path: Path) -> None:
    """
    Join parts, in the order of their runs, into one Parquet file, a row group at a time.
    """
    import pyarrow.parquet

    schema = schema_of(sweep, parts)
    with pyarrow.parquet.ParquetWriter(path, schema, compression='zstd') as writer:
        for group in groups(parts, schema):
            writer.write_table(group, row_group_size=ROWS)


def schema_of(sweep: Sweep, parts: Sequence[Path]) -> Any:
    """Give the columns of all parts, and what the sweep was asked for."""
    import pyarrow.parquet

    schemas = (pyarrow.parquet.read_schema(part) for part in parts)
    return joint_schema(schemas).with_metadata({FACTS: sweep.facts_text().encode()})


def joint_schema(schemas: Iterable[Any]) -> Any:
    """Give the columns of all tables, in the order in which they first have them."""
    import pyarrow

    fields: dict[str, Any] = {}
    for schema in schemas:
        for field in schema:
            fields.setdefault(field.name, field)
    return pyarrow.schema([field.with_nullable(True) for field in fields.values()])


def groups(parts: Iterable[Path], schema: Any) -> Iterator[Any]:
    """Give tables of ROWS rows each, the last of what is left."""
    import pyarrow
    import pyarrow.parquet

    waiting, count = [], 0
    for part in parts:
        table = with_schema(_read(part), schema)
        waiting.append(table)
        count += table.num_rows
        while count >= ROWS:
            whole = pyarrow.concat_tables(waiting)
            yield whole.slice(0, ROWS).combine_chunks()
            waiting, count = [whole.slice(ROWS)], count - ROWS
    if count:
        yield pyarrow.concat_tables(waiting).combine_chunks()


def with_schema(table: Any, schema: Any) -> Any:
    """Give a table the columns of a schema, null where it has none."""
    import pyarrow

    columns = [
        table.column(field.name)
        if field.name in table.column_names
        else pyarrow.nulls(table.num_rows, field.type)
        for field in schema
    ]
    return pyarrow.table(columns, schema=schema)


def _read(part: Path) -> Any:
    """Read one part; `read_table` would import pandas for the same."""
    import pyarrow.parquet

    with pyarrow.parquet.ParquetFile(part) as file:
        return file.read(use_threads=False)


def rows_in(path: Path) -> int | None:
    """Count the rows of a file by what its end says; None: it has no such end."""
    import pyarrow.parquet

    try:
        with pyarrow.parquet.ParquetFile(path) as file:
            return file.metadata.num_rows
    except (OSError, ValueError):  # what pyarrow raises derives from them
        return None


def statuses(path: Path) -> Iterator[list[Row]]:
    """Give status and reason of the rows of a file, group by group."""
    import pyarrow.parquet

    with pyarrow.parquet.ParquetFile(path) as file:
        for group in range(file.num_row_groups):
            read = file.read_row_group(group, columns=['status', 'reason'], use_threads=False)
            yield read.to_pylist()
