# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is drawn, counted and differentiated of a bag does not depend on the order of its file."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from rigid_body_sim.analysis import recorded_contacts, recorded_impacts
from rigid_body_sim.analysis.jumps import jumps_of
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.scene import load_scene
from rigid_body_sim.view.contact_arrows import read_arrows
from rigid_body_sim.view.recorded_motion import read_motion

SCENE = """
version: 1
name: bouncing
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: event}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: ball
    mass: 1
    restitution: 0.6
    shape: {type: sphere, radius: 0.1}
    initial: {position: [0, 0, 0.3], velocity: [0.5, 0, 0]}
"""
COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.10,ball,wrench,world,3,0,0,0,0,0.5
0.20,ball,wrench,world,1,0,0,0,0,0
0.60,ball,impulse,world,0,0.1,0,0,0,0
"""


@pytest.fixture
def bags(verb, tmp_path: Path) -> list[Bag]:
    """A run of a ball that bounces and is pushed, and the same with its instants shuffled."""
    (tmp_path / 'bouncing.yaml').write_text(SCENE)
    (tmp_path / 'commands.csv').write_text(COMMANDS)
    words = ('--commands', tmp_path / 'commands.csv', '--contacts', '--duration', '1')
    assert verb('simulate', tmp_path / 'bouncing.yaml', '-o', tmp_path / 'run', *words)[0] == 0
    (source,) = (tmp_path / 'run').glob('*.mcap')
    return [Bag(source), Bag(shuffled(source, tmp_path / 'shuffled.mcap'))]


def shuffled(source: Path, target: Path) -> Path:
    """Copy a file; what has one log time stays together, in its order."""
    with source.open('rb') as stream, target.open('wb') as out:
        reader, writer = make_reader(stream), Writer(out, chunk_size=4096)
        writer.start(profile='ros2')
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        for a in reader.iter_attachments():
            writer.add_attachment(a.create_time, a.log_time, a.name, a.media_type, a.data)
        found = list(reader.iter_messages(log_time_order=False))
        times = sorted({message.log_time for *_, message in found})
        place = dict(zip(times, np.random.default_rng(0).permutation(len(times)), strict=True))
        numbers: dict[int, int] = {}
        for schema, channel, message in sorted(found, key=lambda each: place[each[2].log_time]):
            if channel.id not in numbers:
                kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                numbers[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, kind, channel.metadata
                )
            told = (message.publish_time, message.sequence)
            writer.add_message(numbers[channel.id], message.log_time, message.data, *told)
        writer.finish()
    return target


def test_what_is_read_of_a_bag_is_the_same_whatever_the_order_of_its_file(bags) -> None:
    motions = [read_motion(bag, samples=50) for bag in bags]
    for one, other in zip(*(motion.tracks for motion in motions), strict=True):
        for a, b in zip(astuple(one), astuple(other), strict=True):
            np.testing.assert_array_equal(a, b)
    for motion in motions:
        assert motion.loads and len(motion.impacts) > 3
    for name, load in motions[0].loads.items():
        np.testing.assert_array_equal(load.time, motions[1].loads[name].time)
        np.testing.assert_array_equal(load.force, motions[1].loads[name].force)
    np.testing.assert_array_equal(motions[0].impacts.time, motions[1].impacts.time)
    np.testing.assert_array_equal(*(motion.command_time for motion in motions))
    for summarise in (recorded_contacts.summarise, recorded_impacts.summarise):
        one, other = map(summarise, bags)
        assert one is not None and one == other
    times = motions[0].tracks[0].time
    arrows = [read_arrows(bag, times, {'ground': 0, 'ball': 1}) for bag in bags]
    np.testing.assert_array_equal(arrows[0].arrows, arrows[1].arrows)
    scene = load_scene(bags[0].attachments['scene.yaml'])
    one, other = (jumps_of(bag, scene) for bag in bags)
    assert one.paths and one == other
