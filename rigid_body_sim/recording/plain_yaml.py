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
_SafeLoader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)  # ten times as fast, if built in


def read_yaml(text: str) -> Any:
    """Return plain values; ValueError, in one line, for what is no YAML or none of this kind."""
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f'{len(text)} characters; read are at most {MOST_CHARACTERS}')
    try:
        _check_shape(text)
        return yaml.load(text, Loader=_SafeLoader)
    except Exception as error:  # its constructors raise what they meet: attribute, overflow, key
        problem = ' '.join(str(error).split()) or type(error).__name__
        raise ValueError(problem[:300]) from error


def _check_shape(text: str) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=_SafeLoader):
        if isinstance(event, yaml.AliasEvent):
            raise ValueError(f'line {event.start_mark.line + 1}: an alias (*); write it out')
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise ValueError(f'nested deeper than {DEEPEST} levels')
