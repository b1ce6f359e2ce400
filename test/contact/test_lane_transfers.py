# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What lanes fetch of bodies and give to them, eight numbers at a time, is that of one by one."""

from typing import Any

import numpy as np
import pytest

from rigid_body_sim.physics.compile.kernels import kernel, plain
from rigid_body_sim.physics.contact.solver import transfers

LANES, RECORD, FIELD = 8, 16, 3  # a field that begins at no line of the cache


def fetch_both(places: Any, table: Any, rows: Any) -> None:
    """Fetch six numbers of each record, then seven."""
    transfers.fetch_six(places, 0, table, FIELD, rows, 0)
    transfers.fetch_seven(places, 0, table, FIELD, rows, 6 * LANES)


def replace_both(places: Any, table: Any, rows: Any) -> None:
    """Strike A, then B, whose angular momentum is known."""
    transfers.replace_on_a(places, 0, table, FIELD, rows, 0, 24, 72)
    transfers.replace_on_b(places, 0, table, FIELD, rows, 0, 48, 72)


def add_both(places: Any, table: Any, rows: Any) -> None:
    """Strike A, then B, with what is added."""
    transfers.add_on_a(places, 0, table, FIELD, rows, 0, 24, 72)
    transfers.add_on_b(places, 0, table, FIELD, rows, 0, 48, 72)


@pytest.mark.parametrize('transfer', [fetch_both, replace_both, add_both])
@pytest.mark.parametrize('shared', [False, True])
@pytest.mark.parametrize('filled', [0, 1, 3, LANES])
def test_lanes_and_bodies_exchange_the_numbers_of_the_plain_source(
    transfer: Any, shared: bool, filled: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """
    Also of lanes that share a record that cannot move: one lane after the other (bits); and of
    batches that do not fill their lanes.
    """
    draw = np.random.default_rng(5)
    numbers = draw.permutation(12)[:LANES] if not shared else draw.integers(0, 3, LANES)
    places = (numbers * RECORD).astype(float)
    table, rows = draw.normal(size=12 * RECORD), draw.normal(size=14 * LANES)
    rows[72 : 72 + LANES] = draw.integers(0, 2, LANES)  # which lanes are visited
    rows[72 + filled : 72 + LANES] = 0.0
    table[::5], rows[:24:7] = -0.0, 0.0  # signs of zeros are bits too
    results = []
    compiled = kernel(transfer)
    for run in (compiled, plain(transfer)):
        own_table, own_rows = table.copy(), rows.copy()
        if run is not compiled:
            for name in ('fetch_six', 'fetch_seven', 'replace_on_a', 'replace_on_b', 'add_on_a',
                         'add_on_b'):  # fmt: skip
                monkeypatch.setattr(transfers, name, plain(getattr(transfers, name)))
        run(places, own_table, own_rows)
        results.append(own_table.tobytes() + own_rows.tobytes())
    assert results[0] == results[1]
    changes = rows[72 : 72 + LANES].any() or transfer is fetch_both
    assert changes == (results[0] != table.tobytes() + rows.tobytes())
