# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A headless Chromium that draws a page and tells what it did: its errors, its requests, its answers.

It is spoken to in the DevTools protocol over a pipe, so that no driver and no port is needed.
"""

from __future__ import annotations

import base64
import contextlib
import fcntl
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import RunError

PATIENCE = 300.0  # [s] for one answer: only what hangs fails, never what is slow

NAMES = ('chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable')
FLAGS = (
    '--headless=new',
    '--no-sandbox',
    '--enable-unsafe-swiftshader',  # WebGL, also where there is no graphics card
    '--use-angle=swiftshader',
    '--disable-dev-shm-usage',
    '--no-first-run',
    '--disable-background-networking',
    '--remote-debugging-pipe',
)
# The browser reads 3 and writes 4: this little program puts the pipes there and becomes it.
PIPES = """
import os, sys
os.dup2(int(sys.argv[1]), 3)
os.dup2(int(sys.argv[2]), 4)
os.execv(sys.argv[3], sys.argv[3:])
"""
FREE = 100  # file descriptors from here on are not 3 and 4, which the browser wants


def find() -> str | None:
    """Path of a Chromium; None if there is none."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Page:
    """
    One tab.

    errors   : what went to the console as an error or a warning, and exceptions, since `open`
    requests : addresses asked for since then
    scale    : [-] pixels that are drawn for each CSS pixel; few cost little, where nobody looks
    """

    def __init__(self, send: int, receive: int) -> None:
        self._send, self._receive = send, receive
        self._buffer = b''
        self._last = 0
        self._session: str | None = None
        self.scale = 1.0
        self.errors: list[str] = []
        self.requests: list[str] = []
        self._seen: list[str] = []
        target = self.ask('Target.createTarget', url='about:blank')['targetId']
        attached = self.ask('Target.attachToTarget', targetId=target, flatten=True)
        self._session = attached['sessionId']
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.ask(f'{domain}.enable')

    def ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result."""
        self._last += 1
        message: dict[str, Any] = {'id': self._last, 'method': method, 'params': parameters}
        if self._session:
            message['sessionId'] = self._session
        os.write(self._send, json.dumps(message).encode() + b'\0')
        deadline = time.monotonic() + PATIENCE
        while True:
            answer = self._next(deadline)
            if answer.get('id') == self._last:
                if 'error' in answer:
                    raise RunError(f'the browser refused {method}: {answer["error"]}')
                return answer['result']

    def _next(self, deadline: float) -> dict[str, Any]:
        while b'\0' not in self._buffer:
            ready, _, _ = select.select([self._receive], [], [], deadline - time.monotonic())
            if not ready:
                raise RunError(f'the browser did not answer within {PATIENCE:g} s')
            more = os.read(self._receive, 1 << 16)
            if not more:
                raise RunError('the browser has ended before its answer')
            self._buffer += more
        line, _, self._buffer = self._buffer.partition(b'\0')
        message = json.loads(line)
        self._note(message.get('method', ''), message.get('params', {}))
        return message

    def _note(self, event: str, about: dict[str, Any]) -> None:
        self._seen.append(event)
        if event == 'Network.requestWillBeSent':
            self.requests.append(about['request']['url'])
        elif event == 'Runtime.exceptionThrown':
            details = about['exceptionDetails']
            self.errors.append(details.get('exception', {}).get('description', details['text']))
        elif event == 'Runtime.consoleAPICalled' and about['type'] in ('error', 'warning'):
            self.errors.append(str([each.get('value') for each in about['args']]))
        elif event == 'Log.entryAdded' and about['entry']['level'] in ('error', 'warning'):
            self.errors.append(about['entry']['text'])

    def open(self, address: str, *, width: int = 1280, height: int = 900) -> None:
        """Go to an address and wait until it is loaded and drawn."""
        self.resize(width, height)
        for known in (self._seen, self.errors, self.requests):
            known.clear()
        self.ask('Page.navigate', url=address)
        deadline = time.monotonic() + PATIENCE
        while 'Page.loadEventFired' not in self._seen:
            self._next(deadline)
        self.settle()

    def resize(self, width: int, height: int = 900) -> None:
        """Change the size of the window [CSS pixel]."""
        self.ask(
            'Emulation.setDeviceMetricsOverride',
            width=width,
            height=height,
            deviceScaleFactor=self.scale,
            mobile=False,
        )

    def settle(self) -> None:
        """Wait until two frames have been drawn."""
        self.evaluate(
            'new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))'
        )

    def evaluate(self, expression: str) -> Any:
        """Value of an expression in the page; a promise is waited for."""
        answer = self.ask(
            'Runtime.evaluate', expression=expression, awaitPromise=True, returnByValue=True
        )
        if 'exceptionDetails' in answer:
            raise RunError(f'the page failed: {answer["exceptionDetails"]}')
        return answer['result'].get('value')

    def wait_for(self, condition: str) -> None:
        """Wait until an expression in the page is true."""
        deadline = time.monotonic() + PATIENCE
        while not self.evaluate(condition):
            if time.monotonic() > deadline:
                raise RunError(f'the page did not come to {condition} within {PATIENCE:g} s')
            time.sleep(0.05)

    def picture(self, *, whole: bool = False) -> bytes:
        """What is to be seen as PNG; `whole`: also what one would have to scroll to."""
        shot = self.ask('Page.captureScreenshot', format='png', captureBeyondViewport=whole)
        return base64.b64decode(shot['data'])


@contextlib.contextmanager
def page(profile: Path) -> Iterator[Page]:
    """
    Start a browser with one tab, and end it.

    profile : empty folder for what it keeps
    """
    program = find()
    if program is None:
        raise RunError(f'no browser found; one of {", ".join(NAMES)} has to be on the path')
    in_read, in_write = (_high(end) for end in os.pipe())
    out_read, out_write = (_high(end) for end in os.pipe())

    words = (*FLAGS, f'--user-data-dir={profile}')
    process = subprocess.Popen(
        [sys.executable, '-ISc', PIPES, str(in_read), str(out_write), program, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        pass_fds=(in_read, out_write),
        # it ends without a word where $TMPDIR cannot be written; Python looks for one that can
        env=os.environ | {'TMPDIR': tempfile.gettempdir()},
    )
    os.close(in_read)
    os.close(out_write)
    try:
        yield Page(in_write, out_read)
    finally:
        os.close(in_write)
        try:
            process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        os.close(out_read)


def _high(descriptor: int) -> int:
    """Move a file descriptor out of the way of 3 and 4."""
    moved = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, FREE)
    os.close(descriptor)
    return moved
