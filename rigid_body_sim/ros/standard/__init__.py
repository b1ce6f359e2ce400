# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The services of `simulation_interfaces`, the standard of ROS for simulators, where it is installed.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rclpy.node import Node

    from rigid_body_sim.ros.run_loop import RunLoop
    from rigid_body_sim.ros.standard.services import Standard
    from rigid_body_sim.runs.run import Run

PACKAGE = 'simulation_interfaces'


def offer(node: Node, loop: RunLoop, run: Run, *, world_frame: str) -> Standard | None:
    """Offer the services, before the run begins; None where the package cannot be used."""
    if find_spec(PACKAGE) is None:
        node.get_logger().debug(f'{PACKAGE} is not installed: no standard services')
        return None
    from rclpy.exceptions import NoTypeSupportImportedException
    from rosidl_generator_py.import_type_support_impl import UnsupportedTypeSupport

    from rigid_body_sim.ros.standard.messages import Messages
    from rigid_body_sim.ros.standard.services import Standard

    try:
        return Standard(node, loop, run, Messages(), world_frame=world_frame)
    except (
        ImportError,
        AttributeError,
        NoTypeSupportImportedException,
        UnsupportedTypeSupport,
    ) as error:
        node.get_logger().warning(f'{PACKAGE} is of no use here, no standard services: {error}')
        return None
