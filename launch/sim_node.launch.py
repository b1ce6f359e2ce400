# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Start the node with everything that RViz shows, and RViz.

    ros2 launch rigid_body_sim sim_node.launch.py scene:=stack
    ros2 launch rigid_body_sim sim_node.launch.py scene:=stack namespace:=lab frame_prefix:=lab/
    ros2 launch rigid_body_sim sim_node.launch.py rviz:=false params_file:=my_node.yaml

A file of parameters overrides what this file sets.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = 'rigid_body_sim'
CONFIG = PathJoinSubstitution([FindPackageShare(PACKAGE), 'config'])
ARGUMENTS = (
    ('scene', 'demo', 'path of a scene file, or the name of a shipped scene'),
    ('namespace', '', 'of the node and its topics'),
    ('frame_prefix', '', 'before the names of frames of bodies, such as lab/'),
    ('record', 'false', 'record a bag from the start'),
    ('rviz', 'true', 'start RViz too; when it is closed, the node ends'),
    (
        'params_file',
        PathJoinSubstitution([CONFIG, 'seen.yaml']),
        'further parameters of the node',
    ),
    ('rviz_config', PathJoinSubstitution([CONFIG, f'{PACKAGE}.rviz']), 'what RViz shows'),
)


def generate_launch_description() -> LaunchDescription:
    """Describe both processes."""
    given = {name: LaunchConfiguration(name) for name, _, _ in ARGUMENTS}
    texts = {
        name: ParameterValue(given[name], value_type=str) for name in ('scene', 'frame_prefix')
    }
    node = Node(
        package=PACKAGE,
        executable='sim_node',
        namespace=given['namespace'],
        parameters=[
            {
                **texts,
                'record': ParameterValue(given['record'], value_type=bool),
                'publish_tf': True,
                'publish_markers': True,
                'publish_odometry': True,
                'publish_arrays': True,
            },
            given['params_file'],
        ],
        output='screen',
        on_exit=Shutdown(),
    )
    rviz = Node(
        package='rviz2',
        executable='rviz2',
        namespace=given['namespace'],
        arguments=['-d', given['rviz_config']],
        parameters=[{'use_sim_time': True}],
        condition=IfCondition(given['rviz']),
        on_exit=Shutdown(),
    )
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, default, description in ARGUMENTS
    ]
    return LaunchDescription([*declared, node, rviz])
