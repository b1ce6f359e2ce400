# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How many ticks are done in one call, so that it lasts about CALL seconds of wall time: between two
calls a run hears who wants it to stop.

It cuts what is done at once, never what is computed: `step(n)` equals n times `step()`.
"""

from __future__ import annotations

CALL = 0.03  # [s] wall; longer: a signal or a request waits; shorter: Python costs more
MOST = 1 << 20  # [tick]


class Pace:
    """
    Learns from the calls that were made.

    ticks : for the next call; the first is one tick
    """

    def __init__(self) -> None:
        self.ticks = 1

    def note(self, ticks: int, seconds: float) -> None:
        """Note how long [s] so many ticks took."""
        if seconds > CALL:
            self.ticks = max(1, int(ticks * CALL / seconds))
        elif ticks >= self.ticks and seconds < CALL / 2:
            self.ticks = min(2 * ticks, MOST)
