# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
When ticks are due on the wall clock.

    tick i after the anchor is due at   anchor + i dt / f
        anchor : [ns] monotonic wall clock
        dt     : [ns] tick length in simulation time
        f      : real-time factor; 0: always due

Deadlines are absolute, so lateness does not add up: after a late tick the next ones follow at
once. Only when more than LONGEST_LAG is lost is the anchor moved, and that is counted. The pacer
decides when ticks run, never what they compute.
"""

from __future__ import annotations

from collections import deque

LONGEST_LAG = (
    1_000_000_000  # [ns] that a run catches up; more would be a long rush after each suspend
)
# [ns] over which the real-time factor is measured; what one late tick is of less looks like a run
# that is slow
LEAST_WINDOW = 1_000_000_000
SHORTEST_NAP = 1_000_000  # [ns] between wake-ups; shorter ticks are done in groups


class Pacer:
    """
    The deadlines of one run; times are passed in.

    overruns         : ticks that began more than one period late
    largest_lateness : [ns] of the start of a tick
    last_lateness    : [ns] of the last one
    lags             : how often the anchor was moved because too much was lost
    """

    def __init__(self, *, dt_ns: int, factor: float, now: int) -> None:
        self._dt_ns = dt_ns
        self.overruns = 0
        self.largest_lateness = 0
        self.last_lateness = 0
        self.lags = 0
        self._counted = 0
        self._looks: deque[tuple[int, float]] = deque()  # when, and what was claimed then
        self.set_factor(factor, now)

    def set_factor(self, factor: float, now: int) -> None:
        """Change the real-time factor from now on."""
        self.factor = factor
        self._period = self._dt_ns / factor if factor else 0.0
        self._group = max(1, round(SHORTEST_NAP / self._period)) if factor else 1
        self.restart(now)

    def restart(self, now: int) -> None:
        """Count deadlines from now on: after a pause, a reset, a change of the factor."""
        self._anchor = now
        self._done = 0
        self._looks.clear()
        self._looks.append((now, self._counted))

    @property
    def deadline(self) -> int:
        """When to wake for the next tick or group of ticks [ns]."""
        return self._anchor + int((self._done + self._group) * self._period)

    def due(self, now: int) -> int:
        """Count the ticks that are due; 0 if the deadline is still to come."""
        late = now - self.deadline
        if late < 0:
            return 0
        if late > LONGEST_LAG:
            self.lags += 1
            self.largest_lateness = max(self.largest_lateness, late)
            self._anchor += late
        return int((now - self._anchor) / self._period) - self._done

    def begin(self, ticks: int, now: int) -> None:
        """Note that ticks begin, which are then as good as done."""
        self.count(ticks)
        if not self.factor:
            return
        late = now - self._anchor - int((self._done + min(self._group, ticks)) * self._period)
        self.last_lateness = late
        if late > self.largest_lateness:
            self.largest_lateness = late
        whole = int((now - self._anchor) / self._period) - self._done
        self.overruns += max(0, min(ticks, whole - self._group))
        self._done += ticks

    def count(self, ticks: int) -> None:
        """Count ticks that have no deadline."""
        self._counted += ticks

    def _claimed(self, now: int) -> float:
        """
        Ticks that count as done: those that are, and of the one (or the group) whose deadline is
        to come the share of its time that has passed.

        Whole ticks in a window are one more or less by where the window ends.
        """
        if not self.factor:
            return self._counted
        passed = (now - self._anchor) / self._period - self._done
        return self._counted + min(max(passed, 0.0), self._group)

    def factor_reached(self, now: int) -> float:
        """
        Real-time factor since the last call or restart; where that is less than LEAST_WINDOW ago,
        since one before it.
        """
        claimed, looks = self._claimed(now), self._looks
        while len(looks) > 1 and looks[1][0] <= now - LEAST_WINDOW:
            looks.popleft()
        begin, before = looks[0]
        looks.append((now, claimed))
        wall = now - begin
        return (claimed - before) * self._dt_ns / wall if wall > 0 else self.factor
