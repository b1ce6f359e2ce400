# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How kernels are compiled is nobody else's business: a program's own numba functions, compiled in
another thread at the same time or called by a kernel, are numba's, and so is all of its inside.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rigid_body_sim.physics.compile import kernels

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(
    not kernels.COMPILED, reason='numba is not installed: nothing is compiled'
)

BESIDE = """
import gc, inspect, threading
import numba
import numpy as np
from numba.core import base, codegen, compiler, cpu, dispatcher, lowering, typeinfer
from numba.core.types import functions
from numba.core.typing import context
from numba.np import arrayobj
from rigid_body_sim import Simulation, load_scene

CLASSES = (functions.BaseFunction, functions.BoundFunction, lowering.Lower, base.BaseContext,
           cpu.CPUContext, context.BaseContext, codegen.CPUCodeLibrary, dispatcher.Dispatcher,
           compiler.CompilerBase, typeinfer.TypeInferer)

def inside():
    modules = {(m.__name__, k): v for m in (arrayobj, lowering, compiler, typeinfer)
               for k, v in vars(m).items() if inspect.isfunction(v)}
    classes = {(c, k): v for c in CLASSES for k, v in vars(c).items() if inspect.isfunction(v)}
    return modules | classes

def process():
    return gc.get_threshold(), gc.get_freeze_count(), numba.config.CACHE_DIR

before, state = inside(), process()
done, seen, wrong = threading.Event(), [0, 0], []

def watch():
    while not done.is_set():
        seen[0] += 1
        if inside() != before or process() != state:
            wrong.append('another inside of numba, or another state of the process')
            return
        done.wait(0.02)

def use():
    a = np.arange(5.0)
    while not done.is_set():
        @numba.njit
        def last(a, i):
            a[-2] = 10.0 + a[-2]
            return a[-1] + a[i]
        got = last(a.copy(), -3)
        if got != 6.0:
            wrong.append(got)
            return
        seen[1] += 1
        done.wait(0.05)

threads = [threading.Thread(target=work) for work in (watch, use)]
for thread in threads:
    thread.start()
sim = Simulation(load_scene('spring_ball'), integrator='midpoint')
sim.prepare()
sim.step(3)
done.set()
for thread in threads:
    thread.join()
if not gc.isenabled():  # paused while kernels compile, and for no longer
    wrong.append('the garbage collector stayed off')
print(wrong, seen[0] > 10, seen[1] > 0)
"""

CALLED = """
import numba
import numpy as np
from numba.extending import overload
from rigid_body_sim.physics.compile import kernels

@numba.njit
def last(a):
    return a[-1]

def first_but_one(a):
    return a[-4]

@overload(first_but_one)
def _first_but_one(a):
    return lambda a: a[-4]

@kernels.kernel
def twice(a):
    return 2.0 * last(a) + first_but_one(a)

@numba.njit
def both(a):
    return last(a), first_but_one(a)

a = np.arange(5.0)
print(twice(a), last(a), both(a), a[-1])
"""


def run(code, tmp_path):
    path = tmp_path / 'program.py'
    path.write_text(code)
    done = subprocess.run(
        [sys.executable, str(path)],
        env=os.environ | {'RIGID_BODY_SIM_CACHE': str(tmp_path), 'PYTHONPATH': str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=HANGING,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.long
def test_functions_of_another_thread_count_from_the_end_while_kernels_compile(tmp_path):
    assert run(BESIDE, tmp_path) == '[] True True'


def test_functions_that_a_kernel_calls_stay_those_of_the_program(tmp_path):
    assert run(CALLED, tmp_path) == '9.0 4.0 (4.0, 1.0) 4.0'
