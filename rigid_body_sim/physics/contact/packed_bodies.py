# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies of a group of islands, packed into blocks of their own while it passes its substeps.

The blocks of a scene (`state.blocks`) hold bodies in the order of the core, whoever touches whom.
So that a group of islands can pass all its substeps before the next one begins, and what it needs
stays in the cache of the processor, its bodies are copied into blocks that are theirs alone, and
back at the end of the tick. The k-th member of the group lies there in lane k % 64 of block
k // 64. Lanes do not see each other, so nothing of this can be seen in a result.

A group of more than CAPACITY bodies stays where it is: blocks that are wholly its own are moved in
place, and of the others its lanes are packed for each motion.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.array_groups import Group, Motion
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import LANES, at

CAPACITY = 512  # [-] bodies: some 250 kB with all they need


class PackedBodies(NamedTuple):
    """
    Room for the bodies of a group: blocks as those of a scene, and a list of LANES bodies.

    translation, rotation : see `state.blocks`
    method                : numbers of the integrator
    chosen                : scratch: bodies of one block
    """

    translation: Array
    rotation: Array
    method: Array
    chosen: Indices


def make_packed_bodies(body_count: int, method_rows: int) -> PackedBodies:
    """Make room for a group of so many bodies at most; method_rows: of the integrator, a body."""
    count = blocks.blocks(min(body_count, CAPACITY))
    rotation = np.zeros(count * blocks.ROTATION)
    for entry, value in ((blocks.QW, 1.0), (blocks.MOMENTS, 1.0), (blocks.INVERSE_MOMENTS, 1.0)):
        rows = 1 if entry == blocks.QW else 3
        blocks.rows(rotation, blocks.ROTATION, entry, rows)[:] = value
    return PackedBodies(
        translation=np.zeros(count * blocks.TRANSLATION),
        rotation=rotation,
        method=np.zeros(count * method_rows * LANES),
        chosen=np.zeros(LANES, dtype=np.int64),
    )


@inline
def member(index: int, group: Group) -> Any:
    """Core index of a member of a group, and its number in the blocks of the motion."""
    body = group.members[index]
    return body, index if group.is_packed else body


@inline
def count_rigid(members: Indices, motion: Motion) -> int:
    """Count the rigid bodies among bodies in the order of the core: they come first."""
    count = len(members)
    while count > 0 and members[count - 1] >= motion.rigid_count:
        count -= 1
    return count


@inline
def end_of_block(first: int, group: Group) -> int:
    """Return the number of the member behind those that are in one block with the first."""
    count = len(group.members)
    if group.is_packed:
        return min(first + LANES, count)
    last = first + 1
    while last < count and group.members[last] // LANES == group.members[first] // LANES:
        last += 1
    return last


@inline
def fill_a_block(members: Indices, body_count: int) -> bool:
    """Tell whether bodies of one block are all that it has."""
    begin = members[0] // LANES * LANES
    return len(members) == min(LANES, body_count - begin)


@inline
def fit(members: Indices, motion: Motion, packed: PackedBodies) -> bool:
    """Tell whether bodies are to be packed: there is room, and others lie among them."""
    room = len(packed.translation) // blocks.TRANSLATION * LANES
    return len(members) < motion.body_count and len(members) <= room


@kernel
def pack(members: Indices, motion: Motion, packed: PackedBodies) -> Motion:
    """Copy bodies into blocks of their own; return them as the bodies of a motion."""
    rigid = count_rigid(members, motion)
    method_rows = len(packed.method) // (len(packed.rotation) // blocks.ROTATION) // LANES
    for index in range(len(members)):
        source = at(members[index], blocks.TRANSLATION)
        target = at(index, blocks.TRANSLATION)
        for entry in range(0, blocks.TRANSLATION, LANES):
            packed.translation[target + entry] = motion.translation[source + entry]
    for index in range(rigid):
        source, target = at(members[index], blocks.ROTATION), at(index, blocks.ROTATION)
        for entry in range(0, blocks.ROTATION, LANES):
            packed.rotation[target + entry] = motion.rotation[source + entry]
        source = at(members[index], method_rows * LANES)
        target = at(index, method_rows * LANES)
        for entry in range(0, method_rows * LANES, LANES):
            packed.method[target + entry] = motion.method[source + entry]
    return Motion(
        len(members), rigid, packed.translation, packed.rotation, packed.method, motion.pivoted
    )


@kernel
def unpack(members: Indices, packed: Motion, motion: Motion) -> None:
    """Copy bodies back: what a tick changes of them."""
    for index in range(len(members)):
        target = at(members[index], blocks.TRANSLATION)
        source = at(index, blocks.TRANSLATION)
        for entry in range(0, blocks.TRANSLATION_STATE, LANES):
            motion.translation[target + entry] = packed.translation[source + entry]
    for index in range(packed.rigid_count):
        target, source = at(members[index], blocks.ROTATION), at(index, blocks.ROTATION)
        for entry in range(0, blocks.ROTATION_STATE, LANES):
            motion.rotation[target + entry] = packed.rotation[source + entry]
