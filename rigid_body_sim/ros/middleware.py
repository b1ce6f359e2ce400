# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What Fast DDS is told before the node is made: that the node does not listen to itself.

Whenever a publisher or a subscription is made, Fast DDS compares it with all that the process has
of the other kind, and copies what it knows of each: the time grows with the square of the bodies,
26 s for 1000 of them and 160 s for 2500, where it is 5 s and 13 s without (measured). It takes a
profile for that, which is read once in a process. So it is given only

- to a process that is the node's alone: others may want to hear each other in theirs;
- where the user has chosen no profile, by variable or by a file in the current folder;
- where no remapping may lead something that the node publishes to one of its commands.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

from rigid_body_sim.runs.commands import KINDS
from rigid_body_sim.stop_signals import STOP

PROFILE = Path(__file__).with_name('fast_dds.xml')
PROFILE_VARIABLES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
PROFILE_FILES = ('DEFAULT_FASTRTPS_PROFILES.xml', 'DEFAULT_FASTDDS_PROFILES.xml')


@contextmanager
def deaf_to_itself(words: Sequence[str]) -> Iterator[None]:
    """
    Make a node that takes nothing which it publishes itself, where that changes nothing but time.

    words : arguments for ROS
    """
    if not STOP.owns_process or _has_profile() or _may_hear_itself(words):
        yield
        return
    os.environ[PROFILE_VARIABLES[0]] = str(PROFILE)
    try:
        yield
    finally:
        del os.environ[PROFILE_VARIABLES[0]]  # it was read; processes begun later choose anew


def _has_profile() -> bool:
    return any(os.environ.get(name) for name in PROFILE_VARIABLES) or any(
        Path(name).exists() for name in PROFILE_FILES
    )


def _may_hear_itself(words: Sequence[str]) -> bool:
    """Whether a rule of remapping leads to or from a topic of commands."""
    rules = (word for flag, word in pairwise(words) if flag in ('-r', '--remap'))
    return any(end.rpartition('/')[2] in KINDS for rule in rules for end in rule.split(':='))
