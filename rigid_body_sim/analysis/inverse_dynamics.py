# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From positions and orientations over time to velocities, accelerations and the wrench that explains
them.

    v = r',  a = r''                        from a spline of degree five through the samples
    s(t) a spline of degree five through the unit quaternions, q = s / |s|, at the samples s = q
    w  = 2 vec(s' q*)                                               [rad/s], world axes
    w' = 2 vec(s'' q*) - 2 (q . s') w                               [rad/s^2]
    F  = m a - m g                                                  [N]
    torque = d/dt (R I R^T w) = R (I w'_B + w_B x I w_B)            [N m]

The wrench is what acts beside the uniform gravity g: at the centre of mass, world axes. For a body
whose mass flows it is that of the model in `model.variable_mass`, thrust included.

The error of each quantity is estimated by its distance to the same quantity from a spline of
degree seven: while the samples resolve the motion that one is far nearer to the truth, and noise
in the samples moves both apart by about as much as it moves each. A force that jumps between
samples is smeared over their spacing and makes the spline ring; `breaks` names such instants, at
which one spline ends and another begins. The ends of a spline are its worst places.

Source: de Boor, A Practical Guide to Splines (not-a-knot ends, by scipy's make_interp_spline).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body, Vector
from rigid_body_sim.physics.model.variable_mass import mass_at

Array = NDArray[np.float64]

DEGREE = 5  # two derivatives keep order four; a higher one rings more on noise
JUDGE = 7  # degree of the spline that tells the error
FEWEST = DEGREE + 1  # samples of one spline
SHORTEST_PIECE = 2 * (
    JUDGE + 1
)  # samples between breaks: the ends of a spline are its worst places


@dataclass(frozen=True, eq=False)
class Derived:
    """
    What the motion of one body tells, world axes, one row per sample.

    velocity, angular_velocity         : (k, 3) [m/s], [rad/s]
    acceleration, angular_acceleration : (k, 3) [m/s^2], [rad/s^2]
    force, torque                      : (k, 3) [N], [N m]; None where no mass is known
    """

    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array
    force: Array | None
    torque: Array | None


@dataclass(frozen=True)
class Estimate:
    """
    Estimated error of one quantity: root of the mean square over the samples, and the largest.
    """

    rms: float
    largest: float


def derive(
    time: Array,
    position: Array,
    orientation: Array,
    *,
    body: Body | None = None,
    gravity: Vector = (0.0, 0.0, 0.0),
    breaks: Sequence[float] = (),
) -> tuple[Derived, dict[str, Estimate]]:
    """
    Derive velocities, accelerations and the wrench, and estimate their errors.

        time        : (k,) [s]    ascending, k >= 6; since the start of the scene where a mass
                                  flows
        position    : (k, 3) [m]  centre of mass, world
        orientation : (k, 4) [-]  xyzw, body to world; turns by less than pi between samples
        body        : its mass properties; None: no wrench
        breaks      : [s] instants at which a force jumps
        returns     : the quantities, and the estimates by name; without any where the samples are
                      too few for one
    """
    _check(time, position, orientation)
    quaternions = continuous(so3.normalise(orientation))
    edges = _edges(time, breaks)
    pieces, distances = [], []
    for begin, end in pairwise(edges):
        last = end == len(time)
        own = slice(
            begin, end if last else end + 1
        )  # the sample at a break ends one spline and begins the next
        samples = time[own], position[own], quaternions[own]
        found = _derived(*samples, degree=DEGREE, body=body, gravity=gravity)
        pieces.append({name: value[: end - begin] for name, value in found.items()})
        if end - begin > JUDGE:
            judge = _derived(*samples, degree=JUDGE, body=body, gravity=gravity)
            distances.append({name: _size(value - judge[name]) for name, value in found.items()})
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    derived = Derived(
        joined['velocity'],
        joined['angular_velocity'],
        joined['acceleration'],
        joined['angular_acceleration'],
        joined.get('force'),
        joined.get('torque'),
    )
    if not distances:
        return derived, {}
    return derived, {
        name: _estimate(np.concatenate([d[name] for d in distances])) for name in joined
    }


def continuous(quaternions: Array) -> Array:
    """Choose between q and -q so that neighbours (k, 4) are on the same side."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    signs = np.concatenate(([1.0], np.where(np.cumsum(flips) % 2 == 1, -1.0, 1.0)))
    return quaternions * signs[:, None]


def _check(time: Array, position: Array, orientation: Array) -> None:
    if len(time) < FEWEST:
        raise UserError(
            f'{len(time)} samples; a spline of degree {DEGREE} needs at least {FEWEST}'
        )
    if not (np.all(np.isfinite(position)) and np.all(np.isfinite(orientation))):
        raise UserError(
            'positions or orientations hold NaN or infinity; every number must be finite'
        )
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        raise UserError(
            f'sample {late[0] + 1}, at {time[late[0] + 1]:.9g} s, is not later '
            'than the one before; times must ascend'
        )


def _edges(time: Array, breaks: Sequence[float]) -> list[int]:
    """
    First sample of each piece, and the end; a break too near to another one or to an end makes no
    piece.
    """
    found = sorted({int(np.searchsorted(time, t - 1e-9)) for t in breaks})
    all_edges = [0, *(i for i in found if 0 < i < len(time)), len(time)]
    kept = [
        i
        for before, i, after in zip(all_edges, all_edges[1:], all_edges[2:])
        if i - before >= SHORTEST_PIECE and after - i >= SHORTEST_PIECE
    ]
    return [0, *kept, len(time)]


def _derived(
    time: Array,
    position: Array,
    quaternions: Array,
    *,
    degree: int,
    body: Body | None,
    gravity: Vector,
) -> dict[str, Array]:
    """Derive from one spline through the samples."""
    path = make_interp_spline(time, position, k=degree)
    turn = make_interp_spline(time, quaternions, k=degree)
    s1, s2 = turn(time, 1), turn(time, 2)
    back = so3.conjugate(quaternions)
    growth = np.sum(quaternions * s1, axis=1, keepdims=True)
    omega = 2.0 * so3.multiply(s1, back)[:, :3]
    alpha = 2.0 * so3.multiply(s2, back)[:, :3] - 2.0 * growth * omega
    acceleration = path(time, 2)
    found = {
        'velocity': path(time, 1),
        'angular_velocity': omega,
        'acceleration': acceleration,
        'angular_acceleration': alpha,
    }
    if body is None:
        return found
    share = np.array([mass_at(body, t) / body.mass for t in time.tolist()])[:, None]
    torque = np.zeros_like(acceleration)
    if body.inertia is not None:
        w, turning = so3.rotate_back(quaternions, omega), so3.rotate_back(quaternions, alpha)
        torque = so3.rotate(quaternions, turning @ body.inertia + np.cross(w, w @ body.inertia))
    force = body.mass * (acceleration - np.asarray(gravity))
    return found | {'force': share * force, 'torque': share * torque}


def _size(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1)


def _estimate(distance: Array) -> Estimate:
    return Estimate(float(np.sqrt(np.mean(distance**2))), float(np.max(distance)))
