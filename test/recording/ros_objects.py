# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The same message as an object of ROS, or of rosbags, built field by field; the bytes they make.
"""

import importlib

import numpy as np
from rosbags.typesys import Stores, get_typestore

from rigid_body_sim.recording import cdr

STORE = get_typestore(Stores.ROS2_JAZZY)


def values_of(message):
    """
    The fields of a message of ours as nested mappings, as its definition has them.
    """
    if isinstance(message, cdr.Described):
        return message.values

    def named(axes, numbers):
        return dict(zip(axes, numbers))

    pose = {
        'position': named('xyz', message.position),
        'orientation': named('xyzw', message.orientation),
    }
    twist = {'linear': named('xyz', message.linear), 'angular': named('xyz', message.angular)}
    stamp = {'sec': message.sec, 'nanosec': message.nanosec}
    return {
        'header': {'stamp': stamp, 'frame_id': message.frame_id},
        'child_frame_id': message.child_frame_id,
        'pose': {'pose': pose, 'covariance': list(message.pose_covariance)},
        'twist': {'twist': twist, 'covariance': list(message.twist_covariance)},
    }


def by_rclpy(type_name, message):
    """
    Bytes that rclpy makes of a message object with the fields of ours; padding may hold anything.
    """
    serialization = importlib.import_module('rclpy.serialization')
    return bytes(serialization.serialize_message(_ros(ros_class(type_name), values_of(message))))


def ros_class(type_name):
    """
    The message class of a type.
    """
    package, _, name = type_name.replace('/msg/', '/').partition('/')
    return getattr(importlib.import_module(f'{package}.msg'), name)


def _ros(kind, values):
    found = kind()
    for name, described in kind.get_fields_and_field_types().items():
        value = values[name]
        inner = described.removeprefix('sequence<').removesuffix('>')
        if isinstance(value, dict):
            value = _ros(ros_class(inner), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            value = [_ros(ros_class(inner), each) for each in value]
        elif described == 'boolean':
            value = bool(value)
        setattr(found, name, value)
    return found


def by_rosbags(type_name, message):
    """
    Bytes that rosbags makes of it; padding is zero.
    """
    return bytes(STORE.serialize_cdr(_foreign(type_name, values_of(message)), type_name))


def _foreign(type_name, values):
    kind, arguments = STORE.types[type_name], {}
    for name, (_, detail) in STORE.get_msgdef(type_name).fields:
        value = values[name]
        if isinstance(value, dict):
            value = _foreign(detail, value)
        elif isinstance(value, list):
            inner = detail[0]
            value = (
                [_foreign(inner[1], each) for each in value]
                if inner[0].name == 'NAME'
                else _plain(inner[1][0], value)
            )
        arguments[name] = value
    return kind(**arguments)


def _plain(name, values):
    return values if name == 'string' else np.array(values, dtype=name)
