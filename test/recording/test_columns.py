# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Topics as arrays are what their messages say one by one, in log-time order, whoever wrote them and
however many topics there are; a message costs no call of numpy of its own.
"""

import sys

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_check import check
from rigid_body_sim.recording.bag_reader import Bag, DamagedBag
from rigid_body_sim.recording.columns import read_columns
from rigid_body_sim.recording.definitions import definition

KINDS = (cdr.PoseStamped, cdr.TwistStamped, cdr.WrenchStamped)


def write(path, topics, instants, *, frame=lambda _draw: 'world', **options):
    """Write a file of so many topics with the mcap package; some skip an instant."""
    draw = np.random.default_rng(7)
    with path.open('wb') as stream:
        writer = Writer(stream, **{'compression': CompressionType.NONE, **options})
        writer.start()
        channels = []
        for number in range(topics):
            kind = KINDS[number % 3]
            schema = writer.register_schema(kind.TYPE, 'ros2msg', definition(kind.TYPE).encode())
            channels.append(writer.register_channel(f'/t{number}', 'cdr', schema))
        for instant in range(instants):
            for number, channel in enumerate(channels):
                if draw.random() < 0.05:
                    continue
                kind = KINDS[number % 3]
                parts = [tuple(draw.normal(size=width)) for _, width in kind.PARTS]
                message = kind(instant, number, frame(draw), *parts)
                writer.add_message(channel, instant, cdr.encode(message), instant)
        writer.finish()
    return Bag(path)


def one_by_one(bag, name):
    """Decode every message of a topic."""
    found = [cdr.decode(bag.topics[name].type, m.data) for m in bag.messages([name])]
    stamp = [10**9 * each.sec + each.nanosec for each in found]
    numbers = [[x for part, _ in each.PARTS for x in getattr(each, part)] for each in found]
    return stamp, numbers, found[0].frame_id if found else ''


@pytest.mark.parametrize('options', [{}, {'chunk_size': 700}, {'use_chunking': False}])
@pytest.mark.parametrize(
    'frame',
    [lambda _draw: 'world', lambda draw: draw.choice(['a', 'world', 'a_longer_name'])],
    ids=['alike', 'frames that change'],
)
def test_columns_are_what_the_messages_say_one_by_one(tmp_path, frame, options):
    bag = write(tmp_path / 'bag.mcap', 40, 12, frame=frame, **options)
    told = []
    columns = read_columns(bag, [*bag.topics], progress=told.append)
    assert sum(told) == sum(bag.counts.values()) or not options.get('use_chunking', True)
    for name, found in columns.items():
        stamp, numbers, frame_id = one_by_one(bag, name)
        assert found.stamp.tolist() == stamp == sorted(stamp)
        assert found.numbers.tobytes() == np.array(numbers).tobytes()
        assert found.frame_id == frame_id


@pytest.mark.parametrize('options', [{'chunk_size': 700}, {'use_chunking': False}])
def test_columns_are_in_the_order_of_log_times_and_say_where_the_file_is_not(tmp_path, options):
    pose = cdr.PoseStamped
    with (tmp_path / 'bag.mcap').open('wb') as stream:
        writer = Writer(stream, **options)
        writer.start()
        schema = writer.register_schema(pose.TYPE, 'ros2msg', definition(pose.TYPE).encode())
        channels = [writer.register_channel(f'/t{n}', 'cdr', schema) for n in range(2)]
        log_times = np.random.default_rng(1).permutation(40).tolist()
        for instant, log_time in enumerate(log_times):
            for n, time in enumerate((log_time, instant)):  # of the first alone they are shuffled
                frame = 'world' * (1 + time % 2 * n)  # messages of two sizes
                message = pose(time, 0, frame, (float(time),) * 3, (0.0, 0.0, 0.0, 1.0))
                writer.add_message(channels[n], time, cdr.encode(message), time)
        writer.finish()
    found = read_columns(Bag(tmp_path / 'bag.mcap'), ['/t0', '/t1'])
    assert [columns.reordered for columns in found.values()] == [True, False]
    for columns in found.values():
        assert columns.stamp.tolist() == [10**9 * time for time in range(40)]
        assert columns.numbers[:, 0].tolist() == [*range(40)]


def test_topics_that_are_not_asked_for_are_left_out(tmp_path):
    bag = write(tmp_path / 'bag.mcap', 9, 5)
    found = read_columns(bag, ['/t4', '/t1'])
    assert [*found] == ['/t4', '/t1']
    assert len(found['/t4'].stamp) == bag.counts['/t4']


def test_a_message_of_many_that_is_none_is_named(tmp_path):
    write(tmp_path / 'bag.mcap', 40, 6, enable_crcs=False)
    data = (tmp_path / 'bag.mcap').read_bytes()
    text = cdr.encode(cdr.PoseStamped(0, 9, 'world', (0.0,) * 3, (0.0,) * 4))[:28]
    place = data.index(text)  # of topic 9, whose frame has another length then
    (tmp_path / 'other.mcap').write_bytes(data[: place + 12] + b'\x20' + data[place + 13 :])
    with pytest.raises(DamagedBag, match=r'/t9: .* with a frame_id of 32 bytes'):
        read_columns(Bag(tmp_path / 'other.mcap'), [f'/t{number}' for number in range(40)])


def calls(work):
    """Count the calls of Python and C functions of a piece of work: no clock is asked."""
    count = 0

    def one(_frame, event, _what):
        nonlocal count
        count += event in ('call', 'c_call')

    before = sys.getprofile()
    sys.setprofile(one)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize(
    ('read', 'most'),
    [
        (lambda bag: read_columns(bag, [*bag.topics]), 4),
        (lambda bag: check(bag.path), 36),
    ],
    ids=['columns', 'check'],
)
def test_a_message_more_costs_few_calls_where_topics_are_many(tmp_path, read, most):
    few, many = (write(tmp_path / f'{n}.mcap', 300, n, chunk_size=40_000) for n in (4, 12))
    cost = [calls(lambda bag=bag: read(bag)) for bag in (few, many)]
    messages = [sum(bag.counts.values()) for bag in (few, many)]
    assert (cost[1] - cost[0]) / (messages[1] - messages[0]) < most
