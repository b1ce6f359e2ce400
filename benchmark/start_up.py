# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How long a user waits: `simulate` on a scene of one body, with a cold and a warm kernel cache, and
the node until ready.

    python benchmark/start_up.py [--repeat 5]
    python benchmark/start_up.py --functions     how many numba compiles: a guess of `simulate`
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


COUNTED = ('tumbling_box', 'two_bodies', 'rolling_sphere', 'stack')
COUNT = """
import sys, time
from numba.core import event
class Count(event.Listener):
    ended = []
    def on_start(self, _event): pass
    def on_end(self, _event): self.ended.append(time.process_time())
event.register('numba:compile', Count())
from rigid_body_sim import Simulation, load_scene
begin = time.process_time()
Simulation(load_scene(sys.argv[1])).prepare()
whole, ended = time.process_time() - begin, Count.ended
shares = [(ended[int(share * len(ended))] - begin) / whole for share in (0.25, 0.5, 0.75, 0.9)]
print(f'{len(ended)} functions in {whole:.1f} s; a quarter, a half, three quarters,',
      'nine tenths of them after', ', '.join(f'{share:.2f}' for share in shares), 'of the time')
"""


def functions() -> None:
    """Print how many functions numba compiles for a scene, and how they share the time."""
    for scene in COUNTED:
        with tempfile.TemporaryDirectory() as cache:
            environment = os.environ | {'RIGID_BODY_SIM_CACHE': cache, 'NUMBA_CACHE_DIR': cache}
            print(f'{scene}: ', end='', flush=True)
            subprocess.run([sys.executable, '-c', COUNT, scene], env=environment, check=True)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--repeat', type=int, default=5)
    parser.add_argument('--functions', action='store_true')
    arguments = parser.parse_args()
    if arguments.functions:
        functions()
        return
    repeat = arguments.repeat
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
