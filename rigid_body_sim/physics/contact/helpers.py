# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The threads that help with ticks, as Python sees them: begun for one call of the kernel of a scene,
and gone when it is over. Whether there are any changes no bit: see `crew`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rigid_body_sim.physics.arrays import Indices
from rigid_body_sim.physics.compile.side_by_side import SideBySide
from rigid_body_sim.physics.contact import crew

Calls = Sequence[Callable[..., Any]]


class Helpers(SideBySide):
    """
    Who helps at a board. Whoever looks at what they write calls `rest` first, as an interrupt may
    come anywhere.
    """

    def __init__(self, board: Indices) -> None:
        super().__init__()
        self._board = board

    def go(self, leads: Callable[..., Any], help_with: Calls, arguments: Sequence[Any]) -> Any:
        """
        Let ticks pass with help; return what the one who leads does.

        leads     : the kernel with the arrays of the scene
        help_with : the same with those of each helper
        """
        board = self._board
        found: list[Any] = []

        def lead(*these: Any) -> None:
            try:
                found.append(leads(*these))
            finally:
                board[crew.OVER] = 1

        self.rest()
        board[crew.TICKETS], board[crew.HELPERS], board[crew.OVER] = 0, len(help_with), 0
        try:
            self.call([*help_with, lead], arguments)
        finally:
            board[crew.HELPERS] = 0
        return found[0]

    def rest(self) -> None:
        """Let the call be over, and wait until nobody works."""
        if self._batch is not None:
            self._board[crew.OVER] = 1
        super().rest()
