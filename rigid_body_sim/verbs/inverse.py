# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`inverse BAG|CSV -o BAG`: from positions and orientations to velocities, accelerations and the
wrench that explains them.

The new bag holds, for each body, its poses and `twist`, `accel` and `wrench` at the same instants,
world axes, each with one standard deviation of every number as a message of the same type on
`twist_std`, `accel_std` and `wrench_std`. The wrench is what acts beside the uniform gravity of
the scene, at the centre of mass; masses and inertias come from the scene that the bag carries, or
from --scene; without either there is no wrench.

Where a force jumps is taken from the recorded commands and impacts, the scene (`analysis.jumps`)
and the poses themselves (`analysis.kinks`); where these change faster than they tell, a warning
names body, times and cure. Noisy poses are smoothed, and the bandwidth is told. What holds at the
ends of the record may be given: --at-rest, --start-velocity, --end-velocity.
"""

from __future__ import annotations

import argparse
import hashlib
import heapq
import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

from rigid_body_sim import __version__
from rigid_body_sim.analysis.inverse_dynamics import (
    Derived,
    Estimate,
    KnownEnds,
    Smoothing,
    derive,
)
from rigid_body_sim.analysis.jumps import Jumps, jumps_of
from rigid_body_sim.analysis.piecewise_spline import Break
from rigid_body_sim.analysis.recorded_poses import Poses, from_bag, from_csv
from rigid_body_sim.analysis.run_steps import RunSteps, steps_of
from rigid_body_sim.analysis.samples import need_ascending
from rigid_body_sim.analysis.scene_begin import scene_began
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_directory import check_new
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.bag_writer import DERIVED_BY, BagWriter
from rigid_body_sim.recording.new_output import as_text
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.runs.reading_guard import reads_recording
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene

SUMMARY = 'from positions to velocities, accelerations and the wrench that explains them'

SCENE_FILE = 'scene.yaml'
REPORT_FILE = 'inverse.json'
UNKNOWN = 'found where the poses show them, else smeared, with deviations as wide'
SHOWN = 4  # stretches that a warning names
UNITS = {
    'velocity': 'm/s',
    'angular_velocity': 'rad/s',
    'acceleration': 'm/s^2',
    'angular_acceleration': 'rad/s^2',
    'force': 'N',
    'torque': 'N m',
}
DEVIATIONS = {
    'twist': ('velocity', 'angular_velocity'),
    'accel': ('acceleration', 'angular_acceleration'),
    'wrench': ('force', 'torque'),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        'source',
        type=Path,
        metavar='BAG|CSV',
        help='bag with poses, or CSV: time, body, px, py, pz[, qx, qy, qz, qw]',
    )
    parser.add_argument(
        '-o', '--output', type=Path, required=True, metavar='BAG', help='bag to write'
    )
    parser.add_argument(
        '--scene', metavar='SCENE', help='masses and inertias, default: the scene in the bag'
    )
    parser.add_argument(
        '--body', metavar='NAME', help='derive this body only, default: all of them'
    )
    parser.add_argument(
        '--bandwidth',
        type=float,
        metavar='HZ',
        help='take faster motion for noise; default: found from the samples',
    )
    for side in ('start', 'end'):
        parser.add_argument(
            f'--{side}-velocity',
            type=float,
            nargs=3,
            metavar=('VX', 'VY', 'VZ'),
            help=f'[m/s] known at the {side} of the record, of one body',
        )
    parser.add_argument(
        '--at-rest', action='store_true', help='the bodies do not move at start and end'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object')


@reads_recording('source')
def run(arguments: argparse.Namespace) -> int:
    """Derive and write; exit code 0."""
    check_new(arguments.output)
    tracks, scene, jumps, steps, began = _read(arguments)
    tracks = _asked(arguments, tracks)
    found = {}
    for poses in tracks:
        found[poses.prefix] = _derive(arguments, poses, scene, jumps, steps, began)
    report = {
        'source': as_text(arguments.source.name),
        'scene': None if scene is None else scene.name,
        'jumps_known': jumps is not None,
        'jumps_not_known_of': [] if jumps is None else jumps.unknown,
        'bodies': {
            poses.prefix.strip('/'): _told(poses, *found[poses.prefix]) for poses in tracks
        },
    }
    _write(
        arguments.output,
        tracks,
        {prefix: derived for prefix, (derived, _) in found.items()},
        scene,
        report,
    )
    if arguments.json:
        print(json.dumps({'bag': str(arguments.output), **report}))
    else:
        _tell(arguments.output, tracks, found, jumps)
    return 0


def _told(poses: Poses, derived: Derived, errors: dict[str, Estimate]) -> dict[str, object]:
    return {
        'samples': len(poses.time_ns),
        'wrench': derived.force is not None,
        'errors': {name: asdict(error) for name, error in errors.items()},
        'smoothing': {name: asdict(smoothing) for name, smoothing in derived.smoothing.items()},
    }


def _asked(arguments: argparse.Namespace, tracks: list[Poses]) -> list[Poses]:
    """Choose the bodies that are asked for."""
    names = ', '.join(poses.body for poses in tracks)
    if arguments.body is not None:
        tracks = [poses for poses in tracks if poses.body == arguments.body]
        if not tracks:
            raise UserError(
                f'{arguments.source}: no poses of a body named {arguments.body!r}; it has: {names}'
            )
    for option in ('start_velocity', 'end_velocity'):
        if getattr(arguments, option) is not None and len(tracks) > 1:
            raise UserError(
                f'{arguments.source}: --{option.replace("_", "-")} is of one body, and this holds '
                f'{names}; choose one with --body NAME'
            )
    return tracks


def _read(
    arguments: argparse.Namespace,
) -> tuple[list[Poses], Scene | None, Jumps | None, RunSteps | None, int]:
    """
    Read the poses, the scene if there is one, the jumps and steps if they are known, and when the
    scene began [ns].
    """
    given = load_scene(find_scene(arguments.scene)) if arguments.scene else None
    if arguments.source.suffix.lower() == '.csv':
        return from_csv(arguments.source), given, None, None, 0
    bag = Bag(arguments.source)
    own, files = None, dict(bag.attachments)
    if SCENE_FILE in files:
        own = load_scene(files.pop(SCENE_FILE), files=files)
    given = own if given is None else given
    tracks = from_bag(bag)
    if given is None or not bag.holds_run:
        return tracks, given, None, None, 0
    began = 0 if own is None else scene_began(bag, own)
    return tracks, given, jumps_of(bag, given, began=began), steps_of(bag.manifest), began


def _derive(
    arguments: argparse.Namespace,
    poses: Poses,
    scene: Scene | None,
    jumps: Jumps | None,
    steps: RunSteps | None,
    began: int,
) -> tuple[Derived, dict[str, Estimate]]:
    bodies = {} if scene is None else {body.name: body for body in scene.bodies}
    body = bodies.get(poses.body)
    # times of a recorder may be those of the wall clock, whose seconds would cost nine digits
    start = began if scene is not None and poses.time_ns[0] < 10**18 else int(poses.time_ns[0])
    breaks = [
        [Break(b.instant - start, b.continuity) for b in table.get(poses.body, ())]
        for table in (({}, {}) if jumps is None else (jumps.paths, jumps.turns))
    ]
    try:
        need_ascending(poses.time_ns, unit=1e-9)  # here: below they count from `start`
        derived, told = derive(
            (poses.time_ns - start).astype(float),
            poses.position,
            poses.orientation,
            body=None if body is None or body.fixed else body,
            gravity=(0.0, 0.0, 0.0) if scene is None else scene.gravity,
            breaks=breaks[0],
            turning_breaks=breaks[1],
            bandwidth=arguments.bandwidth,
            ends=KnownEnds(arguments.start_velocity, arguments.end_velocity, arguments.at_rest),
            steps=steps,
            tick=0.0 if jumps is None else jumps.tick,
            unit=1e-9,
        )
    except (UserError, InvalidModel) as error:
        raise UserError(f'{arguments.source}: {poses.prefix}: {error}') from error
    smoothing = {name: each.later(began * 1e-9) for name, each in derived.smoothing.items()}
    return replace(derived, smoothing=smoothing), told


def _write(
    output: Path,
    tracks: list[Poses],
    found: dict[str, Derived],
    scene: Scene | None,
    report: dict[str, object],
) -> None:
    topics = []
    for poses in tracks:
        topics += [
            Topic(f'{poses.prefix}/pose', cdr.PoseStamped.TYPE),
            Topic(f'{poses.prefix}/twist', cdr.TwistStamped.TYPE),
            Topic(f'{poses.prefix}/accel', cdr.AccelStamped.TYPE),
        ]
        if found[poses.prefix].force is not None:
            topics.append(Topic(f'{poses.prefix}/wrench', cdr.WrenchStamped.TYPE))
        if found[poses.prefix].deviation:
            topics += [
                Topic(f'{topic.name}_std', topic.type)
                for topic in topics
                if topic.name.rpartition('/')[0] == poses.prefix and topic.name[-5:] != '/pose'
            ]
    attachments = {REPORT_FILE: json.dumps(report, indent=1).encode()}
    manifest = {
        DERIVED_BY: 'inverse',
        'source': str(report['source']),
        'package_version': __version__,
    }
    if scene is not None:
        attachments |= {SCENE_FILE: scene.source, **scene.files}
        manifest |= {
            'scene': scene.name,
            'scene_sha256': hashlib.sha256(scene.source).hexdigest(),
        }
    writer = BagWriter(output, topics=topics, manifest=manifest, attachments=attachments)
    streams = [_messages(poses, found[poses.prefix]) for poses in tracks]
    for time_ns, sequence, topic, payload in heapq.merge(*streams, key=lambda message: message[0]):
        writer.write_message(topic, sequence, time_ns, payload)
    writer.close({})


def _messages(poses: Poses, derived: Derived) -> Iterator[tuple[int, int, str, bytes]]:
    """Yield (time [ns], sample, topic, payload) in the order of time."""
    columns = {
        'pose': (cdr.PoseStamped, poses.position, poses.orientation),
        'twist': (cdr.TwistStamped, derived.velocity, derived.angular_velocity),
        'accel': (cdr.AccelStamped, derived.acceleration, derived.angular_acceleration),
    }
    if derived.force is not None and derived.torque is not None:
        columns['wrench'] = (cdr.WrenchStamped, derived.force, derived.torque)
    if derived.deviation:
        for leaf, names in DEVIATIONS.items():
            if leaf in columns:
                first, second = (derived.deviation[name] for name in names)
                columns[f'{leaf}_std'] = (columns[leaf][0], first, second)
    lists = [
        (f'{poses.prefix}/{leaf}', kind, first.tolist(), second.tolist())
        for leaf, (kind, first, second) in columns.items()
    ]
    for sample, time_ns in enumerate(poses.time_ns.tolist()):
        sec, nanosec = divmod(time_ns, 1_000_000_000)
        for topic, kind, first, second in lists:
            message = kind(
                sec, nanosec, poses.frame_id, tuple(first[sample]), tuple(second[sample])
            )
            yield time_ns, sample, topic, cdr.encode(message)


def _tell(
    output: Path,
    tracks: list[Poses],
    found: dict[str, tuple[Derived, dict[str, Estimate]]],
    jumps: Jumps | None,
) -> None:
    for poses in tracks:
        derived, errors = found[poses.prefix]
        samples = len(poses.time_ns)
        print(f'{poses.prefix.strip("/")}: {samples} samples; estimated error, mean (largest):')
        for name, error in errors.items():
            sizes = f'{error.rms:.1e} ({error.largest:.1e})'
            print(f'  {name.replace("_", " "):21} {sizes} {UNITS[name]}')
        if not errors:
            print('  too few samples to estimate an error')
        for name, smoothing in derived.smoothing.items():
            print(f'  {_sentence(name, smoothing)}')
            if smoothing.steep:
                print(f'  {_warning(name, smoothing.steep)}')
        if derived.force is None:
            print('  no wrench: its mass is not known, or it is fixed; give --scene SCENE')
    if jumps is None:
        print(f'jumps: none known (no recorded commands): {UNKNOWN}')
    elif jumps.unknown:
        print(f'jumps: those by {" and ".join(jumps.unknown)} are not known: {UNKNOWN}')
    print(f'bag: {output}')


def _warning(name: str, steep: tuple[tuple[float, float], ...]) -> str:
    """Say where the samples tell too little, and what helps."""
    shown = [f'{begin:.6g} to {end:.6g} s' for begin, end in steep[:SHOWN]]
    more = len(steep) - len(shown)
    times = ', '.join(shown) + (f' and {more} more' if more else '')
    return (
        f'warning: {name} jumps within the samples at {times}: its numbers there are no better '
        'than their deviations; record more poses a second (--publish-rate)'
    )


def _sentence(name: str, smoothing: Smoothing) -> str:
    """Say what was done to the samples of a position or an orientation."""
    unit = 'm' if name == 'position' else 'rad'
    text = f'{name}: noise {smoothing.noise:.1e} {unit}, '
    text += f'smoothed to {smoothing.bandwidth:.3g} Hz' if smoothing.smoothed else 'not smoothed'
    if smoothing.breaks:
        text += f', {smoothing.breaks} jump{"s" if smoothing.breaks > 1 else ""}'
        if smoothing.found:
            text += f' ({len(smoothing.found)} found in the samples)'
    if smoothing.dropped:
        text += (
            f'; {len(smoothing.dropped)} more come too fast for these samples, the first at '
            f'{smoothing.dropped[0]:g} s'
        )
    return text
