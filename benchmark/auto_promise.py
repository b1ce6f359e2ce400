# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Does `integrator: auto` keep its promise? Random scenes, tolerances from 1e-3 to 1e-10, and the
true error at many instants against a slow reference through scipy (DOP853, Radau where stiff).

    python benchmark/auto_promise.py [--scenes 10] [--seed 1] [--kind passive|driven|stiff|all]
                                     [--duration 5] [--tolerances 1e-3 1e-6]

A factor is the largest error [m, rad] over tolerance times time (times one second before the
first), at INSTANTS of the run: the promise holds where it is at most 1. `driven` scenes get held
torques, forces and impulses that no pilot knows of. The reference is run twice, the second time
a hundred times as tight where it can be; where the two differ by more than a tenth of what is
allowed, the case is not counted.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.choose import difference

INSTANTS = 25
TOLERANCES = (1e-3, 1e-4, 1e-6, 1e-8, 1e-10)
Act = Callable[[Simulation], None]


def random_scene(rng: np.random.Generator, *, stiff: bool) -> dict:
    """Make one to three tumbling bodies on springs off their centres, some damped."""
    count = int(rng.integers(1, 4))
    bodies, forces = [], []
    for i in range(count):
        moments = rng.uniform(0.2, 1.0, 3)
        moments[2] = rng.uniform(abs(moments[0] - moments[1]) + 0.05, moments[0] + moments[1])
        bodies.append(
            {
                'name': f'b{i}',
                'mass': float(rng.uniform(0.5, 3.0)),
                'inertia': dict(zip(('ixx', 'iyy', 'izz'), moments.tolist(), strict=True)),
                'initial': {
                    'position': [float(i), 0.0, 0.0],
                    'velocity': rng.normal(0.0, 0.0 if stiff else 0.5, 3).tolist(),
                    'angular_velocity': rng.normal(0.0, 0.0 if stiff else 1.5, 3).tolist(),
                },
            }
        )
        stiffness = 10.0 ** rng.uniform(6.0, 8.0) if stiff else 10.0 ** rng.uniform(0.0, 2.5)
        damping = (
            stiffness * 10.0 ** rng.uniform(-4.0, -3.0)
            if stiff
            else float(rng.choice([0.0, 0.0, 0.3, 1.0]))
        )
        arm = [-0.5, 0.0, 0.0] if stiff else rng.uniform(-0.4, 0.4, 3).tolist()
        other = f'b{i - 1}' if i else 'world'
        at = [0.5 if i else -0.5, 0.0, 0.0] if stiff else rng.uniform(-0.4, 0.4, 3).tolist()
        forces.append(
            {
                'type': 'spring', 'a': f'b{i}', 'a_point': arm, 'b': other, 'b_point': at,
                'stiffness': float(stiffness), 'damping': float(damping),
            }
        )  # fmt: skip
        if not stiff and rng.random() < 0.3:
            forces.append({'type': 'drag', 'body': f'b{i}', 'linear': 0.3, 'angular': 0.1})
    return {
        'version': 1,
        'name': 'random',
        'dt': 0.01 if stiff else float(rng.choice([0.001, 0.005, 0.01, 0.02])),
        'gravity': [0.0, 0.0, -9.81] if stiff or rng.random() < 0.5 else [0.0, 0.0, 0.0],
        'bodies': bodies,
        'forces': forces,
    }


def random_acts(rng: np.random.Generator, scene: dict, duration: float) -> dict[int, Act]:
    """Make three commands at random ticks."""
    acts: dict[int, Act] = {}
    for _ in range(3):
        tick = round(rng.uniform(0.0, duration) / scene['dt'])
        body = f'b{rng.integers(len(scene["bodies"]))}'
        force, torque = rng.normal(0.0, 3.0, 3).tolist(), rng.normal(0.0, 3.0, 3).tolist()
        if rng.random() < 0.5:
            acts[tick] = lambda sim, b=body, f=force, t=torque: sim.set_wrench(
                b, force=f, torque=t
            )
        else:
            acts[tick] = lambda sim, b=body, f=force, t=torque: (
                sim.apply_impulse(b, linear=f, angular=t) and None
            )
    return acts


def states(simulation: Simulation, ticks: list[int], acts: dict[int, Act]) -> list:
    """Run through instants, with the commands at their ticks."""
    found = []
    for end in ticks:
        while simulation.tick < end:
            if simulation.tick in acts:
                acts[simulation.tick](simulation)
            later = [tick for tick in acts if tick > simulation.tick]
            simulation.step(min([end, *later]) - simulation.tick)
        found.append(simulation.state)
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n', maxsplit=1)[0])
    parser.add_argument('--scenes', type=int, default=10)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--kind', choices=('passive', 'driven', 'stiff', 'all'), default='passive')
    parser.add_argument('--duration', type=float, default=5.0)
    parser.add_argument('--tolerances', type=float, nargs='+', default=TOLERANCES)
    arguments = parser.parse_args()
    kinds = ('passive', 'driven', 'stiff') if arguments.kind == 'all' else (arguments.kind,)
    for kind in kinds:
        _judge(kind, arguments)


def _judge(kind: str, arguments: argparse.Namespace) -> None:
    kept = counted = refused = 0
    worst = 0.0
    for number in range(arguments.scenes):
        rng = np.random.default_rng([arguments.seed, number])
        content = random_scene(rng, stiff=kind == 'stiff')
        acts = random_acts(rng, content, arguments.duration) if kind == 'driven' else {}
        scene = load_scene(content)
        ticks = sorted(
            {
                max(1, round(arguments.duration * i / INSTANTS / content['dt']))
                for i in range(1, INSTANTS + 1)
            }
        )
        seconds = np.maximum(np.array(ticks) * content['dt'], 1.0)
        name = 'scipy_radau' if kind == 'stiff' else 'scipy_dop853'
        rough, true = (
            states(
                Simulation(scene, integrator=name, integrator_options={'rtol': r, 'atol': r}),
                ticks,
                acts,
            )
            for r in ((1e-7, 1e-9) if kind == 'stiff' else (1e-11, 1e-13))
        )
        unsure = [difference(a, b) for a, b in zip(rough, true, strict=True)] / seconds
        for tolerance in arguments.tolerances:
            if np.max(unsure) > 0.1 * tolerance:
                continue
            began = time.process_time()
            try:
                simulation = Simulation(
                    scene, integrator='auto', integrator_options={'tolerance': tolerance}
                )
            except InvalidModel as error:
                refused += 1
                print(f'{kind} {number} {tolerance:g}: refused: {error}')
                continue
            chosen = time.process_time() - began
            run = states(simulation, ticks, acts)
            ran = time.process_time() - began - chosen
            factors = [difference(a, b) for a, b in zip(run, true, strict=True)]
            factor = float(np.max(factors / seconds)) / tolerance
            counted += 1
            kept += factor <= 1.0
            worst = max(worst, factor)
            made = ', '.join(f'{c.name} {dict(c.options)} @{c.tick}' for c in simulation.choices)
            print(
                f'{kind} {number} dt {content["dt"]:g} tolerance {tolerance:g}: '
                f'{made} factor {factor:.2g}; {chosen:.1f} s to choose, {ran:.2f} s to run',
                flush=True,
            )
    print(
        f'{kind}: promise kept {kept} of {counted}, {refused} refused, worst factor {worst:.2g}',
        flush=True,
    )


if __name__ == '__main__':
    main()
