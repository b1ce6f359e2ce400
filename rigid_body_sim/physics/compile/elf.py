# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From object files to one flat piece of position-independent code.

What LLVM writes for x86-64 under Linux are relocatable ELF files: sections, and a list of places
that a linker has yet to fill in. A kernel needs of a linker only this: the sections of all files
are put one behind the other, calls and constants inside are resolved against each other once and
for all, and what lies outside (`sin`, `memset`) is reached through slots at the end of the piece.
What is left for whoever loads it are the slots, and the few words that hold an absolute address.

Written after System V Application Binary Interface, AMD64 Architecture Processor Supplement 1.0,
4.4 (relocations). Whatever it does not know is refused (`UnknownCode`): such a kernel is run in
another way.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

_PROGRAM, _SYMBOLS, _RELOCATIONS, _NOTHING = 1, 2, 4, 8  # kinds of sections
_UNWINDING = 0x70000001
_WRITE, _ALLOCATED = 1, 2  # flags of sections
_UNDEFINED, _RESERVED = 0, 0xFF00  # numbers of sections
_LOCAL = 0  # binding of symbols that no other file knows
_ABSOLUTE, _RELATIVE, _CALL, _RELATIVE_LONG = 1, 2, 4, 24  # kinds of relocations
_BY_SLOT = (9, 41, 42)
_X86_64 = 62  # the machine
_STUB = b'\xff\x25'  # jmp *slot(%rip)
SLOT = 8  # [B]


class UnknownCode(Exception):
    """An object file holds what the loader of kernels does not know."""


@dataclass
class FlatCode:
    """
    A piece of code that runs wherever it lies, once its slots are filled.

    code      : what is copied into memory
    entry     : [B] where the function begins that is called
    externals : name -> [B] where its address belongs
    pointers  : [B] where words stand to which the address of the piece is to be added
    """

    code: bytes
    entry: int
    externals: dict[str, int] = field(default_factory=dict)
    pointers: list[int] = field(default_factory=list)


@dataclass
class _Section:
    name: str
    kind: int
    flags: int
    begin: int
    size: int
    link: int
    applies_to: int
    align: int
    place: int = -1  # in the flat piece; -1: left out


@dataclass(frozen=True)
class _Symbol:
    name: str
    section: int
    value: int
    is_local: bool


class _Object:
    """
    An object file as it stands.

    sections and symbols : its own
    """

    def __init__(self, content: bytes) -> None:
        self.content = content
        if content[:6] != b'\x7fELF\x02\x01':
            raise UnknownCode('no 64-bit ELF file')
        machine = struct.unpack_from('<H', content, 18)[0]
        if machine != _X86_64:
            raise UnknownCode(f'machine {machine}')
        begin = struct.unpack_from('<Q', content, 40)[0]
        size, count, names = struct.unpack_from('<HHH', content, 58)
        raw = [struct.unpack_from('<IIQQQQIIQQ', content, begin + i * size) for i in range(count)]
        _, _, _, _, at, *_ = raw[names]
        self.sections = [
            _Section(self._text(at + name), kind, flags, begin, size, link, applies_to, align)
            for name, kind, flags, _address, begin, size, link, applies_to, align, _ in raw
        ]
        self.symbols = [
            symbol for s in self.sections if s.kind == _SYMBOLS for symbol in self._symbols(s)
        ]

    def _text(self, at: int) -> str:
        return self.content[at : self.content.index(b'\0', at)].decode()

    def _symbols(self, table: _Section) -> Iterator[_Symbol]:
        names = self.sections[table.link].begin
        for at in range(table.begin, table.begin + table.size, 24):
            name, info, _, section, value, _ = struct.unpack_from('<IBBHQQ', self.content, at)
            is_local = info >> 4 == _LOCAL
            yield _Symbol(self._text(names + name), section, value, is_local)

    def relocations(self) -> Iterator[tuple[int, int, _Symbol, int]]:
        """Give place in the flat piece, kind, symbol and addend of what is to be filled in."""
        for table in self.sections:
            if table.kind != _RELOCATIONS or self.sections[table.applies_to].place < 0:
                continue
            target = self.sections[table.applies_to]
            for at in range(table.begin, table.begin + table.size, 24):
                offset, info, addend = struct.unpack_from('<QQq', self.content, at)
                yield target.place + offset, info & 0xFFFFFFFF, self.symbols[info >> 32], addend


class _Objects:
    """
    Object files that know each other.

    code   : their sections, one behind the other
    places : [B] in it of what one defines for the others, by name
    """

    def __init__(self, contents: Sequence[bytes]) -> None:
        self.code = bytearray()
        self.found = [_Object(content) for content in contents]
        for one in self.found:
            _lay_out(one, self.code)
        self.places: dict[str, int] = {}
        for one in self.found:
            for symbol in one.symbols:
                if symbol.is_local or symbol.section == _UNDEFINED:
                    continue
                if symbol.name in self.places:
                    raise UnknownCode(f'{symbol.name} is defined twice')
                self.places[symbol.name] = _place(one, symbol)

    def relocations(self) -> Iterator[tuple[int, int, str, int | None, int]]:
        """
        Give place, kind, name of the symbol, its place and addend of what is to be filled in;
        None: it is outside.
        """
        for one in self.found:
            for place, kind, symbol, addend in one.relocations():
                inside = symbol.section != _UNDEFINED
                at = _place(one, symbol) if inside else self.places.get(symbol.name)
                yield place, kind, symbol.name, at, addend


def flatten(contents: Sequence[bytes], name: str) -> FlatCode:
    """
    Make one piece of the object files of a kernel.

    name : of the function that is called
    """
    objects = _Objects(contents)
    code = objects.code
    flat = FlatCode(b'', -1)
    stubs: dict[str, int] = {}
    slots: dict[int | str, int] = {}

    def slot_of(symbol: str, inside: int | None) -> int:
        """Give the slot that holds the address of a symbol."""
        key = symbol if inside is None else inside
        if key not in slots:
            code.extend(bytes(-len(code) % SLOT))
            slots[key] = len(code)
            code.extend(struct.pack('<q', inside or 0))
            if inside is None:
                flat.externals[symbol] = slots[key]
            else:
                flat.pointers.append(slots[key])
        return slots[key]

    def reached(symbol: str, inside: int | None) -> int:
        """Give where a call or a constant is; a stub where it is outside."""
        if inside is not None:
            return inside
        if symbol not in stubs:
            slot = slot_of(symbol, None)
            stubs[symbol] = len(code)
            code.extend(_STUB + struct.pack('<i', slot - len(code) - 6))
        return stubs[symbol]

    for place, kind, symbol, inside, addend in objects.relocations():
        if kind == _ABSOLUTE:
            if inside is None:
                raise UnknownCode(f'the address of {symbol} in a constant')
            struct.pack_into('<q', code, place, inside + addend)
            flat.pointers.append(place)
        elif kind in (_RELATIVE, _CALL):
            struct.pack_into('<i', code, place, reached(symbol, inside) + addend - place)
        elif kind == _RELATIVE_LONG:
            struct.pack_into('<q', code, place, reached(symbol, inside) + addend - place)
        elif kind in _BY_SLOT:
            struct.pack_into('<i', code, place, slot_of(symbol, inside) + addend - place)
        else:
            raise UnknownCode(f'relocation {kind} of {symbol}')
    if name not in objects.places:
        raise UnknownCode(f'no function {name}')
    flat.code, flat.entry = bytes(code), objects.places[name]
    return flat


def _lay_out(found: _Object, code: bytearray) -> None:
    """Put the sections that are needed behind what is there."""
    for section in found.sections:
        unwinds = section.kind == _UNWINDING or section.name.startswith('.eh_frame')
        if not section.flags & _ALLOCATED or not section.size or unwinds:
            continue
        constant = section.name.startswith('.data.rel.ro')
        if section.kind != _PROGRAM or (section.flags & _WRITE and not constant):
            raise UnknownCode(f'a section {section.name} of {section.size} bytes')
        code.extend(bytes(-len(code) % max(1, section.align)))
        section.place = len(code)
        code.extend(found.content[section.begin : section.begin + section.size])


def _place(found: _Object, symbol: _Symbol) -> int:
    """Give where a symbol that an object file defines is in the flat piece."""
    if symbol.section >= _RESERVED or found.sections[symbol.section].place < 0:
        raise UnknownCode(f'{symbol.name} lies in section {symbol.section}')
    return found.sections[symbol.section].place + symbol.value
