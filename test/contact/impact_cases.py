# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies that meet at a point, drawn at random, and Routh's equations integrated by brute force.
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rigid_body_sim.physics.contact.events.collision_matrix import StruckBody

STOPPED = 1e-13  # [-] of the speed: the oracle takes slip for stopped


class Impact(NamedTuple):
    """
    The arguments of `point_impact`.
    """

    a: StruckBody
    b: StruckBody
    normal: tuple
    velocity: tuple
    restitution: float
    friction: float


def rotation(rng):
    matrix, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return matrix * np.linalg.det(matrix)


def symmetric(matrix):
    return tuple(float(matrix[i, j]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))


def box(mass, size, turn, arm_body):
    """
    A box, turned, struck at a point of its own axes.
    """
    x, y, z = np.square(size)
    inverse = 12 / mass / np.array([y + z, x + z, x + y])
    arm = tuple(float(r) for r in turn @ np.asarray(arm_body, dtype=float))
    return StruckBody(1 / mass, symmetric(turn @ np.diag(inverse) @ turn.T), arm)


def random_box(rng):
    """
    A box of any slenderness, struck at one of its corners.
    """
    size = rng.uniform(0.1, 1, 3)
    return box(10 ** rng.uniform(-1, 1), size, rotation(rng), size / 2 * rng.choice([-1, 1], 3))


GROUND = StruckBody(0.0, (0.0,) * 6, (0.0, 0.0, 0.0))


def random_impact(rng):
    """
    Two boxes, or a box and the ground; restitution 0, 1 or between, friction 0 to 1.5.
    """
    a = GROUND if rng.random() < 0.5 else random_box(rng)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    velocity = rng.normal(size=3)
    velocity -= 2 * max(velocity @ normal, 0) * normal
    return Impact(
        a, random_box(rng), tuple(map(float, normal)), tuple(map(float, velocity)),
        float(rng.choice([0, rng.random(), 1])), float(rng.choice([0, rng.uniform(0, 1.5)])),
    )  # fmt: skip


def collision_matrix(impact):
    """
    K of du = K p, world axes (3, 3).
    """
    found = np.zeros((3, 3))
    for inverse_mass, inertia, (x, y, z) in (impact.a, impact.b):
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        xx, xy, xz, yy, yz, zz = inertia
        inverse = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        found += inverse_mass * np.eye(3) - cross @ inverse @ cross
    return found


def _rates(matrix, friction):
    """
    Routh's equations in the slip w, u_n, W and the impulse, by the parameter dp_n = |w| dt.
    """

    def rates(_t, y):
        speed = np.hypot(y[0], y[1])
        push = np.array([-friction * y[0], -friction * y[1], speed])
        slip_x, slip_y, faster = matrix @ push
        return np.concatenate([[slip_x, slip_y, faster, speed * y[2]], push])

    return rates


def _from_rest(matrix, friction):
    """
    Where a point that does not slip goes: its impulse per normal impulse, and its slip.
    """
    across, pull = matrix[:2, :2], matrix[:2, 2]
    stick = -np.linalg.solve(across, pull)
    if np.linalg.norm(stick) <= friction:
        return np.array([*stick, 1.0]), np.zeros(2)

    def direction(growth):
        return np.linalg.solve(growth * np.eye(2) + friction * across, pull)

    growth = brentq(
        lambda x: np.linalg.norm(direction(x)) - 1, 0, 2 * np.linalg.norm(pull), xtol=1e-16
    )
    slip = direction(growth)
    return np.array([*(-friction * slip), 1.0]), growth * slip


def brute_force(impact):
    """
    The impulse on B by Routh's equations and Stronge's rule, every phase by DOP853 at 3e-14.
    """
    normal, velocity = np.array(impact.normal), np.array(impact.velocity)
    approach, size = velocity @ normal, np.linalg.norm(velocity)
    first = velocity - approach * normal
    first /= np.linalg.norm(first)
    axes = np.array([first, np.cross(normal, first), normal])
    matrix = axes @ collision_matrix(impact) @ axes.T
    state = np.array([first @ velocity, 0.0, approach, 0.0, 0.0, 0.0, 0.0])
    returned = None

    def stops(_t, y):
        return np.hypot(y[0], y[1]) - STOPPED * size

    def ends(_t, y):
        return y[2] if returned is None else y[3] - returned

    stops.terminal = ends.terminal = True
    stops.direction, ends.direction = -1, 1
    while True:
        ended = True
        if np.hypot(*state[:2]) > STOPPED * size:
            found = solve_ivp(
                _rates(matrix, impact.friction), (0, 1e9), state, method='DOP853', rtol=3e-14,
                atol=1e-17, events=[stops, ends],
            )  # fmt: skip
            state, ended = found.y[:, -1], len(found.t_events[1]) > 0
            if not ended:
                state[:2] = 0.0
        else:
            push, slip = _from_rest(matrix, impact.friction)
            faster = matrix[2] @ push
            way = -state[2] / faster
            if returned is not None:
                way = np.sqrt(state[2] ** 2 + 2 * faster * (returned - state[3])) - state[2]
                way /= faster
            state[3] += way * (state[2] + way * faster / 2)
            state[2] += way * faster
            state[:2], state[4:] = way * slip, state[4:] + way * push
        if ended and returned is not None:
            return axes.T @ state[4:]
        if ended:
            returned = -(impact.restitution**2) * state[3]
            state[2:4] = 0.0
            if returned == 0.0:
                return axes.T @ state[4:]
