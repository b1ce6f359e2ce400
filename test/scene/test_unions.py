# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body of several parts: `shape: {type: union, parts: [...]}`."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError

HAMMER = """
dt: 0.001
bodies:
  - name: hammer
    shape:
      type: union
      parts:
        - {shape: {type: cylinder, radius: 0.015, length: 0.3}, density: 700}
        - {shape: {type: box, size: [0.04, 0.04, 0.1]}, mass: 0.6, position: [0, 0, 0.17],
           orientation: [0, 1, 0, 1]}
"""


def test_a_hammer_has_the_mass_center_and_inertia_of_handle_and_head():
    body = load_scene(HAMMER.encode()).bodies[0]
    handle = 700 * math.pi * 0.015**2 * 0.3
    mass = handle + 0.6
    height = 0.6 * 0.17 / mass
    assert body.mass == pytest.approx(mass, rel=1e-14)
    assert body.center_of_mass == pytest.approx((0, 0, height), abs=1e-15)
    # the head lies along x: its turn by a right angle about y swaps x and z
    about_x = handle * (0.015**2 / 4 + 0.3**2 / 12 + height**2)
    about_x += 0.6 * ((0.04**2 + 0.04**2) / 12 + (0.17 - height) ** 2)
    about_z = handle * 0.015**2 / 2 + 0.6 * (0.1**2 + 0.04**2) / 12
    assert np.diag(body.inertia)[[0, 2]] == pytest.approx((about_x, about_z), rel=1e-14)
    Simulation(load_scene(HAMMER.encode())).state  # noqa: B018  (it can be run)


def union(*parts, **more):
    return {
        'dt': 0.001,
        'bodies': [{'name': 'b', 'shape': {'type': 'union', 'parts': list(parts)}, **more}],
    }


PLANE = {'type': 'plane', 'normal': [0, 0, 1]}
BALL = {'shape': {'type': 'sphere', 'radius': 0.1}}


def test_parts_without_a_mass_have_the_density_of_the_body():
    body = load_scene(union(BALL, {**BALL, 'position': [0, 0, 1], 'mass': 2}, density=100)).bodies
    assert body[0].mass == pytest.approx(2 + 100 * 4 / 3 * math.pi * 1e-3)


def test_a_union_of_unions_is_the_union_of_all_their_parts():
    """Whose parts weigh something, or get the density of the nearest union that has one."""
    turn = {'orientation': [0, 0, 1, 1]}  # a right angle about z
    inner = {'type': 'union', 'parts': [{**BALL, 'mass': 1}, {**BALL, 'position': [1, 0, 0]}]}
    middle = {'type': 'union', 'parts': [{'shape': inner, 'position': [0, 0, 2], **turn}]}
    flat = (
        {**BALL, 'mass': 1, 'position': [0, 5, 2]},
        {**BALL, 'density': 300, 'position': [0, 6, 2]},
        {**BALL, 'mass': 3},
    )
    expected = load_scene(union(*flat)).bodies[0]
    part = {'shape': middle, 'position': [0, 5, 0]}
    for nested in (
        union({**part, 'density': 300}, {**BALL, 'mass': 3}),
        union(part, {**BALL, 'mass': 3}, density=300),
    ):
        body = load_scene(nested).bodies[0]
        assert body.mass == pytest.approx(expected.mass, rel=1e-14)
        assert body.center_of_mass == pytest.approx(expected.center_of_mass, abs=1e-14)
        assert body.inertia == pytest.approx(expected.inertia, abs=1e-12)


def test_a_union_whose_mass_center_and_inertia_are_stated_needs_no_masses_of_parts():
    stated = {'inertia': {'ixx': 1, 'iyy': 1, 'izz': 1}, 'center_of_mass': [0, 0, 0.1]}
    body = load_scene(union(BALL, {**BALL, 'position': [0, 0, 1]}, mass=2, **stated)).bodies[0]
    assert (body.mass, body.center_of_mass) == (2.0, (0, 0, 0.1))
    assert np.array_equal(body.inertia, np.eye(3))


def test_a_fixed_union_needs_no_mass():
    body = load_scene(union(BALL, {**BALL, 'position': [0, 0, 1]}, fixed=True)).bodies[0]
    assert body.center_of_mass == pytest.approx((0, 0, 0.5))


@pytest.mark.parametrize(
    ('scene', 'reason'),
    [
        (union(), 'shape: parts is empty; a union needs at least one part'),
        (union(BALL), 'parts[0]: neither mass nor density is given'),
        (
            union({'shape': {'type': 'union', 'parts': [{**BALL, 'mass': 1}, BALL]}}),
            'parts[0]: parts[1]: neither mass nor density is given',
        ),
        (
            union({'shape': {'type': 'union', 'parts': [{**BALL, 'mass': 1}]}, 'mass': 2}),
            'parts[0]: mass 2.0 kg is not the sum of the parts, 1.0 kg',
        ),
        (union(BALL, mass=2), 'a mass of the whole is not shared out; give the part a mass [kg]'),
        (
            union({'shape': {'type': 'plane', 'normal': [0, 0, 1]}}),
            'parts[0]: a plane has no mass',
        ),
        (union({'mass': 1}), 'parts[0]: shape is missing'),
        (union({**BALL, 'mass': 1, 'density': 1}), 'parts[0]: give either mass [kg] or density'),
        (union({**BALL, 'mas': 1}), "parts[0].mas: unknown key; did you mean 'mass'?"),
        (union({**BALL, 'mass': -1}), 'parts[0].mass: got -1.0; a positive number'),
        (union({**BALL, 'mass': 1, 'orientation': [0, 0, 0, 0]}), 'a quaternion of zero length'),
        (union({**BALL, 'mass': 1}, mass=2), 'mass 2.0 kg is not the sum of the parts, 1.0 kg'),
    ],
)
def test_an_impossible_union_is_refused(scene, reason):
    with pytest.raises(UserError) as caught:
        load_scene(scene)
    assert reason in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_union_rests_on_the_ground():
    scene = union({**BALL, 'mass': 1}, {**BALL, 'mass': 1, 'position': [3, 0, 0]})
    scene |= {'contact': {'mode': 'timestep'}, 'gravity': [0, 0, -9.81], 'dt': 0.004}
    ground = {'name': 'g', 'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': -1.5}}
    scene['bodies'] = [*scene['bodies'], ground]
    sim = Simulation(load_scene(scene))
    sim.step(500)
    assert sim.state.position[0, 2] == pytest.approx(BALL['shape']['radius'] - 1.5, abs=1e-4)
