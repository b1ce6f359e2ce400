# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The arrays of a scene and the kernels that advance them: only what the scene needs, compiled when it is first needed.

A scene in which nothing depends on the state (commands in world axes, uniform gravity) takes the free kernel; forces
between bodies, drag, or a command in body axes take the coupled one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.blocks import (
    FX,
    HX,
    KX,
    LX,
    PX,
    QX,
    ROTATION,
    TRANSLATION,
    TX,
    blocks,
    gather,
    rows,
    scatter,
)
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces import FORCES, evaluator, held_body_wrench
from rigid_body_sim.physics.integrators.integrator import Integrator
from rigid_body_sim.physics.kernels import argument
from rigid_body_sim.physics.layout import Layout
from rigid_body_sim.physics.model import Scene, Vector

Array = NDArray[np.float64]

CHUNK = 1000  # [tick] between two copies of the state, to which a diverging run returns


class Stepper:
    """
    State and kernels of one run.

    translation, rotation : blocks, see `physics.blocks`
    """

    def __init__(self, scene: Scene, layout: Layout, integrator: Integrator) -> None:
        self._layout = layout
        self._integrator = integrator
        self.translation = layout.translation()
        self.rotation = layout.rotation()
        self._start = (self.translation.copy(), self.rotation.copy())
        self._types = [kind for kind in FORCES if any(f.TYPE == kind for f in scene.forces)]
        self._depends_on_velocity = any(f.depends_on_velocity() for f in scene.forces)
        self._tables, self._ranges = self._stack(scene)
        coefficients = integrator.coefficients(layout.moments)
        self._method = self._blocks_of(coefficients)
        size = integrator.scheme.workspace(blocks(layout.n_moving))
        self._workspace = np.zeros(size)
        self._free: Callable[..., Any] | None = None
        self._coupled: Callable[..., Any] | None = None
        self._hold_table(np.zeros((0, held_body_wrench.COLUMNS)))

    def _stack(self, scene: Scene) -> tuple[Array, list[int]]:
        """One table per type of force, end to end; ranges hold start and count of each."""
        numbers: list[float] = []
        ranges: list[int] = []
        for kind in self._types:
            elements = [force for force in scene.forces if force.TYPE == kind]
            ranges += [len(numbers), len(elements)]
            for element in elements:
                numbers += self._row(element)
        return np.array(numbers, dtype=np.float64), ranges

    def _row(self, element: Any) -> tuple[float, ...]:
        row = element.row(self._layout)
        if len(row) != element.COLUMNS:
            raise InvalidModel(f'force {element.TYPE!r}: a row of {len(row)} numbers, not {element.COLUMNS}')
        return row

    def _blocks_of(self, coefficients: Array) -> Array:
        width = coefficients.shape[1]
        array = np.zeros(blocks(self._layout.n_rigid) * 64 * width)
        if array.size:
            scatter(array, 64 * width, 0, coefficients)
        return array

    def _hold_table(self, table: Array) -> None:
        self._turning = len(table)
        self._elements = argument(np.concatenate((self._tables, table.reshape(-1))))
        self._element_ranges = argument(
            np.array([*self._ranges, len(self._tables), len(table)], dtype=np.int64)
        )
        self._arguments = (
            self._layout.n_moving,
            self._layout.n_rigid,
            argument(self.translation),
            argument(self.rotation),
            argument(self._method),
            argument(self._workspace),
            self._elements,
            self._element_ranges,
        )

    def hold(self, table: Array) -> None:
        """Take over what is held: `table` turns with the bodies, the rest is in the blocks already."""
        if table.size or self._turning:
            self._hold_table(table)
        rows(self.translation, TRANSLATION, FX, 3)[:] = rows(self.translation, TRANSLATION, HX, 3)
        rows(self.rotation, ROTATION, TX, 3)[:] = rows(self.rotation, ROTATION, KX, 3)

    @property
    def _is_free(self) -> bool:
        return not self._types and not self._turning

    def _free_kernel(self) -> Callable[..., Any]:
        if self._free is None:
            self._free = self._integrator.scheme.free(self._integrator.name)
        return self._free

    def _coupled_kernel(self) -> Callable[..., Any]:
        if self._coupled is None:
            kernels = [(kind, FORCES[kind].accumulate) for kind in self._types]
            kernels.append((held_body_wrench.NAME, held_body_wrench.accumulate))
            damped = '_velocity' if self._depends_on_velocity else ''
            self._coupled = self._integrator.scheme.coupled(
                self._integrator.name,
                scene='_'.join(self._types) + damped,
                evaluate=evaluator(kernels),
                velocity_dependent=self._depends_on_velocity,
            )
        return self._coupled

    def prepare(
        self, *, commands_in_body_axes: bool, progress: Callable[[str], None] | None
    ) -> None:
        """Compile the kernels that will be needed by advancing over no tick."""
        name = self._integrator.name
        wanted = []
        if not self._types:
            wanted.append((f'{name} for free bodies', self._free_kernel))
        if self._types or commands_in_body_axes:
            forces = ', '.join([*self._types, 'commands in body axes'])
            wanted.append((f'{name} with {forces}', self._coupled_kernel))
        for text, kernel in wanted:
            if progress is not None:
                progress(text)
            kernel()(0, 0, 1.0, *self._arguments)

    def advance(self, ticks: int, tick: int, h: float) -> int:
        """
        Advance over ticks of length h [s], the first of them being number `tick`.

        returns : ticks done; fewer than asked where a state left the finite numbers, then the state is the last good one
        """
        kernel = self._free_kernel() if self._is_free else self._coupled_kernel()
        done = 0
        while done < ticks:
            chunk = min(CHUNK, ticks - done)
            before = (self.translation.copy(), self.rotation.copy())
            if not self._call(kernel, chunk, tick + done, h):
                self._bad = self._copy_back(before)
                if chunk == 1:
                    return done
                return done + self._creep(kernel, chunk, tick + done, h)
            done += chunk
        return done

    def _creep(self, kernel: Callable[..., Any], ticks: int, tick: int, h: float) -> int:
        """Advance tick by tick up to the one that fails."""
        for done in range(ticks):
            before = (self.translation.copy(), self.rotation.copy())
            if not self._call(kernel, 1, tick + done, h):
                self._bad = self._copy_back(before)
                return done
        return ticks

    def _call(self, kernel: Callable[..., Any], ticks: int, tick: int, h: float) -> bool:
        try:
            return kernel(ticks, tick, h, *self._arguments) == 0.0
        except (ArithmeticError, ValueError):  # the plain source meets a division by zero or a root of NaN
            return False

    def _copy_back(self, before: tuple[Array, Array]) -> int:
        """Return to an earlier state; tell which body left the finite numbers."""
        points = gather(self.translation, TRANSLATION, 0, 6, self._layout.n_moving)
        turns = gather(self.rotation, ROTATION, 0, 7, self._layout.n_rigid)
        bad = ~np.isfinite(points).all(axis=1)
        bad[: self._layout.n_rigid] |= ~np.isfinite(turns).all(axis=1)
        self.translation[:], self.rotation[:] = before
        culprits = np.flatnonzero(bad)
        if not culprits.size:
            return 0
        return int(min(culprits, key=lambda core: self._layout.moving[core]))

    def first_diverged(self) -> int:
        """Core index of the first body, in scene order, that left the finite numbers."""
        return self._bad

    def strike(self, core: int, linear: Vector, angular: Vector) -> None:
        """Add to momentum [N s] and angular momentum [N m s], world axes."""
        block, lane = divmod(core, 64)
        rows(self.translation, TRANSLATION, PX, 3)[block, :, lane] += linear
        if core < self._layout.n_rigid:
            rows(self.rotation, ROTATION, LX, 3)[block, :, lane] += angular

    def orientation(self, core: int) -> Array:
        """Quaternion (4,) of the principal axes of a rigid body."""
        block, lane = divmod(core, 64)
        return rows(self.rotation, ROTATION, QX, 4)[block, :, lane].copy()

    def reset(self) -> None:
        """Return to the start of the scene."""
        self.translation[:], self.rotation[:] = self._start
