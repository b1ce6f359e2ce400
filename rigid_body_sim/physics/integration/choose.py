# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`integrator: auto`: the method and its fineness that meet a tolerance at the least cost for this
scene.

What the tolerance T means: after t seconds no position is wrong by more than T t metres and no
attitude by more than T t radians (by T in the first second), for as long as the pilot run
foresees; after that, each window of a second that is looked at gains no more than T.

A pilot decides. Each candidate that does not refuse the scene runs its first `horizon` seconds,
ever finer until its error is within half the tolerance at every one of INSTANTS; the cheapest of
those that got there is taken. The error is measured from a reference: the exact propagator where
the scene is linear, else the first of REFERENCES that stands still when it is refined: explicit
ones first, implicit ones for scenes too stiff for them. Where motion is so sensitive that none
stands still for so long, the horizon is as far as one does, a second at least; the reason says so.

Costs are nominal (`candidates`), so that the choice depends on the scene alone. The choice is
recorded as if the user had made it, and a replay does not choose again.

While the run goes on, `lookout` goes on looking. With contact there is no pilot and no look:
`dmv6` is taken.

Limits: the pilot knows nothing of commands to come. What an error made before grows to is the
motion's own doing: on a chaotic one it outgrows every tolerance after the horizon.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel, blaming, choose_from
from rigid_body_sim.physics.integration.candidates import (
    MOST_SUBSTEPS,
    ONLY_FOR_CHANGING_INERTIA,
    PRICES,
    TIGHTEST,
    Setting,
    price_of_step,
    settings_of,
)
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.integration.options import Option, checked
from rigid_body_sim.physics.model.inertia_over_time import changing
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

NAME = 'auto'


@dataclass(frozen=True)
class Instant:
    """
    A pilot run at one instant.

    state : of the bodies
    steps : that the method chose so far; 0 where the substeps are given
    beyond : whether springs or dampers were beyond a limit of the method at the start
    """

    state: State
    steps: float = 0.0
    beyond: bool = False


# runs the beginning of a scene: (integrator, options, ticks) -> the run at each of these ticks;
# ends early where it diverges
Pilot = Callable[[str, Mapping[str, Any], Sequence[int]], Iterator[Instant]]

HORIZON = 5.0  # [s]
OPTIONS = {
    'tolerance': Option(1e-6, minimum=1e-13, maximum=1.0),
    'horizon': Option(HORIZON, minimum=1e-9, maximum=1e4),
    'longer_steps': Option(False),  # for `simulate`, see `runs.longer_ticks`
}

SECOND = 1.0  # [s] the least that a pilot foresees, if WINDOW_TICKS make it
WINDOW_TICKS = 1000
PILOT_BODY_TICKS = 1_000_000  # of the default horizon; one asked for is not cut
INSTANTS = 20  # of a pilot at which errors are judged
MARGIN = 0.5  # [-] of the tolerance: what a pilot allows, as what comes later is not known
EXACT = 'linear_propagator'
# whose step is halved, and how often
REFERENCES = (
    ('rk4', 5), ('rk8', 7), ('rk45', 4), ('implicit_midpoint', 10), ('sdirk2', 10), ('lie_rk4', 9),
)  # fmt: skip
REFERENCE_STEPS = 2_000_000  # of a body, that one which is implicit or chooses its steps may take
IDLE = 2  # refinements that let a reference stand still no longer than before: chaos, or rounding
STEP_TIMES_RATE = 3.0  # [-] step times fastest rate, of such a one on a stiff scene
FIRST = REFERENCES[0][0]  # of low order: another may stand still for longer
REFINED = 0.03  # [-] of the tolerance: change of the reference in its last refinement

# impacts make a scene chaotic, so that no pilot can tell its error; contact itself sets the step
WITH_CONTACT = (
    'dmv6', 1, math.nan,
    'dmv6: between contact impulses it turns bodies with order six, and bodies in flight fall '
    'exactly; no pilot, because contact itself, by its substeps, sets the error',
)  # fmt: skip


@dataclass(frozen=True)
class Choice:
    """
    What to use, and why in one line.

    substeps : steps that make a tick; 1 of a method that chooses them itself
    error    : [m, rad] per second, the larger, as estimated where it was made; NaN without a pilot
    options  : of the integrator
    allowed  : [m, rad] per second
    tick     : from which it holds
    """

    name: str
    substeps: int
    error: float
    reason: str
    options: Mapping[str, Any] = field(default_factory=dict)
    allowed: float = math.nan
    tick: int = 0


@dataclass(frozen=True)
class Plan:
    """
    A choice, and what a run needs to go on looking.

    setting : chosen; None: no looks
    spare   : the method that served as reference, as fine as it stood still
    spare_price : [ns] nominal, of a tick with it
    horizon : [tick] foreseen by the pilot
    fastest : [m/s, rad/s] speed and angular velocity of any body in it
    """

    choice: Choice
    setting: Setting | None = None
    spare: Setting | None = None
    spare_price: float = 0.0
    horizon: int = 0
    fastest: tuple[float, ...] = (0.0, 0.0)


def resolve(
    scene: Scene,
    name: str | Mapping[str, Any] | None,
    given: Mapping[str, Any] | None,
    *,
    dt_ns: int,
    pilot: Pilot,
    fastest: Callable[[], float],
    progress: Callable[[str], None] | None = None,
) -> tuple[Integrator, Plan | None]:
    """
    Find the integrator that a user asked for, with its options; choose it for `auto`.

    name  : alone or with its options, see `name_and_options`; None: the scene's
    given : options; None: those of the scene if the integrator is the scene's, else the defaults
    pilot    : runs the beginning of the scene for `auto`
    fastest  : gives the largest rate of its springs and dampers [1/s]
    progress : called with a short text while `auto` tries one method after the other

    Raises InvalidModel for an unknown integrator or option, and for one that refuses the scene.
    """
    asked, given = name_and_options(name, given)
    method = scene.integrator if asked is None else asked
    _need_name(method, (*INTEGRATORS, NAME))
    if given is None:
        given = scene.integrator_options if method == scene.integrator else {}
    _need_options(given)
    plan = None
    if method == NAME:
        settings = configured(given)
        plan = _Choosing(
            scene,
            dt_ns=dt_ns,
            pilot=pilot,
            fastest=fastest,
            say=progress or _silent,
            tolerance=settings['tolerance'],
            horizon=settings['horizon'] if 'horizon' in given else None,
        ).plan()
        method, given = plan.choice.name, plan.choice.options
    integrator = integrator_of(method, given)
    refusal = integrator.refuses(scene)
    if refusal is not None:
        raise InvalidModel(
            f'integrator {method!r} refuses the scene {scene.name!r}: {refusal}',
            at=('integrator',),
        )
    return integrator, plan


def name_and_options(
    name: str | Mapping[str, Any] | None, given: Mapping[str, Any] | None
) -> tuple[Any, Mapping[str, Any] | None]:
    """Part {'name': 'rk45', 'rtol': 1e-9}, as scene files have it; what is no mapping stays."""
    if not isinstance(name, Mapping):
        return name, given
    if given is not None:
        raise InvalidModel(
            f'integrator_options: got {shown(given)} beside the integrator {shown(name)}; give '
            'the options in one of the two',
            at=('integrator',),
        )
    options = dict(name)
    if 'name' not in options:
        raise InvalidModel(
            f"integrator {shown(name)} has no name; needed: {{'name': 'rk45', …}} or a name",
            at=('integrator',),
        )
    return options.pop('name'), options


def check_method(name: str, given: Mapping[str, Any]) -> None:
    """Refuse a method that there is not, `auto` being one, and options that it has not."""
    _need_name(name, (*INTEGRATORS, NAME))
    _need_options(given)
    if name == NAME:
        configured(given)
    else:
        integrator_of(name, given)


def integrator_of(name: str, given: Mapping[str, Any]) -> Integrator:
    """Configure an integrator; InvalidModel for an unknown one or an impossible option."""
    _need_name(name, INTEGRATORS)
    _need_options(given)
    with blaming('integrator'):
        return INTEGRATORS[name].configured(given)


def _need_name(name: object, known: Collection[str]) -> None:
    if not isinstance(name, str) or name not in known:
        cure = choose_from(name, sorted({*INTEGRATORS, NAME}))
        raise InvalidModel(f'integrator {shown(name)} is unknown{cure}', at=('integrator',))


def _need_options(given: object) -> None:
    if not isinstance(given, Mapping):
        raise InvalidModel(
            f'integrator_options: got {shown(given)}; a mapping of options by name is needed'
        )


def configured(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options with their values; InvalidModel for what cannot be."""
    with blaming('integrator'):
        return checked(NAME, OPTIONS, given)


def _silent(_text: str) -> None:
    """Show no progress."""


def difference(state: State, true: State) -> float:
    """Largest difference of positions [m] and attitudes [rad]."""
    distance = np.linalg.norm(state.position - true.position, axis=1)
    angle = angle_between(state.orientation, true.orientation)
    return float(max(np.max(distance, initial=0.0), np.max(angle, initial=0.0)))


def paces(state: State) -> tuple[float, ...]:
    """Largest speed [m/s] and angular velocity [rad/s] of any body."""
    return _largest(state.velocity), _largest(state.angular_velocity_body)


def _largest(vectors: Array) -> float:
    return math.sqrt(np.einsum('ij,ij->i', vectors, vectors).max(initial=0.0))


class _Trajectory:
    """A pilot run, advanced no further than it is asked for."""

    def __init__(self, instants: Iterator[Instant]) -> None:
        self._rest = instants
        self._done: list[Instant] = []

    def at(self, index: int) -> Instant | None:
        """Give the run at one of its instants; None where it has diverged before."""
        while len(self._done) <= index:
            instant = next(self._rest, None)
            if instant is None:
                return None
            self._done.append(instant)
        return self._done[index]

    def error(self, index: int, true: _Trajectory) -> float:
        """Distance from another at one instant; infinite where one has diverged."""
        mine, other = self.at(index), true.at(index)
        if mine is None or other is None:
            return math.inf
        return difference(mine.state, other.state)


@dataclass(frozen=True)
class _Reference:
    """
    The motion that stands for the exact one.

    settled : instants up to which it stands still
    """

    trajectory: _Trajectory
    setting: Setting
    settled: int


class _Choosing:
    """
    One choice for one scene.

    tolerance : [m, rad] error allowed per second of simulated time
    horizon   : [s] None: HORIZON, less where the scene is large
    fastest   : gives the largest rate of the springs and dampers of the scene [1/s]
    """

    def __init__(
        self,
        scene: Scene,
        *,
        dt_ns: int,
        pilot: Pilot,
        fastest: Callable[[], float],
        say: Callable[[str], None],
        tolerance: float,
        horizon: float | None,
    ) -> None:
        self._scene = scene
        self._pilot = pilot
        self._fastest = fastest
        self._say = say
        self._tolerance = tolerance
        self._dt = dt_ns * 1e-9
        window = max(1, min(WINDOW_TICKS, round(SECOND / self._dt)))
        ticks = max(1, round((HORIZON if horizon is None else horizon) / self._dt))
        if horizon is None:
            ticks = min(ticks, max(window, PILOT_BODY_TICKS // len(scene.bodies)))
        count = min(INSTANTS, ticks)
        self._ticks = sorted({-(-ticks * i // count) for i in range(1, count + 1)})
        times = np.array(self._ticks) * self._dt
        self._seconds = np.maximum(times, min(SECOND, times[-1])).tolist()
        self._body_ticks = self._ticks[-1] * len(scene.bodies)
        self._needed = sum(tick <= window for tick in self._ticks) or 1

    def plan(self) -> Plan:
        """
        Choose.

        Raises InvalidModel where no candidate meets the tolerance.
        """
        if self._scene.contact.get('mode', 'none') != 'none':
            return Plan(Choice(*WITH_CONTACT))
        reference = self._reference()
        tried: list[str] = []
        best: tuple[float, Setting, float] | None = None
        prices = {
            name: price_of_step(name, self._scene)
            for name in PRICES
            if INTEGRATORS[name].refuses(self._scene) is None
            and (name not in ONLY_FOR_CHANGING_INERTIA or changing(self._scene))
        }
        for name in sorted(prices, key=lambda each: prices[each]):
            if best is not None and prices[name] >= best[0]:
                break
            self._say(f'auto: trying {name}')
            tried.append(name)
            best = self._cheapest(name, prices[name], reference, best)
        if best is None:
            raise self._nobody(tried)
        return self._planned(best[1], best[2], reference, tried)

    def _cheapest(
        self,
        name: str,
        price: float,
        reference: _Reference,
        best: tuple[float, Setting, float] | None,
    ) -> tuple[float, Setting, float] | None:
        """Give the cheaper of the best so far and the coarsest setting of a method that serves."""
        for setting in settings_of(name, self._tolerance):
            if best is not None and price * setting.substeps >= best[0]:
                break
            run = self._run(setting)
            first = run.at(0)
            if first is None or first.beyond:
                continue  # it may look well for as long as a pilot, and blow up after
            error = self._error_per_second(run, reference)
            if error > MARGIN * self._tolerance:
                continue
            steps = self._steps_per_tick(run, setting, reference.settled)
            if best is None or price * steps < best[0]:
                return price * steps, setting, error
            break
        return best

    def _steps_per_tick(self, run: _Trajectory, setting: Setting, instants: int) -> float:
        last = run.at(instants - 1)
        assert last is not None
        return last.steps / self._ticks[instants - 1] or setting.substeps

    def _run(self, setting: Setting) -> _Trajectory:
        return _Trajectory(self._pilot(setting.name, setting.options, self._ticks))

    def _error_per_second(self, run: _Trajectory, reference: _Reference) -> float:
        """Largest error over time at the instants, as far as the reference stands still."""
        worst = 0.0
        for index in range(reference.settled):
            worst = max(worst, run.error(index, reference.trajectory) / self._seconds[index])
            if worst > MARGIN * self._tolerance:
                break
        return worst

    def _reference(self) -> _Reference:
        """Solve exactly, or refine until the pilot stands still."""
        count = len(self._ticks)
        if INTEGRATORS[EXACT].refuses(self._scene) is None:
            exact = Setting(EXACT, 1)
            run = self._run(exact)
            if run.at(count - 1) is not None:
                return _Reference(run, exact, count)
        best: _Reference | None = None
        for name, refinements in REFERENCES:
            if INTEGRATORS[name].refuses(self._scene) is not None or self._is_too_long(name):
                continue
            if name in ONLY_FOR_CHANGING_INERTIA and not changing(self._scene):
                continue
            self._say(f'auto: reference run with {name}')
            found = self._refined(name, refinements)
            if best is None or found.settled > best.settled:
                best = found
            if best.settled == count or (best.settled >= self._needed and name != FIRST):
                return best
        if best is None or best.settled < self._needed:
            raise InvalidModel(
                'integrator auto: no method settles on the first '
                f'{self._ticks[self._needed - 1] * self._dt:g} s of the scene within '
                f'{REFINED * self._tolerance:.1e} (m, rad) per second, a part of the tolerance: '
                'the scene is too stiff, or chaotic; allow more, name an integrator, or take a '
                'smaller dt',
                at=('integrator',),
            )
        return best

    def _is_too_long(self, name: str) -> bool:
        """Whether a reference that chooses its steps would take too many on this scene."""
        if not INTEGRATORS[name].controls_its_error:
            return False
        steps = max(
            self._ticks[-1] * self._dt * self._fastest() / STEP_TIMES_RATE, self._ticks[-1]
        )
        return steps * len(self._scene.bodies) > REFERENCE_STEPS

    def _refined(self, name: str, refinements: int) -> _Reference:
        """Refine one method until it stands still, or no further."""
        if INTEGRATORS[name].controls_its_error:
            first = min(max(2, math.ceil(-math.log10(REFINED * self._tolerance))), -TIGHTEST - 1)
            settings = [Setting(name, k) for k in range(first, 1 - TIGHTEST)][: refinements + 1]
        else:
            settings = [Setting(name, 2**k) for k in range(refinements + 1)]
        implicit = INTEGRATORS[name].wants_derivatives
        coarse, idle = self._run(settings[0]), 0
        best = _Reference(coarse, settings[0], 0)
        for setting in settings[1:]:
            if implicit and self._body_ticks * setting.substeps > REFERENCE_STEPS:
                break
            fine = self._run(setting)
            settled = self._settled(coarse, fine)
            idle = idle + 1 if settled <= best.settled >= self._needed else 0
            if settled >= best.settled:
                best = _Reference(fine, setting, settled)
            if settled == len(self._ticks) or idle == IDLE:
                break
            coarse = fine
        return best

    def _settled(self, coarse: _Trajectory, fine: _Trajectory) -> int:
        """Count the instants up to which two runs agree."""
        for index, seconds in enumerate(self._seconds):
            moved = fine.error(index, coarse)
            if not moved <= REFINED * self._tolerance * seconds:
                return index
            one, other = coarse.at(index), fine.at(index)
            if one and other and 0.0 < one.steps == other.steps:
                return index  # the same steps: the same run
        return len(self._seconds)

    def _nobody(self, tried: Sequence[str]) -> InvalidModel:
        return InvalidModel(
            f'integrator auto: none of {", ".join(tried)} gains less than {self._tolerance:g} m '
            f'or rad per second with {MOST_SUBSTEPS} substeps of a tick of {self._dt:g} s; allow '
            'more, or take a smaller dt',
            at=('integrator',),
        )

    def _planned(
        self, setting: Setting, error: float, reference: _Reference, tried: Sequence[str]
    ) -> Plan:
        ticks = self._ticks[reference.settled - 1]
        short = '' if ticks == self._ticks[-1] else ', as far as a reference stands still'
        reason = (
            f'{setting.text} errs by {error:.1e} (m, rad) per second in a pilot of '
            f'{ticks * self._dt:g} s{short}, where {self._tolerance:.1e} is allowed, at the least '
            f'cost of {", ".join(tried)}; the pilot knows nothing of commands'
        )
        choice = Choice(
            setting.name,
            setting.substeps,
            error,
            reason,
            options=setting.options,
            allowed=self._tolerance,
        )
        if INTEGRATORS[setting.name].order == math.inf:
            return Plan(choice)
        spare = reference.setting
        if INTEGRATORS[spare.name].order == math.inf:
            spare = setting
        price = price_of_step(spare.name, self._scene) * self._steps_per_tick(
            reference.trajectory, spare, reference.settled
        )
        looks = '; after it a second in every twenty is looked at'
        states = [reference.trajectory.at(i) for i in range(reference.settled)]
        return Plan(
            replace(choice, reason=reason + looks),
            setting,
            spare,
            price,
            ticks,
            tuple(map(max, *(paces(each.state) for each in states if each), (0.0, 0.0))),
        )
