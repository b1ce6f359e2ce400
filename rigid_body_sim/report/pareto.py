# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Who is as accurate for less: the front, the cheapest point at an error, and the verdict in words.

A point is on the front if no other costs less, or as much, and errs less. At an error, of each
side the cheapest point at least as accurate is taken; the ratio is the peer's cost over ours.
Beside it stands the ratio at just that error: along a method's sweep, the logarithm of the cost is
interpolated linearly in the logarithm of the error, and the cheapest method counts.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rigid_body_sim.report.entry import ENGINE
from rigid_body_sim.report.point import OK, Point
from rigid_body_sim.report.problem import ERRORS

SMALLEST = 1e-17  # an error of zero, as a logarithm needs it


@dataclass(frozen=True)
class AtError:
    """
    The cheapest way to an error.

    error                : in the problem's unit
    ours, peer           : cheapest points at least as accurate, in a few fields; None where nobody
                           is; ours without closed forms
    ratio                : cost of peer over cost of ours
    ratio_interpolated   : the same where both sweeps pass through just this error
    closed_form          : cheapest of ours where a step may be the closed form of the motion
    ratio_closed_form    : cost of peer over its cost
    """

    error: float
    ours: dict[str, Any] | None
    peer: dict[str, Any] | None
    ratio: float | None
    ratio_interpolated: float | None
    closed_form: dict[str, Any] | None
    ratio_closed_form: float | None


def usable(points: Iterable[Point]) -> list[Point]:
    """Points with an error that means something and a cost."""
    return [
        point
        for point in points
        if point.status == OK and point.error is not None and point.cost is not None
    ]


def mark_front(points: Sequence[Point]) -> None:
    """Set `on_front`, for each number of bodies apart."""
    for point in points:
        point.on_front = False
    for bodies in {point.bodies for point in points}:
        best = math.inf
        alike = [point for point in usable(points) if point.bodies == bodies]
        for point in sorted(alike, key=lambda p: (p.cost, p.error)):
            assert point.error is not None
            if point.error < best:
                point.on_front, best = True, point.error


def cheapest(points: Iterable[Point], error: float) -> Point | None:
    """Give the cheapest point that errs by no more; None if there is none."""
    accurate = [point for point in usable(points) if (point.error or 0.0) <= error]
    return min(accurate, key=lambda point: point.cost or 0.0, default=None)


def cost_at(points: Iterable[Point], error: float) -> float | None:
    """
    Cost [s] per simulated second at just this error, of the method that is cheapest there.

    None where no sweep passes through it.
    """
    sweeps: dict[tuple[str, str], list[Point]] = {}
    for point in usable(points):
        sweeps.setdefault((point.engine, point.method), []).append(point)
    wanted = math.log(error)
    found = []
    for sweep in sweeps.values():
        sweep.sort(key=lambda point: point.cost or 0.0)
        for coarse, fine in itertools.pairwise(sweep):
            at = [math.log(max(point.error or 0.0, SMALLEST)) for point in (coarse, fine)]
            if at[1] <= wanted <= at[0] and at[1] < at[0]:
                share = (at[0] - wanted) / (at[0] - at[1])
                costs = [math.log(point.cost or SMALLEST) for point in (coarse, fine)]
                found.append(math.exp(costs[0] + share * (costs[1] - costs[0])))
    return min(found, default=None)


def at_equal_error(
    points: Sequence[Point], errors: Sequence[float] = ERRORS
) -> list[dict[str, Any]]:
    """Compare our cheapest point with the peers' at each error."""
    rows = []
    own = [point for point in points if point.engine == ENGINE]
    peers = [point for point in points if point.engine != ENGINE]
    general = [point for point in own if not point.closed_form]
    for error in errors:
        ours, peer = cheapest(general, error), cheapest(peers, error)
        closed = cheapest([point for point in own if point.closed_form], error)
        rows.append(
            asdict(
                AtError(
                    error=error,
                    ours=_short(ours),
                    peer=_short(peer),
                    ratio=_over(peer and peer.cost, ours and ours.cost),
                    ratio_interpolated=_over(cost_at(peers, error), cost_at(general, error)),
                    closed_form=_short(closed),
                    ratio_closed_form=_over(peer and peer.cost, closed and closed.cost),
                )
            )
        )
    return rows


def _over(peer: float | None, ours: float | None) -> float | None:
    return peer / ours if peer and ours else None


def _short(point: Point | None) -> dict[str, Any] | None:
    if point is None:
        return None
    kept = ('engine', 'method', 'setting', 'precision', 'error', 'cost')
    return {name: getattr(point, name) for name in kept}


def verdict(points: Sequence[Point], unit: str, errors: Sequence[float] = ERRORS) -> str:
    """Say which method is cheapest at which accuracy; closed forms in a sentence of their own."""
    general = [point for point in points if not point.closed_form]
    met = [(error, cheapest(general, error)) for error in errors]
    said = [
        f'{name} {_range([error for error, _ in group])} {unit} '
        f'({_steps([point for _, point in group])})'
        for name, group in (
            (name, list(group))
            for name, group in itertools.groupby(
                [(error, point) for error, point in met if point is not None],
                lambda pair: named(pair[1]),
            )
        )
    ]
    sentences = [f'Cheapest: {"; ".join(said)}.'] if said else []
    beyond = [error for error, point in met if point is None]
    if beyond:
        sentences.append(f'None errs by less than {max(beyond):.0e} {unit}.')
    closed = cheapest([point for point in points if point.closed_form], errors[-1])
    if closed is not None:
        sentences.append(
            f'Here a closed form is at hand: {named(closed)}, {closed.setting}, errs by '
            f'{closed.error:.0e} {unit} for {micro(closed.cost)} per simulated second.'
        )
    return ' '.join(sentences)


def _steps(points: Sequence[Point]) -> str:
    """Settings and costs, each once."""
    said = [f'{point.setting}: {micro(point.cost)}' for point in points]
    return f'{", ".join(dict.fromkeys(said))} per simulated second'


def named(point: Point) -> str:
    """Name a method, with its engine unless it is ours."""
    return point.method if point.engine == ENGINE else f'{point.engine} {point.method}'


def _range(errors: Sequence[float]) -> str:
    if len(errors) == 1:
        return f'at {errors[0]:.0e}'
    return f'from {errors[0]:.0e} to {errors[-1]:.0e}'


def micro(seconds: float | None) -> str:
    """Write a cost for people."""
    for scale, unit in ((1.0, 's'), (1e-3, 'ms'), (1e-6, 'us')):
        if seconds and seconds >= scale:
            return f'{seconds / scale:.3g} {unit}'
    return f'{(seconds or 0.0) / 1e-9:.3g} ns'
