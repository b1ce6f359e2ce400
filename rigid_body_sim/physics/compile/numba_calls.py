# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How what a kernel calls is called: as numba calls it, but that

    an array of one axis, without gaps, is handed on as its place and its length, in place of
    numba's seven words, of which a kernel uses these two
    a number is returned, in place of being written where the caller says; a tuple is written there
    as ever: LLVM sees no members in one that came from this return or from that, and makes no
    vectors of the loop that calls
    nobody tells whether it went well, and nobody asks

What may raise an error has to tell: the lowering of such a function ends with `Raises`, and it is
then called as numba does, and so is who calls it (`numba_pipeline._Lowering`). Of the functions
that kernels here are made of that is none, but with NUMBA_BOUNDSCHECK all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

from llvmlite import ir
from numba.core import cgutils, errors, types
from numba.core.callconv import CPUCallConv
from numba.core.cpu import CPUContext
from numba.np.numpy_support import as_dtype

_SHAPE, _NITEMS, _ITEMSIZE, _DATA, _STRIDES = 5, 2, 3, 4, 6  # of an array, as numba keeps it
_LENGTH = ir.IntType(64)


class Raises(errors.UnsupportedError):
    """A function may raise an error, or calls one that may."""


class ContextOfPieces(CPUContext):
    """As the context of which it is made, but for how functions are called."""

    def __init__(self, common: Any) -> None:
        self.__dict__ |= vars(common)
        self._found: dict[Any, Any] = {}

    def get_function(self, fn: Any, sig: Any, _firstcall: bool = True) -> Any:
        """Give what writes a call, looked for once: numba looks at each what it takes."""
        if not isinstance(fn, types.Function):
            return super().get_function(fn, sig, _firstcall)
        found = self._found.get((fn, sig))
        if found is None:
            found = self._found[fn, sig] = super().get_function(fn, sig, _firstcall)
        return found

    @property
    def call_conv(self) -> Any:
        """How functions are called."""
        return Convention(self)

    def compile_subroutine(self, *_arguments: Any, **_keywords: Any) -> Any:
        """Refuse what numba would compile for itself, which is called as numba does."""
        raise Raises('a function of numba')


def is_plain(kind: Any) -> bool:
    """Whether something is an array of one axis, without gaps."""
    return isinstance(kind, types.Array) and kind.ndim == 1 and kind.layout == 'C'


def is_tuple(kind: Any) -> bool:
    """Whether something is a tuple, named or not."""
    return isinstance(kind, types.BaseTuple)


class Convention(CPUCallConv):
    """Arguments, result and nothing else; see this module."""

    def get_function_type(self, restype: Any, argtypes: Any) -> Any:
        """Give the type of a function for LLVM."""
        words = [word for kind in argtypes for word in self._words(kind)]
        returned = self._returned(restype)
        if _has_members(returned):
            return ir.FunctionType(ir.VoidType(), [returned.as_pointer(), *words])
        return ir.FunctionType(returned, words)

    def decorate_function(
        self, fn: Any, args: Any, fe_argtypes: Any, noalias: bool = False
    ) -> None:
        """Say that nothing else points to where a tuple goes."""
        if _writes(fn):
            fn.args[0].add_attribute('captures(none)')
            fn.args[0].add_attribute('noalias')

    def decode_arguments(self, builder: Any, argtypes: Any, func: Any) -> list[Any]:
        """Give the arguments of a function as its body uses them."""
        words = iter(func.args[_writes(func) :])
        return [self._taken(builder, kind, words) for kind in argtypes]

    def call_function(
        self, builder: Any, callee: Any, resty: Any, argtys: Any, args: Any, attrs: Any = None
    ) -> Any:
        """Refuse: by this numba calls what tells whether it went well."""
        raise Raises('a call of a function that may raise')

    def call(
        self, builder: Any, callee: Any, resty: Any, argtys: Sequence[Any], args: Sequence[Any]
    ) -> Any:
        """Call a function; give what it returns, as its caller uses it."""
        words = [
            word
            for kind, value in zip(argtys, args, strict=True)
            for word in self._given(builder, kind, value)
        ]
        returned = self._returned(resty)
        if _has_members(returned):
            place = cgutils.alloca_once(builder, returned)
            builder.call(callee, [place, *words])
            value = builder.load(place)
        else:
            value = builder.call(callee, words)
        if resty == types.none:
            return self.context.get_dummy_value()
        return self.context.get_returned_value(builder, resty, value)

    def return_value(self, builder: Any, retval: Any) -> None:
        """End a function."""
        if _writes(builder.function):
            builder.store(retval, builder.function.args[0])
            builder.ret_void()
        elif isinstance(builder.function.function_type.return_type, ir.VoidType):
            builder.ret_void()
        else:
            builder.ret(retval)

    def _refuse(self, *_arguments: Any, **_keywords: Any) -> Any:
        raise Raises('a kernel that raises an error')

    return_optional_value = return_native_none = return_exc = return_stop_iteration = _refuse
    set_static_user_exc = set_dynamic_user_exc = return_dynamic_user_exc = _refuse
    return_user_exc = return_status_propagate = check_try_status = set_try_status = _refuse

    def _returned(self, kind: Any) -> Any:
        if kind == types.none:
            return ir.VoidType()
        return self.context.data_model_manager[kind].get_return_type()

    def _words(self, kind: Any) -> list[Any]:
        """Give the types of the words as which a value is handed on."""
        if is_plain(kind):
            whole: Any = self.context.get_value_type(kind)
            return [whole.elements[_DATA], _LENGTH]
        if is_tuple(kind):
            return [word for member in kind.types for word in self._words(member)]
        word = self.context.data_model_manager[kind].get_argument_type()
        if not isinstance(word, ir.Type):
            raise Raises(f'a function that takes {kind}')
        return [word]

    def _given(self, builder: Any, kind: Any, value: Any) -> list[Any]:
        """Give the words of a value."""
        if is_plain(kind):
            length = builder.extract_value(value, [_SHAPE, 0])
            return [builder.extract_value(value, _DATA), length]
        if is_tuple(kind):
            return [
                word
                for i, member in enumerate(kind.types)
                for word in self._given(builder, member, builder.extract_value(value, i))
            ]
        return [self.context.data_model_manager[kind].as_argument(builder, value)]

    def _taken(self, builder: Any, kind: Any, words: Iterator[Any]) -> Any:
        """Give a value of the words that come next."""
        if is_plain(kind):
            return self._array(builder, kind, next(words), next(words))
        if is_tuple(kind):
            members = [self._taken(builder, member, words) for member in kind.types]
            return self.context.make_tuple(builder, kind, members)
        return self.context.data_model_manager[kind].from_argument(builder, next(words))

    def _array(self, builder: Any, kind: Any, data: Any, length: Any) -> Any:
        """Give an array that nobody owns, as numba keeps it."""
        whole: Any = self.context.get_value_type(kind)
        size = as_dtype(kind.dtype).itemsize
        members = [ir.Constant(member, None) for member in whole.elements]
        members[_ITEMSIZE] = ir.Constant(whole.elements[_ITEMSIZE], size)
        members[_STRIDES] = ir.Constant(whole.elements[_STRIDES], [size])
        array = ir.Constant(whole, members)
        array = builder.insert_value(array, data, _DATA)
        array = builder.insert_value(array, length, _NITEMS)
        return builder.insert_value(array, length, [_SHAPE, 0])


def _has_members(kind: Any) -> bool:
    return isinstance(kind, ir.Aggregate)


def _writes(function: Any) -> bool:
    """Whether the first word that a function takes is where its result goes."""
    first = function.function_type.args[:1]
    return any(_has_members(getattr(one, 'pointee', None)) for one in first)


def part(builder: Any, array: Any, begin: Any, end: Any) -> Any:
    """Give what is seen of an array, as numba keeps it, between two indices of its elements."""
    nothing = ir.Constant(_LENGTH, 0)
    held = builder.extract_value(array, [_SHAPE, 0])
    end = builder.select(builder.icmp_signed('<', end, held), end, held)
    length = builder.sub(end, begin)
    length = builder.select(builder.icmp_signed('>', length, nothing), length, nothing)
    data = builder.gep(builder.extract_value(array, _DATA), [begin])
    array = builder.insert_value(array, data, _DATA)
    array = builder.insert_value(array, length, _NITEMS)
    return builder.insert_value(array, length, [_SHAPE, 0])


@cache
def of_pieces(context: Any) -> ContextOfPieces:
    """Give the context of what is called, made of that of who calls."""
    return context if isinstance(context, ContextOfPieces) else ContextOfPieces(context)


def caller(described: Any, library: Any) -> Callable[..., Any]:
    """Give what writes the call of a function that raises nothing."""

    def write(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        own = of_pieces(context)
        function = own.declare_function(builder.module, described)
        return own.call_conv.call(builder, function, described.restype, described.argtypes, args)

    found: Any = write
    found.signature, found.libs = described.argtypes, (library,)
    return found
