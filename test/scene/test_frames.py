# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Frames of a body in a scene and in records: names that mean one thing, and numbers."""

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Body, Frame, Scene
from rigid_body_sim.physics.model.shapes import Box
from rigid_body_sim.runs.commands import Command, CommandRules

BOX = {'name': 'box', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'mass': 1.0}
BALL = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}


def scene(frames, **more):
    return load_scene({'dt': 0.001, 'bodies': [BOX | {'frames': frames} | more, BALL]})


def test_frames_are_read_and_their_attitude_is_scaled():
    read = scene({'a': {'position': [1, 2, 3], 'orientation': [0, 0, 3, 4]}, 'b': None})
    assert read.bodies[0].frames == {
        'a': Frame((1.0, 2.0, 3.0), (0.0, 0.0, 0.6, 0.8)),
        'b': Frame(),
    }
    assert read.bodies[1].frames == {}


def test_copies_have_the_frames_of_the_body():
    copies = scene(
        {'a': {'position': [1, 0, 0]}}, repeat={'count': [2, 1, 1], 'spacing': [2, 0, 0]}
    )
    assert [body.frames for body in copies.bodies[:2]] == [{'a': Frame((1.0, 0.0, 0.0))}] * 2
    rules = CommandRules(copies)
    assert rules.refusal(Command('box_2', 'force', (1, 0, 0), frame_id='a')) is None
    assert 'fixed to' in rules.refusal(Command('box_2', 'force', frame_id='box_1/a'))


@pytest.mark.parametrize(
    ('frames', 'where'),
    [
        ({'box': {}}, r"bodies\[0\].frames.box: 'box' is the name of a body"),
        ({'ball': {}}, r"frames.ball: 'ball' is the name of a body"),
        ({'world': {}}, r"frames: 'world' is a reserved name"),
        ({'body': {}}, r"frames.body: 'body' means other axes"),
        ({'left thruster': {}}, 'a frame name is a letter'),
        ({'a__b': {}}, 'a frame name is a letter'),
        ({'a/b': {}}, 'a frame name is a letter'),
        ({3: {}}, 'got 3; a frame name'),
        ({'a' * 101: {}}, '101 letters'),
        ({'a': 'here'}, 'frames.a: .*a mapping such as'),
        ({'a': {'positon': [0, 0, 0]}}, "did you mean 'position'"),
        ({'a': {'position': [0, 0]}}, 'frames.a.position: .*3 numbers'),
        ({'a': {'position': [0, 0, '.inf']}}, 'frames.a.position'),
        ({'a': {'orientation': [0, 0, 0, 0]}}, 'frames.a.orientation: .*zero length'),
        (['a'], 'frames: .*a mapping such as'),
    ],
)
def test_a_frame_that_says_nothing_clear_is_refused_where_it_stands(frames, where):
    with pytest.raises(UserError, match=where):
        scene(frames)


def test_a_point_mass_has_no_frames():
    with pytest.raises(UserError, match=r"bodies\[0\].frames: 'ball' is a point mass"):
        load_scene({'dt': 0.001, 'bodies': [BALL | {'frames': {'a': {}}}]})


@pytest.mark.parametrize(
    ('frames', 'where'),
    [
        ({'b': Frame()}, r'bodies\[0\].frames.b: .*name of a body'),
        ({'x y': Frame()}, r'bodies\[0\].frames: .*frame name'),
        ({'a': (0, 0, 0)}, r'bodies\[0\].frames.a: .*a Frame is needed'),
        ({'a': Frame(position=(0, 'x', 0))}, r'bodies\[0\].frames.a.position'),  # type: ignore[arg-type]
        ([Frame()], r'bodies\[0\].frames: .*mapping'),
    ],
)
def test_a_record_is_held_to_what_a_file_may_say(frames, where):
    box = load_scene({'dt': 0.001, 'bodies': [BOX]}).bodies[0]
    body = Body('b', Box((1.0, 1.0, 1.0)), 1.0, inertia=box.inertia, frames=frames)
    with pytest.raises(InvalidModel, match=where):
        Simulation(Scene('s', 1_000_000, (body,)))


def test_a_name_that_is_also_the_world_frame_of_a_run_is_ambiguous():
    read = scene({'map': {}, 'tip': {}})
    rules = CommandRules(read, world_frame='map')
    assert 'both the world frame and a frame' in rules.refusal(
        Command('box', 'force', frame_id='map')
    )
    for name, means in (('', 'world'), ('box', 'body'), ('box/map', 'map'), ('tip', 'tip')):
        command = Command('box', 'force', (1, 0, 0), frame_id=name)
        assert rules.refusal(command) is None and rules.frame(command) == means


def test_frames_of_others_and_of_nobody_are_told_apart():
    two = load_scene(
        {'dt': 0.001, 'bodies': [BOX | {'frames': {'a': {}}}, BOX | {'name': 'crate'}, BALL]}
    )
    rules = CommandRules(two)
    for name in ('box/a', 'a', 'box'):
        refusal = rules.refusal(Command('crate', 'wrench', frame_id=name))
        assert "fixed to 'box'; allowed: '', 'world', 'crate'" in refusal
    assert rules.refusal(Command('box', 'wrench', frame_id='box/b')).endswith(
        "in frame 'box/b'; allowed: '', 'world', 'box', 'box/a'"
    )
    assert 'point mass' in rules.refusal(Command('ball', 'force', frame_id='ball'))
