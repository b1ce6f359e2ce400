# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies that are moved as told: decks, shakers, docking targets, turntables. No force and no contact
changes their motion.

A point P of the body follows a path, about which the body turns:

    x(t) = x_0 + v_0 t + d(t)
    R(t) = Rz(yaw) Ry(pitch) Rx(roll) exp(t [w_0]) R_0
    d = (surge, sway, heave), each of the six a sum of A sin(2 pi t/T + phase) and of a table

        x_0                : of P, which the position of `initial` (of the centre of mass) puts
        R_0, v_0, w_0      : orientation, velocity and angular velocity of `initial`: v_0 is that
                             of P, so that a centre of mass beside P circles about a point that
                             goes straight
        angles             : [rad] about axes that stand as those of the world

    omega = (cos yaw cos pitch roll' - sin yaw pitch', sin yaw cos pitch roll' + cos yaw pitch',
             yaw' - sin pitch roll') + Rz Ry Rx w_0

Between the rows of a table goes the cubic spline that is twice continuously differentiable and at
rest at both ends (clamped), before and after which the body keeps the first and the last row. So
position, velocity and acceleration are functions of time, exact at every instant; at the ends of a
table the acceleration jumps.

A path is one row of numbers for kernels (`head`, then `wave`s, then `interval`s): `path_of` makes
it for any point of the body, and `motion_at` evaluates it.

Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, section 2.2 (zyx).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.numbers import is_list, number, numbers, shown
from rigid_body_sim.physics.model.scene import Body, Oscillation, PrescribedMotion, Vector
from rigid_body_sim.physics.model.shapes import Plane, Surface
from rigid_body_sim.physics.model.tick_length import LONGEST_NS
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    load,
    load_quaternion,
    scale,
    store,
    store_quaternion,
)

Array = NDArray[np.float64]

WAYS = ('surge', 'sway', 'heave', 'roll', 'pitch', 'yaw')  # along x, y, z; about x, y, z
UNITS = ('m', 'm', 'm', 'rad', 'rad', 'rad')
SHORT_ROW, LONG_ROW = 4, 7  # numbers of a row of a table: time and path, without and with angles
CUBIC = 4  # coefficients
LONGEST = LONGEST_NS * 1e-9  # [s] of a run
NEAR = 1e-9  # [s] a tick so near to an end of a table is at it: times of ticks are rounded
ROUND_OFF = 1e-12  # [-] of places and arms: points about which bodies turn that are one
LARGEST = 1e150  # [m, rad, s^-n] of what a motion is made of: products of two are finite

head = Record()
POSITION = head.vector('m', 'x_0: of P, world')
ORIENTATION = head.quaternion('-', 'R_0')
VELOCITY = head.vector('m/s', 'v_0')
SPIN = head.vector('rad/s', 'w_0, world axes')
ARM = head.vector('m', 'from P to the point that is asked for, axes that ORIENTATION turns')
WAVES = head.number('-', 'how many follow')
INTERVALS = head.number('-', 'how many follow them; behind the last one, its end [s]')
HEAD = head.size

wave = Record()
WAY = wave.number('-', 'of `WAYS`')
AMPLITUDE = wave.number('m or rad', '')
RATE = wave.number('rad/s', '2 pi / period')
PHASE = wave.number('rad', '')
WAVE = wave.size

interval = Record()
BEGIN = interval.number('s', 'when it begins')
COEFFICIENTS = interval.numbers(CUBIC * len(WAYS), 'm or rad, s^-n', 'c0 to c3 of each way')
INTERVAL = interval.size

instant = Record()
AT_POSITION = instant.vector('m', 'of the point, world')
AT_ORIENTATION = instant.quaternion('-', '')
AT_VELOCITY = instant.vector('m/s', 'of the point, world')
AT_SPIN = instant.vector('rad/s', 'world axes')
AT_ACCELERATION = instant.vector('m/s^2', 'of the point, world')
AT_ANGULAR_ACCELERATION = instant.vector('rad/s^2', 'world axes')
# scratch: the six ways, along x, y, z and behind them about x, y, z; and how they change
WAYS_AT = instant.vector('m', 'along x, y, z')
ANGLES_AT = instant.vector('rad', 'about x, y, z')
RATES_AT = instant.vector('m/s', 'of the ways')
ANGULAR_RATES_AT = instant.vector('rad/s', 'of the angles')
CHANGES_AT = instant.vector('m/s^2', 'of the rates')
ANGULAR_CHANGES_AT = instant.vector('rad/s^2', 'of the rates of the angles')
INSTANT = instant.size


@inline
def _product(p: Any, q: Any) -> Any:
    """Quaternion p q, xyzw: q first."""
    p_x, p_y, p_z, p_w = p
    q_x, q_y, q_z, q_w = q
    return (
        p_w * q_x + p_x * q_w + p_y * q_z - p_z * q_y,
        p_w * q_y - p_x * q_z + p_y * q_w + p_z * q_x,
        p_w * q_z + p_x * q_y - p_y * q_x + p_z * q_w,
        p_w * q_w - p_x * q_x - p_y * q_y - p_z * q_z,
    )


@inline
def turned(q: Any, v: Any) -> Any:
    """Turn a vector by a unit quaternion."""
    x, y, z, w = q
    u = (x, y, z)
    twice = scale(2.0, cross(u, v))
    return add(add_scaled(v, w, twice), cross(u, twice))


@inline
def _angle(value: float) -> float:
    """The angle, and NaN where it is none: of infinity Python has no sine, compiled code NaN."""
    return value if -math.inf < value < math.inf else math.nan


@kernel
def _find_ways(paths: Array, path: int, time: float, out: Array) -> None:
    """Write the six ways at a time [s], their rates, and the rates of these."""
    for entry in range(WAYS_AT, INSTANT):
        out[entry] = 0.0
    place = path + HEAD
    for _wave in range(int(paths[path + WAVES])):
        way = int(paths[place + WAY])
        rate = paths[place + RATE]
        angle = _angle(rate * time + paths[place + PHASE])
        size, sine = paths[place + AMPLITUDE], math.sin(angle)
        out[WAYS_AT + way] += size * sine
        out[RATES_AT + way] += size * rate * math.cos(angle)
        out[CHANGES_AT + way] -= size * rate * rate * sine
        place += WAVE
    intervals = int(paths[path + INTERVALS])
    if intervals == 0:
        return
    low, high = 0, intervals
    while high - low > 1:
        middle = (low + high) // 2
        if paths[place + INTERVAL * middle + BEGIN] <= time:
            low = middle
        else:
            high = middle
    last = paths[place + INTERVAL * intervals]
    begin = paths[place]
    place += INTERVAL * low
    within = 1.0 if begin <= time < last else 0.0
    s = max(min(time, last) - paths[place + BEGIN], 0.0)
    for way in range(len(WAYS)):
        c = place + COEFFICIENTS + CUBIC * way
        c1, c2, c3 = load(paths, c + 1)
        out[WAYS_AT + way] += paths[c] + s * (c1 + s * (c2 + s * c3))
        out[RATES_AT + way] += within * (c1 + s * (2.0 * c2 + 3.0 * s * c3))
        out[CHANGES_AT + way] += within * (2.0 * c2 + 6.0 * s * c3)


@kernel
def motion_at(paths: Array, path: int, time: float, out: Array) -> None:
    """
    Evaluate a path at a time [s] since the start of the scene.

    path : where it begins;   out : written, `instant`
    """
    _find_ways(paths, path, time, out)
    roll, pitch, yaw = load(out, ANGLES_AT)
    roll, pitch, yaw = _angle(roll), _angle(pitch), _angle(yaw)
    roll_1, pitch_1, yaw_1 = load(out, ANGULAR_RATES_AT)
    roll_2, pitch_2, yaw_2 = load(out, ANGULAR_CHANGES_AT)
    spin = load(paths, path + SPIN)
    rate = math.sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2])
    half = _angle(0.5 * rate * time)
    sine = math.sin(half) / rate if rate > 0.0 else 0.0
    steady = (sine * spin[0], sine * spin[1], sine * spin[2], math.cos(half))
    about_z = (0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))
    about_y = (0.0, math.sin(0.5 * pitch), 0.0, math.cos(0.5 * pitch))
    about_x = (math.sin(0.5 * roll), 0.0, 0.0, math.cos(0.5 * roll))
    euler = _product(_product(about_z, about_y), about_x)
    q = _product(_product(euler, steady), load_quaternion(paths, path + ORIENTATION))
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    of_angles = (
        cy * cp * roll_1 - sy * pitch_1,
        sy * cp * roll_1 + cy * pitch_1,
        yaw_1 - sp * roll_1,
    )
    carried = turned(euler, spin)
    omega = add(of_angles, carried)
    alpha = (
        cy * cp * roll_2 - sy * pitch_2 - cy * yaw_1 * pitch_1
        - sy * cp * yaw_1 * roll_1 - cy * sp * pitch_1 * roll_1,
        sy * cp * roll_2 + cy * pitch_2 - sy * yaw_1 * pitch_1
        + cy * cp * yaw_1 * roll_1 - sy * sp * pitch_1 * roll_1,
        yaw_2 - sp * roll_2 - cp * pitch_1 * roll_1,
    )  # fmt: skip
    alpha = add(alpha, cross(of_angles, carried))
    arm = turned(q, load(paths, path + ARM))
    around = cross(omega, arm)
    way = add_scaled(load(out, WAYS_AT), time, load(paths, path + VELOCITY))
    store(out, AT_POSITION, add(add(load(paths, path + POSITION), way), arm))
    store_quaternion(out, AT_ORIENTATION, q)
    velocity = add(load(paths, path + VELOCITY), load(out, RATES_AT))
    store(out, AT_VELOCITY, add(velocity, around))
    store(out, AT_SPIN, omega)
    bent = add(cross(alpha, arm), cross(omega, around))
    store(out, AT_ACCELERATION, add(load(out, CHANGES_AT), bent))
    store(out, AT_ANGULAR_ACCELERATION, alpha)


def path_of(body: Body, point: Vector, turn: Any = so3.IDENTITY) -> Array:
    """
    Make the row of numbers for a point of a body.

    point : (3,) [m]  body coordinates
    turn  : (4,) [-]  axes that are asked for, to body axes
    """
    motion = body.motion
    assert motion is not None
    followed = body.center_of_mass if motion.point is None else motion.point
    start = body.initial
    to_followed = so3.rotate(start.orientation, np.subtract(followed, body.center_of_mass))
    numbers_of_head = np.zeros(HEAD)
    numbers_of_head[head.span(POSITION)] = np.asarray(start.position) + to_followed
    numbers_of_head[head.span(ORIENTATION)] = so3.multiply(start.orientation, turn)
    numbers_of_head[head.span(VELOCITY)] = start.velocity
    numbers_of_head[head.span(SPIN)] = start.angular_velocity
    arm = np.subtract(point, followed)
    numbers_of_head[head.span(ARM)] = so3.rotate_back(turn, arm)
    waves = [
        (way, each.amplitude, 2.0 * math.pi / each.period, each.phase)
        for way, name in enumerate(WAYS)
        for each in getattr(motion, name)
    ]
    numbers_of_head[WAVES] = len(waves)
    intervals = np.zeros(0)
    if motion.table:
        intervals = _intervals(motion)
        numbers_of_head[INTERVALS] = len(motion.table) - 1
    return np.concatenate((numbers_of_head, np.array(waves, dtype=np.float64).ravel(), intervals))


def _turns(path: Array) -> bool:
    """Tell whether the body of a path ever turns."""
    waves = path[HEAD : HEAD + WAVE * int(path[WAVES])].reshape(-1, WAVE)
    if np.any(path[head.span(SPIN)]) or np.any(waves[waves[:, WAY] > 2, AMPLITUDE]):
        return True
    begin = HEAD + waves.size
    intervals = path[begin : begin + INTERVAL * int(path[INTERVALS])].reshape(-1, INTERVAL)
    return bool(np.any(intervals[:, COEFFICIENTS + 3 * CUBIC :]))


def greatest_rates(body: Body) -> tuple[Array, Array]:
    """
    Bound how fast the six ways of a body change, waves and table together, without what goes on
    evenly: rates (6,) [m/s, rad/s], and the rates of these (6,) [m/s^2, rad/s^2].
    """
    motion = body.motion
    assert motion is not None
    rates, changes = np.zeros(len(WAYS)), np.zeros(len(WAYS))
    for way, name in enumerate(WAYS):
        for each in getattr(motion, name):
            turning = 2.0 * math.pi / each.period
            rates[way] += abs(each.amplitude) * turning
            changes[way] += abs(each.amplitude) * turning * turning
    if motion.table:
        rows = _intervals(motion)[:-1].reshape(-1, INTERVAL)
        c = rows[:, COEFFICIENTS:].reshape(len(rows), len(WAYS), CUBIC)
        lengths = np.diff([row[0] for row in motion.table])[:, None]
        with np.errstate(all='ignore'):  # a change that goes on evenly turns nowhere
            turns = np.clip(np.nan_to_num(-c[..., 2] / (3.0 * c[..., 3])), 0.0, lengths)
        of_table = np.zeros((2, len(WAYS)))
        for s in (np.zeros_like(lengths), lengths, turns):
            rate = c[..., 1] + s * (2.0 * c[..., 2] + 3.0 * s * c[..., 3])
            change = 2.0 * c[..., 2] + 6.0 * s * c[..., 3]
            of_table = np.maximum(of_table, np.abs((rate, change)).max(axis=1))
        rates, changes = rates + of_table[0], changes + of_table[1]
    return rates, changes


def what_is_common(path: Array) -> bytes:
    """Give what the paths of all points of a body have in common."""
    of_all = path.copy()
    for begin, end in ((POSITION, VELOCITY), (ARM, WAVES)):
        of_all[begin:end] = 0.0
    return (of_all + 0.0).tobytes()  # of the two zeros one


def are_of_one_body(path: Array, other: Array) -> bool:
    """
    Tell whether points with these paths, whose `what_is_common` is the same, keep their place to
    each other: where nothing turns, or all turn about one point.
    """
    if not _turns(path):
        return True
    place, of_other = path[head.span(POSITION)], other[head.span(POSITION)]
    arms = np.concatenate((path[head.span(ARM)], other[head.span(ARM)]))
    size = max(np.max(np.abs(place)), np.max(np.abs(arms)))
    return bool(np.all(np.abs(place - of_other) <= ROUND_OFF * size))


def from_end_of_table(path: Array, time: float) -> float:
    """
    Give the time [s] itself, or the end of the table that it is at but for rounding: from there
    on the acceleration is another.
    """
    if path[INTERVALS] == 0.0:
        return time
    first = float(path[HEAD + WAVE * int(path[WAVES]) + BEGIN])
    for end in (first, float(path[-1])):
        if abs(time - end) < NEAR:
            return end
    return time


def _intervals(motion: PrescribedMotion) -> Array:
    """Coefficients of the spline through a table, and its end."""
    from scipy.interpolate import CubicSpline  # slow to import: only for those who ask

    rows = np.zeros((len(motion.table), LONG_ROW))
    rows[:, : len(motion.table[0])] = motion.table
    times, ways = rows[:, 0], rows[:, 1:]
    at_rest = (1, np.zeros(len(WAYS)))
    with np.errstate(all='ignore'):
        ends: Any = (at_rest, at_rest)
        spline = CubicSpline(times, ways, axis=0, bc_type=ends)
        coefficients = np.moveaxis(spline.c[::-1], 0, -1)
    if not np.all(np.abs(coefficients) < LARGEST):
        raise InvalidModel(
            'between the rows of the table the body moves faster than numbers can tell; check '
            'its times and units',
            at=('table',),
        )
    each = np.concatenate((times[:-1, None], coefficients.reshape(len(times) - 1, -1)), axis=1)
    return np.append(each.ravel(), times[-1])


def check_motion(body: Body) -> None:
    """Refuse a motion that no body, or not this one, can be told."""
    motion = body.motion
    if motion is None:
        return
    name = repr(body.name)
    if not isinstance(motion, PrescribedMotion):
        raise InvalidModel(f'got {shown(motion)}; a PrescribedMotion is needed')
    if not body.fixed:
        raise InvalidModel(f'{name} moves as told, so nothing else moves it: fixed must be True')
    if isinstance(body.shape, Plane):
        raise InvalidModel(f'{name} is a plane, which stands still; move a box in its place')
    if isinstance(body.shape, Surface):
        raise InvalidModel(
            f'{name} is ground of triangles, which stands still; move a box or a union'
        )
    for key, said in (('pivot', body.pivot), ('inertia_over_time', body.inertia_over_time)):
        if said is not None:
            raise InvalidModel(f'{name} moves as told; remove {key}, or motion')
    if any(body.surface_velocity):
        raise InvalidModel(f'{name} moves as told; remove surface_velocity, or motion')
    for way, unit in zip(WAYS, UNITS, strict=True):
        with blaming(way):
            if not is_list(getattr(motion, way)):
                raise InvalidModel(
                    f'got {shown(getattr(motion, way))}; a tuple of Oscillations is needed'
                )
            for each in getattr(motion, way):
                _check_oscillation(each, unit)
    if motion.point is not None:
        with blaming('point'):
            numbers(motion.point, 3, unit='m')
    with blaming('table'):
        _check_table(motion.table)
    _check_start(body)
    waves = any(getattr(motion, way) for way in WAYS)
    if not (
        waves or motion.table or any((*body.initial.velocity, *body.initial.angular_velocity))
    ):
        raise InvalidModel(
            f'nothing moves {name}: give heave, roll …, a table, or initial velocities; or '
            'remove motion and set fixed'
        )


def _check_oscillation(each: Any, unit: str) -> None:
    if not isinstance(each, Oscillation):
        raise InvalidModel(f'got {shown(each)}; an Oscillation is needed')
    number(each.amplitude, unit=unit)
    number(each.phase, unit='rad')
    if not number(each.period, unit='s') > 0.0:
        raise InvalidModel(f'got {shown(each.period)}; a positive period [s] is needed')
    rate = 2.0 * math.pi / each.period
    speed = abs(each.amplitude) * rate
    if not max(abs(each.amplitude), speed, speed * rate, rate * LONGEST) < LARGEST:
        raise InvalidModel(
            f'an amplitude of {each.amplitude:g} {unit} in a period of {each.period:g} s is '
            'further or faster than numbers can tell; check both and their units'
        )


def _check_start(body: Body) -> None:
    """Refuse a steady motion that leaves all numbers within the longest run."""
    for key, unit in (('velocity', 'm/s'), ('angular_velocity', 'rad/s')):
        rates = numbers(getattr(body.initial, key), 3, unit=unit)
        if not max(abs(rate) for rate in rates) * LONGEST < LARGEST:
            raise InvalidModel(
                f'{body.name!r} moves as told, and its initial {key} of {shown(list(rates))} '
                f'{unit} is faster than numbers can tell'
            )


def _check_table(table: Any) -> None:
    if not is_list(table):
        raise InvalidModel(f'got {shown(table)}; a list of rows is needed')
    if not len(table):
        return
    for row in table:
        width = len(row) if is_list(row) else 0
        if width not in (SHORT_ROW, LONG_ROW) or width != len(table[0]):
            raise InvalidModel(
                f'got the row {shown(row)}; all rows must be (t, x, y, z) or all '
                '(t, x, y, z, roll, pitch, yaw) [s, m, rad]'
            )
        numbers(row, width, unit='s, m, rad')
    if len(table) < 2:
        raise InvalidModel('at least two rows are needed')
    for place in range(1, len(table)):
        if not table[place][0] > table[place - 1][0]:
            raise InvalidModel(
                f'row {place}, at {table[place][0]:g} s, is not later than the one before; times '
                'must ascend'
            )
