# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An engine with its ways to run a task, and the points at which it is measured on a problem.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.report.entry import Entry, Runner
from rigid_body_sim.report.peers.task import Task
from rigid_body_sim.report.problem import THROUGHPUT, Problem

SLOW = 0.3  # [s] a run beyond this is the last of its sweep: the next is finer and takes longer
SLOW_FINER = 1.0  # [s] the same for the most accurate way of an engine
TOLERANCES = tuple(float(f'1e-{digits:02}') for digits in range(2, 14, 2))


@dataclass(frozen=True)
class Way:
    """
    One way to run a task: an integrator of the engine, with the calls and settings that suit it.

    build           : task, dt [s] or tolerance -> run; InvalidModel where it cannot
    tolerances      : of a method that controls its error; empty: it takes the steps of the problem
    evaluations     : of the forces in a step; None where it varies
    most_bodies     : beyond it building takes minutes, or memory ends
    finer           : whether it also takes steps finer than those of the problem, to show how
                      accurate it can be
    contact         : whether it is for bodies on the ground; others are for bodies that touch
                      nothing
    commanded       : whether it can be commanded before each step
    """

    method: str
    build: Callable[[Task, float], Runner]
    tolerances: tuple[float, ...] = ()
    evaluations: int | None = None
    most_bodies: int = 1000
    finer: bool = False
    contact: bool = False
    commanded: bool = False


@dataclass(frozen=True)
class Engine:
    """One engine that is installed; a `report.entry.Peer`."""

    engine: str
    version: str
    ways: tuple[Way, ...]
    precision: str = 'f64'

    def entries(self, problem: Problem) -> Iterator[Entry]:
        """
        Give its points on a problem, coarse to fine; one that is refused where it cannot do the
        problem. Whoever takes an entry runs it before asking for the next.
        """
        try:
            task = Task.of(problem, problem.bodies[0])
            ways = self.ways_for(task)
            for way in ways:
                first = way.tolerances[0] if way.tolerances else problem.steps[-1]
                self._built(way, task, first)
        except InvalidModel as refusal:
            yield self._refused(str(refusal))
            return
        for way in ways:
            yield from self._sweep(problem, way)

    def ways_for(self, task: Task) -> list[Way]:
        """Return its ways for bodies on the ground, or for others; InvalidModel if none."""
        ways = [way for way in self.ways if way.contact == (task.ground is not None)]
        if not ways:
            raise InvalidModel('contact is not written for this engine')
        if task.control is not None:
            ways = [way for way in ways if way.commanded]
            if not ways:
                raise InvalidModel('a controller in the loop is not written for this engine')
        return ways

    def _build(self, problem: Problem, way: Way, bodies: int, setting: float) -> Runner:
        return self._built(way, Task.of(problem, bodies), setting)

    def _built(self, way: Way, task: Task, setting: float) -> Runner:
        """
        Build a run; InvalidModel where the engine will not, be it that its interface has changed.
        """
        try:
            return way.build(task, setting)
        except InvalidModel:
            raise
        except Exception as error:
            raise InvalidModel(
                f'{self.engine} {self.version} does not build it: {type(error).__name__}: {error}'
            ) from error

    def _refused(self, reason: str) -> Entry:
        def make() -> Runner:
            raise InvalidModel(reason)

        return Entry(self.engine, self.version, '-', '-', make, self.precision)

    def _sweep(self, problem: Problem, way: Way) -> Iterator[Entry]:
        for bodies in problem.bodies:
            for setting in way.tolerances or steps_of(problem, finer=way.finer):
                if bodies > way.most_bodies:
                    return
                watch = _Watch(partial(self._build, problem, way, bodies, setting))
                yield self._entry(problem, way, bodies, setting, watch.make)
                if watch.seconds() > (SLOW_FINER if way.finer else SLOW):
                    return

    def _entry(
        self,
        problem: Problem,
        way: Way,
        bodies: int,
        setting: float,
        make: Callable[[], Runner],
    ) -> Entry:
        dt, tolerance = (None, setting) if way.tolerances else (setting, None)
        return Entry(
            engine=self.engine,
            version=self.version,
            method=way.method,
            setting=f'dt = {dt:g} s' if dt else f'accuracy = {tolerance:g}',
            make=make,
            precision=self.precision,
            dt=dt,
            tolerance=tolerance,
            bodies=bodies,
            steps=round(problem.duration / dt) if dt else None,
            evaluations=way.evaluations,
        )


def steps_of(problem: Problem, *, finer: bool = False) -> list[float]:
    """
    Steps dt [s] for engines, coarse to fine: also the coarse ones of our implicit methods.

    A damped spring of a joint is implicit in most engines.
    """
    steps = set(problem.steps)
    if finer and problem.kind != THROUGHPUT:
        steps |= {float(f'{min(problem.steps) / parts:.3g}') for parts in (2, 5, 10)}
    task = Task.of(problem, problem.bodies[0])
    if task.stiffness and task.damping:
        steps = steps.union(*problem.steps_of.values())
    return sorted(steps, reverse=True)


class _Watch:
    """Sees how long the first run takes: from the end of building to the next question."""

    def __init__(self, build: Callable[[], Runner]) -> None:
        self._build = build
        self._built: float | None = None

    def make(self) -> Runner:
        """Build."""
        runner = self._build()
        self._built = time.process_time()
        return runner

    def seconds(self) -> float:
        """Time since it was built [s]; 0 if it was not."""
        return 0.0 if self._built is None else time.process_time() - self._built
