# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kernels as images: the same bits as by way of numba and as plain Python, whole or not taken, and
numba not even imported where they are at hand.
"""

import math
import os
import subprocess
import sys
import threading
import time
import weakref
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigid_body_sim.physics.compile import image, kernels
from rigid_body_sim.physics.compile.elf import FlatCode, UnknownCode, flatten
from rigid_body_sim.physics.compile.image import (
    KernelStopped,
    kinds_of,
    load,
    packed,
    unpacked,
    with_last,
)
from rigid_body_sim.physics.compile.images import Images, numba_is_set
from rigid_body_sim.physics.compile.kernel import Kernel
from rigid_body_sim.physics.compile.probe import PROBED, agrees, probe, probe_arguments
from rigid_body_sim.physics.compile.processors import processor
from rigid_body_sim.physics.compile.wanted import Wanted, release_of
from rigid_body_sim.scene import convex_parts, load_scene

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(
    kernels.IMAGES is None, reason='no images here: no numba, another one, or another machine'
)

RUN = """
import sys
from rigid_body_sim import Simulation, load_scene
sim = Simulation(load_scene({'dt': 0.001, 'bodies': [
    {'name': 'b', 'mass': 1, 'shape': {'type': 'particle'}, 'initial': {'velocity': [1, 2, 3]}}]}))
sim.step(100)
print('numba' in sys.modules, sim.state_bytes().hex())
"""


def run(cache, code=RUN, **environment):
    """
    What a program prints: whether it imported numba, and bits.
    """
    result = subprocess.run(
        [sys.executable, '-c', code],
        env=os.environ
        | {'RIGID_BODY_SIM_CACHE': str(cache), 'PYTHONPATH': str(ROOT)}
        | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=HANGING,
    )
    assert result.returncode == 0, result.stderr
    assert result.stderr == ''
    return result.stdout.split()


@pytest.fixture(scope='module')
def cache(tmp_path_factory):
    """A cache that one run has filled."""
    folder = tmp_path_factory.mktemp('cache')
    run(folder)
    return folder


@pytest.fixture(scope='module')
def expected(cache):
    """What a run says that finds its images."""
    return run(cache)


def images_of(cache):
    """The files of images in a cache."""
    (folder,) = cache.iterdir()
    return sorted(folder.glob('*.kernel'))


def test_image_and_plain_source_give_the_same_bits(expected, tmp_path):
    """And numba, where the cache cannot be written, see below."""
    plain = run(tmp_path, RIGID_BODY_SIM_COMPILE='0')
    assert expected[0] == 'False' and plain == expected


@pytest.mark.long
def test_a_setting_of_numba_leads_by_way_of_it_to_the_same_bits(expected, tmp_path):
    assert run(tmp_path, NUMBA_OPT='3') == ['True', expected[1]]


def test_what_is_damaged_or_not_ours_is_made_anew(cache, expected):
    _kept, probed, ticks = images_of(cache)
    assert probed.name.startswith('probe.')
    contents = probed.read_bytes(), ticks.read_bytes()
    ticks.write_bytes(contents[1][:-1])
    probed.chmod(0o666)
    assert run(cache)[1] == expected[1]
    assert (probed.read_bytes(), ticks.read_bytes()) == contents
    assert run(cache) == expected  # mended: without numba again


def test_a_cache_that_cannot_be_written_costs_time_and_no_bit(expected, tmp_path):
    blocked = tmp_path / 'file'
    blocked.write_text('not a folder')
    nowhere = dict.fromkeys(('NUMBA_CACHE_DIR', 'XDG_CACHE_HOME', 'HOME'), str(blocked))
    code = RUN + 'from rigid_body_sim.physics.compile.kernels import CACHE; print(CACHE)'
    assert run(blocked, code, **nowhere) == ['True', expected[1], 'None']


@pytest.mark.parametrize('relative', ['', 'cache', './cache', '~/cache'])
def test_a_cache_home_that_is_no_absolute_path_counts_as_not_set(relative, tmp_path, monkeypatch):
    """As the XDG base directory specification asks: else a folder would lie wherever one works."""
    for name in ('RIGID_BODY_SIM_CACHE', 'NUMBA_CACHE_DIR'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('HOME', str(tmp_path))
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'shared'))
    at_home = tmp_path / '.cache' / 'rigid_body_sim'
    assert kernels._cache_candidates() == [tmp_path / 'shared' / 'rigid_body_sim', at_home]
    monkeypatch.setenv('XDG_CACHE_HOME', relative)
    assert kernels._cache_candidates() == [at_home]
    mesh = load_scene('tetrahedron').bodies[0].shape
    assert convex_parts._cache_files(mesh, 0.05)[0].is_relative_to(at_home)


@pytest.mark.long  # in the short form, the workers of the suite do
def test_two_processes_at_once_make_the_same_images(cache, expected, tmp_path):
    got = []
    both = [threading.Thread(target=lambda: got.append(run(tmp_path)[1])) for _ in range(2)]
    for one in both:
        one.start()
    for one in both:
        one.join()
    assert got == [expected[1]] * 2
    assert [path.name for path in images_of(tmp_path)] == [p.name for p in images_of(cache)]
    assert run(tmp_path)[0] == 'False'


def test_numba_that_broke_since_leaves_what_is_kept_and_says_so_of_the_rest(
    cache, expected, tmp_path
):
    release = release_of('numba')
    (tmp_path / f'numba-{release}.dist-info').mkdir()
    (tmp_path / 'numba').mkdir()
    (tmp_path / 'numba/__init__.py').write_text("raise ImportError('needs another numpy')")
    broken = {'PYTHONPATH': f'{tmp_path}:{ROOT}'}
    assert run(cache, **broken) == expected
    (probed,) = [path for path in images_of(cache) if path.name.startswith('probe.')]
    folder = tmp_path / probed.parent.name
    folder.mkdir(mode=0o700)
    (folder / probed.name).write_bytes(probed.read_bytes())  # and of the kernels none
    (folder / probed.name).chmod(0o600)
    caught = 'import warnings\nwith warnings.catch_warnings(record=True) as said:\n'
    caught += ''.join(f'    {line}\n' for line in RUN.splitlines())
    caught += "print(*(w.message for w in said), sep='|')"
    _, bits, *warned = run(tmp_path, caught, **broken)
    assert bits == expected[1]
    warned = ' '.join(warned)
    assert warned.startswith('numba cannot be imported (needs another numpy)')
    assert warned.count('numba cannot be imported') == 1


# ----- one kernel


@pytest.fixture(scope='module')
def images(tmp_path_factory):
    """Images in a folder of their own, which trust themselves."""
    found = Images(tmp_path_factory.mktemp('images'), None)
    assert found.is_trusted()
    return found


def of_probe():
    return Wanted(probe, PROBED, probe_arguments())


def made(images, function, *arguments):
    return images.find(Wanted(function, kinds_of(arguments), arguments))


def test_the_probe_comes_to_what_its_source_does(images):
    image = images.kept(of_probe())
    assert agrees(image)

    def without(*arguments):
        return image(*arguments[:-1], arguments[-1] / 3.0)  # as if it took one for another

    assert not agrees(without)


@given(st.data())
def test_a_changed_bit_a_cut_or_another_file_makes_an_image_absent(images, data):
    path, _ = of_probe().image_file(images.folder)
    content = path.read_bytes()
    damaged = bytearray(content)
    at = data.draw(st.integers(0, len(content) - 1))
    if data.draw(st.booleans()):
        damaged[at] ^= 1 << data.draw(st.integers(0, 7))
    else:
        del damaged[at:]
    try:
        path.write_bytes(damaged)
        assert images.kept(of_probe()) is None
    finally:
        path.write_bytes(content)
    other, _ = Wanted(total.py_func, PROBED, ()).image_file(images.folder)
    other.write_bytes(content)
    other.chmod(0o600)
    assert images.kept(Wanted(total.py_func, PROBED, ())) is None


def test_images_that_fail_the_probe_are_not_used(tmp_path, monkeypatch):
    found = Images(tmp_path, None)
    monkeypatch.setattr('rigid_body_sim.physics.compile.images.agrees', lambda _: False)
    assert not found.is_trusted()
    assert list(tmp_path.glob('*.kernel')) == []
    assert made(found, count, 3) is None
    assert not found.has_worked()


def count(n):
    return n + 1


def is_more(x, n):
    return x > n


def nothing(a):
    a[0] = 2.0


def functions_of_libm(x):
    mantissa, exponent = math.frexp(x)
    whole = math.sin(x) + math.cos(x) + math.exp(x) + math.atan2(x, 2.0)
    return whole + mantissa + exponent + math.ldexp(x, 3) + math.pow(abs(x), 0.3)


def test_integers_truth_and_nothing_come_back_as_they_are(images):
    image = made(images, count, 3)
    for n in (0, -2, 2**53 + 1, 2**63 - 2, -(2**63)):
        assert image(n) == n + 1
    with pytest.raises(OverflowError):
        image(2**63)
    more = made(images, is_more, 1.0, 3)
    assert (more(4.0, 3), more(3.0, 3)) == (True, False)
    a = np.zeros(1)
    assert made(images, nothing, a)(a) is None
    assert a[0] == 2.0


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-700.0, max_value=700.0))
def test_functions_of_the_c_library_have_the_bits_of_pythons(images, x):
    assert made(images, functions_of_libm, 1.0)(x) == functions_of_libm(x)


def test_last_arguments_at_hand_are_looked_at_as_the_others_are(images):
    a, n = np.zeros(3), 3
    image = made(images, nothing, a)
    hung = with_last(image, [a])
    assert hung() is None
    assert a[0] == 2.0
    assert hung(a) is NotImplemented
    for other in (a.tolist(), a.astype(int), 1.0, None):
        assert with_last(image, [other])() is NotImplemented
    more = made(images, is_more, 1.0, n)
    assert (with_last(more, [n])(4.0), with_last(more, [n])(3.0)) == (True, False)
    assert with_last(more, [n])(4) is NotImplemented  # an integer, where a float was
    brief = with_last(more, [n], brief=True)
    assert (brief(4.0), brief(3.0), brief(4)) == (True, False, NotImplemented)


def test_a_prepared_kernel_is_the_kernel(images):
    for way in (Kernel(is_more, images, None, inlined=False, widest=True), is_more):
        of_three = kernels.prepared(way, (1.0,), (3,))
        assert [of_three(x) for x in (4.0, 3.0)] == [way(4.0, 3), way(3.0, 3)] == [True, False]


class Inner(NamedTuple):
    numbers: np.ndarray
    count: int


class Outer(NamedTuple):
    factor: float
    inner: Inner


def sum_in_groups(shift, outer):
    of_all = shift
    for i in range(outer.inner.count):
        of_all += outer.factor * outer.inner.numbers[i]
    return of_all


def test_groups_of_arguments_are_taken_as_their_members_and_looked_at_as_others_are(images):
    group = Outer(2.0, Inner(np.arange(4.0), 3))
    image = made(images, sum_in_groups, 1.0, group)
    assert image(1.0, 2.0, np.arange(4.0), 3) == sum_in_groups(1.0, group) == 7.0
    way = Kernel(sum_in_groups, images, None, inlined=False, widest=True)
    prepared = kernels.prepared(way, (1.0,), (group,))
    assert prepared(1.0) == way(1.0, group) == way(1.0, group) == 7.0
    assert with_last(image, [group])(1) is NotImplemented  # an integer, where a float was
    other = group._replace(inner=Inner(np.arange(4), 3))  # integers, where floats were
    assert with_last(image, [other])(1.0) is NotImplemented
    assert way(1.0, other) == 7.0
    group.inner.numbers[0] = 10.0
    assert prepared(1.0) == 27.0


def test_images_know_for_which_processor_they_were_made(tmp_path, monkeypatch):
    names, found = set(), Images(tmp_path, None)
    bitcode = found.bitcode(of_probe())
    monkeypatch.setattr(found, 'bitcode', lambda _: bitcode)
    try:
        for name in ('x86-64', 'nehalem'):
            monkeypatch.setenv('NUMBA_CPU_NAME', name)
            monkeypatch.setenv('NUMBA_CPU_FEATURES', '')
            processor.cache_clear()
            assert not numba_is_set()
            assert found.kept(of_probe()) is None
            assert agrees(found.make(of_probe()))
            names.add(of_probe().image_file(tmp_path)[0])
    finally:
        processor.cache_clear()
    assert len(names) == 2


def test_what_an_image_does_not_take_it_refuses_untouched(images):
    a = np.zeros(3)
    image = made(images, nothing, a)
    read_only = a.view()
    read_only.flags.writeable = False
    others = (
        a.tolist(), memoryview(a), a.reshape(1, 3), np.zeros(6)[::2], np.zeros(3, dtype='f4'),
        np.zeros(3, dtype='>f8'), np.zeros(3, dtype=np.int64), read_only, None, 1.0,
        np.frombuffer(bytes(25), np.uint8)[1:].view(np.float64),
    )  # fmt: skip
    assert [image(other) for other in others] == [NotImplemented] * len(others)
    assert image() is image(a, a) is NotImplemented
    assert not a.any()
    with pytest.raises(TypeError):
        image(a=a)


def test_a_kernel_goes_by_way_of_numba_where_no_image_takes_its_arguments():
    two = np.zeros((2, 2))
    assert total(two[:, 0]) == 0.0
    assert total(np.ones(3)) == 3.0
    assert total((1.0, 2.0)) == 3.0
    assert total(np.ones(3, dtype='f4')) == 3.0
    assert total(np.ones(3)) == 3.0


@kernels.kernel
def total(a):
    sum_of = 0.0
    for i in range(len(a)):
        sum_of += a[i]
    return sum_of


def test_a_kernel_that_stops_raises_and_names_itself(images):
    with pytest.raises(KernelStopped, match=r'probe\.probe: stopped with status'):
        images.kept(of_probe())(*probe_arguments(-1.0))


def test_other_threads_run_while_an_image_does(images):
    image = made(images, long_sum, 1)
    beats, done = [], threading.Event()

    def beat():
        while not done.is_set():
            beats.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=beat)
    thread.start()
    begin = time.monotonic()
    image(3 * 10**8)
    end = time.monotonic()
    done.set()
    thread.join()
    inside = [t for t in beats if begin < t < end]
    assert len(inside) > 3  # with the lock held: at most one at either end


def long_sum(n):
    x = 0.1
    for i in range(n):
        x = x * 0.999 + i
    return x


def test_an_image_holds_no_reference_and_leaks_none(images):
    a, image = np.zeros(5), made(images, total.py_func, np.zeros(5))
    big = 10.0**300
    before = sys.getrefcount(a), sys.getrefcount(big), sys.getrefcount(NotImplemented)
    for _ in range(1000):
        image(a)
        image(big)
    after = sys.getrefcount(a), sys.getrefcount(big), sys.getrefcount(NotImplemented)
    assert after == before


def test_what_python_knows_of_an_image_outlives_the_module_that_loaded_it(images):
    """
    Python takes itself apart in no given order, and looks at the description of a function that
    goes after all else: some processes with large arrays ended with a segmentation fault.
    """
    function = made(images, total.py_func, np.zeros(5))
    described = weakref.ref(image._METHODS.pop(function))
    assert described() is not None
    image._METHODS[function] = described()


# ----- the format


@given(st.binary(max_size=400))
def test_bytes_that_are_no_image_are_refused(content):
    with pytest.raises(ValueError):
        unpacked(content)


@pytest.mark.parametrize('content', [b'', b'MZ' + bytes(98), b'\x7fELF\x02\x01' + bytes(94)])
def test_what_is_no_object_file_of_this_machine_is_refused(content):
    with pytest.raises(UnknownCode):
        flatten([content], 'entry')


def test_an_image_without_its_c_function_is_not_loaded():
    flat = unpacked(packed(FlatCode(bytes(16), 0, {'no_such_function': 8}, [])))
    with pytest.raises(OSError, match='no_such_function'):
        load(flat, 'f')


def test_the_key_of_an_image_knows_constants_code_and_what_is_called():
    def key(function, kinds=('float64',)):
        return Wanted(function, kinds, ()).image_file(Path())[1]

    def scaled(factor, inner):
        names = {'FACTOR': factor, 'inner': inner, '__name__': 'given'}
        source = 'def outer(x):\n    return FACTOR * inner(x)\n'
        exec(source, names)
        return names['outer']

    def one(x):
        return x

    def two(x):
        return 2 * x

    keys = [key(scaled(*given)) for given in ((2.0, one), (2.0, two), (3.0, one), (2, one))]
    assert len({*keys, key(scaled(2.0, one), ('int64',))}) == 5
    assert keys[0] == key(scaled(2.0, one))


def test_releases_are_found_without_importing(monkeypatch):
    import llvmlite

    for package, release in (('numpy', np.__version__), ('llvmlite', llvmlite.__version__)):
        monkeypatch.delitem(sys.modules, package)
        release_of.cache_clear()
        assert release_of(package) == release
        monkeypatch.undo()
    release_of.cache_clear()
    assert release_of('no_such_package') is None
