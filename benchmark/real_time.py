# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Does the node keep up with real time?

Ten bodies at 1 kHz, commands at 100 Hz from another process, recording on. Prints: ticks done of
those due, lateness, messages published, received and recorded, gaps in what a subscriber saw, and
the share of one core that the node took. Figures, not a test: a busy machine makes them worse.

    python benchmark/real_time.py --seconds 60 --publish-rate 100
"""

from __future__ import annotations

import argparse
import platform
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import psutil
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import QoSProfile

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag

SCENE, BODIES, COMMANDED, WATCHED = 'ten_bodies', 10, 'box_1', 'ball_2'
COMMAND_RATE = 100  # [Hz]
DT = 0.001  # [s]
PATIENCE = 30  # [s] for start and end


class Watcher:
    """A subscriber that misses nothing of one topic, and reads the node's own figures."""

    def __init__(self, node_process: psutil.Process) -> None:
        rclpy.init()
        self.node = rclpy.create_node('benchmark_watcher')
        self.stamps: list[int] = []
        self.figures: dict[str, str] = {}
        self._process = node_process
        self._first: tuple[float, float] | None = None
        self._last = (0.0, 0.0)
        deep = QoSProfile(depth=1000)
        self.node.create_subscription(PoseStamped, f'/{WATCHED}/pose', self._pose, deep, raw=True)
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._diagnostics, deep)

    def _pose(self, data: bytes) -> None:
        message = cdr.decode(cdr.PoseStamped.TYPE, data)
        self.stamps.append(message.sec * 1_000_000_000 + message.nanosec)

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
        deadline = time.monotonic() + seconds + PATIENCE
        try:
            while time.monotonic() < deadline and self._process.status() != psutil.STATUS_ZOMBIE:
                executor.spin_once(timeout_sec=0.1)
            for _ in range(100):
                executor.spin_once(timeout_sec=0.0)
        except (ExternalShutdownException, psutil.NoSuchProcess):
            pass
        executor.shutdown()
        rclpy.try_shutdown()


def measure(seconds: float, publish_rate: float, bag: Path) -> Watcher:
    """Run node, commander and watcher together."""
    verb = [sys.executable, '-m', 'rigid_body_sim']
    settings = {
        'scene': SCENE,
        'dt': DT,
        'stop_time': seconds,
        'publish_rate': publish_rate,
        'record': 'true',
        'record_path': bag,
    }
    words = [word for name, value in settings.items() for word in ('-p', f'{name}:={value}')]
    node = subprocess.Popen([*verb, 'sim_node', '--ros-args', *words])
    command = ['wrench_pub', COMMANDED, '--force', '1', '0', '0', '--rate', str(COMMAND_RATE)]
    commander = subprocess.Popen(
        [*verb, *command, '--for', str(seconds)], stdout=subprocess.DEVNULL
    )
    watcher = Watcher(psutil.Process(node.pid))
    try:
        watcher.watch(seconds)
    finally:
        commander.terminate()
        commander.wait()
        node.terminate()
        node.wait()
    return watcher


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--seconds', type=float, default=60.0)
    parser.add_argument('--publish-rate', type=float, default=100.0, help='[Hz]')
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'bag'
        watcher = measure(arguments.seconds, arguments.publish_rate, path)
        report(watcher, Bag(path), arguments)


def report(watcher: Watcher, bag: Bag, arguments: argparse.Namespace) -> None:
    """Print the figures."""
    figures, stamps = watcher.figures, watcher.stamps
    due = round(arguments.seconds / DT)
    period = round(1e9 / arguments.publish_rate)
    published = round(arguments.seconds * arguments.publish_rate)
    gaps = sum((after - before) // period - 1 for before, after in pairwise(stamps))
    states = sum(
        n for name, n in bag.counts.items() if name.endswith(('/pose', '/twist', '/clock'))
    )
    commands = bag.counts[f'/{COMMANDED}/wrench']
    rows = {
        'machine': f'{platform.machine()}, {psutil.cpu_count()} cores, '
        f'load {psutil.getloadavg()[0]:.1f}, Python {platform.python_version()}',
        'run': f'{BODIES} bodies, dt {DT:g} s, {arguments.seconds:g} s, '
        f'published at {arguments.publish_rate:g} Hz, commands at {COMMAND_RATE} Hz',
        'ticks done of due': f'{figures["tick"]} of {due}',
        'drift of the last deadline': f'{float(figures["last lateness [s]"]) * 1e3:.3f} ms',
        'largest lateness': f'{float(figures["largest lateness [s]"]) * 1e3:.3f} ms',
        'overruns, lags': f'{figures["overruns"]}, {figures["lags"]}',
        'commands accepted, recorded': f'{figures["accepted commands"]}, {commands}',
        'states recorded of published': f'{states} of {published * (2 * BODIES + 1)}, '
        f'dropped {bag.ending["dropped"] if bag.ending else "?"}',
        'messages a subscriber missed': f'{gaps} of {(stamps[-1] - stamps[0]) // period + 1}',
        'share of one core': f'{watcher.cpu * 100:.1f} %',
        'energy drift': figures['energy drift'],
    }
    for name, value in rows.items():
        print(f'{name:30} {value}')


if __name__ == '__main__':
    main()
