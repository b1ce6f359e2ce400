# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`integrator: auto` meets its tolerance at the least cost, says why, always chooses the same, and
goes on looking.
"""

from dataclasses import replace

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import RunError
from rigid_body_sim.exact import oscillator
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.choose import difference
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs import choices
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.longer_ticks import longer_dt
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.replay import compare
from rigid_body_sim.runs.run import Run, RunSettings

from . import scenes


def spring(tolerance, dt=0.02):
    return load_scene(
        {
            'version': 1,
            'name': 'spring',
            'dt': dt,
            'integrator': {'name': 'auto', 'tolerance': tolerance},
            'bodies': [
                {
                    'name': 'box',
                    'mass': 1.0,
                    'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 3.0},
                    'initial': {'position': [1, 0, 0]},
                }
            ],
            'forces': [{'type': 'spring', 'a': 'box', 'b': 'world', 'stiffness': 4.0}],
        }
    )


@pytest.mark.parametrize(
    'tolerance', [*(pytest.param(rough, marks=pytest.mark.long) for rough in (1e-3, 1e-6)), 1e-9]
)
def test_error_per_second_is_within_the_tolerance(tolerance):
    sim = Simulation(spring(tolerance))
    while sim.time < 5.0:
        sim.step(25)
        exact = oscillator.oscillation(sim.time, mass=1.0, stiffness=4.0, position=1.0)
        error = abs(sim.state.position[0, 0] - float(exact.position[0]))
        assert error <= tolerance * max(sim.time, 1.0)
    assert sim.integrator.name in sim.choice.reason


def test_a_tighter_tolerance_does_not_get_a_cheaper_method():
    loose, tight = (Simulation(spring(t)).choice for t in (1e-3, 1e-9))
    assert (loose.name, loose.substeps) != (tight.name, tight.substeps)
    assert tight.error < loose.error


def test_free_bodies_get_the_default_in_one_step():
    sim = Simulation(scenes.top(dt=0.001), integrator='auto')
    assert (sim.integrator.name, sim.integrator.substeps) == ('dmv6', 1)


def test_the_choice_is_the_same_every_time():
    assert Simulation(spring(1e-6)).choice == Simulation(spring(1e-6)).choice


def test_a_method_that_refuses_the_scene_is_not_chosen():
    sim = Simulation(scenes.oscillator(dt=0.02, damping=0.5), integrator='auto')
    assert INTEGRATORS[sim.integrator.name].refuses(sim.scene) is None


def test_an_option_that_auto_does_not_have_is_refused():
    with pytest.raises(InvalidModel, match='tolerance'):
        Simulation(spring(1e-3), integrator='auto', integrator_options={'rtol': 1e-3})


@pytest.mark.parametrize('name', ['dmv6', 'rk4'])
def test_substeps_divide_the_tick(name):
    """Two substeps of 2 ms are two ticks of 1 ms, bit for bit."""
    coarse = Simulation(
        scenes.oscillator(dt=0.002), integrator=name, integrator_options={'substeps': 2}
    )
    fine = Simulation(scenes.oscillator(dt=0.001), integrator=name)
    coarse.step(50)
    fine.step(100)
    assert coarse.state_bytes() == fine.state_bytes()


def test_each_integrator_bears_the_name_of_its_file():
    """The registry lists files and imports a method when it is asked for."""
    for name, integrator in INTEGRATORS.items():
        assert integrator.name == name
        assert integrator.source


def test_choice_says_what_it_tries_and_what_the_pilot_cannot_know():
    said = []
    sim = Simulation(spring(1e-4), progress=said.append)
    assert said[0] == 'auto: reference run with rk4'
    assert 'auto: trying dmv6' in said
    assert 'knows nothing of commands; after it a second in every twenty' in sim.choice.reason


def test_linear_points_are_judged_by_the_exact_motion_however_stiff():
    said = []
    sim = Simulation(
        scenes.oscillator(dt=0.02, stiffness=1e8), integrator='auto', progress=said.append
    )
    assert sim.integrator.name == 'linear_propagator'
    assert said and not any('reference' in text for text in said)


def hinge(tolerance):
    """Two bars, joined to the world and each other by stiff damped springs off their centres."""
    bars = [
        {
            'name': f'bar{i}',
            'mass': 1.0,
            'inertia': {'ixx': 0.1, 'iyy': 0.1, 'izz': 0.1},
            'initial': {'position': [0.5 + i, 0, 0]},
        }
        for i in range(2)
    ]
    springs = [
        {
            'type': 'spring', 'a': f'bar{i}', 'a_point': [-0.5, 0, 0],
            'b': f'bar{i - 1}' if i else 'world', 'b_point': [0.5, 0, 0] if i else [0, 0, 0],
            'stiffness': 1e8, 'damping': 1e4,
        }
        for i in range(2)
    ]  # fmt: skip
    found = scenes.scene(bars, forces=springs, dt=0.01, gravity=(0.0, 0.0, -9.81))
    return replace(found, integrator='auto', integrator_options={'tolerance': tolerance})


def test_a_stiff_scene_gets_a_method_within_its_limits_that_settles():
    """Too stiff for explicit steps: 1e8 N/m turn at 2.6e4 rad/s."""
    sim = Simulation(hinge(1e-2))
    true = Simulation(
        sim.scene, integrator='rk45', integrator_options={'rtol': 1e-7, 'atol': 1e-7}
    )
    assert not sim.warnings()  # a method beyond its limits may look well in the pilot
    for _ in range(5):
        sim.step(20)
        true.step(20)
        assert difference(sim.state, true.state) <= 1e-2


TWIST = {'force': (0.0, 0.0, 0.0), 'torque': (40.0, 0.0, 150.0)}


def twisted(sim, ticks):
    """Step a box on a spring, twisted from tick 300 to 360, in strides."""
    while sim.tick < 1000:
        if sim.tick == 300:
            sim.hold('box', 'wrench', frame='body', until=360, **TWIST)
        end = 300 if sim.tick < 300 else 1000
        sim.step(min(ticks, end - sim.tick))
    return sim


def test_a_run_that_gets_faster_goes_on_finer_whatever_the_strides():
    sim = twisted(Simulation(spring(1e-4)), 1000)
    watch = sim.watch
    assert watch.missed
    assert watch.worst.error > 1e-4
    assert len(sim.choices) > 1
    first, second = sim.choices[:2]
    assert 300 < second.tick < 1000
    assert (second.name, second.options) != (first.name, first.options)
    assert f'from tick {second.tick} on' in second.reason
    other = twisted(Simulation(spring(1e-4)), 7)
    assert other.choices == sim.choices
    assert other.state_bytes() == sim.state_bytes()


def test_after_a_reset_all_comes_again_as_before():
    sim = twisted(Simulation(spring(1e-4)), 1000)
    sim.reset()
    assert (sim.integrator.name, sim.choice.options) == (
        sim.choices[0].name,
        sim.choices[0].options,
    )
    sim.step(700)
    fresh = Simulation(spring(1e-4))
    fresh.step(700)
    assert sim.state_bytes() == fresh.state_bytes()


def test_a_quiet_run_is_looked_at_and_keeps_its_method():
    sim = Simulation(spring(1e-4))
    sim.step(400)
    assert (sim.watch.looks, sim.watch.missed, len(sim.choices)) == (1, 0, 1)
    assert 0.0 < sim.watch.worst.error <= 1e-4


def test_a_body_put_elsewhere_is_looked_at_and_is_no_error():
    """The jump is given to the look under way too; what moves faster from there is seen."""
    sim = Simulation(spring(1e-4))
    sim.step(60)
    sim.set_state('box', velocity=(0, 0, 0.1))  # calls for a look
    sim.step(10)
    sim.set_state('box', position=sim.state.position[0] + (0.0, 0.0, 0.01))
    sim.step(400)
    assert sim.watch.looks >= 1 and sim.watch.missed == 0
    sim.set_state('box', position=sim.state.position[0] + (0.0, 0.0, 50.0))
    sim.step(2000)
    assert sim.watch.missed and len(sim.choices) > 1


def test_a_named_integrator_is_not_watched():
    sim = Simulation(spring(1e-4), integrator='dmv6')
    assert (sim.watch, sim.choice, sim.choices) == (None, None, ())


@pytest.mark.parametrize('begin', [0, 500])
def test_changes_are_recorded_and_replayed_to_the_bit(tmp_path, begin):
    """Also from a bag that begins in the middle, behind a change."""
    run = Run(Simulation(spring(1e-4)), RunSettings(command_timeout_ns=1_200_000_000))
    twist = Command('box', 'wrench', TWIST['force'], TWIST['torque'], frame_id='box')
    for _ in run.follow({300: [twist]}, begin):
        pass
    recorder = RunRecorder(run, tmp_path / 'bag')
    for tick, output in run.follow({300: [twist]}, 1000):
        recorder.record(output, tick=tick)
    recorder.close('duration')
    recorded = RecordedRun(tmp_path / 'bag')
    made = choices.decoded(Bag(tmp_path / 'bag').messages(['/integrator']), run.simulation.scene)
    assert [(c.tick, c.name, c.options, c.error) for c in made] == [
        (c.tick, c.name, dict(c.options), c.error)
        for c in run.simulation.choices[1:]
        if c.tick >= begin
    ]
    assert made or begin
    outcome = compare(recorded, output=tmp_path / 'again', progress=lambda *_: None)
    assert outcome.difference is None
    assert Bag(tmp_path / 'again').counts == Bag(tmp_path / 'bag').counts


def test_a_change_that_no_run_could_have_made_is_refused():
    scene = spring(1e-4)
    change = choices.Choice('rk4', 2, 0.0, '', {'substeps': 2}, 1e-4, 7)
    for name, options in (('rk99', {}), ('rk4', {'substeps': 0}), ('linear_propagator', {})):
        message = choices.encode(replace(change, name=name, options=options), scene.dt_ns)
        recorded = type('Recorded', (), {'topic': '/integrator', 'sequence': 7, 'data': message})
        with pytest.raises(RunError, match='/integrator, tick 7'):
            choices.decode(recorded, scene)


@pytest.mark.parametrize(
    ('rate', 'duration', 'times', 'timeout', 'ticks'),
    [
        (10.0, 2.0, [], 0.0, 5),  # publishing every 5 ticks of 20 ms
        (10.0, 2.0, [0.2], 0.4, 5),
        (10.0, 2.0, [0.24], 0.0, None),  # a command at tick 12
        (5.0, 2.0, [0.4], 0.08, 2),  # which ends 4 ticks later
        (50.0, 2.0, [], 0.0, None),
        (1.0, 10.0, [], 0.0, 5),  # LONGEST
    ],
)
def test_longer_ticks_meet_all_that_listens(tmp_path, rate, duration, times, timeout, ticks):
    scene = spring(1e-4)
    scene = replace(scene, integrator_options={**scene.integrator_options, 'longer_steps': True})
    commands = None
    if times:
        commands = tmp_path / 'commands.csv'
        rows = [f'{time},box,force,1' for time in times]
        commands.write_text('\n'.join(['time,body,kind,fx', *rows]))
    found = longer_dt(
        scene, None, duration=duration, rate_hz=rate, timeout=timeout, commands=commands
    )
    assert found is ticks if ticks is None else np.isclose(found, 0.02 * ticks)


def test_longer_ticks_are_for_those_who_ask():
    asked = {'duration': 2.0, 'rate_hz': 10.0, 'timeout': 0.0, 'commands': None}
    assert longer_dt(spring(1e-4), None, **asked) is None
    assert longer_dt(spring(1e-4), 'rk4', **asked) is None
