# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies and scenes that touch, for the tests of contact.

`scene` adds fixed bystanders far away, a ball that bounces and resists rolling among them, so that
all scenes of this folder share one compiled kernel (see conftest.py); `lean` scenes have what they
list alone, and a kernel without what is not in them.
"""

import itertools
import math

import numpy as np

from rigid_body_sim.physics.model.scene import Body, Material, Motion, Scene
from rigid_body_sim.physics.model.shapes import Box, Plane, Sphere

G = 9.81  # [m/s^2]
DT = 1.0 / 240.0  # [s]
H = DT / 4.0  # [s] substep
CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))  # of a cube of 2 m


def motion(position, *, velocity=(0, 0, 0), turn=(0, 0, 0), q=(0, 0, 0, 1)):
    """
    Motion with angular velocity `turn`, as floats.
    """
    return Motion(*(tuple(float(x) for x in v) for v in (position, q, velocity, turn)))


def box(name, size, position, *, mass=1.0, fixed=False, material=None, **of_motion):
    """
    A solid box; one number as size: a cube.
    """
    a, b, c = size = tuple(np.broadcast_to(size, 3).astype(float).tolist())
    inertia = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * mass / 12.0
    return Body(
        name, Box(size), mass, inertia=inertia, fixed=fixed, initial=motion(position, **of_motion),
        material=Material(**(material or {})),
    )  # fmt: skip


def ball(name, radius, position, *, mass=1.0, fixed=False, material=None, **of_motion):
    """
    A solid ball.
    """
    return Body(
        name, Sphere(radius), mass, inertia=np.eye(3) * (0.4 * mass * radius**2), fixed=fixed,
        initial=motion(position, **of_motion), material=Material(**(material or {})),
    )  # fmt: skip


def ground(*, slope=0.0, material=None):
    """
    The half space below the origin, falling towards +x by `slope` [rad].
    """
    normal = (math.sin(slope), 0.0, math.cos(slope))
    return Body('ground', Plane(normal), 0.0, fixed=True, material=Material(**(material or {})))


def lean(bodies, *, dt=DT, gravity=(0.0, 0.0, -G), forces=(), **contact):
    """
    A scene of these bodies alone.
    """
    return Scene(
        'touching', round(dt * 1e9), tuple(bodies), gravity=gravity, forces=forces,
        contact={'mode': 'timestep', **contact},
    )  # fmt: skip


def scene(bodies, **settings):
    """
    A scene of these bodies and far bystanders.
    """
    lively = {'restitution': 0.1, 'rolling_friction': 0.01}
    far = [
        ball('far ball', 0.1, (0, 0, -900), fixed=True, material=lively),
        box('far box', 0.1, (0, 0, -990), fixed=True),
        Body('far ground', Plane((0.0, 0.0, 1.0), -1000.0), 0.0, fixed=True),
    ]
    return lean([*bodies, *far], **settings)


def stack(count, *, edge=0.2):
    """
    Cubes of 1 kg on each other on the ground.
    """
    return [ground(), *(box(f'b{i}', edge, (0, 0, edge * (i + 0.5))) for i in range(count))]


def heap(count, *, seed=0):
    """
    Cubes and balls that fall onto each other.
    """
    rng = np.random.default_rng(seed)
    bodies = [ground(material={'restitution': 0.2})]
    for i in range(count):
        place = (*rng.uniform(-0.1, 0.1, 2), 0.3 + 0.3 * i)
        make = ball if i % 3 == 2 else box
        size = 0.1 if i % 3 == 2 else 0.2
        bodies.append(make(f'b{i}', size, place, turn=rng.normal(size=3)))
    return bodies
