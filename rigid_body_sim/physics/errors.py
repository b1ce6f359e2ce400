# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The two ways in which physics says no: before a run, and during one."""


class InvalidModel(ValueError):
    """
    A body, force, step or command that no physics can honour.

    The message is one line: what, where, got, allowed, cure.
    """


class SimulationDiverged(RuntimeError):
    """
    A state that left the finite numbers.

        body  : str  name of the first body (scene order) with a non-finite state
        tick  : int  the tick that produced it; the state before that tick is kept
        cause : str  what to look at
    """

    def __init__(self, *, body: str, tick: int, cause: str) -> None:
        super().__init__(f'{body!r} diverged in tick {tick}: {cause}')
        self.body = body
        self.tick = tick
        self.cause = cause
