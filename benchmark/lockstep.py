# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What lock-step costs, and whether its runs come out again.

    pace     periods per second and processor time per period, of the node and of its partner, with
             a partner that waits as the node does and one in an rclpy executor
    waiting  share of one core that a node takes while nobody answers
    bags     messages of runs on a quiet machine and beside busy processes: an attitude controller
             of the satellite at 100 Hz, and two controllers with a topic each

Every node and every partner is a process. Figures, not a test: a busy machine makes the first two
worse. The third ends with exit code 1 where runs differ.

    python benchmark/lockstep.py pace waiting bags
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import psutil
import rclpy
from rclpy.executors import SingleThreadedExecutor

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.ros.partner import Partner, States

PATIENCE = 120.0  # [s] for what another process says
PERIOD = 0.01  # [s] of the scene


class Attitude:
    """Turns the satellite to the world axes: a PD law on the vector part of its orientation."""

    body, topic = 'satellite', 'satellite/torque'

    def __call__(self, states: States) -> Mapping[str, Any]:
        """Torque [N m], world axes."""
        state = states[self.body]
        error = 2.0 * state.orientation[:3] * np.copysign(1.0, state.orientation[3])
        return {self.topic: -0.4 * error - 0.9 * state.angular_velocity}


class Station:
    """Keeps the inspector where it is, with a memory: a PID law."""

    body, topic = 'inspector', 'inspector/force'

    def __init__(self) -> None:
        self.sum = np.zeros(3)

    def __call__(self, states: States) -> Mapping[str, Any]:
        """Force [N]."""
        state = states[self.body]
        error = state.position - [2.5, 0.5, 0.0]
        self.sum += error * PERIOD
        return {self.topic: -1.5 * error - 0.3 * self.sum - 2.0 * state.velocity}


CONTROLLERS = {control.body: control for control in (Attitude, Station)}


def answer(body: str, *, spins: bool, until: float) -> None:
    """Be a partner up to a simulation time; print figures as JSON."""
    control = CONTROLLERS[body]()
    rclpy.init()
    node = rclpy.create_node(f'{body}_controller')
    moments: list[tuple[float, float]] = []

    def timed(states: States) -> Mapping[str, Any]:
        moments.append((time.perf_counter(), time.process_time()))
        return control(states)

    partner = Partner(node, timed, bodies=[body], topics=[control.topic], spins=spins)
    if spins:
        partner.spin(until=until, patience=PATIENCE)
    else:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while partner.states is None or partner.states.time < until:
            executor.spin_once(timeout_sec=0.1)
    moments = moments[len(moments) // 10 :]  # what begins is slower
    wall, cpu = (b - a for a, b in zip(moments[0], moments[-1]))
    count = len(moments) - 1
    print(json.dumps({'pace': count / wall, 'cpu': cpu / count}))
    rclpy.try_shutdown()


class SimNode:
    """A node in lock-step, in a process of its own; use it in a `with`."""

    def __init__(self, **settings: object) -> None:
        given = {'scene': 'satellite', 'real_time_factor': 0.0, **settings}
        words = [word for name, value in given.items() for word in ('-p', f'{name}:={value}')]
        verb = [sys.executable, '-m', 'rigid_body_sim', 'sim_node', '--ros-args']
        self._process = subprocess.Popen(
            [*verb, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.process = psutil.Process(self._process.pid)
        assert self._process.stdout is not None
        said = []
        try:
            for line in self._process.stdout:
                said.append(line)
                if 'ready:' in line:
                    return
        except BaseException:
            self._process.kill()
            raise
        raise SystemExit(''.join(said))

    def __enter__(self) -> SimNode:
        return self

    def __exit__(self, *_exception: object) -> None:
        self._process.terminate()
        self._process.communicate(timeout=PATIENCE)

    @property
    def cpu(self) -> float:
        """Processor time so far [s]."""
        used = self.process.cpu_times()
        return used.user + used.system


def start_partner(body: str, *, spins: bool, until: float) -> subprocess.Popen[str]:
    """Start `answer` in a process of its own."""
    words = ['--partner', body, '--until', str(until), *['--spins'] * spins]
    return subprocess.Popen([sys.executable, __file__, *words], stdout=subprocess.PIPE, text=True)


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Let processes of this number keep the machine busy."""
    with ExitStack() as stack:
        for _ in range(count):
            process = subprocess.Popen([sys.executable, '-c', 'while True: pass'])
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield


def run(
    topics: Sequence[str], *, spins: bool, seconds: float, bag: Path, **settings: object
) -> tuple[list[dict[str, float]], float]:
    """Let a node and the partners of its topics do a run; returns what they say, and the CPU."""
    listed = '[' + ', '.join(f"'{topic}'" for topic in topics) + ']'
    with SimNode(
        step_mode='lockstep',
        lockstep_topics=listed,
        record='true',
        record_path=bag,
        **settings,
    ) as node:
        before = node.cpu
        partners = [
            start_partner(topic.split('/')[0], spins=spins, until=seconds) for topic in topics
        ]
        said = [partner.communicate(timeout=10 * PATIENCE)[0] for partner in partners]
        used = node.cpu - before if node.process.is_running() else 0.0
    return [json.loads(text) for text in said], used / seconds * PERIOD


def show_pace(runs: int, seconds: float, folder: Path) -> None:
    """Print how fast a locked loop goes, and what it takes."""
    for name, spins in (('own wait set', True), ('rclpy executor', False)):
        paces, costs, nodes = [], [], []
        for number in range(runs):
            bag = folder / f'pace_{spins}_{number}'
            (figures,), node = run([Attitude.topic], spins=spins, seconds=seconds, bag=bag)
            paces.append(figures['pace'])
            costs.append(figures['cpu'] * 1e3)
            nodes.append(node * 1e3)
        print(
            f'{name:16} periods/s: best {max(paces):.0f}, median {median(paces):.0f} of {runs} '
            f'runs; CPU per period: node {median(nodes):.3f} ms, partner {median(costs):.3f} ms; '
            f'load {os.getloadavg()[0]:.1f}',
            flush=True,
        )


def show_waiting(seconds: float) -> None:
    """Print what it costs to wait for nobody, beside a free node that is paused."""
    modes: dict[str, dict[str, object]] = {
        'waiting': {'step_mode': 'lockstep', 'lockstep_topics': f"['{Attitude.topic}']"},
        'paused, free': {'start_paused': 'true'},
    }
    for name, settings in modes.items():
        with SimNode(**settings) as node:
            time.sleep(2.0)
            before = node.cpu
            time.sleep(seconds)
            share = (node.cpu - before) / seconds
        print(f'{name:16} {share * 100:.2f} % of one core over {seconds:g} s', flush=True)


def digest(bag: Path) -> str:
    """SHA-256 of every message of a bag with its times, states and commands alike."""
    sha = hashlib.sha256()
    count = 0
    for message in Bag(bag).messages():
        sha.update(f'{message.topic} {message.sequence} {message.log_time} '.encode())
        sha.update(message.data)
        count += 1
    return f'{sha.hexdigest()[:16]} ({count} messages)'


def compare_bags(runs: int, seconds: float, busy_count: int, folder: Path) -> bool:
    """Print whether runs on a quiet and on a busy machine are equal; returns it."""
    equal = True
    for topics in ([Attitude.topic], [Station.topic, Attitude.topic]):
        found: list[str] = []
        for count in (0, busy_count):
            with busy(count):
                for number in range(runs):
                    bag = folder / f'bag_{len(topics)}_{count}_{number}'
                    # every second run its partners are in executors
                    spins = number % 2 == 0
                    run(topics, spins=spins, seconds=seconds, bag=bag, stop_time=seconds)
                    found.append(digest(bag))
        same = len(set(found)) == 1
        equal &= same
        print(
            f'{", ".join(topics)}: {len(found)} bags, {runs} of them beside {busy_count} busy '
            f'processes: {"equal" if same else "DIFFERENT"}: {", ".join(sorted(set(found)))}',
            flush=True,
        )
    return equal


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('parts', nargs='*', help='pace, waiting, bags; all if none is named')
    parser.add_argument('--runs', type=int, default=5, help='of each kind')
    parser.add_argument('--seconds', type=float, default=20.0, help='of simulation a run')
    parser.add_argument('--busy', type=int, default=4, help='busy processes beside half the bags')
    parser.add_argument('--partner', choices=CONTROLLERS, help=argparse.SUPPRESS)
    parser.add_argument('--spins', action='store_true', help=argparse.SUPPRESS)
    parser.add_argument('--until', type=float, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.partner:
        answer(given.partner, spins=given.spins, until=given.until)
        return 0
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)  # hear nobody else
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    parts = given.parts or ['pace', 'waiting', 'bags']
    print(
        f'{platform.machine()}, {psutil.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, '
        f'Python {platform.python_version()}'
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if 'pace' in parts:
            show_pace(given.runs, given.seconds, folder)
        if 'waiting' in parts:
            show_waiting(given.seconds)
        if 'bags' in parts:
            return 0 if compare_bags(given.runs, given.seconds, given.busy, folder) else 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
