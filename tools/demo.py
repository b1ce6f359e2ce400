# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`make demo`: the node on a scene of several bodies, commands from a second process, a bag, its
replay, a picture.

Everything is done with the verbs as a user would call them; each line printed is one of them.
"""

from __future__ import annotations

import os
import selectors
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

from tqdm import tqdm

ROOT = Path(__file__).parents[1]
SCENE = ROOT / 'config' / 'scenes' / 'demo.yaml'
VERB = [sys.executable, '-m', 'rigid_body_sim']
STEPS = 5
READY_WITHIN = 60.0  # [s] a cold machine compiles first
FLIGHT = 5.0  # [s] of real time under command


class Step:
    """One numbered line of the demo, with a bar that moves while it lasts."""

    count = 0

    def __init__(self, text: str, *, seconds: float) -> None:
        Step.count += 1
        print(f'{Step.count}/{STEPS} {text}', flush=True)
        self._end = time.monotonic() + seconds
        self._bar = tqdm(
            total=round(seconds, 1),
            bar_format='    {bar:40} {n:.0f} s',
            leave=False,
            disable=not sys.stderr.isatty(),
        )

    def wait(self, until, *, failed: str) -> None:
        """Wait until `until` is true; it is asked ten times a second and may wait itself."""
        begin = time.monotonic()
        while not until():
            self._bar.n = min(time.monotonic() - begin, self._bar.total)
            self._bar.refresh()
            if time.monotonic() > self._end:
                self._bar.close()
                raise SystemExit(f'demo: {failed}')
        self._bar.close()


def shown(words: list[str]) -> str:
    """Write a command as a user would type it."""
    short = [
        word.replace(f'{ROOT}{os.sep}', '').replace(sys.executable, 'python') for word in words
    ]
    return shlex.join(short)


def call(*words: object) -> None:
    """Call a verb and show what it says."""
    command = [*VERB, *map(str, words)]
    print(f'    $ {shown(command)}', flush=True)
    result = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    for line in (result.stdout + result.stderr).splitlines():
        print(f'      {line}')
    if result.returncode:
        raise SystemExit(f'demo: this ended with exit code {result.returncode}')


def start(*words: object) -> subprocess.Popen[str]:
    """Start a verb that goes on by itself."""
    command = [*VERB, *map(str, words)]
    print(f'    $ {shown(command)} &', flush=True)
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT, bufsize=1
    )


def lines_of(process: subprocess.Popen[str], said: list[str]):
    """
    Make a question that reads what a process says for a tenth of a second and tells whether it is
    ready.
    """
    assert process.stdout is not None
    selector = selectors.DefaultSelector()
    selector.register(process.stdout, selectors.EVENT_READ)

    def ready() -> bool:
        if selector.select(timeout=0.1):
            said.append(process.stdout.readline().rstrip())
        if process.poll() is not None:
            raise SystemExit('demo: the node ended early:\n' + '\n'.join(said))
        return any('ready:' in line for line in said)

    return ready


def main() -> None:
    """Run the demo."""
    folder = ROOT / 'demo_output' / time.strftime('%Y%m%d_%H%M%S')
    folder.mkdir(parents=True)
    bag, picture = folder / 'run', folder / 'run.png'
    began = time.monotonic()

    step = Step('the node, recording', seconds=READY_WITHIN)
    parameters = {'scene': SCENE, 'record': 'true', 'record_path': bag}
    words = [word for name, value in parameters.items() for word in ('-p', f'{name}:={value}')]
    node = start('sim_node', '--ros-args', *words)
    said: list[str] = []
    try:
        step.wait(
            lines_of(node, said), failed='the node was not ready in time:\n' + '\n'.join(said)
        )
        print(f'      {said[-1]}')

        step = Step('commands from other processes over DDS', seconds=60)
        pushes = [
            start('wrench_pub', 'box', '--force', 0.5, 0, 0.2, '--for', FLIGHT),
            start('wrench_pub', 'can', '--torque', 0, 0, 0.02, '--frame', 'body', '--for', FLIGHT),
            start('wrench_pub', 'cross', '--impulse', '--force', 0, 0.3, 0),
        ]
        step.wait(lambda: _ended(pushes), failed='the commands did not end in time')

        step = Step('SIGINT: the node closes the bag', seconds=20)
        node.send_signal(signal.SIGINT)
        step.wait(lambda: _ended([node]), failed='the node did not end')
    finally:
        if node.poll() is None:
            node.kill()

    Step('the bag alone gives the same run again', seconds=60)
    call('replay', bag)
    Step('a picture', seconds=60)
    call('view', bag, '-o', picture)
    print(f'\nDone in {time.monotonic() - began:.0f} s. Look at')
    for label, path in (('bag', bag), ('picture', picture)):
        print(f'  {label + ":":9}{path}')
    print(f'  try next: {shown([*VERB, "replay", str(bag), "--integrator", "rk4"])}')


def _ended(processes: list[subprocess.Popen[str]]) -> bool:
    """Tell whether all have ended; SystemExit if one failed."""
    time.sleep(0.1)
    for process in processes:
        if process.poll():
            output = process.stdout.read() if process.stdout else ''
            raise SystemExit(
                f'demo: {shown(process.args)} ended with exit code {process.returncode}:\n{output}'
            )
    return all(process.poll() is not None for process in processes)


if __name__ == '__main__':
    main()
