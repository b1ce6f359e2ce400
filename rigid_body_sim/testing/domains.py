# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A DDS domain that no other test run on this machine uses.

Each worker of pytest takes one, and holds a lock on a file of that number for as long as it lives:
domains computed from process numbers alone meet as soon as two runs go on at once.
"""

from __future__ import annotations

import fcntl
import os
import tempfile
from pathlib import Path

from rigid_body_sim.testing.failures import NodeFailure

DOMAINS = 100  # from 1 on: 0 is everybody's, and the ports of those above 101 are not safe


class DomainLease:
    """
    One domain, until `end`.

    number : 1 to 100
    """

    def __init__(self) -> None:
        for step in range(DOMAINS):
            number = 1 + (os.getpid() + step) % DOMAINS
            lock = _locked(Path(tempfile.gettempdir()) / f'rigid_body_sim_domain_{number}.lock')
            if lock is not None:
                self.number, self._lock = number, lock
                return
        raise NodeFailure(
            f'all {DOMAINS} domains are in use: each lock {tempfile.gettempdir()}/'
            'rigid_body_sim_domain_*.lock is held by a test run; end some of them'
        )

    def end(self) -> None:
        """Give it back."""
        os.close(self._lock)


def _locked(path: Path) -> int | None:
    """
    Return a file descriptor that holds the lock of a file; None if another holds it.

    The file stays, of whichever user: reading it is enough for a lock.
    """
    try:
        lock = _opened(path)
    except OSError:  # another user's, who lets nobody read it
        return None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        return None
    return lock


def _opened(path: Path) -> int:
    alone = os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW
    try:
        return os.open(path, alone)
    except FileNotFoundError:
        return os.open(path, alone | os.O_CREAT, 0o644)
