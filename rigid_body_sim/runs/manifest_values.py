# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reads the values of a recorded manifest or ending: texts that may say anything, into what a run
takes.

This is the one door through which they come. A value of the wrong type, beyond its range or
missing is a `DamagedBag` with one line; inside, values are trusted.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.forces.held_wrenches import FOREVER, Slot
from rigid_body_sim.recording.bag_reader import DamagedBag

MOST_TICKS = 2**32 - 1  # a sequence number has 32 bits
MOST_NS = 2**31 * 10**9  # [ns] a ROS stamp counts 2^31 s
MOST_TIMEOUT_NS = 10**30  # [ns]
_SHOWN = 60  # characters of a value in an error


class ManifestValues:
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

    def places(self, key: str, count: int, default: str) -> frozenset[int]:
        """Return a set of places in a list of so many."""
        value = self.json(key, default)
        if not isinstance(value, list) or not all(_is_place(each, count) for each in value):
            raise self.refusal(key, value, f'a list of whole numbers from 0 to {count - 1}')
        return frozenset(value)

    def mapping(self, key: str, default: str | None = None) -> dict[str, Any]:
        """Return a mapping from texts to numbers, texts or truth values."""
        value = self.json(key, default)
        plain = isinstance(value, dict) and all(
            isinstance(each, int | float | str) for each in value.values()
        )
        if not plain:
            raise self.refusal(key, value, 'a mapping to numbers and texts')
        return value

    def held(self, key: str, bodies: int) -> dict[tuple[int, str], Slot]:
        """Return the commands that held, as `recorder.held_as_json` wrote them."""
        value = self.json(key)
        if not isinstance(value, list) or not all(_is_slot(each, bodies) for each in value):
            raise self.refusal(
                key, value, 'a list of (place, source, force, torque, turns with the body, until)'
            )
        return {
            (core, source): Slot(tuple(force), tuple(torque), turns, until)
            for core, source, force, torque, turns, until in value
        }

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


@contextmanager
def interpreting(path: Path) -> Iterator[None]:
    """
    Turn what a recorded run does not bear, deep inside, into one line that names the bag.

    Values are checked one by one where they are read; together they may still not fit, in ways
    that only show where they are used.
    """
    try:
        yield
    except (InvalidModel, SimulationDiverged, UserError, RunError):
        raise
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError) as error:
        problem = ' '.join(str(error).split())[:200] or type(error).__name__
        raise DamagedBag(
            f'{path}: damaged: what it says of its run does not fit together ({problem}); look at '
            f'the messages alone with: bag info, bag diff, view'
        ) from error


def _is_place(value: object, count: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < count


def _is_slot(value: object, bodies: int) -> bool:
    if not isinstance(value, list) or len(value) != 6:
        return False
    core, source, force, torque, turns, until = value
    return (
        _is_place(core, bodies)
        and isinstance(source, str)
        and _is_vector(force)
        and _is_vector(torque)
        and isinstance(turns, bool)
        and _is_place(until, max(FOREVER, MOST_TIMEOUT_NS) + 1)
    )


def _is_vector(value: object) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(x, int | float) and not isinstance(x, bool) for x in value)
        and all(abs(x) <= sys.float_info.max for x in value)
    )
