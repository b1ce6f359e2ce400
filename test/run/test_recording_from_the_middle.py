# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A recording that begins while commands act holds what a replay needs, to the bit."""

import pytest

from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.replay import compare
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.scene import load_scene

SCENE = {
    'dt': 0.001,
    'bodies': [
        {
            'name': 'b',
            'shape': {'type': 'box', 'size': [0.1, 0.2, 0.3]},
            'mass': 1.0,
            'initial': {'position': [0, 0, 0], 'angular_velocity': [0, 1.0, 2.0]},
        }
    ],
}
WORLD = Command('b', 'force', (1.0, 0.0, 0.0))
BODY = Command('b', 'force', (1.0, 0.0, 0.0), frame_id='b')


@pytest.mark.parametrize('held', [WORLD, BODY], ids=['world axes', 'body axes'])
@pytest.mark.parametrize(
    'then',
    [
        [],
        [WORLD],
        [BODY],
        [Command('b', 'force')],
        [Command('b', 'impulse', (1.0, 0.0, 0.0))],
        [Command('b', 'torque', torque=(0.0, 0.0, 1.0))],
    ],
    ids=['nothing', 'world axes', 'body axes', 'zero', 'impulse', 'torque'],
)
@pytest.mark.parametrize('timeout_ns', [0, 50_000_000], ids=['for ever', '50 ms'])
def test_a_recording_begun_under_a_held_command_replays_identically(
    tmp_path, held, then, timeout_ns
):
    simulation = Simulation(load_scene(SCENE))
    run = Run(simulation, RunSettings(command_timeout_ns=timeout_ns))
    run.advance(1, [held])
    while simulation.tick < 33:
        run.advance(1)
    recorder = RunRecorder(run, tmp_path / 'bag')
    commands = then
    while (
        simulation.tick < 105
    ):  # tick by tick, as the node does; the replay does as many as it can at once
        tick = simulation.tick
        recorder.record(run.advance(1, commands), tick=tick)
        commands = [held] if simulation.tick == 67 else []
    recorder.close('stopped')
    outcome = compare(RecordedRun(tmp_path / 'bag'), output=None, progress=lambda tick, last: None)
    assert outcome.difference is None
    assert outcome.messages > 0
