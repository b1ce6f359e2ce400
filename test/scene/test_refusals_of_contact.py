# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scenes of bodies that meet, each with one slip: the line says what, where, got, and the cure."""

from __future__ import annotations

import re
from typing import Any

import pytest

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.contact.settings import ContactSettings
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene

GROUND = '{name: ground, shape: {type: plane, normal: [0, 0, 1]}, friction: 0.5}'
BOX = '{name: box, shape: {type: box, size: [0.2, 0.2, 0.2]}, mass: 1.0}'
FLAT_POINTS = '[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]'
STATED = 'mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}, center_of_mass: [0.25, 0.25, 0.25]'
CORNER = b'OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n'
FILES = {
    'empty.off': b'',
    'blank.stl': b' \n',
    'junk.stl': b'this is no mesh at all\n' * 20,
    'junk.off': b'this is no mesh at all\n' * 20,
    'flat.off': CORNER.replace(b'0 0 1\n3', b'1 1 0\n3', 1),
    'open.off': CORNER.replace(b'4 4 6', b'5 4 6').replace(b'\n3', b'\n0 0 2\n3', 1)[:-2] + b'4\n',
}
EMPTY = 'is empty; a mesh is a closed surface of triangles'


def text(*bodies: str, contact: str = '{mode: timestep}', more: str = '') -> bytes:
    """Write a scene: `contact` stands in line 2, the first body in line 4."""
    lines = ['dt: 0.004', f'contact: {contact}', 'bodies:', *(f'  - {body}' for body in bodies)]
    return '\n'.join([*lines, more]).encode()


def shaped(shape: str, mass: str = 'mass: 1') -> bytes:
    """Write a scene of a ground, and in line 5 a body of this shape."""
    return text(GROUND, f'{{name: b, shape: {{{shape}}}{mass and ", "}{mass}}}')


def refusal(scene: bytes) -> str:
    """Return the one line with which a scene is refused, at the latest before its first tick."""
    with pytest.raises(UserError) as caught:
        simulation_of(load_scene(scene, files=FILES))
    assert '\n' not in str(caught.value)
    return str(caught.value)


def material(slip: str) -> bytes:
    """Write a scene of a ground and a box with one more key."""
    return text(GROUND, f'{BOX[:-1]}, {slip}}}')


SLIPS: tuple[tuple[bytes, str], ...] = (
    (
        material('restitution: -0.5'),
        'bodies[1].restitution: got -0.5; a number [-] from 0.0 to 1.0 is needed (line 5)',
    ),
    (material('friction: .nan'), 'bodies[1].friction: got nan; a finite number [-] is needed'),
    (material('frictoin: 0.5'), "bodies[1].frictoin: unknown key; did you mean 'friction'?"),
    (shaped('type: cone, radius: 1'), "bodies[1].shape.type: shape 'cone' is unknown; allowed: "),
    (shaped('type: box, size: [1, 0, 1]'), 'bodies[1].shape: size along y is 0.0 m; it must be'),
    (shaped('type: box, size: [1, .nan, 1]'), 'shape.size[1]: got nan; a finite number [m]'),
    (
        shaped(f'type: convex_hull, vertices: {FLAT_POINTS}'),
        'bodies[1].shape: 4 vertices span no volume; a convex hull needs at least four points '
        'that do not lie in one plane (line 5)',
    ),
    (
        shaped('type: convex_hull, vertices: [[0, 0, 0], [1, 0, 0], [1, 1, 0]]'),
        'vertices have the shape (3, 3); (n, 3) is needed: at least 4 points of three coordinates',
    ),
    (shaped('type: mesh, file: gone.stl'), "bodies[1].shape.file: 'gone.stl' is not among"),
    (shaped('type: mesh, file: empty.off'), f"bodies[1].shape.file: 'empty.off' {EMPTY}"),
    (shaped('type: mesh, file: blank.stl'), f"'blank.stl' {EMPTY}"),
    (
        shaped('type: mesh, file: junk.stl'),
        "'junk.stl' holds no triangles, read as STL; a mesh is a closed surface of triangles, in "
        'the format of its ending: off, stl, obj, ply (line 5)',
    ),
    (
        shaped('type: mesh, file: junk.off'),
        'lacks the keyword OFF, in capitals, which is to be its first word; write or copy it anew'
        ', or give it the ending of another format: off, stl, obj, ply (line 5)',
    ),
    (
        shaped('type: mesh, file: flat.off'),
        "bodies[1].shape: mesh 'flat.off' encloses 0 m^3 with 2 m^2; a solid needs a finite "
        'volume above zero: give it thickness, or state mass, inertia and center_of_mass (line 5)',
    ),
    (
        shaped('type: mesh, file: open.off'),
        'close the holes, or state mass, inertia and center_of_mass (line 5)',
    ),
    (
        shaped('type: union, parts: []', ''),
        'bodies[1].shape: parts is empty; a union needs at least one part',
    ),
    (
        shaped('type: union', ''),
        'bodies[1].shape: parts is missing; a list of at least one {shape',
    ),
    (
        shaped('type: union, parts: [{shape: {type: sphere, radius: 1}}]', 'mass: 2'),
        'bodies[1].shape: parts[0]: neither mass nor density is given, and a mass of the whole is '
        'not shared out; give the part a mass [kg], or the whole a density [kg/m^3]',
    ),
    (
        shaped('type: plane, normal: [0, 0, 1]', 'fixed: false'),
        'bodies[1].fixed: a plane is always fixed; remove this key or set it to true',
    ),
    (
        shaped('type: plane, normal: [0, 0, 1]', 'initial: {velocity: [1, 0, 0]}'),
        'bodies[1].initial: a fixed body does not move; remove its velocities, or fixed',
    ),
    (
        shaped('type: plane', ''),
        'normal is missing; a list of three numbers [-], out of the solid',
    ),
    (text(BOX, BOX), "bodies[1].name: the name 'box' is taken by an earlier body; names must"),
    (
        text(GROUND, BOX, contact='{mode: timstep}'),
        "contact.mode: contact mode 'timstep' is unknown; did you mean 'timestep'? allowed: none,",
    ),
    (
        text(GROUND, BOX, contact='timestep'),
        "contact: got 'timestep'; a mapping such as {mode: timestep}, with one of none, timestep, "
        'event, is needed (line 2)',
    ),
    *(
        (
            text(GROUND, BOX, contact=f'{{mode: timestep, substeps: {got}}}'),
            f'contact.substeps: got {shown}; a whole number from 1 to 1000 is needed (line 2)',
        )
        for got, shown in (
            ('0', '0'),
            ('2.5', '2.5'),
            ('true', 'True'),
            ('.nan', 'nan'),
            ('.inf', 'inf'),
            ('[4]', '[4]'),
            ('100000', '100000'),
        )
    ),
    (
        text(GROUND, BOX, contact="{mode: timestep, sleeping: 'yes'}"),
        "contact.sleeping: got 'yes'; true or false is needed (line 2)",
    ),
    (
        text(GROUND, BOX, contact='{mode: timestep, sleep_speed: -1}'),
        'contact.sleep_speed: got -1.0; a number [m/s] of at least 0.0 is needed (line 2)',
    ),
    (
        text(GROUND, BOX, contact='{mode: timestep, slop: 1 mm}'),
        "contact.slop: got '1 mm'; a number [m] is needed (line 2)",
    ),
    (
        text(GROUND, BOX, more='integrator: rk4'),
        "scene: integrator: integrator 'rk4' refuses the scene 'scene': with contact a substep "
        'needs one free rotation between its two kicks; take one of: dmv2, ',
    ),
)


@pytest.mark.parametrize(('scene', 'reason'), SLIPS, ids=lambda item: str(item)[-40:])
def test_a_slip_in_a_scene_of_contact_is_named(scene: bytes, reason: str) -> None:
    assert reason in refusal(scene)


def spans_of_flat_hull(*corners: tuple[float, float]) -> list[float]:
    """Return the three spans [m] with which the hull of points in the plane z = 0 is refused."""
    points = ', '.join(f'[{x}, {y}, 0]' for x, y in corners)
    said = re.fullmatch(
        r"scene: bodies\[1\]\.shape: 'b' cannot collide: convex hull: 4 distinct points span "
        r'(\S+) x (\S+) x (\S+) m, no solid; a convex hull needs at least four points that do '
        r'not lie in one plane \(line 5\)',
        refusal(shaped(f'type: convex_hull, vertices: [{points}]', STATED)),
    )
    assert said is not None
    return [float(number) for number in said.groups()]


def test_a_flat_hull_that_is_to_collide_is_refused_with_its_spans() -> None:
    # along its principal axes, which a rectangle has but one pair of
    spans = spans_of_flat_hull((0, 0), (2, 0), (2, 1), (0, 1))
    assert spans == pytest.approx([2.0, 1.0, 0.0], abs=1e-15)


def test_a_flat_hull_of_equal_moments_is_refused_with_spans_along_some_axes() -> None:
    """
    Any two directions at right angles are principal axes of a square, and which a numpy returns is
    its own affair: along x at an angle a to a side it spans |cos a| + |sin a|, the same along y.
    """
    first, second, third = spans_of_flat_hull((0, 0), (1, 0), (1, 1), (0, 1))
    assert first == pytest.approx(second, abs=0.01)  # of three digits
    assert 1.0 <= first <= 2**0.5 + 0.005
    assert third == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        ({'substeps': 0}, 'contact.substeps: got 0; a whole number from 1 to 1000 is needed'),
        ({'relaxations': 101}, 'contact.relaxations: got 101; a whole number from 1 to 100'),
        ({'margin': -1.0}, 'contact.margin: got -1.0; a finite number [m], not negative,'),
        ({'sleep_time': True}, 'contact.sleep_time: got True; a finite number [s], not'),
        ({'sleeping': 1}, 'contact.sleeping: got 1; true or false is needed'),
    ],
)
def test_the_record_of_settings_refuses_the_same(given: dict[str, Any], reason: str) -> None:
    with pytest.raises(InvalidModel) as caught:
        ContactSettings.of(given)
    assert reason in str(caught.value)


def test_the_cure_for_an_open_mesh_is_one() -> None:
    body = load_scene(shaped('type: mesh, file: open.off', STATED), files=FILES).bodies[1]
    assert (body.mass, body.center_of_mass) == (1.0, (0.25, 0.25, 0.25))


def test_a_mesh_without_volume_collides_as_its_hull_with_a_warning() -> None:
    scene = load_scene(shaped('type: mesh, file: open.off', STATED), files=FILES)
    (warning,) = Simulation(scene).scene_warnings
    assert 'as its surface encloses no volume, nobody knows how much of this hull is' in warning
