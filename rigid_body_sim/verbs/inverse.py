# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`inverse BAG|CSV -o BAG`: from positions and orientations to velocities, accelerations and the
wrench that explains them.

The new bag holds, for each body, its poses and `twist`, `accel` and `wrench` at the same instants,
world axes. The wrench is what acts beside the uniform gravity of the scene, at the centre of mass;
masses and inertias come from the scene that the bag carries, or from --scene; without either there
is no wrench. With each quantity comes an estimate of its error.
"""

from __future__ import annotations

import argparse
import hashlib
import heapq
import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from rigid_body_sim import __version__
from rigid_body_sim.analysis.inverse_dynamics import Derived, Estimate, derive
from rigid_body_sim.analysis.recorded_poses import Poses, from_bag, from_csv
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.bag_writer import DERIVED_BY, BagWriter
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.runs.reading_guard import reads_recording
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene

SUMMARY = 'from positions to velocities, accelerations and the wrench that explains them'

SCENE_FILE = 'scene.yaml'
REPORT_FILE = 'inverse.json'
UNITS = {
    'velocity': 'm/s',
    'angular_velocity': 'rad/s',
    'acceleration': 'm/s^2',
    'angular_acceleration': 'rad/s^2',
    'force': 'N',
    'torque': 'N m',
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
    parser.add_argument('--json', action='store_true', help='print one JSON object')


@reads_recording('source')
def run(arguments: argparse.Namespace) -> int:
    """Derive and write; exit code 0."""
    if arguments.output.exists():
        raise UserError(f'{arguments.output}: exists already; choose another name or remove it')
    tracks, scene = _read(arguments)
    bodies = {body.name: body for body in scene.bodies} if scene is not None else {}
    found = {}
    for poses in tracks:
        found[poses.prefix] = _derive(arguments.source, poses, bodies.get(poses.body), scene)
    report = {
        'source': arguments.source.name,
        'scene': None if scene is None else scene.name,
        'bodies': {
            poses.prefix.strip('/'): {
                'samples': len(poses.time_ns),
                'wrench': found[poses.prefix][0].force is not None,
                'errors': {name: asdict(error) for name, error in found[poses.prefix][1].items()},
            }
            for poses in tracks
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
        _tell(arguments.output, tracks, found)
    return 0


def _read(arguments: argparse.Namespace) -> tuple[list[Poses], Scene | None]:
    """Read the poses, and the scene if there is one."""
    given = load_scene(find_scene(arguments.scene)) if arguments.scene else None
    if arguments.source.suffix.lower() == '.csv':
        return from_csv(arguments.source), given
    bag = Bag(arguments.source)
    if given is None and SCENE_FILE in bag.attachments:
        files = dict(bag.attachments)
        given = load_scene(files.pop(SCENE_FILE), files=files)
    return from_bag(bag), given


def _derive(
    source: Path, poses: Poses, body: Body | None, scene: Scene | None
) -> tuple[Derived, dict[str, Estimate]]:
    # times of a recorder may be those of the wall clock, whose seconds would cost nine digits
    start = 0 if scene is not None and poses.time_ns[0] < 10**18 else int(poses.time_ns[0])
    try:
        return derive(
            (poses.time_ns - start).astype(float) * 1e-9,
            poses.position,
            poses.orientation,
            body=None if body is None or body.fixed else body,
            gravity=(0.0, 0.0, 0.0) if scene is None else scene.gravity,
            breaks=[1e-9 * (jump - start) for jump in poses.jumps_ns],
        )
    except (UserError, InvalidModel) as error:
        raise UserError(f'{source}: {poses.prefix}: {error}') from error


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
    output: Path, tracks: list[Poses], found: dict[str, tuple[Derived, dict[str, Estimate]]]
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
        if derived.force is None:
            print('  no wrench: its mass is not known, or it is fixed; give --scene SCENE')
    print(f'bag: {output}')
