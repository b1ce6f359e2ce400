# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A URDF link of several collisions is a body of several parts, each where its origin says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.contact.collision import pose as pose_record
from rigid_body_sim.physics.contact.collision.collider import Colliders
from rigid_body_sim.physics.contact.collision.convexity_defect import convexity_warnings
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hulls import hull
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.shapes import Box, Cylinder, Mesh, Sphere, Union
from rigid_body_sim.physics.model.volume_integrals import volume_integrals
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.scene import files
from rigid_body_sim.scene.files import mesh_from_bytes

INERTIAL = """<inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="2.5"/>
<inertia ixx="0.03" ixy="0.001" ixz="-0.002" iyy="0.04" iyz="0.003" izz="0.05"/></inertial>"""
PLAIN = INERTIAL.format(xyz='0.1 0.2 0.3', rpy='0 0 0')
TETRAHEDRON = b'OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n'
DENTED = b"""OFF
5 6 9
0 0 0
1 0 0
0 1 0
0 0 1
0.1 0.1 0.1
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 4
3 2 3 4
3 3 1 4
"""
GROUND = {
    'name': 'ground',
    'shape': {'type': 'plane', 'normal': [0, 0, 1]},
    'friction': 0.5,
}
# a stool: the seat and four legs, (size, place)
STOOL = (
    ((0.4, 0.4, 0.05), (0.0, 0.0, 0.2)),
    *(((0.05, 0.05, 0.4), (x, y, 0.0)) for x in (-0.15, 0.15) for y in (-0.15, 0.15)),
)


def words(*numbers: float) -> str:
    """Write numbers as URDF does, every digit."""
    return ' '.join(repr(float(number)) for number in numbers)


def collision(geometry: str, *, xyz: str = '0 0 0', rpy: str = '0 0 0') -> str:
    """Write one collision."""
    return (
        f'<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{geometry}</geometry></collision>'
    )


def scene_of(link: str, *others: dict[str, Any], **keys: Any) -> Scene:
    """Return a scene of a URDF link in contact with others."""
    text = f'<robot name="toy"><link name="base">{link}</link></robot>'
    return load_scene(
        surroundings({'name': 'toy', 'urdf': 'toy.urdf', **keys}, *others),
        files={'toy.urdf': text.encode(), 'corner.off': TETRAHEDRON, 'dented.off': DENTED},
    )


def surroundings(*bodies: dict[str, Any]) -> dict[str, Any]:
    """Write a scene in which bodies meet."""
    return {
        'dt': 0.004,
        'gravity': [0, 0, -9.81],
        'contact': {'mode': 'timestep'},
        'bodies': list(bodies),
    }


def poses(scene: Scene) -> NDArray[np.float64]:
    """Return origin (3) and axes (9, row by row) of each shape in the world at the start."""
    return Colliders.of(scene, Layout(scene)).poses.reshape(-1, pose_record.SIZE)


def test_a_link_of_boxes_rests_bit_for_bit_as_the_union_written_in_a_scene() -> None:
    link = INERTIAL.format(xyz='0.01 0.02 0.08', rpy='0 0 0') + ''.join(
        collision(f'<box size="{words(*size)}"/>', xyz=words(*place)) for size, place in STOOL
    )
    moments = {'ixx': 0.03, 'ixy': 0.001, 'ixz': -0.002, 'iyy': 0.04, 'iyz': 0.003, 'izz': 0.05}
    about = {
        'friction': 0.5,
        'initial': {'position': [0, 0, 0.4], 'orientation': [0.05, 0.1, 0, 1]},
    }
    parts = [
        {'shape': {'type': 'box', 'size': list(size)}, 'position': list(place), 'mass': 0.5}
        for size, place in STOOL
    ]
    written = {'name': 'toy', 'shape': {'type': 'union', 'parts': parts}, 'inertia': moments}
    written |= {'center_of_mass': [0.01, 0.02, 0.08], **about}
    states = []
    for scene in (scene_of(link, GROUND, **about), load_scene(surroundings(written, GROUND))):
        simulation = Simulation(scene)
        simulation.step(500)
        states.append(simulation.state_bytes())
        # it stands on its legs: 0.2 m from their ends to the origin of the link, which is 0.08 m
        # below the centre of mass; 1e-3 m: the overlap that the contacts keep
        assert simulation.state.position[0, 2] == pytest.approx(0.28, abs=1e-3)
        assert np.abs(simulation.state.velocity).max() < 1e-3
    assert states[0] == states[1]


PLACES = st.tuples(*[st.floats(-2.0, 2.0)] * 3)  # [m]
ANGLES = st.tuples(st.floats(-3.2, 3.2), st.floats(-1.6, 1.6), st.floats(-3.2, 3.2))  # [rad]
SHAPES = st.sampled_from(
    (
        '<box size="1 2 3"/>',
        '<sphere radius="0.5"/>',
        '<cylinder radius="0.1" length="0.4"/>',
        '<mesh filename="corner.off" scale="0.5 -1 2"/>',
    )
)


@settings(max_examples=60)
@given(
    link=st.tuples(PLACES, ANGLES),
    inertial=st.tuples(PLACES, ANGLES),
    collisions=st.lists(st.tuples(SHAPES, PLACES, ANGLES), min_size=1, max_size=4),
)
def test_each_collision_lies_in_the_link_whatever_the_inertial_frame(
    link: tuple[Any, Any], inertial: tuple[Any, Any], collisions: list[Any]
) -> None:
    # x = r + R (o_k - c), axes R R_k: r, R of the link's centre of mass c; o_k, R_k the origin
    (r, turn), (center, of_inertial) = link, inertial
    text = INERTIAL.format(xyz=words(*center), rpy=words(*of_inertial))
    for geometry, place, angles in collisions:
        text += collision(geometry, xyz=words(*place), rpy=words(*angles))
    axes = Rotation.from_euler('xyz', turn)
    initial = {'position': list(r), 'orientation': axes.as_quat().tolist()}
    scene = scene_of(text, initial=initial)
    assert isinstance(scene.bodies[0].shape, Union) == (len(collisions) > 1)
    colliders = Colliders.of(scene, Layout(scene))
    assert len(colliders) == len(collisions)
    # the same from the state of the core, as every tick does it: R(q) M and r - R c
    core = axes.as_matrix() @ rotation.matrix_from_quaternion(Layout(scene).principal[0])
    mounts = colliders.local_poses.reshape(-1, pose_record.SIZE)
    for (_, place, angles), found, mount in zip(collisions, poses(scene), mounts, strict=True):
        turned = (axes * Rotation.from_euler('xyz', angles)).as_matrix()
        origin = np.array(r) + axes.apply(np.subtract(place, center))
        # round-off of products of rotations near 1 and of lengths below 10 m
        assert found[3:].reshape(3, 3) == pytest.approx(turned, abs=5e-15)
        assert found[:3] == pytest.approx(origin, abs=5e-14)
        moving = core @ mount[3:].reshape(3, 3)
        assert moving == pytest.approx(turned, abs=5e-15)
        assert np.array(r) - moving @ mount[:3] == pytest.approx(origin, abs=5e-14)


def test_the_parts_of_a_link_weigh_nothing_by_themselves() -> None:
    link = PLAIN + collision('<box size="1 2 3"/>') * 3  # a box of water: 6000 kg each
    body = scene_of(link).bodies[0]
    alone = scene_of(PLAIN).bodies[0]
    assert (body.mass, body.center_of_mass) == (2.5, (0.1, 0.2, 0.3))
    assert np.array_equal(body.inertia, alone.inertia)


def test_primitives_and_meshes_of_a_link_join_in_the_order_of_the_file() -> None:
    body = scene_of(
        PLAIN
        + collision('<sphere radius="0.2"/>')
        + collision('<mesh filename="corner.off" scale="2 3 0.5"/>', xyz='0 0 1')
        + collision('<mesh filename="corner.off" scale="-1 1 1"/>')
        + collision('<cylinder radius="0.1" length="0.3"/>', rpy='1.2 0 -0.4')
    ).bodies[0]
    assert isinstance(body.shape, Union)
    ball, stretched, mirrored, rod = (part.shape for part in body.shape.parts)
    assert (ball, rod) == (Sphere(0.2), Cylinder(0.1, 0.3))
    for shape, factors in ((stretched, (2, 3, 0.5)), (mirrored, (-1, 1, 1))):
        assert isinstance(shape, Mesh)
        volume, center, _ = volume_integrals(shape.vertices, shape.faces)
        # outside stays out: a volume below zero would say that the triangles were turned in
        assert volume == pytest.approx(abs(np.prod(factors)) / 6, rel=1e-15)
        assert center == pytest.approx(np.array(factors) / 4, rel=1e-15)
    assert body.shape.parts[1].position == (0.0, 0.0, 1.0)
    assert (body.shape_position, body.shape_orientation) == ((0.0, 0.0, 0.0), rotation.IDENTITY)


def test_one_collision_is_no_union() -> None:
    body = scene_of(PLAIN + collision('<box size="1 2 3"/>', xyz='0 0 1')).bodies[0]
    assert (body.shape, body.shape_position) == (Box((1.0, 2.0, 3.0)), (0.0, 0.0, 1.0))


def test_a_mesh_in_several_collisions_is_warned_of_once_for_each_body() -> None:
    link = PLAIN + collision('<mesh filename="dented.off"/>') * 3
    scene = scene_of(link, repeat={'count': [3, 1, 1], 'spacing': [4, 0, 0]})
    (warning,) = convexity_warnings(scene)
    assert warning.startswith("'toy_1' collides as the convex hull of its mesh 'dented.off'")
    assert warning.endswith('(2 bodies more)')


def test_a_mesh_that_many_collisions_name_is_read_and_its_hull_found_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    read: list[str] = []
    found: list[str] = []

    def reading(text: bytes, *, name: str) -> Mesh:
        read.append(name)
        return mesh_from_bytes(text, name=name)

    def finding(points: NDArray[np.float64], *, name: str) -> hulls.Polyhedron:
        found.append(name)
        return hull(points, name=name)

    monkeypatch.setattr(files, 'mesh_from_bytes', reading)
    monkeypatch.setattr(hulls, 'hull', finding)
    link = PLAIN + collision('<mesh filename="dented.off"/>') * 3
    link += collision('<mesh filename="dented.off" scale="2 2 2"/>') * 2
    written = {'name': 'stone', 'shape': {'type': 'mesh', 'file': 'dented.off'}, 'mass': 1}
    scene = scene_of(link, written, repeat={'count': [3, 1, 1], 'spacing': [4, 0, 0]})
    assert len(Colliders.of(scene, Layout(scene))) == 3 * 5 + 1
    assert len(convexity_warnings(scene)) > 0
    assert read == ['dented.off']
    assert found == ["mesh 'dented.off'"] * 2  # as it is, and twice as large


def test_a_fixed_link_without_inertial_has_the_center_of_its_volume() -> None:
    link = collision('<box size="1 1 1"/>', xyz='1 0 0') + collision('<box size="1 1 3"/>')
    assert scene_of(link, fixed=True).bodies[0].center_of_mass == pytest.approx((0.25, 0.0, 0.0))


GOOD = collision('<box size="1 1 1"/>')
NAMED = '<collision name="arm"><geometry>{}</geometry></collision>'


@pytest.mark.parametrize(
    ('wrong', 'reason'),
    [
        (
            NAMED.format('<box size="1 2 0"/>'),
            "<collision name='arm'> (line 4): size along z is 0.0 m; it must be positive",
        ),
        (
            NAMED.format('<mesh filename="gone.off"/>'),
            "<collision name='arm'> (line 4): 'gone.off' is not among the given files",
        ),
        (
            NAMED.format('<mesh filename="corner.off" scale="1 0 1"/>'),
            "<collision name='arm'> (line 4): <mesh> scale (1.0, 0.0, 1.0); no factor may be zero",
        ),
        (
            NAMED.format('<box size="1 2 3"/><sphere radius="1"/>'),
            '<collision> (line 4) needs one <geometry> with one shape (box, cylinder, sphere, '
            'mesh); a further shape is a further <collision>',
        ),
        ('<collision/>', '<collision> (line 4) needs one <geometry>'),
        (
            NAMED.format('<capsule radius="1" length="1"/>'),
            '<capsule> (line 4): capsules are not supported in URDF; describe the body in a scene',
        ),
    ],
)
def test_a_bad_collision_among_good_ones_is_named(wrong: str, reason: str) -> None:
    with pytest.raises(UserError) as caught:
        scene_of(f'{PLAIN}\n{GOOD}\n{wrong}\n{GOOD}')
    assert reason in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_body_of_several_collisions_needs_none_of_its_files_again(tmp_path: Path) -> None:
    link = PLAIN + GOOD + collision('<mesh filename="corner.off"/>')
    (tmp_path / 'corner.off').write_bytes(TETRAHEDRON)
    (tmp_path / 'toy.urdf').write_text(
        f'<robot name="toy"><link name="base">{link}</link></robot>'
    )
    scene = load_scene(tmp_path / 'toy.urdf')
    assert sorted(scene.files) == ['corner.off', 'toy.urdf']
    again = load_scene(scene.source, files=scene.files)
    assert np.array_equal(poses(scene), poses(again))
