# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An entry: one engine with one method and one setting on one problem, ready to be run and timed.

Ours and those of peers are alike to the loop that measures: it calls `fresh`, then `advance` under
the clock, then `final`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from rigid_body_sim import __version__
from rigid_body_sim.physics.diagnostics.invariants import Drift, DriftMeter
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.report.evaluations import evaluations_per_step
from rigid_body_sim.report.method import Method
from rigid_body_sim.report.problem import Control, Final, Problem

ENGINE = 'rigid_body_sim'
DRIFT_SAMPLES = 32  # looks at the invariants over a run: enough to catch an oscillation
FEW_SAMPLES, MANY_BODIES = 4, 1_000  # of so many bodies a look takes long


class Runner(Protocol):
    """
    A run that can be repeated.

    fresh   : put the start back; not timed
    advance : over the whole duration, in the fastest calls that a user would make; timed
    final   : the end; not timed
    """

    def fresh(self) -> None: ...
    def advance(self) -> None: ...
    def final(self) -> Final: ...


@dataclass(frozen=True)
class Entry:
    """
    One point to be measured.

    setting     : text such as "dt = 0.1 s" or "rtol = 1e-06"
    dt          : [s] step; None where a tolerance sets it
    tolerance   : [-]; None where dt sets the error
    steps       : steps of a run, all bodies at once; None where not known
    evaluations : of the forces in a step; None where it varies
    closed_form : whether the step is the closed form of this very motion
    make        : build the run, compile, warm up; may raise: then the entry is refused
    options     : tick and integrator options, for ours
    """

    engine: str
    version: str
    method: str
    setting: str
    make: Callable[[], Runner]
    precision: str = 'f64'
    dt: float | None = None
    tolerance: float | None = None
    bodies: int = 1
    steps: int | None = None
    evaluations: float | None = None
    closed_form: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)


class Peer(Protocol):
    """
    Another engine: `report.peers` has one file for each.

    entries : problem -> its points, sweeps included; none where it cannot do the problem
    """

    @property
    def engine(self) -> str: ...
    @property
    def version(self) -> str: ...
    def entries(self, problem: Problem) -> Iterable[Entry]: ...


class OurRunner:
    """
    A `Simulation` over a number of ticks, and back to its start.

    drift  : of energy and angular momentum in `first`, the run that is not timed
    passed : states of that run at instants that divide the duration evenly, the end included
    """

    def __init__(self, simulation: Simulation, ticks: int, instants: int = 1) -> None:
        self.simulation = simulation
        self.instants = instants
        self.passed: list[Final] = []
        self.ticks = ticks
        simulation.prepare()
        self._start = simulation.state_bytes()
        self.drift = Drift(None, None, None)

    def fresh(self) -> None:
        """Restore the state of tick 0, and let it be taken in: a tick need not do so any more."""
        self.simulation.restore(tick=0, state=self._start, slots={})
        self.simulation.accelerations()

    def advance(self) -> None:
        """Step to the end in one call."""
        self.simulation.step(self.ticks)

    def first(self) -> None:
        """Step to the end with looks at the invariants: the same bits as `advance`."""
        simulation = self.simulation
        meter = DriftMeter(simulation.invariants, simulation.state, time=0.0)
        many = len(simulation.scene.bodies) > MANY_BODIES
        looks = math.ceil((FEW_SAMPLES if many else DRIFT_SAMPLES) / self.instants)
        samples = looks * self.instants
        for sample in range(1, samples + 1):
            due = self.ticks * sample // samples - simulation.tick
            if due:
                simulation.step(due)
                meter.sample(simulation.state, time=simulation.time, commanded=False)
            if sample % looks == 0:
                self.passed.append(simulation.state)
        self.drift = meter.drift()

    def final(self) -> Final:
        """Give the state."""
        return self.simulation.state


class CommandedRunner(OurRunner):
    """A `Simulation` that is commanded before each tick, from what its state is then."""

    def __init__(self, simulation: Simulation, ticks: int, control: Control) -> None:
        super().__init__(simulation, ticks)
        self.control = control

    def advance(self) -> None:
        """Read, command, step."""
        command(self.simulation, self.ticks, self.control)

    def first(self) -> None:
        """Do the same: nothing is kept of what is commanded."""
        self.advance()


def command(simulation: Simulation, ticks: int, control: Control) -> None:
    """Step so many ticks, commanding all bodies before each."""
    for _ in range(ticks):
        now = simulation.state
        force, torque = control(now.velocity, now.angular_velocity)
        simulation.set_wrenches(force=force, torque=torque)
        simulation.step(1)


@dataclass(frozen=True)
class Setting:
    """
    How one of our methods is set.

    dt        : [s] tick
    substeps  : steps that make a tick
    tolerance : [-] rtol of a method that controls its error; None: dt sets the error
    """

    dt: float
    substeps: int = 1
    tolerance: float | None = None

    def __str__(self) -> str:
        """Write it for people."""
        if self.tolerance is not None:
            return f'rtol = {self.tolerance:g}'
        more = f', {self.substeps} substeps' if self.substeps > 1 else ''
        return f'dt = {self.dt:g} s{more}'

    def options(self) -> dict[str, Any]:
        """Integrator options that set it."""
        if self.tolerance is not None:
            return {'rtol': self.tolerance, 'atol': 1e-3 * self.tolerance}
        return {'substeps': self.substeps}


def our_entry(
    problem: Problem, method: Method, setting: Setting, *, scene: Scene, bodies: int = 1
) -> Entry:
    """Make an entry of ours."""
    ticks = round(problem.duration / setting.dt)
    options = {**method.options, **setting.options()}
    scene = method.scene_of(scene)

    def make() -> Runner:
        simulation = Simulation(
            scene, integrator=method.integrator, integrator_options=options, dt=setting.dt
        )
        if problem.control is not None:
            return CommandedRunner(simulation, ticks, problem.control)
        return OurRunner(simulation, ticks, problem.instants)

    fixed = setting.tolerance is None
    return Entry(
        engine=ENGINE,
        version=__version__,
        method=method.text,
        setting=str(setting),
        make=make,
        dt=setting.dt / setting.substeps if fixed else None,
        tolerance=setting.tolerance,
        bodies=bodies,
        steps=ticks * setting.substeps if fixed else None,
        evaluations=evaluations_per_step(method.configured(), scene),
        closed_form=method.text in problem.closed_form,
        options={'dt': setting.dt, **options},
    )
