# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Indexes of messages are stepped over, those of chunks read at once: the same is found."""

import io

import numpy as np
import pytest
from mcap.records import ChunkIndex

from rigid_body_sim.recording import mcap_file, mcap_scan, mcap_summary

from .conftest import Run

NAMES = ('box', *(f'body{i}' for i in range(40)))


@pytest.fixture(scope='module')
def content(tmp_path_factory) -> bytes:
    """A bag of many channels, in several chunks: its bytes."""
    folder = tmp_path_factory.mktemp('indexes') / 'bag'
    run = Run(NAMES)
    writer = run.open(folder)
    for first in range(0, 60, 10):
        run.write(writer, 10, first)
        writer.flush()  # ends a chunk
    writer.close({'end_reason': 'stop_time', 'wall_time': ''})
    (file,) = folder.glob('*.mcap')
    return file.read_bytes()


def outcome(content: bytes, **how: bool) -> tuple[list[tuple[int, int]], str]:
    """Give the records but for indexes of messages, with their places, and how reading ends."""
    found: list[tuple[int, int]] = []
    try:
        found.extend(
            (record.opcode, record.position)
            for record in mcap_scan.records(io.BytesIO(content), **how)
            if record.opcode != mcap_file.MESSAGE_INDEX
        )
    except mcap_scan.Torn as error:
        return found, f'{type(error).__name__}: {error}'
    return found, 'whole'


def test_stepping_over_indexes_finds_the_same_records_and_sums(content, monkeypatch):
    for room in (16, 100, 1 << 16):  # also where an index does not fit into what is read at once
        monkeypatch.setattr(mcap_scan, 'RUN_OF_INDEXES', room)
        found, end = outcome(content, message_indexes=False)
        assert (found, end) == outcome(content)
        assert end == 'whole' and [opcode for opcode, _ in found].count(mcap_file.CHUNK) > 3


def test_damage_is_told_of_as_by_who_reads_every_index(content):
    """Bits flipped anywhere, cuts, and frames of indexes that say something else."""
    draw = np.random.default_rng(3)
    indexes = [
        record.position
        for record in mcap_scan.records(io.BytesIO(content))
        if record.opcode == mcap_file.MESSAGE_INDEX
    ]
    places = [*draw.integers(0, len(content), 40).tolist()]
    places += [at + i for at in draw.choice(indexes, 12).tolist() for i in (0, 1, 4, 8, 12)]
    ends = set()
    for place in places:
        damaged = bytearray(content)
        damaged[place] ^= 1 << int(draw.integers(8))
        for version in (bytes(damaged), content[:place]):
            found = outcome(version, message_indexes=False)
            assert found == outcome(version)
            ends.add(found[1].partition(':')[0])
    assert ends >= {'Torn', 'WrongSum'}


def test_the_index_of_a_chunk_is_read_as_the_mcap_package_reads_it(content):
    summary = mcap_summary.read_summary(io.BytesIO(content))
    records = [
        record
        for record in mcap_scan.records(io.BytesIO(content))
        if record.opcode == mcap_file.CHUNK_INDEX
    ]
    assert summary.chunks == [record.parse(ChunkIndex) for record in records]
    assert len(summary.chunks) > 3 and all(x.message_index_offsets for x in summary.chunks)
    for end in range(0, len(records[0].content) - 1, 7):
        cut = records[0]._replace(content=records[0].content[:end])
        with pytest.raises(mcap_scan.Torn, match='unreadable ChunkIndex'):
            mcap_summary._chunk_index(cut)
