# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a scene file may be, and what a command line may ask: one line and an exit code, soon."""

from __future__ import annotations

import io
import json
import os
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim.__main__ import main
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.mass_properties import of_shape
from rigid_body_sim.physics.model.shapes import Mesh
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.runs import run
from rigid_body_sim.runs.commands import read_csv
from rigid_body_sim.scene import experiment, load_scene

POINT = 'dt: 0.001\nbodies:\n- {name: a, shape: {type: particle}, mass: %s}\n'
CUBE = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
])  # fmt: skip


def mass(text: str) -> float:
    """
    The mass that a scene file with this text reads.
    """
    return load_scene((POINT % text).encode()).bodies[0].mass


@pytest.mark.parametrize(
    'text',
    ['010', '08', '0x10', '0b11', '0o7', '1_000', '1:30', '1:30.5', '00.5', '"010"', '!!int 010',
     '!!float 1_0.0', '2001-01-01', '1,5', '1/2'],
)  # fmt: skip
def test_what_json_and_c_do_not_call_a_number_is_refused_with_text_and_line(text: str) -> None:
    with pytest.raises(UserError, match=r'bodies\[0\].mass: got .*\(line 3\)') as refused:
        mass(text if text[0] in '"!' or ',' not in text else f'"{text}"')
    assert text.split()[-1].strip('"') in str(refused.value)


@settings(max_examples=40, deadline=None)
@given(st.floats(1e-300, 1e300) | st.integers(1, 10**20))
def test_a_number_of_json_is_that_number(number: float) -> None:
    assert mass(json.dumps(number)) == float(number)


@settings(max_examples=60, deadline=None)
@given(st.text('0123456789', min_size=1, max_size=3), st.text('0123456789xXob_:.eE+-', max_size=4))
def test_a_number_that_is_accepted_is_what_json_reads(begin: str, end: str) -> None:
    text = begin + end
    try:
        found = mass(text)
    except UserError:
        return
    assert found == json.loads(
        f'{text}0' if text.endswith('.') else text.lower().replace('.e', '.0e')
    )


def test_commands_of_a_table_are_numbers_in_the_same_sense(tmp_path: Path) -> None:
    scene = load_scene((POINT % 1).encode())
    (tmp_path / 'c.csv').write_text('time,body,kind,fx\n0.5,a,force,010\n')
    with pytest.raises(
        UserError, match="line 2: fx '010'; allowed: a finite number; write it in decimal"
    ):
        read_csv(tmp_path / 'c.csv', scene, dt_ns=1_000_000)


def test_only_regular_files_of_some_size_are_read(tmp_path: Path) -> None:
    pipe, endless, huge = (tmp_path / name for name in ('pipe', 'zero.yaml', 'huge.yaml'))
    os.mkfifo(pipe)
    endless.symlink_to('/dev/zero')
    huge.touch()
    os.truncate(huge, 2**33)
    for path, reason in (
        (pipe, 'a named pipe'),
        (endless, 'a device'),
        (huge, 'more than 64 MiB'),
        (tmp_path, 'a folder'),
    ):
        with pytest.raises(UserError, match=f'cannot be read: .*{reason}'):
            load_scene(path)
    (tmp_path / 'm.yaml').write_text((POINT % 1).replace('particle', 'mesh, file: zero.stl'))
    (tmp_path / 'zero.stl').symlink_to('/dev/zero')
    with pytest.raises(UserError, match=r'bodies\[0\].shape.file: .*a device'):
        load_scene(tmp_path / 'm.yaml')


def test_aliases_cannot_make_much_of_little() -> None:
    nests = [f'a{i}: &a{i} {{<<: [{", ".join([f"*a{i - 1}"] * 10)}]}}' for i in range(1, 9)]
    bomb = '\n'.join(['a0: &a0 {x: 1}', *nests]).encode()
    with pytest.raises(UserError, match='aliases repeat more than'):
        load_scene(bomb)
    deep = '\n'.join(['a0: &a0 [1]', *(f'a{i}: &a{i} [*a{i - 1}]' for i in range(1, 60))])
    with pytest.raises(UserError, match='nested more than 32 levels deep'):
        load_scene(deep.encode())


def test_an_alias_that_repeats_a_little_is_read() -> None:
    text = POINT.replace('- {', '- &a {').encode() % b'1'
    assert len(load_scene(text + b'- {<<: *a, name: b}\n').bodies) == 2


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ((POINT % 1).replace('name: a', f'name: {"n" * 5000}'), '5000 letters; a body name has'),
        (f'name: {"n" * 5000}\n' + POINT % 1, 'a name is one line of at most 200'),
        ('name: "a\\e[2Jb"\n' + POINT % 1, r'a name is one line of at most 200'),
        (f'{"k" * 900}: 1\n' + POINT % 1, 'unknown key'),
    ],
)
def test_names_are_bounded(text: str, reason: str) -> None:
    with pytest.raises(UserError, match=reason) as refused:
        load_scene(text.encode())
    assert len(str(refused.value)) < 400 and str(refused.value).isprintable()


def test_a_shipped_scene_is_loaded_by_name_and_a_text_is_no_path() -> None:
    assert load_scene('satellite').name == load_scene('satellite.yaml').name
    with pytest.raises(UserError, match="did you mean 'two_bodies'"):
        load_scene('two_bodys')
    with pytest.raises(UserError, match='got a text of 3 lines') as refused:
        load_scene(POINT % 1)
    assert len(str(refused.value)) < 200


@pytest.mark.parametrize(
    ('copies', 'shift', 'reason'),
    [
        (2, 0.0, '12 of its faces stand there more than once'),
        (2, 0.5, 'points inside are counted 2 times'),
        (3, 0.1, 'points inside are counted [23] times'),
    ],
)
def test_a_mesh_that_counts_its_inside_twice_is_refused(
    copies: int, shift: float, reason: str
) -> None:
    vertices = np.concatenate([CUBE + shift * i for i in range(copies)])
    faces = np.concatenate([FACES + (len(CUBE) * i if shift else 0) for i in range(copies)])
    with pytest.raises(InvalidModel, match=reason):
        of_shape(Mesh(vertices, faces), density=1.0)


def test_parts_that_touch_and_hollows_are_counted_right() -> None:
    for inner, turn, volume in ((CUBE + (1, 0.3, 0), 1, 2.0), (0.5 * CUBE + 0.25, -1, 0.875)):
        faces = np.concatenate([FACES, FACES[:, ::turn] + len(CUBE)])
        mesh = Mesh(np.concatenate([CUBE, inner]), faces)
        assert of_shape(mesh, density=1.0).mass == pytest.approx(volume, rel=1e-14)  # round-off


@pytest.mark.parametrize(
    ('words', 'reason'),
    [
        (['simualte'], "did you mean 'simulate'"),
        (['simulate', 'two_bodys', '-o', 'x'], "did you mean 'two_bodies'"),
        (['simulate', 'projectile', '-o', 'x', '--integrator', 'dmv61'], "did you mean 'dmv6'"),
        (['simulate', 'projectile', '-o', 'x', '--integrator', ''], "integrator '' is unknown"),
        (['simulate', 'projectile', '-o', 'x', '--dt', '0'], '0.0 s is not positive'),
        (['simulate', 'projectile', '-o', 'x', '--duration', '1e300'], 'make it shorter'),
        (['simulate', 'projectile', '-o', 'x', '--publish-rate', '1e-300'], 'publish rate'),
        (['simulate', 'projectile', '-o', 'x', '--command-timeout', '1e-300'], '1e-09'),
        (['simulate', 'projectile', '-o', 'y' * 300], 'File name too long'),
        (['simulate', 'projectile', '-o', 'none/such/x'], 'none/such does not exist'),
        (['simulate', 's' * 5000, '-o', 'x'], 'no such file'),
    ],
)
def test_a_slip_on_the_command_line_is_one_line_and_exit_code_two(
    words: list[str],
    reason: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    said = capsys.readouterr().err
    assert reason in said and said.count('\n') == 1
    assert not list(tmp_path.iterdir())


def test_a_terminal_that_knows_ascii_alone_is_written_to(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = io.TextIOWrapper(io.BytesIO(), encoding='ascii')
    monkeypatch.setattr(sys, 'stdout', terminal)
    assert main(['--help']) == 0
    terminal.flush()
    assert b'VERB \\u2026' in terminal.buffer.getvalue()


def test_more_bodies_than_a_scene_or_a_recording_holds_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    few = (POINT % '1, repeat: {count: [5, 1, 1], spacing: [1, 1, 1]}').encode()
    (tmp_path / 'few.yaml').write_bytes(few)
    assert run.MOST_TOPICS == np.iinfo(np.uint16).max  # numbers of channels have 16 bits
    monkeypatch.setattr(run, 'MOST_TOPICS', 19)
    assert main(['simulate', str(tmp_path / 'few.yaml'), '-o', str(tmp_path / 'x')]) == 2
    assert '5 bodies take commands on 25 topics' in capsys.readouterr().err
    monkeypatch.setattr(experiment, 'MOST_BODIES', 4)
    with pytest.raises(UserError, match='more than 4 bodies; make fewer copies'):
        load_scene(few)


def test_an_impossible_domain_is_an_argument(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip('rclpy')
    monkeypatch.setenv('ROS_DOMAIN_ID', '300')
    assert main(['wrench_pub', 'box', '--force', '1', '0', '0']) == 2
    assert "ROS_DOMAIN_ID is '300'" in capsys.readouterr().err


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('value', [1e160, 1.7e308, 5e-324])
@pytest.mark.parametrize('place', ['velocity', 'gravity', 'stiffness', 'time'])
def test_extreme_numbers_raise_nothing_but_what_is_ours(place: str, value: float) -> None:
    scene = {
        'dt': 0.001,
        'gravity': [value if place == 'gravity' else 0.0, 0, 0],
        'bodies': [
            {'name': 'a', 'shape': {'type': 'particle'}, 'mass': 1,
             'initial': {'velocity': [value if place == 'velocity' else 0.0, 0, 0]}},
        ],
        'forces': [
            {'type': 'bumper', 'a': 'a', 'b': 'world', 'length': 1,
             'stiffness': value if place == 'stiffness' else 1.0},
            {'type': 'time', 'body': 'a',
             'table': [[0, 0, 0, 1], [value if place == 'time' else 1.0, 0, 0, 2]]},
        ],
    }  # fmt: skip
    try:
        simulation = Simulation(load_scene(scene))
    except (UserError, InvalidModel):
        return
    assert not np.isnan(simulation.energy())
    simulation.warnings()
    simulation.accelerations()
    simulation.keep_energy_balance()
    with suppress(InvalidModel):
        simulation.apply_impulse('a', linear=(value, 0, 0))


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'gravity': [0, 0, -1e200]}, 'gravity: got 1e.200 m/s.2, whose square .*up to 1e.150'),
        (
            {'forces': [{'type': 'constant', 'body': 'a', 'force': [1e200, 0, 0]}]},
            r'forces\[0\].force: got 1e.200 N, whose square is beyond the numbers',
        ),
        (
            {'forces': [{'type': 'spring', 'a': 'a', 'b': 'world', 'stiffness': 1e308}]},
            r'forces\[0\].stiffness: got 1e.308 N/m, whose square',
        ),
        (
            {'gravity': [0, 0, -1e149], 'bodies': [{'name': 'a', 'mass': 1e152}]},
            r'bodies\[0\].mass: 1e.152 kg in a gravity of 1e.149 m/s.2, 1 m from the origin',
        ),
    ],
)
def test_what_pushes_without_a_finite_energy_is_refused(
    changes: dict[str, object], reason: str
) -> None:
    scene = {'dt': 0.001, 'bodies': [{'name': 'a', 'mass': 1.0}]} | changes
    for body in scene['bodies']:
        body['shape'] = {'type': 'particle'}
    with pytest.raises(UserError, match=reason):
        load_scene(scene)


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('integrator', ['dmv6', 'rk4', 'sdirk2', 'linearly_implicit'])
def test_limits_of_a_speed_beyond_the_numbers_are_looked_at_without_a_word(
    integrator: str,
) -> None:
    ball = {'name': 'a', 'shape': {'type': 'particle'}, 'mass': 1.0}
    drag = {'type': 'drag', 'body': 'a', 'quadratic': 0.1}
    simulation = Simulation(
        load_scene({'dt': 0.001, 'bodies': [ball], 'forces': [drag]}), integrator=integrator
    )
    simulation.apply_impulse('a', linear=(1e200, 0, 0))  # its square is none
    (told,) = (text for text in simulation.warnings() if 'the energy is' in text)
    assert 'inf J by 0 s' in told and 'up to 1e154' in told


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('value', [1e80, 1e100, 1e160])
def test_ground_of_any_size_under_any_weight_raises_nothing_but_what_is_ours(value: float) -> None:
    flat = {'type': 'heightfield', 'spacing': [value, value], 'heights': [[0, 0], [0, 0]]}
    bodies = [
        {'name': 'ground', 'shape': flat, 'fixed': True},
        {
            'name': 'ball',
            'shape': {'type': 'sphere', 'radius': 1},
            'mass': 1,
            'initial': {'position': [0, 0, value]},
        },
    ]
    scene = {'dt': 0.001, 'gravity': [0, 0, -value], 'contact': {'mode': 'timestep'}}
    with suppress(UserError, InvalidModel):
        Simulation(load_scene(scene | {'bodies': bodies}))
