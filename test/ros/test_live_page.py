# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The live page of a running node: what it publishes arrives, in scene order, with the node's scene.
"""

import json
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped

from rigid_body_sim.analysis.recorded_contacts import contact_topics
from rigid_body_sim.analysis.recorded_impacts import read_impacts
from rigid_body_sim.errors import RunError
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.ros import state_listener
from rigid_body_sim.ros.state_listener import StateListener
from rigid_body_sim.scene import load_scene
from rigid_body_sim.view import live_server
from rigid_body_sim.view.bag_follower import BagFollower
from rigid_body_sim.view.growing_motion import joined
from rigid_body_sim.view.page_record import page_record
from rigid_body_sim.view.playback_page import unpacked

from ..pages import array_of
from ..patience import PATIENCE
from .conftest import start


@contextmanager
def heard(node, instants):
    """Motion of so many instants of a node, and who listened."""
    with StateListener(node.namespace) as listener:
        blocks = [listener.begin()]
        deadline = time.monotonic() + PATIENCE
        while sum(len(block.tracks[0].time) for block in blocks) < instants:
            assert time.monotonic() < deadline
            block = listener.more()
            if block is not None:
                blocks.append(block)
        yield joined(blocks), listener


def test_the_states_of_a_node_arrive_with_its_scene(start_node, meet):
    node = start_node()
    meet(node).be_known()
    with heard(node, 20) as (motion, listener):
        scene = load_scene(node.folder / 'laboratory.yaml')
        assert listener.scene is not None and listener.title == scene.name
    assert motion.touching is None  # it publishes no contacts
    assert [track.name for track in motion.tracks] == [body.name for body in scene.bodies]
    for track, body in zip(motion.tracks, scene.bodies, strict=True):
        assert np.array_equal(track.time, track.twist_time)
        ticks = np.diff(track.time) / 0.01  # [s] published a hundred times a second
        assert np.all(ticks > 0.5) and np.allclose(ticks, np.round(ticks), atol=1e-6)
        # nothing pushes anybody: all stay, to the bit, where the scene puts them
        assert np.all(track.position == body.initial.position)


def test_a_node_that_goes_while_it_is_asked_for_its_scene_is_waited_for(monkeypatch):
    monkeypatch.setattr(state_listener, 'FIRST', 0.1)
    monkeypatch.setattr(state_listener, 'ANSWER', 0.1)
    gone = state_listener._Publisher('/', 'gone')
    with StateListener() as listener:
        monkeypatch.setattr(
            listener, '_candidates', lambda: {gone: {'/box/pose': cdr.PoseStamped.TYPE}}
        )
        with pytest.raises(RunError, match='no state of all of them came'):
            listener.begin()
    assert listener.scene is None


def names_of(motion):
    return [track.name for track in motion.tracks]


@pytest.mark.parametrize('told', [True, False])
def test_a_pose_that_is_remapped_is_that_of_its_body(start_node, meet, told):
    node = start_node(more=('-r', 'box/pose:=/gps/pose'))
    meet(node).be_known()
    with StateListener(node.namespace if told else None) as listener:
        motion = listener.begin()
        scene = load_scene(node.folder / 'laboratory.yaml')
        assert names_of(motion) == [body.name for body in scene.bodies]
        for track, body in zip(motion.tracks, scene.bodies, strict=True):
            assert np.array_equal(track.time, track.twist_time)
            assert np.all(track.position == body.initial.position)


def test_a_bag_with_a_remapped_pose_is_followed_as_its_body(start_node, meet):
    node = start_node(more=('-r', 'box/pose:=/gps/pose'), record='true', record_path='live')
    peer = meet(node)
    told = peer.listen('stone/pose', cdr.PoseStamped)
    peer.until(lambda: len(told) > 30, 'poses')
    assert node.stop(signal.SIGINT) == 0
    scene = load_scene(node.folder / 'laboratory.yaml')
    found = BagFollower(node.folder / 'live').begin()
    assert sorted(names_of(found)) == sorted(body.name for body in scene.bodies)


def test_what_others_publish_is_no_part_of_the_page(start_node, meet):
    """As the goal of a planner: a pose that comes once, or never, of no body of the scene."""
    node = start_node()
    peer = meet(node)
    target = peer.node.create_publisher(PoseStamped, peer.full('a_target/pose'), 10)
    peer.be_known()
    for namespace in (None, node.namespace):
        with StateListener(namespace) as listener:
            motion = listener.begin()
        scene = load_scene(node.folder / 'laboratory.yaml')
        assert names_of(motion) == [body.name for body in scene.bodies]
    peer.node.destroy_publisher(target)


@pytest.mark.parametrize('named', ['none', 'stone'])
def test_bodies_without_topics_of_their_own_are_seen_from_the_arrays(start_node, meet, named):
    node = start_node(body_topics=named, publish_arrays='true')
    meet(node).be_known()
    with heard(node, 20) as (motion, listener):
        scene = load_scene(node.folder / 'laboratory.yaml')
        assert listener.title == scene.name
    assert names_of(motion) == [body.name for body in scene.bodies]
    for track, body in zip(motion.tracks, scene.bodies, strict=True):
        assert np.array_equal(track.time, track.twist_time) and len(track.time) >= 20
        assert np.all(track.position == body.initial.position)
        # of unit length, to round-off
        assert np.allclose(track.orientation, body.initial.orientation, rtol=0, atol=1e-15)
        assert not track.velocity.any()


@pytest.mark.parametrize(
    'late',
    [
        '/poses',
        '/box/twist',
        *(pytest.param(late, marks=pytest.mark.long) for late in ('/twists', '/plate/pose')),
    ],
)
def test_who_is_discovered_in_parts_is_waited_for(start_node, meet, monkeypatch, late):
    words = {} if late.count('/') == 2 else {'body_topics': 'stone', 'publish_arrays': 'true'}
    node = start_node(**words)
    meet(node).be_known()
    published, begin = StateListener._published, time.monotonic()

    def in_parts(self):
        """All but one topic, for longer than topics are waited for of which nobody knows."""
        found = published(self)
        if time.monotonic() > begin + 3.0:
            return found
        return {
            who: {wire: kind for wire, kind in wires.items() if not wire.endswith(late)}
            for who, wires in found.items()
        }

    monkeypatch.setattr(StateListener, '_published', in_parts)
    with heard(node, 5) as (motion, _):
        pass
    assert names_of(motion) == ['box', 'stone', 'plate']
    assert all(len(track.time) == len(track.twist_time) >= 5 for track in motion.tracks)


def test_arrays_of_a_scene_that_cannot_be_read_here_are_told_with_the_cure(
    start_node, meet, monkeypatch
):
    node = start_node(body_topics='none', publish_arrays='true')
    meet(node).be_known()
    (node.folder / 'laboratory.yaml').unlink()
    with (
        StateListener(node.namespace) as listener,
        pytest.raises(RunError, match=r'poses in an array, and its scene.* body_topics:='),
    ):
        listener.begin()


def test_who_waits_for_a_node_is_stopped_by_ctrl_c_and_says_so():
    words = [sys.executable, '-m', 'rigid_body_sim', 'view', '--live', '--namespace', '/nobody']
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(5.0)  # it looks for the node, or is still on the way: the same is said of both
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith('rigid_body_sim view: stopped by Ctrl-C before ')


def test_another_run_begins_when_the_node_is_started_again(start_node, meet):
    node = start_node()
    meet(node).be_known()
    with StateListener(node.namespace) as listener:
        before = listener.begin()
        deadline = time.monotonic() + PATIENCE
        while before.tracks[0].time[-1] < 2.0:
            before = listener.more() or before
            assert time.monotonic() < deadline
        node.stop(signal.SIGKILL)
        again = start(node.folder, node.namespace)
        try:
            while listener.run == 0:
                block = listener.more()
                assert time.monotonic() < deadline
        finally:
            again.close()
    assert listener.run == 1 and listener.scene is not None
    assert names_of(block) == names_of(before)


# Falls for 25.2 ticks.
BOUNCING = """
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: event}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}, restitution: 1}
  - {name: ball, shape: {type: sphere, radius: 0.1}, mass: 2, initial: {position: [0, 0, 0.15]}}
"""


def test_forces_over_time_count_from_the_reset_of_a_node(start_node, meet, tmp_path):
    """
    A force of as many newtons as seconds have passed. Also who comes after the reset sees it so.
    """
    path = tmp_path / 'pushed.yaml'
    path.write_text(PUSHED)
    node = start_node(scene=path, diagnostics_period=0.5)
    peer = meet(node)
    peer.be_known()

    def drawn(run):
        record, numbers = unpacked(run.page())
        time, force = (array_of(record['series'][n], numbers) for n in ('time', 'arrows_0'))
        return time, force.reshape(-1, 3)[:, 0]

    def look(run, until):
        deadline = time.monotonic() + PATIENCE
        while not until(*drawn(run)):
            assert time.monotonic() < deadline
            run.look()

    with StateListener(node.namespace) as listener:
        run = live_server.LiveRun(listener)
        look(run, lambda _, force: live_server.UNKNOWN_BEGIN not in run.page())
        answer = peer.trigger('reset')
        reset = float(re.search(r'([0-9.]+) s', answer.message)[1])
        look(run, lambda instants, force: instants[-1] > reset + 0.5 and force[-1] < 1.0)
        instants, force = drawn(run)
    expected = np.where(instants < reset, instants, instants - reset)
    # single precision of some seconds
    assert np.allclose(force, expected, rtol=0, atol=1e-5) and np.any(instants < reset)
    with StateListener(node.namespace) as listener:
        run = live_server.LiveRun(listener)
        look(run, lambda _, force: live_server.UNKNOWN_BEGIN not in run.page())
        instants, force = drawn(run)
    assert np.allclose(force, instants - reset, rtol=0, atol=1e-5)


PUSHED = """
dt: 0.01
bodies: [{name: ball, shape: {type: sphere, radius: 0.1}, mass: 1}]
forces: [{type: time, body: ball, table: [[0, 0, 0, 0], [1000, 1000, 0, 0]]}]
"""


def test_impacts_of_a_node_are_published_recorded_and_in_its_live_page(
    start_node, meet, run_verb, tmp_path
):
    """A ball that loses nothing meets the ground at odd multiples of its time of fall."""
    path = tmp_path / 'bouncing.yaml'
    path.write_text(BOUNCING)
    node = start_node(scene=path, record='true', record_path='live')
    peer = meet(node)
    told = peer.listen('rigid_body_sim/impacts', cdr.PointCloud2)
    with heard(node, 60) as (motion, listener):
        record, numbers, look = page_record(motion, listener.scene, live=True)
    peer.until(lambda: len(told) > 3, 'impacts')
    assert node.stop(signal.SIGINT) == 0
    bag = Bag(node.folder / 'live')
    assert not contact_topics(bag)  # they are off by default
    whole = read_impacts(bag)
    fall = np.sqrt(2 * 0.05 / 9.81)  # [s]
    expected = fall * (2 * np.arange(len(whole)) + 1)
    # round-off of that many flights, each some 1e-16 s
    assert np.allclose(whole.time, expected, rtol=0, atol=1e-12)
    of_bag = [m.data for m in bag.messages([f'{node.namespace}/rigid_body_sim/impacts'])]
    assert {cdr.encode(each) for each in told} <= set(of_bag)
    shown = array_of(record['impacts']['times'], numbers)
    assert look.impacts and len(shown) and set(shown) <= set(whole.time)
    outcome = json.loads(run_verb('replay', bag.path, '--json').stdout)
    assert outcome['identical'], outcome


def test_energies_and_contact_forces_of_a_node_are_in_the_page(start_node, meet):
    """A ball that rolls on the ground is pushed up by its weight, 1 kg times 9.81 m/s^2."""
    node = start_node(scene='rolling_sphere', publish_contacts='true')
    meet(node).be_known()
    with heard(node, 20) as (motion, listener):
        record, numbers, look = page_record(motion, listener.scene, live=True)
    assert look.energies and look.contacts
    assert [curve['values'] for curve in record['curves'][0]['curves']] == [
        'kinetic', 'potential', 'total',
    ]  # fmt: skip
    starts = array_of(record['contacts']['starts'], numbers)
    forces = array_of(record['contacts']['arrows'], numbers).reshape(-1, 6)[:, 3:]
    touching = np.diff(starts)[1:]  # nothing pressed before the first tick
    assert len(starts) == len(motion.tracks[0].time) + 1 and np.all(touching == 1)
    # it neither rises nor sinks by more than the ground gives way in its first instants
    assert np.allclose(forces[-10:, 2], 9.81, rtol=1e-3)
    height = array_of(record['series']['potential'], numbers)
    assert np.allclose(height, height[0], rtol=1e-4)  # overlap of some micrometres of 0.1 m
