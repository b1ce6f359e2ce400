# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The compiled kernels and the plain Python source give the same bits."""

import hashlib
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.compile import kernels

from .. import inside
from ..patience import HANGING
from . import bits_of_elements, bits_of_methods, scenes

ROOT = str(Path(__file__).parents[2])


@pytest.mark.skipif(
    not kernels.COMPILED, reason='numba is not installed: there is nothing to compare with'
)
@pytest.mark.parametrize(
    ('bits', 'how'),
    [
        pytest.param(bits_of_methods, [], id='methods'),
        pytest.param(bits_of_methods, ['in full'], id='methods in full', marks=pytest.mark.long),
        pytest.param(bits_of_elements, bits_of_elements.SHORT, id='forces'),
        pytest.param(bits_of_elements, [], id='forces on more methods', marks=pytest.mark.long),
    ],
)
def test_every_integrator_and_force_gives_the_same_bits_with_and_without_numba(bits, how):
    """
    Compiled in this process: as all tests know them.
    """
    result = subprocess.run(
        [sys.executable, bits.__file__, *how],
        env=os.environ | {'RIGID_BODY_SIM_COMPILE': '0', 'PYTHONPATH': ROOT},
        capture_output=True,
        text=True,
        check=True,
        timeout=HANGING,
    )
    first, *plain = result.stdout.splitlines()
    assert first == 'False'
    assert plain == list(bits.lines(*how))


RUN = """
import sys
sys.path.insert(0, sys.argv[1])
import numba
if sys.argv[2] == 'unknown':
    numba.__version__ = '0.0'
from rigid_body_sim import Simulation
from rigid_body_sim.physics.state.blocks import rotate
import scenes
sim = Simulation(eval('scenes.' + sys.argv[3]), integrator='explicit_euler')
sim.step(50)
print(type(rotate).__name__, sim.state_bytes().hex())
"""
TOP, OSCILLATOR, CHAIN = 'top()', 'oscillator(dt=0.01)', 'linked_points()'
FREE = 'scene([{"name": "a", "mass": 1.0, "shape": {"type": "particle"}}], gravity=(0, 0, -9.81))'


def kind_and_bits(*arguments: str, cache: Path) -> list[str]:
    """How a kernel is made, and the bits of a run, with the release of numba and the scene."""
    result = subprocess.run(
        [sys.executable, '-c', RUN, str(Path(__file__).parent), *arguments],
        env=os.environ | {'RIGID_BODY_SIM_CACHE': str(cache), 'PYTHONPATH': ROOT},
        capture_output=True,
        text=True,
        check=True,
        timeout=HANGING,
    )
    return result.stdout.split()


@pytest.mark.skipif(not kernels.COMPILED, reason='numba is not installed: nothing is compiled')
@pytest.mark.parametrize(
    'scene', [FREE, pytest.param(TOP, marks=pytest.mark.long)], ids=['point', 'top']
)
def test_a_numba_whose_inside_is_not_known_gives_the_same_bits(tmp_path, scene):
    kind, bits = kind_and_bits('unknown', scene, cache=tmp_path)
    assert kind == 'CPUDispatcher'
    sim = Simulation(eval(f'scenes.{scene}'), integrator='explicit_euler')
    sim.step(50)
    assert bits == sim.state_bytes().hex()


@pytest.mark.skipif(not kernels.COMPILED, reason='numba is not installed: nothing is compiled')
@pytest.mark.long
def test_what_an_earlier_scene_compiled_gives_the_same_bits_in_another(tmp_path):
    """
    Points on springs, whose kernel finds what that of a point on a spring has left. In the short
    form all kernels of the suite do, whose bits are compared above.
    """
    kind_and_bits('this', OSCILLATOR, cache=tmp_path)
    _, bits = kind_and_bits('this', CHAIN, cache=tmp_path)
    chain = Simulation(scenes.linked_points(), integrator='explicit_euler')
    chain.step(50)
    assert bits == chain.state_bytes().hex()


@pytest.mark.skipif(not kernels.COMPILED, reason='numba is not installed: nothing is compiled')
def test_a_kernel_gives_the_same_to_python_and_to_a_kernel():
    for _ in range(2):
        assert doubled(0.1) == 0.2
        assert doubled_three(0.1, 3) == 0.2 + 6 + 4


@kernels.inline
def doubled(x):
    return x + x


@kernels.kernel
def doubled_three(x, n):
    return doubled(x) + doubled(n) + doubled(2)


def test_a_reset_run_takes_the_kernel_that_it_has():
    """
    For arguments of other types, numba would compile it anew.
    """
    sim = Simulation(scenes.oscillator(dt=0.01))
    _, kernel = inside.kernels_of(sim)
    called = []

    def noted(*arguments):
        called.append(tuple(type(one) for one in arguments))
        return kernel(*arguments)

    inside.advance_by(sim, noted)
    sim.step(3)
    sim.reset()
    sim.step(3)
    assert len(called) == 2
    assert called[0] == called[1]


def test_the_cache_folder_names_the_kernel_sources():
    if kernels.CACHE is not None:
        assert kernels.CACHE.name == f'kernels-{inside.source_digest()}'
        assert len(hashlib.sha256(b'').hexdigest()[:16]) == len(inside.source_digest())


@pytest.mark.parametrize(
    ('meet', 'is_of_numbers'),
    [
        (lambda: 1.0 / 0.0, True),
        (lambda: math.sqrt(-1.0), True),
        (lambda: math.sin(math.inf), True),
        (lambda: int(math.nan), True),
        (lambda: int(math.inf), True),
        (lambda: math.exp(1e3), True),
        (lambda: memoryview(bytearray(8)).cast('d')[0:0:0], False),
        (lambda: memoryview(bytearray(9)).cast('d'), False),
        (lambda: float('seven'), False),
        (lambda: (lambda a, b: a)(*(1, 2)[:1]), False),
    ],
)
def test_only_what_compiled_code_passes_through_as_no_number_counts_as_divergence(
    monkeypatch, meet, is_of_numbers
):
    monkeypatch.setattr(kernels, 'COMPILED', False)
    with pytest.raises((ArithmeticError, ValueError, TypeError)) as caught:
        meet()
    assert kernels.left_the_numbers(caught.value) == is_of_numbers


def test_an_error_of_a_kernel_that_is_a_bug_is_not_called_divergence():
    sim = Simulation(scenes.oscillator(dt=0.01))

    def with_a_bug(*_arguments):
        raise ValueError('memoryview assignment: lvalue and rvalue have different structures')

    inside.advance_by(sim, with_a_bug)
    with pytest.raises(ValueError, match='memoryview'):
        sim.step()
