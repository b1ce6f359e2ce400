# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ways in which physics says no: before a run, and during one."""

from collections.abc import Collection
from functools import partial
from types import TracebackType
from typing import Any

LIKENESS = 0.6  # [-] how near a known word must be to be proposed in place of an unknown one
LONGEST_WORD = 80  # [-] letters that a message shows; a longer word resembles nothing
MOST_NAMED = 60  # [-] words that a message lists


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


class UnknownBody(InvalidModel, KeyError):
    """A name that no body of the scene has; the message names the nearest."""

    __str__ = BaseException.__str__  # that of KeyError would put quotes around it


def path_text(path: tuple[str | int, ...]) -> str:
    """Write a path as messages do: bodies[3].shape."""
    steps = (f'[{key}]' if isinstance(key, int) else f'.{_short(key)}' for key in path)
    return ''.join(steps).lstrip('.')


def _short(word: str) -> str:
    return word if len(word) <= LONGEST_WORD else f'{word[:LONGEST_WORD]}…'


def nearest(word: object, known: Collection[str]) -> str | None:
    """
    Find the known word that a slip may have meant; None where none is near. Capitals are a slip.
    """
    import difflib  # only for who made a slip

    if not isinstance(word, str) or len(word) > LONGEST_WORD:
        return None
    small = {each.casefold(): each for each in reversed([*known])}
    near = difflib.get_close_matches(word.casefold(), small, n=1, cutoff=LIKENESS)
    return small[near[0]] if near else None


def choose_from(word: object, known: Collection[str]) -> str:
    """Write the cure for an unknown word: the nearest known one, and all that are allowed."""
    near = nearest(word, known)
    proposal = '; allowed' if near is None else f'; did you mean {near!r}? allowed'
    listed = [*known][:MOST_NAMED]
    more = f', … ({len(known)} in all)' if len(known) > len(listed) else ''
    return f'{proposal}: {", ".join(listed)}{more}'


class blaming:  # noqa: N801  (used as a statement: with blaming('mass'):)
    """Say of the refusals inside this block that what they blame lies at this place."""

    __slots__ = ('_at',)

    def __init__(self, *at: str | int) -> None:
        self._at = at

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: object, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if isinstance(error, InvalidModel):
            error.at = (*self._at, *error.at)


class SimulationDiverged(RuntimeError):
    """
    A state that left the finite numbers.

        body  : str  name of the first body (scene order) with a non-finite state
        tick  : int  the tick that produced it; the state before that tick is kept
        cause : str  what to look at
        found : str  of it, what was seen, where the rest is a guess; empty: there is none
    """

    def __init__(self, *, body: str, tick: int, cause: str, found: str = '') -> None:
        super().__init__(f'{body!r} diverged in tick {tick}: {cause}')
        self.body = body
        self.tick = tick
        self.cause = cause
        self.found = found

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by its words: a pool of processes hands it to who asked, or breaks."""
        told = {name: getattr(self, name) for name in ('body', 'tick', 'cause', 'found')}
        return partial(type(self), **told), (), self.__dict__


class SimulationBusy(RuntimeError):
    """A simulation was asked for something while a step of it was under way."""

    def __init__(self) -> None:
        super().__init__(
            'this Simulation is in a step, of another thread or of the code that was interrupted '
            'for this call; one simulation belongs to one thread at a time: wait for its step, or '
            'give each thread a Simulation of its own'
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without its words, which it makes itself."""
        return type(self), (), self.__dict__
