# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two names of a topic: its own, which the scene gives it, and that on the wire, where remapping
rules of ROS put it.

A bag holds the names on the wire, as rosbag2 records them; the manifest says which topic each one
is (`topic_names`: own -> wire, of those that differ), so that whoever reads it meets the own ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # reading needs more packages than recording
    from rigid_body_sim.recording.record_values import RecordValues

KEY = 'topic_names'  # of the manifest


def names_on_the_wire(
    own: Iterable[str], resolve: Callable[[str], str]
) -> tuple[dict[str, str], list[str]]:
    """
    Name the topics of a bag as they are on the wire.

    Where several would come to one name, these keep their own: a bag holds each topic apart.

    own     : names of the topics, each once
    resolve : what remapping rules make of one
    returns : own -> wire, of those that differ; topics that keep their own name for that reason
    """
    wire = {name: resolve(name) for name in own}
    kept: list[str] = []
    while shared := [name for name, count in Counter(wire.values()).items() if count > 1]:
        back = [name for name, taken in wire.items() if taken in shared and name != taken]
        kept += back
        wire.update((name, name) for name in back)
    return {name: taken for name, taken in wire.items() if name != taken}, kept


def read_names(values: RecordValues) -> dict[str, str]:
    """Read them from a manifest; DamagedBag where two topics would have one name."""
    names = values.mapping(KEY, '{}')
    if not all(isinstance(wire, str) for wire in names.values()):
        raise values.refusal(KEY, names, 'a mapping to names of topics')
    if len(set(names.values())) < len(names):
        raise values.refusal(KEY, names, 'another name for each topic')
    return names


def own_names(names: Mapping[str, str]) -> dict[str, str]:
    """Turn own -> wire into wire -> own."""
    return {wire: own for own, wire in names.items()}


def own_by_kind(
    wires: Mapping[str, str],
    bodies: Iterable[str],
    *,
    namespace: str,
    kinds: Mapping[str, str],
) -> tuple[dict[str, str], list[str]]:
    """
    Tell which topic of a body each one on the wire is, where nobody has noted it: by its name, or
    as the only one of its type that a body lacks.

    Of several that are remapped, the name on the wire has to hold that of the body.

    wires   : topics that a node publishes -> their types
    bodies  : of its scene; none: they are whatever the names say
    kinds   : leaf -> type, of the topics that are asked for
    returns : wire -> own; those of the type of poses or twists that could be of several bodies
    """
    space = namespace.rstrip('/')
    found = {
        wire: wire for wire, kind in wires.items() if kinds.get(wire.rpartition('/')[2]) == kind
    }
    owners = {f'{space}/{body}': body for body in bodies}
    if not owners:
        return found, []
    having = {owners[own] for wire in wires if (own := wire.rpartition('/')[0]) in owners}
    lost: list[str] = []
    for leaf in ('pose', 'twist'):
        strange = [
            wire
            for wire, kind in wires.items()
            if kind == kinds[leaf] and wire.rpartition('/')[0] not in owners
        ]
        lacking = [body for body in having if f'{space}/{body}/{leaf}' not in found]
        lacking = lacking or [
            own for own in owners.values() if f'{space}/{own}/{leaf}' not in found
        ]
        for wire in strange:
            found.pop(wire, None)
            of = [body for body in lacking if body in wire.split('/')]
            if len(strange) == len(lacking) == 1:
                of = lacking
            if len(of) == 1:
                found[wire] = f'{space}/{of[0]}/{leaf}'
            else:
                lost.append(wire)
    return found, lost
