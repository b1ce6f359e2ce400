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
ROUNDING = 1e-14  # [-] of the largest energy, of what moved: what sums of it leave


def balance_line(balance: EnergyBalance) -> str:
    """
    Write the balance on one line; what is zero because nothing of its kind acts is left out, and
    so are digits below what is known.
    """
    if not math.isfinite(balance.defect):
        return 'energy balance: none, the energy is beyond all numbers'
    if balance.turnover == 0.0:
        return 'energy balance: nothing moved'
    shares = {
        'commands': balance.work_of_commands,
        'drives': balance.work_of_drives,
        'dissipation': -balance.dissipation,
        'contact': -balance.contact,
    }
    parts = [_signed(name, share) for name, share in shares.items() if share != 0.0]
    known = max(balance.uncertainty, ROUNDING * balance.turnover)
    closes = known >= abs(balance.defect)
    if closes and not parts:
        return (
            'energy balance: nothing brought energy or took it, and it stayed: within '
            f'{known:.1e} J of the {balance.turnover:.3g} J that moved'
        )
    if not closes:
        parts.append(_signed('defect of the method', balance.defect, digits=2))
    equation = ' '.join(parts).removeprefix('+ ')
    beyond = f'closes within {known:.1e} J of the {balance.turnover:.3g} J that moved'
    words = beyond if closes else defect_words(balance)
    return f'energy balance: change {balance.change:.4g} J = {equation} ({words})'


def _signed(name: str, joules: float, *, digits: int = 4) -> str:
    return f'{"-" if joules < 0.0 else "+"} {name} {abs(joules):.{digits}g} J'


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
        yield f'momentum: {drift_text(drift.momentum)}'
        yield f'angular momentum: {drift_text(drift.angular_momentum)}'
        return
    if not kept:
        yield 'momentum, angular momentum: they change, as forces from outside act on every body'
        return
    for quantity in dict.fromkeys(law.quantity for law in kept):
        laws = sorted((x for x in kept if x.quantity == quantity), key=lambda x: -x.drift)
        for law in laws[:LINES]:
            yield f'{quantity} of {_names(law.bodies)}: {drift_text(law.drift)}'
        if len(laws) > LINES:
            yield f'{quantity} of {len(laws) - LINES} others: less'


def _names(bodies: Sequence[str]) -> str:
    named = ', '.join(bodies[:NAMED])
    return named if len(bodies) <= NAMED else f'{named} and {len(bodies) - NAMED} more'


def drift_text(drift: float | None) -> str:
    """Write a relative drift for people."""
    if drift is None:
        return 'no conservation law holds in this scene'
    if not math.isfinite(drift):
        return 'drift beyond all numbers'
    if drift == 0.0:
        return 'no drift, to the last bit'
    return f'drift {drift:.1e} of its largest value'


def contact_lines(rise: float | None, joules: float | None, gap: float | None) -> Iterator[str]:
    """
    Say what holds where bodies meet: friction and impacts may take energy, never give it.

    rise, joules : [-] of the largest energy, [J] how far the energy rose above an earlier value;
                   None where something else may raise it
    gap          : [m] the deepest; negative where they overlapped, None where nothing touched
    """
    if rise is not None and joules is not None:
        if rise < ROUNDING:
            yield f'energy rise: none beyond rounding ({joules:.1e} J)'
        else:
            yield (
                f'energy rise: {joules:.1e} J, {rise:.1e} of the largest energy (overlap that is '
                'undone lifts bodies, and flight errs with its method; impacts give none)'
            )
    if gap is None:
        yield 'deepest overlap: nothing touched'
    elif gap < 0.0:
        yield f'deepest overlap: {-gap:.1e} m'
    else:
        yield 'deepest overlap: none'


def pace_text(simulated: float, wall: float) -> str:
    """Say how much faster than the clock a run was, also where it was slower."""
    pace = simulated / max(wall, 1e-9)
    return f'{pace:.0f} times real time' if pace >= 10.0 else f'{pace:.2g} times real time'
