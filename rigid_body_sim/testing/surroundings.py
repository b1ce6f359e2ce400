# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The environment of node and test: a domain of their own, this machine alone, and quick discovery.

A discovery profile that the user has chosen is left as it is.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import rigid_body_sim
from rigid_body_sim.ros.middleware import PROFILE_VARIABLES

PROFILE = Path(__file__).with_name('fast_dds.xml')


def surroundings(domain: int, given: Mapping[str, str]) -> dict[str, str | None]:
    """
    What to change in an environment; None: to be taken out.
    """
    changes: dict[str, str | None] = {
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_STATIC_PEERS': None,
    }
    if not any(given.get(name) for name in PROFILE_VARIABLES):
        changes[PROFILE_VARIABLES[0]] = str(PROFILE)
    return changes


def of_child(domain: int) -> dict[str, str]:
    """
    The environment of a node: it finds this very package, and writes each line at once.
    """
    changed = {**os.environ, **surroundings(domain, os.environ)}
    environment = {name: value for name, value in changed.items() if value is not None}
    environment['RCUTILS_LOGGING_BUFFERED_STREAM'] = '0'
    environment['RCUTILS_COLORIZED_OUTPUT'] = '0'
    home = Path(rigid_body_sim.__file__).parents[1]
    if home.name not in ('site-packages', 'dist-packages'):
        path = environment.get('PYTHONPATH')
        environment['PYTHONPATH'] = os.pathsep.join([str(home), *([path] if path else [])])
    return environment
