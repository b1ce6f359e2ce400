# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Commands that hold: the force and torque each source last asked for, until it asks for something
else or its time is up.

A body has one slot per source ('force', 'torque', 'wrench'), and one more per source and named
frame ('wrench/left_thruster'): thrusters push side by side. Slots add, in this order, frames by
name. A slot in world axes stays as it is; one in body axes, or in a named frame, turns with the
body.
Force acts at the centre of mass, or at the origin of the frame: then it is held as what it does
about the centre of mass.
"""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.elements import held_body_wrench
from rigid_body_sim.physics.forces.power import HELD
from rigid_body_sim.physics.model.named_frames import (
    RESERVED_FRAMES,
    SEPARATOR,
    at_center,
    frame_of,
)
from rigid_body_sim.physics.model.numbers import checked_vector, numbers, shown
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.blocks import (
    FORCE,
    FX,
    FY,
    FZ,
    HELD_FORCE,
    HELD_TORQUE,
    HX,
    HY,
    HZ,
    KX,
    KY,
    KZ,
    LANES,
    ROTATION,
    TORQUE,
    TRANSLATION,
    TX,
    TY,
    TZ,
    rows,
    scatter,
)
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]

SOURCES = ('force', 'torque', 'wrench')
FOREVER = 2**62  # [tick]
NO_VECTOR: Vector = (0.0, 0.0, 0.0)


class Slot(NamedTuple):
    """
    One held command.

    force, torque : [N], [N m]  world axes, or principal axes where `turns_with_body`
    until         : [tick]      first tick on which it no longer acts
    """

    force: Vector
    torque: Vector
    turns_with_body: bool
    until: int = FOREVER


@dataclass(frozen=True, eq=False)
class Rows:
    """
    What the source 'wrench' asks of all bodies at once, until changed: slots as arrays.

    force, torque    : (m, 3) [N], [N m]  core order; world axes, or principal axes
    turns_with_body  : which of the two
    """

    force: Array
    torque: Array
    turns_with_body: bool

    def acting(self) -> NDArray[np.intp]:
        """Find the bodies of which something is asked."""
        return np.flatnonzero(_asked(self.force) | _asked(self.torque))

    def slots(self) -> dict[tuple[int, str], Slot]:
        """Give the same as slots."""
        force, torque = self.force.tolist(), self.torque.tolist()
        return {
            (core, 'wrench'): Slot(tuple(force[core]), tuple(torque[core]), self.turns_with_body)
            for core in self.acting().tolist()
        }

    def sums(self) -> tuple[Array, Array, Array]:
        """Give what `HeldWrenches.sums` gives of these slots."""
        columns = held_body_wrench.COLUMNS
        if not self.turns_with_body:
            return self.force.copy(), self.torque.copy(), np.zeros((0, columns))
        bodies = self.acting()
        table = np.zeros((len(bodies), columns))
        table[:, held_body_wrench.BODY] = table[:, held_body_wrench.RIGID] = bodies
        table[:, held_body_wrench.FORCES] = self.force[bodies]
        table[:, held_body_wrench.TORQUES] = self.torque[bodies]
        return np.zeros_like(self.force), np.zeros_like(self.torque), table


class HeldWrenches:
    """
    The slots of a scene.

    Those of `put_rows` stay arrays until somebody looks at single ones: with many bodies a slot
    for each would cost more than the tick. Of the others a change costs what it changes: `write`
    touches the bodies commanded since the last one, and no more.
    """

    def __init__(self, layout: Layout, gravity: Vector) -> None:
        self._layout = layout
        with np.errstate(over='ignore'):  # such a run diverges by name
            self._weight = layout.masses[:, None] * np.asarray(gravity)
        for core in range(layout.n_moving):
            if flow_of(layout.body(core)) is not None:
                self._weight[core] = 0.0  # `elements.variable_mass` adds it after its own factor
        self._weights = self._weight.tolist()
        self._still = np.setdiff1d(np.arange(len(layout.bodies)), layout.moving)
        self._is_in_order = np.array_equal(layout.moving, np.arange(len(layout.bodies)))
        self._table = np.zeros((0, held_body_wrench.COLUMNS))
        self._slots: dict[tuple[int, str], Slot] = {}
        self._rows: Rows | None = None  # then there are no other slots
        self._sources: dict[int, tuple[str, ...]] = {}  # of each body, in the order of adding
        self._ending = FOREVER  # [tick] no slot ends before
        self._is_exact = True  # whether one ends then
        self._changed: set[int] | None = None  # bodies since the last `write`; None: any
        self._turning: dict[int, int] | None = {}  # core index: its row of `_table`; None: look

    @property
    def slots(self) -> dict[tuple[int, str], Slot]:
        """Every slot by (core index, source): a copy."""
        return dict(self._slots) if self._rows is None else self._rows.slots()

    @slots.setter
    def slots(self, slots: dict[tuple[int, str], Slot]) -> None:
        sources: dict[int, list[str]] = {}
        for core, source in sorted(slots, key=_place):
            sources.setdefault(core, []).append(source)
        self.__dict__.update(  # one call of C: no interrupt comes between
            _slots=dict(slots),
            _rows=None,
            _sources={core: tuple(names) for core, names in sources.items()},
            _ending=min((slot.until for slot in slots.values()), default=FOREVER),
            _is_exact=True,
            _changed=None,
        )

    @property
    def turns(self) -> bool:
        """Whether one of them turns with its body."""
        if self._rows is not None:
            return self._rows.turns_with_body and bool(len(self._rows.acting()))
        return any(slot.turns_with_body for slot in self._slots.values())

    def checked(
        self, body: str, force: Any, torque: Any, frame: str
    ) -> tuple[int, Vector, Vector, str]:
        """
        Return the core index of a body, what is asked of it at its centre of mass as vectors, and
        the frame: world axes in 'world', body axes in any other.

        Raises InvalidModel for an unknown or fixed body, an unknown frame, anything but finite
        numbers, a torque on a point mass.
        """
        core = self._layout.core(body)
        record = self._layout.body(core)
        frame = frame_of(record, frame)
        try:
            pushed, turned = numbers(force, 3, unit='N'), numbers(torque, 3, unit='N m')
        except InvalidModel:  # told with the name of the body
            pushed = checked_vector(f'command to {body!r}', 'force', force)
            turned = checked_vector(f'command to {body!r}', 'torque', torque)
        force, torque = cast(Vector, pushed), cast(Vector, turned)
        if core >= self._layout.n_rigid and any(torque):
            raise InvalidModel(
                f'command to {body!r}: torque {torque} on a point mass, which has no orientation; '
                'give a force only, or give the body a shape with extent'
            )
        if frame in record.frames:
            try:
                force, torque = at_center(record.frames[frame], force, torque)
            except InvalidModel as error:
                raise InvalidModel(f'command to {body!r} in frame {frame!r}: {error}') from None
        return core, force, torque, frame

    def put(
        self, body: str, source: str, *, force: Any, torque: Any, frame: str, until: int
    ) -> None:
        """Put what one source asks of a body into its slot; see `Simulation.hold`."""
        core, force, torque, frame = self.checked(body, force, torque, frame)
        if not isinstance(source, str) or source not in SOURCES:
            raise InvalidModel(
                f'command to {body!r}: source {shown(source)}; allowed: {", ".join(SOURCES)}'
            )
        if not isinstance(until, int | np.integer):
            raise InvalidModel(f'command to {body!r}: until {shown(until)}; a tick is needed')
        in_body = frame != 'world'
        if in_body:
            force = self._layout.principal_axes(body, force)
            torque = self._layout.principal_axes(body, torque)
        if frame not in RESERVED_FRAMES:
            source += SEPARATOR + frame
        if self._rows is not None:
            self.slots = self._rows.slots()
        if self._changed is not None:
            self._changed.add(core)  # before it is so: an interrupt may come in between
        if not (any(force) or any(torque)):
            self._drop(core, source)
            return
        before = self._slots.get((core, source))
        if before is None:
            known = {*self._sources.get(core, ()), source}
            self._sources[core] = tuple(sorted(known, key=lambda name: _place((core, name))))
        elif before.until == self._ending != FOREVER:
            self._is_exact = False
        if until < self._ending:
            self._ending, self._is_exact = until, True
        self._slots[core, source] = Slot(force, torque, in_body, until)

    def _drop(self, core: int, source: str) -> None:
        """Forget a slot, if there is one."""
        slot = self._slots.pop((core, source), None)
        if slot is not None:
            self._is_exact &= slot.until != self._ending or self._ending == FOREVER
            left = tuple(name for name in self._sources[core] if (core, name) in self._slots)
            if left:
                self._sources[core] = left
            else:
                del self._sources[core]

    def put_rows(self, *, force: Any, torque: Any, frame: str) -> None:
        """Put what the source 'wrench' asks of every body; see `Simulation.set_wrenches`."""
        if not isinstance(frame, str) or frame not in RESERVED_FRAMES:
            raise InvalidModel(
                f"commands to all bodies: frame {shown(frame)}; allowed: 'world', 'body'; a frame "
                'of one body is for set_wrench'
            )
        layout, turns = self._layout, frame != 'world'
        pushed, turned = (
            self._rows_of(name, values) for name, values in (('force', force), ('torque', torque))
        )
        points = slice(layout.n_rigid, None)
        has_points = layout.n_rigid < layout.n_moving
        if has_points and (turned[points].any() or (turns and pushed[points].any())):
            asked = np.abs(turned) + np.abs(pushed) if turns else np.abs(turned)
            core = layout.n_rigid + int(np.argmax(asked[points].any(axis=1)))
            self.checked(layout.body(core).name, pushed[core], turned[core], 'world')
            layout.principal_axes(layout.body(core).name, NO_VECTOR)
        if turns:
            rigid = slice(layout.n_rigid)
            pushed[rigid] = layout.all_principal_axes(pushed[rigid]) + 0.0
            turned[rigid] = layout.all_principal_axes(turned[rigid]) + 0.0
        asked_of_all = Rows(pushed, turned, turns)
        others = {}
        if self._rows is None:
            others = {key: slot for key, slot in self._slots.items() if key[1] != 'wrench'}
        if others:
            self.slots = {**others, **asked_of_all.slots()}
            return
        self.__dict__.update(
            _slots={},
            _rows=asked_of_all,
            _sources={},
            _ending=FOREVER,
            _is_exact=True,
            _changed=None,
        )  # one call of C: no interrupt comes between

    def _rows_of(self, name: str, values: Any) -> Array:
        """Return (m, 3) finite numbers in core order of (n, 3) in scene order; None: zeros."""
        layout = self._layout
        count = len(layout.bodies)
        if values is None:
            return np.zeros((layout.n_moving, 3))
        try:
            given = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError):
            given = np.zeros(0)
        if given.shape != (count, 3):
            raise InvalidModel(
                f'commands to all bodies: {name} {shown(values)} of shape {np.shape(given)}; '
                f'allowed: an array ({count}, 3), a row for each body in the order of the scene, '
                'or None'
            )
        with np.errstate(over='ignore', invalid='ignore'):
            is_finite = math.isfinite(np.add.reduce(given, axis=None))  # or beyond the numbers
        if not is_finite or (self._still.size and given[self._still].any()):
            wrong = ~np.isfinite(given).all(axis=1)
            wrong[self._still] |= given[self._still].any(axis=1)
            if wrong.any():
                row = int(np.argmax(wrong))
                self.checked(layout.names[row], given[row], NO_VECTOR, 'world')  # says the reason
        return (given if self._is_in_order else given[layout.moving]) + 0.0  # no zero is negative

    def drop_expired(self, tick: int) -> bool:
        """Let go of what ends before this tick; tell whether there was any."""
        if self._ending > tick:
            return False
        expired = [key for key, slot in self._slots.items() if slot.until <= tick]
        if self._changed is not None:
            self._changed.update(core for core, _ in expired)
        for key in expired:
            self._drop(*key)
        self._find_end()
        return bool(expired)

    def _find_end(self) -> None:
        self._ending = min((slot.until for slot in self._slots.values()), default=FOREVER)
        self._is_exact = True

    @property
    def no_end_before(self) -> int:
        """A tick [tick] before which no slot ends; `next_expiry`, or earlier, without a search."""
        return self._ending

    def next_expiry(self) -> int:
        """First tick on which a slot ends."""
        if not self._is_exact:
            self._find_end()
        return self._ending

    def sums(self) -> tuple[Array, Array, Array]:
        """
        Add up the slots.

        returns : force (m, 3) and torque (m, 3) in world axes without gravity, and the table of
                  what turns with the bodies: rows of `elements.held_body_wrench`
        """
        if self._rows is not None:
            return self._rows.sums()
        force = np.zeros((self._layout.n_moving, 3))
        torque = np.zeros((self._layout.n_moving, 3))
        turning: list[list[float]] = []
        for core in sorted(self._sources):
            held, row = self._sums_of(core)
            force[core], torque[core] = held[:3], held[3:]
            if row is not None:
                turning.append([core, core, *row])
        table = np.array(turning, dtype=np.float64).reshape(-1, held_body_wrench.COLUMNS)
        return force, torque, table

    def _sums_of(self, core: int) -> tuple[list[float], list[float] | None]:
        """
        Add up the slots of a body: force and torque in world axes, and those that turn with it,
        or None.
        """
        held, turning = [0.0] * 6, None
        for source in self._sources.get(core, ()):
            slot = self._slots.get((core, source))
            if slot is None:  # an interrupt came while it was put or dropped
                continue
            if not slot.turns_with_body:
                total = held
            elif turning is None:
                total = turning = [0.0] * 6
            else:
                total = turning
            total[:] = map(operator.add, total, (*slot.force, *slot.torque))
        return held, turning

    def acting(self) -> Array:
        """Give what is held, rows of `forces.power.held`, without gravity."""
        force, torque, table = self.sums()
        rows = []
        for core in np.flatnonzero(force.any(axis=1) | torque.any(axis=1)).tolist():
            rigid = core if core < self._layout.n_rigid else -1
            rows.append([core, rigid, *force[core], *torque[core], 0.0])
        rows += [[*row, 1.0] for row in table.tolist()]
        return np.array(rows, dtype=np.float64).reshape(-1, HELD)

    def write(self, translation: Array, rotation: Array) -> Array:
        """
        Write what is held in world axes, gravity with it, into the blocks, for the bodies whose
        commands changed since `written`; return the table of what turns.
        """
        if self._changed is None:
            self._write_all(translation, rotation)
        else:
            self._write_bodies(self._changed, translation, rotation)
        return self._table

    def written(self) -> None:
        """Note that what `write` gave has arrived: until then an interrupt lets all be redone."""
        self._changed = set()

    def _write_all(self, translation: Array, rotation: Array) -> None:
        force, torque, table = self.sums()
        with np.errstate(over='ignore', invalid='ignore'):
            force += self._weight
        for array, size, values, held, total in (
            (translation, TRANSLATION, force, HELD_FORCE, FORCE),
            (rotation, ROTATION, torque[: self._layout.n_rigid], HELD_TORQUE, TORQUE),
        ):
            if len(values):
                scatter(array, size, held, values)
                rows(array, size, total, 3)[:] = rows(array, size, held, 3)
        self._table, self._turning = table, None

    def _write_bodies(self, changed: set[int], translation: Array, rotation: Array) -> None:
        rows_of: dict[int, list[float] | None] = {}
        places = self._turning
        if places is None:
            cores = self._table[:, held_body_wrench.BODY].astype(int).tolist()
            places = self._turning = {core: row for row, core in enumerate(cores)}
        for core in changed:
            (*force, tx, ty, tz), turning = self._sums_of(core)
            if turning is not None or core in places:
                rows_of[core] = turning
            wx, wy, wz = self._weights[core]
            fx, fy, fz = force[0] + wx, force[1] + wy, force[2] + wz
            k = core // LANES * TRANSLATION + core % LANES
            translation[k + HX] = translation[k + FX] = fx
            translation[k + HY] = translation[k + FY] = fy
            translation[k + HZ] = translation[k + FZ] = fz
            if core < self._layout.n_rigid:
                k = core // LANES * ROTATION + core % LANES
                rotation[k + KX] = rotation[k + TX] = tx
                rotation[k + KY] = rotation[k + TY] = ty
                rotation[k + KZ] = rotation[k + TZ] = tz
        if all(row is not None and core in places for core, row in rows_of.items()):
            for core, row in rows_of.items():
                self._table[places[core], held_body_wrench.FORCE :] = row
        else:
            self._table, self._turning = self.sums()[2], None


def _asked(values: Array) -> NDArray[np.bool_]:
    """Tell which rows of (m, 3) are not zero; five times as fast as `any` along an axis."""
    x, y, z = values.T
    return (x != 0.0) | (y != 0.0) | (z != 0.0)


def _place(key: tuple[int, str]) -> tuple[int, int, str]:
    """Order in which a slot is added."""
    source, _, frame = key[1].partition(SEPARATOR)
    return key[0], SOURCES.index(source), frame


def is_source(name: str) -> bool:
    """Tell whether a slot can have this name."""
    return name.partition(SEPARATOR)[0] in SOURCES
