# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The text of a scene: YAML bytes to plain Python values, with the line of each value.

Read by PyYAML's safe loader, and stricter: a key that stands twice in one mapping is an error, not
a silent choice; what is no decimal number (`numerals`) stays text, where YAML 1.1 reads 010 as
eight and 1:30 as ninety; and what is written, or repeated by aliases and merge keys, is bounded.

Plain values are built straight from the events of the parser. A text with an alias, a tag, a merge
key or a fault goes through PyYAML's tree of nodes, four times as dear: that alone refuses, and
that alone knows lines, which only messages ask for.
"""

from __future__ import annotations

import codecs
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml
from yaml.events import (
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)
from yaml.reader import Reader

from rigid_body_sim.errors import UserError
from rigid_body_sim.scene.numerals import DECIMAL

Path = tuple[str | int, ...]

_SafeLoader = getattr(
    yaml, 'CSafeLoader', yaml.SafeLoader
)  # the C parser is ten times as fast, where it is built in
DEEPEST = 32  # [-] levels of nesting, aliases followed
MOST_VALUES = 2_000_000  # [-] in one text: about 2 GB while it is read
MOST_REPEATED = 200_000  # [-] values that aliases repeat; some hundred bytes can ask for 1e9
LONGEST_WHOLE = 300  # [-] digits; longer ones are beyond the floats
NOT_FINITE = ('inf', 'nan')
ALIAS = b'*'
# numbers of which YAML 1.1 and `numerals` say the same: a shortcut past both
USUAL = re.compile(r'-?(?:0|[1-9][0-9]{0,17})(?:\.[0-9]+(?:e[-+][0-9]+)?)?', re.ASCII)
# words that PyYAML writes as they are, but for those that mean something else
WORD = re.compile(r'[A-Za-z_][A-Za-z0-9_]{0,60}(?:[./-][A-Za-z0-9_]{1,30}){0,1}', re.ASCII)
MEANINGS = frozenset(('yes', 'no', 'true', 'false', 'on', 'off', 'null', 'y', 'n'))
MERGE = 'tag:yaml.org,2002:merge'


@dataclass(frozen=True)
class Document:
    """
    One parsed text.

    name    : what error messages call it
    content : plain values
    text    : what was read, for line numbers; None where lines mean nothing to the reader
    """

    name: str
    content: Any
    text: bytes | None = None

    def line(self, path: Path) -> int | None:
        """Return the line (from 1) of the value at the path, or of its nearest parent."""
        node = None if self.text is None else _composed(self.text)
        for key in path:
            child = _child(node, key)
            if child is None:
                break
            node = child
        return None if node is None else node.start_mark.line + 1

    def written(self, path: Path, key: object) -> str | None:
        """Return how a key that means no text, such as `yes`, is written in a mapping there."""
        node = None if self.text is None else _composed(self.text)
        for step in path:
            node = _child(node, step)
        for key_node, _ in node.value if isinstance(node, yaml.MappingNode) else ():
            construct = _PLAIN.get(key_node.tag)
            meant = construct(key_node.value) if construct is not None else _NotPlain
            if meant.__class__ is key.__class__ and meant == key:
                return key_node.value
        return None


def read(text: bytes, *, name: str, with_lines: bool = True) -> Document:
    """Parse YAML bytes."""
    try:
        try:
            content = _built(text)
        except _NotPlain:
            content = _constructed(text)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = '' if mark is None else f'line {mark.line + 1}, column {mark.column + 1}: '
        told = _one_line(error.problem or error.context or 'not YAML')
        if mark is not None and _is_tab(text, mark):
            told = 'a tab, and YAML indents by blanks alone; write blanks in its place'
        raise UserError(f'{name}: {place}{told}') from error
    # PyYAML leaks these from values that only look like dates or tagged numbers.
    except (
        yaml.YAMLError,
        ValueError,
        KeyError,
        AttributeError,
        TypeError,
        OverflowError,
    ) as error:
        told = _no_text(text) or f'not readable as YAML: {_one_line(error)}'
        raise UserError(f'{name}: {told}') from error
    return Document(name, content, text if with_lines else None)


def write(mapping: Mapping[str, Any]) -> bytes:
    """Return the YAML bytes of a mapping; numpy values become plain ones, bit for bit."""
    try:
        if mapping:
            return ''.join(f'{line}\n' for line in _block(mapping, '')).encode()
    except (_NotPlain, RecursionError, ValueError):  # an integer of more digits than are printed
        pass
    try:
        return yaml.dump(mapping, Dumper=_Dumper, sort_keys=False, allow_unicode=True).encode()
    except (yaml.YAMLError, RecursionError, ValueError, TypeError) as error:
        raise UserError(
            f'scene: cannot be written as YAML: {_one_line(error)}; '
            'use numbers, strings, lists and mappings'
        ) from error


def _is_tab(text: bytes, mark: yaml.Mark) -> bool:
    """Tell whether a tab stands where PyYAML stumbled."""
    line = text.decode(errors='replace').splitlines()[mark.line : mark.line + 1]
    return ''.join(line)[mark.column : mark.column + 1] == '\t'


def _no_text(text: bytes) -> str | None:
    """Say where bytes are no text in UTF-8, or a character is none of YAML; None: all is."""
    if text.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return None
    try:
        fault = Reader.NON_PRINTABLE.search(text.decode())
    except UnicodeDecodeError as error:
        line, byte = 1 + text.count(b'\n', 0, error.start), text[error.start]
        return (
            f'line {line}: the byte 0x{byte:02X} is no text in UTF-8 (in Latin-1 {chr(byte)!r}); '
            'save the file in UTF-8'
        )
    if fault is None:
        return None
    line = 1 + fault.string.count('\n', 0, fault.start())
    return f'line {line}: holds {fault[0]!r}, which controls and shows nothing; take it away'


class _NotPlain(Exception):
    """A text holds what only the tree of nodes can tell, or refuse."""


def _built(text: bytes) -> Any:
    """Return the values of a text without aliases, tags, merge keys and faults; or _NotPlain."""
    try:
        loader = _Loader(text)
        try:
            return _Builder(loader.resolve).values(loader.get_event)
        finally:
            loader.dispose()
    except (yaml.YAMLError, ValueError) as error:
        raise _NotPlain from error


class _Builder:
    """
    Makes values of events, with the judgements of `_Loader`.

    resolve : gives the tag of a plain scalar, as YAML 1.1 has it
    """

    def __init__(self, resolve: Callable[..., str]) -> None:
        self._resolve = resolve
        self._known: dict[str, Any] = {}  # plain scalars that occurred: keys, zeros

    def values(self, next_event: Callable[[], Any]) -> Any:
        """Take all events of a text."""
        next_event()  # the stream begins
        if next_event().__class__ is not yaml.DocumentStartEvent:
            return None
        root: list[Any] = []
        self._fill(root, next_event)
        if next_event().__class__ is not yaml.StreamEndEvent:
            raise _NotPlain
        return root[0]

    def _fill(self, root: list[Any], next_event: Callable[[], Any]) -> None:
        """Put the one value of a document into a list."""
        known, missing = self._known, _NotPlain
        above: list[Any] = []  # the collections around the innermost open one
        inside: Any = root
        key: Any = None  # of a mapping, whose value comes next
        for _ in range(MOST_VALUES + 1):
            kind = (event := next_event()).__class__
            while kind is MappingEndEvent or kind is SequenceEndEvent:
                inside = above.pop()
                kind = (event := next_event()).__class__
            if kind is ScalarEvent:
                value = event.value
                if event.implicit[0]:
                    plain = known.get(value, missing)
                    value = self._resolved(value) if plain is missing else plain
            elif kind is MappingStartEvent:
                value = {}
            elif kind is SequenceStartEvent:
                value = []
            elif kind is yaml.DocumentEndEvent:
                return
            else:
                raise _NotPlain  # an alias
            if event.tag is not None or event.anchor is not None:
                raise _NotPlain
            if inside.__class__ is list:
                inside.append(value)
            elif key is None:
                if value.__class__ is not str or value in inside:
                    raise _NotPlain
                key = value
                continue
            else:
                inside[key] = value
                key = None
            if kind is not ScalarEvent:
                above.append(inside)
                inside = value
                if len(above) >= DEEPEST:
                    raise _NotPlain
        raise _NotPlain

    def _resolved(self, text: str) -> Any:
        """Return what a plain scalar means."""
        if USUAL.fullmatch(text):
            value = float(text) if '.' in text else int(text)
        else:
            construct = _PLAIN.get(self._resolve(yaml.ScalarNode, text, (True, False)))
            if construct is None:
                raise _NotPlain
            value = construct(text)
        self._known[text] = value
        return value


def _constructed(text: bytes) -> Any:
    """Return the values of any text, by way of its tree; PyYAML's errors for what is none."""
    loader = _Loader(text)
    try:
        root = loader.get_single_node()
        if root is not None and ALIAS in text:
            _bound_aliases(root)
        return None if root is None else loader.construct_document(root)
    finally:
        loader.dispose()


def _composed(text: bytes) -> yaml.Node | None:
    """Return the tree of a text that was read before."""
    loader = _Loader(text)
    try:
        return loader.get_single_node()
    finally:
        loader.dispose()


class _Loader(_SafeLoader):  # type: ignore[misc, valid-type]  # the base is chosen at run time
    """
    A safe loader that refuses duplicate keys, nesting on which the C parser would crash, and more
    values than the memory should hold.
    """

    depth = 0
    values = 0

    def descend_resolver(self, current_node: Any, current_index: Any) -> None:
        """Count the levels on the way in; called for every node."""
        self.depth += 1
        self.values += 1
        if self.depth > DEEPEST:
            raise _too_deep(current_node)
        if self.values > MOST_VALUES:
            raise yaml.MarkedYAMLError(
                problem=f'holds more than {MOST_VALUES} values; `repeat` makes many bodies of one'
            )
        super().descend_resolver(current_node, current_index)

    def ascend_resolver(self) -> None:
        """Count the levels on the way out."""
        self.depth -= 1
        super().ascend_resolver()

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Build a mapping after a look at its keys."""
        seen: set[str] = set()
        for key, _ in node.value:
            if key.tag == MERGE or not isinstance(key, yaml.ScalarNode):
                continue
            if key.value in seen:
                raise yaml.MarkedYAMLError(
                    problem=f'the key {key.value!r} stands twice in one mapping; keep one of them',
                    problem_mark=key.start_mark,
                )
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def _too_deep(node: Any) -> yaml.MarkedYAMLError:
    return yaml.MarkedYAMLError(
        problem=f'nested more than {DEEPEST} levels deep; a scene needs six',
        problem_mark=getattr(node, 'start_mark', None),
    )


def _whole(text: str) -> int | float | str:
    """Read what YAML 1.1 calls an integer: a number only where `numerals` calls it one."""
    if not DECIMAL.fullmatch(text):
        return text
    is_plain = len(text) <= LONGEST_WHOLE and text.lstrip('+-').isdigit()
    return int(text) if is_plain else float(text)


def _decimal(text: str) -> float | str:
    """Read what YAML 1.1 calls a float: a number only where `numerals` calls it one."""
    if text.lstrip('+-.').lower() in NOT_FINITE:
        return float(text.replace('.', ''))
    return float(text) if DECIMAL.fullmatch(text) else text


def _scalar(construct: Callable[[str], Any]) -> Callable[..., Any]:
    """Make a constructor of nodes out of one of texts."""

    def constructor(loader: Any, node: yaml.ScalarNode) -> Any:
        text = loader.construct_scalar(node)
        return construct(text) if isinstance(text, str) else text

    return constructor


_TAG = 'tag:yaml.org,2002:'
_OWN = {_TAG + 'int': _whole, _TAG + 'float': _decimal, _TAG + 'timestamp': str}
_PLAIN: dict[str, Callable[[str], Any]] = {
    **_OWN,
    _TAG + 'str': str,
    _TAG + 'bool': lambda text: yaml.SafeLoader.bool_values[text.lower()],
    _TAG + 'null': lambda text: None,
}
for _name, _construct in _OWN.items():
    _Loader.add_constructor(_name, _scalar(_construct))


def _bound_aliases(root: yaml.Node) -> None:
    """Refuse a text that aliases make endless, too deep or too large."""
    sizes: dict[int, tuple[int, int]] = {}  # values and levels, aliases followed
    repeated = _sized(root, sizes, set())[0] - len(sizes)
    if repeated > MOST_REPEATED:
        raise yaml.MarkedYAMLError(
            problem=f'its aliases repeat more than {MOST_REPEATED} values; write fewer of them',
            problem_mark=root.start_mark,
        )


def _sized(node: yaml.Node, sizes: dict[int, tuple[int, int]], above: set[int]) -> tuple[int, int]:
    """Count the values and levels below a node; each node is counted once and remembered."""
    known = sizes.get(id(node))
    if known is not None:
        return known
    if id(node) in above:
        raise yaml.MarkedYAMLError(
            problem='an alias stands inside of what it repeats', problem_mark=node.start_mark
        )
    above.add(id(node))
    values, levels = 1, 0
    children = node.value if isinstance(node, yaml.CollectionNode) else ()
    for child in children:
        for one in child if isinstance(child, tuple) else (child,):
            more, deeper = _sized(one, sizes, above)
            values, levels = values + more, max(levels, deeper)
    above.discard(id(node))
    if levels >= DEEPEST:
        raise _too_deep(node)
    sizes[id(node)] = values, levels + 1
    return sizes[id(node)]


def _block(collection: Any, margin: str) -> list[str]:
    """Write a mapping or list that is not empty as PyYAML does in block style; or _NotPlain."""
    lines = []
    if isinstance(collection, Mapping):
        for key, given in collection.items():
            if key.__class__ is not str:
                raise _NotPlain
            value = _without_numpy(given)
            start = f'{margin}{_scalar_text(key)}:'
            if not _is_open(value):
                lines.append(f'{start} {_scalar_text(value)}')
                continue
            lines.append(start)
            lines += _block(value, f'{margin}  ' if value.__class__ is dict else margin)
        return lines
    for value in map(_without_numpy, collection):
        if _is_open(value):
            first, *rest = _block(value, f'{margin}  ')
            lines += [f'{margin}- {first[len(margin) + 2 :]}', *rest]
        else:
            lines.append(f'{margin}- {_scalar_text(value)}')
    return lines


def _is_open(value: Any) -> bool:
    return value.__class__ in (dict, list, tuple) and len(value) > 0


def _without_numpy(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def _scalar_text(value: Any) -> str:
    """Write what holds nothing as PyYAML does; _NotPlain for what it may quote or fold."""
    kind = value.__class__
    if kind is float and math.isfinite(value):
        text = repr(value)
        return text if '.' in text or 'e' not in text else text.replace('e', '.0e', 1)
    if kind is int:
        return str(value)
    if kind is str and WORD.fullmatch(value) and value.lower() not in MEANINGS:
        return value
    if value is None or kind is bool:
        return {None: 'null', True: 'true', False: 'false'}[value]
    if kind in (list, tuple, dict) and not value:
        return '{}' if kind is dict else '[]'
    raise _NotPlain


class _Dumper(yaml.SafeDumper):
    """A safe dumper that knows numpy values and never abbreviates by anchors."""

    def ignore_aliases(self, data: Any) -> bool:
        """Write every value where it stands."""
        return True


_Dumper.add_multi_representer(
    np.ndarray, lambda dumper, value: dumper.represent_data(value.tolist())
)
_Dumper.add_multi_representer(
    np.generic, lambda dumper, value: dumper.represent_data(value.item())
)


def _child(node: yaml.Node | None, key: str | int) -> yaml.Node | None:
    if isinstance(node, yaml.SequenceNode) and isinstance(key, int):
        return node.value[key] if key < len(node.value) else None
    if isinstance(node, yaml.MappingNode):
        for key_node, value in node.value:
            if isinstance(key_node, yaml.ScalarNode) and key_node.value == key:
                return value
    return None


def _one_line(message: object) -> str:
    return ' '.join(str(message).split())
