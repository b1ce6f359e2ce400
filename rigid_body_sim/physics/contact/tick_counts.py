# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Counts: what Python and the kernel of the ticks tell each other in integers.

The kernel returns early where Python is needed, with a status and before anything of the next tick
has changed (FELL_ASLEEP: after a whole tick); Python answers, and calls it again.
"""

from rigid_body_sim.physics.arrays import Record

counts = Record()
# said by Python
COLLIDERS = counts.number('-', 'how many there are')
PLANES = counts.number('-', 'how many of them are planes, the first ones')
SURFACES = counts.number('-', 'how many of them are ground of triangles')
PAIR_ROOM = counts.number('-', 'room in the list of pairs')
MANIFOLD_ROOM = counts.number('-', 'room in the list of manifolds')
ROW_ROOM = counts.number('-', 'room for rows of constraints, in numbers')
BATCH_ROOM = counts.number('-', 'room in the list of batches')
CACHE_ROOM = counts.number('-', 'room in the impulse cache, in numbers')
PIECE = counts.number('-', '1: each call is a piece of a tick: nobody falls asleep in it')
FINE = counts.number('-', '1: no call asks for finer pieces')
SLEEP_CHANGED = counts.number('-', '1: other bodies sleep than in the last call')
EVENT_ROOM = counts.number('-', 'room in the list of events: `events`')
IMPACT_ROOM = counts.number('-', 'room in the list of impacts')
CUTTING = counts.number('-', 'what is done where impacts ask for a cut: the names below')
INSTANT = counts.number('-', 'what a call over no tick does with an impact: the names below')
# said by the kernel
STATUS = counts.number('-', 'why it has returned: one of the names below')
DONE = counts.number('-', 'ticks that were done')
PAIRS = counts.number('-', 'pairs in the last tick')
MANIFOLDS = counts.number('-', 'manifolds in the last tick')
BATCHES = counts.number('-', 'batches of constraints in the last tick')
LANES = counts.number('-', 'lanes of a batch that are gone over: see `colouring.lanes_in_use`')
PIECES = counts.number('-', 'into so many the tick should be cut')
GROUPS = counts.number('-', 'groups of islands in the last tick')
ASSEMBLED = counts.number('-', '1: batches and rows are those of the manifolds in the cache')
RENEWED = counts.number('-', '1: materials and softness of all constraints are written anew')
HAS_LOST = counts.number('-', '1: some body has lost a line: see `impulse_cache.link_lost`')
PAIRS_OF_PART = counts.number('-', 'pairs of one part of the narrow phase')
EVENTS = counts.number('-', 'events of the last tick, and one')
IMPACTS = counts.number('-', 'impacts in the list, of all ticks of the call; set to 0 by Python')
CUTS = counts.number('-', 'impacts of the last tick that ask for a cut')
SIZE = counts.size

# statuses
COMPLETE = 0  # all ticks are done
SHORT_OF_PAIRS = 1  # which list is too short
SHORT_OF_MANIFOLDS = 2
SHORT_OF_ROWS = 3
SHORT_OF_CACHE = 4
TOO_LONG = 5  # the tick should be cut into pieces
WOKEN = 6  # sleepers are marked that wake before the tick
FELL_ASLEEP = 7  # some body fell asleep in the tick
SHORT_OF_EVENTS = 8
SHORT_OF_IMPACTS = 9
CUT = 10  # the tick should be cut at an impact

# what is done where impacts ask for a cut
ASKS_FOR_CUTS, HIDES_CUTS, LEAVES_CUTS = 0, 1, 2  # return; go on without; leave it to the solver

# what a call over no tick does with the impact at which it was cut
NOTHING, LOOKS, STRIKES = 0, 1, 2
