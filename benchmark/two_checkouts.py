# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a tick costs in two checkouts, side by side.

    python benchmark/two_checkouts.py OTHER [THIS] [--repeat 9] [--only stack]

One process for each checkout, asked in turn, so that both meet the same weather on the machine;
processor time, medians with extremes, and the ratio of this one to the other. Both do the same
ticks from the same state, so where the bits agree the work does too. `--cold` measures instead
the processor time from nothing to the first tick, with an empty cache.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SCENES = ROOT / 'config' / 'scenes'


def free_bodies(count: int) -> dict[str, Any]:
    """Boxes that tumble, far from one another."""
    body = {
        'name': 'box',
        'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
        'mass': 2.0,
        'initial': {'angular_velocity': [0.3, 1.0, 0.5]},
    }
    if count > 1:
        body['repeat'] = {'count': [count, 1, 1], 'spacing': [2.0, 0, 0]}
    return {'dt': 0.001, 'integrator': 'dmv6', 'bodies': [body]}


def pile(shape: dict[str, Any], side: int, height: int, spacing: float) -> dict[str, Any]:
    """Bodies that fall onto the ground from a loose grid."""
    return {
        'dt': 0.004,
        'gravity': [0, 0, -9.81],
        'contact': {'mode': 'timestep'},
        'bodies': [
            {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.4},
            {
                'name': 'body',
                'shape': shape,
                'density': 1000.0,
                'friction': 0.4,
                'initial': {'position': [0, 0, 0.2]},
                'repeat': {
                    'count': [side, side, height],
                    'spacing': [spacing, spacing, spacing],
                    'jitter': 0.01,
                },
            },
        ],
    }


def hull() -> dict[str, Any]:
    """Give a convex hull of twenty points on a sphere."""
    draw = random.Random(7)
    points = [[draw.gauss(0, 1) for _ in range(3)] for _ in range(20)]
    sizes = [sum(x * x for x in point) ** 0.5 for point in points]
    vertices = [[0.1 * x / size for x in point] for point, size in zip(points, sizes, strict=True)]
    return {'type': 'convex_hull', 'vertices': vertices}


CASES: dict[str, tuple[Any, int]] = {  # name -> scene, ticks of a measurement
    'one free body': (free_bodies(1), 200_000),
    '1000 free bodies': (free_bodies(1000), 10_000),
    'stack of ten boxes': (str(SCENES / 'stack.yaml'), 10_000),
    '1000 boxes': (pile({'type': 'box', 'size': [0.2, 0.2, 0.2]}, 10, 10, 0.25), 200),
    '1000 spheres': (pile({'type': 'sphere', 'radius': 0.1}, 10, 10, 0.25), 200),
    '200 hulls': (pile(hull(), 7, 4, 0.25), 200),
}


def serve() -> None:
    """Answer requests on standard input: a case to prepare, or ticks to do."""
    from rigid_body_sim import Simulation, load_scene

    running: dict[str, Any] = {}
    for line in sys.stdin:
        name, ticks = json.loads(line)
        if name not in running:
            running[name] = Simulation(load_scene(CASES[name][0]))
        began = time.process_time()
        running[name].step(ticks)
        print(json.dumps(time.process_time() - began), flush=True)


class Checkout:
    """One checkout, in a process of its own."""

    def __init__(self, path: Path, cache: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, '--serve'],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ
            | {'PYTHONPATH': str(path), 'RIGID_BODY_SIM_CACHE': cache, 'NUMBA_CACHE_DIR': cache},
        )

    def seconds(self, name: str, ticks: int) -> float:
        """Do ticks of a case; processor time [s]."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.write(json.dumps([name, ticks]) + '\n')
        self._process.stdin.flush()
        return float(json.loads(self._process.stdout.readline()))

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def spread(values: list[float], unit: float) -> str:
    """Median with the extremes."""
    middle, low, high = statistics.median(values) / unit, min(values) / unit, max(values) / unit
    return f'{middle:9.3g} ({low:.3g} .. {high:.3g})'


def measure(paths: list[Path], names: list[str], repeat: int, *, cold: bool) -> None:
    """Print a line for each case."""
    print(f'{"":20} {"other":>30} {"this":>30}   this/other')
    with tempfile.TemporaryDirectory() as caches:
        kept = [f'{caches}/{i}' for i in range(2)]
        checkouts = [] if cold else [Checkout(*pair) for pair in zip(paths, kept, strict=True)]
        for name in names:
            ticks = CASES[name][1]
            times: list[list[float]] = [[], []]
            for checkout in checkouts:
                checkout.seconds(name, ticks // 10)  # compile, and come to the same state
            for run in range(repeat):
                for i in range(2):
                    if cold:
                        checkout = Checkout(paths[i], f'{caches}/{name}{run}{i}')
                        times[i].append(checkout.seconds(name, 1))
                        checkout.close()
                    else:
                        times[i].append(checkouts[i].seconds(name, ticks))
            unit = 1.0 if cold else ticks * 1e-6
            ratio = statistics.median(times[1]) / statistics.median(times[0])
            print(
                f'{name:20} {spread(times[0], unit):>30} {spread(times[1], unit):>30} {ratio:9.3f}'
            )
        for checkout in checkouts:
            checkout.close()
    print('processor time: ' + ('s to the first tick' if cold else 'us a tick'))


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description='what a tick costs in two checkouts')
    parser.add_argument('other', type=Path, nargs='?')
    parser.add_argument('this', type=Path, nargs='?', default=ROOT)
    parser.add_argument('--repeat', type=int, default=9)
    parser.add_argument('--only', nargs='+', default=list(CASES), choices=CASES)
    parser.add_argument('--cold', action='store_true')
    parser.add_argument('--serve', action='store_true', help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.serve:
        serve()
        return
    if arguments.other is None:
        parser.error('name the other checkout')
    paths = [arguments.other.resolve(), arguments.this.resolve()]
    measure(paths, arguments.only, arguments.repeat, cold=arguments.cold)


if __name__ == '__main__':
    main()
