# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Error, drift and cost of every point of a problem.

First each entry runs once, cleanly: its error, and for ours the drift of the invariants. Then the
clock: in each repetition all entries take turns, so that a busy moment of the machine hits all of
them alike; median and quartiles are kept. Timed is the stepping alone, from a fresh start, kernels
compiled and warm; a run shorter than a millisecond is taken as often as makes one; a long one is
timed fewer times. No garbage collection under the clock. The clock is that of the processor time
of this process, so that what else the machine does favours nobody; all threads count.
"""

from __future__ import annotations

import gc
import math
import statistics
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.report.entry import ENGINE, Entry, OurRunner, Peer, Runner
from rigid_body_sim.report.method import method
from rigid_body_sim.report.point import DIVERGED, NOT_ACCURATE, OK, REFUSED, Point, finite
from rigid_body_sim.report.problem import Problem
from rigid_body_sim.report.sweep import Sweep

SHORTEST = 1e-3  # [s] a repetition lasts at least so long
LONG = 0.25  # [s] a point takes no more time than this, or two repetitions
REPETITIONS, QUICK_REPETITIONS = 7, 3

Progress = Callable[[str], None]


@dataclass
class _Timed:
    """A point with the run that is to be timed; None if there is nothing to time."""

    point: Point
    runner: Runner | None
    steps: int | None
    first: float  # [s] of the run that was not timed
    repeats: int = 1  # runs in one repetition
    every: int = 1  # it takes part in each so many-th repetition
    seconds: list[float] = field(default_factory=list)


def measure(
    problem: Problem,
    methods: Sequence[str],
    *,
    peers: Sequence[Peer] = (),
    repetitions: int = REPETITIONS,
    quick: bool = False,
    progress: Progress = lambda _text: None,
) -> list[Point]:
    """
    Measure a problem with some methods and peers.

    methods  : as `report.method` reads them
    progress : called with a short text before each piece of work
    """
    of_peers: list[_Timed] = []
    for peer in peers:
        for entry in peer.entries(problem):
            progress(f'{entry.engine} {entry.method}, {entry.setting}')
            of_peers.append(_taken(problem, entry))
    ours: list[Point] = []
    for bodies in problem.bodies_for(quick=quick):
        scene = problem.scene(bodies)
        timed: list[_Timed] = []
        for name in methods:
            sweep = Sweep(problem, method(name), scene, bodies, quick=quick)
            for entry in sweep:
                progress(f'{name}, {entry.setting}')
                timed.append(_taken(problem, entry))
                sweep.saw(timed[-1].point, timed[-1].first)
        ours += [each.point for each in timed]
        timed += [each for each in of_peers if each.point.bodies == bodies]
        ready = [each for each in timed if each.runner is not None]
        take_turns(ready, repetitions, progress)
        for each in ready:
            each.point.set_cost(each.seconds, duration=problem.duration, steps=each.steps)
            each.runner = None  # of many bodies it is large
    return ours + [each.point for each in of_peers]


def _taken(problem: Problem, entry: Entry) -> _Timed:
    """Run an entry for the first time."""
    point, runner, seconds = run_once(problem, entry)
    return _Timed(point, runner, entry.steps, seconds)


def run_once(problem: Problem, entry: Entry) -> tuple[Point, Runner | None, float]:
    """
    Run an entry from start to end and judge the end.

    returns : the point without its cost, the run if it came to a finite end, and how long it
              took [s]
    """
    try:
        runner = entry.make()
    except InvalidModel as refusal:
        point = Point.of(entry, REFUSED, str(refusal))
        point.setting, point.dt, point.tolerance = 'any', None, None
        return point, None, 0.0
    except Exception as failure:
        if entry.engine == ENGINE:
            raise
        return Point.of(entry, REFUSED, said(failure)), None, 0.0
    begin = time.process_time()
    try:
        runner.fresh()
        if isinstance(runner, OurRunner):
            runner.first()
        else:
            runner.advance()
    except SimulationDiverged as diverged:
        return Point.of(entry, DIVERGED, str(diverged)), None, time.process_time() - begin
    except Exception as failure:
        if entry.engine == ENGINE:
            raise
        return Point.of(entry, DIVERGED, said(failure)), None, time.process_time() - begin
    seconds = time.process_time() - begin
    with np.errstate(all='ignore'):  # an end on its way to infinity
        error = _error(problem, runner)
    if not math.isfinite(error):
        return Point.of(entry, DIVERGED, 'the end is not finite'), None, seconds
    accurate = error < problem.useless
    point = Point.of(
        entry,
        OK if accurate else NOT_ACCURATE,
        '' if accurate else f'errors from {problem.useless:g} {problem.error_unit} on say nothing',
    )
    point.error = error
    if isinstance(runner, OurRunner):
        point.energy_drift = finite(runner.drift.energy)
        point.angular_momentum_drift = finite(runner.drift.angular_momentum)
    return point, runner, seconds


def said(failure: Exception) -> str:
    """Give the first line of what another engine said when it failed."""
    lines = str(failure).strip().splitlines()
    return f'{type(failure).__name__}: {lines[0] if lines else "no reason given"}'


def _error(problem: Problem, runner: Runner) -> float:
    """Error of the end, or the worst of several instants."""
    if problem.error_of_run is not None and isinstance(runner, OurRunner):
        return problem.error_of_run(runner.simulation)
    if problem.error_on_way is None or not isinstance(runner, OurRunner):
        return problem.error(runner.final())
    return max(problem.error_on_way(instant, state) for instant, state in enumerate(runner.passed))


def take_turns(timed: Iterable[_Timed], repetitions: int, progress: Progress) -> None:
    """Time all runs, one after the other, so many times."""
    entries = [(each, each.runner) for each in timed if each.runner is not None]
    was_on = gc.isenabled()
    clock = clock_cost()
    gc.collect()
    gc.disable()
    try:
        for each, runner in entries:
            # the first of them may have to fetch what nothing has used for minutes
            again = () if each.first > LONG else (_seconds(runner, 1, clock) for _ in range(3))
            once = min(again, default=each.first)
            each.repeats = max(1, math.ceil(SHORTEST / max(once, 1e-9)))
            wanted = min(repetitions, max(2, int(LONG / (once * each.repeats))))
            each.every = math.ceil(repetitions / wanted)
        for repetition in range(repetitions):
            progress(f'timing, repetition {repetition + 1} of {repetitions}')
            for each, runner in entries:
                if repetition % each.every == 0:
                    if each.repeats > 1:  # what others have driven out of the caches comes back
                        _seconds(runner, 1, clock)
                    each.seconds.append(_seconds(runner, each.repeats, clock))
    finally:
        if was_on:
            gc.enable()


def clock_cost() -> float:
    """Time that reading the clock takes itself [s]."""
    return statistics.median(-(time.process_time() - time.process_time()) for _ in range(101))


def _seconds(runner: Runner, repeats: int, clock: float) -> float:
    """Mean processor time of a run [s]."""
    total = 0.0
    for _ in range(repeats):
        runner.fresh()
        begin = time.process_time()
        runner.advance()
        total += time.process_time() - begin
    return max(total / repeats - clock, 1e-9)
