# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a tick costs: `Simulation.step(n)` of free bodies, ns per body and tick, beside reference
figures.

Bodies with moments (1, 2, 3) kg m^2, random spin of 1 rad/s, held force and torque, dt = 1 ms. The
integrators take turns, so that a busy moment of the machine hits them alike; median and spread of
the repetitions are printed. A calibration loop (a chain of 1e7 multiply-adds) tells one machine
from another.

    python benchmark/step_cost.py [--bodies 1 10 100 1000] [--repeat 7]
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time
from functools import partial

import numpy as np

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

# ns per body and tick, measured with bare kernels on a 2-core AVX-512 machine: the figures to stay
# within a factor of
REFERENCE = {
    ('dmv6', 1): 96.0,
    ('dmv6', 10): 28.7,
    ('dmv6', 100): 16.6,
    ('dmv6', 1000): 13.6,
    ('rk4', 1): 110.7,
    ('rk4', 10): 30.0,
    ('rk4', 100): 17.4,
    ('rk4', 1000): 14.2,
    ('semi_implicit_euler', 1): 29.7,
    ('semi_implicit_euler', 10): 6.8,
    ('semi_implicit_euler', 100): 3.9,
    ('semi_implicit_euler', 1000): 4.0,
}
BODY_TICKS = 400_000  # in one repetition


def free_bodies(count: int):
    """Make a scene of so many free bodies."""
    spins = np.random.default_rng(1).normal(size=(count, 3))
    spins /= np.linalg.norm(spins, axis=1)[:, None]
    return load_scene(
        {
            'version': 1,
            'name': f'free_{count}',
            'dt': 0.001,
            'gravity': [0, 0, -9.81],
            'bodies': [
                {
                    'name': f'b{i}',
                    'mass': 1.0,
                    'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 3.0},
                    'initial': {'angular_velocity': spin},
                }
                for i, spin in enumerate(spins.tolist())
            ],
        }
    )


@kernels.kernel
def _calibration(count, x):
    y = 0.0
    for _ in range(count):
        y = y * x + 1.0
    return y


def timed(call) -> float:
    """Wall time of a call [s]."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--bodies', type=int, nargs='+', default=[1, 10, 100, 1000])
    able = [n for n, m in INTEGRATORS.items() if m.refuses(free_bodies(1)) is None]
    able = sorted(name for name in able if not INTEGRATORS[name].is_reference)
    parser.add_argument('--integrators', nargs='+', default=able)
    parser.add_argument('--repeat', type=int, default=7)
    arguments = parser.parse_args()
    _calibration(1, 0.5)
    calibration = statistics.median(timed(lambda: _calibration(10_000_000, 0.5)) for _ in range(5))
    print(f'{platform.machine()}, {kernels.versions()}, compiled: {kernels.COMPILED}')
    print(f'calibration: {calibration * 100:.2f} ns per dependent multiply-add; seed 1')
    print(
        f'{"integrator":22}{"bodies":>7}{"ns/body-tick":>14}{"spread":>16}{"reference":>11}{"ratio":>7}'
    )
    for count in arguments.bodies:
        scene = free_bodies(count)
        sims = {name: Simulation(scene, integrator=name) for name in arguments.integrators}
        ticks = max(1, BODY_TICKS // max(count, 8))
        costs: dict[str, list[float]] = {name: [] for name in sims}
        for sim in sims.values():
            sim.set_wrench('b0', force=(1.0, 0, 0), torque=(0, 0.01, 0))
            sim.step(2)
        for _ in range(arguments.repeat):
            for name, sim in sims.items():
                costs[name].append(timed(partial(sim.step, ticks)) / ticks / count * 1e9)
        for name, measured in costs.items():
            median = statistics.median(measured)
            reference = REFERENCE.get((name, count))
            beside = f'{reference:11.1f}{median / reference:7.2f}' if reference else ''
            print(
                f'{name:22}{count:7}{median:14.1f}{min(measured):9.1f}…{max(measured):<6.1f}{beside}'
            )


if __name__ == '__main__':
    main()
