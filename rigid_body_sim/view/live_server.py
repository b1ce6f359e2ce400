# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Serves the page of a run that goes on: a small HTTP server on the loopback of this machine.

    /                     the page, with all that was there when it was asked for
    /events?run=R&after=K the blocks after the first K of a run as server-sent events, as they come

A block is what came between two looks. A run is what one page shows: where another one has begun,
here or in a server that was started at this address since, or where the blocks after the first K
are no longer apart, the event `begin` lets the page load itself anew.

Nobody but this machine is served: the address is that of the loopback, and a request under another
host name is refused.
"""

from __future__ import annotations

import base64
import json
import secrets
import threading
from dataclasses import replace
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.forces.acting_elements import is_timed
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.stop_signals import STOP, Stopped
from rigid_body_sim.view.drawn_part import drawn_part, until_beyond
from rigid_body_sim.view.growing_motion import joined, size_of, thinned
from rigid_body_sim.view.page_record import Look, more_of
from rigid_body_sim.view.playback_page import live_page
from rigid_body_sim.view.recorded_motion import RecordedMotion

LOOPBACK = '127.0.0.1'
LOOK = 0.1  # [s] between looks at what has come
ALIVE = 5.0  # [s] between signs of life to a browser, which show that it has gone
MOST_BYTES = 1 << 26  # [byte] of motion that are kept: of more, older blocks are thinned
UNKNOWN_BEGIN = 'nobody tells of a reset: forces over time count from t = 0'
YOUNGEST = 20  # blocks that stay as they came: 2 s, by which a browser may be behind


class Source(Protocol):
    """
    Where states come from.

    scene, title, about : known after `begin`
    ended               : whether nothing more will come
    run                 : number of the run that blocks are of
    """

    scene: Scene | None
    title: str
    about: str
    ended: bool

    @property
    def run(self) -> int:
        """Another number after another run has begun."""
        ...

    def begin(self) -> RecordedMotion:
        """Give the first block; waits for it."""
        ...

    def more(self) -> RecordedMotion | None:
        """Give what came since, if anything."""
        ...


class LiveRun:
    """
    What has come so far, for all browsers.

    name : of the run that is shown, which no other has
    size : of all that is kept of it [byte]
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self._changed = threading.Condition()
        self.stopped = False
        self._begin(source.begin())
        self._is_whole = source.ended

    def _begin(self, block: RecordedMotion) -> None:
        """Begin a run with its first block."""
        block = drawn_part(block, name=self.source.title)
        self._beyond = block.beyond
        self._run = self.source.run
        self._blocks = [block]
        self._numbers = [1]  # of the last that came of what is in each block
        self.size = size_of(block)
        self._renew()

    def _renew(self) -> None:
        """Let every page that is open load itself anew."""
        self.name = secrets.token_hex(8)
        _, self._look = live_page(joined(self._blocks), self.source.scene, title='')

    def look(self) -> None:
        """Take what has come."""
        block = self.source.more()
        with self._changed:
            if block is not None and self.source.run != self._run:
                self._begin(block)
            elif block is not None:
                self._take(block)
            # not before its last block is here, or who streams would end without it
            self._is_whole = self.source.ended
            if block is not None or self._is_whole:
                self._changed.notify_all()

    def _take(self, block: RecordedMotion) -> None:
        """Put a block behind the others; of a run that diverges what can be drawn of it."""
        if self._beyond is not None:
            return
        block = until_beyond(block)
        self._beyond = block.beyond
        if not all(len(track.time) for track in block.tracks):
            return
        was_known = block.began == self._blocks[-1].began
        self._blocks.append(block)
        self._numbers.append(self._numbers[-1] + 1)
        self.size += size_of(block)
        if self.size > MOST_BYTES and len(self._blocks) > 2 * YOUNGEST:
            self._thin()
        if not was_known:  # instants that went out since the reset counted from before it
            self._renew()

    def _thin(self) -> None:
        """Make one block of the older ones, with as many instants as half of the room takes."""
        older = joined(self._blocks[:-YOUNGEST])
        count = len(older.tracks[0].time)
        older = thinned(older, count * MOST_BYTES // (2 * size_of(older)))
        self._blocks[:-YOUNGEST] = [older]
        del self._numbers[: -YOUNGEST - 1]
        self.size = sum(map(size_of, self._blocks))

    def stop(self) -> None:
        """Send everybody home."""
        with self._changed:
            self.stopped = True
            self._changed.notify_all()

    def page(self) -> str:
        """Write the page of all that has come."""
        with self._changed:
            blocks, told, name = list(self._blocks), self._numbers[-1], self.name
            source, beyond = self.source, self._beyond
            scene, title = source.scene, source.title
            motion = replace(joined(blocks), beyond=beyond)
            is_told = scene is None or not is_timed(scene) or motion.begin_is_known
            note = '' if is_told else UNKNOWN_BEGIN
            about = ' · '.join(filter(None, (source.about, note, 'live')))
        page, _ = live_page(
            motion,
            scene,
            title=title,
            about=about,
            live={'told': told, 'run': name},
        )
        return page

    def after(self, run: str, told: int) -> tuple[int, str | None] | None:
        """
        Wait for what is after the first blocks of a run.

        returns : their number then, and what is new as a page takes it, None for nothing; None:
                  that cannot be told, as another run is shown or the blocks are apart no more
        """
        with self._changed:
            if run == self.name and self._numbers[-1] <= told and not self.ended:
                self._changed.wait(ALIVE)
            if run != self.name or told not in self._numbers:
                return None
            known, look = self._numbers[-1], self._look
            new = self._blocks[self._numbers.index(told) + 1 :]
        return known, _event(joined(new), look) if new else None

    @property
    def ended(self) -> bool:
        """Whether nothing more will come."""
        return self._is_whole or self.stopped


def _event(motion: RecordedMotion, look: Look) -> str:
    """Write a block as a page takes it."""
    record, numbers = more_of(motion, look)
    return json.dumps({'record': record, 'numbers': base64.b64encode(numbers).decode()})


class _Handler(BaseHTTPRequestHandler):
    @property
    def _run(self) -> LiveRun:
        assert isinstance(self.server, Server)
        return self.server.run

    def do_GET(self) -> None:
        """Answer a browser."""
        host = self.headers.get('Host', '').partition(':')[0]
        address = urlsplit(self.path)
        if host not in (LOOPBACK, 'localhost'):
            self.send_error(HTTPStatus.FORBIDDEN, f'serves {LOOPBACK} only')
        elif address.path == '/':
            self._send(self._run.page().encode(), 'text/html; charset=utf-8')
        elif address.path == '/events':
            self._stream(parse_qs(address.query))
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def _send(self, content: bytes, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header('Content-Type', kind)
        self.send_header('Content-Length', str(len(content)))
        self.send_header('Cache-Control', 'no-store')
        self.end_headers()
        self.wfile.write(content)

    def _stream(self, query: dict[str, list[str]]) -> None:
        told = self.headers.get('Last-Event-ID') or query.get('after', ['0'])[0]
        if not told.isdecimal():
            self.send_error(HTTPStatus.BAD_REQUEST, 'after: a number of blocks')
            return
        self.send_response(HTTPStatus.OK)
        self.send_header('Content-Type', 'text/event-stream')
        self.send_header('Cache-Control', 'no-store')
        self.end_headers()
        run, known, name = self._run, int(told), query.get('run', [''])[0]
        try:
            while True:
                ended = run.ended
                news = run.after(name, known)
                if news is None:
                    self._write('event: begin\ndata:\n\n')
                    return
                known, event = news
                if event is not None:
                    self._write(f'id: {known}\ndata: {event}\n\n')
                elif ended:
                    self._write('event: end\ndata:\n\n')
                    return
                else:
                    self._write(': here\n\n')
        except OSError:  # the browser has gone
            return

    def _write(self, text: str) -> None:
        self.wfile.write(text.encode())
        self.wfile.flush()

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing of each request."""


class Server(ThreadingHTTPServer):
    """The server of one run."""

    daemon_threads = True

    def __init__(self, port: int, run: LiveRun) -> None:
        self.run = run
        super().__init__((LOOPBACK, port), _Handler)


def serve(source: Source, *, port: int) -> int:
    """
    Serve until a signal comes; returns the exit code, 0: that is how it ends. Stopped by one that
    comes before there is anything to serve.
    """
    STOP.keep()
    run = LiveRun(source)
    try:
        server = Server(port, run)
    except OSError as error:
        raise UserError(f'--port {port}: cannot be had ({error.strerror})') from error
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    print(f'http://{LOOPBACK}:{server.server_port}/  (Ctrl-C ends)', flush=True)
    try:
        _go_on(run)
    finally:
        run.stop()
        server.shutdown()
        server.server_close()
    return 0


def _go_on(run: LiveRun) -> None:
    waiting = threading.Event()
    while not STOP.number:
        try:
            run.look()  # also of what has ended: another run may come in its place
        except Stopped:  # while it waited for another run
            return
        except RunError:
            run.stop()
            raise
        waiting.wait(LOOK)
