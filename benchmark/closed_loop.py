# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a controller in a Python loop pays: read the state, command, `step(1)`.

    python benchmark/closed_loop.py [--bodies 1 10 100 1000] [--repeat 7] [--only all]

Processor time of one round in microseconds, median and extremes of the repetitions; the cases take
turns, so that a busy moment of the machine hits them alike. Free bodies tumble at 1 ms; the box
stands on the ground. Each round reads position and angular velocity and gives another command, so
nothing can be kept from the last one; a weak one, which acts to the end of the repetitions.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

from rigid_body_sim import Simulation, load_scene

LASTS = 0.05  # [s] a repetition


def scene(bodies: int, *, ground: bool = False) -> dict[str, Any]:
    """Describe boxes far from one another, that tumble or stand on the ground."""
    box: dict[str, Any] = {
        'name': 'b',
        'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
        'mass': 2.0,
        'initial': {'angular_velocity': [0.3, 1.0, 0.5]},
    }
    if bodies > 1:
        box['repeat'] = {'count': [bodies, 1, 1], 'spacing': [2.0, 0, 0]}
    made: dict[str, Any] = {'dt': 0.001, 'integrator': 'dmv6', 'bodies': [box]}
    if ground:
        box['initial'] = {'position': [0, 0, 0.05]}
        made |= {'gravity': [0, 0, -9.81], 'contact': {'mode': 'timestep'}, 'dt': 0.004}
        plane = {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
        made['bodies'] = [plane, box]
    return made


def rounds(bodies: int) -> dict[str, Callable[[], object]]:
    """Make the rounds for so many bodies, each on a simulation of its own."""
    made: dict[str, Callable[[], object]] = {}

    def add(name: str, round_of: Callable[[Simulation], Callable[[], object]], **kind: Any):
        simulation = Simulation(load_scene(scene(bodies, **kind)))
        simulation.prepare(commands_in_body_axes='body' in name)
        made[name] = round_of(simulation)
        made[name]()

    def step(simulation):
        return simulation.step

    def state(simulation):
        def one():
            simulation.step(1)
            return simulation.state.position, simulation.state.angular_velocity

        return one

    def one_wrench(simulation, frame='world'):
        name = simulation.scene.bodies[-1].name

        def one():
            at, spin = simulation.state.position[-1], simulation.state.angular_velocity[-1]
            push, torque = (-1e-3 * at[0], 0.0, 1e-3), -1e-3 * spin
            simulation.set_wrench(name, force=push, torque=torque, frame=frame)
            simulation.step(1)

        return one

    def all_wrenches(simulation, frame='world'):
        def one():
            now = simulation.state
            simulation.set_wrenches(
                force=-1e-3 * now.position, torque=-1e-3 * now.angular_velocity, frame=frame
            )
            simulation.step(1)

        return one

    add('step(1)', step)
    add('state + step(1)', state)
    add('state + one wrench + step(1)', one_wrench)
    add('state + one wrench in body axes + step(1)', lambda s: one_wrench(s, 'body'))
    if hasattr(Simulation, 'set_wrenches'):
        add('state + all wrenches + step(1)', all_wrenches)
        add('state + all wrenches in body axes + step(1)', lambda s: all_wrenches(s, 'body'))
    if bodies == 1:
        add('box on the ground: state + one wrench + step(1)', one_wrench, ground=True)
    return made


def microseconds(call: Callable[[], object], count: int) -> float:
    """Processor time of a call [us], the mean of so many."""
    begin = time.process_time()
    for _ in range(count):
        call()
    return (time.process_time() - begin) / count * 1e6


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--bodies', type=int, nargs='+', default=[1, 10, 100, 1000])
    parser.add_argument('--repeat', type=int, default=7)
    parser.add_argument('--only', default='', help='cases whose name holds this text')
    arguments = parser.parse_args()
    print(f'{"bodies":>7}  {"round":52}{"median":>9}{"from":>9}{"to":>9}   [us]')
    for bodies in arguments.bodies:
        cases = {n: call for n, call in rounds(bodies).items() if arguments.only in n}
        counts = {
            name: max(3, int(LASTS / 1e-6 / microseconds(call, 20)))
            for name, call in cases.items()
        }
        costs: dict[str, list[float]] = {name: [] for name in cases}
        for _ in range(arguments.repeat):
            for name, call in cases.items():
                costs[name].append(microseconds(call, counts[name]))
        for name, measured in costs.items():
            print(
                f'{bodies:7}  {name:52}{statistics.median(measured):9.2f}'
                f'{min(measured):9.2f}{max(measured):9.2f}',
                flush=True,
            )


if __name__ == '__main__':
    main()
