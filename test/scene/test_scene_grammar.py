# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the grammar says of each key of a scene is what the reader does; page and schema are made of
it.

COMPLETE are scenes that hold every key. Each value in them is changed in every way that the
grammar knows of, and reader, schema and grammar must agree.
"""

from __future__ import annotations

import copy
import importlib.util
import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rigid_body_sim.errors import UserError
from rigid_body_sim.scene import document, load_scene
from rigid_body_sim.scene import grammar as g
from rigid_body_sim.scene.shipped_scenes import schema_path, shipped_scenes

ROOT = Path(__file__).parents[2]
KNOWN = g.grammar()
FILES = {
    'tetrahedron.off': (ROOT / 'config/scenes/meshes/tetrahedron.off').read_bytes(),
    'bed.csv': b'0,0,0\n0,0.5,0\n',
    'box.urdf': b'<robot name="r"><link name="l"><inertial><mass value="2"/>'
    b'<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>',
}
PLACED = {'position': [1, 2, 3], 'orientation': [0, 0, 0.6, 0.8]}
WAVE = {'amplitude': 0.5, 'period': 7, 'phase': 0.1}
BOX = {'shape': {'type': 'box', 'size': [1, 2, 3]}, 'mass': 2}


def _scene(*bodies: Any, **keys: Any) -> dict[str, Any]:
    named = [{'name': f'body{i}', **body} for i, body in enumerate(bodies)]
    return {'dt': 0.001, **keys, 'bodies': named}


def _densities() -> Iterator[Any]:
    box, axis = {'type': 'box', 'size': [1, 1, 1]}, [[-0.5, 900], [0.5, 600]]
    yield {'shape': box, 'density': {'type': 'linear', 'at_origin': 250, 'gradient': [0, 0, 100]}}
    yield {'shape': box, 'density': {'at_origin': 250, 'gradient': [0, 0, 100]}}
    terms = [{'coefficient': 900, 'powers': [2, 0, 0]}]
    yield {'shape': box, 'density': {'type': 'polynomial', 'terms': terms}}
    yield {'shape': box, 'density': {'type': 'table', 'along': 'z', 'rows': axis}}


COMPLETE = {
    'scene': _scene(
        BOX, version=1, name='all', gravity=[1, 2, 3], integrator='rk4', orientation='matrix',
        forces=[],
    ),
    'orientation': _scene(
        BOX, integrator={'name': 'rk4', 'substeps': 2},
        orientation={'representation': 'matrix', 'reorthonormalise': True},
    ),
    'bodies': _scene(
        {
            **BOX,
            'initial': {**PLACED, 'velocity': [1, 0, 0], 'angular_velocity': [0, 1, 0]},
            'center_of_mass': [0, 0.1, 0],
            'inertia': {'ixx': 1, 'iyy': 1, 'izz': 1, 'ixy': 0.1, 'ixz': 0.1, 'iyz': 0.1},
            'frames': {'left': PLACED, 'right': None},
            'mass_rate': -0.1, 'exhaust_velocity': [0, 0, -10], 'final_mass': 1,
            'restitution': 0.3, 'friction': 0.7, 'rolling_friction': 0.01,
            'torsional_friction': 0.02,
        },
        {'shape': BOX['shape'], 'density': 100, 'initial': {'angular_velocity_body': [0, 1, 0]}},
        {**BOX, 'mass_rate': -0.1, 'exhaust_velocity': 10},
        {**BOX, 'fixed': True, 'surface_velocity': [1, 0, 0]},
        {**BOX, 'pivot': {'point': [0, 0, 1.5], 'at': [0, 0, 4]}},
        {**BOX, 'repeat': {'count': [2, 1, 1], 'spacing': [3, 3, 3], 'jitter': 0.1}},
        {
            'shape': {'type': 'sphere', 'radius': 1}, 'mass': 1,
            'inertia_over_time': {
                'table': [[0, 1, 1, 1], [1, 2, 2, 2]], 'interpolation': 'linear'
            },
        },
    ),
    'urdf': _scene({'urdf': 'box.urdf'}),
    'motions': _scene(
        {'shape': BOX['shape'], 'motion': dict.fromkeys(g.WAYS, WAVE)},
        {
            'shape': BOX['shape'],
            'motion': {
                'heave': [WAVE, WAVE], 'roll': [WAVE], 'point': [0, 0, 1],
                'table': [[0, 0, 0, 0], [5, 2, 0, 0]],
            },
        },
        {'motion': {'table': [[0, 0, 0, 0, 0, 0, 0], [5, 2, 0, 0, 0, 0, 1]]}},
    ),
    'shapes': _scene(
        {'shape': {'type': 'particle'}, 'mass': 1},
        {'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1},
        {'shape': {'type': 'cylinder', 'radius': 0.1, 'length': 1}, 'density': 100},
        {'shape': {'type': 'capsule', 'radius': 0.1, 'length': 1}, 'density': 100},
        {
            'shape': {
                'type': 'convex_hull', 'vertices': [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
            },
            'mass': 1,
        },
        {'shape': {'type': 'mesh', 'file': 'tetrahedron.off', 'as': 'hull'}, 'mass': 1},
        {'shape': {'type': 'mesh', 'file': 'tetrahedron.off', 'as': 'triangles'}, 'fixed': True},
        {
            'shape': {
                'type': 'heightfield', 'heights': [[0, 0], [0, 1]], 'spacing': [0.5, 1],
                'origin': [1, 2, 3],
            },
            'fixed': True,
        },
        {'shape': {'type': 'heightfield', 'file': 'bed.csv', 'spacing': 0.5}, 'fixed': True},
        {'shape': {'type': 'plane', 'normal': [0, 0, 1], 'offset': -1}},
        {
            'shape': {
                'type': 'particles',
                'particles': [
                    {'mass': m, 'position': [m, m * m, m**3]} for m in (1, 2, 3, 4)
                ],
            }
        },
        {
            'shape': {
                'type': 'union',
                'parts': [
                    {'shape': BOX['shape'], 'mass': 1, **PLACED},
                    {'shape': BOX['shape'], 'density': 100},
                ],
            }
        },
    ),
    'densities': _scene(*_densities()),
    'forces': _scene(
        BOX, BOX,
        forces=[
            {
                'type': 'spring', 'a': 'body0', 'b': 'world', 'stiffness': 10, 'damping': 1,
                'rest_length': 0.5, 'a_point': [1, 0, 0], 'b_point': [1, 0, 5],
            },
            {
                'type': 'bumper', 'a': 'body0', 'b': 'body1', 'stiffness': 10, 'length': 1,
                'a_point': [1, 0, 0], 'b_point': [1, 0, 5],
            },
            {
                'type': 'constant', 'body': 'body0', 'force': [1, 0, 0], 'torque': [0, 1, 0],
                'frame': 'body', 'point': [1, 0, 0],
            },
            {
                'type': 'drag', 'body': 'body0', 'linear': 1, 'quadratic': 1, 'angular': 1,
                'angular_quadratic': 1,
            },
            {
                'type': 'gravity', 'among': ['body0', 'body1'], 'constant': 1e-3,
                'softening': 0.1,
            },
            {
                'type': 'time', 'body': 'body1', 'table': [[0, 1, 0, 0], [1, 2, 0, 0]],
                'interpolation': 'cubic', 'outside': 'hold', 'frame': 'body', 'point': [1, 0, 0],
            },
        ],
    ),
    'contact': _scene(
        BOX, BOX, BOX,
        contact={
            'mode': 'timestep', 'substeps': 2, 'damping_ratio': 1, 'relaxations': 3,
            'restitution_threshold': 0.02, 'slop': 1e-4, 'push_out_speed': 1, 'margin': 0.02,
            'sleeping': True, 'sleep_speed': 0.02, 'sleep_time': 1,
            'ignore': [['body0', 'body1']],
            'pairs': [
                {
                    'bodies': ['body1', 'body2'], 'friction': 0.1, 'restitution': 0.2,
                    'rolling_friction': 0.1, 'torsional_friction': 0.1,
                }
            ],
        },
    ),
    **{
        f'integrator {name}': _scene(
            BOX,
            integrator={'name': name, **{key: each.default for key, each in it.keys.items()}},
        )
        for name, it in KNOWN['integrator'].variants.items()
    },
}  # fmt: skip
for _name in ('bodies', 'motions', 'shapes', 'densities'):  # one body each: quicker
    for _i, _body in enumerate(COMPLETE.pop(_name)['bodies']):
        COMPLETE[f'{_name}_{_i}'] = _scene(_body)
CONCAVITY = _scene({'shape': {'type': 'mesh', 'file': 'x.stl', 'as': 'parts', 'concavity': 0.1}})
JUDGED = (
    'break the triangle inequality',
    'a rigid body needs positive ones',
    'not later than the one before',
    'their places must ascend',
    'it must span the shape',
    'span no volume',
    'a plane needs a finite normal of non-zero length',
    'the density falls to',
    '.density: mass is 0.0 kg',
    'a body that loses mass has a smaller one at the end',
)  # of numbers together, which no key can tell alone


@cache
def validator() -> jsonschema.Draft7Validator:
    return jsonschema.Draft7Validator(json.loads(schema_path().read_text(encoding='utf-8')))


def by_schema(content: Any) -> str:
    """Say why the schema refuses a scene; nothing if it takes it."""
    for error in validator().iter_errors(content):
        return f'{list(error.absolute_path)}: {error.message}'
    return ''


def by_reader(content: Any) -> str:
    """Say why the reader refuses a scene; nothing if it takes it."""
    try:
        load_scene(content, files=FILES)
    except UserError as error:
        return str(error)
    return ''


Path_ = tuple[Any, ...]


def leaves(part: g.Mappings, value: Any, path: Path_) -> Iterator[tuple[Path_, str, g.Key, Any]]:
    """Walk a scene with the grammar: path, `mapping.key`, key and value of every key in it."""
    name = part.about
    if part.variants:
        tag = value.get(part.tag, part.default_tag)
        part, name = part.variants[tag], f'{name} {tag}'
    for key, each in part.keys.items():
        if key in value:
            yield (*path, key), f'{name} {key}', each, value[key]
            yield from _inside(each.kind, value[key], (*path, key))


def _inside(kind: Any, value: Any, path: Path_) -> Iterator[tuple[Path_, str, g.Key, Any]]:
    match kind:
        case g.Part() if isinstance(value, dict):
            yield from leaves(KNOWN[kind.name], value, path)
        case g.ListOf() if isinstance(value, list):
            for i, each in enumerate(value):
                yield from _inside(kind.each, each, (*path, i))
        case g.Named():
            for name, each in value.items():
                if each is not None:
                    yield from _inside(kind.each, each, (*path, name))
        case g.Either():
            for one in kind.kinds:
                yield from _inside(one, value, path)


EVERY = [
    (scene, path, name, key, value)
    for scene, content in COMPLETE.items()
    for path, name, key, value in leaves(KNOWN['scene'], content, ())
]


ALL = [*{(each[2], type(each[4]), len(each[1])): each for each in EVERY}.values()]  # once each


def changed(scene: str, path: Path_, value: Any) -> Any:
    """Give a scene with one value replaced; without it for `...`."""
    content = json.loads(json.dumps(COMPLETE[scene]))  # no value stands there twice
    place = content
    for step in path[:-1]:
        place = place[step]
    if value is ...:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return content


def numbers(kind: Any, value: Any, path: Path_) -> Iterator[tuple[Path_, Any]]:
    """Find the numbers of a value: path and kind of each."""
    match kind:
        case g.Number() | g.Whole() if not isinstance(value, list | dict):
            yield path, kind
        case g.Numbers() if isinstance(value, list):
            for i, each in enumerate(value):
                yield from numbers(kind.each, each, (*path, i))
        case g.Rows():
            for i, row in enumerate(value):
                each = kind.columns or [g.Number(kind.units)] * len(row)
                yield from (((*path, i, j), each[j]) for j in range(len(row)))
        case g.ListOf():
            for i, each in enumerate(value):
                yield from numbers(kind.each, each, (*path, i))
        case g.Either():
            for one in kind.kinds:
                yield from numbers(one, value, path)


def _each_once() -> Iterator[tuple[str, Path_, Any]]:
    seen = set()
    for scene, where, name, key, value in ALL:
        for path, kind in numbers(key.kind, value, where):
            it = (name, kind, path[len(where) :])
            if it not in seen:
                seen.add(it)
                yield scene, path, kind


NUMBERS = [*_each_once()]


def told(path: Path_) -> str:
    """Write a path as messages do."""
    return ''.join(f'[{step}]' if isinstance(step, int) else f'.{step}' for step in path)[1:]


def test_every_key_stands_in_one_of_the_complete_scenes_and_all_are_scenes() -> None:
    seen = {name for _, _, name, _, _ in EVERY}
    every = set()
    for part in KNOWN.values():
        for tag, one in part.variants.items() or {'': part}.items():
            name = f'{part.about} {tag}' if tag else part.about
            every |= {f'{name} {key}' for key in one.keys}
    assert every - seen == {'One shape. mesh concavity'}  # needs CoACD; below
    for name, content in COMPLETE.items():
        assert by_reader(content) == by_schema(content) == '', name
    assert len(ALL) > 150 and len(NUMBERS) > 120


def test_the_limits_of_concavity_are_those_of_the_reader() -> None:
    assert by_schema(CONCAVITY | {'bodies': []})
    for wrong in (0.001, 1.5, 'near'):
        content = copy.deepcopy(CONCAVITY)
        content['bodies'][0] |= {'mass': 1}
        assert by_schema(content) == ''
        content['bodies'][0]['shape']['concavity'] = wrong
        assert by_schema(content) and 'shape.concavity: got' in by_reader(content)


def test_the_unit_of_each_number_is_the_one_that_the_reader_asks_for() -> None:
    wrong = []
    for scene, path, kind in NUMBERS:
        content = changed(scene, path, 'heavy')
        said = by_reader(content)
        units = [''] if isinstance(kind, g.Whole) else [kind.unit, *kind.unit.split(', ')]
        names_it = told(path[:-1] if isinstance(path[-1], int) else path) in said
        if (
            not by_schema(content)
            or not names_it
            or not any(f'[{unit}]' in said or not unit for unit in units)
        ):
            wrong.append(f'{scene} {told(path)} {units[0]}: {said}')
    assert not wrong, '\n'.join(wrong)


def test_what_is_beyond_a_limit_is_refused_by_reader_and_schema() -> None:
    accepted, tried = [], 0
    for scene, path, kind in NUMBERS:
        beyond = []
        if getattr(kind, 'positive', False):
            beyond += [0.0, -1.0]
        if kind.minimum is not None:
            beyond.append(kind.minimum - 1 if kind.minimum in (0, 1) else kind.minimum / 2)
        if kind.maximum is not None:
            beyond.append(kind.maximum * 2)
        for value in beyond:
            tried += 1
            content = changed(scene, path, value)
            if not by_reader(content) or not by_schema(content):
                accepted.append(f'{scene} {told(path)} = {value}')
    assert not accepted and tried > 80, '\n'.join(accepted)


@pytest.mark.parametrize('every', [6, pytest.param(1, marks=pytest.mark.long)])
def test_the_reader_has_no_limit_of_a_number_that_the_grammar_does_not_know(every: int) -> None:
    unknown = []
    for number, (scene, path, kind) in enumerate(NUMBERS):
        texts = () if getattr(kind, 'maximum', None) else ('1e-3', '+.5')  # limits are for numbers
        for value in (-1, 0, *((3, *texts) if number % every == 0 else ())):
            content = changed(scene, path, value)
            said = by_reader(content)
            if said and not by_schema(content) and not any(why in said for why in JUDGED):
                unknown.append(f'{scene} {told(path)} = {value}: {said}')
            if not said and (why := by_schema(content)):
                unknown.append(f'{scene} {told(path)} = {value}: schema {why}')
    assert not unknown, '\n'.join(unknown)


def test_what_is_left_out_is_its_default() -> None:
    differ, tried = [], 0
    for scene, path, name, key, _ in ALL:
        if key.required or key.default is None:
            continue
        without, empty = (changed(scene, path, value) for value in (..., None))
        given = changed(scene, path, key.default)
        tried += 1
        if by_reader(without):
            continue
        seen = [_records(content) for content in (without, empty, given)]
        if seen[0] != seen[1] or seen[0] != seen[2] or by_schema(empty) or by_schema(given):
            differ.append(f'{scene} {told(path)} {name}: {by_schema(given)}')
    assert not differ and tried > 60, '\n'.join(differ)


def _records(content: Any) -> str:
    """Write what is simulated; two scenes with the same text are the same."""
    scene = load_scene(content, files=FILES)
    options = {}
    if scene.integrator != 'auto':
        from rigid_body_sim.physics.integration.integrators import INTEGRATORS

        options = INTEGRATORS[scene.integrator].configured(scene.integrator_options).settings
    contact = scene.contact
    if contact['mode'] != 'none':
        from rigid_body_sim.physics.contact.settings import ContactSettings

        contact = ContactSettings.of(contact)
    parts = (scene.name, scene.dt_ns, scene.gravity, scene.bodies, scene.forces, scene.integrator)
    return repr((*parts, options, contact))


def test_what_must_be_there_and_what_nobody_knows_is_refused_by_both() -> None:
    accepted, tried = [], 0
    for scene, path, name, key, value in ALL:
        wrong = []
        if key.required:
            wrong += [changed(scene, path, ...), changed(scene, path, None)]
        if isinstance(value, dict) and not isinstance(key.kind, g.Named):
            wrong.append(changed(scene, (*path, 'colour'), 1))
        match key.kind:
            case g.Truth():
                wrong += [changed(scene, path, 'yes'), changed(scene, path, 1)]
            case g.Words():
                wrong += [changed(scene, path, 'nonsense'), changed(scene, path, 1)]
            case g.Text():
                wrong += [changed(scene, path, 12), changed(scene, path, [])]
            case g.Number() | g.Whole():
                wrong += [changed(scene, path, bad) for bad in (True, [1], {}, '010', '1:30')]
            case g.Numbers():
                wrong += [changed(scene, path, bad) for bad in (1, [1], [1] * 9, [True] * 3)]
        for content in wrong:
            tried += 1
            if not by_reader(content) or not by_schema(content):
                accepted.append(f'{scene} {told(path)} ({name}): {content}')
    assert not accepted and tried > 500, '\n'.join(accepted)


@pytest.mark.parametrize('rule', g.BODY.rules, ids=lambda rule: rule.sentence[:40])
def test_what_keys_say_of_each_other_is_what_the_reader_says(rule: g.Rule) -> None:
    """One body that breaks each rule of a body is refused by both."""
    ball, point = {'type': 'sphere', 'radius': 1}, {'type': 'particle'}
    tensor = {'ixx': 1, 'iyy': 1, 'izz': 1}
    plane = {'type': 'plane', 'normal': [0, 0, 1]}
    grid = {'type': 'heightfield', 'heights': [[0, 0], [0, 0]], 'spacing': 1}
    over_time = {'table': [[0, 1, 1, 1], [1, 1, 1, 1]]}
    turned = {'orientation': [0, 0, 0, 1]}
    broken = {
        'it has a shape': [{'mass': 1}, {}],
        'what may move needs a mass': [{'shape': ball}, {'shape': ball, 'fixed': False}],
        'what may move and has no volume': [{'shape': point}, {'inertia': tensor}],
        'the mass of what may move': [{'shape': ball, 'mass': 0}],
        'a plane and a height field have': [{'shape': plane, 'mass': 1},
                                            {'shape': grid, 'fixed': True, 'density': 1}],
        'a plane is one': [{'shape': plane, 'repeat': {'count': [2, 1, 1],
                                                       'spacing': [1, 1, 1]}}],
        'a height field, and': [{'shape': grid}],
        'a particle': [
            {'shape': point, 'mass': 1, 'inertia': tensor},
            {'shape': point, 'mass': 1, 'initial': turned},
            {'shape': point, 'mass': 1, 'initial': {'angular_velocity_body': [0, 0, 0]}},
            {'shape': point, 'mass': 1, 'frames': {'a': None}},
        ],
        'the exhaust': [{'shape': ball, 'mass': 1, 'exhaust_velocity': 1},
                        {'shape': ball, 'mass': 1, 'final_mass': 1}],
        'a URDF file': [{'urdf': 'box.urdf', 'mass': 1}],
        'what moves as told': [{'shape': ball, 'motion': {}, 'fixed': True}],
        'one of inertia': [{'shape': ball, 'mass': 1, 'inertia': tensor,
                            'inertia_over_time': over_time}],
        'copies cannot': [{'shape': ball, 'mass': 1, 'pivot': {'point': [0, 0, 1]},
                           'repeat': {'count': [2, 1, 1], 'spacing': [1, 1, 1]}}],
    }  # fmt: skip
    (bodies,) = [found for start, found in broken.items() if rule.sentence.startswith(start)]
    for body in bodies:
        content = _scene(body)
        assert by_reader(content) and by_schema(content), body


@pytest.mark.parametrize(
    'content',
    [
        _scene({**BOX, 'initial': {'angular_velocity': [0, 0, 1],
                                   'angular_velocity_body': [0, 0, 1]}}),
        _scene(BOX, contact={'mode': 'none', 'substeps': 2}),
        _scene({**BOX, 'name': 'a__b'}), _scene({**BOX, 'name': 'world'}),
        _scene({**BOX, 'name': '2nd'}), _scene({**BOX, 'name': 'n' * 101}),
        _scene({**BOX, 'frames': {'a b': None}}), _scene(),
        _scene({'shape': {'type': 'union', 'parts': [
            {'shape': {'type': 'plane', 'normal': [0, 0, 1]}}]}}),
        _scene({'shape': {'type': 'union', 'parts': [{**BOX, 'density': 1}]}}),
        _scene({'shape': {'type': 'heightfield', 'spacing': 1}, 'fixed': True}),
        _scene(BOX, version=2), _scene(BOX, integrator={'name': 'dmv6', 'rtol': 1e-9}),
        _scene(BOX, forces=[{'type': 'time', 'body': 'body0', 'table': [[0, 1, 0, 0], [1, 2]]}]),
    ],
)  # fmt: skip
def test_what_is_wrong_beyond_one_key_is_refused_by_both(content: Any) -> None:
    assert by_reader(content) and by_schema(content)


@pytest.mark.parametrize('name', sorted(shipped_scenes()))
def test_the_schema_takes_every_shipped_scene(name: str) -> None:
    path = shipped_scenes()[name]
    assert by_schema(document.read(path.read_bytes(), name=name).content) == ''


def test_page_and_schema_are_what_the_grammar_says() -> None:
    spec = importlib.util.spec_from_file_location(
        'scene_reference', ROOT / 'tools' / 'scene_reference.py'
    )
    assert spec is not None and spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.page() == tool.PAGE.read_text(), 'run `python tools/scene_reference.py`'
    assert tool.schema() == tool.SCHEMA.read_text(), 'run `python tools/scene_reference.py`'
    jsonschema.Draft7Validator.check_schema(json.loads(tool.schema()))
    assert schema_path() == tool.SCHEMA
