# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The fixture `simulation` in test files as users write them, run by a pytest of their own.

Nodes and bags are real. Kernels are plain Python here: scenes are small, and nodes start faster.
"""

import re
import shlex
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rigid_body_sim.testing.domains import DomainLease

from ..patience import HANGING, PATIENCE

pytest.importorskip('rclpy')
pytest_plugins = ['pytester']

ROOT = Path(__file__).parents[2]
PLUGIN = ('-p', 'rigid_body_sim.testing.plugin', '-p', 'no:cacheprovider')

FILE = """
import os
import signal
import time
import pytest
from rigid_body_sim.testing import NodeFailure, Wrench

BALL = {'name': 'ball', 'mass': 2.0, 'shape': {'type': 'sphere', 'radius': 0.1}}
SCENE = {'dt': 0.01, 'bodies': [BALL]}
STIFF = {'type': 'spring', 'a': 'ball', 'b': 'world', 'b_point': [1, 0, 0], 'stiffness': 1e7}

def push(state):
    return {'ball/force': (1.0, 0.0, 0.0)}

def test_breaks_a_law(simulation):
    sim = simulation(SCENE, lockstep=['ball/force'])
    end = sim.lockstep(push, until=0.5)
    assert end['ball'].velocity[0] > 1.0

def test_diverges(simulation):
    sim = simulation({**SCENE, 'forces': [STIFF]}, integrator='explicit_euler')
    sim.until(lambda state: state.time > 100, 200)

def test_passes_but_its_node_does_not(simulation):
    sim = simulation(SCENE)
    sim.until(lambda state: state.time > 0.7, 10)
    os.kill(sim.pid, signal.SIGKILL)
"""


@pytest.fixture
def tried(pytester, monkeypatch):
    """
    Run pytest on a file; give its result.
    """
    monkeypatch.setenv('PYTHONPATH', str(ROOT), prepend=':')
    monkeypatch.setenv('RIGID_BODY_SIM_COMPILE', '0')

    def run(text, *words):
        pytester.makepyfile(test_it=text)
        return pytester.runpytest_subprocess(*PLUGIN, *words, timeout=HANGING)

    return run


def replayed(line):
    """
    Run a line of the summary in a shell.
    """
    return subprocess.run(
        ['sh', '-c', line], capture_output=True, text=True, timeout=HANGING, check=False
    )


def test_a_failure_shows_the_last_lines_and_keeps_the_bag_with_the_line_that_replays_it(
    tried, pytester
):
    result = tried(FILE, '-q')
    result.assert_outcomes(failed=2, passed=1, errors=1)
    result.stdout.fnmatch_lines(
        [
            '*_ test_breaks_a_law _*',
            '*- node 1 -*',
            'domain *, t = 0.5 s; the last lines of the node:',
            '*ready: scene (ball)*',
            '*_ test_diverges _*',
            'E *the node ended while the test waited for the next state, with exit code 1; the *',
            'E *diverged in tick *',
        ]
    )
    result.stdout.fnmatch_lines(
        [
            '*_ ERROR at teardown of test_passes_but_its_node_does_not _*',
            'the node ended by SIGKILL in place of 0; the last lines of the node:',
        ]
    )
    lines = {
        found.group(1): line
        for line in result.stdout.lines
        if (found := re.search(r'failed_bags/([^ ]+)$', line))
    }
    assert list(lines) == [
        'test_breaks_a_law',
        'test_diverges',
        'test_passes_but_its_node_does_not_recovered',
    ]
    for name in ('test_breaks_a_law', 'test_passes_but_its_node_does_not_recovered'):
        answer = replayed(lines[name])
        assert answer.returncode == 0, answer.stdout + answer.stderr
        assert 'identical' in answer.stdout
    bags = pytester.path / 'failed_bags'
    assert (bags / 'test_breaks_a_law' / 'metadata.yaml').is_file()
    assert shlex.split(lines['test_breaks_a_law'])[-1] == str(bags / 'test_breaks_a_law')


REFUSED = """
import pytest
from rigid_body_sim.testing import NodeFailure, Wrench

BALL = {'name': 'ball', 'mass': 2.0, 'shape': {'type': 'sphere', 'radius': 0.1}}
PLATE = {'name': 'plate', 'fixed': True, 'shape': {'type': 'sphere', 'radius': 0.1}}
SCENE = {'dt': 0.01, 'bodies': [BALL, PLATE]}

def test_no_such_scene(simulation):
    simulation('satelite')

def test_bad_mapping(simulation):
    simulation({'dt': 0.01, 'bodies': [{**BALL, 'mass': -1.0}]})

def test_no_such_parameter(simulation):
    simulation(SCENE, real_time_facter=2.0)

def test_bad_value(simulation):
    simulation(SCENE, publish_rate=0)

def test_refusals_while_it_runs(simulation):
    sim = simulation(SCENE, real_time_factor=2, lockstep=['ball/wrench'], namespace='lab')
    for wrong, word in (
        (lambda state: {'bal/wrench': (0,) * 6}, 'bal/wrench'),
        (lambda state: {'ball/wrench': (1, 2)}, 'at t = 0 s, for ball/wrench'),
        (lambda state: {'ball/wrench': Wrench(force=(0, 0, float('nan')))}, 'finite'),
    ):
        with pytest.raises(ValueError, match=word):
            sim.lockstep(wrong, until=1.0)
    with pytest.raises(NodeFailure, match='is fixed'):
        sim.force('plate', (1, 0, 0))
    with pytest.raises(NodeFailure, match='topic of lock-step'):
        sim.wrench('ball', (1, 0, 0))
    with pytest.raises(NodeFailure, match='no body is named'):
        sim.force('bal', (1, 0, 0))
    with pytest.raises(NodeFailure, match='range'):
        sim.set('real_time_factor', -1)
    with pytest.raises(NodeFailure, match='refused step: not paused'):
        sim.call('step')
    with pytest.raises(NodeFailure, match='waits for its controller'):
        sim.until(lambda state: True, 1)
    push = Wrench(force=(0, 4.0, 0), frame='body')
    half = sim.lockstep(lambda state: {'ball/wrench': push}, until=0.5)
    assert half.time == 0.5 and list(half) == ['ball', 'plate']
    end = sim.lockstep(lambda state: None, until=1.0)
    assert end['ball'].velocity[1] == pytest.approx(1.0, rel=1e-12)
    assert sim.bag().counts['/lab/ball/wrench'] == 100
    with pytest.raises(NodeFailure, match='has ended'):
        sim.time

def test_two_at_once(simulation):
    one = simulation(SCENE, start_paused=True, step_count=10)
    two = simulation(SCENE, start_paused=True, step_count=20, publish_rate=10.0)
    assert one.domain != two.domain
    one.impulse('ball', linear=(2.0, 0, 0))
    for sim, time in ((one, 0.1), (two, 0.2), (one, 0.2), (two, 0.4)):
        sim.call('step')
        assert sim.time == pytest.approx(time)
    assert one.state('ball').velocity[0] == 1.0
    assert two.state('ball').velocity[0] == 0.0
    assert 'reset at tick 20' in one.call('reset')
    assert one.time == pytest.approx(0.2) and one.state('ball').velocity[0] == 0.0
    one.force('ball', (0, 0, 20.0), frame='body')
    one.call('step')
    assert one.state('ball').velocity[2] == pytest.approx(1.0)  # 20 N, 2 kg, 0.1 s
    assert [one.bag(k).counts.get('/ball/impulse', 0) for k in (0, 1)] == [1, 0]
"""


def test_a_refusal_is_told_in_the_words_of_the_node_and_two_run_at_once(tried, pytester):
    result = tried(REFUSED, '-q', '-W', 'error')
    result.assert_outcomes(failed=4, passed=2)
    text = result.stdout.str()
    for words in (
        "NodeFailure: scene 'satelite': no such file; give",
        "'satellite'?",
        'bodies[0].mass: ',
        'real_time_facter is not one of this node and has no effect; did you mean real_time_f',
        'sim_node: error: parameter publish_rate: got 0.0; allowed: a number from 1e-09 to 1e+09',
    ):
        assert words in text
    assert not (pytester.path / 'failed_bags').exists()


def test_nothing_but_pytest_is_imported_before_a_test_asks_for_a_simulation():
    """
    The plugin is loaded by every pytest of an environment.
    """
    program = (
        'import pytest, sys; before = set(sys.modules); import rigid_body_sim.testing.plugin; '
    )
    program += 'print(*sorted(set(sys.modules) - before))'
    run = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert run.stdout.split() == [
        'rigid_body_sim',
        'rigid_body_sim.testing',
        'rigid_body_sim.testing.plugin',
    ]


ORPHAN = """
import os, sys
from pathlib import Path
from rigid_body_sim.testing.node_process import NodeProcess

node = NodeProcess([], folder=Path(sys.argv[1]), environment=os.environ)
print(node.pid, flush=True)
os._exit(1)
"""


def test_a_node_ends_when_the_process_of_its_test_is_gone(tmp_path):
    run = subprocess.run(
        [sys.executable, '-c', ORPHAN, str(tmp_path)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert run.returncode == 1
    process = Path('/proc') / run.stdout.strip()
    deadline = time.monotonic() + PATIENCE
    while process.exists():
        assert time.monotonic() < deadline, 'the node outlives the test'
        time.sleep(0.05)


def test_a_domain_is_taken_by_one_only():
    one, two = DomainLease(), DomainLease()
    assert one.number != two.number
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as somebody:
        one.end()
        somebody.bind(('', 7410 + 250 * one.number))  # as the first node of that domain does
        three = DomainLease()
        assert three.number not in (one.number, two.number)
    two.end()
    three.end()
