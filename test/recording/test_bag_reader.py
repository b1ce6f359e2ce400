# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bags of any rosbag2 recorder are read; what is none is refused with a cure.
"""

import shutil
from io import BytesIO

import numpy as np
import pytest
import yaml
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import bag_reader, cdr
from rigid_body_sim.recording.bag_reader import Bag, DamagedBag
from rigid_body_sim.recording.definitions import definition

COMMAND = cdr.encode(cdr.WrenchStamped(1, 2, 'box', (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)))


def library_file(path, compression=CompressionType.NONE, messages=1000, times=None, **options):
    """
    Write an MCAP file with the mcap package.

    times : [ns] log times; none given: the numbers of the messages
    """
    with path.open('wb') as stream:
        writer = Writer(stream, chunk_size=4096, compression=compression, **options)
        writer.start(profile='ros2', library='other')
        kind = cdr.WrenchStamped.TYPE
        schema = writer.register_schema(kind, 'ros2msg', definition(kind).encode())
        channel = writer.register_channel('/box/wrench', 'cdr', schema)
        for number in range(messages):
            time = number if times is None else int(times[number])
            writer.add_message(channel, time, COMMAND, time, number)
        writer.finish()


@pytest.mark.parametrize('compression', list(CompressionType))
def test_every_compression_is_read(tmp_path, compression):
    library_file(tmp_path / 'other.mcap', compression)
    bag = Bag(tmp_path / 'other.mcap')
    assert bag.topics['/box/wrench'].type == cdr.WrenchStamped.TYPE
    assert bag.counts == {'/box/wrench': 1000}
    assert [message.log_time for message in bag.messages()] == list(range(1000))
    assert {message.data for message in bag.messages()} == {COMMAND}
    assert bag.manifest == {} and bag.ending is None and not bag.complete


def test_a_file_without_chunks_is_read(tmp_path):
    library_file(tmp_path / 'other.mcap', use_chunking=False)
    assert len(list(Bag(tmp_path / 'other.mcap').messages())) == 1000


def test_a_bag_written_by_rosbags_is_read(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    with RosbagsWriter(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection('/box/wrench', cdr.WrenchStamped.TYPE, typestore=store)
        for number in range(10):
            writer.write(connection, 10**18 + number, COMMAND)
    bag = Bag(tmp_path / 'bag')
    assert [(m.topic, m.data) for m in bag.messages()] == [('/box/wrench', COMMAND)] * 10
    assert (bag.first_time, bag.last_time) == (10**18, 10**18 + 9)


def test_a_bag_of_several_files_is_read_in_order(record, mcap_of):
    directory = record()
    library_file(directory / 'more_1.mcap', messages=3)
    path = directory / 'metadata.yaml'
    content = yaml.safe_load(path.read_text())
    content['rosbag2_bagfile_information']['relative_file_paths'].append('more_1.mcap')
    path.write_text(yaml.safe_dump(content))
    bag = Bag(directory)
    messages = list(bag.messages())
    assert [m.topic for m in messages[-3:]] == ['/box/wrench'] * 3
    assert len(messages) == sum(bag.counts.values())
    assert bag.counts['/box/wrench'] == 3


@pytest.mark.parametrize('chunks', [True, False])
@pytest.mark.parametrize('reach', [3, 100, 1000])
def test_messages_come_by_log_time_whatever_their_order_in_the_files(tmp_path, chunks, reach):
    """Swapped within a chunk, over some of 30 messages, and at random; in files one by one."""
    path, random = tmp_path / 'other.mcap', np.random.default_rng(reach)
    times = np.arange(1000) // 2 + random.integers(0, reach, 1000)
    library_file(path, times=times, use_chunking=chunks)
    bag = Bag(path)
    in_file = [(m.log_time, m.sequence) for m in bag.messages()]
    assert in_file != sorted(in_file)
    assert [(m.log_time, m.sequence) for m in bag.messages_by_time()] == sorted(in_file)


def test_of_an_ordered_file_no_more_than_a_chunk_is_held(tmp_path, monkeypatch):
    library_file(tmp_path / 'other.mcap')
    read = []
    of_record = bag_reader._messages
    monkeypatch.setattr(bag_reader, '_messages', lambda *a: (read.append(a), of_record(*a))[1])
    messages = Bag(tmp_path / 'other.mcap').messages_by_time()
    for number, message in enumerate(messages):
        assert message.log_time == number and len(read) <= 1 + number // 20
    assert number == 999 and len(read) > 20


def test_topics_select_messages(record):
    bag = Bag(record())
    assert {m.topic for m in bag.messages(['/clock', '/box/force'])} == {'/clock', '/box/force'}
    assert list(bag.messages(['/nothing'])) == []


def test_unusable_paths_are_refused_with_a_cure(tmp_path, record, mcap_of):
    with pytest.raises(UserError, match='no such file'):
        Bag(tmp_path / 'missing')
    (tmp_path / 'empty').mkdir()
    with pytest.raises(UserError, match='not a bag'):
        Bag(tmp_path / 'empty')
    (tmp_path / 'text').write_text('hello')
    with pytest.raises(UserError, match='not a bag'):
        Bag(tmp_path / 'text')
    (tmp_path / 'nothing.mcap').touch()
    with pytest.raises(UserError, match='not a bag'):
        Bag(tmp_path / 'nothing.mcap')
    directory = record()
    metadata = directory / 'metadata.yaml'
    text = metadata.read_text()
    for wrong in ('', 'a: [', 'a: 1', 'rosbag2_bagfile_information:\n  relative_file_paths: []'):
        metadata.write_text(wrong)
        with pytest.raises(UserError, match='not the metadata of a bag'):
            Bag(directory)
    metadata.write_text(text.replace('storage_identifier: mcap', 'storage_identifier: sqlite3'))
    with pytest.raises(UserError, match=r"'sqlite3'.*ros2 bag convert"):
        Bag(directory)
    metadata.write_text(text)
    mcap_of(directory).rename(tmp_path / 'gone')
    with pytest.raises(UserError, match=r'missing, but metadata.yaml names it'):
        Bag(directory)


def test_a_torn_recording_names_its_cure(tmp_path, record, mcap_of):
    directory = record(ticks=5000)
    whole = mcap_of(directory).read_bytes()
    torn = tmp_path / 'torn.mcap'
    for size in (9, 1000, len(whole) // 2, len(whole) - 1):
        torn.write_bytes(whole[:size])
        with pytest.raises(DamagedBag, match='bag recover'):
            Bag(torn)
    (directory / 'metadata.yaml').unlink()
    with pytest.raises(DamagedBag, match=r'unfinished.*bag recover'):
        Bag(directory)


def test_damage_in_a_chunk_is_found_while_reading(tmp_path, record, mcap_of, run):
    directory = record(ticks=5000)
    path = mcap_of(directory)
    data = bytearray(path.read_bytes())
    data[data.index(run.state(2500).data) + 100] ^= 1
    path.write_bytes(data)
    with pytest.raises(DamagedBag, match='CRC'):
        list(Bag(directory).messages())


def test_a_file_without_summary_is_sent_to_recovery(tmp_path):
    stream = BytesIO()
    writer = Writer(stream, use_statistics=False)
    writer.start(profile='ros2')
    writer.finish()
    (tmp_path / 'bare.mcap').write_bytes(stream.getvalue())
    with pytest.raises(DamagedBag, match=r'no summary.*bag recover'):
        Bag(tmp_path / 'bare.mcap')


def test_a_lone_file_is_the_same_recording(tmp_path, record, mcap_of):
    directory = record()
    shutil.copy(mcap_of(directory), tmp_path / 'lone.mcap')
    lone, whole = Bag(tmp_path / 'lone.mcap'), Bag(directory)
    assert list(lone.messages()) == list(whole.messages())
    assert (lone.counts, lone.manifest, lone.ending) == (
        whole.counts,
        whole.manifest,
        whole.ending,
    )
