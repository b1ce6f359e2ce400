# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether a passive run gained or lost energy, seen from its rows: then its method did it.

The rules are those of `diagnostics.energy_balance`: without command and drive the energy must not
rise by more than truncation and, where bodies meet, overlap may explain; nor may it fall, where
nothing brakes and nothing touched. Some rows are looked at, so that a run without commands costs
as good as nothing more. What the method takes beside dampers is told by `Run.energy_balance`,
which makes the run again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.energy_balance import (
    NOT_IN_MOTION,
    PassiveEnergy,
    overlap_energy,
    unexplained_loss,
    words_for_gain,
)
from rigid_body_sim.physics.state.snapshot import State

if TYPE_CHECKING:
    from rigid_body_sim.physics.simulation import Simulation

Array = NDArray[np.float64]

LOOKS = 64  # [-] rows


def energy_warning(
    simulation: Simulation, time: Array, values: Array, masses: Array | None
) -> str | None:
    """
    Warn where the energy of a scene in which nothing brings any in rose too far, or fell where
    nothing takes any; None: it did not.

    simulation : stands at the end of the run
    time   : (m,) [s];   values : (m, n, COLUMNS) as of a Run;   masses : (m, n) [kg] or None
    """
    invariants = simulation.invariants
    if len(time) < 2 or invariants.is_driven:
        return None
    rows = np.unique(np.linspace(0, len(time) - 1, LOOKS).round().astype(int))
    states = [State(values[k], None if masses is None else masses[k]) for k in rows]
    with np.errstate(all='ignore'):  # a run about to diverge
        energies = [
            (invariants.kinetic_energy(state), invariants.potential_energy(state))
            for state in states
        ]
    meets = simulation.has_contact
    overlap = overlap_energy(float(np.linalg.norm(invariants.weight()))) if meets else 0.0
    seen, worst, end = PassiveEnergy(*energies[0], overlap=overlap), 0, energies[0]
    changes = []
    for k, now in enumerate(energies):
        before = seen.gain
        seen.look(*now)
        worst = k if seen.gain > before else worst
        if np.isfinite(now).all():
            end = now
            changes.append(seen.change(*now))
    tolerated = seen.tolerated(*end)
    if seen.gain > tolerated:
        stored = invariants.stored_energy(states[worst]) - invariants.stored_energy(states[0])
        return words_for_gain(
            seen.gain,
            tolerated,
            time=float(time[rows[worst]]),
            integrator=simulation.integrator.name,
            in_springs=stored > NOT_IN_MOTION * seen.gain,
        )
    loss = unexplained_loss(changes)
    if loss > tolerated and not simulation.may_lose_energy:
        return simulation.words_for_loss(loss, tolerated)
    return None
