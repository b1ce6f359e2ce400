# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Who may meet whom in a tick: the events of each body, in linked lists, and what hangs together.

For n bodies: n numbers each of PARENT, FIRST, CARRIED, CONCERNED, ASKED, PULLED; then for each
event the next event of the body of A, and of that of B. Event 0 is none: it keeps a copy of the
one at which the tick is to be cut.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Indices
from rigid_body_sim.physics.compile.kernels import inline

PARENT = 0  # bodies that met in this tick: see `islands.union_find`, which takes the lists so
FIRST = 1  # first event of a body; NO_EVENT
CARRIED = 2  # 1: the solver moves it
CONCERNED = 3  # 1: the tick is to be cut for it
ASKED = 4  # 1: its events hold all that it may reach
PULLED = 5  # 1: a force on it depends on the state or on time, so it does not fly by itself
FIELDS = 6

NO_EVENT = 0  # also: the event that the cut is at
NOBODY = -1


@inline
def next_place(event: int, side: int, body_count: int) -> int:
    """Where the link of an event to the next one of the body of A (0) or B (1) is."""
    return FIELDS * body_count + 2 * event + side


def size_of_links(body_count: int, room: int) -> int:
    """Count the numbers of the lists, with room for so many events."""
    return FIELDS * body_count + 2 * room


@inline
def clear(body_count: int, links: Indices) -> None:
    """Begin a tick: no events. Who is pulled stays so."""
    for body in range(body_count):
        links[FIRST * body_count + body] = NO_EVENT
        links[PARENT * body_count + body] = body
        links[CARRIED * body_count + body] = 0
        links[CONCERNED * body_count + body] = 0
        links[ASKED * body_count + body] = 0


@inline
def enter(event: int, body: int, side: int, body_count: int, links: Indices) -> None:
    """Put an event first among those of a body; below 0: of none."""
    if body >= 0:
        links[next_place(event, side, body_count)] = links[FIRST * body_count + body]
        links[FIRST * body_count + body] = 2 * event + side


@inline
def following(entry: int, body_count: int, links: Indices) -> int:
    """Entry, 2 event + side, behind one in the list of a body; below 2: none."""
    return links[FIELDS * body_count + entry]
