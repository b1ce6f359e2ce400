# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`report -o DIR`: speed against error of every method on problems with exact answers.

Writes report.json and report.csv, pictures, and report.html, one page that needs nothing else.
A folder that holds a report is refused: what was measured for minutes is never replaced.
With --scene the same for a scene of your own: which integrator, which step?
"""

from __future__ import annotations

import argparse
import math
import os
import shlex
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.compile.kernels import warn_if_plain
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.recording.new_output import check_text, is_taken
from rigid_body_sim.report import own_scene, results
from rigid_body_sim.report.entry import Peer
from rigid_body_sim.report.machine import made
from rigid_body_sim.report.measure import QUICK_REPETITIONS, REPETITIONS, measure
from rigid_body_sim.report.method import method
from rigid_body_sim.report.names import chosen
from rigid_body_sim.report.point import Point
from rigid_body_sim.report.problem import SEED, Problem
from rigid_body_sim.report.problems import PROBLEMS
from rigid_body_sim.report.publish import publish
from rigid_body_sim.report.warm_up import end_helpers, warm_up
from rigid_body_sim.runs.warning_lines import warning_printer
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene
from rigid_body_sim.stop_signals import STOP, say
from rigid_body_sim.terminal import progress_bar

SUMMARY = 'speed against error: tables, plots, one HTML page'
ALL = 'all'
NUMBERS = ('duration', 'tolerance', 'publish-rate')  # of --scene
DURATION, TOLERANCE = 10.0, 1e-6  # [s], [m or rad] of --scene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        required=True,
        metavar='DIR',
        help='folder to write into; it must not hold a report yet',
    )
    parser.add_argument(
        '--problems', nargs='+', metavar='NAME', help=f'of: {", ".join(PROBLEMS)}; default: all'
    )
    parser.add_argument(
        '--integrators',
        nargs='+',
        metavar='NAME',
        help='with options: blanes_moan4:drift=exact; default: those that suit each problem; '
        f'{ALL}: every one, references too',
    )
    parser.add_argument(
        '--peers',
        nargs='*',
        metavar='NAME',
        help='other engines beside ours, each in turn with it; without a name all that are '
        'installed',
    )
    parser.add_argument(
        '--scene',
        metavar='SCENE',
        help='in place of the problems: which integrator and which dt for this scene? A file '
        '(YAML), or the name of a shipped scene',
    )
    parser.add_argument(
        '--duration',
        type=float,
        metavar='S',
        help=f'with --scene: simulated time [s], default {DURATION:g}',
    )
    parser.add_argument(
        '--tolerance',
        type=float,
        metavar='E',
        help=f'with --scene: largest error allowed at any of ten instants [m or rad], '
        f'default {TOLERANCE:g}',
    )
    parser.add_argument(
        '--publish-rate',
        type=float,
        metavar='HZ',
        help='with --scene: how often states are to be published and commands taken; no longer '
        f'tick is tried; default {own_scene.PUBLISH_RATE:g}',
    )
    parser.add_argument(
        '--starts',
        action='store_true',
        help='also how long the first step is waited for, from source, from shipped bitcode and '
        'later; takes minutes',
    )
    parser.add_argument(
        '--quick', action='store_true', help='short runs, few bodies, three repetitions'
    )
    parser.add_argument(
        '--repetitions',
        type=int,
        metavar='N',
        help=f'how often each point is timed, default {REPETITIONS}, with --quick '
        f'{QUICK_REPETITIONS}',
    )


def run(arguments: argparse.Namespace) -> int:
    """Measure problem after problem; exit code 0, or that of the signal that stopped it."""
    os.environ.setdefault('RIGID_BODY_SIM_THREADS', '1')  # processor time is measured
    warn_if_plain(warning_printer('report'))
    wanted = _wanted(arguments)
    about = made(repetitions=wanted.repetitions, quick=wanted.quick, seed=SEED)
    about |= {'command': _command(arguments), 'scene': arguments.scene}
    done: list[dict[str, Any]] = []
    begun: list[dict[str, Any]] = []

    def interrupted() -> str:
        end_helpers()
        if not done:
            return '; nothing is written'
        about['interrupted'] = True
        try:
            publish(results.report(about, done, wanted.absent), wanted.output)
        except (RunError, UserError) as error:
            return f'; {error}; {_safe(wanted)}'
        return f'; {len(done)} of {len(wanted.problems)} problems are in {wanted.output}'

    STOP.before_leaving = interrupted
    begin = time.monotonic()
    try:
        if arguments.scene:
            done.append(_own_scene(arguments, wanted))
            _publish(about, done, wanted)
        else:
            with _Progress('report') as progress:
                warm_up(wanted.problems, wanted.methods, progress.show)
            measuring = time.monotonic()
            for number, name in enumerate(wanted.problems, 1):
                left = rest_words(number - 1, len(wanted.problems), time.monotonic() - measuring)
                with _Progress(f'{name} ({number} of {len(wanted.problems)}{left})') as progress:
                    problem = PROBLEMS[name]
                    points = _measured(problem, wanted, progress)
                done.append(results.problem_results(problem, points))
                _publish(about, done, wanted)
                print(f'{name}: {done[-1]["verdict"]}', flush=True)
            if arguments.starts:
                with _Progress('first start') as progress:
                    begun += _starts(wanted, progress)
                _publish(about, done, wanted, begun)
    except KeyboardInterrupt:  # in a program that calls this verb
        say(f'rigid_body_sim report: stopped by {STOP.name}{interrupted()}')
        return STOP.exit_code
    print(f'measured in {time.monotonic() - begin:.0f} s: {wanted.output}')
    return 0


def _command(arguments: argparse.Namespace) -> str | None:
    """Write the command that makes the report again; None: `make report` does."""
    words: list[str] = []
    for option in ('scene', 'problems', 'integrators', *NUMBERS, 'peers', 'repetitions'):
        given = getattr(arguments, option.replace('-', '_'))
        if given is not None:
            values = given if isinstance(given, list) else [given]
            words += [f'--{option}', *map(str, values)]
    words += [f'--{flag}' for flag in ('starts', 'quick') if getattr(arguments, flag)]
    if {*words} <= {'--peers', '--starts'}:
        return None
    words += ['-o', str(arguments.output)]
    return f'python -m rigid_body_sim report {shlex.join(words)}'


def rest_words(done: int, of: int, elapsed: float) -> str:
    """Say roughly how long the rest of the problems takes; nothing before the first is done."""
    return f', some {elapsed / done * (of - done):.0f} s left' if done else ''


def _publish(
    about: dict[str, Any],
    done: list[dict[str, Any]],
    wanted: _Wanted,
    begun: Sequence[dict[str, Any]] = (),
) -> None:
    try:
        with STOP.kept():
            publish(results.report(about, done, wanted.absent, begun), wanted.output)
    except RunError as error:
        raise RunError(f'{error}; {_safe(wanted)}') from error


def _safe(wanted: _Wanted) -> str:
    """Say which problems a report holds that could not be written to its end."""
    try:
        names = [problem['name'] for problem in results.read(wanted.output)['problems']]
    except UserError:
        return 'nothing that was measured is safe'
    left = [name for name in wanted.problems if name not in names]
    rest = f'; measure the rest into another folder: --problems {" ".join(left)}' if left else ''
    return f'{results.JSON} holds {", ".join(names)}{rest}'


def _starts(wanted: _Wanted, progress: _Progress) -> list[dict[str, Any]]:
    from rigid_body_sim.report import first_start, peers

    engines = {peer.engine for peer in wanted.peers}
    names = [name for name in peers.names() if peers.engine_of(name) in engines]
    return first_start.measure(names, repetitions=wanted.repetitions, progress=progress.show)


@dataclass(frozen=True)
class _Wanted:
    """The checked command line; without methods each problem has its own."""

    output: Path
    problems: list[str]
    methods: list[str]
    repetitions: int
    quick: bool
    peers: list[Peer]
    absent: list[dict[str, str]]


def _wanted(arguments: argparse.Namespace) -> _Wanted:
    """Check the command line."""
    for other in ('problems', 'peers', 'starts'):
        if arguments.scene and getattr(arguments, other) not in (None, False):
            raise UserError(f'--scene and --{other}: give one of them')
    for name in NUMBERS:
        value = getattr(arguments, name.replace('-', '_'))
        if value is not None and not arguments.scene:
            raise UserError(f'--{name} goes with --scene: problems have theirs')
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise UserError(f'--{name} {value:g}; allowed: a positive number')
    repetitions = arguments.repetitions
    if repetitions is None:
        repetitions = QUICK_REPETITIONS if arguments.quick else REPETITIONS
    if repetitions < 1:
        raise UserError(f'--repetitions {repetitions}; allowed: 1 or more')
    for name in (str(arguments.output), arguments.scene or ''):
        check_text(name, what='a name in a report')  # which holds the command that made it
    if is_taken(arguments.output) and not arguments.output.is_dir():
        raise UserError(f'{arguments.output}: is a file; -o names the folder to write into')
    if is_taken(arguments.output / results.JSON):
        raise UserError(
            f'{arguments.output}: holds a report already; choose another folder or remove it'
        )
    peers, absent = _peers(arguments.peers)
    return _Wanted(
        arguments.output,
        chosen(arguments.problems, PROBLEMS, option='--problems', what='problem'),
        _methods(arguments.integrators),
        repetitions,
        arguments.quick,
        peers,
        absent,
    )


def _peers(given: Sequence[str] | None) -> tuple[list[Peer], list[dict[str, str]]]:
    """Load other engines; none unless asked for. Those that are absent, with a reason each."""
    if given is None:
        return [], []
    from rigid_body_sim.report import peers

    found, absent = peers.find(chosen(given, peers.names(), option='--peers', what='engine'))
    return list(found), [{'engine': each.engine, 'reason': each.reason} for each in absent]


def _methods(given: Sequence[str] | None) -> list[str]:
    """Methods given; those of all integrators for `all`; none for the choice of each problem."""
    if given is None:
        return []
    if ALL in given:
        return list(INTEGRATORS)
    return [method(text).text for text in dict.fromkeys(given)]


def _measured(problem: Problem, wanted: _Wanted, progress: _Progress) -> list[Point]:
    return measure(
        problem,
        wanted.methods or problem.integrators,
        peers=wanted.peers if problem.error_of_run is None else [],
        repetitions=wanted.repetitions,
        quick=wanted.quick,
        progress=progress.show,
    )


def _own_scene(arguments: argparse.Namespace, wanted: _Wanted) -> dict[str, Any]:
    """Measure a scene of the user's; print the table and the recommendation."""
    scene = load_scene(find_scene(arguments.scene))
    duration = own_scene.whole_duration(scene, arguments.duration or DURATION)
    tolerance = arguments.tolerance or TOLERANCE
    publish_rate = arguments.publish_rate or own_scene.PUBLISH_RATE
    with _Progress(scene.name) as progress:
        against = own_scene.reference(scene, duration, progress.show)
        problem = own_scene.problem_of(
            scene, duration, against, tolerance=tolerance, publish_rate=publish_rate
        )
        points = _measured(problem, wanted, progress)
    found = results.problem_results(problem, points)
    found['reference_error'] = against.error
    found['recommendation'] = own_scene.recommendation(
        points, problem, tolerance=tolerance, against=against, publish_rate=publish_rate
    )
    print(own_scene.table(points))
    print(f'reference: {problem.reference}')
    print(f'recommended for {scene.name}: {found["recommendation"]}')
    return found


class _Progress:
    """One line on a terminal that says what is measured, and goes away."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._bar = progress_bar(total=0, bar_format='{desc}')

    def show(self, text: str) -> None:
        """Replace the line."""
        self._bar.set_description_str(f'{self._title}: {text}')

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._bar.close()
