# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Looks whether what a bag says of its run fits together, so that it can be run again: everything
but the run itself, which is what `replay` does.
"""

from __future__ import annotations

import os
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.recovery import STATE_TYPES
from rigid_body_sim.recording.topics import CLOCK_TOPIC
from rigid_body_sim.runs.reading_guard import interpreting
from rigid_body_sim.runs.recorded_facts import manifest_differences
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.run import Run


def check_run(path: str | os.PathLike[str]) -> list[str]:
    """Return the findings; none for bags that hold no run of this package."""
    bag = Bag(path)
    if not bag.holds_run:
        return []
    try:
        recorded = RecordedRun(Path(path), bag)
        recorded.commands()
        with interpreting(recorded.bag.path):
            run = recorded.stand_at_start()
            again = RunRecorder(run, None).manifest
    except (UserError, RunError, InvalidModel) as error:
        return [f'cannot be run again: {error}']
    found = [
        f'{name}: {said!r:.100}, of the run it is {is_!r:.100}'
        for name, said, is_ in manifest_differences(recorded.bag.manifest, again)
    ]
    found += _uneven(recorded, run)
    ending = recorded.bag.ending or {}
    derived = {
        'ticks': recorded.last_tick - recorded.first_tick,
        'last_time_ns': recorded.last_tick * recorded.dt_ns,
    }
    for key, value in derived.items():
        if key in ending and ending[key] != str(value):
            found.append(f'ending, {key}: {ending[key]!r:.100}, by its ticks it is {value}')
    return found


def _uneven(recorded: RecordedRun, run: Run) -> list[str]:
    """Name the topics that lack states, or have too many: each published tick has one of each."""
    counts = recorded.bag.counts
    states = counts.get(CLOCK_TOPIC, 0)
    wanted = [topic for topic in run.packer.topics if topic.type in STATE_TYPES]
    return [
        f'{topic.name}: {counts.get(topic.name, 0)} messages, {CLOCK_TOPIC} has {states}'
        for topic in wanted
        if counts.get(topic.name, 0) != states
    ]
