# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Odometry: the bytes of ROS, read by us and by others."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from rigid_body_sim.recording import cdr

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPE = cdr.Odometry.TYPE
WORDS = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=11)
DOUBLES = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)


@st.composite
def odometries(draw):
    """
    Messages of any names and doubles.
    """
    numbers = draw(st.lists(DOUBLES, min_size=13, max_size=13))
    known = draw(DOUBLES)
    return cdr.Odometry(
        *(draw(st.integers(-(2**31), 2**31 - 1)), draw(st.integers(0, 2**32 - 1))),
        *(draw(WORDS), draw(WORDS)),
        *(tuple(numbers[a:b]) for a, b in ((0, 3), (3, 7), (7, 10), (10, 13))),
        pose_covariance=(known, *[0.0] * 35),
        twist_covariance=(*[0.0] * 35, known),
    )


def foreign(message):
    """
    The same message as an object of the rosbags package.
    """
    kind = STORE.types
    point, turn, vector, pose, twist = (
        kind[f'geometry_msgs/msg/{name}']
        for name in ('Point', 'Quaternion', 'Vector3', 'Pose', 'Twist')
    )
    stamp = kind['builtin_interfaces/msg/Time'](message.sec, message.nanosec)
    where = pose(point(*message.position), turn(*message.orientation))
    moves = twist(vector(*message.linear), vector(*message.angular))
    return kind[TYPE](
        kind['std_msgs/msg/Header'](stamp, message.frame_id),
        message.child_frame_id,
        kind['geometry_msgs/msg/PoseWithCovariance'](where, np.array(message.pose_covariance)),
        kind['geometry_msgs/msg/TwistWithCovariance'](moves, np.array(message.twist_covariance)),
    )


def bits(message):
    return [
        np.float64(value).tobytes() if isinstance(value, float) else value
        for value in cdr.fields(message).values()
    ]


@given(odometries(), st.booleans())
def test_bytes_are_those_of_rosbags_and_are_read_in_both_orders(message, little_endian):
    theirs = bytes(STORE.serialize_cdr(foreign(message), TYPE, little_endian=little_endian))
    if little_endian:
        assert cdr.encode(message) == theirs
    assert bits(cdr.decode(TYPE, theirs)) == bits(message)
    assert cdr.canonical(message, theirs) == cdr.encode(message)


@given(odometries())
def test_rclpy_reads_the_same_message(message):
    serialization = pytest.importorskip('rclpy.serialization')
    from nav_msgs.msg import Odometry

    ours = cdr.encode(message)
    theirs = serialization.serialize_message(serialization.deserialize_message(ours, Odometry))
    assert len(theirs) == len(ours)
    assert cdr.canonical(cdr.decode(TYPE, theirs), theirs) == ours


@given(odometries(), st.data())
def test_truncated_and_overlong_payloads_are_refused(message, data):
    payload = cdr.encode(message)
    cut = data.draw(st.integers(0, len(payload) - 1))
    for wrong in (payload[:cut], payload + b'\0', payload + bytes(8)):
        with pytest.raises(cdr.CdrError, match=TYPE):
            cdr.decode(TYPE, wrong)


def test_every_number_has_a_name_of_its_own():
    zero = (0.0,) * 3
    named = cdr.fields(cdr.Odometry(1, 2, 'world', 'box', zero, (0.0, 0.0, 0.0, 1.0), zero, zero))
    assert len(named) == 2 + 2 + 85
    assert named['child_frame_id'] == 'box'
    assert named['pose_covariance.35'] == 0.0
