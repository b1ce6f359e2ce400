# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a scene says of pairs of bodies: which do not meet, and which have a material of their own.

    ignore: ((a, b), (c, d, e), (balls, balls))      no two members of an entry meet
    pairs:  ({'bodies': (a, b), 'friction': 0.1},)   in place of what their materials give

A member is the name of a body or a tuple of names, a group: of two groups every body of one with
every other body of the other. Kernels get both as tables in the rising order of pair ids, see
`collision.neighbour_list`; without rules there is no table, and no code that looks into it.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel, blaming, choose_from
from rigid_body_sim.physics.model.material import MATERIAL
from rigid_body_sim.physics.model.numbers import number, shown

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST = 5_000_000  # [-] pairs that rules may name; more would fill the memory


@dataclass(frozen=True)
class PairRules:
    """
    The rules of a scene, by pairs of scene indices.

    ignored   : (n,) first * bodies + second, first < second, in rising order
    of_pairs  : the same of the pairs with a material, as the scene gives them
    materials : (m, n) columns as in `model.material`; NaN: as the materials of the two give it
    """

    ignored: Indices
    of_pairs: Indices
    materials: Array


def pair_rules(contact: Mapping[str, Any], names: Sequence[str]) -> PairRules:
    """
    Judge the rules of a scene and number its pairs.

        contact : as of a scene
        names   : of its bodies

    Raises InvalidModel, with a path from `contact` on.
    """
    index = {name: i for i, name in enumerate(names)}
    count = len(names)
    ignored = np.zeros(0, dtype=np.int64)
    for i, entry in enumerate(_entries(contact, 'ignore')):
        with blaming('ignore', i):
            found = _pairs_of_entry(entry, index, count, len(ignored))
            new = np.union1d(ignored, found)
            if len(new) == len(ignored):
                raise InvalidModel(
                    f'{_named(found[0], names)} are ignored by an earlier entry; remove one of '
                    'the two'
                )
            ignored = new
    keys, rows = [], []
    seen = np.zeros(0, dtype=np.int64)
    for i, entry in enumerate(_entries(contact, 'pairs')):
        with blaming('pairs', i):
            bodies, material = _material(entry)
            with blaming('bodies'):
                found = _pairs_of_entry(bodies, index, count, len(seen), most=2)
            for others, said in ((seen, 'given twice'), (ignored, 'ignored, so they never meet')):
                twice = np.intersect1d(found, others)
                if len(twice):
                    raise InvalidModel(
                        f'{_named(twice[0], names)} are {said}; remove one of the two',
                        at=('bodies',),
                    )
            seen = np.union1d(seen, found)
            keys.append(found)
            rows.append(np.tile(material, (len(found), 1)))
    return PairRules(
        ignored,
        np.concatenate(keys) if keys else np.zeros(0, dtype=np.int64),
        np.concatenate(rows) if rows else np.zeros((0, len(MATERIAL))),
    )


def check_form(ignore: Any, pairs: Any) -> None:
    """Refuse rules of another form, without knowing the bodies."""
    for i, entry in enumerate(_entries({'ignore': ignore}, 'ignore')):
        with blaming('ignore', i):
            _members(entry)
    for i, entry in enumerate(_entries({'pairs': pairs}, 'pairs')):
        with blaming('pairs', i):
            _material(entry)


def _entries(contact: Mapping[str, Any], key: str) -> Sequence[Any]:
    given = contact.get(key, ())
    if not isinstance(given, list | tuple):
        raise InvalidModel(f'got {shown(given)}; a list is needed', at=(key,))
    return given


def _members(entry: Any) -> list[tuple[Any, ...]]:
    """Give the members of an entry as groups."""
    if not isinstance(entry, list | tuple) or len(entry) < 2:
        raise InvalidModel(f'got {shown(entry)}; a list of at least two bodies is needed')
    groups = [tuple(m) if isinstance(m, list | tuple) else (m,) for m in entry]
    for i, group in enumerate(groups):
        for name in group:
            if not isinstance(name, str):
                raise InvalidModel(f'got {shown(name)}; the name of a body is needed', at=(i,))
    return groups


def _pairs_of_entry(
    entry: Any, index: Mapping[str, int], count: int, before: int, *, most: int | None = None
) -> Indices:
    """Number the pairs of bodies that an entry names; before: so many are known already."""
    groups = _members(entry)
    if most is not None and len(groups) > most:
        raise InvalidModel(f'got {len(groups)} bodies; a pair has two')
    for i, group in enumerate(groups):
        for name in group:
            if name not in index:
                raise InvalidModel(f'body {shown(name)} is unknown{choose_from(name, index)}',
                                   at=(i,))  # fmt: skip
    total = before + sum(len(a) * len(b) for a, b in itertools.combinations(groups, 2))
    if total > MOST:
        raise InvalidModel(
            f'got {total} pairs; at most {MOST} are allowed: give bodies that meet nobody no shape'
        )
    found = []
    for first, second in itertools.combinations(groups, 2):
        a = np.array([index[name] for name in first], dtype=np.int64)
        b = np.array([index[name] for name in second], dtype=np.int64)
        a, b = np.repeat(a, len(b)), np.tile(b, len(a))
        low, high = np.minimum(a, b), np.maximum(a, b)
        found.append((low * count + high)[low != high])
    pairs = np.unique(np.concatenate(found))
    if not len(pairs):
        raise InvalidModel(f'got {shown(entry)}; a body does not meet itself: name another')
    return pairs


def _material(entry: Any) -> tuple[Any, list[float]]:
    """Give the bodies of an entry of `pairs`, and its material."""
    keys = ('bodies', *MATERIAL)
    if not isinstance(entry, Mapping):
        raise InvalidModel(
            f'got {shown(entry)}; a mapping such as {{bodies: [a, b], friction: 0.1}} is needed'
        )
    for key in entry:
        if key not in keys:
            raise InvalidModel(f'unknown key {shown(key)}{choose_from(key, keys)}')
    if 'bodies' not in entry:
        raise InvalidModel('bodies is missing; a list of two bodies is needed')
    with blaming('bodies'):
        _members(entry['bodies'])
    if len(entry) == 1:
        raise InvalidModel(f'nothing is said of them; give one of {", ".join(MATERIAL)}')
    material = []
    for key, known in MATERIAL.items():
        with blaming(key):
            given = entry.get(key)
            if given is not None:
                number(given, unit=known.unit, minimum=known.least, maximum=known.most)
            material.append(np.nan if given is None else float(given))
    return entry['bodies'], material


def _named(pair: Any, names: Sequence[str]) -> str:
    first, second = divmod(int(pair), len(names))
    return f'{names[first]!r} and {names[second]!r}'
