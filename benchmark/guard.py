# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`make bench`: has anything become slower?

A few costs are measured as ratios to a calibration loop that runs beside them, and compared with
those in `figures.json`: beyond 1.5 times the exit code is 1 and the line says which. So a slowdown
is seen on any machine. Each cost has the calibration that is like it:

    chain  : multiply-adds that wait for each other         one body, coupled bodies
    lanes  : 64 lanes of arithmetic with a root             blocks full of bodies
    python : a loop of the interpreter                      what a call costs

In each repetition everything takes a turn, on the clock of the processor time; the median of the
ratios counts. What is too slow is measured once more before it is called so.

    python benchmark/guard.py             compare
    python benchmark/guard.py --accept    write what is measured into figures.json
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording.bag_metadata import Information, TopicSummary
from rigid_body_sim.recording.cdr import PoseStamped
from rigid_body_sim.recording.topics import qos_text
from rigid_body_sim.report.problems import PROBLEMS
from rigid_body_sim.scene import load_scene

FIGURES = Path(__file__).parent / 'figures.json'
SLOWER = 1.5  # [-] from which a cost is called slower
REPETITIONS = 15
LASTS = 0.01  # [s] a turn
LANES = 64

Call = Callable[[], object]

# name: (problem, integrator, its options, bodies, dt [s], calibration)
COSTS = {
    'one free body, dmv6': ('torque_free_top', 'dmv6', {}, 1, 0.01, 'chain'),
    'one free body, rk4': ('torque_free_top', 'rk4', {}, 1, 0.01, 'chain'),
    'one free body, rk8': ('torque_free_top', 'rk8', {}, 1, 0.1, 'chain'),
    '1000 free bodies, dmv6': ('throughput', 'dmv6', {}, 1000, 0.001, 'lanes'),
    '1000 free bodies, rk4': ('throughput', 'rk4', {}, 1000, 0.001, 'lanes'),
    'spring, blanes_moan4': ('oscillator', 'blanes_moan4', {}, 1, 0.01, 'chain'),
    'spring, rk4': ('oscillator', 'rk4', {}, 1, 0.01, 'chain'),
    'stiff spring, sdirk2': ('stiff_oscillator', 'sdirk2', {}, 1, 0.001, 'chain'),
    'heavy top, blanes_moan4 exact': (
        'heavy_top',
        'blanes_moan4',
        {'drift': 'exact'},
        1,
        0.01,
        'chain',
    ),
    'heavy top, rk8': ('heavy_top', 'rk8', {}, 1, 0.01, 'chain'),
    'stack of ten boxes, dmv6': ('stack', 'dmv6', {}, 1, 0.005, 'chain'),
    '100 boxes on the ground, dmv6': ('pile', 'dmv6', {}, 100, 0.005, 'chain'),
}
CALL = 'a call of step(1)'
LOOP = 'state, one wrench, step(1)'
LOAD = 'loading a body of a scene'
CLOSE = 'metadata of a topic of a bag'


@kernels.kernel
def _chain(count, x):
    y = 0.0
    for _ in range(count):
        y = y * x + 1.0
    return y


@kernels.kernel
def _lanes(count, values):
    for _ in range(count):
        for k in range(LANES):
            v = values[k]
            values[k] = math.sqrt(v * v + 0.5 * v) / (1.0 + v) + 0.5


def _python(count: int) -> int:
    total = 0
    for i in range(count):
        total += i & 3
    return total


def calibrations() -> dict[str, Call]:
    """Make the loops, each about a turn long on a machine of today."""
    values = kernels.argument(np.linspace(0.5, 1.5, LANES))
    return {
        'chain': lambda: _chain(5_000_000, 0.5),
        'lanes': lambda: _lanes(100_000, values),
        'python': lambda: _python(250_000),
    }


def costs() -> dict[str, tuple[Call, float, str]]:
    """Make what is measured: a call, how many body-steps it makes, its calibration."""
    made: dict[str, tuple[Call, float, str]] = {}
    for name, (problem, integrator, options, bodies, dt, like) in COSTS.items():
        simulation = Simulation(
            PROBLEMS[problem].scene(bodies),
            integrator=integrator,
            integrator_options=options,
            dt=dt,
        )
        simulation.prepare()
        start = simulation.state_bytes()
        simulation.step(2)
        ticks, lasted = 1, 0.0
        while lasted < LASTS:
            ticks *= 2
            lasted = min(_stepped(simulation, ticks) for _ in range(2))

        def turn(simulation=simulation, start=start, ticks=ticks) -> None:
            simulation.restore(tick=0, state=start, slots={})
            simulation.step(ticks)

        made[name] = (turn, ticks * bodies, like)
    simulation = Simulation(PROBLEMS['projectile'].scene(), integrator='dmv6', dt=0.001)
    simulation.prepare()

    def calls() -> None:
        for _ in range(2000):
            simulation.step(1)

    made[CALL] = (calls, 2000, 'python')
    return made | around_the_steps()


def around_the_steps() -> dict[str, tuple[Call, float, str]]:
    """Make what a user pays beside the steps: commands, the text of a scene, the end of a bag."""
    simulation = Simulation(PROBLEMS['projectile'].scene(), integrator='dmv6', dt=0.001)
    simulation.prepare()
    name = simulation.scene.bodies[0].name

    def loop() -> None:
        for k in range(500):
            height = simulation.state.position[0, 2]
            simulation.set_wrench(name, force=(0.0, 1e-3 * k, -1e-3 * height))
            simulation.step(1)

    body = (
        '  - {name: b%d, shape: {type: box, size: [0.4, 0.2, 0.1]}, mass: 2.0, friction: 0.4, '
        'initial: {position: [%d.5, 0, 1], velocity: [0, 0.1, 0]}}\n'
    )
    text = 'dt: 0.001\nbodies:\n' + ''.join(body % (k, k) for k in range(100))
    topics = [
        TopicSummary(f'/b{k}/pose', PoseStamped.TYPE, 'cdr', qos_text(), 'RIHS01_0', k)
        for k in range(3000)
    ]
    end = Information('run_0.mcap', topics, 0, 10**9, {})
    return {
        LOOP: (loop, 500, 'python'),
        LOAD: (lambda: load_scene(text.encode()), 100, 'python'),
        CLOSE: (lambda: (end.text(), end.file_text()), 3000, 'python'),
    }


def _stepped(simulation: Simulation, ticks: int) -> float:
    begin = time.process_time()
    simulation.step(ticks)
    return time.process_time() - begin


def _seconds(call: Call) -> float:
    begin = time.process_time()
    call()
    return time.process_time() - begin


def measured() -> dict[str, tuple[float, float]]:
    """Name -> cost of a body and step [ns], ratio to the calibration (per body and step)."""
    loops, wanted = calibrations(), costs()
    for call in loops.values():
        call()
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in wanted}
    for _ in range(REPETITIONS):
        beside = {name: _seconds(call) for name, call in loops.items()}
        for name, (call, steps, like) in wanted.items():
            cost = _seconds(call) / steps
            times[name].append((cost, cost / beside[like]))
    return {
        name: (
            1e9 * statistics.median(cost for cost, _ in pairs),
            statistics.median(ratio for _, ratio in pairs),
        )
        for name, pairs in times.items()
    }


def slower(
    found: Mapping[str, float], accepted: Mapping[str, float], *, limit: float = SLOWER
) -> list[str]:
    """
    Name the costs whose ratio has grown by more than the limit, or that nobody accepted yet.
    """
    return [
        name
        for name, ratio in found.items()
        if name not in accepted or ratio > limit * accepted[name]
    ]


def main() -> int:
    """Compare, or accept; exit code 1 where something is slower."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--accept', action='store_true', help='write figures.json')
    arguments = parser.parse_args()
    found = measured()
    ratios = {name: ratio for name, (_, ratio) in found.items()}
    if arguments.accept:
        text = json.dumps({'ratios': {k: float(f'{v:.4g}') for k, v in ratios.items()}}, indent=1)
        FIGURES.write_text(text + '\n', encoding='utf-8')
        print(f'accepted: {FIGURES.name}')
        return 0
    accepted = json.loads(FIGURES.read_text(encoding='utf-8'))['ratios']
    if slower(ratios, accepted):  # a second opinion
        again = measured()
        ratios = {name: min(ratio, again[name][1]) for name, ratio in ratios.items()}
    bad = slower(ratios, accepted)
    for name, ratio in ratios.items():
        was = accepted.get(name)
        beside = f'{ratio / was:5.2f} times what was accepted' if was else '  not accepted yet'
        mark = '   SLOWER' if was and name in bad else ''
        print(f'{name:32}{found[name][0]:10.1f} ns per body and step {beside}{mark}')
    for name in bad:
        what = f'more than {SLOWER:g} times' if name in accepted else 'not among'
        print(
            f'bench: error: {name}: {what} what figures.json holds; find out why, or accept it '
            'with: make bench-accept',
            file=sys.stderr,
        )
    return 1 if bad else 0


if __name__ == '__main__':
    sys.exit(main())
