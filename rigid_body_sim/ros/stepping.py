# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Steps that somebody asked for while the run is paused, done a stretch at a time, so that between
two of them requests are served, one to stop among them.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from rigid_body_sim.ros.requests import Answer, Request

MOST_SAID = 1000  # [-] steps of a request of which each is told
TELL = 100_000_000  # [ns] after which one is told anyway
GAP = 1_000_000  # [ns] between two, or a client loses some: its queue usually holds ten


@dataclass(frozen=True)
class StepsAsked:
    """
    What a request of the name `steps` is about.

    count    : steps; a tick each, in lock-step a period
    progress : is told how many are done and how many are left, by the thread of the run: after
               each step; of more than MOST_SAID as often, evenly, and whenever TELL nanoseconds
               went by. None: nobody is told
    """

    count: int
    progress: Callable[[int, int], object] | None = None


class Steps:
    """The steps of one request, `steps` or `step`, which is answered with the last of them."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self._asked: StepsAsked = request.value
        self._parts = min(self._asked.count, MOST_SAID)  # after each of which somebody is told
        self._said = time.monotonic_ns()
        self._saying = self._asked.progress is not None
        self.done = 0

    @property
    def left(self) -> int:
        """Steps that are still to be done."""
        return self._asked.count - self.done

    @property
    def due(self) -> int:
        """When to go on [ns], of the monotonic clock."""
        return self._said + GAP if self._saying else 0

    @property
    def stretch(self) -> int:
        """Steps that may be done before somebody is told."""
        if self._asked.progress is None:
            return self.left
        return self._end_of_part - self.done

    @property
    def _end_of_part(self) -> int:
        """The first step after those that are done with which a part ends."""
        part = self.done * self._parts // self._asked.count + 1
        return -(-part * self._asked.count // self._parts)

    def note(self, steps: int) -> None:
        """Count steps that were done, and tell of them."""
        end = self._end_of_part
        self.done += steps
        progress = self._asked.progress
        if progress is None or not steps:
            return
        now = time.monotonic_ns()
        self._saying = self.done >= end or now >= self._said + TELL
        if self._saying:
            self._said = now
            progress(self.done, self.left)

    def end(self, why: str, where: str) -> None:
        """Answer the request; `why` it was broken off, empty where all were done."""
        said = f'{self.done} of {self._asked.count} steps, at {where}'
        if self.request.name == 'step' and not why:
            said = f'at {where}'
        self.request.give(Answer(not why, f'{said}: {why}' if why else said))
