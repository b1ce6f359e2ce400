# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is kept of compiled kernels is read whole or not at all: damage costs a compilation, never a
run or a result; and what others may write is not read.
"""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.kernel_files import KernelFiles, is_ours

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
KEY = ('signature', ('triple', 'cpu', 'features'))
pytestmark = pytest.mark.skipif(not kernels.COMPILED, reason='numba is not installed')


def files(folder, name='f', releases='numba 1'):
    return KernelFiles(str(folder), name, 'source', releases)


@pytest.fixture(scope='module')
def kept(tmp_path_factory):
    """A folder with one kept kernel: its files, path and bytes."""
    folder = tmp_path_factory.mktemp('kept')
    one = files(folder)
    one.save(KEY, {'code': b'machine code'})
    (path,) = folder.iterdir()
    return one, path, path.read_bytes()


def test_what_is_kept_comes_back_and_nothing_else_lies_beside(kept):
    one, path, _ = kept
    assert one.holds(KEY)
    assert one.load(KEY) == {'code': b'machine code'}
    assert list(path.parent.iterdir()) == [path]
    assert one.load(('another', KEY)) is None


@given(st.data())
def test_a_changed_bit_a_cut_or_a_tail_makes_it_absent(kept, data):
    one, path, content = kept
    damaged = bytearray(content)
    kind = data.draw(st.sampled_from(['bit', 'cut', 'tail']))
    if kind == 'bit':
        at = data.draw(st.integers(0, 8 * len(content) - 1))
        damaged[at // 8] ^= 1 << at % 8
    elif kind == 'cut':
        del damaged[data.draw(st.integers(0, len(content) - 1)) :]
    else:
        damaged += data.draw(st.binary(min_size=1, max_size=9))
    try:
        path.write_bytes(damaged)
        assert not one.holds(KEY)
        assert one.load(KEY) is None
    finally:
        path.write_bytes(content)


def test_a_whole_file_under_another_name_or_of_another_release_is_absent(tmp_path):
    one, other = files(tmp_path), files(tmp_path, 'g')
    one.save(KEY, 'f')
    (path,) = tmp_path.iterdir()
    other.save(KEY, 'g')
    (of_other,) = set(tmp_path.iterdir()) - {path}
    path.replace(of_other)
    assert other.load(KEY) is None
    one.save(KEY, 'f')
    assert files(tmp_path, releases='numba 2').load(KEY) is None


def test_what_cannot_be_unpickled_any_more_is_absent(tmp_path, monkeypatch):
    one = files(tmp_path)
    monkeypatch.setattr('numba.core.serialize.dumps', lambda _: pickle.dumps(GONE))
    one.save(KEY, None)
    assert one.holds(KEY)
    monkeypatch.delitem(globals(), 'Gone')
    assert one.load(KEY) is None


class Gone:
    """A class that a later release may lack."""


GONE = Gone()


@pytest.mark.parametrize('mode', [0o770, 0o707, 0o777])
def test_a_folder_or_file_that_others_may_write_is_not_trusted(tmp_path, mode):
    one = files(tmp_path)
    one.save(KEY, 'f')
    (path,) = tmp_path.iterdir()
    assert is_ours(path.stat())
    path.chmod(mode & 0o666)
    assert one.load(KEY) is None
    path.chmod(0o600)
    assert one.load(KEY) == 'f'
    tmp_path.chmod(mode)
    assert not is_ours(tmp_path.stat())


@pytest.mark.skipif(not hasattr(os, 'geteuid'), reason='no users here')
def test_a_folder_of_another_user_is_passed_over(tmp_path, monkeypatch):
    found = tmp_path.stat()
    assert is_ours(found)
    monkeypatch.setattr(os, 'geteuid', lambda: found.st_uid + 1)
    assert not is_ours(found)


def test_what_finds_no_room_is_not_kept(tmp_path):
    one = files(tmp_path / 'absent')
    one.save(KEY, 'f')
    assert one.load(KEY) is None


RUN = """
from rigid_body_sim import Simulation, load_scene
sim = Simulation(load_scene({'dt': 0.001, 'bodies': [
    {'name': 'b', 'mass': 1, 'shape': {'type': 'particle'}, 'initial': {'velocity': [1, 2, 3]}}]}))
sim.step(100)
print(sim.state_bytes().hex())
"""


def bits_of_a_run(cache):
    result = subprocess.run(
        [sys.executable, '-c', RUN],
        env=os.environ | {'RIGID_BODY_SIM_CACHE': str(cache), 'PYTHONPATH': str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
        timeout=HANGING,
    )
    assert result.stderr == ''
    return result.stdout


@pytest.mark.long  # in the short form: of images in test_images, of their parts in test_pieces
def test_a_run_mends_a_damaged_cache_and_keeps_its_bits(tmp_path):
    expected = bits_of_a_run(tmp_path)
    written = sorted(tmp_path.rglob('*.kernel'))
    assert written
    for count, path in enumerate(written):
        content = path.read_bytes()
        path.write_bytes([content[: len(content) // 2], b'', content[::-1]][count % 3])
    assert bits_of_a_run(tmp_path) == expected
    assert sorted(tmp_path.rglob('*.kernel')) == written
    times = [path.stat().st_mtime_ns for path in written]
    assert bits_of_a_run(tmp_path) == expected
    assert [path.stat().st_mtime_ns for path in written] == times  # mended: nothing written again
