# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bags of tests that failed: kept below the root folder of the tests, with the line that replays
each.
"""

from __future__ import annotations

import hashlib
import re
import shlex
import shutil
import sys
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording.bag_reader import Bag

FOLDER = 'failed_bags'
LONGEST = 120  # [-] letters of a folder's name


def folder_name(test: str) -> str:
    """
    Make the name of a folder of that of a test, whatever its parameters hold.

    Where letters had to be replaced a digest keeps it apart from others.
    """
    name = re.sub(r'[^\w.=+\-\[\]]+', '_', test, flags=re.ASCII).lstrip('.')
    if name == test and len(name) <= LONGEST:
        return name
    return f'{name[:LONGEST]}-{hashlib.sha256(test.encode()).hexdigest()[:8]}'


def keep(bag: Path, root: Path, test: str, number: int) -> Path:
    """
    Move the bag of a test to where it stays, in place of the one of an earlier failure.

    number : which simulation of the test it is, 1 for the first
    returns : its new path; the old one where the folder of the tests cannot be written to
    """
    name = folder_name(test) + (f'_{number}' if number > 1 else '')
    target = root / FOLDER / name
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists():
            shutil.rmtree(target)
        shutil.move(bag, target)
    except OSError:
        return bag
    return target


def replay_line(bag: Path) -> str:
    """Say how a bag is replayed; of one that was cut off, how it is recovered first."""
    verb = [sys.executable, '-m', 'rigid_body_sim']
    replay = [*verb, 'replay', str(bag)]
    try:
        is_whole = Bag(bag).complete
    except (UserError, RunError, OSError):
        is_whole = False
    if is_whole:
        return shlex.join(replay)
    recovered = f'{bag}_recovered'
    recover = [*verb, 'bag', 'recover', str(bag), '-o', recovered]
    return f'{shlex.join(recover)} && {shlex.join([*verb, "replay", recovered])}'
