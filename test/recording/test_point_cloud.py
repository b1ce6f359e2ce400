# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Clouds of float64 points: the bytes of ROS, read by us and by others."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap_ros2._dynamic import generate_dynamic
from rosbags.typesys import Stores, get_typestore

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.definitions import definition

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPE = cdr.PointCloud2.TYPE
WORDS = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)
DOUBLES = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)


@st.composite
def clouds(draw):
    """
    Clouds of any fields and points.
    """
    names = tuple(draw(st.lists(WORDS, min_size=1, max_size=4)))
    points = st.lists(st.tuples(*[DOUBLES] * len(names)), max_size=4)
    stamp = draw(st.integers(-(2**31), 2**31 - 1)), draw(st.integers(0, 2**32 - 1))
    return cdr.PointCloud2(*stamp, draw(WORDS), names, tuple(draw(points)))


def foreign(cloud):
    """
    The same message as an object of the rosbags package.
    """
    kind = STORE.types
    stamp = kind['builtin_interfaces/msg/Time'](cloud.sec, cloud.nanosec)
    fields = [
        kind['sensor_msgs/msg/PointField'](name, 8 * place, 8, 1)
        for place, name in enumerate(cloud.names)
    ]
    step, width = 8 * len(cloud.names), len(cloud.points)
    data = np.frombuffer(np.array(cloud.points, dtype='<f8').tobytes(), np.uint8)
    header = kind['std_msgs/msg/Header'](stamp, cloud.frame_id)
    return kind[TYPE](header, 1, width, fields, False, step, step * width, data, True)


def bits(cloud):
    """
    All of a cloud, doubles by their bits, so that NaN equals itself.
    """
    texts = cloud.sec, cloud.nanosec, cloud.frame_id, cloud.names
    return texts, len(cloud.points), np.array(cloud.points, dtype=float).tobytes()


@given(clouds())
def test_decoding_inverts_encoding_bit_for_bit(cloud):
    assert bits(cdr.decode(TYPE, cdr.encode(cloud))) == bits(cloud)


@given(clouds())
def test_bytes_are_those_of_rosbags(cloud):
    assert cdr.encode(cloud) == bytes(STORE.serialize_cdr(foreign(cloud), TYPE))


@given(clouds())
def test_big_endian_is_read(cloud):
    payload = bytes(STORE.serialize_cdr(foreign(cloud), TYPE, little_endian=False))
    assert payload[1] == 0
    assert bits(cdr.decode(TYPE, payload)) == bits(cloud)


@given(clouds())
def test_mcap_ros2_reads_the_same_points(cloud):
    read = generate_dynamic(TYPE, definition(TYPE))[TYPE](cdr.encode(cloud))
    assert read.header.frame_id == cloud.frame_id
    assert [field.name for field in read.fields] == list(cloud.names)
    assert [field.offset for field in read.fields] == [8 * k for k in range(len(cloud.names))]
    assert read.point_step == 8 * len(cloud.names) and read.width == len(cloud.points)
    assert bytes(read.data) == np.array(cloud.points, dtype='<f8').tobytes()


@given(clouds())
def test_rclpy_reads_what_is_written_and_writes_what_is_read(cloud):
    serialization = pytest.importorskip('rclpy.serialization')
    from sensor_msgs.msg import PointCloud2

    message = serialization.deserialize_message(cdr.encode(cloud), PointCloud2)
    assert bytes(message.data) == np.array(cloud.points, dtype='<f8').tobytes()
    theirs = serialization.serialize_message(message)
    assert bits(cdr.decode(TYPE, theirs)) == bits(cloud)


def test_every_scalar_has_a_name():
    cloud = cdr.PointCloud2(1, 2, 'world', ('x', 'gap'), ((1.0, 2.0), (3.0, 4.0)))
    named = cdr.fields(cloud)
    assert (named['fields'], named['width']) == ('x gap', 2)
    assert (named['points[1].x'], named['points[1].gap']) == (3.0, 4.0)


@given(clouds(), st.data())
def test_no_part_of_a_cloud_is_a_cloud(cloud, data):
    payload = cdr.encode(cloud)
    cut = data.draw(st.integers(0, len(payload) - 1))
    filled = payload + bytes(-len(payload) % 4)
    for wrong in (payload[:cut], filled + b'\0', filled + bytes(4)):
        with pytest.raises(cdr.CdrError):
            cdr.decode(TYPE, wrong)


@given(clouds())
def test_what_dds_fills_up_to_four_bytes_is_passed_over(cloud):
    payload = cdr.encode(cloud)
    assert bits(cdr.decode(TYPE, payload + bytes(-len(payload) % 4))) == bits(cloud)


def test_other_kinds_of_fields_are_refused():
    cloud = foreign(cdr.PointCloud2(1, 2, 'world', ('x', 'y'), ((1.0, 2.0),)))
    for changes in ({'datatype': 7}, {'count': 2}, {'offset': 16}):
        fields = [cloud.fields[0], cloud.fields[1]]
        kind = type(fields[1])
        fields[1] = kind(**{**vars(fields[1]), **changes, '__msgtype__': fields[1].__msgtype__})
        changed = type(cloud)(**{**vars(cloud), 'fields': fields})
        with pytest.raises(cdr.CdrError, match="field 'y' at"):
            cdr.decode(TYPE, bytes(STORE.serialize_cdr(changed, TYPE)))
