# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a run did to its energy: the balance of `diagnostics.energy_balance`, and its history.

A bag has both in its ending. Of a run in memory they are found by making it again: a meter beside
a controller would cost every run as much again, whether somebody asks or not.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.library.made_again import MadeAgain
from rigid_body_sim.library.run_arrays import RunArrays
from rigid_body_sim.physics.diagnostics.energy_balance import EnergyBalance
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.kept_lines import balance_line

AFFORDABLE = 3.0  # [s] of processor time that a run took: it is made again without being asked
KEPT = '_ending'  # of a run: what was found
MAY_BE_NONE = 'gain'  # of a balance: all else are numbers


def ending_of(run: RunArrays) -> Mapping[str, str]:
    """
    Give what the ending of a bag says of a run, as far as energy goes; empty: nothing. It is kept.

    Raises RunError where a run in memory, made again, comes out otherwise.
    """
    kept = run.__dict__
    if KEPT not in kept:
        kept[KEPT] = _ending(run)
    return kept[KEPT]


def _ending(run: RunArrays) -> Mapping[str, str]:
    if run._origin is None:
        return (Bag(run.path).ending or {}) if run.path is not None else {}
    again = MadeAgain(run)
    for _ in again.follow():
        pass
    again.check('energy_balance')
    return again.run.energy.ending()


def balance_of(ending: Mapping[str, str]) -> EnergyBalance | None:
    """Read the balance of a run from its ending; None where there is none."""
    try:
        told = json.loads(ending['energy_balance'])
        values: dict[str, Any] = {
            field.name: value
            if (value := told[field.name]) is None and field.name == MAY_BE_NONE
            else float('nan' if value is None else value)  # JSON knows no infinity
            for field in fields(EnergyBalance)
        }
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError):
        return None
    return EnergyBalance(**values)


def is_affordable(run: RunArrays) -> bool:
    """Whether the balance is known, or soon made."""
    return KEPT in run.__dict__ or run._origin is None or run._cost < AFFORDABLE


def words_of(run: RunArrays) -> str:
    """Say what became of the energy, in a line."""
    if run.scene is None:
        return 'energy balance: not known without a scene'
    if not is_affordable(run):
        cost = math.ceil(run._cost)
        return f'energy balance: run.energy_balance makes the run again for it, some {cost} s'
    try:
        balance = balance_of(ending_of(run))
    except (RunError, UserError) as error:
        return f'energy balance: not known; {error}'
    return 'energy balance: none is recorded' if balance is None else balance_line(balance)


def summary_of(run: RunArrays) -> str:
    """Say what a run is, what became of its energy, how it ended, and its warnings."""
    first, *rest = repr(run).splitlines()
    return '\n'.join([first, f'  {words_of(run)}', *rest])
