# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Does the node keep up with real time?

Ten bodies at 1 kHz, commands at 100 Hz from another process, recording on. Prints: ticks done of
those due, lateness, messages published, received and recorded, gaps in what a subscriber saw, and
the share of one core that the node took. Figures, not a test: a busy machine makes them worse.

    python benchmark/real_time.py --seconds 60 --publish-rate 100
    python benchmark/real_time.py --crowd 1000               # pose and twist of each at 100 Hz
    python benchmark/real_time.py --crowd 10000 --arrays     # all in two messages at 100 Hz

A crowd ticks at 100 Hz, flies freely, and takes no commands here; a subscriber of depth 1000 hears
pose and twist of one body, or both arrays. The share of a core is that of a node that runs: what
thousands of endpoints cost at its start and at its end is told apart.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from struct import Struct

import psutil
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, PoseStamped, TwistStamped
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import QoSProfile
from sensor_msgs.msg import MultiDOFJointState

from rigid_body_sim.recording.bag_reader import Bag

COMMAND_RATE = 100  # [Hz]
PATIENCE = 60  # [s] for start and end
CROWD_PATIENCE = 0.15  # [s] more per body with topics of its own: endpoints come and go slowly
STAMP = Struct('<iI')  # at byte 4 of every stamped message


@dataclass(frozen=True)
class Load:
    """
    What the node has to do.

    watched   : topics that a subscriber hears, and their types
    commanded : body that gets commands; empty: none
    """

    scene: str
    bodies: int
    dt: float
    watched: tuple[tuple[str, type], ...]
    commanded: str = ''
    parameters: tuple[str, ...] = ()
    patience: float = PATIENCE


TEN = Load('ten_bodies', 10, 0.001, (('/ball_2/pose', PoseStamped),), 'box_1')


def crowd(count: int, folder: Path, *, arrays: bool) -> Load:
    """Write a scene of so many boxes that tumble freely, side by side."""
    width = math.isqrt(count - 1) + 1
    bodies = [
        {
            'name': f'body_{k}',
            'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
            'mass': 2.0,
            'initial': {
                'position': [k % width, k // width, 0],
                'velocity': [0, 0, 1],
                'angular_velocity': [0.1, 0.001 * k, 1],
            },
        }
        for k in range(count)
    ]
    path = folder / 'crowd.yaml'
    scene = {'version': 1, 'name': 'crowd', 'dt': 0.01, 'bodies': bodies}
    path.write_text(json.dumps(scene))  # which is YAML too
    if arrays:
        return Load(
            *(str(path), count, 0.01),
            (('/poses', PoseArray), ('/twists', MultiDOFJointState)),
            parameters=('-p', 'publish_arrays:=true', '-p', 'body_topics:=none'),
        )
    name = f'body_{count // 2}'
    watched = ((f'/{name}/pose', PoseStamped), (f'/{name}/twist', TwistStamped))
    return Load(str(path), count, 0.01, watched, patience=PATIENCE + CROWD_PATIENCE * count)


class Watcher:
    """A subscriber that misses nothing of some topics, and reads the node's own figures."""

    def __init__(self, node_process: psutil.Process, load: Load) -> None:
        rclpy.init()
        self.node = rclpy.create_node('benchmark_watcher')
        self.stamps: dict[str, list[int]] = {topic: [] for topic, _ in load.watched}
        self.figures: dict[str, str] = {}
        self._process = node_process
        self._first: tuple[float, float] | None = None
        self._last = (0.0, 0.0)
        self._patience = load.patience
        deep = QoSProfile(depth=1000)
        for topic, kind in load.watched:
            take = partial(self._take, self.stamps[topic])
            self.node.create_subscription(kind, topic, take, deep, raw=True)
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._diagnostics, deep)

    def _take(self, stamps: list[int], data: bytes) -> None:
        sec, nanosec = STAMP.unpack_from(data, 4)
        stamps.append(sec * 1_000_000_000 + nanosec)

    def _diagnostics(self, message: DiagnosticArray) -> None:
        self.figures = {pair.key: pair.value for pair in message.status[0].values}
        try:
            used = self._process.cpu_times()
        except psutil.NoSuchProcess:
            return
        self._last = (time.monotonic(), used.user + used.system)
        self._first = self._first or self._last

    @property
    def cpu(self) -> float:
        """Share of one core between the first and the last diagnostics."""
        assert self._first is not None
        return (self._last[1] - self._first[1]) / (self._last[0] - self._first[0])

    def watch(self, seconds: float) -> None:
        """Listen until the node has ended."""
        executor = SingleThreadedExecutor()
        executor.add_node(self.node)
        deadline = time.monotonic() + seconds + self._patience
        try:
            while time.monotonic() < deadline and self._process.status() != psutil.STATUS_ZOMBIE:
                executor.spin_once(timeout_sec=0.1)
            for _ in range(100):
                executor.spin_once(timeout_sec=0.0)
        except (ExternalShutdownException, psutil.NoSuchProcess):
            pass
        executor.shutdown()
        rclpy.try_shutdown()


def measure(load: Load, seconds: float, publish_rate: float, bag: Path) -> Watcher:
    """Run node, commander and watcher together."""
    verb = [sys.executable, '-m', 'rigid_body_sim']
    settings = {
        'scene': load.scene,
        'dt': load.dt,
        'stop_time': seconds,
        'publish_rate': publish_rate,
        'record': 'true',
        'record_path': bag,
    }
    words = [word for name, value in settings.items() for word in ('-p', f'{name}:={value}')]
    node = subprocess.Popen([*verb, 'sim_node', '--ros-args', *words, *load.parameters])
    processes = [node]
    if load.commanded:
        command = ['wrench_pub', load.commanded, '--force', '1', '0', '0']
        command += ['--rate', str(COMMAND_RATE), '--for', str(seconds)]
        processes.append(subprocess.Popen([*verb, *command], stdout=subprocess.DEVNULL))
    watcher = Watcher(psutil.Process(node.pid), load)
    try:
        watcher.watch(seconds)
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait()
    return watcher


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--seconds', type=float, default=60.0)
    parser.add_argument('--publish-rate', type=float, default=100.0, help='[Hz]')
    parser.add_argument('--crowd', type=int, default=0, help='bodies; 0: ten, with commands')
    parser.add_argument('--arrays', action='store_true', help='a crowd without topics of its own')
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'bag'
        count, arrays = arguments.crowd, arguments.arrays
        load = crowd(count, Path(folder), arrays=arrays) if count else TEN
        watcher = measure(load, arguments.seconds, arguments.publish_rate, path)
        report(load, watcher, Bag(path), arguments)


def report(load: Load, watcher: Watcher, bag: Bag, arguments: argparse.Namespace) -> None:
    """Print the figures."""
    figures = watcher.figures
    due = round(arguments.seconds / load.dt)
    period = round(1e9 / arguments.publish_rate)
    published = round(arguments.seconds * arguments.publish_rate) + 1  # that of t = 0 too
    missed = {
        topic: f'{sum((b - a) // period - 1 for a, b in pairwise(stamps) if b > a)} of '
        f'{(stamps[-1] - stamps[0]) // period + 1}'
        for topic, stamps in watcher.stamps.items()
        if stamps
    }
    leaves = ('/poses', '/twists') if arguments.arrays else ('/pose', '/twist')
    states = sum(n for name, n in bag.counts.items() if name.endswith((*leaves, '/clock')))
    messages = published * (1 + 2 * (1 if arguments.arrays else load.bodies))
    commands = bag.counts.get(f'/{load.commanded}/wrench', 0)
    rows = {
        'machine': f'{platform.machine()}, {psutil.cpu_count()} cores, '
        f'load {psutil.getloadavg()[0]:.1f}, Python {platform.python_version()}',
        'run': f'{load.bodies} bodies{" in arrays" if arguments.arrays else ""}, '
        f'dt {load.dt:g} s, {arguments.seconds:g} s, published at {arguments.publish_rate:g} Hz, '
        f'commands at {COMMAND_RATE if load.commanded else 0} Hz',
        'ticks done of due': f'{figures["tick"]} of {due}',
        'drift of the last deadline': f'{float(figures["last lateness [s]"]) * 1e3:.3f} ms',
        'largest lateness': f'{float(figures["largest lateness [s]"]) * 1e3:.3f} ms',
        'overruns, lags': f'{figures["overruns"]}, {figures["lags"]}',
        'commands accepted, recorded': f'{figures["accepted commands"]}, {commands}',
        'states recorded of published': f'{states} of {messages}, '
        f'dropped {bag.ending["dropped"] if bag.ending else "?"}',
        'messages a subscriber missed': ', '.join(f'{k}: {v}' for k, v in missed.items()),
        'share of one core': f'{watcher.cpu * 100:.1f} %',
        'energy drift': figures['energy drift'],
    }
    for name, value in rows.items():
        print(f'{name:30} {value}')


if __name__ == '__main__':
    main()
