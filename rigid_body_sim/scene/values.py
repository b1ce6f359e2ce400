# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Values of a scene with their place in it, and the questions a reader may ask of them.

Every question either answers with a checked value or raises a UserError of one line:
`scenes/box.yaml: bodies[2].mass: got 'heavy'; a number [kg] is needed (line 14)`.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Collection
from types import TracebackType
from typing import Any, cast

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel, choose_from, path_text
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Quaternion, Vector
from rigid_body_sim.scene import numerals
from rigid_body_sim.scene.document import Document, Path


class Value:
    """
    One value of a scene and where it stands.

    above, key : the value that holds it, and where in that; None: it is the whole document
    """

    __slots__ = ('_above', '_key', 'content', 'document')

    def __init__(
        self, content: Any, document: Document, above: Value | None = None, key: str | int = ''
    ) -> None:
        self.content = content
        self.document = document
        self._above = above
        self._key = key

    @property
    def path(self) -> Path:
        """Where it stands in the document; asked by messages alone."""
        return () if self._above is None else (*self._above.path, self._key)

    def error(self, message: str) -> UserError:
        """Return the error that names this place."""
        place = path_text(self.path)
        where = f'{self.document.name}: {place}: ' if place else f'{self.document.name}: '
        line = self.document.line(self.path)
        return UserError(where + message + (f' (line {line})' if line else ''))

    def blamed(self, *otherwise: str) -> Blamed:
        """
        Give the refusals of the physics inside this block the name of this place.

        otherwise : path below it of what is to blame where a refusal does not say
        """
        return Blamed(self, otherwise)

    def below(self, path: Path) -> Value:
        """Follow a path as far as there are values."""
        place = self
        for key in path:
            is_there = (
                key in place.content
                if isinstance(place.content, dict)
                else isinstance(place.content, list) and key in range(len(place.content))
            )
            if not is_there:
                break
            place = Value(cast(Any, place.content)[key], place.document, place, key)
        return place

    def number(
        self,
        *,
        unit: str,
        minimum: float | None = None,
        maximum: float | None = None,
        positive: bool = False,
    ) -> float:
        """Return a finite float; the text of a decimal is a number, a truth value is not."""
        number = _number(self.content)
        wanted = f'a {"positive " if positive else ""}number [{unit}]'
        if number is None:
            raise self.error(
                f'got {shown(self.content)}; {wanted} is needed{numerals.cure(self.content)}'
            )
        if not math.isfinite(number):
            raise self.error(f'got {shown(self.content)}; a finite number [{unit}] is needed')
        if positive and number <= 0.0:
            raise self.error(f'got {number!r}; {wanted} is needed')
        if minimum is not None and maximum is not None and not minimum <= number <= maximum:
            raise self.error(
                f'got {number!r}; a number [{unit}] from {minimum!r} to {maximum!r} is needed'
            )
        if minimum is not None and number < minimum:
            raise self.error(
                f'got {number!r}; a number [{unit}] of at least {minimum!r} is needed'
            )
        if maximum is not None and number > maximum:
            raise self.error(f'got {number!r}; a number [{unit}] of at most {maximum!r} is needed')
        return number

    def whole(self, *, minimum: int, maximum: int) -> int:
        """Return a whole number; text that is a decimal is one, a truth value is not."""
        number = _number(self.content)
        if number is None or not (minimum <= number <= maximum and number == int(number)):
            raise self.error(
                f'got {shown(self.content)}; a whole number from {minimum} to {maximum} is needed'
                f'{numerals.cure(self.content)}'
            )
        return int(number)

    def numbers(self, count: int, *, unit: str) -> tuple[float, ...]:
        """Return a list of so many finite floats."""
        if not isinstance(self.content, list) or len(self.content) != count:
            raise self.error(
                f'got {shown(self.content)}; a list of {count} numbers [{unit}] is needed'
            )
        numbers = tuple(map(_number, self.content))
        for index, number in enumerate(numbers):
            if number is None or not math.isfinite(number):
                self._item(index).number(unit=unit)  # refuses, by name
        return cast(tuple[float, ...], numbers)

    def _item(self, index: int) -> Value:
        return Value(self.content[index], self.document, self, index)

    def vector(self, *, unit: str) -> Vector:
        """Return three finite floats."""
        x, y, z = self.numbers(3, unit=unit)
        return x, y, z

    def quaternion(self) -> Quaternion:
        """Return four finite floats xyzw, scaled to unit length."""
        with self.blamed():
            return rotation.normalised(self.numbers(4, unit='-'))

    def text(self, what: str) -> str:
        """Return a non-empty string."""
        if not isinstance(self.content, str) or not self.content:
            raise self.error(f'got {shown(self.content)}; {what} is needed, as text')
        return self.content

    def choice(self, known: Collection[str], *, what: str) -> str:
        """Return one of the known words."""
        if not isinstance(self.content, str) or self.content not in known:
            raise self.error(
                f'{what} {shown(self.content)} is unknown{choose_from(self.content, known)}'
            )
        return self.content

    def truth(self) -> bool:
        """Return true or false."""
        if not isinstance(self.content, bool):
            raise self.error(f'got {shown(self.content)}; true or false is needed')
        return self.content

    def items(self, what: str = 'a list') -> list[Value]:
        """Return the elements of a list."""
        if not isinstance(self.content, list):
            raise self.error(f'got {shown(self.content)}; {what} is needed')
        return [self._item(index) for index in range(len(self.content))]

    def need_mapping(self, what: str) -> None:
        """Refuse anything but a mapping; to be asked before its keys are."""
        if not isinstance(self.content, dict):
            raise self.error(f'got {shown(self.content)}; {what} is needed')

    def at(self, key: str, *, what: str) -> Value:
        """Return the value of a key that must be there."""
        value = self.find(key)
        if value is None:
            raise self.error(f'{key} is missing; {what} is needed')
        return value

    def find(self, key: str) -> Value | None:
        """Return the value of a key, or None where the key is absent or empty."""
        content = self.content.get(key)
        return None if content is None else Value(content, self.document, self, key)

    def need_known(self, known: Collection[str], *, ignored: str = '') -> None:
        """
        Refuse keys that nobody reads.

        ignored : how those begin that are a place for anchors; empty: none do
        """
        for key in self.content:
            if key not in known and not (ignored and str(key).startswith(ignored)):
                if not isinstance(key, str):
                    word = self.document.written(self.path, key) or shown(key)
                else:
                    word = key if key.isprintable() else shown(key)
                place = Value(None, self.document, self, word)
                raise place.error(f'unknown key{choose_from(word, known)}')


class Blamed:
    """A block whose refusals by the physics are told with a place in the scene."""

    __slots__ = ('_otherwise', '_place')

    def __init__(self, place: Value, otherwise: tuple[str, ...]) -> None:
        self._place = place
        self._otherwise = otherwise

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: object, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if isinstance(error, InvalidModel):
            place = self._place.below(error.at or self._otherwise)
            raise place.error(str(error)) from error


def shown(content: Any) -> str:
    """Return a short text of anything that can stand in a scene."""
    if content is None:
        return 'nothing'
    if isinstance(content, dict):
        return 'a mapping'
    try:
        return reprlib.repr(content)
    except ValueError:  # an integer of more digits than Python prints
        return 'a huge integer'


def _number(content: Any) -> float | None:
    if content.__class__ is float:
        return content
    if isinstance(content, bool):
        return None
    if isinstance(content, str):  # YAML 1.1 reads 1e-3 as text
        return numerals.decimal(content)
    if isinstance(content, int | float):
        try:
            return float(content)
        except OverflowError:
            return math.inf
    return None
