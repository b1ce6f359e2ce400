# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What LLVM is to compile of one function: the text of it, simplified by itself, and of what it
names, by symbol.

A kernel is the texts of some hundred functions, put together and read by LLVM (`joined`). Nothing
is linked, and what is done to a function by itself is done once: whoever reuses a piece in another
kernel takes its text.

The same source gives the same text in every process. In that of one module attributes and metadata
are numbered, and what is its own alone may be called as something else in another module:
attributes stand where they are named here, numbers of metadata and such names are those of their
content, which is the same wherever it stands; and the symbol of a function is that of what it was
made of (`numba_pipeline`).

A piece is kept in a file (`PieceFiles`), which names those of the pieces that it needs, with a
digest of their text: where one of them is not whole, or another one, none that needs it is whole,
and they are compiled anew. What all the same names a function that nobody defines is not run
(`Unresolved`).
"""

from __future__ import annotations

import json
import pickle
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from rigid_body_sim.physics.compile.elf import UnknownCode
from rigid_body_sim.physics.compile.kernel_files import named, read_whole, write_whole

_VALUE = re.compile(r'^define .*?^\}\n|^declare [^\n]*\n|^@[^\n]*\n', re.DOTALL | re.MULTILINE)
_SYMBOL = re.compile(r'@("[^"]*"|[\w.$-]+)')
_OUTSIDE = re.compile(r'declare |@\S+ = (?:external|extern_weak) ')
_OWN = re.compile(r'@("[^"]*"|[\w.$-]+) = (?:internal|private) ')
_NODE = re.compile(r'^!(\d+) = (.*)\n', re.MULTILINE)
_METADATA = re.compile(r'!(\d+)')
_ATTRIBUTES = re.compile(r'^attributes #(\d+) = \{ (.*) \}\n', re.MULTILINE)
_GROUP = re.compile(r' #(\d+)')
_ASIDE = re.compile(r' +; preds = .*')
_DIGITS = 24  # of the digest in the name of what is a module's own
_MOST = 2**31  # of the numbers that LLVM reads
_ADDRESS = 'numba.dynamic.globals'  # how the symbols of variables begin that hold one


def hold_addresses(symbols: Iterable[str]) -> bool:
    """Tell whether what has these symbols holds an address of this process."""
    return any(symbol.startswith(_ADDRESS) for symbol in symbols)


class Place(NamedTuple):
    """Where a piece is kept: file, key, and digest of its text."""

    file: str
    key: str
    digest: str


class Unresolved(Exception):
    """Pieces, put together, name what nobody defines."""


@dataclass(frozen=True, eq=False)
class Piece:
    """
    The text of one function.

        defined  : what it defines, by symbol
        declared : what it names and others define, by symbol
        foreign  : bitcode of what it calls that is no piece, by name
        needs    : pieces of the functions that it calls
        place    : file and key under which it is kept, and the digest of its text
    """

    defined: dict[str, str]
    declared: dict[str, str]
    foreign: dict[str, bytes]
    needs: tuple[Piece, ...]
    place: Place | None = None

    @property
    def is_for_all(self) -> bool:
        """
        Whether another process can use it: numba's own pipeline gives symbols that bear a number
        of the process, and what holds an address is of this one.
        """
        return not self.foreign and not hold_addresses(self.defined)


def in_order(pieces: Iterable[Piece]) -> Iterator[Piece]:
    """Give pieces with all that they need, each once, what is needed before who needs it."""
    seen: set[int] = set()
    under_way: list[tuple[Piece | None, Iterator[Piece]]] = [(None, iter(pieces))]
    while under_way:
        who, ahead = under_way[-1]
        piece = next(ahead, None)
        if piece is None:
            under_way.pop()
            if who is not None:
                yield who
        elif id(piece) not in seen:
            seen.add(id(piece))
            under_way.append((piece, iter(piece.needs)))


def taken_apart(text: str) -> tuple[dict[str, str], dict[str, str]]:
    """
    Sort what a module holds into what it defines and what it declares, by symbol.

    text : of the module, as LLVM writes it

    UnknownCode if its metadata name each other in a circle.
    """
    values = [(_name(value), value) for value in _VALUE.findall(text)]
    groups = dict(_ATTRIBUTES.findall(text))
    nodes = _Nodes(dict(_NODE.findall(text)), next(n for n, v in values if v.startswith('define')))
    names: dict[str, str] = {}
    for symbol, value in values:
        found = _OWN.match(value)
        if found:  # numba names a text by the hash that it has in this process
            digest = sha256(value[found.end() :].encode()).hexdigest()[:_DIGITS]
            names[symbol] = f'{_ADDRESS if hold_addresses([symbol]) else "own"}.{digest}'

    def named(found: re.Match[str]) -> str:
        own = names.get(found[1].strip('"'))
        return found[0] if own is None else f'@"{own}"'

    defined, declared = {}, {}
    for symbol, value in values:
        whole = _SYMBOL.sub(named, value) if names else value
        if not value.startswith('@'):
            whole = _GROUP.sub(lambda found: ' ' + groups[found[1]], _ASIDE.sub('', whole))
            whole = _METADATA.sub(lambda found: '!' + nodes.number(found[1]), whole)
        (declared if _OUTSIDE.match(value) else defined)[names.get(symbol, symbol)] = whole
    return defined | nodes.texts, declared


def _name(value: str) -> str:
    found = _SYMBOL.search(value)
    assert found is not None
    return found[1].strip('"')


class _Nodes:
    """
    Metadata of a module, numbered by their content; what is distinct, by whose it is as well.

        texts : of the nodes that were asked for, with all that they name
    """

    def __init__(self, contents: dict[str, str], owner: str) -> None:
        self.texts: dict[str, str] = {}
        self._contents, self._owner = contents, owner
        self._numbers: dict[str, str | None] = {}  # None: asked for, as it names itself

    def number(self, old: str) -> str:
        """Give the number of a node, by that which it has in its module."""
        if old not in self._numbers:
            self._numbers[old] = None
            content = self._contents[old]
            others = {one: self.number(one) for one in _METADATA.findall(content) if one != old}
            named = _METADATA.sub(lambda found: f'!{others.get(found[1], "")}', content)
            whose = f'{self._owner} {old} ' if content.startswith('distinct') else ''
            digest = sha256((whose + named).encode()).digest()
            number = self._numbers[old] = str(int.from_bytes(digest[:8], 'big') % _MOST)
            named = _METADATA.sub(lambda found: f'!{others.get(found[1], number)}', content)
            self.texts['!' + number] = f'!{number} = {named}\n'
        known = self._numbers[old]
        if known is None:
            raise UnknownCode(f'{self._owner} has metadata in a circle')
        return known


def joined(head: str, pieces: Iterable[Piece]) -> str:
    """Put the texts of pieces, and of all that they need, together; head: triple and layout."""
    defined: dict[str, str] = {}
    declared: dict[str, str] = {}
    for piece in in_order(pieces):
        declared |= piece.declared
        for symbol, text in piece.defined.items():
            defined.setdefault(symbol, text)
    for symbol in declared.keys() & defined.keys():
        del declared[symbol]
    return ''.join((head, *declared.values(), *defined.values()))


class PieceFiles:
    """
    The pieces that a folder keeps.

    folder : see `kernel_files` for who may write into it
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        with suppress(OSError):  # then nothing is kept
            folder.mkdir(mode=0o700, exist_ok=True)
        self._known: dict[str, Piece] = {}  # by file: read, or written, once a process
        self._reads = True

    def distrust(self) -> None:
        """Read nothing any more: all is compiled anew, and written over what is there."""
        self._reads = False
        self._known.clear()

    def load(self, name: str, key: str) -> tuple[Piece, bytes] | None:
        """Give a piece, and what was kept with it; None where not all that it needs is whole."""
        path = named(self._folder, name, key.encode())
        content = read_whole(path, key.encode()) if self._reads else None
        if content is None:
            return None
        text, beside = pickle.loads(content)
        place = Place(path.name, key, _digest(text))
        known = self._known.get(path.name)
        if known is None or known.place != place:
            defined, declared, places = json.loads(text)
            needs = tuple(self._needed(Place(*one)) for one in places)
            whole = tuple(one for one in needs if one is not None)
            if len(whole) < len(needs):
                return None
            known = self._known[path.name] = Piece(defined, declared, {}, whole, place)
        return known, beside

    def _needed(self, place: Place) -> Piece | None:
        piece = self._known.get(place.file)
        if piece is None:
            found = self.load(place.file.rsplit('.', 2)[0], place.key)
            piece = found and found[0]
        return piece if piece is not None and piece.place == place else None

    def save(self, name: str, key: str, piece: Piece, beside: bytes) -> Piece:
        """Keep a piece, if others can use it and what it needs is kept; give it with its place."""
        places = [one.place for one in piece.needs]
        if not piece.is_for_all or None in places:
            return piece
        path = named(self._folder, name, key.encode())
        text = json.dumps([piece.defined, piece.declared, places]).encode()
        write_whole(path, key.encode(), pickle.dumps((text, beside)))
        place = Place(path.name, key, _digest(text))
        kept = self._known[path.name] = replace(piece, place=place)
        return kept


def _digest(text: bytes) -> str:
    return sha256(text).hexdigest()
