# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A user's own scene as a problem: which method, which step?

Nobody knows its exact end, so the finest run stands for it. Each of REFERENCES that does not
refuse the scene halves its step until its end no longer moves closer to the one before; the one
that came closest is the reference. Its own error is that last move, or what the second closest
method disagrees by, if more. What is to be judged by it must err by more.

The error of a run is the largest distance [m] or angle [rad] of any body from the reference, at
any of INSTANTS instants: a scene that comes to rest would forgive everything at its end.

Every method is tried that the scene takes. Ticks longer than the publishing period are not: nobody
would hear of the scene, nor the scene of commands, as often as was asked. Limits: chaotic motion
makes every reference wrong in time, and its own error says so; commands are not part of a scene.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rigid_body_sim.errors import UserError
from rigid_body_sim.exact.attitude import angle_between
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.report.measure import Progress
from rigid_body_sim.report.method import method
from rigid_body_sim.report.pareto import cheapest, micro
from rigid_body_sim.report.point import OK, Point
from rigid_body_sim.report.problem import Final, Problem

REFERENCES = ('linear_propagator', 'rk8', 'exact_rotor', 'rk4', 'dmv6', 'sdirk2', 'lie_rk4')
VARIANTS = ('blanes_moan4:drift=exact',)
METHODS = (*(name for name, each in INTEGRATORS.items() if not each.is_reference), *VARIANTS)
MOST_BODY_STEPS = 400_000  # of the finest run of the reference, and of a sweep
MULTIPLES = (100, 50, 20, 10, 5, 2, 1)  # [tick] steps longer than the scene's
SUBSTEPS = (2, 5, 10, 20, 50, 100, 200, 500)
PUBLISH_RATE = 100.0  # [Hz] that of a run if nothing else is said
ROUNDED = 1e-9  # [-] of a period that is a whole number of ticks
INSTANTS = 10  # at which runs are compared; the duration is so many times any step
CLOSE = 1e-12  # [m, rad] near enough: finer steps would only round
IDLE = 0.8  # [-] a move not shorter than this of the one before: round-off, or no convergence
SURE = 1e-9  # [m, rad] two references as close as this are enough
ENOUGH = 1e-3  # [of the tolerance] finer steps of a method are not asked for
UNIT = 'm or rad'


@dataclass(frozen=True)
class Reference:
    """
    The motion that stands for the exact one.

    states : at the instants
    error : [m, rad] how far its end moved when its step was halved for the last time, or how far
            it is from the second closest
    """

    states: list[Final]
    error: float
    text: str


def distance(a: Final, b: Final) -> float:
    """Largest distance [m] or angle [rad] between the bodies of two ends."""
    apart = np.linalg.norm(a.position - b.position, axis=1)
    turned = angle_between(a.orientation, b.orientation)
    return float(max(np.max(apart, initial=0.0), np.max(turned, initial=0.0)))


def apart(a: Sequence[Final], b: Sequence[Final]) -> float:
    """Largest distance of two motions at any instant."""
    return max(distance(one, other) for one, other in zip(a, b, strict=True))


def whole_duration(scene: Scene, duration: float) -> float:
    """Round a duration up to a multiple of INSTANTS ticks [s]."""
    if not math.isfinite(duration) or duration <= 0.0:
        raise UserError(f'--duration {duration:g} s; allowed: a positive number of seconds')
    ticks = math.ceil(round(duration * 1e9 / scene.dt_ns) / INSTANTS) or 1
    return INSTANTS * ticks * scene.dt_ns / 1e9


def reference(scene: Scene, duration: float, progress: Progress) -> Reference:
    """Find the finest end; UserError where nobody reaches it."""
    found: list[Reference] = []
    for name in REFERENCES:
        progress(f'reference with {name}')
        refined = _refined(scene, name, duration)
        found += [refined] if refined is not None else []
        if sum(each.error <= SURE for each in found) >= 2:
            break
    if not found:
        raise UserError(
            f'{scene.name}: none of {", ".join(REFERENCES)} comes to an end of {duration:g} s '
            f'within {MOST_BODY_STEPS} steps of a body; ask for a shorter --duration'
        )
    best, *others = sorted(found, key=lambda each: each.error)
    if others:
        doubt = apart(best.states, others[0].states) - others[0].error
        best = replace(best, error=max(best.error, doubt))
    return best


def _refined(scene: Scene, name: str, duration: float) -> Reference | None:
    """Halve the step of one method until that no longer helps."""
    coarse, best = None, None
    substeps, ticks = 1, round(duration * 1e9 / scene.dt_ns)
    while substeps * ticks * len(scene.bodies) <= MOST_BODY_STEPS or substeps <= 2:
        try:
            fine = _states(scene, name, ticks, substeps)
        except InvalidModel:
            return None
        if coarse is not None and fine is not None:
            moved = apart(coarse, fine)
            if best is not None and moved > IDLE * best.error:
                break
            text = f'{name} with {substeps} substeps of {scene.dt_ns * 1e-9:g} s'
            best = Reference(fine, moved, text)
            if moved <= CLOSE:
                break
        coarse = fine
        substeps *= 2
    return best


def _states(scene: Scene, name: str, ticks: int, substeps: int) -> list[Final] | None:
    """Give the states at the instants; None if the run diverged."""
    simulation = Simulation(scene, integrator=name, integrator_options={'substeps': substeps})
    states: list[Final] = []
    try:
        for _ in range(INSTANTS):
            simulation.step(ticks // INSTANTS)
            states.append(simulation.state)
    except SimulationDiverged:
        return None
    return states


def problem_of(
    scene: Scene,
    duration: float,
    against: Reference,
    *,
    tolerance: float,
    publish_rate: float = PUBLISH_RATE,
) -> Problem:
    """
    Make a problem of a scene, in which errors far below the tolerance are not asked for.

    publish_rate : [Hz] no tick is longer than its period, but for that of the scene
    """
    tick = scene.dt_ns / 1e9
    ticks = round(duration / tick)
    longer = [
        tick * many
        for many in MULTIPLES
        if ticks % (INSTANTS * many) == 0
        and (many == 1 or tick * many * publish_rate <= 1.0 + ROUNDED)
    ]
    moved = max(distance(Simulation(scene).state, state) for state in against.states)
    return Problem(
        name=scene.name,
        title=f'Your scene: {scene.name}',
        description=f'{len(scene.bodies)} bodies for {duration:g} s.',
        shows='Which method and which step to use here.',
        document=scene,
        duration=duration,
        error=lambda final: distance(final, against.states[-1]),
        instants=INSTANTS,
        error_on_way=lambda instant, state: distance(state, against.states[instant]),
        error_unit=UNIT,
        reference=f'{against.text}, right to {against.error:.0e} {UNIT}',
        useless=max(0.5, 0.1 * moved),
        integrators=METHODS,
        steps=(*longer, *(tick / many for many in SUBSTEPS)),
        tick=longer[0],
        longest_tick=tick,
        enough=max(ENOUGH * tolerance, 3.0 * against.error),
        most_steps=max(ticks, MOST_BODY_STEPS // max(1, len(scene.bodies))),
    )


def recommendation(
    points: Sequence[Point],
    problem: Problem,
    *,
    tolerance: float,
    against: Reference,
    publish_rate: float = PUBLISH_RATE,
) -> str:
    """Say in one line what to use."""
    best = cheapest(points, tolerance)
    if best is not None and against.error > tolerance:
        return (
            f'nothing can be recommended for {tolerance:g} {UNIT}: the reference itself '
            f'({against.text}) is right to {against.error:.0e} only; ask for a shorter --duration '
            'or allow more with --tolerance'
        )
    if best is None:
        fit = [point for point in points if point.status == OK and point.error is not None]
        if not fit:
            return 'no method comes to the end of this scene'
        best = min(fit, key=lambda point: point.error or 0.0)
        return (
            f'none errs by less than {tolerance:g} {UNIT}; the closest is {_use(best, problem)}: '
            f'error {best.error:.0e} {UNIT}'
        )
    more = '' if (best.error or 0.0) > 10 * against.error else ' (as far as the reference tells)'
    return (
        f'use {_use(best, problem)}: error {best.error:.0e} {UNIT}{more} at '
        f'{micro(best.cost)} per simulated second; of all methods that take the scene, with ticks '
        f'up to {max(problem.tick, problem.longest_tick):g} s (states are published and commands '
        f'taken {publish_rate:g} times a second: --publish-rate){_beyond(best, problem)}'
    )


def _beyond(point: Point, problem: Problem) -> str:
    """Say where a run with it would be warned: the error is that of this duration alone."""
    if point.tolerance is not None or not isinstance(problem.document, Scene):
        return ''
    given = method(point.method)
    dt, substeps = problem.tick_of(point.dt or problem.longest_tick)
    simulation = Simulation(
        problem.document,
        integrator=given.integrator,
        integrator_options={**given.options, 'substeps': substeps},
        dt=dt,
    )
    found = simulation.stability.check(simulation.state)
    return ''.join(f'; for longer runs mind that {violation.text}' for violation in found)


def _use(point: Point, problem: Problem) -> str:
    """Write a point as a user sets it."""
    given = method(point.method)
    options = ''.join(f', {key}: {value}' for key, value in given.options.items())
    if point.tolerance is not None:
        return (
            f'integrator {given.integrator}{options}, dt {problem.tick:g}, '
            f'rtol {point.tolerance:g}, atol {1e-3 * point.tolerance:g}'
        )
    dt, substeps = problem.tick_of(point.dt or problem.longest_tick)
    return f'integrator {given.integrator}{options}, dt {dt:g}, substeps {substeps}'


def table(points: Sequence[Point]) -> str:
    """Write error and cost of every method and step, one line each, the front marked."""
    lines = [f'  {"integrator":26}{"setting":32}{"error":>10}{"per simulated s":>17}']
    for point in points:
        mark = '*' if point.on_front else ' '
        if point.error is None:
            lines.append(f'{mark} {point.method:26}{point.setting:32}{point.status:>10}')
            continue
        lines.append(
            f'{mark} {point.method:26}{point.setting:32}{point.error:10.1e}{micro(point.cost):>17}'
        )
    return '\n'.join(lines)
