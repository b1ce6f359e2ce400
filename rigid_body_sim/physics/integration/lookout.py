# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`integrator: auto` keeps looking while the run goes on: now and then a shadow in half steps, and a
change of method at a tick boundary where the error calls for one.

A look is a window of a second (LEAST_TICKS to WINDOW_TICKS). The shadow begins with the state of
the run, is given the same commands at the same ticks, and at the end of the window

    e = r d,   d : distance of run and shadow [m, rad],   r : Richardson's factor of the method

is what the run gained in it. A look begins where the pilot ends and every EVERY windows from then
on, and also where a command begins to act, this too once in EVERY windows; so looks cost a fifth
of the run at most, on average, with a shadow of twice its cost. A look is called for besides
where a body is FASTER than any was before, asked every PACE_TICKS, in every window for some time
after a command; this goes by powers, so it is rare.

    e beyond the tolerance      the method goes on with so many substeps that half the tolerance
                                should be met, or the spare one where that is DEARER; the next
                                window is looked at too, AGAIN times at most
    far below it (COARSEN)      one notch back within the method, never below the pilot's choice

Only two methods take part, the chosen one and the spare, which was the pilot's reference: both
were compiled before the start. A run that diverges goes back to its last good tick and goes on
finer, RESCUES times at most in a window.

Everything depends on ticks, states and commands alone, never on a clock: equal inputs give equal
runs, however many ticks are done at once. What a window gained has been seen by then: it is not
run again, but said (`Lookout.worst`).

Limits: the seconds in between are not looked at. An error of the past is not mended, only its
growth is watched.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, Protocol

from rigid_body_sim.physics.integration.candidates import MOST_SUBSTEPS, Setting, price_of_step
from rigid_body_sim.physics.integration.choose import (
    MARGIN,
    SECOND,
    WINDOW_TICKS,
    Choice,
    Plan,
    difference,
    paces,
)
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.snapshot import State

LEAST_TICKS = 50  # of a window
APART_TICKS = 2000  # at least, between the begins of two looks
PACE_TICKS = 300  # at least, between two looks at how fast bodies are
EVERY = 20  # [window] likewise
AGAIN = 3  # looks one after the other that do not bring the error within the tolerance
COARSEN = 0.25  # [-] of the tolerance: a coarser setting must promise so little
FINEST = 64 * MOST_SUBSTEPS  # substeps of a tick that a look may ask for
RESCUES = 4
DEARER = 8.0  # [-] than the spare, of which no error is known: so much the same method may become
FASTER = 1.5  # [-] speed or angular velocity over the largest before: calls for a look
SLOW = 0.1  # [m/s, rad/s] what counts as no motion there


class Steps(Protocol):
    """A simulation as far as a look needs it as its shadow."""

    @property
    def tick(self) -> int:
        """Ticks done."""
        ...

    @property
    def state(self) -> State:
        """The bodies now."""
        ...

    def step(self, ticks: int = 1) -> None:
        """Advance."""
        ...

    @property
    def hold(self) -> Callable[..., object]:
        """Hold a command."""
        ...

    @property
    def apply_impulse(self) -> Callable[..., object]:
        """Strike a body."""
        ...

    @property
    def set_state(self) -> Callable[..., object]:
        """Put a body elsewhere."""
        ...


Read = Callable[[], State]
Shadow = Callable[[str, Mapping[str, Any]], Steps]


@dataclass(frozen=True)
class Look:
    """
    What one window gained.

    tick   : where it ended
    error  : [m, rad] per second
    """

    tick: int
    error: float


class Watch:
    """
    What a simulation asks while it runs; this one watches nothing.

    next_tick : at which `meet` wants to be called next
    looks     : how many windows were looked at
    missed    : how many of them gained more than the tolerance
    worst     : the one that gained most; None before the first
    """

    looks = missed = 0
    worst: Look | None = None
    next_tick: float = math.inf

    @property
    def settings(self) -> Sequence[tuple[str, Mapping[str, Any]]]:
        """Name and options of what it may go on with, to be compiled before the start."""
        return ()

    def meet(self, tick: int, read: Read) -> None:
        """
        Do what is due at this tick; called before each stretch of ticks.

        read : gives the state
        """

    def follow(self, tick: int) -> None:
        """Take notice of where the run has come to."""

    def hold(self, tick: int, body: str, source: str, **asked: Any) -> None:
        """Take notice of a command."""

    def strike(self, tick: int, body: str, **asked: Any) -> None:
        """Take notice of an impulse, in world axes."""

    def place(self, tick: int, body: str, **asked: Any) -> None:
        """Take notice of a body that was put elsewhere."""

    def reset(self, tick: int) -> None:
        """Begin anew: the scene is back at its start."""

    def resume(self, tick: int) -> None:
        """Go on from a state that was restored."""

    def rescue(self, tick: int) -> bool:
        """Whether the run, which diverged, goes on in another way."""
        return False

    def attach(self, *, shadow: Shadow, change: Callable[[Choice], None]) -> None:
        """
        Watch one simulation.

        shadow : (name, options) -> another run from the present state and commands; one may be
                 given again
        change : goes on with another choice
        """
        self._make_shadow, self._change = shadow, change

    def __getstate__(self) -> dict[str, Any]:
        attached = ('_make_shadow', '_change')
        return {name: value for name, value in self.__dict__.items() if name not in attached}

    def copied(self) -> Watch:
        """Give a watch that goes on in the same way, to be attached to a copy of the run."""
        return copy(self)


class Lookout(Watch):
    """
    Watches one run.

    plan    : of the pilot
    failed  : exceptions with which a run diverges
    """

    def __init__(
        self,
        plan: Plan,
        scene: Scene,
        *,
        dt_ns: int,
        failed: type[Exception],
    ) -> None:
        assert plan.setting is not None and plan.spare is not None
        self._plan = plan
        self._scene = scene
        self._dt = dt_ns * 1e-9
        self._failed = failed
        self._first, self._spare = plan.setting, plan.spare
        self._window = max(LEAST_TICKS, min(WINDOW_TICKS, round(SECOND / self._dt)))
        self._pace = max(PACE_TICKS, self._window)
        self._apart = max(APART_TICKS, EVERY * self._window)
        self._begin(0)

    @property
    def settings(self) -> Sequence[tuple[str, Mapping[str, Any]]]:
        """Name and options of what it may go on with, to be compiled before the start."""
        return [(s.name, s.options) for s in dict.fromkeys((self._first, self._spare))]

    def copied(self) -> Lookout:
        """Give a watch that goes on in the same way, with a shadow of its own."""
        other = copy(self)
        other._shadow = copy(self._shadow)
        return other

    def _begin(self, tick: int) -> None:
        """Watch from the start of the scene on."""
        self._setting = self._first
        self._shadow: Steps | None = None
        self._again = AGAIN
        self._rescues = RESCUES
        self._called = False
        self._alert_until = tick
        self._commands_from = tick  # when a command may have a look begin
        self._regular = self._look_at = tick + self._plan.horizon
        self._fastest = self._plan.fastest
        self._wait(tick)

    def _wait(self, tick: int) -> None:
        """Be called at the next look, at the end of this one, or to see how fast bodies are."""
        pace = self._window if tick < self._alert_until else self._pace
        self.next_tick = min(self._look_at, self._ends if self._shadow else tick + pace)

    def meet(self, tick: int, read: Read) -> None:
        """Begin a look, or end one, where it is time."""
        if tick < self.next_tick:
            return
        if self._shadow is not None:
            self._judge(tick, read())
        elif self._is_faster(read()):
            self._look_at = tick
        if self._look_at <= tick:
            self._shadow = self._make_shadow(*self._setting.shadow)
            self._ends = tick + self._window
            if self._regular <= tick:
                self._regular = tick + self._apart
            if self._called:
                self._commands_from = tick + self._apart
            self._called = False
            self._look_at = self._regular
        self._wait(tick)

    def _is_faster(self, state: State) -> bool:
        """Whether a body moves much faster than any did when it was last asked."""
        now = paces(state)
        faster = any(
            new > FASTER * max(old, SLOW) for new, old in zip(now, self._fastest, strict=True)
        )
        if faster:
            self._fastest = tuple(map(max, now, self._fastest))
        return faster

    def follow(self, tick: int) -> None:
        """Let the shadow do the ticks that the run did; where it diverges, the look is lost."""
        if self._shadow is not None:
            try:
                self._shadow.step(tick - self._shadow.tick)
            except self._failed:
                self._shadow = None

    def _with(self, tick: int) -> Steps | None:
        """Give the shadow; none where an interrupt left it behind."""
        if self._shadow is not None and self._shadow.tick != tick:
            self._shadow = None
        return self._shadow

    def hold(self, tick: int, body: str, source: str, **asked: Any) -> None:
        """A command was given: the shadow takes it too, or a look begins if one is due."""
        shadow = self._with(tick)
        if shadow is not None:
            shadow.hold(body, source, **asked)
        self._call(tick)

    def strike(self, tick: int, body: str, **asked: Any) -> None:
        """Take an impulse, in world axes, as `hold` takes a command."""
        shadow = self._with(tick)
        if shadow is not None:
            shadow.apply_impulse(body, **asked)
        self._call(tick)

    def place(self, tick: int, body: str, **asked: Any) -> None:
        """Put a body elsewhere, as `hold` takes a command."""
        shadow = self._with(tick)
        if shadow is not None:
            shadow.set_state(body, **asked)
        self._call(tick)

    def _call(self, tick: int) -> None:
        """Ask for a look as soon as commands may have one."""
        self._called = True
        self._alert_until = tick + self._apart
        self._look_at = min(self._look_at, max(tick, self._commands_from))
        if self._shadow is None:
            self.next_tick = min(self.next_tick, self._look_at)

    def reset(self, tick: int) -> None:
        """Begin anew with the pilot's choice: the scene is back at its start."""
        if self._setting != self._first:
            self._go_on(self._first, tick, self._plan.choice.error, 'reset: as the pilot chose')
        self._begin(tick)

    def resume(self, tick: int) -> None:
        """Go on from a state that was restored, of which nothing is known: look at once."""
        self._shadow = None
        self._again, self._rescues = AGAIN, RESCUES
        self._called = False
        self.next_tick = self._look_at = self._regular = self._commands_from = tick

    def rescue(self, tick: int) -> bool:
        """Go on finer after a run diverged; False where that was tried too often."""
        if not self._rescues:
            return False
        self._rescues -= 1
        setting = self._finer(1e-3)
        if setting == self._setting:
            return False
        self._shadow = None
        self.next_tick = self._look_at = tick
        self._again = AGAIN
        self._go_on(setting, tick, math.inf, 'the run diverged')
        return True

    def _judge(self, tick: int, state: State) -> None:
        """End a look: say what the window gained, and go on finer or coarser."""
        shadow = self._with(tick)
        self._shadow = None
        if shadow is None:
            return
        self._rescues = RESCUES
        seconds = self._window * self._dt
        error = self._setting.richardson * difference(state, shadow.state) / seconds
        allowed = self._plan.choice.allowed
        self.looks += 1
        if self.worst is None or error > self.worst.error:
            self.worst = Look(tick, error)
        if error > allowed:
            self.missed += 1
            setting = self._finer(MARGIN * allowed / error)
            if setting != self._setting:
                self._go_on(setting, tick, error, f'more than {allowed:.1e}')
                if self._again:
                    self._again -= 1
                    self._look_at = tick
            return
        self._again = AGAIN
        setting, grows = self._setting.coarser()
        if setting == self._setting or self._setting == self._first:
            return
        if error * grows <= COARSEN * allowed:
            self._fastest = paces(state)
            self._go_on(setting, tick, error, f'far below {allowed:.1e}')

    def _finer(self, share: float) -> Setting:
        """Give a setting that should err by that share; the same where none is left."""
        finer = self._setting.finer(share)
        if self._setting.name == self._spare.name:
            return finer if self._is_possible(finer) else self._setting
        if not self._is_possible(finer) or self._price(finer) > DEARER * self._price(self._spare):
            if self._spare.controls_its_error or self._setting.controls_its_error:
                return self._spare
            return Setting(self._spare.name, max(self._spare.fineness, self._setting.fineness))
        return finer

    def _is_possible(self, setting: Setting) -> bool:
        return setting.controls_its_error or setting.fineness <= FINEST

    def _price(self, setting: Setting) -> float:
        if setting.name == self._spare.name != self._first.name:
            return self._plan.spare_price
        return price_of_step(setting.name, self._scene) * setting.substeps

    def _go_on(self, setting: Setting, tick: int, error: float, why: str) -> None:
        self._setting = setting
        reason = (
            f'{setting.text} from tick {tick} on: error per second {error:.1e} (m, rad), {why}'
        )
        self._change(
            Choice(
                setting.name,
                setting.substeps,
                error,
                reason,
                options=setting.options,
                allowed=self._plan.choice.allowed,
                tick=tick,
            )
        )


class RecordedChoices(Watch):
    """
    Changes of method that were recorded, taken again at their ticks: what a `Lookout` did.

    choices : in the order of their ticks
    """

    def __init__(self, choices: Sequence[Choice]) -> None:
        self._rest = tuple(sorted(choices, key=lambda choice: choice.tick))
        self._wait()

    def _wait(self) -> None:
        self.next_tick = self._rest[0].tick if self._rest else math.inf

    @property
    def settings(self) -> Sequence[tuple[str, Mapping[str, Any]]]:
        """Name and options of what is to come."""
        return [(choice.name, choice.options) for choice in self._rest]

    def meet(self, tick: int, read: Read) -> None:
        """Change where one was changed."""
        while self._rest and self._rest[0].tick <= tick:
            first, *rest = self._rest
            self._rest = tuple(rest)
            self._change(first)
        self._wait()
