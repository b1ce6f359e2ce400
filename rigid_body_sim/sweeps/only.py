# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""One run of a sweep again, into a bag: the scene with its values, as `simulate` records it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import RunError
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.runs.recorder import recording
from rigid_body_sim.runs.run import Run, RunSettings, publish_every
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene
from rigid_body_sim.stop_signals import STOP
from rigid_body_sim.sweeps.looks import LAST
from rigid_body_sim.sweeps.plan import Sweep

RATE = 100.0  # [Hz] of recorded states, as of `simulate`


def record_one(sweep: Sweep, run: int, path: Path, *, expected: dict[str, Any]) -> None:
    """
    Record one run of a sweep.

    expected : its row; the bag ends with its last states

    Raises RunError if the bag came to other states than the row, Stopped by a signal.
    """
    scene = load_scene(sweep.text(run), files=sweep.files, title=sweep.name)
    simulation = simulation_of(scene)
    simulation.prepare()
    settings = RunSettings(
        command_timeout_ns=0, publish_every=publish_every(RATE, simulation.dt_ns)
    )
    whole = Run(simulation, settings)
    last = round(sweep.duration * 1e9 / simulation.dt_ns)
    try:
        with recording(whole, path, done='duration') as recorder:
            for tick, output in whole.follow({}, last):
                recorder.record(output, tick=tick)
                STOP.check(lambda: f'at {simulation.time:.9g} s; the bag is whole up to there')
    except SimulationDiverged:
        if expected['ticks'] != simulation.tick:
            raise
    for i, body in enumerate(scene.bodies):
        row = simulation.state.values[i].tolist()
        for name, place in LAST:
            told = expected.get(f'{body.name}.{name}')
            if told is not None and not _same(told, row[place]):
                raise RunError(
                    f'run {run}: {body.name}.{name} is {row[place]!r} in the bag and {told!r} in '
                    'its row (please report this scene)'
                )


def _same(one: float, other: float) -> bool:
    return one.hex() == other.hex() or (math.isnan(one) and math.isnan(other))
