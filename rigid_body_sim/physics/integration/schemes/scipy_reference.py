# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reference solutions: each tick is one call of scipy.integrate.solve_ivp on (r, p, q, omega_body) of
the whole scene.

    r' = p / m,   p' = F,   q' = q (omega, 0) / 2,   omega' = I^-1 (R^T torque - omega x I omega)

The same forces, an independent solver: for comparison, not for speed (about a millisecond a tick).
q is scaled to unit length where forces are evaluated and after each tick. Nothing is remembered
from tick to tick, and the solver counts time from the begin of the tick, so that its steps do not
depend on when that is; scipy is imported when the first tick runs.

Positions are rounded to 1e-16 of their distance from the origin, and the forces of springs with
them. Where that is more than the tolerances ask, the solver takes the noise for motion and its
steps shrink to nothing: such a tick ends with TOO_MANY_EVALUATIONS, as does one that is too long.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.integration.schemes.steps import finite, start_evaluation
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE, TOO_MANY_EVALUATIONS
from rigid_body_sim.physics.model.plain_products import cross
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    MOMENTS,
    MOMENTUM,
    ORIENTATION,
    POSITION,
    ROTATION,
    TORQUE,
    TRANSLATION,
    gather,
    scatter,
)

Array = NDArray[np.float64]

# columns of a point: r, p; of a rotation: q, omega in body axes; of a quaternion
POINT, R, P = 6, slice(0, 3), slice(3, 6)
RIGID, Q, OMEGA = 7, slice(0, 4), slice(4, 7)
AXIS, SCALAR = slice(0, 3), slice(3, 4)
MOST = 100_000  # evaluations of a tick: some ten seconds
FIRST_LOOK = 20_000  # evaluations after which a tick that would take five times MOST is ended


class _TooMany(ArithmeticError):
    """A tick asks for too many evaluations."""


def too_many_evaluations(distance: float) -> str:
    """Say what has happened, and what to do; the farthest position is a distance [m] away."""
    rounding = distance * np.finfo(float).eps
    return (
        f'the solver of scipy would evaluate its forces more than {MOST} times in this tick. The '
        f'farthest body is {distance:.3g} m from the origin, where positions are rounded to '
        f'{rounding:.1g} m: if rtol and atol ask for more than that leaves of the forces, move '
        'the scene to the origin or allow more; else the tick is too long for it'
    )


@dataclass(frozen=True)
class ScipyReference:
    """
    A method of scipy.integrate.solve_ivp.

    method : 'DOP853', 'Radau', 'BDF' or 'LSODA'
    """

    method: str

    def free(self, name: str) -> Callable[..., Any]:
        """Make the function for a scene without forces that depend on the state."""
        return self.coupled(name, scene='', evaluate=_no_forces, velocity_dependent=False)

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """
        Make the function for the force elements of a scene; it has the signature of a kernel.
        """

        def advance(ticks: int, tick: int, h: float, *arrays: Any) -> float:
            equations = _Equations(evaluate, *arrays)
            for passed in range(ticks):
                try:
                    if not equations.advance(self.method, tick + passed, h):
                        return DID_NOT_CONVERGE
                except _TooMany:
                    return TOO_MANY_EVALUATIONS
            return equations.finite()

        return advance

    def workspace(self, blocks: int) -> int:
        """Two numbers: rtol and atol."""
        return 2


def _no_forces(*_arguments: Any) -> None:
    """Evaluate nothing."""


class _Equations:
    """The equations of motion of the bodies in the blocks, as scipy wants them: y' = f(t, y)."""

    def __init__(
        self,
        evaluate: Callable[..., Any],
        n_bodies: int,
        n_rigid: int,
        translation: Any,
        rotation: Any,
        method: Any,
        workspace: Any,
        elements: Any,
        ranges: Any,
    ) -> None:
        self._evaluate = evaluate
        self._sizes = (n_bodies, n_rigid)
        self._split = POINT * n_bodies
        self._arguments = (translation, rotation, elements, ranges)
        self._blocks = (np.asarray(translation), np.asarray(rotation))
        self._tolerances = {'rtol': workspace[0], 'atol': workspace[1]}
        self._tick = (0.0, 1.0)  # [s] begin and length of that which is solved
        self._evaluations = 0  # of it so far
        self._inverse_mass = gather(self._blocks[0], TRANSLATION, INVERSE_MASS, 1, n_bodies)
        self._moments = gather(self._blocks[1], ROTATION, MOMENTS, 3, n_rigid)
        self._inverses = gather(self._blocks[1], ROTATION, INVERSE_MOMENTS, 3, n_rigid)

    def _parts(self, y: Array) -> tuple[Array, Array]:
        """View y as rows of points and of rotations."""
        return y[: self._split].reshape(-1, POINT), y[self._split :].reshape(-1, RIGID)

    def _unpack(self, y: Array) -> tuple[Array, Array, Array]:
        """
        Position and momentum (n, 6), unit quaternion (n_rigid, 4), angular velocity in principal
        axes (n_rigid, 3).
        """
        points, rotations = self._parts(y)
        q = rotations[:, Q] / np.linalg.norm(rotations[:, Q], axis=1)[:, None]
        return points, q, rotations[:, OMEGA]

    def _write(self, points: Array, q: Array, omega: Array) -> None:
        translation, rotation = self._blocks
        scatter(translation, TRANSLATION, POSITION, points[:, R])
        scatter(translation, TRANSLATION, MOMENTUM, points[:, P])
        if len(q):
            scatter(rotation, ROTATION, ORIENTATION, q)
            scatter(rotation, ROTATION, ANGULAR_MOMENTUM, _rotate(q, self._moments * omega))

    def _read(self) -> Array:
        n_bodies, n_rigid = self._sizes
        translation, rotation = self._blocks
        points = np.hstack(
            (
                gather(translation, TRANSLATION, POSITION, 3, n_bodies),
                gather(translation, TRANSLATION, MOMENTUM, 3, n_bodies),
            )
        )
        q = gather(rotation, ROTATION, ORIENTATION, 4, n_rigid)
        momentum = gather(rotation, ROTATION, ANGULAR_MOMENTUM, 3, n_rigid)
        omega = _rotate(_conjugate(q), momentum) * self._inverses
        return np.concatenate((points.ravel(), np.hstack((q, omega)).ravel()))

    def slope(self, time: float, y: Array) -> Array:
        """y' at a time [s] since the begin of the tick."""
        self._count(time)
        points, q, omega = self._unpack(y)
        self._write(points, q, omega)
        translation, rotation, elements, ranges = self._arguments
        n_bodies, n_rigid = self._sizes
        start_evaluation(n_bodies, n_rigid, translation, rotation)
        self._evaluate(0, self._tick[0] + float(time), translation, rotation, elements, ranges)
        force = gather(self._blocks[0], TRANSLATION, FORCE, 3, n_bodies)
        out = np.empty_like(y)
        of_points, of_rotations = self._parts(out)
        of_points[:, R] = points[:, P] * self._inverse_mass
        of_points[:, P] = force
        if n_rigid:
            torque = gather(self._blocks[1], ROTATION, TORQUE, 3, n_rigid)
            u, w = q[:, AXIS], q[:, SCALAR]
            of_rotations[:, AXIS] = 0.5 * (w * omega + cross(u, omega))
            of_rotations[:, SCALAR] = -0.5 * (u * omega).sum(axis=1)[:, None]
            gyroscopic = cross(omega, self._moments * omega)
            of_rotations[:, OMEGA] = (_rotate(_conjugate(q), torque) - gyroscopic) * self._inverses
        if not np.isfinite(out).all():  # scipy would look for a step for ever
            raise FloatingPointError('a slope is not finite')
        return out

    def _count(self, time: float) -> None:
        """Count an evaluation at a time [s] of the tick, which ends if there would be too many."""
        self._evaluations += 1
        if self._evaluations >= MOST:
            raise _TooMany
        if self._evaluations == FIRST_LOOK:
            h = self._tick[1]
            if time * 5 * MOST < FIRST_LOOK * h:
                raise _TooMany

    def advance(self, method: str, tick: int, h: float) -> bool:
        """Advance over one tick; tell whether the solver reached its end."""
        from scipy.integrate import solve_ivp

        self._tick, self._evaluations = (tick * h, h), 0
        start = self._read()
        with np.errstate(
            all='ignore'
        ):  # a state that leaves the finite numbers shows in the result
            try:
                result = solve_ivp(
                    self.slope,
                    (0.0, h),
                    start,
                    method=method,
                    **self._tolerances,
                )
            except _TooMany:
                raise
            except (
                ArithmeticError,
                ValueError,
            ):  # `slope`, the solver or a plain kernel met infinity
                return False
        if not result.success:
            return False
        self._write(*self._unpack(result.y[:, -1]))
        return True

    def finite(self) -> float:
        """Give 0, or NaN if a number left the finite ones."""
        return finite(*self._sizes, *self._arguments[:2])


def _conjugate(q: Array) -> Array:
    return q * (-1.0, -1.0, -1.0, 1.0)


def _rotate(q: Array, v: Array) -> Array:
    """Rotate rows from body to world axes, see `blocks.rotate`."""
    u, w = q[:, AXIS], q[:, SCALAR]
    t = 2.0 * cross(u, v)
    return v + w * t + cross(u, t)
