# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a tick is: when commands act, and what is said of them."""

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.recording import cdr
from rigid_body_sim.runs.commands import Command, decode
from rigid_body_sim.runs.felt_accelerations import felt_accelerations
from rigid_body_sim.runs.run import Run, RunSettings

SCENE = {
    'version': 1,
    'name': 'run',
    'dt': 0.001,
    'bodies': [
        {'name': 'box', 'mass': 2.0, 'shape': {'type': 'box', 'size': [0.3, 0.2, 0.1]}},
        {'name': 'ball', 'mass': 1.0, 'shape': {'type': 'particle'}},
    ],
}


def make_run(**settings):
    return Run(Simulation(load_scene(SCENE)), RunSettings(**settings))


def messages(run, commands, last_tick):
    """Topic, sequence is implied by the stamp; return (topic, stamp in ticks, message)."""
    found = []
    topics = dict(enumerate(run.packer.topics, start=1))
    for _, output in run.follow(commands, last_tick):
        for channel, payload in (each for batch in output.batches for each in batch.payloads()):
            message = cdr.decode(topics[channel].type, payload)
            tick = (message.sec * 10**9 + message.nanosec) // run.simulation.dt_ns
            found.append((topics[channel].name, tick, message))
    return found


def of(found, topic):
    return [(tick, message) for name, tick, message in found if name == topic]


def test_first_applied_wrench_with_a_new_value_names_the_tick_on_which_it_first_acted():
    run = make_run(command_timeout_ns=0)
    found = messages(run, {13: [Command('box', 'wrench', force=(4.0, 0, 0))]}, 50)
    first = next(tick for tick, m in of(found, '/box/applied_wrench') if m.force == (4.0, 0, 0))
    assert first == 13
    tick, pose = of(found, '/box/pose')[-1]
    t = (tick - first) * 0.001
    assert pose.position[0] == pytest.approx(0.5 * (4.0 / 2.0) * t**2, rel=1e-12)  # round-off


def test_states_come_at_publish_ticks_and_commands_do_not_move_them():
    run = make_run(publish_every=10)
    found = messages(run, {13: [Command('box', 'force', force=(1.0, 0, 0))]}, 40)
    for topic in ('/box/pose', '/ball/twist', '/clock'):
        assert [tick for tick, _ in of(found, topic)] == [10, 20, 30, 40]
    # all bodies at the tick before each publish tick; the commanded one also when it changes
    assert [tick for tick, _ in of(found, '/ball/applied_wrench')] == [9, 19, 29, 39]
    assert [tick for tick, _ in of(found, '/box/applied_wrench')] == [9, 13, 19, 29, 39]


def test_held_command_times_out_and_says_so_on_that_tick():
    run = make_run(command_timeout_ns=20_000_000)
    found = messages(run, {5: [Command('box', 'wrench', force=(2.0, 0, 0))]}, 60)
    values = {tick: m.force[0] for tick, m in of(found, '/box/applied_wrench')}
    assert values[5] == values[9] == values[19] == 2.0
    assert values[25] == 0.0
    # 20 ticks of 1 m/s^2
    assert run.simulation.state.velocity[0, 0] == pytest.approx(0.02, rel=1e-12)  # round-off


def test_who_looks_between_ticks_changes_no_byte():
    commands = {
        5: [Command('box', 'wrench', force=(2.0, 0, 0), torque=(0, 0, 0.1), frame_id='box')]
    }
    plain, watched = (make_run(command_timeout_ns=20_000_000) for _ in range(2))
    expected, found = [], []
    for tick in range(60):
        for run, kept in ((plain, expected), (watched, found)):
            output = run.advance(1, commands.get(tick, ()))
            kept += [payload for batch in output.batches for _, payload in batch.payloads()]
        linear, _ = felt_accelerations(watched.simulation)  # also when the command is about to end
        assert linear[0].any() == (5 <= tick < 24)
    assert found == expected
    assert watched.simulation.state_bytes() == plain.simulation.state_bytes()


def test_a_command_repeated_in_time_does_not_end():
    run = make_run(command_timeout_ns=20_000_000)
    command = Command('box', 'wrench', force=(2.0, 0, 0))
    messages(run, {k: [command] for k in range(0, 100, 15)}, 100)
    assert run.simulation.state.velocity[0, 0] == pytest.approx(0.1, rel=1e-12)  # round-off


def test_impulse_is_shown_as_its_mean_force_over_the_tick_and_acts_once():
    run = make_run()
    found = messages(run, {7: [Command('ball', 'impulse', force=(0.5, 0, 0))]}, 20)
    values = {tick: m.force[0] for tick, m in of(found, '/ball/applied_wrench')}
    assert values[7] == pytest.approx(0.5 / 0.001, rel=1e-15)
    assert values[9] == values[19] == 0.0
    assert run.simulation.state.velocity[1, 0] == 0.5


def test_last_command_of_a_source_within_a_tick_wins_and_all_are_recorded():
    run = make_run(command_timeout_ns=0)
    commands = [
        Command('box', 'wrench', force=(9.0, 0, 0)),
        Command('box', 'wrench', force=(2.0, 0, 0)),
        Command('box', 'force', force=(1.0, 0, 0)),
    ]
    (_, output), *_ = run.follow({0: commands}, 1)
    assert [topic for topic, _ in output.consumed] == ['/box/wrench', '/box/wrench', '/box/force']
    np.testing.assert_array_equal(run.simulation.applied_wrench()[0][0], (3.0, 0, 0))


def test_wrench_in_body_axes_is_shown_in_world_axes_as_it_turns():
    scene = dict(SCENE)
    scene['bodies'] = [
        dict(SCENE['bodies'][0], initial={'angular_velocity': [0, 0, 10.0]}),
        SCENE['bodies'][1],
    ]
    run = Run(Simulation(load_scene(scene)), RunSettings(command_timeout_ns=0))
    command = Command('box', 'wrench', force=(1.0, 0, 0), frame_id='box')
    found = messages(run, {0: [command]}, 100)
    for tick, message in of(found, '/box/applied_wrench'):
        angle = 10.0 * tick * 0.001
        # the spin is steady about a principal axis: dmv6 is right to 1e-13 rad at h omega = 0.01
        np.testing.assert_allclose(message.force, (np.cos(angle), np.sin(angle), 0), atol=1e-12)


@pytest.mark.parametrize(
    ('command', 'reason'),
    [
        (Command('nobody', 'force'), 'no body is named'),
        (Command('box', 'force', force=(float('inf'), 0, 0)), 'not finite'),
        (Command('box', 'force', frame_id='map'), "frame 'map'"),
        (Command('box', 'force', frame_id='ball'), "frame 'ball'"),
        (Command('ball', 'torque', torque=(1.0, 0, 0)), 'point mass'),
        (Command('ball', 'impulse', torque=(1e198, 0, 0)), 'point mass'),
        (Command('ball', 'force', force=(1.0, 0, 0), frame_id='ball'), 'axes of the point mass'),
    ],
)
def test_refused_commands_say_why(command, reason):
    assert reason in make_run().rules.refusal(command)


def test_reset_puts_the_bodies_back_and_time_goes_on():
    run = make_run()
    messages(run, {0: [Command('box', 'wrench', force=(2.0, 0, 0))]}, 30)
    run.reset()
    assert run.simulation.tick == 30
    np.testing.assert_array_equal(run.simulation.state.position, np.zeros((2, 3)))
    messages(run, {}, 60)
    np.testing.assert_array_equal(run.simulation.state.velocity, np.zeros((2, 3)))


def test_a_command_is_recorded_with_the_bytes_in_which_it_came():
    sent = Command('box', 'wrench', force=(4.0, -0.0, 0), frame_id='world', stamp_ns=7).message
    garbage = sent[:22] + b'leaked' + sent[28:]  # what a sender's memory held in the padding
    assert cdr.decode(cdr.WrenchStamped.TYPE, garbage) == cdr.decode(cdr.WrenchStamped.TYPE, sent)
    run = make_run(namespace='/lab')
    commands = [decode('box', 'wrench', sent), decode('box', 'wrench', garbage)]
    (topic, first), (_, second) = run.advance(1, commands).consumed
    assert topic == '/lab/box/wrench'
    assert first is sent
    assert second == sent
