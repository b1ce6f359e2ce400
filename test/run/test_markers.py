# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Markers show each shape where it is, and arrows as long as what acts; what ends is deleted.

Shapes are compared by their support function: h(d) = max d . x over the points of a solid. Equal
support in all directions means equal convex hulls.
"""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim import load_scene
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.placed_parts import placed_parts
from rigid_body_sim.physics.model.reach import reach
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.marker_packing import (
    ADD,
    ARROW,
    CUBE,
    CYLINDER,
    DELETE,
    LINE_LIST,
    SPHERE,
    SPHERE_LIST,
    TRIANGLE_LIST,
    Arrows,
    MarkerPacker,
    Scale,
)
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.runs.scene_markers import MarkerPlaces, forms_of, scale_of

from ..recording.ros_objects import by_rclpy, by_rosbags

TOPIC = Topic('/rigid_body_sim/markers', cdr.MARKERS)
NOTHING = np.zeros((0, 3))
SCALE = Scale(0.5, 2.0, 1.0, 10.0)
DIRECTIONS = rotation.rotate(
    rotation.normalise(np.random.default_rng(1).normal(size=(60, 4))), (0.0, 0.0, 1.0)
)

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.4, 0.4, 0.4]]
PLACED = {'position': [0.3, -0.2, 0.1], 'orientation': [0.5, 0.5, 0.5, 0.5]}
SHAPES = {
    'sphere': {'type': 'sphere', 'radius': 0.3},
    'box': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
    'cylinder': {'type': 'cylinder', 'radius': 0.2, 'length': 0.7},
    'capsule': {'type': 'capsule', 'radius': 0.2, 'length': 0.7},
    'hull': {'type': 'convex_hull', 'vertices': CORNERS},
    'union': {
        'type': 'union',
        'parts': [
            {'shape': {'type': 'capsule', 'radius': 0.1, 'length': 0.5}, **PLACED},
            {'shape': {'type': 'convex_hull', 'vertices': CORNERS}},
        ],
    },
}


def scene_of(shape, contact='none', **more):
    """
    One body of a shape in a scene.
    """
    weight = {'density': 100.0} if shape['type'] == 'union' else {'mass': 2.0}
    body = {'name': 'thing', 'shape': shape, **weight, **more}
    scene = {'version': 1, 'name': 'one', 'dt': 0.001, 'bodies': [body]}
    return load_scene({**scene, 'contact': {'mode': contact}})


class Packer:
    """
    Packs the markers of a scene whose bodies stand at given positions and orientations.
    """

    def __init__(self, scene, scale=SCALE):
        forms = forms_of(scene)
        self._places = MarkerPlaces(forms)
        self.packer = MarkerPacker(
            forms, topic=TOPIC, frame_id='world', scale=scale, first_channel_id=5
        )

    def start(self, *poses):
        return self.packer.pack_start(3, 7, self._poses(poses)[1])

    def pack(self, poses, force, torque, point=NOTHING, contact_force=NOTHING):
        centers, placed = self._poses(poses)
        arrows = Arrows(centers, force, torque, point, contact_force)
        return self.packer.pack(4, 9, placed, arrows)

    def _poses(self, poses):
        positions, turns = (np.array(column, dtype=np.float64) for column in zip(*poses))
        return positions, self._places.poses(positions, turns)


def markers_in(batch):
    """
    The markers of a batch of one message, whose bytes are those of ROS.
    """
    ((_, payload),) = batch.payloads()
    message = cdr.decode(cdr.MARKERS, payload)
    assert payload == cdr.encode(message) == by_rosbags(cdr.MARKERS, message)
    pytest.importorskip('rclpy')
    theirs = by_rclpy(cdr.MARKERS, message)
    assert len(theirs) == len(payload)
    assert cdr.canonical(cdr.decode(cdr.MARKERS, theirs), theirs) == payload
    return message.values['markers']


def corners_of(marker):
    return np.array([list(point.values()) for point in marker['points']])


def support_of_marker(marker):
    """
    Support (k,) [m] of what a viewer draws for a marker, along DIRECTIONS.
    """
    pose, scale = marker['pose'], np.array(list(marker['scale'].values()))
    position = np.array(list(pose['position'].values()))
    turn = np.array(list(pose['orientation'].values()))
    own = rotation.rotate_back(turn, DIRECTIONS)
    match marker['type']:
        case kind if kind == SPHERE:
            assert len(set(scale)) == 1
            reaches = np.full(len(own), 0.5 * scale[0])
        case kind if kind == CUBE:
            reaches = 0.5 * np.abs(own) @ scale
        case kind if kind == CYLINDER:
            assert scale[0] == scale[1]
            flat = np.hypot(own[:, 0], own[:, 1])
            reaches = 0.5 * scale[0] * flat + 0.5 * scale[2] * np.abs(own[:, 2])
        case kind if kind == TRIANGLE_LIST:
            assert tuple(scale) == (1, 1, 1)
            reaches = (corners_of(marker) @ own.T).max(axis=0)
        case kind:
            raise AssertionError(kind)
    return DIRECTIONS @ position + reaches


def support_of_shape(part, directions):
    """
    Support (k,) [m] of a shape from its centre of mass, along directions in body axes.
    """
    shape = part.shape
    own = rotation.rotate_back(part.shape_orientation, directions)
    offset = directions @ np.subtract(part.shape_position, part.center_of_mass)
    flat = np.hypot(own[:, 0], own[:, 1])
    match type(shape).__name__:
        case 'Sphere':
            return offset + shape.radius
        case 'Box':
            return offset + 0.5 * np.abs(own) @ np.array(shape.size)
        case 'Cylinder':
            return offset + shape.radius * flat + 0.5 * shape.length * np.abs(own[:, 2])
        case 'Capsule':
            return offset + shape.radius + 0.5 * shape.length * np.abs(own[:, 2])
        case _:
            return offset + (shape.vertices @ own.T).max(axis=0)


turns = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
places = st.tuples(*[st.floats(-5, 5)] * 3)


@cache
def drawn(kind, contact):
    """
    A scene of one shape, and its packer.
    """
    scene = scene_of(SHAPES[kind], contact)
    return scene, Packer(scene)


@settings(max_examples=40)
@given(st.sampled_from(sorted(SHAPES)), st.sampled_from(['none', 'timestep']), places, turns)
def test_what_is_drawn_is_the_shape_where_it_is(kind, contact, place, turn):
    scene, packer = drawn(kind, contact)
    turn = rotation.normalise(turn)
    batch = packer.start((place, turn))
    ((_, payload),) = batch.payloads()
    markers = cdr.decode(cdr.MARKERS, payload).values['markers']
    found = np.max([support_of_marker(marker) for marker in markers], axis=0)
    own = rotation.rotate_back(turn, DIRECTIONS)
    parts = placed_parts(scene.bodies[0])
    expected = DIRECTIONS @ np.array(place)
    expected += np.max([support_of_shape(part, own) for part in parts], axis=0)
    assert found == pytest.approx(expected, abs=1e-12)  # round-off of rotations of metres


def test_triangles_of_a_hull_look_outwards_and_leave_out_what_lies_inside():
    (form,) = forms_of(scene_of(SHAPES['hull'], 'timestep'))
    corners = form.points.reshape(-1, 3, 3)
    assert {tuple(np.round(corner, 9)) for corner in form.points} == {
        tuple(map(float, corner)) for corner in CORNERS
    }
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside = np.array(CORNERS, dtype=float).mean(axis=0)
    assert np.all(np.sum(normals * (corners[:, 0] - inside), axis=1) > 0.0)


def test_a_plane_is_drawn_in_its_plane_around_the_scene():
    bodies = [
        {
            'name': 'slope',
            'shape': {'type': 'plane', 'normal': [1, 2, 2], 'offset': 0.3},
            'initial': {'position': [1, 0, 0], 'orientation': [0, 0, 0.6, 0.8]},
        },
        {
            'name': 'ball',
            'shape': {'type': 'sphere', 'radius': 0.1},
            'mass': 1.0,
            'initial': {'position': [7, 8, 9]},
        },
    ]
    scene = load_scene({'version': 1, 'name': 'slope', 'dt': 0.001, 'bodies': bodies})
    initial = [(body.initial.position, body.initial.orientation) for body in scene.bodies]
    plane, _ = markers_in(Packer(scene).start(*initial))
    turn = np.array(initial[0][1])
    normal = rotation.rotate(turn, np.array([1, 2, 2]) / 3.0)
    pose = plane['pose']
    corners = np.array(list(pose['position'].values())) + rotation.rotate(
        list(pose['orientation'].values()), corners_of(plane)
    )
    distance = (corners - initial[0][0]) @ normal
    assert distance == pytest.approx(0.3, abs=1e-12)
    assert plane['type'] == TRIANGLE_LIST and len(corners) == 6
    # the ball's foot on the plane lies within the square
    foot = np.array([7, 8, 9]) - ((np.array([7, 8, 9]) - initial[0][0]) @ normal - 0.3) * normal
    assert np.linalg.norm(corners - foot, axis=1).min() > 0.1
    assert corners.mean(axis=0) == pytest.approx(foot, abs=1.0)


def test_points_are_small_balls_and_frames_are_three_axes():
    bodies = [
        {'name': 'stone', 'shape': {'type': 'particle'}, 'mass': 1.0},
        {
            'name': 'dumbbell',
            'shape': {
                'type': 'particles',
                'particles': [
                    {'position': place, 'mass': 1.0} for place in ([0, 0, 0], [1, 0, 0], [0, 1, 0])
                ],
            },
            'frames': {'nose': {'position': [0.1, 0.2, 0.3], 'orientation': [0, 0, 1, 0]}},
        },
    ]
    scene = load_scene({'version': 1, 'name': 'points', 'dt': 0.001, 'bodies': bodies})
    turn = rotation.normalise((1.0, 2.0, 3.0, 4.0))
    poses = [((1, 2, 3), (0, 0, 0, 1)), ((4, 5, 6), turn)]
    stone, dumbbell, nose = markers_in(Packer(scene).start(*poses))
    assert (stone['type'], stone['ns'], stone['id']) == (SPHERE, 'shapes', 0)
    assert (dumbbell['type'], dumbbell['ns'], dumbbell['id']) == (SPHERE_LIST, 'shapes', 1)
    assert len(dumbbell['points']) == 3
    assert (nose['type'], nose['ns'], nose['id']) == (LINE_LIST, 'frames', 0)
    assert [list(color.values()) for color in nose['colors'][::2]] == [
        *([1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1])
    ]
    place = np.array((4, 5, 6)) + rotation.rotate(turn, (0.1, 0.2, 0.3))
    assert list(nose['pose']['position'].values()) == pytest.approx(place, abs=1e-14)
    axes = rotation.rotate(list(nose['pose']['orientation'].values()), corners_of(nose))
    expected = rotation.rotate(turn, np.diag((-1.0, -1.0, 1.0)))
    length = np.linalg.norm(axes[1])
    assert axes[1::2] == pytest.approx(length * expected, abs=1e-14)
    assert not axes[::2].any()


def test_arrows_are_as_long_as_what_acts_and_end_where_it_ends():
    scene = scene_of(SHAPES['box'])
    packer, poses = Packer(scene), [((1, 2, 3), (0, 0, 0, 1))]
    force, none = np.array([[0.0, -3.0, 4.0]]), np.zeros((1, 3))
    point, push = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]), np.array([[0, 0, 2.0], [0, 0, 0]])

    def arrows(*acting):
        batch = packer.pack(poses, *acting)
        return [m for m in markers_in(batch) if m['ns'] != 'shapes']

    first, second, third = arrows(force, none, point, push)
    assert [(m['ns'], m['id'], m['type'], m['action']) for m in (first, second, third)] == [
        ('forces', 0, ARROW, ADD),
        ('contact_forces', 0, ARROW, ADD),
        ('contact_forces', 1, ARROW, ADD),
    ]
    assert corners_of(first) == pytest.approx(np.array([[1, 2, 3], [1, 0.5, 5]]), abs=1e-14)
    assert corners_of(second) == pytest.approx(np.array([[0, 0, 1], [0, 0, 2]]), abs=1e-14)
    assert np.array_equal(*corners_of(third))
    found = arrows(none, force, point[:1], push[:1])
    assert [(m['ns'], m['id'], m['action']) for m in found] == [
        *(('forces', 0, DELETE), ('torques', 0, ADD)),
        *(('contact_forces', 0, ADD), ('contact_forces', 1, DELETE)),
    ]
    found = arrows(none, none)
    assert [(m['ns'], m['action']) for m in found] == [
        ('torques', DELETE),
        ('contact_forces', DELETE),
    ]
    assert arrows(none, none) == []


def test_an_impact_hides_nothing_and_no_number_is_lost():
    scene = scene_of(SHAPES['box'])
    packer, poses = Packer(scene), [((0, 0, 0), (0, 0, 0, 1))]
    for size in (1e308, 1e6):
        force = np.array([[size, 0.0, -size]])
        batch = packer.pack(poses, force, 0.0 * force)
        _, arrow = markers_in(batch)
        ends = corners_of(arrow)
        assert np.linalg.norm(ends[1]) == pytest.approx(SCALE.longest, rel=1e-15)
    tiny = np.array([[5e-324, 0.0, 0.0]])
    batch = packer.pack(poses, tiny, 0.0 * tiny)
    assert np.isfinite(corners_of(markers_in(batch)[1])).all()


@settings(max_examples=40)
@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.integers(0, 4)), max_size=6))
def test_a_viewer_that_saw_all_messages_shows_what_the_last_one_says(steps):
    bodies = [{'name': name, 'shape': SHAPES['box'], 'mass': 1.0} for name in ('a', 'bcd')]
    packer = Packer(load_scene({'version': 1, 'name': 'two', 'dt': 0.001, 'bodies': bodies}))
    poses = [((0, 0, 0), (0, 0, 0, 1))] * 2
    seen = {}
    for one, two, count in steps:
        force = np.array([[float(one), 0, 0], [0, float(two), 0]])
        contacts = np.ones((count, 3))
        batch = packer.pack(poses, force, force[::-1], contacts, contacts)
        ((_, payload),) = batch.payloads()
        markers = cdr.decode(cdr.MARKERS, payload).values['markers']
        assert len({(m['ns'], m['id']) for m in markers}) == len(markers)
        for marker in markers:
            if marker['action'] == DELETE:
                del seen[marker['ns'], marker['id']]
            else:
                seen[marker['ns'], marker['id']] = marker
        shown = [key for key in seen if key[0] != 'shapes']
        expected = [('forces', k) for k, on in enumerate((one, two)) if on]
        expected += [('torques', 1 - k) for k, on in enumerate((one, two)) if on]
        expected += [('contact_forces', k) for k in range(count)]
        assert sorted(shown) == sorted(expected)


def test_the_start_is_shown_without_arrows_and_changes_nothing_after_it():
    scene = scene_of(SHAPES['box'])
    packer, poses = Packer(scene), [((0, 0, 0), (0, 0, 0, 1))]
    force = np.ones((1, 3))
    packer.pack(poses, force, force, force, force)
    shown = packer.packer.shown
    found = markers_in(packer.start(*poses))
    assert [m['action'] for m in found] == [ADD, DELETE, DELETE, DELETE]
    assert packer.packer.shown == shown


def test_a_weight_is_as_long_as_the_largest_body_is_wide():
    scene = scene_of(SHAPES['box'])
    scale, size = scale_of(scene, 0.0), reach(scene.bodies[0])
    assert size == pytest.approx(0.5 * np.sqrt(0.21))
    assert scale.metres_per_newton * 2.0 * 9.80665 == pytest.approx(2.0 * size)
    assert scale.metres_per_newton_metre * size == pytest.approx(scale.metres_per_newton)
    assert scale_of(scene, 3.0).metres_per_newton == 3.0


def test_a_mesh_is_drawn_by_its_own_triangles_where_nothing_meets(tmp_path):
    import trimesh

    ring = trimesh.creation.annulus(r_min=0.2, r_max=0.4, height=0.1, sections=12)
    ring.export(tmp_path / 'ring.stl')
    path = tmp_path / 'ring.yaml'
    text = (
        'version: 1\nname: ring\ndt: 0.001\ncontact: {{mode: {}}}\nbodies:\n'
        '  - {{name: ring, mass: 1.0, shape: {{type: mesh, file: ring.stl}}}}\n'
    )
    counts = {}
    for contact in ('none', 'timestep'):
        path.write_text(text.format(contact))
        (form,) = forms_of(load_scene(path))
        counts[contact] = len(form.points) // 3
        assert form.kind == TRIANGLE_LIST
    assert counts == {'none': len(ring.faces), 'timestep': 44}  # a prism of 12 sides as triangles
