# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`check` names what is wrong, also what readers pass over in silence.
"""

import hashlib

import pytest
import yaml
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import mcap_file, mcap_scan
from rigid_body_sim.recording.bag_check import check
from rigid_body_sim.recording.bag_writer import BagWriter

TYPE = 'geometry_msgs/msg/WrenchStamped'
NO_FAULT = ['no manifest: not recorded by rigid_body_sim, cannot be replayed']


@pytest.mark.parametrize(('topics', 'messages'), [(1, 3), (1, 0), (0, 0)])
def test_a_whole_bag_of_the_library_rosbags_has_no_fault(tmp_path, topics, messages):
    """Its channels tell no hash, and times of what holds no message are any."""
    store, path = get_typestore(Stores.ROS2_JAZZY), tmp_path / 'bag'
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for _ in range(topics):
            connection = writer.add_connection('/box/wrench', TYPE, typestore=store)
            for number in range(messages):
                writer.write(connection, 10**18 + number, bytes(60))
    assert check(path) == NO_FAULT


def test_a_hash_that_is_not_that_of_its_channel_is_found_where_both_are_told(record):
    directory = record()

    def change(information):
        for entry, told in zip(information['topics_with_message_count'], ('', 'RIHS01_00')):
            entry['topic_metadata']['type_description_hash'] = told

    rewrite_metadata(directory, change)
    assert sum('type hash differs from its channel' in each for each in check(directory)) == 1


def rewrite_metadata(directory, change):
    """
    Change the inner map of metadata.yaml in place.
    """
    path = directory / 'metadata.yaml'
    content = yaml.safe_load(path.read_text())
    change(content['rosbag2_bagfile_information'])
    path.write_text(yaml.safe_dump(content))


def silent_messages(directory):
    """
    Number of messages that rosbags yields.
    """
    with Reader(directory) as reader:
        return len(list(reader.messages()))


def test_a_recording_without_fault_has_no_finding(record, mcap_of):
    directory = record(ticks=20_000)
    assert check(directory) == []
    assert check(mcap_of(directory)) == []


@pytest.mark.parametrize(
    ('key', 'value', 'finding'),
    [
        ('offered_qos_profiles', [], 'quality of service differs'),
        ('type_description_hash', 'RIHS01_00', 'type hash differs'),
        ('type', 'geometry_msgs/msg/Pose', 'type geometry_msgs/msg/Pose, in the file'),
        ('name', '/elsewhere', 'in the metadata only'),
    ],
)
def test_a_topic_that_differs_in_the_metadata_is_found(record, key, value, finding):
    directory = record()

    def change(information):
        information['topics_with_message_count'][3]['topic_metadata'][key] = value

    rewrite_metadata(directory, change)
    found = check(directory)
    assert any(finding in each for each in found)


def test_rosbags_drops_the_topic_in_silence_where_the_qualities_differ(record):
    directory = record()
    whole = silent_messages(directory)

    def change(information):
        information['topics_with_message_count'][2]['topic_metadata']['offered_qos_profiles'] = []

    rewrite_metadata(directory, change)
    assert silent_messages(directory) < whole, 'the trap that the finding is about'
    assert any('/clock: quality of service differs' in each for each in check(directory))


@pytest.mark.parametrize(
    ('key', 'value', 'finding'),
    [
        ('message_count', 1, '1 messages, the file holds'),
        ('version', 10, 'rosbags reads up to 9'),
        ('starting_time', {'nanoseconds_since_epoch': 5}, 'times'),
        ('duration', None, 'missing or misplaced'),
        ('topics_with_message_count', [], 'in the file only'),
    ],
)
def test_metadata_that_does_not_fit_the_file_is_found(record, key, value, finding):
    directory = record()
    rewrite_metadata(directory, lambda information: information.update({key: value}))
    assert any(finding in each for each in check(directory))


def places(path, opcode):
    """
    Positions of the records with an opcode.
    """
    with path.open('rb') as stream:
        return [each.position for each in mcap_scan.records(stream) if each.opcode == opcode]


@pytest.mark.parametrize(
    ('opcode', 'inside', 'finding'),
    [
        (mcap_file.CHUNK, 500, 'CRC'),
        (mcap_file.MESSAGE_INDEX, 16, 'message index does not match'),
        (mcap_file.ATTACHMENT, 60, 'crc'),
        (mcap_file.STATISTICS, 9, 'the summary does not match its CRC'),
        (mcap_file.CHUNK_INDEX, 30, 'the summary does not match its CRC'),
        (mcap_file.CHANNEL, 30, 'the data section has the CRC'),
        (mcap_file.METADATA, 90, 'the manifest does not match its checksum'),
        (mcap_file.FOOTER, 25, 'the summary does not match its CRC'),
    ],
)
def test_a_flipped_bit_is_found_wherever_it_is(record, mcap_of, opcode, inside, finding):
    directory = record()
    path = mcap_of(directory)
    data = bytearray(path.read_bytes())
    data[places(path, opcode)[0] + inside] ^= 1
    path.write_bytes(data)
    assert any(finding.lower() in each.lower() for each in check(directory)), check(directory)


def test_missing_message_indexes_are_found(record, mcap_of):
    directory = record()
    path = mcap_of(directory)
    data = bytearray(path.read_bytes())
    for position in places(path, mcap_file.MESSAGE_INDEX):
        data[position] = 0x80  # a private opcode, which readers skip
    path.write_bytes(data)
    assert any('message index does not match' in each for each in check(path))


def test_a_torn_or_unfinished_recording_is_a_finding(record, mcap_of, tmp_path):
    directory = record()
    torn = tmp_path / 'torn.mcap'
    torn.write_bytes(mcap_of(directory).read_bytes()[:-5])
    assert any('torn' in each for each in check(torn))
    (directory / 'metadata.yaml').unlink()
    assert any('unfinished' in each for each in check(directory))


def test_a_path_without_a_bag_is_no_finding_but_an_error(tmp_path):
    with pytest.raises(UserError, match='no such file'):
        check(tmp_path / 'missing')


def test_a_scene_that_is_not_that_of_the_manifest_is_found(tmp_path, run):
    writer = BagWriter(
        tmp_path / 'run',
        topics=run.topics,
        manifest={'scene_sha256': hashlib.sha256(b'another scene').hexdigest()},
        attachments={'scene.yaml': b'this scene'},
    )
    writer.close({})
    assert any('does not match scene_sha256' in each for each in check(tmp_path / 'run'))


def test_times_that_go_back_are_found(tmp_path, run):
    writer = run.open(tmp_path / 'run')
    writer.write(run.state(5))
    writer.write(run.state(4))
    writer.close({})
    assert any('goes back' in each for each in check(tmp_path / 'run'))
