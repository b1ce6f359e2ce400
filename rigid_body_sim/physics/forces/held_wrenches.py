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

from dataclasses import dataclass
from typing import Any

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
from rigid_body_sim.physics.model.numbers import checked_vector, shown
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.blocks import (
    HELD_FORCE,
    HELD_TORQUE,
    ROTATION,
    TRANSLATION,
    scatter,
)
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]

SOURCES = ('force', 'torque', 'wrench')
FOREVER = 2**62  # [tick]
NO_VECTOR: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Slot:
    """
    One held command.

    force, torque : [N], [N m]  world axes, or principal axes where `turns_with_body`
    until         : [tick]      first tick on which it no longer acts
    """

    force: Vector
    torque: Vector
    turns_with_body: bool
    until: int = FOREVER

    @property
    def is_zero(self) -> bool:
        """Whether it asks for nothing."""
        return not (any(self.force) or any(self.torque))


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
        return np.flatnonzero((self.force != 0.0).any(axis=1) | (self.torque != 0.0).any(axis=1))

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
    for each would cost more than the tick.
    """

    def __init__(self, layout: Layout, gravity: Vector) -> None:
        self._layout = layout
        with np.errstate(over='ignore'):  # such a run diverges by name
            self._weight = layout.masses[:, None] * np.asarray(gravity)
        for core in range(layout.n_moving):
            if flow_of(layout.body(core)) is not None:
                self._weight[core] = 0.0  # `elements.variable_mass` adds it after its own factor
        self._slots: dict[tuple[int, str], Slot] = {}
        self._rows: Rows | None = None  # then there are no other slots

    @property
    def slots(self) -> dict[tuple[int, str], Slot]:
        """Every slot by (core index, source)."""
        if self._rows is not None:
            self._slots = self._rows.slots()
            self._rows = None
        return self._slots

    @slots.setter
    def slots(self, slots: dict[tuple[int, str], Slot]) -> None:
        self._slots = slots
        self._rows = None

    @property
    def may_end(self) -> bool:
        """Whether there are slots that may have an end."""
        return self._rows is None and bool(self._slots)

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
        force, torque = (
            checked_vector(f'command to {body!r}', 'force', force),
            checked_vector(f'command to {body!r}', 'torque', torque),
        )
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
        slot = Slot(force, torque, in_body, until)
        if frame not in RESERVED_FRAMES:
            source += SEPARATOR + frame
        if slot.is_zero:
            self.slots.pop((core, source), None)
        else:
            self.slots[core, source] = slot

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
        if turned[points].any() or (turns and pushed[points].any()):
            asked = np.abs(turned) + np.abs(pushed) if turns else np.abs(turned)
            core = layout.n_rigid + int(np.argmax(asked[points].any(axis=1)))
            self.checked(layout.body(core).name, pushed[core], turned[core], 'world')
            layout.principal_axes(layout.body(core).name, NO_VECTOR)
        if turns:
            pushed[: layout.n_rigid] = layout.all_principal_axes(pushed[: layout.n_rigid])
            turned[: layout.n_rigid] = layout.all_principal_axes(turned[: layout.n_rigid])
        rows = Rows(pushed + 0.0, turned + 0.0, turns)  # no zero is negative, as in sums
        others = {}
        if self._rows is None:
            others = {key: slot for key, slot in self._slots.items() if key[1] != 'wrench'}
        if others:
            self.slots = {**others, **rows.slots()}
        else:
            self._slots, self._rows = {}, rows

    def _rows_of(self, name: str, values: Any) -> Array:
        """Return (m, 3) finite numbers in core order of (n, 3) in scene order; None: zeros."""
        layout = self._layout
        count = len(layout.bodies)
        if values is None:
            return np.zeros((layout.n_moving, 3))
        try:
            given = np.array(values, dtype=np.float64)
        except (TypeError, ValueError):
            given = np.zeros(0)
        if given.shape != (count, 3):
            raise InvalidModel(
                f'commands to all bodies: {name} {shown(values)} of shape {np.shape(given)}; '
                f'allowed: an array ({count}, 3), a row for each body in the order of the scene, '
                'or None'
            )
        wrong = ~np.isfinite(given).all(axis=1)
        still = np.ones(count, dtype=bool)
        still[layout.moving] = False
        if (wrong | (still & given.any(axis=1))).any():
            row = int(np.argmax(wrong | (still & given.any(axis=1))))
            body = layout.names[row]
            self.checked(body, given[row], NO_VECTOR, 'world')  # refuses it with the reason
        return given[layout.moving]

    def drop_expired(self, tick: int) -> bool:
        """Let go of what ends before this tick; tell whether there was any."""
        if not self.may_end:
            return False
        expired = [key for key, slot in self.slots.items() if slot.until <= tick]
        for key in expired:
            del self.slots[key]
        return bool(expired)

    def next_expiry(self) -> int:
        """First tick on which a slot ends."""
        if not self.may_end:
            return FOREVER
        return min((slot.until for slot in self.slots.values()), default=FOREVER)

    def _ordered(self) -> list[tuple[int, Slot]]:
        return [(key[0], self.slots[key]) for key in sorted(self.slots, key=_place)]

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
        turning: dict[int, Array] = {}
        for core, slot in self._ordered():
            if slot.turns_with_body:
                row = turning.setdefault(core, np.zeros(held_body_wrench.COLUMNS))
                row[held_body_wrench.BODY] = row[held_body_wrench.RIGID] = core
                row[held_body_wrench.FORCES] += slot.force
                row[held_body_wrench.TORQUES] += slot.torque
            else:
                force[core] += slot.force
                torque[core] += slot.torque
        table = np.array(list(turning.values())).reshape(-1, held_body_wrench.COLUMNS)
        return force, torque, table

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
        Write what is held in world axes, gravity with it, into the blocks; return the table of
        what turns.
        """
        force, torque, table = self.sums()
        if self._layout.n_moving:
            with np.errstate(over='ignore', invalid='ignore'):
                scatter(translation, TRANSLATION, HELD_FORCE, force + self._weight)
        if self._layout.n_rigid:
            scatter(rotation, ROTATION, HELD_TORQUE, torque[: self._layout.n_rigid])
        return table


def _place(key: tuple[int, str]) -> tuple[int, int, str]:
    """Order in which a slot is added."""
    source, _, frame = key[1].partition(SEPARATOR)
    return key[0], SOURCES.index(source), frame


def is_source(name: str) -> bool:
    """Tell whether a slot can have this name."""
    return name.partition(SEPARATOR)[0] in SOURCES
