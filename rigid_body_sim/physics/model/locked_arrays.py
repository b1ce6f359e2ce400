# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Arrays and mappings of records that nobody can write to: all simulations share a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np


class LockedArrays:
    """A record whose arrays are locked where they come writeable: out of a pickle or deep copy."""

    def __setstate__(self, fields: Mapping[str, Any]) -> None:
        for value in fields.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(fields)


class LockedMapping(dict[str, Any]):
    """A mapping of a record, which cannot be changed; `copy` and `|` give one that can."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError(
            'a mapping of a scene or body cannot be written to, for all its simulations share it; '
            'make another record: dataclasses.replace(scene, contact={**scene.contact, …})'
        )

    __setitem__ = __delitem__ = __ior__ = _refuse  # pyright: ignore
    clear = pop = popitem = setdefault = update = _refuse  # pyright: ignore

    def __reduce__(self) -> tuple[Any, ...]:
        return (LockedMapping, (dict(self),))


def locked_mapping(value: Any) -> Any:
    """
    Give a mapping that nobody can write to, nor to mappings in it, with tuples in place of lists;
    anything else as it is.
    """
    if isinstance(value, LockedMapping) or not isinstance(value, Mapping):
        return value
    return LockedMapping({key: _locked_inside(each) for key, each in value.items()})


def _locked_inside(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return tuple(map(_locked_inside, value))
    return locked_mapping(value)


def locked(value: Any) -> Any:
    """Give an array that nobody else has and nobody can write to; anything else as it is."""
    if isinstance(value, np.ndarray) and (value.flags.writeable or value.base is not None):
        value = value.copy()
        value.setflags(write=False)
    return value
