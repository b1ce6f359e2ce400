# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A short run of two bodies to record: states every fifth tick, wrenches and commands in between.
"""

import hashlib
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_writer import BagWriter
from rigid_body_sim.recording.packing import StatePacker
from rigid_body_sim.recording.topics import command_topics

BODIES = ('box', 'ball')
DT_NS = 1_000_000
SCENE = b'version: 1\nname: pair\n'
MANIFEST = {
    'schema_version': '1',
    'package_version': '0.1.0',
    'integrator': 'dmv6',
    'dt_ns': str(DT_NS),
    'scene_sha256': hashlib.sha256(SCENE).hexdigest(),
}


class Run:
    """
    A made-up run: its numbers depend on the tick alone.
    """

    def __init__(self, bodies=BODIES):
        self.bodies = bodies
        self.packer = StatePacker(bodies, dt_ns=DT_NS)
        self.topics = [*self.packer.topics, *command_topics(bodies)]

    def arrays(self, tick):
        """
        Return the six arrays of a tick.
        """
        numbers = np.random.default_rng(tick)
        widths = {'position': 3, 'orientation': 4, 'velocity': 3, 'angular_velocity': 3}
        widths |= {'force': 3, 'torque': 3}
        return {name: numbers.random((len(self.bodies), width)) for name, width in widths.items()}

    def state(self, tick):
        """
        Return the batch of a published tick.
        """
        return self.packer.pack(tick, **self.arrays(tick))

    def write(self, writer, ticks, first=0):
        """
        Write ticks as the node does: commands, wrenches where they changed, states every fifth.
        """
        for tick in range(first, first + ticks):
            if tick % 7 == 0:
                command = cdr.Vector3Stamped(0, tick, 'box', (float(tick), 0.0, -0.0))
                payload = cdr.encode(command)
                writer.write_message('/box/force', tick, tick * DT_NS, payload)
            if tick % 5 == 4:
                writer.write(self.state(tick + 1))
            elif tick % 7 == 0:
                arrays = self.arrays(tick)
                wrenches = {name: arrays[name] for name in ('force', 'torque')}
                writer.write(self.packer.pack_wrenches(np.array([0]), tick, **wrenches))

    def open(self, path, **options):
        """
        Open a writer for this run.
        """
        return BagWriter(
            path,
            topics=self.topics,
            manifest=MANIFEST,
            attachments={'scene.yaml': SCENE},
            **options,
        )


@pytest.fixture
def run():
    """
    The run to record.
    """
    return Run()


@pytest.fixture
def make_run():
    """
    Make a run of other bodies.
    """
    return Run


@pytest.fixture
def record(tmp_path, run):
    """
    Record some ticks under a name; returns the directory.
    """

    def make(name='run', ticks=100, **options):
        path = tmp_path / name
        writer = run.open(path, **options)
        run.write(writer, ticks)
        writer.close({'end_reason': 'stop_time', 'wall_time': name})
        return path

    return make


@pytest.fixture
def mcap_of():
    """
    Path of the MCAP file in a bag directory.
    """

    def find(directory: Path) -> Path:
        (path,) = directory.glob('*.mcap')
        return path

    return find
