# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The curves of a problem and how each is drawn, the same in pictures and on the page.

A curve is one method of one engine over its sweep. Ours are coloured, solid, with filled marks;
those of peers are black or grey, dashed, with hollow marks, a shape for each engine: in print and
for the colour-blind the two are never alike. The best of each stand out and bear their names; the
others are thin and pale. Colours after Okabe and Ito (2008).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rigid_body_sim.report.entry import ENGINE
from rigid_body_sim.report.point import OK
from rigid_body_sim.report.problem import THROUGHPUT

Row = Mapping[str, Any]

COLORS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#56B4E9', '#E69F00', '#8A7A00')
MARKS = ('o', 's', '^', 'D', 'v', 'P', 'X')
PEER_COLORS = ('#000000', '#555555', '#333333', '#777777', '#222222', '#666666')
PEER_MARKS = ('s', 'o', '^', 'D', 'v', 'P')
PALE, PALE_PEER = '#A9B4BD', '#B8B8B8'
DEFAULT = 'dmv6'  # the integrator of a scene that names none: it always stands out
SMALLEST = 1e-16  # below is round-off of the error itself; zero has no place on a logarithmic axis
MOST = len(COLORS)


@dataclass(frozen=True)
class Series:
    """
    One curve.

    label   : for a reader
    points  : rows of the report in the order of the sweep; x, y : their places
    stands_out : whether it is bold and bears its name
    """

    engine: str
    method: str
    label: str
    ours: bool
    stands_out: bool
    color: str
    mark: str
    points: tuple[Row, ...]
    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True)
class Axes:
    """What the two axes of a problem show, both logarithmic."""

    x: str
    y: str
    x_field: str
    y_field: str


def axes_of(problem: Row) -> Axes:
    """Error against cost, or the cost of a body against their number."""
    if problem['kind'] == THROUGHPUT:
        return Axes('bodies', 'cost of a body and step [ns]', 'bodies', 'ns_per_body_step')
    return Axes(
        'cost [s per simulated second]',
        f'{measure_of(problem)} [{problem["error_unit"]}]',
        'cost',
        'error',
    )


def measure_of(problem: Row) -> str:
    """Say what is called the error of a run."""
    instants = problem.get('instants', 1)
    return 'error at the end' if instants == 1 else f'largest error at {instants} instants'


def series_of(problem: Row) -> list[Series]:
    """Every curve of a problem: ours first, those that stand out first."""
    axes = axes_of(problem)
    groups: dict[tuple[str, str], list[Row]] = {}
    for point in problem['points']:
        usable = point['status'] == OK or problem['kind'] == THROUGHPUT
        if usable and point[axes.x_field] and point[axes.y_field] is not None:
            groups.setdefault((point['engine'], point['method']), []).append(point)
    best = _ours_that_stand_out(groups, axes) | _peers_that_stand_out(groups, axes)
    engines = sorted({engine for engine, _ in groups if engine != ENGINE})
    colors = iter(COLORS)
    marks = iter(MARKS)
    found = []
    for (engine, method), points in groups.items():
        ours, out = engine == ENGINE, (engine, method) in best
        place = 0 if ours else engines.index(engine)
        if ours:
            color, mark = (next(colors), next(marks)) if out else (PALE, '.')
            mark = '*' if points[0]['closed_form'] else mark
        else:
            color = PEER_COLORS[place % len(PEER_COLORS)] if out else PALE_PEER
            mark = PEER_MARKS[place % len(PEER_MARKS)]
        found.append(
            Series(
                engine,
                method,
                _label(points[0]),
                ours,
                out,
                color,
                mark,
                tuple(points),
                tuple(max(float(point[axes.x_field]), SMALLEST) for point in points),
                tuple(max(float(point[axes.y_field]), SMALLEST) for point in points),
            )
        )
    return sorted(found, key=lambda series: (not series.ours, not series.stands_out))


def _label(point: Row) -> str:
    """Name of a curve."""
    if point['engine'] != ENGINE:
        precision = '' if point['precision'] == 'f64' else f' ({point["precision"]})'
        return f'{point["engine"]} {point["method"]}{precision}'
    return f'{point["method"]} (closed form)' if point['closed_form'] else point['method']


def front_of(problem: Row) -> list[tuple[float, float]]:
    """Places of the points than which none is as accurate for less, by cost; no closed forms."""
    if problem['kind'] == THROUGHPUT:
        return []
    axes = axes_of(problem)
    general = [point for point in problem['points'] if point['status'] == OK and point['cost']]
    general = [point for point in general if not point['closed_form']]
    return [
        (float(point[axes.x_field]), max(float(point[axes.y_field]), SMALLEST))
        for point in best_points(general, axes)
    ]


def best_points(points: Sequence[Row], axes: Axes) -> list[Row]:
    """Points than which none is lower and further to the left; lowest at each x for throughput."""
    kept: list[Row] = []
    if axes.x_field == 'bodies':
        for bodies in sorted({point['bodies'] for point in points}):
            alike = [point for point in points if point['bodies'] == bodies]
            kept.append(min(alike, key=lambda point: point[axes.y_field]))
        return kept
    for point in sorted(points, key=lambda p: (p[axes.x_field], p[axes.y_field])):
        if not kept or point[axes.y_field] < kept[-1][axes.y_field]:
            kept.append(point)
    return kept


def _ours_that_stand_out(
    groups: Mapping[tuple[str, str], list[Row]], axes: Axes
) -> set[tuple[str, str]]:
    """Return a closed form, our methods with the most points on our front, and the default."""
    own = [point for (engine, _), group in groups.items() if engine == ENGINE for point in group]
    general = [point for point in own if not point['closed_form']]
    closed = list(dict.fromkeys(point['method'] for point in own if point['closed_form']))
    front = [point['method'] for point in best_points(general, axes)]
    ranked = closed[:1] + sorted(dict.fromkeys(front), key=lambda method: -front.count(method))
    others = [method for engine, method in groups if engine == ENGINE and method not in ranked]
    others.sort(key=lambda method: min(p[axes.y_field] for p in groups[ENGINE, method]))
    if DEFAULT in others:
        ranked = [*ranked[: MOST - 1], DEFAULT]
    ranked += [method for method in others if method != DEFAULT]
    return {(ENGINE, method) for method in ranked[:MOST]}


def _peers_that_stand_out(
    groups: Mapping[tuple[str, str], list[Row]], axes: Axes
) -> set[tuple[str, str]]:
    """Return of each engine the method with the most points on the engine's own front."""
    found = set()
    for name in {engine for engine, _ in groups} - {ENGINE}:
        own = [point for (engine, _), group in groups.items() if engine == name for point in group]
        front = best_points(own, axes)
        methods = [point['method'] for point in front]
        lowest = min(front, key=lambda point: point[axes.y_field])['method']
        found.add((name, max(methods, key=lambda m: (methods.count(m), m == lowest))))
    return found
