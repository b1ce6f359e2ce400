# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What can be read of the bodies at one instant, in scene order, body axes and world axes.

One compiled pass over the blocks fills one array; a `State` is views of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import argument, flat, kernel, prepared
from rigid_body_sim.physics.model import prescribed_motion
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import moments_at
from rigid_body_sim.physics.model.pivot import arm_of
from rigid_body_sim.physics.model.prescribed_motion import from_end_of_table, path_of
from rigid_body_sim.physics.model.variable_mass import flow_of, masses_at
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import (
    LANES,
    ROTATION,
    TRANSLATION,
    at,
    orientation,
    rotated,
    rotated_back,
)
from rigid_body_sim.physics.state.layout import Layout, unknown_body
from rigid_body_sim.physics.vectors import add, cross, load, load_strided, scale, store, subtract

Array = NDArray[np.float64]

body = Record()
POSITION = body.vector('m', 'centre of mass, world')
ORIENTATION = body.quaternion('-', 'body axes to world; (0, 0, 0, 1) of a point mass')
VELOCITY = body.vector('m/s', 'of the centre of mass, world')
ANGULAR_VELOCITY = body.vector('rad/s', 'world axes')
ANGULAR_VELOCITY_BODY = body.vector('rad/s', 'body axes')
MOMENTUM = body.vector('kg m/s', 'world axes')
ANGULAR_MOMENTUM = body.vector('kg m^2/s', 'about the centre of mass, world axes')
COLUMNS = body.size

# columns of each, of all bodies: made once, as a controller reads them in every tick
_EDGES = (
    POSITION, ORIENTATION, VELOCITY, ANGULAR_VELOCITY, ANGULAR_VELOCITY_BODY, MOMENTUM,
    ANGULAR_MOMENTUM, COLUMNS,
)  # fmt: skip
(
    _POSITION, _ORIENTATION, _VELOCITY, _ANGULAR_VELOCITY, _ANGULAR_VELOCITY_BODY, _MOMENTUM,
    _ANGULAR_MOMENTUM,
) = ((slice(None), slice(begin, end)) for begin, end in pairwise(_EDGES))  # fmt: skip

pivoted = Record()
INDEX = pivoted.number('-', 'scene index')
ARM = pivoted.vector('m', 'from the pivot to the centre of mass, body axes')
MASS = pivoted.number('kg', '')
SIZE_PIVOTED = pivoted.size

QUATERNION = 4  # numbers of one


@kernel
def _read(out, n_moving, n_rigid, translation, rotation, principal, scene_index):
    for i in range(n_moving):
        k = at(i, TRANSLATION)
        row = int(scene_index[i]) * COLUMNS
        momentum = load_strided(translation, k + blocks.MOMENTUM, LANES)
        store(out, row + POSITION, load_strided(translation, k + blocks.POSITION, LANES))
        store(out, row + VELOCITY, scale(translation[k + blocks.INVERSE_MASS], momentum))
        store(out, row + MOMENTUM, momentum)
    for i in range(n_rigid):
        k = at(i, ROTATION)
        row = int(scene_index[i]) * COLUMNS
        q = orientation(rotation, i)
        momentum = load_strided(rotation, k + blocks.ANGULAR_MOMENTUM, LANES)
        a, b, c = rotated_back(q, momentum)
        omega = (
            a * rotation[k + blocks.J1],
            b * rotation[k + blocks.J2],
            c * rotation[k + blocks.J3],
        )
        store(out, row + ANGULAR_VELOCITY, rotated(q, omega))
        store(out, row + ANGULAR_MOMENTUM, momentum)
        vector_part = load(principal, QUATERNION * i)
        scalar_part = principal[QUATERNION * i + QUATERNION - 1]
        if scalar_part != 1.0:  # body axes from principal axes: q_body = q_principal V*
            u, v, t = vector_part
            x, y, z, w = q
            omega = rotated((u, v, t, scalar_part), omega)
            q = (
                -w * u + x * scalar_part - y * t + z * v,
                -w * v + y * scalar_part - z * u + x * t,
                -w * t + z * scalar_part - x * v + y * u,
                w * scalar_part + x * u + y * v + z * t,
            )
        store(out, row + ORIENTATION, (q[0], q[1], q[2]))
        out[row + ORIENTATION + QUATERNION - 1] = q[QUATERNION - 1]
        store(out, row + ANGULAR_VELOCITY_BODY, omega)


@kernel
def _move_to_centers(count, pivots, values):
    """
    Make position, velocity, momentum and own angular momentum of the centre of mass of those of
    the pivot.
    """
    for number in range(count):
        place = SIZE_PIVOTED * number
        row = int(pivots[place + INDEX]) * COLUMNS
        x, y, z = load(values, row + ORIENTATION)
        q = x, y, z, values[row + ORIENTATION + QUATERNION - 1]
        arm = rotated(q, load(pivots, place + ARM))
        velocity = cross(load(values, row + ANGULAR_VELOCITY), arm)
        momentum = scale(pivots[place + MASS], velocity)
        about_pivot = load(values, row + ANGULAR_MOMENTUM)
        store(values, row + POSITION, add(load(values, row + POSITION), arm))
        store(values, row + VELOCITY, velocity)
        store(values, row + MOMENTUM, momentum)
        store(values, row + ANGULAR_MOMENTUM, subtract(about_pivot, cross(arm, momentum)))


def _told(path: Array, time: float) -> Array:
    """Evaluate the path of a body that is moved as told: `prescribed_motion.instant`."""
    out = np.zeros(prescribed_motion.INSTANT)
    prescribed_motion.motion_at(argument(path), 0, time, argument(out))
    return out


def _put_told(row: Array, path: Array, time: float) -> None:
    """Write the motion at a time [s] of a body that is moved as told."""
    out = _told(path, time)
    q = out[prescribed_motion.AT_ORIENTATION : prescribed_motion.AT_VELOCITY]
    spin = out[prescribed_motion.AT_SPIN : prescribed_motion.AT_ACCELERATION]
    row[POSITION:ORIENTATION] = out[: prescribed_motion.AT_ORIENTATION]
    row[ORIENTATION:VELOCITY] = q
    row[VELOCITY:ANGULAR_VELOCITY] = out[prescribed_motion.AT_VELOCITY : prescribed_motion.AT_SPIN]
    row[ANGULAR_VELOCITY:ANGULAR_VELOCITY_BODY] = spin
    row[ANGULAR_VELOCITY_BODY:MOMENTUM] = so3.rotate_back(q, spin)


# of an array and of the views of it; by the name of what it sets it takes twice as long
_set_flags: Any = np.ndarray.setflags


class State:
    """
    The bodies of a scene at one instant: a copy, in scene order, that cannot be written to.

    values : (n, COLUMNS)  rows of `body`
    masses : (n,) [kg]  zero for fixed bodies; None where the mass of no body changes
    places : scene index by name; None where nobody asks by name

    `state['box']` is one body: `StateOfBody`.
    """

    __slots__ = ('_masses', '_places', '_values')  # a controller reads a state in every tick

    def __init__(
        self,
        values: Array,
        masses: Array | None = None,
        places: Mapping[str, int] | None = None,
    ) -> None:
        _set_flags(values, False)
        self._values = values
        self._masses = masses
        self._places = places

    @property
    def values(self) -> Array:
        """Rows of `body` (n, COLUMNS)."""
        return self._values

    @property
    def masses(self) -> Array | None:
        """Masses (n,) [kg], zero for fixed bodies; None where the mass of no body changes."""
        return self._masses

    @property
    def places(self) -> Mapping[str, int] | None:
        """Scene index by name; None where nobody asks by name."""
        return self._places

    def __repr__(self) -> str:
        return f'<State of {len(self.values)} bodies: position, orientation, velocity, …>'

    def __getitem__(self, name: str) -> StateOfBody:
        """Give one body by its name; UnknownBody, which is an InvalidModel, for another name."""
        places = self.places or {}
        try:
            return StateOfBody(name, self.values[places[name]])
        except (KeyError, TypeError):  # TypeError: an array is no name
            raise unknown_body(name, tuple(places)) from None

    @property
    def position(self) -> Array:
        """Centres of mass (n, 3) [m], world."""
        return self._values[_POSITION]

    @property
    def orientation(self) -> Array:
        """Unit quaternions (n, 4) [-], xyzw, body to world; (0, 0, 0, 1) for point masses."""
        return self._values[_ORIENTATION]

    @property
    def velocity(self) -> Array:
        """Velocities of the centres of mass (n, 3) [m/s], world."""
        return self._values[_VELOCITY]

    @property
    def angular_velocity(self) -> Array:
        """Angular velocities (n, 3) [rad/s], world axes."""
        return self._values[_ANGULAR_VELOCITY]

    @property
    def angular_velocity_body(self) -> Array:
        """Angular velocities (n, 3) [rad/s], body axes."""
        return self._values[_ANGULAR_VELOCITY_BODY]

    @property
    def momentum(self) -> Array:
        """Momenta (n, 3) [kg m/s], world."""
        return self._values[_MOMENTUM]

    @property
    def angular_momentum(self) -> Array:
        """Angular momenta about the own centres of mass (n, 3) [kg m^2/s], world axes."""
        return self._values[_ANGULAR_MOMENTUM]


_new_state = object.__new__  # a third of the time of the constructor


class StateOfBody:
    """
    One body at one instant: its row of each array of a `State`, which cannot be written to.

    name : of the body
    """

    __slots__ = ('_values', 'name')

    def __init__(self, name: str, values: Array) -> None:
        self.name = name
        self._values = values

    def __repr__(self) -> str:
        x, y, z = self.position
        return f'<state of {self.name!r}: position ({x:.6g}, {y:.6g}, {z:.6g}) m, …>'

    @property
    def position(self) -> Array:
        """Centre of mass (3,) [m], world."""
        return self._values[POSITION:ORIENTATION]

    @property
    def orientation(self) -> Array:
        """Unit quaternion (4,) [-], xyzw, body to world; (0, 0, 0, 1) for a point mass."""
        return self._values[ORIENTATION:VELOCITY]

    @property
    def velocity(self) -> Array:
        """Velocity of the centre of mass (3,) [m/s], world."""
        return self._values[VELOCITY:ANGULAR_VELOCITY]

    @property
    def angular_velocity(self) -> Array:
        """Angular velocity (3,) [rad/s], world axes."""
        return self._values[ANGULAR_VELOCITY:ANGULAR_VELOCITY_BODY]

    @property
    def angular_velocity_body(self) -> Array:
        """Angular velocity (3,) [rad/s], body axes."""
        return self._values[ANGULAR_VELOCITY_BODY:MOMENTUM]

    @property
    def momentum(self) -> Array:
        """Momentum (3,) [kg m/s], world."""
        return self._values[MOMENTUM:ANGULAR_MOMENTUM]

    @property
    def angular_momentum(self) -> Array:
        """Angular momentum about its centre of mass (3,) [kg m^2/s], world axes."""
        return self._values[ANGULAR_MOMENTUM:COLUMNS]


class StateReader:
    """
    Reads the blocks of one layout.

    is_timed : whether what is read depends on time
    """

    def __init__(self, layout: Layout) -> None:
        self._still = np.zeros((len(layout.bodies), COLUMNS))
        for i, body in enumerate(layout.bodies):
            self._still[i, POSITION:ORIENTATION] = body.initial.position
            self._still[i, ORIENTATION:VELOCITY] = body.initial.orientation
        self._told = [
            (i, path_of(body, body.center_of_mass))
            for i, body in enumerate(layout.bodies)
            if body.motion is not None
        ]
        self._sizes = (layout.n_moving, layout.n_rigid)
        self._principal = argument(layout.principal.ravel())
        self._scene_index = argument(layout.moving)
        self._last: tuple[Any, Any, Callable[..., Any]] = (None, None, _read)  # blocks and reader
        self._flowing = [i for i, b in enumerate(layout.bodies) if flow_of(b) is not None]
        self._bodies = layout.bodies
        self._places = layout.places
        self._changing = [
            (core, body.inertia_over_time)
            for core, body in ((c, layout.body(c)) for c in range(layout.n_rigid))
            if body.inertia_over_time is not None
        ]
        rows = [
            (layout.moving[core], *arm_of(layout.body(core)), layout.body(core).mass)
            for core in layout.pivoted
        ]
        self._pivots = (len(rows), argument(np.array(rows, dtype=np.float64).reshape(-1)))
        self.is_timed = bool(self._told or self._changing or self._flowing)
        is_filled = layout.n_rigid == len(layout.bodies)  # every number is written
        self._begin = partial(np.empty, self._still.shape) if is_filled else self._still.copy
        self._is_all = not (self.is_timed or self._pivots[0])  # whether the kernel writes all

    def _put_what_is_told(self, values: Array, rotation: Array, time: float) -> None:
        """Write motions that are told, and the moments of inertia of this time."""
        for i, path in self._told:
            _put_told(values[i], path, time)
        for core, law in self._changing:
            moments = moments_at(law, time)  # the blocks may hold those of the last stage
            block, lane = divmod(core, LANES)
            inverse = blocks.rows(rotation, ROTATION, blocks.INVERSE_MOMENTS, 3)
            inverse[block, :, lane] = 1.0 / moments

    def put_accelerations_told(self, found: Array, time: float) -> None:
        """
        Write the accelerations of the bodies that are moved as told, from a time on: second
        derivatives of their paths, no differences.

        found : (2, n, 3) [m/s^2] of the centres of mass, [rad/s^2]; scene order, world axes
        time  : [s] since the start of the scene
        """
        linear = slice(prescribed_motion.AT_ACCELERATION, prescribed_motion.AT_ACCELERATION + 3)
        angular = slice(linear.stop, linear.stop + 3)
        for i, path in self._told:
            out = _told(path, from_end_of_table(path, time))
            found[0, i], found[1, i] = out[linear], out[angular]

    def _reader_of(self, translation: Array, rotation: Array) -> Callable[..., Any]:
        """Make what reads these blocks."""
        blocks_of_both = (argument(translation), argument(rotation))
        last = (*self._sizes, *blocks_of_both, self._principal, self._scene_index)
        read = prepared(_read, (flat(self._begin()),), last, brief=True)
        self._last = (translation, rotation, read)
        return read

    def read(self, translation: Array, rotation: Array, time: float) -> State:
        """Read the state of all bodies, `time` [s] after the start of the scene."""
        of_translation, of_rotation, read = self._last
        if of_translation is not translation or of_rotation is not rotation:
            read = self._reader_of(translation, rotation)
        values = self._begin()
        if self._is_all:
            read(flat(values))
            _set_flags(values, False)
            state = _new_state(State)
            state._values, state._masses, state._places = values, None, self._places
            return state
        if self.is_timed:
            self._put_what_is_told(values, rotation, time)
        out = flat(values)
        read(out)
        if self._pivots[0]:
            _move_to_centers(*self._pivots, out)
        if not self._flowing:
            return State(values, None, self._places)
        masses = masses_at(self._bodies, time)
        assert masses is not None
        masses.setflags(write=False)
        # the blocks hold the momenta of the mass at the start
        with np.errstate(over='ignore', invalid='ignore'):  # a state on its way to infinity
            for i in self._flowing:
                values[i, MOMENTUM:COLUMNS] *= masses[i] / self._bodies[i].mass
        return State(values, masses, self._places)
