# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Everything that acts on the bodies of a scene, as tables of numbers and one kernel.

The force elements of a type share one table; behind them follow the pivots, what is held and turns
with the bodies, and the flows of mass. The chain of their kernels is evaluated in the order of
`chain`; where an element begins, ends or has a kink at an instant of its own, the schedule knows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.forces.elements import (
    FORCES,
    held_body_wrench,
    inertia_over_time,
    pivot,
    variable_mass,
)
from rigid_body_sim.physics.forces.elements.inertia_over_time import rows as inertia_rows
from rigid_body_sim.physics.forces.evaluator import derivatives, evaluator
from rigid_body_sim.physics.forces.power import PowerKernel, of_wrenches
from rigid_body_sim.physics.forces.schedule import Schedule, Switch, places_of
from rigid_body_sim.physics.forces.tables import stacked
from rigid_body_sim.physics.model.inertia_over_time import changing
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.variable_mass import end_of_flow, flow_of
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]


def is_timed(scene: Scene) -> bool:
    """Whether what acts in a scene, or a mass or an inertia, depends on time itself."""
    flows = any(flow_of(body) is not None for body in scene.bodies)
    return flows or bool(changing(scene)) or any(hasattr(f, 'acts') for f in scene.forces)


class ActingElements:
    """
    The elements of one scene.

    numbers, ranges     : what the kernels read: the tables, and where each begins and how many
                          rows it has
    arguments           : both as a kernel takes them
    schedule            : instants at which an element begins, ends or has a kink; None: there are
                          none
    kinks               : instants [s], ascending, at which a wrench changes its course
    is_timed            : whether a wrench depends on time itself
    depends_on_velocity : whether one depends on velocities
    pivots              : bodies that turn about a fixed point
    """

    def __init__(self, scene: Scene, layout: Layout) -> None:
        self._types = [kind for kind in FORCES if any(f.TYPE == kind for f in scene.forces)]
        self.depends_on_velocity = any(f.depends_on_velocity() for f in scene.forces)
        tables, self._ranges, self._switches = stacked(scene.forces, self._types, layout)
        self.pivots = pivot.Pivots(layout)
        self._ranges_of_pivots = [len(tables), self.pivots.count]
        self._tables = np.concatenate((tables, self.pivots.table.reshape(-1)))
        self._ranges_of_inertia = self._take_inertias(scene, layout)
        flowing = [body for body in scene.bodies if flow_of(body) is not None]
        # where masses flow, a potential that goes with them changes: its element says that power
        self._all_conserve = {
            kind
            for kind in self._types
            if not (flowing and hasattr(FORCES[kind], 'power'))
            and all(f.conserves_energy() for f in scene.forces if f.TYPE == kind)
        }
        self._flows = [variable_mass.row(body, layout, scene.gravity) for body in flowing]
        self._ends_of_flow = [end_of_flow(body) for body in flowing]
        self.is_timed = is_timed(scene)
        kinks = [f.kinks() for f in scene.forces if hasattr(f, 'kinks')]
        self.kinks = np.array(sorted({t for each in kinks for t in each}), dtype=np.float64)
        self._sizes = (layout.n_moving, layout.n_rigid)
        self._instants = _instants_of(scene, layout)
        self._pulled = _pulled_of(scene, layout)
        self._powers: dict[str, PowerKernel] = {}
        self._evaluate: Callable[..., Any] | None = None
        self._always = bool(self.names)  # something depends on the state whatever is commanded
        self.do_nothing = not self._always
        self.set_turning(np.zeros((0, held_body_wrench.COLUMNS)))

    def _take_inertias(self, scene: Scene, layout: Layout) -> list[int]:
        """Add the pieces of inertia over time to the tables; give where, or nothing."""
        pieces = [piece for body in changing(scene) for piece in inertia_rows(body, layout)]
        start = len(self._tables)
        self._tables = np.concatenate((self._tables, *(row for row, _, _ in pieces)))
        for number, (_, begin, end) in enumerate(pieces):
            place = start + number * inertia_over_time.COLUMNS + inertia_over_time.SWITCH
            self._switches.append(Switch(place, begin, end))
        return [start, len(pieces)] if pieces else []

    def set_turning(self, table: Array) -> None:
        """Take over the table of what is held and turns with the bodies."""
        self.turning = len(table)
        self.do_nothing = not (self._always or self.turning)
        flows = np.array(self._flows, dtype=np.float64).reshape(-1)
        last = len(self._tables) + table.size
        self.numbers = np.concatenate((self._tables, table.reshape(-1), flows))
        held = self.numbers[len(self._tables) : last]
        self.table = held.reshape(-1, held_body_wrench.COLUMNS)
        ranges = [*self._ranges, len(self._tables), len(table)]
        if self.pivots.count and self._types:
            ranges = [*self._ranges_of_pivots, *ranges]
        ranges += [last, len(self._flows)] if self._flows else []
        ranges += self._ranges_of_pivots
        ranges = [*self._ranges_of_inertia, *ranges]
        self.arguments = (argument(self.numbers), argument(np.array(ranges, dtype=np.int64)))
        places = range(last + variable_mass.SWITCH, len(self.numbers), variable_mass.COLUMNS)
        ends = [Switch(p, -math.inf, t) for p, t in zip(places, self._ends_of_flow, strict=True)]
        self._ranges_of_chain = ranges
        switches = [*self._switches, *ends]
        self.schedule = Schedule(switches, self.kinks) if self.is_timed else None

    def change_turning(self, table: Array) -> None:
        """Take over other numbers for as many bodies as turn already."""
        self.table[:] = table

    def bodies_at(self, places: Sequence[float], h: float) -> NDArray[np.bool_]:
        """
        Tell on which moving bodies something begins, ends or has a kink at places [tick].
        """
        found = np.zeros(self._sizes[0], dtype=np.bool_)
        for core, instants in self._instants:
            found[core] |= bool(np.isin(places_of(instants, h), places).any())
        return found

    def pulled(self) -> NDArray[np.bool_]:
        """Tell of each moving body whether something acts on it that the blocks do not hold."""
        found = self._pulled.copy()
        found[self.table[:, held_body_wrench.BODY].astype(np.int64)] = True
        return found

    @property
    def names(self) -> list[str]:
        """Name what depends on the state whatever is commanded."""
        names = [*self._types, *([variable_mass.NAME] if self._flows else [])]
        names += [inertia_over_time.NAME] if self._ranges_of_inertia else []
        return names + ([pivot.NAME] if self.pivots.count else [])

    def chain(self) -> list[tuple[str, Any]]:
        """Give the elements of the scene, with those that no scene names, by name."""
        chain: list[tuple[str, Any]] = [(kind, FORCES[kind]) for kind in self._types]
        chain.append((held_body_wrench.NAME, held_body_wrench))
        if self.pivots.count and self._types:
            chain.insert(0, (f'{pivot.NAME}_first', pivot.FIRST))
        if self._flows:
            chain.append((variable_mass.NAME, variable_mass))
        if self.pivots.count:
            chain.append((pivot.NAME, pivot.LAST))
        if self._ranges_of_inertia:
            chain.insert(0, (inertia_over_time.NAME, inertia_over_time))
        return chain

    def working(self) -> list[tuple[PowerKernel, int, int]]:
        """
        Give the elements that bring or take energy: kernel, first place and number of each type.
        """
        ranges = zip(self._ranges_of_chain[::2], self._ranges_of_chain[1::2], strict=True)
        return [
            (self._power_of(name, element), start, count)
            for (name, element), (start, count) in zip(self.chain(), ranges, strict=False)
            if count
            and name not in self._all_conserve
            and (hasattr(element, 'power') or name in self._types)
        ]

    def _power_of(self, name: str, element: Any) -> PowerKernel:
        if hasattr(element, 'power'):
            return element.power
        if name not in self._powers:
            self._powers[name] = of_wrenches(element.accumulate, *self._sizes)
        return self._powers[name]

    @property
    def kernel_name(self) -> str:
        """Tell the kernels for these elements from those for others."""
        return '_'.join(name for name, _ in self.chain() if name != held_body_wrench.NAME)

    def evaluate(self) -> Callable[..., Any]:
        """Make the kernel that adds up all forces and torques."""
        if self._evaluate is None:
            self._evaluate = evaluator(
                [(name, element.accumulate) for name, element in self.chain()]
            )
        return self._evaluate

    def derivatives(self) -> Any:
        """Make the kernel of their derivatives."""
        chain = self.chain()
        # the last word on all others is a derivative of theirs, if they have one
        unknown = [name for name, element in chain if not hasattr(element, 'linearise')]
        return derivatives(
            chain, by_differences=bool(self._flows or (self.pivots.count and unknown))
        )


def _pulled_of(scene: Scene, layout: Layout) -> NDArray[np.bool_]:
    """
    Tell of each moving body whether an element of the scene acts on it.
    """
    cores = {int(scene_index): core for core, scene_index in enumerate(layout.moving)}
    found = np.zeros(layout.n_moving, dtype=np.bool_)
    found[np.asarray(layout.pivoted, dtype=np.int64)] = True
    for force in scene.forces:
        for name in force.bodies():
            if name in layout.names and layout.index(name) in cores:
                found[cores[layout.index(name)]] = True
    for index, core in cores.items():
        body = scene.bodies[index]
        found[core] |= flow_of(body) is not None or body.inertia_over_time is not None
    return found


def _instants_of(scene: Scene, layout: Layout) -> list[tuple[int, Array]]:
    """
    Instants [s] at which what acts on a moving body begins, ends or has a kink, body by body.
    """
    cores = {int(scene_index): core for core, scene_index in enumerate(layout.moving)}
    found = []
    for force in scene.forces:
        instants = [*force.acts()] if hasattr(force, 'acts') else []
        instants += force.kinks() if hasattr(force, 'kinks') else []
        ends = {cores.get(layout.index(name)) for name in force.bodies() if name in layout.names}
        found += [(core, instants) for core in ends if core is not None and instants]
    for index, body in enumerate(scene.bodies):
        if index in cores:
            core = cores[index]
            if flow_of(body) is not None:
                found.append((core, [end_of_flow(body)]))
            if body.inertia_over_time is not None:
                pieces = inertia_rows(body, layout)
                found.append((core, [t for _, *ends in pieces for t in ends]))
    return [(core, np.array(times, dtype=np.float64)) for core, times in found]
