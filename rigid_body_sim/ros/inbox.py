# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where commands wait between the executor's thread, which fills it, and the tick that takes them.

A command is judged as it comes in: what is refused is counted by its reason and goes no further.
"""

from __future__ import annotations

import threading
from collections import Counter, deque
from collections.abc import Mapping

from rigid_body_sim.recording.cdr import CdrError
from rigid_body_sim.runs.asked_states import AskedState
from rigid_body_sim.runs.commands import Command, CommandRules, decode

ROOM = 100_000  # [commands] that may wait; only a paused simulation lets so many come together
_REASONS = (
    50  # different reasons that are counted apart; a sender that invents frames fills no memory
)
OTHER = 'other reasons'


class Inbox:
    """
    Topics and services write, the run reads; a lock keeps the counts, `deque` needs none.
    """

    def __init__(self, rules: CommandRules) -> None:
        self._rules = rules
        self._counting = threading.Lock()
        self._waiting: deque[Command] = deque()
        self._refused: Counter[str] = Counter()
        self.last_refusal = ''
        self.accepted = 0

    def receive(self, body: str, kind: str, data: bytes) -> str | None:
        """
        Judge and store a command as it came over the wire.

        returns : why it is refused; None if it is not
        """
        command = self.judge(body, kind, data)
        if isinstance(command, str):
            return command
        if len(self._waiting) >= ROOM:
            return self.refuse(f'{ROOM} commands wait already; is the simulation paused?')
        with self._counting:
            self.accepted += 1
        self._waiting.append(command)
        return None

    def judge(self, body: str, kind: str, data: bytes) -> Command | str:
        """Read a command as it came over the wire; why it is refused, where it is."""
        try:
            command = decode(body, kind, data)
        except CdrError as error:
            return self.refuse(f'{kind} for {body!r} cannot be read: {error}')
        reason = self._rules.refusal(command)
        return command if reason is None else self.refuse(reason)

    def frame(self, command: Command) -> str:
        """Frame of a command that was not refused: world, body, or one of the body's own."""
        return self._rules.frame(command)

    def refuse(self, reason: str) -> str:
        """Count a command that is refused; give the reason."""
        with self._counting:
            known = reason in self._refused or len(self._refused) < _REASONS
            self._refused[reason if known else OTHER] += 1
            self.last_refusal = reason
        return reason

    @property
    def refused(self) -> Mapping[str, int]:
        """Number of refused commands by reason: a copy."""
        return dict(self._refused)

    def take(self) -> list[Command]:
        """Take what waits, in the order of arrival."""
        waiting = self._waiting
        return [waiting.popleft() for _ in range(len(waiting))]

    def asked_states(self) -> dict[str, AskedState]:
        """Which states wait to be given to bodies with the coming tick; the last one counts."""
        waiting = self._waiting.copy()
        return {command.body: command.state for command in waiting if command.state is not None}

    def clear(self) -> None:
        """Forget what waits."""
        self._waiting.clear()
