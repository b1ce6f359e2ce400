# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a record or a command calls a number: a finite int or float of Python or numpy.

Neither text, nor a truth value, nor a whole number beyond the floats is one.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from itertools import chain
from typing import Any, TypeGuard

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel

NUMBERS = (int, float, np.integer, np.floating)
NONE = (bool, np.timedelta64)  # which are of those classes, and no numbers
USUAL = frozenset((float, np.float64))  # what they are as a rule
OF_COMMANDS = USUAL | {int, np.int64, np.float32}  # and as who writes a controller gives them
LISTS = frozenset((list, tuple))
FLOATS = np.dtype(np.float64)
_Array = np.ndarray
SixFloats = tuple[float, float, float, float, float, float]
REAL = 'iuf'  # kinds of dtypes: whole, unsigned, floating
COUNTS = {3: 'three', 4: 'four'}


def is_list(value: object) -> TypeGuard[Sequence[Any]]:
    """Tell whether something is a list, a tuple, or an array with rows."""
    return isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim > 0)


def is_number(value: object) -> bool:
    """Tell whether something is a finite number."""
    if type(value) is not float:
        if isinstance(value, NONE) or not isinstance(value, NUMBERS):
            return False
        try:
            value = float(value)
        except OverflowError:  # an integer beyond the floats
            return False
    return math.isfinite(value)


def number(
    value: Any, *, unit: str, minimum: float | None = None, maximum: float | None = None
) -> float:
    """
    Return a finite number as a float; InvalidModel for anything else.

    unit             : for the message
    minimum, maximum : limits, themselves allowed
    """
    is_right = (
        is_number(value)
        and (minimum is None or value >= minimum)
        and (maximum is None or value <= maximum)
    )
    if not is_right:
        least = '' if minimum is None else f', at least {minimum!r}'
        most = '' if maximum is None else f', at most {maximum!r}'
        raise InvalidModel(f'got {shown(value)}; a finite number [{unit}]{least}{most} is needed')
    return float(value)


def numbers(value: Any, count: int, *, unit: str) -> tuple[float, ...]:
    """Return so many finite numbers as floats; InvalidModel for anything else."""
    kind = value.__class__
    if kind is np.ndarray and value.shape == (count,) and value.dtype == np.float64:
        made = tuple(value.tolist())
    elif kind in (tuple, list) and len(value) == count and USUAL.issuperset(map(type, value)):
        made = tuple(map(float, value))
    else:
        made = ()
    if made and all(map(math.isfinite, made)):
        return made
    items = tuple(value) if is_list(value) else ()
    if len(items) != count or not all(map(is_number, items)):
        raise InvalidModel(
            f'got {shown(value)}; {COUNTS.get(count, count)} finite numbers [{unit}] are needed'
        )
    return tuple(map(float, items))


def two_vectors(first: Any, second: Any) -> SixFloats | None:
    """
    Return six finite floats of two tuples, lists or arrays as a controller gives them; None for
    anything else, which may still be numbers: see `numbers`.
    """
    try:
        kind = first.__class__
        if kind is _Array:
            a, b, c = first.tolist()
        elif kind is tuple or kind is list:
            a, b, c = first
        else:
            return None
        kind = second.__class__
        if kind is _Array:
            x, y, z = second.tolist()
        elif kind is tuple or kind is list:
            x, y, z = second
        else:
            return None
    except (TypeError, ValueError):  # an array or a list of another shape
        return None
    try:
        if not (a.__class__ is b.__class__ is c.__class__ is float):
            known = OF_COMMANDS
            if not (a.__class__ in known and b.__class__ in known and c.__class__ in known):
                return None
            a, b, c = float(a), float(b), float(c)
        if not (x.__class__ is y.__class__ is z.__class__ is float):
            known = OF_COMMANDS
            if not (x.__class__ in known and y.__class__ in known and z.__class__ in known):
                return None
            x, y, z = float(x), float(y), float(z)
    except OverflowError:  # a whole number beyond the floats
        return None
    total = a + b + c + x + y + z
    return (a, b, c, x, y, z) if total - total == 0.0 else None  # no infinity, and a number


def in_doubles(values: np.ndarray) -> np.ndarray:
    """Return an array of real numbers in 64 bits; of anything else, as it is."""
    return values.astype(FLOATS) if values.dtype.kind in REAL else values


def array_of_numbers(values: Any) -> np.ndarray | None:
    """
    Return an array of floats, finite or not, of rows of numbers or of what numpy takes for one;
    None where something in it is no number: a text, a truth value, a duration, what is masked, a
    whole number beyond the floats, rows of different lengths.
    """
    try:
        rows = _usual_rows(values)
        if rows is None and _are_numbers(values):
            rows = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RecursionError):
        return None
    return rows


def _usual_rows(values: Any) -> np.ndarray | None:
    """
    Return an array of rows of one length as who writes a controller gives them; None for anything
    else. They are judged all at once: one by one that costs five times as much as numpy needs.
    """
    if values.__class__ not in LISTS or not LISTS.issuperset(map(type, values)):
        return None
    lengths = set(map(len, values))
    flat = list(chain.from_iterable(values))
    if len(lengths) != 1 or not OF_COMMANDS.issuperset(map(type, flat)):
        return None
    return np.fromiter(flat, np.float64, len(flat)).reshape(len(values), *lengths)


def _are_numbers(values: Any) -> bool:
    kind = values.__class__
    if kind is list or kind is tuple:
        kinds = set(map(type, values))
        if kinds == {_Array}:
            kinds = {array.dtype.type for array in values}
        return OF_COMMANDS.issuperset(kinds) or all(map(_are_numbers, values))
    if isinstance(values, NUMBERS):
        return not isinstance(values, NONE)
    if kind is not np.ndarray and np.any(getattr(values, 'mask', False)):
        return False
    array = np.asarray(values)
    return array.dtype.kind in 'iuf' or (
        array.dtype.kind == 'O' and array.ndim > 0 and _are_numbers(array.tolist())
    )


def checked_vector(said: str, name: str, values: Any) -> tuple[float, float, float]:
    """Return three finite numbers; InvalidModel, which begins with `said`, for anything else."""
    try:
        x, y, z = numbers(values, 3, unit='-')
    except InvalidModel:
        raise InvalidModel(
            f'{said}: {name} {shown(values)}; allowed: three finite numbers'
        ) from None
    return (x, y, z)


def exact_sum(values: Sequence[float]) -> float:
    """Sum with one rounding; sums beyond the numbers, and infinities, as plain addition has it."""
    try:
        return math.fsum(values)
    except (OverflowError, ValueError):  # on the way; or infinities of both signs
        return float(sum(values))


def shown(value: object) -> str:
    """Write anything in one short line."""
    try:
        text = reprlib.repr(value)
    except Exception:  # whatever a foreign repr raises; an integer of more digits than are printed
        text = f'a {type(value).__name__}'
    return ' '.join(text.split())
