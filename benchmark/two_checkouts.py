# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`make bench`: has anything become slower? This checkout beside another, in one run.

    python benchmark/two_checkouts.py [OTHER] [--only CASE …] [--rounds 7] [--visits 3] [--cold]

        OTHER : a revision of this repository, or the folder of another checkout. Default: HEAD
                where something is not committed yet, else the commit before

A revision is checked out into a temporary folder; each checkout has a process and a kernel cache
of its own, and all of it goes at the end. The two take turns, the first of a round being the one
or the other, so that both meet the same weather on the machine; the clock is processor time. Both
do the same work: where the bits agree, the ticks are the same.

What counts is the ratio this / other within a round. Two processes of the same program differ by a
few per cent for their whole life, by where their memory happens to lie; so the rounds are spread
over visits, each with new processes. A case is slower where

    the median of all ratios is above 1 + TOLERATED,
    its lower bound (order statistics, 99 % of equal checkouts pass) is above 1, and
    the median of every visit is above 1,

and all of this is so again in a second opinion. Exit code 0: nothing is slower; 1: what is said to
be; 2: no comparison could be made. `--cold` measures from nothing to the first tick, caches empty.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bench_cases import CASES

ROOT = Path(__file__).resolve().parents[1]
TOLERATED = 0.03  # [-] slower by less is nobody's business
CHANCE = 0.005  # [-] that the lower bound lies above the median of equal checkouts
LASTS = 0.04  # [s] a turn: far above the resolution of the clock, below a second for all cases
COLD = ('one free body', 'stack of ten boxes')
ROUNDS, VISITS = 7, 3


class NoComparison(Exception):
    """The two cannot be compared; the text says why."""


def git(*words: str, folder: Path = ROOT) -> str:
    """Ask git; NoComparison with its own words where it refuses."""
    try:
        done = subprocess.run(
            ['git', *words], cwd=folder, capture_output=True, text=True, check=False
        )
    except OSError as error:
        raise NoComparison(f'git: {error}') from None
    if done.returncode:
        raise NoComparison(f'git {words[0]}: {done.stderr.strip()}')
    return done.stdout.strip()


def default_revision(folder: Path = ROOT) -> str:
    """HEAD where the work tree differs from it, else the commit before."""
    changed = git('status', '--porcelain', '--untracked-files=no', folder=folder)
    return 'HEAD' if changed else 'HEAD~1'


@contextmanager
def checked_out(other: str, folder: Path = ROOT) -> Iterator[tuple[Path, str]]:
    """Give the folder of a revision, or of a checkout that is there, and a name for it."""
    if Path(other).is_dir():
        yield Path(other).resolve(), str(other)
        return
    commit = git('rev-parse', '--verify', f'{other}^{{commit}}', folder=folder)
    with tempfile.TemporaryDirectory(prefix='bench_') as temporary:
        place = Path(temporary) / 'checkout'
        git('worktree', 'prune', folder=folder)  # of a run that was killed
        git('worktree', 'add', '--detach', str(place), commit, folder=folder)
        try:
            yield place, f'{other} ({git("log", "-1", "--format=%h %s", commit, folder=folder)})'
        finally:
            git('worktree', 'remove', '--force', str(place), folder=folder)


class Checkout:
    """
    One checkout, in a process of its own.

    cache : folder of its kernels
    """

    def __init__(self, path: Path, cache: Path) -> None:
        cache.mkdir(parents=True, exist_ok=True)
        variables = {'PYTHONPATH': path, 'RIGID_BODY_SIM_CACHE': cache, 'NUMBA_CACHE_DIR': cache}
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name('bench_cases.py'))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=cache,  # not the folder of another checkout
            env=os.environ
            | {key: str(value) for key, value in variables.items()}
            | {'BENCH_FOLDER': str(cache), 'OMP_NUM_THREADS': '1', 'PYTHONHASHSEED': '0'}
            | {'RIGID_BODY_SIM_THREADS': '1'},  # processor time is measured, of what all do alone
        )

    def __enter__(self) -> Checkout:
        return self

    def __exit__(self, *_: object) -> None:
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()

    def seconds(self, case: str, count: int) -> float:
        """Processor time of the work, so many times over [s]; NoComparison where it fails."""
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps([case, count]) + '\n')
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except OSError:
            line = ''
        answer = json.loads(line) if line else 'its process ended'
        if isinstance(answer, str):
            raise NoComparison(answer)
        return answer


@dataclass
class Measured:
    """
    What was measured of one case.

    count  : times that the work is done in a turn
    times  : (other, this) [s], a list for each visit
    reason : why there is no comparison; empty: there is one
    """

    count: int = 1
    times: list[list[tuple[float, float]]] = field(default_factory=list)
    reason: str = ''

    def ratios(self) -> list[list[float]]:
        """This over other, visit by visit."""
        return [[this / other for other, this in pairs] for pairs in self.times]


@dataclass(frozen=True)
class Verdict:
    """
    What the ratios this / other say.

    median, low, high : of all; low and high bound the median of ever so many rounds
    slower, faster    : whether that is more than noise
    """

    median: float
    low: float
    high: float
    slower: bool
    faster: bool


def rank_of_bound(count: int, chance: float = CHANCE) -> int:
    """
    Rank (from 0) of the ratio that lies above the true median with at most that chance.

    Each ratio is above the median or below with a half: P(at most r of n) = sum C(n, i) / 2^n.
    -1: so few ratios bound nothing.
    """
    below, rank = 0.0, -1
    for i in range(count):
        below += math.comb(count, i) / 2.0**count
        if below > chance:
            break
        rank = i
    return rank


def verdict(visits: Sequence[Sequence[float]], *, tolerated: float = TOLERATED) -> Verdict:
    """Judge ratios this / other, visit by visit."""
    ratios = sorted(ratio for visit in visits for ratio in visit)
    median, rank = statistics.median(ratios), rank_of_bound(len(ratios))
    low, high = (ratios[rank], ratios[-1 - rank]) if rank >= 0 else (0.0, math.inf)
    medians = [statistics.median(visit) for visit in visits]
    return Verdict(
        median,
        low,
        high,
        slower=median > 1.0 + tolerated and low > 1.0 and min(medians) > 1.0,
        faster=median < 1.0 / (1.0 + tolerated) and high < 1.0 and max(medians) < 1.0,
    )


def ready(pair: Sequence[Checkout], case: str, measured: Measured) -> None:
    """Compile, and find how often the work makes a turn; both do the same."""
    for checkout in pair:
        checkout.seconds(case, 1)
    while True:
        lasted = [checkout.seconds(case, measured.count) for checkout in pair]
        if measured.times or min(lasted) >= LASTS:
            return
        measured.count *= 2


def show(text: str) -> None:
    """Show progress on a terminal."""
    if sys.stderr.isatty():
        print(f'\r{text:60}', end='\r', file=sys.stderr, flush=True)


def visit(
    paths: Sequence[Path],
    caches: Sequence[Path],
    found: dict[str, Measured],
    rounds: int,
    number: int,
) -> None:
    """Measure all cases with a new process for each checkout."""
    with ExitStack() as stack:
        pair = [stack.enter_context(Checkout(*each)) for each in zip(paths, caches)]
        for case, measured in found.items():
            if measured.reason:
                continue
            show(f'{number + 1}: {case}')
            times: list[tuple[float, float]] = []
            try:
                ready(pair, case, measured)
                for k in range(rounds):
                    turn = [0.0, 0.0]
                    for i in ((0, 1), (1, 0))[k % 2]:
                        turn[i] = pair[i].seconds(case, measured.count)
                    times.append((turn[0], turn[1]))
            except NoComparison as error:
                measured.reason = str(error)
                for each in pair:
                    each.__exit__()
                pair = [stack.enter_context(Checkout(*each)) for each in zip(paths, caches)]
                continue
            measured.times.append(times)


def cold_visit(
    paths: Sequence[Path], caches: Sequence[Path], found: dict[str, Measured], rounds: int
) -> None:
    """Measure from nothing to the first tick, each time with an empty cache."""
    for case, measured in found.items():
        times = []
        for number in range(rounds):
            turn = [0.0, 0.0]
            for i in ((0, 1), (1, 0))[number % 2]:
                with (
                    tempfile.TemporaryDirectory(dir=caches[i].parent) as empty,
                    Checkout(paths[i], Path(empty)) as checkout,
                ):
                    turn[i] = checkout.seconds(case, 1)
            times.append((turn[0], turn[1]))
        measured.times.append(times)


def line_of(case: str, measured: Measured, judged: Verdict | None) -> str:
    """Write what was found of a case."""
    if judged is None:
        return f'{case:30} not compared: {measured.reason}'
    pairs = [pair for visited in measured.times for pair in visited]
    micro = [1e6 * statistics.median(pair[i] for pair in pairs) / measured.count for i in (0, 1)]
    mark = '   SLOWER' if judged.slower else '   faster' if judged.faster else ''
    return (
        f'{case:30}{micro[0]:13.4g}{micro[1]:13.4g}{judged.median:9.3f}'
        f'   {judged.low:.3f} .. {judged.high:.3f}{mark}'
    )


def compare(
    paths: Sequence[Path], cases: Sequence[str], *, rounds: int, visits: int, cold: bool
) -> list[str]:
    """Print a line for each case; give one for each that has become slower."""

    def measured(wanted: Sequence[str]) -> dict[str, Measured]:
        found = {case: Measured() for case in wanted}
        for number in range(visits):
            if cold:
                cold_visit(paths, caches, found, rounds)
            else:
                visit(paths, caches, found, rounds, number)
        return found

    with tempfile.TemporaryDirectory(prefix='bench_cache_') as folder:
        caches = [Path(folder) / 'other', Path(folder) / 'this']
        for cache in caches:
            cache.mkdir()
        found = measured(cases)
        judged = {
            case: None if each.reason else verdict(each.ratios()) for case, each in found.items()
        }
        doubtful = [case for case, each in judged.items() if each is not None and each.slower]
        if doubtful:  # a second opinion
            for case, again in measured(doubtful).items():
                second = verdict(again.ratios())
                if not second.slower:
                    found[case], judged[case] = again, second
    print(f'{"us of processor time":30}{"other":>13}{"this":>13}{"ratio":>9}   99 % of it')
    lines = []
    for case, each in found.items():
        now = judged[case]
        print(line_of(case, each, now))
        if now is not None and now.slower:
            lines.append(
                f'{case}: {100 * (now.median - 1):.1f} % slower '
                f'({100 * (now.low - 1):.1f} to {100 * (now.high - 1):.1f} %)'
            )
    if all(each is None for each in judged.values()):
        raise NoComparison('no case could be measured in both checkouts')
    return lines


def main(words: Sequence[str] | None = None, *, folder: Path = ROOT) -> int:
    """Compare; exit code 1 where something is slower, 2 where nothing could be compared."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('other', nargs='?', help='revision or folder; default: see above')
    parser.add_argument('--only', nargs='+', choices=CASES, metavar='CASE', help=', '.join(CASES))
    parser.add_argument('--rounds', type=int, default=ROUNDS, help='of a visit')
    parser.add_argument('--visits', type=int, default=VISITS, help='with new processes')
    parser.add_argument('--cold', action='store_true', help='from an empty cache; minutes')
    given = parser.parse_args(words)
    cases = given.only or list(COLD if given.cold else CASES)
    if rank_of_bound(given.rounds * given.visits) < 0:
        parser.error('fewer than eight rounds in all can tell nothing from noise')
    try:
        with checked_out(given.other or default_revision(folder), folder) as (other, name):
            print(f'other: {name}')
            slower = compare(
                [other, folder],
                cases,
                rounds=given.rounds,
                visits=given.visits,
                cold=given.cold,
            )
    except NoComparison as error:
        print(f'bench: error: {error}', file=sys.stderr)
        return 2
    for line in slower:
        print(f'bench: slower: {line}', file=sys.stderr)
    return 1 if slower else 0


def _stop(*_: object) -> None:
    """End as an exception does: worktree and caches go."""
    sys.exit(143)


if __name__ == '__main__':
    signal.signal(signal.SIGTERM, _stop)
    sys.exit(main())
