# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A DDS domain that no other test run on this machine uses.

Each worker of pytest takes one, and holds a lock on a file of that number for as long as it lives:
domains computed from process numbers alone meet as soon as two runs go on at once. Who knows of no
lock is found by the port that the first participant of a domain listens on.

Source of the port: OMG DDSI-RTPS 2.5, section 9.6.2.4: PB + DG d + d1 + PG p, with p = 0.
"""

from __future__ import annotations

import fcntl
import os
import socket
import tempfile
from pathlib import Path

from rigid_body_sim.testing.failures import NodeFailure

PB, DG, D1 = 7400, 250, 10  # [-] port base, domain gain, offset of discovery of one's own
DOMAINS = 100  # from 1 on: 0 is everybody's, and the ports of those above 101 are not safe


class DomainLease:
    """
    One domain, until `end`.

    number : 1 to 100
    """

    def __init__(self) -> None:
        for step in range(DOMAINS):
            number = 1 + (os.getpid() + step) % DOMAINS
            if _is_inhabited(number):
                continue
            lock = _locked(Path(tempfile.gettempdir()) / f'rigid_body_sim_domain_{number}.lock')
            if lock is not None:
                self.number, self._lock = number, lock
                return
        raise NodeFailure(
            f'all {DOMAINS} domains are in use, by nodes or by test runs, which hold the locks '
            f'{tempfile.gettempdir()}/rigid_body_sim_domain_*.lock; end some of them'
        )

    def end(self) -> None:
        """Give it back."""
        os.close(self._lock)


def _is_inhabited(number: int) -> bool:
    """Whether somebody on this machine is in a domain."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(('', PB + DG * number + D1))
        except OSError:
            return True
    return False


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
