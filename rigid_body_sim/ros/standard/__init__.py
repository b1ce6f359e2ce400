# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The services of `simulation_interfaces`, the standard of ROS for simulators."""
