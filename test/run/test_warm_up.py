# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was compiled beforehand is not compiled again, whether it is an image or bitcode."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.image import kinds_of, load
from rigid_body_sim.physics.compile.image_maker import make
from rigid_body_sim.physics.compile.images import Images
from rigid_body_sim.physics.compile.probe import PROBED, agrees, probe, probe_arguments
from rigid_body_sim.physics.compile.processors import LEVELS, TOLD, level, processor
from rigid_body_sim.physics.compile.wanted import Wanted

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(
    kernels.IMAGES is None, reason='no images here: no numba, another one, or another machine'
)
SCENE = """
version: 1
name: ball
dt: 0.01
bodies: [{name: ball, shape: {type: particle}, mass: 1}]
"""


def warm_up(cache, *words, **environment):
    return subprocess.run(
        [sys.executable, '-m', 'rigid_body_sim', 'warm-up', *words],
        env={k: v for k, v in os.environ.items() if k != 'RIGID_BODY_SIM_COMPILE'}
        | {'RIGID_BODY_SIM_CACHE': str(cache), 'PYTHONPATH': str(ROOT)}
        | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=HANGING,
    )


def test_a_scene_is_compiled_once_and_leaves_an_image_and_bitcode(tmp_path):
    scene, cache, bitcode = tmp_path / 'ball.yaml', tmp_path / 'cache', tmp_path / 'bitcode'
    scene.write_text(SCENE)
    first = warm_up(cache, str(scene), '--bitcode', str(bitcode))
    assert first.returncode == 0, first.stderr
    assert ' kernels made, ' in first.stdout
    (of_sources,) = cache.iterdir()
    images = {path.name.partition('.')[0] for path in of_sources.glob('*.kernel')}
    assert images >= {'probe', 'splitting'}
    (shipped,) = bitcode.iterdir()
    assert shipped.name == of_sources.name
    kept = list(shipped.iterdir())
    assert {path.name.partition('.')[0] for path in kept} == images
    assert all(path.stat().st_mode & 0o444 == 0o444 for path in kept)  # for who installs it

    again = warm_up(cache, str(scene), str(scene))  # each in a process
    assert again.returncode == 0, again.stderr
    assert [line.partition(': ')[2].partition(',')[0] for line in again.stdout.splitlines()] == [
        'ready before',
        'ready before',
    ]


def test_what_cannot_be_made_ready_is_said_before_anything_is(tmp_path, verb):
    plain = warm_up(tmp_path, 'free_fall', RIGID_BODY_SIM_COMPILE='0')
    for (code, out, err), said in (
        (verb('warm-up', 'no_such', 'free_fall'), 'no such file'),
        ((plain.returncode, plain.stdout, plain.stderr), 'nothing is compiled here'),
        (verb('warm-up', 'free_fall', '-j', '0'), 'must be 1 or more'),
    ):
        assert (code, out) == (2, '')
        (line,) = err.splitlines()
        assert said in line


def test_a_scene_or_a_folder_that_takes_nothing_in_place_of_that_of_bitcode_is_said_at_once(
    tmp_path, verb, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kernels, 'COMPILED', True)
    (tmp_path / 'mine.yaml').write_text('version: 1')
    for words, said in (
        (('satellite',), 'this is a scene; put the scene first: warm_up satellite --bitcode'),
        (('mine.yaml',), 'this is a scene; put the scene first: warm_up mine.yaml --bitcode'),
        (('/proc/here', 'satellite'), 'cannot be written: '),
        (('/proc', 'satellite'), 'cannot be written: '),
    ):
        code, out, err = verb('warm_up', '--bitcode', *words)
        assert (code, out, err.count('\n')) == (2, '', 1)
        assert said in err
    assert not (tmp_path / 'satellite').exists()


@pytest.fixture(scope='module')
def shipped(tmp_path_factory):
    """A folder of bitcode, with that of the probe and of a kernel."""
    folder = tmp_path_factory.mktemp('shipped')
    maker = Images(tmp_path_factory.mktemp('made'), None)
    maker.save_to(folder)
    assert maker.find(wanted()) is not None
    return maker, folder


def wanted():
    return Wanted(third, ('float64',), (1.0,))


def third(x):
    return x / 3.0


def test_an_image_made_of_shipped_bitcode_is_that_made_by_numba(shipped, tmp_path, monkeypatch):
    maker, folder = shipped

    def asked(*_):
        raise AssertionError('numba was asked')

    monkeypatch.setattr('rigid_body_sim.physics.compile.numba_pipeline.linked', asked)
    user = Images(tmp_path, folder)
    assert user.has_worked()  # so that nobody imports numba to see whether it compiles
    user.takes_level = False
    assert user.find(wanted())(0.1) == 0.1 / 3.0
    for one in (wanted(), Wanted(probe, PROBED, probe_arguments())):
        assert one.image_file(user.folder)[0].read_bytes() == (
            one.image_file(maker.folder)[0].read_bytes()
        )


def levels_here():
    """Name the levels whose images this processor can run."""
    names = list(LEVELS)
    return names[names.index(str(level())) :] if level() else []


def nothing_is_made(*_):
    raise AssertionError('an image was made')


def test_where_an_image_was_shipped_for_the_level_of_this_processor_nothing_is_made(
    shipped, tmp_path, monkeypatch
):
    _, folder = shipped
    monkeypatch.setattr('rigid_body_sim.physics.compile.image_maker.make', nothing_is_made)
    for one in levels_here():
        monkeypatch.setattr('rigid_body_sim.physics.compile.images.level', lambda of=one: of)
        user = Images(tmp_path, folder)
        assert user.has_worked()
        assert user.find(wanted())(0.1) == 0.1 / 3.0
        assert user.made == list(tmp_path.iterdir()) == []


def test_images_for_a_level_are_not_taken_where_the_probe_fails(shipped, tmp_path, monkeypatch):
    _, folder = shipped
    monkeypatch.setattr('rigid_body_sim.physics.compile.images.agrees', lambda _: False)
    assert Images(tmp_path, folder).of_level(wanted()) is None


def test_whoever_names_a_processor_gets_no_image_for_a_level(shipped, monkeypatch):
    _, folder = shipped
    monkeypatch.setenv('NUMBA_CPU_NAME', 'nehalem')
    level.cache_clear()
    try:
        assert Images(None, folder).of_level(wanted()) is None
    finally:
        monkeypatch.undo()
        level.cache_clear()


@pytest.mark.parametrize('lacking', ['avx2', 'avx512vl', 'cx16'])
def test_a_processor_reaches_a_level_only_with_all_that_it_asks_for(lacking, monkeypatch):
    can = LEVELS['x86-64-v4'] - {lacking}
    described = {'flags': ' '.join(sorted(can))}
    monkeypatch.setattr('rigid_body_sim.physics.compile.processors._described', lambda: described)
    for name in TOLD:
        monkeypatch.delenv(name, raising=False)
    assert level.__wrapped__() == ('x86-64-v3' if lacking == 'avx512vl' else None)


def stir(numbers, factor, unused):
    """Go over lanes, with branches and sums whose order matters; `unused` is dropped by LLVM."""
    total = 0.0
    for _ in range(7):
        for lane in range(8):
            x = numbers[lane] * factor + 1.0 / (3.0 + numbers[lane] * numbers[lane])
            numbers[lane] = np.sqrt(x) if x > 0.1 else x - factor
        for lane in range(len(numbers)):
            total += numbers[lane] * 0.1
    return total


def test_what_is_shipped_has_the_bits_of_what_is_made_here_and_of_plain_python(tmp_path):
    numbers, unused = np.linspace(-2.0, 3.0, 11), np.zeros(1)
    arguments = (numbers, 0.7, unused)
    wanted = Wanted(stir, kinds_of(arguments) or (), arguments)
    shipping = Images(tmp_path, None)
    shipping.save_to(tmp_path / 'shipped')
    results = []

    def run(image, array):
        own = numbers.copy()
        results.append((image(array(own), 0.7, unused), own.tobytes()))

    for images, is_closed in ((Images(None, None), False), (shipping, True)):
        bitcode = images.bitcode(wanted)
        assert bitcode.is_closed == is_closed
        run(images.make(wanted), np.asarray)
        for name in levels_here():
            run(load(make(bitcode, level=name), 'stir'), np.asarray)
    run(stir, memoryview)
    assert len(results) == 3 + 2 * len(levels_here()) and len(set(results)) == 1


@pytest.mark.parametrize('part', [0, 40, -1])
def test_damage_of_what_was_shipped_counts_as_its_absence(shipped, tmp_path, monkeypatch, part):
    _, folder = shipped
    other = tmp_path / 'shipped'
    other.mkdir()
    for path in folder.iterdir():
        content = bytearray(path.read_bytes())
        content[part] ^= 4
        (other / path.name).write_bytes(content)
    asked = []
    linked = 'rigid_body_sim.physics.compile.numba_pipeline.linked'
    monkeypatch.setattr(linked, lambda *_: asked.append(1) or give_up())

    def give_up():
        raise RuntimeError

    assert Images(tmp_path, other).find(wanted()) is None
    assert asked


def test_bitcode_names_no_processor_and_gives_the_same_on_a_lesser_one(shipped, monkeypatch):
    maker, _ = shipped
    bitcode = maker.bitcode(Wanted(probe, PROBED, probe_arguments()))
    assert not any(b'target-cpu' in content for content in bitcode.partitions)
    for name in ('x86-64', 'x86-64-v2', 'x86-64-v3'):
        if name == 'x86-64-v3' and 'avx2' not in str(processor()):
            continue
        monkeypatch.setenv('NUMBA_CPU_NAME', name)
        monkeypatch.setenv('NUMBA_CPU_FEATURES', '')
        assert agrees(Images(None, maker.shipped).make(Wanted(probe, PROBED, ())))
