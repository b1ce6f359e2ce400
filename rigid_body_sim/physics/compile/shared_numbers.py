# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Integers that several threads read and write, as LLVM is told to do it: each read, write or change
is one, and whoever sees it sees all that was written before it (release and acquire). The plain
source (`contact.crew`) runs on one thread, where that is a matter of course.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.typing.templates import make_intrinsic_template

_INDEX, _SHORT = ir.IntType(64), ir.IntType(32)
_ALIGNED = 8  # [B]


def numba_type(name: str) -> Any:
    """What numba takes such a function for; name: of a function of `contact.crew`."""
    define = DEFINITIONS[name]
    return types.Function(make_intrinsic_template(object(), define, name))


def _at(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """Point at the number whose array and index are the first two arguments."""
    data = context.make_array(signature.args[0])(context, builder, values[0]).data
    return builder.gep(data, [values[1]])


def _seen() -> Callable[..., Any]:
    def write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        at = _at(context, builder, signature, values)
        return builder.load_atomic(at, 'acquire', _ALIGNED)

    def define(_typing: Any, numbers: Any, index: Any) -> Any:
        return types.int64(numbers, index), write

    return define


def _show() -> Callable[..., Any]:
    def write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        at = _at(context, builder, signature, values)
        builder.store_atomic(values[2], at, 'release', _ALIGNED)
        return context.get_dummy_value()

    def define(_typing: Any, numbers: Any, index: Any, value: Any) -> Any:
        return types.none(numbers, index, types.int64), write

    return define


def _count_one() -> Callable[..., Any]:
    def write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        at = _at(context, builder, signature, values)
        builder.atomic_rmw('add', at, ir.Constant(_INDEX, 1), 'acq_rel')
        return context.get_dummy_value()

    def define(_typing: Any, numbers: Any, index: Any) -> Any:
        return types.none(numbers, index), write

    return define


def _replace() -> Callable[..., Any]:
    def write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        at = _at(context, builder, signature, values)
        found = builder.cmpxchg(at, values[2], values[3], 'acq_rel', 'acquire')
        return builder.extract_value(found, 1)

    def define(_typing: Any, numbers: Any, index: Any, old: Any, new: Any) -> Any:
        return types.boolean(numbers, index, types.int64, types.int64), write

    return define


def _ask_system() -> Callable[..., Any]:
    def write(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        function, number = values
        is_there = builder.icmp_unsigned('!=', function, ir.Constant(_INDEX, 0))
        with builder.if_then(is_there):
            kind = ir.FunctionType(_SHORT, [_SHORT])
            call = builder.inttoptr(function, kind.as_pointer())
            builder.call(call, [builder.trunc(number, _SHORT)])
        return _context.get_dummy_value()

    def define(_typing: Any, function: Any, number: Any) -> Any:
        return types.none(types.int64, types.int64), write

    return define


DEFINITIONS = {
    'seen': _seen(),
    'show': _show(),
    'count_one': _count_one(),
    'replace': _replace(),
    'ask_system': _ask_system(),
}
