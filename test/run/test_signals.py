# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Runs that are stopped or killed: `tools/interrupt_runs.py` does it by the hundred.
"""

import os
import signal
import subprocess
import sys
import time

import pytest

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.pace import CALL, Pace

from ..patience import HANGING, PATIENCE
from .conftest import ROOT


@pytest.fixture
def begun(tmp_path):
    """Start `simulate` in a process of its own; wait until its bag holds more than its start."""
    processes = []

    def start(*words):
        process = subprocess.Popen(
            [sys.executable, '-m', 'rigid_body_sim', 'simulate', *words, '-o', tmp_path / 'bag'],
            env=os.environ | {'PYTHONPATH': str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        file, size, deadline = tmp_path / 'bag' / 'bag_0.mcap', 0, time.monotonic() + PATIENCE
        sizes = set()
        while len(sizes) < 4:  # with those of a bag that is being made
            assert time.monotonic() < deadline and process.poll() is None, process.stderr.read()
            if file.exists() and (size := file.stat().st_size):
                sizes.add(size)
            time.sleep(0.01)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    ('numbers', 'code', 'name'),
    [
        pytest.param([signal.SIGINT], 130, 'Ctrl-C', marks=pytest.mark.long),
        ([signal.SIGTERM] * 3, 143, 'SIGTERM'),
    ],
)
def test_a_signal_ends_a_run_at_a_tick_with_a_whole_bag(
    begun, verb, tmp_path, numbers, code, name
):
    process = begun('two_bodies', '--duration', '1e6', '--publish-rate', '7')
    for number in numbers:
        process.send_signal(number)
        time.sleep(0.003)
    _, said = process.communicate(timeout=HANGING)
    assert process.returncode == code
    *_, line = said.splitlines()
    assert f'stopped by {name} at ' in line and ' s of 1000000 s' in line
    bag = Bag(tmp_path / 'bag')
    assert bag.ending['end_reason'] == 'signal'
    # the run was long, and is not to be done again: as long as needed to see that ticks are whole
    assert float(line.partition(' at ')[2].split()[0]) == pytest.approx(
        int(bag.ending['last_tick']) * 1e-3
    )
    assert verb('bag', 'check', bag.path)[0] == 0
    assert verb('replay', bag.path)[0] == 0


def test_a_killed_slow_run_loses_no_more_than_its_last_moments(begun, verb, tmp_path):
    process = begun(
        'two_bodies', '--integrator', 'scipy_radau', '--publish-rate', '500', '--duration', '1e3'
    )
    process.kill()
    assert process.wait() == -signal.SIGKILL
    assert verb('bag', 'recover', tmp_path / 'bag', '-o', tmp_path / 'saved')[0] == 0
    saved = Bag(tmp_path / 'saved')
    assert 0 < sum(saved.counts.values()) and next(saved.messages()).log_time == 0
    assert verb('replay', saved.path)[0] == 0


def test_a_pace_finds_how_many_ticks_take_its_time():
    for tick in (1e-7, 1e-3, 10.0):  # [s] that one takes
        pace = Pace()
        for _ in range(40):
            pace.note(pace.ticks, pace.ticks * tick)
        assert pace.ticks == 1 or CALL / 4 <= pace.ticks * tick <= CALL * 1.01


INTERRUPTED_IMPORT = """
import os, signal, sys

class Interrupts:
    def find_spec(name, path=None, target=None):
        if name == 'rigid_body_sim.stop_signals':  # one of the first that a verb needs
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Interrupts)
from rigid_body_sim.executables import simulate
sys.exit(simulate())
"""


def test_ctrl_c_while_an_executable_imports_its_verb_leaves_no_traceback():
    ended = subprocess.run(
        [sys.executable, '-c', INTERRUPTED_IMPORT],
        env=os.environ | {'PYTHONPATH': str(ROOT)},
        capture_output=True,
        timeout=PATIENCE,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (-signal.SIGINT, b'')  # a shell says 130
