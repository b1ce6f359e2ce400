# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The energy balance of a run as it goes: looks at publish ticks, a history of them, and a warning
while a passive scene gains, where a scene has lost what nothing took, or where the numbers end.

Looks depend on ticks alone, so that a replay finds the same numbers to the bit. They are made at
every publish tick at first; when the history is full, every second row of it goes, and from then
on every second look. Where bodies meet every publish tick is looked at, because contact may take
energy at any.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict

import numpy as np

from rigid_body_sim.physics.diagnostics.energy_balance import (
    NOT_IN_MOTION,
    EnergyBalance,
    unexplained_loss,
    words_for_gain,
)
from rigid_body_sim.physics.simulation import Simulation

ROWS = 256  # of the history: more than a picture shows
COLUMNS = ('time', 'change', 'work_of_commands', 'work_of_drives', 'dissipation', 'contact',
           'defect')  # fmt: skip
TERMS = COLUMNS[1:]  # of the equation [J]
CONTACT, DEFECT = COLUMNS.index('contact'), COLUMNS.index('defect')


class EnergyLog:
    """
    The balance of one run.

    history : rows of COLUMNS [s, J …], ascending
    """

    def __init__(
        self, simulation: Simulation, every: int, warn: Callable[[str], None], *, phase: int = 0
    ) -> None:
        self._simulation = simulation
        self._every = every
        self._phase = phase
        self._warn = warn
        self.begin()

    def begin(self) -> None:
        """Begin the balance here, with all its sums at zero."""
        simulation = self._simulation
        simulation.keep_energy_balance()
        self._stored = simulation.stored_energy()
        self.begun_at = simulation.tick
        self._stride = 1
        self._gain = 0.0  # at the last look [J]
        self._warned_of: set[bool] = set()  # whether it stood in springs
        self._has_numbers = True
        self._may_warn_of_loss = True
        self.history: list[tuple[float, ...]] = []
        self._look()

    def at_publish(self) -> None:
        """Look at the energy, if it is time to; at a publish tick."""
        number = (self._simulation.tick - self._phase) // self._every
        if number % self._stride == 0:
            self._look()
            if len(self.history) >= ROWS:
                self._thin_out()
        elif self._simulation.has_contact:
            self._simulation.look_at_energy()

    def _thin_out(self) -> None:
        """Keep the first row and those of every second look."""
        self._stride *= 2
        whole = self._stride * self._every
        ticks = [round(row[0] * 1e9 / self._simulation.dt_ns) for row in self.history]
        self.history = [
            row
            for tick, row in zip(ticks, self.history, strict=True)
            if tick == self.begun_at or (tick - self._phase) % whole == 0
        ]

    def _look(self) -> None:
        self._simulation.look_at_energy()
        balance = self.balance()
        self.history.append(self._row(balance))
        gain = balance.gain or 0.0
        if balance.gains and gain > self._gain:  # it is now that so much was gained
            self._tell(balance, gain)
        self._gain = gain
        if self._may_warn_of_loss:
            self._look_for_loss(balance)

    def _look_for_loss(self, balance: EnergyBalance) -> None:
        """Warn once of energy that nothing took, while nothing has touched."""
        loss = unexplained_loss([row[DEFECT] - row[CONTACT] for row in self.history])
        if not loss > balance.loss_tolerated:
            return
        self._may_warn_of_loss = False
        if not self._simulation.has_touched:
            self._warn(self._simulation.words_for_loss(loss, balance.loss_tolerated))

    def _row(self, balance: EnergyBalance) -> tuple[float, ...]:
        values = asdict(balance)
        return (self._simulation.time, *(values[name] for name in TERMS))

    def balance(self) -> EnergyBalance:
        """
        Draw the balance now; warn once if it has no numbers any more, and no gain led there.
        """
        balance = self._simulation.energy_balance()
        terms = {name: getattr(balance, name) for name in TERMS}
        beyond = {name: joules for name, joules in terms.items() if not math.isfinite(joules)}
        if beyond and self._has_numbers and not self._warned_of:
            self._has_numbers = False
            simulation = self._simulation
            singular = simulation.singular_force()
            self._warn(_words_for_no_numbers(beyond, time=simulation.time, singular=singular))
        return balance

    def ending(self) -> dict[str, str]:
        """Give the balance and its history as a bag keeps them."""
        rows = list(self.history)
        if not rows or rows[-1][0] != self._simulation.time:
            rows.append(self._row(self.balance()))
        return {
            'energy_balance': balance_json(self.balance()),
            'energy_history': json.dumps(
                {name: [_short(row[i]) for row in rows] for i, name in enumerate(COLUMNS)}
            ),
        }

    def _tell(self, balance: EnergyBalance, gain: float) -> None:
        """Warn of a gain: once of what springs hold, and once of what is in the motion."""
        simulation = self._simulation
        in_springs = simulation.stored_energy() - self._stored > NOT_IN_MOTION * gain
        if in_springs in self._warned_of:
            return
        self._warned_of.add(in_springs)
        self._warn(
            words_for_gain(
                gain,
                balance.tolerated,
                time=simulation.time,
                integrator=simulation.integrator.name,
                in_springs=in_springs,
            )
        )


def _words_for_no_numbers(
    beyond: Mapping[str, float], *, time: float, singular: str | None
) -> str:
    """
    Warn in one line at a time [s], of terms of the balance [J] that are no numbers any more.

    singular : of a force that has no energy where its bodies are, in words
    """
    told = ', '.join(f'{name.replace("_", " ")} {joules} J' for name, joules in beyond.items())
    said = f'the energy balance has no numbers any more by {time:g} s: {told}'
    unseen = 'errors in the energy are not seen from here on'
    if singular is not None:
        return f'{said}; {singular}; {unseen}'
    return (
        f'{said}; a command, speed or place is so large that its energy passes 1.8e308 J, where '
        f'numbers end, and {unseen}; look at the last commands (N, N m, N s, N m s, m, m/s) '
        'and begin anew, with ~/reset in the node'
    )


def balance_json(balance: EnergyBalance) -> str:
    """Write a balance: floats survive to the bit; what is no number is null."""
    return json.dumps(as_numbers(balance))


def as_numbers(balance: EnergyBalance) -> dict[str, float | None]:
    """Give the fields of a balance; JSON knows neither infinity nor NaN."""
    return {
        name: value if value is None or np.isfinite(value) else None
        for name, value in asdict(balance).items()
    }


def _short(value: float) -> float | None:
    """Seven digits, for pictures."""
    return float(f'{value:.7g}') if np.isfinite(value) else None
