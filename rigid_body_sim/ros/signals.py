# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
SIGINT and SIGTERM as a flag.

The ROS context stays valid until the bag is closed and the last words are said; a second signal
does no more than the first.
"""

from __future__ import annotations

import signal
from types import FrameType
from typing import Protocol


class Stopped(Exception):
    """A signal came before the run began."""


class Stoppable(Protocol):
    """What ends when its `stop` is set."""

    stop: bool


class Signals:
    """The flag; from its making to `restore`."""

    def __init__(self) -> None:
        self.raised = False
        self._watched: Stoppable | None = None
        self._before = {
            number: signal.signal(number, self._raise)
            for number in (signal.SIGINT, signal.SIGTERM)
        }

    def _raise(self, _number: int, _frame: FrameType | None) -> None:
        self.raised = True
        if self._watched is not None:
            self._watched.stop = True

    def check(self) -> None:
        """Raise Stopped if a signal came."""
        if self.raised:
            raise Stopped

    def watch(self, loop: Stoppable) -> None:
        """Stop this loop on a signal, also on one that came before."""
        self._watched = loop
        if self.raised:
            loop.stop = True

    def restore(self) -> None:
        """Put back the handlers that were there."""
        for number, handler in self._before.items():
            signal.signal(number, handler)
