# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Compares what a bag says of its run, in manifest and ending, with what the run itself says when it
is run again.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

NOT_OF_THE_RUN = {
    'package_version',
    'software',
    'platform',
    'integrator_choice',
    'command_kinds',  # that were known then; a later version may know more
}
EXACT = ('last_tick', 'ticks', 'last_time_ns', 'final_state_sha256', 'state_chain_sha256')
FIGURES = (
    'energy_drift',
    'momentum_drift',
    'angular_momentum_drift',
    'energy_rise',
    'deepest_gap',
    'orientation_drift',
)
UNEVEN_ENDINGS = {'diverged', 'error'}  # within a tick: the last look was not at its boundary
RELATIVE = 1e-6  # sums over bodies are rounded otherwise on other processors
OF_TURNOVER = 1e-9  # [-] what rounding leaves of joules, relative to the energy that moved
ABSOLUTE = 1e-12  # of a drift relative to the largest value: such a rounding of it


class Fact(NamedTuple):
    """A value that the recording states otherwise than the run."""

    name: str
    recorded: str
    replayed: str


def manifest_differences(recorded: Mapping[str, str], again: Mapping[str, str]) -> Iterator[Fact]:
    """Compare manifests: what both state and the run decides."""
    for key in again.keys() & recorded.keys() - NOT_OF_THE_RUN:
        if recorded[key] != again[key] and _parsed(recorded[key]) != _parsed(again[key]):
            yield Fact(f'manifest, {_words(key)}', recorded[key], again[key])


def ending_differences(
    recorded: Mapping[str, str], again: Mapping[str, str], *, same_looks: bool
) -> Iterator[Fact]:
    """
    Compare endings: ticks and hashes exactly; figures, where both looked at the same ticks, up to
    rounding.
    """
    for key in EXACT:
        if key in recorded and recorded[key] != again[key]:
            yield Fact(_words(key), recorded[key], again[key])
    if not same_looks or recorded.get('end_reason') in UNEVEN_ENDINGS:
        return
    for key in FIGURES:
        said, is_ = recorded.get(key, 'nothing'), again.get(key, 'nothing')
        if not _alike(_number(said), _number(is_)):
            yield Fact(_words(key), said, is_)
    least = _least_joules(again)
    said, is_ = (ending.get('energy_balance', 'nothing') for ending in (recorded, again))
    if not _same_joules(_parsed(said), _parsed(is_), least):
        yield Fact('energy balance', said, is_)
    said, is_ = (ending.get('energy_history', 'nothing') for ending in (recorded, again))
    yield from _history_differences(_parsed(said), _parsed(is_), least)


def _least_joules(ending: Mapping[str, str]) -> float:
    """Energy that rounding may leave, beside what moved [J]."""
    balance = _parsed(ending.get('energy_balance', 'nothing'))
    numbers = balance if isinstance(balance, dict) else {}
    moved, unsure = (numbers.get(key) or 0.0 for key in ('turnover', 'uncertainty'))
    return max(ABSOLUTE, OF_TURNOVER * moved, 10.0 * unsure)


def _same_joules(recorded: Any, again: Any, least: float) -> bool:
    """Whether two energies, or two balances, are the same up to rounding."""
    if isinstance(recorded, dict) and isinstance(again, dict):
        return recorded.keys() == again.keys() and all(
            _same_joules(recorded[key], again[key], least) for key in again.keys() - {'relative'}
        )
    if isinstance(recorded, float) and isinstance(again, int | float):
        return math.isclose(recorded, again, rel_tol=RELATIVE, abs_tol=least)
    return recorded == again


def _history_differences(recorded: Any, again: Any, least: float) -> Iterator[Fact]:
    """Compare the energies over time that pictures draw; the first that is another one."""
    if recorded == again:
        return
    if _shape(recorded) != _shape(again):
        yield Fact('energy history', _shape(recorded), _shape(again))
        return
    for key, column in again.items():
        for said, is_ in zip(recorded[key], column, strict=True):
            if not _same_joules(said, is_, 0.0 if key == 'time' else least):
                yield Fact(f'energy history, {_words(key)}', repr(said), repr(is_))
                return


def _shape(history: Any) -> str:
    """Say which columns of how many rows a history has."""
    if not isinstance(history, dict):
        return 'none'
    lengths = {key: len(rows) if isinstance(rows, list) else 0 for key, rows in history.items()}
    return ', '.join(f'{lengths[key]} of {key}' for key in sorted(lengths))


def _parsed(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return _number(text)


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _alike(a: float | str, b: float | str) -> bool:
    """Whether two values are equal, numbers up to rounding."""
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    close = math.isclose(a, b, rel_tol=RELATIVE, abs_tol=ABSOLUTE)
    return close or (math.isnan(a) and math.isnan(b))


def _words(key: str) -> str:
    return key.removesuffix('_sha256').replace('_', ' ')
