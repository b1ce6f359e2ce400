# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The energy balance of a run: what changed, what was brought in and taken out, what is left over.

    change = work of commands + work of drives - dissipation - contact + defect              [J]

        change      : of `Simulation.energy()` since the balance began
        commands    : work of what was held on the bodies or struck them
        drives      : of forces over time, constant ones without a potential, flows of mass
        dissipation : what dampers and drag took, not negative
        contact     : what friction and impacts took, not negative; zero where no bodies meet
        defect      : what no force accounts for: the error that the steps of the method made in
                      the energy, positive where it was brought in

The works are integrals of the power along the motion that the run made (`work_meter`). So the
defect is the sum of what each step did to the energy less what the forces at its states did, and
goes to zero with the order of the method. It says nothing of where the bodies are: a run can be
wrong with a small defect.

Contact knows no power. There the rule is: contact may only take. What the balance without contact
fell by, at its lowest look so far, was taken by contact; what it has risen since is defect. (A
defect that contact at once takes again is not seen; what overlap or a resting contact stores for a
moment is seen as defect, and gone with it.)

In a passive scene, without command and drive, the energy must not rise. `gain` is how far it did,
above its lowest value before; `gains` says whether that is more than a method within its limits
does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.work_meter import WorkMeter
from rigid_body_sim.physics.forces.power import COMMANDS, DISSIPATION, DRIVES

Array = NDArray[np.float64]

# A method within its step limits keeps the energy of a free body within 1 % (`step_limits`), a
# spring at h omega = 0.3 within 1 % of its swing: less is truncation, more is a run gone wrong.
TOO_MUCH = 0.01  # [-] of the largest kinetic energy and change of potential energy
OVERLAP = 1e-3  # [m] where bodies meet, heaps sink and rise by less while they come to rest
ROUNDING = 1e-15  # [-] of kinetic and potential energy: of reading them, not of the run


@dataclass(frozen=True)
class EnergyBalance:
    """
    change = work_of_commands + work_of_drives - dissipation - contact + defect, all [J].

    uncertainty : [J] how wrong the defect may be: the works are integrals from samples
    relative    : [-] |defect| over the turnover
    turnover    : [J] largest energy that moved: of kinetic energy, changes of potential energy,
                  and each of the works, at the looks so far
    gain        : [J] how far the energy of a passive scene rose above its lowest value before;
                  None where a command or a drive acted
    tolerated   : [J] a gain that truncation and, where bodies meet, overlap may explain
    """

    change: float
    work_of_commands: float
    work_of_drives: float
    dissipation: float
    contact: float
    defect: float
    uncertainty: float
    relative: float
    turnover: float
    gain: float | None
    tolerated: float

    @property
    def gains(self) -> bool:
        """Whether a passive scene gained more energy than is tolerated."""
        return self.gain is not None and self.gain > self.tolerated


@dataclass
class _Seen:
    """What the looks so far met [J]."""

    kinetic: float
    lowest_potential: float
    highest_potential: float
    lowest: float = 0.0  # change of the energy
    gain: float = 0.0
    lowest_rest: float = 0.0  # change less works, where bodies meet


class EnergyLedger:
    """
    Keeps the balance of one run.

    meter             : of the works
    works             : () -> works so far [J], and how wrong they may be
    kinetic, potential: [J] where it begins
    meets             : whether bodies meet
    driven            : whether the scene itself brings energy in
    weight            : [N] of all that moves
    """

    def __init__(
        self,
        meter: WorkMeter,
        works: Callable[[], tuple[Array, Array]],
        kinetic: float,
        potential: float,
        *,
        meets: bool,
        driven: bool,
        weight: float,
    ) -> None:
        self._meter = meter
        self._work_done = works
        self._begin = (kinetic, potential)
        self._meets = meets
        self._driven = driven
        self._overlap = OVERLAP * weight if meets else 0.0
        self._seen = _Seen(kinetic, potential, potential)

    @property
    def is_passive(self) -> bool:
        """Whether nothing brought energy in so far."""
        return not (self._driven or self._meter.was_commanded)

    def _change(self, kinetic: float, potential: float) -> float:
        return (kinetic - self._begin[0]) + (potential - self._begin[1])

    def look(self, kinetic: float, potential: float) -> None:
        """Take the energies of now [J] into the lowest and the largest."""
        if not (math.isfinite(kinetic) and math.isfinite(potential)):
            return
        seen, change = self._seen, self._change(kinetic, potential)
        seen.kinetic = max(seen.kinetic, kinetic)
        seen.lowest_potential = min(seen.lowest_potential, potential)
        seen.highest_potential = max(seen.highest_potential, potential)
        seen.gain = max(seen.gain, change - seen.lowest)
        seen.lowest = min(seen.lowest, change)
        if self._meets:
            commands, drives, taken, _ = self._works()
            seen.lowest_rest = min(seen.lowest_rest, change - (commands + drives - taken))

    def _works(self) -> tuple[float, float, float, float]:
        """Work of commands and drives, what was dissipated, and how wrong they may be [J]."""
        work, error = self._work_done()
        values = work.tolist()
        return values[COMMANDS], values[DRIVES], values[DISSIPATION], float(error.sum())

    def balance(self, kinetic: float, potential: float) -> EnergyBalance:
        """Draw the balance with the energies of now [J]; the looks stay as they are."""
        seen, change = self._seen, self._change(kinetic, potential)
        commands, drives, taken, error = self._works()
        rest = change - (commands + drives - taken)
        contact = max(0.0, -min(seen.lowest_rest, rest)) if self._meets else 0.0
        defect = rest + contact
        largest = max(seen.kinetic, kinetic)
        span = max(seen.highest_potential, potential) - min(seen.lowest_potential, potential)
        moved = max(largest, span)
        turnover = max(moved, abs(commands), abs(drives), taken)
        rounding = ROUNDING * (largest + abs(potential) + abs(self._begin[1]))
        return EnergyBalance(
            change=change,
            work_of_commands=commands,
            work_of_drives=drives,
            dissipation=taken,
            contact=contact,
            defect=defect,
            uncertainty=error + rounding,
            relative=0.0 if defect == 0.0 else abs(defect) / turnover if turnover else math.inf,
            turnover=turnover,
            gain=max(seen.gain, change - seen.lowest) if self.is_passive else None,
            tolerated=TOO_MUCH * moved + rounding + self._overlap,
        )
