# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a general kernel leaves open is declared, and bound name by name before it runs."""

import dis
from importlib import import_module
from pkgutil import walk_packages
from types import FunctionType, SimpleNamespace

import pytest

from rigid_body_sim import physics
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.kernels import KernelSlot, plain, slot, slots_of, specialise
from rigid_body_sim.physics.compile.sources import codes, globals_read

STAGES = slot('[-] stages of a step')
SHARES = slot('[tick] share of each stage')
move = slot('kernel (share): moves by a share')
empty = slot('[-] what nobody names')

TABLE = SimpleNamespace(move=3.0)


def _sum():
    total = 0.0
    for stage in range(STAGES):
        total += SHARES[stage]
    return total


def _moved():
    return move(1.0)


def _attribute():
    return TABLE.move


@kernels.kernel
def _doubled(share):
    return 2.0 * share


def test_what_is_bound_is_used():
    made = specialise(_sum, name='two', STAGES=2, SHARES=(0.25, 0.5))
    assert made() == plain(made)() == 0.75
    assert specialise(_moved, name='double', move=_doubled)() == 2.0


def test_equal_bindings_give_one_kernel_and_others_another():
    made = specialise(_sum, name='one', STAGES=1, SHARES=(0.5,))
    assert specialise(_sum, name='one', STAGES=1, SHARES=(0.5,)) is made
    assert specialise(_sum, name='one', STAGES=1, SHARES=(1.0,)) is not made


def test_of_what_a_family_offers_only_what_is_named_tells_kernels_apart():
    family = {'STAGES': 1, 'SHARES': (0.5,), 'move': _doubled, 'none_of_this_module': 3}
    made = specialise(_sum, name='one', offered=family)
    assert made is specialise(_sum, name='one', offered={**family, 'none_of_this_module': 4})
    assert specialise(_sum, name='one', offered=family, SHARES=(1.0,))() == 1.0


def test_a_missing_name_is_refused_with_its_meaning():
    with pytest.raises(
        TypeError, match=r'_sum\): nothing is bound to SHARES <slot: \[tick\] share'
    ):
        specialise(_sum, name='short', STAGES=2)


@pytest.mark.parametrize('name', ['STAGE', 'empty', 'move', 'TABLE'])
def test_a_name_that_the_source_does_not_leave_open_is_refused(name):
    bindings = {'STAGES': 1, 'SHARES': (1.0,), name: 1}
    with pytest.raises(TypeError, match=rf'names no slot {name}; it has SHARES .*, STAGES '):
        specialise(_sum, name='wrong', **bindings)


def test_a_slot_is_not_bound_to_a_slot():
    with pytest.raises(TypeError, match='is itself a slot: STAGES'):
        specialise(_sum, name='slot', STAGES=empty, SHARES=(1.0,))


@pytest.mark.parametrize('make', [kernels.kernel, kernels.inline])
def test_a_source_with_slots_is_no_kernel(make):
    with pytest.raises(TypeError, match=r'_sum: names SHARES .*, STAGES .*: bind with'):
        make(_sum)


def test_an_attribute_of_the_name_of_a_slot_is_none():
    assert slots_of(_attribute) == {}
    assert kernels.kernel(_attribute) is not None


USES = {
    'called': lambda x: x(1.0), 'tested': bool, 'an index': [1, 2].__getitem__,
    'an integer': int, 'a number': float, 'counted to': range, 'unpacked': list, 'asked': len,
    'read': lambda x: x[0], 'added to': lambda x: x + 1, 'added': lambda x: 1.0 + x,
    'multiplied': lambda x: 2.0 * x, 'a divisor': lambda x: 1 / x, 'negated': lambda x: -x,
    'raised': lambda x: x**2, 'equal': lambda x: x == 0.0, 'unequal': lambda x: x != 0.0,
    'less': lambda x: x < 1, 'more': lambda x: 1 < x, 'a bound': lambda x: min(64, x),
    'rounded': round, 'masked': lambda x: x & 1,
}  # fmt: skip


@pytest.mark.parametrize('use', USES)
def test_an_empty_slot_is_no_value(use):
    with pytest.raises(TypeError, match=r'<slot: \[-\] what nobody names> is empty'):
        USES[use](empty)


def _modules():
    for found in walk_packages(physics.__path__, f'{physics.__name__}.'):
        yield import_module(found.name)


def test_each_slot_of_the_package_is_named_by_a_function_of_its_module():
    for module in _modules():
        declared = {name for name, value in vars(module).items() if isinstance(value, KernelSlot)}
        functions = [
            value
            for value in vars(module).values()
            if isinstance(value, FunctionType) and value.__module__ == module.__name__
        ]
        named = {name for function in functions for name in slots_of(function)}
        assert declared == named, f'{module.__name__}: {declared ^ named}'


def _read_by_dis(code):
    return {
        instruction.argval
        for part in codes(code)
        for instruction in dis.get_instructions(part)
        if instruction.opname in ('LOAD_GLOBAL', 'LOAD_NAME')
    }


@pytest.mark.parametrize('every', [4, pytest.param(1, marks=pytest.mark.long)])
def test_the_globals_that_a_function_reads_are_those_that_dis_finds(every):
    far = 'lambda x: ' + ' + '.join(f'global_{i} * x.attribute_{i}' for i in range(200))
    seen = [compile(far, 'far', 'eval')]  # numbers of names that do not fit into a byte
    for module in _modules():
        values = map(plain, vars(module).values())
        seen += [value.__code__ for value in values if isinstance(value, FunctionType)]
    assert len(_read_by_dis(seen[0])) == 200 and len(seen) > 1000
    for code in seen[::every]:
        assert globals_read(code) == _read_by_dis(code)
