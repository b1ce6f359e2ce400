# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reads the values of a recorded manifest or ending: texts that may say anything, as plain values.

This is the one door through which they come. A value of the wrong type, beyond its range or
missing is a `DamagedBag` with one line; inside, values are trusted.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rigid_body_sim.recording.bag_files import DamagedBag

_SHOWN = 60  # characters of a value in an error


class RecordValues:
    """
    The values of one record.

    path  : of the bag
    title : of the record
    """

    def __init__(self, path: Path, title: str, content: Mapping[str, str]) -> None:
        self._path = path
        self._title = title
        self._content = content

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text as it stands."""
        value = self._content.get(key, default)
        if value is None:
            raise self.refusal(key, 'nothing', 'a value; the record is not whole')
        return value

    def integer(self, key: str, low: int, high: int, default: str | None = None) -> int:
        """Return a whole number from low to high."""
        text = self.text(key, default)
        if text.isascii() and text.isdecimal() and len(text) <= 40 and low <= int(text) <= high:
            return int(text)
        raise self.refusal(key, text, f'a whole number from {low} to {high}')

    def yes(self, key: str, default: str) -> bool:
        """Return true or false."""
        value = self.json(key, default)
        if not isinstance(value, bool):
            raise self.refusal(key, value, 'true or false')
        return value

    def names(self, key: str) -> list[str]:
        """Return a list of texts."""
        value = self.json(key)
        if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
            raise self.refusal(key, value, 'a list of texts')
        return value

    def mapping(self, key: str, default: str | None = None) -> dict[str, Any]:
        """Return a mapping from texts to numbers, texts or truth values."""
        value = self.json(key, default)
        plain = isinstance(value, dict) and all(
            isinstance(each, int | float | str) for each in value.values()
        )
        if not plain:
            raise self.refusal(key, value, 'a mapping to numbers and texts')
        return value

    def section(self, key: str, default: str | None = None) -> dict[str, Any]:
        """Return a mapping from texts to whatever JSON can say: a part of a scene."""
        value = self.json(key, default)
        if not isinstance(value, dict):
            raise self.refusal(key, value, 'a mapping')
        return value

    def json(self, key: str, default: str | None = None) -> Any:
        """Return what a JSON text says."""
        text = self.text(key, default)
        try:
            return json.loads(text)
        except (ValueError, RecursionError) as error:
            raise self.refusal(key, text, 'JSON') from error

    def refusal(self, key: str, got: object, allowed: str) -> DamagedBag:
        """Say in one line what a value is and what it may be."""
        shown = repr(got)
        if len(shown) > _SHOWN:
            shown = shown[: _SHOWN - 3] + '...'
        return DamagedBag(
            f'{self._path}: damaged: {key} of its {self._title} is {shown}; allowed: {allowed}'
        )
