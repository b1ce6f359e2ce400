# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `import rigid_body_sim as rbs` offers: names, rotations, notebooks, an environment."""

import pickle
import subprocess
import sys
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid_body_sim as rbs
from rigid_body_sim import rotation

RANDOM = np.random.default_rng(3)


def test_every_public_name_is_there_before_it_is_asked_for():
    code = (
        'import sys, rigid_body_sim as r; '
        'print(len(set(r.__all__) - set(dir(r))), "numpy" in sys.modules)'
    )
    said = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert said.stdout.split() == ['0', 'False']
    for name in dir(rbs):
        assert getattr(rbs, name) is not None


def test_the_package_is_imported_in_a_tenth_of_a_second():
    code = (
        'import time; t = time.process_time(); import rigid_body_sim; '
        'print(time.process_time() - t)'
    )
    spent = [
        float(subprocess.run([sys.executable, '-c', code], capture_output=True, check=True).stdout)
        for _ in range(3)
    ]
    assert min(spent) < 0.1  # s of processor time


def test_rotations_are_those_of_scipy():
    vectors = RANDOM.normal(size=(2, 5, 3))
    p, q = rotation.exp(vectors)
    assert np.allclose(Rotation.from_quat(p).as_rotvec(), _shortest(vectors[0]), atol=1e-14)
    together = (Rotation.from_quat(p) * Rotation.from_quat(q)).as_matrix()
    assert np.allclose(rotation.matrix(rotation.multiply(p, q)), together, atol=1e-14)
    v = RANDOM.normal(size=(5, 3))
    assert np.allclose(rotation.rotate(q, v), Rotation.from_quat(q).apply(v), atol=1e-14)
    assert np.allclose(rotation.rotate_back(q, rotation.rotate(q, v)), v, atol=1e-14)
    assert np.allclose(rotation.multiply(q, rotation.inverse(q)), rotation.IDENTITY, atol=1e-15)
    assert np.allclose(rotation.from_scipy(rotation.as_scipy(q)), q)


def _shortest(vectors):
    return Rotation.from_rotvec(vectors).as_rotvec()


@pytest.mark.parametrize('size', [1e-300, 1e-12, 1e-6, 1e-3, 1.0, 3.14])
def test_log_undoes_exp_to_the_last_digits_however_small_the_turn(size):
    axis = np.array([0.6, -0.48, 0.64])
    vector = size * axis
    assert np.allclose(rotation.log(rotation.exp(vector)), vector, rtol=4e-15, atol=0)
    assert np.allclose(rotation.log(-rotation.exp(vector)), vector, rtol=4e-15, atol=0)


def test_log_takes_every_shape_and_refuses_what_is_no_attitude():
    assert rotation.log(np.zeros((2, 0, 4))).shape == (2, 0, 3)
    assert rotation.log(rotation.exp(np.zeros((2, 3, 3)))).shape == (2, 3, 3)
    assert rotation.log((0, 0, 0, 2)).tolist() == [0, 0, 0]
    for wrong in ((1, 2, 3), 1.0, (0, 0, 0, 0), (0, 0, 0, np.nan)):
        with pytest.raises(rbs.InvalidModel):
            rotation.log(wrong)


NAN, HALF = float('nan'), np.ones(4) / 2
TURN = rotation.matrix(HALF)
NO_ATTITUDES = [
    (0, 0, 0, 0), (0, 0, 0, 2), (0, 0, 0, 1.00001), (0, 0, NAN, 1), (0, 0, 0, 1e200), (1, 2, 3),
    'abcd', None, 1.0, (0, 0, 0, True), [HALF, 2 * HALF],
]  # fmt: skip
NO_MATRICES = [
    2 * TURN, -TURN, TURN @ np.diag((1, 1, -1)), TURN + 1e-5, TURN * NAN, np.zeros((3, 3)),
    1e200 * TURN, np.eye(4), np.eye(2), 'abc', None, [TURN, 2 * TURN],
    np.array([[1, 1e-5, 0], [0, 1, 0], [0, 0, 1]]),
]  # fmt: skip


@pytest.mark.parametrize(
    'of',
    [
        rotation.inverse, rotation.conjugate, rotation.matrix,
        lambda q: rotation.rotate(q, (1, 2, 3)), lambda q: rotation.rotate_back(q, (1, 2, 3)),
        lambda q: rotation.angle_between(q, HALF), lambda q: rotation.angle_between(HALF, q),
    ],
)  # fmt: skip
def test_what_is_no_attitude_turns_nothing(of):
    for wrong in NO_ATTITUDES:
        with pytest.raises(rbs.InvalidModel, match=r'got .* needed'):
            of(wrong)
    of(HALF.astype(np.float32))
    of((0, 0, 0, 1 + 1e-7))
    of(np.zeros((0, 4)))


def test_what_is_no_rotation_matrix_is_no_attitude():
    for wrong in NO_MATRICES:
        with pytest.raises(rbs.InvalidModel, match=r'from_matrix: .*got .*'):
            rotation.from_matrix(wrong)
    for right in (TURN, TURN.astype(np.float32), [TURN, TURN.T], np.zeros((0, 3, 3))):
        rotation.from_matrix(right)


def test_a_refused_rotation_is_told_by_its_place():
    with pytest.raises(rbs.InvalidModel, match=r'matrix: q\[1\]: got .* length is 2, allowed: 1'):
        rotation.matrix([HALF, 2 * HALF])
    with pytest.raises(rbs.InvalidModel, match=r'determinant is -1, allowed: \+1'):
        rotation.from_matrix(np.diag((1, 1, -1)))
    for of in (rotation.exp, rotation.normalise, rotation.log, rotation.as_scipy):
        for wrong in ((NAN, 0, 0, 0), (NAN, 0, 0), 'abc', 5):
            with pytest.raises(rbs.InvalidModel, match='got'):
                of(wrong)


def test_scenes_and_simulations_tell_of_themselves():
    scene, sim = rbs.load_scene('two_bodies'), rbs.Simulation('two_bodies')
    assert repr(scene).startswith(
        "<Scene 'two_bodies': 2 bodies (box, ball), forces: drag, spring"
    )
    assert '<td>box</td><td>Box</td><td>2</td>' in scene._repr_html_()
    assert '<td>ball</td>' in sim._repr_html_() and 'tick 0' in sim._repr_html_()
    odd = rbs.make_scene([rbs.make_body('a', mass=1)], name='<script>alert(1)</script>')
    assert '<script>' not in odd._repr_html_() + rbs.Simulation(odd)._repr_html_()


def test_a_notebook_plays_a_run_in_a_frame_of_its_own(run, bag, tab, tmp_path):
    html = run._repr_html_()
    assert html.count('<iframe') == 1 and 'srcdoc=' in html and len(html) < 1_500_000
    assert 'http://' not in html.replace('http://www.w3.org', '')
    file = tmp_path / 'cell.html'
    file.write_text(f'<!doctype html><meta charset="utf-8"><body>{html}</body>')
    tab.open(file.as_uri())
    ready = "document.querySelector('iframe').contentDocument?.querySelectorAll('canvas').length"
    end = time.monotonic() + 60
    while not (tab.evaluate(ready) or 0) > 1 and time.monotonic() < end:
        time.sleep(0.2)
    assert tab.evaluate(ready) > 1  # the bodies, and the plots beside them
    assert 'srcdoc=' in rbs.open_bag(bag)._repr_html_()


def test_an_environment_pickles_and_goes_on_with_the_same_bits():
    env = rbs.BodyEnv('satellite', 'satellite', torque=0.5, every=0.1)
    env.reset(seed=1)
    other = pickle.loads(pickle.dumps(env))
    action = np.array([0.5, -1.0, 0.0])
    for _ in range(3):
        assert env.step(action)[0].tobytes() == other.step(action)[0].tobytes()


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize(
    'action', [[0.1, 0.2], [[0.1, 0.2, 0.3]], 0.5, [], ['1', '2', '3'], [True] * 3, [np.nan] * 3]
)
def test_an_action_of_another_shape_or_kind_is_refused(action):
    env = rbs.BodyEnv('satellite', 'satellite', torque=0.5, every=0.1)
    env.reset(seed=1)
    with pytest.raises(rbs.InvalidModel, match=r"action of 'satellite'.*allowed.*\(3,\)"):
        env.step(action)
    assert env.simulation.tick == 0


@pytest.mark.parametrize(
    ('given', 'said'),
    [
        ({'torque': -1}, 'torque: got -1; a finite number [N m], at least 0.0 is needed'),
        ({'reach': 'far'}, "reach: got 'far'; a finite number [m], at least 1.0 is needed"),
        ({'every': 0.0}, 'every: 0.0 s; allowed: from one tick of 0.01 s on'),
        ({'duration': -1}, 'duration: -1 s; allowed: a number of seconds from 0 on'),
        ({'reward': 3}, 'reward: got 3; allowed: a function, reward(state, action), which'),
        ({'start': {'velocity': 1}}, "start: got {'velocity': 1}; allowed: a function, start("),
        ({'start': lambda _rng: {'speed': 1}}, "start: gave 'speed'; allowed: position, "),
        ({'start': lambda _rng: 3}, 'start: gave 3; allowed: a mapping with position, '),
    ],
)
def test_what_an_environment_refuses_it_names(given, said):
    with pytest.raises(rbs.InvalidModel) as refused:
        rbs.BodyEnv('satellite', 'satellite', **{'torque': 1.0, **given}).reset(seed=1)
    assert str(refused.value).startswith(f"environment of 'satellite': {said}")


def test_the_environment_passes_the_check_of_gymnasium_without_a_warning():
    import gymnasium
    from gymnasium.utils.env_checker import check_env

    def start(rng):
        return {'angular_velocity': rng.normal(0, 0.1, 3)}

    env = rbs.BodyEnv('satellite', 'satellite', torque=0.5, every=0.1, duration=1, start=start)
    check_env(env)
    check_env(rbs.BodyEnv('satellite', 'beacon', force=1))
    check_env(
        gymnasium.make(
            'rigid_body_sim/Body-v0', scene='satellite', body='beacon', force=1
        ).unwrapped
    )
    runs = []
    for _ in range(2):
        observation, _ = env.reset(seed=7)
        rows = [observation]
        truncated = False
        while not truncated:
            observation, reward, terminated, truncated, _ = env.step(-5 * rows[-1][10:])
            rows.append(observation)
            assert reward <= 0 and not terminated
        runs.append(np.array(rows))
    assert runs[0].tobytes() == runs[1].tobytes() and len(runs[0]) == 11
    assert np.abs(runs[0][-1, 10:]).max() < 0.2 * np.abs(runs[0][0, 10:]).max()
    env = rbs.BodyEnv('satellite', 'beacon', force=1, every=1, duration=60, reach=10)
    env.reset()
    while True:
        observation, _, terminated, truncated, told = env.step([1, 0, 0])
        if terminated or truncated:
            break
    assert terminated and 'left its reach' in told['problem']
    assert env.observation_space.contains(observation)
    with pytest.raises(rbs.InvalidModel, match='one at least is commanded'):
        rbs.BodyEnv('satellite', 'satellite')
    with pytest.raises(rbs.InvalidModel, match='of a point mass a force alone'):
        rbs.BodyEnv('satellite', 'beacon', torque=1)
