# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From positions and orientations over time to velocities, accelerations and the wrench that explains
them.

    v = r',  a = r''                        from a spline through the samples, or near noisy ones
    s(t) a spline likewise through or near the unit quaternions, q = s / |s|
    w  = 2 vec(s' s*) / |s|^2                                       [rad/s], world axes
    w' = 2 vec(s'' s*) / |s|^2 - 2 (s . s') / |s|^2 w               [rad/s^2]
    F  = m a - m g                                                  [N]
    torque = d/dt (R I R^T w) = R (I w'_B + w_B x I w_B + I' w_B)   [N m]

The wrench is what acts beside the uniform gravity g: at the centre of mass, world axes. For a body
whose mass flows it is that of the model in `model.variable_mass`, thrust included.

A force that jumps between samples is smeared over their spacing and makes a spline ring; `breaks`
names such instants, at which the spline is only as smooth as the motion (`piecewise_spline`).
Samples with white noise are smoothed, with the bandwidth that has the least estimated error or one
that is asked for (`derivatives_with_bands`). The error of each quantity is estimated: what noise
does to it, what the spline cannot follow and, if they are known, what the steps of a run left in
it (`run_steps`). The ends of a record are its worst places.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.analysis.derivatives_with_bands import (
    Errors,
    Fit,
    Followed,
    blind_spots,
    errors,
    follow,
    steep,
    unsure,
)
from rigid_body_sim.analysis.piecewise_spline import BEFORE, NEAR, Break, End, Undetermined
from rigid_body_sim.analysis.run_steps import RunSteps, left_in_first, left_in_second
from rigid_body_sim.analysis.samples import need_bandwidth, need_motion, vector_of
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import moments_at, rates_at
from rigid_body_sim.physics.model.scene import Body, Vector
from rigid_body_sim.physics.model.variable_mass import mass_at

Array = NDArray[np.float64]

QUATERNION = 4  # columns


@dataclass(frozen=True, eq=False)
class Derived:
    """
    What the motion of one body tells, world axes, one row per sample.

    velocity, angular_velocity         : (k, 3) [m/s], [rad/s]; where an impulse strikes at a
                                         sample, those before it, as a run records them
    acceleration, angular_acceleration : (k, 3) [m/s^2], [rad/s^2]
    force, torque                      : (k, 3) [N], [N m]; None where no mass is known
    deviation : one standard deviation (k, 3) of each of these by its name, noise and what the
                spline cannot follow; without any where the samples are too few for one
    smoothing : what was found and done, of 'position' and 'orientation'
    """

    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array
    force: Array | None
    torque: Array | None
    deviation: dict[str, Array]
    smoothing: dict[str, Smoothing]


@dataclass(frozen=True)
class Estimate:
    """
    Estimated error of one quantity: root of the mean square over the samples, and the largest.
    """

    rms: float
    largest: float


@dataclass(frozen=True)
class Smoothing:
    """
    How the samples of a position or an orientation were taken.

    noise     : [m] or [rad] standard deviation along or about each axis; zero: no more than
                rounding
    bandwidth : [Hz] faster motion is not followed
    smoothed  : False: the spline goes through the samples
    breaks    : how many jumps it has
    found     : [s] instants of those among them that were not given, found in the samples
    steep     : [s] from and to: stretches in which the samples change faster than they tell, by
                jumps that are not known or last; the deviations are wide there
    dropped   : [s] instants of jumps too near to others to be told apart at this rate of samples
    """

    noise: float
    bandwidth: float
    smoothed: bool
    breaks: int
    found: tuple[float, ...]
    steep: tuple[tuple[float, float], ...]
    dropped: tuple[float, ...]

    def later(self, seconds: float) -> Smoothing:
        """Give the same with all instants so much later [s]."""
        return replace(
            self,
            found=tuple(instant + seconds for instant in self.found),
            steep=tuple((begin + seconds, end + seconds) for begin, end in self.steep),
            dropped=tuple(instant + seconds for instant in self.dropped),
        )


@dataclass(frozen=True, eq=False)
class KnownEnds:
    """
    What is known of a motion at its first and its last sample; it is kept exactly.

    start_velocity, end_velocity : (3,) [m/s]; None: not known
    at_rest                      : whether the body neither moves nor turns at either
    """

    start_velocity: ArrayLike | None = None
    end_velocity: ArrayLike | None = None
    at_rest: bool = False


def derive(
    time: Array,
    position: Array,
    orientation: Array,
    *,
    body: Body | None = None,
    gravity: Vector = (0.0, 0.0, 0.0),
    breaks: Sequence[float | Break] = (),
    turning_breaks: Sequence[float | Break] | None = None,
    bandwidth: float | None = None,
    ends: KnownEnds | None = None,
    steps: RunSteps | None = None,
    tick: float = 0.0,
    unit: float = 1.0,
) -> tuple[Derived, dict[str, Estimate]]:
    """
    Derive velocities, accelerations and the wrench, and estimate their errors.

        time        : (k,) [unit] ascending, k >= 6; since the start of the scene where a mass
                                  flows or an inertia changes
        position    : (k, 3) [m]  centre of mass, world
        orientation : (k, 4) [-]  xyzw, body to world; turns by less than pi between samples
        body        : its mass properties; None: no wrench
        breaks      : [unit] instants at which a force jumps, or a `Break` for an impulse
        turning_breaks : those at which a torque jumps; None: the same
        bandwidth   : [Hz] faster motion is taken for noise; None: found from the samples
        ends        : what is known of the motion at the first and the last sample
        steps       : of the run that made the motion: what they left in it counts as error
        tick        : [unit] in whose steps forces act that jump when they are not known to; zero:
                      at any instant
        unit        : [s] of the times: whole nanoseconds are exact where seconds are rounded
        returns     : the quantities, and the estimates by name; without any where the samples are
                      too few for one

    Raises UserError for samples that tell no motion, or a bandwidth that is not positive.
    """
    need_motion(time, position, unit=unit)
    need_bandwidth(bandwidth)
    if not np.all(np.isfinite(orientation)):
        raise UserError('orientations hold NaN or infinity; every number must be finite')
    turning = breaks if turning_breaks is None else turning_breaks
    quaternions = continuous(so3.normalise(orientation))
    path_ends, turn_ends = _ends(ends or KnownEnds(), unit)
    path = _follow(time, position, breaks, path_ends, bandwidth, unit)
    turn = _follow(time, quaternions, turning, turn_ends, bandwidth, unit)
    found, judge = (
        _quantities(time, p, q, unit=unit, body=body, gravity=gravity)
        for p, q in ((path.fit.own, turn.fit.own), (path.fit.judge, turn.fit.judge))
    )
    judged = bool(np.any(path.fit.judged) and np.any(turn.fit.judged))
    told = _errors(time, found, judge, path, turn, unit, body, steps, tick) if judged else {}
    derived = Derived(
        found['velocity'],
        found['angular_velocity'],
        found['acceleration'],
        found['angular_acceleration'],
        found.get('force'),
        found.get('torque'),
        {name: error.deviation for name, error in told.items()},
        {'position': path.smoothing, 'orientation': turn.smoothing},
    )
    return derived, {name: Estimate(error.rms, error.largest) for name, error in told.items()}


def _ends(known: KnownEnds, unit: float) -> tuple[list[End], list[End]]:
    """Conditions of the path and of the turn."""
    path = []
    for side, what, given in ((0, 'start', known.start_velocity), (-1, 'end', known.end_velocity)):
        velocity = np.zeros(3) if given is None and known.at_rest else given
        if known.at_rest and np.any(velocity):
            raise UserError(f'{what} velocity {given} of a body at rest; give one of them')
        if velocity is not None:
            path.append(End(1, unit * vector_of(f'{what} velocity', velocity), side))
    turn = [End(1, np.zeros(4), side) for side in (0, -1)] if known.at_rest else []
    return path, turn


def continuous(quaternions: Array) -> Array:
    """Choose between q and -q so that neighbours (k, 4) are on the same side."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    signs = np.concatenate(([1.0], np.where(np.cumsum(flips) % 2 == 1, -1.0, 1.0)))
    return quaternions * signs[:, None]


@dataclass(frozen=True, eq=False)
class _Followed:
    """A position or an orientation with its derivatives."""

    samples: Followed
    smoothing: Smoothing

    @property
    def fit(self) -> Fit:
        """The spline."""
        return self.samples.fit


def _follow(
    time: Array,
    samples: Array,
    breaks: Sequence[float | Break],
    ends: Sequence[End],
    bandwidth: float | None,
    unit: float,
) -> _Followed:
    turns = samples.shape[1] == QUATERNION
    try:
        found = follow(
            time,
            samples,
            [b if isinstance(b, Break) else Break(float(b)) for b in breaks],
            ends,
            bandwidth=None if bandwidth is None else bandwidth * unit,
            turns=turns,
        )
    except Undetermined as error:
        raise UserError(f'{error}; are they of one motion, at times that differ?') from error
    axis_noise = float(np.sqrt(np.mean(np.square(found.noise))))
    if turns:  # a turn by a changes three of the four by a / 2
        axis_noise *= 2.0 * np.sqrt(4.0 / 3.0)
    smoothing = Smoothing(
        axis_noise,
        0.5 * found.fit.free / (float(time[-1] - time[0]) * unit),
        found.fit.smooths,
        len(found.layout.breaks),
        tuple(unit * b.instant for kink in found.kinks for b in kink.breaks),
        tuple((unit * begin, unit * end) for begin, end in steep(found, time)),
        tuple(unit * instant for instant in found.given_up),
    )
    return _Followed(found, smoothing)


def _quantities(
    time: Array,
    path: list[Array],
    turn: list[Array],
    *,
    unit: float,
    body: Body | None,
    gravity: Vector,
) -> dict[str, Array]:
    """Derive from values, first and second derivatives of position and quaternion."""
    s, s1, s2 = turn[0], turn[1] / unit, turn[2] / unit**2
    square = np.sum(s * s, axis=1, keepdims=True)
    back = so3.conjugate(s) / square
    growth = np.sum(s * s1, axis=1, keepdims=True) / square
    omega = 2.0 * so3.multiply(s1, back)[:, :3]
    omega_before = 2.0 * so3.multiply(turn[BEFORE] / unit, back)[:, :3]
    alpha = 2.0 * so3.multiply(s2, back)[:, :3] - 2.0 * growth * omega
    acceleration = path[2] / unit**2
    found = {
        'velocity': path[BEFORE] / unit,
        'angular_velocity': omega_before,
        'acceleration': acceleration,
        'angular_acceleration': alpha,
    }
    if body is None:
        return found
    share = _mass_share(body, time, unit)
    torque = np.zeros_like(acceleration)
    if body.inertia is not None:
        q = s / np.sqrt(square)
        w, turning = so3.rotate_back(q, omega), so3.rotate_back(q, alpha)
        inertia, rate = _inertia(body, time, unit)
        momentum = np.einsum('kij,kj->ki', inertia, w)
        changing = np.einsum('kij,kj->ki', inertia, turning) + np.einsum('kij,kj->ki', rate, w)
        torque = so3.rotate(q, changing + np.cross(w, momentum))
    force = body.mass * (acceleration - np.asarray(gravity))
    return found | {'force': share * force, 'torque': share * torque}


def _mass_share(body: Body, time: Array, unit: float) -> Array:
    """m(t) / m0 as a column."""
    if body.mass_flow is None:
        return np.ones((len(time), 1))
    return np.array([mass_at(body, t * unit) / body.mass for t in time.tolist()])[:, None]


def _inertia(body: Body, time: Array, unit: float) -> tuple[Array, Array]:
    """
    Inertia at each sample and its rate there, both (k, 3, 3), body axes.

    At a row the rate is that of the side from which the spline has its derivatives: what follows,
    at the last sample what was before. A row is at a sample where a break would be (`NEAR`).
    """
    law = body.inertia_over_time
    if body.inertia is None or law is None:
        inertia = np.zeros((3, 3)) if body.inertia is None else body.inertia
        same = np.broadcast_to(inertia, (len(time), 3, 3))
        return same, np.zeros_like(same)
    seconds = (time * unit).tolist()
    near = NEAR * np.diff(time)
    toward = (np.append(time[:-1] + 2.0 * near, time[-1] - 2.0 * near[-1]) * unit).tolist()
    now = np.array([np.diag(moments_at(law, t)) for t in seconds])
    rates = [rates_at(law, t, toward=beside) for t, beside in zip(seconds, toward)]
    return now, np.array([np.diag(rate) for rate in rates])


def _errors(
    time: Array,
    found: dict[str, Array],
    judge: dict[str, Array],
    path: _Followed,
    turn: _Followed,
    unit: float,
    body: Body | None,
    steps: RunSteps | None,
    tick: float,
) -> dict[str, Errors]:
    """What noise does to each quantity, and in its distance to the judge."""
    by_steps = _left_by_steps(time * unit, found, path, turn, unit, body, steps)
    strays = {id(each): unsure(each.samples, time, tick) for each in (path, turn)}

    def told(
        name: str,
        followed: _Followed,
        order: int,
        square: Array | float,
        second: Array,
        gyroscopic: Array | float = 0.0,
    ) -> Errors:
        """Square: (n, 3) of the quantity for a derivative of one."""
        fit, noise = followed.fit, along if followed is path else about
        factor, gyroscopic = noise * square, noise * gyroscopic
        blind = blind_spots(fit, time, second)
        if order != 2:
            blind *= 0.5 * unit * fit.span[:, None]
        by_noise, in_distance = (
            spread[order][:, None] * factor / (unit**4 if order == 2 else unit**2)
            + spread[1][:, None] * gyroscopic / unit**2
            for spread in (fit.response, fit.disagreement)
        )
        low = 2 if order == 2 else 1
        blind = blind + strays[id(followed)][low][:, None] * np.sqrt(square) * (
            (1.0 if followed is path else 2.0) / unit**low  # |w| = 2 |q'|
        )
        blind = blind + by_steps.get(name, 0.0)
        return errors(fit, found[name], judge[name], by_noise, in_distance, blind)

    one = np.ones((len(time), 3))
    along, about = np.square(path.samples.noise) * one, np.square(turn.smoothing.noise) * one
    linear, angular = found['acceleration'], found['angular_acceleration']
    result = {
        'velocity': told('velocity', path, BEFORE, 1.0, linear),
        'angular_velocity': told('angular_velocity', turn, BEFORE, 1.0, angular),
        'acceleration': told('acceleration', path, 2, 1.0, linear),
        'angular_acceleration': told('angular_acceleration', turn, 2, 1.0, angular),
    }
    if body is None:
        return result
    share = np.square(_mass_share(body, time, unit))
    result['force'] = told('force', path, 2, share * body.mass**2, body.mass * linear)
    in_world = _inertia_in_world(turn, body, time, unit)
    by_rate = _gyroscopic(in_world, found['angular_velocity'])
    result['torque'] = told(
        'torque',
        turn,
        2,
        share * np.sum(np.square(in_world), axis=2),
        np.einsum('kij,kj->ki', in_world, angular),
        share * np.sum(np.square(by_rate), axis=2),
    )
    return result


def _inertia_in_world(turn: _Followed, body: Body, time: Array, unit: float) -> Array:
    """Inertia at each sample (k, 3, 3) in world axes."""
    inertia, _ = _inertia(body, time, unit)
    s = turn.fit.own[0]
    matrices = so3.matrix_from_quaternion(s / np.linalg.norm(s, axis=1, keepdims=True))
    return matrices @ inertia @ np.swapaxes(matrices, 1, 2)


def _left_by_steps(
    seconds: Array,
    found: dict[str, Array],
    path: _Followed,
    turn: _Followed,
    unit: float,
    body: Body | None,
    steps: RunSteps | None,
) -> dict[str, Array]:
    """What the steps of the run left in each quantity, (k, 3)."""
    if steps is None or body is None:
        return {}
    linear, along, about = found['acceleration'], path.fit.piece, turn.fit.piece
    left = {
        'velocity': left_in_first(steps, steps.order, seconds, along, linear),
        'acceleration': left_in_second(steps, steps.order, seconds, along, linear),
        'force': left_in_second(steps, steps.order, seconds, along, found['force']),
    }
    if body.inertia is None:
        return left
    in_world = _inertia_in_world(turn, body, seconds / unit, unit)
    driving, omega = found['torque'], found['angular_velocity']
    if not steps.turns_free:
        driving = np.einsum('kij,kj->ki', in_world, found['angular_acceleration'])
    turned = np.abs(driving) * np.sum(np.square(omega), axis=1, keepdims=True)
    left['torque'] = left_in_second(steps, steps.turn_order, seconds, about, driving, turned)
    by_torque = np.abs(np.linalg.inv(in_world))
    first = left_in_first(steps, steps.turn_order, seconds, about, driving)
    left['angular_acceleration'] = np.einsum('kij,kj->ki', by_torque, left['torque'])
    left['angular_velocity'] = np.einsum('kij,kj->ki', by_torque, first)
    return left


def _gyroscopic(inertia: Array, omega: Array) -> Array:
    """Derivative (k, 3, 3) of w x I w by w: [w] I - [I w]."""

    def crossing(v: Array) -> Array:
        return np.cross(v[:, None, :], np.eye(3)[None]).swapaxes(1, 2)

    momentum = np.einsum('kij,kj->ki', inertia, omega)
    return crossing(omega) @ inertia - crossing(momentum)
