# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which settings of a method are tried on a problem, coarse to fine, and when finer ones are no use.

A sweep ends at the round-off floor, before runs of too many steps, or after a run that took long:
what comes next is finer and takes longer.
"""

from __future__ import annotations

from collections.abc import Iterator

from rigid_body_sim.physics.model import Scene
from rigid_body_sim.report.entry import Entry, Setting, our_entry
from rigid_body_sim.report.method import Method
from rigid_body_sim.report.problem import THROUGHPUT, Problem

TOLERANCES = tuple(float(f'1e-{digits:02}') for digits in range(3, 14))
SLOW = 1.0  # [s] a run beyond this is the last of its sweep
FLOOR = 1e-9  # [of `useless`] an error below this may be round-off
SETTLED = 0.5  # [-] two errors in a row that gained less than this on the best: the floor
QUICK_STEPS, QUICK_BODIES = 5_000, 1_000


class Sweep:
    """
    The settings of one method on one problem.

    scenes : by number of bodies, read once for all integrators
    quick  : only those of few steps and few bodies
    """

    def __init__(
        self,
        problem: Problem,
        method: Method,
        scenes: dict[int, Scene],
        *,
        quick: bool = False,
    ) -> None:
        self.problem, self.method = problem, method
        self._most_steps = min(problem.most_steps, QUICK_STEPS) if quick else problem.most_steps
        self._bodies = [n for n in problem.bodies if not quick or n <= QUICK_BODIES]
        self._scenes = scenes
        self._best = float('inf')
        self._idle = 0
        self._ended = False

    def _scene(self, bodies: int) -> Scene:
        if bodies not in self._scenes:
            self._scenes[bodies] = self.problem.scene(bodies)
        return self._scenes[bodies]

    def __iter__(self) -> Iterator[Entry]:
        """Give entry after entry; tell the outcome of each to `saw` before asking for the next."""
        problem = self.problem
        for bodies in self._bodies:
            scene = self._scene(bodies)
            for setting in self._settings():
                if self._ended:
                    return
                yield our_entry(problem, self.method, setting, scene=scene, bodies=bodies)

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

    def saw(self, error: float | None, seconds: float) -> None:
        """
        Learn how the last entry went.

        error   : None where the run diverged
        seconds : of the whole run
        """
        if seconds > SLOW:
            self._ended = True
        if error is None or self.problem.kind == THROUGHPUT:
            return
        gained = error < SETTLED * self._best
        self._idle = 0 if gained or self._best > FLOOR * self.problem.useless else self._idle + 1
        self._best = min(self._best, error)
        self._ended = self._ended or self._idle >= 2 or error <= self.problem.enough

    def refused(self) -> None:
        """Learn that the integrator will not have the scene: no other setting will do."""
        self._ended = True
