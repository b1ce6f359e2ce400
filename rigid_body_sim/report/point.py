# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was found at one entry: error, drift and cost, or why there is none."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from rigid_body_sim.report.entry import Entry

OK, NOT_ACCURATE, DIVERGED, REFUSED = 'ok', 'not accurate', 'diverged', 'refused'


@dataclass
class Point:
    """
    One point of a work–precision plot; its fields are the columns of the CSV.

    setting                : of the method, in words
    dt                     : [s], or None where a tolerance sets the step
    tolerance              : [-], or None where dt sets the error
    status                 : OK; NOT_ACCURATE: the error is so large that the result says nothing;
                             DIVERGED; REFUSED: the engine will not have the problem
    note                   : why, where the status is not OK
    error                  : at the end, in the problem's unit; None without a finite end
    energy_drift, angular_momentum_drift : relative, worst of the run; None where not conserved
    cost                   : [s] per simulated second, median of the repetitions
    cost_low, cost_high    : its quartiles
    runs                   : repetitions that were timed
    ns_per_step            : [ns] of a step of all bodies; None where steps are not known
    ns_per_body_step       : the same for one body
    evaluations_per_step   : of the forces; None where it varies
    closed_form            : whether a step is the closed form of this very motion
    on_front               : whether no other point is as accurate for less
    """

    engine: str
    version: str
    method: str
    precision: str
    setting: str
    dt: float | None
    tolerance: float | None
    bodies: int
    status: str
    note: str = ''
    error: float | None = None
    energy_drift: float | None = None
    angular_momentum_drift: float | None = None
    cost: float | None = None
    cost_low: float | None = None
    cost_high: float | None = None
    runs: int = 0
    ns_per_step: float | None = None
    ns_per_body_step: float | None = None
    evaluations_per_step: float | None = None
    closed_form: bool = False
    on_front: bool = False

    @classmethod
    def of(cls, entry: Entry, status: str, note: str = '') -> Point:
        """Begin with what the entry says of itself."""
        return cls(
            engine=entry.engine,
            version=entry.version,
            method=entry.method,
            precision=entry.precision,
            setting=entry.setting,
            dt=entry.dt,
            tolerance=entry.tolerance,
            bodies=entry.bodies,
            status=status,
            note=note,
            evaluations_per_step=entry.evaluations,
            closed_form=entry.closed_form,
        )

    def set_cost(self, seconds: Sequence[float], *, duration: float, steps: int | None) -> None:
        """
        Take the times of whole runs.

        seconds  : [s] of each repetition
        duration : [s] simulated in a run
        steps    : of a run
        """
        low, middle, high = quartiles(seconds)
        self.cost, self.cost_low, self.cost_high = (
            time / duration for time in (middle, low, high)
        )
        self.runs = len(seconds)
        if steps:
            self.ns_per_step = middle / steps * 1e9
            self.ns_per_body_step = self.ns_per_step / self.bodies


def quartiles(values: Sequence[float]) -> tuple[float, float, float]:
    """Lower quartile, median, upper quartile; of one value, that value three times."""
    if len(values) == 1:
        return values[0], values[0], values[0]
    low, middle, high = statistics.quantiles(values, n=4, method='inclusive')
    return low, middle, high


def finite(value: float | None) -> float | None:
    """JSON knows neither infinity nor NaN: what is no number is None."""
    return value if value is not None and math.isfinite(value) else None
