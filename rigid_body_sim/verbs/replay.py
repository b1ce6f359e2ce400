# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`replay BAG`: run a recorded bag again from its own scene and commands.

With the same settings every message is compared bit by bit: exit code 0 if identical, 3 with the
first difference if not.
With --integrator or --dt the distance from the recording is reported.
"""

from __future__ import annotations

import argparse
import json
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path

from rigid_body_sim.physics.compile.kernels import warn_if_plain
from rigid_body_sim.recording.bag_directory import check_new
from rigid_body_sim.runs.compile_note import CompileNote, expected_functions
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.replay import Comparison, Errors, Progress, compare, measure
from rigid_body_sim.runs.warning_lines import warning_printer
from rigid_body_sim.terminal import NoBar, printable, progress_bar

SUMMARY = 're-run a bag from its own scene and commands and compare bit by bit'
DIFFERS = 3
UNITS = {'position': 'm', 'angle': 'rad', 'velocity': 'm/s', 'angular_velocity': 'rad/s'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        'bag', type=Path, help='bag directory or .mcap file recorded by this package'
    )
    parser.add_argument(
        '--integrator', metavar='NAME', help='run with another integrator and report the error'
    )
    parser.add_argument(
        '--dt',
        type=float,
        metavar='S',
        help='run with another tick length [s] and report the error',
    )
    parser.add_argument('-o', '--output', type=Path, metavar='BAG', help='record the new run')
    parser.add_argument('--json', action='store_true', help='print one JSON object')


def run(arguments: argparse.Namespace) -> int:
    """Replay; exit code 0, or 3 where the replay differs from the recording."""
    warn_if_plain(warning_printer('replay'))
    recorded = RecordedRun(arguments.bag)
    if arguments.output is not None:
        check_new(arguments.output)
    shown = not arguments.json
    with (
        CompileNote(expected_functions(recorded.scene), shown=shown) as note,
        ExitStack() as bars,
    ):
        progress, warn = _shown_on(note, bars, shown=shown), warning_printer('replay')
        if arguments.integrator is None and arguments.dt is None:
            outcome = compare(recorded, output=arguments.output, progress=progress, warn=warn)
            note.end()
            bars.close()
            return _tell(recorded, outcome, as_json=arguments.json)
        again, errors = measure(
            recorded,
            integrator=arguments.integrator,
            dt=arguments.dt,
            output=arguments.output,
            progress=progress,
            warn=warn,
        )
    settings = {
        'integrator': again.simulation.integrator.name,
        'dt': again.simulation.dt,
        'warnings': again.warnings,
    }
    _tell_errors(recorded, settings, errors, as_json=arguments.json)
    return 0


def _shown_on(note: CompileNote, bars: ExitStack, *, shown: bool) -> Progress:
    """Show the ticks as a bar, from the first of them on: until then kernels are compiled."""
    bar: list[NoBar] = []

    def progress(tick: int, last_tick: int) -> None:
        if not bar:
            note.end()
            made = progress_bar(total=last_tick, unit='tick', unit_scale=True, shown=shown)
            bar.append(bars.enter_context(made))
        bar[0].total = last_tick
        bar[0].update(tick - bar[0].n)

    return progress


def _tell(recorded: RecordedRun, outcome: Comparison, *, as_json: bool) -> int:
    difference = outcome.difference
    if as_json:
        result = {
            'identical': difference is None,
            'ticks': outcome.ticks,
            'bodies': len(recorded.scene.bodies),
            'messages': outcome.messages,
            'final_state_sha256': outcome.final_state_sha256,
            'recovered': outcome.recovered,
            'warnings': list(outcome.warnings),
        }
        if difference is not None:
            result |= asdict(difference)
        print(json.dumps(result))
    elif difference is None:
        saved = ' saved by the recovery' if outcome.recovered else ''
        bodies = len(recorded.scene.bodies)
        print(
            f'identical: {outcome.ticks} ticks{saved} of {bodies} '
            f'bod{"y" if bodies == 1 else "ies"}, {outcome.messages} messages, every bit'
        )
        print(f'  sha256 of the final state: {outcome.final_state_sha256}')
    else:
        ulps = '' if difference.ulps is None else f' ({difference.ulps} ulp)'
        body = f', body {difference.body!r}' if difference.body else ''
        print(f'differs first in tick {difference.tick}{body}, {difference.field}{ulps}')
        print(f'  recorded {printable(difference.recorded)}')
        print(f'  replayed {printable(difference.replayed)}')
    return DIFFERS if difference is not None else 0


def _tell_errors(
    recorded: RecordedRun, settings: dict[str, object], errors: dict[str, Errors], *, as_json: bool
) -> None:
    if as_json:
        bodies = {name: asdict(error) for name, error in errors.items()}
        print(json.dumps({'identical': False, **settings, 'errors': bodies}))
        return
    print(
        f'recorded with {recorded.integrator} at {recorded.dt_ns * 1e-9:g} s, run again with '
        f'{settings["integrator"]} at {settings["dt"]:g} s; largest (last) difference:'
    )
    width = max(map(len, errors), default=4)
    for name, error in errors.items():
        values = ', '.join(
            f'{quantity.replace("_", " ")} {error.largest[quantity]:.2e} '
            f'({error.last[quantity]:.2e}) {unit}'
            for quantity, unit in UNITS.items()
            if error.last
        )
        print(f'  {name:{width}}  {values}')
