# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What only shows when a run is made of a scene is told with file, place and line as well."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.__main__ import main
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene.refusal import refusal

STATED = 'mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}, center_of_mass: [0.5, 0.5, 0]'
FLAT = 'shape: {type: convex_hull, vertices: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]}'
BALL = 'name: ball, shape: {type: sphere, radius: 1}, mass: 1'
CUBE = 'shape: {type: box, size: [1, 1, 1]}, mass: 1'
LINK = """<robot name="sheet"><link name="sheet"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><mesh filename="flat.off"/></geometry></collision></link></robot>
"""
SQUARE = 'OFF\n4 4 6\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n3 0 2 1\n3 0 3 2\n'


def written(folder: Path, *lines: str, contact: bool = True) -> Path:
    """Write a scene file whose bodies begin in line 4."""
    mode = 'timestep' if contact else 'none'
    head = ['dt: 0.004', f'contact: {{mode: {mode}}}', 'bodies:']
    (folder / 'slip.yaml').write_text('\n'.join([*head, *lines]) + '\n')
    (folder / 'sheet.urdf').write_text(LINK)
    (folder / 'flat.off').write_text(SQUARE)
    return folder / 'slip.yaml'


def refused(path: Path) -> str:
    """Return the line with which a scene that can be read is refused as a run."""
    scene = load_scene(path)
    with pytest.raises(UserError) as caught:
        simulation_of(scene)
    assert '\n' not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ('lines', 'place', 'reason', 'line'),
    [
        ((f'  - {{{BALL}}}', f'  - {{name: b, {STATED},', f'     {FLAT}}}'),
         'bodies[1].shape', "'b' cannot collide: convex hull: 4 distinct points", 6),
        ((f'  - {{{BALL}}}', f'  - name: tile_x\n    {FLAT}\n    mass: 1',
          '    inertia: {ixx: 1, iyy: 1, izz: 1}\n    center_of_mass: [0, 0, 0]',
          '    repeat: {count: [2, 1, 1], spacing: [3, 0, 0]}'),
         'bodies[1].shape', "'tile_x_1' cannot collide: convex hull: 4 distinct points", 6),
        ((f'  - {{{BALL}}}', '  - {name: sheet, urdf: sheet.urdf}'),
         'bodies[1]', "'sheet' cannot collide: mesh 'flat.off': 4 distinct points", 5),
        ((f'  - {{{BALL}}}', 'integrator:', '  rk4'),
         'integrator', "integrator 'rk4' refuses the scene 'slip': with contact", 6),
        (('  - {name: dot, shape: {type: particle}, mass: 1}', 'forces:',
          '  - {type: drag, body: dot, linear: 1}',
          '  - {type: constant, body: dot, torque: [1, 0, 0]}'),
         'forces[1]', "force constant: 'dot' is a point mass", 7),
    ],
    ids=['hull', 'copy', 'urdf', 'integrator', 'force'],
)  # fmt: skip
def test_a_run_that_cannot_be_made_names_file_place_and_line(
    tmp_path: Path, lines: tuple[str, ...], place: str, reason: str, line: int
) -> None:
    path = written(tmp_path, *lines)
    said = refused(path)
    assert said.startswith(f'{path}: {place}: {reason}')
    assert said.endswith(f'(line {line})')


def test_the_command_line_says_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, f'  - {{name: b, {STATED}, {FLAT}}}')
    words = ['simulate', str(path), '-o', str(tmp_path / 'bag'), '--duration', '1']
    assert main(words) == 2
    said = capsys.readouterr().err
    assert f"{path}: bodies[0].shape: 'b' cannot collide" in said
    assert not (tmp_path / 'bag').exists()


def test_what_the_caller_chose_is_no_fault_of_the_file(tmp_path: Path) -> None:
    scene = load_scene(written(tmp_path, f'  - {{{BALL}}}', 'integrator: dmv6'))
    for name, reason in (('rk4', 'refuses the scene'), ('rk5', 'is unknown')):
        with pytest.raises(InvalidModel, match=f'^integrator {name!r} {reason}'):
            simulation_of(scene, integrator=name)
    with pytest.raises(InvalidModel, match=r'^-1.0 s'):
        simulation_of(scene, dt=-1.0)


def test_a_lone_urdf_file_is_named_without_a_line_of_what_nobody_wrote(tmp_path: Path) -> None:
    written(tmp_path)
    scene = load_scene(tmp_path / 'sheet.urdf')
    said = refusal(scene, InvalidModel('too thin', at=('bodies', 0, 'shape')))
    assert str(said) == f'{tmp_path / "sheet.urdf"}: bodies[0]: too thin'


def test_a_scene_that_nobody_wrote_is_refused_by_physics_alone() -> None:
    scene = load_scene({'dt': 0.01, 'bodies': [{'name': 'b', 'mass': 1, 'shape': {'type': 'sphere',
        'radius': 1}}], 'contact': {'mode': 'timestep'}, 'integrator': 'rk4'})  # fmt: skip
    with pytest.raises(InvalidModel) as caught:
        Simulation(scene)
    assert caught.value.at == ('integrator',)
    with pytest.raises(UserError, match=r"^scene: integrator: integrator 'rk4' refuses") as told:
        simulation_of(scene)
    assert 'line' not in str(told.value)


def test_a_density_that_varies_over_a_flat_hull_is_the_fault_of_the_shape(tmp_path: Path) -> None:
    of_density = 'density: {at_origin: 1, gradient: [0, 0, 0]}'
    path = written(tmp_path, f'  - {{name: b, {FLAT}, {of_density}}}', contact=False)
    with pytest.raises(UserError, match=r'bodies\[0\]\.shape: 4 vertices span no volume'):
        load_scene(path)
    falls = CUBE.replace('mass: 1', 'density: {at_origin: 1, gradient: [9, 0, 0]}')
    with pytest.raises(UserError, match=r'bodies\[0\]\.density: the density falls to'):
        load_scene(written(tmp_path, f'  - {{name: b, {falls}}}', contact=False))
