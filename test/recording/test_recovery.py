# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What was flushed before a recording was cut off can be restored, and ends where a tick ends.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_check import check
from rigid_body_sim.recording.bag_files import DamagedBag
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.definitions import definition
from rigid_body_sim.recording.recovery import recover

PER_TICK = 7  # messages of a published tick of two bodies


def read_everywhere(directory, file):
    """
    Read a bag with every reader at hand; returns the number of messages, on which they agree.
    """
    with file.open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        counts = {len(list(reader.iter_decoded_messages()))}
    for path in (directory, file):
        with AnyReader([path]) as reader:
            counts.add(
                len(
                    [reader.deserialize(data, each.msgtype) for each, _, data in reader.messages()]
                )
            )
        counts.add(len(list(Bag(path).messages())))
    assert len(counts) == 1
    return counts.pop()


CHILD = """
import sys, time
import numpy as np
from rigid_body_sim.recording.bag_writer import BagWriter
from rigid_body_sim.recording.packing import StatePacker

packer = StatePacker(['box', 'ball'], dt_ns=1_000_000)
writer = BagWriter(sys.argv[1], topics=packer.topics, manifest={'dt_ns': '1000000'},
                   attachments={'scene.yaml': b'name: pair'}, background=True)
three, four = np.ones((2, 3)), np.ones((2, 4))
start = time.monotonic()
tick = 0
while True:
    tick = max(tick + 1, int((time.monotonic() - start) * 1000))
    writer.write(packer.pack(tick, position=three, orientation=four, velocity=three,
                             angular_velocity=three, force=three, torque=three))
    print(tick, time.monotonic_ns(), flush=True)
    time.sleep(0.01)  # [s] so slow that chunks are closed by time alone
"""


def test_a_killed_recording_loses_no_more_than_half_a_second(tmp_path, mcap_of):
    target = tmp_path / 'run'
    with subprocess.Popen(
        [sys.executable, '-c', CHILD, str(target)], stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        recorded = {}  # tick -> when it had been handed to the writer
        begin = None
        for line in child.stdout:
            tick, written = map(int, line.split())
            recorded[tick] = written
            begin = begin or written
            if written > begin + 1_300_000_000 and len(recorded) > 60:
                break
        killed = time.monotonic_ns()
        child.send_signal(signal.SIGKILL)
    old = [tick for tick, written in recorded.items() if written < killed - 500_000_000]
    found = recover(target, tmp_path / 'saved')
    assert len(old) > 20
    assert found.last_tick >= max(old)
    saved = Bag(tmp_path / 'saved')
    ticks = [message.sequence for message in saved.messages(['/clock'])]
    assert ticks[: len(old)] == sorted(old)
    assert len(ticks) * PER_TICK == read_everywhere(
        tmp_path / 'saved', mcap_of(tmp_path / 'saved')
    )
    assert check(tmp_path / 'saved') == []
    assert saved.manifest == {'dt_ns': '1000000'}
    assert saved.attachments == {'scene.yaml': b'name: pair'}


def test_every_cut_is_recovered_to_a_prefix_that_ends_with_a_tick(tmp_path, run, mcap_of):
    writer = run.open(tmp_path / 'run')
    for part in range(6):  # six chunks, cut within ticks and between them
        run.write(writer, 10, first=10 * part)
        writer.write_message('/box/force', 10 * part + 9, 0, cdr.encode(command(part)))
        writer.flush()
    writer.close({'end_reason': 'stop_time'})
    whole = list(Bag(tmp_path / 'run').messages())
    data = mcap_of(tmp_path / 'run').read_bytes()
    last = -1
    for number, size in enumerate([*range(10, len(data), 501), len(data)]):
        torn = tmp_path / f'{number}.mcap'
        torn.write_bytes(data[:size])
        target = tmp_path / f'saved_{number}'
        try:
            found = recover(torn, target)
        except RunError:
            assert last < 0, 'a longer piece cannot hold less'
            assert not target.exists()
            continue
        messages = list(Bag(target).messages())
        assert messages == whole[: len(messages)]
        assert found.last_tick is not None and found.last_tick >= last
        if found.torn_at is not None and len(messages) < len(whole):
            assert messages[-1].sequence == found.last_tick
            assert messages[-1].topic == '/ball/twist'
        last = found.last_tick
    assert last == 60


def command(number):
    """
    Some command.
    """
    return cdr.Vector3Stamped(0, number, 'box', (1.0, 2.0, 3.0))


def test_an_incomplete_last_tick_is_dropped(tmp_path, run, mcap_of):
    writer = run.open(tmp_path / 'run')
    run.write(writer, 10)
    batch = run.state(15)
    names = [topic.name for topic in run.packer.topics]
    for channel, payload in list(batch.payloads())[:-1]:  # all but the last twist
        writer.write_message(names[channel - 1], 15, 15_000_000, payload)
    writer.flush()
    found = recover(tmp_path / 'run', tmp_path / 'saved')
    assert (found.last_tick, found.dropped) == (10, PER_TICK - 1)
    assert max(m.sequence for m in Bag(tmp_path / 'saved').messages()) == 10
    assert Bag(tmp_path / 'saved').recovered['last_tick'] == '10'
    writer.close({})


def test_a_finished_file_without_metadata_is_kept_to_the_last_message(record, tmp_path):
    directory = record(ticks=99)  # ends with messages after the last whole tick
    whole = Bag(directory)
    messages = list(whole.messages())
    (directory / 'metadata.yaml').unlink()
    found = recover(directory, tmp_path / 'saved')
    assert (found.dropped, found.torn_at) == (0, None)
    saved = Bag(tmp_path / 'saved')
    assert list(saved.messages()) == messages
    assert (saved.ending, saved.manifest) == (whole.ending, whole.manifest)
    assert check(tmp_path / 'saved') == []


def test_damage_ends_the_good_part(record, tmp_path, mcap_of, run):
    directory = record(ticks=20_000)
    path = mcap_of(directory)
    data = bytearray(path.read_bytes())
    data[data.index(run.state(15_000).data) + 100] ^= 1
    path.write_bytes(data)
    before = path.read_bytes()
    found = recover(directory, tmp_path / 'saved')
    assert 'CRC' in found.problem
    assert 0 < found.last_tick < 15_000
    assert check(tmp_path / 'saved') == []
    assert path.read_bytes() == before, 'the source is never changed'


def test_a_torn_bag_of_another_recorder_keeps_every_whole_message(tmp_path):
    path = tmp_path / 'other.mcap'
    kind = cdr.PoseStamped.TYPE
    payload = cdr.encode(cdr.PoseStamped(0, 0, 'map', (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0)))
    with path.open('wb') as stream:
        writer = Writer(stream, chunk_size=1024)
        writer.start(profile='ros2', library='other')
        schema = writer.register_schema(kind, 'ros2msg', definition(kind).encode())
        metadata = {'offered_qos_profiles': '- depth: 5\n', 'topic_type_hash': ''}
        channel = writer.register_channel('/pose', 'cdr', schema, metadata)
        writer.add_attachment(7, 8, 'note.txt', 'text/plain', b'hello')
        for number in range(100):
            writer.add_message(channel, number, payload, number + 1)
        writer.finish()
    path.write_bytes(path.read_bytes()[:-2000])
    found = recover(path, tmp_path / 'saved')
    assert found.last_tick is None and found.dropped == 0
    messages = list(Bag(tmp_path / 'saved').messages())
    assert 10 < len(messages) == found.messages
    assert {message.data for message in messages} == {payload}
    with (tmp_path / 'saved' / 'saved_0.mcap').open('rb') as stream:
        reader = make_reader(stream)
        assert reader.get_header().library == 'other recovered'
        (attachment,) = reader.iter_attachments()
        assert (attachment.create_time, attachment.log_time) == (7, 8)
        for _, each, message in reader.iter_messages():
            assert each.metadata == metadata
            assert message.publish_time == message.log_time + 1


def test_recovering_a_recovery_changes_no_message(record, tmp_path):
    directory = record()
    recover(directory, tmp_path / 'once')
    recover(tmp_path / 'once', tmp_path / 'twice')
    assert list(Bag(tmp_path / 'twice').messages()) == list(Bag(directory).messages())
    assert check(tmp_path / 'twice') == []


def test_paths_that_cannot_be_used_are_refused(record, tmp_path):
    directory = record()
    with pytest.raises(UserError, match='no such file'):
        recover(tmp_path / 'missing', tmp_path / 'saved')
    with pytest.raises(UserError, match='exists already'):
        recover(directory, directory)
    (tmp_path / 'text').write_text('hello, this is no bag')
    with pytest.raises(UserError, match='not a bag'):
        recover(tmp_path / 'text', tmp_path / 'saved')
    (tmp_path / 'two').mkdir()
    for name in ('a.mcap', 'b.mcap'):
        shutil.copy(directory / 'run_0.mcap', tmp_path / 'two' / name)
    with pytest.raises(UserError, match=r'holds 2 .mcap files.* one by one'):
        recover(tmp_path / 'two', tmp_path / 'saved')
    (tmp_path / 'none').mkdir()
    with pytest.raises(UserError, match=r'holds no .mcap file'):
        recover(tmp_path / 'none', tmp_path / 'saved')
    assert not (tmp_path / 'saved').exists()


@pytest.mark.parametrize('torn', [(11,), (7, 11), ()])
def test_the_cure_for_an_unfinished_bag_of_several_files_cures_it(record, tmp_path, torn):
    file = record() / 'run_0.mcap'
    split = tmp_path / 'split'
    split.mkdir()
    for number in range(12):
        shutil.copy(file, split / f'split_{number}.mcap')
    for number in torn:
        os.truncate(split / f'split_{number}.mcap', file.stat().st_size - 9)
    with pytest.raises(DamagedBag, match=r'no metadata.yaml.* one by one') as unfinished:
        Bag(split)
    with pytest.raises(UserError, match=r'holds 12 .mcap files, expected one') as several:
        recover(split, tmp_path / 'saved')
    for told in map(str, (unfinished.value, several.value)):
        named = re.findall(r'bag recover (\S+) -o NEW', told)
        assert len(named) == min(1, len(torn)) and ('each of the 2 torn' in told) == (
            len(torn) == 2
        )
    for number, name in enumerate(named):
        assert recover(name, tmp_path / f'saved{number}').messages
    for number in {*range(12)} - {*torn}:
        assert Bag(split / f'split_{number}.mcap').counts


def test_nothing_to_save_is_a_failure(record, tmp_path, mcap_of):
    data = mcap_of(record()).read_bytes()
    for size in (8, 20, 3000):
        (tmp_path / 'torn.mcap').write_bytes(data[:size])
        with pytest.raises(RunError, match='nothing to save'):
            recover(tmp_path / 'torn.mcap', tmp_path / 'saved')
    assert not (tmp_path / 'saved').exists()
