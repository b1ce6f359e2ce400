# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Stands guard where recordings are interpreted: what they do not bear is one line, not a traceback.
"""

from __future__ import annotations

import argparse
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path

import numpy as np

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.recording.bag_files import DamagedBag

# what Python raises where values are not what the code takes for granted
MISFITS = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, struct.error)
Verb = Callable[[argparse.Namespace], int]


@contextmanager
def interpreting(path: Path) -> Iterator[None]:
    """
    Turn what a recording does not bear, deep inside, into one line that names the bag.

    Values are checked one by one where they are read; together, or with the messages, they may
    still not fit, in ways that only show where they are used.
    """
    try:
        with np.errstate(all='ignore'):  # infinite and missing numbers are shown as what they are
            yield
    except (InvalidModel, SimulationDiverged, UserError, RunError):
        raise
    except MISFITS as error:
        problem = ' '.join(str(error).split())[:200] or type(error).__name__
        raise DamagedBag(
            f'{path}: damaged: what it holds does not fit together ({problem}); ask what is wrong '
            f'with: bag check {path}'
        ) from error


def reads_recording(argument: str) -> Callable[[Verb], Verb]:
    """Let a verb read the recording that its argument names under the guard of `interpreting`."""

    def guarded(run: Verb) -> Verb:
        @wraps(run)
        def run_guarded(arguments: argparse.Namespace) -> int:
            with interpreting(Path(getattr(arguments, argument))):
                return run(arguments)

        return run_guarded

    return guarded
