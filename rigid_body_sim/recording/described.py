# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
CDR bytes of messages as their definitions describe them: of any type in `definitions`.

    number    aligned to its size, counted from byte 4
    text      its length with the NUL at its end, the bytes, the NUL
    T[]       how many, then each;   T[n] each
    message   its fields, one after the other

Values are what a reader expects: a number, a text, a list, or a mapping of the fields of a
message; `float64[]` and `uint8[]` are lists too. It is the plain and slow form, for comparing and
for showing; packers write large messages themselves, and the tests hold them against this one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from struct import Struct
from struct import error as struct_error
from typing import Any, ClassVar, NamedTuple

from rigid_body_sim.recording.cdr_parts import U32, CdrError, PartReader, string, up
from rigid_body_sim.recording.definitions import fields_of

_FORMATS = {
    'bool': 'B',
    'uint8': 'B',
    'byte': 'B',
    'int8': 'b',
    'uint16': 'H',
    'int16': 'h',
    'uint32': 'I',
    'int32': 'i',
    'uint64': 'Q',
    'int64': 'q',
    'float32': 'f',
    'float64': 'd',
}
_NUMBERS = {
    name: (Struct(f'>{letter}'), Struct(f'<{letter}')) for name, letter in _FORMATS.items()
}
_FIELD = re.compile(r'(?P<kind>[\w/]+)(?P<list>\[(?P<count>\d*)\])? +(?P<name>\w+)')

Values = Mapping[str, Any]


class _Field(NamedTuple):
    """length: None for one value, -1 for a list of any length."""

    name: str
    kind: str
    length: int | None


@dataclass(frozen=True, slots=True)
class Described:
    """A message of the type type_name; values: field -> number, text, list or mapping."""

    PARTS: ClassVar[tuple[tuple[str, int], ...]] = ()

    type_name: str
    values: Values


@cache
def _fields(type_name: str) -> tuple[_Field, ...]:
    package, found = type_name.split('/')[0], []
    for line in fields_of(type_name):
        match = _FIELD.match(line)
        if match is None or '=' in line:  # a constant
            continue
        kind = match['kind']
        if kind not in _NUMBERS and kind != 'string':
            kind = kind if '/' in kind else f'{package}/{kind}'
            kind = kind.replace('/', '/msg/', 1)
        count = None if match['list'] is None else int(match['count'] or -1)
        found.append(_Field(match['name'], kind, count))
    return tuple(found)


def encode_described(message: Described) -> bytes:
    """Give the payload from byte 4 on, little endian; CdrError for what does not fit."""
    content = bytearray(4)
    try:
        _write_message(content, message.type_name, message.values)
    except (struct_error, KeyError, TypeError, ValueError) as error:
        raise CdrError(f'{message.type_name}: {error}') from error
    return bytes(content[4:])


def _write_message(content: bytearray, type_name: str, values: Values) -> None:
    for field in _fields(type_name):
        value = values[field.name]
        if field.length is None:
            _write(content, field.kind, value)
            continue
        if field.length < 0:
            _write(content, 'uint32', len(value))
        elif len(value) != field.length:
            raise CdrError(f'{type_name}: {field.name} needs {field.length} values')
        for each in value:
            _write(content, field.kind, each)


def _write(content: bytearray, kind: str, value: Any) -> None:
    number = _NUMBERS.get(kind)
    if number is not None:
        content += bytes(up(len(content) - 4, number[1].size) + 4 - len(content))
        content += number[1].pack(value)
    elif kind == 'string':
        content += bytes(up(len(content), 4) - len(content)) + string(value)
    else:
        _write_message(content, kind, value)


def decode_described(type_name: str, payload: bytes, order: int) -> Described:
    """Read a payload whose encapsulation was checked; CdrError."""
    reader = _DescribedReader(type_name, payload, order)
    message = Described(type_name, reader.message(type_name))
    left = reader.left  # DDS fills a message up to a multiple of four bytes
    reader.need(left < 4 and (left == 0 or len(payload) % 4 == 0), f'{left} bytes more')
    return message


class _DescribedReader(PartReader):
    """Reads fields in the order of their definition."""

    def __init__(self, type_name: str, payload: bytes, order: int) -> None:
        super().__init__(type_name, payload, order)
        self._at = 4

    def message(self, type_name: str) -> Values:
        return {field.name: self._field(field) for field in _fields(type_name)}

    def _field(self, field: _Field) -> Any:
        if field.length is None:
            return self._value(field.kind)
        count = self.u32() if field.length < 0 else field.length
        self.need(count * _least(field.kind) <= self.left, f'{count} values of {field.name}')
        return [self._value(field.kind) for _ in range(count)]

    def _value(self, kind: str) -> Any:
        number = _NUMBERS.get(kind)
        if number is not None:
            self.align(number[0].size)
            return number[self._order].unpack(self.take(number[0].size))[0]
        if kind == 'string':
            return self.text()
        return self.message(kind)


@cache
def _least(kind: str) -> int:
    """Bytes that a value takes at least, so that no number of values is believed."""
    if kind in _NUMBERS:
        return _NUMBERS[kind][0].size
    if kind == 'string':
        return U32[1].size
    return sum(
        _least(field.kind) if field.length is None else max(4, field.length * _least(field.kind))
        for field in _fields(kind)
    )


def flat(values: Any, name: str = '') -> dict[str, int | float | str]:
    """Every number and text of a value by its name: `markers[2].pose.position.x` and so on."""
    if isinstance(values, Mapping):
        items = [(f'{name}.{key}' if name else key, value) for key, value in values.items()]
    elif isinstance(values, list):
        items = [(f'{name}[{place}]', value) for place, value in enumerate(values)]
    else:
        return {name: values}
    return {key: each for inner, value in items for key, each in flat(value, inner).items()}
