# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How a run in lock-step waits: for answers, for the wall clock, for a link that is not proven yet.

What is waited for is said in `lockstep`; here is when to look, to say the state again, to count as
paused, and when the next period is due. None of it changes what a period computes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Sequence
from typing import Protocol

from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.ros.lockstep import Gate, LockstepFigures, no_answer, notes
from rigid_body_sim.runs.commands import Command

REPEAT = 250_000_000  # [ns] between two times that a state is said to a link that is not proven
LONGEST_WAIT = 100_000_000  # [ns] without looking whether a signal came
NEVER = 2**62  # [ns]


class Door(Protocol):
    """Where the answers come in, see `listener.OwnWaitSet`."""

    def wait(self, longest: int) -> None:
        """Take what has come, or comes within so many nanoseconds."""

    def take(self) -> None:
        """Take what has come."""

    def wake(self) -> None:
        """End the wait; from any thread."""

    def close(self) -> None:
        """Let go of what is waited for."""


class LockstepTurns:
    """
    The waiting of one run; belongs to its thread. Times are passed in, in ns of a monotonic clock.

    door    : hands what comes to the gate
    links   : tells who is connected: a value that changes with it
    silence : why nothing can come on a topic of the list, by its place there; empty: it can
    publish : says a batch again; what is said again is not recorded
    warn    : is told of a time-out and of its end
    """

    def __init__(
        self,
        gate: Gate,
        *,
        dt_ns: int,
        publish_every: int,
        door: Door,
        links: Callable[[], Hashable],
        silence: Callable[[int], str],
        publish: Callable[[Batch], None],
        warn: Callable[[str], None],
    ) -> None:
        self.gate = gate
        self.period = gate.terms.period
        self.timed_out = False
        self.wake = door.wake
        self._dt_ns = dt_ns
        self._publish_every = publish_every
        self._door = door
        self._links = links
        self._silence = silence
        self._publish = publish
        self._warn = warn
        self._shown: Sequence[Batch] = ()
        self._stamp = 0
        self._linked: Hashable = None
        self._outside: Counter[str] = Counter()
        self._wall = 0  # [ns] that a period must last; 0: as fast as possible
        self._due = self._since = self._next_look = 0

    def note(self, command_timeout_ns: int) -> None:
        """Warn of terms that may not be meant; `command_timeout_ns`: how long a command holds."""
        for text in notes(
            self.gate.terms,
            command_timeout_ns=command_timeout_ns,
            publish_every=self._publish_every,
            dt_ns=self._dt_ns,
        ):
            self._warn(text)

    def reach(self, tick: int, batches: Sequence[Batch], now: int) -> None:
        """Stand at a tick: if it is an instant, wait for answers to the states in `batches`."""
        if tick % self.period:
            return
        if not self.gate.terms.stamped:
            self._door.take()  # what came before the state was published is no answer to it
        self._stamp = tick * self._dt_ns
        self._shown = batches
        self.gate.open(self._stamp)
        self.timed_out = False
        self._since, self._next_look = now, now + REPEAT

    def next_instant(self, tick: int) -> int:
        """
        Tell the instant after a tick.

        A reset goes there: at the same one, answers to the state before it would count.
        """
        return (tick // self.period + 1) * self.period

    def restart(self, now: int, factor: float) -> None:
        """Begin to wait anew: after a pause, or a change of the real-time factor."""
        self.timed_out = False
        self._wall = round(min(self.period * self._dt_ns / factor, NEVER)) if factor else 0
        self._since, self._due = now, now + self._wall

    def is_ready(self, now: int) -> bool:
        """Whether the next period is to be done now."""
        if not self.gate.is_full:
            return False
        if self.timed_out:
            self._warn(f'lock-step goes on at {self._stamp * 1e-9:g} s: every topic has answered')
            self.timed_out = False
        return now >= self._due

    def take(self, others: Sequence[Command], now: int) -> list[Command]:
        """Take the commands of the period that begins: the answers, and then what else came."""
        self._outside.update(f'{command.body}/{command.kind}' for command in others)
        self._due = max(self._due + self._wall, now)  # what is lost is not made up for
        return [*self.gate.take(), *others]

    def wait(self, now: int, until: int) -> None:
        """Wait for answers, up to a time at most; less if somebody wakes the door."""
        if self.gate.is_full:
            self._listen(min(self._due, until) - now)
            return
        timeout = self.gate.terms.timeout
        end = self._since + timeout if timeout and not self.timed_out else NEVER
        if now >= end:
            self.timed_out, end = True, NEVER
            self._warn(
                f'paused: {no_answer(self.missing())}, for {timeout * 1e-9:g} s '
                '(lockstep_timeout); goes on with the answer'
            )
        self._look(now)
        self._listen(min(self._next_look, end, until) - now)

    def rest(self, now: int, until: int) -> None:
        """Let answers come in while a person has paused the run."""
        if self.gate.is_full:
            self.timed_out = False
        else:
            self._look(now)
            until = min(until, self._next_look)
        self._listen(until - now)

    def _listen(self, longest: int) -> None:
        longest = min(longest, LONGEST_WAIT)
        if self.gate.is_proven:
            self._door.wait(longest)
            return
        known = set(self.gate.proven)
        self._door.wait(longest)
        new = self.gate.proven - known
        if new and self._have_links_changed():
            self.gate.proven = new

    def _have_links_changed(self) -> bool:
        linked, self._linked = self._linked, self._links()
        return linked != self._linked

    def _look(self, now: int) -> None:
        """Say the state again, if it is time and not everybody has answered on these links."""
        if now < self._next_look:
            return
        self._next_look = now + REPEAT
        if self._have_links_changed():
            self.gate.proven = set()
        if not self.gate.is_proven:
            for batch in self._shown:
                self._publish(batch)

    def no_answer(self) -> str:
        """Take what has come; say which topics are missing, empty where none is."""
        self._door.take()
        return '' if self.gate.is_full else no_answer(self.missing())

    def missing(self) -> dict[str, str]:
        """The topics that have not answered, and what is known of the reason."""
        return {
            topic: why or self._silence(self.gate.terms.topics.index(topic))
            for topic, why in self.gate.missing.items()
        }

    def close(self) -> None:
        """Hear no more; the thread has ended."""
        self._door.close()

    def figures(self, now: int) -> LockstepFigures:
        """Say where the run stands."""
        missing = self.missing()
        return LockstepFigures(
            time=self._stamp / 1e9,
            period=self.period * self._dt_ns / 1e9,
            missing=missing,
            waited=(now - self._since) * 1e-9 if missing else 0.0,
            timed_out=self.timed_out,
            dropped=dict(self.gate.dropped),
            outside=dict(self._outside),
            unlisted=list(self.gate.unlisted.values()),
        )
