# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be read of impacts at their instants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# what an impact may be; `Impacts.kind` holds the place in this list
KINDS = ('impact', 'summed', 'joint', 'unsettled')


@dataclass(frozen=True, eq=False)
class Impacts:
    """
    Impacts, in the order in which they happened.

    tick_ns   : (m,) int [ns]   start of the tick in which it happened
    remainder : (m,)   [s]      from there to its instant, to the last digit
    bodies    : (m, 2) int      scene indices
    point     : (m, 3) [m]      world, midway between the surfaces; of several points their mean
    normal    : (m, 3) [-]      unit vector from the first body to the second, world
    impulse   : (m, 3) [N s]    on the second body, world axes; the first gets the opposite
    approach  : (m,)   [m/s]    at which the surfaces met, along the normal
    kind      : (m,) int        place in KINDS. impact: of one pair, by the law of impact; summed:
                                the rest of a series of ever smaller ones, at the instant at which
                                it ends; joint: of several pairs at once, with what carries them;
                                unsettled: a cluster that impacts of pairs did not settle
    """

    tick_ns: NDArray[np.int64]
    remainder: Array
    bodies: NDArray[np.int64]
    point: Array
    normal: Array
    impulse: Array
    approach: Array
    kind: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.remainder)

    @property
    def time(self) -> Array:
        """Instants (m,) [s]: rounded, of large times the digits of `remainder` are lost."""
        return self.tick_ns / 1e9 + self.remainder

    def __getitem__(self, which: Any) -> Impacts:
        """Choose impacts as rows of an array: by a slice, a mask, or a list of places."""
        if isinstance(which, int | np.integer):
            which = [which]
        return Impacts(*(getattr(self, each.name)[which] for each in fields(self)))


NO_IMPACTS = Impacts(
    np.zeros(0, dtype=np.int64),
    np.zeros(0),
    np.zeros((0, 2), dtype=np.int64),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros(0),
    np.zeros(0, dtype=np.int64),
)


def joined(parts: Sequence[Impacts]) -> Impacts:
    """Put lists of impacts one behind the other."""
    parts = [part for part in parts if len(part)]
    if len(parts) < 2:
        return parts[0] if parts else NO_IMPACTS
    return Impacts(
        *(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(Impacts))
    )


def hardest(all_of_them: Impacts, most: int) -> Impacts:
    """Keep so many at most, those with the largest impulses, in their order."""
    if len(all_of_them) <= most:
        return all_of_them
    sizes = np.linalg.norm(all_of_them.impulse, axis=1)
    return all_of_them[np.sort(np.argsort(-sizes, kind='stable')[:most])]
