# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether passive chains of bars on stiff springs gain energy, and whether that is said beforehand.

One to four bodies, rigid with springs at the ends of arms or points, assembled without tension,
with and without rest length, damper, gravity and motion at the start; steps drawn so that h omega
of the springs (`diagnostics.step_limits`) spans the range asked for. Nothing but gravity and
springs acts, so the energy must not rise; what rises by more than GAIN of all the energy in play
is a miss, unless the run warned: at the start of the springs, or on the way of a spin.

    python benchmark/stiff_chains.py [--integrators NAME …] [--chains 200] [--low 0.3] [--high 300]

Prints for each decade of h omega: chains, those that gained, those that stopped (which is loud),
and those that gained in silence.
"""

from __future__ import annotations

import argparse
import math
from itertools import pairwise
from typing import Any

import numpy as np

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import SimulationDiverged

IMPLICIT = ('implicit_euler', 'implicit_midpoint', 'sdirk2', 'linearly_implicit')
GAIN = 0.05  # [of the energy in play] a rise beyond it is none of round-off or of a bounded error
TICKS, LOOKS = 3000, 60


def chain(rng: np.random.Generator) -> dict[str, Any]:
    """Draw a chain that hangs from the world, or flies."""
    points, resting = rng.random() < 0.2, rng.random() < 0.3
    stiffness = 10 ** rng.uniform(2, 8)
    damping = rng.choice([0.0, 10 ** rng.uniform(-4, 1)])
    still = rng.random() < 0.3
    bodies: list[dict[str, Any]] = []
    forces: list[dict[str, Any]] = []
    end, before, before_arm = np.zeros(3), 'world', np.zeros(3)
    for i in range(int(rng.integers(1, 5))):
        mass, length = 10 ** rng.uniform(-1, 1), rng.uniform(0.1, 1.0)
        arm = 0.0 if points else 0.5 * length
        arm = arm * _direction(rng)
        gap = rng.uniform(0.1, 1.0) * _direction(rng) if points or resting else np.zeros(3)
        position = end + gap + arm
        body: dict[str, Any] = {'name': f'b{i}', 'mass': float(mass)}
        body['initial'] = {'position': position.tolist()}
        if not still:
            body['initial']['velocity'] = rng.normal(size=3).tolist()
        spring = {'type': 'spring', 'a': f'b{i}', 'b': before, 'stiffness': float(stiffness)}
        spring['damping'] = float(damping * math.sqrt(stiffness * mass))
        spring['rest_length'] = float(np.linalg.norm(gap))
        if points:
            body['shape'] = {'type': 'particle'}
        else:
            a, b, c = rng.uniform(0.3, 1.0, size=3)
            moments = (
                mass * (rng.uniform(0.1, 0.3) * length) ** 2 * np.array([a + b, b + c, c + a])
            )
            body['inertia'] = dict(zip(('ixx', 'iyy', 'izz'), moments.tolist(), strict=True))
            if not still:
                spin = rng.choice([0.0, 1.0, 5.0]) * rng.normal(size=3)
                body['initial']['angular_velocity_body'] = spin.tolist()
            spring['a_point'] = (-arm).tolist()
            spring['b_point'] = before_arm.tolist()
        bodies.append(body)
        forces.append(spring)
        end, before, before_arm = position + arm, f'b{i}', arm
    if len(bodies) > 1 and rng.random() < 0.3:
        forces = forces[1:]
    gravity = [0.0, 0.0, float(rng.choice([0.0, -9.81]))]
    head = {'version': 1, 'name': 'chain', 'dt': 1e-3, 'gravity': gravity}
    return head | {'bodies': bodies, 'forces': forces}


def _direction(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def in_play(document: dict[str, Any], simulation: Simulation) -> float:
    """Energy that the bodies have or can take from gravity over half a metre [J]."""
    state = simulation.state
    energy = 0.0
    for i, body in enumerate(simulation.scene.bodies):
        spin = state.angular_velocity_body[i]
        energy += 0.5 * body.mass * float(state.velocity[i] @ state.velocity[i])
        energy += 0.0 if body.inertia is None else 0.5 * float(spin @ body.inertia @ spin)
        energy += 0.5 * body.mass * abs(document['gravity'][2])
    return energy


def outcome(name: str, rng: np.random.Generator, low: float, high: float) -> tuple[float, str]:
    """Run one chain: h omega, and 'kept', 'stopped', 'gained' or 'silent'."""
    document = chain(rng)
    probe = Simulation(load_scene(document), integrator=name)
    rate = float(np.max(probe.stability.rates(probe.state)['oscillation']))
    product = 10 ** rng.uniform(math.log10(low), math.log10(high))
    document['dt'] = max(round(product / rate * 1e9), 1) / 1e9
    simulation = Simulation(load_scene(document), integrator=name)
    start, scale = simulation.energy(), in_play(document, simulation)
    if scale == 0.0:
        return product, 'kept'
    warned, highest = bool(simulation.warnings()), start
    try:
        for _ in range(LOOKS):
            simulation.step(TICKS // LOOKS)
            highest = max(highest, simulation.energy())
            warned = warned or bool(simulation.warnings())
    except SimulationDiverged:
        return product, 'stopped'
    if highest - start <= GAIN * scale:
        return product, 'kept'
    return product, 'gained' if warned else 'silent'


def main() -> None:
    """Draw chains for each method and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').split('\n\n')[0])
    parser.add_argument('--integrators', nargs='+', default=list(IMPLICIT))
    parser.add_argument('--chains', type=int, default=200)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--low', type=float, default=0.3)
    parser.add_argument('--high', type=float, default=300.0)
    given = parser.parse_args()
    for name in given.integrators:
        rng = np.random.default_rng(given.seed)
        found = [outcome(name, rng, given.low, given.high) for _ in range(given.chains)]
        print(f'{name}: h omega, chains, gained after a warning, stopped, gained in silence')
        edges = [given.low, *(10.0**k for k in range(-3, 6)), given.high]
        edges = sorted({edge for edge in edges if given.low <= edge <= given.high})
        for begin, end in pairwise(edges):
            there = [what for product, what in found if begin <= product < end]
            counts = [there.count(what) for what in ('gained', 'stopped', 'silent')]
            print(f'  {begin:g} to {end:g}: {len(there)}', *counts, sep=', ')


if __name__ == '__main__':
    main()
