# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which remarks are due, where thousands a second have the same few causes.

To ask the logger of rclpy costs 0.4 ms a time, also where it keeps silent. So it is not asked:
each cause is told once in a while, and of many causes the first few.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

WHILE = 1_000_000_000  # [ns] in which a cause is told once
MOST = 10  # causes told in a while; a sender that invents them fills neither log nor memory


class Remark(NamedTuple):
    """
    What there is to say.

    cause : what it has in common with others of its kind, of which one is told
    text  : what is told
    """

    cause: str
    text: str


class Remarks:
    """
    What was told a short while ago; belongs to one thread.

    clock : [ns], monotonic
    """

    def __init__(self, clock: Callable[[], int] = time.monotonic_ns) -> None:
        self._clock = clock
        self._told: set[str] = set()
        self._end = 0

    def is_due(self, cause: str) -> bool:
        """Whether to tell it; who asks does."""
        now = self._clock()
        if now >= self._end:
            self._told.clear()
            self._end = now + WHILE
        if cause in self._told or len(self._told) >= MOST:
            return False
        self._told.add(cause)
        return True
