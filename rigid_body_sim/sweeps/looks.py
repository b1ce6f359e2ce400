# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a row of a sweep tells of its run: last states, extremes at the looks, the energy balance.

Looks are at whole ticks that duration and `every` name, t = 0 and the end among them. All numbers
are made by the same sums of the same shape whether a run stands alone or beside others: element by
element, bodies in scene order.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.energy_balance import ROUNDING, TOO_MUCH, EnergyBalance
from rigid_body_sim.physics.diagnostics.invariants import Invariants
from rigid_body_sim.physics.diagnostics.numerical_damping import damps_no_spring
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state import snapshot
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

XYZ = ('x', 'y', 'z')
LAST = (  # columns of a last state, and where they stand in a state
    *((f'position.{c}', snapshot.POSITION + i) for i, c in enumerate(XYZ)),
    *((f'orientation.{c}', snapshot.ORIENTATION + i) for i, c in enumerate((*XYZ, 'w'))),
    *((f'velocity.{c}', snapshot.VELOCITY + i) for i, c in enumerate(XYZ)),
    *((f'angular_velocity.{c}', snapshot.ANGULAR_VELOCITY + i) for i, c in enumerate(XYZ)),
    *(
        (f'angular_velocity_body.{c}', snapshot.ANGULAR_VELOCITY_BODY + i)
        for i, c in enumerate(XYZ)
    ),
)
OF_POINT = ('position', 'velocity')  # what a point mass has of it


def look_ticks(ticks: int, every: int) -> list[int]:
    """Give the ticks after the start at which is looked: each `every` ticks, and the last."""
    found = list(range(every, ticks, every))
    return [*found, ticks]


class Looks:
    """
    Last states and extremes of runs side by side.

    scene : of one of them: who moves, who turns, who has columns
    named : of the bodies with columns; (): all that move
    runs  : how many
    """

    def __init__(self, scene: Scene, named: Sequence[str], runs: int) -> None:
        self._bodies = [
            (i, body)
            for i, body in enumerate(scene.bodies)
            if (body.name in named if named else not body.fixed)
        ]
        self._at = [i for i, _ in self._bodies]
        self.values = np.zeros((runs, len(scene.bodies), snapshot.COLUMNS))
        shape = (runs, len(self._at))
        self._low = np.full((*shape, 3), math.inf)
        self._high = np.full((*shape, 3), -math.inf)
        self._fastest = np.zeros((*shape, 2))
        self._pressed = np.full(shape, math.nan)  # [N] largest contact force; NaN: none is told
        self._gap = np.full(runs, math.inf)  # [m]
        self.meets = scene.contact.get('mode', 'none') != 'none'

    def look(self, values: Array) -> None:
        """Take states (runs, bodies, COLUMNS) into the extremes."""
        self.values = values
        own = values[:, self._at]
        position = own[..., snapshot.POSITION : snapshot.ORIENTATION]
        np.minimum(self._low, position, out=self._low)
        np.maximum(self._high, position, out=self._high)
        with np.errstate(over='ignore', invalid='ignore'):
            for k, first in enumerate((snapshot.VELOCITY, snapshot.ANGULAR_VELOCITY_BODY)):
                x, y, z = (own[..., first + i] for i in range(3))
                speed = np.sqrt(x * x + y * y + z * z)
                np.maximum(self._fastest[..., k], speed, out=self._fastest[..., k])

    def look_at_contacts(self, simulation: Simulation) -> None:
        """Take contact forces and gaps of a run that stands alone into the extremes."""
        contacts = simulation.contacts()
        gap = simulation.deepest_gap()
        self._gap[0] = math.inf if gap is None else gap
        force, _ = contacts.wrenches(simulation.state.position, simulation.dt)
        x, y, z = force[self._at].T
        self._pressed[0] = np.fmax(self._pressed[0], np.sqrt(x * x + y * y + z * z))

    def without(self, stays: NDArray[np.bool_]) -> None:
        """Go on with those runs only."""
        for name in ('values', '_low', '_high', '_fastest', '_pressed', '_gap'):
            setattr(self, name, getattr(self, name)[stays].copy())

    def columns(self, keep: Sequence[str], run: int) -> dict[str, Any]:
        """Give the columns of one of the runs."""
        found: dict[str, Any] = {}
        for k, (i, body) in enumerate(self._bodies):
            if 'last' in keep:
                row = self.values[run, i].tolist()
                found |= {
                    f'{body.name}.{name}': row[place]
                    for name, place in LAST
                    if not body.is_point or name.startswith(OF_POINT)
                }
            if 'extremes' in keep:
                found |= dict(self._extremes(body.name, run, k, turns=not body.is_point))
        if self.meets and 'extremes' in keep:
            gap = float(self._gap[run])
            found['contact.deepest_gap'] = gap if gap < math.inf else None
        return found

    def _extremes(self, name: str, run: int, k: int, *, turns: bool) -> Iterator[tuple[str, Any]]:
        for i, c in enumerate(XYZ):
            yield f'{name}.position.{c}.min', float(self._low[run, k, i])
            yield f'{name}.position.{c}.max', float(self._high[run, k, i])
        yield f'{name}.speed.max', float(self._fastest[run, k, 0])
        if turns:
            yield f'{name}.angular_speed.max', float(self._fastest[run, k, 1])
        if self.meets:
            yield f'{name}.contact_force.max', float(self._pressed[run, k])


class QuietEnergies:
    """
    The energy balances of runs side by side in which nothing works: no drive, no damper, no
    contact. Then all of a change is defect; the other quantities are those of `EnergyBalance`.

    scenes : of the runs, bodies of all in the same order
    """

    def __init__(self, scenes: Sequence[Scene], values: Array) -> None:
        self._laws = [Invariants(scene) for scene in scenes] if scenes[0].forces else []
        bodies = [[0.0 if b.fixed else b.mass for b in scene.bodies] for scene in scenes]
        self._masses = np.array(bodies)
        self._gravity = scenes[0].gravity
        kinetic, potential = self._energies(values)
        still = np.zeros(len(scenes))
        # rows as KINETIC and the others count them, a column for each run [J]
        self._seen = np.array([kinetic, potential, kinetic, potential, potential, still, still])

    @np.errstate(all='ignore')
    def _energies(self, values: Array) -> tuple[Array, Array]:
        """Kinetic and potential energies [J] of the runs."""
        kinetic = np.zeros(len(values))
        weight = np.zeros(len(values))
        for body in range(values.shape[1]):
            of_body = values[:, body]
            moving, turning, height = np.zeros((3, len(values)))
            for i in range(3):
                velocity = of_body[:, snapshot.VELOCITY + i]
                spin = of_body[:, snapshot.ANGULAR_VELOCITY + i]
                moving += of_body[:, snapshot.MOMENTUM + i] * velocity
                turning += of_body[:, snapshot.ANGULAR_MOMENTUM + i] * spin
                height += of_body[:, snapshot.POSITION + i] * self._gravity[i]
            kinetic += 0.5 * (moving + turning)
            weight -= self._masses[:, body] * height
        for run, law in enumerate(self._laws):
            weight[run] += law.stored_energy(State(values[run].copy()))
        return kinetic, weight

    @np.errstate(all='ignore')
    def look(self, values: Array) -> None:
        """Take the energies of now into the balances."""
        kinetic, potential = self._energies(values)
        seen = self._seen
        change = (kinetic - seen[KINETIC]) + (potential - seen[POTENTIAL])
        known = np.isfinite(change)
        np.maximum(seen[LARGEST], kinetic, out=seen[LARGEST], where=known)
        np.minimum(seen[LOWEST], potential, out=seen[LOWEST], where=known)
        np.maximum(seen[HIGHEST], potential, out=seen[HIGHEST], where=known)
        np.maximum(seen[GAIN], change - seen[LEAST], out=seen[GAIN], where=known)
        np.minimum(seen[LEAST], change, out=seen[LEAST], where=known)

    def balances(self, values: Array) -> list[EnergyBalance]:
        """Draw the balances."""
        rows = zip(*(row.tolist() for row in (*self._energies(values), *self._seen)), strict=True)
        return [_quiet_balance(*row) for row in rows]

    def without(self, stays: NDArray[np.bool_]) -> None:
        """Go on with those runs only."""
        kept = np.flatnonzero(stays).tolist()
        self._laws = [self._laws[i] for i in kept] if self._laws else []
        self._seen = self._seen[:, stays].copy()
        self._masses = self._masses[stays]


# what looks at energies have met: at the start, then the largest and lowest since; GAIN: of the
# change above its LEAST so far
KINETIC, POTENTIAL, LARGEST, LOWEST, HIGHEST, LEAST, GAIN = range(7)


def _quiet_balance(
    kinetic: float,
    potential: float,
    first_kinetic: float,
    first_potential: float,
    largest: float,
    lowest: float,
    highest: float,
    least: float,
    gain: float,
) -> EnergyBalance:
    """Draw the balance of a run in which nothing works, as `EnergyLedger` does [J]."""
    change = (kinetic - first_kinetic) + (potential - first_potential)
    largest = max(largest, kinetic)
    turnover = max(largest, max(highest, potential) - min(lowest, potential))
    rounding = ROUNDING * (largest + abs(potential) + abs(first_potential))
    return EnergyBalance(
        change=change,
        work_of_commands=0.0,
        work_of_drives=0.0,
        dissipation=0.0,
        contact=0.0,
        defect=change,
        uncertainty=rounding,
        relative=0.0 if change == 0.0 else abs(change) / turnover if turnover else math.inf,
        turnover=turnover,
        gain=max(gain, change - least),
        tolerated=TOO_MUCH * turnover + rounding,
    )


def energy_columns(balance: EnergyBalance) -> Mapping[str, float | None]:
    """Give the columns of an energy balance [J]."""
    return {f'energy.{name}': value for name, value in asdict(balance).items()}


def energy_warning(balance: EnergyBalance, integrator: Integrator, *, touched: bool) -> str | None:
    """
    Warn of a passive scene that gained energy, and of one whose method took what nothing else did.

    The end alone does not tell a loss from a swing of the energy, which other methods make.
    """
    name = integrator.name
    if not balance.gains:
        loss = -balance.unexplained
        if touched or damps_no_spring(integrator) or not loss > balance.loss_tolerated:
            return None
        return (
            f'the scene lost {loss:.2g} J, which no force, damper or command took; up to '
            f'{balance.loss_tolerated:.2g} J would be truncation; {name} lost it: take a '
            'shorter dt or another integrator'
        )
    return (
        f'the scene gained {balance.gain:.2g} J, though no command and no drive acts; up to '
        f'{balance.tolerated:.2g} J would be truncation; {name} brought it in: take a '
        'shorter dt or another integrator'
    )
