# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A saved run checks whole and replays; any bag comes back as the arrays that it holds."""

import shutil

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory

import rigid_body_sim as rbs
from rigid_body_sim.__main__ import main
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.definitions import definition

from .conftest import VECTORS, damper, same_bits


def assert_same(run, other):
    assert other.names == run.names and same_bits(other.time, run.time)
    for name in run:
        for quantity in VECTORS:
            assert same_bits(getattr(other[name], quantity), getattr(run[name], quantity)), (
                quantity
            )
        # computed from the twist in world axes: round-off of two rotations
        found, wanted = (each[name].angular_velocity_body for each in (other, run))
        assert np.allclose(found, wanted, rtol=1e-14, atol=1e-15)
    assert np.allclose(other.energy, run.energy, rtol=1e-13, atol=1e-15)


def test_a_saved_run_checks_whole_replays_and_comes_back(run, bag):
    assert main(['bag', 'check', str(bag)]) == main(['replay', str(bag)]) == 0
    assert_same(run, rbs.open_bag(bag))


@pytest.mark.parametrize('every', [0.01, 0.02, 0.1])
def test_commands_come_back_at_their_rows_however_far_apart(every, tmp_path):
    run = rbs.simulate('satellite', 1, every=every, controller=damper)
    run.save(tmp_path / 'bag')
    assert main(['replay', str(tmp_path / 'bag')]) == 0
    assert_same(run, rbs.open_bag(tmp_path / 'bag'))


def test_a_run_from_the_middle_with_what_holds_and_ends_there(tmp_path):
    sim = rbs.Simulation('satellite')
    sim.step(7)  # no multiple of the five ticks between rows
    sim.set_wrench('inspector', force=(0, 0.1, 0), frame='body')
    sim.hold('satellite', 'force', force=(1, 2, 3), until=33)
    run = sim.run(1, every=0.05)
    assert run.time[0] == 0.07
    run.save(tmp_path / 'bag')
    assert main(['bag', 'check', str(tmp_path / 'bag')]) == 0
    assert main(['replay', str(tmp_path / 'bag')]) == 0
    assert_same(run, rbs.open_bag(tmp_path / 'bag'))


@pytest.mark.parametrize('scene', ['rocket', 'skater', 'deck_landing'])
def test_masses_inertias_and_decks_that_change_come_back(scene, tmp_path):
    run = rbs.simulate(scene, 0.4, every=0.04)
    run.save(tmp_path / 'bag')
    assert main(['replay', str(tmp_path / 'bag')]) == 0
    assert_same(run, rbs.open_bag(tmp_path / 'bag'))


def test_numbers_are_those_that_another_reader_finds(bag):
    run, found = rbs.open_bag(bag), {}
    (file,) = bag.glob('*.mcap')
    with file.open('rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, said in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, said))
    for name in run:
        poses = [said.pose for _, said in found[f'/{name}/pose']]
        places = [[p.position.x, p.position.y, p.position.z] for p in poses]
        assert run[name].position.tolist() == places
        turns = [p.orientation for p in poses]
        assert run[name].orientation.tolist() == [[q.x, q.y, q.z, q.w] for q in turns]
        wrenches = found[f'/{name}/applied_wrench']
        for row, time in enumerate(run.time):
            told = [said.wrench for at, said in wrenches if at <= round(time * 1e9)]
            wanted = told[-1].torque if told else None
            got = run[name].torque[row].tolist()
            assert got == ([wanted.x, wanted.y, wanted.z] if told else [0, 0, 0])


def test_bags_of_arrays_and_namespaces_and_other_recorders_come_back(tmp_path):
    base = ['simulate', 'satellite', '--duration', '0.2']
    plain, arrays = tmp_path / 'plain', tmp_path / 'arrays'
    assert main([*base, '-o', str(plain)]) == 0
    assert main([*base, '-o', str(arrays), '--arrays', '--body-topics', 'none']) == 0
    run, other = rbs.open_bag(plain), rbs.open_bag(arrays)
    assert run.names == other.names == ('satellite', 'inspector', 'beacon')
    assert same_bits(run['beacon'].position, other['beacon'].position)
    assert np.isnan(other['beacon'].force[-1]).all() or not other['beacon'].force.any()
    derived = tmp_path / 'derived'
    assert main(['inverse', str(plain), '-o', str(derived)]) == 0
    found = rbs.open_bag(derived)
    assert same_bits(found['satellite'].position, run['satellite'].position)
    assert np.isnan(found['satellite'].force).all()  # nobody recorded what was commanded


def balls(path, *messages):
    """Write poses of a ball that rises by 1 m/s: (log time, stamp) [s], in file order."""
    with path.open('wb') as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema(
            cdr.PoseStamped.TYPE, 'ros2msg', definition(cdr.PoseStamped.TYPE).encode()
        )
        channel = writer.register_channel('/ball/pose', 'cdr', schema)
        for log, sec in messages:
            pose = cdr.PoseStamped(sec, 0, 'world', (0.0, 0.0, sec), (0.0, 0.0, 0.0, 1.0))
            writer.add_message(channel, log, cdr.encode(pose), log)
        writer.finish()
    return path


@pytest.mark.parametrize(
    ('log_times', 'problem'),
    [
        ((1, 2, 3, 4, 5), 'message 4 by log time, of 1 s, comes after that of 3 s; '),
        ((1, 2, 3, 1, 2), 'two messages are of 1 s, and log times go back in the file; '),
    ],
    ids=['clock of the wall', 'clock of the run'],
)
def test_a_bag_whose_time_goes_back_is_refused_with_the_message_that_does(
    tmp_path, log_times, problem
):
    path = balls(tmp_path / 'looped.mcap', *zip(log_times, (1, 2, 3, 1, 2), strict=True))
    with pytest.raises(rbs.UserError, match=f'/ball/pose: {problem}'):
        rbs.open_bag(path)


def test_a_bag_is_read_in_the_order_of_its_log_times_whatever_that_of_its_file(tmp_path):
    order = (1, 2, 5, 3, 4, 6, 8, 7, 9)
    path = balls(tmp_path / 'shuffled.mcap', *((100 + sec, sec) for sec in order))
    heights = rbs.open_bag(path)['ball'].position[:, 2]
    assert heights.tolist() == [*range(1, 10)]
    derived = tmp_path / 'derived'
    assert main(['inverse', str(path), '-o', str(derived)]) == 0
    assert rbs.open_bag(derived).time.tolist() == [*range(1, 10)]


def test_damaged_bags_and_what_is_none_end_in_one_error(bag, tmp_path):
    with pytest.raises(rbs.UserError, match='no such file'):
        rbs.open_bag(tmp_path / 'nothing')
    cut = tmp_path / 'cut'
    shutil.copytree(bag, cut)
    (file,) = cut.glob('*.mcap')
    whole = file.read_bytes()
    for damaged in (whole[: len(whole) // 2], whole[:4000] + b'\0\0\0\0' + whole[4004:], b''):
        file.write_bytes(damaged)
        with pytest.raises((rbs.RunError, rbs.UserError)) as refused:
            rbs.open_bag(cut)
        assert '\n' not in str(refused.value)


def test_a_run_of_a_bag_is_not_saved_again_and_no_path_is_overwritten(run, bag, tmp_path):
    with pytest.raises(rbs.UserError, match='which is its bag'):
        rbs.open_bag(bag).save(tmp_path / 'again')
    with pytest.raises(rbs.UserError, match='exists already'):
        run.save(bag)
    with pytest.raises(rbs.UserError, match='does not exist'):
        run.save(tmp_path / 'no' / 'folder')


def test_a_scene_changed_in_python_is_the_one_that_the_bag_holds(tmp_path):
    from dataclasses import replace

    moon = replace(rbs.load_scene('two_bodies'), gravity=(0.0, 0.0, -1.62))
    run = rbs.simulate(moon, 0.1, every=0.1)
    run.save(tmp_path / 'bag')
    assert rbs.open_bag(tmp_path / 'bag').scene.gravity == (0.0, 0.0, -1.62)
    assert main(['replay', str(tmp_path / 'bag')]) == 0
