# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene made in Python is the one that the same words in a file make, and has a text too."""

from dataclasses import replace

import numpy as np
import pytest

import rigid_body_sim as rbs
from rigid_body_sim.scene.shipped_scenes import shipped_scenes
from rigid_body_sim.scene.writing import difference, mapping_of, with_text

from .conftest import same_bits

SPIN, ATTITUDE = [0.1, 0.2, 0.3], [0.1, 0.2, 0.3, 0.9]


def test_records_are_those_of_the_reader():
    box = {'name': 'box', 'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]}, 'density': 250,
           'friction': 0.3, 'frames': {'nose': {'position': [0.2, 0, 0]}},
           'initial': {'position': [0, 0, 1], 'orientation': ATTITUDE,
                       'angular_velocity_body': SPIN}}  # fmt: skip
    drone = {'name': 'drone', 'mass': 1, 'inertia': {'ixx': 1, 'iyy': 2, 'izz': 2.5}}
    spring = {'type': 'spring', 'a': 'drone', 'b': 'world', 'b_point': [1, 0, 1], 'stiffness': 50}
    ground = {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
    mode = {'mode': 'timestep'}
    written = rbs.load_scene(
        {'name': 'three', 'dt': 0.002, 'gravity': [0, 0, -9.81], 'contact': mode,
         'bodies': [box, drone, ground], 'forces': [spring]}
    )  # fmt: skip
    made = rbs.make_scene(
        [
            rbs.make_body(
                'box',
                rbs.Box((0.4, 0.2, 0.1)),
                density=250,
                friction=0.3,
                position=(0, 0, 1),
                orientation=ATTITUDE,
                angular_velocity_body=SPIN,
                frames={'nose': rbs.Frame((0.2, 0, 0))},
            ),
            rbs.make_body('drone', mass=1, inertia=(1, 2, 2.5)),
            rbs.make_body('ground', rbs.Plane((0, 0, 1))),
        ],
        [rbs.Spring('drone', 'world', b_point=(1, 0, 1), stiffness=50)],
        dt=0.002,
        name='three',
        gravity=(0, 0, -9.81),
        contact=mode,
    )
    assert difference(made, written) is None
    a, b = rbs.Simulation(made), rbs.Simulation(written)
    assert a.state_bytes() == b.state_bytes()


def test_a_pendulum_hangs_where_that_of_the_file_hangs():
    written = rbs.load_scene('pendulum').bodies[0]
    made = rbs.make_body(
        written.name,
        written.shape,
        mass=written.mass,
        orientation=written.initial.orientation,
        pivot=written.pivot,
    )
    assert difference(made.initial, written.initial) is None


@pytest.mark.parametrize('name', sorted(shipped_scenes().keys() - {'sea_bed', 'pile_of_1000'}))
def test_every_shipped_scene_can_be_written_and_read_to_the_bit(name):
    scene = rbs.load_scene(name)
    written = with_text(replace(scene, source=b''))
    assert difference(scene, written) is None and written.source


def test_triangles_are_written_as_the_text_had_them():
    scene = replace(rbs.load_scene('sea_bed'), gravity=(0.0, 0.0, -1.0))
    written = with_text(scene)
    assert difference(scene, written) is None
    with pytest.raises(rbs.InvalidModel, match='no scene file can say it'):
        with_text(replace(scene, source=b''))


def test_what_no_file_can_say_is_refused_by_its_place():
    body = replace(rbs.make_body('a', rbs.Sphere(0.1), mass=1), shape_position=(0.1, 0, 0))
    with pytest.raises(rbs.InvalidModel, match=r'bodies\[0\].shape_position: no scene file'):
        mapping_of(rbs.make_scene([body]))


@pytest.mark.parametrize(
    ('make', 'reason'),
    [
        (lambda: rbs.make_body('a', rbs.Box((1, 1, 1))), 'mass'),
        (lambda: rbs.make_body('a', rbs.Box((1, 1, 1)), mass=-1), 'mass'),
        (lambda: rbs.make_body('a', rbs.Box((1, 1, 1)), mass=1, density=1), 'mass'),
        (lambda: rbs.make_body('a', mass=1, inertia=np.eye(2)), r'shape \(2, 2\)'),
        (lambda: rbs.make_body('a', mass=1, position=(0, 0)), 'position: got'),
        (lambda: rbs.make_body('a', mass=1, position=(0, 0, np.nan)), 'position: got'),
        (lambda: rbs.make_body('a', rbs.Plane((0, 0, 1)), mass=1), 'ground and has no mass'),
        (lambda: rbs.make_body('a'), 'finite number'),
        (
            lambda: rbs.make_body(
                'a', mass=1, inertia=(1, 1, 1), angular_velocity=SPIN, angular_velocity_body=SPIN
            ),
            'not both',
        ),
        (lambda: rbs.make_scene([]), 'at least one body'),
        (lambda: rbs.make_scene([rbs.make_body('a', mass=1)] * 2), "name 'a' is taken"),
        (lambda: rbs.make_scene([rbs.make_body('a', mass=1, inertia=(1, 1, 5))]), 'triangle'),
        (lambda: rbs.make_scene([rbs.make_body('a', mass=1)], dt=1 / 3), 'nanoseconds'),
        (
            lambda: rbs.make_scene(
                [rbs.make_body('ball', mass=1)], [rbs.Spring('bal', 'world', stiffness=1)]
            ),
            "did you mean 'ball'",
        ),
    ],
)
def test_what_no_physics_can_honour_is_refused(make, reason):
    with pytest.raises(rbs.InvalidModel, match=reason):
        make()


NAN, HUGE = float('nan'), 10**400
NO_NUMBERS = [True, 'a', [1], {}, NAN, float('inf'), HUGE]
NO_VECTORS = [[1, 2], [1, 2, NAN], 'abc', [True, 0, 0], 5, {}, [[1, 2, 3]], [1, 2, HUGE]]
NO_ATTITUDES = [[0, 0, 0, 0], [0, 0, 1], [NAN, 0, 0, 1], 'abcd', [True, 0, 0, 1], 5, {}]
NO_TRUTHS = [0, 1, 'yes', [True], 2.5]
NO_MOMENTS = [[1, 1, 3], [1, 1, -1], [0, 1, 1], [NAN, 1, 1], [True, 1, 1], [1, 1, HUGE]]
WORDS = {  # of a body: what it may not be
    'mass': [-1, 0, *NO_NUMBERS],
    'density': [-1, 0, *NO_NUMBERS],
    'restitution': [-1, 2, *NO_NUMBERS],
    'friction': [-1, *NO_NUMBERS],
    'fixed': NO_TRUTHS,
    'position': NO_VECTORS,
    'velocity': NO_VECTORS,
    'angular_velocity': NO_VECTORS,
    'angular_velocity_body': NO_VECTORS,
    'center_of_mass': NO_VECTORS,
    'surface_velocity': NO_VECTORS,
    'orientation': NO_ATTITUDES,
    'inertia': NO_MOMENTS,
    'frames': [5, True, [1]],
}
WORDS_OF_SCENE = {
    'dt': [-1, 0, *NO_NUMBERS],
    'gravity': NO_VECTORS,
    'contact': [5, 'none', [1], True, {'mode': 'x'}, {'mode': 'timestep', 'substep': 1}],
    'integrator': [
        5, 'rk5', [1], True, {'rtol': 1}, {'name': 'rk45', 'rtoll': 1},
        {'name': 'rk45', 'rtol': 9},
        *({'name': 'rk45', 'substeps': none} for none in (0, 1.5, True, 'a', NAN)),
        {'name': 'auto', 'tolerance': -1},
    ],
}  # fmt: skip
STARTS = ('position', 'velocity', 'orientation', 'angular_velocity', 'angular_velocity_body')


def written(word, value, *, of_scene):
    """Read a scene of a sphere in which a word has a value."""
    body = {'name': 'b', 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1.0}
    scene = {'version': 1, 'name': 's', 'dt': 1e-3, 'bodies': [body]}
    if word == 'density':
        del body['mass']
    if word == 'inertia':
        value = dict(zip(('ixx', 'iyy', 'izz'), value, strict=True))
    place = body.setdefault('initial', {}) if word in STARTS else body
    (scene if of_scene else place)[word] = value
    return rbs.load_scene(scene)


def made(word, value, *, of_scene):
    """Make the same scene."""
    mass = {} if word == 'density' else {'mass': 1.0}
    body = mass if of_scene else mass | {word: value}
    scene = {'dt': 1e-3} | ({word: value} if of_scene else {})
    return rbs.make_scene([rbs.make_body('b', rbs.Sphere(0.1), **body)], **scene)


@pytest.mark.parametrize('word', [*WORDS, *WORDS_OF_SCENE])
def test_what_a_file_may_not_say_no_call_may_say(word):
    of_scene = word in WORDS_OF_SCENE
    for value in (WORDS_OF_SCENE if of_scene else WORDS)[word]:
        with pytest.raises(rbs.UserError, match=word):
            written(word, value, of_scene=of_scene)
        with pytest.raises(rbs.InvalidModel, match=word):
            made(word, value, of_scene=of_scene)


@pytest.mark.parametrize('none', [5, 'box', {'type': 'box'}, [rbs.Sphere(1)], rbs.Box, b''])
def test_what_is_no_record_is_refused_by_its_place(none):
    for call, place in (
        (lambda: rbs.make_body('b', none, mass=1), "body 'b': shape: got"),
        (
            lambda: rbs.make_body('b', mass=1, inertia=(1, 1, 1), pivot=none),
            "body 'b': pivot: got",
        ),
        (lambda: rbs.make_scene(none), 'bodies'),
        (lambda: rbs.make_scene([rbs.make_body('b', mass=1)], none), 'forces'),
        (lambda: rbs.make_scene([none]), r'bodies\[0\]: got'),
    ):
        with pytest.raises(rbs.InvalidModel, match=place):
            call()


def test_a_position_beside_a_pivot_must_be_the_one_that_follows():
    pivot = rbs.Pivot((0, 0, 0.5), (0, 0, 2))

    def hung(**start):
        return rbs.make_body('b', rbs.Box((0.1, 0.1, 1)), mass=1, pivot=pivot, **start)

    assert hung(position=(0, 0, 1.5)).initial == hung().initial
    for wrong in ({'position': (0, 0, 0)}, {'velocity': (0, 0, 1)}):
        with pytest.raises(rbs.InvalidModel, match='with this pivot'):
            hung(**wrong)


def test_an_integrator_may_come_with_its_options_as_in_a_scene_file():
    told = {'name': 'rk45', 'rtol': 1e-9}
    scene = rbs.make_scene([rbs.make_body('a', mass=1)], integrator=told)
    assert (scene.integrator, scene.integrator_options) == ('rk45', {'rtol': 1e-9})
    apart = rbs.Simulation('two_bodies', integrator='rk45', integrator_options={'rtol': 1e-9})
    together = rbs.Simulation('two_bodies', integrator=told)
    assert together.integrator.name == 'rk45'
    assert together.integrator.settings == apart.integrator.settings
    assert told == {'name': 'rk45', 'rtol': 1e-9}
    for wrong, reason in (
        ({'name': 'rk45', 'rtoll': 1e-9}, "no option 'rtoll'; did you mean 'rtol'"),
        ({'name': 'rk46'}, "'rk46' is unknown"),
        ({'rtol': 1e-9}, 'has no name'),
    ):
        with pytest.raises(rbs.InvalidModel, match=reason):
            rbs.Simulation('two_bodies', integrator=wrong)
    with pytest.raises(rbs.InvalidModel, match='in one of the two'):
        rbs.Simulation('two_bodies', integrator=told, integrator_options={'atol': 1e-9})


def test_ticks_beyond_what_time_can_count_are_refused():
    sim = rbs.Simulation('two_bodies')
    sim.step(3)
    for ticks in (10**30, 2**62, np.int64(2**62), 9_223_372_036_852):
        with pytest.raises(rbs.InvalidModel, match='allowed: up to tick 9223372036854, '):
            sim.step(ticks)
    assert sim.tick == 3


def test_a_scene_of_records_runs_saves_and_comes_back(tmp_path):
    ball = rbs.make_body('ball', mass=0.5, position=(1, 0, 0))
    scene = rbs.make_scene([ball], [rbs.Spring('ball', 'world', stiffness=50)], name='swing')
    run = rbs.simulate(scene, 0.1, every=0.01)
    run.save(tmp_path / 'bag')
    other = rbs.open_bag(tmp_path / 'bag')
    assert other.scene.name == 'swing'
    assert same_bits(other['ball'].position, run['ball'].position)
