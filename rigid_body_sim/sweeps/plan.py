# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a sweep does, as a value: a scene, what varies in it, how many runs.

Run K is made of (seed, K) alone.

Lists and grids of several keys are gone through in full, the last key fastest; after the last
point they begin anew. Distributions are drawn for every run.
"""

from __future__ import annotations

import hashlib
import json
import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from rigid_body_sim import __version__
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import choose_from
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording.new_output import check_text
from rigid_body_sim.scene import document, load_scene
from rigid_body_sim.scene.experiment import ReadBodies, scene_of_content
from rigid_body_sim.scene.files import Files
from rigid_body_sim.scene.writing import with_text
from rigid_body_sim.sweeps import GROUPS, scene_keys
from rigid_body_sim.sweeps.distributions import Distribution, Listed, Spec, spec_of, stream_of

LOOKS = 100  # [-] at extremes and energy, over a run, unless told otherwise
MOST_RUNS = 10**12  # [-] more have no end
LONGEST = 2.0**31  # [s], as of recordings
TRIED = 3  # first runs from whose refusals an unknown key is known before any work


@cache
def code_digest() -> str:
    """Tell the code that decides the bits of a run from other such code."""
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    for room in ('physics', 'scene', 'sweeps'):
        for path in sorted((package / room).rglob('*.py')):
            digest.update(path.relative_to(package).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@dataclass(frozen=True)
class Axis:
    """
    One key that varies.

    key    : as it was written, and as its columns are called
    path   : its place in the scene
    spec   : what it takes
    length : of the list that a draw gives; None: it is one value
    """

    key: str
    path: document.Path
    spec: Spec
    length: int | None = None

    def value(self, run: int, point: int, seed: int) -> Any:
        """Give the value in one run; point: its place in a list."""
        if isinstance(self.spec, Listed):
            return self.spec.values[point]
        stream = stream_of(seed, scene_keys.path_text(self.path), run)
        return self.spec.draw(stream, self.length)

    @cached_property
    def columns(self) -> dict[str, str]:
        """Name the columns of the key, and what they hold: 'float', 'int', 'bool' or 'text'."""
        if self.length is not None:
            kind = 'int' if getattr(self.spec, 'name', '') == 'integers' else 'float'
            return {f'{self.key}[{i}]': kind for i in range(self.length)}
        if isinstance(self.spec, Distribution) and self.spec.name != 'choice':
            return {self.key: 'int' if self.spec.name == 'integers' else 'float'}
        values = _given(self.spec)
        lengths = {len(value) if isinstance(value, list) else None for value in values}
        kinds = {_kind(x) for v in values for x in (v if isinstance(v, list) else [v])}
        kind = kinds.pop() if len(kinds) == 1 else 'float' if kinds == {'int', 'float'} else 'text'
        length = lengths.pop() if len(lengths) == 1 else 0
        if length and kind != 'text':
            return {f'{self.key}[{i}]': kind for i in range(length)}
        return {self.key: kind if length is None else 'text'}

    def columns_with(self, value: Any) -> dict[str, Any]:
        """Give the columns of the key for one of its values; None: it was not drawn."""
        names = list(self.columns)
        if value is None:
            return dict.fromkeys(names)
        if names == [self.key]:
            as_text = self.columns[self.key] == 'text' and not isinstance(value, str)
            return {self.key: json.dumps(value, ensure_ascii=False) if as_text else value}
        return dict(zip(names, value, strict=True))


def _kind(value: Any) -> str:
    if isinstance(value, bool):
        return 'bool'
    if isinstance(value, int):
        return 'int' if abs(value) < 2**63 else 'text'
    return 'float' if isinstance(value, float) else 'text'


@dataclass(frozen=True)
class Sweep:
    """
    A sweep.

    name     : what messages call the text of the scene
    title    : of the scene
    content  : of the scene, as its text holds it
    files    : that it names: name -> bytes
    axes     : what varies
    runs     : how many runs
    seed     : of all draws
    duration : [s] of each run
    every    : [s] between looks at extremes and energy; None: a hundredth of the duration
    keep     : of GROUPS
    bodies   : names of those with columns of their own; (): all that move
    code     : digest of the physics that is to run it
    """

    name: str
    title: str
    content: Mapping[str, Any]
    files: Mapping[str, bytes]
    axes: tuple[Axis, ...]
    runs: int
    seed: int = 0
    duration: float = 10.0
    every: float | None = None
    keep: tuple[str, ...] = GROUPS
    bodies: tuple[str, ...] = ()
    code: str = field(default_factory=code_digest)

    @property
    def points(self) -> int:
        """Count the combinations of all lists and grids."""
        return math.prod(len(a.spec.values) for a in self.axes if isinstance(a.spec, Listed))

    def values(self, run: int) -> list[Any]:
        """Give what the axes hold in one run."""
        rest, found = run % self.points, []
        for axis in reversed(self.axes):
            point = 0
            if isinstance(axis.spec, Listed):
                rest, point = divmod(rest, len(axis.spec.values))
            found.append(axis.value(run, point, self.seed))
        return found[::-1]

    def varied_columns(self, values: Sequence[Any]) -> dict[str, Any]:
        """Give the columns of all axes."""
        found: dict[str, Any] = {}
        for axis, value in zip(self.axes, values, strict=True):
            found |= axis.columns_with(value)
        return found

    def content_with(self, values: Sequence[Any]) -> Any:
        """Give the content of the scene with these values of the axes."""
        content: Any = self.content
        for axis, value in zip(self.axes, values, strict=True):
            content = scene_keys.replaced(content, axis.path, value)
        return content

    def scene(self, values: Sequence[Any]) -> Scene:
        """Read the scene with these values; UserError for what is none."""
        return self.reader()(values)

    def reader(self) -> Callable[[Sequence[Any]], Scene]:
        """Give a reader of many scenes, which reads once what does not vary."""
        files, bodies = self.open_files(), ReadBodies()
        bodies.remember(self.content['bodies'], self.name, files)

        def read(values: Sequence[Any]) -> Scene:
            content = self.content_with(values)
            return scene_of_content(content, name=self.name, files=files, bodies=bodies)

        return read

    def open_files(self) -> Files:
        """Give the files of the scene to its reader."""
        return Files(folder=Path(), given=self.files)

    def text(self, run: int) -> bytes:
        """Write the scene of one run as YAML."""
        return document.write(self.content_with(self.values(run)))

    def facts(self) -> dict[str, Any]:
        """Say what a table of this sweep stands for; two sweeps of the same facts are the same."""
        return {
            'package_version': __version__,
            'physics': self.code,
            'scene': self.name,
            'scene_sha256': hashlib.sha256(document.write(self.content)).hexdigest(),
            'files': {
                name: hashlib.sha256(data).hexdigest() for name, data in sorted(self.files.items())
            },
            'vary': {axis.key: str(axis.spec) for axis in self.axes},
            'runs': self.runs,
            'seed': self.seed,
            'duration': self.duration,
            'every': self.every,
            'keep': list(self.keep),
            'bodies': list(self.bodies),
        }

    def facts_text(self) -> str:
        """Write the facts."""
        return json.dumps(self.facts(), indent=1, ensure_ascii=False)


def plan_sweep(
    source: Any,
    vary: Mapping[str, Any],
    *,
    runs: int | None = None,
    seed: int = 0,
    duration: float = 10.0,
    every: float | None = None,
    keep: Sequence[str] = GROUPS,
    bodies: Sequence[str] = (),
) -> Sweep:
    """
    Check what a sweep is asked for; arguments as `ensemble.sweep` takes them.

    Raises UserError, one line with place and cure; InvalidModel for records that no scene file can
    say.
    """
    scene = with_text(source) if isinstance(source, Scene) else load_scene(source)
    check_text(scene.origin.name, what='the path of a scene that is swept')  # the table holds it
    content = document.read(scene.source, name=scene.origin.name).content
    axes = _axes(vary, content)
    points = math.prod(len(a.spec.values) for a in axes if isinstance(a.spec, Listed))
    if runs is None and points == 1 and any(isinstance(a.spec, Distribution) for a in axes):
        raise UserError('sweep: say how many runs to draw: runs=1000, on the command line --runs')
    sweep = Sweep(
        name=scene.origin.name,
        title=scene.name,
        content=content,
        files=_files(source, scene, content, axes),
        axes=axes,
        runs=points if runs is None else _whole(runs, 'runs', least=1, most=MOST_RUNS),
        seed=_whole(seed, 'seed', least=0, most=2**128),
        duration=_seconds(duration, 'duration'),
        every=None if every is None else _seconds(every, 'every'),
        keep=_keep(keep),
        bodies=_bodies(bodies, scene),
    )
    _refuse_unknown_keys(sweep)
    return sweep


def _axes(vary: Mapping[str, Any], content: Mapping[str, Any]) -> tuple[Axis, ...]:
    if not isinstance(vary, Mapping):
        raise UserError(
            f'vary: got {shown(vary)}; a mapping is needed: '
            "{'satellite.mass': uniform(10, 14), 'dt': [0.001, 0.01]}"
        )
    axes: list[Axis] = []
    for key, given in vary.items():
        if not isinstance(key, str):
            raise UserError(f'vary: the key {shown(key)} is no text, as satellite.mass is')
        path = scene_keys.parse(key, content)
        for other in axes:
            _refuse_overlap(key, path, other)
        spec = spec_of(given, key=key)
        held = scene_keys.value_at(content, path)
        axes.append(Axis(key, path, spec, _length(key, spec, held)))
    return tuple(axes)


def _refuse_overlap(key: str, path: document.Path, other: Axis) -> None:
    """Refuse two keys of which one is the other, holds it, or stands in its place."""
    shorter = min(len(path), len(other.path))
    if path[:shorter] == other.path[:shorter]:
        how = 'are the same place' if path == other.path else 'lie inside of each other'
        raise UserError(f'vary: {other.key} and {key} {how} in the scene; vary one of them')
    stand_in = scene_keys.ALTERNATIVES.get(str(path[-1]))
    if path[:-1] == other.path[: len(path) - 1] and stand_in == other.path[len(path) - 1]:
        raise UserError(f'vary: {other.key} and {key} cannot both be given; vary one of them')


def _length(key: str, spec: Spec, held: Any) -> int | None:
    """Tell how many numbers a draw gives; UserError where one value is offered for a list."""
    numbers = isinstance(held, list) and all(
        isinstance(x, int | float) and not isinstance(x, bool) for x in held
    )
    of_key = len(held) if numbers and held else None
    if isinstance(spec, Distribution):
        return spec.length(of_key)
    single = all(isinstance(v, int | float) for v in spec.values)
    if of_key is not None and single:
        raise UserError(
            f'vary {key}: holds a list of {of_key} numbers; give a list of lists such as '
            f'[{held}], or vary one of its numbers: {key}[{of_key - 1}]'
        )
    return None


def _files(
    source: Any, scene: Scene, content: Mapping[str, Any], axes: tuple[Axis, ...]
) -> Mapping[str, bytes]:
    """Read the files that the scene names, also those that varied values name."""
    found = dict(scene.files)
    if isinstance(source, Scene) or not any(_names_a_file(axis) for axis in axes):
        return found
    folder = Path(scene.origin.name).parent if scene.origin.has_lines else Path()
    for axis in axes:
        for value in _given(axis.spec) if _names_a_file(axis) else ():
            files = Files(folder=folder, given=None)
            changed = scene_keys.replaced(content, axis.path, value)
            with suppress(UserError):  # for the row of that run
                scene_of_content(changed, name=scene.origin.name, files=files)
            found |= files.used
    return found


def _names_a_file(axis: Axis) -> bool:
    """Whether a value of an axis may name a file."""
    given = _given(axis.spec)
    return axis.path[0] == 'bodies' and any(isinstance(v, str | dict) for v in given)


def _given(spec: Spec) -> tuple[Any, ...]:
    """Give the values of a list, or the arguments of a distribution."""
    return spec.values if isinstance(spec, Listed) else spec.arguments


def _whole(value: Any, what: str, *, least: int, most: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if isinstance(value, bool) or not least <= number <= most:
        raise UserError(
            f'sweep: {what} {shown(value)}; allowed: a whole number from {least} to {most}'
        )
    return number


def _seconds(value: Any, what: str) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not 0.0 < value < LONGEST:
        raise UserError(
            f'sweep: {what} {shown(value)} s; allowed: a positive number of seconds below 2^31'
        )
    return float(value)


def _names(what: str, given: Any) -> tuple[str, ...]:
    """Return a name alone as a list of one; UserError for what is no list."""
    if isinstance(given, str):
        return (given,)
    if not isinstance(given, Iterable):
        raise UserError(f'sweep: {what}: got {shown(given)}; a list of names is needed')
    named = tuple(given)
    for name in named:
        if not isinstance(name, str):
            raise UserError(f'sweep: {what}: got {shown(name)}; a name is needed, as text')
    return named


def _keep(keep: Sequence[str]) -> tuple[str, ...]:
    named = _names('keep', keep)
    for name in named:
        if name not in GROUPS:
            raise UserError(f'sweep: keep {shown(name)}; allowed: {", ".join(GROUPS)}')
    return tuple(name for name in GROUPS if name in named)


def _bodies(bodies: Sequence[str], scene: Scene) -> tuple[str, ...]:
    named = _names('bodies', bodies)
    known = [body.name for body in scene.bodies]
    for name in named:
        if name not in known:
            raise UserError(f'sweep: bodies: {shown(name)} is unknown{choose_from(name, known)}')
    return named


def _refuse_unknown_keys(sweep: Sweep) -> None:
    """
    Refuse a key that the reader of scenes does not know: no run could be made.

    What it says of values is for the rows of the runs: others may have better ones.
    """
    for axis_number, axis in enumerate(sweep.axes):
        for run in range(min(TRIED, sweep.runs)):
            alone = replace(sweep, axes=(axis,))
            value = sweep.values(run)[axis_number]
            try:
                alone.scene([value])
            except UserError as error:
                place = f'{scene_keys.path_text(axis.path)}: unknown key'
                if place in str(error):
                    raise UserError(f'vary {axis.key}: {error}') from None
