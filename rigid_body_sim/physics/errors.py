# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ways in which physics says no: before a run, and during one."""

from collections.abc import Iterator
from contextlib import contextmanager


class InvalidModel(ValueError):
    """
    A body, force, step or command that no physics can honour.

    The message is one line: what, where, got, allowed, cure.
        at : what is to blame, as a path in the scene or in the body that is looked at, such as
             ('bodies', 3, 'shape'); bodies and forces by their place in the scene; (): not known
    """

    def __init__(self, message: str, *, at: tuple[str | int, ...] = ()) -> None:
        super().__init__(message)
        self.at = at


@contextmanager
def blaming(*at: str | int) -> Iterator[None]:
    """Say of the refusals inside this block that what they blame lies at this place."""
    try:
        yield
    except InvalidModel as error:
        error.at = (*at, *error.at)
        raise


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


class SimulationBusy(RuntimeError):
    """A simulation was asked for something while a step of it was under way."""

    def __init__(self) -> None:
        super().__init__(
            'this Simulation is in a step, of another thread or of the code that was interrupted '
            'for this call; one simulation belongs to one thread at a time: wait for its step, or '
            'give each thread a Simulation of its own'
        )
