# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Does to a node in lock-step what partners and people may do, at random and while it waits.

A node with two topics, two partners in processes of their own; meanwhile services are called
(pause, step, reset, record), the real-time factor changes, commands come that nobody waits for,
with old and early stamps and no numbers, and partners are killed and replaced. At the end, by
SIGINT: exit code 0, no traceback, every service was answered, every bag replays bit for bit and
holds one answer to each state, in the order of the list.

    python tools/attack_lockstep.py --seconds 30 --seed 1
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Vector3Stamped, WrenchStamped
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.ros.partner import Partner, States, stamp_of
from rigid_body_sim.ros.qos import of_commands

TOPICS = {'satellite': 'satellite/torque', 'inspector': 'inspector/wrench'}
ANSWER = 60.0  # [s] for a service
ASK_AGAIN = 5.0  # [s] what is asked before both know of each other may be lost
LOOK = 0.01  # [s]


def answer(body: str, seed: int) -> None:
    """Be a partner for ever; some states take long."""
    rclpy.init()
    node = rclpy.create_node(f'{body}_controller')
    dice = random.Random(seed)

    def control(states: States) -> dict[str, object]:
        if dice.random() < 0.002:
            time.sleep(dice.choice([0.02, 0.3, 0.8]))
        rate = states[body].angular_velocity
        if body == 'satellite':
            return {TOPICS[body]: -0.5 * rate}
        return {TOPICS[body]: np.concatenate([-0.2 * states[body].position, -0.1 * rate])}

    Partner(node, control, bodies=[body], topics=[TOPICS[body]], spins=True).spin()


class Attacker:
    """Does one thing after the other; `done` counts them by name."""

    def __init__(self, node: Node, seed: int) -> None:
        self.dice = random.Random(seed)
        self.done: dict[str, int] = {}
        self.waits: dict[str, float] = {}  # [s] longest answer by name
        self._node = node
        self._seed = seed
        self._switches = {name: node.create_client(SetBool, f'/rigid_body_sim/{name}')
                          for name in ('pause', 'record')}  # fmt: skip
        self._triggers = {name: node.create_client(Trigger, f'/rigid_body_sim/{name}')
                          for name in ('step', 'reset')}  # fmt: skip
        self._parameters = node.create_client(SetParameters, '/rigid_body_sim/set_parameters')
        self._torque = node.create_publisher(Vector3Stamped, TOPICS['satellite'], of_commands())
        self._other = node.create_publisher(WrenchStamped, 'beacon/impulse', of_commands())
        self.partners = {body: self._start(body) for body in TOPICS}

    def _start(self, body: str) -> subprocess.Popen[bytes]:
        words = ['--partner', body, '--seed', str(self.dice.randrange(1000))]
        return subprocess.Popen([sys.executable, __file__, *words])

    def _ask(self, name: str, client: object, request: object) -> None:
        assert client.wait_for_service(ANSWER)  # type: ignore[attr-defined]
        for _ in range(round(ANSWER / ASK_AGAIN)):
            asked = time.monotonic()
            future = client.call_async(request)  # type: ignore[attr-defined]
            rclpy.spin_until_future_complete(self._node, future, timeout_sec=ASK_AGAIN)
            if future.done():
                break
        assert future.done(), f'{name} was not answered within {ANSWER} s'
        self.waits[name] = max(self.waits.get(name, 0.0), time.monotonic() - asked)

    def do(self, name: str) -> None:
        """Do one of `ACTS`."""
        self.done[name] = self.done.get(name, 0) + 1
        getattr(self, name)()

    def pause(self) -> None:
        """Pause or go on."""
        wanted = self.dice.random() < 0.4
        self._ask('pause', self._switches['pause'], SetBool.Request(data=wanted))

    def record(self) -> None:
        """Begin a bag, or end it."""
        wanted = self.dice.random() < 0.6
        self._ask('record', self._switches['record'], SetBool.Request(data=wanted))

    def step(self) -> None:
        """Step, paused or not, answered or not."""
        self._ask('step', self._triggers['step'], Trigger.Request())

    def reset(self) -> None:
        """Put everything back."""
        self._ask('reset', self._triggers['reset'], Trigger.Request())

    def factor(self) -> None:
        """Change the real-time factor."""
        value = self.dice.choice([0.0, 0.0, 0.5, 3.0])
        parameter = Parameter('real_time_factor', value=value).to_parameter_msg()
        self._ask('factor', self._parameters, SetParameters.Request(parameters=[parameter]))

    def rogue(self) -> None:
        """Answer what was not asked, with stamps of any time and things that are no numbers."""
        message = Vector3Stamped()
        message.header.stamp.sec = self.dice.choice([0, 0, 1, 100000])
        message.vector.x = self.dice.choice([1.0, float('nan'), 0.1])
        message.header.frame_id = self.dice.choice(['', 'nowhere', 'satellite'])
        self._torque.publish(message)

    def other(self) -> None:
        """Strike a body on a topic that nobody waits for."""
        message = WrenchStamped()
        message.wrench.force.x = self.dice.uniform(-0.001, 0.001)
        self._other.publish(message)

    def kill(self) -> None:
        """Kill a partner; another one takes over."""
        body = self.dice.choice(list(TOPICS))
        self.partners[body].kill()
        self.partners[body].wait()
        self.partners[body] = self._start(body)

    def close(self) -> None:
        """End the partners."""
        for partner in self.partners.values():
            partner.kill()
            partner.wait()


ACTS = {'pause': 3, 'record': 2, 'step': 2, 'reset': 2, 'factor': 1, 'rogue': 4, 'other': 2,
        'kill': 1}  # fmt: skip


def attack(folder: Path, seconds: float, seed: int) -> int:
    """Attack a node for a time and judge what is left; returns the number of faults."""
    settings = {
        'scene': 'satellite', 'real_time_factor': 0.0, 'step_mode': 'lockstep',
        'lockstep_topics': str(list(TOPICS.values())), 'lockstep_timeout': 0.5,
        'record': 'true', 'record_path': folder / 'bag', 'diagnostics_period': 0.1,
    }  # fmt: skip
    words = [word for name, value in settings.items() for word in ('-p', f'{name}:={value}')]
    log = folder / 'said'
    with log.open('w') as sink:
        process = subprocess.Popen(
            [sys.executable, '-m', 'rigid_body_sim', 'sim_node', '--ros-args', *words],
            stdout=sink, stderr=sink,
        )  # fmt: skip
    while 'ready:' not in log.read_text() and process.poll() is None:
        time.sleep(LOOK)
    rclpy.init()
    attacker = Attacker(rclpy.create_node('attacker'), seed)
    faults = 0
    try:
        end = time.monotonic() + seconds
        while time.monotonic() < end and process.poll() is None:
            attacker.do(attacker.dice.choices([*ACTS], [*ACTS.values()])[0])
            time.sleep(attacker.dice.choice([0.0, 0.01, 0.1, 0.5]))
    finally:
        process.send_signal(signal.SIGINT)
        code = process.wait(60)
        attacker.close()
        rclpy.try_shutdown()
    said = log.read_text()
    faults += _fault(code != 0, f'exit code {code}') + _fault('Traceback' in said, said)
    bags = sorted(folder.glob('bag*'))
    for bag in bags:
        replay = subprocess.run(
            [sys.executable, '-m', 'rigid_body_sim', 'replay', bag],
            check=False,
            capture_output=True,
            text=True,
        )
        faults += _fault(replay.returncode != 0, f'{bag.name}: {replay.stdout}{replay.stderr}')
        faults += _fault(
            not _in_step(bag), f'{bag.name}: answers that are not those of its states'
        )
    longest = ', '.join(f'{name} {wait:.3f} s' for name, wait in attacker.waits.items())
    print(f'seed {seed}: {attacker.done}; {len(bags)} bags; longest answers: {longest}')
    print(said.splitlines()[-2] if said else '')
    return faults


def _in_step(path: Path) -> bool:
    """Whether each instant took one answer a topic, in the order of the list, with its stamp."""
    wanted = [f'/{topic}' for topic in TOPICS.values()]
    messages = list(Bag(path).messages(wanted))
    order = [message.topic for message in messages]
    stamps = [stamp_of(message.data) for message in messages]
    times = [message.log_time for message in messages]
    whole = order == wanted * (len(order) // len(wanted))
    return whole and stamps == times and len(set(times)) * len(wanted) == len(times)


def _fault(is_one: bool, text: str) -> int:
    if is_one:
        print(f'FAULT: {text}', file=sys.stderr)
    return int(is_one)


def main() -> int:
    """Attack and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--seconds', type=float, default=30.0)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--partner', choices=TOPICS, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.partner:
        answer(given.partner, given.seed)
        return 0
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)  # hear nobody else
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    with tempfile.TemporaryDirectory() as folder:
        return 1 if attack(Path(folder), given.seconds, given.seed) else 0


if __name__ == '__main__':
    sys.exit(main())
