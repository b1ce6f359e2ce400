# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`simulate SCENE -o BAG`: a scene to a bag, as fast as the machine can, without ROS."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from contextlib import nullcontext, suppress
from dataclasses import asdict
from itertools import groupby
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.compile.kernels import warn_if_plain
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording.bag_directory import check_new
from rigid_body_sim.runs import choices, viewing_arguments
from rigid_body_sim.runs.commands import Command, read_csv
from rigid_body_sim.runs.compile_note import CompileNote, expected_functions
from rigid_body_sim.runs.energy_log import as_numbers
from rigid_body_sim.runs.kept_lines import (
    balance_line,
    contact_lines,
    drift_text,
    momentum_lines,
    pace_text,
)
from rigid_body_sim.runs.longer_ticks import longer_dt
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.run import (
    Run,
    RunSettings,
    need_numbers,
    publish_every,
    rate_note,
    start_alone_note,
)
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.runs.timeouts import timeout_problem
from rigid_body_sim.runs.warning_lines import warning_printer
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.experiment import URDF_SUFFIX
from rigid_body_sim.scene.shipped_scenes import find_scene
from rigid_body_sim.stop_signals import STOP, say
from rigid_body_sim.terminal import progress_bar

SUMMARY = 'run a scene without ROS, as fast as possible, into a bag'
DRIFT_SAMPLES = (
    256  # looks at the invariants over a run: enough to catch an oscillation, cheap beside the run
)
PROGRESS_EVERY = 0.2  # [s] wall
PUBLISH_RATE = 100.0  # [Hz] unless one is given
NEAR = 1e-6  # [-] of a duration: rounded by less to whole ticks it is not worth a word


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        'scene', help='scene file (YAML), URDF file of one link, or the name of a shipped scene'
    )
    parser.add_argument(
        '-o', '--output', type=Path, required=True, metavar='BAG', help='bag to write'
    )
    parser.add_argument(
        '--duration',
        type=float,
        default=10.0,
        metavar='S',
        help='simulated time [s], to the nearest whole tick, default 10',
    )
    parser.add_argument(
        '--dt', type=float, metavar='S', help='tick length [s], default: of the scene'
    )
    parser.add_argument(
        '--integrator',
        metavar='NAME',
        help='default: of the scene; auto: the cheapest that meets a tolerance',
    )
    parser.add_argument(
        '--commands',
        type=Path,
        metavar='CSV',
        help='timed commands: columns time, body, kind (force, torque, wrench, impulse, '
        'set_state), frame (world, body, or one of the body), fx … tz, of set_state x … wz',
    )
    parser.add_argument(
        '--command-timeout',
        type=float,
        default=0.0,
        metavar='S',
        help='how long a command holds [s], default 0: until changed',
    )
    parser.add_argument(
        '--publish-rate',
        type=float,
        metavar='HZ',
        help=f'recorded states per second, default {PUBLISH_RATE:g}; rounded to whole ticks',
    )
    parser.add_argument(
        '--estimate-error',
        action='store_true',
        help='let two finer runs go along and report how wrong the run is; six times the cost, on '
        'stiff scenes more',
    )
    parser.add_argument(
        '--contacts',
        action='store_true',
        help='record where bodies touch and with what force, on <body>/contacts',
    )
    viewing_arguments.add(parser)
    parser.add_argument('--json', action='store_true', help='print one JSON object')


def run(arguments: argparse.Namespace) -> int:
    """
    Simulate; exit code 0, 1 for a run that diverged, or that of the signal that stopped it; the
    bag is closed and can be replayed.
    """
    STOP.stage = 'while the scene was read; nothing is recorded'
    scene = _load_scene(find_scene(arguments.scene), quiet=arguments.json)
    names = viewing_arguments.names_of(arguments, scene)
    need_numbers(scene.name, names)
    warn_if_plain(warning_printer('simulate'))
    rate = PUBLISH_RATE if arguments.publish_rate is None else arguments.publish_rate
    with _Note('reading the scene', shown=not arguments.json) as note:
        dt = arguments.dt
        if dt is None:
            dt = longer_dt(
                scene,
                arguments.integrator,
                duration=arguments.duration,
                rate_hz=rate,
                timeout=arguments.command_timeout,
                commands=arguments.commands,
            )
        simulation = simulation_of(
            scene, integrator=arguments.integrator, dt=dt, progress=note.show
        )
    ticks = whole_ticks(arguments.duration, simulation)
    if arguments.commands:
        _say_timeout(arguments.command_timeout, simulation)
    timed = (
        read_csv(arguments.commands, scene, dt_ns=simulation.dt_ns, commanded=names)
        if arguments.commands
        else []
    )
    every = publish_every(rate, simulation.dt_ns)
    settings = RunSettings(
        command_timeout_ns=_nanoseconds(arguments.command_timeout),
        publish_every=every,
        estimate_error=arguments.estimate_error,
        publish_contacts=arguments.contacts,
        view=viewing_arguments.settings_of(arguments, publish_every=every, dt_ns=simulation.dt_ns),
    )
    check_new(arguments.output)
    STOP.stage = 'while compiling; nothing is recorded'
    compiled = time.monotonic()
    turning = any(command.frame_id == command.body for _, command in timed)
    with CompileNote(expected_functions(scene), shown=not arguments.json) as compiling:
        simulation.prepare(commands_in_body_axes=turning, progress=compiling.compiling)
    compiled = time.monotonic() - compiled
    whole = Run(simulation, settings, warn=warning_printer('simulate'))
    asked = arguments.publish_rate is not None or arguments.dt is not None
    rounded = rate_note(rate, simulation.dt_ns) if asked else None
    idle = _idle_note(arguments.commands, timed, ticks, simulation.dt_ns)
    for note in (rounded, start_alone_note(every, ticks, simulation.dt_ns), idle):
        if note is not None:
            whole.add_warning(note)
    STOP.keep()
    return _record(whole, arguments, ticks, timed, compiled=compiled)


def _record(
    whole: Run,
    arguments: argparse.Namespace,
    ticks: int,
    timed: list[tuple[int, Command]],
    *,
    compiled: float,
) -> int:
    """Run to the end, or to a signal, and close the bag whatever comes; return the exit code."""
    simulation = whole.simulation
    every = whole.settings.publish_every
    look_every = every * max(1, ticks // every // DRIFT_SAMPLES)
    recorder = RunRecorder(whole, arguments.output, look_every=look_every)
    started = time.monotonic()
    reason, code, failed = 'error', 0, ''
    try:
        _advance(whole, recorder, ticks, timed, quiet=arguments.json)
        reason = 'duration' if simulation.tick == ticks else 'signal'
    except SimulationDiverged as diverged:
        reason, code, failed = 'diverged', 1, f'rigid_body_sim simulate: error: {diverged}'
    finally:
        try:
            recorder.close(reason)
        except RunError:
            if failed:
                say(failed)
            raise
    if failed:
        say(f'{failed}; the bag holds the ticks before')
    wall = time.monotonic() - started
    if reason == 'signal':
        code = STOP.exit_code
        say(
            f'rigid_body_sim simulate: stopped by {STOP.name} at {simulation.time:.9g} s of '
            f'{ticks * simulation.dt:.9g} s; the bag is whole up to there'
        )
    with suppress(OSError) if reason == 'signal' else nullcontext():  # the terminal may be gone
        _report(whole, arguments, wall=wall, compiled=compiled, reason=reason)
        sys.stdout.flush()
    return code


def _load_scene(path: Path, *, quiet: bool) -> Scene:
    """Read the scene; around a lone URDF file say what was assumed."""
    scene = load_scene(path)
    if path.suffix.lower() == URDF_SUFFIX and not quiet:
        x, y, z = scene.gravity
        print(
            f'{path}: the body {scene.bodies[0].name} alone, dt {scene.dt_ns * 1e-9:g} s, gravity '
            f'({x:g}, {y:g}, {z:g}) m/s^2, no contact; a scene that names it may say otherwise'
        )
    return scene


def _advance(
    whole: Run, recorder: RunRecorder, ticks: int, timed: list[tuple[int, Command]], *, quiet: bool
) -> None:
    """Follow the run up to `ticks`, or to a signal."""
    simulation = whole.simulation
    commands = {
        tick: [command for _, command in group]
        for tick, group in groupby(timed, lambda item: item[0])
    }
    due = 0.0
    with progress_bar(total=ticks, unit='tick', unit_scale=True, shown=not quiet) as bar:
        for tick, output in whole.follow(commands, ticks):
            recorder.record(output, tick=tick)
            if STOP.number:
                return
            if not bar.disable and time.monotonic() > due:
                with suppress(OSError):  # a terminal that hung up; its signal is on the way
                    bar.update(simulation.tick - bar.n)
                due = time.monotonic() + PROGRESS_EVERY


def whole_ticks(duration: float, simulation: Simulation) -> int:
    """
    Count the ticks of a duration [s], the nearest whole number, and say so where it is rounded.

    Raises UserError unless it is positive, at least one tick, and what a bag can count.
    """
    if not math.isfinite(duration) or duration <= 0:
        raise UserError(f'--duration {duration:g} s; allowed: a positive number of seconds')
    ticks = round(min(duration, 2.0**31) * 1e9 / simulation.dt_ns)
    if ticks < 1:
        raise UserError(
            f'--duration {duration:g} s is less than one tick of {simulation.dt:g} s; make it '
            'longer'
        )
    if ticks >= 2**32 or duration >= 2**31:
        raise UserError(
            f'--duration {duration:g} s: a bag counts less than 2^32 ticks and 2^31 s; make it '
            'shorter'
        )
    whole = ticks * simulation.dt
    if abs(whole - duration) > NEAR * duration:
        say(
            f'rigid_body_sim simulate: --duration {duration:g} s is no whole number of ticks of '
            f'{simulation.dt:g} s; the run takes {ticks} of them, {whole:.9g} s'
        )
    return ticks


def _say_timeout(timeout: float, simulation: Simulation) -> None:
    """Say where a command acts longer than its timeout [s], as it ends with a tick."""
    ticks = -(-round(timeout * 1e9) // simulation.dt_ns)
    whole = ticks * simulation.dt
    if timeout and abs(whole - timeout) > NEAR * timeout:
        say(
            f'rigid_body_sim simulate: --command-timeout {timeout:g} s is no whole number of '
            f'ticks of {simulation.dt:g} s; a command acts for {ticks} of them, {whole:.9g} s'
        )


def _idle_note(
    path: Path | None, timed: list[tuple[int, Command]], ticks: int, dt_ns: int
) -> str | None:
    """
    Say in a line that a file of commands holds none, or some that come too late; None: all act.

    The bag keeps the line, so it names the file, and not the folder in which it lies.
    """
    if path is None:
        return None
    if not timed:
        return (
            f'{path.name} of --commands holds a header and no command: the run goes without; '
            'give rows, or leave --commands out'
        )
    late = [command for tick, command in timed if tick >= ticks]
    if not late:
        return None
    first = min(command.stamp_ns for command in late)
    return (
        f'{path.name} of --commands: {len(late)} of {len(timed)} commands never act, the first at '
        f'{first * 1e-9:.9g} s: the last tick of the run begins at '
        f'{(ticks - 1) * dt_ns * 1e-9:.9g} s; make --duration longer, or their times earlier'
    )


def _nanoseconds(seconds: float) -> int:
    problem = timeout_problem('--command-timeout', seconds, never='until changed')
    if problem is not None:
        raise UserError(problem)
    return round(seconds * 1e9)


class _Note:
    """One line on a terminal that says what is waited for, and goes away."""

    def __init__(self, text: str, *, shown: bool) -> None:
        self._bar = progress_bar(total=0, bar_format='{desc}', shown=shown)
        self.show(text)

    def show(self, text: str) -> None:
        self._bar.set_description_str(f'{text} …')

    def __enter__(self) -> _Note:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._bar.close()


def _report(
    whole: Run, arguments: argparse.Namespace, *, wall: float, compiled: float, reason: str
) -> None:
    simulation = whole.simulation
    drift = whole.sample_drift()
    balance = whole.energy_balance()
    bodies = len(simulation.scene.bodies)
    body_ticks = max(1, simulation.tick * bodies)
    result = {
        'bag': str(arguments.output),
        'scene': simulation.scene.name,
        'integrator': simulation.integrator.name,
        'integrator_options': dict(simulation.integrator.settings),
        'dt': simulation.dt,
        'bodies': bodies,
        'ticks': simulation.tick,
        'publish_rate': 1e9 / (whole.settings.publish_every * simulation.dt_ns),
        'sim_time': simulation.time,
        'wall_time': wall,
        'compile_time': compiled,
        'ns_per_body_tick': wall / body_ticks * 1e9,
        'energy_drift': _finite(drift.energy),
        'momentum_drift': _finite(drift.momentum),
        'angular_momentum_drift': _finite(drift.angular_momentum),
        'energy_rise': _finite(drift.energy_rise),
        'energy_balance': as_numbers(balance),
        'kept': [asdict(law) | {'drift': _finite(law.drift)} for law in whole.kept()],
        'deepest_gap': whole.deepest_gap(),
        'orientation_drift': _finite(whole.orientation_drift()),
        'end_reason': reason,
        'warnings': whole.warnings,
    }
    result |= choices.facts(simulation)
    estimate = whole.error_estimate()
    if arguments.estimate_error:
        result['error_estimate'] = estimate.figures() if estimate is not None else None
    if arguments.json:
        print(json.dumps(result))
        return
    print(
        f'{result["scene"]}: {simulation.time:g} s of {bodies} bod{"y" if bodies == 1 else "ies"} '
        f'with {simulation.integrator.name}, {simulation.tick} ticks in {wall:.2f} s '
        f'({pace_text(simulation.time, wall)})'
    )
    for line in choices.summary(simulation):
        print(f'  auto: {line}')
    print(f'  {balance_line(balance)}')
    if drift.energy is not None:
        print(f'  energy: {drift_text(drift.energy)}')
    for line in momentum_lines(drift, whole.kept()):
        print(f'  {line}')
    if result['orientation_drift'] is not None:
        print(f'  drift of the matrices: |R^T R - 1| up to {result["orientation_drift"]:.1e}')
    if whole.has_contact:
        gap = result['deepest_gap']
        for line in contact_lines(result['energy_rise'], drift.energy_rise_joules, gap):
            print(f'  {line}')
    if estimate is not None:
        print(
            f'  estimated error: position {estimate.position:.1e} m, angle {estimate.angle:.1e} '
            'rad, '
            f'velocity {estimate.velocity:.1e} m/s, angular velocity '
            f'{estimate.angular_velocity:.1e} rad/s'
            + (f'; not reliable: {estimate.doubt}' if estimate.doubt else '')
        )
    elif arguments.estimate_error:
        print('  estimated error: none, a finer run beside this one left the finite numbers')
    print(f'  bag: {arguments.output}')


def _finite(drift: float | None) -> float | None:
    """JSON knows neither infinity nor NaN: a drift beyond the numbers is no number."""
    return drift if drift is not None and math.isfinite(drift) else None
