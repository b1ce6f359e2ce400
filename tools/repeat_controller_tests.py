# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Runs the examples of tests of controllers over and over beside busy processes, and says how often
they passed and how long they took.

    python tools/repeat_controller_tests.py --times 20 --busy 4
"""

import argparse
import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
PLUGINS = ('-p', 'rigid_body_sim.testing.plugin', '-p', 'no:cacheprovider')


def spin() -> None:
    """Keep a core busy, until the parent is gone."""
    parent = os.getppid()
    while os.getppid() == parent:
        sum(range(1_000_000))


def run_once(workers: int) -> tuple[bool, float, str]:
    """Return whether all passed, the wall time [s], and what pytest wrote."""
    parallel = ('-p', 'xdist', '-n', str(workers)) if workers else ()
    begin = time.monotonic()
    run = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', *PLUGINS, *parallel, 'examples/controller_tests'],
        cwd=ROOT,
        env={**os.environ, 'PYTEST_DISABLE_PLUGIN_AUTOLOAD': '1'},
        capture_output=True,
        text=True,
        check=False,
    )
    return run.returncode == 0, time.monotonic() - begin, run.stdout + run.stderr


def main() -> int:
    """1 unless every repetition passed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--times', type=int, default=20)
    parser.add_argument('--busy', type=int, default=4, help='busy processes beside')
    parser.add_argument('--workers', type=int, default=0, help='of pytest; 0: none, one process')
    given = parser.parse_args()
    crowd = [multiprocessing.Process(target=spin, daemon=True) for _ in range(given.busy)]
    for one in crowd:
        one.start()
    results = []
    for number in range(1, given.times + 1):
        passed, seconds, said = run_once(given.workers)
        results.append((passed, seconds))
        load = os.getloadavg()[0]
        print(f'{number}: {"passed" if passed else "FAILED"} in {seconds:.1f} s, load {load:.1f}')
        if not passed:
            print(said)
    for one in crowd:
        one.terminate()
    times = sorted(seconds for _, seconds in results)
    green = sum(passed for passed, _ in results)
    print(f'{green} of {len(results)} passed; {times[0]:.1f} to {times[-1]:.1f} s each')
    return int(green != len(results))


if __name__ == '__main__':
    sys.exit(main())
