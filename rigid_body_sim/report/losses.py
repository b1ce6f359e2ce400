# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where ours is not the cheaper one, or not by as much as is aimed at: said before anything else.

Aimed at: 30 times less cost than the best peer at 1e-4, 100 times at 1e-8 and beyond, by methods
for any forces; closed forms count for themselves. And what no number here says.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rigid_body_sim.report.entry import ENGINE
from rigid_body_sim.report.pareto import ERRORS
from rigid_body_sim.report.problem import THROUGHPUT
from rigid_body_sim.report.tables import ratio, time_text

Row = Mapping[str, Any]

GOALS = ((1e-4, 30.0), (1e-8, 100.0), (1e-10, 100.0))  # error -> ratio aimed at

LIMITS = (
    'Costs are those of the steps. Starting Python, reading a scene and compiling kernels, which '
    'takes seconds the first time and is kept on disk, come before; so does the building of a '
    'model in other engines. The first start has a table of its own where it was measured.',
    'A run of one or two steps costs what its call costs, a few microseconds: there a closed form '
    'or a high order gains nothing over any other method.',
    'Most problems are a single body. The other engines are made for robots and heaps, and carry '
    'what that needs through every step; see the throughput for many bodies.',
    'DART, PyBullet, Rapier and Pinocchio are stepped from Python, as their Python users do; from '
    'C++ or Rust they would save up to a microsecond a step.',
    'Single precision (f32) is marked; below 1e-4 it is no match for anybody.',
    'Errors are those at the end of the run. The last digits of long runs are round-off, and move '
    'with the machine.',
)


def losses(report: Row) -> list[str]:
    """Say where a peer is cheaper, or reaches an error that ours does not."""
    said = []
    for problem in report['problems']:
        rows = [row for row in problem.get('at_equal_error') or [] if row['peer']]
        said += _grouped(problem, [row for row in rows if row['ours'] is None], _unreached)
        cheaper = [row for row in rows if row['ratio'] is not None and row['ratio'] < 1.0]
        said += _grouped(problem, cheaper, _dearer)
        if problem['kind'] == THROUGHPUT:
            said += _slower_steps(problem)
    return said + _slower_starts(report)


def _slower_starts(report: Row) -> list[str]:
    """Say of each way to start ours where another engine is there before."""
    rows = report.get('starts') or []
    said = []
    for ours in (row for row in rows if row['engine'] == ENGINE):
        others = [r for r in rows if r['engine'] != ENGINE and r['scene'] == ours['scene']]
        best = min(others, key=lambda row: row['cost'], default=None)
        if best is not None and best['cost'] < ours['cost']:
            said.append(
                f'First start, {ours["scene"]}: ours {ours["way"]} takes '
                f'{time_text(ours["cost"])} of processor time, {best["engine"]} '
                f'{time_text(best["cost"])}.'
            )
    return said


def missed_goals(report: Row) -> list[str]:
    """Say where ours is cheaper, but by less than is aimed at."""
    said = []
    for problem in report['problems']:
        rows = problem.get('at_equal_error') or []
        if tuple(row['error'] for row in rows) != ERRORS:
            continue  # not a smooth problem: nothing is aimed at
        for row in rows:
            goal = dict(GOALS).get(row['error'])
            if goal and row['ratio'] is not None and 1.0 <= row['ratio'] < goal:
                said += _grouped(problem, [row], _short_of_goal)
    return said


def _grouped(problem: Row, rows: Sequence[Row], say: Callable[[Row], str]) -> list[str]:
    """Say the same of neighbouring errors in one line."""
    lines = []
    for what, group in itertools.groupby(rows, say):
        errors = [f'{row["error"]:.0e}' for row in group]
        span = errors[0] if len(errors) == 1 else f'{errors[0]} to {errors[-1]}'
        lines.append(f'{problem["title"]}, {span} {problem["error_unit"]}: {what}.')
    return lines


def _unreached(row: Row) -> str:
    peer, closed = row['peer'], row['closed_form']
    beside = f' (the closed form {closed["method"]} does)' if closed else ''
    return f'none of our methods gets there, {peer["engine"]} {peer["method"]} does{beside}'


def _dearer(row: Row) -> str:
    peer, ours = row['peer'], row['ours']
    return (
        f'{peer["engine"]} {peer["method"]} ({peer["setting"]}) costs {time_text(peer["cost"])} '
        f'per simulated second, our {ours["method"]} ({ours["setting"]}) '
        f'{time_text(ours["cost"])}'
    )


def _short_of_goal(row: Row) -> str:
    form, goal = row['ratio_closed_form'], dict(GOALS)[row['error']]
    beside = f'; by a closed form {ratio(form).text}' if form else ''
    return f'{ratio(row["ratio"]).text} times cheaper, aimed at {goal:.0f}{beside}'


def _slower_steps(problem: Row) -> list[str]:
    return [
        f'{problem["title"]}, {row["bodies"]} bodies: {row["peer"]["engine"]} steps faster.'
        for row in problem.get('at_equal_bodies') or []
        if row['ratio'] is not None and row['ratio'] < 1.0
    ]
