# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Stop runs at random moments by one or two signals, or kill them, and see what is left.

    python tools/interrupt_runs.py --trials 200 --seed 7
    python tools/interrupt_runs.py --trials 200 --seed 7 --kill
    python tools/interrupt_runs.py --trials 50 --node [--kill]
    python tools/interrupt_runs.py --trials 60 --verbs

After a signal: the exit code is that of a signal sent (or 0: it came after the end), nothing looks
like a traceback, no bag or a whole one that `bag check` and `replay` like. After SIGKILL: `bag
recover` and `replay` like what is left, and what is lost was handed to the recorder less than half
a second (wall) before; of the node, whose recorder nobody can ask, the file was written to less
than half a second before. --verbs stops `replay`, `sweep`, `report` in place of runs: exit code,
no traceback, and no file that looks done and is not. Most runs are forked from this process, which
has everything imported; every `--fresh`-th is a process of its own, so that signals fall into its
start too.

Exit code 1 if anything was otherwise; the folders of such trials are kept and named.
"""

from __future__ import annotations

import argparse
import atexit
import contextlib
import faulthandler
import io
import itertools
import json
import mmap
import os
import random
import shutil
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter, defaultdict
from pathlib import Path
from typing import NamedTuple

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim import __main__ as verbs
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.recovery import recover
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.scene.shipped_scenes import find_scene

HANGING = 60.0  # [s] after the signal
PROMISED = 0.5  # [s] of wall time that a kill may cost
LOG = struct.Struct('<dq')  # when the recorder was given something, up to which tick
LOG_ROOM = 1 << 20  # entries, the oldest overwritten
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
CODES = {number: 128 + number for number in SIGNALS}
SUSPICIOUS = ('Traceback', 'Exception ignored', 'Fatal Python error', 'Segmentation')

# elastic, so that impacts never end: ten and more in each message that is written
IMPACTS = """version: 1
name: impacts
dt: 0.004
contact: {mode: event}
bodies:
  - {name: floor, restitution: 1.0, shape: {type: plane, normal: [0, 0, 1]}}
  - {name: roof, restitution: 1.0, shape: {type: plane, normal: [0, 0, -1], offset: -0.3}}
  - name: ball
    mass: 1.0
    restitution: 1.0
    shape: {type: sphere, radius: 0.05}
    initial: {position: [0, 0, 0.1], velocity: [0, 0, -20]}
    repeat: {count: [3, 1, 1], spacing: [0.5, 0, 0]}
"""
WRITTEN = {'impacts': IMPACTS}  # scenes that are not shipped
FAST = {
    'two_bodies': ['two_bodies', '--duration', '1e6'],
    'two_bodies at 1 Hz': ['two_bodies', '--duration', '1e6', '--publish-rate', '1'],
    'a day between states': ['oscillator', '--duration', '2e6', '--publish-rate', '1e-5'],
    'ten_bodies': ['ten_bodies', '--duration', '1e5', '--publish-rate', '1000'],
    'stack': ['stack', '--duration', '1e5'],
    'a short run': ['two_bodies', '--duration', '2'],
    'impacts': ['impacts', '--duration', '1e6'],
}
SLOW = {
    'scipy_radau': ['two_bodies', '--integrator', 'scipy_radau', '--publish-rate', '10',
                    '--duration', '1000'],
    'scipy_dop853': ['two_bodies', '--integrator', 'scipy_dop853', '--duration', '1000'],
}  # fmt: skip
AUTO = {'auto': ['two_bodies', '--integrator', 'auto', '--duration', '1e5']}
NODE = {
    'node': ['two_bodies', 'real_time_factor:=1.0'],
    'node, as fast as it can': ['two_bodies', 'real_time_factor:=0.0'],
    'node, impacts': ['impacts', 'real_time_factor:=1.0'],
}
SWEEP = ('two_bodies', '--vary', 'box.mass=uniform:1:2', '--seed', '3', '--duration', '100')
VERBS = {
    'replay': ['replay', 'long'],
    'sweep': ['sweep', *SWEEP, '--runs', '1000', '-j', '1'],
    'sweep, two workers': ['sweep', *SWEEP, '--runs', '1000', '-j', '2'],
    'report': ['report', '--problems', 'oscillator', '--integrators', 'dmv6', 'rk4', 'rk8'],
    'simulate with an estimate': [
        'simulate',
        'two_bodies',
        '--estimate-error',
        '--duration',
        '1e6',
    ],
}
LONG = 3000  # [s] of the bag that is replayed


class Outcome(NamedTuple):
    """What one trial showed; loss [s]: of a killed run."""

    code: int
    bag: str
    problems: list[str]
    reaction: float
    loss: float


def scene_of(name: str) -> str:
    """Give what the verbs take for a scene: its name, or the file that is written for it."""
    if name not in WRITTEN:
        return name
    file = Path(tempfile.gettempdir()) / f'interrupt_runs_{os.getpid()}_{name}.yaml'
    if not file.exists():
        file.write_text(WRITTEN[name])
        atexit.register(file.unlink, missing_ok=True)
    return str(file)


def words_of(case: str, bag: Path, long: Path | None) -> list[str]:
    """Give the command line of a case."""
    if case in VERBS:
        verb, *words = VERBS[case]
        output = [] if verb == 'replay' else ['-o', str(bag)]
        if verb == 'sweep':
            output[-1] += '.parquet'
        return [verb, *(str(long) if word == 'long' else word for word in words), *output]
    if case in NODE:
        scene, factor = NODE[case]
        words = [f'scene:={scene_of(scene)}', factor, 'record:=true', f'record_path:={bag}']
        return ['sim_node', '--ros-args', *(w for word in words for w in ('-p', word))]
    scene, *words = {**FAST, **SLOW, **AUTO}[case]
    return ['simulate', scene_of(scene), *words, '-o', str(bag)]


def warm_up(case: str) -> None:
    """Compile what a case needs: otherwise every signal comes while that is done."""
    if case in VERBS:
        return
    scene, *options = NODE[case] if case in NODE else {**FAST, **SLOW, **AUTO}[case]
    chosen = dict(itertools.pairwise(options)).get('--integrator')
    simulation = Simulation(load_scene(find_scene(scene_of(scene))), integrator=chosen)
    simulation.prepare(commands_in_body_axes=case in NODE)


def watched(log: mmap.mmap) -> None:
    """Let the recorder of this process note when it is given what."""
    record, count = RunRecorder.record, 0

    def noting(self, output, *, tick):
        nonlocal count
        record(self, output, tick=tick)
        if output.batches and output.batches[-1].tick is not None:
            LOG.pack_into(log, LOG.size * (count % LOG_ROOM), time.monotonic(), output.tick)
            count += 1

    RunRecorder.record = noting


def begin(words: list[str], said: Path, log: mmap.mmap | None, *, fresh: bool) -> int:
    """Start a run in a process of its own; return its number."""
    if fresh:
        with said.open('wb') as stream:
            return subprocess.Popen(
                [sys.executable, '-m', 'rigid_body_sim', *words],
                stdin=subprocess.DEVNULL, stdout=stream, stderr=stream, start_new_session=True,
                preexec_fn=lambda: [signal.signal(n, signal.SIG_DFL) for n in SIGNALS],  # noqa: PLW1509
            ).pid  # fmt: skip
    sys.stdout.flush()
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)  # the child hears them when it listens
    child = os.fork()
    if child:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        return child
    try:
        os.setsid()
        stream = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(stream, 1)
        os.dup2(stream, 2)
        for number in SIGNALS:  # which a parent in the background ignores
            signal.signal(number, signal.SIG_DFL)
        faulthandler.register(signal.SIGUSR1)
        verbs.STOP.listen(owns_process=True)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        if log is not None:
            watched(log)
        code = verbs.main(words)
        verbs.STOP.ignore()
        sys.stdout.flush()
    except SystemExit as end:
        code = int(end.code or 0)
    except BaseException:
        import traceback

        traceback.print_exc()
        code = 70
    os._exit(code)


def wait(process: int, seconds: float) -> int | None:
    """Wait for the end of a process; its exit code, minus the signal that killed it, or None."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(process, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    return None


def quiet(*words: str) -> int:
    """Call a verb here; its exit code."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        return verbs.main(list(words))


def seen_in(bag: Path, *, killed: bool) -> tuple[str, list[str], int]:
    """Look at what is left of a bag; say what it is, what is wrong, and its last tick."""
    if not bag.exists():
        return 'none', [], -1
    if (bag / 'metadata.yaml').exists():
        whole = Bag(bag)
        problems = (
            [f'check {quiet("bag", "check", str(bag))}'] if quiet('bag', 'check', str(bag)) else []
        )
        kind, looked_at = 'whole', bag
    else:
        problems = [] if killed else ['unfinished after a signal']
        looked_at = bag.with_name('saved')
        try:
            recover(bag, looked_at)
        except (RunError, UserError) as error:
            young = any(word in str(error) for word in ('nothing to save', 'holds 0 .mcap'))
            return 'too young', [] if young else [str(error)], -1
        kind, whole = 'saved', Bag(looked_at)
    last = whole.ending['last_tick'] if whole.ending else whole.recovered['last_tick']
    if code := quiet('replay', str(looked_at)):
        problems.append(f'replay {code}')
    return kind, problems, int(last)


def left_by(case: str, bag: Path, code: int) -> list[str]:
    """Say what is wrong with the files of a verb that was stopped."""
    problems = []
    table, page, results = bag.with_name('bag.parquet'), bag / 'report.html', bag / 'report.json'
    if case.startswith('sweep'):
        if code == 0 and not table.exists():
            problems.append('done without a table')
        if table.exists():
            import pandas

            rows = len(pandas.read_parquet(table))
            problems += [] if rows == 1000 else [f'a table of {rows} rows']
    if page.exists() and not page.read_text().rstrip().endswith('</html>'):
        problems.append('half a page')
    if results.exists():
        json.loads(results.read_text())
    if code == 0 and case == 'report' and not page.exists():
        problems.append('done without a page')
    return problems


def lost(log: mmap.mmap, last_tick: int, killed: float) -> float:
    """Tell how long before its end the run had handed over the first state that is lost [s]."""
    size = LOG.size * LOG_ROOM
    entries = (LOG.unpack_from(log, place) for place in range(0, size, LOG.size))
    first = killed
    for moment, tick in entries:
        if moment == 0.0:
            break
        if tick > last_tick:
            first = min(first, moment)
    return max(0.0, killed - first)


def trial(
    case: str, chance: random.Random, folder: Path, options: argparse.Namespace, long: Path | None
) -> Outcome:
    """Do one."""
    bag, said = folder / 'bag', folder / 'said'
    said.touch()
    fresh = chance.random() * options.fresh < 1.0 or case == 'sweep, two workers'
    log = None
    if options.kill and not fresh:
        log = mmap.mmap(-1, LOG.size * LOG_ROOM)
    late = 8.0 if fresh else 3.0
    process = begin(words_of(case, bag, long), said, log, fresh=fresh)
    time.sleep(chance.uniform(0.0, late) if chance.random() < 0.8 else chance.uniform(0.0, 0.3))
    numbers = [signal.SIGKILL] if options.kill else [chance.choice(SIGNALS)]
    if not options.kill and chance.random() < 0.5:
        numbers += [chance.choice(SIGNALS) for _ in range(chance.choice((1, 1, 2)))]
    sent = time.monotonic()
    for place, number in enumerate(numbers):
        if place:
            time.sleep(min(0.5, chance.expovariate(1 / 0.02)))
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, number)
    code = wait(process, HANGING)
    reaction = time.monotonic() - sent
    problems = []
    if code is None:
        problems.append('hangs')
        if not fresh:
            os.kill(process, signal.SIGUSR1)  # says where
            time.sleep(1.0)
        os.kill(process, signal.SIGKILL)
        wait(process, HANGING)
        code = -9
    # of signals that arrive together the process is told in the order of their numbers
    codes = set() if case in NODE else {CODES[number] for number in numbers if number in CODES}
    allowed = {0, -9} if options.kill else {0, *codes}
    text = said.read_text(errors='replace')
    unborn = fresh or -code in numbers  # Python itself had not begun, or the child to listen
    if unborn and not list(folder.glob('bag*')) and 'rigid_body_sim' not in text:
        return Outcome(0, 'of nobody', problems, reaction, 0.0)
    if code not in allowed:
        problems.append(f'exit code {code}')
    problems += [f'said {word}' for word in SUSPICIOUS if word in text]
    if case in VERBS and VERBS[case][0] != 'simulate':
        problems += left_by(case, bag, code)
        return Outcome(code, 'of no run', problems, reaction, 0.0)
    written = max((file.stat().st_mtime for file in bag.glob('*.mcap')), default=0.0)
    kind, found, last = seen_in(bag, killed=options.kill)
    loss = 0.0
    if case in NODE and code == -9 and kind == 'saved':
        loss = max(0.0, time.time() - (time.monotonic() - sent) - written)
        if loss > PROMISED:
            found.append(f'written {loss:.2f} s before')
    if log is not None and code == -9:
        loss = lost(log, last, sent)
        if loss > PROMISED:
            found.append(f'lost {loss:.2f} s')
    return Outcome(code, kind, problems + found, reaction, loss)


def table(outcomes: dict[str, list[Outcome]]) -> str:
    """Put the figures in rows."""
    rows = [
        '| case | trials | exit codes | bags | wrong | reaction [s] median, largest '
        '| lost [s] median, largest |',
        '|---|---|---|---|---|---|---|',
    ]
    for case, found in outcomes.items():
        codes, bags = Counter(o.code for o in found), Counter(o.bag for o in found)
        reactions, losses = [o.reaction for o in found], [o.loss for o in found]
        rows.append(
            f'| {case} | {len(found)} | {", ".join(f"{k}: {n}" for k, n in codes.most_common())} '
            f'| {", ".join(f"{n} {k}" for k, n in bags.most_common())} '
            f'| {sum(bool(o.problems) for o in found)} '
            f'| {statistics.median(reactions):.2f}, {max(reactions):.2f} '
            f'| {statistics.median(losses):.2f}, {max(losses):.2f} |'
        )
    return '\n'.join(rows)


def main() -> int:
    """Try as often as asked for; print a table."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--trials', type=int, default=200)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--kill', action='store_true', help='SIGKILL in place of signals')
    parser.add_argument('--node', action='store_true', help='the node in place of simulate')
    parser.add_argument('--verbs', action='store_true', help='other verbs in place of simulate')
    parser.add_argument('--fresh', type=int, default=8, help='every so manieth: a new process')
    parser.add_argument('--cases', nargs='+', help='only these')
    options = parser.parse_args()
    cases = [*NODE] if options.node else [*FAST, *SLOW, *([] if options.kill else AUTO)]
    cases = [*VERBS] if options.verbs else cases
    cases = options.cases or cases
    if options.node:
        options.fresh = 1  # middleware does not like to be forked
    warnings.filterwarnings('ignore', message='.*use of fork')  # its thread is that of a bar
    chance = random.Random(options.seed)
    outcomes: dict[str, list[Outcome]] = defaultdict(list)
    wrong = 0
    long = None
    for case in cases:
        warm_up(case)
    if options.verbs:
        long = Path(tempfile.mkdtemp()) / 'long'
        atexit.register(shutil.rmtree, long.parent, ignore_errors=True)
        quiet('simulate', 'two_bodies', '--duration', str(LONG), '-o', str(long))
    for number in range(options.trials):
        case = cases[number % len(cases)]
        folder = Path(tempfile.mkdtemp(prefix=f'interrupt_{number}_'))
        outcome = trial(case, chance, folder, options, long)
        outcomes[case].append(outcome)
        if outcome.problems:
            wrong += 1
            print(f'{folder}: {case}: {"; ".join(outcome.problems)}', flush=True)
        else:
            shutil.rmtree(folder)
    print(table(outcomes))
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
