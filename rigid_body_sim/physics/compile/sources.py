# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a compiled kernel depends on: its source, that of all it calls, and the numbers they name.

The sources of `physics` are digested file by file (`digest_of_sources`), which gives the folder of
kernels its name. What else a kernel reaches is found by following the names in it
(`digest_of`): constants bound into it or changed since their module was read, and functions that
stand outside, as an integrator or a force element of a user.
"""

from __future__ import annotations

import hashlib
import marshal
import opcode
import os
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]  # physics
_OWN = f'{ROOT}{os.sep}'
_EXTENDED = opcode.opmap['EXTENDED_ARG']
_READS = {  # what reads a global, and which bits of its argument are no number of a name
    opcode.opmap['LOAD_GLOBAL']: 1 if sys.version_info >= (3, 11) else 0,
    opcode.opmap['LOAD_NAME']: 0,
}
_PLAIN = int | float | complex | bool | str | None


@cache
def digest_of_sources() -> str:
    """Digest every file of `physics` as it stood when first asked, in 16 hexadecimal digits."""
    root = str(ROOT)
    paths = [  # at every start: pathlib takes three times as long
        os.path.join(folder, name)  # noqa: PTH118
        for folder, _, names in os.walk(root)
        for name in names
        if name.endswith('.py')
    ]
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.removeprefix(root).encode())
        with open(path, 'rb') as file:  # noqa: PTH123
            digest.update(file.read())
    return digest.hexdigest()[:16]


def codes(code: CodeType) -> Iterator[CodeType]:
    """Give the code of a function, and of what is defined inside it."""
    yield code
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from codes(part)


@cache
def globals_read(code: CodeType) -> frozenset[str]:
    """
    Name the globals that a function reads, and what is defined inside it.

    A scan of the bytes, some 60 functions at every start: `dis` takes twenty times as long.
    """
    found: set[str] = set()
    for part in codes(code):
        operations, names = part.co_code, part.co_names
        high = 0  # what EXTENDED_ARG puts before the next argument
        for operation, low in zip(operations[::2], operations[1::2], strict=True):
            argument = high | low
            high = argument << 8 if operation == _EXTENDED else 0
            if operation in _READS:
                found.add(names[argument >> _READS[operation]])
    return frozenset(found)


def digest_of(function: FunctionType) -> str:
    """Digest the files of `physics` and what a kernel reaches beside, in 32 hexadecimal digits."""
    digest = hashlib.sha256(digest_of_sources().encode())
    seen: set[int] = set()
    ahead: list[Any] = [function]
    while ahead:
        plain = ahead.pop()
        if id(plain) in seen:
            continue
        seen.add(id(plain))
        digest.update(f'{plain.__module__}.{plain.__qualname__}'.encode())
        if not plain.__code__.co_filename.startswith(_OWN):
            digest.update(marshal.dumps(plain.__code__))
        cells = [cell.cell_contents for cell in plain.__closure__ or ()]
        named = plain.__globals__
        values = [(n, named[n]) for n in _names(plain.__code__) if n in named]
        for name, value in [*values, *(('', cell) for cell in cells)]:
            digest.update(f'{name}={_told(value, ahead)};'.encode())
    return digest.hexdigest()[:32]


@cache
def _names(code: CodeType) -> tuple[str, ...]:
    return tuple(sorted({name for part in codes(code) for name in part.co_names}))


def _told(value: Any, ahead: list[Any]) -> str:
    """Tell a value apart from others; functions among it are added to what lies ahead."""
    if isinstance(value, _PLAIN):
        return repr(value)
    if isinstance(value, tuple | list):
        return f'({",".join(_told(one, ahead) for one in value)})'
    plain = getattr(value, 'py_func', value)
    if isinstance(plain, FunctionType):
        if not plain.__module__.startswith('numpy'):
            ahead.append(plain)
        return f'{plain.__module__}.{plain.__qualname__}'
    if isinstance(value, ModuleType | type | BuiltinFunctionType | np.ufunc):
        return value.__name__
    if isinstance(value, np.ndarray):
        return f'{value.dtype}{value.shape}{hashlib.sha256(value.tobytes()).hexdigest()}'
    return f'{type(value).__qualname__} {value!r}'
