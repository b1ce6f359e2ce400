# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a key takes from run to run: values one after the other, or draws from a distribution.

    10:14:5            five values from 10 to 14, both included
    1, 2, 5            these values; [[0, 0, 1], [0, 1, 0]] where each is a list itself
    uniform(10, 14)    a draw for each run; also written uniform:10:14, which no shell interprets

A draw for run K is the beginning of a stream of its own, which seed, key and K name (Philox, a
counter-based generator): neither the number of runs nor their order, nor what else is varied,
changes it. Of a key that holds a list, every number is drawn by itself, unless the distribution
gives the whole list (`direction`, `rotation`).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import choose_from
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.scene import document, numerals

Draw = Callable[[np.random.Generator, list[Any], 'int | None'], Any]

MOST_POINTS = 1_000_000  # [-] of a grid on one key; more are a slip of the pen
NOT = ('nan', 'inf', 'infinity')  # words that are numbers, and no distributions
MOST_REJECTED = 10_000  # [-] draws in a row outside of the limits of a truncated distribution


@dataclass(frozen=True)
class Kind:
    """
    One distribution.

    arguments : their names
    draw      : (generator, arguments, length of the list or None) -> value
    check     : arguments -> what is wrong with them, or None
    length    : of the list that it always gives; None: as long as the key's
    optional  : how many arguments at the end may be left out
    any_value : whether arguments may be anything, and any number of them
    """

    arguments: tuple[str, ...]
    draw: Draw
    check: Callable[..., str | None] = lambda *_: None
    length: int | None = None
    optional: int = 0
    any_value: bool = False


@dataclass(frozen=True)
class Listed:
    """Values that runs take one after the other."""

    values: tuple[Any, ...]

    def __str__(self) -> str:
        return f'{list(self.values)}'


@dataclass(frozen=True)
class Distribution:
    """A draw for each run: `name` in KINDS, with its arguments."""

    name: str
    arguments: tuple[Any, ...]

    def __str__(self) -> str:
        return f'{self.name}({", ".join(map(str, self.arguments))})'

    def length(self, of_key: int | None) -> int | None:
        """Count the numbers of a draw; None: it is a value by itself."""
        kind = KINDS[self.name]
        if kind.length is not None or kind.any_value:
            return kind.length
        lists = {len(a) for a in self.arguments if isinstance(a, list)}
        return max(lists, default=of_key) if lists else of_key

    def draw(self, stream: np.random.Generator, length: int | None) -> Any:
        """Give a value: a float, a list of so many, or one of the choices."""
        value = KINDS[self.name].draw(stream, list(self.arguments), length)
        return value.tolist() if isinstance(value, np.ndarray) else value


Spec = Listed | Distribution


def stream_of(seed: int, key: str, run: int) -> np.random.Generator:
    """
    Give the stream of random numbers of one key in one run.

    key : as `scene_keys.path_text` writes it: one place, one stream, however it was called
    """
    words = np.frombuffer(hashlib.sha256(key.encode()).digest()[:16], dtype='<u4')
    root = np.random.SeedSequence(seed, spawn_key=(run, *map(int, words)))
    return np.random.Generator(np.random.Philox(root))


def spec_of(given: Any, *, key: str) -> Spec:
    """Read what was given for a key: text as on the command line, or values of Python."""
    if isinstance(given, Listed | Distribution):
        return given
    if isinstance(given, str):
        return _parsed(given, key)
    if isinstance(given, np.ndarray):
        given = given.tolist()
    if isinstance(given, range | tuple):
        given = list(given)
    if isinstance(given, Mapping) or not isinstance(given, list):
        given = [given]
    return _listed(given, key)


def _listed(values: Sequence[Any], key: str) -> Listed:
    if not values:
        raise UserError(f'vary {key}: got an empty list; at least one value is needed')
    return Listed(tuple(plain(value, key) for value in values))


def plain(value: Any, key: str) -> Any:
    """Turn a value into what a scene file can hold."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, bool | int | float | str) or value is None:
        return value
    if isinstance(value, list | tuple):
        return [plain(item, key) for item in value]
    if isinstance(value, Mapping):
        return {str(name): plain(item, key) for name, item in value.items()}
    raise UserError(
        f'vary {key}: got {shown(value)}; allowed: numbers, texts, lists and mappings as in a '
        f'scene, or a distribution: {", ".join(KINDS)}'
    )


def _parsed(text: str, key: str) -> Spec:
    text = text.strip()
    name, bracket, rest = text.partition('(')
    if bracket and name.strip().isidentifier():
        if not rest.endswith(')'):
            raise UserError(f'vary {key}: {text!r} has no closing bracket')
        return _distribution(name.strip(), _yaml_list(rest[:-1], text, key), key)
    parts = text.split(':')
    if parts[0] in KINDS or (len(parts) > 1 and parts[0].isidentifier() and parts[0] not in NOT):
        return _distribution(parts[0], _yaml_list(', '.join(parts[1:]), text, key), key)
    if len(parts) == 3 and not any(letter in text for letter in '{["\''):
        return _grid(*parts, text=text, key=key)
    if text.startswith('['):
        with suppress(UserError):  # [0, 0, 1], [0, 0, 2] is no list, but the inside of one
            values = _read(text, name=f'vary {key}')
            if isinstance(values, list):
                return _listed(values, key)
    return _listed(_yaml_list(text, text, key), key)


def _yaml_list(inside: str, text: str, key: str) -> list[Any]:
    if not inside.strip():
        return []
    try:
        values = _read(f'[{inside}]', name='')
    except UserError:
        raise UserError(
            f'vary {key}: got {text!r}; allowed: a list such as 1,2,5 or [0,0,1],[0,0,2], a grid '
            'FIRST:LAST:POINTS, or a draw such as uniform:LOW:HIGH'
        ) from None
    return values if isinstance(values, list) else [values]


def _read(text: str, *, name: str) -> Any:
    """Read YAML; what a scene takes for a number is one: 1e-3, which YAML 1.1 calls a text."""
    return _with_numbers(document.read(text.encode(), name=name).content)


def _with_numbers(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_numbers(item) for item in value]
    if isinstance(value, dict):
        return {key: _with_numbers(item) for key, item in value.items()}
    number = numerals.decimal(value) if isinstance(value, str) else None
    return value if number is None else number


def _grid(low: str, high: str, count: str, *, text: str, key: str) -> Listed:
    try:
        first, last, points = float(low), float(high), int(count)
    except ValueError:
        raise UserError(
            f'vary {key}: got {text!r}; a grid is FIRST:LAST:POINTS, two numbers and a whole one'
        ) from None
    if not (math.isfinite(first) and math.isfinite(last)):
        raise UserError(f'vary {key}: got {text!r}; the ends of a grid must be finite numbers')
    if not 1 <= points <= MOST_POINTS:
        raise UserError(f'vary {key}: got {text!r}; a grid has 1 to {MOST_POINTS} points')
    steps = max(1, points - 1)
    inner = [first + (last - first) * (i / steps) for i in range(points)]
    return Listed((*inner[:-1], last) if points > 1 else (first,))


def _distribution(name: str, arguments: Sequence[Any], key: str) -> Distribution:
    """Check a distribution; UserError."""
    if name not in KINDS:
        raise UserError(f'vary {key}: distribution {name!r} is unknown{choose_from(name, KINDS)}')
    kind, wanted = KINDS[name], f'{name}({", ".join(KINDS[name].arguments)})'
    if kind.any_value:
        if not arguments:
            raise UserError(f'vary {key}: {name}() has nothing to choose from')
        return Distribution(name, tuple(plain(value, key) for value in arguments))
    fewest = len(kind.arguments) - kind.optional
    if not fewest <= len(arguments) <= len(kind.arguments):
        raise UserError(
            f'vary {key}: {name} got {len(arguments)} arguments; it is written {wanted}'
        )
    numbers = tuple(_numbers(value, f'vary {key}: {wanted}') for value in arguments)
    lengths = {len(value) for value in numbers if isinstance(value, list)}
    if len(lengths) > 1 or (kind.length is not None and lengths):
        raise UserError(f'vary {key}: {wanted}: its lists differ in length, or it takes none')
    wrong = kind.check(*map(np.asarray, numbers))
    if wrong is not None:
        given = ', '.join(map(str, numbers))
        raise UserError(f'vary {key}: got {name}({given}); {wrong}')
    return Distribution(name, numbers)


def _numbers(value: Any, where: str) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_number(item, where) for item in value]
    return _number(value, where)


def _number(value: Any, where: str) -> float:
    try:
        if isinstance(value, bool):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise UserError(f'{where}: got {shown(value)}; a finite number is needed')
    return number


def _ascending(low: Any, high: Any) -> str | None:
    return None if np.all(low <= high) else 'the first number must not be above the second'


def _positive_range(low: Any, high: Any) -> str | None:
    return _ascending(low, high) if np.all(low > 0) else 'both numbers must be positive'


def _deviation(_mean: Any, deviation: Any) -> str | None:
    return None if np.all(deviation >= 0) else 'the deviation must not be negative'


def _truncation(mean: Any, deviation: Any, low: Any, high: Any) -> str | None:
    if not (np.all(deviation > 0) and np.all(low < high)):
        return 'the deviation must be positive, and the lowest value below the highest'
    outside = np.maximum(low - mean, mean - high) / deviation
    return (
        None
        if np.all(outside <= 3.0)
        else ('the mean lies more than three deviations outside of the limits; move one of them')
    )


def _whole_range(low: Any, high: Any) -> str | None:
    whole = np.all(low == np.floor(low)) and np.all(high == np.floor(high))
    small = np.all(np.abs(low) < 2**53) and np.all(np.abs(high) < 2**53)
    return _ascending(low, high) if whole and small else 'two whole numbers below 2^53 are needed'


def _not_negative(length: Any = 1.0) -> str | None:
    return None if np.all(length >= 0) else 'the length must not be negative'


def _uniform(stream: np.random.Generator, arguments: list[Any], length: int | None) -> Any:
    low, high = map(np.asarray, arguments)
    return _clipped(low + (high - low) * stream.random(length), low, high)


def _loguniform(stream: np.random.Generator, arguments: list[Any], length: int | None) -> Any:
    low, high = map(np.asarray, arguments)
    exponent = np.log(low) + (np.log(high) - np.log(low)) * stream.random(length)
    return _clipped(np.exp(exponent), low, high)


def _clipped(values: Any, low: Any, high: Any) -> Any:
    values = np.clip(values, low, high)
    return values if np.ndim(values) else float(values)


def _normal(stream: np.random.Generator, arguments: list[Any], length: int | None) -> Any:
    mean, deviation = map(np.asarray, arguments)
    values = mean + deviation * stream.standard_normal(length)
    return values if np.ndim(values) else float(values)


def _truncated(stream: np.random.Generator, arguments: list[Any], length: int | None) -> Any:
    """Draw again what lies outside, number by number."""
    size = 1 if length is None else length
    mean, deviation, low, high = (np.broadcast_to(a, size) for a in arguments)
    values = np.zeros(size)
    for i in range(size):
        for _ in range(MOST_REJECTED):
            values[i] = mean[i] + deviation[i] * stream.standard_normal()
            if low[i] <= values[i] <= high[i]:
                break
        else:
            raise UserError(f'truncated_normal: no draw lies in [{low[i]:g}, {high[i]:g}]')
    return values if length is not None else float(values[0])


def _integers(stream: np.random.Generator, arguments: list[Any], length: int | None) -> Any:
    low, high = (np.asarray(a, dtype=np.int64) for a in arguments)
    values = stream.integers(low, high, size=length, endpoint=True)
    return values if np.ndim(values) else int(values)


def _choice(stream: np.random.Generator, arguments: list[Any], _length: int | None) -> Any:
    return arguments[int(stream.integers(len(arguments)))]


def _direction(stream: np.random.Generator, arguments: list[Any], _length: int | None) -> Any:
    return (arguments[0] if arguments else 1.0) * _unit(stream, 3)


def _rotation(stream: np.random.Generator, _arguments: list[Any], _length: int | None) -> Any:
    return _unit(stream, 4)


def _unit(stream: np.random.Generator, size: int) -> Any:
    """Draw a point of the unit sphere: the direction of a normal draw is uniform on it."""
    while True:
        values = stream.standard_normal(size)
        norm = math.sqrt(sum(x * x for x in values.tolist()))
        if norm > 0.1:  # shorter ones lose digits; their directions are as good as any others'
            return values / norm


KINDS: dict[str, Kind] = {
    'uniform': Kind(('LOW', 'HIGH'), _uniform, _ascending),
    'normal': Kind(('MEAN', 'DEVIATION'), _normal, _deviation),
    'loguniform': Kind(('LOW', 'HIGH'), _loguniform, _positive_range),
    'truncated_normal': Kind(('MEAN', 'DEVIATION', 'LOW', 'HIGH'), _truncated, _truncation),
    'integers': Kind(('LOW', 'HIGH'), _integers, _whole_range),
    'choice': Kind(('VALUE', '…'), _choice, any_value=True),
    'direction': Kind(('LENGTH',), _direction, _not_negative, length=3, optional=1),
    'rotation': Kind((), _rotation, length=4),
}


def uniform(low: Any, high: Any) -> Distribution:
    """Evenly between two numbers; lists give each number of a list its own limits."""
    return _distribution('uniform', (low, high), 'uniform')


def normal(mean: Any, deviation: Any) -> Distribution:
    """Gauss's distribution, by its mean and standard deviation."""
    return _distribution('normal', (mean, deviation), 'normal')


def loguniform(low: Any, high: Any) -> Distribution:
    """Evenly in the logarithm between two positive numbers."""
    return _distribution('loguniform', (low, high), 'loguniform')


def truncated_normal(mean: Any, deviation: Any, low: Any, high: Any) -> Distribution:
    """Gauss's distribution within limits: a mass that must not be negative."""
    return _distribution('truncated_normal', (mean, deviation, low, high), 'truncated_normal')


def integers(low: int, high: int) -> Distribution:
    """Whole numbers from low to high, both included."""
    return _distribution('integers', (low, high), 'integers')


def choice(*values: Any) -> Distribution:
    """One of the values, each as likely."""
    return _distribution('choice', values, 'choice')


def direction(length: float = 1.0) -> Distribution:
    """Vectors of one length, evenly in all directions."""
    return _distribution('direction', (length,), 'direction')


def random_rotation() -> Distribution:
    """Orientations (quaternions xyzw), evenly over all rotations."""
    return _distribution('rotation', (), 'rotation')
