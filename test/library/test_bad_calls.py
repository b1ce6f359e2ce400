# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever is handed to a public function, it works or is refused in one line that says what."""

import numpy as np
import pytest

import rigid_body_sim as rbs

ODD = [
    -1, 0, 1, 2.5, float('nan'), float('inf'), 1j, 10**400, True, None, 'x', '', b'x', '\0',
    [], [1], (1, 2), {}, {'x': 1}, {1, 2}, np.array([1.0]), np.zeros((2, 3)), object(),
]  # fmt: skip
REFUSALS = (rbs.InvalidModel, rbs.UserError, rbs.RunError)


def short(**options):
    return rbs.simulate('two_bodies', 0.01, every=0.001, **options)


def answering(answer):
    return short(controller=lambda _t, _state: answer)


def moved(**motion):
    motion = rbs.PrescribedMotion(**motion)
    return rbs.make_scene([rbs.make_body('a', rbs.Sphere(1), mass=1, motion=motion)])


def hung(force):
    return rbs.make_scene([rbs.make_body('a', rbs.Sphere(1), mass=1)], [force])


def swept(**options):
    given = {'vary': {'dt': [0.001]}, 'duration': 0.01, 'workers': 1} | options
    return rbs.sweep('two_bodies', given.pop('vary'), **given)


CALLS = {  # of a simulation and of what is odd
    'every': lambda _, odd: rbs.simulate('two_bodies', 0.01, every=odd),
    'controller': lambda _, odd: short(controller=odd),
    'answer': lambda _, odd: answering(odd),
    'answer of a body': lambda _, odd: answering({'box': odd}),
    'answers of a body': lambda _, odd: answering({'box': [odd]}),
    'wrench': lambda _, odd: answering({'box': rbs.Wrench(force=odd)}),
    'frame': lambda _, odd: answering({'box': rbs.Wrench(frame=odd)}),
    'dt': lambda _, odd: short(dt=odd),
    'integrator': lambda _, odd: short(integrator=odd),
    'options': lambda _, odd: short(integrator='rk45', integrator_options=odd),
    'scene': lambda _, odd: rbs.Simulation(odd),
    'load_scene': lambda _, odd: rbs.load_scene(odd),
    'step': lambda sim, odd: sim.step(odd),
    'run_for': lambda sim, odd: sim.run_for(odd),
    'run': lambda sim, odd: sim.run(odd),
    'set_wrench': lambda sim, odd: sim.set_wrench(odd, force=(1, 2, 3)),
    'set_wrench force': lambda sim, odd: sim.set_wrench('box', force=odd),
    'set_wrenches': lambda sim, odd: sim.set_wrenches(force=odd, torque=None),
    'hold': lambda sim, odd: sim.hold('box', odd, force=(1, 2, 3)),
    'impulse': lambda sim, odd: sim.apply_impulse('box', linear=odd),
    'set_state': lambda sim, odd: sim.set_state('box', position=odd),
    'orientation': lambda sim, odd: sim.set_state('box', orientation=odd),
    'motion_of': lambda sim, odd: sim.motion_of('box', odd),
    'moment_of_inertia': lambda sim, odd: sim.moment_of_inertia('box', direction=odd),
    'restore tick': lambda sim, odd: sim.restore(tick=odd, state=sim.state_bytes(), slots={}),
    'restore state': lambda sim, odd: sim.restore(tick=0, state=odd, slots={}),
    'restore slots': lambda sim, odd: sim.restore(tick=0, state=sim.state_bytes(), slots=odd),
    'load': lambda _, odd: rbs.Simulation.load(odd),
    'open_bag': lambda _, odd: rbs.open_bag(odd),
    'vary': lambda _, odd: swept(vary=odd),
    'keep': lambda _, odd: swept(keep=odd),
    'bodies': lambda _, odd: swept(bodies=odd),
    'seed': lambda _, odd: swept(seed=odd),
    'uniform': lambda _, odd: rbs.uniform(odd, 2),
    'integers': lambda _, odd: rbs.integers(odd, 3),
    'inverse_kinematics': lambda _, odd: rbs.inverse_kinematics(np.arange(9.0), odd),
    'box': lambda _, odd: rbs.Box(odd),
    'cylinder': lambda _, odd: rbs.Cylinder(odd, 1),
    'hull': lambda _, odd: rbs.ConvexHull(odd),
    'mesh': lambda _, odd: rbs.Mesh(odd, [[0, 1, 2]]),
    'faces': lambda _, odd: rbs.Mesh(np.eye(4, 3), odd),
    'particles': lambda _, odd: rbs.Particles(odd, [[0, 0, 0]]),
    'union': lambda _, odd: rbs.Union(odd),
    'part': lambda _, odd: rbs.Part(odd),
    'frame record': lambda _, odd: rbs.Frame((0, 0, 0), odd),
    'way': lambda _, odd: moved(heave=odd),
    'oscillation': lambda _, odd: moved(heave=(odd,)),
    'spring': lambda _, odd: hung(rbs.Spring('a', odd, stiffness=1)),
    'stiffness': lambda _, odd: hung(rbs.Spring('a', 'world', stiffness=odd)),
    'table': lambda _, odd: hung(rbs.TimeTable('a', odd)),
    'gravity': lambda _, odd: hung(rbs.Gravity(odd)),
}


@pytest.mark.usefixtures('plain_source')
@pytest.mark.filterwarnings('ignore')
@pytest.mark.parametrize('call', CALLS)
def test_what_is_odd_works_or_is_refused_in_one_line(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = rbs.load_scene('two_bodies')
    wants_simulation = CALLS[call].__code__.co_varnames[0] != '_'
    for odd in ODD:
        sim = rbs.Simulation(scene, dt=0.02) if wants_simulation else None  # few ticks a second
        try:
            CALLS[call](sim, odd)
        except REFUSALS as error:
            assert str(error) and '\n' not in str(error)


@pytest.mark.parametrize('odd', [None, 5, b'x', [1], 'a\0b', '', object()])
def test_what_is_no_path_is_refused_by_who_asks(odd):
    with pytest.raises(rbs.UserError, match=r'^open_bag: got .*; a path is needed'):
        rbs.open_bag(odd)


@pytest.mark.parametrize('name', ['.', '..', '/', 'folder'])
def test_a_folder_in_place_of_a_file_is_refused_as_one(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'folder').mkdir()
    run = short()
    for write in (run.to_csv, run.to_parquet, rbs.Simulation('two_bodies').save):
        with pytest.raises(rbs.UserError, match='is a folder, and a file is to be written'):
            write(name)


@pytest.mark.parametrize('odd', [None, 3, ['satellite'], '', object()])
def test_what_is_no_scene_is_told_what_a_scene_may_be(odd):
    for take in (rbs.simulate, rbs.Simulation, rbs.load_scene):
        with pytest.raises(rbs.UserError, match=r'^scene: got .*; .*name of a shipped scene'):
            take(odd)


@pytest.mark.parametrize('odd', [True, 3, 'x'])
def test_a_progress_that_cannot_be_called_is_refused_before_it_is_needed(odd):
    with pytest.raises(rbs.InvalidModel, match=r'^progress: got .*; a function of a short text'):
        rbs.Simulation('satellite', progress=odd)
