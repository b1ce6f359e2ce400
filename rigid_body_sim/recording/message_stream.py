# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The messages of a recording in file order: one by one, or compared as the bytes that they are.

Two message records are the same where their bytes are: so a replay need not take apart what it
made itself. Only where bytes differ, or channels have other numbers, is it told message by message
in what.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import mcap_file, mcap_scan
from rigid_body_sim.recording.recorded_message import RecordedMessage


class MessageStream:
    """
    A reader that goes through the messages of the files of a bag once.

    files   : in order
    names   : of each file: channel id -> name that the run gives the topic
    damaged : makes the error for a file that is torn
    """

    def __init__(
        self,
        files: Sequence[Path],
        names: Sequence[Mapping[int, str]],
        damaged: Callable[[Path, mcap_scan.Torn], UserError],
    ) -> None:
        self._names = names
        self._damaged = damaged
        self._bodies = self._all_bodies(files)
        self._body = b''
        self._place = 0  # [bytes] in the body
        self._record = mcap_scan.Record(0, 0, b'')  # which held it
        self._file = files[0]
        self._known: Mapping[int, str] = {}

    def has_numbers(self, topics: Sequence[str]) -> bool:
        """Tell whether topics[i] has channel id i + 1 in every file."""
        numbered = dict(enumerate(topics, start=1))
        return all(numbered.items() <= dict(names).items() for names in self._names)

    def take(self, records: bytes) -> bool:
        """Go past message records if they come next, byte by byte; else stay."""
        while len(self._body) - self._place < len(records):
            rest = self._body[self._place :]
            if not self._next_body():
                self._body, self._place = rest, 0
                return False
            self._body, self._place = rest + self._body, 0
        if not self._body.startswith(records, self._place):
            return False
        self._place += len(records)
        return True

    def next(self) -> RecordedMessage | None:
        """Take the next message; None behind the last one."""
        while True:
            while self._place == len(self._body):
                if not self._next_body():
                    return None
            try:
                found, self._place = mcap_scan.message_at(self._body, self._place, self._record)
                if found is None:
                    continue
                if found.channel not in self._known:
                    problem = f'message of the unknown channel {found.channel}'
                    raise mcap_scan.Torn(self._record.position, problem)
            except mcap_scan.Torn as error:
                raise self._damaged(self._file, error) from error
            _, sequence, log_time, publish_time, data = found
            return RecordedMessage(
                self._known[found.channel], sequence, log_time, data, publish_time
            )

    def _next_body(self) -> bool:
        self._place = 0
        self._body = next(self._bodies, b'')
        return bool(self._body)

    def _all_bodies(self, files: Sequence[Path]) -> Iterator[bytes]:
        """Yield the bytes of all message records, chunk by chunk."""
        for file, known in zip(files, self._names, strict=True):
            self._file, self._known = file, known
            with file.open('rb') as stream:
                try:
                    for record in mcap_scan.records(stream, message_indexes=False):
                        self._record = record
                        if record.opcode == mcap_file.CHUNK:
                            yield mcap_scan.opened_chunk(record)[1]
                        elif record.opcode == mcap_file.MESSAGE:
                            yield mcap_scan.framed(record)
                        elif record.opcode == mcap_file.DATA_END:
                            break
                except mcap_scan.Torn as error:
                    raise self._damaged(file, error) from error
