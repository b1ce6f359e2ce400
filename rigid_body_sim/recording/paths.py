# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a user wants something written or read: text or a Path, and nothing else."""

import reprlib
from pathlib import Path

from rigid_body_sim.errors import UserError


def path_of(given: object, *, said: str) -> Path:
    """
    Return a path; UserError for what is none.

    said : who asks
    """
    try:
        path = Path(given)  # type: ignore[arg-type]  # which is what it tells
        if '\0' not in str(path) and given != '':
            return path
    except TypeError:
        pass
    shown = ' '.join(reprlib.repr(given).split())
    raise UserError(f"{said}: got {shown}; a path is needed, as text or a pathlib.Path: 'run_1'")
