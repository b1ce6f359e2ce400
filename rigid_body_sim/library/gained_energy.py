# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether a passive run gained energy, seen from its rows: then its method brought it in.

The rule is that of `diagnostics.energy_balance`: without command and drive the energy must not
rise by more than truncation and, where bodies meet, overlap may explain. Some rows are looked at,
so that a run without commands costs as good as nothing more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.energy_balance import (
    NOT_IN_MOTION,
    PassiveEnergy,
    overlap_energy,
    words_for_gain,
)
from rigid_body_sim.physics.diagnostics.invariants import Invariants
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

LOOKS = 64  # [-] rows


def gain_warning(
    invariants: Invariants,
    time: Array,
    values: Array,
    masses: Array | None,
    *,
    meets: bool,
    integrator: str,
) -> str | None:
    """
    Warn where the energy of a scene in which nothing brings any in rose too far; None: it did not.

    time   : (m,) [s];   values : (m, n, COLUMNS) as of a Run;   masses : (m, n) [kg] or None
    meets  : whether bodies meet
    """
    if len(time) < 2 or invariants.is_driven:
        return None
    rows = np.unique(np.linspace(0, len(time) - 1, LOOKS).round().astype(int))
    states = [State(values[k], None if masses is None else masses[k]) for k in rows]
    with np.errstate(all='ignore'):  # a run about to diverge
        energies = [
            (invariants.kinetic_energy(state), invariants.potential_energy(state))
            for state in states
        ]
    overlap = overlap_energy(float(np.linalg.norm(invariants.weight()))) if meets else 0.0
    seen, worst, end = PassiveEnergy(*energies[0], overlap=overlap), 0, energies[0]
    for k, now in enumerate(energies):
        before = seen.gain
        seen.look(*now)
        worst = k if seen.gain > before else worst
        end = now if np.isfinite(now).all() else end
    tolerated = seen.tolerated(*end)
    if not seen.gain > tolerated:
        return None
    stored = invariants.stored_energy(states[worst]) - invariants.stored_energy(states[0])
    return words_for_gain(
        seen.gain,
        tolerated,
        time=float(time[rows[worst]]),
        integrator=integrator,
        in_springs=stored > NOT_IN_MOTION * seen.gain,
    )
