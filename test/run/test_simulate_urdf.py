# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A URDF file is run as it is, and its bag needs none of the files it was made from."""

import shutil

import pytest

from rigid_body_sim.recording.bag_reader import Bag

URDF = """<robot name="toy"><link name="base">
<inertial><origin xyz="0 0 0.1"/><mass value="2"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
<collision><geometry><mesh filename="meshes/corner.off" scale="0.1"/></geometry></collision>
</link></robot>"""
TETRAHEDRON = 'OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n'


@pytest.fixture
def robot(tmp_path):
    """Write a URDF file with its mesh."""
    folder = tmp_path / 'robot'
    (folder / 'meshes').mkdir(parents=True)
    (folder / 'meshes' / 'corner.off').write_text(TETRAHEDRON)
    (folder / 'toy.urdf').write_text(URDF)
    return folder / 'toy.urdf'


def test_a_urdf_file_falls_and_replays_without_its_files(verb, as_json, robot, tmp_path):
    bag = tmp_path / 'run'
    code, result = as_json('simulate', robot, '-o', bag, '--duration', '0.5')
    assert (code, result['scene'], result['bodies'], result['dt']) == (0, 'toy', 1, 0.001)
    assert sorted(Bag(bag).attachments) == [
        'meshes/corner.off',
        'scene.yaml',
        'start_state.bin',
        'toy.urdf',
    ]
    shutil.rmtree(robot.parent)
    code, replayed = as_json('replay', bag)
    assert (code, replayed['identical']) == (0, True)


def test_a_link_of_several_collisions_lies_on_the_ground_and_replays(
    verb, as_json, robot, tmp_path
):
    ball = (
        '<collision><origin xyz="0.2 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>'
    )
    robot.write_text(URDF.replace('</link>', ball + '</link>'))
    scene = robot.parent / 'scene.yaml'
    scene.write_text(
        'dt: 0.004\ngravity: [0, 0, -9.81]\ncontact: {mode: timestep}\nbodies:\n'
        '  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}, friction: 0.5}\n'
        '  - {name: toy, urdf: toy.urdf, friction: 0.5, initial: {position: [0, 0, 0.3]}}\n'
    )
    bag = tmp_path / 'run'
    code, _ = as_json('simulate', scene, '-o', bag, '--duration', '1', '--contacts')
    assert code == 0
    shutil.rmtree(robot.parent)
    code, replayed = as_json('replay', bag)
    assert (code, replayed['identical']) == (0, True)


def test_what_is_assumed_around_a_urdf_file_is_said(verb, robot, tmp_path):
    code, out, _ = verb('simulate', robot, '-o', tmp_path / 'run', '--duration', '0.01')
    assert code == 0
    assert 'the body base alone, dt 0.001 s, gravity (0, 0, -9.81) m/s^2, no contact' in out


def test_contacts_of_bodies_that_pass_through_each_other_are_refused(verb, robot, tmp_path):
    code, _, err = verb('simulate', robot, '-o', tmp_path / 'run', '--contacts')
    assert code == 2 and not (tmp_path / 'run').exists()
    assert "contacts of the scene 'toy': asked for, but its bodies do not meet" in err
