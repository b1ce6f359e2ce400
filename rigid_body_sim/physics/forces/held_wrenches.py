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

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument, flat, prepared
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.elements import held_body_wrench
from rigid_body_sim.physics.forces.held_lanes import (
    BODY,
    COLUMNS,
    NO_VECTOR,
    RIGID,
    list_turning,
    put_all,
    put_one,
    put_row,
    take_and_list_rows,
    take_and_put_rows,
    take_rows,
)
from rigid_body_sim.physics.forces.power import HELD
from rigid_body_sim.physics.model.named_frames import (
    RESERVED_FRAMES,
    SEPARATOR,
    at_center,
    frame_of,
)
from rigid_body_sim.physics.model.numbers import (
    FLOATS,
    SixFloats,
    array_of_numbers,
    checked_vector,
    in_doubles,
    is_list,
    shown,
    two_vectors,
)
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.blocks import (
    FORCE,
    HELD_FORCE,
    HELD_TORQUE,
    ROTATION,
    TORQUE,
    TRANSLATION,
    rows,
    scatter,
)
from rigid_body_sim.physics.state.layout import Layout, Matrix, turned_by

Array = NDArray[np.float64]

SOURCES = ('force', 'torque', 'wrench')
FOREVER = 2**62  # [tick]
NOTHING = (0.0,) * 6  # force [N] and torque [N m]
WRENCH = 6  # rows: FORCE and HELD_FORCE, or TORQUE and HELD_TORQUE, follow each other


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


# how a lone source is written at once: core index, key of its slot, row that is written, by what,
# (None: it has no slot), from which axes (rows of V^T; None: the world's), first tick on which it
# no longer acts. A tuple, taken apart where it is read, with each command: of what has names that
# costs three times as much
AtOnce = tuple[int, tuple[int, str], int, Callable[..., Any] | None, Matrix | None, int]
# what was written at once: how, and force and torque in the axes that were asked
Written = tuple[AtOnce, SixFloats]

_Array = np.ndarray
_new_slot = tuple.__new__  # of `Slot`: half the time of its constructor


@dataclass(eq=False)
class Rows:
    """
    What the source 'wrench' asks of all bodies at once, until changed: slots as arrays.

    force, torque    : (m, 3) [N], [N m]  core order; world axes, or principal axes
    turns_with_body  : which of the two
    writers          : who writes them into lanes: see `HeldWrenches`
    take_at_once     : who takes over others and writes them
    table            : where they write what turns
    """

    force: Array
    torque: Array
    turns_with_body: bool
    writers: tuple[Any, ...] | None = None
    take_at_once: Callable[..., Any] | None = None
    table: Any = None

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
        if not self.turns_with_body:
            return self.force.copy(), self.torque.copy(), np.zeros((0, COLUMNS))
        bodies = self.acting()
        table = np.zeros((len(bodies), COLUMNS))
        table[:, BODY] = table[:, RIGID] = bodies
        table[:, held_body_wrench.FORCES] = self.force[bodies]
        table[:, held_body_wrench.TORQUES] = self.torque[bodies]
        return np.zeros_like(self.force), np.zeros_like(self.torque), table


class HeldWrenches:
    """
    The slots of a scene.

    Those of `put_rows` stay arrays until somebody looks at single ones: with many bodies a slot
    for each would cost more than the tick. Of the others a change costs what it changes: `write`
    touches the bodies commanded since the last one, and no more.

    The lone source of a rigid body that asks for other numbers, and for nothing else, has them in
    their lanes at once (`put_at_once`), and so have all bodies those of rows that follow rows in
    the same axes (`put_rows_at_once`): that is what a controller does in every tick.
    """

    def __init__(self, layout: Layout, gravity: Vector) -> None:
        self._layout = layout
        with np.errstate(over='ignore'):  # such a run diverges by name
            self._weight = layout.masses[:, None] * np.asarray(gravity)
        for core in range(layout.n_moving):
            if flow_of(layout.body(core)) is not None:
                self._weight[core] = 0.0  # `elements.variable_mass` adds it after its own factor
        self._records = [layout.body(core) for core in range(layout.n_moving)]
        self._cores = {record.name: core for core, record in enumerate(self._records)}
        stands = np.ones(len(layout.bodies), dtype=bool)
        stands[layout.moving] = False
        self._still = np.flatnonzero(stands)
        self._nothing = np.zeros((len(layout.bodies), 3))
        self._shape = self._nothing.shape
        self._asked: dict[bool, tuple[Rows, Callable[..., Any]]] = {}  # by whether it turns
        self._blocks: tuple[Any, Any] = (None, None)  # into whose lanes `_writer` writes
        self._writer: Callable[..., Any] = put_one
        # blocks of translation, their lanes of FORCE and HELD_FORCE, what these hold where nothing
        # is commanded, and lanes of torques: to be written again, as behind a reset
        self._weights: tuple[Array, Array, Array, Array] | None = None
        # of which table; from principal axes, from body axes
        self._row_writers: tuple[Any, Callable[..., Any], Callable[..., Any]]
        self._row_writers = None, put_row, put_row
        self._table = np.zeros((0, COLUMNS))
        self._slots: dict[tuple[int, str], Slot] = {}
        self._rows: Rows | None = None  # then there are no other slots
        self._sources: dict[int, tuple[str, ...]] = {}  # of each body, in the order of adding
        self.no_end_before = FOREVER  # [tick] no slot ends before; `next_expiry`, or earlier
        self._is_exact = True  # whether one ends then
        self._changed: set[int] | None = None  # bodies since the last `write`; None: any
        self._turning: dict[int, int] | None = {}  # core index: its row of `_table`; None: look
        self._at_once: dict[tuple[str, str, str], AtOnce] = {}  # by body, source and frame
        self._written: dict[tuple[int, str], Written] = {}  # at once, and not in the slots yet
        self._is_settled = False  # whether lanes and rows are for these slots, whatever they ask
        self._take_at_once: Callable[..., Any] | None = None  # of rows that are in their lanes

    @property
    def slots(self) -> dict[tuple[int, str], Slot]:
        """Every slot by (core index, source): a copy."""
        self._take_written()
        return dict(self._slots) if self._rows is None else self._rows.slots()

    @slots.setter
    def slots(self, slots: dict[tuple[int, str], Slot]) -> None:
        sources: dict[int, list[str]] = {}
        for core, source in sorted(slots, key=_place):
            sources.setdefault(core, []).append(source)
        self._unsettle()
        self.__dict__.update(  # one call of C: no interrupt comes between
            _slots=dict(slots),
            _written={},
            _rows=None,
            _sources={core: tuple(names) for core, names in sources.items()},
            no_end_before=min((slot.until for slot in slots.values()), default=FOREVER),
            _is_exact=True,
            _changed=None,
        )

    def _take_written(self) -> None:
        """Put what was written at once into the slots, for who looks at their numbers."""
        for key, (way, (a, b, c, x, y, z)) in self._written.items():
            _core, _key, _row, _write, axes, until = way
            force, torque = (a, b, c), (x, y, z)
            if axes is not None:
                force, torque = turned_by(axes, force), turned_by(axes, torque)
            self._slots[key] = _new_slot(Slot, (force, torque, axes is not None, until))
        self._written = {}

    def _unsettle(self) -> None:
        """Note that slots come or go, or lie elsewhere: none is written at once before `write`."""
        self._is_settled, self._at_once, self._take_at_once = False, {}, None

    @property
    def acts(self) -> bool:
        """Whether anything is asked of any body."""
        if self._rows is None:
            return bool(self._slots)
        return bool(self._rows.force.any() or self._rows.torque.any())

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
        try:
            core = self._cores[body]
        except (KeyError, TypeError):
            core = self._layout.core(body)  # says what is wrong
        if frame.__class__ is not str or (frame != 'world' and frame != 'body'):
            frame = frame_of(self._records[core], frame)
        numbers = two_vectors(force, torque)
        if numbers is None:
            force = checked_vector(f'command to {body!r}', 'force', force)
            torque = checked_vector(f'command to {body!r}', 'torque', torque)
        else:
            force, torque = numbers[:3], numbers[3:]
        if core >= self._layout.n_rigid and any(torque):
            raise InvalidModel(
                f'command to {body!r}: torque {torque} on a point mass, which has no orientation; '
                'give a force only, or give the body a shape with extent'
            )
        if frame not in RESERVED_FRAMES:
            try:
                force, torque = at_center(self._records[core].frames[frame], force, torque)
            except InvalidModel as error:
                raise InvalidModel(f'command to {body!r} in frame {frame!r}: {error}') from None
        return core, force, torque, frame

    def put_at_once(
        self, body: str, source: str, force: Any, torque: Any, frame: str, until: int
    ) -> bool:
        """
        Do what `put` does, and write it, where a source asks for nothing but other numbers; tell
        whether that was so. False: nothing has changed.
        """
        try:
            way = self._at_once[body, source, frame]
        except (KeyError, TypeError):  # TypeError: an array is no name
            return False
        core, key, row, write, _axes, ends = way
        asked = two_vectors(force, torque)
        if asked is None or until != ends:
            return False
        if write is None or asked == NOTHING:
            return write is None and asked == NOTHING  # no slot, and none is needed for nothing
        changed = self._changed
        if changed is None:
            return False
        changed.add(core)  # an interrupt before it is written has `write` do it
        self._written[key] = way, asked
        fx, fy, fz, tx, ty, tz = asked
        write(row, fx, fy, fz, tx, ty, tz)  # half the time of `*asked`
        changed.discard(core)
        return True

    def _note_way(self, key: tuple[int, str], body: str, frame: str, until: int) -> None:
        """Note how `put_at_once` writes what a source asks of a body, if it may."""
        core, source = key
        if not self._is_settled or frame not in RESERVED_FRAMES or core >= self._layout.n_rigid:
            return
        if len(self._sources[core]) > 1:
            return
        row, write, axes = core, self._writer, None
        if frame != 'world':
            if self._turning is None or core not in self._turning:
                return
            row, write = self._turning[core], self._writer_of_row(turns=True)
            axes = self._layout.principal_axes_as_rows(core)
        self._at_once[body, source, frame] = core, key, row, write, axes, until

    def put(
        self, body: str, source: str, *, force: Any, torque: Any, frame: str, until: int
    ) -> None:
        """Put what one source asks of a body into its slot; see `Simulation.hold`."""
        asked_frame = frame
        self._take_written()
        core, force, torque, frame = self.checked(body, force, torque, frame)
        if source.__class__ is not str or source not in SOURCES:
            raise InvalidModel(
                f'command to {body!r}: source {shown(source)}; allowed: {", ".join(SOURCES)}'
            )
        if until.__class__ is not int and not isinstance(until, int | np.integer):
            raise InvalidModel(f'command to {body!r}: until {shown(until)}; a tick is needed')
        in_body = frame != 'world'
        if in_body:
            force = self._layout.principal_axes_of(core, force)
            torque = self._layout.principal_axes_of(core, torque)
            if frame != 'body':
                source += SEPARATOR + frame
        if self._rows is not None:
            self.slots = self._rows.slots()
        key = core, source
        if force == NO_VECTOR == torque and key not in self._slots:
            if asked_frame in RESERVED_FRAMES:
                self._at_once[body, source, asked_frame] = core, key, 0, None, None, until
            return
        if self._changed is not None:
            self._changed.add(core)  # before it is so: an interrupt may come in between
        if force == NO_VECTOR == torque:
            self._drop(core, source)
            return
        before = self._slots.get(key)
        if before is None or before.turns_with_body is not in_body:
            self._unsettle()
        if before is None:
            known = {*self._sources.get(core, ()), source}
            self._sources[core] = tuple(sorted(known, key=lambda name: _place((core, name))))
        elif before.until == self.no_end_before != FOREVER:
            self._is_exact = False
        if until < self.no_end_before:
            self.no_end_before, self._is_exact = until, True
        self._slots[key] = _new_slot(Slot, (force, torque, in_body, until))
        if self._is_settled:
            self._note_way(key, body, asked_frame, until)

    def _drop(self, core: int, source: str) -> None:
        """Forget a slot, if there is one."""
        self._unsettle()
        slot = self._slots.pop((core, source), None)
        if slot is not None:
            self._is_exact &= slot.until != self.no_end_before or self.no_end_before == FOREVER
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
        self._take_written()
        turns = frame != 'world'
        asked, take = self._asked.get(turns) or self._make_rows(turns)
        others = {}
        if self._rows is None and self._slots:
            others = {key: slot for key, slot in self._slots.items() if key[1] != 'wrench'}
        self._changed = None  # before it is so: an interrupt may come in between
        self._unsettle()
        pushed, turned = self._flat(force), self._flat(torque)
        if pushed is None or turned is None or take(pushed, turned):
            pushed, turned = self._checked_rows(force, torque, turns=turns)
            take(argument(pushed.reshape(-1)), argument(turned.reshape(-1)))
        if others:
            self.slots = {**others, **asked.slots()}
        elif self._rows is not asked:
            self.__dict__.update(
                _slots={}, _rows=asked, _sources={}, no_end_before=FOREVER, _is_exact=True
            )  # one call of C: no interrupt comes between

    def put_rows_at_once(self, force: Any, torque: Any, frame: str) -> bool:
        """
        Do what `put_rows` does, and write it, where rows follow others in the same axes; tell
        whether that was so. False: nothing has changed, or `put_rows` is to do it all.
        """
        take, asked = self._take_at_once, self._rows
        if take is None or asked is None or frame.__class__ is not str:
            return False
        if frame != ('body' if asked.turns_with_body else 'world'):
            return False
        shape = self._shape
        if force is None:
            force = self._nothing
        if torque is None:
            torque = self._nothing
        if not force.__class__ is torque.__class__ is _Array:
            return False
        if not force.dtype is torque.dtype is FLOATS:
            force, torque = in_doubles(force), in_doubles(torque)
            if not force.dtype is torque.dtype is FLOATS:
                return False
        if not force.shape == shape == torque.shape:
            return False
        self._changed = None  # an interrupt before all is there has `write` do it
        if take(flat(force), flat(torque)) != 0:
            return False
        self._changed = set()
        return True

    def _make_rows(self, turns: bool) -> tuple[Rows, Callable[..., Any]]:
        """Make what keeps the rows of one kind, and what takes them over, all or none."""
        layout = self._layout
        made = Rows(np.zeros((layout.n_moving, 3)), np.zeros((layout.n_moving, 3)), turns)
        kept = (argument(made.force.reshape(-1)), argument(made.torque.reshape(-1)))
        still, axes = argument(self._still), argument(layout.to_principal)
        last = (argument(layout.moving), still, layout.n_rigid, int(turns), axes, *kept)
        nothing = argument(self._nothing.reshape(-1))
        self._asked[turns] = made, prepared(take_rows, (nothing, nothing), last, brief=True)
        return self._asked[turns]

    def _flat(self, values: Any) -> Any:
        """Give rows of numbers, or zeros for None, as kernels take them; None: ask further."""
        if values is None:
            values = self._nothing
        if values.__class__ is not _Array or values.shape != self._shape:
            return None
        values = in_doubles(values)
        return flat(values) if values.dtype is FLOATS else None

    def _checked_rows(self, force: Any, torque: Any, *, turns: bool) -> tuple[Array, Array]:
        """Return (n, 3) numbers in scene order that the bodies may be asked for."""
        layout = self._layout
        pushed, turned = (
            self._rows_of(name, values) for name, values in (('force', force), ('torque', torque))
        )
        points = layout.moving[layout.n_rigid :]
        if turned[points].any() or (turns and pushed[points].any()):
            asked = np.abs(turned) + np.abs(pushed) if turns else np.abs(turned)
            index = int(points[np.argmax(asked[points].any(axis=1))])
            name = layout.names[index]
            self.checked(name, pushed[index], turned[index], 'world')
            layout.principal_axes(name, NO_VECTOR)
        return pushed, turned

    def _rows_of(self, name: str, values: Any) -> Array:
        """Return (n, 3) finite numbers in scene order; None: zeros."""
        layout = self._layout
        if values is None:
            return self._nothing
        given = array_of_numbers(values)
        if given is None:
            self._refuse_row(name, values)
        if given is None or given.shape != self._shape:
            shape = '' if given is None else f' of shape {given.shape}'
            raise InvalidModel(
                f'commands to all bodies: {name} {shown(values)}{shape}; allowed: an array '
                f'{self._shape} of finite numbers, a row for each body in the order of the scene, '
                'or None'
            )
        wrong = ~np.isfinite(given).all(axis=1)
        wrong[self._still] |= given[self._still].any(axis=1)
        if wrong.any():
            row = int(np.argmax(wrong))
            checked_vector(f'command to {layout.names[row]!r}', name, given[row])
            self.checked(layout.names[row], given[row], NO_VECTOR, 'world')  # says the reason
        return np.ascontiguousarray(given) + 0.0  # no zero is negative

    def _refuse_row(self, name: str, values: Any) -> None:
        """Name the first row that is none, where there is one for each body."""
        if is_list(values) and len(values) == len(self._layout.names):
            for body, row in zip(self._layout.names, values, strict=True):
                checked_vector(f'command to {body!r}', name, row)

    def drop_expired(self, tick: int) -> bool:
        """Let go of what ends before this tick; tell whether there was any."""
        if self.no_end_before > tick:
            return False
        self._take_written()
        expired = [key for key, slot in self._slots.items() if slot.until <= tick]
        if self._changed is not None:
            self._changed.update(core for core, _ in expired)
        for key in expired:
            self._drop(*key)
        self._find_end()
        return bool(expired)

    def _find_end(self) -> None:
        self.no_end_before = min((slot.until for slot in self._slots.values()), default=FOREVER)
        self._is_exact = True

    def next_expiry(self) -> int:
        """First tick on which a slot ends."""
        if not self._is_exact:
            self._find_end()
        return self.no_end_before

    def sums(self) -> tuple[Array, Array, Array]:
        """
        Add up the slots.

        returns : force (m, 3) and torque (m, 3) in world axes without gravity, and the table of
                  what turns with the bodies: rows of `elements.held_body_wrench`
        """
        self._take_written()
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
        table = np.array(turning, dtype=np.float64).reshape(-1, COLUMNS)
        return force, torque, table

    def _sums_of(self, core: int) -> tuple[Sequence[float], Sequence[float] | None]:
        """
        Add up the slots of a body: force and torque in world axes, and those that turn with it,
        or None.
        """
        held, turning = NOTHING, None
        for source in self._sources.get(core, ()):
            slot = self._slots.get((core, source))
            if slot is None:  # an interrupt came while it was put or dropped
                continue
            asked = (*slot.force, *slot.torque)
            if slot.turns_with_body:
                turning = [*map(operator.add, turning or NOTHING, asked)]
            else:
                held = [*map(operator.add, held, asked)]
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
        if self._changed is not None:
            self._write_bodies(self._changed, translation, rotation)
        elif self._rows is not None:
            self._write_rows(self._rows, translation, rotation)
        else:
            self._write_all(translation, rotation)
        return self._table

    def written(self, table: Array) -> None:
        """
        Note that what `write` gave has arrived: until then an interrupt lets all be redone.

        table : where what turns lies now
        """
        if table is not self._table:
            self._unsettle()
        self._table, self._changed = table, set()
        self._is_settled = self._rows is None and self._blocks[0] is not None
        asked = self._rows
        if asked is not None and asked.turns_with_body and asked.table is not table:
            asked.take_at_once, asked.table = self._taker_of_turning(asked, table), table
        self._take_at_once = None if asked is None else asked.take_at_once

    def prepare(self, translation: Array, rotation: Array) -> None:
        """Compile what writes the commands to single bodies into these blocks."""
        self._make_writer(translation, rotation)

    def _make_writer(self, translation: Array, rotation: Array) -> None:
        """Make what writes into the lanes of these blocks."""
        arrays = [argument(array) for array in (self._weight.reshape(-1), translation, rotation)]
        write = prepared(put_one, (0, *NOTHING), (self._layout.n_rigid, *arrays), brief=True)
        self._unsettle()
        self._writer, self._blocks = write, (translation, rotation)

    def _writer_of_row(self, *, turns: bool = False) -> Callable[..., Any]:
        """Give what writes what turns with a body into its row of the table."""
        if self._row_writers[0] is not self._table:
            last = argument(self._layout.to_principal), flat(self._table)
            first = (0, *NOTHING)
            as_it_is = prepared(put_row, first, (0, *last), brief=True)
            turned = prepared(put_row, first, (1, *last), brief=True)
            self._row_writers = self._table, as_it_is, turned
        return self._row_writers[2 if turns else 1]

    def _write_all(self, translation: Array, rotation: Array) -> None:
        if not self._sources and self._weights and self._weights[0] is translation:
            _, lanes, weights, turning_lanes = self._weights
            lanes[...], turning_lanes[...] = weights, 0.0
            self._table, self._turning = self._table[:0], {}
            return
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
        if not self._sources:
            lanes = rows(translation, TRANSLATION, FORCE, WRENCH)
            turning_lanes = rows(rotation, ROTATION, TORQUE, WRENCH)
            self._weights = translation, lanes, lanes.copy(), turning_lanes

    def _write_rows(self, asked: Rows, translation: Array, rotation: Array) -> None:
        """Do what `_write_all` does, for what is asked of all at once."""
        if asked.writers is None or asked.writers[0] is not translation:
            asked.writers = (translation, *self._writers_of(asked, translation, rotation))
            if not asked.turns_with_body:
                asked.take_at_once = self._taker_at_once(asked, translation, rotation)
        _, put, list_turning, table = asked.writers
        put()
        if asked.turns_with_body:
            self._table, self._turning = table[: list_turning()], None
        else:
            self._table, self._turning = self._table[:0], {}

    def _writers_of(self, asked: Rows, translation: Array, rotation: Array) -> tuple[Any, ...]:
        """
        Make what writes rows into lanes, what lists those that turn, and where it lists them.
        """
        sizes = self._layout.n_moving, self._layout.n_rigid
        arrays = [argument(array) for array in (self._weight.reshape(-1), translation, rotation)]
        given = [argument(array.reshape(-1)) for array in (asked.force, asked.torque)]
        table = np.zeros((sizes[1], COLUMNS))
        listed = prepared(list_turning, (), (*given, sizes[1], flat(table)), brief=True)
        if asked.turns_with_body:
            given = [argument(np.zeros(3 * sizes[0]))] * 2
        return prepared(put_all, (), (*given, *sizes, *arrays), brief=True), listed, table

    def _taker_of_turning(self, asked: Rows, table: Array) -> Callable[..., Any]:
        """Make what takes over rows in body axes and lists them where what turns lies now."""
        layout, nothing = self._layout, flat(self._nothing)
        last = (
            argument(layout.moving), argument(self._still), layout.n_rigid,
            argument(layout.to_principal), flat(asked.force), flat(asked.torque), flat(table),
        )  # fmt: skip
        return prepared(take_and_list_rows, (nothing, nothing), last, brief=True)

    def _taker_at_once(
        self, asked: Rows, translation: Array, rotation: Array
    ) -> Callable[..., Any]:
        """Make what takes over rows in world axes and writes them into lanes, all or none."""
        layout, nothing = self._layout, argument(self._nothing.reshape(-1))
        arrays = (asked.force, asked.torque, self._weight)
        last = (
            argument(layout.moving), argument(self._still), layout.n_rigid,
            argument(layout.to_principal), *(argument(array.reshape(-1)) for array in arrays),
            argument(translation), argument(rotation),
        )  # fmt: skip
        return prepared(take_and_put_rows, (nothing, nothing), last, brief=True)

    def _write_bodies(self, changed: set[int], translation: Array, rotation: Array) -> None:
        if not changed:
            return
        self._take_written()
        if self._blocks[0] is not translation or self._blocks[1] is not rotation:
            self._make_writer(translation, rotation)
        put_one, all_sources, slots = self._writer, self._sources, self._slots
        rows_of: dict[int, Sequence[float] | None] = {}
        places = self._turning
        if places is None:
            cores = self._table[:, BODY].astype(int).tolist()
            places = self._turning = {core: row for row, core in enumerate(cores)}
        for core in changed:
            sources = all_sources.get(core)
            if sources is not None and len(sources) == 1:  # as a rule
                slot = slots.get((core, sources[0]))
                row = places.get(core)
                if slot is not None and slot.turns_with_body is (row is not None):
                    asked = (*slot.force, *slot.torque)
                    if row is None:
                        put_one(core, *asked)
                    else:
                        put_one(core, *NOTHING)
                        self._writer_of_row()(row, *asked)
                    continue
            held, turning = self._sums_of(core)
            if turning is not None or core in places:
                rows_of[core] = turning
            put_one(core, *held)
        if not rows_of:
            return
        if all(row is not None and core in places for core, row in rows_of.items()):
            for core, row in rows_of.items():
                self._writer_of_row()(places[core], *(row or NOTHING))
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
