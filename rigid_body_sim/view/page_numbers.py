# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
All arrays of a page in one run of bytes, so that they are compressed together and once.

An entry tells the browser where an array stands: kind (f4, f8, u4: little-endian, as typed arrays
are there), first byte, and number of values, in C order.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

ALIGNED = 8  # [byte]
LARGEST_SINGLE = float(np.finfo(np.float32).max)
SINGLE = 1e4  # [-] of what is drawn: so far away single precision still is 6e-4 of it


class PageNumbers:
    """Collects arrays, equal ones once."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._known: dict[tuple[str, bytes], dict[str, Any]] = {}
        self._end = 0

    def add(self, values: ArrayLike, kind: str) -> dict[str, Any]:
        """Take an array as f4, f8 or u4 and return its entry."""
        array = np.asarray(values)
        if kind == 'f4':  # larger ones round to infinity, which is no length of an arrow
            array = np.clip(array, -LARGEST_SINGLE, LARGEST_SINGLE)
        array = np.ascontiguousarray(array, dtype=f'<{kind}')
        content = array.tobytes()
        if (kind, content) not in self._known:
            entry = {'kind': kind, 'at': self._end, 'size': int(array.size)}
            padding = bytes(-len(content) % ALIGNED)
            self._parts += [content, padding]
            self._end += len(content) + len(padding)
            self._known[kind, content] = entry
        return self._known[kind, content]

    def add_places(self, values: ArrayLike, drawn: float) -> dict[str, Any]:
        """Take lengths [m], in double precision where they are far from what is drawn so large."""
        farthest = float(np.max(np.abs(values), initial=0.0))
        return self.add(values, 'f8' if farthest > SINGLE * drawn else 'f4')

    def joined(self) -> bytes:
        """Give all of them."""
        return b''.join(self._parts)
