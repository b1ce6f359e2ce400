# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a run kept, in lines for people: its energy balance, and momentum and angular momentum of the
bodies that keep them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rigid_body_sim.physics.diagnostics.conserved_groups import KeptQuantity
from rigid_body_sim.physics.diagnostics.energy_balance import EnergyBalance
from rigid_body_sim.physics.diagnostics.invariants import Drift

NAMED = 3  # bodies that a line names
LINES = 6  # groups that have a line of their own


def balance_line(balance: EnergyBalance) -> str:
    """
    Write the balance on one line; what is zero because nothing of its kind acts is left out.
    """
    parts = [
        f'{sign} {name} {value:.4g} J'
        for sign, name, value in (
            ('+', 'commands', balance.work_of_commands),
            ('+', 'drives', balance.work_of_drives),
            ('-', 'dissipation', balance.dissipation),
            ('-', 'contact', balance.contact),
        )
        if value != 0.0
    ]
    equation = ' '.join([*parts, f'+ defect {balance.defect:.2g} J']).removeprefix('+ ')
    return f'energy balance: change {balance.change:.4g} J = {equation} ({defect_words(balance)})'


def defect_words(balance: EnergyBalance) -> str:
    """Say how large the defect is beside what moved, and how well it is known."""
    if not math.isfinite(balance.defect):
        return 'beyond all numbers'
    if balance.turnover == 0.0:
        return 'nothing moved'
    said = f'{balance.relative:.1e} of the {balance.turnover:.3g} J that moved'
    if balance.uncertainty >= abs(balance.defect):
        return f'{said}; known only to {balance.uncertainty:.1e} J'
    return f'{said}, +- {balance.uncertainty:.0e} J'


def momentum_lines(drift: Drift, kept: Sequence[KeptQuantity]) -> Iterator[str]:
    """Say how well momentum and angular momentum were kept: of all, or of whom they are."""
    if drift.momentum is not None:
        yield f'momentum drift: {drift_text(drift.momentum)}'
        yield f'angular momentum drift: {drift_text(drift.angular_momentum)}'
        return
    if not kept:
        yield 'momentum, angular momentum: forces from outside act on every body'
        return
    for quantity in dict.fromkeys(law.quantity for law in kept):
        laws = sorted((x for x in kept if x.quantity == quantity), key=lambda x: -x.drift)
        for law in laws[:LINES]:
            yield f'{quantity} drift of {_names(law.bodies)}: {drift_text(law.drift)}'
        if len(laws) > LINES:
            yield f'{quantity} drift of {len(laws) - LINES} others: less'


def _names(bodies: Sequence[str]) -> str:
    named = ', '.join(bodies[:NAMED])
    return named if len(bodies) <= NAMED else f'{named} and {len(bodies) - NAMED} more'


def drift_text(drift: float | None) -> str:
    """Write a relative drift for people."""
    if drift is None:
        return 'no conservation law holds in this scene'
    if not math.isfinite(drift):
        return 'beyond all numbers'
    return f'{drift:.1e} of the largest value'
