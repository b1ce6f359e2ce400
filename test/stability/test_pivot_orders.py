# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Measured order equals claimed order on a heavy symmetric top, whose torque depends on its attitude.

One method of each scheme by default; `make test-stability` takes all.
"""

import itertools
import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import heavy_top
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.rotation import angle_between

ACROSS, AXIAL, MOMENT = 0.35, 0.15, 9.81 * 0.5
TILT, PRECESSION = math.radians(30.0), 2.0
SPIN = heavy_top.spin_for(
    PRECESSION, inertia_across=ACROSS, inertia_axial=AXIAL, weight_moment=MOMENT, tilt=TILT
)
SLOPE = 0.1  # what the order may differ by: the next term of the error at these step lengths

# (orientation as a matrix, step lengths): |omega| is 22 rad/s, so h omega is 0.2 at h = 0.01
STEPS = {1: (2e-4, 1e-4), 2: (0.002, 0.001), 4: (0.004, 0.002), 8: (0.04, 0.025)}
STEPS_OF = {'blanes_moan4': (0.02, 0.0125), 'lie_rk4': (0.002, 0.001)}
SHORT = ('blanes_moan4', 'dmv6', 'implicit_midpoint', 'rk4')
FEW = 0.25  # [s] whose ticks take less as plain source than compiling
PLAIN = ('dmv6', 'implicit_midpoint')


def top(dt):
    start = heavy_top.steady(0.0, precession=PRECESSION, spin=SPIN, tilt=TILT)
    return load_scene(
        {
            'version': 1,
            'name': 'heavy_top',
            'dt': dt,
            'gravity': [0.0, 0.0, -9.81],
            'bodies': [
                {
                    'name': 'top',
                    'mass': 1.0,
                    'center_of_mass': [0.0, 0.0, 0.5],
                    'inertia': {'ixx': 0.1, 'iyy': 0.1, 'izz': 0.15},
                    'pivot': {'point': [0.0, 0.0, 0.0], 'at': [0.0, 0.0, 0.0]},
                    'initial': {
                        'orientation': [math.sin(TILT / 2), 0.0, 0.0, math.cos(TILT / 2)],
                        'angular_velocity_body': np.ravel(start.angular_velocity_body).tolist(),
                    },
                }
            ],
        }
    )


def error(name, dt, *, seconds=1.0, **options):
    simulation = Simulation(top(dt), integrator=name, integrator_options=options or None)
    simulation.step(round(seconds / dt))
    exact = heavy_top.steady(seconds, precession=PRECESSION, spin=SPIN, tilt=TILT)
    return float(angle_between(simulation.state.orientation[0], np.ravel(exact.orientation)))


def names():
    """Integrators of fixed step; those that share their scheme with another are long."""
    fixed = [
        name
        for name, method in INTEGRATORS.items()
        if not method.controls_its_error and method.refuses(top(0.01)) is None
    ]
    return [
        *((name, FEW) for name in PLAIN),
        *(
            pytest.param(
                name, 1.0, marks=pytest.mark.long if name in PLAIN or name not in SHORT else ()
            )
            for name in sorted(fixed)
        ),
    ]


@pytest.mark.parametrize(('name', 'seconds'), names())
def test_heavy_top_converges_with_the_claimed_order(name, seconds, request):
    if seconds == FEW:
        request.getfixturevalue('plain_source')
    order = INTEGRATORS[name].order
    steps = STEPS_OF.get(name) or STEPS[order]
    errors = [error(name, h, seconds=seconds) for h in steps]
    for (g, a), (h, b) in itertools.pairwise(zip(steps, errors, strict=True)):
        assert math.log(a / b) / math.log(g / h) == pytest.approx(order, abs=SLOPE)


@pytest.mark.long
@pytest.mark.parametrize('reorthonormalise', [True, False])
@pytest.mark.parametrize('name', ['explicit_euler', 'midpoint', 'rk4', 'rk8'])
def test_heavy_top_converges_with_the_claimed_order_on_a_matrix(name, reorthonormalise):
    order = INTEGRATORS[name].order
    steps = STEPS[order]
    a, b = (error(name, h, orientation='matrix', reorthonormalise=reorthonormalise) for h in steps)
    assert math.log(a / b) / math.log(steps[0] / steps[1]) == pytest.approx(order, abs=SLOPE)


@pytest.mark.long
@pytest.mark.parametrize(
    ('name', 'allowed'),
    [
        ('rk45', 1e-7),
        ('scipy_dop853', 1e-9),
        ('scipy_radau', 1e-6),
        ('scipy_bdf', 1e-4),
        ('scipy_lsoda', 1e-6),
    ],
)
def test_heavy_top_is_followed_to_within_the_tolerance(name, allowed):
    seconds = 0.2
    assert error(name, 0.05, seconds=seconds) < allowed  # tolerances, times what the motion adds
