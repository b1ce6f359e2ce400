# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a bag tells of its contacts: `bag info` counts and finds extremes, `view` draws the loads.

The recorded contacts are made up, so that every number is known.
"""

from __future__ import annotations

import argparse
import json

import numpy as np
import pytest

from rigid_body_sim.analysis.recorded_contacts import summarise
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.bag_writer import BagWriter
from rigid_body_sim.recording.contact_packing import ContactPacker
from rigid_body_sim.recording.packing import StatePacker
from rigid_body_sim.verbs import bag as bag_verb
from rigid_body_sim.verbs import view
from rigid_body_sim.view.picture import picture
from rigid_body_sim.view.recorded_motion import read_motion

BODIES = ('ground', 'box', 'ball')
DT_NS = 10_000_000
TICKS = 100
WEIGHT = 8.0  # [N] on four corners of the box
HIT = 30  # [tick] the ball hits the box, once, 5 N and 0.25 mm deep
RULES = {'pairs': [{'bodies': ['box', 'ball'], 'friction': 0.1}], 'ignore': [['ground', 'ball']]}
SCENE = b"""version: 1
name: made_up
dt: 0.01
gravity: [0, 0, -4]
contact: {mode: timestep}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - {name: box, mass: 2, shape: {type: box, size: [1, 1, 1]}}
  - {name: ball, mass: 1, shape: {type: sphere, radius: 1}}
"""


def contacts_of(tick):
    """
    The box rests on four corners; at one tick the ball hits it.
    """
    corners = [(x, y, 0.0) for x in (0, 1) for y in (0, 1)]
    hit = [(1, 2)] if tick == HIT else []
    count = 4 + len(hit)
    force = np.tile((0.0, 0.0, WEIGHT / 4), (count, 1))
    force[4:] = (3.0, 0.0, 4.0)
    return {
        'bodies': np.array([(0, 1)] * 4 + hit),
        'point': np.array(corners + [(0.5, 0.5, 1.0)] * len(hit)),
        'normal': np.tile((0.0, 0.0, 1.0), (count, 1)),
        'gap': np.array([-1e-6] * 4 + [-2.5e-4] * len(hit)),
        'force': force,
    }


@pytest.fixture
def record(tmp_path):
    """
    Record bodies at rest, with or without their contacts.
    """

    def make(*, contacts=True, mode='timestep', name='run'):
        states = StatePacker(BODIES, dt_ns=DT_NS)
        touching = ContactPacker(
            BODIES,
            movable=(False, True, True),
            dt_ns=DT_NS,
            first_channel_id=1 + len(states.topics),
        )
        writer = BagWriter(
            tmp_path / name,
            topics=[*states.topics, *(touching.topics if contacts else ())],
            manifest={'contact': json.dumps({**RULES, 'mode': mode}), 'dt_ns': str(DT_NS)},
            attachments={'scene.yaml': SCENE.replace(b'timestep', mode.encode())},
        )
        rest = {key: np.zeros((3, 3)) for key in ('position', 'velocity', 'angular_velocity')}
        rest |= {key: np.zeros((3, 3)) for key in ('force', 'torque')}
        rest['orientation'] = np.tile((0.0, 0.0, 0.0, 1.0), (3, 1))
        for tick in range(1, TICKS + 1):
            batch = states.pack(tick, **rest)
            packed = touching.pack(tick, **contacts_of(tick)) if contacts else None
            before, after = states.split(batch)
            for part in (before, packed, after) if packed is not None else (batch,):
                writer.write(part)
        writer.close({})
        return tmp_path / name

    return make


def info(path, *words):
    parser = argparse.ArgumentParser()
    bag_verb.add_arguments(parser)
    return bag_verb.run(parser.parse_args(['info', str(path), *words]))


def drawn_texts(path):
    """
    Everything written in the picture of a bag, and the figure.
    """
    figure = picture(read_motion(Bag(path), samples=50), None, title='run')
    figure.canvas.draw()
    found = figure.findobj(lambda artist: hasattr(artist, 'get_text'))
    return figure, '\n'.join(artist.get_text() for artist in found)


def test_info_counts_contacts_and_finds_the_extremes(record, capsys):
    path = record()
    assert info(path, '--json') == 0
    facts = json.loads(capsys.readouterr().out)['contacts']
    # four of the box in each message, one more of box and of ball at the hit, and the empty
    # message with which the ball let go
    assert (facts['messages'], facts['contacts']) == (TICKS + 2, 4 * TICKS + 2)
    assert facts['largest_force'] == {'value': 5.0, 'body': 'box', 'time': HIT * 0.01}
    assert facts['deepest_gap'] == {'value': -2.5e-4, 'body': 'box', 'time': HIT * 0.01}
    info(path)
    text = capsys.readouterr().out
    assert '402 in 102 messages' in text
    assert '5 N on box at 0.3 s' in text and '-0.00025 m on box at 0.3 s' in text


def test_info_says_how_to_record_contacts_where_there_could_be_some(record, capsys):
    info(record(contacts=False))
    assert 'contacts:   not recorded; simulate --contacts' in capsys.readouterr().out
    info(record(contacts=False, mode='none', name='free'))
    assert 'contacts' not in capsys.readouterr().out


def test_a_bag_of_another_recorder_has_no_contacts_of_ours(record, tmp_path):
    writer = BagWriter(
        tmp_path / 'foreign', topics=Bag(record()).topics.values(), manifest={}, attachments={}
    )
    writer.close({})
    assert summarise(Bag(tmp_path / 'foreign')) is None


def test_the_picture_draws_what_each_body_carries(record):
    figure, said = drawn_texts(record())
    assert 'contact force [N]' in said
    (axes,) = [axes for axes in figure.axes if 'contact' in axes.get_ylabel()]
    loads = {float(line.get_ydata().max()): len(line.get_xdata()) for line in axes.lines}
    # box: its weight, and at the hit 5 N more, which thinning keeps; ball: the hit, then nothing
    assert loads == {WEIGHT + 5.0: 50, 5.0: 2}


def test_the_picture_says_how_to_record_contacts(record):
    _, said = drawn_texts(record(contacts=False))
    assert 'ontacts were not recorded' in said and 'simulate --contacts' in said
    _, said = drawn_texts(record(contacts=False, mode='none', name='free'))
    assert 'contact' not in said


def test_view_draws_a_scene_with_contact(record, tmp_path):
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    output = tmp_path / 'run.png'
    assert view.run(parser.parse_args([str(record()), '-o', str(output)])) == 0
    assert output.stat().st_size > 10_000
