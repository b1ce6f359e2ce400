# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From the bodies of a scene to the arrays of the kernels, and back to names.

The kernels keep moving bodies only, rigid ones first, then point masses, each in scene order
("core order"), and turn rigid bodies about their principal axes. The principal frame is fixed in
the body: q_principal = q_body V, where the columns of V are the principal axes in body axes. Where
they coincide V = 1 and no bit is touched.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel, UnknownBody, blaming, nearest
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import check_inertia_over_time
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.physics.model.pivot import arm_of, check_pivot, inertia_of
from rigid_body_sim.physics.model.place import WORLD, Place
from rigid_body_sim.physics.model.plain_products import product, times
from rigid_body_sim.physics.model.principal_axes import principal_axes
from rigid_body_sim.physics.model.scene import Body, Scene, Vector
from rigid_body_sim.physics.model.variable_mass import check_flow, end_of_flow, flow_of
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    LANES,
    MOMENTS,
    MOMENTUM,
    ORIENTATION,
    POSITION,
    QW,
    ROTATION,
    ROTATION_STATE,
    TRANSLATION,
    TRANSLATION_STATE,
    blocks,
    gather,
    rows,
    scatter,
)

Array = NDArray[np.float64]
Matrix = Sequence[Sequence[float]]  # (3, 3), rows of plain numbers
NO_VECTOR: Vector = (0.0, 0.0, 0.0)

STATE_OF_POINT = TRANSLATION_STATE // LANES  # [-] numbers of a body's state
STATE_OF_TURN = ROTATION_STATE // LANES
NAMED = 8  # bodies that an error names


def turned_by(matrix: Matrix, vector: Vector) -> Vector:
    """Return M v, for the rows of a matrix."""
    x, y, z = vector
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def unknown_body(name: object, names: Sequence[str]) -> UnknownBody:
    """Say that none of the names is that, and which is near."""
    known = ', '.join(names[:NAMED]) + (', …' if len(names) > NAMED else '')
    near = nearest(name, names)
    meant = '' if near is None else f'did you mean {near!r}? '
    return UnknownBody(f'no body is named {shown(name)}; {meant}the scene has: {known}')


class Layout:
    """
    Where each body of a scene is kept.

    places     : scene index by name
    moving     : (m,)   scene index of each body in core order
    n_rigid    : the first so many of them are rigid
    moments    : (n_rigid, 3) [kg m^2]  principal moments, about the pivot of a body that has one
    principal  : (n_rigid, 4) [-]       quaternion of V, principal to body axes
    to_principal : (9 n_rigid,) [-]     V^T, row by row
    pivoted    : core indices of the bodies that turn about a pivot
    """

    def __init__(self, scene: Scene) -> None:
        self.bodies = scene.bodies
        self.names = tuple(body.name for body in scene.bodies)
        self.places = {name: i for i, name in enumerate(self.names)}
        for i, body in enumerate(scene.bodies):
            if body.mass_flow is not None:
                with blaming('bodies', i):
                    check_flow(body)
            if body.inertia_over_time is not None:
                with blaming('bodies', i, 'inertia_over_time'):
                    check_inertia_over_time(body)
            if body.pivot is not None:
                with blaming('bodies', i, 'pivot'):
                    check_pivot(body)
        movable = [i for i, body in enumerate(scene.bodies) if not body.fixed]
        rigid = [i for i in movable if not scene.bodies[i].is_point]
        self.moving = np.array(
            rigid + [i for i in movable if scene.bodies[i].is_point], dtype=np.int64
        )
        self.n_moving = len(self.moving)
        self.n_rigid = len(rigid)
        self._core = {int(i): core for core, i in enumerate(self.moving)}
        self.masses = np.array([scene.bodies[i].mass for i in self.moving], dtype=np.float64)
        self.moments = np.zeros((self.n_rigid, 3))
        self._axes = np.zeros((self.n_rigid, 3, 3))
        for core, i in enumerate(rigid):
            with blaming('bodies', i, 'inertia'):
                self.moments[core], self._axes[core] = principal_axes(inertia_of(scene.bodies[i]))
        # plain numbers of V^T: products and sums as `times` has them, without arrays
        turned = np.swapaxes(self._axes, 1, 2)
        self._to_principal = turned.tolist()
        self.to_principal = np.ascontiguousarray(turned).reshape(-1)
        self.pivoted = [core for core, i in enumerate(rigid) if scene.bodies[i].pivot is not None]
        self.principal = so3.quaternion_from_matrix(self._axes).reshape(self.n_rigid, 4)

    def index(self, name: str) -> int:
        """Scene index of a body; UnknownBody, which is an InvalidModel, for an unknown name."""
        try:
            return self.places[name]
        except (KeyError, TypeError):  # TypeError: a list or an array is no name
            raise unknown_body(name, self.names) from None

    def core(self, name: str) -> int:
        """Core index of a moving body; InvalidModel for an unknown or a fixed one."""
        core = self._core.get(self.index(name))
        if core is None:
            if self.bodies[self.index(name)].motion is not None:
                raise InvalidModel(
                    f'{name!r} moves as told and cannot be pushed; choose a body without `motion`'
                )
            raise InvalidModel(
                f'{name!r} is fixed and cannot be pushed; choose a body without `fixed: true`'
            )
        return core

    def place(self, body: str, point: Vector | None) -> Place:
        """
        Find a point in shape coordinates of a body (None: its centre of mass), or in world
        coordinates for 'world'.
        """
        if body == WORLD:
            return Place(-1, -1, point or NO_VECTOR)
        index = self.index(body)
        record = self.bodies[index]
        arm = np.subtract(point, record.center_of_mass) if point is not None else np.zeros(3)
        core = self._core.get(index)
        if record.motion is not None:
            raise InvalidModel(
                f'{body!r} moves as told, and forces do not follow it yet; choose another body, '
                'or the world'
            )
        if core is None:
            start = record.initial
            return Place(-1, -1, as_vector(start.position + so3.rotate(start.orientation, arm)))
        if core < self.n_rigid:
            return Place(core, core, as_vector(times(self._axes[core].T, arm)))
        if np.any(arm):
            raise InvalidModel(
                f'{body!r} is a point mass and has no point {tuple(point or ())}; leave the '
                'point out'
            )
        return Place(core, -1, NO_VECTOR)

    def start_position(self, core: int) -> Vector:
        """Where the row of a body among the translations starts: see `model.pivot`."""
        body = self.body(core)
        return body.initial.position if body.pivot is None else body.pivot.at

    def arm(self, core: int) -> Vector:
        """Arm from the pivot of a body to its centre of mass [m], principal axes."""
        return as_vector(times(self._axes[core].T, arm_of(self.body(core))))

    def principal_axes(self, body: str, vector: Vector) -> Vector:
        """Turn a vector from the axes of a body into its principal axes."""
        return self.principal_axes_of(self.core(body), vector)

    def principal_axes_of(self, core: int, vector: Vector) -> Vector:
        """Turn a vector from the axes of a body, given by its core index, into principal axes."""
        if core >= self.n_rigid:
            name = self.body(core).name
            raise InvalidModel(f'{name!r} is a point mass and has no axes; use the frame world')
        return turned_by(self._to_principal[core], vector)

    def principal_axes_as_rows(self, core: int) -> Matrix:
        """Give the matrix by which `principal_axes_of` turns: its rows."""
        return self._to_principal[core]

    def mass(self, body: str) -> tuple[float, float, float]:
        """
        Give the mass of a body at the start [kg], its rate [kg/s] and how long that lasts [s];
        zero and zero if steady.
        """
        record = self.bodies[self.index(body)]
        flow = flow_of(record)
        return (
            (record.mass, 0.0, 0.0)
            if flow is None
            else (record.mass, flow.rate, end_of_flow(record))
        )

    def to_body_axes(self, matrices: Array) -> Array:
        """
        Turn matrices (n_rigid, 3, 3) from principal axes to world into those from body axes to
        world.
        """
        return product(matrices, np.swapaxes(self._axes, 1, 2))

    def translation(self) -> Array:
        """Make the translation blocks at the start of the scene."""
        array = np.zeros(blocks(self.n_moving) * TRANSLATION)
        if self.n_moving:
            starts = [self.start_position(core) for core in range(self.n_moving)]
            scatter(array, TRANSLATION, POSITION, np.array(starts))
            velocities = np.array([self.bodies[i].initial.velocity for i in self.moving])
            velocities[self.pivoted] = 0.0
            scatter(array, TRANSLATION, MOMENTUM, self.masses[:, None] * velocities)
            scatter(array, TRANSLATION, INVERSE_MASS, 1.0 / self.masses[:, None])
        return array

    def rotation(self) -> Array:
        """
        Make the rotation blocks at the start of the scene; empty lanes hold a unit sphere at rest.
        """
        array = np.zeros(blocks(self.n_rigid) * ROTATION)
        rows(array, ROTATION, QW, 1)[:] = 1.0
        rows(array, ROTATION, MOMENTS, 3)[:] = 1.0
        rows(array, ROTATION, INVERSE_MOMENTS, 3)[:] = 1.0
        if self.n_rigid:
            starts = [self.bodies[i].initial for i in self.moving[: self.n_rigid]]
            q = np.array([s.orientation for s in starts])
            turned = [not np.array_equal(v, np.eye(3)) for v in self._axes]
            q[turned] = so3.normalise(so3.multiply(q[turned], self.principal[turned]))
            with np.errstate(over='ignore', invalid='ignore'):  # the first tick will tell
                omega = so3.rotate_back(q, np.array([s.angular_velocity for s in starts]))
                momentum = so3.rotate(q, self.moments * omega)
            scatter(array, ROTATION, ORIENTATION, q)
            scatter(array, ROTATION, ANGULAR_MOMENTUM, momentum)
            scatter(array, ROTATION, MOMENTS, self.moments)
            scatter(array, ROTATION, INVERSE_MOMENTS, 1.0 / self.moments)
        return array

    def state_bytes(self, translation: Array, rotation: Array) -> bytes:
        """
        Give what a run must remember, core order, float64 little endian: r, p and their residuals,
        then q, L.
        """
        points = gather(translation, TRANSLATION, 0, STATE_OF_POINT, self.n_moving)
        turns = gather(rotation, ROTATION, 0, STATE_OF_TURN, self.n_rigid)
        return points.astype('<f8').tobytes() + turns.astype('<f8').tobytes()

    @property
    def state_size(self) -> int:
        """Count the bytes of `state_bytes`."""
        return 8 * (self.n_moving * STATE_OF_POINT + self.n_rigid * STATE_OF_TURN)

    def set_state_bytes(self, state: bytes, translation: Array, rotation: Array) -> None:
        """Restore what `state_bytes` gave."""
        wanted = self.state_size
        if len(state) != wanted:
            raise InvalidModel(f'a state of this scene has {wanted} bytes, got {len(state)}')
        numbers = np.frombuffer(state, dtype='<f8').astype(np.float64)
        split = self.n_moving * STATE_OF_POINT
        if self.n_moving:
            scatter(translation, TRANSLATION, 0, numbers[:split].reshape(-1, STATE_OF_POINT))
        if self.n_rigid:
            scatter(rotation, ROTATION, 0, numbers[split:].reshape(-1, STATE_OF_TURN))

    def body(self, core: int) -> Body:
        """Body at a place of the core order."""
        return self.bodies[int(self.moving[core])]


def as_vector(values: Array) -> Vector:
    """Three numbers of an array as a tuple."""
    x, y, z = (float(value) for value in values)
    return (x, y, z)
