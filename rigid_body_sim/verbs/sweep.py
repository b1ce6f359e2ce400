# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`sweep SCENE --vary KEY=… -o FILE.parquet|.csv`: a scene many times with keys that differ; a row
a run.

KEY is a place in the scene: box.mass, satellite.initial.velocity[2], bodies[0].shape.radius,
gravity[2], forces[0].stiffness, contact.mode, integrator, dt. What it takes is a grid
FIRST:LAST:POINTS, a list 1,2,5, or a draw for each run: uniform:LOW:HIGH, normal:MEAN:DEVIATION,
loguniform:LOW:HIGH, truncated_normal:MEAN:DEVIATION:LOW:HIGH, integers:LOW:HIGH, choice:A:B,
direction:LENGTH, rotation (also written with brackets and commas, in quotes: 'normal(0, 0.1)').
Grids and lists of several keys are combined in full. Run K depends on the seed and K alone.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.stop_signals import STOP, say
from rigid_body_sim.sweeps import DIVERGED, DONE, GROUPS, REFUSED
from rigid_body_sim.sweeps.nursery import Nursery
from rigid_body_sim.terminal import progress_bar

if TYPE_CHECKING:  # what takes time to import is, where it is needed
    from rigid_body_sim.sweeps.ensemble import Outcome
    from rigid_body_sim.sweeps.plan import Sweep

SUMMARY = 'run a scene many times with keys that differ; one row of a table a run'
PROGRESS_EVERY = 0.2  # [s] wall
SHOWN_REASONS = 3  # [-] in the summary; all are in the file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument('scene', help='scene file (YAML), or the name of a shipped scene')
    parser.add_argument(
        '--vary', action='append', default=[], metavar='KEY=VALUES', help='once for each key'
    )
    parser.add_argument(
        '--runs',
        type=int,
        metavar='N',
        help='how many, default: all combinations of grids and lists',
    )
    parser.add_argument('--seed', type=int, default=0, metavar='S', help='of draws, default 0')
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE', help='FILE.parquet or FILE.csv to write; '
        'parts of it stand in FILE.parts until it is done, and the same command goes on from them'
    )  # fmt: skip
    parser.add_argument(
        '--duration',
        type=float,
        default=10.0,
        metavar='S',
        help='of each run [s], to the nearest whole tick, default 10',
    )
    parser.add_argument(
        '--every',
        type=float,
        metavar='S',
        help='simulated time [s] between looks at extremes and energy, default: duration / 100',
    )
    parser.add_argument(
        '--keep',
        default=','.join(GROUPS),
        metavar='GROUPS',
        help=f'what a row holds beside what was varied, default {",".join(GROUPS)}',
    )
    parser.add_argument(
        '--bodies',
        default='',
        metavar='NAMES',
        help='those with columns of their own, with commas; default: all that move',
    )
    parser.add_argument(
        '-j',
        '--workers',
        type=int,
        metavar='N',
        help='processes, default: one a core; no bit depends on it',
    )
    parser.add_argument(
        '--scheduler',
        metavar='ADDRESS',
        help='let the workers of this Dask scheduler make the runs: tcp://HOST:8786',
    )
    parser.add_argument('--only', type=int, metavar='K', help='make run K (from 0) alone again')
    parser.add_argument('--bag', type=Path, metavar='BAG', help='record the run of --only')
    parser.add_argument('--json', action='store_true', help='print one JSON object')


def run(arguments: argparse.Namespace) -> int:
    """
    Sweep; exit code 0, 1 if no run came to its end, or that of the signal that stopped it.
    """
    STOP.stage = 'before a run was made'
    with _nursery(arguments) as nursery:
        return _run(arguments, nursery)


@contextmanager
def _nursery(arguments: argparse.Namespace) -> Iterator[Nursery | None]:
    """
    Start what workers come from while the plan is still made, where they are likely to be needed.

    A scene in which bodies meet is not packed (`packs`); a guess that fails costs half a second of
    processor time, or as much of waiting.
    """
    alone = arguments.workers == 1 or arguments.only is not None or arguments.scheduler is not None
    if alone or arguments.output is None or not _seems_to_have_contact(arguments.scene):
        yield None
        return
    nursery = Nursery(meeting=True)
    try:
        yield nursery
    finally:
        nursery.close()


def _seems_to_have_contact(scene: str) -> bool:
    from rigid_body_sim.scene.shipped_scenes import find_scene

    try:
        text = find_scene(scene).read_text(encoding='utf-8')
    except (UserError, OSError, ValueError):  # told when the scene is read
        return False
    return re.search(r'^contact:', text, re.MULTILINE) is not None


def _run(arguments: argparse.Namespace, nursery: Nursery | None) -> int:
    from rigid_body_sim.sweeps import ensemble
    from rigid_body_sim.sweeps.plan import plan_sweep

    plan = plan_sweep(
        arguments.scene,
        _vary(arguments.vary),
        runs=arguments.runs,
        seed=arguments.seed,
        duration=arguments.duration,
        every=arguments.every,
        keep=_words(arguments.keep),
        bodies=_words(arguments.bodies),
    )
    workers = ensemble.checked_workers(arguments.workers)
    if arguments.only is not None:
        return _only(plan, arguments)
    if arguments.bag is not None:
        raise UserError('--bag records one run: say which, with --only K')
    if arguments.output is None:
        raise UserError('-o FILE is missing: FILE.parquet or FILE.csv to write')
    if plan.runs < plan.points:
        say(
            f'rigid_body_sim sweep: {plan.runs} runs of {plan.points} combinations: the others '
            'are not made; leave --runs out for all'
        )
    began = time.monotonic()
    with _Bar(plan, quiet=arguments.json) as bar:
        outcome = ensemble.to_file(
            plan,
            arguments.output,
            workers=workers,
            scheduler=arguments.scheduler,
            progress=bar.show,
            nursery=nursery,
        )
    STOP.keep()
    return _report(plan, arguments, outcome, wall=time.monotonic() - began)


def _vary(given: list[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in given:
        key, sign, values = text.partition('=')
        if not sign or not key.strip() or not values.strip():
            raise UserError(
                f'--vary {text!r}: allowed: KEY=VALUES, such as box.mass=1:5:9 or '
                'box.initial.velocity=normal:0:0.1'
            )
        if key.strip() in found:
            raise UserError(f'--vary {key.strip()} is given twice; keep one of them')
        found[key.strip()] = values
    return found


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(',') if word.strip()]


class _Bar:
    """How far the sweep is: on a terminal, and in the words of a signal that ends it."""

    def __init__(self, plan: Sweep, *, quiet: bool) -> None:
        self._bar = progress_bar(total=plan.runs, unit='run', shown=not quiet)
        self._due = 0.0
        self._is_first = True

    def show(self, done: float, runs: int) -> None:
        """Tell how many runs are done, those of tasks under way by their share."""
        STOP.stage = (
            f'after {int(done)} of {runs} runs; what is done is kept, and the same command goes '
            'on from there'
        )
        if self._bar.disable or time.monotonic() < self._due:
            return
        self._due = time.monotonic() + PROGRESS_EVERY
        if self._is_first:  # those of an earlier process say nothing of the pace of this one
            self._is_first, self._bar.initial, self._bar.n = False, int(done), int(done)
        with suppress(OSError):  # a terminal that hung up; its signal is on the way
            self._bar.update(max(0, int(done) - int(self._bar.n)))

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._bar.close()


def _report(plan: Sweep, arguments: argparse.Namespace, outcome: Outcome, *, wall: float) -> int:
    for note in outcome.notes:
        say(f'rigid_body_sim sweep: {note}')
    failed, made = outcome.failed, outcome.made
    before = outcome.before
    made_before, failed_before = (before.made, before.failed) if before else (0, 0)
    whole = failed + failed_before
    code = 1 if plan.runs and whole == plan.runs else 0
    if arguments.json:
        result = {
            'output': str(arguments.output),
            'scene': plan.title,
            'runs': plan.runs,
            'made_now': made,
            'failed_now': failed,
            'reasons': outcome.reasons,
            'seed': plan.seed,
            'duration': plan.duration,
            'wall_time': wall,
            'processor_time': sum(os.times()[:4]),
        }
        print(json.dumps(result))
        return code
    were = 'was' if made_before == 1 else 'were'
    taken = f'; {made_before} of them {were} made before' if made_before else ''
    print(f'{plan.title}: {_runs(plan.runs)} of {plan.duration:g} s in {wall:.2f} s{taken}')
    if whole:
        told = f', {failed_before} of them before' if failed_before else ''
        ends = outcome.ends + (before.ends if before else Counter())
        how = ', '.join(f'{count} {status}' for status, count in sorted(ends.items()))
        print(f'  {how}{told}: {"its row says" if whole == 1 else "their rows say"} why')
        reasons = Counter(outcome.reasons) + Counter(before.reasons if before else ())
        often = sorted(reasons.items(), key=lambda item: (-item[1], item[0]))
        for reason, count in often[:SHOWN_REASONS]:
            print(f'    {_runs(count)}: {reason}')
    print(f'  table: {arguments.output}')
    sys.stdout.flush()
    return code


def _runs(count: int) -> str:
    return '1 run' if count == 1 else f'{count} runs'


def _only(plan: Sweep, arguments: argparse.Namespace) -> int:
    """Make one run again; with --bag into a bag that replays."""
    from rigid_body_sim.recording.bag_directory import check_new
    from rigid_body_sim.sweeps import ensemble

    number = arguments.only
    if not 0 <= number < plan.runs:
        raise UserError(f'--only {number}; allowed: a run from 0 to {plan.runs - 1}')
    if arguments.bag is not None:
        check_new(arguments.bag)
    STOP.stage = 'while the run was made; nothing is kept'
    row = ensemble.one_row(plan, number)
    if arguments.bag is not None and row['status'] in (DONE, DIVERGED):
        from rigid_body_sim.sweeps.only import record_one  # who records nothing starts faster

        record_one(plan, number, arguments.bag, expected=row)
    _print_row(row, arguments)
    return {DONE: 0, REFUSED: 2}.get(row['status'], 1)


def _print_row(row: dict[str, Any], arguments: argparse.Namespace) -> None:
    if row['status'] == REFUSED:
        raise UserError(f'run {row["run"]}: {row["reason"]}')
    if row['status'] not in (DONE, DIVERGED):
        raise RunError(f'run {row["run"]}: {row["reason"]}')
    if arguments.json:
        finite = {
            name: None if isinstance(value, float) and value - value != 0.0 else value
            for name, value in row.items()
        }
        print(json.dumps({'bag': arguments.bag and str(arguments.bag), **finite}))
        return
    for name, value in row.items():
        if value is not None:
            print(f'{name}: {value}')
    if arguments.bag is not None:
        print(f'bag: {arguments.bag}')
    sys.stdout.flush()
