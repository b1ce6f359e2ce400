# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reads YAML that other programs wrote into a bag, in time and memory proportional to its length.

Aliases are refused, and merge keys with them: ten lines of them stand for a thousand million
nodes. So is what is nested deeper than any metadata of a bag.
"""

from __future__ import annotations

from typing import Any

import yaml

MOST_CHARACTERS = 1 << 26  # 9,000 bodies take 2^24
DEEPEST = 32  # metadata.yaml has 6 levels
_ODD = ('tag:yaml.org,2002:merge', 'tag:yaml.org,2002:value')
_SafeLoader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)  # ten times as fast, if built in


def read_yaml(text: str) -> Any:
    """Return plain values; ValueError, in one line, for what is no YAML or none of this kind."""
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f'{len(text)} characters; read are at most {MOST_CHARACTERS}')
    try:
        try:
            return _built(text)
        except _NotPlain:
            _check_shape(text)
            return yaml.load(text, Loader=_SafeLoader)
    except Exception as error:  # its constructors raise what they meet: attribute, overflow, key
        problem = ' '.join(str(error).split()) or type(error).__name__
        raise ValueError(problem[:300]) from error


class _NotPlain(Exception):
    """A text holds an alias, a tag, a merge key or a fault, or is nested too deep."""


def _built(text: str) -> Any:
    """
    Return the values of a plain text in one pass over its events, as PyYAML's loader makes them
    in three; a scalar that occurred before is not read again.
    """
    loader = _SafeLoader(text)
    try:
        next_event = loader.get_event
        next_event()  # the stream begins
        if not isinstance(next_event(), yaml.DocumentStartEvent):
            raise _NotPlain
        root: list[Any] = []
        known: dict[str, Any] = {}
        above: list[Any] = []  # the collections around the innermost open one
        inside: Any = root
        key: Any = _NotPlain  # of a mapping, whose value comes next
        while (kind := (event := next_event()).__class__) is not yaml.DocumentEndEvent:
            if kind is yaml.MappingEndEvent or kind is yaml.SequenceEndEvent:
                inside = above.pop()
                continue
            if kind is yaml.AliasEvent or event.anchor is not None or event.tag is not None:
                raise _NotPlain
            if kind is yaml.ScalarEvent:
                value = event.value
                if event.implicit[0]:
                    if value not in known:
                        known[value] = _meant(loader, value)
                    value = known[value]
            else:
                value = {} if kind is yaml.MappingStartEvent else []
            if inside.__class__ is list:
                inside.append(value)
            elif key is _NotPlain:
                if value.__class__ is not str:
                    raise _NotPlain
                key = value
                continue
            else:
                inside[key] = value
                key = _NotPlain
            if kind is not yaml.ScalarEvent:
                above.append(inside)
                inside = value
                if len(above) > DEEPEST:
                    raise _NotPlain
        if not isinstance(next_event(), yaml.StreamEndEvent):
            raise _NotPlain
        return root[0]
    except yaml.YAMLError as error:
        raise _NotPlain from error
    finally:
        loader.dispose()


def _meant(loader: Any, text: str) -> Any:
    """Return what a plain scalar means to a loader."""
    tag = loader.resolve(yaml.ScalarNode, text, (True, False))
    if tag in _ODD:
        raise _NotPlain
    return loader.construct_object(yaml.ScalarNode(tag, text))


def _check_shape(text: str) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=_SafeLoader):
        if isinstance(event, yaml.AliasEvent):
            raise ValueError(f'line {event.start_mark.line + 1}: an alias (*); write it out')
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise ValueError(f'nested deeper than {DEEPEST} levels')
