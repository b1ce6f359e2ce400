# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What to say where a Python package is missing: who owns it, and how one comes by it."""

from __future__ import annotations

_OF_ROS = ('rclpy', 'rcl_interfaces', 'builtin_interfaces', 'ament_index_python', 'std_srvs')
_MESSAGES = ('_msgs', '_interfaces')
_DISTRIBUTIONS = {'yaml': 'PyYAML'}  # that have another name than what is imported

_OPTIONAL = {
    'distributed': 'it talks to a Dask cluster (--scheduler); a sweep on this machine does not',
    'coacd': 'a scene with a mesh `as: parts` needs it; a recording of that scene does not',
    'gymnasium': 'the environments need it (the extra gym)',
    'pandas': 'tables need it (the extra tables)',
    'pyarrow': 'Parquet files need it (the extra tables)',
    'xarray': 'data sets with named dimensions need it (the extra tables)',
}


def missing(module: str) -> str:
    """
    Say in one line that a module cannot be imported, and the cure.

    module : as ModuleNotFoundError names it
    """
    package = module.partition('.')[0]
    if package in _OF_ROS or package.endswith(_MESSAGES):
        return (
            f'ROS 2 is missing here (the Python package {package}, which pip knows under no such '
            'name): source a ROS 2 Jazzy installation that has it, or run make venv, which brings '
            'rclpy as wheels (requirements/ros.txt)'
        )
    if package in _OPTIONAL:
        return (
            f'the Python package {package} is missing: pip install {package}; {_OPTIONAL[package]}'
        )
    name = _DISTRIBUTIONS.get(package, package)
    return (
        f'the Python package {package} is missing: pip install {name}, or run make venv, which '
        'brings all that is needed (requirements/runtime.txt)'
    )
