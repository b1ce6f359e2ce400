# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What of a scene collides, where it is, and how large it is.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision import bounds_record, collider_record
from rigid_body_sim.physics.contact.collision import pose as pose_record
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    HULL,
    PLANE,
    SPHERE,
    Colliders,
    world_aabb,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.pairs import collide_kernel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.scene import Body, Material, Motion, Scene
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Particle,
    Particles,
    Plane,
    Sphere,
)
from rigid_body_sim.physics.state.layout import Layout

TURN = (0.1, 0.7, -0.5, 0.5)  # xyzw; made a unit quaternion below
CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [0.1, 0.9, 0.0], [0.2, 0.1, 0.8]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def body(name, shape, *, fixed=False, **more):
    motion = Motion((1.0, -2.0, 3.0), tuple(so3.normalise(TURN).tolist()))
    if fixed:
        return Body(name, shape, 0.0, fixed=True, initial=motion, **more)
    if isinstance(shape, Particle):
        return Body(name, shape, 1.0, initial=motion, **more)
    mass = of_shape(shape, mass=4.0)
    return Body(
        name,
        shape,
        4.0,
        center_of_mass=tuple(mass.center_of_mass.tolist()),
        inertia=mass.inertia,
        initial=motion,
        **more,
    )


def colliders(*bodies):
    scene = Scene('scene', 1_000_000, bodies)
    return Colliders.of(scene, Layout(scene))


SOLIDS = {
    SPHERE: Sphere(0.3),
    CAPSULE: Capsule(0.2, 0.7),
    BOX: Box((0.4, 0.6, 1.0)),
    CYLINDER: Cylinder(0.3, 0.8),
    HULL: ConvexHull(CORNERS),
    PLANE: Plane((0.0, 0.0, 1.0), 0.5),
}


def test_each_solid_is_one_collider_in_scene_order_and_the_rest_is_none():
    empty = body('dust', Particles(CORNERS, np.ones(4)))
    shapeless = Body('ghost', None, 1.0)
    found = colliders(
        *(body(f'b{kind}', shape, fixed=kind == PLANE) for kind, shape in SOLIDS.items()),
        empty,
        shapeless,
        body('mesh', Mesh(CORNERS, FACES)),
        body('point', Particle()),
        body('wall', Box((1.0, 1.0, 1.0)), fixed=True),
    )
    assert found.types.tolist() == [*SOLIDS, HULL, SPHERE, BOX]
    assert found.table.reshape(-1, collider_record.SIZE)[
        :, collider_record.SCENE_INDEX
    ].tolist() == [0, 1, 2, 3, 4, 5, 8, 9, 10]
    # moving bodies in core order: rigid ones first (the dust is one, the ghost is a point mass)
    assert found.bodies.tolist() == [0, 1, 2, 3, 4, -1, 6, 8, -1]


def test_equal_hulls_share_one_record():
    one = colliders(body('a', ConvexHull(CORNERS)))
    four = colliders(*(body(f'b{i}', Mesh(CORNERS, FACES)) for i in range(4)))
    assert np.array_equal(one.shape_parameters, four.shape_parameters)
    assert set(four.table[collider_record.PARAMETERS :: collider_record.SIZE].tolist()) == {0}


def test_the_hull_of_equal_shapes_is_found_once(monkeypatch):
    found = []
    hull = hulls.hull
    monkeypatch.setattr(hulls, 'hull', lambda *a, **k: found.append(1) or hull(*a, **k))
    mesh = Mesh(CORNERS, FACES)
    equal = (body(f'c{i}', ConvexHull(CORNERS.copy())) for i in range(5))
    colliders(*(body(f'b{i}', mesh) for i in range(5)), *equal)
    assert len(found) == 2


def test_cylinder_is_given_as_a_prism_only_where_a_pair_needs_it():
    cylinder = body('c', SOLIDS[CYLINDER])
    ground = body('g', SOLIDS[PLANE], fixed=True)
    assert (
        colliders(cylinder, ground, body('s', SOLIDS[SPHERE])).shape_parameters.size == 2 + 4 + 1
    )
    assert colliders(cylinder, body('h', SOLIDS[HULL])).shape_parameters.size > 100


@pytest.fixture
def share_kernels():
    """
    Nothing: here pairs are asked for themselves.
    """


def test_pairs_are_those_that_can_meet():
    ground, wall = body('g', SOLIDS[PLANE], fixed=True), body('w', SOLIDS[BOX], fixed=True)
    assert colliders(ground, wall).pairs() == ()
    assert colliders(ground, wall, body('s', SOLIDS[SPHERE])).pairs() == (
        (SPHERE, BOX),
        (SPHERE, PLANE),
    )
    two = colliders(ground, body('s', SOLIDS[SPHERE]), body('t', SOLIDS[SPHERE]))
    assert two.pairs() == ((SPHERE, SPHERE), (SPHERE, PLANE))


def test_pose_at_the_start_is_the_shape_in_the_world():
    """By `mounts` from the centre of mass and the principal axes, as a tick computes it."""
    record = body('h', SOLIDS[HULL])
    scene = Scene('scene', 1_000_000, (record,))
    layout = Layout(scene)
    found = Colliders.of(scene, layout)
    world = np.asarray(record.initial.position) + so3.rotate(
        record.initial.orientation, CORNERS - np.asarray(record.center_of_mass)
    )
    origin, turn = found.poses[:3], found.poses[3:].reshape(3, 3)
    assert np.allclose(origin + CORNERS @ turn.T, world, rtol=0.0, atol=1e-14)
    center, mount = found.local_poses[:3], found.local_poses[3:].reshape(3, 3)
    q = so3.multiply(record.initial.orientation, layout.principal[0])
    again = so3.matrix_from_quaternion(q) @ mount
    assert np.allclose(again, turn, rtol=0.0, atol=1e-14)
    assert np.allclose(record.initial.position - again @ center, origin, rtol=0.0, atol=1e-14)


def test_plane_is_where_its_body_is():
    found = colliders(body('g', Plane((0.0, 0.6, 0.8), 0.5), fixed=True))
    normal, offset = found.shape_parameters[:3], found.shape_parameters[3]
    motion = body('g', Plane((0.0, 0.6, 0.8), 0.5), fixed=True).initial
    assert np.allclose(normal, so3.rotate(motion.orientation, (0.0, 0.6, 0.8)), atol=1e-15)
    on_it = np.asarray(motion.position) + so3.rotate(motion.orientation, (7.0, 0.3, 0.4))
    assert abs(normal @ on_it - offset) < 1e-14


def test_materials_are_kept_in_their_order():
    found = colliders(body('a', SOLIDS[SPHERE], material=Material(0.1, 0.2, 0.3, 0.4)))
    assert found.materials.tolist() == [0.1, 0.2, 0.3, 0.4]


def surface(kind, rng):
    """Points on the surface of a solid, shape axes."""
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    flat = directions[:, :2] / np.linalg.norm(directions[:, :2], axis=1)[:, None]
    match SOLIDS[kind]:
        case Sphere(radius=r):
            return r * directions
        case Capsule(radius=r, length=length):
            return r * directions + np.outer(np.sign(directions[:, 2]), [0, 0, 0.5 * length])
        case Box(size=size):
            return 0.5 * np.asarray(size) * np.sign(directions)
        case Cylinder(radius=r, length=length):
            return np.column_stack((r * flat, 0.5 * length * np.sign(directions[:, 2])))
        case ConvexHull(vertices=vertices):
            return vertices


@pytest.mark.parametrize('kind', [SPHERE, CAPSULE, BOX, CYLINDER, HULL])
def test_bounding_box_and_ball_hold_the_solid_and_are_not_much_larger(kind):
    found = colliders(body('b', SOLIDS[kind]))
    rng = np.random.default_rng(8)
    points = surface(kind, rng)
    for _ in range(50):
        turn = so3.matrix_from_quaternion(so3.normalise(rng.normal(size=4)))
        poses = np.concatenate((rng.normal(size=3), turn.ravel()))
        box = world_aabb(argument(found.local_bounds), 0, argument(poses))
        middle, half = np.array(box)
        away = np.abs(poses[:3] + points @ turn.T - middle)
        assert np.all(away <= half + 1e-14)
        assert np.max(np.linalg.norm(away, axis=1)) <= found.radius[0] + 1e-14
        assert np.all(half <= 2.0 * np.max(away, axis=0))
    assert found.radius[0] <= 1.001 * np.max(
        np.linalg.norm(points - found.local_bounds[:3], axis=1)
    )


def test_plane_has_no_bounds():
    assert np.isinf(
        colliders(body('g', SOLIDS[PLANE], fixed=True)).local_bounds[bounds_record.RADIUS]
    )
    assert pose_record.SIZE == len(colliders(body('g', SOLIDS[PLANE], fixed=True)).poses)


@pytest.mark.parametrize('pair', [(BOX, SPHERE), (PLANE, PLANE), (-1, 0), (SPHERE, 7)])
def test_pair_in_the_wrong_order_is_refused(pair):
    with pytest.raises(ValueError, match='exchange the two'):
        collide_kernel(*pair)


def test_only_the_pair_that_is_asked_for_is_imported():
    program = (
        'import sys\n'
        'from rigid_body_sim.physics.contact.collision.pairs import collide_kernel\n'
        'collide_kernel(0, 5)\n'
        'start = "rigid_body_sim.physics.contact.collision.pairs."\n'
        'print([name[len(start):] for name in sys.modules if name.startswith(start)])\n'
        'print("scipy.spatial" in sys.modules)\n'
    )
    root = Path(__file__).parents[2]
    result = subprocess.run(
        [sys.executable, '-c', program], cwd=root, capture_output=True, text=True, check=True
    )
    assert result.stdout.split('\n')[:2] == ["['sphere_plane']", 'False']
