# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`integrator: auto`: the method and the number of substeps that meet a tolerance at the least cost
for this scene.

A pilot run decides. Each candidate that does not refuse the scene runs the first second of it
(PILOT_TICKS at most) with
1, 2, 4, … substeps until its error is within the tolerance; the cheapest of those that got there
is taken. The error is that of positions [m] and attitudes [rad] at the end of the pilot, from a
reference: the exact propagator where the scene is linear, else a Runge–Kutta run refined until it
stood still, of order four (compiled within a second or two) or, where that does not get there,
eight. The tolerance is the error gained in one second of simulated time, so a shorter pilot is
allowed its share.

Costs are nominal, so that the choice depends on the scene alone: the same scene gets the same
method on every machine.
The choice is recorded as if the user had made it, and a replay does not choose again.

With contact there is no pilot: `dmv6` is taken.

Limits: the pilot knows nothing of commands to come, nor of what the scene does later on; the
reason says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel, blaming, choose_from
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.integration.options import Option, checked
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.snapshot import State

NAME = 'auto'

# runs the beginning of a scene: (integrator, substeps, ticks) -> state at the end; None: diverged
Pilot = Callable[[str, int, int], State | None]

OPTIONS = {'tolerance': Option(1e-6, minimum=1e-13, maximum=1.0)}

PILOT = 1.0  # [s]
PILOT_TICKS = 1000
MOST_SUBSTEPS = 64
EXACT = 'linear_propagator'
REFERENCES = (('rk4', 5), ('rk8', 7))  # and how often the step is halved
REFINED = 0.03  # [-] of the tolerance: change of the reference in its last refinement

# nominal cost of a step: ns per body, and evaluations of the forces; `benchmark/step_cost.py`
# measures
COSTS = {
    'linear_propagator': (10.0, 0),
    'dmv6': (14.0, 1),
    'rk4': (17.0, 4),
    'dmv10': (18.0, 1),
    'rk8': (110.0, 12),
    'blanes_moan4': (120.0, 6),
    'exact_rotor': (500.0, 1),
}
# impacts make a scene chaotic, so that no pilot can tell its error; contact itself sets the step
WITH_CONTACT = (
    'dmv6', 1, math.nan,
    'dmv6: between contact impulses it turns bodies with order six, and bodies in flight fall '
    'exactly; no pilot, because contact itself, by its substeps, sets the error',
)  # fmt: skip
EVALUATION = 30.0  # [ns] of one force element


@dataclass(frozen=True)
class Choice:
    """
    What to use, and why in one line.

    substeps : steps that make a tick
    error    : of the pilot [m, rad], the larger; NaN without a pilot
    """

    name: str
    substeps: int
    error: float
    reason: str


def resolve(
    scene: Scene,
    name: str | None,
    given: Mapping[str, Any] | None,
    *,
    dt_ns: int,
    pilot: Pilot,
    progress: Callable[[str], None] | None = None,
) -> tuple[Integrator, Choice | None]:
    """
    Find the integrator that a user asked for, with its options; choose it for `auto`.

    name  : None: the scene's
    given : options; None: those of the scene if the integrator is the scene's, else the defaults
    pilot    : runs the beginning of the scene for `auto`
    progress : called with a short text while `auto` tries one method after the other

    Raises InvalidModel for an unknown integrator or option, and for one that refuses the scene.
    """
    name = scene.integrator if name is None else name
    if given is None:
        given = scene.integrator_options if name == scene.integrator else {}
    choice = None
    if name == NAME:
        choice = choose(scene, dt_ns=dt_ns, pilot=pilot, progress=progress, **configured(given))
        name, given = choice.name, {'substeps': choice.substeps}
    if not isinstance(name, str) or name not in INTEGRATORS:
        cure = choose_from(name, sorted([*INTEGRATORS, NAME]))
        raise InvalidModel(f'integrator {shown(name)} is unknown{cure}', at=('integrator',))
    if not isinstance(given, Mapping):
        raise InvalidModel(
            f'integrator_options: got {shown(given)}; a mapping of options by name is needed'
        )
    with blaming('integrator'):
        integrator = INTEGRATORS[name].configured(given)
    refusal = integrator.refuses(scene)
    if refusal is not None:
        raise InvalidModel(
            f'integrator {name!r} refuses the scene {scene.name!r}: {refusal}', at=('integrator',)
        )
    return integrator, choice


def configured(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options with their values; InvalidModel for what cannot be."""
    with blaming('integrator'):
        return checked(NAME, OPTIONS, given)


def choose(
    scene: Scene,
    *,
    dt_ns: int,
    pilot: Pilot,
    tolerance: float,
    progress: Callable[[str], None] | None = None,
) -> Choice:
    """
    Choose for one scene.

    tolerance : [m, rad] error allowed per second of simulated time

    Raises InvalidModel where no candidate meets the tolerance.
    """
    if scene.contact.get('mode', 'none') != 'none':
        return Choice(*WITH_CONTACT)
    ticks = max(1, min(PILOT_TICKS, round(PILOT * 1e9 / dt_ns)))
    allowed = tolerance * ticks * dt_ns * 1e-9
    say = progress or _silent
    reference = _reference(scene, pilot, ticks, dt_ns, allowed, say)
    tried: list[str] = []
    best: tuple[float, Choice] | None = None
    for name, (step, evaluations) in COSTS.items():
        if INTEGRATORS[name].refuses(scene) is not None:
            continue
        terms = len(scene.forces) + sum(body.pivot is not None for body in scene.bodies)
        price = step * len(scene.bodies) + EVALUATION * evaluations * terms
        substeps = 1
        if best is None or price < best[0]:
            say(f'auto: trying {name}')
        while substeps <= MOST_SUBSTEPS and (best is None or price * substeps < best[0]):
            error = _error(pilot(name, substeps, ticks), reference)
            if error <= allowed:
                best = price * substeps, Choice(name, substeps, error, '')
                break
            substeps *= 2
        tried.append(name)
    if best is None:
        raise InvalidModel(
            f'integrator auto: none of {", ".join(tried)} gains less than {tolerance:g} m or '
            'rad per second with '
            f'{MOST_SUBSTEPS} substeps of a tick of {dt_ns * 1e-9:g} s; allow more, or take a '
            'smaller dt'
        )
    choice = best[1]
    reason = (
        f'{choice.name} with {choice.substeps} substep{"s" if choice.substeps > 1 else ""} a '
        f'tick errs by {choice.error:.1e} (m, rad) in a pilot of '
        f'{ticks * dt_ns * 1e-9:g} s where {allowed:.1e} is allowed, at the least cost of '
        f'{", ".join(tried)}; the pilot knows nothing of commands, nor of what comes after it'
    )
    return Choice(choice.name, choice.substeps, choice.error, reason)


def _silent(_text: str) -> None:
    """Show no progress."""


def _reference(
    scene: Scene, pilot: Pilot, ticks: int, dt_ns: int, allowed: float, say: Callable[[str], None]
) -> State:
    """Solve exactly, or refine until the end of the pilot stands still."""
    if INTEGRATORS[EXACT].refuses(scene) is None:
        exact = pilot(EXACT, 1, ticks)
        if exact is not None:
            return exact
    name = ''
    for name, halvings in REFERENCES:
        say(f'auto: reference run with {name}')
        coarse = pilot(name, 1, ticks)
        for doublings in range(1, halvings + 1):
            fine = pilot(name, 2**doublings, ticks)
            if fine and coarse and _error(coarse, fine) <= REFINED * allowed:
                return fine
            coarse = fine
    raise InvalidModel(
        f'integrator auto: {name} does not settle on the first {ticks * dt_ns * 1e-9:g} s '
        'of the scene within '
        f'{allowed:.1e} (m, rad): it is stiff or chaotic; name an integrator, or take a smaller '
        'dt',
        at=('integrator',),
    )


def _error(state: State | None, true: State) -> float:
    """Largest difference of positions [m] and attitudes [rad]."""
    if state is None:
        return np.inf
    distance = np.linalg.norm(state.position - true.position, axis=1)
    angle = angle_between(state.orientation, true.orientation)
    return float(max(np.max(distance, initial=0.0), np.max(angle, initial=0.0)))
