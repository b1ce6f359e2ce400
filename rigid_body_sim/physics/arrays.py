# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Arrays and records: tables of numbers whose fields count themselves.

A kernel sees one-dimensional arrays. What stands where in them is declared once, field by field,
as module-level integers, which numba takes for constants:

    body = Record()
    MOMENTUM = body.vector('kg m/s', 'of the centre of mass')
    INVERSE_MASS = body.number('1/kg', '')
    SIZE = body.size

    x = bodies[i * SIZE + MOMENTUM]

`stride` is the distance of two numbers of a field: 1 where a record is a row of numbers, 8 where
each number is a row of eight lanes. `fields_of` gives the fields with their names, for the page of
docs and for tests.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]  # in a kernel: one-dimensional
Indices = NDArray[np.int64]

UNUSED = 'unused'  # meaning of padding


@dataclass(frozen=True)
class Field:
    """
    One field of a record.

    begin   : where it begins
    count   : numbers in it
    unit    : '-' for none
    meaning : what it says, with its frame
    """

    begin: int
    count: int
    unit: str
    meaning: str


class Record:
    """
    A table that grows by a field at a time.

    stride : distance of two numbers of a field
    begin  : where the first field begins, where it continues another record
    """

    def __init__(self, *, stride: int = 1, begin: int = 0) -> None:
        self.stride = stride
        self.begin = begin
        self.fields: list[Field] = []

    @property
    def size(self) -> int:
        """Where the next field would begin: the numbers of the record, if it begins at 0."""
        last = self.fields[-1] if self.fields else None
        return self.begin if last is None else last.begin + self.stride * last.count

    def numbers(self, count: int, unit: str, meaning: str) -> int:
        """Add a field of several numbers; give its place."""
        field = Field(self.size, count, unit, meaning)
        self.fields.append(field)
        return field.begin

    def number(self, unit: str, meaning: str) -> int:
        """Add a field of one number."""
        return self.numbers(1, unit, meaning)

    def vector(self, unit: str, meaning: str) -> int:
        """Add a field x, y, z."""
        return self.numbers(3, unit, meaning)

    def quaternion(self, unit: str, meaning: str) -> int:
        """Add a field x, y, z, w."""
        return self.numbers(4, unit, meaning)

    def symmetric(self, unit: str, meaning: str) -> int:
        """Add a symmetric matrix: xx, xy, xz, yy, yz, zz."""
        return self.numbers(6, unit, meaning)

    def matrix(self, unit: str, meaning: str) -> int:
        """Add a matrix (3, 3), row by row."""
        return self.numbers(9, unit, meaning)

    def span(self, begin: int) -> slice:
        """All numbers of the field that begins there: `rows[:, body.span(MOMENTUM)]`."""
        field = next(field for field in self.fields if field.begin == begin)
        return slice(begin, begin + self.stride * field.count, self.stride)

    def padding(self, size: int) -> int:
        """Leave numbers unused up to a size, for the sake of aligned rows; give that size."""
        unused = (size - self.size) // self.stride
        if unused > 0:
            self.numbers(unused, '-', UNUSED)
        return self.size


def fields_of(module: ModuleType, record: Record) -> dict[str, Field]:
    """
    Give the fields of a record by the names that a module gives them: those that stand between the
    record and the next one, the first of each place. Padding has none.
    """
    names: dict[int, str] = {}
    inside = False
    for name, value in vars(module).items():
        if isinstance(value, Record):
            inside = value is record
        elif inside and name.isupper() and isinstance(value, int) and not name.startswith('SIZE'):
            names.setdefault(value, name)
    fields = [field for field in record.fields if field.meaning != UNUSED]
    return {names.get(field.begin, ''): field for field in fields}
