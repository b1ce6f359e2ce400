# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A step beyond a limit of the integrator is warned of in words: at the start, when it is passed on
the way, in the bag; so is a mesh that collides as a larger hull. A run that diverges ends with
exit code 1 and a readable bag, whatever the verb.
"""

import json
from itertools import pairwise

import pytest

from rigid_body_sim import Simulation, SimulationDiverged, load_scene
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.asked_states import AskedState
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.scene.shipped_scenes import find_scene

from .conftest import SCENES

BALL = {'name': 'ball', 'mass': 1.0, 'shape': {'type': 'particle'}}
STIFF = """version: 1
name: stiff
dt: 0.01
bodies:
  - {name: ball, mass: 1, shape: {type: particle}, initial: {position: [1, 0, 0]}}
forces:
  - {type: spring, a: ball, b: world, stiffness: 1000000}
"""
BOX = """version: 1
name: box
dt: 0.01
bodies:
  - {name: box, mass: 1, shape: {type: box, size: [0.4, 0.2, 0.1]}}
"""
# A wedge with a notch: an L of three unit squares in x and z, one metre deep.
NOTCHED = """OFF
12 20 0
0 0 0
2 0 0
2 0 1
1 0 1
1 0 2
0 0 2
0 1 0
2 1 0
2 1 1
1 1 1
1 1 2
0 1 2
3 0 1 2
3 0 2 3
3 0 3 5
3 3 4 5
3 6 8 7
3 6 9 8
3 6 11 9
3 9 11 10
3 0 7 1
3 0 6 7
3 1 8 2
3 1 7 8
3 2 9 3
3 2 8 9
3 3 10 4
3 3 9 10
3 4 11 5
3 4 10 11
3 5 6 0
3 5 11 6
"""
MEETING = """version: 1
name: meeting
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: timestep}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: angle
    density: 100
    shape: {type: mesh, file: notched.off}
    initial: {position: [0, 0, 1]}
    repeat: {count: [3, 1, 1], spacing: [4, 0, 0]}
  - name: corner
    density: 100
    shape: {type: mesh, file: convex.off}
    initial: {position: [0, 9, 1]}
"""
TURN = 'time,body,kind,frame,tx,ty,tz\n0.05,box,torque,world,1,0.3,0.1\n'


def scene(bodies, forces, *, dt=0.01):
    return load_scene({'version': 1, 'name': 's', 'dt': dt, 'bodies': bodies, 'forces': forces})


@pytest.fixture
def stiff(tmp_path):
    path = tmp_path / 'stiff.yaml'
    path.write_text(STIFF)
    return path


@pytest.fixture
def box(tmp_path):
    (tmp_path / 'box.yaml').write_text(BOX)
    (tmp_path / 'turn.csv').write_text(TURN)
    return tmp_path / 'box.yaml', '--commands', tmp_path / 'turn.csv', '--integrator', 'rk4'


@pytest.mark.parametrize('path', sorted(SCENES.glob('*.yaml')), ids=lambda path: path.stem)
def test_shipped_scenes_are_within_the_limits_of_their_integrators(path):
    assert Simulation(load_scene(find_scene(path.stem))).warnings() == []


def test_simulate_warns_at_the_start_and_says_body_product_limit_and_cure(verb, stiff, tmp_path):
    code, _, err = verb('simulate', stiff, '-o', tmp_path / 'b', '--duration', 0.1)
    assert code == 0
    line, gain = err.splitlines()
    assert line.startswith("rigid_body_sim simulate: warning: 'ball' may swing at 1e+03 rad/s")
    for part in ('h omega = 10 a step', 'dmv6', 'only up to 2', 'dt <= 0.002 s', 'substeps: 5'):
        assert part in line
    assert 'warning: the scene gained' in gain and 'dmv6 brought it in' in gain
    told = [text.partition('warning: ')[2] for text in (line, gain)]
    assert json.loads(Bag(tmp_path / 'b').ending['warnings']) == told


def test_each_cure_of_a_warning_heals(stiff):
    made = load_scene(stiff)
    (text,) = Simulation(made).warnings()
    assert 'the integrator linearly_implicit' in text
    assert Simulation(made, dt=0.002).warnings() == []
    assert Simulation(made, integrator_options={'substeps': 5}).warnings() == []
    assert Simulation(made, integrator='linearly_implicit').warnings() == []
    assert Simulation(made, dt=0.0021).warnings() != []


def test_a_limit_that_is_passed_on_the_way_is_warned_of_once(verb, box, tmp_path):
    code, _, err = verb('simulate', *box, '-o', tmp_path / 'b', '--duration', 1)
    assert code == 0
    (line,) = err.splitlines()
    assert "warning: 'box' turns by h |omega| =" in line and 'only up to 0.25' in line


@pytest.fixture
def meeting(tmp_path):
    (tmp_path / 'notched.off').write_text(NOTCHED)
    convex = (SCENES / 'meshes' / 'tetrahedron.off').read_text()
    (tmp_path / 'convex.off').write_text(convex)
    (tmp_path / 'meeting.yaml').write_text(MEETING)
    return tmp_path / 'meeting.yaml'


def test_a_mesh_that_collides_as_a_larger_hull_is_warned_of_once(verb, meeting, tmp_path):
    code, _, err = verb('simulate', meeting, '-o', tmp_path / 'b', '--duration', 0.02)
    assert code == 0
    (line,) = err.splitlines()
    # The hull of the L is a square of 2 m without a corner of half a square: 3 of 3.5 m^3.
    for part in (
        "warning: 'angle_1' collides as the convex hull of its mesh", '14 % of this hull',
        'a union of convex shapes', '(2 bodies more)',
    ):  # fmt: skip
        assert part in line
    assert 'corner' not in line
    assert json.loads(Bag(tmp_path / 'b').ending['warnings']) == [line.partition('warning: ')[2]]
    assert Simulation(load_scene(meeting)).warnings() == [line.partition('warning: ')[2]]


def test_a_mesh_that_meets_nothing_is_not_warned_of(meeting):
    meeting.write_text(MEETING.replace('mode: timestep', 'mode: none'))
    assert Simulation(load_scene(meeting)).warnings() == []


def test_json_names_the_warnings(as_json, stiff, tmp_path):
    code, told = as_json('simulate', stiff, '-o', tmp_path / 'b', '--duration', 0.1)
    assert code == 0
    limit, gain = told['warnings']
    assert limit.startswith("'ball' ") and gain.startswith('the scene gained ')
    code, told = as_json('replay', tmp_path / 'b')
    assert (code, told['warnings']) == (0, [limit, gain])
    code, told = as_json('replay', tmp_path / 'b', '--integrator', 'linear_propagator')
    assert (code, told['warnings']) == (0, [])


def test_a_run_that_spins_itself_apart_ends_with_1_and_a_whole_bag(verb, box, tmp_path):
    code, out, err = verb('simulate', *box, '-o', tmp_path / 'b', '--duration', 10)
    assert code == 1
    warning, error = err.splitlines()
    assert 'warning' in warning
    assert "'box' diverged in tick" in error and 'rk4' in error
    ending = Bag(tmp_path / 'b').ending
    assert ending['end_reason'] == 'diverged'
    assert f'tick {ending["last_tick"]}:' in error
    assert len(json.loads(ending['warnings'])) == 1
    code, out, _ = verb('replay', tmp_path / 'b')
    assert (code, out.startswith('identical')) == (0, True)


def test_a_replay_that_diverges_ends_with_1_and_a_whole_bag(verb, stiff, tmp_path):
    words = ('--integrator', 'linear_propagator', '--duration', 5)
    assert verb('simulate', stiff, '-o', tmp_path / 'b', *words)[0] == 0
    code, out, err = verb(
        'replay', tmp_path / 'b', '--integrator', 'dmv6', '-o', tmp_path / 'again'
    )
    assert (code, out) == (1, '')
    *warnings, error = err.splitlines()
    assert len(warnings) == 2  # of the limit, and of the energy that was gained
    assert all(line.startswith('rigid_body_sim replay: warning:') for line in warnings)
    assert error.startswith("rigid_body_sim replay: error: 'ball' diverged in tick")
    again = Bag(tmp_path / 'again')
    assert again.ending['end_reason'] == 'diverged'
    assert int(again.ending['last_tick']) > 100
    poses = sum(1 for _ in again.messages(['/ball/pose']))
    assert poses == 1 + int(again.ending['last_tick'])  # t = 0 among them
    assert verb('bag', 'check', tmp_path / 'again')[0] == 0


def test_a_replay_over_huge_numbers_prints_numbers(as_json, verb, stiff, tmp_path):
    words = ('--integrator', 'linear_propagator', '--duration', 1)
    assert verb('simulate', stiff, '-o', tmp_path / 'b', *words)[0] == 0
    code, told = as_json('replay', tmp_path / 'b', '--integrator', 'dmv6')
    assert code == 0
    assert 1e150 < told['errors']['ball']['largest']['position'] < 1e250


def in_contact(share, *, mode='timestep', substeps=4, dt=0.02, more=()):
    """A ball of 1 kg on a spring, at a share of the limit of dmv6: h omega = 2."""
    stiffness = (2.0 * share * substeps / dt) ** 2
    ball = {'name': 'ball', 'mass': 1.0, 'shape': {'type': 'sphere', 'radius': 0.1}}
    return load_scene(
        {
            'dt': dt,
            'contact': {'mode': mode, 'substeps': substeps},
            'bodies': [*more, ball | {'initial': {'position': [0.01, 0, 0]}}],
            'forces': [{'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': stiffness}],
        }
    )


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize(('mode', 'substeps'), [('timestep', 4), ('timestep', 1), ('event', 4)])
def test_a_step_in_contact_is_a_substep_of_it_and_what_is_said_to_be_stable_is(mode, substeps):
    within, beyond = (
        Simulation(in_contact(share, mode=mode, substeps=substeps)) for share in (0.95, 1.05)
    )
    assert within.warnings() == []
    (said,) = beyond.warnings()
    assert 'h omega = 2.1 a step; dmv6 is stable only up to 2; take dt <= 0.019 s' in said
    assert ('contact.substeps: 5' in said) == (substeps == 4)
    assert 'the integrator' not in said  # none that takes contact has a longer step
    within.step(300)
    assert abs(within.state.position).max() < 0.05  # 1/sqrt(1 - 0.95^2) of where it began
    beyond.step(20)
    assert abs(beyond.state.position).max() > 1.0


@pytest.mark.usefixtures('plain_source')
def test_who_takes_others_along_when_it_diverges_is_named_with_its_steps():
    box = {'name': 'box', 'mass': 2.0, 'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]}}
    box |= {'initial': {'position': [-1, 0, 1], 'angular_velocity': [0, 2, 0.02]}}
    sim = Simulation(in_contact(10.0, more=[box]))
    with pytest.raises(SimulationDiverged) as error:
        sim.step(300)
    assert error.value.body == 'ball'
    assert 'at dt = 0.02 s, 4 substeps of contact in a step, the limits' in str(error.value)


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize(
    ('command', 'words'),
    [
        (
            Command('box', 'torque', torque=(0, 3e11, 4e11)),
            '/box/torque in tick 30: torque of 5e+11 N m, which gives 2.4e+13 rad/s within 0.2 s',
        ),
        (
            Command('box', 'impulse', torque=(1e12, 1e12, 0)),
            '/box/impulse in tick 30: angular impulse of 1.41e+12 N m s, which gives 3.39e+14 rad',
        ),
        (
            Command('box', 'set_state', state=AskedState(angular=(6e9, 8e9, 0))),
            '/box/set_state in tick 30: angular velocity of 1e+10 rad/s',
        ),
    ],
)
def test_a_command_of_absurd_size_is_blamed_for_the_run_that_it_ends(command, words):
    run = Run(Simulation(load_scene(BOX.encode())), RunSettings(publish_every=10))
    modest = Command('box', 'torque', torque=(1e-3, 0, 0))
    with pytest.raises(SimulationDiverged) as error:
        for _, _output in run.follow({10: [modest], 30: [command], 31: [modest]}, 200):
            pass
    said = str(error.value)
    assert "'box' diverged in tick 3" in said
    assert f'its state is no longer finite; likely by the command to {words}' in said
    assert said.endswith('check its size and unit')
    assert 'smaller dt' not in said


@pytest.mark.usefixtures('plain_source')
def test_of_a_run_that_no_command_ends_none_is_blamed():
    pushed = [Command('ball', 'force', force=(100.0, 0, 0))]
    run = Run(Simulation(load_scene(STIFF.encode())), RunSettings(publish_every=10))
    with pytest.raises(SimulationDiverged, match='take a smaller dt or another integrator'):
        for _, _output in run.follow(dict.fromkeys(range(0, 1000, 10), pushed), 1000):
            pass
    run.reset()
    # what was asked before a reset has no part in what comes after it
    run.advance(1, [Command('ball', 'set_state', state=AskedState((1e12, 0, 0)))])
    run.reset()
    with pytest.raises(SimulationDiverged, match='take a smaller dt or another integrator'):
        for _, _output in run.follow({}, run.simulation.tick + 1000):
            pass


@pytest.mark.usefixtures('plain_source')
def test_what_is_held_of_absurd_size_is_blamed_without_a_topic_too():
    sim = Simulation(load_scene(BOX.encode()))
    sim.set_wrench('box', torque=(0, 3e11, 4e11))
    with pytest.raises(SimulationDiverged, match=r"command to 'box': torque of 5e\+11 N m, which"):
        sim.step(100)


def rates(made):
    sim = Simulation(made)
    return {kind: found.tolist() for kind, found in sim.stability.rates(sim.state).items()}


def test_frequency_of_one_spring_is_exact_whatever_it_holds():
    two = [BALL, BALL | {'name': 'rock', 'mass': 3.0}]
    spring = {'type': 'spring', 'a': 'rock', 'b': 'ball', 'stiffness': 12.0, 'damping': 3.0}
    found = rates(scene(two, [spring]))
    assert found['oscillation'] == pytest.approx([4.0, 4.0])  # sqrt(12 (1 + 1/3))
    assert found['relaxation'] == pytest.approx([4.0, 4.0])  # 3 (1 + 1/3)
    held = {'type': 'spring', 'a': 'world', 'b': 'ball', 'stiffness': 9.0}
    assert rates(scene(two, [held]))['oscillation'] == pytest.approx([3.0, 0.0])
    fixed = [BALL, BALL | {'name': 'rock', 'mass': 3.0, 'fixed': True}]
    assert rates(scene(fixed, [spring]))['oscillation'] == pytest.approx([12.0**0.5])


def test_frequency_of_a_spring_off_centre_counts_the_rotation():
    """A rod of moment I, a spring k across its tip at l: omega^2 = k (1/m + l^2 / I)."""
    rod = {'name': 'rod', 'mass': 2.0, 'inertia': {'ixx': 0.01, 'iyy': 0.5, 'izz': 0.5}}
    spring = {'type': 'spring', 'a': 'rod', 'a_point': [1, 0, 0], 'b': 'world', 'stiffness': 8.0}
    found = rates(scene([rod], [spring | {'b_point': [1, 0, 0]}]))
    assert found['oscillation'] == pytest.approx([(8.0 * (0.5 + 2.0)) ** 0.5])


def test_frequency_of_a_chain_is_bounded_closely():
    """n equal masses between walls: 2 sqrt(k/m) cos(pi / (2 (n + 1))) is the highest."""
    n = 10
    bodies = [BALL | {'name': f'b{i}'} for i in range(n)]
    ends = ['world', *(f'b{i}' for i in range(n)), 'world']
    links = [{'type': 'spring', 'a': a, 'b': b, 'stiffness': 100.0} for a, b in pairwise(ends)]
    assert max(rates(scene(bodies, links))['oscillation']) == pytest.approx(20.0, rel=1e-12)


def test_drag_counts_with_the_present_speed():
    moving = BALL | {'initial': {'velocity': [3, 0, 4]}}
    drag = {'type': 'drag', 'body': 'ball', 'linear': 1.0, 'quadratic': 2.0}
    assert rates(scene([moving], [drag]))['relaxation'] == pytest.approx([11.0])


def test_many_bodies_beyond_a_limit_make_one_line():
    bodies = [
        {
            'name': f'b{i}',
            'mass': 1.0,
            'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 3.0},
            'initial': {'angular_velocity': [30.0 + i, 1, 1]},
        }
        for i in range(5)
    ]
    (text,) = Simulation(scene(bodies, []), integrator='rk4').warnings()
    assert text.startswith("'b4' ") and text.endswith('(4 bodies more)')


def test_body_names_are_those_of_the_scene_where_points_come_first():
    rod = {'name': 'rod', 'mass': 2.0, 'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 3.0}}
    spring = {'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': 1e6}
    (text,) = Simulation(scene([BALL, rod], [spring])).warnings()
    assert text.startswith("'ball' ")


@pytest.mark.parametrize('name', sorted(INTEGRATORS))
def test_a_body_at_rest_is_no_cause_of_warnings(name):
    assert Simulation(scene([BALL], []), integrator=name).warnings() == []
