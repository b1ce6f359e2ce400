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
does. `PassiveEnergy` says so of a run that keeps no balance: it needs nothing but looks.

A loss is the same the other way, `unexplained_loss`: how far the change that no work explains,
defect - contact, has stayed below what it once was. It is seen only while nothing touches, as what
contact takes is not known apart; a scene may be driven. An energy that swings, as kicks and drifts
let it, comes back, and is no loss.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.work_meter import ROUNDING, WorkMeter
from rigid_body_sim.physics.forces.power import COMMANDS, DISSIPATION, DRIVES

Array = NDArray[np.float64]

# A method within its step limits keeps the energy of a free body within 1 % (`step_limits`), a
# spring at h omega = 0.3 within 1 % of its swing: less is truncation, more is a run gone wrong.
TOO_MUCH = 0.01  # [-] of the largest kinetic energy and change of potential energy
OVERLAP = 1e-3  # [m] where bodies meet, heaps sink and rise by less while they come to rest
NOT_IN_MOTION = 0.9  # [-] share of a gain that springs hold, from which on it is no motion
LOOKS_AT_LEAST = 16  # [-] before a loss is told: fewer do not tell it from a swing
LAST = 4  # [-] a loss is what the last of so many parts of the looks are below the highest


@dataclass(frozen=True)
class EnergyBalance:
    """
    change = work_of_commands + work_of_drives - dissipation - contact + defect, all [J].

    uncertainty : [J] how wrong the defect may be: the works are integrals from samples, and those
                  of impulses differences of energies that are rounded
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
    def unexplained(self) -> float:
        """Change that no command, drive and damper made: contact and defect [J]."""
        return self.defect - self.contact

    @property
    def loss_tolerated(self) -> float:
        """Loss that truncation, and works that are not known better, may explain [J]."""
        return max(self.tolerated, TOO_MUCH * self.turnover) + self.uncertainty

    @property
    def gains(self) -> bool:
        """Whether a passive scene gained more energy than is tolerated."""
        return self.gain is not None and self.gain > self.tolerated


class PassiveEnergy:
    """
    The energy that looks at a run met, and how far it rose.

    kinetic, potential : [J] where it begins
    overlap            : [J] that overlap of bodies that meet may explain

    gain    : [J] how far the energy rose above its lowest value before
    highest : [J] the most that the energy ever was above that of the begin
    largest : [J] kinetic energy
    """

    def __init__(self, kinetic: float, potential: float, *, overlap: float = 0.0) -> None:
        self._begin = (kinetic, potential)
        self._overlap = overlap
        self._potentials = (potential, potential)
        self._lowest = 0.0
        self.largest = kinetic
        self.gain = 0.0
        self.highest = 0.0

    def change(self, kinetic: float, potential: float) -> float:
        """Change of the energy since the begin [J]."""
        return (kinetic - self._begin[0]) + (potential - self._begin[1])

    def look(self, kinetic: float, potential: float) -> None:
        """Take the energies of now [J] into the lowest and the largest."""
        if not (math.isfinite(kinetic) and math.isfinite(potential)):
            return
        low, high = self._potentials
        self._potentials = (min(low, potential), max(high, potential))
        self.largest = max(self.largest, kinetic)
        self.gain = self.gain_by(kinetic, potential)
        self._lowest = min(self._lowest, self.change(kinetic, potential))
        self.highest = max(self.highest, self.change(kinetic, potential))

    def gain_by(self, kinetic: float, potential: float) -> float:
        """Give the gain with the energies of now [J]."""
        return max(self.gain, self.change(kinetic, potential) - self._lowest)

    def moved(self, kinetic: float, potential: float) -> float:
        """Largest kinetic energy or change of potential energy, with those of now [J]."""
        low, high = self._potentials
        return max(self.largest, kinetic, max(high, potential) - min(low, potential))

    def rounding(self, kinetic: float, potential: float) -> float:
        """How wrong the reading of the energies may be, with those of now [J]."""
        largest = max(self.largest, kinetic)
        return ROUNDING * (largest + abs(potential) + abs(self._begin[1]))

    def tolerated(self, kinetic: float, potential: float) -> float:
        """Gain that truncation and overlap may explain, with the energies of now [J]."""
        rounding = self.rounding(kinetic, potential)
        return TOO_MUCH * self.moved(kinetic, potential) + rounding + self._overlap


def overlap_energy(weight: float) -> float:
    """Energy that overlap may hold where bodies meet [J], of the weight of all that moves [N]."""
    return OVERLAP * weight


def unexplained_loss(looks: Sequence[float]) -> float:
    """
    How far the energy stays below what it was [J], of looks at a change that nothing explains.

    looks : (m,) [J] from the start on, evenly; 0 where they are too few
    """
    if len(looks) < LOOKS_AT_LEAST:
        return 0.0
    return max(looks) - max(looks[-(len(looks) // LAST) :])


def words_for_loss(
    loss: float, tolerated: float, *, time: float, integrator: str, damping: str | None
) -> str:
    """
    Warn of a loss in one line.

        loss, tolerated : [J]
        time            : [s]
        damping         : what the steps take from oscillations, `NumericalDamping.text`, if known
    """
    said = (
        f'the scene lost {loss:.2g} J by {time:g} s, which no force, damper or command took; up '
        f'to {tolerated:.2g} J would be truncation'
    )
    if damping is not None:
        return f'{said}; {damping}'
    return f'{said}; {integrator} lost it: take a shorter dt or another integrator'


def words_for_no_energy(energy: float, *, time: float, singular: str | None) -> str:
    """
    Warn in one line of an energy [J] at a time [s] that is no number.

    singular : of a force that has no energy where its bodies are, in words
    """
    cause = singular or (
        'a command, speed or place is so large that its square passes 1.8e308, where numbers end; '
        'look at the last commands (allowed in a node: up to 1e154 N, N m, N s, N m s)'
    )
    return f'the energy is {energy} J by {time:g} s, and errors in it are not seen; {cause}'


def words_for_gain(
    gain: float, tolerated: float, *, time: float, integrator: str, in_springs: bool
) -> str:
    """
    Warn of a gain in one line.

        gain, tolerated : [J]
        time            : [s]
        in_springs      : whether nearly all of it (NOT_IN_MOTION) is in what force elements store
    """
    said = (
        f'the scene gained {gain:.2g} J by {time:g} s, though no command and no '
        f'drive acts; up to {tolerated:.2g} J would be truncation'
    )
    if in_springs:
        return (
            f'{said}; nearly all of it stands in springs that a step of {integrator} does not '
            'resolve: what their ends are apart at the ticks is an error of position, not an '
            'energy that a body has; judge the run by its motion, or take a shorter dt'
        )
    return f'{said}; {integrator} brought it in: take a shorter dt or another integrator'


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
        self._meets = meets
        self._driven = driven
        overlap = overlap_energy(weight) if meets else 0.0
        self._seen = PassiveEnergy(kinetic, potential, overlap=overlap)
        self._lowest_rest = 0.0  # change less works, where bodies meet [J]

    @property
    def is_passive(self) -> bool:
        """Whether nothing brought energy in so far."""
        return not (self._driven or self._meter.was_commanded)

    def look(self, kinetic: float, potential: float) -> None:
        """Take the energies of now [J] into the lowest and the largest."""
        if not (math.isfinite(kinetic) and math.isfinite(potential)):
            return
        self._seen.look(kinetic, potential)
        if self._meets:
            commands, drives, taken, _ = self._works()
            rest = self._seen.change(kinetic, potential) - (commands + drives - taken)
            self._lowest_rest = min(self._lowest_rest, rest)

    def _works(self) -> tuple[float, float, float, float]:
        """Work of commands and drives, what was dissipated, and how wrong they may be [J]."""
        work, error = self._work_done()
        values = work.tolist()
        return values[COMMANDS], values[DRIVES], values[DISSIPATION], float(error.sum())

    def balance(self, kinetic: float, potential: float) -> EnergyBalance:
        """Draw the balance with the energies of now [J]; the looks stay as they are."""
        seen = self._seen
        change = seen.change(kinetic, potential)
        commands, drives, taken, error = self._works()
        rest = change - (commands + drives - taken)
        contact = max(0.0, -min(self._lowest_rest, rest)) if self._meets else 0.0
        defect = rest + contact
        turnover = max(seen.moved(kinetic, potential), abs(commands), abs(drives), taken)
        return EnergyBalance(
            change=change,
            work_of_commands=commands,
            work_of_drives=drives,
            dissipation=taken,
            contact=contact,
            defect=defect,
            uncertainty=error + seen.rounding(kinetic, potential),
            relative=0.0 if defect == 0.0 else abs(defect) / turnover if turnover else math.inf,
            turnover=turnover,
            gain=seen.gain_by(kinetic, potential) if self.is_passive else None,
            tolerated=seen.tolerated(kinetic, potential),
        )
