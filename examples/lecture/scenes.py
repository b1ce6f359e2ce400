# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scenes that several lessons share: a mass on a spring, and a planet about its sun."""

import numpy as np

MASS, K, START = 0.5, 50.0, 0.2  # [kg], [N/m], [m]
OMEGA = np.sqrt(K / MASS)  # [rad/s]

G, SUN, PLANET = 1.0, 1000.0, 1e-9  # [m^3/(kg s^2)], [kg]: a small sky in SI numbers
A, E = 10.0, 0.3  # [m] semi-major axis, [-] eccentricity
PERIOD = 2 * np.pi * np.sqrt(A**3 / (G * SUN))  # [s] Kepler's third law
SPEED = np.sqrt(G * SUN / A * (1 + E) / (1 - E))  # [m/s] at the nearest point


def hung(damping, integrator):
    """A mass on a spring and a damper [N s/m], drawn out and let go."""
    return {
        'dt': 0.001,
        'integrator': integrator,
        'bodies': [
            {
                'name': 'mass',
                'shape': {'type': 'particle'},
                'mass': MASS,
                'initial': {'position': [START, 0, 0]},
            }
        ],
        'forces': [
            {'type': 'spring', 'a': 'mass', 'b': 'world', 'stiffness': K, 'damping': damping}
        ],
    }


def orbit(integrator, dt=0.005):
    """A planet about a sun that hardly feels it, from the nearest point on."""
    return {
        'dt': dt,
        'integrator': integrator,
        'bodies': [
            {'name': 'sun', 'shape': {'type': 'particle'}, 'mass': SUN},
            {
                'name': 'planet',
                'shape': {'type': 'particle'},
                'mass': PLANET,
                'initial': {'position': [A * (1 - E), 0, 0], 'velocity': [0, SPEED, 0]},
            },
        ],
        'forces': [{'type': 'gravity', 'constant': G}],
    }
