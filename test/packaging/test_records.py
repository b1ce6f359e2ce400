# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fields of records: where they stand, and all their numbers at once."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from rigid_body_sim.physics.arrays import Record, fields_of


@pytest.mark.parametrize('stride', [1, 8])
def test_the_spans_of_all_fields_are_every_number_once(stride: int) -> None:
    record = Record(stride=stride, begin=16)
    places = [
        record.number('kg', 'one'),
        record.vector('m', 'three'),
        record.quaternion('-', 'four'),
        record.symmetric('kg m^2', 'six'),
        record.matrix('-', 'nine'),
    ]
    numbers = np.arange(record.size)
    spans = [numbers[record.span(place)] for place in places]
    assert [len(span) for span in spans] == [1, 3, 4, 6, 9]
    assert [int(span[0]) for span in spans] == places
    assert np.array_equal(np.concatenate(spans), numbers[16::stride])


def test_padding_has_no_name_though_a_number_of_the_module_is_its_place() -> None:
    made, record = ModuleType('made'), Record()
    made.row, made.MASS = record, record.number('kg', 'mass')
    made.SIZE, made.COUNT = record.padding(8), 1
    assert list(fields_of(made, record)) == ['MASS']
