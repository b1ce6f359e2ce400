# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scenes of hard cases, and what is measured on them."""

import importlib.util
from pathlib import Path

import numpy as np

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

_SCRIPT = Path(__file__).parents[2] / 'benchmark' / 'stability_limits.py'


def limits_script():
    """Load `benchmark/stability_limits.py`, which measures what the tests compare."""
    spec = importlib.util.spec_from_file_location('stability_limits', _SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def scene(*bodies, forces=(), dt, gravity=(0.0, 0.0, 0.0)):
    return load_scene(
        {
            'version': 1,
            'name': 'hard',
            'dt': dt,
            'gravity': list(gravity),
            'bodies': list(bodies),
            'forces': list(forces),
        }
    )


def body(inertia, omega, *, mass=1.0, name='top', **initial):
    return {
        'name': name,
        'mass': mass,
        'inertia': dict(zip(('ixx', 'iyy', 'izz'), inertia)),
        'initial': {'angular_velocity_body': list(omega), **initial},
    }


def top(inertia, omega, *, dt, **more):
    return scene(body(inertia, omega, **more), dt=dt)


def point(name, *, mass=1.0, **initial):
    return {'name': name, 'mass': mass, 'shape': {'type': 'particle'}, 'initial': initial}


def on_a_spring(*, dt, stiffness, damping=0.0, position=1.0, velocity=0.0):
    """A point mass of 1 kg on a spring along x, held at the origin."""
    spring = {'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': stiffness}
    if damping:
        spring['damping'] = damping
    ball = point('ball', position=[position, 0, 0], velocity=[velocity, 0, 0])
    return scene(ball, forces=[spring], dt=dt)


def in_a_fluid(*, dt, rate, velocity=1.0):
    """A point mass of 1 kg with v' = -rate v."""
    drag = {'type': 'drag', 'body': 'ball', 'linear': rate}
    return scene(point('ball', velocity=[velocity, 0, 0]), forces=[drag], dt=dt)


def methods(for_scene, *, references=False):
    """Names of the integrators that take a scene."""
    return sorted(
        name
        for name, method in INTEGRATORS.items()
        if method.refuses(for_scene) is None and (references or not method.is_reference)
    )


def run(for_scene, name, ticks):
    """Positions and velocities along x after each tick, up to where it diverges; and whether."""
    sim = Simulation(for_scene, integrator=name)
    found = []
    for _ in range(ticks):
        try:
            sim.step()
        except SimulationDiverged:
            return np.array(found).reshape(-1, 2), True
        found.append((sim.state.position[0, 0], sim.state.velocity[0, 0]))
    return np.array(found), False
