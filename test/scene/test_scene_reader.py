# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the scene reader accepts, and how it refuses: in one line, with place and cure."""

from __future__ import annotations

import copy
import io
import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.shapes import Capsule, Mesh, Particles, Plane
from rigid_body_sim.scene import load_scene

from ..patience import HANGING

ROUND_OFF = 1e-14  # [-] relative: a few dozen operations

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

EXAMPLE = b"""\
# A box tumbles freely while a spring holds a ball.
version: 1
name: two_bodies
dt: 0.001                      # s, a whole number of nanoseconds
integrator: quick              # optional
gravity: [0, 0, -9.81]
contact: {mode: none}
bodies:
  - name: box
    shape: {type: box, size: [0.4, 0.2, 0.1]}
    mass: 2.0
    initial: {position: [0, 0, 1], orientation: [0, 0, 0, 1],
              velocity: [0, 0, 0], angular_velocity: [0, 0, 1]}
  - name: ball
    shape: {type: particle}
    mass: 0.5
    initial: {position: [1, 0, 0]}
forces:
  - {type: rope, a: ball, b: world, b_point: [1, 0, 1], stiffness: 50, side: right}
  - {type: rope, a: box, b: ball, stiffness: 1e3}
"""


@dataclass(frozen=True)
class Rope:
    """A force element of this test: every kind of field that a force can have."""

    a: str = field(metadata={'kind': 'body'})
    b: str = field(metadata={'kind': 'body_or_world'})
    stiffness: float = field(metadata={'kind': 'number', 'unit': 'N/m', 'positive': True})
    b_point: tuple[float, ...] = field(
        default=(0.0, 0.0, 0.0), metadata={'kind': 'point', 'unit': 'm'}
    )
    damping: float = field(
        default=0.0, metadata={'kind': 'number', 'unit': 'N s/m', 'minimum': 0.0}
    )
    side: str = field(default='left', metadata={'kind': 'choice', 'choices': ('left', 'right')})

    def __post_init__(self) -> None:
        if self.a == self.b:
            raise InvalidModel(f'a and b are both {self.a!r}; a rope needs two ends')


@pytest.fixture(autouse=True)
def registries(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read against two small registries: the reader knows no force or integrator by name."""
    monkeypatch.setattr(
        'rigid_body_sim.physics.forces.elements.FORCES', {'rope': Rope}, raising=False
    )
    monkeypatch.setattr(
        'rigid_body_sim.physics.integration.integrators.INTEGRATORS',
        {'quick': None, 'exact': None},
        raising=False,
    )


def scene(**changes: Any) -> dict[str, Any]:
    """Return a small valid scene with some keys replaced."""
    return {'dt': 0.001, 'bodies': [body()], **changes}


def body(**changes: Any) -> dict[str, Any]:
    """Return a valid body with some keys replaced; None removes a key."""
    keys = {'name': 'box', 'shape': {'type': 'box', 'size': [1, 2, 3]}, 'mass': 12, **changes}
    return {key: value for key, value in keys.items() if value is not None}


def load_body(**changes: Any) -> Any:
    """Return the only body of a scene."""
    return load_scene(scene(bodies=[body(**changes)])).bodies[0]


def refusal(source: Any, **options: Any) -> str:
    """Return the message with which a scene is refused, after checking that it is one line."""
    with pytest.raises(UserError) as caught:
        load_scene(source, **options)
    message = str(caught.value)
    assert '\n' not in message
    return message


# ------ what is read


def test_the_example_of_the_design_is_read() -> None:
    read = load_scene(EXAMPLE)
    assert (read.name, read.dt_ns, read.integrator) == ('two_bodies', 1_000_000, 'quick')
    assert read.gravity == (0.0, 0.0, -9.81)
    assert read.contact == {'mode': 'none'}
    assert read.source == EXAMPLE
    box, ball = read.bodies
    assert box.initial.position == (0.0, 0.0, 1.0)
    assert box.initial.angular_velocity == (0.0, 0.0, 1.0)
    assert np.diag(box.inertia) == pytest.approx(
        (2 / 12 * 0.05, 2 / 12 * 0.17, 2 / 12 * 0.2), rel=ROUND_OFF
    )
    assert ball.is_point and not box.is_point
    assert read.forces == (
        Rope('ball', 'world', 50.0, b_point=(1.0, 0.0, 1.0), side='right'),
        Rope('box', 'ball', 1000.0),  # YAML 1.1 takes 1e3 for a text
    )


def test_what_is_left_out_is_the_plain_case() -> None:
    read = load_scene(scene())
    assert read.gravity == (0.0, 0.0, 0.0)
    assert read.forces == ()
    assert read.contact == {'mode': 'none'}
    assert read.bodies[0].initial.orientation == (0.0, 0.0, 0.0, 1.0)
    assert read.integrator == Scene.integrator


def test_an_empty_value_is_a_missing_one() -> None:
    assert load_scene(b'dt: 0.001\nforces:\nbodies: [{name: a, mass: 1, shape: {type: particle}}]')
    assert 'dt is missing' in refusal(b'dt:\nbodies: []')


def test_file_bytes_and_mapping_give_the_same_scene(tmp_path: Path) -> None:
    path = tmp_path / 'two.yaml'
    path.write_bytes(EXAMPLE)
    from_file, from_bytes = load_scene(path), load_scene(EXAMPLE)
    assert load_scene(str(path)).source == from_file.source == from_bytes.source
    assert from_file.forces == from_bytes.forces
    assert from_file.bodies[0].initial == from_bytes.bodies[0].initial


def test_the_source_of_a_mapping_is_the_scene_again_bit_for_bit() -> None:
    odd = (1e-7 / 3, -0.0, 1.7e140)
    first = load_scene(
        scene(bodies=[body(initial={'position': np.array(odd)}, mass=np.float64(0.1))])
    )
    again = load_scene(first.source)
    assert first.bodies[0].initial.position == odd
    assert math.copysign(1.0, first.bodies[0].initial.position[1]) == -1.0
    assert again.bodies[0].initial == first.bodies[0].initial
    assert again.bodies[0].mass == first.bodies[0].mass == 0.1
    assert np.array_equal(again.bodies[0].inertia, first.bodies[0].inertia)


def test_the_name_defaults_to_the_name_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / 'falling.yaml'
    path.write_bytes(load_scene(scene()).source)
    assert load_scene(path).name == 'falling'


@pytest.mark.parametrize('dt', (0.001, '1e-3', 1e-9, 0.1, 1, 0.0025, 123456789e-9))
def test_a_tick_is_a_whole_number_of_nanoseconds(dt: Any) -> None:
    assert load_scene(scene(dt=dt)).dt_ns == round(float(dt) * 1e9)


@pytest.mark.parametrize(
    ('dt', 'reason'),
    (
        (1 / 3, 'nearest allowed value is 0.333333333 s'),
        (1 / 240, 'nearest allowed value is 0.004166667 s'),
        (0.0010000000000000002, 'nearest allowed value is 0.001 s'),
        (1e-10, 'nearest allowed value is 0.000000001 s'),
        (0, 'not positive'),
        (-0.001, 'not positive'),
        (math.nan, 'finite number'),
        (math.inf, 'finite number'),
        (1e300, '64 bits'),
        ('fast', "got 'fast'; a number"),
        (True, 'got True; a number'),
        ([0.001], 'a number'),
    ),
)
def test_any_other_tick_is_refused(dt: Any, reason: str) -> None:
    message = refusal(scene(dt=dt))
    assert message.startswith('scene: dt: ') and reason in message


def test_a_center_of_mass_alone_keeps_the_tensor_of_the_shape() -> None:
    plain, moved = load_body(), load_body(center_of_mass=[0.1, 0.2, 0.3])
    assert moved.center_of_mass == (0.1, 0.2, 0.3)
    assert np.array_equal(moved.inertia, plain.inertia)


def test_inertia_is_the_tensor_about_the_centre_of_mass() -> None:
    inertia = {'ixx': 1, 'iyy': 2, 'izz': '2.5e0', 'ixz': -0.25}
    read = load_body(inertia=inertia, center_of_mass=[0.1, 0, 0])
    assert np.array_equal(read.inertia, ((1, 0, -0.25), (0, 2, 0), (-0.25, 0, 2.5)))
    assert read.center_of_mass == (0.1, 0.0, 0.0)
    assert read.mass == 12.0


def test_inertia_and_mass_are_enough_without_a_shape() -> None:
    read = load_body(shape=None, inertia={'ixx': 1, 'iyy': 2, 'izz': 2.5})
    assert read.shape is None and not read.is_point
    assert np.array_equal(read.inertia, np.diag((1, 2, 2.5)))


@pytest.mark.parametrize(
    'shape',
    (
        {'type': 'sphere', 'radius': 0.3},
        {'type': 'box', 'size': [0.1, 0.2, 0.3]},
        {'type': 'cylinder', 'radius': 0.1, 'length': 0.4},
        {'type': 'capsule', 'radius': 0.1, 'length': 0.4},
    ),
)
def test_simple_solids_have_an_exactly_diagonal_tensor(shape: dict[str, Any]) -> None:
    inertia = load_body(shape=shape).inertia
    assert np.array_equal(inertia, np.diag(np.diag(inertia)))


def test_every_type_of_shape_is_read() -> None:
    capsule = load_body(shape={'type': 'capsule', 'radius': 0.1, 'length': 0.4}, mass=1)
    assert capsule.shape == Capsule(0.1, 0.4)
    points = [{'mass': 1, 'position': [1, 0, 0]}, {'mass': 3, 'position': [-1, 0, 1]}]
    points.append({'mass': 1, 'position': [0, 5, 0]})
    joined = load_body(shape={'type': 'particles', 'particles': points}, mass=None)
    assert isinstance(joined.shape, Particles)
    assert joined.mass == 5.0
    assert joined.center_of_mass == pytest.approx((-0.4, 1.0, 0.6), rel=ROUND_OFF)
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    hull = load_body(shape={'type': 'convex_hull', 'vertices': corners}, mass=None, density=6)
    assert hull.mass == pytest.approx(1.0, rel=ROUND_OFF)
    assert hull.center_of_mass == pytest.approx((0.25, 0.25, 0.25), rel=ROUND_OFF)
    ground = load_body(shape={'type': 'plane', 'normal': [0, 0, 2], 'offset': -1}, mass=None)
    assert ground.shape == Plane((0.0, 0.0, 1.0), -1.0)
    assert ground.fixed and ground.mass == 0.0 and not ground.is_point


def test_a_mesh_is_read_beside_the_scene_and_kept_with_it(tmp_path: Path) -> None:
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / 'corner.off').write_bytes(TETRAHEDRON)
    shape = {'type': 'mesh', 'file': 'meshes/corner.off'}
    path = tmp_path / 'mesh.yaml'
    path.write_bytes(
        load_scene(scene()).source.replace(
            b'bodies:',
            b'bodies:\n'
            + b"""\
- {name: corner, density: 6, shape: {type: mesh, file: meshes/corner.off}}""",
        )
    )
    read = load_scene(path)
    assert read.files == {'meshes/corner.off': TETRAHEDRON}
    corner = read.bodies[0]
    assert isinstance(corner.shape, Mesh) and corner.shape.name == 'meshes/corner.off'
    assert corner.mass == pytest.approx(1.0, rel=ROUND_OFF)
    assert corner.center_of_mass == pytest.approx((0.25, 0.25, 0.25), rel=ROUND_OFF)

    again = load_scene(read.source, files=read.files)  # as a replay does, from anywhere
    assert np.array_equal(again.bodies[0].inertia, corner.inertia)
    assert again.files == read.files
    message = refusal(path, files={})
    assert "bodies[0].shape.file: 'meshes/corner.off' is not among the given files" in message
    assert 'cannot be read' in refusal(
        scene(bodies=[body(shape={**shape, 'file': 'nowhere.off'})])
    )


ANCHORED = b"""dt: 0.01
x-ball: &ball {shape: {type: sphere, radius: 0.1}, mass: 2}
bodies: [{<<: *ball, name: a}, {<<: *ball, name: b, mass: 3}]
"""


def test_capitals_are_a_slip_as_others_are() -> None:
    assert "'QUICK' is unknown; did you mean 'quick'? " in refusal(scene(integrator='QUICK'))
    assert "unknown key; did you mean 'mass'? " in refusal(
        scene(bodies=[{'name': 'a', 'MASS': 1}])
    )


@pytest.mark.parametrize('key', ['yes', 'Off', '~', 'null', '1.50', '2026-01-02', '0x10', '7'])
def test_a_key_that_means_no_text_is_named_as_it_is_written_with_its_line(key: str) -> None:
    text = f'dt: 0.01\nname: t\n{key}: 1\n'.encode()
    message = refusal(text)
    assert message.startswith(f'scene: {key}: unknown key; ') and message.endswith('(line 3)')
    nested = b'dt: 0.01\nbodies:\n- name: a\n  mass: 1\n  ' + key.encode() + b': 1\n'
    message = refusal(nested)
    assert message.startswith(f'scene: bodies[0].{key}: unknown key; ')
    assert message.endswith('(line 5)')


def test_a_key_that_begins_with_x_holds_what_bodies_have_in_common() -> None:
    assert [each.mass for each in load_scene(ANCHORED).bodies] == [2.0, 3.0]
    message = refusal(ANCHORED.replace(b'x-ball', b'y-ball'))
    assert message.startswith('scene: y-ball: unknown key; allowed: ')
    message = refusal(ANCHORED.replace(b'mass: 3', b'x-mass: 3'))
    assert message.startswith("scene: bodies[1].x-mass: unknown key; did you mean 'mass'? ")


def test_an_stl_mesh_joins_its_corners() -> None:
    triangles = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    corners = ('0 0 0', '1 0 0', '0 1 0', '0 0 1')
    facets = ''.join(
        'facet normal 0 0 0\nouter loop\n'
        + ''.join(f'vertex {corners[k]}\n' for k in triangle)
        + 'endloop\nendfacet\n'
        for triangle in triangles
    )
    stl = f'solid corner\n{facets}endsolid corner\n'.encode()
    shape = {'type': 'mesh', 'file': 'corner.stl'}
    read = load_scene(
        scene(bodies=[body(shape=shape, density=6, mass=None)]), files={'corner.stl': stl}
    )
    assert read.bodies[0].mass == pytest.approx(1.0, rel=ROUND_OFF)


@pytest.mark.parametrize('head', ['OFF\n12 8 0', 'OFF 12 8 18', '# prism\nOFF\n\n12 8 0 # counts'])
def test_polygons_of_an_off_mesh_are_cut_into_triangles(head: str) -> None:
    angle = np.arange(6) * math.pi / 3
    ring = [f'{math.cos(a)!r} {math.sin(a)!r}' for a in angle.tolist()]
    points = [f'{corner} {z}' for z in (0, 2) for corner in ring]
    sides = [f'4 {i} {(i + 1) % 6} {6 + (i + 1) % 6} {6 + i}' for i in range(6)]
    ends = ['6 5 4 3 2 1 0', '6 6 7 8 9 10 11 0.5 0.5 0.5']  # the last one with a colour
    off = '\n'.join([head, *points, *ends, *sides]).encode()
    shape = {'type': 'mesh', 'file': 'prism.off'}
    given = scene(bodies=[body(shape=shape, density=6, mass=None)])
    prism = load_scene(given, files={'prism.off': off}).bodies[0]
    assert prism.mass == pytest.approx(6 * 2 * 1.5 * math.sqrt(3), rel=ROUND_OFF)  # of a hexagon
    assert prism.center_of_mass == pytest.approx((0, 0, 1), abs=ROUND_OFF)


@pytest.mark.parametrize('parted', [b' ', b' # no end of a row\n'], ids=['a line', 'a word each'])
def test_numbers_of_off_may_be_parted_by_any_blanks(parted: bytes) -> None:
    given = scene(bodies=[body(shape={'type': 'mesh', 'file': 'a.off'}, density=6, mass=None)])
    texts = (TETRAHEDRON, parted.join(TETRAHEDRON.split()))
    plain, other = (load_scene(given, files={'a.off': text}).bodies[0] for text in texts)
    assert (other.mass, other.center_of_mass) == (plain.mass, plain.center_of_mass)
    assert other.mass == pytest.approx(1.0, rel=ROUND_OFF)


@pytest.mark.parametrize(
    ('text', 'file', 'reason'),
    (
        (b'OFF\n1 2', 'a.off', 'read as OFF, is cut short: it counts 1 vertices and 2 faces'),
        (b'OFF\n1 x', 'a.off', 'not readable as OFF'),
        (TETRAHEDRON.removeprefix(b'OFF\n'), 'a.off', 'lacks the keyword OFF, in capitals'),
        (b'# OFF' + TETRAHEDRON.lower(), 'a.off', 'lacks the keyword OFF, in capitals'),
        (b' '.join(TETRAHEDRON.split()[:-1]), 'a.off', 'is cut short: it counts 4 vertices'),
        (b'', 'a.stl', "'a.stl' is empty; a mesh is a closed surface"),
        (b'\x00\xff' * 50, 'a.ply', 'not readable as PLY'),
        (b'hello' * 40, 'a.stl', "'a.stl' holds no triangles, read as STL"),
        (b'hello', 'a.txt', 'allowed endings: off, stl, obj, ply'),
        (TETRAHEDRON.replace(b'4 4 6', b'4 3 6').rsplit(b'3 1', 1)[0], 'a.off', 'faces'),
    ),
)
def test_a_broken_mesh_is_refused(text: bytes, file: str, reason: str) -> None:
    source = scene(bodies=[body(shape={'type': 'mesh', 'file': file})])
    message = refusal(source, files={file: text})
    assert message.startswith('scene: bodies[0].shape.file: ') and reason in message


STL = b'box'.ljust(80) + (4).to_bytes(4, 'little') + bytes(200)
STL_TEXT = b'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n'
PLY = (
    b'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n'
    b'property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n'
    + TETRAHEDRON.split(b'\n', 2)[2]
)


@pytest.mark.parametrize(
    ('text', 'file', 'reason'),
    (
        (STL[:-1], 'a.stl', 'is cut short: it counts 4 triangles and has 283 bytes; allowed: 84'),
        (STL[:84], 'a.stl', 'has 84 bytes; allowed: 84 + 50 * 4 = 284 bytes; write or copy it'),
        (STL + b' ', 'a.stl', 'has bytes behind its triangles: it counts 4 triangles and has 285'),
        (b'solid'.ljust(80) + STL[80:-9], 'a.stl', 'is cut short: it counts 4 triangles'),
        (STL_TEXT, 'a.stl', "is cut short: text without 'endsolid' at its end"),
        (TETRAHEDRON.strip().rsplit(b'\n', 1)[0], 'a.off', '4 vertices and 4 faces, a line each'),
        (TETRAHEDRON.strip()[:-2], 'a.off', 'its last face counts 3 corners and has 2'),
        (PLY.strip().rsplit(b'\n', 2)[0], 'a.ply', 'has 6 lines of them; allowed: 8 lines'),
        (PLY.strip()[:-2], 'a.ply', 'its last face counts 3 corners and has 2'),
    ),
)
@pytest.mark.parametrize('kind', ('mesh', 'ground'))
def test_a_mesh_that_is_cut_short_is_told_so(text, file, reason, kind) -> None:
    shape = {'type': 'mesh', 'file': file}
    said = {'shape': shape}
    if kind == 'ground':
        said = {'shape': shape | {'as': 'triangles'}, 'fixed': True, 'mass': None}
    whole = scene(bodies=[body(**said)])
    message = refusal(whole, files={file: text})
    assert message.startswith('scene: bodies[0].shape') and reason in message


def as_npy(table: Any, save: Callable[..., None] = np.save) -> bytes:
    """The bytes of an array as NumPy saves it."""
    file = io.BytesIO()
    save(file, np.asarray(table))
    return file.getvalue()


GROUND = {'type': 'heightfield', 'spacing': 1}


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize(
    ('text', 'file', 'reason'),
    (
        (b'', 'a.csv', "'a.csv' is empty; give a table of numbers"),
        (b'\n \n', 'a.txt', "'a.txt' is empty; give a table of numbers"),
        (b'# none\n', 'a.csv', 'it holds comments and no numbers; give a table'),
        (as_npy([[1j, 2], [3, 4]]), 'a.npy', 'its elements are complex128; allowed: integers'),
        (as_npy([['1', '2'], ['3', '4']]), 'a.npy', 'its elements are <U1; allowed: integers'),
        (as_npy([[1.0, 2.0], [3.0, 4.0]], np.savez), 'a.npy', 'it is an archive of arrays'),
        (as_npy([[1.0, 2.0], [3.0, 4.0]])[:-3], 'a.npy', 'is not readable as NPY'),
    ),
)
def test_a_table_without_real_numbers_is_refused(text: bytes, file: str, reason: str) -> None:
    source = scene(bodies=[body(shape=GROUND | {'file': file}, fixed=True, mass=None)])
    message = refusal(source, files={file: text})
    assert message.startswith('scene: bodies[0].shape.file: ') and reason in message


def test_a_byte_order_mark_before_a_table_is_read_over() -> None:
    source = scene(bodies=[body(shape=GROUND | {'file': 'a.csv'}, fixed=True, mass=None)])
    read, plain = (
        load_scene(source, files={'a.csv': mark + b'1,2\n3,4\n'}).bodies[0].shape.vertices
        for mark in (b'\xef\xbb\xbf', b'')
    )
    assert np.array_equal(read, plain)


def stl_text(name: str) -> bytes:
    """The tetrahedron as STL in words."""
    corners = ('0 0 0', '1 0 0', '0 1 0', '0 0 1')
    facets = ''.join(
        'facet normal 0 0 0\nouter loop\n'
        + ''.join(f'vertex {corners[k]}\n' for k in face)
        + 'endloop\nendfacet\n'
        for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    )
    return f'solid {name}\n{facets}endsolid {name}\n'.encode()


def test_a_whole_mesh_is_read_whatever_stands_behind_it() -> None:
    for file, text in (
        ('a.stl', stl_text('facet vertex')),
        ('b.stl', stl_text('') + b'\n\n'),
        ('a.off', TETRAHEDRON + b'\n# the end\n'),
        ('b.off', TETRAHEDRON.replace(b'\n', b'\r\n')),
        ('a.ply', PLY),
    ):
        read = load_scene(
            scene(bodies=[body(shape={'type': 'mesh', 'file': file})]), files={file: text}
        )
        assert len(read.bodies[0].shape.faces) == 4


def test_an_open_mesh_is_refused_at_its_shape() -> None:
    source = scene(bodies=[body(shape={'type': 'mesh', 'file': 'a.off'})])
    opened = TETRAHEDRON.replace(b'4 4 6', b'4 5 6') + b'3 0 1 2\n'
    message = refusal(source, files={'a.off': opened})
    assert message.startswith("scene: bodies[0].shape: mesh 'a.off' is open: 3 edges")


def test_fixed_bodies_need_no_mass() -> None:
    wall = load_body(fixed=True, mass=None)
    assert wall.fixed and wall.mass == 0.0 and wall.inertia is None and not wall.is_point
    heavy = load_body(fixed=True)
    assert heavy.fixed and heavy.mass == 12.0


def test_a_fixed_body_of_no_mass_is_one_that_says_none() -> None:
    told, silent = (load_body(fixed=True, mass=mass) for mass in (0, None))
    assert told.mass == silent.mass == 0.0 and told.inertia is silent.inertia is None
    assert told.center_of_mass == silent.center_of_mass
    with pytest.raises(UserError, match='mass is 0'):
        load_body(mass=0)


def test_angular_velocity_may_be_given_in_body_axes() -> None:
    quarter = [0, 0, math.sqrt(0.5), math.sqrt(0.5)]  # about z: body x is world y
    read = load_body(initial={'orientation': quarter, 'angular_velocity_body': [3, 0, 0]})
    assert read.initial.angular_velocity == pytest.approx((0.0, 3.0, 0.0), abs=ROUND_OFF)


def test_quaternions_are_normalised_and_unit_ones_kept_bit_for_bit() -> None:
    assert load_body(initial={'orientation': [0, 0, 3, 4]}).initial.orientation == (0, 0, 0.6, 0.8)
    q = tuple(rotation.normalise((0.1, -0.5, 0.3, 0.7)).tolist())
    stretched = tuple(x * (1 + 2.3e-16) for x in q)
    for given_q in (q, stretched):
        assert load_body(initial={'orientation': list(given_q)}).initial.orientation == given_q


def test_contact_material_is_read_per_body() -> None:
    material = load_body(restitution=0.5, friction=0.3, rolling_friction='1e-3').material
    assert (material.restitution, material.friction) == (0.5, 0.3)
    assert (material.rolling_friction, material.torsional_friction) == (0.001, 0.0)


def test_the_settings_of_contact_are_the_fields_of_its_record() -> None:
    given = {'mode': 'timestep', 'substeps': '8', 'slop': '1e-4'}
    contact = load_scene(scene(contact=given)).contact
    assert contact == {'mode': 'timestep', 'substeps': 8, 'slop': 1e-4}
    assert isinstance(contact['substeps'], int)


def test_a_scene_without_contact_imports_none_of_it() -> None:
    code = (
        'import sys; from rigid_body_sim import load_scene;'
        f'load_scene({scene(contact={"mode": "none"})!r});'
        "assert not [m for m in sys.modules if m.startswith('rigid_body_sim.physics.contact')]"
    )
    subprocess.run([sys.executable, '-c', code], check=True, timeout=HANGING)


def test_copies_stand_on_a_grid() -> None:
    grid = {'count': [2, 1, 3], 'spacing': [0.5, 1, 2]}
    start = {'position': [1, 2, 3], 'velocity': [0, 0, 1]}
    copies = load_scene(scene(bodies=[body(repeat=grid, initial=start)])).bodies
    assert [copy.name for copy in copies] == [f'box_{n}' for n in range(1, 7)]
    positions = [copy.initial.position for copy in copies]
    assert positions == [(x, 2, z) for z in (3, 5, 7) for x in (1, 1.5)]
    assert all(copy.initial.velocity == (0, 0, 1) and copy.mass == 12 for copy in copies)


def test_jittered_copies_stay_near_their_places_and_fill_them_evenly() -> None:
    grid = {'count': [10, 10, 10], 'spacing': [0, 0, 0], 'jitter': 0.5}
    copies = load_scene(scene(bodies=[body(repeat=grid)])).bodies
    places = np.array([copy.initial.position for copy in copies])
    assert np.all(np.abs(places) < 0.5) and len(np.unique(places, axis=0)) == 1000
    # In each eighth of the cube about 125 of them; of random ones some would be off by 20.
    octants = ((places > 0.0) @ (1, 2, 4)).tolist()
    assert all(abs(octants.count(k) - 125) <= 10 for k in range(8))


# ------ what is refused


REFUSED_BODIES: tuple[tuple[dict[str, Any], str], ...] = (
    ({'mass': -1}, 'bodies[0].mass: mass is -1.0 kg; it must be positive and finite'),
    ({'mass': math.nan}, 'bodies[0].mass: got nan; a finite number [kg]'),
    ({'mass': math.inf}, 'bodies[0].mass: got inf; a finite number [kg]'),
    ({'mass': 10**400}, 'a finite number [kg]'),
    ({'mass': True}, 'bodies[0].mass: got True; a number [kg]'),
    ({'mass': 'heavy'}, "bodies[0].mass: got 'heavy'; a number [kg]"),
    ({'mass': '1_0'}, 'a number [kg]'),
    ({'mass': None}, 'bodies[0]: mass is missing; mass [kg] or density [kg/m^3] is needed'),
    ({'density': 3}, 'either mass [kg] or density'),
    ({'mas': 1}, "bodies[0].mas: unknown key; did you mean 'mass'? allowed: name"),
    (
        {'exhaust_velocity': 3},
        'bodies[0].exhaust_velocity: exhaust_velocity says nothing without mass_rate',
    ),
    ({'mass_rate': -0.1, 'final_mass': 13}, 'bodies[0].final_mass: '),
    (
        {'mass_rate': -0.1, 'final_mass': 0},
        'bodies[0].final_mass: got 0.0; a positive number [kg]',
    ),
    (
        {'mass_rate': -0.1, 'exhaust_velocity': [0, 1]},
        'bodies[0].exhaust_velocity: got [0, 1]; a list of 3',
    ),
    ({'mass_rate': -0.1, 'fixed': True, 'initial': {}}, 'bodies[0].mass_rate: '),
    ({'shape': None}, 'shape is missing; give one ({type: particle}'),
    ({'shape': 'box'}, "bodies[0].shape: got 'box'; a mapping such as"),
    ({'shape': {}}, 'bodies[0].shape: type is missing; one of particle'),
    ({'shape': {'type': 'bocks'}}, "bodies[0].shape.type: shape 'bocks' is unknown"),
    ({'shape': {'type': ['box']}}, "shape ['box'] is unknown"),
    (
        {'shape': {'type': 'box', 'sise': [1, 1, 1]}},
        "shape.sise: unknown key; did you mean 'size'?",
    ),
    (
        {'shape': {'type': 'box', 'size': [1, 1]}},
        'shape.size: got [1, 1]; a list of 3 numbers [m]',
    ),
    ({'shape': {'type': 'box', 'size': [1, 1, 'x']}}, "shape.size[2]: got 'x'; a number [m]"),
    ({'shape': {'type': 'box', 'size': [1, 1, 0]}}, 'size along z is 0.0 m; it must be positive'),
    ({'shape': {'type': 'sphere'}}, 'bodies[0].shape: radius is missing; a length [m]'),
    ({'shape': {'type': 'sphere', 'radius': -1}}, 'bodies[0].shape: radius is -1.0 m'),
    ({'shape': {'type': 'convex_hull', 'vertices': [[0, 0, 0]]}}, 'at least 4 points'),
    ({'shape': {'type': 'convex_hull', 'vertices': []}}, 'at least 4 points'),
    ({'shape': {'type': 'convex_hull', 'vertices': [[k, 0, 0] for k in range(5)]}}, 'one plane'),
    ({'shape': {'type': 'particles', 'particles': []}, 'mass': None}, 'at least 1 point of'),
    ({'shape': {'type': 'particles', 'particles': [{'mass': 1}]}}, 'position is missing'),
    (
        {'shape': {'type': 'particles', 'particles': [{'mass': 12, 'position': [1, 2, 3]}]}},
        'bodies[0].shape: principal moments (0, 0, 0) kg m^2 are not all positive',
    ),
    ({'shape': {'type': 'plane', 'normal': [0, 0, 0]}, 'mass': None}, 'non-zero length'),
    ({'shape': {'type': 'plane', 'normal': [0, 0, 1]}}, 'bodies[0].mass: a plane is static'),
    (
        {
            'shape': {'type': 'plane', 'normal': [0, 0, 1]},
            'mass': None,
            'repeat': {'count': [1, 1, 2], 'spacing': [0, 0, 1]},
        },
        'bodies[0].repeat: a plane is one plane wherever',
    ),
    (
        {'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'mass': None, 'fixed': False},
        'bodies[0].fixed: a plane is always fixed',
    ),
    ({'shape': {'type': 'particle'}, 'density': 1, 'mass': None}, 'no volume'),
    (
        {'shape': {'type': 'particle'}, 'inertia': {'ixx': 1}},
        'inertia: a particle is a point mass',
    ),
    (
        {'shape': {'type': 'particle'}, 'initial': {'orientation': [0, 0, 0, 1]}},
        'bodies[0].initial.orientation: a particle is a point mass and does not rotate',
    ),
    (
        {'shape': {'type': 'particle'}, 'initial': {'angular_velocity_body': [0, 0, 0]}},
        'initial.angular_velocity_body: a particle',
    ),
    (
        {'inertia': {'ixx': 1, 'iyy': 1, 'izz': 3}},
        'bodies[0].inertia: principal moments (1, 1, 3) kg m^2 break the triangle inequality; '
        'a rigid body needs I1 + I2 >= I3',
    ),
    ({'inertia': {'ixx': 1, 'iyy': 1}}, 'bodies[0].inertia: izz is missing; a moment of inertia'),
    ({'inertia': [1, 1, 1]}, 'bodies[0].inertia: got [1, 1, 1]; a mapping'),
    ({'inertia': {'ixx': 1, 'iyy': 1, 'izz': 1, 'iyx': 0}}, "did you mean 'iyz'?"),
    ({'fixed': 'yes'}, "bodies[0].fixed: got 'yes'; true or false"),
    ({'fixed': True, 'initial': {'velocity': [1, 0, 0]}}, 'a fixed body does not move'),
    ({'initial': {'orientation': [0, 0, 0, 0]}}, 'orientation: a quaternion of zero length'),
    ({'initial': {'orientation': [0, 0, math.nan, 1]}}, 'orientation[2]: got nan; a finite'),
    ({'initial': {'orientation': [0, 0, 1]}}, 'a list of 4 numbers'),
    (
        {'initial': {'positon': [0, 0, 0]}},
        "initial.positon: unknown key; did you mean 'position'?",
    ),
    (
        {'initial': {'angular_velocity': [0, 0, 1], 'angular_velocity_body': [0, 0, 1]}},
        'keep one of the two',
    ),
    ({'restitution': 1.5}, 'bodies[0].restitution: got 1.5; a number [-] from 0.0 to 1.0'),
    ({'friction': -0.1}, 'bodies[0].friction: got -0.1; a number [-] of at least 0.0'),
    ({'friction': '.inf'}, "bodies[0].friction: got '.inf'; a number [-]"),
    ({'rolling_friction': -1e-3}, 'rolling_friction: got -0.001; a number [m] of at least 0.0'),
    ({'torsional_friction': -1}, 'torsional_friction: got -1.0; a number [m] of at least 0.0'),
    ({'frction': 1}, "bodies[0].frction: unknown key; did you mean 'friction'?"),
    ({'repeat': 3}, 'bodies[0].repeat: got 3; a mapping such as {count'),
    ({'repeat': {'count': [1, 2, 3]}}, 'repeat: spacing is missing; a list of three lengths [m]'),
    ({'repeat': {'count': [1, 2], 'spacing': [0, 0, 0]}}, 'repeat.count: got [1, 2]; a list of 3'),
    (
        {'repeat': {'count': [1, 2, 0], 'spacing': [0, 0, 0]}},
        'repeat.count: got [1, 2, 0]; three whole numbers of at least 1',
    ),
    (
        {'repeat': {'count': [1, 2.5, 1], 'spacing': [0, 0, 0]}},
        'repeat.count: got [1, 2.5, 1]; three whole numbers',
    ),
    (
        {'repeat': {'count': [1e3, 1e3, 1], 'spacing': [0, 0, 0]}},
        'repeat.count: 1000000 copies; at most 100000',
    ),
    (
        {'repeat': {'count': [2, 1, 1], 'spacing': [0, 0, 0], 'jitter': -1}},
        'repeat.jitter: got -1.0; a number [m] of at least 0.0',
    ),
    ({'urdf': 'box.urdf'}, 'bodies[0].shape: the URDF file says what the body is'),
    ({'urdf': 3, 'shape': None, 'mass': None}, 'bodies[0].urdf: got 3; the path of a URDF file'),
    (
        {'urdf': 'box.urdf', 'shape': None, 'mass': None},
        "bodies[0].urdf: 'box.urdf' cannot be read: No such file",
    ),
    ({'name': '2fast'}, "bodies[0].name: got '2fast'; a body name is a letter"),
    ({'name': 'a__b'}, 'a body name is a letter'),
    ({'name': 'a b\n'}, 'a body name is a letter'),
    ({'name': 'bóx'}, 'a body name is a letter'),
    ({'name': ''}, "got ''; a name is needed"),
    ({'name': 3}, 'got 3; a name is needed'),
    ({'name': None}, 'bodies[0]: name is missing'),
    ({'name': 'world'}, "bodies[0].name: 'world' is a reserved name"),
    ({'name': 'clock'}, "bodies[0].name: 'clock' is a reserved name"),
)


@pytest.mark.parametrize(('changes', 'reason'), REFUSED_BODIES)
def test_an_impossible_body_is_refused(changes: dict[str, Any], reason: str) -> None:
    message = refusal(scene(bodies=[body(**changes)]))
    assert message.startswith('scene: bodies[0]') and reason in message


REFUSED_SCENES: tuple[tuple[dict[str, Any], str], ...] = (
    ({'body': []}, "scene: body: unknown key; did you mean 'bodies'? allowed: version"),
    ({'dt': None}, 'scene: dt is missing; the tick length [s] is needed'),
    ({'bodies': None}, 'scene: bodies is missing; a list of bodies is needed'),
    ({'bodies': []}, 'at least one body'),
    ({'bodies': {}}, 'scene: bodies: got a mapping; a list of bodies'),
    ({'bodies': [3]}, 'scene: bodies[0]: got 3; a mapping such as'),
    ({'bodies': [body(), body()]}, "scene: bodies[1].name: the name 'box' is taken"),
    ({'version': 2}, 'scene: version: got 2; this program reads scenes of version 1'),
    ({'version': True}, 'scene: version: got True'),
    ({'version': '2'}, "scene: version: got '2'"),
    ({'version': '0x1'}, "scene: version: got '0x1'"),
    (
        {'integrator': 'quik'},
        "integrator 'quik' is unknown; did you mean 'quick'? allowed: quick,",
    ),
    ({'integrator': 3}, 'integrator 3 is unknown'),
    ({'gravity': -9.81}, 'scene: gravity: got -9.81; a list of 3 numbers [m/s^2]'),
    ({'gravity': [0, 0, '.nan']}, "scene: gravity[2]: got '.nan'; a number"),
    ({'contact': {'mode': 'events'}}, "did you mean 'event'? allowed: none, timestep, event"),
    ({'contact': {'mode': 'magic'}}, "contact mode 'magic' is unknown; allowed: none, timestep"),
    ({'contact': {}}, 'contact: mode is missing; one of none, timestep'),
    (
        {'contact': {'mode': 'timestep', 'substep': 2}},
        "contact.substep: unknown key; did you mean 'substeps'? allowed: mode, substeps",
    ),
    (
        {'contact': {'mode': 'timestep', 'substeps': 0}},
        'scene: contact.substeps: got 0; a whole number from 1 to 1000 is needed',
    ),
    (
        {'contact': {'mode': 'timestep', 'substeps': 1.5}},
        'contact.substeps: got 1.5; a whole number from 1 to 1000 is needed',
    ),
    ({'contact': {'mode': 'timestep', 'substeps': 'many'}}, "contact.substeps: got 'many'; a who"),
    (
        {'contact': {'mode': 'timestep', 'slop': -1}},
        'scene: contact.slop: got -1.0; a number [m] of at least 0.0 is needed',
    ),
    (
        {'contact': {'mode': 'timestep', 'margin': math.nan}},
        'margin: got nan; a finite number [m]',
    ),
    ({'contact': {'mode': 'none', 'slop': 1}}, 'contact.slop: unknown key'),
    ({'contact': 'none'}, "contact: got 'none'; a mapping such as {mode: timestep}"),
    ({'forces': {}}, 'forces: got a mapping; a list'),
    ({'forces': [{}]}, 'forces[0]: type is missing; one of rope'),
    ({'forces': [{'type': 'roap'}]}, "forces[0].type: force 'roap' is unknown; did you mean"),
    (
        {'forces': [{'type': 'rope', 'a': 'box'}]},
        'forces[0]: b is missing; the name of a body, or',
    ),
    (
        {'forces': [{'type': 'rope', 'a': 'bax', 'b': 'world', 'stiffness': 1}]},
        "forces[0].a: body 'bax' is unknown; did you mean 'box'? allowed: box",
    ),
    (
        {'forces': [{'type': 'rope', 'a': 'world', 'b': 'world', 'stiffness': 1}]},
        "forces[0].a: body 'world' is unknown",
    ),
    (
        {'forces': [{'type': 'rope', 'a': 'box', 'b': 'world', 'stiffness': 0}]},
        'forces[0].stiffness: got 0.0; a positive number [N/m] is needed',
    ),
    (
        {'forces': [{'type': 'rope', 'a': 'box', 'b': 'world', 'stiffness': 1, 'damping': -1}]},
        'forces[0].damping: got -1.0; a number [N s/m] of at least 0.0',
    ),
    (
        {'forces': [{'type': 'rope', 'a': 'box', 'b': 'world', 'stiffness': 1, 'side': 'up'}]},
        "choice 'up' is unknown; allowed: left, right",
    ),
    (
        {'forces': [{'type': 'rope', 'a': 'box', 'b': 'box', 'stiffness': 1}]},
        "forces[0]: a and b are both 'box'; a rope needs two ends",
    ),
    (
        {'bodies': [body(name='box_2'), body(repeat={'count': [2, 1, 1], 'spacing': [1, 0, 0]})]},
        "scene: bodies[1].name: the name 'box_2' is taken",
    ),
    ({'name': 7}, 'scene: name: got 7; a name is needed'),
)


@pytest.mark.parametrize(('changes', 'reason'), REFUSED_SCENES)
def test_an_impossible_scene_is_refused(changes: dict[str, Any], reason: str) -> None:
    assert reason in refusal(scene(**changes))


def test_a_refusal_names_file_place_and_line(tmp_path: Path) -> None:
    path = tmp_path / 'box.yaml'
    path.write_bytes(EXAMPLE.replace(b'mass: 0.5', b'mass: much'))
    assert (
        refusal(path) == f"{path}: bodies[1].mass: got 'much'; a number [kg] is needed (line 16)"
    )


@pytest.mark.parametrize(
    ('text', 'reason'),
    (
        (b'dt: 0.001\ndt: 0.002\nbodies: []', "line 2, column 1: the key 'dt' stands twice"),
        (b'bodies:\n- {name: a, name: b}', "line 2, column 13: the key 'name' stands twice"),
        (b'bodies: [', 'expected'),
        (b'', 'got nothing; a mapping'),
        (b'[1, 2]', 'got [1, 2]; a mapping'),
        (b'\xff\xfe\x00', 'scene: '),
        (b'\x00', 'scene: '),
        (b'dt: 2026-99-99', "dt: got '2026-99-99'; a number [s]"),
        (b'dt: !!python/object:os.system x', 'line 1'),
        (b'dt: !!int x', "dt: got 'x'; a number [s]"),
        (b'dt: 0x' + b'f' * 5000, "dt: got '0xfff"),
        (b'a: &a [*a]', 'line 1, column 4: an alias stands inside of what it repeats'),
        (b'? [1, 2]\n: 3', 'line 1'),
        (b'--- 1\n--- 2', 'line 2'),
        (b'[' * 100_000, 'nested more than'),
        (b'{a: ' * 100_000, 'nested more than'),
        (b'- ' * 100_000, 'nested more than'),
    ),
)
def test_text_that_is_no_scene_is_refused(text: bytes, reason: str) -> None:
    assert reason in refusal(text)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    assert 'nowhere.yaml: cannot be read: No such file' in refusal(tmp_path / 'nowhere.yaml')
    assert 'cannot be read' in refusal(tmp_path)
    assert 'no such file' in refusal('a\0b')
    assert 'got 3; the path of a scene file' in refusal(3)


def test_a_mapping_that_is_no_yaml_is_refused() -> None:
    assert 'cannot be written as YAML' in refusal(scene(name=object()))
    assert 'cannot be written as YAML' in refusal(scene(dt=10**5000))
    circle: dict[str, Any] = scene()
    circle['bodies'] = [circle]
    assert 'cannot be written as YAML' in refusal(circle)


# ------ nothing but a scene or one clear line, whatever comes in

WORDS = (
    'version name dt integrator gravity contact mode none bodies forces shape type mass density '
    'inertia center_of_mass fixed initial position orientation velocity angular_velocity '
    'angular_velocity_body restitution friction mass_rate radius length size vertices particles '
    'positions masses file normal offset particle sphere box cylinder capsule convex_hull mesh '
    'plane ixx iyy izz ixy rope a b b_point stiffness damping side left world'
).split()
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.sampled_from((10**400, 1e200, 1e-200, 5e-324, '1e-3', 'nowhere.off', '\0')),
    st.sampled_from(WORDS),
    st.text(max_size=8),
    st.dates(),
    st.binary(max_size=4),
)
JUNK = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=5),
        st.lists(st.floats(), min_size=3, max_size=4),
        st.dictionaries(st.one_of(st.sampled_from(WORDS), SCALARS), inner, max_size=5),
    ),
    max_leaves=12,
)
VALID = {
    'version': 1,
    'name': 'all',
    'dt': 0.001,
    'integrator': 'quick',
    'gravity': [0, 0, -9.81],
    'contact': {'mode': 'none'},
    'bodies': [
        body(initial={'position': [0, 0, 1], 'orientation': [0, 0, 0, 1], 'velocity': [0, 1, 0]}),
        body(name='ball', shape={'type': 'particle'}, initial={'position': [0, 0, 1]}),
        body(
            name='can',
            shape={'type': 'cylinder', 'radius': 1, 'length': 2},
            center_of_mass=[0, 0, 1],
        ),
        body(name='pill', shape={'type': 'capsule', 'radius': 1, 'length': 2}, restitution=0.5),
        body(
            name='hull',
            shape={
                'type': 'convex_hull',
                'vertices': [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
            },
            inertia={'ixx': 1, 'iyy': 1, 'izz': 1, 'ixy': 0.1},
        ),
        body(
            name='joined',
            shape={
                'type': 'particles',
                'particles': [{'mass': 1, 'position': [x, x * x, 0]} for x in (0, 1, 2)],
            },
            mass=None,
        ),
        body(name='ground', shape={'type': 'plane', 'normal': [0, 0, 1], 'offset': 0}, mass=None),
    ],
    'forces': [{'type': 'rope', 'a': 'ball', 'b': 'box', 'stiffness': 1, 'b_point': [0, 0, 1]}],
}


def places(content: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """List the paths of all values inside a nested content."""
    children = (
        content.items()
        if isinstance(content, dict)
        else enumerate(content)
        if isinstance(content, list)
        else ()
    )
    return [path] + [place for key, child in children for place in places(child, (*path, key))]


def scene_or_user_error(load: Callable[[], Scene]) -> None:
    """Fail on any exception but a UserError of one line."""
    try:
        assert isinstance(load(), Scene)
    except UserError as error:
        assert len(str(error).splitlines()) == 1, str(error)


ANYTHING = pytest.mark.parametrize('draws', [60, pytest.param(300, marks=pytest.mark.long)])


@ANYTHING
def test_any_mapping_is_a_scene_or_one_clear_line(draws: int) -> None:
    @settings(max_examples=draws)
    @given(st.dictionaries(st.one_of(st.sampled_from(WORDS), SCALARS), JUNK, max_size=6))
    def holds(junk: dict[Any, Any]) -> None:
        scene_or_user_error(lambda: load_scene(junk, files={}))

    holds()


@ANYTHING
def test_a_scene_with_one_wrong_value_is_a_scene_or_one_clear_line(draws: int) -> None:
    @settings(max_examples=draws)
    @given(st.sampled_from(places(VALID)[1:]), JUNK)
    def holds(place: tuple[Any, ...], junk: Any) -> None:
        changed = copy.deepcopy(VALID)
        target: Any = changed
        for key in place[:-1]:
            target = target[key]
        target[place[-1]] = junk
        scene_or_user_error(lambda: load_scene(changed, files={}))

    holds()


@ANYTHING
def test_any_bytes_are_a_scene_or_one_clear_line(draws: int) -> None:
    @settings(max_examples=draws)
    @given(st.one_of(st.binary(), st.text().map(str.encode)))
    @example(b'- !!timestamp x')
    @example(b'!!bool x')
    @example(b'? !!set {a}\n: b')
    @example(b'1: &a {<<: *a}')
    def holds(text: bytes) -> None:
        scene_or_user_error(lambda: load_scene(text, files={}))

    holds()


def test_the_scene_that_the_junk_starts_from_is_valid() -> None:
    assert len(load_scene(VALID).bodies) == 7
