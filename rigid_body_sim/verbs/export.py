# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`export BAG -o FILE.csv|.parquet`: poses, twists, applied wrenches and energies as one table, a row
per published instant, that of the start included.

Columns: time [s]; BODY.position.x … z [m]; BODY.orientation.x … w (xyzw, body to world);
BODY.velocity.x … z [m/s] and BODY.angular_velocity.x … z [rad/s], BODY.force.x … z [N] and
BODY.torque.x … z [N m], all in world axes; kinetic_energy, potential_energy and energy [J].

Force and torque are what commands exert: in each row those last told at its instant or before. The
numbers are those of the bag to the bit; CSV has the up to 17 digits that say as much. A Parquet
file needs pyarrow.

With --impacts a row per impact of `contact: {mode: event}`: time [s], and as exact as it is known,
tick_ns [ns] and remainder [s] from there; kind; the bodies a and b; point [m], normal from a to b
and impulse on b [N s], world axes; approach [m/s].
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.library import tables
from rigid_body_sim.library.from_bag import open_bag
from rigid_body_sim.library.run import Run
from rigid_body_sim.recording.new_output import check_folder
from rigid_body_sim.runs.reading_guard import reads_recording
from rigid_body_sim.stop_signals import STOP, say
from rigid_body_sim.terminal import progress_bar

SUMMARY = 'poses, twists, wrenches and energies of a bag as one table'

WRITERS = {'.csv': tables.write_csv, '.parquet': tables.write_parquet}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare `export BAG -o FILE.csv|FILE.parquet`."""
    parser.add_argument('bag', metavar='BAG', help='bag directory or .mcap file')
    parser.add_argument(
        '-o',
        '--output',
        metavar='FILE',
        required=True,
        type=Path,
        help='FILE.csv or FILE.parquet; one that exists is replaced',
    )
    parser.add_argument(
        '--impacts',
        action='store_true',
        help='the impacts at their instants, in place of the states',
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object')


@reads_recording('bag')
def run(arguments: argparse.Namespace) -> int:
    """Write the table; exit code 0."""
    output = arguments.output
    write = WRITERS.get(output.suffix.lower())
    if write is None:
        raise UserError(
            f'{output}: no table is written {f"as {output.suffix}" * bool(output.suffix)}'
            f'{"without a suffix" * (not output.suffix)}; give FILE.csv or FILE.parquet'
        )
    check_folder(output)
    STOP.stage = f'before {output} was written'
    shown = not arguments.json
    with progress_bar(unit=' messages', unit_scale=True, shown=shown) as bar:
        found = open_bag(arguments.bag, progress=bar.update)
    if arguments.impacts:
        with STOP.kept():
            tables.write_impacts(found, output)
        _tell(arguments, found)
        return 0
    with (
        STOP.kept(),  # half a table looks like a whole one
        progress_bar(total=len(found.time), unit=' rows', shown=shown) as bar,
    ):
        write(found, output, progress=bar.update)
    _tell(arguments, found)
    return 0


def _tell(arguments: argparse.Namespace, found: Run) -> None:
    of_impacts = arguments.impacts
    count = len(tables.impact_columns(found) if of_impacts else tables.columns(found))
    rows = len(found.impacts if of_impacts else found.time)
    if arguments.json:
        said = {
            'output': str(arguments.output),
            'rows': rows,
            'columns': count,
            'bodies': len(found.names),
            'end_reason': found.end_reason,
        }
        print(json.dumps(said))
        return
    print(f'{arguments.output}: {rows} rows, {count} columns')
    if found.problem:
        say(f'rigid_body_sim export: {arguments.bag}: {found.problem}')
