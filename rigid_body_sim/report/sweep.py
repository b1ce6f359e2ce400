# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which settings of a method are tried on a problem, coarse to fine, and when finer ones are no use.

A sweep ends at the round-off floor, before runs of too many steps, or after a run that took long:
what comes next is finer and takes longer.
"""

from __future__ import annotations

from collections.abc import Iterator

from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.report.entry import Entry, Setting, our_entry
from rigid_body_sim.report.method import Method
from rigid_body_sim.report.point import REFUSED, Point
from rigid_body_sim.report.problem import THROUGHPUT, Problem

TOLERANCES = tuple(float(f'1e-{digits:02}') for digits in range(3, 14))
SLOW = 1.0  # [s] a run beyond this is the last of its sweep
FLOOR = 1e-9  # [of `useless`] an error below this may be round-off
SETTLED = 0.5  # [-] two errors in a row that gained less than this on the best: the floor
QUICK_STEPS = 5_000


class Sweep:
    """
    The settings of one method on one problem, for one number of bodies.

    quick : only those of few steps
    """

    def __init__(
        self,
        problem: Problem,
        method: Method,
        scene: Scene,
        bodies: int = 1,
        *,
        quick: bool = False,
    ) -> None:
        self.problem, self.method, self.scene, self.bodies = problem, method, scene, bodies
        self._most_steps = min(problem.most_steps, QUICK_STEPS) if quick else problem.most_steps
        self._best = float('inf')
        self._idle = 0
        self._ended = False

    def __iter__(self) -> Iterator[Entry]:
        """Give entry after entry; tell the outcome of each to `saw` before asking for the next."""
        for setting in self._settings():
            if self._ended:
                return
            yield our_entry(
                self.problem, self.method, setting, scene=self.scene, bodies=self.bodies
            )

    def _settings(self) -> list[Setting]:
        """Settings, coarse to fine."""
        problem = self.problem
        if self.method.configured().controls_its_error:
            many = problem.kind == THROUGHPUT
            return [
                Setting(problem.tick, tolerance=tolerance)
                for tolerance in ((1e-9,) if many else TOLERANCES)
            ]
        return [
            Setting(dt, substeps)
            for dt, substeps in map(problem.tick_of, problem.steps_for(self.method.text))
            if round(problem.duration / dt) * substeps <= self._most_steps
        ]

    def saw(self, point: Point, seconds: float) -> None:
        """
        Learn how the last entry went.

        seconds : of the whole run
        """
        if seconds > SLOW or point.status == REFUSED:
            self._ended = True
        error = point.error
        if error is None:
            return
        gained = error < SETTLED * self._best
        self._idle = 0 if gained or self._best > FLOOR * self.problem.useless else self._idle + 1
        self._best = min(self._best, error)
        self._ended = self._ended or self._idle >= 2 or error <= self.problem.enough
