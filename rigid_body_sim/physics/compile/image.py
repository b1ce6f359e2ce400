# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kernels as images: machine code that is copied into memory and called, without the compiler that
made it.

    image : head, a few words of JSON, and the code (`elf.FlatCode`) behind it

An image takes one kind of each argument (`kind_of`): 64-bit integers, floats, truth values, and
contiguous one-dimensional arrays of them; and gives one of these numbers, or nothing (RETURNS).
A group of arguments (NamedTuple) is taken as its members in a row, as numba's code takes it:
grouped or not, a call costs the same.

In memory it is a builtin function of Python: it looks at each argument itself, lets Python's lock
go, runs, and gives the result; where an argument is of another kind it gives NotImplemented and
has done nothing. That it knows where Python and numpy keep what it looks at is checked with each
release of them (`images.Images.is_trusted`). A kernel that stops with an error raises
KernelStopped.

Its last arguments can be at hand already (`with_last`): they hang on the function, in a tuple
behind its name, and are looked at in each call as the others are. A brief one, whose name is a
`BriefName`, keeps the lock: to let it go and take it again costs 50 ns, half of such a call.

What is loaded here is trusted as code: `kernel_files` sees to it that it is whole and ours.
"""

from __future__ import annotations

import ctypes
import json
import mmap
import struct
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np

from rigid_body_sim.physics.compile.elf import FlatCode

FORMAT = 4
RETURNS = ('float64', 'int64', 'bool', 'none')
BEGIN, END = '(', ')'  # of a group of arguments
READ, WRITE = 0x101, 0x400  # flags of an array: contiguous and aligned; writeable
_WORD = struct.Struct('<q')
_HEAD = struct.Struct('<I')
_WITH_ARRAY_OF_ARGUMENTS = 0x80  # METH_FASTCALL
_READABLE_CODE = mmap.PROT_READ | mmap.PROT_EXEC
_ARRAYS = {
    (kind, READ | flags): f'{text}{name}[]'
    for kind, name in (('d', 'float64'), ('l', 'int64'), ('?', 'bool'))
    for flags, text in ((WRITE, ''), (0, 'constant '))
}
_NUMBERS: dict[type, str] = {
    int: 'int64', float: 'float64', bool: 'bool',
    np.int64: 'int64', np.float64: 'float64', np.bool_: 'bool',
}  # fmt: skip


class BriefName(str):
    """Name of a function that is done before another thread would get Python's lock."""

    __slots__ = ()


class KernelStopped(RuntimeError):
    """A compiled kernel met what its plain source would have raised: kernel, status of numba."""

    def __str__(self) -> str:
        """Tell what happened, and how to learn more."""
        name, status = self.args
        return (
            f'kernel {name}: stopped with status {status} of numba, which a kernel never does: an '
            'error of this package; RIGID_BODY_SIM_COMPILE=0 runs its plain source, which says '
            'where'
        )


def kind_of(value: Any) -> str | None:
    """Name the kind of an argument; None: images take no such thing."""
    known = _NUMBERS.get(type(value))
    if known is not None or type(value) is not np.ndarray or value.ndim != 1:
        return known
    return _ARRAYS.get((value.dtype.char, value.flags.num & (READ | WRITE)))


def is_group(value: Any) -> bool:
    """Tell whether an argument is a NamedTuple."""
    return isinstance(value, tuple) and hasattr(value, '_fields')


def kinds_of(arguments: Sequence[Any]) -> tuple[str, ...] | None:
    """
    Name the kinds of all arguments; None: images do not take one of them. The kinds of a group
    stand between its name and END.
    """
    kinds: list[str | None] = []
    for value in arguments:
        if is_group(value):
            kinds += [type(value).__name__ + BEGIN, *(kinds_of(value) or [None]), END]
        else:
            kinds.append(kind_of(value))
    return None if None in kinds else tuple(kinds)  # pyright: ignore[reportReturnType]


def of_members(kinds: Sequence[str]) -> tuple[str, ...]:
    """Give the kinds of what is passed: of the members of groups, and not of the groups."""
    return tuple(kind for kind in kinds if kind != END and not kind.endswith(BEGIN))


def members(arguments: Sequence[Any]) -> Iterator[Any]:
    """Give arguments as an image takes them: the members of a group in its place."""
    for value in arguments:
        if is_group(value):
            yield from members(value)
        else:
            yield value


def usual(value: Any) -> Any:
    """Give an argument of a known kind as an image knows it: a number or array of numpy's is."""
    if isinstance(value, np.ndarray):
        return value.view(np.dtype(value.dtype.char))
    return value.item() if isinstance(value, np.generic) else value


def objects() -> dict[str, Any]:
    """Give what an image knows of Python and numpy, by the names that it has for them."""
    return {
        'the_str': str,
        'the_int': int,
        'the_float': float,
        'the_ndarray': np.ndarray,
        'the_dtype_float64': np.dtype(np.float64),
        'the_dtype_int64': np.dtype(np.int64),
        'the_dtype_bool': np.dtype(np.bool_),
        'the_true': True,
        'the_false': False,
        'the_none': None,
        'the_other': NotImplemented,
        'the_error': KernelStopped,
    }


def packed(flat: FlatCode) -> bytes:
    """Give the bytes of an image, as they are kept."""
    head = {
        'format': FORMAT,
        'entry': flat.entry,
        'externals': flat.externals,
        'pointers': flat.pointers,
    }
    text = json.dumps(head, sort_keys=True).encode()
    return _HEAD.pack(len(text)) + text + flat.code


def unpacked(content: bytes) -> FlatCode:
    """Give what `packed` has packed; ValueError for anything else."""
    try:
        begin = _HEAD.size + _HEAD.unpack_from(content)[0]
        head = json.loads(content[_HEAD.size : begin])
        if head['format'] != FORMAT:
            raise ValueError(f'image of format {head["format"]}')
        flat = FlatCode(content[begin:], head['entry'], head['externals'], head['pointers'])
    except (struct.error, KeyError, TypeError) as error:
        raise ValueError(f'no image: {error!r}') from error
    places = [flat.entry, *flat.externals.values(), *flat.pointers]
    if not all(isinstance(at, int) and 0 <= at < len(flat.code) for at in places):
        raise ValueError('an image whose head does not fit its code')
    return flat


class _Method(ctypes.Structure):
    """How Python describes a builtin function: PyMethodDef."""

    _fields_ = (
        ('name', ctypes.c_char_p),
        ('place', ctypes.c_void_p),
        ('flags', ctypes.c_int),
        ('doc', ctypes.c_char_p),
    )


def load(flat: FlatCode, name: str) -> Callable[..., Any]:
    """
    Make a builtin function of an image, for as long as the process lives.

    OSError where the system lets nobody run code that was made at run time, or lacks a function
    that the code calls.
    """
    place = _placed(flat) + flat.entry
    method = _Method(name.encode(), place, _WITH_ARRAY_OF_ARGUMENTS, None)
    made = _function(method, (name,))
    _METHODS[made] = _kept(method)  # nobody knows who holds its address
    return made


def with_last(
    image: Callable[..., Any], last: Sequence[Any], *, brief: bool = False
) -> Callable[..., Any]:
    """
    Give an image with its last arguments at hand: it is called with the others.

    brief : whether it keeps Python's lock

    A call looks at 60 arrays that hang on it in less time than Python needs to list them.
    """
    name = BriefName(image.__name__) if brief else image.__name__
    return _function(_METHODS[image], (name, *members(last)))


def _function(method: _Method, owned: tuple[Any, ...]) -> Callable[..., Any]:
    """Make a builtin function that has a tuple with its name and its last arguments."""
    make = ctypes.pythonapi.PyCFunction_NewEx
    make.restype = ctypes.py_object
    make.argtypes = (ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)
    return make(ctypes.addressof(method), owned, None)


@cache
def _libraries() -> tuple[Any, ...]:
    return ctypes.pythonapi, ctypes.CDLL(None, use_errno=True), ctypes.CDLL('libm.so.6')


@cache
def _address(name: str) -> int:
    """Find an object of `objects`, or a function of Python or the C library."""
    known = objects()
    if name in known:
        return id(known[name])
    for library in _libraries():
        try:
            return ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0
        except AttributeError:
            continue
    raise OSError(f'no function {name} in Python or the C library')


def _placed(flat: FlatCode) -> int:
    """Copy code into memory, fill in what it lacks, and let it be run; its address."""
    memory = mmap.mmap(-1, len(flat.code), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    _kept(memory)  # nobody knows who holds its address
    memory[: len(flat.code)] = flat.code
    address = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    for name, at in flat.externals.items():
        _WORD.pack_into(memory, at, _address(name))
    for at in flat.pointers:
        _WORD.pack_into(memory, at, _WORD.unpack_from(memory, at)[0] + address)
    place, size = ctypes.c_void_p(address), ctypes.c_size_t(len(memory))
    if _libraries()[1].mprotect(place, size, _READABLE_CODE):
        number = ctypes.get_errno()
        raise OSError(number, 'the system does not let code that is made at run time be run')
    return address


def _kept(thing: Any) -> Any:
    """
    Keep a thing until the process is gone, and give it back.

    A list of this module would let it go when Python takes itself apart, in no order that is
    given: a function that goes later would look into memory that is not there any more.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))
    return thing


_METHODS: dict[Callable[..., Any], _Method] = {}
