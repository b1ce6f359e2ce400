# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A run in memory to a bag: it is made again from its start with its commands at their ticks, and
recorded; it must end in the same bits.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.library.run_arrays import RunArrays
from rigid_body_sim.physics.model.named_frames import SEPARATOR
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording.new_output import check_new
from rigid_body_sim.runs import run as runs
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.scene.writing import with_text


def write_bag(run: RunArrays, path: str | os.PathLike[str]) -> None:
    """Record a run; see `Run.save`."""
    folder, origin = Path(path), run._origin
    if origin is None or run._ticks is None:
        raise UserError(f'{folder}: this run came from {run.path}, which is its bag: copy that')
    check_new(folder)
    first, last, per = run._ticks
    simulation = Simulation.__new__(Simulation)
    simulation.__setstate__({**origin.start, 'scene': with_text(origin.start['scene'])})
    if simulation.watch is not None:  # what `auto` did is done again, not chosen again
        simulation.follow_choices(origin.choices)
    settings = runs.RunSettings(command_timeout_ns=0, publish_every=per, publish_phase=first % per)
    again = runs.Run(simulation, settings)
    commands: dict[int, list[Command]] = {}
    for tick, body, force, torque, frame in origin.commands:
        x = Command(
            body,
            'wrench',
            (force[0], force[1], force[2]),
            (torque[0], torque[1], torque[2]),
            frame_id=_frame_id(body, frame),
            stamp_ns=tick * simulation.dt_ns,
        )
        commands.setdefault(tick, []).append(x)
    recorder, reason = RunRecorder(again, folder), 'error'
    try:
        for tick, output in again.follow(commands, last):
            recorder.record(output, tick=tick)
        reason = run.end_reason
    finally:
        recorder.close(reason)
    if simulation.state_bytes() != origin.final:
        shutil.rmtree(folder)
        raise RunError(
            f'{folder}: not written: made again, the run ends in another state; something else '
            'than its controller changed the simulation on the way (set_wrench, apply_impulse or '
            'set_state from inside the controller); answer wrenches in place of that'
        )


def _frame_id(body: str, frame: str) -> str:
    """Name a frame as a message does."""
    if frame in ('world', 'body'):
        return {'world': '', 'body': body}[frame]
    return f'{body}{SEPARATOR}{frame.removeprefix(body + SEPARATOR)}'
