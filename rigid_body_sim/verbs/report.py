# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`report -o DIR`: speed against error of every method on problems with exact answers.

Writes report.json and report.csv, pictures, and report.html, one page that needs nothing else.
With --scene the same for a scene of your own: which integrator, which step?
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.integrators import INTEGRATORS
from rigid_body_sim.report import results
from rigid_body_sim.report.machine import made
from rigid_body_sim.report.measure import QUICK_REPETITIONS, REPETITIONS, measure
from rigid_body_sim.report.method import method
from rigid_body_sim.report.names import chosen
from rigid_body_sim.report.problem import SEED
from rigid_body_sim.report.problems import PROBLEMS
from rigid_body_sim.report.publish import publish

SUMMARY = 'speed against error: tables, plots, one HTML page'
ALL = 'all'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        '-o', '--output', type=Path, required=True, metavar='DIR', help='folder to write into'
    )
    parser.add_argument(
        '--problems', nargs='+', metavar='NAME', help=f'of: {", ".join(PROBLEMS)}; default: all'
    )
    parser.add_argument(
        '--integrators',
        nargs='+',
        metavar='NAME',
        help=f'default: those that suit each problem; {ALL}: every one, references too',
    )
    parser.add_argument(
        '--quick', action='store_true', help='short runs, few bodies, three repetitions'
    )
    parser.add_argument(
        '--repetitions',
        type=int,
        metavar='N',
        help=f'how often each point is timed, default {REPETITIONS}',
    )


def run(arguments: argparse.Namespace) -> int:
    """Measure problem after problem; exit code 0, or 1 where it was interrupted."""
    problems = chosen(arguments.problems, PROBLEMS, option='--problems', what='problem')
    integrators = _integrators(arguments.integrators)
    repetitions = arguments.repetitions
    if repetitions is None:
        repetitions = QUICK_REPETITIONS if arguments.quick else REPETITIONS
    if repetitions < 1:
        raise UserError(f'--repetitions {repetitions}; allowed: 1 or more')
    if arguments.output.exists() and not arguments.output.is_dir():
        raise UserError(f'{arguments.output}: is a file; -o names the folder to write into')
    about = made(repetitions=repetitions, quick=arguments.quick, seed=SEED)
    done: list[dict[str, Any]] = []
    begin = time.monotonic()
    try:
        for number, name in enumerate(problems, 1):
            with _Progress(f'{name} ({number} of {len(problems)})') as progress:
                problem = PROBLEMS[name]
                points = measure(
                    problem,
                    integrators or problem.integrators,
                    repetitions=repetitions,
                    quick=arguments.quick,
                    progress=progress.show,
                )
            done.append(results.problem_results(problem, points))
            publish(results.report(about, done), arguments.output)
            print(f'{name}: {done[-1]["verdict"]}', flush=True)
    except KeyboardInterrupt:
        about['interrupted'] = True
        publish(results.report(about, done), arguments.output)
        print(
            f'rigid_body_sim report: interrupted; {len(done)} of {len(problems)} problems are in '
            f'{arguments.output}',
            file=sys.stderr,
        )
        return 1
    print(f'{len(done)} problems in {time.monotonic() - begin:.0f} s: {arguments.output}')
    return 0


def _integrators(given: Sequence[str] | None) -> list[str]:
    """Names given; those of all for `all`; none for the choice of each problem."""
    if given is None:
        return []
    if ALL in given:
        return list(INTEGRATORS)
    return [method(text).text for text in given]


class _Progress:
    """One line on a terminal that says what is measured, and goes away."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._bar = tqdm(
            total=0, bar_format='{desc}', disable=not sys.stderr.isatty(), leave=False
        )

    def show(self, text: str) -> None:
        """Replace the line."""
        self._bar.set_description_str(f'{self._title}: {text}')

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._bar.close()
