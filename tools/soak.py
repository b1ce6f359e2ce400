# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A node that is kept: 1000 ticks a second, four publishers at 100 Hz, recording, parameters changed,
pauses, steps, resets, recording off and on. Then everything must add up.

    python tools/soak.py                  ten minutes
    python tools/soak.py --seconds 90     a short form

Checked: the bags hold every tick once and without a gap; every command that the node accepted is
in one of them; each bag replays bit for bit; the memory of the node grew by less than 5 MB after
the first two minutes (in a short form: the first fifth); it ends with exit code 0. Printed: how
late ticks began (99th percentile of samples taken ten times a second, and the largest of all).
Exit code 1 where something does not add up.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
SPACE = '/soak'
NODE = f'{SPACE}/rigid_body_sim'
COMMANDS = ('box/wrench', 'box/force', 'ball/force', 'ball/impulse')
RATE = 100  # [Hz] of each publisher
ROUND = 15.0  # [s] between two rounds of pause, step, reset, record
GROWTH = 5.0  # [MB]
WAIT = 60.0  # [s] for an answer


def publish() -> int:
    """Publish on all topics; 'go' and 'stop' on standard input; print what was sent so far."""
    import rclpy

    from rigid_body_sim.recording.topics import COMMAND_TYPES
    from rigid_body_sim.ros import conversions, qos
    from rigid_body_sim.runs.commands import Command

    rclpy.init()
    node = rclpy.create_node('sender')
    senders = []
    for name in COMMANDS:
        body, kind = name.split('/')
        force = (0.0, 0.0, 1e-3 if kind == 'impulse' else 0.1)
        message = Command(body, kind, force=force).message
        publisher = node.create_publisher(
            conversions.MESSAGE_TYPES[COMMAND_TYPES[kind]], f'{SPACE}/{name}', qos.of_commands()
        )
        senders.append((publisher, message))
    going, idle = threading.Event(), threading.Event()
    sent = [0]

    def work() -> None:
        deadline = time.monotonic()
        while True:
            if not going.is_set():
                idle.set()
                going.wait()
                idle.clear()
                deadline = time.monotonic()
            for publisher, message in senders:
                publisher.publish(message)
                sent[0] += 1
            deadline += 1 / RATE
            time.sleep(max(0.0, deadline - time.monotonic()))

    end = time.monotonic() + WAIT
    while not all(publisher.get_subscription_count() for publisher, _ in senders):
        if time.monotonic() > end:
            return 1  # no node
        time.sleep(0.05)
    threading.Thread(target=work, daemon=True).start()
    print('ready', flush=True)
    for line in sys.stdin:
        if line.strip() == 'go':
            going.set()
        else:
            going.clear()
            idle.wait(WAIT)
            print(sent[0], flush=True)
    os._exit(0)


class Soak:
    """The node, its senders, and who asks them for things."""

    def __init__(self, folder: Path, domain: int) -> None:
        from rigid_body_sim.ros.peer import Peer

        self.folder = folder
        environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain)}
        words = f"""scene:={ROOT}/config/scenes/two_bodies.yaml dt:=0.001 record:=true
            record_path:=bag diagnostics_period:=0.1 publish_rate:=100.0 step_count:=20"""
        given = [word for pair in words.split() for word in ('-p', pair)]
        names = ('-r', f'__ns:={SPACE}')
        self.said = (folder / 'node.log').open('w+')
        self.node = subprocess.Popen(
            [sys.executable, '-m', 'rigid_body_sim', 'sim_node', '--ros-args', *given, *names],
            cwd=folder,
            env={**environment, 'PYTHONPATH': str(ROOT)},
            stdout=self.said,
            stderr=subprocess.STDOUT,
        )
        self.sender = subprocess.Popen(
            [sys.executable, __file__, '--publish'],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.peer = Peer(domain, {}, lambda *_: None)
        self.lateness: list[float] = []
        self.memory: list[tuple[float, float]] = []  # (s, MB)
        self._seen = ''
        self.begin = time.monotonic()

    def watch(self, seconds: float) -> None:
        """Collect figures for so long."""
        end = time.monotonic() + seconds
        while True:
            self.peer.hear(0.05)
            self._look()
            if self.node.poll() is not None:
                raise SystemExit(f'the node ended early: {(self.folder / "node.log").read_text()}')
            if time.monotonic() >= end:
                return

    def _look(self) -> None:
        health = self.peer.health()
        if health and health['time [s]'] != self._seen:
            self._seen = health['time [s]']
            self.lateness.append(float(health['last lateness [s]']))
            self.memory.append((time.monotonic() - self.begin, _megabytes(self.node.pid)))

    def ask(self, name: str, request: bool | None = None) -> str:
        """Call a service of the node; return what it said."""
        answer = self.peer.ask(f'{NODE}/{name}', request, None, wait=self._patience())
        if not answer.success:
            raise SystemExit(f'~/{name} refused: {answer.message}')
        return answer.message

    def set(self, name: str, value: float) -> str:
        """Set a parameter; return why it was refused."""
        return self.peer.set(NODE, name, value, wait=self._patience())

    def _patience(self):
        end = time.monotonic() + WAIT

        def wait() -> None:
            self.peer.hear(0.0)
            if time.monotonic() > end:
                raise SystemExit(f'no answer within {WAIT:g} s')

        return wait

    def send(self, on: bool) -> int:
        """Let the senders go, or stop them; return how much they have sent when they stand."""
        assert self.sender.stdin is not None
        assert self.sender.stdout is not None
        self.sender.stdin.write('go\n' if on else 'stop\n')
        self.sender.stdin.flush()
        return 0 if on else int(self.sender.stdout.readline())

    def settle(self) -> int:
        """Stop the senders and wait until all has come and acted; return what was sent."""
        sent = self.send(False)
        self.watch(0.5)
        accepted = -1
        while accepted != (now := int(self.peer.health()['accepted commands'])):
            accepted = now
            self.watch(0.3)
        return sent

    def turn(self, number: int) -> None:
        """Do one round of everything."""
        self.send(True)
        for factor in (0.5, 2.0, 1.0):
            if problem := self.set('real_time_factor', factor):
                raise SystemExit(f'real_time_factor: {problem}')
            self.watch(0.5)
        self.watch(ROUND - 6.0)
        self.ask('pause', True)
        self.watch(0.3)
        for _ in range(5):
            self.ask('step')
        self.ask('pause', False)
        if number % 3 == 0:  # commands that wait are forgotten by a reset
            self.settle()
            self.ask('reset')
        elif number % 3 == 1:  # no tick is done while nothing is recorded
            self.settle()
            self.ask('pause', True)
            self.ask('record', False)
            if problem := self.set('command_timeout', 0.1 + 0.1 * (number % 4)):
                raise SystemExit(f'command_timeout: {problem}')
            self.ask('record', True)
            self.ask('pause', False)

    def close(self) -> int:
        """End the node as a user would; return its exit code."""
        self.sender.kill()
        self.sender.wait()
        self.node.send_signal(2)
        code = self.node.wait(WAIT)
        self.peer.close()
        return code


def _megabytes(pid: int) -> float:
    """Resident memory of a process."""
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def judge(folder: Path, accepted: int) -> list[str]:
    """Read and replay all bags; say what does not add up."""
    from rigid_body_sim.recording.bag_reader import Bag

    problems = []
    bags = sorted((Bag(path) for path in folder.glob('bag*')), key=_first)
    commands, at = 0, 0
    for bag in bags:
        assert bag.ending is not None
        if _first(bag) != at:
            problems.append(f'{bag.path.name}: begins at tick {_first(bag)}, expected {at}')
        at = int(bag.ending['last_tick'])
        names = [name for name in bag.topics if name.endswith(COMMANDS)]
        commands += sum(bag.counts[name] for name in names)
        done = subprocess.run(
            [*f'{sys.executable} -m rigid_body_sim replay --json'.split(), str(bag.path)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0 or not json.loads(done.stdout)['identical']:
            problems.append(f'{bag.path.name}: replay: {done.stdout}{done.stderr}')
    print(f'{len(bags)} bags, {at} ticks, {commands} commands recorded, {accepted} accepted')
    if commands != accepted:
        problems.append(f'{accepted} commands were accepted, {commands} are recorded')
    return problems


def _first(bag) -> int:
    return int(bag.manifest['first_tick'])


def main() -> int:
    """Soak, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--seconds', type=float, default=600.0)
    parser.add_argument('--domain', type=int, default=1 + os.getpid() % 100)
    parser.add_argument('--publish', action='store_true', help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.publish:
        return publish()
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['PYTHONPATH'] = str(ROOT)
    with tempfile.TemporaryDirectory() as name:
        soak = Soak(Path(name), arguments.domain)
        try:
            assert soak.sender.stdout is not None
            if not soak.sender.stdout.readline():
                raise SystemExit(f'no node: {(Path(name) / "node.log").read_text()}')
            soak.watch(1.0)
            soak.begin, number = time.monotonic(), 0
            soak.memory.clear()
            while time.monotonic() < soak.begin + arguments.seconds:
                soak.turn(number)
                number += 1
            sent = soak.settle()
            health = soak.peer.health()
        finally:
            code = soak.close()
        problems = [] if code == 0 else [f'exit code {code}']
        accepted = int(health['accepted commands'])
        early = min(120.0, arguments.seconds / 5)
        before = max((size for at, size in soak.memory if at <= early), default=0.0)
        grown = max(size for at, size in soak.memory if at > early) - before
        lateness = sorted(soak.lateness)
        print(
            f'{number} rounds, load {os.getloadavg()[0]:.1f}; {sent} sent, lost '
            f'{health["lost commands"]}, refused {health["refused commands"]}\n'
            f'lateness p99 {lateness[int(0.99 * len(lateness))] * 1e3:.2f} ms of '
            f'{len(lateness)} samples, largest {float(health["largest lateness [s]"]) * 1e3:.1f} '
            f'ms, overruns {health["overruns"]}\nmemory {before:.1f} MB after {early:g} s, then '
            f'{grown:+.1f} MB'
        )
        if grown > GROWTH:
            problems.append(f'memory grew by {grown:.1f} MB')
        problems += judge(Path(name), accepted)
        if problems:
            print((Path(name) / 'node.log').read_text()[-3000:])
    print('\n'.join(problems) or 'everything adds up')
    return bool(problems)


if __name__ == '__main__':
    sys.exit(main())
