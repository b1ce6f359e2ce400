# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a report was made on: machine, processor, software, load."""

from __future__ import annotations

import os
import platform
import sys
from datetime import datetime, timezone
from importlib import metadata
from pathlib import Path
from typing import Any

from rigid_body_sim import __version__
from rigid_body_sim.physics.compile import kernels


def processor() -> str:
    """Name the processor as its maker does, if the system knows."""
    try:
        for line in Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines():
            if line.startswith('model name'):
                return line.partition(':')[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def made(*, repetitions: int, quick: bool, seed: int) -> dict[str, Any]:
    """Describe where, when and with what a report is made."""
    versions = {'rigid_body_sim': __version__, **kernels.versions(), 'scipy': version('scipy')}
    return {
        'date': datetime.now(timezone.utc).isoformat(timespec='seconds'),
        'machine': f'{platform.system()} {platform.machine()}',
        'cpu': processor(),
        'cores': os.cpu_count(),
        'load': _load(),
        'threads': 1,
        'clock': 'processor time',
        'versions': versions,
        'compiled': kernels.COMPILED,
        'python': sys.version.split()[0],
        'seed': seed,
        'repetitions': repetitions,
        'quick': quick,
        'interrupted': False,
    }


def version(package: str) -> str:
    """Give the version of an installed package, or 'absent'."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return 'absent'


def _load() -> float | None:
    """Processes that wanted to run in the minute before: 0 on a quiet machine."""
    try:
        return round(os.getloadavg()[0], 2)
    except OSError:
        return None
