# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Eight records of a table to and from eight lanes, as LLVM is told to do it: by loads of eight
numbers and shuffles, where the plain source (`solver.transfers`) takes number after number. The
same numbers are added in the same order, so that the bits are the same.

Number by number costs some 40 instructions a lane, and whoever then reads eight lanes at once
waits until all of them are in the cache.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.typing.templates import make_intrinsic_template

_WIDTH = 8
_NUMBER, _INDEX, _SHORT = ir.DoubleType(), ir.IntType(64), ir.IntType(32)
_VECTOR = ir.VectorType(_NUMBER, _WIDTH)
_ALIGNED = 8  # [B]
# of eight rows of eight, two after two, four after four, eight after eight
_STAGES = (
    (1, (0, 8, 2, 10, 4, 12, 6, 14), (1, 9, 3, 11, 5, 13, 7, 15)),
    (2, (0, 1, 8, 9, 4, 5, 12, 13), (2, 3, 10, 11, 6, 7, 14, 15)),
    (4, (0, 1, 2, 3, 8, 9, 10, 11), (4, 5, 6, 7, 12, 13, 14, 15)),
)


def numba_type(name: str) -> Any:
    """What numba takes a transfer for; name: of a function of `solver.transfers`."""
    define = DEFINITIONS[name]
    return types.Function(make_intrinsic_template(object(), define, name))


def _mask(places: Sequence[int]) -> Any:
    return ir.Constant(ir.VectorType(_SHORT, len(places)), list(places))


def _transposed(builder: Any, rows: Sequence[Any]) -> list[Any]:
    """Give the columns of eight rows."""
    rows = list(rows)
    for apart, first, second in _STAGES:
        rows = [
            builder.shuffle_vector(rows[i & ~apart], rows[i | apart], _mask(which))
            for i in range(_WIDTH)
            for which in (second if i & apart else first,)
        ]
    return rows


class _Writer:
    """Writes the code of one call; arguments as `solver.transfers` has them."""

    def __init__(self, context: Any, builder: Any, signature: Any, values: Sequence[Any]) -> None:
        self.builder = builder
        self._data = [
            context.make_array(kind)(context, builder, value).data
            if isinstance(kind, types.Array)
            else value
            for kind, value in zip(signature.args, values, strict=True)
        ]

    def place(self, array: int, index: Any) -> Any:
        """Point at eight numbers of the array that is an argument of a number."""
        at = self.builder.gep(self._data[array], [index])
        return self.builder.bitcast(at, _VECTOR.as_pointer())

    def row(self, array: int, index: int, further: int = 0) -> Any:
        """Point at a row of lanes; index: the argument that says where the first one begins."""
        begin = self.builder.add(self._data[index], ir.Constant(_INDEX, _WIDTH * further))
        return self.place(array, begin)

    def load(self, at: Any) -> Any:
        return self.builder.load(at, align=_ALIGNED)

    def store(self, value: Any, at: Any) -> None:
        self.builder.store(value, at, align=_ALIGNED)

    def records(self) -> list[Any]:
        """Point at the field of the record of each lane: arguments 0 to 3."""
        places = self.load(self.row(0, 1))
        numbers = self.builder.fptosi(places, ir.VectorType(_INDEX, _WIDTH))
        lanes = [ir.Constant(_SHORT, lane) for lane in range(_WIDTH)]
        begins = [self.builder.extract_element(numbers, lane) for lane in lanes]
        field = self._data[3]
        return [self.place(2, self.builder.add(begin, field)) for begin in begins]


def _fetch(count: int) -> Callable[..., Any]:
    def write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        writer = _Writer(context, builder, signature, values)
        columns = _transposed(builder, [writer.load(at) for at in writer.records()])
        for number, column in enumerate(columns[:count]):
            writer.store(column, writer.row(4, 5, number))
        return context.get_dummy_value()

    def define(
        _typing: Any, places: Any, place: Any, table: Any, field: Any, rows: Any, to: Any
    ) -> Any:
        return types.none(places, place, table, field, rows, to), write

    return define


def _while_lanes_are_left(builder: Any, active: Any, write_lane: Callable[[int], None]) -> None:
    """
    Write lane after lane, up to the last active one. Empty lanes are the last ones, and all have
    the same record: each would wait until what the one before has written there can be read.
    """
    lanes = builder.bitcast(active, ir.IntType(_WIDTH))

    def write_from(lane: int) -> None:
        if lane == _WIDTH:
            return
        later = builder.icmp_unsigned('>=', lanes, ir.Constant(ir.IntType(_WIDTH), 1 << lane))
        with builder.if_then(later):
            write_lane(lane)
            write_from(lane + 1)

    write_from(0)


def _strike(*, of_b: bool, replaces: bool) -> Callable[..., Any]:
    takes = (0, 1, 2, 6, 7) if replaces else tuple(range(_WIDTH))

    def write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        writer = _Writer(context, builder, signature, values)
        records = writer.records()
        rows = [writer.load(writer.row(4, 5 if i < 3 else 6, i % 3)) for i in range(6)]
        nothing = ir.Constant(_VECTOR, [-0.0] * _WIDTH)  # what changes no bit when it is added
        if not of_b:  # the opposite of what B is given
            rows[:3] = [builder.fsub(nothing, row) for row in rows[:3]]
        visited = writer.load(writer.row(4, 7))
        active = builder.fcmp_ordered('>', visited, ir.Constant(_VECTOR, [0.0] * _WIDTH))
        rows = [builder.select(active, row, nothing) for row in rows]
        given = _transposed(builder, [*rows, nothing, nothing])

        def write_lane(lane: int) -> None:
            at, change = records[lane], given[lane]
            old = writer.load(at)
            new = builder.fadd(old, change)
            if replaces:
                places = [i if i in takes else i + _WIDTH for i in range(_WIDTH)]
                new = builder.shuffle_vector(new, change, _mask(places))
                is_active = builder.extract_element(active, ir.Constant(_SHORT, lane))
                new = builder.select(is_active, new, old)
            writer.store(new, at)

        _while_lanes_are_left(builder, active, write_lane)
        return context.get_dummy_value()

    def define(
        _typing: Any, places: Any, place: Any, table: Any, field: Any, rows: Any, linear: Any,
        angular: Any, visited: Any,
    ) -> Any:  # fmt: skip
        return types.none(places, place, table, field, rows, linear, angular, visited), write

    return define


DEFINITIONS = {
    'fetch_six': _fetch(6),
    'fetch_seven': _fetch(7),
    'replace_on_a': _strike(of_b=False, replaces=True),
    'replace_on_b': _strike(of_b=True, replaces=True),
    'add_on_a': _strike(of_b=False, replaces=False),
    'add_on_b': _strike(of_b=True, replaces=False),
}
