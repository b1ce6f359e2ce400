# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Arrays of records that nobody can write to: all simulations of a scene share them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


class LockedArrays:
    """A record whose arrays are locked where they come writeable: out of a pickle or deep copy."""

    def __setstate__(self, fields: Mapping[str, Any]) -> None:
        for value in fields.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(fields)


def locked(value: Any) -> Any:
    """Give an array that nobody else has and nobody can write to; anything else as it is."""
    if isinstance(value, np.ndarray) and (value.flags.writeable or value.base is not None):
        value = value.copy()
        value.setflags(write=False)
    return value
