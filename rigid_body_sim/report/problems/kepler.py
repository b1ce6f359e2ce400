# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two bodies on ellipses about their common centre of mass: five periods and a third."""

from __future__ import annotations

from rigid_body_sim.exact import kepler
from rigid_body_sim.report.problem import (
    LECTURE,
    Problem,
    ladder,
    position_error,
    scene_document,
)

GRAVITATION = 1.0  # [m^3/(kg s^2)]
SUN, PLANET = 2.0, 1.0  # [kg]
PARAMETER = GRAVITATION * (SUN + PLANET)  # [m^3/s^2]
AXIS, ECCENTRICITY = 1.0, 0.5  # [m], [-]
DURATION = 20.0  # [s] 5.5 periods
SHARES = (-PLANET / (SUN + PLANET), SUN / (SUN + PLANET))  # of the way from one to the other


def along(t: float) -> kepler.Translation:
    """Motion of the planet as the sun sees it."""
    return kepler.relative(t, parameter=PARAMETER, semi_major_axis=AXIS, eccentricity=ECCENTRICITY)


START, END = along(0.0), along(DURATION)

PROBLEM = Problem(
    name='kepler',
    heading=LECTURE,
    title='Kepler: two bodies on ellipses',
    description='Two masses of 2 and 1 kg attract each other with G = 1 m^3/(kg s^2) and go round '
    'their common centre for 20 s, five periods and a half, with an eccentricity of 0.5.',
    shows='Methods that conserve no energy spiral; those that do run early or late along the '
    'ellipse.',
    document=scene_document(
        'kepler',
        [
            {
                'name': name,
                'shape': {'type': 'particle'},
                'mass': mass,
                'initial': {
                    'position': (share * START.position).tolist(),
                    'velocity': (share * START.velocity).tolist(),
                },
            }
            for name, mass, share in zip(('sun', 'planet'), (SUN, PLANET), SHARES, strict=True)
        ],
        forces=[{'type': 'gravity', 'constant': GRAVITATION, 'among': ['sun', 'planet']}],
    ),
    duration=DURATION,
    error=position_error([share * END.position for share in SHARES]),
    error_unit='m',
    reference="Kepler's equation",
    useless=0.5,
    integrators=(
        'explicit_euler',
        'semi_implicit_euler',
        'dmv6',
        'force_gradient4',
        'blanes_moan4',
        'rk4',
        'rk45',
        'rk8',
    ),
    steps=ladder(0.2, 0.0005),
    tick=2.0,
)
