# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`replay`: the recording alone gives the same run again, bit by bit."""

import shutil
import struct

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

import rigid_body_sim as rbs
from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import RunError
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.recorder import RunRecorder, recording
from rigid_body_sim.runs.run import Run, RunSettings, last_tick

from ..integrators.scenes import OF_EACH_KIND, mostly_long
from .conftest import SCENES


def rewritten(bag, target, *, change_message=None, change_attachment=None):
    """Copy a bag to a lone file with the mcap library, changing what is asked."""
    (source,) = bag.glob('*.mcap')
    with source.open('rb') as stream, target.open('wb') as out:
        reader = make_reader(stream)
        writer = Writer(out, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        for a in reader.iter_attachments():
            data = change_attachment(a.name, a.data) if change_attachment else a.data
            writer.add_attachment(a.create_time, a.log_time, a.name, a.media_type, data)
        schemas, channels = {}, {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id], channel.metadata
                )
            data = message.data
            if change_message:
                data = change_message(channel.topic, message.sequence, data)
            writer.add_message(
                channels[channel.id],
                message.log_time,
                data,
                message.publish_time,
                message.sequence,
            )
        writer.finish()
    return target


def flip_last_bit_of_last_double(data):
    (bits,) = struct.unpack('<Q', data[-8:])
    return data[:-8] + struct.pack('<Q', bits ^ 1)


TWO_BODIES = load_scene(SCENES / 'two_bodies.yaml')
ABLE = sorted(
    name
    for name, integrator in INTEGRATORS.items()
    if integrator.refuses(TWO_BODIES) is None and not integrator.is_reference
)


@pytest.mark.parametrize('integrator', mostly_long(ABLE, short=OF_EACH_KIND))
def test_replay_of_a_bag_is_identical(verb, as_json, tmp_path, commands, integrator):
    words = ('--duration', 0.3, '--commands', commands, '--integrator', integrator)
    assert verb('simulate', SCENES / 'two_bodies.yaml', '-o', tmp_path / 'b', *words)[0] == 0
    code, result = as_json('replay', tmp_path / 'b')
    assert (code, result['identical'], result['ticks']) == (0, True, 300)


def test_replay_of_a_lone_file_and_into_a_new_bag_is_identical(as_json, bag, tmp_path):
    (file,) = bag.glob('*.mcap')
    lone = shutil.copy(file, tmp_path / 'lone.mcap')
    code, result = as_json('replay', lone, '-o', tmp_path / 'again')
    assert (code, result['identical']) == (0, True)
    code, result = as_json('replay', tmp_path / 'again')
    assert (code, result['identical']) == (0, True)


def test_one_flipped_bit_in_a_state_is_found_with_tick_body_and_field(as_json, bag, tmp_path):
    def flip(topic, sequence, data):
        return (
            flip_last_bit_of_last_double(data)
            if (topic, sequence) == ('/ball/twist', 120)
            else data
        )

    code, result = as_json('replay', rewritten(bag, tmp_path / 'f.mcap', change_message=flip))
    assert code == 3
    assert not result['identical']
    assert (result['tick'], result['body'], result['field'], result['ulps']) == (
        120, 'ball', 'twist.angular.z', 1,
    )  # fmt: skip


def test_one_flipped_bit_in_a_command_is_found(as_json, bag, tmp_path):
    # the last double of the message is a torque, which a point mass cannot take: flip the force
    def flip_force(topic, sequence, data):
        if topic != '/ball/impulse':
            return data
        return flip_last_bit_of_last_double(data[:-40]) + data[-40:]

    code, result = as_json(
        'replay', rewritten(bag, tmp_path / 'f.mcap', change_message=flip_force)
    )
    assert code == 3
    assert result['body'] == 'ball'
    assert result['tick'] >= 150


def test_a_changed_scene_is_not_replayed(verb, bag, tmp_path):
    def change(name, data):
        return data.replace(b'0.5', b'0.6') if name == 'scene.yaml' else data

    code, _, err = verb('replay', rewritten(bag, tmp_path / 'f.mcap', change_attachment=change))
    assert code == 1
    assert 'scene.yaml' in err


def test_a_missing_message_is_found(as_json, bag, tmp_path):
    target = tmp_path / 'short.mcap'
    rewritten(bag, target)
    with target.open('rb') as stream:
        kept = [
            (schema, channel, message)
            for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False)
            if (channel.topic, message.sequence) != ('/box/pose', 60)
        ]
        stream.seek(0)
        reader = make_reader(stream)
        metadata = list(reader.iter_metadata())
        attachments = list(reader.iter_attachments())
    with (tmp_path / 'cut.mcap').open('wb') as out:
        writer = Writer(out)
        writer.start(profile='ros2')
        for record in metadata:
            writer.add_metadata(record.name, record.metadata)
        for a in attachments:
            writer.add_attachment(0, 0, a.name, a.media_type, a.data)
        channels = {}
        for schema, channel, message in kept:
            if channel.id not in channels:
                schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schema_id, channel.metadata
                )
            writer.add_message(
                channels[channel.id],
                message.log_time,
                message.data,
                message.log_time,
                message.sequence,
            )
        writer.finish()
    code, result = as_json('replay', tmp_path / 'cut.mcap')
    assert code == 3
    assert result['tick'] == 60


def test_another_integrator_or_step_gives_the_error_not_a_verdict(as_json, bag):
    code, coarse = as_json('replay', bag, '--dt', 0.002)
    assert code == 0
    assert not coarse['identical']
    _, fine = as_json('replay', bag, '--integrator', 'rk4', '--dt', 0.0005)
    for result in (coarse, fine):
        assert set(result['errors']) == {'box', 'ball'}
    # both runs differ from the recorded dmv6 at 1 ms by their own errors and by its: of order h^2
    assert 0 < fine['errors']['ball']['largest']['position'] < 1e-3


def test_a_step_that_meets_no_recorded_time_is_refused(verb, bag):
    code, _, err = verb('replay', bag, '--dt', 0.7)
    assert code == 2
    assert '--dt' in err


def test_a_bag_without_a_tick_has_nothing_to_compare_another_method_with(verb, tmp_path):
    rbs.Simulation('oscillator').run(0.0).save(tmp_path / 'still')
    code, _, err = verb('replay', tmp_path / 'still', '--integrator', 'rk4')
    assert code == 2 and '--dt' not in err
    assert f'{tmp_path / "still"}: holds no state after that of its start' in err


def test_a_bag_begun_in_mid_run_with_commands_held_is_identical(as_json, tmp_path):
    scene = load_scene(SCENES / 'two_bodies.yaml')
    run = Run(Simulation(scene), RunSettings())
    push = Command('box', 'wrench', force=(1.0, 0, 0), torque=(0, 0.01, 0), frame_id='box')
    for _ in run.follow({0: [Command('ball', 'force', force=(0, 1.0, 0))], 70: [push]}, 117):
        pass
    recorder = RunRecorder(run, tmp_path / 'mid')
    for tick, output in run.follow({130: [push]}, 400):
        recorder.record(output, tick=tick)
    recorder.close('stopped')
    code, result = as_json('replay', tmp_path / 'mid')
    assert (code, result['identical'], result['ticks']) == (0, True, 400 - 117)


def test_a_run_that_fails_inside_a_tick_leaves_no_ending_ahead_of_its_messages(
    as_json, verb, tmp_path
):
    scene = load_scene(
        {
            'name': 'ages',
            'dt': 1_000_000,
            'gravity': [0, 0, 0],
            'bodies': [{'name': 'b', 'shape': {'type': 'particle'}, 'mass': 1.0}],
        }
    )
    run, bag = Run(Simulation(scene), RunSettings(publish_every=1)), tmp_path / 'ages'
    with pytest.raises(RunError, match='does not fit'), recording(run, bag, done='') as recorder:
        for tick, output in run.follow({}, 3000):
            recorder.record(output, tick=tick)
    assert run.simulation.tick == 2148  # ahead of what any message can bear
    assert recorder.is_torn
    assert not (bag / 'metadata.yaml').exists()
    assert verb('bag', 'recover', bag, '-o', tmp_path / 'saved')[0] == 0
    code, result = as_json('replay', tmp_path / 'saved')
    assert (code, result['identical'], result['ticks']) == (0, True, 2147)


def test_the_last_tick_is_one_that_messages_bear():
    assert last_tick(1) == 2**32 - 1
    assert last_tick(500_000_000) == 2**32 - 1  # half a second before the stamps end
    assert last_tick(1_000_000_000) == 2**31 - 1
    assert last_tick(10**15) == 2147


def test_what_is_no_recording_is_refused(verb, tmp_path):
    (tmp_path / 'x.mcap').write_bytes(b'not a bag')
    for path in (tmp_path / 'x.mcap', tmp_path / 'missing'):
        code, _, err = verb('replay', path)
        assert code == 2
        assert err.count('\n') == 1
