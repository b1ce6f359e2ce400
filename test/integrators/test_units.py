# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""No method knows metres, kilograms or seconds: a scene in other units moves as it did."""

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

from . import scenes

METHODS = [
    name
    for name, method in INTEGRATORS.items()
    if not name.startswith('scipy_') and 'atol' not in method.options  # which has units
]
# powers of two, so that numbers are scaled exactly; of masses even ones, whose roots are
OTHER_UNITS = [(2.0**20, 1.0, 1), (2.0**-70, 2.0**40, 1), (2.0**70, 2.0**-60, 8), (1.0, 1.0, 4)]
SMALL_AND_LARGE = OTHER_UNITS[1:3]  # with every unit another one


def linked(rng, *, rest, length=1.0, mass=1.0, time=1):
    """
    Draw two bodies and a point on stiff damped springs off their centres; in other units.

    rest : [-] whether springs have a length, in which forces are not linear
    """
    bodies, forces = [], []
    for i in range(3):
        m = float(rng.uniform(0.2, 5.0))
        a, b, c = rng.uniform(0.1, 1.0, size=3)
        position, velocity, spin, arm = rng.normal(size=(4, 3))
        moments = 0.2 * m * np.array([a + b, b + c, c + a]) * mass * length**2
        each = {
            'name': f'b{i}',
            'mass': m * mass,
            'initial': {
                'position': (position * length).tolist(),
                'velocity': (velocity * length / time).tolist(),
            },
        }
        spring = {
            'type': 'spring',
            'a': each['name'],
            'b': f'b{i - 1}' if i else 'world',
            'stiffness': float(10 ** rng.uniform(2, 5)) * mass / time**2,
            'damping': float(rng.choice([0.0, 3.0])) * mass / time,
            'rest_length': float(rng.uniform(0.1, 1.0)) * length * rest,
        }
        if i == 2:
            each['shape'] = {'type': 'particle'}
        else:
            each['inertia'] = dict(zip(('ixx', 'iyy', 'izz'), moments.tolist(), strict=True))
            each['initial']['angular_velocity_body'] = (spin / time).tolist()
            spring['a_point'] = (0.3 * arm * length).tolist()
        bodies.append(each)
        forces.append(spring)
        forces.append({'type': 'drag', 'body': each['name'], 'quadratic': 0.1 * mass / length})
    gravity = [0.0, 0.0, -9.81 * length / time**2]
    return scenes.scene(bodies, forces=forces, gravity=gravity, dt=0.002 * time)


def end(name, units, ticks, **scene):
    """State after some ticks, in the units of the scene that was not scaled."""
    length, _, time = units
    scene = linked(np.random.default_rng(5), length=length, mass=units[1], time=time, **scene)
    sim = Simulation(scene, integrator=name)
    sim.step(ticks)
    state = sim.state
    return (
        state.position / length,
        state.velocity * (time / length),
        state.orientation,
        state.angular_velocity * time,
    )


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize(
    ('others', 'rests', 'ticks'),
    [(SMALL_AND_LARGE, 1, 8), pytest.param(OTHER_UNITS, 2, 20, marks=pytest.mark.long)],
    ids=['short', 'all'],
)
@pytest.mark.parametrize(
    'name',  # of the two that iterate one
    scenes.mostly_long(METHODS, short={*scenes.OF_EACH_KIND} - {'sdirk2'}),
)
def test_a_scene_in_other_units_moves_with_the_same_digits(name, others, rests, ticks):
    for rest in [rest for rest in (1.0, 0.0) if not refuses(name, rest)][:rests]:
        here = end(name, (1.0, 1.0, 1), ticks, rest=rest)
        for units in others:
            for a, b in zip(here, end(name, units, ticks, rest=rest), strict=True):
                np.testing.assert_array_equal(a, b, err_msg=f'units {units}')


def refuses(name, rest):
    scene = linked(np.random.default_rng(5), rest=rest)
    return INTEGRATORS[name].refuses(scene) is not None
