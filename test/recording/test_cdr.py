# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
CDR bytes: what is written can be read, by us and by others, and what is no message is refused.
"""

import importlib
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap_ros2._dynamic import generate_dynamic
from rosbags.typesys import Stores, get_typestore

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.definitions import definition

STORE = get_typestore(Stores.ROS2_JAZZY)
ORDERS = {'little': True, 'big': False}

seconds = st.integers(-(2**31), 2**31 - 1)
nanoseconds = st.integers(0, 2**32 - 1)
frames = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=20)
doubles = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)


def vectors(width):
    """
    Tuples of any doubles.
    """
    return st.tuples(*[doubles] * width)


messages = st.one_of(
    st.builds(cdr.Clock, seconds, nanoseconds),
    st.builds(cdr.PoseStamped, seconds, nanoseconds, frames, vectors(3), vectors(4)),
    st.builds(cdr.TwistStamped, seconds, nanoseconds, frames, vectors(3), vectors(3)),
    st.builds(cdr.WrenchStamped, seconds, nanoseconds, frames, vectors(3), vectors(3)),
    st.builds(cdr.Vector3Stamped, seconds, nanoseconds, frames, vectors(3)),
)


def foreign(message, store=STORE):
    """
    The same message as an object of the rosbags package.
    """
    kind = store.types
    stamp = kind['builtin_interfaces/msg/Time'](message.sec, message.nanosec)
    if isinstance(message, cdr.Clock):
        return kind[message.TYPE](stamp)
    header = kind['std_msgs/msg/Header'](stamp, message.frame_id)
    parts = [getattr(message, name) for name, _ in message.PARTS]
    inner = [
        kind[f'geometry_msgs/msg/{name}'](*part) for name, part in zip(inner_names(message), parts)
    ]
    if len(inner) == 2:
        whole = message.TYPE.removesuffix('Stamped')
        inner = [kind[whole](*inner)]
    return kind[message.TYPE](header, *inner)


def inner_names(message):
    """
    Types of the parts of a message.
    """
    return ('Point', 'Quaternion') if isinstance(message, cdr.PoseStamped) else ('Vector3',) * 2


def bits(message):
    """
    All scalars, doubles by their bits, so that NaN equals itself.
    """
    return [
        np.float64(value).tobytes() if isinstance(value, float) else value
        for value in cdr.fields(message).values()
    ]


@given(messages)
def test_decoding_inverts_encoding_bit_for_bit(message):
    assert bits(cdr.decode(message.TYPE, cdr.encode(message))) == bits(message)


@given(messages)
def test_bytes_are_those_of_rosbags(message):
    assert cdr.encode(message) == bytes(STORE.serialize_cdr(foreign(message), message.TYPE))


@given(messages)
def test_big_endian_is_read(message):
    payload = bytes(STORE.serialize_cdr(foreign(message), message.TYPE, little_endian=False))
    assert payload[1] == 0
    assert bits(cdr.decode(message.TYPE, payload)) == bits(message)


@given(messages)
def test_mcap_ros2_reads_the_same_values(message):
    decode = generate_dynamic(message.TYPE, definition(message.TYPE))[message.TYPE]
    read = decode(cdr.encode(message))
    if isinstance(message, cdr.Clock):
        assert (read.clock.sec, read.clock.nanosec) == (message.sec, message.nanosec)
        return
    assert read.header.frame_id == message.frame_id
    body = getattr(read, message.TYPE.split('/')[-1].removesuffix('Stamped').lower(), None)
    parts = [read.vector] if body is None else [getattr(body, name) for name, _ in message.PARTS]
    if isinstance(message, cdr.Vector3Stamped):
        parts = [read.vector]
    values = [getattr(part, axis) for part in parts for axis in 'xyzw' if hasattr(part, axis)]
    expected = [value for name, _ in message.PARTS for value in getattr(message, name)]
    assert np.array(values).tobytes() == np.array(expected).tobytes()


@given(messages)
def test_rclpy_serialises_the_same_bytes_outside_padding(message):
    serialization = pytest.importorskip('rclpy.serialization')
    kind = ros_type(message.TYPE)
    ours = cdr.encode(message)
    theirs = serialization.serialize_message(serialization.deserialize_message(ours, kind))
    assert len(theirs) == len(ours)
    assert bits(cdr.decode(message.TYPE, theirs)) == bits(message)
    if not isinstance(message, cdr.Clock):
        end = 16 + len(message.frame_id.encode()) + 1
        start = 4 + cdr.up(end - 4, 8)
        theirs = theirs[:end] + bytes(start - end) + theirs[start:]
    assert theirs == ours


def ros_type(name):
    """
    The message class of a type name.
    """
    package, _, short = name.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), short)


@given(messages, st.binary(min_size=7, max_size=7))
def test_padding_may_hold_anything(message, noise):
    if isinstance(message, cdr.Clock):
        return
    payload = bytearray(cdr.encode(message))
    end = 16 + len(message.frame_id.encode()) + 1
    start = 4 + cdr.up(end - 4, 8)
    payload[end:start] = noise[: start - end]
    payload[2:4] = noise[:2]  # encapsulation options
    assert bits(cdr.decode(message.TYPE, bytes(payload))) == bits(message)


@given(messages, st.binary(min_size=7, max_size=7), st.booleans())
def test_bytes_are_kept_unless_their_order_or_padding_would_tell_equal_messages_apart(
    message, noise, little_endian
):
    ours = cdr.encode(message)
    assert cdr.canonical(message, ours) == ours
    if not isinstance(message, cdr.PointCloud2):
        assert cdr.canonical(message, ours) is ours
    theirs = bytearray(
        STORE.serialize_cdr(foreign(message), message.TYPE, little_endian=little_endian)
    )
    if not isinstance(message, cdr.Clock):
        end = 16 + len(message.frame_id.encode()) + 1
        theirs[end : 4 + cdr.up(end - 4, 8)] = noise[: 4 + cdr.up(end - 4, 8) - end]
    theirs[2:4] = noise[:2]
    assert cdr.canonical(message, bytes(theirs)) == ours


@given(messages, st.data())
def test_truncated_and_overlong_payloads_are_refused(message, data):
    payload = cdr.encode(message)
    cut = data.draw(st.integers(0, len(payload) - 1))
    for wrong in (payload[:cut], payload + b'\0', payload + bytes(8)):
        with pytest.raises(cdr.CdrError, match=message.TYPE):
            cdr.decode(message.TYPE, wrong)


@given(st.sampled_from(sorted(cdr.TYPES)), st.binary(max_size=120))
def test_noise_is_decoded_or_refused_but_never_crashes(type_name, noise):
    for payload in (noise, b'\0\1\0\0' + noise, b'\0\0\0\0' + noise):
        with suppress(cdr.CdrError):
            cdr.decode(type_name, payload)


@pytest.mark.parametrize(
    ('change', 'problem'),
    [
        ((1, 2), 'encapsulation 00 02'),
        ((0, 1), 'encapsulation 01 01'),
        ((12, 200), 'expected'),
        ((21, ord('x')), 'NUL'),
        ((17, 0), 'NUL'),
        ((16, 0xFF), 'UTF-8'),
    ],
)
def test_a_malformed_message_is_refused_with_its_reason(change, problem):
    zeros = (0.0, 0.0, 0.0)
    payload = bytearray(cdr.encode(cdr.TwistStamped(1, 2, 'world', zeros, zeros)))
    payload[change[0]] = change[1]
    with pytest.raises(cdr.CdrError, match=problem):
        cdr.decode(cdr.TwistStamped.TYPE, bytes(payload))


def test_an_empty_frame_may_come_without_its_nul():
    message = cdr.Vector3Stamped(1, 2, '', (1.0, 2.0, 3.0))
    payload = bytearray(cdr.encode(message))
    payload[12] = 0
    assert cdr.decode(message.TYPE, bytes(payload)) == message


@pytest.mark.parametrize(
    'message',
    [
        cdr.Clock(2**31, 0),
        cdr.Clock(0, -1),
        cdr.Vector3Stamped(0, 0, 'a\0b', (0.0, 0.0, 0.0)),
    ],
)
def test_what_cdr_cannot_hold_is_refused(message):
    with pytest.raises(cdr.CdrError):
        cdr.encode(message)


def test_an_unknown_type_is_refused():
    with pytest.raises(cdr.CdrError, match='unknown type'):
        cdr.decode('std_msgs/msg/String', b'\0\1\0\0' + bytes(8))
