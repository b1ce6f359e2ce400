# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body is put elsewhere: from the tick that was said on, to the bit, without a defect."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.asked_states import AskedState
from rigid_body_sim.runs.commands import Command, CommandRules, decode
from rigid_body_sim.runs.recorded_facts import manifest_differences
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import RunRecorder, recording
from rigid_body_sim.runs.replay import compare
from rigid_body_sim.runs.run import Run, RunSettings

from .conftest import SCENES

FREE = {
    'name': 'free',
    'dt': 0.001,
    'gravity': [0, 0, -9.81],
    'bodies': [
        {
            'name': 'box',
            'mass': 2.0,
            'inertia': {'ixx': 0.3, 'iyy': 0.2, 'izz': 0.15, 'ixy': 0.01},
            'initial': {'angular_velocity': [1, 2, 3]},
        },
        {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 0.5},
    ],
}
TURN = so3.unit_quaternion((0.1, -0.2, 0.3, 0.9))
MOVED = AskedState((1.0, 2.0, 3.0), TURN, (4.0, -5.0, 6.0), (0.3, -0.2, 0.1))
PIVOT = {
    'name': 'top',
    'mass': 1.0,
    'inertia': {'ixx': 0.02, 'iyy': 0.02, 'izz': 0.01},
    'pivot': {'point': [0, 0, -0.2], 'at': [0, 0, 1]},
}


def free():
    return Simulation(load_scene(FREE))


def asked(body, state, **more):
    return Command(body, 'set_state', state=state, **more)


def recorded(path, run, ticks, commands):
    recorder = RunRecorder(run, path)
    for tick, output in run.follow(commands, ticks):
        recorder.record(output, tick=tick)
    recorder.close('stopped')
    return path


def replayed(path):
    return compare(RecordedRun(path), output=None, progress=lambda tick, last: None)


def test_what_is_asked_is_what_is_read_and_the_rest_stays():
    sim = free()
    sim.step(100)
    before = sim.state
    sim.set_state('box', position=(1, 2, 3))
    now = sim.state
    assert tuple(now.position[0]) == (1, 2, 3)
    assert np.array_equal(now.values[0, 3:], before.values[0, 3:])
    assert np.array_equal(now.values[1], before.values[1])
    sim.set_state('box', orientation=(0, 0, 2, 2))
    now = sim.state
    # principal axes are not those of the body: two rotations, a few roundings
    assert now.orientation[0] == pytest.approx((0, 0, math.sqrt(0.5), math.sqrt(0.5)), abs=1e-15)
    assert now.angular_velocity[0] == pytest.approx(before.angular_velocity[0], abs=1e-14)
    sim.set_state('box', velocity=(1, 0, 0), angular_velocity=(0, 0, 2), frame='body')
    now = sim.state
    assert now.velocity[0] == pytest.approx((0, 1, 0), abs=1e-15)
    assert now.angular_velocity_body[0] == pytest.approx((0, 0, 2), abs=1e-14)
    sim.set_state('ball', velocity=(7, 8, 9))
    assert tuple(sim.state.velocity[1]) == (7, 8, 9)
    assert sim.tick == 100


def test_it_goes_on_as_a_body_that_began_there():
    sim, other = free(), dict(FREE)
    sim.step(50)
    sim.set_state('box', position=(1, 2, 3), orientation=TURN, velocity=(4, -5, 6),
                  angular_velocity=(0.3, -0.2, 0.1))  # fmt: skip
    sim.step(200)
    start = {'position': [1, 2, 3], 'orientation': list(TURN), 'velocity': [4, -5, 6],
             'angular_velocity': [0.3, -0.2, 0.1]}  # fmt: skip
    other['bodies'] = [FREE['bodies'][0] | {'initial': start}, FREE['bodies'][1]]
    there = Simulation(load_scene(other))
    there.step(200)
    assert np.array_equal(sim.state.values[0], there.state.values[0])


@pytest.mark.parametrize('integrator', ['rk4', 'dmv6'])
def test_a_matrix_that_an_integrator_remembers_is_that_of_the_new_orientation(integrator):
    options = {'orientation': 'matrix'} if integrator == 'rk4' else None
    both = [
        Simulation(load_scene(FREE), integrator=integrator, integrator_options=options)
        for _ in 'ab'
    ]
    for sim in both:
        sim.step(20)
    kept = both[0].orientation_matrices()[0]
    both[0].set_state('box', orientation=TURN, angular_velocity=(0, 0, 1))
    assert both[0].orientation_matrices()[0] == pytest.approx(
        so3.matrix_from_quaternion(TURN), abs=1e-15
    )
    assert not np.allclose(both[0].orientation_matrices()[0], kept)
    both[1].set_state('ball', position=(0, 0, 1))  # which the box does not feel
    assert np.array_equal(both[1].orientation_matrices()[0], kept)


def test_the_energy_it_brings_is_work_of_commands_and_nothing_is_left_over():
    scene = load_scene(SCENES / 'two_bodies.yaml')
    sim = Simulation(scene, dt=1e-4)
    sim.keep_energy_balance()
    sim.step(50)
    before = sim.energy()
    sim.set_state('ball', position=(1.2, 0.1, 0.5), velocity=(0, 1, 0))
    brought = sim.energy() - before
    assert sim.energy_balance().work_of_commands == pytest.approx(brought, rel=1e-12)
    sim.step(200)
    balance = sim.energy_balance()
    assert balance.work_of_commands == pytest.approx(brought, rel=1e-12)
    assert abs(balance.defect) < 1e-5 * balance.turnover  # dmv6 at this step: h^2
    assert balance.gain is None and not balance.gains


def test_a_passive_run_whose_state_is_set_reports_no_drift_and_no_gain(tmp_path):
    run = Run(free(), RunSettings(publish_every=10))
    commands = {
        100: [asked('box', MOVED)],
        205: [asked('ball', AskedState(position=(0, 0, 50), linear=(1, 2, 3)))],
    }
    path = recorded(tmp_path / 'a', run, 400, commands)
    drift = run.sample_drift()
    # round-off of energies of some hundred joules
    assert drift.energy < 1e-12 and drift.momentum < 1e-12
    kept = run.kept()
    assert kept and all(law.drift < 1e-12 for law in kept)
    assert abs(run.energy_balance().defect) < 1e-10 * run.energy_balance().turnover
    assert run.warnings == []
    assert replayed(path).difference is None


def test_it_acts_from_the_tick_on_with_which_it_is_recorded(tmp_path):
    run = Run(free(), RunSettings(publish_every=1))
    path = recorded(tmp_path / 'a', run, 40, {17: [asked('box', MOVED, frame_id='world')]})
    bag = Bag(path)
    (message,) = bag.messages(['/box/set_state'])
    assert (message.sequence, message.log_time) == (17, 17_000_000)
    poses = {m.sequence: cdr.decode(cdr.PoseStamped.TYPE, m.data)
             for m in bag.messages(['/box/pose'])}  # fmt: skip
    h, v = 1e-3, np.array(MOVED.linear)
    fallen = -0.5 * 9.81 * (17 * h) ** 2
    assert poses[17].position == pytest.approx((0, 0, fallen), abs=1e-15)
    # kick, drift, kick: exact for a constant force
    expected = np.array(MOVED.position) + h * v + (0, 0, -0.5 * 9.81 * h * h)
    assert poses[18].position == pytest.approx(expected, abs=1e-15)
    assert replayed(path).difference is None
    # nobody else was commanded: there is no channel that nobody used
    assert [name for name in bag.topics if not bag.counts[name]] == []


def test_a_bag_of_a_version_that_knew_fewer_commands_is_no_other_run():
    said = {'command_kinds': '["force", "torque", "wrench", "impulse"]', 'dt_ns': '1'}
    again = {'command_kinds': '["force", "set_state"]', 'dt_ns': '1'}
    assert list(manifest_differences(said, again)) == []
    assert len(list(manifest_differences(said, again | {'dt_ns': '2'}))) == 1


@pytest.mark.filterwarnings('ignore:overflow')  # on the way to infinity
@pytest.mark.parametrize('kind', ['set_state', 'impulse'])
def test_a_command_that_breaks_a_run_is_in_neither_bag_nor_state(tmp_path, kind):
    wild = AskedState(angular=(0, 0, 1e149))
    commands = {
        10: [asked('box', MOVED)],
        20: [
            Command('box', kind, torque=(0, 0, 1e307)) if kind == 'impulse' else asked('box', wild)
        ],
    }
    run = Run(free(), RunSettings(publish_every=5))
    with pytest.raises(SimulationDiverged), recording(run, tmp_path / 'a', done='') as recorder:
        for tick, output in run.follow(commands, 40):
            recorder.record(output, tick=tick)
    assert run.simulation.tick == 20
    assert np.abs(run.simulation.state.angular_velocity).max() < 10
    assert replayed(tmp_path / 'a').difference is None


def test_an_estimate_of_the_error_goes_on_and_replays(tmp_path):
    run = Run(free(), RunSettings(publish_every=10, estimate_error=True))
    path = recorded(tmp_path / 'a', run, 300, {100: [asked('box', MOVED)]})
    estimate = run.error_estimate()
    truth = Simulation(load_scene(FREE), integrator='rk8')
    truth.step(100)
    truth.set_state('box', position=MOVED.position, orientation=TURN, velocity=MOVED.linear,
                    angular_velocity=MOVED.angular)  # fmt: skip
    truth.step(200)
    # the error of 0.1 s before was taken away with the state: that of 0.2 s is left
    angle = float(so3.angle_between(truth.state.orientation[0],
                                    run.simulation.state.orientation[0]))  # fmt: skip
    assert estimate.reliable and angle / 3 < estimate.angle < 3 * angle
    assert replayed(path).difference is None


def test_a_pivot_lets_a_body_turn_and_nothing_else():
    sim = Simulation(load_scene({'dt': 0.001, 'bodies': [PIVOT]}))
    sim.set_state('top', orientation=(1, 0, 0, 1), angular_velocity=(0, 0, 2))
    assert sim.state.position[0] == pytest.approx((0, -0.2, 1), abs=1e-15)
    assert sim.state.velocity[0] == pytest.approx((0.4, 0, 0), abs=1e-15)
    state = sim.state
    sim.set_state('top', position=state.position[0], velocity=state.velocity[0])  # as it is
    assert np.array_equal(sim.state.values, state.values)
    for wrong in ({'position': (0, -0.2, 1.1)}, {'velocity': (0, 0, 1)}):
        with pytest.raises(InvalidModel, match='would tear it off its pivot'):
            sim.set_state('top', **wrong)
    rules = CommandRules(sim.scene)
    there = AskedState((0, -0.2, 1), (1, 0, 0, 1), (0.4, 0, 0), (0, 0, 2))
    assert rules.refusal(asked('top', there)) is None
    assert 'it is (0, 0, 1.2) m' in rules.refusal(asked('top', AskedState()))


@pytest.mark.parametrize(
    ('wanted', 'reason'),
    [
        ({'position': (0, 0, math.nan)}, 'position .*three finite numbers'),
        ({'velocity': (0, 0)}, 'velocity .*three finite numbers'),
        ({'orientation': (0, 0, 0, 0)}, 'zero length'),
        ({'orientation': (0, 0, math.inf, 0)}, 'orientation'),
        ({'angular_velocity': 'fast'}, 'angular_velocity'),
        ({'velocity': (1e308, 0, 0)}, 'beyond the largest number'),
        ({'angular_velocity': (1e308, 0, 0)}, 'beyond the largest number'),
        ({'angular_velocity': (0, 1e151, 0)}, 'angular velocity of 1e.151 rad/s has no finite'),
        (
            {'velocity': (1e200, 0, 0)},
            r'velocity of 1e.200 m/s has no finite.*up to 5e.149',
        ),
        ({'position': (0, 0, -1e308)}, r'position of 1e.308 m has no finite energy.*\(m, kg, s\)'),
        ({'position': (0, 0, 1), 'frame': 'nozzle'}, "frame 'nozzle'; allowed: world, body"),
    ],
)
def test_no_body_is_in_such_a_state_and_nothing_has_changed(wanted, reason):
    sim = free()
    sim.step(3)
    before = sim.state_bytes()
    with pytest.raises(InvalidModel, match=reason):
        sim.set_state('box', **wanted)
    assert sim.state_bytes() == before


def test_a_point_mass_takes_position_and_velocity_alone():
    sim = free()
    sim.set_state('ball', position=(1, 1, 1), orientation=(0, 0, 0, 2), velocity=(1, 2, 3),
                  angular_velocity=(0, 0, 0), frame='body')  # fmt: skip
    assert tuple(sim.state.velocity[1]) == (1, 2, 3)
    for turned in ({'orientation': TURN}, {'angular_velocity': (0, 0, 1)}):
        with pytest.raises(InvalidModel, match='point mass and does not turn'):
            sim.set_state('ball', **turned)


@pytest.mark.parametrize(
    ('command', 'reason'),
    [
        (asked('box', AskedState(), frame_id='box'), 'a pose is told in the world'),
        (asked('box', AskedState(), frame_id='elsewhere'), "in frame 'elsewhere'"),
        (asked('box', AskedState(child_frame_id='ball')), 'which is another body'),
        (asked('ball', AskedState(child_frame_id='box')), 'which is another body'),
        (asked('box', AskedState(orientation=(0, 0, 0, 0))), 'zero length'),
        (asked('box', AskedState(linear=(math.nan, 0, 0))), 'three finite numbers'),
        (asked('ball', AskedState(orientation=TURN)), 'does not turn'),
        (asked('box', AskedState(linear=(1e308, 0, 0))), 'beyond the largest number'),
        (asked('box', AskedState((0, 1e308, 0))), 'the position of 1e+308 m has no finite energy'),
        (Command('ball', 'force', (0, 1e200, 0)), 'of 1e+200 N: its square is'),
        (Command('box', 'wrench', torque=(1.7e308, 0, 0)), 'of 1.7e+308 N m: its square'),
        (Command('box', 'wrench', (1.7e308, 1.7e308, 0)), 'of inf N: its square'),
        (
            Command('ball', 'impulse', (1e160, 0, 0)),
            'of 1e+160 N s: its square',
        ),
        (Command('box', 'impulse', torque=(9e153, 0, 0)), 'N m s: its square'),
        (asked('stone', AskedState()), 'no body is named'),
        (asked('floor', AskedState()), 'is fixed'),
    ],
)
def test_a_message_that_cannot_be_honoured_is_refused_with_a_reason(command, reason):
    floor = {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
    scene = load_scene(FREE | {'bodies': [*FREE['bodies'], floor]})
    assert reason in CommandRules(scene).refusal(command)


def test_the_twist_stands_in_the_child_frame_where_that_is_the_body():
    for child, expected in (('box', so3.rotate(TURN, (1, 0, 0))), ('', (1, 0, 0))):
        run = Run(free(), RunSettings())
        state = AskedState((0, 0, 0), TURN, (1, 0, 0), (0, 0, 0), child_frame_id=child)
        command = asked('box', state, stamp_ns=5)
        again = decode('box', 'set_state', command.message)
        assert again == command
        run.advance(1, [again])
        assert run.simulation.state.velocity[0, :2] == pytest.approx(expected[:2], abs=1e-15)


CSV = """time,body,kind,frame,fx,fz,x,y,z,qz,qw,vx,wz
0.05,drone,wrench,front_left,,3,,,,,,,
0.10,drone,set_state,body,,,1,2,30,1,1,4,2
0.15,drone,impulse,drone/rear_right,0.1,,,,,,,,
0.20,drone,set_state,,,,0,0,5,,,,
"""


def test_a_file_of_commands_knows_frames_and_states(verb, tmp_path):
    file, bag = tmp_path / 'c.csv', tmp_path / 'bag'
    file.write_text(CSV)
    words = ('simulate', 'quadrotor', '--duration', 0.3, '--commands', file)
    code, _, err = verb(*words, '-o', bag)
    assert code == 0, err
    assert verb('replay', bag, '-o', tmp_path / 'again')[0] == 0
    assert verb('bag', 'diff', bag, tmp_path / 'again')[0] == 0
    assert verb('bag', 'check', bag)[0] == 0
    for line, reason in (
        ('0,drone,set_state,rear_left,,,1,2,3,,,,', "frame 'rear_left' of a set_state"),
        ('0,drone,set_state,,1,,1,2,3,,,,', 'set_state has no fx'),
        ('0,drone,force,,1,,1,,,,,,', 'force has no x'),
        ('0,drone,set_state,,,,1,2,3,0,0,,', 'zero length'),
        # what is left out would put the body to the origin, or turn it by half a turn
        ('0,drone,set_state,,,,,,,,,4,', 'set_state without x'),
        ('0,drone,set_state,,,,1,,3,,,,', 'set_state without y'),
        ('0,drone,set_state,,,,1,2,3,0.7,,,', 'set_state without qw'),
        (
            '0,drone,force,rotor,1,,,,,,,,',
            "allowed: '', 'world', 'drone', 'body'",
        ),
    ):
        file.write_text(CSV.splitlines()[0] + '\n' + line + '\n')
        code, _, err = verb(*words, '-o', tmp_path / 'none')
        assert code == 2 and 'line 2: ' in err and reason in err


def test_inverse_takes_it_for_a_jump_of_the_pose(verb, tmp_path):
    file = tmp_path / 'c.csv'
    file.write_text(CSV)
    verb('simulate', 'quadrotor', '--duration', 0.4, '--commands', file, '-o', tmp_path / 'a')
    assert verb('inverse', tmp_path / 'a', '-o', tmp_path / 'b')[0] == 0
    run, found = Bag(tmp_path / 'a'), Bag(tmp_path / 'b')
    told, derived = (
        {m.log_time: cdr.decode(cdr.TwistStamped.TYPE, m.data)
         for m in bag.messages(['/drone/twist'])}
        for bag in (run, found)
    )  # fmt: skip
    assert len(told) == 41
    for time, twist in told.items():
        # short pieces of five samples between the jumps: truncation of the splines
        assert derived[time].linear == pytest.approx(twist.linear, abs=2e-4)
        assert derived[time].angular == pytest.approx(twist.angular, abs=2e-3)


def test_what_is_put_elsewhere_leaves_the_kernel_the_arrays_that_it_has(monkeypatch):
    """
    To hand a kernel of contact its arrays takes ten ticks of one box.
    """
    ground = {'name': 'ground', 'fixed': True, 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
    box = {'name': 'box', 'mass': 1, 'shape': {'type': 'box', 'size': [1, 1, 1]}}
    box['initial'] = {'position': [0, 0, 0.5]}
    scene = {'dt': 0.001, 'gravity': [0, 0, -9.81], 'contact': {'mode': 'timestep'}}
    simulation = Simulation(load_scene({'name': 'one', **scene, 'bodies': [box, ground]}))
    simulation.step(10)
    handed, world = [], WorldArrays.world
    monkeypatch.setattr(WorldArrays, 'world', lambda *given: handed.append(1) or world(*given))
    for _ in range(3):
        simulation.set_state('box', velocity=(1, 0, 0))
        simulation.step()
    assert not handed and len(simulation.contacts())
    simulation.reset()  # here a tick may have been broken off while a list grew
    simulation.step()
    assert handed
