# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Pieces of kernels: each stands once in a kernel and before who needs it, whatever needs whom; the
same source gives the same text in every process; one that is damaged on disk is absent with all
that need it, and compiled anew to the same bits; what does not fit together is never run.
"""

import ctypes
import math
import os
import pickle
import random
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.elf import UnknownCode
from rigid_body_sim.physics.compile.images import Images
from rigid_body_sim.physics.compile.kernel import Kernel
from rigid_body_sim.physics.compile.kernel_files import DIGEST_SIZE, MAGIC
from rigid_body_sim.physics.compile.pieces import (
    Piece,
    PieceFiles,
    in_order,
    joined,
    taken_apart,
)

from .. import inside
from ..patience import HANGING

ROOT = Path(__file__).parents[2]
compiled = pytest.mark.skipif(
    kernels.IMAGES is None, reason='no images here: no numba, another one, or another machine'
)


def piece(name, needs=()):
    declared = {other: f'declare {other}\n' for one in needs for other in one.defined}
    return Piece({name: f'define {name}\n'}, declared, {}, tuple(needs))


@given(st.integers(1, 12), st.randoms(use_true_random=False))
def test_each_piece_stands_once_and_after_all_that_it_needs(count, chance):
    made = []
    for number in range(count):
        needs = chance.sample(made, chance.randint(0, min(3, len(made))))
        made.append(piece(f'f{number}', needs))
    found = list(in_order([made[-1]]))
    assert len({id(one) for one in found}) == len(found)
    place = {id(one): number for number, one in enumerate(found)}
    for one in found:
        assert all(place[id(need)] < place[id(one)] for need in one.needs)
    text = joined('head\n', [made[-1]])
    assert text.startswith('head\n') and 'declare' not in text  # all that is named is there
    assert text.count('define') == len(found)


def module(name, uses, *rest):
    """A module as LLVM writes it: a function that uses things, and what stands beside it."""
    return ''.join((f'define i8 @{name}() {{\n  use {uses} ; preds = %entry\n}}\n', *rest))


def test_metadata_and_what_is_a_modules_own_bear_the_names_of_their_content():
    """Two modules number alike what differs; put together, each keeps its own."""
    same = '!0 = !{i32 7}\n'
    first, second = (
        taken_apart(module('f', '!1', same, f'!1 = !{{!0, i32 {n}}}\n'))[0] for n in (1, 2)
    )
    assert len(first.keys() & second.keys() - {'f'}) == 1  # !{i32 7} is one and the same
    assert first['f'] != second['f']
    ours, longer = (
        [
            taken_apart(module('g', f'@const.{run}{end}', f'@const.{run} = internal i8 {n}\n'))[0]
            for n in (1, 2)
            for run in (7, 8)  # numba names a text by the hash that it has in this process
        ]
        for end in ('', '.of_another')
    )
    assert ours[0] == ours[1] and ours[2] == ours[3]
    assert ours[0]['g'] != ours[2]['g']
    assert '@const.7.of_another' in longer[0]['g']  # which only begins like the other


def test_two_loops_are_two_however_alike_what_is_said_of_them():
    """LLVM knows a loop by metadata that name themselves."""
    said = '!0 = distinct !{!0, !2}\n', '!1 = distinct !{!1, !2}\n', '!2 = !{i32 1}\n'
    whole = joined('', [Piece(*taken_apart(module(f, '!0, !1', *said)), {}, ()) for f in 'fg'])
    loops = re.findall(r'^(!\d+) = distinct !{(!\d+), (!\d+)}$', whole, re.MULTILINE)
    assert len({number for number, _, _ in loops}) == len(loops) == 4
    assert all(itself == number for number, itself, _ in loops)
    assert len({other for _, _, other in loops}) == 1
    with pytest.raises(UnknownCode, match='circle'):
        taken_apart(module('f', '!0', '!0 = !{!1}\n', '!1 = !{!0}\n'))


def test_attributes_stand_where_they_are_named_and_what_is_outside_is_declared():
    defined, declared = taken_apart(
        module('f', '#1', 'declare i8 @"g h"(i8) #0\n', '@e = external global i8\n')
        + 'attributes #0 = { nounwind memory(read) }\nattributes #1 = { cold }\n'
    )
    assert defined == {'f': 'define i8 @f() {\n  use cold\n}\n'}
    assert declared == {
        'g h': 'declare i8 @"g h"(i8) nounwind memory(read)\n',
        'e': '@e = external global i8\n',
    }


@given(st.randoms(use_true_random=False))
def test_a_damaged_piece_is_absent_with_all_that_need_it(tmp_path_factory, chance):
    folder = tmp_path_factory.mktemp('pieces')
    kept, files = [], PieceFiles(folder)
    for number in range(6):
        needs = chance.sample(kept, chance.randint(0, min(2, len(kept))))
        name = f'f{number}'
        kept.append(files.save(name, name, piece(name, needs), b'beside'))
    hit, other = chance.sample(kept, 2)
    path = folder / hit.place.file
    content = bytearray(path.read_bytes())
    damage = chance.choice(['bit', 'cut', 'another file', 'gone'])
    if damage == 'bit':
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif damage == 'cut':
        del content[chance.randrange(len(content)) :]
    elif damage == 'another file':
        content = (folder / other.place.file).read_bytes()
    path.unlink() if damage == 'gone' else path.write_bytes(bytes(content))
    fresh = PieceFiles(folder)
    for number, one in enumerate(kept):
        found = fresh.load(f'f{number}', f'f{number}')
        if hit in in_order([one]):
            assert found is None
        else:
            assert found is not None and found[1] == b'beside'
            assert joined('', [found[0]]) == joined('', [one])


def test_a_piece_that_was_compiled_anew_to_another_text_is_not_taken_for_the_old_one(tmp_path):
    files = PieceFiles(tmp_path)
    low = files.save('low', 'low', piece('low'), b'')
    files.save('high', 'high', piece('high', [low]), b'')
    PieceFiles(tmp_path).save('low', 'low', piece('other'), b'')
    assert PieceFiles(tmp_path).load('high', 'high') is None
    PieceFiles(tmp_path).save('low', 'low', piece('low'), b'')  # as before: to the same text
    assert PieceFiles(tmp_path).load('high', 'high') is not None


def test_what_holds_an_address_or_calls_what_others_compiled_is_of_this_process_alone(tmp_path):
    files = PieceFiles(tmp_path)
    address = Piece({'numba.dynamic.globals.7f00': '@a = …'}, {}, {}, ())
    foreign = replace(piece('f'), foreign={'0': b'BC'})
    for one in (address, foreign):
        kept = files.save('f', 'f', one, b'')
        assert kept.place is None
        assert files.save('g', 'g', piece('g', [kept]), b'').place is None
    assert list(tmp_path.iterdir()) == []


# ----- pieces of numba


def above_one(x):
    return max(x, 1.0)


def cosh_by_address(x):
    return COSH(x)


def sum_by_numba(a):
    return a.sum()


COSH = ctypes.CDLL(None).cosh
COSH.restype, COSH.argtypes = ctypes.c_double, [ctypes.c_double]


def calling(inner, images, folder):
    """A kernel that calls another one, and how the inner one is compiled."""
    called = Kernel(inner, images, folder, inlined=False, widest=False)

    def outer(x):
        return called(x) + 1.0

    return Kernel(outer, images, folder, inlined=False, widest=False), called


@compiled
@pytest.mark.parametrize('by_numba', [False, True])
def test_pieces_that_name_what_nobody_defines_are_not_run_but_compiled_anew(tmp_path, by_numba):
    """Whole, of this source and this release, and wrong all the same."""
    made = []
    for folder in (tmp_path / 'right', tmp_path / 'wrong'):
        folder.mkdir(mode=0o700)
        images = None if by_numba else Images(folder, None)
        if made:
            text, beside = inside.kept_piece(made[0], (1.0,))
            empty = Piece({}, text.declared, {}, ())
            inside.keep_piece(above_one, folder, (1.0,), empty, beside)
        outer, called = calling(above_one, images, folder)
        assert [outer(x) for x in (0.5, 3.0)] == [2.0, 4.0]
        made.append(called)
    right, wrong = (inside.kept_piece(one, (1.0,))[0] for one in made)
    assert right.defined == wrong.defined  # mended


@compiled
def test_a_function_that_is_only_called_leaves_no_address(tmp_path):
    """Also where its arguments are found on two ways, and it waits on the stack meanwhile."""
    called = Kernel(above_one, None, tmp_path, inlined=False, widest=False)

    def outer(x, y):
        return called(x if x > y else called(y) if y > 2.0 else x * y)

    images = Images(tmp_path, None)
    kernel = Kernel(outer, images, tmp_path, inlined=False, widest=False)
    assert [kernel(*one) for one in ((4.0, 1.0), (1.0, 3.0), (1.5, 2.0))] == [4.0, 3.0, 3.0]
    assert list(tmp_path.glob('*outer*.kernel'))


@compiled
@pytest.mark.filterwarnings('ignore:Cannot cache compiled function')  # numba says so, too
@pytest.mark.parametrize(
    ('inner', 'argument', 'result', 'has_image'),
    [
        (cosh_by_address, 1.0, math.cosh(1.0), False),
        (sum_by_numba, np.arange(4.0), 6.0, True),
    ],
)
def test_kernels_of_what_only_this_process_has_run_and_leave_no_piece(
    tmp_path, inner, argument, result, has_image
):
    outer, _ = calling(inner, Images(tmp_path, None), tmp_path)
    assert outer(argument) == result + 1.0
    assert list((tmp_path / 'pieces').glob('*.kernel')) == []
    assert bool(list(tmp_path.glob('*outer*.kernel'))) == has_image


RUN = """
import hashlib
import sys
from rigid_body_sim import Simulation, load_scene
scene = sys.argv[1] if sys.argv[1:] else {'dt': 0.01, 'integrator': 'explicit_euler', 'bodies': [
    {'name': 'b', 'mass': 1, 'shape': {'type': 'particle'}, 'initial': {'position': [1, 0, 0]}}
], 'forces': [{'type': 'spring', 'a': 'b', 'b': 'world', 'stiffness': 4}]}
simulation = Simulation(load_scene(scene))
simulation.step(100)
print(hashlib.sha256(simulation.state_bytes()).hexdigest())
"""


@compiled
@pytest.mark.parametrize('scene', [[], pytest.param(['spring_ball'], marks=pytest.mark.long)])
def test_a_kernel_is_the_same_whether_its_pieces_are_kept_damaged_or_made(tmp_path, scene):
    """
    Also to the last letter of its text, whatever the order in which strings have their hashes.
    """
    cache = tmp_path / 'cache'

    def run(order):
        own = {'RIGID_BODY_SIM_CACHE': str(cache), 'PYTHONHASHSEED': order}
        done = subprocess.run(
            [sys.executable, '-c', RUN, *scene], env=os.environ | own,
            cwd=ROOT, capture_output=True, text=True, timeout=HANGING, check=True,
        )  # fmt: skip
        return done.stdout, done.stderr

    def text(path):
        return pickle.loads(path.read_bytes()[len(MAGIC) + DIGEST_SIZE :])[0]

    made = run('1')
    assert made[1] == ''
    found = sorted(cache.glob('kernels-*/pieces/*.kernel'))
    assert len(found) > 10
    whole = {path: text(path) for path in found}
    images = {path: path.read_bytes() for path in cache.glob('kernels-*/*.kernel')}
    for path in images:  # kernels are put together anew
        path.unlink()
    random.Random(1).shuffle(found)
    for path in found[:5]:
        path.write_bytes(path.read_bytes()[:-1])
    assert run('2') == made
    assert {path: text(path) for path in whole} == whole
    assert {path: path.read_bytes() for path in images} == images
