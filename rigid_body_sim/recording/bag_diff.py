# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Compares two recordings message by message and names the first difference.

Equal means: the same topics, ticks, times and payload bytes in the same order. Doubles are
compared by their bits.
"""

from __future__ import annotations

from itertools import zip_longest
from typing import NamedTuple

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag, RecordedMessage
from rigid_body_sim.recording.ulps import ulp_distance

Scalar = int | float | str


class Difference(NamedTuple):
    """
    The first difference of two recordings A and B.

    message : place in the file, from 0
    tick    : sequence of the message (of A; of B where A has ended)
    topic   : its topic
    field   : a message field, `topic`, `sequence`, `log_time`, `type`, `end` or `byte N`
    a, b    : its values
    ulps    : distance of the values if they are doubles
    """

    message: int
    tick: int
    topic: str
    field: str
    a: Scalar
    b: Scalar
    ulps: int | None


class Comparison(NamedTuple):
    """Number of equal messages, and the first difference or None."""

    equal: int
    difference: Difference | None


def compare(a: Bag, b: Bag) -> Comparison:
    """Compare the messages of two recordings."""
    number = -1
    for number, (x, y) in enumerate(zip_longest(a.messages(), b.messages())):
        if x != y:
            return Comparison(number, _difference(number, x, y, a))
        if a.topics[x.topic] != b.topics[x.topic]:
            kinds = a.topics[x.topic].type, b.topics[x.topic].type
            return Comparison(
                number, Difference(number, x.sequence, x.topic, 'type', *kinds, None)
            )
    return Comparison(number + 1, None)


def _difference(
    number: int, x: RecordedMessage | None, y: RecordedMessage | None, bag: Bag
) -> Difference:
    if x is None or y is None:
        last = x or y
        assert last is not None
        ends = ('end of A', 'a message') if x is None else ('a message', 'end of B')
        return Difference(number, last.sequence, last.topic, 'end', *ends, None)
    for field in ('topic', 'sequence', 'log_time'):
        values = getattr(x, field), getattr(y, field)
        if values[0] != values[1]:
            return Difference(number, x.sequence, x.topic, field, *values, None)
    field, a, b, ulps = first_difference(bag.topics[x.topic].type, x.data, y.data)
    return Difference(number, x.sequence, x.topic, field, a, b, ulps)


def first_difference(type_name: str, a: bytes, b: bytes) -> tuple[str, Scalar, Scalar, int | None]:
    """Name the first field in which two unequal payloads differ: field, both values, ulps."""
    try:
        pairs = zip(
            cdr.fields(cdr.decode(type_name, a)).items(),
            cdr.fields(cdr.decode(type_name, b)).values(),
        )
    except cdr.CdrError:
        pairs = ()
    for (field, x), y in pairs:
        if isinstance(x, float) and isinstance(y, float):
            ulps = int(ulp_distance(x, y))
            if ulps:
                return field, x, y, ulps
        elif x != y:
            return field, x, y, None
    place = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
    return f'byte {place}', a[place : place + 1].hex(), b[place : place + 1].hex(), None
