# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What kernels call is the plain source: parts of arrays, ranges, members of tuples, and what is
handed on and returned, whether or not it may raise an error; and of what the package is made
nothing may.
"""

import os
import subprocess
import sys
from pathlib import Path
from types import FunctionType
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigid_body_sim.physics.compile import kernels

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(
    not kernels.COMPILED, reason='numba is not installed: nothing is compiled'
)
LENGTH = 7
place = st.integers(0, LENGTH + 3)
STRIDE = 3


def as_python(kernel):
    """The source of a kernel as Python runs it, with that of what it calls."""
    source = kernels.plain(kernel)
    called = {name: as_python(value) for name, value in source.__globals__.items()
              if name in source.__code__.co_names and hasattr(value, 'py_func')}  # fmt: skip
    return FunctionType(source.__code__, source.__globals__ | called)


class Pair(NamedTuple):
    numbers: object
    counts: object


@kernels.inline
def _note(part, out):
    out[0] = len(part)
    for i in range(len(part)):
        out[1 + i] = part[i]


@kernels.kernel
def _parts(begin, end, numbers, out):
    _note(numbers[begin:end], out)
    _note(numbers[begin:], out[10:])
    _note(numbers[:end], out[20:])
    _note(numbers[2:5], out[30:])
    _note(numbers[begin:][:end][1:], out[40:])


@given(place, place)
def test_a_part_of_an_array_is_what_lies_between_two_indices(begin, end):
    found = []
    for run in (_parts, as_python(_parts)):
        out = np.zeros(50)
        run(begin, end, np.arange(1.0, LENGTH + 1.0), out)
        found.append(out)
    assert np.array_equal(*found)


@kernels.inline
def _list_by(start, stop, step, out):
    count = 0
    for number in range(start, stop, step):
        out[count] = number
        count += 1
    return count


@kernels.kernel
def _ranges(start, stop, step, out):
    count = _list_by(start, stop, step, out)
    count += _list_by(start, stop, STRIDE, out[count:])
    count += _list_by(stop, start, -STRIDE, out[count:])
    for number in range(stop):
        out[count] = number
        count += 1
    for number in range(start, stop):
        for other in range(number, start - 1, -1):
            out[count] = other
            count += 1
            if other == 2:
                break
    return count


@given(st.integers(-6, 6), st.integers(-6, 6), st.integers(-4, 4).filter(bool))
def test_a_range_is_that_of_python(start, stop, step):
    found = []
    for run in (_ranges, as_python(_ranges)):
        out = np.zeros(200)
        found.append((run(start, stop, step, out), out.tolist()))
    assert found[0] == found[1]


@kernels.inline
def _sum_and_turn(way, pair):
    total = 0.0
    for number in way:
        total += number
    pair.numbers[0] += total
    pair.counts[0] += 1
    return (way[1], way[2], way[0]), pair.counts[0] > 1, pair


@kernels.kernel
def _hand_on(axis, numbers, counts, out):
    way, is_later, pair = _sum_and_turn((1.0, 20.0, 300.0), Pair(numbers, counts))
    out[0] = way[axis]
    way, is_later, pair = _sum_and_turn(way, pair)
    for number in (4, axis):
        out[1] += number
    out[2] = way[axis] if is_later else 0.0
    out[3] = pair.numbers[0] + len(pair.counts)


@pytest.mark.parametrize('axis', range(3))
def test_tuples_with_their_arrays_are_handed_on_and_returned(axis):
    found = []
    for run in (_hand_on, as_python(_hand_on)):
        numbers, counts, out = np.zeros(2), np.zeros(3, dtype=np.int64), np.zeros(4)
        run(axis, numbers, counts, out)
        found.append((numbers.tolist(), counts.tolist(), out.tolist()))
    assert found[0] == found[1]
    assert found[0][:2] == ([642.0, 0.0], [2, 0, 0])


@kernels.inline
def _raise_to(base, exponent):
    return base**exponent  # numba compiles a loop for it, which may raise an error


@kernels.inline
def _cubes(count, out):
    for i in range(count):
        out[i] = _raise_to(i, 3) + out[i]


@kernels.kernel
def _cubes_of(count, out):
    _cubes(count, out)
    _cubes(count - 1, out[1:])


def test_what_may_raise_an_error_is_called_all_the_same():
    out = np.zeros(5)
    _cubes_of(5, out)
    assert out.tolist() == [0, 1, 8 + 1, 27 + 8, 64 + 27]


FAR = """
import sys
import numpy as np
from rigid_body_sim.physics.compile import kernels

@kernels.inline
def member(numbers, place):
    return numbers[place]

@kernels.kernel
def run(numbers, place, axis):
    of_tuple = member((0.0, 0.0, 0.0), axis)
    return member(numbers, place) + member(numbers[1:], place) + of_tuple

for words in sys.argv[1:]:
    try:
        print(run(np.arange(5.0), *map(int, words.split())))
    except IndexError:
        print('refused')
"""


@pytest.mark.parametrize(
    'others', [[], pytest.param([{'NUMBA_OPT': '3'}], marks=pytest.mark.long)]
)
def test_who_wants_indices_checked_gets_no_piece_that_was_kept_without(tmp_path, others):
    """
    Nor the other way round. In the long form also by way of numba, to which any setting leads.
    """
    program = tmp_path / 'far.py'
    program.write_text(FAR)

    def run(*places_and_axes, **environment):
        own = {'RIGID_BODY_SIM_CACHE': str(tmp_path), 'PYTHONPATH': str(ROOT)}
        done = subprocess.run(
            [sys.executable, str(program), *places_and_axes], env=os.environ | own | environment,
            check=True, capture_output=True, text=True, timeout=HANGING,
        )  # fmt: skip
        return done.stdout.split()

    assert run('2 0') == ['5.0']
    for other in others:
        assert run('2 0', **other) == ['5.0']
    checked = run('4 0', '2 3', '2 0', NUMBA_BOUNDSCHECK='1')
    assert checked == ['refused', 'refused', '5.0']
    for unchecked in ({}, *others):
        (beside,) = run('4 0', **unchecked)  # a number beside the array
        assert beside != 'refused'


COUNT = """
import sys
from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.compile import numba_calls, numba_pipeline

why, own = [], numba_pipeline.LowerKernel.lower
def lower(self):
    try:
        own(self)
    except numba_calls.Raises:
        why.append(self.func_ir.func_id.func_qualname)
        raise
numba_pipeline.LowerKernel.lower = lower
Simulation(load_scene(sys.argv[1])).step(2)
assert len(numba_pipeline._ALL_CALLED) > 20
print(*why)
"""


@pytest.mark.skipif(kernels.IMAGES is None, reason='no images here')
def test_nothing_that_springs_are_made_of_may_raise_an_error(tmp_path):
    environment = os.environ | {'RIGID_BODY_SIM_CACHE': str(tmp_path), 'PYTHONPATH': str(ROOT)}
    done = subprocess.run(
        [sys.executable, '-c', COUNT, str(ROOT / 'config/scenes/two_bodies.yaml')],
        env=environment, check=False, capture_output=True, text=True, timeout=HANGING,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not done.stdout.split()
