# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How long a user waits: `simulate` on a scene of one body, with a cold and a warm kernel cache, and
the node until ready.

    python benchmark/start_up.py [--repeat 5]
"""

from __future__ import annotations

import argparse
import os
import selectors
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

VERB = [sys.executable, '-m', 'rigid_body_sim']


def simulate(folder: Path, name: str, cache: Path) -> float:
    """Wall time of one second of free fall [s], from the start of the process to its end."""
    begin = time.perf_counter()
    subprocess.run(
        [*VERB, 'simulate', 'free_fall', '-o', str(folder / name), '--duration', '1', '--json'],
        env=os.environ | {'RIGID_BODY_SIM_CACHE': str(cache)},
        check=True,
        capture_output=True,
    )
    return time.perf_counter() - begin


def node_ready(cache: Path) -> float:
    """Wall time from the start of the node to its line that says ready [s]."""
    begin = time.perf_counter()
    node = subprocess.Popen(
        [*VERB, 'sim_node', '--ros-args', '-p', 'scene:=free_fall'],
        env=os.environ | {'RIGID_BODY_SIM_CACHE': str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        bufsize=1,
    )
    assert node.stdout is not None
    selector = selectors.DefaultSelector()
    selector.register(node.stdout, selectors.EVENT_READ)
    while selector.select(timeout=60):
        line = node.stdout.readline()
        if 'ready:' in line or not line:
            break
    waited = time.perf_counter() - begin
    node.send_signal(signal.SIGINT)
    node.wait(timeout=20)
    return waited


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--repeat', type=int, default=5)
    repeat = parser.parse_args().repeat
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cache = folder / 'cache'
        print(f'simulate, one body, cold cache: {simulate(folder, "cold", cache):6.2f} s')
        warm = [simulate(folder, f'warm_{i}', cache) for i in range(repeat)]
        print(
            f'simulate, one body, warm cache: {statistics.median(warm):6.2f} s  '
            f'({min(warm):.2f}…{max(warm):.2f}), limit 2 s'
        )
        print(f'sim_node until ready, cold    : {node_ready(cache):6.2f} s')
        ready = [node_ready(cache) for _ in range(repeat)]
        print(
            f'sim_node until ready, warm    : {statistics.median(ready):6.2f} s  '
            f'({min(ready):.2f}…{max(ready):.2f}), limit 3 s'
        )


if __name__ == '__main__':
    main()
