# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Message definitions and type hashes of the recorded types, so that a bag can be written where no
ROS is installed.

The texts are the field lists of the ROS 2 Jazzy `.msg` files without comments. `definition` joins
a type and its dependencies as rosbag2 embeds them (`ros2msg` encoding); the hash (RIHS01,
REP-2016) is that of the type description. The tests compare both with the installed files and with
values computed by another implementation.
"""

from __future__ import annotations

_SEPARATOR = '\n' + '=' * 80 + '\n'

_FIELDS = {
    'builtin_interfaces/msg/Time': ('int32 sec', 'uint32 nanosec'),
    'std_msgs/msg/Header': ('builtin_interfaces/Time stamp', 'string frame_id'),
    'rosgraph_msgs/msg/Clock': ('builtin_interfaces/Time clock',),
    'sensor_msgs/msg/PointField': (
        *('uint8 INT8    = 1', 'uint8 UINT8   = 2', 'uint8 INT16   = 3', 'uint8 UINT16  = 4'),
        *('uint8 INT32   = 5', 'uint8 UINT32  = 6', 'uint8 FLOAT32 = 7', 'uint8 FLOAT64 = 8'),
        *('string name', 'uint32 offset', 'uint8 datatype', 'uint32 count'),
    ),
    'sensor_msgs/msg/PointCloud2': (
        *('std_msgs/Header header', 'uint32 height', 'uint32 width', 'PointField[] fields'),
        *('bool is_bigendian', 'uint32 point_step', 'uint32 row_step', 'uint8[] data'),
        'bool is_dense',
    ),
    'geometry_msgs/msg/Point': ('float64 x', 'float64 y', 'float64 z'),
    'geometry_msgs/msg/Quaternion': ('float64 x 0', 'float64 y 0', 'float64 z 0', 'float64 w 1'),
    'geometry_msgs/msg/Vector3': ('float64 x', 'float64 y', 'float64 z'),
    'geometry_msgs/msg/Pose': ('Point position', 'Quaternion orientation'),
    'geometry_msgs/msg/Twist': ('Vector3 linear', 'Vector3 angular'),
    'geometry_msgs/msg/Wrench': ('Vector3 force', 'Vector3 torque'),
    'geometry_msgs/msg/Accel': ('Vector3 linear', 'Vector3 angular'),
    'geometry_msgs/msg/PoseStamped': ('std_msgs/Header header', 'Pose pose'),
    'geometry_msgs/msg/TwistStamped': ('std_msgs/Header header', 'Twist twist'),
    'geometry_msgs/msg/AccelStamped': ('std_msgs/Header header', 'Accel accel'),
    'geometry_msgs/msg/WrenchStamped': ('std_msgs/Header header', 'Wrench wrench'),
    'geometry_msgs/msg/Vector3Stamped': ('std_msgs/Header header', 'Vector3 vector'),
    'geometry_msgs/msg/PoseWithCovariance': ('Pose pose', 'float64[36] covariance'),
    'geometry_msgs/msg/TwistWithCovariance': ('Twist twist', 'float64[36] covariance'),
    'nav_msgs/msg/Odometry': (
        *('std_msgs/Header header', 'string child_frame_id'),
        *('geometry_msgs/PoseWithCovariance pose', 'geometry_msgs/TwistWithCovariance twist'),
    ),
    'geometry_msgs/msg/PoseArray': ('std_msgs/Header header', 'Pose[] poses'),
    'geometry_msgs/msg/Transform': ('Vector3 translation', 'Quaternion rotation'),
    'geometry_msgs/msg/TransformStamped': (
        *('std_msgs/Header header', 'string child_frame_id', 'Transform transform'),
    ),
    'tf2_msgs/msg/TFMessage': ('geometry_msgs/TransformStamped[] transforms',),
    'sensor_msgs/msg/MultiDOFJointState': (
        *('std_msgs/Header header', 'string[] joint_names'),
        *('geometry_msgs/Transform[] transforms', 'geometry_msgs/Twist[] twist'),
        'geometry_msgs/Wrench[] wrench',
    ),
    'builtin_interfaces/msg/Duration': ('int32 sec', 'uint32 nanosec'),
    'std_msgs/msg/ColorRGBA': ('float32 r', 'float32 g', 'float32 b', 'float32 a'),
    'sensor_msgs/msg/CompressedImage': (
        *('std_msgs/Header header', 'string format', 'uint8[] data'),
    ),
    'visualization_msgs/msg/UVCoordinate': ('float32 u', 'float32 v'),
    'visualization_msgs/msg/MeshFile': ('string filename', 'uint8[] data'),
    'visualization_msgs/msg/Marker': (
        *('int32 ARROW=0', 'int32 CUBE=1', 'int32 SPHERE=2', 'int32 CYLINDER=3'),
        *('int32 LINE_STRIP=4', 'int32 LINE_LIST=5', 'int32 CUBE_LIST=6', 'int32 SPHERE_LIST=7'),
        *('int32 POINTS=8', 'int32 TEXT_VIEW_FACING=9', 'int32 MESH_RESOURCE=10'),
        *('int32 TRIANGLE_LIST=11', 'int32 ARROW_STRIP=12'),
        *('int32 ADD=0', 'int32 MODIFY=0', 'int32 DELETE=2', 'int32 DELETEALL=3'),
        *('std_msgs/Header header', 'string ns', 'int32 id', 'int32 type', 'int32 action'),
        *('geometry_msgs/Pose pose', 'geometry_msgs/Vector3 scale', 'std_msgs/ColorRGBA color'),
        *('builtin_interfaces/Duration lifetime', 'bool frame_locked'),
        *('geometry_msgs/Point[] points', 'std_msgs/ColorRGBA[] colors'),
        *('string texture_resource', 'sensor_msgs/CompressedImage texture'),
        *('UVCoordinate[] uv_coordinates', 'string text', 'string mesh_resource'),
        *('MeshFile mesh_file', 'bool mesh_use_embedded_materials'),
    ),
    'visualization_msgs/msg/MarkerArray': ('Marker[] markers',),
}

HASHES = {
    'geometry_msgs/msg/PoseStamped': (
        'RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8'
    ),
    'geometry_msgs/msg/TwistStamped': (
        'RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64'
    ),
    'geometry_msgs/msg/AccelStamped': (
        'RIHS01_ef1df9eabae0a708cc049a061ebcddc4e2a5f745730100ba680e086a9698b165'
    ),
    'geometry_msgs/msg/WrenchStamped': (
        'RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77'
    ),
    'geometry_msgs/msg/Vector3Stamped': (
        'RIHS01_d4829622288cbb443886e7ea94ea5671a3b1be6bab4ad04224432a65f7d7887a'
    ),
    'sensor_msgs/msg/PointCloud2': (
        'RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5'
    ),
    'nav_msgs/msg/Odometry': (
        'RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0'
    ),
    'geometry_msgs/msg/PoseArray': (
        'RIHS01_af0cc36d190e104d546d168d6b39df04fa4b4ccecf59cb4c9ed328d3d5004aa0'
    ),
    'sensor_msgs/msg/MultiDOFJointState': (
        'RIHS01_4d4ded702cfba7ff3ec783835c1a1425f75e53939a430ff355d1fee4b3bbc40b'
    ),
    'visualization_msgs/msg/MarkerArray': (
        'RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf'
    ),
    'tf2_msgs/msg/TFMessage': (
        'RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087'
    ),
    'rosgraph_msgs/msg/Clock': (
        'RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564'
    ),
}


def fields_of(type_name: str) -> tuple[str, ...]:
    """Return the lines of a type's definition, constants too."""
    return _FIELDS[type_name]


def definition(type_name: str) -> str:
    """
    Return the text of a type followed by its dependencies.

    Depth first, the dependencies of one type in sorted order, each once; the headline of a
    dependency is `MSG: std_msgs/Header`, without `/msg/`.
    """
    dependencies = (
        f'MSG: {name.replace("/msg/", "/")}\n{_text(name)}'
        for name in _dependencies(type_name, set())
    )
    return _SEPARATOR.join([_text(type_name), *dependencies])


def _text(type_name: str) -> str:
    return ''.join(f'{field}\n' for field in _FIELDS[type_name])


def _dependencies(type_name: str, seen: set[str]) -> list[str]:
    package = type_name.split('/')[0]
    used = (field.split()[0].removesuffix('[]') for field in _FIELDS[type_name])
    names = (word if '/' in word else f'{package}/{word}' for word in used)
    known = {name.replace('/', '/msg/', 1) for name in names} & _FIELDS.keys()
    found = []
    for name in sorted(known - seen):
        if name not in seen:
            seen.add(name)
            found += [name, *_dependencies(name, seen)]
    return found
