# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The material of what touches: its quantities, and which two bodies have together.

A quantity is a field of `Material`, and says all that is known of it: unit, least and most, how
those of two bodies combine, what it means. Scene reader, grammar, validation and the rules of
pairs are made of that (`MATERIAL`), and so are the columns of a collider (`material`), of a pair
with a material of its own (`of_pair`, which replaces what the two give, key by key), and those of
a constraint. Time stepping and impacts at their instants have a pair's material from one kernel,
`material_of_pair`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline


@inline
def larger(of_a: float, of_b: float) -> float:
    """Combine two numbers to the larger."""
    return max(of_a, of_b)


@inline
def geometric_mean(of_a: float, of_b: float) -> float:
    """Combine two numbers to their geometric mean."""
    return math.sqrt(of_a * of_b)


class Law(NamedTuple):
    """
    How the numbers of two bodies combine.

    said    : in words, as a scene's page has it
    combine : inline kernel (number of A, number of B)
    """

    said: str
    combine: Any


LARGER = Law('the larger', larger)
GEOMETRIC_MEAN = Law('the geometric mean', geometric_mean)


@dataclass(frozen=True)
class Quantity:
    """
    One quantity of a material.

    unit        : '-' for none
    of_two      : how those of two bodies combine
    meaning     : what it says
    least, most : limits, themselves allowed; None: none
    """

    unit: str
    of_two: Law
    meaning: str
    least: float = 0.0
    most: float | None = None


def _key(default: float, **known: Any) -> Any:
    """Describe a quantity, which is a key of a body and of a pair; default: of a body."""
    return field(default=default, metadata={'quantity': Quantity(**known)})


@dataclass(frozen=True)
class Material:
    """Contact material [-]; rolling and torsional friction are lengths [m]."""

    restitution: float = _key(
        0.0, unit='-', most=1.0, of_two=LARGER, meaning='share of the speed that an impact leaves'
    )
    friction: float = _key(0.5, unit='-', of_two=GEOMETRIC_MEAN, meaning='Coulomb friction')
    rolling_friction: float = _key(
        0.0, unit='m', of_two=LARGER, meaning='arm of the resistance to rolling'
    )
    torsional_friction: float = _key(
        0.0, unit='m', of_two=LARGER, meaning='arm of the resistance to spinning'
    )


USUAL = Material()  # of a body of which nothing is said
MATERIAL: dict[str, Quantity] = {one.name: one.metadata['quantity'] for one in fields(Material)}


def add_material(record: Record) -> tuple[int, ...]:
    """Add a number for each quantity to a record; give their places, in the order of the table."""
    return tuple(record.number(one.unit, one.meaning) for one in MATERIAL.values())


material = Record()  # of a collider
RESTITUTION, FRICTION, ROLLING_FRICTION, TORSIONAL_FRICTION = add_material(material)
SIZE = material.size

of_pair = Record(begin=SIZE)  # behind the same columns; NaN in them: not given
PAIR_ID = of_pair.number('-', 'later collider times their count plus earlier one')
SIZE_OF_PAIR = of_pair.size

_restitution, _friction, _rolling, _torsional = (one.of_two.combine for one in MATERIAL.values())


@inline
def store_material(array: Array, place: int, stride: int, numbers: Any) -> None:
    """Write the numbers of a material, in the order of the table and a stride apart."""
    (
        array[place + stride * RESTITUTION],
        array[place + stride * FRICTION],
        array[place + stride * ROLLING_FRICTION],
        array[place + stride * TORSIONAL_FRICTION],
    ) = numbers


@inline
def _own_row(pair_id: float, of_pairs: Array) -> int:
    """Where the row of a pair begins among those with a material of their own; -1: it has none."""
    low, high = 0, len(of_pairs) // SIZE_OF_PAIR
    while low < high:
        middle = (low + high) // 2
        if of_pairs[middle * SIZE_OF_PAIR + PAIR_ID] < pair_id:
            low = middle + 1
        else:
            high = middle
    place = low * SIZE_OF_PAIR
    if place < len(of_pairs) and of_pairs[place + PAIR_ID] == pair_id:
        return place
    return -1


@inline
def _given(column: int, own: int, of_pairs: Array, otherwise: float) -> float:
    """Choose what the scene gives the pair itself; NaN is not given."""
    if own < 0:
        return otherwise
    value = of_pairs[own + column]
    return value if value == value else otherwise


@inline
def material_of_pair(a: int, b: int, materials: Array, of_pairs: Array) -> Any:
    """
    Return the material of a pair of colliders, a number for each quantity in the order of the
    table: what the scene gives the pair itself, else what the two have together.

        materials : of all colliders, rows as `material`
        of_pairs  : rows as `of_pair`, in the rising order of ids
    """
    row_a, row_b = a * SIZE, b * SIZE
    own = _own_row(float(max(a, b) * (len(materials) // SIZE) + min(a, b)), of_pairs)
    restitution = _restitution(materials[row_a + RESTITUTION], materials[row_b + RESTITUTION])
    friction = _friction(materials[row_a + FRICTION], materials[row_b + FRICTION])
    rolling = _rolling(materials[row_a + ROLLING_FRICTION], materials[row_b + ROLLING_FRICTION])
    torsional = _torsional(
        materials[row_a + TORSIONAL_FRICTION], materials[row_b + TORSIONAL_FRICTION]
    )
    return (
        _given(RESTITUTION, own, of_pairs, restitution),
        _given(FRICTION, own, of_pairs, friction),
        _given(ROLLING_FRICTION, own, of_pairs, rolling),
        _given(TORSIONAL_FRICTION, own, of_pairs, torsional),
    )
