# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A URDF file of one link is a body: what it says is taken as written, or refused by name."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.contact.collision.collider import Colliders
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Box, Cylinder, Mesh, Sphere
from rigid_body_sim.physics.model.volume_integrals import volume_integrals
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.scene import load_scene

ROUND_OFF = 1e-15  # [-] relative: a product of three matrices
INERTIAL = """<inertial><origin xyz="0.1 0.2 0.3" rpy="{rpy}"/><mass value="2.5"/>
<inertia ixx="0.03" ixy="0.001" ixz="-0.002" iyy="0.04" iyz="0.003" izz="0.05"/></inertial>"""
TENSOR = np.array([[0.03, 0.001, -0.002], [0.001, 0.04, 0.003], [-0.002, 0.003, 0.05]])
PLAIN = INERTIAL.format(rpy='0 0 0')
TETRAHEDRON = b"""OFF
4 4 6
0 0 0
1 0 0
0 1 0
0 0 1
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
"""


def urdf(link: str, *, beside: str = '') -> str:
    """Return a URDF text of one link."""
    return (
        f'<?xml version="1.0"?>\n<robot name="toy"><link name="base">{link}</link>{beside}</robot>'
    )


def write(folder: Path, text: str) -> Path:
    """Write a URDF file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / 'toy.urdf'
    path.write_text(text)
    return path


def read(folder: Path, link: str, **keys: Any) -> Body:
    """Return the body of a scene that names a URDF file of one link."""
    write(folder, urdf(link))
    scene = folder / 'scene.yaml'
    keys = {'name': 'toy', 'urdf': 'toy.urdf', **keys}
    scene.write_text(f'dt: 0.001\nbodies:\n  - {keys!r}\n')
    return load_scene(scene).bodies[0]


def collision(geometry: str, origin: str = '') -> str:
    """Return a link with mass and one collision."""
    return f'{PLAIN}<collision>{origin}<geometry>{geometry}</geometry></collision>'


def refusal(folder: Path, text: str) -> str:
    """Return the one line with which a URDF file is refused."""
    with pytest.raises(UserError) as caught:
        load_scene(write(folder, text))
    assert '\n' not in str(caught.value)
    assert str(caught.value).startswith(str(folder / 'toy.urdf'))
    return str(caught.value)


# ------ what is read


def test_mass_and_inertia_are_taken_bit_for_bit_as_written(tmp_path: Path) -> None:
    body = read(tmp_path, collision('<box size="1 2 3"/>'))  # a box of that size: 32 times as much
    assert body.mass == 2.5
    assert body.center_of_mass == (0.1, 0.2, 0.3)
    assert np.array_equal(body.inertia, TENSOR)


@pytest.mark.parametrize('angles', ((0.3, 0.0, 0.0), (0.0, -0.7, 0.0), (0.5, 1.1, -2.0)))
def test_the_inertia_frame_is_turned_into_the_link(
    tmp_path: Path, angles: tuple[float, float, float]
) -> None:
    body = read(tmp_path, INERTIAL.format(rpy=' '.join(map(str, angles))))
    r = Rotation.from_euler('xyz', angles).as_matrix()  # roll, pitch, yaw about fixed axes
    assert body.inertia == pytest.approx(r @ TENSOR @ r.T, abs=ROUND_OFF)
    assert body.center_of_mass == (0.1, 0.2, 0.3)  # its place does not turn
    assert body.shape is None


def test_primitives_and_their_places_are_read(tmp_path: Path) -> None:
    origin = '<origin xyz="0 0 0.5" rpy="1.2 0 -0.4"/>'
    body = read(tmp_path, collision('<cylinder radius="0.1" length="0.3"/>', origin))
    assert body.shape == Cylinder(0.1, 0.3)
    assert body.shape_position == (0.0, 0.0, 0.5)
    expected = Rotation.from_euler('xyz', (1.2, 0.0, -0.4)).as_matrix()
    turned = rotation.matrix_from_quaternion(np.array(body.shape_orientation))
    assert turned == pytest.approx(expected, abs=ROUND_OFF)
    body = read(tmp_path, collision('<box size="1 2 3"/>'))
    assert (body.shape, body.shape_position) == (Box((1.0, 2.0, 3.0)), (0.0, 0.0, 0.0))
    assert body.shape_orientation == rotation.IDENTITY
    assert read(tmp_path, collision('<sphere radius="0.2"/>')).shape == Sphere(0.2)


@pytest.mark.parametrize('scale', ('2', '2 3 0.5', '-1 1 1'))
def test_a_mesh_is_scaled_and_a_mirror_image_keeps_its_outside(tmp_path: Path, scale: str) -> None:
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / 'corner.off').write_bytes(TETRAHEDRON)
    body = read(tmp_path, collision(f'<mesh filename="meshes/corner.off" scale="{scale}"/>'))
    assert isinstance(body.shape, Mesh)
    factors = np.ones(3) * [float(word) for word in scale.split()]
    volume, center, _ = volume_integrals(body.shape.vertices, body.shape.faces)
    assert volume == pytest.approx(abs(np.prod(factors)) / 6, rel=1e-15)
    assert center == pytest.approx(factors / 4, rel=1e-15)


@pytest.mark.parametrize('place', ('beside', 'itself', 'workspace'))
def test_package_paths_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    package = {
        'beside': tmp_path / 'robots',
        'itself': tmp_path / 'robots',
        'workspace': tmp_path / 'install' / 'share' / 'robots',
    }[place]
    (package / 'meshes').mkdir(parents=True)
    (package / 'meshes' / 'corner.off').write_bytes(TETRAHEDRON)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path / 'install'))
    folder = {'beside': tmp_path / 'scenes', 'itself': package / 'urdf'}.get(place, tmp_path)
    mesh = 'package://robots/meshes/corner.off'
    body = read(folder, collision(f'<mesh filename="{mesh}"/>'))
    assert isinstance(body.shape, Mesh) and body.shape.name == mesh


def test_a_urdf_file_alone_is_a_scene(tmp_path: Path) -> None:
    path = write(tmp_path, urdf(PLAIN))
    scene = load_scene(path)
    assert (scene.name, scene.bodies[0].name) == ('toy', 'base')
    assert (scene.dt_ns, scene.gravity) == (1_000_000, (0.0, 0.0, -9.81))
    assert scene.contact == {'mode': 'none'}
    again = load_scene(scene.source, files=scene.files)
    assert again.source == scene.source and again.files == {'toy.urdf': path.read_bytes()}


def test_the_files_it_names_are_kept_so_that_nothing_else_is_needed(tmp_path: Path) -> None:
    (tmp_path / 'robots' / 'meshes').mkdir(parents=True)
    (tmp_path / 'robots' / 'meshes' / 'corner.off').write_bytes(TETRAHEDRON)
    write(tmp_path / 'robots', urdf(collision('<mesh filename="meshes/corner.off"/>')))
    body = {'name': 'toy', 'urdf': 'robots/toy.urdf', 'friction': 0.25}
    (tmp_path / 'scene.yaml').write_text(f'dt: 0.001\nbodies: [{body!r}]\n')
    scene = load_scene(tmp_path / 'scene.yaml')
    assert sorted(scene.files) == ['robots/meshes/corner.off', 'robots/toy.urdf']
    again = load_scene(scene.source, files=scene.files).bodies[0]
    assert np.array_equal(again.inertia, TENSOR) and again.material.friction == 0.25
    assert isinstance(again.shape, Mesh)


def test_it_moves_bit_for_bit_as_the_same_body_written_in_a_scene(tmp_path: Path) -> None:
    body = read(tmp_path, PLAIN, initial={'angular_velocity_body': [1, 2, 3]})
    moments = dict(zip(('ixx', 'iyy', 'izz'), np.diag(TENSOR).tolist()))
    products = {'ixy': 0.001, 'ixz': -0.002, 'iyz': 0.003}
    written = {
        'name': 'toy',
        'mass': 2.5,
        'inertia': moments | products,
        'center_of_mass': [0.1, 0.2, 0.3],
        'initial': {'angular_velocity_body': [1, 2, 3]},
    }
    states = []
    for source in (tmp_path / 'scene.yaml', {'dt': 0.001, 'bodies': [written]}):
        simulation = Simulation(load_scene(source))
        simulation.step(100)
        states.append(simulation.state_bytes())
    assert body.mass == 2.5 and states[0] == states[1]


def test_the_collision_shape_lies_where_the_link_says(tmp_path: Path) -> None:
    origin = '<origin xyz="0.4 -0.1 0.2" rpy="0.3 0.5 -0.8"/>'
    write(tmp_path, urdf(collision('<box size="1 2 3"/>', origin)))
    q = Rotation.from_euler('xyz', (0.7, -0.2, 1.9)).as_quat().tolist()
    body = {'name': 'toy', 'urdf': 'toy.urdf', 'initial': {'position': [3, 4, 5]}}
    body['initial']['orientation'] = q
    (tmp_path / 'scene.yaml').write_text(f'dt: 0.001\nbodies: [{body!r}]\n')
    scene = load_scene(tmp_path / 'scene.yaml')
    layout = Layout(scene)
    colliders = Colliders.of(scene, layout)
    link = Rotation.from_quat(q).as_matrix()
    turned = link @ Rotation.from_euler('xyz', (0.3, 0.5, -0.8)).as_matrix()
    place = np.array((3, 4, 5)) + link @ (np.array((0.4, -0.1, 0.2)) - (0.1, 0.2, 0.3))
    assert colliders.poses[3:] == pytest.approx(turned.ravel(), abs=ROUND_OFF)
    assert colliders.poses[:3] == pytest.approx(place, abs=1e-14)  # of lengths near 10 m
    # the same from the state of the core, as every tick does it: R(q) M and r - R c
    axes = rotation.matrix_from_quaternion(
        rotation.multiply(scene.bodies[0].initial.orientation, layout.principal[0])
    )
    moving = axes @ colliders.local_poses[3:].reshape(3, 3)
    assert moving == pytest.approx(turned, abs=2 * ROUND_OFF)
    assert (3, 4, 5) - moving @ colliders.local_poses[:3] == pytest.approx(place, abs=1e-14)


def test_a_fixed_body_needs_no_inertial(tmp_path: Path) -> None:
    bare = '<collision><origin xyz="1 0 0"/><geometry><sphere radius="1"/></geometry></collision>'
    body = read(tmp_path, bare, fixed=True)
    assert (body.mass, body.fixed, body.center_of_mass) == (0.0, True, (1.0, 0.0, 0.0))


# ------ what is refused

JOINT = '<link name="arm"/><joint name="elbow" type="fixed"><parent link="base"/></joint>'
REFUSED = (
    ('<robot', 'not readable as XML'),
    ('<model/>', '<model> where <robot> should stand'),
    ('<robot name="toy"/>', '<link> is missing'),
    (
        urdf(PLAIN, beside=JOINT),
        "<robot> (line 2) has 2 <link> ('base', 'arm'); one is supported: a body is one link; ",
    ),
    (urdf(PLAIN, beside='<joint name="elbow"/>'), '<joint> (line 3): joints are not supported'),
    (urdf(PLAIN, beside='<gazebo><mu1>1</mu1></gazebo>'), '<gazebo> (line 3): settings for'),
    (urdf(PLAIN * 2), '<link> (line 2) has 2 <inertial>; one is supported: a link has one mass'),
    (urdf(collision('<capsule radius="1" length="1"/>')), '<capsule> (line 3): capsules are not'),
    (urdf(collision('<cone radius="1"/>')), '<cone> (line 3): is not supported in <geometry>'),
    (urdf(PLAIN + '<collision/>'), '<collision> (line 3) needs one <geometry>'),
    (urdf(''), 'has no <inertial>, and none is made up'),
    (urdf('<inertial><mass value="1"/></inertial>'), '<inertial> has no <inertia>'),
    (urdf(PLAIN.replace(' iyy="0.04"', '')), '<inertia> (line 3): iyy is missing'),
    (
        urdf(PLAIN.replace('"2.5"', '"0"')),
        '<inertial> (line 2): <mass> is 0.0 kg; it must be positive',
    ),
    (urdf(PLAIN.replace('"2.5"', '"nan"')), "<mass value='nan'> (line 2): a finite number needed"),
    (urdf(PLAIN.replace('"0.05"', '"0.5"')), 'break the triangle inequality'),
    (urdf(PLAIN.replace('0.1 0.2 0.3', '0.1 0.2')), '3 finite numbers needed'),
    (urdf(collision('<box size="1 2 ${w}"/>')), "<box size='1 2 ${w}'> (line 3): 3 finite"),
    (urdf(collision('<box size="1 2 0"/>')), 'size along z is 0.0 m'),
    (urdf(collision('<sphere/>')), '<sphere> (line 3): radius is missing'),
    (urdf(collision('<mesh filename="http://x/y.stl"/>')), 'http:// is not supported'),
    (urdf(collision('<mesh filename="gone.stl"/>')), "'gone.stl' cannot be read"),
    (urdf(collision('<mesh filename="package://gone/a.stl"/>')), 'is not found; looked in: '),
    (urdf(collision('<mesh filename="toy.urdf"/>')), "'toy.urdf' has no known mesh format"),
    (
        '<robot name="t" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include/></robot>',
        'xacro (line 1) is not supported; expand the file first',
    ),
    ('<!DOCTYPE a [<!ENTITY b "c">]><robot name="t"/>', 'a document type is not supported'),
    (urdf(PLAIN).replace('"base"', '"my-base"'), "<link name='my-base'> is no name for topics"),
)


@pytest.mark.parametrize(('text', 'reason'), REFUSED, ids=lambda item: item[:40])
def test_what_is_not_supported_is_named(tmp_path: Path, text: str, reason: str) -> None:
    assert reason in refusal(tmp_path, text)


@pytest.mark.parametrize(
    'key', ({'mass': 1}, {'shape': {'type': 'particle'}}, {'inertia': {}}, {'mass_rate': 1})
)
def test_a_scene_does_not_say_again_what_the_urdf_file_says(
    tmp_path: Path, key: dict[str, Any]
) -> None:
    with pytest.raises(UserError, match='the URDF file says what the body is; remove this key'):
        read(tmp_path, PLAIN, **key)


WHOLE = urdf(collision('<box size="1 2 3"/>', '<origin xyz="0 0 1" rpy="1 0 0"/>'))
WORDS = st.sampled_from(
    ('', '"', '<', '/>', '<link name="a"/>', '<origin/>', 'nan', '1e999', '-1', '0', ' ', '&a;')
)


@pytest.mark.parametrize('draws', [60, pytest.param(300, marks=pytest.mark.long)])
def test_a_urdf_with_any_slip_is_a_scene_or_one_clear_line(draws: int) -> None:
    @settings(max_examples=draws)
    @given(st.integers(0, len(WHOLE)), st.integers(0, 12), st.one_of(WORDS, st.text(max_size=6)))
    def holds(at: int, cut: int, slip: str) -> None:
        text = (WHOLE[:at] + slip + WHOLE[at + cut :]).encode(errors='surrogatepass')
        body = {'name': 'toy', 'urdf': 'toy.urdf'}
        try:
            scene = load_scene({'dt': 0.001, 'bodies': [body]}, files={'toy.urdf': text})
            Simulation(scene)
        except UserError as error:
            assert len(str(error).splitlines()) == 1, str(error)

    holds()


@given(st.binary(max_size=60))
def test_bytes_that_are_no_urdf_are_refused(text: bytes) -> None:
    with pytest.raises(UserError, match=r'^scene: bodies\[0\]\.urdf: toy\.urdf: '):
        load_scene(
            {'dt': 0.001, 'bodies': [{'name': 'toy', 'urdf': 'toy.urdf'}]},
            files={'toy.urdf': text},
        )


def test_without_its_library_the_cure_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, 'yourdfpy', None)
    assert 'is not installed; install it: pip install yourdfpy' in refusal(tmp_path, urdf(PLAIN))


def test_visuals_and_materials_move_nothing_and_are_passed_over(tmp_path: Path) -> None:
    seen = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
    assert read(tmp_path, seen + PLAIN).shape is None
