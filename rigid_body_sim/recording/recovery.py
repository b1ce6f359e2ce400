# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Restores a recording that was cut off, by SIGKILL, a power failure, or a full disk, or damaged.

What is whole is copied; indexes, summary and metadata.yaml are built anew. Of our own recordings
the last incomplete tick is dropped, so that the copy ends where a tick ends: a tick is whole when
clock, poses and twists of every body have it as their sequence. The source is never changed.

A chunk that does not match its CRC ends the good part: what comes after it would hide the gap. Any
other record that cannot be read is left out. Where the source was not only cut off but altered,
the copy says so (`suspect`), and so does a copy of the copy; a manifest that is not what was
recorded is not copied: messages alone can still be looked at, but claim nothing.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.records import Attachment, Channel, Header, McapRecord, Metadata, Schema

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import bag_directory, cdr, mcap_file, mcap_scan, mcap_summary
from rigid_body_sim.recording.bag_copy import BagCopy
from rigid_body_sim.recording.bag_files import lone_file
from rigid_body_sim.recording.bag_reader import RECOVERED, SUSPECT
from rigid_body_sim.recording.bag_writer import ENDING, MANIFEST
from rigid_body_sim.recording.seal import (
    ATTACHMENTS,
    MESSAGES_CRC,
    altered_files,
    crc_text,
    is_broken,
)

STATE_TYPES = {cdr.Clock.TYPE, cdr.PoseStamped.TYPE, cdr.TwistStamped.TYPE}
_KINDS: dict[int, type[McapRecord]] = {
    mcap_file.HEADER: Header,
    mcap_file.METADATA: Metadata,
    mcap_file.ATTACHMENT: Attachment,
}
_MOST_IDS = 65535  # channel ids and schema ids are 16 bits, from 1
_MOST_REASONS = 5  # told of what was left out


class Recovery(NamedTuple):
    """
    What was saved.

    messages  : number of messages in the copy
    dropped   : whole messages left out because their tick is not
    last_tick : the last whole tick; None in recordings that have no ticks
    torn_at   : [bytes] where the good part of the source ends; None when all of it was good
    problem   : what stands there
    """

    messages: int
    dropped: int
    last_tick: int | None
    torn_at: int | None
    problem: str


@dataclass
class _Survey:
    """
    What of a source is good.

    header      : None where it cannot be read
    seen        : good messages
    whole       : of these, up to the last whole tick
    problems    : why records were left out, or that the whole is not what was written
    torn        : what ended the good part
    finished    : whether the source has the end that a recorder writes when it closes a bag
    """

    declared: _Declared
    header: Header | None = None
    seen: int = 0
    whole: int = 0
    last_tick: int | None = None
    manifest: dict[str, str] = field(default_factory=dict)
    ending: dict[str, str] | None = None
    recovered: dict[str, str] | None = None
    crc: int = 0
    attachments: dict[str, bytes] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    torn: mcap_scan.Torn | None = None
    finished: bool = False
    _tick: int = -1
    _arrived: set[int] = field(default_factory=set)

    def take(self, record: mcap_scan.Record, content: McapRecord | mcap_scan.Message) -> None:
        """Count one good record."""
        if isinstance(content, mcap_scan.Message):
            self.seen += 1
            self.crc = mcap_scan.message_crc(record, self.crc)
            self._follow_ticks(content)
        elif isinstance(content, Header):
            self.header = content
        elif isinstance(content, Attachment):
            self.attachments[content.name] = content.data
        elif isinstance(content, Metadata) and content.name == MANIFEST:
            self.manifest = content.metadata
        elif isinstance(content, Metadata) and content.name == ENDING:
            self.ending = content.metadata
        elif isinstance(content, Metadata) and content.name == RECOVERED:
            self.recovered = content.metadata

    def _follow_ticks(self, message: mcap_scan.Message) -> None:
        states = self.declared.states
        if message.channel not in states:
            return
        if message.sequence != self._tick:
            self._tick, self._arrived = message.sequence, set()
        self._arrived.add(message.channel)
        if self._arrived == states:
            self.whole, self.last_tick = self.seen, self._tick

    def close(self) -> None:
        """Judge what was found."""
        if not self.manifest or not self.declared.states:
            self.whole, self.last_tick = self.seen, None
        elif self.torn is None or self.ending is not None:  # whatever was lost, no message was
            self.whole = self.seen if self.last_tick is not None else 0

    @property
    def copies_run(self) -> bool:
        """Whether manifest and attachments are those that were recorded, as far as they tell."""
        altered = altered_files(self.manifest.get(ATTACHMENTS), self.attachments)
        return not is_broken(self.manifest) and not altered

    @property
    def suspicion(self) -> str:
        """What shows that the source was altered and not only cut off; empty if nothing does."""
        if not self.copies_run:
            return 'the manifest or an attachment is not what was recorded'
        if any(is_broken(record) for record in self._closing):
            return 'the ending record is not what was recorded'
        if known := [record[SUSPECT] for record in self._closing if SUSPECT in record]:
            return known[0]
        if sums := {record[MESSAGES_CRC] for record in self._closing if MESSAGES_CRC in record}:
            return '' if sums == {crc_text(self.crc)} else 'the messages are not what was recorded'
        lost = self.finished and self.manifest and not self._closing
        return '; '.join(
            [
                *self.problems,
                *([str(self.torn)] if isinstance(self.torn, mcap_scan.Altered) else []),
                *(['the ending record is missing, and nothing was cut off'] if lost else []),
            ]
        )

    @property
    def _closing(self) -> list[dict[str, str]]:
        """What the source says of its end: of the run, of a recovery before."""
        return [record for record in (self.ending, self.recovered) if record is not None]


class _Declared:
    """
    The schemas and channels of a source; those of a good summary are preferred, its CRC protects
    them.

    problems : which declarations were left out, and why
    """

    def __init__(self, stream: BinaryIO) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.states: set[int] = set()
        self.problems: list[str] = []
        self._types: dict[str, str] = {}
        with suppress(mcap_scan.Torn):
            summary = mcap_summary.read_summary(stream)
            if summary.has_crc:
                for stated in (*summary.schemas.values(), *summary.channels.values()):
                    self._take(stated)
        with suppress(mcap_scan.Torn):
            for record in _unpacked(stream):
                if record.opcode in (mcap_file.SCHEMA, mcap_file.CHANNEL):
                    self._read(record)

    def _read(self, record: mcap_scan.Record) -> None:
        try:
            content = record.parse(Schema if record.opcode == mcap_file.SCHEMA else Channel)
        except mcap_scan.Torn as error:
            problem = str(error)
        else:
            if self._take(content):
                return
            problem = f'at byte {record.position}: a declaration contradicts another'
        if len(self.problems) < _MOST_REASONS:
            self.problems.append(problem)

    def _take(self, record: Schema | Channel) -> bool:
        """Keep a declaration; false where it contradicts another or there are too many."""
        if isinstance(record, Schema):
            good = record.id > 0 and len(self.schemas) < _MOST_IDS
            return good and self.schemas.setdefault(record.id, record) == record
        if record.id in self.channels:
            return self.channels[record.id] == record
        schema = self.schemas.get(record.schema_id)
        kind = '' if schema is None else schema.name
        lost = schema is None and record.schema_id != 0
        if lost or self._types.setdefault(record.topic, kind) != kind:
            return False
        if len(self.channels) == _MOST_IDS:
            return False
        self.channels[record.id] = record
        if kind in STATE_TYPES:
            self.states.add(record.id)
        return True


def recover(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> Recovery:
    """
    Copy what is whole in `source` (bag directory or .mcap file) to the new bag directory `target`.

    UserError for paths that cannot be used; RunError when there is nothing to save.
    """
    file = lone_file(Path(source))
    try:
        stream = file.open('rb')
    except OSError as error:
        raise UserError(f'{file}: cannot be read ({error.strerror})') from error
    with stream:
        survey = _survey(stream, file)
        problem = '; '.join([*survey.problems, *([str(survey.torn)] if survey.torn else [])])
        found = Recovery(
            survey.whole,
            survey.seen - survey.whole,
            survey.last_tick,
            survey.torn.position if survey.torn else None,
            problem,
        )
        if found.messages == 0:
            raise RunError(
                f'{file}: nothing to save: {found.dropped} whole messages, no whole tick '
                f'({problem or "the recording is empty"})'
            )
        _copy(stream, survey, found, Path(target))
    return found


def _survey(stream: BinaryIO, file: Path) -> _Survey:
    """Find out which records are good, and where the last whole tick ends."""
    declared = _Declared(stream)
    survey = _Survey(declared, problems=list(declared.problems))
    try:
        for record, content in _good_records(stream, declared, survey.problems):
            survey.take(record, content)
        survey.finished = True
    except mcap_scan.WrongSum as error:
        survey.problems.append(str(error))
        survey.finished = True
    except mcap_scan.Torn as error:
        if error.position == 0:
            raise UserError(f'{file}: not a bag: {error}') from error
        survey.torn = error
    survey.close()
    return survey


def _copy(stream: BinaryIO, survey: _Survey, found: Recovery, target: Path) -> None:
    """Write the good records, up to the last whole tick, to a new bag."""
    bag_directory.create(target)
    note = {
        'recovered': 'true',
        'last_tick': '' if found.last_tick is None else str(found.last_tick),
        'dropped': str(found.dropped),
        'problem': found.problem,
        **({SUSPECT: survey.suspicion} if survey.suspicion else {}),
    }
    left_out = set() if survey.copies_run else {MANIFEST, ENDING}
    if survey.ending is not None and is_broken(survey.ending):
        left_out.add(ENDING)
    try:
        with (target / bag_directory.file_name(target)).open('xb', buffering=0) as output:
            copy = BagCopy(output, survey.header, found.messages, left_out)
            for schema in survey.declared.schemas.values():
                copy.take(schema)
            for channel in survey.declared.channels.values():
                copy.take(channel)
            with suppress(mcap_scan.Torn):  # the survey has told
                for _, content in _good_records(stream, survey.declared, []):
                    copy.take(content)
            copy.finish(target, note)
    except OSError as error:
        raise RunError(
            f'{target}: writing failed ({error.strerror}); the source is unchanged; '
            'make room and try again'
        ) from error


def _good_records(
    stream: BinaryIO, declared: _Declared, problems: list[str]
) -> Iterator[tuple[mcap_scan.Record, McapRecord | mcap_scan.Message]]:
    """
    Yield messages, metadata and attachments that can be read, chunks unpacked; Torn where the good
    part ends.

    Why a record was left out is appended to `problems`, each reason once.
    """
    told = set[str]()

    def leave_out(reason: str) -> None:
        if reason not in told and len(told) < _MOST_REASONS:
            told.add(reason)
            problems.append(reason)

    for record in _unpacked(stream):
        if record.opcode == mcap_file.MESSAGE:
            message = mcap_scan.message(record)
            if max(message.log_time, message.publish_time) > mcap_scan.MOST_TIME:
                raise mcap_scan.Altered(record.position, f'a message at {message.log_time} ns')
            if message.channel in declared.channels:
                yield record, message
            else:
                leave_out(f'messages of channel {message.channel}, which is not declared')
            continue
        kind = _KINDS.get(record.opcode)
        if kind is None:
            continue
        try:
            content = record.parse(kind)
        except mcap_scan.Torn as error:
            leave_out(str(error))
            continue
        yield record, content


def _unpacked(stream: BinaryIO) -> Iterator[mcap_scan.Record]:
    """Yield the records of the data section and those in its chunks."""
    for number, record in enumerate(mcap_scan.records(stream)):
        if number == 0 and record.opcode != mcap_file.HEADER:
            raise mcap_scan.Torn(record.position, 'the header is missing')
        if record.opcode == mcap_file.DATA_END:
            break
        if record.opcode == mcap_file.CHUNK:
            yield from mcap_scan.inner_records(record)
        else:
            yield record
