# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A bag as a run: the poses, twists and applied wrenches that it holds, as arrays.

Rows are the instants at which every body has a pose and a twist; numbers are those of the
messages. Rates in body axes, momenta and energies are computed from them with the scene of the
bag. A bag without twists (of another recorder) has NaN in their place.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.analysis.recorded_impacts import read_impacts
from rigid_body_sim.analysis.recorded_states import complete
from rigid_body_sim.analysis.scene_begin import scene_began
from rigid_body_sim.errors import UserError
from rigid_body_sim.library.run import WHOLE, Run
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state import snapshot
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.columns import Columns, Progress, need_time_forward, read_columns
from rigid_body_sim.recording.every_body import with_every_body
from rigid_body_sim.recording.paths import path_of
from rigid_body_sim.recording.record_values import RecordValues
from rigid_body_sim.runs.manifest_values import MOST_NS
from rigid_body_sim.runs.reading_guard import interpreting
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import SCENE_FILE
from rigid_body_sim.scene import load_scene

Array = NDArray[np.float64]
LEAVES = {
    'pose': cdr.PoseStamped.TYPE,
    'twist': cdr.TwistStamped.TYPE,
    'applied_wrench': cdr.WrenchStamped.TYPE,
}
WHOLE_ENDS = (WHOLE, 'stop_time', 'reset', 'replayed', 'signal')  # of a node a signal is the end


def open_bag(path: str | os.PathLike[str], *, progress: Progress | None = None) -> Run:
    """
    Read a bag of this package as arrays.

    path     : of the bag or of its .mcap file
    progress : told how many messages were read since it was told last

    Raises UserError for what is no bag, or one without poses, and RunError for a damaged one; a
    recording that was cut off is restored by `bag recover` first.
    """
    place = path_of(path, said='open_bag')
    with interpreting(place):
        return _read(place, progress or (lambda _count: None))


def _read(path: Path, progress: Progress) -> Run:
    whole = Bag(path)
    bag = with_every_body(whole)
    scene = _scene(whole)
    topics = _topics(bag, scene)
    if not topics:
        raise UserError(
            f'{path}: holds no poses; expected messages of {cdr.PoseStamped.TYPE} on topics that '
            'end in /pose'
        )
    wanted = [name for of_body in topics.values() for name in of_body.values()]
    columns = read_columns(bag, wanted, progress=progress)
    names = tuple(topics)
    for topic in wanted:
        found = columns[topic]
        need_time_forward(found.stamp, f'{path}: {topic}', reordered=found.reordered)
    poses = [columns[topics[name]['pose']] for name in names]
    twists = [
        columns[topics[name]['twist']] if 'twist' in topics[name] else None for name in names
    ]
    stamps = _common([of.stamp for of in (*poses, *twists) if of is not None])
    if not len(stamps):
        raise UserError(f'{path}: holds no instant at which every body has a pose and a twist')
    values = np.full((len(stamps), len(names), snapshot.COLUMNS), np.nan)
    for i, (pose, twist) in enumerate(zip(poses, twists, strict=True)):
        values[:, i, snapshot.POSITION : snapshot.VELOCITY] = _at(pose, stamps)
        if twist is not None:
            rates = slice(snapshot.VELOCITY, snapshot.ANGULAR_VELOCITY_BODY)
            values[:, i, rates] = _at(twist, stamps)
    time: Array = np.divide(stamps, 1e9)
    ours = scene is not None and names == tuple(body.name for body in scene.bodies)
    masses = None
    if ours and scene is not None:
        masses = complete(scene, values, np.divide(stamps - scene_began(whole, scene), 1e9))
    else:
        spins_in_body_axes(values)
    return Run(
        names=names,
        time=time,
        scene=scene if ours else None,
        path=str(path),
        impacts=read_impacts(whole),
        _values=values,
        _wrench=_wrenches(whole, [topics[n] for n in names], columns, stamps),
        _masses=masses,
        **_told(whole, float(time[-1])),
    )


def spins_in_body_axes(values: Array) -> None:
    """Turn angular velocities into body axes where no scene says more."""
    q = values[..., snapshot.ORIENTATION : snapshot.VELOCITY]
    w = values[..., snapshot.ANGULAR_VELOCITY : snapshot.ANGULAR_VELOCITY_BODY]
    with np.errstate(all='ignore'):
        values[..., snapshot.ANGULAR_VELOCITY_BODY : snapshot.MOMENTUM] = rotation.rotate_back(
            q, w
        )


def _scene(bag: Bag) -> Scene | None:
    """Read the scene that a bag holds."""
    files = dict(bag.attachments)
    source = files.pop(SCENE_FILE, None)
    if source is None:
        return None
    title = bag.manifest.get('scene', 'scene')
    return load_scene(source, files=files, title=f'{title}.yaml')


def _topics(bag: Bag, scene: Scene | None) -> dict[str, dict[str, str]]:
    """Find the topics of each body, by leaf; in the order of the scene, or of the bag."""
    found: dict[str, dict[str, str]] = {}
    for topic in bag.topics.values():
        prefix, _, leaf = topic.name.rpartition('/')
        if LEAVES.get(leaf) == topic.type and bag.counts.get(topic.name, 0):
            found.setdefault(prefix, {})[leaf] = topic.name
    found = {prefix: leaves for prefix, leaves in found.items() if 'pose' in leaves}
    short = {prefix: prefix.rpartition('/')[2] for prefix in found}
    if len(set(short.values())) < len(short):  # two robots in a bag of another recorder
        short = {prefix: prefix.strip('/') for prefix in found}
    by_name = {short[prefix]: leaves for prefix, leaves in found.items()}
    order = [] if scene is None else [body.name for body in scene.bodies]
    if set(order) == set(by_name):
        return {name: by_name[name] for name in order}
    return by_name


def _common(stamps: Sequence[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Instants that all have."""
    if all(np.array_equal(stamps[0], other) for other in stamps[1:]):
        return stamps[0]
    return reduce(np.intersect1d, stamps)


def _at(columns: Columns, stamps: NDArray[np.int64]) -> Array:
    if np.array_equal(columns.stamp, stamps):
        return columns.numbers
    return columns.numbers[np.searchsorted(columns.stamp, stamps)]


def _wrenches(
    bag: Bag,
    topics: Sequence[Mapping[str, str]],
    columns: Mapping[str, Columns],
    stamps: NDArray[np.int64],
) -> Array:
    """Give the last wrench told for each instant or before it, (2, m, n, 3)."""
    found = np.full((2, len(stamps), len(topics), 3), np.nan)
    first = np.full((2, len(topics), 3), np.nan)
    for i, leaves in enumerate(topics):
        told = columns[leaves['applied_wrench']] if 'applied_wrench' in leaves else None
        if told is None or not len(told.stamp):
            continue
        place = np.searchsorted(told.stamp, stamps, side='right') - 1
        rows = np.where((place >= 0)[:, None], told.numbers[place], np.nan)
        found[0, :, i], found[1, :, i] = rows[:, :3], rows[:, 3:]
    missing = np.isnan(found[0, 0, :, 0])
    if bag.holds_run and missing.any():
        first = _held_at_start(bag, len(topics))
        found[:, :1, missing] = first[:, None, missing]
    return found


def _held_at_start(bag: Bag, bodies: int) -> Array:
    """Say what commands exert where a recording begins, before its first tick; NaN: unknown."""
    held = RecordValues(bag.path, 'manifest', bag.manifest).json('held_at_start', '[]')
    if not held:
        return np.zeros((2, bodies, 3))
    simulation = RecordedRun(bag.path).stand_at_start().simulation
    applied = np.array(simulation.applied_wrench())
    return applied if applied.shape[1] == bodies else np.full((2, bodies, 3), np.nan)


def _told(bag: Bag, last: float) -> dict[str, Any]:
    """Say what the run was and how it ended, as far as the bag tells."""
    manifest = RecordValues(bag.path, 'manifest', bag.manifest)
    dt_ns = manifest.integer('dt_ns', 1, MOST_NS, '0') if 'dt_ns' in bag.manifest else 0
    told: dict[str, Any] = {
        'integrator': manifest.text('integrator', ''),
        'dt': dt_ns / 1e9 if dt_ns else float('nan'),
        'end_reason': WHOLE,
        'end_time': last,
    }
    if not bag.holds_run:
        return told
    if bag.ending is None:
        return {
            **told,
            'end_reason': 'cut off',
            'problem': 'the recording was cut off and restored up to here',
        }
    ending = RecordValues(bag.path, 'ending record', bag.ending)
    reason = ending.text('end_reason', WHOLE)
    lines = ending.json('warnings', '[]')
    told |= {
        'end_reason': WHOLE if reason == 'replayed' else reason,
        'end_time': ending.integer('last_time_ns', 0, MOST_NS, '0') / 1e9,
        'warnings': tuple(map(str, lines)) if isinstance(lines, list) else (),
    }
    if reason not in WHOLE_ENDS:
        told['problem'] = f'the bag says that the run ended by: {reason}'
    return told
