# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the lessons share: a claim that is measured, and a run as arrays."""

from types import SimpleNamespace

import numpy as np

from rigid_body_sim import Simulation, load_scene


def claim(sentence, measured, *, within, unit=''):
    """Print a claim with what was measured; an error if it does not hold."""
    worst = float(np.max(np.abs(measured)))
    print(f'{sentence}: within {within:g} {unit}'.rstrip() + f'  (measured {worst:.1e})')
    assert worst <= within, f'{sentence}: {worst:.3e} is more than {within:g} {unit}'


def follow(scene, duration, every, **choices):
    """
    Run a scene; give its states over time, t = 0 first.

    time (m,) [s]; position, velocity, spin (m, bodies, 3) [m, m/s, rad/s];
    attitude (m, bodies, 4) [xyzw]; momentum, angular_momentum (m, 3); energy (m,) [J]; simulation
    """
    simulation = Simulation(load_scene(scene), **choices)
    rows = []
    for _ in range(round(duration / every) + 1):
        state = simulation.state
        rows.append(
            (
                simulation.time,
                state.position,
                state.velocity,
                state.angular_velocity,
                state.orientation,
                simulation.momentum(),
                simulation.angular_momentum(),
                simulation.energy(),
            )
        )
        simulation.step(round(every / simulation.dt))
    names = 'time position velocity spin attitude momentum angular_momentum energy'
    columns = dict(zip(names.split(), map(np.array, zip(*rows))))
    return SimpleNamespace(simulation=simulation, **columns)
