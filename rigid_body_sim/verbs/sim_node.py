# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`sim_node --ros-args -p scene:=SCENE …`: the ROS 2 node.

Wrenches in, poses and twists out, a bag on request.
"""

from __future__ import annotations

import argparse

from rigid_body_sim.ros.parameters import help_text
from rigid_body_sim.stop_signals import STOP

SUMMARY = 'the ROS 2 node: wrenches in, poses and twists out, a bag on request'
TAKES_ROS_ARGUMENTS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line: everything is a ROS parameter."""
    parser.usage = (
        f'{parser.prog} [--ros-args -p name:=value … --params-file FILE -r __ns:=/NAMESPACE]'
    )
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = help_text()


def run(arguments: argparse.Namespace) -> int:
    """Run the node until stop_time, SIGINT, SIGTERM or SIGHUP."""
    STOP.stage = 'before it was ready'
    # takes most of the start
    from rigid_body_sim.ros.session import run_node

    run_node(arguments.ros_arguments)
    return 0
