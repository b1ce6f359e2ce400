# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a scene's forces look like: ties between points, pivots, and the arrows of drag and drives.

An end of a tie is a point of a body as seen from its centre of mass, in body axes, or a point of
the world. Drag is computed from the recorded velocities, a constant or tabulated wrench from the
scene and the recorded attitude: the formulas are those of `physics.forces.elements`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from rigid_body_sim.physics.forces.elements.bumper import Bumper
from rigid_body_sim.physics.forces.elements.constant import Constant
from rigid_body_sim.physics.forces.elements.drag import Drag
from rigid_body_sim.physics.forces.elements.spring import Spring
from rigid_body_sim.physics.forces.elements.time import TimeTable
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Body, Scene

Array = NDArray[np.float64]

WORLD = -1  # place of an end that no body has
COIL = 0.09  # [-] radius of a coil, of the length of its spring
SLIM = 0.5  # [-] radius of a coil at most, of the arrow that suits the scene


@dataclass(frozen=True, eq=False)
class ArrowSet:
    """
    Vectors of some bodies over time.

    kind    : of ARROWS in page/palette.js
    bodies  : (m,)  places in the page
    at      : (m, 3) [m]  where each arrow begins, as seen from the centre of mass, body axes
    vectors : (k, m, 3) [N] or [N m]  world axes
    """

    kind: str
    bodies: list[int]
    at: list[list[float]]
    vectors: Array


def drawn_ties(
    scene: Scene | None, places: Mapping[str, int], arrow: float
) -> list[dict[str, Any]]:
    """
    Give springs, bumpers and pivots.

    places : of the bodies in the page, by name; what ties others is left out
    arrow  : [m] length that suits the scene
    """
    if scene is None:
        return []
    bodies = {body.name: body for body in scene.bodies}
    ties: list[dict[str, Any]] = []
    for force in scene.forces:
        if not isinstance(force, Spring | Bumper) or not {force.a, force.b} <= {*places, 'world'}:
            continue
        ends = {
            'a': _end(force.a, force.a_point, bodies, places),
            'b': _end(force.b, force.b_point, bodies, places),
        }
        if isinstance(force, Bumper):
            radius = min(0.5 * SLIM * arrow, 0.4 * force.length)
            more = {'kind': 'bumper', 'length': force.length, 'radius': radius}
        else:
            long = force.rest_length or arrow
            radius = min(SLIM * arrow, COIL * long)
            more = {'kind': 'spring', 'damping': force.damping, 'radius': radius, 'long': long}
        ties.append(ends | more)
    for body in scene.bodies:
        if body.pivot is not None and body.name in places:
            at = list(body.pivot.at)
            radius = 0.12 * arrow
            ties.append({'kind': 'pivot', 'body': places[body.name], 'at': at, 'radius': radius})
    return ties


def _end(
    name: str, point: Sequence[float] | None, bodies: Mapping[str, Body], places: Mapping[str, int]
) -> dict[str, Any]:
    if name == 'world':
        return {'body': WORLD, 'at': list(point or (0.0, 0.0, 0.0))}
    return {'body': places[name], 'at': _from_center(bodies[name], point)}


def _from_center(body: Body, point: Sequence[float] | None) -> list[float]:
    """Point of a body (3,) [m] as seen from its centre of mass; None: the centre itself."""
    if point is None:
        return [0.0, 0.0, 0.0]
    return np.subtract(point, body.center_of_mass).tolist()


@dataclass(frozen=True, eq=False)
class RecordedStates:
    """
    All bodies of a page at its instants.

    time                       : (k,) [s]  since the scene began
    orientation                : (k, n, 4) [-] xyzw
    velocity, angular_velocity : (k, n, 3) [m/s], [rad/s], world axes
    """

    time: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array


def force_arrows(
    scene: Scene | None,
    places: Mapping[str, int],
    states: RecordedStates,
    *,
    idle: bool = False,
) -> list[ArrowSet]:
    """Give drag and drives, a set for each kind that acts; `idle`: also those that do not yet."""
    if scene is None:
        return []
    bodies = {body.name: body for body in scene.bodies}
    found: dict[str, list[tuple[int, list[float], Array]]] = {}
    for force in scene.forces:
        if not isinstance(force, Drag | Constant | TimeTable) or force.body not in places:
            continue
        place = places[force.body]
        kind = 'drag' if isinstance(force, Drag) else 'drive'
        point = None if isinstance(force, Drag) else force.point
        at = _from_center(bodies[force.body], point)
        vectors = (
            _drag(force, states, place)
            if isinstance(force, Drag)
            else _drive(force, states, place)
        )
        for name, vector in zip((kind, f'{kind}_torque'), vectors, strict=True):
            if idle or np.any(vector):
                found.setdefault(name, []).append((place, at, vector))
    return [
        ArrowSet(
            kind,
            [place for place, _, _ in rows],
            [at for _, at, _ in rows],
            np.stack([vector for _, _, vector in rows], axis=1),
        )
        for kind, rows in found.items()
    ]


def _drag(force: Drag, states: RecordedStates, place: int) -> tuple[Array, Array]:
    v, w = states.velocity[:, place], states.angular_velocity[:, place]
    speed, rate = (np.linalg.norm(each, axis=1, keepdims=True) for each in (v, w))
    return (
        -(force.linear + force.quadratic * speed) * v,
        -(force.angular + force.angular_quadratic * rate) * w,
    )


def _drive(force: Constant | TimeTable, states: RecordedStates, place: int) -> tuple[Array, Array]:
    """Force and torque (k, 3) that a scene prescribes, world axes."""
    if isinstance(force, Constant):
        wrench = np.tile((*force.force, *force.torque), (len(states.time), 1))
    else:
        wrench = _tabulated(force, states.time)
    if force.frame == 'body':
        turns = states.orientation[:, place]
        return rotation.rotate(turns, wrench[:, :3]), rotation.rotate(turns, wrench[:, 3:])
    return wrench[:, :3], wrench[:, 3:]


def _tabulated(force: TimeTable, time: Array) -> Array:
    table = np.array(force.table, dtype=np.float64)
    instants, rows = table[:, 0], table[:, 1:]
    inside = np.clip(time, instants[0], instants[-1])
    if force.interpolation == 'cubic':
        values = CubicSpline(instants, rows, bc_type='not-a-knot')(inside)
    else:
        values = np.stack([np.interp(inside, instants, column) for column in rows.T], axis=1)
    if force.outside == 'zero':
        values[(time < instants[0]) | (time > instants[-1])] = 0.0
    return np.hstack((values, np.zeros((len(time), 6 - values.shape[1]))))
