# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A recording is an ordinary rosbag2 bag: every reader sees every message.
"""

import errno
import os
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import bag_writer, cdr, chunk_queue
from rigid_body_sim.recording.bag_check import check
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.mcap_file import CHUNK, McapFile
from rigid_body_sim.recording.recovery import recover
from rigid_body_sim.recording.topics import COMMAND_TYPES, QOS, Topic

from ..patience import HANGING

TICKS = 100
EXPECTED = 15 + 12 + 20 * 7  # commands, wrenches where they changed, published ticks of 2 bodies


def read_by_mcap(path, **options):
    """
    Topic, sequence, log time and bytes as the mcap package reads them.
    """
    with path.open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True, **options)
        return [
            (channel.topic, message.sequence, message.log_time, message.data)
            for _, channel, message in reader.iter_messages(log_time_order=False)
        ]


def test_mcap_reads_it_in_order_with_its_crcs(record, mcap_of):
    directory = record(ticks=TICKS)
    messages = read_by_mcap(mcap_of(directory))
    assert len(messages) == EXPECTED
    assert messages == [tuple(message)[:4] for message in Bag(directory).messages()]
    assert [message[2] for message in messages] == sorted(message[2] for message in messages)
    with mcap_of(directory).open('rb') as stream:
        records = list(StreamReader(stream, validate_crcs=True).records)
    assert len(records) > EXPECTED


def test_time_and_topic_filters_use_the_index(record, mcap_of):
    with mcap_of(record(ticks=TICKS)).open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        found = list(
            reader.iter_messages(['/box/pose'], starting_at=20_000_000, ending_at=40_000_000)
        )
    assert [message.sequence for _, _, message in found] == [20, 25, 30, 35, 40]


def test_mcap_ros2_decodes_it(record, mcap_of, run):
    with mcap_of(record(ticks=TICKS)).open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        poses = [each.decoded_message for each in reader.iter_decoded_messages(['/ball/pose'])]
    assert len(poses) == TICKS // 5
    position = run.arrays(TICKS)['position'][1]
    last = poses[-1].pose.position
    assert (last.x, last.y, last.z) == tuple(position)


@pytest.mark.parametrize('lone', [False, True], ids=['directory', 'lone file'])
def test_rosbags_reads_it(record, mcap_of, run, lone):
    directory = record(ticks=TICKS)
    path = mcap_of(directory) if lone else directory
    with AnyReader([path]) as reader:
        assert reader.message_count == EXPECTED
        assert {each.topic: each.msgcount for each in reader.connections} == Bag(path).counts
        read = [
            (each.topic, time, bytes(data), reader.deserialize(data, each.msgtype))
            for each, time, data in reader.messages()
        ]
    with Reader(path) as reader:
        assert len(list(reader.messages())) == EXPECTED
        assert (reader.start_time, reader.duration) == (0, TICKS * 1_000_000 + 1)
    ours = sorted((m.topic, m.log_time, m.data) for m in Bag(path).messages())
    assert sorted(each[:3] for each in read) == ours


def test_metadata_is_that_of_version_9(record):
    directory = record(ticks=TICKS)
    text = (directory / 'metadata.yaml').read_text()
    assert '&' not in text and '*' not in text
    content = yaml.safe_load(text)['rosbag2_bagfile_information']
    assert content['version'] == 9
    assert content['message_count'] == EXPECTED
    assert content['starting_time']['nanoseconds_since_epoch'] == 0
    assert content['duration']['nanoseconds'] == TICKS * 1_000_000
    assert content['relative_file_paths'] == ['run_0.mcap']
    assert content['custom_data']['rigid_body_sim.integrator'] == 'dmv6'
    for entry in content['topics_with_message_count']:
        assert entry['topic_metadata']['offered_qos_profiles'] == [dict(QOS[0])]
    assert sorted(path.name for path in directory.iterdir()) == ['metadata.yaml', 'run_0.mcap']


def test_the_record_for_rosbag2_is_the_inner_map(record, mcap_of):
    directory = record()
    with mcap_of(directory).open('rb') as stream:
        found = {each.name: each.metadata for each in make_reader(stream).iter_metadata()}
    inner = yaml.safe_load(found['rosbag2']['serialized_metadata'])
    outer = yaml.safe_load((directory / 'metadata.yaml').read_text())
    assert outer == {'rosbag2_bagfile_information': inner}


def test_manifest_attachment_and_ending_are_kept(record):
    bag = Bag(record())
    assert bag.manifest['integrator'] == 'dmv6'
    assert bag.attachments == {'scene.yaml': b'version: 1\nname: pair\n'}
    assert bag.ending == {'end_reason': 'stop_time', 'wall_time': 'run'}
    assert bag.complete


def test_equal_runs_give_equal_files_up_to_the_ending(record, mcap_of):
    first = mcap_of(record('first', ticks=20_000)).read_bytes()
    second = mcap_of(record('second', ticks=20_000)).read_bytes()
    end = first.index(b'rigid_body_sim_end') - 13  # opcode and two lengths stand before it
    assert end > 2**21, 'more than one chunk'
    assert first[:end] == second[:end]
    assert first != second


def test_the_background_writer_writes_the_same_messages(record):
    direct = record('direct', ticks=5000)
    threaded = record('threaded', ticks=5000, background=True)
    assert list(Bag(direct).messages()) == list(Bag(threaded).messages())
    assert check(threaded) == []


def test_flush_puts_everything_in_the_file(tmp_path, run, mcap_of):
    for background in (False, True):
        writer = run.open(tmp_path / str(background), background=background)
        writer.write(run.state(1))
        writer.flush()
        with mcap_of(writer.path).open('rb') as stream:
            data = stream.read()
        assert run.state(1).data in data
        writer.close({})


def test_an_empty_recording_is_valid_everywhere(record, mcap_of):
    directory = record(ticks=0)
    assert check(directory) == []
    assert read_by_mcap(mcap_of(directory)) == []
    for path in (directory, mcap_of(directory)):
        with Reader(path) as reader:
            assert reader.message_count == 0
            assert len(reader.connections) == 17  # 1 + 2 bodies * (3 states + 5 commands)


def test_a_channel_on_demand_is_made_by_its_first_message(tmp_path, run):
    """
    Equal messages give equal files, and readers find neither less nor more.
    """
    commands = [Topic(f'/box/{kind}', type_) for kind, type_ in COMMAND_TYPES.items()]
    force = cdr.encode(cdr.Vector3Stamped(0, 0, '', (1.0, 0.0, 0.0)))
    wrench = cdr.encode(cdr.WrenchStamped(0, 0, '', (1.0, 0.0, 0.0), (0.0, 0.0, 2.0)))

    run.topics = run.packer.topics

    def made(name, background):
        writer = run.open(tmp_path / name / 'bag', on_demand=commands, background=background)
        for tick in range(50):
            if tick in (20, 40):
                writer.write_message('/box/wrench', tick, tick * 1_000_000, wrench)
            if tick == 30:
                writer.flush()  # a chunk before the next new channel
                writer.write_message('/box/force', tick, tick * 1_000_000, force)
            writer.write(run.state(tick + 1))
        writer.close({})
        return tmp_path / name / 'bag'

    bag, other, threaded = made('a', False), made('b', False), made('c', True)
    (file,) = bag.glob('*.mcap')
    assert file.read_bytes() == next(other.glob('*.mcap')).read_bytes()
    assert list(Bag(threaded).messages()) == list(Bag(bag).messages())
    names = [topic.name for topic in run.packer.topics]
    for path in (bag, threaded):
        assert check(path) == []
        assert list(Bag(path).topics) == [*names, '/box/wrench', '/box/force']
        assert read_by_mcap(next(path.glob('*.mcap')))
        with Reader(path) as reader:
            counts = {c.topic: c.msgcount for c in reader.connections}
            assert len(list(reader.messages())) == sum(counts.values())
        assert (counts['/box/wrench'], counts['/box/force']) == (2, 1)
        assert not {'/box/torque', '/box/impulse', '/box/set_state'} & counts.keys()


def test_an_existing_target_is_refused_and_left_alone(record, run, tmp_path):
    directory = record()
    before = (directory / 'metadata.yaml').read_bytes()
    with pytest.raises(UserError, match=r'exists already.*choose another path'):
        run.open(directory)
    assert (directory / 'metadata.yaml').read_bytes() == before
    (tmp_path / 'file').write_text('x')
    with pytest.raises(UserError, match='exists already'):
        run.open(tmp_path / 'file')
    with pytest.raises(UserError, match='cannot be created'):
        run.open(tmp_path / 'file' / 'below')
    with pytest.raises(UserError, match='without it'):
        run.open(tmp_path / 'name.mcap')


def test_a_directory_above_the_bag_is_made(tmp_path, run):
    run.open(tmp_path / 'a' / 'b').close({})
    assert Bag(tmp_path / 'a' / 'b').complete


def test_closing_twice_is_closing_once(tmp_path, run):
    writer = run.open(tmp_path / 'run')
    writer.close({'end_reason': 'first'})
    writer.close({'end_reason': 'second'})
    assert Bag(tmp_path / 'run').ending == {'end_reason': 'first'}


def test_a_batch_of_other_channels_is_refused(tmp_path, run, make_run):
    writer = run.open(tmp_path / 'run')
    with pytest.raises(ValueError, match='which is not what the recording was opened with'):
        writer.write(make_run(('other', 'names')).state(1))
    writer.close({})


def test_more_topics_than_channel_ids_are_refused(tmp_path, run):
    topics = [Topic(f'/t{number}', cdr.Clock.TYPE) for number in range(2**16)]
    run.topics = topics
    with pytest.raises(UserError, match='at most 65535'):
        run.open(tmp_path / 'run')
    assert not (tmp_path / 'run').exists()


def test_chunks_carry_the_crc_of_their_body(record, mcap_of):
    with mcap_of(record()).open('rb') as stream:
        chunks = [
            each
            for each in StreamReader(stream, emit_chunks=True).records
            if type(each).__name__ == 'Chunk'
        ]
    assert chunks and CHUNK == 6
    for chunk in chunks:
        assert chunk.uncompressed_crc == zlib.crc32(chunk.data) != 0


FULL_DISK = """
import resource, signal, sys
from pathlib import Path
import numpy as np
from rigid_body_sim.errors import RunError
from rigid_body_sim.recording.bag_writer import BagWriter
from rigid_body_sim.recording.packing import StatePacker

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000))
packer = StatePacker(['box'], dt_ns=1000)
writer = BagWriter(sys.argv[1], topics=packer.topics, manifest={'dt_ns': '1000'}, attachments={},
                   background=sys.argv[2] == 'background')
three, four = np.zeros((1, 3)), np.zeros((1, 4))
failed = []
try:
    for tick in range(1, 100_000):
        writer.write(packer.pack(tick, position=three, orientation=four, velocity=three,
                                 angular_velocity=three, force=three, torque=three))
        if tick == 1000:
            writer.flush()
except RunError as error:
    failed.append(str(error))
try:
    writer.close({'end_reason': 'error'})
except RunError as error:
    failed.append(str(error))
print('\\n'.join(failed))
"""


@pytest.mark.parametrize('mode', [pytest.param('direct', marks=pytest.mark.long), 'background'])
def test_a_full_disk_ends_the_recording_and_names_what_is_safe(tmp_path, mode):
    target = tmp_path / 'run'
    result = subprocess.run(
        [sys.executable, '-c', FULL_DISK, str(target), mode],
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    at_write, at_close = result.stdout.splitlines()
    assert at_write == at_close
    assert os.strerror(errno.EFBIG) in at_write
    safe = int(at_write.partition('ticks up to ')[2].split()[0])
    assert safe >= 1000  # flushed; how much the worker took since is a matter of the machine
    assert not (target / 'metadata.yaml').exists()
    assert recover(target, tmp_path / 'saved').last_tick == safe
    assert check(tmp_path / 'saved') == []


@pytest.mark.parametrize('background', [False, True])
@pytest.mark.parametrize('how', ['folder removed', 'file removed', 'replaced', 'moved'])
def test_a_recording_whose_file_is_taken_away_says_so_and_calls_nothing_safe(
    tmp_path, run, mcap_of, how, background
):
    writer = run.open(tmp_path / 'run', background=background)
    run.write(writer, 20)
    writer.flush()
    file, moved = mcap_of(tmp_path / 'run'), tmp_path / 'elsewhere'
    if how == 'moved':
        (tmp_path / 'run').rename(moved)
    else:
        file.unlink()
    if how == 'folder removed':
        (tmp_path / 'run').rmdir()
    elif how == 'replaced':
        file.write_bytes(b'another')
    said = set()
    run.write(writer, 10, first=20)
    for call in (writer.flush, lambda: writer.write(run.state(30)), lambda: writer.close({})):
        with pytest.raises(RunError) as error:
            call()
        said.add(str(error.value))
    (line,) = said
    assert line.startswith(f'{tmp_path / "run"}: the file of this recording was')
    assert not (tmp_path / 'run' / 'metadata.yaml').exists()
    if how == 'moved':
        where = line.partition('bag recover ')[2].removesuffix(' -o NEW')
        assert f'moved to {where}' in line
        assert 'ticks up to 20 are safe there' in line
        assert recover(Path(where), tmp_path / 'saved').last_tick == 20
    else:
        assert 'recorded is lost' in line
        assert 'safe' not in line


def test_a_device_without_room_fails_at_the_first_byte_and_leaves_nothing(
    tmp_path, run, monkeypatch
):
    if not Path('/dev/full').exists():
        pytest.skip('no /dev/full here')

    def full(path, *_, **__):
        return open('/dev/full', 'wb', 0)  # noqa: PTH123  (it stands in for Path.open)

    monkeypatch.setattr(bag_writer.Path, 'open', full)
    with pytest.raises(RunError, match=r'run: .*No space left on device.*nothing is recorded'):
        run.open(tmp_path / 'run')
    assert not (tmp_path / 'run').exists()


@pytest.mark.parametrize('background', [False, True])
def test_after_one_failure_nothing_more_is_written(tmp_path, run, monkeypatch, background):
    writer = run.open(tmp_path / 'run', background=background)
    run.write(writer, 10)
    writer.flush()
    write_chunk = McapFile.write_chunk

    def fail_once(file, chunk):
        monkeypatch.setattr(McapFile, 'write_chunk', write_chunk)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(McapFile, 'write_chunk', fail_once)
    run.write(writer, 10, first=10)
    for call in (writer.flush, lambda: writer.write(run.state(30)), lambda: writer.close({})):
        with pytest.raises(RunError, match='ticks up to 10 are safe'):
            call()
    assert not (tmp_path / 'run' / 'metadata.yaml').exists()
    assert recover(tmp_path / 'run', tmp_path / 'saved').last_tick == 10


def test_nothing_is_dropped_when_the_disk_is_slow(tmp_path, run, monkeypatch):
    monkeypatch.setattr(chunk_queue, 'PENDING_BYTES', 10_000)
    monkeypatch.setattr(chunk_queue, 'THREADED_CHUNK_BYTES', 1000)
    writer = run.open(tmp_path / 'run', background=True)
    run.write(writer, 5000)
    writer.close({})
    assert Bag(tmp_path / 'run').counts['/clock'] == 1000
    sequences = [message.sequence for message in Bag(tmp_path / 'run').messages(['/clock'])]
    assert np.array_equal(sequences, np.arange(5, 5001, 5))
