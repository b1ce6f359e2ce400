# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The node of a test: a process whose words are read as they come, and which is gone in the end.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from rigid_body_sim.testing.failures import NodeFailure, with_last_lines

READY = re.compile(r'\bready: ')
REFUSAL = re.compile(r'^rigid_body_sim sim_node: error: .*$', re.MULTILINE)
SILENCE = 300.0  # [s] without a word before it is ready; compiling a kernel takes some 20
ENDING = 60.0  # [s] from SIGINT to the end; a bag is closed and words are sent within 1


class NodeProcess:
    """
    `sim_node` in a process of its own.

    words       : arguments for ROS
    folder      : where it runs
    environment : all of it
    """

    def __init__(
        self, words: Sequence[str], *, folder: Path, environment: Mapping[str, str]
    ) -> None:
        child = [sys.executable, '-m', 'rigid_body_sim.testing.child', str(os.getpid())]
        self._lines: list[str] = []
        self._is_ready = self._is_silent = False
        self._changed = threading.Condition()
        self._process = subprocess.Popen(
            [*child, 'sim_node', '--ros-args', *words],
            cwd=folder,
            env=dict(environment),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding='utf-8',
            errors='replace',  # who is killed may leave half a letter
        )
        # a pipe that nobody reads stops the node as soon as it is full
        self._reader = threading.Thread(target=self._read, name='node_output', daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with self._changed:
                self._lines.append(line)
                self._is_ready = self._is_ready or READY.search(line) is not None
                self._changed.notify_all()
        with self._changed:
            self._is_silent = True
            self._changed.notify_all()

    @property
    def said(self) -> str:
        """What it wrote so far."""
        return ''.join(self._lines)

    @property
    def exit_code(self) -> int | None:
        """How it ended; None while it runs."""
        return self._process.poll()

    @property
    def pid(self) -> int:
        """Number of its process."""
        return self._process.pid

    def wait_until_ready(self) -> None:
        """Wait until it is ready; NodeFailure, with its own words, if it ends or hangs."""
        with self._changed:
            while not self._is_ready:
                words = len(self._lines)
                if self._is_silent:
                    break
                if not self._changed.wait(SILENCE) and len(self._lines) == words:
                    raise NodeFailure(
                        with_last_lines(f'the node is not ready after {SILENCE:g} s', self.said)
                    )
        if not self._is_ready:
            raise self.ended('before it was ready')

    def ended(self, when: str) -> NodeFailure:
        """Say how it ended: by its own one line where it refused something."""
        code = self._wait(ENDING)
        if code is None:  # its output is closed, itself not
            self.kill()
            code = self._process.returncode
        refusal = REFUSAL.search(self.said)
        if code == 2 and refusal:
            return NodeFailure(refusal.group())
        return NodeFailure(with_last_lines(f'the node ended {when}, {_by(code)}', self.said))

    def check(self, when: str) -> None:
        """NodeFailure if it has ended."""
        if self._process.poll() is not None:
            raise self.ended(when)

    def stop(self) -> None:
        """End it by SIGINT; NodeFailure unless it exits with 0."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            if self._wait(ENDING) is None:
                raise NodeFailure(
                    with_last_lines(
                        f'the node did not end within {ENDING:g} s of SIGINT', self.said
                    )
                )
        self._reader.join(ENDING)
        code = self._process.returncode
        if code != 0:
            raise NodeFailure(
                with_last_lines(f'the node ended {_by(code)} in place of 0', self.said)
            )

    def kill(self) -> None:
        """Make sure that it is gone."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._reader.join(ENDING)
        if not self._reader.is_alive() and self._process.stdout is not None:
            self._process.stdout.close()

    def _wait(self, seconds: float) -> int | None:
        deadline = time.monotonic() + seconds
        while self._process.poll() is None:
            left = deadline - time.monotonic()
            if left <= 0.0:
                return None
            try:
                self._process.wait(left)
            except subprocess.TimeoutExpired:
                return None
        self._reader.join(ENDING)
        return self._process.returncode


def _by(code: int) -> str:
    """Say in words what an exit code means."""
    if code >= 0:
        return f'with exit code {code}'
    try:
        return f'by {signal.Signals(-code).name}'
    except ValueError:
        return f'by signal {-code}'
