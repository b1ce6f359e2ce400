# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Pictures of recorded runs: read back truly, drawn visibly, refused clearly.

The recorded motions are closed forms, so that the numbers in the picture are known.
"""

from __future__ import annotations

import argparse
import resource
import warnings
from functools import cache, partial
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
import yaml
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from rigid_body_sim.__main__ import main
from rigid_body_sim.errors import UserError
from rigid_body_sim.exact import ballistic, free_asymmetric_top
from rigid_body_sim.exact.attitude import rotate
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.bag_writer import BagWriter
from rigid_body_sim.recording.packing import StatePacker
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.scene import load_scene
from rigid_body_sim.verbs import view
from rigid_body_sim.view.energy_history import energy_history
from rigid_body_sim.view.picture import picture, roll_pitch_yaw
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track, read_motion

DT_NS = 10_000_000
TICKS = 200
GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]
MASS, INERTIA = 2.0, (0.3, 0.2, 0.4)  # [kg], [kg m^2]
START, VELOCITY, SPIN = (0.0, 0.0, 1.0), (1.0, 0.5, 6.0), (0.1, 5.0, -0.2)


def scene_text(bodies, gravity=GRAVITY, title='thrown'):
    """YAML of a scene of equal bodies; the motion is written elsewhere."""
    moments = dict(zip(('ixx', 'iyy', 'izz'), INERTIA, strict=True))
    return yaml.safe_dump(
        {
            'version': 1,
            'name': title,
            'dt': DT_NS * 1e-9,
            'gravity': list(gravity),
            'bodies': [{'name': name, 'mass': MASS, 'inertia': moments} for name in bodies],
        }
    ).encode()


@cache
def motion_of(time, places):
    """Thrown tumbling bodies, each shifted along y: the arrays that a tick records."""
    flight = ballistic.flight(time, position=START, velocity=VELOCITY, acceleration=GRAVITY)
    turning = free_asymmetric_top.rotation(time, inertia=INERTIA, angular_velocity_body=SPIN)
    rates = rotate(turning.orientation, turning.angular_velocity_body)
    shift = np.outer(np.arange(places), (0.0, 1.0, 0.0))
    return {
        'position': flight.position + shift,
        'orientation': np.tile(turning.orientation, (places, 1)),
        'velocity': np.tile(flight.velocity, (places, 1)),
        'angular_velocity': np.tile(rates, (places, 1)),
    }


def thrown(
    folder, bodies=('box', 'can'), *, scene=True, namespace='', pushed=(), jump=0.0, title='thrown'
):
    """Record thrown bodies; `pushed` ticks carry an applied wrench and a jump of the speed."""
    packer = StatePacker(bodies, dt_ns=DT_NS, namespace=namespace)
    path = folder / 'thrown'
    writer = BagWriter(
        path,
        topics=packer.topics,
        manifest={'schema_version': '1', 'integrator': 'dmv6', 'dt_ns': str(DT_NS)},
        attachments={'scene.yaml': scene_text(bodies, title=title)} if scene else {},
    )
    force, extra = np.zeros((len(bodies), 3)), np.zeros(3)
    for tick in range(1, TICKS + 1):
        arrays = dict(motion_of(tick * DT_NS * 1e-9, len(bodies)))
        force[:] = tick - 1 in pushed
        extra[0] += jump * (tick - 1 in pushed)
        arrays['velocity'] = arrays['velocity'] + extra
        writer.write(packer.pack(tick, **arrays, force=force, torque=0.0 * force))
    writer.close({})
    return path


@pytest.fixture
def throw(tmp_path):
    """Record thrown bodies, see `thrown`."""
    return partial(thrown, tmp_path)


def draw(bag, output):
    """Run the verb."""
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    return view.run(parser.parse_args([str(bag), '-o', str(output)]))


def figure_of_verb(patch, bag, output):
    """The figure that the verb draws into a file."""
    seen = {}
    patch.setattr(view, 'picture', lambda *a, **k: seen.setdefault('figure', picture(*a, **k)))
    assert draw(bag, output) == 0
    return seen['figure']


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    """What is written on the page of two thrown bodies, and its pixels."""
    folder = tmp_path_factory.mktemp('page')
    with pytest.MonkeyPatch.context() as patch:
        figure = figure_of_verb(patch, thrown(folder), folder / 'run.png')
    return texts(figure), matplotlib.image.imread(folder / 'run.png')[:, :, :3]


def test_the_picture_shows_more_than_paper(page):
    """The file opens as a picture and holds curves in several colours."""
    _, pixels = page
    assert pixels.shape[0] > 800 and pixels.shape[1] > 1000
    colored = np.ptp(pixels, axis=2) > 0.3
    assert colored.mean() > 1e-3
    assert len(np.unique(np.round(pixels[colored] * 4), axis=0)) > 5


def test_letters_that_the_font_of_a_picture_lacks_are_named_in_one_line(
    throw, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(view, 'picture', titled)  # to draw more takes long
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert draw(throw(title='場の箱'), tmp_path / 'run.png') == 0
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    assert said.startswith("rigid_body_sim view: warning: the font of the picture lacks '場の箱'")


def test_positions_and_speeds_come_back_to_the_bit(throw):
    """What was packed is what is drawn."""
    track = read_motion(Bag(throw(namespace='/lab')), samples=TICKS).tracks[1]
    assert track.name == 'can'
    expected = [motion_of(k * DT_NS * 1e-9, 2) for k in range(1, TICKS + 1)]
    for name, rows in (
        ('position', track.position),
        ('orientation', track.orientation),
        ('velocity', track.velocity),
        ('angular_velocity', track.angular_velocity),
    ):
        np.testing.assert_array_equal(rows, [arrays[name][1] for arrays in expected])
    np.testing.assert_allclose(track.time, np.arange(1, TICKS + 1) * 0.01, rtol=1e-15)


def test_thinning_keeps_the_first_and_the_last_instant(throw):
    """Thirty samples of two hundred: evenly spaced, and the end of the run is not lost."""
    track = read_motion(Bag(throw()), samples=30).tracks[0]
    assert 30 <= len(track.time) <= 31
    np.testing.assert_allclose(track.time[[0, -1]], [0.01, 2.0], rtol=1e-15)
    np.testing.assert_array_equal(track.time, track.twist_time)


def test_energy_of_a_thrown_tumbling_body_is_constant_and_right(throw):
    """E = m v^2/2 + I w^2/2 + m g z for two bodies, by hand."""
    path = throw()
    history = energy_history(
        load_scene(scene_text(('box', 'can'))), read_motion(Bag(path), samples=50)
    )
    by_hand = 0.5 * MASS * np.dot(VELOCITY, VELOCITY) + MASS * 9.81 * START[2]
    by_hand += 0.5 * np.dot(INERTIA, np.square(SPIN))
    # Round-off of some thirty operations.
    np.testing.assert_allclose(history.kinetic + history.potential, 2.0 * by_hand, rtol=1e-14)
    assert history.drift.max() < 1e-14
    assert np.ptp(history.kinetic) > 10.0


def test_a_push_is_no_drift_but_a_jump_without_one_is(throw):
    """The same jump of the speed, once under a recorded wrench and once with the wrench hidden."""
    scene = load_scene(scene_text(('box', 'can')))
    pushed = read_motion(Bag(throw(pushed=(100, 101), jump=0.5)), samples=TICKS)
    np.testing.assert_allclose(pushed.command_time, [1.0, 1.01], rtol=1e-15)
    assert energy_history(scene, pushed).drift.max() < 1e-14
    hidden = RecordedMotion(pushed.tracks, np.empty(0))
    drift = energy_history(scene, hidden).drift
    assert drift[98].max() < 1e-14  # before the push
    largest_speed = np.linalg.norm(pushed.tracks[0].velocity, axis=1).max()
    np.testing.assert_allclose(drift[-1, 1], 1.0 / largest_speed, rtol=1e-12)  # 1 m/s gained


def test_a_bag_without_a_scene_is_drawn_without_energy(throw):
    """Nobody knows the masses: the panels say so."""
    assert 'masses are unknown' in texts(drawn(throw(scene=False)))


def test_title_axes_and_legend_name_what_is_seen(page):
    """Scene, integrator and dt above; units on every axis; bodies by name."""
    said, _ = page
    for words in ('thrown, integrator dmv6, dt = 0.01 s', 'box', 'can', 'x [m]', 'z [m]'):
        assert words in said
    for label in ('energy [J]', 'simulation time [s]', 'velocity [m/s]: z', 'attitude [°]: roll'):
        assert label in said
    for label in ('angular velocity [rad/s], body axes: x', 'angular momentum [kg m²/s]'):
        assert label in said
    assert 'commanded' not in said  # nothing was: no empty panel


def test_of_many_bodies_ten_are_named_and_the_rest_counted(throw):
    """Fourteen bodies: no legend of fourteen lines, and no silence about the other four."""
    said = texts(drawn(throw(tuple(f'body_{i}' for i in range(14)))))
    assert '4 more bodies, not named' in said
    assert 'body_9' in said and 'body_10' not in said


def test_a_command_of_one_tick_is_drawn_with_its_value(throw):
    """One newton along each axis at tick 100 of 200, also where only 30 instants are drawn."""
    motion = read_motion(Bag(throw(pushed=(100,))), samples=30)
    assert [track.force.max() for track in motion.tracks] == [1.0, 1.0]
    said = texts(picture(motion, None, title='push'))
    assert 'commanded force [N]: x' in said and 'commanded torque' not in said


def test_roll_pitch_and_yaw_are_those_of_scipy():
    turns = Rotation.random(200, rng=np.random.default_rng(3))
    wanted = turns.as_euler('ZYX', degrees=True)[:, ::-1]
    # round-off, magnified by the nearness of 90 degrees
    np.testing.assert_allclose(roll_pitch_yaw(turns.as_quat()), wanted, atol=1e-9)


def test_what_lies_still_has_no_empty_panels():
    t = np.linspace(0.0, 1.0, 20)
    still = track(
        'box', t, np.ones((20, 3)), np.tile((0, 0, 0, 1.0), (20, 1)), *np.zeros((2, 20, 3))
    )
    figure = picture(
        RecordedMotion((still,), np.empty(0)), None, title='still', caption='It rests.'
    )
    said = texts(figure)
    assert 'It rests.' in said and 'position [m]: x' in said
    for nothing in ('velocity', 'attitude', 'momentum', 'trajectories', 'drift'):
        assert nothing not in said


def test_bodies_that_only_turn_are_shown_by_the_paths_of_their_axes():
    """A spin about z on the spot: the picture follows x or y, never z, which does not move."""
    t = np.linspace(0.0, 3.0, 50)
    turning = free_asymmetric_top.rotation(t, inertia=INERTIA, angular_velocity_body=(0, 0, 2.0))
    zeros = np.zeros((50, 3))
    motion = RecordedMotion(
        (track('top', t, zeros, turning.orientation, zeros, zeros + (0, 0, 2.0)),), np.empty(0)
    )
    said = texts(picture(motion, None, title='spin'))
    assert 'no body travels' in said
    assert 'top: x axis' in said or 'top: y axis' in said


def test_a_bag_of_another_recorder_starts_at_zero(tmp_path):
    """No manifest, no tick numbers, stamps of the wall clock, a frame name of changing length."""
    path = tmp_path / 'foreign'
    writer = BagWriter(
        path, topics=[Topic('/rover/pose', cdr.PoseStamped.TYPE)], manifest={}, attachments={}
    )
    for k, frame in enumerate(('map', 'odometry', 'map')):
        message = cdr.PoseStamped(1_700_000_000 + k, 5, frame, (1.0 * k, 0.0, 0.0), (0, 0, 0, 1))
        writer.write_message('/rover/pose', 0, 10**18 + k, cdr.encode(message))
    writer.close({})
    motion = read_motion(Bag(path), samples=10)
    # The stamps are 1.7e9 s: their round-off is 2.4e-7 s.
    np.testing.assert_allclose(motion.tracks[0].time, [0.0, 1.0, 2.0], atol=5e-7)
    np.testing.assert_array_equal(motion.tracks[0].position[:, 0], [0.0, 1.0, 2.0])
    assert draw(path, tmp_path / 'run.png') == 0


def rising(path, *times):
    """A ball that rises by 1 m/s: (log time, stamp) [s] of its poses, in file order."""
    writer = BagWriter(
        path, topics=[Topic('/ball/pose', cdr.PoseStamped.TYPE)], manifest={}, attachments={}
    )
    for log, sec in times:
        message = cdr.PoseStamped(sec, 0, 'map', (0.0, 0.0, 1.0 * sec), (0, 0, 0, 1))
        writer.write_message('/ball/pose', 0, log, cdr.encode(message))
    writer.close({})
    return path


@pytest.mark.parametrize('suffix', ['png', 'html'])
def test_a_bag_whose_time_goes_back_is_not_drawn(tmp_path, suffix):
    """As of a player in a loop: one time would stand for two places."""
    path = rising(tmp_path / 'loop', *enumerate((1, 2, 3, 1, 2, 3)))
    said = '/ball/pose: message 4 by log time, of 1 s, comes after that of 3 s; .* its own bag'
    with pytest.raises(UserError, match=said):
        draw(path, tmp_path / f'run.{suffix}')
    assert not list(tmp_path.glob('run*'))


def test_a_bag_whose_clock_went_back_with_the_run_is_not_drawn(tmp_path):
    path = rising(tmp_path / 'twice', *((sec, sec) for sec in (1, 2, 3, 1, 2, 3)))
    with pytest.raises(UserError, match='two messages are of 1 s, and log times go back in the'):
        draw(path, tmp_path / 'run.png')


def test_a_bag_is_drawn_in_the_order_of_its_log_times_whatever_that_of_its_file(tmp_path):
    path = rising(tmp_path / 'shuffled', *((sec, sec) for sec in (1, 2, 5, 3, 4, 6)))
    (ball,) = read_motion(Bag(path), samples=100).tracks
    assert ball.time.tolist() == [0, 1, 2, 3, 4, 5]
    assert ball.position[:, 2].tolist() == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize('name', ['run.pdf', 'run', 'missing/run.png'])
def test_other_outputs_are_refused(name, tmp_path):
    """A format that is not drawn, and a folder that is not there."""
    with pytest.raises(UserError, match=r'give FILE\.png|create it first'):
        draw(tmp_path / 'nothing', tmp_path / Path(name))


@pytest.mark.parametrize('suffix', ['png', 'html'])
def test_what_was_drawn_before_outlives_a_full_disk(throw, tmp_path, capsys, monkeypatch, suffix):
    monkeypatch.setattr(view, 'picture', lambda *_, **__: Figure())  # to draw more takes long
    bag = throw()
    output = tmp_path / f'out.{suffix}'
    output.write_text('drawn before')
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000, hard))
    try:
        code = main(['view', str(bag), '-o', str(output)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert code == 1
    assert f'{output}: cannot be written: File too large' in capsys.readouterr().err
    assert output.read_text() == 'drawn before'
    assert not list(tmp_path.glob('.*'))


def test_a_bag_without_poses_is_refused(tmp_path):
    """The message names what was looked for."""
    writer = BagWriter(
        tmp_path / 'empty',
        topics=[Topic('/clock', cdr.Clock.TYPE)],
        manifest={},
        attachments={},
    )
    writer.close({})
    with pytest.raises(UserError, match='holds no poses to draw'):
        draw(tmp_path / 'empty', tmp_path / 'run.png')


def titled(*_, title, **__):
    """A figure with nothing but its title."""
    figure = Figure()
    figure.suptitle(title)
    return figure


def drawn(path):
    """The figure of a bag as the verb draws it, its scene included."""
    bag = Bag(path)
    motion = read_motion(bag, samples=50)
    source = bag.attachments.get('scene.yaml')
    energy = energy_history(load_scene(source), motion) if source else None
    return picture(motion, energy, title='run')


def texts(figure):
    """Everything written in a figure, one line each."""
    found = figure.findobj(lambda artist: hasattr(artist, 'get_text'))
    return '\n'.join(artist.get_text() for artist in found)


def track(name, time, position, orientation, velocity, angular_velocity):
    """A track whose poses and twists share their times."""
    return Track(name, time, position, orientation, time, velocity, angular_velocity)
