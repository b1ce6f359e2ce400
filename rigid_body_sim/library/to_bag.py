# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A run in memory to a bag: it is made again, and recorded; it must end in the same bits.
"""

from __future__ import annotations

import os
import shutil

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.library.made_again import MadeAgain
from rigid_body_sim.library.run_arrays import RunArrays
from rigid_body_sim.recording.bag_directory import check_new
from rigid_body_sim.recording.paths import path_of
from rigid_body_sim.runs.recorder import RunRecorder


def write_bag(run: RunArrays, path: str | os.PathLike[str]) -> None:
    """Record a run; see `Run.save`."""
    folder = path_of(path, said='save')
    if run._origin is None:
        raise UserError(f'{folder}: this run came from {run.path}, which is its bag: copy that')
    check_new(folder)
    again = MadeAgain(run)
    recorder, reason = RunRecorder(again.run, folder), 'error'
    try:
        for tick, output in again.follow():
            recorder.record(output, tick=tick)
        reason = run.end_reason
    finally:
        recorder.close(reason)
    try:
        again.check(f'{folder}: not written')
    except RunError:
        shutil.rmtree(folder)
        raise
