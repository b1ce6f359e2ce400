# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Replay of scenes in which time itself acts: forces over time, burn-out, bodies that are moved as
told, the loads of what stands as the scene begins; also after a reset.
"""

import pytest

from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.scene import load_scene

SCENE = """
version: 1
dt: 0.002
gravity: [0, 0, -9.81]
bodies:
  - name: rocket
    shape: {type: cylinder, radius: 0.1, length: 1}
    mass: 5
    mass_rate: -4
    exhaust_velocity: 40
    final_mass: 3.1234
    initial: {angular_velocity: [0.1, 0.2, 0.3]}
  - {name: moon, shape: {type: particle}, mass: 2, initial: {position: [3, 0, 0]}}
forces:
  - type: time
    body: rocket
    frame: body
    table: [[0.0511, 0, 0, 0, 0.01, 0, 0], [0.2345, 1, 0, 0, 0, 0.01, 0]]
  - {type: gravity, constant: 0.1}
"""
MOVED = """
version: 1
dt: 0.002
gravity: [0, 0, -9.81]
CONTACT
bodies:
  - name: deck
    shape: {type: box, size: [1, 1, 0.2]}
    motion: {heave: {amplitude: 0.1, period: 1.3}}
  - name: load
    shape: {type: box, size: [0.2, 0.2, 0.2]}
    mass: 1
    initial: {position: [0, 0, 0.2]}
"""
DECK = MOVED.replace('CONTACT', 'contact: {mode: timestep}')
STANDS = DECK.replace('motion: {heave: {amplitude: 0.1, period: 1.3}}', 'fixed: true')
COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.3,rocket,wrench,body,1,0,0,0,0.01,0
0.4,rocket,impulse,world,1,0,0,0,0,0.01
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text(SCENE)
    return path


@pytest.mark.parametrize('integrator', ['dmv6', pytest.param('rk4', marks=pytest.mark.long)])
def test_a_run_across_jumps_and_burn_out_replays_bit_for_bit(
    scene, tmp_path, verb, as_json, integrator
):
    (tmp_path / 'commands.csv').write_text(COMMANDS)
    words = (
        '--duration',
        0.8,
        '--integrator',
        integrator,
        '--commands',
        tmp_path / 'commands.csv',
    )
    assert verb('simulate', scene, '-o', tmp_path / 'run', *words)[0] == 0
    code, result = as_json('replay', tmp_path / 'run')
    assert code == 0 and result['identical']
    code, result = as_json('replay', tmp_path / 'run', '--dt', '0.001')
    assert code == 0
    # dmv6 has order two: the jumps and the burn-out within ticks cost nothing beside
    assert result['errors']['rocket']['largest']['position'] < 1e-3


@pytest.mark.parametrize('ticks', [pytest.param(0, marks=pytest.mark.long), 17])
@pytest.mark.parametrize(
    'text', [SCENE, MOVED.replace('CONTACT', ''), DECK, STANDS],
    ids=['timed', 'moved', 'deck', 'stands'],
)  # fmt: skip
def test_a_recording_begun_after_a_reset_replays_bit_for_bit(text, ticks, tmp_path, as_json):
    run = Run(Simulation(load_scene(text.encode())), RunSettings(publish_every=5))
    for _ in range(33):
        run.advance(1)
    run.reset()
    for _ in range(ticks):
        run.advance(1)
    recorder = RunRecorder(run, tmp_path / 'run')
    while run.simulation.tick < 350:  # past the burn-out, which is 0.46915 s after the reset
        tick = run.simulation.tick
        recorder.record(run.advance(350 - tick), tick=tick)
    recorder.close('duration')
    code, result = as_json('replay', tmp_path / 'run')
    assert code == 0 and result['identical']
