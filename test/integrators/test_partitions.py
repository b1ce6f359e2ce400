# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A kernel that LLVM compiles in partitions is the kernel that it compiles as a whole."""

import re
from itertools import pairwise

import numpy as np
import pytest
from llvmlite.binding.context import GlobalContextRef

from rigid_body_sim.physics.compile import image_maker, kernels, partitions, side_by_side
from rigid_body_sim.physics.compile.elf import UnknownCode, flatten
from rigid_body_sim.physics.compile.image import kinds_of, load
from rigid_body_sim.physics.compile.image_maker import Bitcode, closed, make
from rigid_body_sim.physics.compile.images import Images
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.compile.wanted import Wanted

pytestmark = pytest.mark.skipif(
    kernels.IMAGES is None, reason='no images here: no numba, another one, or another machine'
)
DEFINED = re.compile(r'^define .*?(@"[^"]*"|@[\w.$-]+)\(', re.MULTILINE)


@inline
def length(x, y):
    return np.sqrt(x * x + y * y)


@kernel
def turn(angle, numbers):
    for i in range(0, len(numbers) - 1, 2):
        x, y = numbers[i], numbers[i + 1]
        numbers[i] = np.cos(angle) * x - np.sin(angle) * y
        numbers[i + 1] = np.sin(angle) * x + np.cos(angle) * y


@kernel
def longest(numbers):
    most = 0.0
    for i in range(0, len(numbers) - 1, 2):
        most = max(most, length(numbers[i], numbers[i + 1]))
    return most


@kernel
def bring_in(most, numbers):
    found = longest(numbers)
    if found > most:
        for i in range(len(numbers)):
            numbers[i] *= most / found


@kernel
def swirl(turns, angle, numbers):
    for _ in range(turns):
        turn(angle, numbers)
        numbers[0] += longest(numbers)
        bring_in(3.0, numbers)
    return longest(numbers)


NUMBERS = np.linspace(-1.0, 2.0, 10)
ARGUMENTS = (7, 0.3, NUMBERS)


@pytest.fixture(scope='module')
def bitcode():
    """Give the kernel, not yet closed."""
    wanted = Wanted(kernels.plain(swirl), kinds_of(ARGUMENTS) or (), ARGUMENTS)
    return Images(None, None).bitcode(wanted)


def in_many(bitcode, monkeypatch):
    """Close a kernel, every function of which stays one, in as many partitions as there can be."""
    monkeypatch.setattr(image_maker, 'LONG', 0)
    monkeypatch.setattr(partitions, 'LEAST', 1)
    return closed(bitcode)


def result(image):
    numbers = NUMBERS.copy()
    return image(7, 0.3, numbers), numbers.tobytes()


def test_a_kernel_in_partitions_has_the_bits_of_the_whole_and_of_plain_python(
    bitcode, monkeypatch
):
    whole = closed(bitcode)
    divided = in_many(bitcode, monkeypatch)
    assert len(whole.partitions) == 1
    assert len(divided.partitions) > 2
    plain = NUMBERS.copy()
    expected = as_plain(7, 0.3, plain), plain.tobytes()
    assert result(load(make(whole), 'swirl')) == expected
    assert result(load(make(divided), 'swirl')) == expected


def as_plain(turns, angle, numbers):
    """Do what `swirl` does, with what it calls as plain source too."""
    for _ in range(turns):
        turn.py_func(angle, numbers)
        numbers[0] += longest.py_func(numbers)
        found = longest.py_func(numbers)
        if found > 3.0:
            numbers *= 3.0 / found
    return longest.py_func(numbers)


def test_an_image_does_not_depend_on_how_many_threads_made_it(bitcode, monkeypatch):
    divided = in_many(bitcode, monkeypatch)
    made = []
    for count in (1, 2, 5):
        monkeypatch.setattr(side_by_side, 'threads', lambda count=count: count)
        made.append(make(divided))
    for one, other in pairwise(made):
        assert one == other


def test_partitions_take_turns_where_llvmlite_hides_what_it_locks(bitcode, monkeypatch):
    divided = in_many(bitcode, monkeypatch)
    expected = make(divided)
    asked = []

    def locked(name):
        asked.append(name)
        return getattr(partitions.ffi.lib, name)

    monkeypatch.setattr(partitions, '_unlocked', locked)
    assert make(divided) == expected
    assert len(asked) >= 2 * len(divided.partitions)


def test_what_runs_without_the_lock_has_a_context_of_its_own(bitcode, monkeypatch):
    """numba compiles what a user has in one that all threads share."""
    contexts, unlocked = [], partitions._unlocked

    def watched(name):
        def call(maker, module, *others):
            contexts.append(module._context)
            return unlocked(name)(maker, module, *others)

        return call

    monkeypatch.setattr(partitions, '_unlocked', watched)
    make(in_many(bitcode, monkeypatch))
    assert contexts
    assert not any(isinstance(one, GlobalContextRef) for one in contexts)


def test_each_function_is_in_one_partition_and_all_that_it_names_with_it():
    lines = '\n'.join('  %x = load i64, ptr @number' for _ in range(5))
    names = ['@a', '@"b c"', '@d.e$f-1', '@g']
    bodies = [
        f'define internal fastcc void {name}(ptr nonnull %p) unnamed_addr #{i} {{\n{lines}\n'
        f'  call void {names[i - 1]}(ptr %p), !range !{i}\n  ret void\n}}\n'
        for i, name in enumerate(names)
    ]
    attributes = [f'attributes #{i} = {{ nounwind }}\n' for i in range(4)]
    metadata = [f'!{i} = !{{!{i + 4}}}\n!{i + 4} = !{{i64 {i}, i64 9}}\n' for i in range(4)]
    head = 'target triple = "x86_64-unknown-linux-gnu"\n'
    number = '@number = private constant i64 3\n@unused = common global ptr null\n'
    text = ''.join([head, number, *bodies, *attributes, *metadata])
    texts = partitions.divided(text)
    assert len(texts) == 1  # it is short
    partitions_of_four = divided_finely(text)
    assert [DEFINED.findall(one) for one in partitions_of_four] == [[name] for name in names]
    for i, one in enumerate(partitions_of_four):
        assert one.startswith(head)
        assert one.count('\n') == len(set(one.splitlines())) + 4  # the five loads are alike
        assert f'declare hidden fastcc void {names[i - 1]}(' in one
        assert '@number = ' in one
        assert '@unused' not in one
        assert f'!{i + 4} = ' in one
        assert f'!{(i + 1) % 4} = ' not in one


def divided_finely(text):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(partitions, 'LEAST', 1)
        patch.setattr(partitions, 'MOST', 4)
        return partitions.divided(text)


def test_what_two_object_files_define_is_refused(bitcode):
    one = closed(bitcode).partitions[0]
    machine = image_maker.machine_for('x86-64', '')
    content = partitions.compiled(one, machine, lambda *_: None)
    assert flatten([content], bitcode.symbol).code
    with pytest.raises(UnknownCode, match='defined twice'):
        flatten([content, content], bitcode.symbol)


def test_what_is_kept_of_a_divided_kernel_is_read_as_it_was(bitcode, monkeypatch):
    divided = in_many(bitcode, monkeypatch)
    assert Bitcode.unpacked(divided.packed()) == divided
    with pytest.raises(ValueError, match='no bitcode'):
        Bitcode.unpacked(divided.packed()[:-1])
