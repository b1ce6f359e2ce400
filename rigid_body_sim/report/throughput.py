# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How the cost of a body grows with the number of bodies: comparison and verdict.

Speed is compared at the same number of bodies; each point carries its error, since the fastest
step of a low order is not the fastest way to an answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rigid_body_sim.report.entry import ENGINE
from rigid_body_sim.report.pareto import named
from rigid_body_sim.report.point import Point


def _timed(points: Sequence[Point]) -> list[Point]:
    return [point for point in points if point.ns_per_body_step is not None]


def _short(point: Point | None) -> dict[str, Any] | None:
    if point is None:
        return None
    kept = ('engine', 'method', 'setting', 'precision', 'error', 'ns_per_body_step')
    return {name: getattr(point, name) for name in kept}


def at_equal_bodies(points: Sequence[Point]) -> list[dict[str, Any]]:
    """
    Compare the fastest step of ours with the fastest of the peers, at each number of bodies.

    ours          : of any order
    ours_accurate : fastest of ours that errs no more than that peer
    ratio         : cost of peer over cost of ours; ratio_accurate: over ours_accurate
    """
    rows = []
    timed = _timed(points)
    for bodies in sorted({point.bodies for point in timed}):
        alike = [point for point in timed if point.bodies == bodies]
        ours = _fastest([point for point in alike if point.engine == ENGINE])
        peer = _fastest([point for point in alike if point.engine != ENGINE])
        accurate = peer and _fastest(
            [p for p in alike if p.engine == ENGINE and _error(p) <= _error(peer)]
        )
        rows.append(
            {
                'bodies': bodies,
                'ours': _short(ours),
                'ours_accurate': _short(accurate),
                'peer': _short(peer),
                'ratio': _over(peer, ours),
                'ratio_accurate': _over(peer, accurate),
            }
        )
    return rows


def _error(point: Point) -> float:
    return float('inf') if point.error is None else point.error


def _fastest(points: Sequence[Point]) -> Point | None:
    return min(points, key=lambda point: point.ns_per_body_step or 0.0, default=None)


def _over(peer: Point | None, ours: Point | None) -> float | None:
    if peer is None or ours is None or not ours.ns_per_body_step:
        return None
    return (peer.ns_per_body_step or 0.0) / ours.ns_per_body_step


def throughput_verdict(points: Sequence[Point]) -> str:
    """Say who steps fastest at the smallest and the largest number of bodies."""
    timed = _timed(points)
    counts = sorted({point.bodies for point in timed})
    said = []
    for bodies in dict.fromkeys(counts[:1] + counts[-1:]):
        best = _fastest([point for point in timed if point.bodies == bodies])
        assert best is not None
        said.append(
            f'{named(best)} with {bodies} {"body" if bodies == 1 else "bodies"}: '
            f'{best.ns_per_body_step:.3g} ns per body and step, error {best.error:.1e}'
        )
    return f'Fastest step: {"; ".join(said)}.' if said else ''
