# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The arrays of bodies, forces and constraints in groups, as the stages of a tick take them; those of
collision are in `collision.collider`.

A group is a NamedTuple: it compiles as an argument of a kernel, and is a plain tuple in Python.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Motion(NamedTuple):
    """
    The bodies that move: see `state.blocks`.

    body_count  : rigid bodies and point masses
    rigid_count : rigid bodies, which come first
    method      : numbers per body of the integrator
    pivoted     : core indices of those that turn about a pivot
    """

    body_count: int
    rigid_count: int
    translation: Array
    rotation: Array
    method: Array
    pivoted: Indices


class Group(NamedTuple):
    """
    Bodies that touch, and where they are in the blocks of a motion.

    members   : their core indices, in the order of the core
    is_packed : whether the blocks are theirs alone: then the first of them is body 0 there; else
                all are in the blocks of the scene: see `packed_bodies`
    motion    : with these blocks
    """

    members: Indices
    is_packed: bool
    motion: Motion


class Forces(NamedTuple):
    """
    The force elements.

    elements, ranges : tables of the elements, and where each type begins
    saved            : forces and torques of before the motion of a substep
    """

    elements: Array
    ranges: Indices
    saved: Array


class Constraints(NamedTuple):
    """
    The manifolds and what the solver makes of them.

    manifolds     : of the tick: see `collision.manifold_record`
    rows          : constraints in wide lanes: see `solver.constraint`
    batches       : of eight constraints that share no moving body: see `solver.batch_record`
    colours       : colours of each body, a bit each, while constraints are coloured
    partners      : twice how many moving ones each body touches, and 1 for all else
    open_batches  : the batch of each colour that is not full
    impulse_cache : impulses for the warm start: see `solver.cache_record`
    groups        : of islands: see `solver.group_record`
    group_of      : the group of each body that touches
    order         : manifolds in the order of their groups
    places        : scratch: where manifolds lie in the cache
    roots         : scratch: union-find of bodies
    unsettled     : of islands that go on: see `islands.unsettled_record`
    members       : scratch: manifolds of a surface, see `solver.surface_members`
    scratch       : of the batch under way, of each thread its own: see `solver.lane_scratch`
    """

    manifolds: Array
    rows: Array
    batches: Indices
    colours: Indices
    partners: Indices
    open_batches: Indices
    impulse_cache: Array
    groups: Indices
    group_of: Indices
    order: Indices
    places: Indices
    roots: Indices
    unsettled: Array
    members: Indices
    scratch: Array
