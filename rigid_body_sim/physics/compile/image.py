# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kernels as images: machine code that is copied into memory and called, without the compiler that
made it.

    image   : head, a few words of JSON, and the code (`elf.FlatCode`) behind it
    call    : result = entry(table, leading …)
    table   : one 64-bit word for each number, two (address, length) for each array, in the order
              of the arguments behind the leading ones
    leading : the first numbers of a kernel, at most LEADING, which a caller changes at each call
              (ticks, number of the first, length); what is behind them it often does not

An image takes one kind of each argument (`kind_of`): 64-bit integers, floats, truth values, and
contiguous one-dimensional arrays of them. It gives one of these numbers, or nothing (RETURNS); on
its way through C each is a float, of the same bits. A kernel that stops with an error says so by
the payload of a NaN (STOPPED), which `Image.result` raises.

Python's lock is let go during a call; the table is never written again after it was made, so
that two threads may call one kernel at the same time.

What is loaded here is trusted as code: `kernel_files` sees to it that it is whole and ours.
"""

from __future__ import annotations

import ctypes
import json
import mmap
import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.elf import FlatCode

LEADING = 3
FORMAT = 1
RETURNS = ('float64', 'int64', 'bool', 'none')
STOPPED = 0x7FFD_5B53_0000_0000  # a NaN that no arithmetic makes; its low half is numba's status
_WORD = struct.Struct('<q')
_HEAD = struct.Struct('<I')
_BEHAVED = 0x501  # flags of an array: contiguous, aligned, writeable
_READ_ONLY = 0x101
_ARRAYS = {
    (kind, flags): f'{text}{name}[]'
    for kind, name in (('d', 'float64'), ('l', 'int64'), ('?', 'bool'))
    for flags, text in ((_BEHAVED, ''), (_READ_ONLY, 'constant '))
}
_NUMBERS: dict[type, str] = {
    int: 'int64', float: 'float64', bool: 'bool',
    np.int64: 'int64', np.float64: 'float64', np.bool_: 'bool',
}  # fmt: skip
_C = {'int64': ctypes.c_int64, 'float64': ctypes.c_double, 'bool': ctypes.c_bool}


class KernelStopped(RuntimeError):
    """A compiled kernel met what its plain source would have raised."""


def kind_of(value: Any) -> str | None:
    """Name the kind of an argument; None: images take no such thing."""
    known = _NUMBERS.get(type(value))
    if known is not None or type(value) is not np.ndarray or value.ndim != 1:
        return known
    return _ARRAYS.get((value.dtype.char, value.flags.num & _BEHAVED))


def kinds_of(arguments: Sequence[Any]) -> tuple[str, ...] | None:
    """Name the kinds of all arguments; None: images do not take one of them."""
    kinds = tuple(map(kind_of, arguments))
    return None if None in kinds else kinds  # pyright: ignore[reportReturnType]


def count_leading(kinds: Sequence[str]) -> int:
    """Count the arguments that are handed over with each call."""
    first = next((i for i, kind in enumerate(kinds) if kind.endswith('[]')), len(kinds))
    return min(first, LEADING)


def words_of(value: Any) -> tuple[int, ...]:
    """Give what stands in the table for an argument."""
    if isinstance(value, np.ndarray):
        return value.__array_interface__['data'][0], len(value)
    if isinstance(value, float):
        return _WORD.unpack(struct.pack('<d', value))
    return (int(value),)


def packed(flat: FlatCode, returns: str) -> bytes:
    """Give the bytes of an image, as they are kept."""
    head = {
        'format': FORMAT,
        'returns': returns,
        'entry': flat.entry,
        'externals': flat.externals,
        'pointers': flat.pointers,
    }
    text = json.dumps(head, sort_keys=True).encode()
    return _HEAD.pack(len(text)) + text + flat.code


def unpacked(content: bytes) -> tuple[FlatCode, str]:
    """Give what `packed` has packed; ValueError for anything else."""
    try:
        begin = _HEAD.size + _HEAD.unpack_from(content)[0]
        head = json.loads(content[_HEAD.size : begin])
        if head['format'] != FORMAT or head['returns'] not in RETURNS:
            raise ValueError(f'image of format {head["format"]}')
        flat = FlatCode(content[begin:], head['entry'], head['externals'], head['pointers'])
    except (struct.error, KeyError, TypeError) as error:
        raise ValueError(f'no image: {error!r}') from error
    places = [flat.entry, *flat.externals.values(), *flat.pointers]
    if not all(isinstance(at, int) and 0 <= at <= len(flat.code) - 1 for at in places):
        raise ValueError('an image whose head does not fit its code')
    return flat, head['returns']


class Image:
    """
    Machine code in memory, for as long as the process lives.

    kinds   : of the arguments, see `kind_of`
    returns : of RETURNS

    OSError where the system lets nobody run code that was made at run time, or lacks a function
    that the code calls.
    """

    def __init__(self, flat: FlatCode, kinds: tuple[str, ...], returns: str, name: str) -> None:
        self.name, self.returns = name, returns
        self.leading = count_leading(kinds)
        address = _placed(flat)
        types = [_C[kind] for kind in kinds[: self.leading]]
        prototype = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, *types)
        self._entry: Any = prototype(address + flat.entry)

    def __call__(self, *arguments: Any) -> Any:
        """Call with all arguments."""
        table = _table(arguments[self.leading :])
        got = self._entry(table.ctypes.data, *arguments[: self.leading])
        return got if self.returns == 'float64' and got == got else self.result(got)

    def prepared(self, kept: Sequence[Any]) -> tuple[Any, int, Any]:
        """
        Give the native function and the address of a table of all arguments but the leading ones,
        which is its first argument; and what is to be held as long as it is called.
        """
        table = _table(kept)
        return self._entry, table.ctypes.data, (table, kept)

    def result(self, got: float) -> Any:
        """Give what a call came to; KernelStopped if it came to an error."""
        raw = struct.pack('<d', got)
        status, mark = struct.unpack('<iI', raw)
        if mark == STOPPED >> 32:
            raise KernelStopped(
                f'kernel {self.name}: stopped with status {status} of numba, which a kernel never '
                'does: an error of this package; RIGID_BODY_SIM_COMPILE=0 runs its plain source, '
                'which says where'
            )
        if self.returns == 'float64':
            return got
        (number,) = _WORD.unpack(raw)
        return {'int64': number, 'bool': bool(number), 'none': None}[self.returns]


def _table(kept: Sequence[Any]) -> NDArray[np.int64]:
    return np.array([word for value in kept for word in words_of(value)], dtype=np.int64)


@cache
def _libraries() -> tuple[Any, ...]:
    return ctypes.CDLL(None, use_errno=True), ctypes.CDLL('libm.so.6')


def _address(name: str) -> int:
    """Find a function of the C library, or of what the process has loaded before it."""
    for library in _libraries():
        try:
            return ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0
        except AttributeError:
            continue
    raise OSError(f'no function {name} in the C library')


def _placed(flat: FlatCode) -> int:
    """Copy code into memory, fill in what it lacks, and let it be run; its address."""
    memory = mmap.mmap(-1, max(1, len(flat.code)), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    _PLACED.append(memory)  # never given back: nobody knows who holds its address
    memory[: len(flat.code)] = flat.code
    address = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    for name, at in flat.externals.items():
        _WORD.pack_into(memory, at, _address(name))
    for at in flat.pointers:
        _WORD.pack_into(memory, at, _WORD.unpack_from(memory, at)[0] + address)
    size = len(memory)
    if _libraries()[0].mprotect(ctypes.c_void_p(address), ctypes.c_size_t(size), 1 | 4):
        number = ctypes.get_errno()
        raise OSError(number, 'the system does not let code that is made at run time be run')
    return address


_PLACED: list[mmap.mmap] = []
