# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contacts are told to each body as it feels them, and an empty message says that it let go.
"""

import numpy as np
import pytest

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.batch import MESSAGE_HEAD_SIZE
from rigid_body_sim.recording.contact_packing import (
    FIELDS,
    FORCE,
    GAP,
    NORMAL,
    OTHER,
    POINT,
    ContactPacker,
    cloud_points,
)

BODIES = ('ground', 'box', 'ball', 'post')
MOVABLE = (False, True, True, False)
DT_NS = 1_000_000
NOTHING = np.empty((0, 2), dtype=np.int64)


def make_packer(**options):
    return ContactPacker(
        BODIES, movable=MOVABLE, dt_ns=DT_NS, **{'first_channel_id': 10, **options}
    )


def arrays(bodies, seed=0):
    """
    Contacts of the given pairs, with made-up numbers.
    """
    numbers, count = np.random.default_rng(seed), len(bodies)
    return {
        'bodies': np.array(bodies, dtype=np.int64).reshape(-1, 2),
        'point': numbers.normal(size=(count, 3)),
        'normal': numbers.normal(size=(count, 3)),
        'gap': numbers.normal(size=count),
        'force': numbers.normal(size=(count, 3)),
    }


def decoded(batch, packer):
    """
    Topic -> message.
    """
    topics = dict(enumerate(packer.topics, start=10))
    return {
        topics[channel].name: cdr.decode(topics[channel].type, payload)
        for channel, payload in (batch.payloads() if batch else ())
    }


def test_only_movable_bodies_are_told_of_their_contacts():
    assert [topic.name for topic in make_packer(namespace='lab').topics] == [
        '/lab/box/contacts',
        '/lab/ball/contacts',
    ]
    packer = make_packer()
    found = decoded(packer.pack(3, **arrays([(0, 1), (2, 3), (0, 2)])), packer)
    assert list(found) == ['/box/contacts', '/ball/contacts']
    assert [len(message.points) for message in found.values()] == [1, 2]


def test_a_contact_of_two_movable_bodies_is_told_from_both_sides():
    packer, given = make_packer(), arrays([(1, 2)])
    found = decoded(packer.pack(3, **given), packer)
    (first,), (second,) = (cloud_points(found[f'/{name}/contacts']) for name in ('box', 'ball'))
    for side, sign, other in ((second, 1.0, 1.0), (first, -1.0, 2.0)):
        assert np.array_equal(side[POINT], given['point'][0])
        assert np.array_equal(side[NORMAL], sign * given['normal'][0])
        assert np.array_equal(side[FORCE], sign * given['force'][0])
        assert (side[GAP], side[OTHER]) == (given['gap'][0], other)


def test_the_contacts_of_a_body_keep_the_order_in_which_they_were_found():
    packer, given = make_packer(), arrays([(0, 1)] * 4 + [(3, 1)])
    (message,) = decoded(packer.pack(3, **given), packer).values()
    assert np.array_equal(cloud_points(message)[:, GAP], given['gap'])


def test_packed_payloads_are_what_the_encoder_writes():
    for frame_id in ('', 'map', 'world', 'Bezug_ä'):
        packer = make_packer(frame_id=frame_id)
        batch = packer.pack(2001, **arrays([(0, 1), (1, 2), (2, 3)]))
        for _, payload in batch.payloads():
            message = cdr.decode(cdr.PointCloud2.TYPE, payload)
            assert payload == cdr.encode(message)
            assert (message.sec, message.nanosec, message.frame_id) == (2, 1_000_000, frame_id)
            assert message.names == FIELDS
        assert len(batch.data) == sum(
            MESSAGE_HEAD_SIZE + len(payload) for _, payload in batch.payloads()
        )


def test_one_empty_message_says_that_a_body_let_go():
    packer = make_packer()
    assert packer.pack(1, **arrays(NOTHING)) is None
    assert packer.pack(2, **arrays([(0, 1), (1, 2)])) is not None
    found = decoded(packer.pack(3, **arrays([(0, 1)])), packer)
    assert [len(message.points) for message in found.values()] == [1, 0]
    assert cdr.decode(cdr.PointCloud2.TYPE, cdr.encode(found['/ball/contacts'])).points == ()
    found = decoded(packer.pack(4, **arrays([(0, 1)])), packer)
    assert list(found) == ['/box/contacts']


def test_what_is_written_next_depends_on_who_touched_and_nothing_else():
    packer, later = make_packer(), make_packer()
    packer.pack(2, **arrays([(0, 1), (1, 2)]))
    later.touching = packer.touching
    given = arrays([(0, 2)], seed=5)
    assert packer.pack(3, **given).data == later.pack(3, **given).data


def test_they_lie_between_wrenches_and_states_in_a_bag_that_others_read(tmp_path, make_run):
    run = make_run(BODIES)
    count = len(run.packer.topics)
    packer = make_packer(first_channel_id=count + 1)
    run.topics[count:count] = packer.topics
    given = arrays([(0, 1), (1, 2)])
    writer = run.open(tmp_path / 'run')
    for tick in (1, 2):
        wrenches, states = run.packer.split(run.state(tick))
        assert wrenches.data + states.data == run.state(tick).data
        for batch in (wrenches, packer.pack(tick, **given), states):
            writer.write(batch)
    writer.close({})
    leaves = [message.topic.split('/')[-1] for message in Bag(tmp_path / 'run').messages()]
    once = ['applied_wrench'] * 4 + ['contacts'] * 2 + ['clock'] + ['pose'] * 4 + ['twist'] * 4
    assert leaves == once * 2
    times = [message.log_time for message in Bag(tmp_path / 'run').messages()]
    assert times == sorted(times)
    reader = pytest.importorskip('rosbags.highlevel').AnyReader
    with reader([tmp_path / 'run']) as bag:
        wanted = [c for c in bag.connections if c.topic == '/box/contacts']
        clouds = [bag.deserialize(data, wanted[0].msgtype) for _, _, data in bag.messages(wanted)]
    assert [cloud.width for cloud in clouds] == [2, 2]
    points = np.frombuffer(clouds[0].data.tobytes(), '<f8').reshape(2, len(FIELDS))
    assert np.array_equal(points[0, FORCE], given['force'][0])
    assert np.array_equal(points[1, FORCE], -given['force'][1])
