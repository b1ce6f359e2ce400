# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A mesh that collides as convex parts: hollow where it is hollow, with the mass of the mesh.
"""

import json

import numpy as np
import pytest

from rigid_body_sim.errors import UserError
from rigid_body_sim.missing_packages import missing
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene

CORNERS = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]  # an L, seen along y


def angle():
    """
    OBJ of an L-shaped prism, 1 m thick.
    """
    lines = [f'v {x} {y} {z}' for y in (0, 1) for x, z in CORNERS]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
    faces = [*caps, *((c + 6, b + 6, a + 6) for a, b, c in caps)]
    for k in range(6):
        a, b = k, (k + 1) % 6
        faces += [(b, a, a + 6), (b, a + 6, b + 6)]
    return '\n'.join([*lines, *(f'f {a + 1} {b + 1} {c + 1}' for a, b, c in faces)]).encode()


def block(low, high):
    return [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
            for z in (low[2], high[2])]  # fmt: skip


PARTS = {'concavity': 0.05, 'parts': [block((0, 0, 0), (2, 1, 1)), block((0, 0, 1), (1, 1, 2))]}
FILES = {'angle.obj': angle(), 'angle.obj.parts_0.05.json': json.dumps(PARTS).encode()}
SCENE = """
dt: 0.004
gravity: [0, 0, -9.81]
contact: {{mode: timestep}}
bodies:
  - name: angle
    fixed: {fixed}
    mass: 6.0
    shape: {{type: mesh, file: angle.obj, {how}}}
  - {{name: ball, shape: {{type: sphere, radius: 0.2}}, mass: 1,
     initial: {{position: {place}}}}}
"""


def loaded(how='as: parts', *, fixed='true', files=FILES):
    # the centre of mass of three blocks of 2 kg: at 5/6 along x and z
    place = np.array([1.5, 0.5, 1.3]) - [5 / 6, 0.5, 5 / 6]
    text = SCENE.format(how=how, fixed=fixed, place=place.tolist())
    return load_scene(text.encode(), files=files)


def test_ball_lies_in_the_corner_of_a_mesh_of_parts_and_not_of_its_hull():
    hollow, full = Simulation(loaded()), Simulation(loaded('as: hull'))
    for sim in (hollow, full):
        sim.step(250)
    # on the step at z = 1, 0.1 m below where it began; the sink of rest is 1e-6 m
    assert hollow.state.position[1, 2] == pytest.approx(1.2 - 5 / 6, abs=1e-5)
    assert np.linalg.norm(full.state.position[1] - hollow.state.position[1]) > 0.05
    assert any('convex hull' in line for line in full.warnings())
    assert not hollow.warnings()


def test_mass_properties_are_those_of_the_mesh():
    parts, hull = (loaded(how, fixed='false').bodies[0] for how in ('as: parts', 'as: hull'))
    assert parts.mass == hull.mass
    assert np.array_equal(parts.inertia, hull.inertia)
    assert parts.center_of_mass == pytest.approx((5 / 6, 0.5, 5 / 6), abs=1e-12)


def test_bag_keeps_the_parts_so_that_a_replay_needs_no_decomposition():
    scene = loaded()
    assert set(scene.files) == set(FILES)
    again = load_scene(scene.source, files=scene.files)
    sims = [Simulation(each) for each in (scene, again)]
    for sim in sims:
        sim.step(50)
    assert sims[0].state_bytes() == sims[1].state_bytes()


def test_decomposition_holds_the_mesh_to_its_concavity(tmp_path, monkeypatch):
    pytest.importorskip('coacd')
    monkeypatch.setenv('RIGID_BODY_SIM_CACHE', str(tmp_path))
    only = {'angle.obj': FILES['angle.obj']}
    first = loaded(files=only)
    assert 2 <= len(first.bodies[0].shape.parts) <= 4
    assert len(list((tmp_path / 'parts').iterdir())) == 1
    again = loaded(files=only)
    assert first.files == again.files
    sim = Simulation(first)
    sim.step(250)
    # concavity 0.05 of half the box of 2 m
    assert sim.state.position[1, 2] == pytest.approx(1.2 - 5 / 6, abs=0.05)


@pytest.mark.parametrize(
    ('how', 'files', 'said'),
    [
        ('as: part', FILES, "did you mean 'parts'?"),
        ('concavity: 0.1', FILES, 'set as: parts'),
        ('as: parts, concavity: 2', FILES, 'from 0.01 to 1.0'),
        ('as: parts', FILES | {'angle.obj.parts_0.05.json': b'{}'}, 'holds no parts'),
    ],
)
def test_parts_that_cannot_be_are_refused(how, files, said):
    with pytest.raises(UserError) as caught:
        loaded(how, files=files)
    assert said in str(caught.value)


def test_missing_package_is_named_with_what_needs_it():
    assert 'pip install coacd' in missing('coacd')
    assert 'as: parts' in missing('coacd')


def test_parts_are_kept_in_the_first_cache_that_can_be_written(tmp_path, monkeypatch):
    stands_for = tmp_path / 'coacd.py'  # the library, which takes seconds and may be absent
    stands_for.write_text(
        'calls = []\n'
        'def set_log_level(level): pass\n'
        'def Mesh(vertices, faces): return vertices\n'
        'def run_coacd(vertices, **how):\n'
        '    calls.append(how)\n'
        '    return [(vertices, None)]\n'
    )
    (tmp_path / 'no folder').touch()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv('RIGID_BODY_SIM_CACHE', str(tmp_path / 'no folder' / 'cache'))
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'shared'))
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    files = {'angle.obj': FILES['angle.obj']}
    for _ in range(2):
        loaded(files=files)
    import coacd

    assert len(coacd.calls) == 1
    assert len(list((tmp_path / 'shared/rigid_body_sim/parts').iterdir())) == 1
    assert not (tmp_path / 'home').exists()
