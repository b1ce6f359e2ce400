# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The playback page draws every body as it collides: the same shapes at the same places."""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rigid_body_sim import load_scene
from rigid_body_sim.physics.contact.collision import collider_record
from rigid_body_sim.physics.contact.collision import pose as pose_record
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    HULL,
    SPHERE,
    Colliders,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    COUNT,
    VERTICES,
)
from rigid_body_sim.physics.model.reach import reach
from rigid_body_sim.physics.model.scene import Body, Motion, Scene
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Part,
    Particle,
    Particles,
    Sphere,
    Union,
)
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view.drawn_shapes import DrawnShapes, drawn_planes, inertia_form
from rigid_body_sim.view.page_numbers import PageNumbers

from ..pages import PageOf, array_of

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
DENTED = Mesh(
    np.vstack((CORNERS, [0.1, 0.1, 0.1])),
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]]),
)
SHAPES = (
    Sphere(0.3),
    Box((0.1, 0.2, 0.3)),
    Cylinder(0.2, 0.5),
    Capsule(0.1, 0.4),
    ConvexHull(2.0 * CORNERS - 1.0),
    Mesh(CORNERS, FACES),
    Particle(),
)


def surface(form, numbers):
    """Vertices (n, 3) and faces (m, 3) of a form."""
    held = numbers.joined() if isinstance(numbers, PageNumbers) else numbers
    vertices, faces = (array_of(form[name], held) for name in ('vertices', 'faces'))
    return vertices.reshape(-1, 3).astype(float), faces


def drawing(*, ball=0.01, meshes_collide=True):
    """Shapes of a page, none yet, and its numbers."""
    numbers = PageNumbers()
    return DrawnShapes(numbers, ball=ball, meshes_collide=meshes_collide), numbers


def same_points(found, wanted, *, within):
    """Whether two sets of points are the same, in any order."""
    apart = np.linalg.norm(found[:, None] - wanted[None], axis=2)
    return len(found) == len(wanted) and apart.min(axis=1).max() <= within


def same_geometry(form, kind, numbers, held):
    """Whether a form has the sizes by which contact knows it."""
    if kind == SPHERE:
        return form == {'type': 'sphere', 'radius': numbers[0]}
    if kind in (CAPSULE, CYLINDER):
        name = 'capsule' if kind == CAPSULE else 'cylinder'
        return form == {'type': name, 'radius': numbers[0], 'length': 2.0 * numbers[1]}
    if kind == BOX:
        return form['type'] == 'box' and np.array_equal(form['size'], 2.0 * numbers[:3])
    assert kind == HULL
    count = int(numbers[COUNT])
    corners = numbers[VERTICES : VERTICES + 3 * count].reshape(-1, 3)
    # the page is in single precision; corners are of the order of 1 m
    whole = corners + numbers[CENTER : CENTER + 3]
    return same_points(surface(form, held)[0], whole, within=3e-7)


VECTORS = st.tuples(*[st.floats(-2.0, 2.0)] * 3)  # [m]
TURNS = st.integers(0, 2**32 - 1).map(
    lambda seed: tuple(Rotation.random(rng=np.random.default_rng(seed)).as_quat().tolist())
)
PARTS = st.builds(
    lambda shape, position, orientation: Part(
        shape, mass=1.0, position=position, orientation=orientation
    ),
    st.recursive(
        st.sampled_from(SHAPES),
        lambda inner: st.lists(
            st.builds(lambda s, p, q: Part(s, position=p, orientation=q), inner, VECTORS, TURNS),
            min_size=1,
            max_size=3,
        ).map(lambda parts: Union(tuple(parts))),
        max_leaves=4,
    ),
    VECTORS,
    TURNS,
)


@settings(max_examples=80)
@given(
    parts=st.lists(PARTS, min_size=1, max_size=3),
    single=st.booleans(),
    center=VECTORS,
    place=st.tuples(VECTORS, TURNS),
    stands=st.tuples(VECTORS, TURNS),
)
def test_each_part_is_drawn_with_the_geometry_and_the_pose_that_contact_has(
    parts, single, center, place, stands
):
    shape = parts[0].shape if single else Union(tuple(parts))
    body = Body(
        name='b',
        shape=shape,
        mass=1.0,
        inertia=np.eye(3),
        center_of_mass=center,
        shape_position=place[0],
        shape_orientation=place[1],
        initial=Motion(position=stands[0], orientation=stands[1]),
    )
    scene = Scene(name='s', dt_ns=1_000_000, bodies=(body,), contact={'mode': 'timestep'})
    colliders = Colliders.of(scene, Layout(scene))
    drawn, held = drawing()
    points = {'type': 'point', 'radius': 0.01}  # contact gives them no surface in a union
    found = drawn.parts(body)
    if isinstance(shape, Union):
        found = [part for part in found if drawn.forms[part['form']] != points]
    assert len(found) == len(colliders)
    axes = Rotation.from_quat(stands[1])
    table = colliders.table.reshape(-1, collider_record.SIZE)
    for part, pose, row in zip(
        found, colliders.poses.reshape(-1, pose_record.SIZE), table, strict=True
    ):
        origin = np.array(stands[0]) + axes.apply(part['at'])
        turn = (axes * Rotation.from_quat(part['turn'])).as_matrix()
        # round-off of products of three rotations and of lengths below 20 m
        assert origin == pytest.approx(pose[:3], abs=5e-14)
        assert turn == pytest.approx(pose[3:].reshape(3, 3), abs=5e-15)
        form = drawn.forms[part['form']]
        if form == points:
            assert isinstance(shape, Particle)
            continue
        assert same_geometry(
            form, row[0], colliders.shape_parameters[row[collider_record.PARAMETERS] :], held
        )
        if form['type'] == 'surface':
            corners = pose[:3] + surface(form, held)[0] @ turn.T
            farthest = np.linalg.norm(corners - stands[0], axis=1).max()
            assert reach(body) >= farthest * (1.0 - 1e-6)  # single precision of the page


def test_the_point_masses_of_a_body_are_drawn_where_its_axes_carry_them():
    turn = Rotation.from_euler('xyz', (0.3, -0.4, 1.0))
    points = np.array([[1.0, 0, 0], [0, 2.0, 0]])
    body = Body(
        name='b',
        shape=Union(
            (
                Part(Particles(points, np.ones(2)), orientation=tuple(turn.as_quat())),
                Part(Particle(), mass=1.0, position=(0.0, 0.0, 3.0)),
            )
        ),
        mass=3.0,
        center_of_mass=(0.1, 0.2, 0.3),
    )
    places = [part['at'] for part in drawing()[0].parts(body)]
    wanted = np.vstack((turn.apply(points), [0, 0, 3])) - body.center_of_mass
    assert places == pytest.approx(wanted, abs=1e-15)  # round-off
    assert reach(body) == pytest.approx(np.linalg.norm(wanted, axis=1).max(), rel=1e-15)


def test_equal_shapes_stand_in_the_page_once():
    drawn, _ = drawing(meshes_collide=False)
    again = Mesh(CORNERS, FACES, name='another')
    for shape in (Sphere(0.5), Mesh(CORNERS, FACES), again, Sphere(0.5), Box((1.0, 1.0, 1.0))):
        parts = (Part(shape), Part(shape, position=(1.0, 0.0, 0.0)))
        drawn.parts(Body(name='b', shape=Union(parts), mass=1.0))
    assert [form['type'] for form in drawn.forms] == ['sphere', 'surface', 'box']


@pytest.mark.parametrize('collide', [True, False])
def test_a_hollow_mesh_is_drawn_by_its_faces_and_where_it_collides_its_hull_too(collide):
    drawn, held = drawing(meshes_collide=collide)
    body = Body(name='b', shape=DENTED, mass=1.0)
    mesh, *hull = drawn.parts(body)
    vertices, faces = surface(drawn.forms[mesh['form']], held)
    assert np.array_equal(vertices, DENTED.vertices.astype('<f4'))
    assert np.array_equal(faces.reshape(-1, 3), DENTED.faces)
    assert [part.get('translucent', False) for part in hull] == [True] * collide
    for part in hull:
        assert same_points(surface(drawn.forms[part['form']], held)[0], CORNERS, within=0.0)


def test_points_in_a_plane_are_drawn_although_they_span_no_solid():
    flat = ConvexHull([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    drawn, held = drawing(meshes_collide=False)
    (part,) = drawn.parts(Body(name='b', shape=flat, mass=1.0))
    assert len(surface(drawn.forms[part['form']], held)[0]) == 4


def test_a_plane_is_drawn_where_contact_has_it():
    turn = Rotation.from_euler('xyz', (0.3, 0.2, -1.0)).as_quat().tolist()
    initial = {'position': [1, 2, 3], 'orientation': turn}
    plane = {'type': 'plane', 'normal': [0, 1, 2], 'offset': 0.5}
    scene = load_scene(
        {
            'dt': 0.01,
            'contact': {'mode': 'timestep'},
            'bodies': [
                {'name': 'wall', 'shape': plane, 'initial': initial},
                {'name': 'ball', 'shape': {'type': 'sphere', 'radius': 1}, 'mass': 1},
            ],
        }
    )
    (found,) = drawn_planes(scene)
    known = Colliders.of(scene, Layout(scene)).shape_parameters[:4]
    # round-off of lengths of 3 m
    assert [*found['normal'], found['offset']] == pytest.approx(known, abs=4e-15)


LINK = """<robot name="hammer"><link name="hammer">
<inertial><origin xyz="0.3 0.05 0.02"/><mass value="1"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial>
<collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.06 0.04"/></geometry></collision>
<collision><origin xyz="0.4 0 0.02" rpy="0 0 0.5"/><geometry><box size="0.1 0.2 0.1"/></geometry>
</collision></link></robot>
"""
SCENE = """
version: 1
name: bodies of parts
dt: 0.002
gravity: [0, 0, -9.81]
contact: {mode: timestep}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: hammer
    urdf: hammer.urdf
    initial: {position: [0, 0, 0.2], orientation: [0.1, 0.2, 0, 1]}
  - name: lopsided
    shape: {type: box, size: [0.1, 0.1, 0.3]}
    mass: 1
    center_of_mass: [0, 0, -0.1]
    initial: {position: [-0.05, 0, 0.3], velocity: [0, 0, -1]}
  - name: joined
    shape:
      type: union
      parts:
        - {shape: {type: sphere, radius: 0.1}, mass: 1, position: [0.2, 0, 0]}
        - shape: {type: box, size: [0.1, 0.2, 0.3]}
          mass: 1
          position: [-0.2, 0, 0.1]
          orientation: [0, 0.38268343, 0, 0.92387953]
    initial: {position: [0.3, 0.1, 0.6], angular_velocity: [3, 2, 1]}
"""


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    """The page of half a second in which the bodies fall upon each other."""
    folder = tmp_path_factory.mktemp('parts')
    (folder / 'hammer.urdf').write_text(LINK)
    (folder / 'parts.yaml').write_text(SCENE)
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = [folder / 'parts.yaml', '-o', folder / 'bag', '--duration', '0.5', '--contacts']
    words += ['--publish-rate', '500', '--json']
    assert simulate.run(parser.parse_args([*map(str, words)])) == 0
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    assert view.run(parser.parse_args([str(folder / 'bag'), '-o', str(folder / 'run.html')])) == 0
    return folder / 'run.html'


def poses_of(run):
    """Positions and orientations (k, n, 7) of the bodies."""
    return np.concatenate((run.positions, run.of_bodies('orientation')), axis=2)


def height_above(form, point):
    """Distance of a point from the surface of a ball or box [m], shape axes; inside negative."""
    if form['type'] == 'sphere':
        return np.linalg.norm(point) - form['radius']
    outside = np.abs(point) - 0.5 * np.array(form['size'])
    return np.linalg.norm(np.maximum(outside, 0.0)) + min(outside.max(), 0.0)


def seen_from(part, pose, point):
    """Return a point of the world in the axes of a drawn part."""
    in_body = Rotation.from_quat(pose[3:]).inv().apply(point - pose[:3])
    return Rotation.from_quat(part['turn']).inv().apply(in_body - part['at'])


def heights_above(run, poses, point):
    """Distance of a point of the world from the surface of each body, the first a ground [m]."""
    return [abs(point[2])] + [
        min(
            abs(height_above(run['forms'][part['form']], seen_from(part, pose, point)))
            for part in body['parts']
        )
        for body, pose in zip(run['bodies'][1:], poses[1:], strict=True)
    ]


def is_at_edge(run, number, pose, point):
    """Whether a point of the world is at an edge of a body of boxes, to a millimetre."""
    beside = []
    for part in run['bodies'][number]['parts']:
        form = run['forms'][part['form']]
        if form['type'] == 'box':
            outside = np.abs(seen_from(part, pose, point)) - 0.5 * np.array(form['size'])
            beside.append(np.sort(np.abs(outside))[1])
    return bool(beside) and min(beside) < 1e-3


def moved(before, after, point):
    """Way of the point of a body that is now at a point of the world, between two poses [m]."""
    arm = Rotation.from_quat(after[3:]).inv().apply(point - after[:3])
    return point - before[:3] - Rotation.from_quat(before[3:]).apply(arm)


def test_each_arrow_begins_on_the_drawn_surface_of_a_body_that_can_move(page):
    """
    A point of contact goes with the one body that can move, or half with each of two.

    So it stays on the surface of the one; and it leaves those of two by up to half of the way
    that they slide along each other in the tick, all of it where an edge slides across an edge.
    """
    run = PageOf(page)
    poses, starts = poses_of(run), run.array(run['contacts']['starts'])
    assert np.allclose(np.diff(run.times), 0.002)  # [s] each tick
    arrows = run.array(run['contacts']['arrows']).reshape(-1, 6)
    met = set()
    for i in range(1, len(poses)):
        for point in arrows[starts[i] : starts[i + 1], :3].astype(float):
            heights = heights_above(run, poses[i], point)
            other, body = sorted(np.argsort(heights)[:2].tolist())
            ways = [moved(poses[i - 1, k], poses[i, k], point) for k in (other, body)]
            slid = np.linalg.norm(ways[1] - ways[0]) if other else 0.0
            across = all(is_at_edge(run, k, poses[i, k], point) for k in (other, body) if k)
            share = 1.0 if across and other else 0.5
            # single precision below 1 m; of second order 0.02 of the way: no body turns by more
            assert heights[body] < 3e-7 + 1.02 * share * slid, (i, other, body)
            met.add((other, body))
    assert met == {(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)}


def test_a_browser_puts_each_part_where_contact_would_find_it(tab, page):
    run = PageOf(page)
    tab.open(f'{page.as_uri()}#paused')
    tab.wait_for("document.body.dataset.state === 'ready'")
    scene = load_scene(page.parent / 'parts.yaml', files={'hammer.urdf': LINK.encode()})
    for instant in (0, len(run.times) - 1):
        tab.evaluate(f'view.seek({float(run.times[instant])!r})')
        matrices, distinct = tab.evaluate('[view.bodies.matrices(), view.bodies.forms.length]')
        assert tab.errors == []
        assert distinct == len(run['forms'])
        bodies = tuple(
            replace(body, initial=Motion(position=tuple(pose[:3]), orientation=tuple(pose[3:])))
            for body, pose in zip(scene.bodies, poses_of(run)[instant], strict=True)
        )
        moved_there = replace(scene, bodies=bodies)
        colliders = Colliders.of(moved_there, Layout(moved_there))
        wanted = colliders.poses.reshape(-1, pose_record.SIZE)[1:]  # the ground has no parts
        found = np.array([each for group in matrices for each in group]).reshape(-1, 4, 4)
        assert len(found) == len(wanted) == 5
        # columns of the library are rows here; single precision, below 1 m
        assert found[:, 3, :3] == pytest.approx(wanted[:, :3], abs=1e-6)
        turns = found[:, :3, :3].transpose(0, 2, 1)
        assert turns == pytest.approx(wanted[:, 3:].reshape(-1, 3, 3), abs=1e-6)


MOMENTS = st.tuples(*[st.floats(0.1, 3.0)] * 3)  # squares of sizes over 6, whatever they are


@settings(max_examples=25)
@given(squares=MOMENTS, turn=TURNS, mass=st.floats(0.1, 50.0), alike=st.booleans())
def test_a_body_without_a_shape_is_drawn_as_a_solid_of_its_inertia(squares, turn, mass, alike):
    a, b, c = squares
    b = a if alike else b
    axes = Rotation.from_quat(turn).as_matrix()
    inertia = axes @ np.diag(mass * np.array((b + c, a + c, a + b))) @ axes.T
    form, drawn_turn = inertia_form(mass, inertia)
    if form['type'] == 'box':
        x, y, z = np.square(form['size']) / 12.0  # I_x = m (y^2 + z^2) / 12
    else:
        x, y, z = np.square(form['radii']) / 5.0  # I_x = m (y^2 + z^2) / 5
        assert alike or min(abs(a - b), abs(b - c), abs(c - a)) < 1e-5
    back = Rotation.from_quat(drawn_turn).as_matrix()
    again = back @ np.diag(mass * np.array((y + z, x + z, x + y))) @ back.T
    # round-off, twelve digits of the largest; a side thinner than a fiftieth is drawn thicker
    if min(x, y, z) > 0.02**2 * max(x, y, z) * 1.01:
        assert np.allclose(again, inertia, rtol=0, atol=1e-12 * np.trace(inertia))
