# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The crew of a tick: the thread that goes through the recipe leads; others, if there are any, help
with what falls into parts that have nothing to do with each other (`step`).

    leads                                  helps, until the call is over
        post(KIND, parts)                      wait for a post
        while there is a part: do it           while there is a part: do it
        wait for the parts that were taken     …

Who helps is inside the same kernel, with the same arrays but for scratch of its own. It takes a
part only if it is there: who leads waits for no more than the parts that were taken. What a part
does depends on its number alone, not on who does it, so that the bits are the same.

A post is one number, TICKETS: what is to be done, and which parts are left. A part is taken by
writing it anew without the part, in one go; so nobody can take a part of a post that is gone. Who
leads takes the last one that is left, who helps the first: so in each tick a thread finds most of
what it needs in its own cache.

Who waits looks again and again, but not for long (LOOKS): then who leads lets others go first, and
who helps sleeps between two looks (NAP). Who helps begins and ends with a call of the kernel
(`helpers`).
"""

from __future__ import annotations

import ctypes
from contextlib import suppress
from functools import cache
from typing import NamedTuple

import numpy as np

from rigid_body_sim.physics.arrays import Indices, Record
from rigid_body_sim.physics.compile.kernels import inline, kernel, transfer
from rigid_body_sim.physics.state import blocks

LINE = 8  # numbers of a cache line: who writes into one keeps others from reading it

board = Record()
TICKETS = board.number('-', 'the post: what is to be done, and the parts left: see `_post_of`')
board.padding(LINE)
FINISHED = board.number('-', 'parts of the post that are done')
board.padding(2 * LINE)
OVER = board.number('-', '1: the call is over: who helps goes; set by Python')
HELPERS = board.number('-', 'how many may help in this call; set by Python')
YIELD = board.number('-', 'where the function of the system is that lets others go first, or 0')
SLEEP = board.number('-', 'the same of the one that sleeps for some microseconds')
SIZE = board.padding(3 * LINE)

own = Record()
HELPS = own.number('-', '0: it leads; 1: it helps')
ALONE = own.number('-', '1: nobody else is to do anything of the post')
LEFT = own.number('-', 'parts that are left of such a post')
SIZE_OF_OWN = own.padding(LINE)

KIND_UNIT, LAST_UNIT = 1 << 48, 1 << 24
# what is to be done
NOTHING, BODIES, COLLIDERS, MANIFOLDS, GROUPS, IMPULSES = range(6)
NO_PART = -1

# parts of a tick: fewer wait for each other longer, more cost calls, and lists with gaps
BODIES_OF_PART = 2 * blocks.LANES  # [-] whole blocks; as many colliders

# looks before one lets others go first: 0.2 ms, longer than a group takes, or goes by between two
# posts of 1000 boxes. Who gives a busy processor away gets it back after some ms.
LOOKS = 100_000
NAP = 50  # [us]


class Crew(NamedTuple):
    """
    What threads tell each other.

    board : see above
    own   : of each thread its own: HELPS, ALONE, LEFT
    """

    board: Indices
    own: Indices


@transfer
def seen(numbers: Indices, index: int) -> int:
    """Read a number that another thread may write."""
    return numbers[index]


@transfer
def show(numbers: Indices, index: int, value: int) -> None:
    """Write a number that another thread may read, and with it all that was written before."""
    numbers[index] = value


@transfer
def count_one(numbers: Indices, index: int) -> None:
    """Add one to a number to which others may add, too."""
    numbers[index] += 1


@transfer
def replace(numbers: Indices, index: int, old: int, new: int) -> bool:
    """Write a number if it is still the old one; tell whether it was."""
    if numbers[index] != old:
        return False
    numbers[index] = new
    return True


@transfer
def ask_system(function: int, number: int) -> None:
    """Call a function of the system, if there is one, with a number."""


@inline
def helps(crew: Crew) -> bool:
    """Tell whether this thread helps; else it leads."""
    return crew.own[HELPS] != 0


@inline
def is_alone(crew: Crew) -> bool:
    """Tell whether nobody helps."""
    return crew.board[HELPERS] == 0


@inline
def parts_of(count: int) -> int:
    """Count the parts of so many bodies or colliders."""
    return (count + BODIES_OF_PART - 1) // BODIES_OF_PART


@inline
def post(kind: int, parts: int, crew: Crew) -> None:
    """Let parts be done by whoever is there; a lone one by who posts it."""
    if crew.board[HELPERS] == 0 or parts == 1:
        crew.own[ALONE], crew.own[LEFT] = 1, parts
        return
    crew.own[ALONE] = 0
    crew.board[FINISHED] = 0
    show(crew.board, TICKETS, _post_of(kind, 0, parts))


@inline
def _post_of(kind: int, first: int, last: int) -> int:
    """Write a post as one number: parts are left from a first one on; last: the one behind."""
    return kind * KIND_UNIT + last * LAST_UNIT + first


@inline
def _is_left(tickets: int) -> bool:
    """Tell whether some part of a post is left."""
    return tickets % LAST_UNIT < tickets % KIND_UNIT // LAST_UNIT


@kernel
def take(kind: int, crew: Crew) -> int:
    """Take a part of what is to be done; NO_PART: none is left, or something else is done now."""
    if crew.own[ALONE] == 1:
        crew.own[LEFT] -= 1
        return crew.own[LEFT]
    while True:
        tickets = seen(crew.board, TICKETS)
        if tickets // KIND_UNIT != kind or not _is_left(tickets):
            return NO_PART
        first, last = tickets % LAST_UNIT, tickets % KIND_UNIT // LAST_UNIT
        part = last - 1
        left = _post_of(kind, first, part)
        if helps(crew):
            part = first
            left = _post_of(kind, first + 1, last)
        if replace(crew.board, TICKETS, tickets, left):
            return part


@inline
def finish(crew: Crew) -> None:
    """Tell that a part is done."""
    if crew.own[ALONE] == 0:
        count_one(crew.board, FINISHED)


@kernel
def wait_for_parts(parts: int, crew: Crew) -> None:
    """Wait until all parts are done: none is left that nobody has taken."""
    if crew.own[ALONE] == 0:
        looks = 0
        while seen(crew.board, FINISHED) < parts:
            looks += 1
            if looks > LOOKS:
                ask_system(crew.board[YIELD], 0)


@kernel
def wait_for_post(crew: Crew) -> int:
    """Wait until there is something to be done, and tell what; NOTHING: the call is over."""
    board = crew.board
    looks = 0
    while seen(board, OVER) == 0:
        tickets = seen(board, TICKETS)
        if _is_left(tickets):
            return tickets // KIND_UNIT
        looks += 1
        if looks > LOOKS:
            ask_system(board[SLEEP], NAP)
    return NOTHING


@cache
def _of_system(name: str) -> int:
    """Tell where a function of the system is; 0 where there is none."""
    with suppress(AttributeError, OSError, TypeError):
        return ctypes.cast(getattr(ctypes.CDLL(None), name), ctypes.c_void_p).value or 0
    return 0


def make_board() -> Indices:
    """Make a board that nobody helps at."""
    made = np.zeros(SIZE, dtype=np.int64)
    made[OVER] = 1
    made[YIELD], made[SLEEP] = _of_system('sched_yield'), _of_system('usleep')
    return made
