# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scenes on which integrators are judged."""

import pytest

from rigid_body_sim import load_scene
from rigid_body_sim.physics.integration.integrators import INTEGRATORS


def scene(bodies, *, forces=(), dt=0.001, gravity=(0.0, 0.0, 0.0)):
    return load_scene(
        {
            'version': 1,
            'name': 'test',
            'dt': dt,
            'gravity': list(gravity),
            'bodies': bodies,
            'forces': list(forces),
        }
    )


def top(*, inertia=(1.0, 2.0, 3.0), omega=(0.01, 1.0, 0.01), dt=0.001, name='top', **initial):
    """A free body with principal axes along its axes."""
    i1, i2, i3 = inertia
    body = {
        'name': name,
        'mass': 1.0,
        'inertia': {'ixx': i1, 'iyy': i2, 'izz': i3},
        'initial': {'angular_velocity_body': list(omega), **initial},
    }
    return scene([body], dt=dt)


def names_for(scene):
    """Integrators that do not refuse a scene, references left out."""
    return sorted(
        name
        for name, method in INTEGRATORS.items()
        if not method.is_reference and method.refuses(scene) is None
    )


def of_fixed_step(names=tuple(INTEGRATORS)):
    """Integrators whose error the tick length sets, not a tolerance."""
    return sorted(name for name in names if not INTEGRATORS[name].controls_its_error)


def oscillator(*, dt, stiffness=4.0, damping=0.0, position=1.0, shape=None):
    """A point mass of 1 kg on a spring along x, or a body of a shape."""
    ball = {
        'name': 'ball',
        'shape': shape or {'type': 'particle'},
        'mass': 1.0,
        'initial': {'position': [position, 0.0, 0.0]},
    }
    spring = {
        'type': 'spring',
        'a': 'ball',
        'b': 'world',
        'stiffness': stiffness,
        'damping': damping,
    }
    return scene([ball], forces=[spring], dt=dt)


def linked_bodies(integrator=None):
    """
    Two tumbling bodies on springs off their centres, a point mass, a push in body axes and
    gravity.

    A spring is damped and a body feels drag, unless the integrator refuses that.
    """
    whole = _linked_bodies(damped=True)
    if integrator is None or INTEGRATORS[integrator].refuses(whole) is None:
        return whole
    return _linked_bodies(damped=False)


def _linked_bodies(*, damped):
    damping = {'damping': 0.4} if damped else {}
    drag = {'type': 'drag', 'body': 'rod', 'linear': 0.1, 'angular_quadratic': 0.05}
    return scene(
        [
            {
                'name': 'box',
                'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
                'mass': 2.0,
                'initial': {'position': [0, 0, 1], 'angular_velocity': [1, 2, 3]},
            },
            {
                'name': 'rod',
                'mass': 1.0,
                'inertia': {'ixx': 0.2, 'iyy': 0.3, 'izz': 0.25, 'ixy': 0.02, 'iyz': -0.01},
                'initial': {'position': [1, 0, 1], 'velocity': [0, 1, 0]},
            },
            {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 0.5},
        ],
        forces=[
            {
                'type': 'spring',
                'a': 'box',
                'a_point': [0.2, 0.1, 0.05],
                'b': 'rod',
                'b_point': [0, 0.3, 0],
                'stiffness': 40.0,
                'rest_length': 0.5,
            },
            {'type': 'spring', 'a': 'ball', 'b': 'box', 'stiffness': 30.0, **damping},
            *([drag] if damped else []),
            {
                'type': 'constant',
                'body': 'box',
                'force': [0, 0, 1],
                'frame': 'body',
                'point': [0.1, 0, 0],
            },
        ],
        gravity=(0.0, 0.0, -9.81),
    )


def linked_points(*, dt=0.001):
    """
    Three point masses in a row on damped springs without rest length, the first tied to the world:
    linear.
    """
    names = ('a', 'b', 'c')
    shape = {'type': 'particle'}
    bodies = [
        {
            'name': n,
            'shape': shape,
            'mass': 1.0 + i,
            'initial': {'position': [1.0 + i, 0.1 * i, 0.0]},
        }
        for i, n in enumerate(names)
    ]
    ends = (('a', 'world', 0.2), ('b', 'a', 0.1), ('c', 'b', 0.3))
    springs = [
        {'type': 'spring', 'a': a, 'b': b, 'stiffness': 9.0, 'damping': damping}
        for a, b, damping in ends
    ]
    drag = {'type': 'drag', 'body': 'b', 'linear': 0.2}
    return scene(bodies, forces=[*springs, drag], dt=dt, gravity=(0.0, 0.0, -9.81))


TURNING = names_for(top())


def of_each_scheme(names):
    """
    Parameters: one name for each scheme and order; the others, which differ from it in how a body
    turns alone, for the long form.
    """
    return mostly_long(names, short=first_of_each_scheme(names))


def first_of_each_scheme(names):
    """
    One name for each scheme and order.
    """
    first = {(type(INTEGRATORS[n].scheme), INTEGRATORS[n].order): n for n in reversed(names)}
    first[type(INTEGRATORS['dmv6'].scheme), INTEGRATORS['dmv6'].order] = 'dmv6'
    return {*first.values()}


# one name for each scheme, whatever the order: two of one scheme differ in their coefficients
OF_EACH_KIND = {
    **{type(method.scheme): name for name, method in sorted(INTEGRATORS.items())},
    **{type(INTEGRATORS[name].scheme): name for name in ('dmv6', 'rk4', 'implicit_midpoint')},
}.values()


def mostly_long(names, *, short):
    """
    Parameters: a few names for the short form, as each compiles anew; the others for the long one.
    """
    chosen = {*short}
    return [n if n in chosen else pytest.param(n, marks=pytest.mark.long) for n in names]
