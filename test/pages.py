# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a written page holds: its record, and its numbers as arrays."""

from __future__ import annotations

import numpy as np

from rigid_body_sim.view.playback_page import unpacked


def array_of(entry, numbers):
    """The array that an entry points to, flat."""
    kind = np.dtype('<' + entry['kind'])
    return np.frombuffer(numbers, kind, count=entry['size'], offset=entry['at'])


class PageOf:
    """A page that was written, taken apart."""

    def __init__(self, path):
        self.record, self.numbers = unpacked(path.read_text())

    def __getitem__(self, key):
        return self.record[key]

    def array(self, entry):
        return array_of(entry, self.numbers)

    @property
    def times(self):
        return self.series('time')[:, 0]

    def series(self, name):
        """Rows of a series, one per instant."""
        entry = self.record['series'][name]
        return self.array(entry).reshape(-1, entry['width'])

    def of_bodies(self, name):
        """A series as (instants, bodies, numbers)."""
        rows = self.series(name)
        return rows.reshape(len(rows), len(self.record['bodies']), -1)

    @property
    def positions(self):
        """Positions (k, n, 3) [m] in the world."""
        origins = np.array([body['origin'] for body in self.record['bodies']])
        return self.of_bodies('position').astype(float) + origins
