# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What can be read of the bodies at one instant, in scene order, body axes and world axes.

One compiled pass over the blocks fills one array; a `State` is views of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument, kernel
from rigid_body_sim.physics.model.pivot import arm_of
from rigid_body_sim.physics.model.variable_mass import flow_of, masses_at
from rigid_body_sim.physics.state.blocks import (
    IM,
    J1,
    J2,
    J3,
    LX,
    LY,
    LZ,
    PX,
    PY,
    PZ,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    RX,
    RY,
    RZ,
    TRANSLATION,
    at,
    rotate,
)
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]
COLUMNS = 22


@kernel
def _read(n_moving, n_rigid, translation, rotation, principal, scene_index, out):
    for i in range(n_moving):
        k = at(i, TRANSLATION)
        o = int(scene_index[i]) * 22
        im = translation[k + IM]
        out[o], out[o + 1], out[o + 2] = (
            translation[k + RX],
            translation[k + RY],
            translation[k + RZ],
        )
        px, py, pz = translation[k + PX], translation[k + PY], translation[k + PZ]
        out[o + 7], out[o + 8], out[o + 9] = px * im, py * im, pz * im
        out[o + 16], out[o + 17], out[o + 18] = px, py, pz
    for i in range(n_rigid):
        k = at(i, ROTATION)
        o = int(scene_index[i]) * 22
        x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
        lx, ly, lz = rotation[k + LX], rotation[k + LY], rotation[k + LZ]
        a, b, c = rotate(-x, -y, -z, w, lx, ly, lz)
        a, b, c = a * rotation[k + J1], b * rotation[k + J2], c * rotation[k + J3]
        out[o + 10], out[o + 11], out[o + 12] = rotate(x, y, z, w, a, b, c)
        out[o + 19], out[o + 20], out[o + 21] = lx, ly, lz
        p, q, r, s = (
            principal[4 * i],
            principal[4 * i + 1],
            principal[4 * i + 2],
            principal[4 * i + 3],
        )
        if s != 1.0:  # body axes from principal axes: q_body = q_principal V*
            a, b, c = rotate(p, q, r, s, a, b, c)
            x, y, z, w = (
                -w * p + x * s - y * r + z * q,
                -w * q + y * s - z * p + x * r,
                -w * r + z * s - x * q + y * p,
                w * s + x * p + y * q + z * r,
            )
        out[o + 3], out[o + 4], out[o + 5], out[o + 6] = x, y, z, w
        out[o + 13], out[o + 14], out[o + 15] = a, b, c


@kernel
def _move_to_centers(count, pivots, values):
    """
    Make position, velocity, momentum and own angular momentum of the centre of mass of those of
    the pivot: rows of scene index, arm (3) in body axes, mass.
    """
    for e in range(count):
        m = 5 * e
        o = int(pivots[m]) * 22
        a, b, c = rotate(
            values[o + 3], values[o + 4], values[o + 5], values[o + 6],
            pivots[m + 1], pivots[m + 2], pivots[m + 3],
        )  # fmt: skip
        x, y, z = values[o + 10], values[o + 11], values[o + 12]
        u, v, w = y * c - z * b, z * a - x * c, x * b - y * a
        values[o], values[o + 1], values[o + 2] = (
            values[o] + a,
            values[o + 1] + b,
            values[o + 2] + c,
        )
        values[o + 7], values[o + 8], values[o + 9] = u, v, w
        mass = pivots[m + 4]
        u, v, w = mass * u, mass * v, mass * w
        values[o + 16], values[o + 17], values[o + 18] = u, v, w
        values[o + 19] -= b * w - c * v
        values[o + 20] -= c * u - a * w
        values[o + 21] -= a * v - b * u


@dataclass(frozen=True, eq=False)
class State:
    """
    The bodies of a scene at one instant: a copy, in scene order.

    values : (n, 22)
    masses : (n,) [kg]  zero for fixed bodies; None where the mass of no body changes
    """

    values: Array
    masses: Array | None = None

    @property
    def position(self) -> Array:
        """Centres of mass (n, 3) [m], world."""
        return self.values[:, 0:3]

    @property
    def orientation(self) -> Array:
        """Unit quaternions (n, 4) [-], xyzw, body to world; (0, 0, 0, 1) for point masses."""
        return self.values[:, 3:7]

    @property
    def velocity(self) -> Array:
        """Velocities of the centres of mass (n, 3) [m/s], world."""
        return self.values[:, 7:10]

    @property
    def angular_velocity(self) -> Array:
        """Angular velocities (n, 3) [rad/s], world axes."""
        return self.values[:, 10:13]

    @property
    def angular_velocity_body(self) -> Array:
        """Angular velocities (n, 3) [rad/s], body axes."""
        return self.values[:, 13:16]

    @property
    def momentum(self) -> Array:
        """Momenta (n, 3) [kg m/s], world."""
        return self.values[:, 16:19]

    @property
    def angular_momentum(self) -> Array:
        """Angular momenta about the own centres of mass (n, 3) [kg m^2/s], world axes."""
        return self.values[:, 19:22]


class StateReader:
    """Reads the blocks of one layout."""

    def __init__(self, layout: Layout) -> None:
        self._still = np.zeros((len(layout.bodies), COLUMNS))
        for i, body in enumerate(layout.bodies):
            self._still[i, 0:3] = body.initial.position
            self._still[i, 3:7] = body.initial.orientation
        self._sizes = (layout.n_moving, layout.n_rigid)
        self._principal = argument(layout.principal.ravel())
        self._scene_index = argument(layout.moving)
        self._flowing = np.array([flow_of(body) is not None for body in layout.bodies])
        self._bodies = layout.bodies
        rows = [
            (layout.moving[core], *arm_of(layout.body(core)), layout.body(core).mass)
            for core in layout.pivoted
        ]
        self._pivots = (len(rows), argument(np.array(rows, dtype=np.float64).reshape(-1)))

    def read(self, translation: Array, rotation: Array, *, time: float) -> State:
        """Read the state of all bodies, `time` [s] after the start of the scene."""
        values = self._still.copy()
        _read(
            *self._sizes,
            argument(translation),
            argument(rotation),
            self._principal,
            self._scene_index,
            argument(values.reshape(-1)),
        )
        if self._pivots[0]:
            _move_to_centers(*self._pivots, argument(values.reshape(-1)))
        if not self._flowing.any():
            return State(values)
        masses = masses_at(self._bodies, time)
        assert masses is not None
        for i in np.flatnonzero(
            self._flowing
        ):  # the blocks hold the momenta of the mass at the start
            values[i, 16:22] *= masses[i] / self._bodies[i].mass
        return State(values, masses)
